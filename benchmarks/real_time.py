# SPDX-License-Identifier: BSD-3-Clause
"""Measure a control loop around FMUs and write the table of docs/fmu.md: `make real-time`.

Each round sets a new torque, makes a step of 1 ms and reads all outputs. Bounded cost (rk4, one step, two
corrections) is compared with error control (auto).
"""

from __future__ import annotations

import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import gelenk

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from fmu.c_hosts import compiled, extracted  # noqa: E402 (found by the line above)

PAGE = ROOT / "docs" / "fmu.md"
BEGIN = "<!-- table: made by benchmarks/real_time.py -->\n"
END = "<!-- end of table -->"
ROUNDS = 300_000
SCENES = ("four_bar", "slider_crank", "five_bar", "cart_pole")
BOUNDED: dict[str, str | float] = {
    "solver.integrator": "rk4",
    "solver.step": 1e-3,
    "solver.corrections": 2,
}
MODES: dict[str, dict[str, str | float]] = {"bounded": BOUNDED, "`auto`, 1e-6": {}}


def rows() -> list[str]:
    out: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        host = compiled("real_time_host", Path(folder), where=ROOT / "benchmarks")
        if host is None:
            sys.exit("no C compiler was found (cc)")
        for name in SCENES:
            for mode, settings in MODES.items():
                scene = gelenk.load(ROOT / "scenes" / f"{name}.yaml").with_parameters(settings)
                fmu = gelenk.export_fmu(scene, Path(folder) / "x.fmu")
                arguments = extracted(fmu, Path(folder) / f"{name}{len(out)}")
                run = subprocess.run(
                    [str(host), *arguments, str(ROUNDS)], capture_output=True, text=True, check=True
                )
                times = [f"{float(word):.1f}" for word in run.stdout.split()]
                out.append(f"| {name} | {mode} | " + " | ".join(times) + " |")
                print(out[-1], flush=True)
    return out


def main() -> None:
    lines = [
        "| Scene | Mode | median | 99.9 % | 99.999 % | maximum |",
        "|---|---|---|---|---|---|",
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
