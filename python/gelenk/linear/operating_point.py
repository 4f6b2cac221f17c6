# SPDX-License-Identifier: BSD-3-Clause
"""Operating points: which mechanism, where, and how it gets there."""

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
from gelenk.simulation.inputs import Inputs, Signal, functions_and_constants, is_motion, set_inputs
from gelenk.simulation.plant import Plant
from gelenk.simulation.run import configure, grid

START = "solver.start"  # the parameter of ours that says what a run begins with

type Mechanism = Scene | str | PathLike[str] | Mapping[str, Any]
type At = float | Mapping[str, Value] | None


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A point of a mechanism's motion, which `linearize`, `modes` and `equilibrium` take for a source.

    Their keyword arguments of the same names make one for a single call.

    Attributes:
        source: a .fmu file, or whatever `gelenk.load` takes.
        at: None, the start values; a time [s], where the motion from the start values under `input_values`
            gets to; or values by name, on top of the start values: a joint's state ("hinge.phi", attained
            exactly), a parameter ("hinge.phi_start", "pole.m"), an input.
        input_values: see `gelenk.simulation.inputs.functions`; inputs that are not named are 0.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, where `at` is a time.

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
        """The point that a call names: its source, if that is one, or one made of the arguments beside it.

        Raises:
            UsageError: both.
        """
        beside = {
            "at": at, "input_values": input_values, "parameters": parameters, "tolerance": tolerance
        }  # fmt: skip
        if not isinstance(source, OperatingPoint):
            return cls(source, **beside)  # type: ignore[arg-type]
        both = ", ".join(name for name, value in beside.items() if value is not None)
        if both:
            raise UsageError(f"{both}: given beside an operating point, which has its own")
        return source

    @property
    def time(self) -> float:
        """Of the point [s]. Raises UsageError: a time that no motion gets to."""
        if self.at is None or isinstance(self.at, Mapping):
            return 0.0
        time = number("at", self.at, "real")
        if time < 0:
            raise UsageError(f"at: found {time:g} s, expected 0 or more")
        return time

    @property
    def values(self) -> Mapping[str, Value]:
        """Those that `at` gives by name."""
        return self.at if isinstance(self.at, Mapping) else {}

    def reach(self, plant: Plant) -> Reached:
        """Starts a plant and takes it to the point, where its inputs stay.

        Args:
            plant: that of `source`.

        Raises:
            UsageError: a name or a value is wrong.
            AssemblyError: the loops cannot be closed with these values.
            StepError: the motion does not get to `at`.
        """
        settings, exact = self._settings(plant)
        twice = "twice, as an input and as part of the point"
        signals = functions_and_constants(self.input_values, settings, [*plant.inputs, *plant.idle], twice)
        configure(plant, settings, self.tolerance, {})
        plant.start(self.tolerance, {name: signal(0.0) for name, signal in signals.items()})
        _go_on(plant, self.time, signals)
        return Reached(settings, exact)

    def _settings(self, plant: Plant) -> tuple[dict[str, Value], dict[str, float]]:
        """What to set before the start, and what of it has to be so afterwards."""
        known = [*plant.parameters, *plant.inputs, *plant.idle]
        settings = dict(self.parameters or {})
        exact = {}
        faults = []
        for name, value in self.values.items():
            start = start_parameter(name)
            place = start if name not in known and start in known else name
            if place not in known:
                faults.append(unknown(name, "state, parameter or input", [*plant.outputs, *known]))
            elif place in settings:
                faults.append(f"{name}: given twice, as a parameter and as part of the point")
            else:
                settings[place] = value
                if place != name:
                    exact[name] = number(name, value, "real")
        if faults:
            raise UsageError("\n".join(faults))
        starts = {start_parameter(name) for name in plant.readings}
        told = [name for name in settings if name in starts and name not in (self.parameters or {})]
        if told and START in plant.parameters:
            settings.setdefault(START, "as_given")  # else the plant might look for another start from there
        return settings, exact


@dataclass(frozen=True)
class Reached:
    """What was done to a plant to take it to an operating point.

    Attributes:
        settings: parameters that were set, start values among them.
        exact: states by name, and the values that they have to have there.
    """

    settings: Mapping[str, Value]
    exact: Mapping[str, float]

    def check(self, found: Derivatives) -> None:
        """Raises UsageError: a state was a guess, and the loops have been closed at another value."""
        faults = [
            f"{name}: the loops are closed at {found.values[name]:.9g} instead of {value:.9g}, "
            f"which was a guess: {name.rpartition('.')[0]}.fixed is not set"
            for name, value in self.exact.items()
            if not math.isclose(found.values[name], value, rel_tol=1e-9, abs_tol=1e-9 * found.size(name))
        ]
        if faults:
            raise UsageError("\n".join(faults))


def _go_on(plant: Plant, time: float, signals: Mapping[str, Signal]) -> None:
    """Runs as `gelenk.simulate` does, and leaves the inputs at what they are at the end."""
    if time == 0:
        return
    times = grid(time, plant.step).tolist()
    for start, end in itertools.pairwise(times):
        set_inputs(plant, signals, start, end)
        plant.advance(start, end)
    for name, signal in signals.items():
        if not is_motion(name):  # these are where the run has followed them to
            plant.set_input(name, signal(time))
