# SPDX-License-Identifier: BSD-3-Clause
"""Measure control loops around FMUs and write the table of docs/real-time.md: `make real-time`.

Each round sets the first input to another value, makes a step of 1 ms and reads all outputs. All scenes of
the gallery and of scenes/ run again and again to their end, with error control (auto) and in bounded steps.
"""

from __future__ import annotations

import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import fmpy

import gelenk

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from fmu.c_hosts import compiled, extracted  # noqa: E402 (found by the line above)

PAGE = ROOT / "docs" / "real-time.md"
BEGIN = "<!-- table: made by benchmarks/real_time.py -->\n"
END = "<!-- end of table -->"
ROUNDS = 100_000
STEP = 1e-3  # s
FIXED: dict[str, str | float] = {"solver.integrator": "rk4", "solver.step": STEP, "solver.corrections": 2}
IMPULSES: dict[str, str | float] = {"solver.integrator": "moreau-jean", "solver.step": STEP}
SET = {  # largest value of the first input, where one makes sense in the scene's experiment: N m, N
    "four_bar": 2.0,
    "slider_crank": 2.0,
    "five_bar": 2.0,
    "cart_pole": 2.0,
    "stewart": 20.0,
    "backlash_drive": 1.0,
    "gears": 1.0,
    "worm_hoist": 1.0,
}


def scenes() -> Iterator[tuple[str, Path]]:
    for path in sorted((ROOT / "scenes").glob("*.yaml")):
        yield path.stem, path
    for path in sorted((ROOT / "docs" / "gallery").glob("*/scene.yaml")):
        if not (ROOT / "scenes" / f"{path.parent.name}.yaml").exists():
            yield path.parent.name, path


def measured(host: Path, name: str, scene: gelenk.Scene, folder: Path) -> list[str]:
    fmu = gelenk.export_fmu(scene, folder / "plant.fmu")
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    (counted,) = (v.valueReference for v in variables if v.name == "solver.worst_step_evaluations")
    period = round(float(scene.to_dict()["experiment"]["stop"]) / STEP)
    own = [str(ROUNDS), str(period), str(SET.get(name, 0.0)), str(counted)]
    command = [str(host), *extracted(fmu, folder / "fmu"), *own]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode == 5:
        return [f"refused at {run.stdout.strip()} s", "", "", "", ""]
    run.check_returncode()
    *times, evaluations = run.stdout.split()
    return [*(f"{float(word):.1f}" for word in times), evaluations]


def rows() -> Iterator[str]:
    with tempfile.TemporaryDirectory() as folder:
        host = compiled("real_time_host", Path(folder), where=ROOT / "benchmarks")
        if host is None:
            sys.exit("no C compiler was found (cc)")
        for name, path in scenes():
            scene = gelenk.load(path)
            modes = {"`auto`": {}, "`rk4`": FIXED}
            if scene.to_dict().get("contacts"):
                modes["`moreau-jean`"] = IMPULSES
            for mode, settings in modes.items():
                with tempfile.TemporaryDirectory() as own:
                    values = measured(host, name, scene.with_parameters(settings), Path(own))
                row = f"| {name} | {mode} | " + " | ".join(values) + " |"
                print(row, flush=True)
                yield row


def main() -> None:
    lines = [
        "| Scene | Integrator | median | 99.9 % | 99.999 % | maximum | most evaluations |",
        "|---|---|---|---|---|---|---|",
        *rows(),
        "",
        f"CPU time of the thread in µs, {ROUNDS:,} cycles each, including 0.3 µs for reading the clock, "
        f"{platform.machine()}.",
    ]
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
