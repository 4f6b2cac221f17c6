# SPDX-License-Identifier: BSD-3-Clause
"""A bare importer of FMUs of FMI 3.0 for model exchange through ctypes."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_bool, c_double, c_size_t
from dataclasses import dataclass
from typing import Any

from fmu.host import OK
from fmu.host3 import Fmu3, Slave3


@dataclass
class Event:
    """Where all flags of fmi3UpdateDiscreteStates that need another call or change nominals are false."""

    states_changed: bool
    next_time: float | None


class Importer3(Slave3):
    """An instance for model exchange. Methods named after what they read assert that the call succeeds."""

    def __init__(self, fmu: Fmu3, **options: Any) -> None:
        super().__init__(fmu, **options)
        self.size = len(fmu.description.derivatives)

    def _instantiate(self, name: bytes | None, token: bytes | None, resources: bytes | None) -> Any:
        return self.fmu.library.fmi3InstantiateModelExchange(
            name, token, resources, c_bool(False), c_bool(self.logging_on), None, self._logger
        )

    def start(self) -> Importer3:
        """In continuous-time mode at t = 0."""
        super().start()
        self.event()
        self.go_on()
        return self

    def update(self, missing: int | None = None) -> tuple[int, list[float]]:
        """Status and results of fmi3UpdateDiscreteStates; `missing`: the place that is null."""
        places = [c_bool() for _ in range(5)] + [c_double()]
        pointers = [None if i == missing else ctypes.byref(place) for i, place in enumerate(places)]
        return self.call("fmi3UpdateDiscreteStates", *pointers), [place.value for place in places]

    def event(self) -> Event:
        status, (again, ends, nominals, states, has_next, time) = self.update()
        assert status == OK, self.said
        assert not again
        assert not ends
        assert not nominals
        return Event(bool(states), time if has_next else None)

    def enter_event_mode(self) -> None:
        assert self.call("fmi3EnterEventMode") == OK, self.said

    def go_on(self) -> None:
        assert self.call("fmi3EnterContinuousTimeMode") == OK, self.said

    def set_time(self, t: float) -> int:
        return self.call("fmi3SetTime", c_double(t))

    def set_states(self, x: Sequence[float]) -> int:
        return self.call("fmi3SetContinuousStates", (c_double * len(x))(*x), c_size_t(len(x)))

    def go_to(self, t: float, x: Sequence[float]) -> None:
        for status in (self.set_time(t), self.set_states(x)):
            assert status == OK, self.said

    def read(self, function: str, count: int) -> tuple[int, list[float]]:
        values = (c_double * max(1, count))()
        return self.call(function, values, c_size_t(count)), list(values)[:count]

    def _of_states(self, function: str) -> list[float]:
        status, values = self.read(function, self.size)
        assert status == OK, self.said
        return values

    def states(self) -> list[float]:
        return self._of_states("fmi3GetContinuousStates")

    def rates(self) -> list[float]:
        return self._of_states("fmi3GetContinuousStateDerivatives")

    def nominals(self) -> list[float]:
        return self._of_states("fmi3GetNominalsOfContinuousStates")

    def count(self, what: str) -> int:
        number = c_size_t(99)
        assert self.call(f"fmi3GetNumberOf{what}", ctypes.byref(number)) == OK, self.said
        return number.value

    def completed(self) -> bool:
        """Whether event mode must be entered."""
        needed, ends = c_bool(), c_bool()
        places = ctypes.byref(needed), ctypes.byref(ends)
        assert self.call("fmi3CompletedIntegratorStep", c_bool(True), *places) == OK, self.said
        assert not ends.value
        return needed.value
