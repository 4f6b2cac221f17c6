# SPDX-License-Identifier: BSD-3-Clause
"""How a run ended, told apart four ways."""

from __future__ import annotations

from enum import StrEnum

FACTOR = 100.0  # an error over this many times what was asked is wrong
NO_TWO_DIGITS = 1e-2  # the same for methods of which no error can be asked


class Outcome(StrEnum):
    """Good; finished but wrong; refused, in words; failed: no end within the limit, or a crash."""

    GOOD = "good"
    WRONG = "wrong"
    REFUSED = "refused"
    FAILED = "failed"


def allowed(tolerance: float | None) -> float:
    """The largest error that is still good; tolerance None: of a method with fixed steps."""
    return NO_TWO_DIGITS if tolerance is None else FACTOR * tolerance


def judged(error: float, tolerance: float | None, digits: float) -> Outcome:
    """Of a finished run. digits: error of the reference itself, which a run is not blamed for."""
    return Outcome.GOOD if error <= max(allowed(tolerance), digits) else Outcome.WRONG
