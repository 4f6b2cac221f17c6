# SPDX-License-Identifier: BSD-3-Clause
"""A bare host of FMI 2.0 through ctypes: every call gives its status and what was logged, unchecked."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any

import fmpy

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
MODEL_EXCHANGE, CO_SIMULATION = range(2)
DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED = range(4)

Logger = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", Logger),
        ("allocateMemory", c_void_p),
        ("freeMemory", c_void_p),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    )


class Fmu:
    """An extracted FMU: its library and its table of variables."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.description = fmpy.read_model_description(str(folder), validate=False)
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        (library,) = (self.folder / "binaries" / "linux64").glob("*.so")
        self.library = ctypes.CDLL(str(library))
        self.library.fmi2Instantiate.restype = c_void_p
        self.library.fmi2FreeInstance.restype = None

    @property
    def resources(self) -> str:
        return (self.folder / "resources").as_uri()


class Slave:
    """One instance. `log` holds (status, category, sentence) of every message so far."""

    def __init__(
        self,
        fmu: Fmu,
        name: str | None = "plant",
        *,
        kind: int = CO_SIMULATION,
        guid: str | None = "",
        resources: str | None = "",
        callbacks: bool = True,
        logger: bool = True,
        logging_on: bool = False,
    ) -> None:
        self.fmu = fmu
        self.log: list[tuple[int, str, str]] = []
        self._logger = Logger(self._write) if logger else Logger()
        self._callbacks = Callbacks(self._logger, None, None, None, None)
        self.component = fmu.library.fmi2Instantiate(
            _text(name),
            c_int(kind),
            _text(fmu.description.guid if guid == "" else guid),
            _text(fmu.resources if resources == "" else resources),
            ctypes.byref(self._callbacks) if callbacks else None,
            c_int(0),
            c_int(logging_on),
        )

    def _write(self, _env: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
        text = message.decode()
        assert "%" not in text.replace("%%", ""), f"the logger takes it for a format: {text}"
        self.log.append((status, category.decode(), text.replace("%%", "%")))

    @property
    def said(self) -> str:
        """The last sentence."""
        return self.log[-1][2] if self.log else ""

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.fmu.library, function)(c_void_p(self.component), *arguments))

    def free(self) -> None:
        self.fmu.library.fmi2FreeInstance(c_void_p(self.component))

    def setup(self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> int:
        return self.call(
            "fmi2SetupExperiment",
            c_int(tolerance is not None),
            c_double(tolerance or 0.0),
            c_double(start),
            c_int(stop is not None),
            c_double(stop or 0.0),
        )

    def enter(self) -> int:
        return self.call("fmi2EnterInitializationMode")

    def leave(self) -> int:
        return self.call("fmi2ExitInitializationMode")

    def start(self) -> Slave:
        """Ready to step from t = 0."""
        for status in (self.setup(), self.enter(), self.leave()):
            assert status == OK, self.said
        return self

    def step(self, current: float, size: float) -> int:
        return self.call("fmi2DoStep", c_double(current), c_double(size), c_int(1))

    def references(self, names: Sequence[str]) -> Any:
        return (c_uint * len(names))(*(self.fmu.reference[n] for n in names))

    def set_real(self, **values: float) -> int:
        """Names with __ for the dot: drive__tau=3.0."""
        return self.set({name.replace("__", "."): value for name, value in values.items()})

    def set(self, values: dict[str, float], function: str = "fmi2SetReal", kind: Any = c_double) -> int:
        numbers = (kind * len(values))(*values.values())
        return self.call(function, self.references(list(values)), c_size_t(len(values)), numbers)

    def get(self, name: str, function: str = "fmi2GetReal", kind: Any = c_double) -> Any:
        value = (kind * 1)()
        status = self.call(function, self.references([name]), c_size_t(1), value)
        assert status == OK, self.said
        return value[0]

    def outputs(self) -> list[float]:
        names = [v.name for v in self.fmu.description.modelVariables if v.causality == "output"]
        values = (c_double * len(names))()
        assert self.call("fmi2GetReal", self.references(names), c_size_t(len(names)), values) == OK, self.said
        return list(values)

    def run(self, steps: int, size: float = 1e-2, first: int = 0) -> list[list[float]]:
        """Outputs after each of the steps."""
        rows = []
        for k in range(first, first + steps):
            assert self.step(k * size, size) == OK, self.said
            rows.append(self.outputs())
        return rows


def _text(value: str | None) -> bytes | None:
    return None if value is None else value.encode()


def expect(slave: Slave, status: int, wanted: int, *words: str) -> None:
    """This status and one new finished sentence with these words."""
    assert status == wanted, (status, slave.log)
    assert len(slave.log) == 1, slave.log
    assert slave.log[0][0] == wanted
    for word in words:
        assert word in slave.said, f"{word!r} not in {slave.said!r}"
    slave.log.clear()
