# SPDX-License-Identifier: BSD-3-Clause
"""Operating points: a mechanism, a state and inputs, and how to reach them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from os import PathLike
from typing import Any

from gelenk.errors import UsageError
from gelenk.model.scene import Scene
from gelenk.model.values import Value, number, start_parameter, unknown
from gelenk.simulation.derivatives import Derivatives
from gelenk.simulation.inputs import InputFunction, Inputs, functions_and_constants, is_motion, set_inputs
from gelenk.simulation.plant import Plant
from gelenk.simulation.run import configure, grid

START = "solver.start"  # the parameter that selects the start state of a run

type Mechanism = Scene | str | PathLike[str] | Mapping[str, Any]
type At = float | Mapping[str, Value] | None


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """An operating point, which `linearize`, `modes` and `equilibrium` accept as their source.

    It can be used in several calls; the keyword arguments of the same names specify one for a single call.

    Attributes:
        source: a .fmu file, or anything `gelenk.load` accepts.
        at: None: the start values. A time [s]: the state that the motion from the start values under
            `input_values` reaches. Values by name: the start values with these replaced: a state of a joint
            ("hinge.phi", attained exactly), a parameter ("hinge.phi_start", "pole.m") or an input.
        input_values: see `gelenk.simulation.inputs.functions`; inputs that are not named are 0.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, if `at` is a time.

    >>> upright = gelenk.OperatingPoint("scenes/cart_pole.yaml", at={"hinge.phi": 0})
    >>> gelenk.linearize(upright).nstates, gelenk.modes(upright).stability
    (4, 'unstable')
    """

    source: Mechanism
    _: KW_ONLY
    at: At = None
    input_values: Inputs | None = None
    parameters: Mapping[str, Value] | None = None
    tolerance: float | None = None

    @classmethod
    def given(
        cls,
        source: Mechanism | OperatingPoint,
        at: At,
        input_values: Inputs | None,
        parameters: Mapping[str, Value] | None,
        tolerance: float | None = None,
    ) -> OperatingPoint:
        """Return the operating point of a call: its source, or one made of its other arguments.

        Args:
            source: a mechanism or an operating point.
            at: as the attribute.
            input_values: as the attribute.
            parameters: as the attribute.
            tolerance: as the attribute.

        Raises:
            UsageError: the source is an operating point, and other arguments are given.
        """
        arguments = {
            "at": at, "input_values": input_values, "parameters": parameters, "tolerance": tolerance
        }  # fmt: skip
        if not isinstance(source, OperatingPoint):
            return cls(source, **arguments)  # type: ignore[arg-type]
        both = ", ".join(name for name, value in arguments.items() if value is not None)
        if both:
            raise UsageError(f"{both}: not allowed with an operating point, which contains them")
        return source

    @property
    def time(self) -> float:
        """Time of the operating point [s]. Raises UsageError if it is negative or not a finite number."""
        if self.at is None or isinstance(self.at, Mapping):
            return 0.0
        time = number("at", self.at, "real")
        if time < 0:
            raise UsageError(f"at: found {time:g} s, expected 0 or more")
        return time

    @property
    def values(self) -> Mapping[str, Value]:
        """Values by name in `at`; empty if it is None or a time."""
        return self.at if isinstance(self.at, Mapping) else {}

    def reach(self, plant: Plant) -> Reached:
        """Start a plant and bring it to the operating point; its inputs keep their values there.

        Args:
            plant: the plant of `source`, not yet started.

        Returns:
            Reached: the parameters that were set, and states whose values remain to be checked.

        Raises:
            UsageError: a name or a value is invalid.
            AssemblyError: the loops cannot be closed with these values.
            StepError: the motion cannot be computed up to `at`.
        """
        settings, exact = self._settings(plant)
        twice = "twice, as an input and in `at`"
        signals = functions_and_constants(self.input_values, settings, [*plant.inputs, *plant.idle], twice)
        configure(plant, settings, self.tolerance, {})
        plant.start(self.tolerance, {name: signal(0.0) for name, signal in signals.items()})
        _advance(plant, self.time, signals)
        return Reached(settings, exact)

    def _settings(self, plant: Plant) -> tuple[dict[str, Value], dict[str, float]]:
        """Return the values to set before the start, and the states that must have exactly these values."""
        known = [*plant.parameters, *plant.inputs, *plant.idle]
        settings = plant.by_parameter(self.parameters or {})
        exact = {}
        faults = []
        outputs = {*plant.outputs, *plant.readings}
        other = {name: value for name, value in self.values.items() if name not in outputs}
        at = {name: value for name, value in self.values.items() if name in outputs}
        for name, value in (at | plant.by_parameter(other)).items():
            start = start_parameter(name)
            place = start if name not in known and start in known else name
            if place not in known:
                faults.append(unknown(name, "state, parameter or input", [*plant.outputs, *known]))
            elif place in settings:
                faults.append(f"{name}: given twice, in `parameters` and in `at`")
            else:
                settings[place] = value
                if place != name:
                    exact[name] = number(name, value, "real")
        if faults:
            raise UsageError("\n".join(faults))
        starts = {start_parameter(name) for name in plant.readings}
        given = [name for name in settings if name in starts and name not in (self.parameters or {})]
        if given and START in plant.parameters:
            settings.setdefault(START, "as_given")  # the plant must not search for an equilibrium from there
        return settings, exact


@dataclass(frozen=True)
class Reached:
    """The settings with which a plant was brought to an operating point.

    Attributes:
        settings: values of parameters, including start values.
        exact: states by name, with the values that they must have.
    """

    settings: Mapping[str, Value]
    exact: Mapping[str, float]

    def check(self, found: Derivatives) -> None:
        """Raise UsageError if a state was an initial guess and assembly has changed it."""
        faults = [
            f"{name}: assembly changed it from {value:.9g} to {found.values[name]:.9g}, because it is an "
            f"initial guess; set {name.rpartition('.')[0]}.fixed to keep it"
            for name, value in self.exact.items()
            if not math.isclose(found.values[name], value, rel_tol=1e-9, abs_tol=1e-9 * found.size(name))
        ]
        if faults:
            raise UsageError("\n".join(faults))


def _advance(plant: Plant, time: float, signals: Mapping[str, InputFunction]) -> None:
    """Advance in the steps of `gelenk.simulate`; the inputs keep their final values."""
    if time == 0:
        return
    times = grid(time, plant.step).tolist()
    for start, end in itertools.pairwise(times):
        set_inputs(plant, signals, start, end)
        plant.advance(start, end)
    for name, signal in signals.items():
        if not is_motion(name):  # motion inputs keep the value reached at the end of the last step
            plant.set_input(name, signal(time))
