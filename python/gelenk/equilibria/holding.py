# SPDX-License-Identifier: BSD-3-Clause
"""Poses at rest with dry friction, hard limits and one-way clutches: what holds them, with what margin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gelenk.errors import EquilibriumError, SceneError
from gelenk.linear.operating_point import START, OperatingPoint
from gelenk.model.scene import Scene
from gelenk.model.values import Value, start_parameter
from gelenk.simulation.scene_plant import ScenePlant

# Largest speed at rest, in the mechanism's own units: assembly leaves rounding.
SPEED_TOLERANCE = 1e-9
ONE_WAY = "one_way"


@dataclass(frozen=True)
class Holding:
    """What keeps a coordinate at rest: dry friction, and contact with a hard limit or a one-way clutch.

    Attributes:
        friction: force of friction along the coordinate [N m, N].
        limit: the largest static friction [N m, N]; 0 for a joint without friction.
        contact: force of the hard limit along the coordinate [N m, N]: positive at the lower bound, negative
            at the upper one, 0 away from both; or that of the one-way clutch, in its free direction.
        bound: "lower" or "upper" for the bound that the coordinate touches, "one_way" for a one-way clutch;
            empty: none.
        unit: unit of the forces.
    """

    friction: float
    limit: float
    contact: float
    bound: str
    unit: str

    @property
    def margin(self) -> float:
        """The part of static friction that is not used: 1 if none is used, 0 just before break-away."""
        if self.friction == 0:
            return 1.0
        return max(0.0, 1 - self.fraction)  # what holds exceeds its limit by rounding at the most

    @property
    def fraction(self) -> float:
        """The friction needed as a fraction of its limit; more than 1 for what cannot be held."""
        return abs(self.friction) / self.limit if self.limit else math.inf

    def __str__(self) -> str:
        parts = []
        if self.limit:
            parts.append(f"friction {self.friction:.6g} of {self.limit:.6g} {_spelled(self.unit)}")
        if self.bound:
            by = "one-way clutch" if self.bound == ONE_WAY else f"contact at its {self.bound} limit"
            parts.append(f"{by} {self.contact:.6g} {_spelled(self.unit)}")
        return ", ".join([*parts, f"margin {self.margin:.6g}"])


def _spelled(unit: str) -> str:
    return unit.replace(".", " ")


class RestingScene:
    """A scene with dry friction or hard limits, in poses at rest; all values are in SI units.

    Attributes:
        plant: the scene as a plant.
        settings: parameters other than start values.
        inputs: values of the inputs.
    """

    def __init__(self, scene: Scene, point: OperatingPoint) -> None:
        """Bring the scene to the initial pose.

        Args:
            scene: the scene.
            point: the operating point with the initial pose.
        """
        self._scene = scene
        self._one_way = {name for name, joint in scene.to_dict()["joints"].items() if ONE_WAY in joint}
        self.plant = plant = ScenePlant(scene)
        settings = point.reach(plant).settings
        self._forces, self._balanced, self._held = plant.rest_forces()
        starts = self.starts()
        flags = {name: False for name in plant.parameters if name.endswith(".fixed")}
        kept = {name: value for name, value in settings.items() if name not in starts and name != START}
        self.settings: dict[str, Value] = {**kept, **flags}
        self.inputs = plant.input_values

    def starts(self) -> dict[str, Value]:
        """Return the present pose as start values, with zero velocities."""
        known, rates, values = set(self.plant.parameters), self.plant.rates, self.plant.values
        out: dict[str, Value] = {}
        for name in self.plant.readings:
            if start_parameter(name) in known:
                is_coordinate = ".Q[" in name or rates.get(name) in rates
                out[start_parameter(name)] = values[name] if is_coordinate else 0.0
        return out

    def smooth_plant(self) -> ScenePlant:
        """Return the plant in the same pose, without friction and limits."""
        smooth = ScenePlant(self._scene.without_friction_and_limits())
        known = set(smooth.parameters)
        settings = {**self.settings, **self.starts(), START: "as_given"}
        smooth.set_parameters({name: value for name, value in settings.items() if name in known})
        smooth.start(None, self.inputs)
        return smooth

    def put(
        self, starts: Mapping[str, Value], inputs: Mapping[str, float], start: str = "as_given"
    ) -> dict[str, Holding]:
        """Bring the plant to a pose, and return what has to hold its coordinates.

        Args:
            starts: start values.
            inputs: values of the inputs.
            start: "equilibrium": to the equilibrium near these values.

        Raises:
            AssemblyError: the loops cannot be closed, or there is no equilibrium.
            EquilibriumError: the pose is beyond a limit, or a prescribed motion moves it.
        """
        self.plant.reset()
        self.plant.set_parameters({**self.settings, **starts, START: start})
        try:
            self.plant.start(None, inputs)
        except SceneError:
            beyond = self._beyond_limits(starts)
            if not beyond:
                raise
            raise EquilibriumError(
                f"no equilibrium within the hard limits: the one found has {' and '.join(beyond)}"
            ) from None
        self._check_speeds()
        self._forces, self._balanced, self._held = self.plant.rest_forces()
        return {
            name: Holding(friction=force - contact, limit=limit, contact=contact, bound=bound, unit=unit)
            for name, unit, force, limit, side in self._forces
            # Friction does what contact, which only pushes, cannot.
            for contact, bound in [self._contact(name, force, side)]
        }

    def _contact(self, name: str, force: float, side: int) -> tuple[float, str]:
        """Return what a limit or a one-way clutch does of the force that is needed, and which it is."""
        if side == 0:
            return 0.0, ""
        contact = min(force, 0.0) if side > 0 else max(force, 0.0)
        if name.rpartition(".")[0] in self._one_way:
            return contact, ONE_WAY
        return contact, "upper" if side > 0 else "lower"

    def _beyond_limits(self, starts: Mapping[str, Value]) -> list[str]:
        joints = self._scene.to_dict()["joints"]
        out = []
        for name, *_ in self._forces:
            limit = joints[name.rpartition(".")[0]].get("limit", {})
            value = float(starts[start_parameter(name)])
            for bound, sign in (("lower", -1), ("upper", 1)):
                if bound in limit and sign * (value - limit[bound]) > 0:
                    unit = _spelled(self.plant.unit(name))
                    out.append(
                        f"{name} = {value:.6g} {unit}, beyond its {bound} limit of {limit[bound]:.6g} {unit}"
                    )
        return out

    def _check_speeds(self) -> None:
        values = self.plant.values
        for name in self._of_order(1):
            if abs(values[name]) > SPEED_TOLERANCE * self.plant.size(name):
                unit = _spelled(self.plant.unit(name))
                raise EquilibriumError(
                    f"no pose at rest: a prescribed motion moves {name} = {values[name]:.6g} {unit}"
                )

    def _of_order(self, order: int) -> list[str]:
        """Return the readings that are time derivatives of coordinates of this order."""
        rates = self.plant.rates
        names = [name for name in rates if rates[name] in rates and name not in rates.values()]
        names = [rates[name] for name in names]
        return names if order == 1 else [rates[name] for name in names]

    def largest_acceleration(self) -> tuple[str, float]:
        """Return the name and the value of the largest acceleration in the present pose."""
        values = self.plant.values
        names = self._of_order(2)
        worst = max(names, key=lambda name: abs(values[name] / self.plant.size(name)), default="")
        return worst, values.get(worst, 0.0)

    def check_held(self, holding: Mapping[str, Holding]) -> None:
        """Raise EquilibriumError if friction and contact cannot hold the pose of the last `put`.

        Args:
            holding: what it returned.
        """
        if self._balanced and self._held:
            return
        name, value = self.largest_acceleration()
        moves = f"; {name} = {value:.6g} {_spelled(self.plant.unit(name))}" if name else ""
        worst = max(holding, key=lambda name: holding[name].fraction, default="")
        needed = holding.get(worst)
        if not self._balanced or needed is None or needed.fraction <= 1:
            raise EquilibriumError(f"friction and limits do not hold this pose{moves}")
        if not needed.limit:
            leaves = (
                "overruns its one-way clutch"
                if needed.bound == ONE_WAY
                else f"leaves its {needed.bound} limit"
            )
            raise EquilibriumError(f"friction and limits do not hold this pose: {worst} {leaves}{moves}")
        unit = _spelled(needed.unit)
        raise EquilibriumError(
            f"friction does not hold this pose: {worst} would need {abs(needed.friction):.6g} {unit}, "
            f"and its limit is {needed.limit:.6g} {unit}{moves}"
        )
