# SPDX-License-Identifier: BSD-3-Clause
"""Measure where located events and steps cost the same: `python -m benchmarks.contacts.schemes`.

Balls are thrown on a floor, bounce, slide and roll, without touching each other, so that their motion can be
computed to any accuracy. CPU time is divided between phases in which nothing happens and events. The picture
and the table, from which the thresholds of `auto` are chosen (src/event/scheme_watch.h), are written to
docs/nonsmooth-measurements.md, with `--print` to the terminal only.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.contacts.problems import GRAVITY, Array
from benchmarks.page_parts import put

import gelenk
from gelenk.chart.style import save
from gelenk.chart.tables import rows
from gelenk.extras import pyplot

ROOT = Path(__file__).resolve().parents[2]
MAKER = "benchmarks/contacts/schemes.py"
COUNTS = (1, 2, 4, 8, 16)
DRAWN = (1, 4, 16)
STOP, STEP = 1.0, 0.02  # s: end and communication step
TOLERANCES = (1e-4, 1e-6, 1e-8)
STEPS = (1e-2, 1e-3, 1e-4)  # s
REFERENCE = 1e-11  # tolerance
RADIUS, MASS = 0.05, 0.5  # m, kg


def balls(count: int, **solver: Any) -> dict[str, Any]:
    rng = np.random.default_rng(3)
    names = range(count)
    starts = [
        {
            "r": [0, 0.5 * k, 0.1 + 0.2 * rng.random()],
            "v": [float(rng.uniform(0.5, 1)), 0, 0],
            "w": rng.normal(size=3).tolist(),
            "fixed": True,
        }
        for k in names
    ]
    shape = {"s": {"sphere": RADIUS, "surface": "stone"}}
    inertia = [0.4 * MASS * RADIUS**2] * 3
    return {
        "gelenk": 1,
        "gravity": [0, 0, -GRAVITY],
        "bodies": {f"b{k}": {"mass": MASS, "inertia": inertia, "shapes": shape} for k in names},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "stone"}}},
        "joints": {
            f"j{k}": {"type": "free", "parent": "ground", "child": f"b{k}", "start": starts[k]} for k in names
        },
        "contacts": {"c": {"between": ["stone", "stone"], "friction": 0.4, "restitution": 0.3}},
        "solver": {"max_evaluations": 10_000_000, "max_events": 100_000, **solver},
    }


@dataclass
class Course:
    """A run.

    Attributes:
        places: of the balls at the end, shape (balls, 3) [m].
        cpu: of each communication step [s].
        events: in each.
        closed: points of contact at the end of each.
    """

    places: Array
    cpu: Array
    events: Array
    closed: Array

    @property
    def work(self) -> float:
        """CPU time per simulated second [s]."""
        return float(self.cpu.sum() / STOP)

    @property
    def rolling(self) -> float:
        """CPU time per simulated second while all balls roll [s]."""
        at_rest = (self.events == 0) & (self.closed == self.closed[-1])
        return float(np.median(self.cpu[at_rest]) / STEP)


def run(count: int, tolerance: float = 1e-6, **solver: Any) -> Course:
    plant = gelenk.Simulation(gelenk.load(balls(count, **solver)))
    plant.initialize(tolerance=tolerance)
    records = []
    events = 0.0
    for k in range(1, round(STOP / STEP) + 1):
        start = time.process_time()
        plant.step_to(k * STEP)
        cpu = time.process_time() - start
        now = plant.diagnostic("solver.events")
        records.append((cpu, now - events, plant.diagnostic("solver.contact_points")))
        events = now
    places = np.array([plant.values([f"j{k}.r[{i}]" for i in (1, 2, 3)]) for k in range(count)])
    cpu, count_of_events, closed = np.array(records).T
    return Course(places, cpu, count_of_events, closed)


def cost_of_event(located: Course) -> float:
    """CPU time beyond that of rolling, by event [s]."""
    flight = located.cpu.sum() - located.rolling * STOP
    return float(flight / max(1.0, located.events.sum()))


def table(located: dict[int, Course], stepped: dict[int, Course]) -> str:
    lines = []
    for count, course in located.items():
        per_step = stepped[count].work * 1e-3
        cells = [course.rolling, stepped[count].rolling, 1e3 * cost_of_event(course), 1e3 * per_step]
        ratio = cost_of_event(course) / per_step
        lines.append(
            [str(count), *(f"{1e3 * cell:.3g}" for cell in cells[:2]), f"{cells[2]:.2g}", f"{ratio:.0f}"]
        )
    head = [
        "balls",
        "rolling: events [ms/s]",
        "rolling: steps of 1 ms [ms/s]",
        "an event [ms]",
        "in steps of 1 ms",
    ]
    return rows(head, lines)


def draw(path: Path) -> None:
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(7, 4.2), layout="constrained")
    for count, color in zip(DRAWN, ("#0072B2", "#D55E00", "#009E73"), strict=True):
        exact = run(count, REFERENCE, integrator="erk").places
        series = (
            ("events", "o-", [run(count, tolerance, integrator="erk") for tolerance in TOLERANCES]),
            ("steps", "s--", [run(count, integrator="moreau-jean", step=h) for h in STEPS]),
        )
        for name, look, courses in series:
            errors = [float(np.abs(course.places - exact).max()) for course in courses]
            work = [1e3 * course.work for course in courses]
            word = "ball" if count == 1 else "balls"
            axis.loglog(errors, work, look, color=color, label=f"{count} {word}, {name}")
    axis.invert_xaxis()
    axis.set(xlabel="largest error after 1 s [m]", ylabel="CPU time per simulated second [ms]")
    axis.grid(which="major", alpha=0.3)
    axis.legend(frameon=False, fontsize=8)
    save(figure, path, 100)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--print", action="store_true", help="do not write the page")
    options = parser.parse_args(arguments)
    located = {count: run(count, integrator="erk") for count in COUNTS}
    stepped = {count: run(count, integrator="moreau-jean", step=1e-3) for count in COUNTS}
    shown = table(located, stepped)
    if options.print:
        print(shown)
        return
    picture = ROOT / "docs" / "pictures" / "contact-schemes.png"
    draw(picture)
    put(
        ROOT / "docs" / "nonsmooth-measurements.md",
        MAKER,
        {"schemes": f"![work against error of both schemes](pictures/{picture.name})\n\n{shown}"},
    )


if __name__ == "__main__":
    main()
