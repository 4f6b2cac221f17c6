# SPDX-License-Identifier: BSD-3-Clause
"""Exceptions and warnings for faults in what a user provides; messages use the user's names."""

from __future__ import annotations

import difflib
import errno
import os
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gelenk.simulation.result import Result
    from gelenk.viewer.pages import View

MAX_LISTED = 1000  # files of a folder in which similar names are looked for


class GelenkError(Exception):
    """Base class of Gelenk's own exceptions."""

    @property
    def lines(self) -> tuple[str, ...]:
        """The message, one line per fault."""
        return tuple(str(self).splitlines())


class SceneError(GelenkError):
    """A scene is invalid. The message lists all faults found in it, one per line."""

    def __init__(self, lines: Iterable[str] | str) -> None:
        self._lines = (lines,) if isinstance(lines, str) else tuple(lines)
        super().__init__("\n".join(self._lines))

    @property
    def lines(self) -> tuple[str, ...]:
        """The faults, one line each: "file: path: found ..., expected ..."."""
        return self._lines


class AssemblyError(GelenkError):
    """The loops cannot be closed with these start values. The message gives the smallest closure error and
    its place.
    """


class StepError(GelenkError):
    """A step failed. The plant remains at the last valid time, from which the simulation can continue."""

    #: Results of `gelenk.simulate` up to the failed step; None if `Simulation.step_to` was called directly.
    result: Result | None = None
    #: Page of `gelenk.view` on which the mechanism moves up to the failed step; None if another function
    #: was called.
    view: View | None = None


class StepBudgetError(StepError):
    """A step exhausted its evaluation budget (`solver.max_evaluations`) and ended early, at the plant's
    `time`.

    The next step continues from there.
    """


class UsageError(GelenkError):
    """An invalid call, such as an unknown name, a value that is not finite, or a step back in time."""


class EquilibriumError(GelenkError):
    """No equilibrium was found. The message gives the largest residual acceleration."""


class OperatingPointWarning(UserWarning):
    """A model was linearized about a point that is not an equilibrium: the message gives the rates of the
    states. Or it leaves out idle rotations, which the message names.
    """


class SceneWarning(UserWarning):
    """A scene contains a valid but suspicious value, such as an angle in degrees. The message gives its
    place.
    """


class FileWarning(UserWarning):
    """A file was read that is not complete. The message says what is missing."""


class StartWarning(UserWarning):
    """The start is at or near a singular configuration, the run will not keep its tolerance, or something is
    probably not intended: guesses that are changed a lot, tables of inputs that end early, nothing that
    moves. The message says where, and what follows.
    """


class MissingFileError(GelenkError, FileNotFoundError):
    """A file that should be read does not exist. The message names files with a similar name."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self._message = f"{path}: no such file or directory{_similar(Path(path))}"
        super().__init__(errno.ENOENT, os.strerror(errno.ENOENT), str(path))

    def __str__(self) -> str:
        return self._message

    def __reduce__(self) -> tuple[Any, ...]:
        return MissingFileError, (self.filename,)


def _similar(path: Path) -> str:
    """Return "; did you mean ...?" with files of a similar name in the folder or its folder `scenes`."""
    folders = (path.parent, path.parent / "scenes")
    files = {
        str(file): file.name
        for folder in folders
        if folder.is_dir()
        for file in sorted(folder.iterdir())[:MAX_LISTED]
        if file.suffix.lower() == path.suffix.lower()
    }
    near = difflib.get_close_matches(path.name, files.values(), n=3, cutoff=0.75)
    found = [place for place, name in files.items() if name in near]
    return f"; did you mean {' or '.join(found)}?" if found else ""


class ExportError(GelenkError):
    """A file of an FMU cannot be read or written, or a platform is not available."""
