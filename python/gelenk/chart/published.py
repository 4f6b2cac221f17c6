# SPDX-License-Identifier: BSD-3-Clause
"""Evaluations against published figures of other solvers at equal accuracy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gelenk.chart import mechanisms
from gelenk.chart.case import Case
from gelenk.chart.measure import Runner, Task
from gelenk.chart.methods import AUTO, Method
from gelenk.chart.scenes import ANDREWS, light_cart_pole_truth
from gelenk.chart.tables import rows
from gelenk.errors import GelenkError

# MEBDFI on Andrews' squeezer, index 3 (Mazzia & Magherini, IVP Test Set 2.4): rtol = atol, residuals,
# Jacobians, significant correct digits of q. The row at 1e-2 stopped early.
MEBDFI = (
    (1e-3, 350, 22, -0.21), (1e-4, 466, 23, 0.37), (1e-5, 736, 29, 2.49), (1e-6, 993, 39, 4.01),
    (1e-7, 1310, 40, 3.13), (1e-8, 1674, 56, 5.59), (1e-9, 2026, 64, 5.49), (1e-10, 2564, 73, 5.79),
)  # fmt: skip
# SciPy's DOP853 on the light cart-pole (N. Parsons 2026): rtol, right-hand sides, e.
DOP853 = ((1e-4, 10352, 7.289e-3), (1e-6, 15923, 1.077e-4), (1e-8, 25574, 1.451e-7), (1e-10, 43154, 2.021e-9),
          (1e-12, 53240, 1.222e-10))  # fmt: skip
CRITERION = 1e-6  # acceptable e of the publication
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(6, 25))


@dataclass(frozen=True)
class Effort:
    """A run of Gelenk; its error is measured as in the publication."""

    tolerance: float
    evaluations: float
    error: float


def andrews_case() -> Case:
    """Return Andrews' squeezer for 30 ms in one communication step."""
    return Case("andrews", "", mechanisms.shipped("andrews"), 0.03, 0.03)


def andrews_efforts(method: Method = AUTO) -> list[Effort]:
    """Run a method at all tolerances; the error is the largest relative one of the seven angles at 30 ms
    against PSIDE's solution.
    """
    efforts = []
    for tolerance in TOLERANCES:
        runner = Runner(Task(andrews_case(), method, tolerance))
        try:
            course = runner.record()
        except GelenkError:
            continue
        end = dict(zip(runner.names, course.states[-1], strict=True))
        error = max(abs(float(end[f"{name}.phi"]) / phi - 1) for name, (phi, _) in ANDREWS.items())
        efforts.append(Effort(tolerance, course.counts["solver.evaluations"], error))
    return efforts


def cart_pole_case(step: float) -> Case:
    """Return the light cart-pole for 10 s with this communication step [s]; 0.01 s in the publication."""
    return Case("light-cart-pole", "", mechanisms.light_cart_pole(), 10.0, step)


def cart_pole_efforts(step: float, method: Method = AUTO) -> list[Effort]:
    """Run a method at all tolerances; the error is the root mean square of (x, theta) over the samples
    against the closed form. step: communication step [s].
    """
    case = cart_pole_case(step)
    truth = light_cart_pole_truth(case.grid[case.samples()])
    efforts = []
    for tolerance in TOLERANCES:
        try:
            runner = Runner(Task(case, method, tolerance))
            course = runner.record()
        except GelenkError:
            continue
        squares = sum(
            (course.states[:, runner.names.index(name)] - truth[name]) ** 2
            for name in ("track.s", "hinge.phi")
        )
        error = math.sqrt(float(np.mean(squares)))
        efforts.append(Effort(tolerance, course.counts["solver.evaluations"], error))
    return efforts


def cheapest(efforts: list[Effort], error: float) -> Effort | None:
    """Return the run with the fewest evaluations whose error is at most `error`, or None."""
    return min((e for e in efforts if e.error <= error), key=lambda e: e.evaluations, default=None)


def andrews_table(efforts: list[Effort]) -> str:
    """Return a table of MEBDFI's figures and of Gelenk's cheapest runs with at least as many digits."""
    lines = []
    for tolerance, residuals, jacobians, digits in MEBDFI:
        ours = cheapest(efforts, 10.0**-digits)
        mine = ["none", "", ""] if ours is None else [
            f"{ours.evaluations:.0f}", f"{-math.log10(ours.error):.2f}", f"{ours.tolerance:.0e}"]  # fmt: skip
        lines.append([f"{tolerance:.0e}", str(residuals), str(jacobians), f"{digits:.2f}", *mine])
    header = [
        "MEBDFI: tolerance",
        "residuals",
        "Jacobians",
        "digits",
        "`auto`: evaluations",
        "digits",
        "tolerance",
    ]
    return rows(header, lines)


def cart_pole_table(at_samples: list[Effort], free: list[Effort]) -> str:
    """Return a table of DOP853's figures and of Gelenk's cheapest runs that are at least as accurate.

    Args:
        at_samples: Runs with a communication step for each sample.
        free: Runs with communication steps of 0.5 s.
    """
    lines = []
    criterion = ("published criterion", None, CRITERION)
    for name, count, error in (criterion, *((f"{tolerance:.0e}", n, e) for tolerance, n, e in DOP853)):
        cells = [name, "" if count is None else str(count), f"{error:.1e}"]
        for efforts in (at_samples, free):
            ours = cheapest(efforts, error)
            cells += ["none", ""] if ours is None else [f"{ours.evaluations:.0f}", f"{ours.error:.1e}"]
        lines.append(cells)
    header = ["DOP853: rtol", "evaluations", "e", "`auto`, steps of 0.01 s: evaluations", "e",
              "`auto`, steps of 0.5 s: evaluations", "e"]  # fmt: skip
    return rows(header, lines)
