# SPDX-License-Identifier: BSD-3-Clause
"""FMUs for model exchange as plants, whose states are advanced by CVODE, which fmpy contains."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import byref, c_double, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any, override

import fmpy.fmi1
from fmpy import fmi2
from fmpy.sundials import CVodeSolver
from fmpy.sundials.cvode import CV_ROOT_RETURN, CVode
from fmpy.sundials.libraries import sundials_cvode

from gelenk.errors import StepError
from gelenk.simulation.fmi3 import Model3
from gelenk.simulation.fmu_description import is_fmi3, type_of
from gelenk.simulation.fmu_plant import FmuPlant

_ONE_STEP = 2  # CV_ONE_STEP of CVODE
_DISCARD = 2  # fmi2Discard: a shorter step may help
_ROUNDING = 1e-10  # of an input that continues, relative to its value and at least to 1
_SAME_TIME = 1e-13  # relative: times so near to each other are one, which CVODE requires of its steps
_TOLERANCE = 1e-6  # if the FMU states none
# Of the tolerance, for errors of single steps of the backward differentiation formulas: errors of runs of the
# shipped scenes are then at most 33 times the tolerance at 1e-9, and otherwise 16,000 times. Below the finest
# one rounding prevails.
_OF_STEPS = 1e-3
_FINEST = 1e-13


@dataclass
class _Input:
    """An input in a communication step: a polynomial in the time since its start."""

    value: float = 0.0
    derivatives: Sequence[float] = ()
    reached: float | None = None  # where the last step ended

    def at(self, since: float) -> float:
        return self.value + sum(
            d * since**k / math.factorial(k) for k, d in enumerate(self.derivatives, start=1)
        )

    def has_jumped(self) -> bool:
        if self.reached is None:
            return False
        return abs(self.value - self.reached) > _ROUNDING * max(1.0, abs(self.reached))


class ExchangedFmuPlant(FmuPlant):
    """A model exchange FMU of FMI 2.0 or 3.0 as a plant; see `gelenk.simulation.plant.Plant`."""

    instance_types = (fmi2.FMU2Model, Model3)
    part = "modelExchange"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.held = frozenset(name for name in self.inputs if type_of(self._variables[name]) != "Real")
        self._solver: _Cvode | None = None
        self._signals: dict[str, _Input] = {}
        self._start = 0.0  # s: of the communication step
        self._next_event = math.inf

    @property
    @override
    def run_warnings(self) -> list[str]:
        return list(self._warnings_in_steps)  # those of methods of the FMU do not apply

    @override
    def start(
        self,
        tolerance: float | None,
        inputs: Mapping[str, float],
        input_derivatives: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        self._signals.clear()
        self._start = 0.0
        super().start(tolerance, inputs)
        own = getattr(self._description.defaultExperiment, "tolerance", None)
        of_steps = max(_FINEST, _OF_STEPS * (tolerance or float(own or _TOLERANCE)))
        with self._reporting(StepError):
            self._pass_event()
            self._solver = _Cvode(self._slave, self._description, self.set_time, of_steps)

    @override
    def set_input(self, name: str, value: float) -> None:
        super().set_input(name, value)
        signal = self._signals.setdefault(name, _Input())
        signal.value, signal.derivatives = value, ()

    @override
    def set_input_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        self._signals[name].derivatives = tuple(derivatives)

    def set_time(self, t: float) -> None:
        """Go to a time [s], with the inputs there."""
        self._slave.setTime(t)
        moving = {name: signal for name, signal in self._signals.items() if any(signal.derivatives)}
        if moving:
            self._slave.setReal(
                self._references_of([*moving]), [signal.at(t - self._start) for signal in moving.values()]
            )

    @override
    def advance(self, start: float, end: float) -> None:
        self._start = t = start
        with self._last_reason(), self._reporting(StepError):
            self.set_time(t)
            if any(signal.has_jumped() for signal in self._signals.values()):
                self._event(t)
            while t < end:
                t = self._step_towards(t, min(end, self._next_event))
        for signal in self._signals.values():  # held from here, unless they are set again
            signal.value = signal.reached = signal.at(end - start)
            signal.derivatives = ()
        self._warnings_in_steps += self._warnings

    @contextmanager
    def _last_reason(self) -> Iterator[None]:
        """Keep the last of the sentences in an error: each step that is discarded gives one."""
        try:
            yield
        except StepError as e:
            raise StepError(str(e).splitlines()[-1]) from e

    def _step_towards(self, t: float, end: float) -> float:
        assert self._solver is not None
        has_root = False
        if end - t > _SAME_TIME * abs(end):
            has_root, t = self._solver.step_towards(end)
        else:
            t = end
        self.set_time(t)
        has_step_event, terminates = self._slave.completedIntegratorStep()
        if has_root or has_step_event or t >= self._next_event:
            self._event(t)
        if terminates:
            raise StepError(f"t = {t:g} s: the FMU ends the simulation")
        return t

    def _event(self, t: float) -> None:
        assert self._solver is not None
        self._slave.enterEventMode()
        self._pass_event()
        self._solver.reset(t)

    def _pass_event(self) -> None:
        again, terminates = True, False
        while again and not terminates:
            again, terminates, _, _, is_defined, time = self._slave.newDiscreteStates()
            self._next_event = time if is_defined else math.inf
        if terminates:
            raise StepError("the FMU ends the simulation at an event")
        self._slave.enterContinuousTimeMode()


class _Cvode(CVodeSolver):  # type: ignore[misc]
    """fmpy's solver, which does not step beyond a time, and shortens steps that an FMU discards."""

    def __init__(
        self, fmu: Any, description: Any, set_time: Callable[[float], None], tolerance: float
    ) -> None:
        self._failure: Exception | None = None
        super().__init__(
            nx=description.numberOfContinuousStates,
            nz=len(description.eventIndicators)
            if is_fmi3(description)
            else description.numberOfEventIndicators,
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=set_time,
            input=_NoInput(),
            startTime=0.0,
            relativeTolerance=tolerance,
        )

    @override
    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
        return self._tried(super().f, t, y, ydot, user_data)

    @override
    def g(self, t: float, y: Any, gout: Any, user_data: Any) -> int:
        return self._tried(super().g, t, y, gout, user_data)

    def _tried(self, call: Callable[..., int], *arguments: Any) -> int:
        """Call a function of CVODE; exceptions cannot pass through it."""
        try:
            return call(*arguments)
        except fmpy.fmi1.FMICallException as e:
            self._failure = e
            return 1 if e.status == _DISCARD else -1
        except Exception as e:
            self._failure = e
            return -1

    def step_towards(self, end: float) -> tuple[bool, float]:
        """Make one step, at most to a time or to the first zero of an event indicator.

        Returns:
            bool: whether an event indicator has changed its sign.
            float: the time reached [s].

        Raises:
            StepError: CVODE cannot continue.
        """
        reached = c_double(0.0)
        sundials_cvode.CVodeSetStopTime(c_void_p(self.cvode_mem), c_double(end))
        flag = CVode(self.cvode_mem, end, self.x, byref(reached), _ONE_STEP)
        if flag < 0:
            if self._failure is not None:
                raise self._failure
            raise StepError(f"t = {reached.value:g} s: CVODE: {self.error_info[3]}")
        if not self.discrete:
            self.set_x(self.px, self.nx)
        return flag == CV_ROOT_RETURN, reached.value


class _NoInput:
    """Inputs are set with the time."""

    def apply(self, t: float) -> None:
        """Do nothing."""
