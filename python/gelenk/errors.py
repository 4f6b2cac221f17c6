# SPDX-License-Identifier: BSD-3-Clause
"""What can go wrong because of what a user gave; the messages are whole sentences in the user's names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gelenk.simulation.result import Result


class GelenkError(Exception):
    """The root of Gelenk's own exceptions."""

    @property
    def lines(self) -> tuple[str, ...]:
        """The message, one finished line per fault."""
        return tuple(str(self).splitlines())


class SceneError(GelenkError):
    """A scene that cannot be: every fault found in it, one line each."""

    def __init__(self, lines: Iterable[str] | str) -> None:
        self._lines = (lines,) if isinstance(lines, str) else tuple(lines)
        super().__init__("\n".join(self._lines))

    @property
    def lines(self) -> tuple[str, ...]:
        """One finished line per fault: "file: path: found ..., expected ..."."""
        return self._lines


class AssemblyError(GelenkError):
    """The loops cannot be closed with these start values. Says the smallest gap and where it gapes."""


class StepError(GelenkError):
    """A step could not be made. The plant stands at its last good time and can go on from there."""

    #: What `gelenk.simulate` had computed until then; None when the step was made by hand.
    result: Result | None = None


class StepBudgetError(StepError):
    """A step has used up its evaluations (`solver.max_evaluations`) and ended early, at the plant's `time`.

    Another step takes it on from there.
    """


class UsageError(GelenkError):
    """A wrong call: a name that does not exist, a value that is not finite, a step back in time."""


class EquilibriumError(GelenkError):
    """No equilibrium was found. Says which acceleration remains, and how large it is."""


class OperatingPointWarning(UserWarning):
    """A linear model was asked for about a point that is no equilibrium; names the states that change."""


class SceneWarning(UserWarning):
    """A scene says what is allowed and hardly meant, such as an angle in degrees; names the place."""


class StartWarning(UserWarning):
    """The start is a singular configuration, or beside one; names the loop and what it leaves open."""


class ExportError(GelenkError):
    """A file of the FMU could not be read or written."""
