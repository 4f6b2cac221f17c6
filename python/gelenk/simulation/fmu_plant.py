# SPDX-License-Identifier: BSD-3-Clause
"""FMUs as plants that `gelenk.simulate` can run, with fmpy."""

from __future__ import annotations

import logging
import math
import re
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import c_double, c_int, c_uint
from functools import cached_property
from pathlib import Path
from typing import Any, override

import fmpy
import fmpy.fmi1
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import AssemblyError, GelenkError, SceneWarning, StartWarning, StepError, UsageError
from gelenk.file_reading import existing
from gelenk.model.scales import Scales
from gelenk.model.scene import Scene, load
from gelenk.model.values import Value, number
from gelenk.simulation.derivatives import LOCKED_ROUNDING, Derivatives, Quaternion, quaternions_of, rates_of
from gelenk.simulation.fmi3 import Slave3
from gelenk.simulation.fmu_description import (
    annotations_of,
    description_of,
    experiment_of,
    integer_types,
    is_fmi3,
    provides_derivatives,
    type_of,
    unit_of,
)
from gelenk.simulation.fmu_file import extract
from gelenk.simulation.fmu_slave import instantiated
from gelenk.simulation.plant import Plant

log = logging.getLogger(__name__)

_WARNING = 1  # fmi2Warning; larger statuses are failures
_DISCARD = 2  # fmi2Discard: the values are not available


class FmuPlant(Plant):
    """A co-simulation FMU of FMI 2.0 or 3.0 as a plant; see `gelenk.simulation.plant.Plant`."""

    instance_types: tuple[type, type] = (FMU2Slave, Slave3)  # by version of FMI
    part = "coSimulation"  # of fmpy's description

    def __init__(self, path: Path) -> None:
        self._file = existing(path)
        self._messages: list[str] = []
        self._warnings: list[str] = []
        self._warnings_in_steps: list[str] = []
        self._description = description_of(path, self.part)
        self._variables = {v.name: v for v in self._description.modelVariables}
        self.name = str(self._description.modelName)
        self.stop, self.step = experiment_of(path, self._description.defaultExperiment)
        self.inputs = self._names("input")
        self.outputs = self._names("output")
        self.parameters = self._names("parameter")
        self._interface = getattr(self._description, self.part)
        interpolates = bool(getattr(self._interface, "canInterpolateInputs", False))
        self.held = frozenset(
            name for name in self.inputs if not interpolates or type_of(self._variables[name]) != "Real"
        )
        self.idle: list[str] = []
        self.readings = [*self.outputs, *self._names("local")]
        self.units = {name: unit_of(v) for name, v in self._variables.items() if type_of(v) == "Real"}
        self.assembly_report = ""
        self._references: list[int] = []
        self._folder = tempfile.mkdtemp(prefix="gelenk-")
        self._log = _core.FmuLog()
        self._slave: Any = None
        try:
            extract(path, self._folder)
            self._annotations = annotations_of(path, self._folder)
            with self._reporting(UsageError):
                self._slave = instantiated(
                    self.instance_types[is_fmi3(self._description)], self._folder, self._description.guid,
                    self._interface.modelIdentifier, self._log, verbose=log.isEnabledFor(logging.INFO),
                )  # fmt: skip
                self._slave.integer_types = integer_types(self._description)
        except BaseException:
            self.close()
            raise

    def _names(self, causality: str) -> list[str]:
        return [v.name for v in self._description.modelVariables if v.causality == causality]

    @property
    def _is_ours(self) -> bool:
        return str(self._description.generationTool).startswith("Gelenk")

    @cached_property
    @override
    def scene(self) -> Scene | None:
        file = Path(self._folder) / "resources" / "scene.json"
        if not self._is_ours or not file.exists():  # others may name something else so
            return None
        with warnings.catch_warnings():  # which its exporter has seen
            warnings.simplefilter("ignore", SceneWarning)
            return load(file)

    @cached_property
    @override
    def quaternions(self) -> tuple[Quaternion, ...]:
        scene = self.scene
        return () if scene is None else quaternions_of(scene)

    @cached_property
    def _rates(self) -> dict[str, str]:
        """Outputs that are time derivatives, by the names of what they differentiate, as far as known."""
        scene, known = self.scene, {*self._real(self.readings)}
        rates = {} if scene is None else rates_of(_core.output_signals(scene._core))
        return {name: rate for name, rate in rates.items() if rate in known and name in self._variables}

    @property
    @override
    def events(self) -> list[tuple[float, str]]:
        return []  # FMUs log their events

    @property
    @override
    def run_warnings(self) -> list[str]:
        found = list(self._warnings_in_steps)
        if {"solver.scheme", "solver.step_error"} <= self._variables.keys():
            scheme, error = self._slave.getReal(self._references_of(["solver.scheme", "solver.step_error"]))
            if scheme:
                found.append(
                    f"time steps with impulses at the end, with an estimated error of {error:.2g} (m, rad)"
                )
        return found

    @override
    def set_parameters(self, settings: Mapping[str, Value]) -> None:
        for name, value in settings.items():
            self._set(name, value)

    def _set(self, name: str, value: Value) -> None:
        v = self._variables[name]
        with self._reporting(UsageError):
            if type_of(v) == "String":
                self._slave.setString([v.valueReference], [str(value)])
                return
            if choices := self._choices(v):
                x = number(name, value, "enumeration", choices)
                self._slave.setInteger([v.valueReference], [[*choices.values()][int(x) - 1]])
                return
            x = number(name, value, "boolean" if type_of(v) == "Boolean" else "real")
            if type_of(v) == "Boolean":
                self._slave.setBoolean([v.valueReference], [bool(x)])
            elif type_of(v) == "Integer":
                if x != round(x):
                    raise UsageError(f"{name}: found {value!r}, expected a whole number")
                self._slave.setInteger([v.valueReference], [int(x)])
            else:
                self._slave.setReal([v.valueReference], [x])

    def _choices(self, variable: Any) -> dict[str, int]:
        """Return the items of a choice with their numbers; until version 0.1 choices were Enumerations."""
        if type_of(variable) == "Enumeration":
            return {item.name: int(item.value) for item in variable.declaredType.items}
        for choice in () if self._annotations is None else self._annotations.findall(".//Choice"):
            if choice.get("variable") == variable.name:
                return {item.get("name", ""): int(item.get("value", "0")) for item in choice.findall("Item")}
        return {}

    @override
    def reset(self) -> None:
        with self._reporting(UsageError):
            self._slave.reset()

    @override
    def start(
        self,
        tolerance: float | None,
        inputs: Mapping[str, float],
        input_derivatives: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        with self._reporting(AssemblyError):
            self._slave.setupExperiment(tolerance=tolerance, startTime=0.0)
            self._slave.enterInitializationMode()
            for name, value in inputs.items():
                self.set_input(name, value)
            for name, derivatives in (input_derivatives or {}).items():
                self.set_input_derivatives(name, derivatives)
            self._collect_messages()
            self._warnings.clear()
            self._slave.exitInitializationMode()
        self._warnings_in_steps.clear()
        for sentence in self._warnings:
            warnings.warn(sentence, StartWarning, stacklevel=2)

    @override
    def select(self, names: list[str]) -> None:
        for name in names:
            if type_of(self._variables[name]) != "Real":
                raise UsageError(f"{name}: not a real variable; only real variables can be recorded")
        self._references = [self._variables[name].valueReference for name in names]

    @override
    def set_input(self, name: str, value: float) -> None:
        if not np.isfinite(value):
            raise UsageError(f"{name}: found {value}, expected a finite number")
        self._set(name, value)

    @override
    def set_input_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        if is_fmi3(self._description):  # which has none; FMUs of Gelenk continue the values of motions
            return
        n = len(derivatives)
        reference = self._variables[name].valueReference
        with self._reporting(UsageError):  # fmpy's wrapper only works for one number of inputs
            self._slave.fmi2SetRealInputDerivatives(
                self._slave.component, (c_uint * n)(*[reference] * n), n, (c_int * n)(*range(1, n + 1)),
                (c_double * n)(*derivatives),
            )  # fmt: skip

    @override
    def advance(self, start: float, end: float) -> None:
        with self._reporting(StepError):
            self._slave.doStep(start, end - start)
        self._warnings_in_steps += self._warnings

    @override
    def read(self) -> NDArray[np.float64]:
        with self._reporting(StepError):
            return np.array(self._slave.getReal(self._references) if self._references else [])

    @override
    def derivatives(self, coordinates: Sequence[str], friction: str = "present") -> Derivatives:
        if friction != "present":
            raise UsageError(
                f"friction: found {friction!r} with an FMU, expected 'present'; others require the scene"
            )
        if not provides_derivatives(self._file, self._folder, self.part):
            raise UsageError(
                f"{self._file}: this FMU provides no directional derivatives, which linearization requires"
            )
        own = {u.variable.derivative.name: u.variable.name for u in self._description.derivatives}
        declared = {name: self._rates.get(name, rate) for name, rate in own.items()}  # an output if there is
        states = [name for name in self._variables if name in declared]  # in the order of declaration
        inputs, outputs = self._real(self.inputs), self._real(self.outputs)
        unknowns = [*dict.fromkeys([*outputs, *declared.values()])]
        inner = [name for name in states if name not in unknowns]  # states that are not outputs
        names = [*inputs, *unknowns, *inner]
        with self._reporting(UsageError):
            # What contacts permit of changes of states; other tools need not know it.
            asked = [*unknowns, *inner] if self._is_ours else unknowns
            C, D = self._jacobian(asked, states), self._jacobian(asked, inputs)
            if not self._is_ours:
                C = np.vstack([C, np.eye(len(states))[[states.index(n) for n in inner]]])
                D = np.vstack([D, np.zeros((len(inner), len(inputs)))])
            values = self._slave.getReal(self._references_of(names))
        # What is at rest keeps no velocity that it is given. What rolls may move with its heading.
        velocities = {q: declared[q] for q in states if declared[q] in declared}
        locked = (q for q, v in velocities.items() if np.abs(C[unknowns.index(v)]).max() <= LOCKED_ROUNDING)
        return Derivatives(
            tuple(states), tuple(inputs), tuple(outputs), (*unknowns, *inner), C, D,
            dict(zip(names, map(float, values), strict=True)), self._rates | declared, self.quaternions,
            tuple(locked), self.units, *self._annotated(),
        )  # fmt: skip

    def _real(self, names: Iterable[str]) -> list[str]:
        return [name for name in names if type_of(self._variables[name]) == "Real"]

    def _annotated(self) -> tuple[int | None, Scales]:
        """Return the minimal number of states, None if unknown, and the mechanism's own units."""
        order = None if self._annotations is None else self._annotations.find(".//Order")
        if order is None:
            return None, Scales()
        scales = (float(order.get(key, "1")) for key in ("length", "mass", "time"))
        return int(order.get("states", "0")), Scales(*scales)

    def _jacobian(self, unknowns: list[str], knowns: list[str]) -> NDArray[np.float64]:
        columns = [self._column(unknowns, name) for name in knowns]
        return np.array(columns, np.float64).reshape(len(knowns), len(unknowns)).T

    def _column(self, unknowns: list[str], known: str) -> list[float]:
        """Return the derivatives with respect to an input or state, NaN where the FMU cannot give them."""
        references = self._references_of([known])

        def derivatives(of: list[str]) -> list[float]:
            return list(self._slave.getDirectionalDerivative(self._references_of(of), references, [1.0]))

        try:
            return derivatives(unknowns)
        except fmpy.fmi1.FMICallException as e:
            if e.status != _DISCARD:
                raise
            fault = e
        out = []
        for name in unknowns:
            try:
                out += derivatives([name])
            except fmpy.fmi1.FMICallException as e:
                if e.status != _DISCARD:
                    raise
                out.append(math.nan)
        if all(map(math.isnan, out)):
            raise fault
        return out

    def _references_of(self, names: Sequence[str]) -> list[int]:
        return [self._variables[name].valueReference for name in names]

    @override
    def close(self) -> None:
        if self._slave is not None:
            self._slave.freeInstance()
            self._slave = None
        shutil.rmtree(self._folder, ignore_errors=True)

    def _collect_messages(self) -> None:
        """Collect the messages that the FMU has logged."""
        for status, message in self._log.take():
            # Without names of C functions and of unpacked files.
            text = message.decode("utf-8", "replace")
            text = text.replace(f"{self._folder}/resources/scene.json", str(self._file))
            if status > _WARNING:
                text = re.sub(r"^fmi[23]\w+: ", "", text)
                self._messages.append(text)
            else:
                log.info("%s", text)
            if status == _WARNING:
                self._warnings.append(text)

    @contextmanager
    def _reporting(self, error: Callable[[str], GelenkError]) -> Iterator[None]:
        """Turn a failed call of fmpy into an exception with the messages that the FMU has logged."""
        self._messages.clear()
        self._warnings.clear()
        try:
            yield
        except GelenkError:
            raise
        except Exception as e:  # exceptions of fmpy, and plain Exception if instantiation fails
            self._collect_messages()
            if (
                not self._messages
                and not isinstance(e, fmpy.fmi1.FMICallException)
                and type(e) is not Exception
            ):
                raise
            raise error("\n".join(self._messages) or f"{self._file}: {e}") from e
        self._collect_messages()
