# SPDX-License-Identifier: BSD-3-Clause
"""A bare importer of FMUs for model exchange through ctypes."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_double, c_int, c_size_t
from typing import Any

from fmu.host import MODEL_EXCHANGE, OK, Fmu, Slave


class EventInfo(ctypes.Structure):
    _fields_ = (
        ("new_discrete_states_needed", c_int),
        ("terminate_simulation", c_int),
        ("nominals_changed", c_int),
        ("states_changed", c_int),
        ("next_event_time_defined", c_int),
        ("next_event_time", c_double),
    )


class Importer(Slave):
    """An instance for model exchange. Methods named after what they read assert that the call succeeds."""

    def __init__(self, fmu: Fmu, **options: Any) -> None:
        super().__init__(fmu, kind=MODEL_EXCHANGE, **options)
        self.size = len(fmu.description.derivatives)

    def start(self) -> Importer:
        """In continuous-time mode at t = 0."""
        super().start()
        self.event()
        self.go_on()
        return self

    def event(self) -> EventInfo:
        info = EventInfo()
        assert self.new_discrete_states(info) == OK, self.said
        return info

    def new_discrete_states(self, info: EventInfo | None) -> int:
        return self.call("fmi2NewDiscreteStates", None if info is None else ctypes.byref(info))

    def enter_event_mode(self) -> None:
        assert self.call("fmi2EnterEventMode") == OK, self.said

    def go_on(self) -> None:
        assert self.call("fmi2EnterContinuousTimeMode") == OK, self.said

    def set_time(self, t: float) -> int:
        return self.call("fmi2SetTime", c_double(t))

    def set_states(self, x: Sequence[float]) -> int:
        return self.call("fmi2SetContinuousStates", (c_double * len(x))(*x), c_size_t(len(x)))

    def go_to(self, t: float, x: Sequence[float]) -> None:
        for status in (self.set_time(t), self.set_states(x)):
            assert status == OK, self.said

    def read_states(self, function: str, count: int) -> tuple[int, list[float]]:
        values = (c_double * max(1, count))()
        return self.call(function, values, c_size_t(count)), list(values)[:count]

    def _read(self, function: str, count: int) -> list[float]:
        status, values = self.read_states(function, count)
        assert status == OK, self.said
        return values

    def states(self) -> list[float]:
        return self._read("fmi2GetContinuousStates", self.size)

    def rates(self) -> list[float]:
        return self._read("fmi2GetDerivatives", self.size)

    def nominals(self) -> list[float]:
        return self._read("fmi2GetNominalsOfContinuousStates", self.size)

    def indicators(self) -> list[float]:
        count = self.fmu.description.numberOfEventIndicators
        return self._read("fmi2GetEventIndicators", count)

    def completed(self) -> bool:
        """Whether event mode must be entered."""
        needed, ends = c_int(), c_int()
        status = self.call("fmi2CompletedIntegratorStep", c_int(1), ctypes.byref(needed), ctypes.byref(ends))
        assert status == OK, self.said
        assert not ends.value
        return bool(needed.value)
