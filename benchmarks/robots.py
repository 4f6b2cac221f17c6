# SPDX-License-Identifier: BSD-3-Clause
"""Robots of published packages fall for a second, each from its zero position, at default settings.

    python -m benchmarks.robots DIRECTORY...

Every file *.urdf below the directories is imported with its limits and dry friction, joints at zero, and
simulated without control in a process of its own, which is ended after LIMIT. What is not imported is
counted; what does not get to the end, or needs more than GOAL of processor time, is listed, the worst
first. With --all everything is listed; with --floating the root link falls, too.

Packages on PyPI that ship such files (`pip install --no-deps --target DIRECTORY NAME`); the first is there
for the tests anyway:

    example-robot-data 6.0.0, rtb-data 2.0.0, icub-models 3.2.0, armar 1.1.0, dexmate-urdf 0.8.4,
    fourier-robot-descriptions 0.2.7, hello-robot-stretch-urdf 0.1.2, airo-models 0.0.12,
    gym-ignition-models 1.1.1, jvrc-description 1.1.1, gb-robot-models 0.1.0

Meshes may be missing: masses and inertias are in the URDF files.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import gelenk

SECONDS, STEP = 1.0, 0.01  # s: simulated, and per communication step
GOAL = 0.5  # s of processor time, without the import
LIMIT = 20.0  # s, for one robot, with the start of the interpreter


@dataclass(frozen=True)
class Fall:
    """What has become of a robot.

    Args:
        path: its file.
        outcome: "fell", "not imported", "refused" or "too slow".
        seconds: processor time of the run [s].
        text: number of events and evaluations, or why it did not get to the end.
    """

    path: Path
    outcome: str
    seconds: float = 0.0
    text: str = ""

    @property
    def is_good(self) -> bool:
        """Whether it fell for long enough within the goal, or is no robot that can."""
        return self.outcome == "not imported" or (self.outcome == "fell" and self.seconds <= GOAL)


def fall(path: Path, floating: bool = False) -> Fall:
    """Simulate one robot in this process."""
    try:
        scene = gelenk.import_urdf(path, repair_inertia=True, floating=floating)
        plant = gelenk.Simulation(scene)
        plant.initialize()
    except (gelenk.GelenkError, OSError) as e:
        return Fall(path, "not imported", 0.0, " ".join(str(e).split())[:200])
    start = time.process_time()
    try:
        for k in range(1, round(SECONDS / STEP) + 1):
            plant.step_to(k * STEP)
    except gelenk.GelenkError as e:
        seconds = time.process_time() - start
        return Fall(path, "refused", seconds, f"at {plant.time:.4f} s: " + " ".join(str(e).split())[:250])
    events, evaluations = (plant.diagnostic(f"solver.{name}") for name in ("events", "evaluations"))
    text = f"{events:.0f} events, {evaluations:.0f} evaluations"
    return Fall(path, "fell", time.process_time() - start, text)


def fall_apart(path: Path, floating: bool) -> Fall:
    """Simulate one robot in another process."""
    command = [sys.executable, "-m", "benchmarks.robots", "--one", str(path)]
    try:
        found = subprocess.run(
            command + ["--floating"] * floating, capture_output=True, text=True, timeout=LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return Fall(path, "too slow", LIMIT, f"more than {LIMIT:g} s")
    lines = found.stdout.splitlines()
    if found.returncode != 0 or not lines:
        return Fall(path, "refused", 0.0, f"ended with {found.returncode}: {found.stderr[-200:]}")
    outcome, seconds, text = lines[-1].split("\t", 2)
    return Fall(path, outcome, float(seconds), text)


def robots(directories: list[Path]) -> list[Path]:
    """Return the URDF files below these directories, in the order of their names."""
    return sorted(path for directory in directories for path in directory.rglob("*.urdf"))


def main(arguments: list[str]) -> int:
    """Run the study; returns the number of robots beyond the goal."""
    parser = argparse.ArgumentParser(prog="benchmarks.robots", description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("directories", nargs="*", type=Path)
    parser.add_argument("--one", type=Path, help="simulate this file in this process")
    parser.add_argument("--floating", action="store_true", help="the root link moves freely")
    parser.add_argument("--all", action="store_true", help="list all robots")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args(arguments)
    if chosen.one is not None:
        done = fall(chosen.one, chosen.floating)
        print(f"{done.outcome}\t{done.seconds:.4f}\t{done.text}")
        return 0
    with ThreadPoolExecutor(chosen.jobs) as pool:
        falls = list(pool.map(lambda path: fall_apart(path, chosen.floating), robots(chosen.directories)))
    beyond = [of for of in falls if not of.is_good]
    for of in sorted(falls if chosen.all else beyond, key=lambda of: (of.outcome, -of.seconds)):
        print(f"{of.outcome:12} {of.seconds:7.3f} s  {of.path}  {of.text}")
    fell = sum(of.outcome == "fell" for of in falls)
    no_robots = sum(of.outcome == "not imported" for of in falls)
    print(f"{len(falls)} files: {no_robots} not imported, {fell} fell, {len(beyond)} beyond the goal")
    return len(beyond)


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 100))
