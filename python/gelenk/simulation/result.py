# SPDX-License-Identifier: BSD-3-Clause
"""Results of a simulation: a table of signals over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.model.values import unknown


class Result:
    """Signals over time: `result["A.phi"]` is an array with the shape of `result.time`."""

    def __init__(self, names: Sequence[str], rows: NDArray[np.float64], units: Mapping[str, str]) -> None:
        """Make a result of rows of shape (times, 1 + len(names)), with time in the first column."""
        self._rows = rows
        self._column = {name: i for i, name in enumerate(("time", *names))}
        #: Units by name, as FMI spells them; "1" for dimensionless signals.
        self.units = dict(units)
        #: What assembly has found; empty if unknown.
        self.assembly_report = ""
        #: Times [s] of the rows before which a singular configuration was crossed, where motion on another
        #: branch is possible; empty if unknown.
        self.singular_positions: tuple[float, ...] = ()
        # : Times [s] and descriptions of events, in order: contacts with stops and releases, singular
        # configurations : crossed. Empty for an FMU, which logs its events (category logEvents).
        self.events: tuple[tuple[float, str], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals, without `time`."""
        return tuple(self._column)[1:]

    @property
    def time(self) -> NDArray[np.float64]:
        """Times [s] of the rows."""
        return self._rows[:, 0]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._column:
            raise UsageError(unknown(name, "output", self._column))
        return self._rows[:, self._column[name]]

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    @property
    def table(self) -> NDArray[np.void]:
        """The results as a structured array with the fields `time` and the names, shape (times,)."""
        fields = np.dtype([(name, np.float64) for name in self._column])
        return np.ascontiguousarray(self._rows).view(fields).reshape(-1)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write `time` and the signals to a CSV file, all numbers with full precision. Raises OSError."""
        Path(path).write_text(self.csv(), encoding="utf-8")

    def csv(self) -> str:
        """Return the text of the CSV file that `to_csv` writes."""
        lines = [",".join(self._column)]
        lines.extend(",".join(map(repr, row)) for row in self._rows.tolist())
        return "\n".join(lines) + "\n"

    def __repr__(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "empty"
        return f"<Result {span}, {len(self)} rows: {', '.join(self.names)}>"
