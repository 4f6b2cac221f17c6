# SPDX-License-Identifier: BSD-3-Clause
"""fmpy's instances of FMUs of FMI 3.0, with the functions of FMI 2.0 that FMI 3.0 names otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import c_bool, c_void_p
from pathlib import Path
from typing import Any

from fmpy import fmi3

from gelenk import _core


class _WordsOfFmi2:
    """What FMI 2.0 calls otherwise. Arguments are fmpy's."""

    integer_types: Mapping[int, str] = {}  # of whole numbers and choices, by value reference
    _experiment: tuple[float | None, float] = (None, 0.0)

    def begin(self: Any, log: _core.FmuLog, *, verbose: bool) -> None:
        """Create the instance, with a log that lives as long as it.

        Raises:
            Exception: there is none.
        """
        self.callback = fmi3.fmi3LogMessageCallback(log.logger_of_fmi3)
        resources = f"{Path(self.unzipDirectory) / 'resources'}/"
        texts = [text.encode() for text in (self.instanceName, self.guid, resources)]
        environment = c_void_p(log.environment)
        self.component = self.created(*texts, c_bool(False), c_bool(verbose), environment)
        if not self.component:
            raise Exception("the FMU cannot be instantiated")

    def setupExperiment(self, tolerance: float | None = None, startTime: float = 0.0) -> None:
        self._experiment = (tolerance, startTime)

    def enterInitializationMode(self) -> None:
        tolerance, start = self._experiment
        super().enterInitializationMode(tolerance=tolerance, startTime=start)  # type: ignore[misc]

    def getReal(self: Any, references: Sequence[int]) -> list[float]:
        return list(self.getFloat64(references))

    def setReal(self: Any, references: Sequence[int], values: Sequence[float]) -> None:
        self.setFloat64(references, values)

    def setInteger(self: Any, references: Sequence[int], values: Sequence[int]) -> None:
        for reference, value in zip(references, values, strict=True):
            getattr(self, f"set{self.integer_types[reference]}")([reference], [value])


class Slave3(_WordsOfFmi2, fmi3.FMU3Slave):  # type: ignore[misc]
    """An instance for co-simulation."""

    def created(self, *arguments: Any) -> Any:
        """Return the instance of the library."""
        *first, environment = arguments
        self.no_update = fmi3.fmi3IntermediateUpdateCallback()
        none = (fmi3.fmi3ValueReference * 0)()
        return self.fmi3InstantiateCoSimulation(
            *first, c_bool(False), c_bool(False), none, 0, environment, self.callback, self.no_update
        )


class Model3(_WordsOfFmi2, fmi3.FMU3Model):  # type: ignore[misc]
    """An instance for model exchange."""

    def created(self, *arguments: Any) -> Any:
        """Return the instance of the library."""
        return self.fmi3InstantiateModelExchange(*arguments, self.callback)

    def newDiscreteStates(self) -> Any:  # noqa: D102
        return self.updateDiscreteStates()

    def getDerivatives(self, derivatives: Any, count: int) -> Any:  # noqa: D102
        return self.getContinuousStateDerivatives(derivatives, count)
