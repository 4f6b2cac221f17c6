# SPDX-License-Identifier: BSD-3-Clause
"""Make the tables and pictures of docs/performance.md: `make bench`.

All figures are written as CSV to out/bench/, pictures to docs/pictures/. The text between the markers of the
page is replaced; the rest is left unchanged. `--quick` measures a small part and writes to out/bench/ only.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.page_parts import put
from benchmarks.speed import aims, errors, families, figures, masters, operations, page, timings, tools
from benchmarks.speed.tools import ROOT, Tools

OUT = ROOT / "out" / "bench"
STEPPED = ("fourbar", "slidercrank", "arm7", "stewart")
QUICK_ERRORS = ("fourbar", "arm7")
QUICK_SIZES = {1, 8, 10, 16, 32, 40, 64, 128}


def say(words: str) -> None:
    print(words, flush=True)


def chosen(quick: bool, only: str | None) -> list[str]:
    """Return the names of the mechanisms, those of one size first."""
    if only:
        return [name for name in families.MAKERS if any(part in name for part in only.split(","))]
    sized = [
        f"{family}_{n}"
        for family, members in families.FAMILIES.items()
        for n in members
        if not quick or n in QUICK_SIZES
    ]
    return [*families.SINGLE, *sized]


def kernel_parts(found: list[timings.Timing], names: list[str], pictures: Path) -> dict[str, str]:
    single = [name for name in names if name in families.SINGLE]
    figures.draw_forward(found, pictures / "speed-forward.png")
    figures.draw_kernels(found, pictures / "speed-kernels.png")
    figures.draw_single(found, single, pictures / "speed-single.png")
    return {
        "forward": page.forward_table(found, names),
        "exponents": page.exponents(found),
        "kernels": page.kernel_table(found, names),
        "methods": page.method_table(found, names),
        "faults": page.faults(found),
    }


type Parts = tuple[dict[str, str], list[aims.Aim]]


def kernels(made: Tools, names: list[str], rounds: int, pictures: Path) -> Parts:
    """Measure all kernels of Gelenk and the accelerations of the other engines."""
    found = timings.study(made, names, "forward", rounds, report=say)
    timings.write_csv(found, OUT / "kernels.csv")
    return kernel_parts(found, names, pictures), aims.of_kernels(found)


def steps(made: Tools, names: list[str]) -> Parts:
    """Measure communication steps."""
    found = masters.study(made, names, say)
    masters.write_csv(found, OUT / "steps.csv")
    return {"steps": page.step_table(found)}, aims.of_steps(found)


def precision(made: Tools, names: list[str], rounds: int, pictures: Path) -> Parts:
    """Measure processor time against error."""
    runs, truths = errors.study(made, names, rounds, say)
    errors.write_csv(runs, OUT / "errors.csv")
    parts = {"errors": page.error_table(runs, (1e-4, 1e-6, 1e-8))}
    for name in truths:
        picture = pictures / f"speed-errors-{name}.png"
        figures.draw_errors([run for run in runs if run.scene == name], truths[name], picture)
        parts[f"errors-{name}"] = (
            f"![{name}: processor time against error](pictures/{picture.name})\n\n"
            f"{families.make(name).stop:g} s; the reference solutions of two programs at "
            f"1e-12 differ by {truths[name].digits:.1e}."
        )
    return parts, aims.of_runs(runs)


def counted(made: Tools, names: list[str]) -> Parts:
    """Count the instructions of an evaluation."""
    found = operations.study(made, names, say)
    return ({"operations": page.operations_table(found)} if found else {}), []


def machine() -> str:
    """Return a description of the machine."""
    return (
        f"{platform.machine().replace('_', '-')}, {os.cpu_count()} cores, Python {platform.python_version()}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument(
        "--scenes",
        help="mechanisms whose names contain one of these comma-separated words; writes to out/bench/ only",
    )
    parser.add_argument("--only", choices=["kernels", "steps", "errors", "operations"])
    parser.add_argument("--programs", type=Path, default=ROOT / "build" / "bench" / "benchmarks" / "speed",
                        help="folder of gelenk-kernels and gelenk-runs")  # fmt: skip
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "bench" / "speed",
                        help="folder for the other engines and the programs around them")  # fmt: skip
    given = parser.parse_args()
    begin = time.monotonic()
    private = given.quick or given.scenes
    pictures = OUT if private else ROOT / "docs" / "pictures"
    OUT.mkdir(parents=True, exist_ok=True)
    made = tools.prepare(given.folder.resolve(), given.programs.resolve(), None, say)
    for name, why in made.missing.items():
        say(f"{name}: {why}")
    names = chosen(given.quick, given.scenes)
    rounds = 1 if given.quick else 3
    compared = QUICK_ERRORS if given.quick else errors.SCENES
    studies: dict[str, Callable[[], Parts]] = {
        "kernels": lambda: kernels(made, names, rounds, pictures),
        "steps": lambda: steps(made, [name for name in STEPPED if name in names]),
        "errors": lambda: precision(made, [name for name in compared if name in names], rounds, pictures),
        "operations": lambda: counted(made, [name for name in operations.SCENES if name in names]),
    }
    parts: dict[str, str] = {}
    aimed: list[aims.Aim] = []
    for name, study in studies.items():
        if given.only in (None, name):
            made_parts, made_aims = study()
            parts |= made_parts
            aimed += made_aims
    if not given.only:
        parts["aims"] = aims.table(aimed)
        parts["machine"] = (
            f"{machine()}; {tools.versions(made)}. Total measuring time: {time.monotonic() - begin:.0f} s."
        )
    say(aims.table(aimed))
    target = OUT / "performance.md" if private else ROOT / "docs" / "performance.md"
    if private:
        target.write_text("", encoding="utf-8")
    put(target, "benchmarks/speed", parts)
    say(f"{target.relative_to(ROOT)}: {len(parts)} parts updated")


if __name__ == "__main__":
    main()
