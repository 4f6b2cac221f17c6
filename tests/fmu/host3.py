# SPDX-License-Identifier: BSD-3-Clause
"""A bare host of FMI 3.0 through ctypes: every call gives its status and what was logged, unchecked."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from ctypes import c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy

from fmu.host import OK

Logger = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
KINDS: dict[str, Any] = {"Float64": c_double, "Int32": c_int32, "Int64": c_int64, "Boolean": c_bool}


class Fmu3:
    """An extracted FMU: its library and its table of variables."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.description = fmpy.read_model_description(str(folder), validate=False)
        self.variables = {v.name: v for v in self.description.modelVariables}
        (library,) = (self.folder / "binaries" / "x86_64-linux").glob("*.so")
        self.library = ctypes.CDLL(str(library))
        for kind in ("CoSimulation", "ModelExchange", "ScheduledExecution"):
            getattr(self.library, f"fmi3Instantiate{kind}").restype = c_void_p
        self.library.fmi3FreeInstance.restype = None

    @property
    def outputs(self) -> list[str]:
        return [name for name, v in self.variables.items() if v.causality == "output"]


@dataclass
class Step:
    status: int
    event: bool
    terminate: bool
    early: bool
    time: float


class Slave3:
    """One instance for co-simulation. `log` holds (status, category, sentence) of every message so far."""

    def __init__(
        self,
        fmu: Fmu3,
        name: str | None = "plant",
        *,
        token: str | None = "",
        resources: str | None = "",
        logging_on: bool = False,
        event_mode: bool = False,
        early_return: bool = False,
        intermediate: int = 0,
    ) -> None:
        self.fmu = fmu
        self.log: list[tuple[int, str, str]] = []
        self._logger = Logger(self._write)
        self.logging_on = logging_on
        self._of_co_simulation = (c_bool(event_mode), c_bool(early_return), None, c_size_t(intermediate))
        self.instance = self._instantiate(
            _text(name),
            _text(fmu.description.instantiationToken if token == "" else token),
            _text(f"{fmu.folder / 'resources'}/" if resources == "" else resources),
        )

    def _instantiate(self, name: bytes | None, token: bytes | None, resources: bytes | None) -> Any:
        return self.fmu.library.fmi3InstantiateCoSimulation(
            name, token, resources, c_bool(False), c_bool(self.logging_on), *self._of_co_simulation,
            None, self._logger, None,
        )  # fmt: skip

    def _write(self, _env: Any, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(), message.decode()))

    @property
    def said(self) -> str:
        """The last sentence."""
        return self.log[-1][2] if self.log else ""

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.fmu.library, function)(c_void_p(self.instance), *arguments))

    def free(self) -> None:
        self.fmu.library.fmi3FreeInstance(c_void_p(self.instance))

    def enter(self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> int:
        return self.call(
            "fmi3EnterInitializationMode",
            c_bool(tolerance is not None),
            c_double(tolerance or 0.0),
            c_double(start),
            c_bool(stop is not None),
            c_double(stop or 0.0),
        )

    def leave(self) -> int:
        return self.call("fmi3ExitInitializationMode")

    def start(self) -> Slave3:
        """Ready to step from t = 0."""
        for status in (self.enter(), self.leave()):
            assert status == OK, self.said
        return self

    def step(self, current: float, size: float) -> Step:
        event, terminate, early, time = c_bool(), c_bool(), c_bool(), c_double()
        places = [ctypes.byref(place) for place in (event, terminate, early, time)]
        status = self.call("fmi3DoStep", c_double(current), c_double(size), c_bool(True), *places)
        return Step(status, event.value, terminate.value, early.value, time.value)

    def references(self, names: Sequence[str]) -> Any:
        return (c_uint * len(names))(*(self.fmu.variables[n].valueReference for n in names))

    def set(self, values: Mapping[str, float], kind: str = "Float64") -> int:
        numbers = (KINDS[kind] * len(values))(*values.values())
        size = c_size_t(len(values))
        return self.call(f"fmi3Set{kind}", self.references(list(values)), size, numbers, size)

    def get(self, names: Sequence[str], kind: str = "Float64") -> list[Any]:
        values, size = (KINDS[kind] * len(names))(), c_size_t(len(names))
        assert self.call(f"fmi3Get{kind}", self.references(names), size, values, size) == OK, self.said
        return list(values)

    def outputs(self) -> list[float]:
        return self.get(self.fmu.outputs)

    def run(self, steps: int, size: float = 1e-2, first: int = 0) -> list[list[float]]:
        """Outputs after each of the steps."""
        rows = []
        for k in range(first, first + steps):
            assert self.step(k * size, size).status == OK, self.said
            rows.append(self.outputs())
        return rows

    def sensitivity(
        self, function: str, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float], count: int
    ) -> list[float]:
        out = (c_double * count)()
        status = self.call(
            function,
            self.references(unknowns), c_size_t(len(unknowns)),
            self.references(knowns), c_size_t(len(knowns)),
            (c_double * len(seed))(*seed), c_size_t(len(seed)),
            out, c_size_t(count),
        )  # fmt: skip
        assert status == OK, self.said
        return list(out)


def _text(value: str | None) -> bytes | None:
    return None if value is None else value.encode()


def expect(slave: Slave3, status: int, wanted: int, *words: str) -> None:
    """This status and one new finished sentence with these words."""
    assert status == wanted, (status, slave.log)
    assert len(slave.log) == 1, slave.log
    assert slave.log[0][0] == wanted
    for word in words:
        assert word in slave.said, f"{word!r} not in {slave.said!r}"
    slave.log.clear()
