# SPDX-License-Identifier: BSD-3-Clause
"""Poses at rest with dry friction, hard limits and one-way clutches: what holds them, with what margin."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gelenk.equilibria.swings import (
    has_isotropic_friction,
    is_friction_of_joint,
    path_of_law,
    room,
    swing_limits,
    unit_of_law,
)
from gelenk.errors import EquilibriumError, SceneError, UsageError
from gelenk.linear.model import EQUILIBRIUM_RATE_TOLERANCE
from gelenk.linear.operating_point import START, OperatingPoint
from gelenk.model.values import Value, start_parameter, unknown
from gelenk.simulation.scene_plant import ScenePlant

# Gaps up to this are closed, in the mechanism's own units.
TOUCH_TOLERANCE = 1e-10
# Largest speed at rest, in the mechanism's own units: assembly leaves rounding.
SPEED_TOLERANCE = 1e-9
ONE_WAY = "one_way"
LOCK = "lock"
HELD_BY_LOCK = 2  # in place of the side of a bound


@dataclass(frozen=True)
class Holding:
    """What keeps a coordinate at rest: dry friction, a lock, contact with a hard limit or a one-way clutch.

    Attributes:
        friction: force of friction along the coordinate [N m, N].
        limit: the largest static friction [N m, N]; 0 for a joint without friction.
        contact: force of the hard limit along the coordinate [N m, N]: positive at the lower bound, negative
            at the upper one, 0 away from both; of the one-way clutch, in its free direction; of the lock.
        bound: "lower" or "upper" for the bound that the coordinate touches, "one_way" for a one-way clutch,
            "lock" for a lock; empty: none.
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
            named = {ONE_WAY: "one-way clutch", LOCK: "lock"}
            by = named.get(self.bound, f"contact at its {self.bound} limit")
            parts.append(f"{by} {self.contact:.6g} {_spelled(self.unit)}")
        return ", ".join([*parts, f"margin {self.margin:.6g}"])


@dataclass(frozen=True)
class ContactPoint:
    """A point at which two shapes touch at rest, and what they exert there.

    Attributes:
        contact: name of the contact; "J.limit" is the limit of the joint J, "J.friction" its friction along
            several velocities together.
        bodies: names of the bodies with its first and its second surface.
        position: of the point in the world [m].
        force: on the first body, in the world [N].
        normal: normal force [N]; of the limit of a ball joint its torque [N m], while `force` is zero; 0 of
            the friction of a joint.
        friction: size of the friction [N], of the rotation of a joint [N m].
        limit: the largest static friction, under this normal force [N, N m].
    """

    contact: str
    bodies: tuple[str, str]
    position: tuple[float, float, float]
    force: tuple[float, float, float]
    normal: float
    friction: float
    limit: float

    @property
    def margin(self) -> float:
        """The part of static friction that is not used: 1 if none is used, 0 just before sliding begins."""
        if self.friction == 0:
            return 1.0
        return max(0.0, 1 - self.friction / self.limit) if self.limit > 0 else 0.0

    def __str__(self) -> str:
        unit = unit_of_law(self.contact)
        if is_friction_of_joint(self.contact):
            return f"{' on '.join(self.bodies)}: friction {self.friction:.6g} of {self.limit:.6g} {unit}"
        kind = "torque" if unit == "N m" else "normal force"
        friction = f", friction {self.friction:.6g} of {self.limit:.6g} N" if self.limit > 0 else ""
        at = ", ".join(f"{x:.6g}" for x in self.position)
        return f"{' on '.join(self.bodies)} at ({at}) m: {kind} {self.normal:.6g} {unit}{friction}"


def _vector(x: Sequence[float]) -> tuple[float, float, float]:
    return (x[0], x[1], x[2])


def _spelled(unit: str) -> str:
    return unit.replace(".", " ")


class PosedScene:
    """A scene in poses or steady motions, and the search for them; values are in SI units unless noted.

    Attributes:
        plant: the scene as a plant.
        settings: parameters other than start values.
        inputs: values of the inputs.
    """

    def __init__(self, plant: ScenePlant, point: OperatingPoint) -> None:
        """Bring a scene to the initial state.

        Args:
            plant: the scene as a plant, not yet started.
            point: the operating point with the initial state.
        """
        self.plant = plant
        self._joints = plant.scene.to_dict()["joints"]
        self._holds = plant.scene.has_friction_or_limits
        self._contacts = list(plant.scene.to_dict().get("contacts", {}))
        self._swings = swing_limits(self._joints)
        self._has_isotropic_friction = has_isotropic_friction(plant.readings)
        settings = point.reach(plant).settings
        known, rates = set(plant.parameters), plant.rates
        starts = [name for name in plant.readings if start_parameter(name) in known]
        parameters = {START, *map(start_parameter, starts)}
        kept = {name: value for name, value in settings.items() if name not in parameters}
        flags = {f"{name.rpartition('.')[0]}.fixed" for name in starts} & known
        self.settings: dict[str, Value] = {**kept, **dict.fromkeys(sorted(flags), False)}
        self.inputs = plant.input_values
        self._coordinates = [name for name in starts if ".Q[" in name or rates.get(name) in rates]
        self._elements = [name for name in starts if rates.get(name) == f"{name}.rate"]
        self._velocities = [name for name in starts if name not in {*self._coordinates, *self._elements}]
        self._forces = plant.rest_forces()[0] if self._holds else []

    @property
    def has_contacts(self) -> bool:
        """Whether shapes can touch, ball joints meet their limits, or joints have isotropic friction."""
        return bool(self._contacts or self._swings or self._has_isotropic_friction)

    def starts(self, steady: bool = False) -> dict[str, Value]:
        """Return the present pose as start values, with its velocities in steady motion, else zero."""
        values = self.plant.values
        kept = [*self._coordinates, *self._elements]
        out: dict[str, Value] = {start_parameter(name): values[name] for name in kept}
        return out | {start_parameter(name): values[name] if steady else 0.0 for name in self._velocities}

    def hold(self, hold: Mapping[str, float]) -> None:
        """Check the names to be held, and let assembly keep the coordinates of joints with a single one.

        Raises:
            UsageError: a name is not a coordinate that can be held.
        """
        holdable = [name for name in self._coordinates if ".Q[" not in name]
        faults = []
        for name in [name for name in hold if name not in holdable]:
            if name in self._velocities or name in self._coordinates:
                faults.append(
                    f"{name}: found a velocity or part of a quaternion, expected a coordinate of a joint"
                )
            else:
                faults.append(unknown(name, "coordinate", holdable))
        if faults:
            raise UsageError("\n".join(faults))
        for name in hold:  # a single coordinate of a joint can be attained exactly
            joint = name.rpartition(".")[0]
            own = [n for n in holdable if n.startswith(f"{joint}.")]
            if own == [name] and f"{joint}.fixed" in self.settings:
                self.settings[f"{joint}.fixed"] = True

    def put(self, starts: Mapping[str, Value], inputs: Mapping[str, float]) -> None:
        """Bring the plant to a state.

        Args:
            starts: start values.
            inputs: values of the inputs.

        Raises:
            AssemblyError: the loops cannot be closed.
            EquilibriumError: the pose is beyond a limit.
        """
        self.plant.reset()
        self.plant.set_parameters({**self.settings, **starts, START: "as_given"})
        try:
            self.plant.start(None, inputs)
        except SceneError:
            beyond = self._beyond_limits(starts)
            if not beyond:
                raise
            raise EquilibriumError(
                f"no equilibrium within the hard limits: the one found has {' and '.join(beyond)}"
            ) from None

    def holding(self) -> dict[str, Holding]:
        """Return what has to hold the coordinates of the present pose at rest.

        Raises:
            EquilibriumError: a prescribed motion moves it.
        """
        if not self._holds:
            return {}
        self._check_speeds()
        return {
            name: Holding(friction=force - contact, limit=limit, contact=contact, bound=bound, unit=unit)
            for name, unit, force, limit, side in self.plant.rest_forces()[0]
            # Friction does what contact, which only pushes, cannot.
            for contact, bound in [self._contact(name, force, side)]
        }

    def contact_points(self) -> tuple[ContactPoint, ...]:
        """Return all points at which shapes touch in the present pose, with the forces that hold it.

        Raises:
            EquilibriumError: a contact is closed of which the points are not known.
        """
        if not self.has_contacts:
            return ()
        *_, points, _, undefined = self.plant.rest_forces()
        if undefined:
            raise EquilibriumError(
                f"contacts.{undefined} is closed between shapes whose points of contact are not located, so "
                "that its forces at rest are not known"
            )
        return tuple(
            ContactPoint(name, (first, second), _vector(at), _vector(force), normal, friction, limit)
            for name, first, second, at, force, normal, friction, limit in points
        )

    def check_open(self) -> None:
        """Raise EquilibriumError where anything touches: no search knows the forces of contacts."""
        values = self.plant.values
        for name in self._contacts:
            gap = values[f"{name}.gap"]
            if gap <= TOUCH_TOLERANCE * self.plant.size(f"{name}.gap"):
                raise EquilibriumError(
                    f"contacts.{name} has a gap of {gap:.6g} m in the pose found, expected one above 0: the "
                    "search does not know the forces of contacts; friction='present' asks whether they hold "
                    "a given pose"
                )
        for name, limit in self._swings.items():
            left = room(limit, [values[f"{name}.Q[{k}]"] for k in range(1, 5)])
            if left <= TOUCH_TOLERANCE:
                raise EquilibriumError(
                    f"joints.{name}.limit is closed in the pose found, at a swing of "
                    f"{limit['swing']:.6g} rad, expected less: the search does not know its torque; "
                    "friction='present' asks whether it holds a given pose"
                )

    def _contact(self, name: str, force: float, side: int) -> tuple[float, str]:
        """Return what a limit, a one-way clutch or a lock does of the force that is needed, and which."""
        if side == 0:
            return 0.0, ""
        if side == HELD_BY_LOCK:
            return force, LOCK
        contact = min(force, 0.0) if side > 0 else max(force, 0.0)
        if self._group(name, ONE_WAY):
            return contact, ONE_WAY
        return contact, "upper" if side > 0 else "lower"

    def _group(self, coordinate: str, key: str) -> Mapping[str, Any]:
        """Return the entry of a coordinate among those of its joint, of several by their names; {}: none."""
        joint, _, own = coordinate.rpartition(".")
        entry: Mapping[str, Any] = self._joints[joint].get(key, {})
        return entry.get(own, {}) if any(isinstance(x, Mapping) for x in entry.values()) else entry

    def _beyond_limits(self, starts: Mapping[str, Value]) -> list[str]:
        out = []
        for name, *_ in self._forces:
            limit = self._group(name, "limit")
            value = float(starts[start_parameter(name)])
            for bound, sign in (("lower", -1), ("upper", 1)):
                if bound in limit and sign * (value - limit[bound]) > 0:
                    unit = _spelled(self.plant.unit(name))
                    out.append(
                        f"{name} = {value:.6g} {unit}, beyond its {bound} limit of {limit[bound]:.6g} {unit}"
                    )
        for name, limit in self._swings.items():
            Q = [starts.get(start_parameter(f"{name}.Q[{k}]")) for k in range(1, 5)]
            left = 0.0 if None in Q else room(limit, [float(x) for x in Q if x is not None])
            if left < -TOUCH_TOLERANCE:
                swing = limit["swing"] - left
                out.append(
                    f"{name} at a swing of {swing:.6g} rad, beyond its limit of {limit['swing']:.6g} rad"
                )
        return out

    def _check_speeds(self) -> None:
        values = self.plant.values
        for name in self._velocities:
            if abs(values[name]) > SPEED_TOLERANCE * self.plant.size(name):
                raise EquilibriumError(
                    f"no pose at rest: a prescribed motion moves {name} = {self.spelled(name, values[name])}"
                )

    def spelled(self, name: str, value: float) -> str:
        """Return the value of a reading with its unit."""
        return f"{value:.6g} {_spelled(self.plant.unit(name))}"

    def largest(self, accelerations: Mapping[str, float]) -> tuple[str, float]:
        """Return the name and the value of the largest of these accelerations in own units; "", 0: none."""
        sizes = {name: abs(value / self.plant.size(name)) for name, value in accelerations.items()}
        worst = max(sizes, key=lambda name: sizes[name], default="")
        return worst, accelerations.get(worst, 0.0)

    def accelerations(self) -> dict[str, float]:
        """Return the present accelerations of the independent velocities."""
        values, rates = self.plant.values, self.plant.rates
        return {rates[name]: values[rates[name]] for name in self.plant.states if name in self._velocities}

    def check_elements(self) -> None:
        """Raise EquilibriumError if states of elements change in the present pose."""
        values = self.plant.values
        rates = {f"{name}.rate": values[f"{name}.rate"] for name in self._elements}
        name, value = self.largest(rates)
        size = 1 + abs(values.get(name.removesuffix(".rate"), 0.0))
        if abs(value) > EQUILIBRIUM_RATE_TOLERANCE * size:
            raise EquilibriumError(
                f"states of elements change in this pose: {name} = {self.spelled(name, value)}; expected "
                "start values at which they do not"
            )

    def _check_points(self, pushes: bool) -> None:
        """Raise EquilibriumError if contacts cannot exert the forces that would hold the pose.

        Args:
            pushes: whether no point has to pull.
        """
        points = self.contact_points()
        if not pushes:
            worst = min(points, key=lambda point: point.normal)
            raise EquilibriumError(
                f"contacts do not hold this pose: {path_of_law(worst.contact)} would have to pull with "
                f"{-worst.normal:.6g} {unit_of_law(worst.contact)} between {' and '.join(worst.bodies)}"
            )
        beyond = [point for point in points if point.friction > point.limit]
        if not beyond:
            return
        worst = max(beyond, key=lambda point: point.friction - point.limit)
        raise EquilibriumError(
            f"contacts do not hold this pose: {path_of_law(worst.contact)} would need a friction of "
            f"{worst.friction:.6g} {unit_of_law(worst.contact)} between {' and '.join(worst.bodies)}, "
            f"and its limit is {worst.limit:.6g} {unit_of_law(worst.contact)}"
        )

    def check_held(self, holding: Mapping[str, Holding]) -> None:
        """Raise EquilibriumError if friction and contact cannot hold the present pose.

        Args:
            holding: what has to hold it.
        """
        self.check_elements()
        _, balanced, held, _, pushes, _ = self.plant.rest_forces()
        if balanced and held:
            return
        name, value = self.largest(self.accelerations())
        moves = f"; {name} = {self.spelled(name, value)}" if name else ""
        if balanced and self.has_contacts:
            self._check_points(pushes)
        worst = max(holding, key=lambda name: holding[name].fraction, default="")
        needed = holding.get(worst)
        if not balanced or needed is None or needed.fraction <= 1:
            what = "friction, limits and contacts" if self.has_contacts else "friction and limits"
            raise EquilibriumError(f"{what} do not hold this pose{moves}")
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
