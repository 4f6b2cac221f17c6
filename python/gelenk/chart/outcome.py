# SPDX-License-Identifier: BSD-3-Clause
"""The four outcomes of a run."""

from __future__ import annotations

from enum import StrEnum

FACTOR = 100.0  # largest acceptable error / tolerance
NO_TWO_DIGITS = 1e-2  # largest acceptable error of methods with fixed steps


class Outcome(StrEnum):
    """Good; finished but wrong; refused with an error message; failed by a timeout or a crash."""

    GOOD = "good"
    WRONG = "wrong"
    REFUSED = "refused"
    FAILED = "failed"


def allowed(tolerance: float | None) -> float:
    """Return the largest acceptable error; tolerance None: of a method with fixed steps."""
    return NO_TWO_DIGITS if tolerance is None else FACTOR * tolerance


def judged(error: float, tolerance: float | None, digits: float) -> Outcome:
    """Return the outcome of a finished run.

    Args:
        error: Largest error of the run.
        tolerance: Requested tolerance; None for fixed steps.
        digits: Error of the reference solution; smaller errors are always acceptable.
    """
    return Outcome.GOOD if error <= max(allowed(tolerance), digits) else Outcome.WRONG
