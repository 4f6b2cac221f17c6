# SPDX-License-Identifier: BSD-3-Clause
"""Results of a simulation: a table of signals over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.file_writing import write_text
from gelenk.model.values import unknown

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from gelenk.model.scene import Source
    from gelenk.viewer.pages import View


LISTED = 12  # names of signals in a repr


class Result:
    """Signals over time: `result["A.phi"]` is an array with the shape of `result.time`."""

    #: What `gelenk.simulate` was called with, the plant and its arguments; None if it was read or unpickled.
    run: tuple[Any, dict[str, Any]] | None = None
    #: The scene of a result that was read from a file, with the parameters of its run, as plain data; None if
    #: the file does not contain it.
    scene: Mapping[str, Any] | None = None

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
        #: Times [s] and descriptions of events, in order: what sticks, slips, meets or leaves a limit or
        #: stop, singular configurations crossed. Empty for an FMU, which logs its events (category
        #: logEvents).
        self.events: tuple[tuple[float, str], ...] = ()
        #: Why the run may not have kept its tolerance, a sentence each: events with an uncertain outcome
        #: (docs/nonsmooth-laws.md); from when to when contacts were solved in time steps, and the estimated
        #: error (docs/time-stepping.md).
        self.warnings: tuple[str, ...] = ()

    def __getstate__(self) -> dict[str, Any]:
        # Inputs may be functions, which cannot be pickled.
        return {name: value for name, value in self.__dict__.items() if name != "run"}

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
        write_text(path, self.csv())

    def csv(self) -> str:
        """Return the text of the CSV file that `to_csv` writes; two marks say that it is complete."""
        from gelenk.simulation.csv_file import csv_text

        return csv_text(list(self._column), self._rows)

    def save(self, path: str | PathLike[str]) -> None:
        """Write all signals to a file; the ending determines the format, all numbers keep their bits.

        Args:
            path: .csv; .parquet, for pandas; .nc (NetCDF 4, which is HDF5), for xarray; or .mat, with the
                variables `time`, `values` (a column for each signal), `names` and `units`. All but CSV
                contain the units.

        Raises:
            UsageError: the ending is another one, or a package for the format is not installed.
            OSError: the file cannot be written.
        """
        from gelenk.simulation.files import write_result

        write_result(self, Path(path))

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Result:
        """Read a file that `save` has written. CSV files contain no units, and no file contains events.

        Raises:
            UsageError: the file is no such result, or a package for its format is not installed.
            OSError: the file cannot be read.

        Warns:
            FileWarning: a CSV file was cut off, as by a full disk of the program that copied it.
        """
        from gelenk.simulation.files import read_result

        return read_result(Path(path))

    def plot(self, names: Sequence[str] = (), *, degrees: bool = False) -> Figure:
        """Plot signals over time, with a panel for each unit and a line at each event.

        Args:
            names: signals, or patterns ("crank.*"); by default all positions.
            degrees: whether angles and their derivatives are plotted in degrees.

        Returns:
            Figure: of matplotlib; its `savefig` writes it, notebooks display it.

        Raises:
            UsageError: a name is unknown, the result has no units, or matplotlib is not installed.
        """
        from gelenk.simulation.plot import plot

        figure: Figure = plot(self, names, degrees=degrees)
        return figure

    def view(self, *, scene: Source | None = None, reactions: bool = False) -> View:
        """Return a page on which the mechanism moves as in this run, which is repeated with its poses.

        A result that was read from a file is not repeated: poses are computed from its joint coordinates.

        Args:
            scene: of a result that was read from a file without one (.csv); anything `gelenk.load` accepts.
            reactions: whether forces and torques of all joints are recorded, too, and shown as arrows; not of
                results from files.

        Raises:
            UsageError: the result has no mechanism, or lacks coordinates of joints.
            SceneError, StepError, OSError: see `gelenk.simulate`.
        """
        from gelenk.simulation.views import view, view_of_result

        source = scene if scene is not None else self.scene
        if self.run is None and source is None:
            raise UsageError(
                "the result has no mechanism: it was read from a file without one, or the run failed; "
                "give its scene"
            )
        if source is not None:
            return view_of_result(self, source)
        assert self.run is not None

        plant, arguments = self.run
        return view(plant, reactions=reactions, **arguments)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame with a column for each signal; the index is `time`, `attrs["units"]` the units.

        Raises:
            UsageError: pandas is not installed.
        """
        from gelenk.simulation.files import to_pandas

        return to_pandas(self)

    def to_xarray(self) -> xr.Dataset:
        """Return a Dataset with the dimension `time`; the attribute `units` of each signal is its unit.

        Raises:
            UsageError: xarray is not installed.
        """
        from gelenk.simulation.files import to_xarray

        return to_xarray(self)

    def _repr_html_(self) -> str:
        from gelenk.simulation.result_html import result_html

        return result_html(self)

    def __repr__(self) -> str:
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "empty"
        listed = ", ".join(self.names[:LISTED])
        left = len(self.names) - LISTED
        more = f" and {left} more" if left > 0 else ""
        events = f", {len(self.events)} event{'' if len(self.events) == 1 else 's'}" if self.events else ""
        return f"<Result {span}, {len(self)} rows{events}: {listed or 'no signals'}{more}>"
