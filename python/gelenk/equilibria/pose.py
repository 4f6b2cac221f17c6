# SPDX-License-Identifier: BSD-3-Clause
"""Poses of a plant with their linearized accelerations, and steps between them that keep the loops closed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from gelenk.errors import AssemblyError, UsageError
from gelenk.linear.minimal_realization import MinimalRealization, check_complete
from gelenk.linear.model import equilibrium_rate_bounds
from gelenk.linear.operating_point import START
from gelenk.model.rotation import rotated
from gelenk.model.values import Value, start_parameter, unknown
from gelenk.simulation.derivatives import Derivatives, Quaternion
from gelenk.simulation.plant import Plant

Array = NDArray[np.float64]

MAX_STEP_ANGLE = 0.3  # rad; larger rotations of a joint in one step could lead to another branch


@dataclass(frozen=True)
class LinearizedPose:
    """A pose of a plant with accelerations a that have to vanish, and their Jacobian: da = A dx + B du.

    Everything is in the mechanism's own units, so that tolerances and least squares refer to them. At rest, x
    are the coordinates that determine the others best at this pose: the acceleration of a coordinate at its
    dead center would vanish for any motion of the others. In steady motion, x are the independent coordinates
    and velocities.

    Attributes:
        found: derivatives of all readings at this pose.
        minimal: the same with respect to minimal states.
        unknowns: names of x.
        conditions: names of the velocities whose accelerations have to vanish.
        accelerations: these accelerations, shape (conditions,).
        A: their derivatives with respect to x, shape (conditions, unknowns).
        B: their derivatives with respect to the inputs, shape (conditions, inputs).
        basis: derivatives of the states of `minimal` with respect to x, shape (states, unknowns).
        velocity_basis: at rest, the matrix of dx/dt = velocity_basis v, where v are the velocities of the
            conditions, shape (unknowns, conditions); empty in steady motion.
    """

    found: Derivatives
    minimal: MinimalRealization
    unknowns: tuple[str, ...]
    conditions: tuple[str, ...]
    accelerations: Array
    A: Array
    B: Array
    basis: Array
    velocity_basis: Array

    def jacobian(self, names: Sequence[str]) -> Array:
        """Return derivatives of readings or rotation coordinates by the unknowns, shape (names, unknowns)."""
        return _rows(self.minimal, names) @ self.basis

    def accelerations_of(self, speeds: Sequence[str]) -> Array:
        """Return the time derivatives of any velocities, shape (speeds,)."""
        return np.array([self.minimal.rate(name)[2] for name in speeds])

    @property
    def is_equilibrium(self) -> bool:
        """Whether the accelerations vanish to the rounding error of their terms."""
        return bool((np.abs(self.accelerations) <= equilibrium_rate_bounds(self.A, self.sizes)).all())

    @property
    def residual(self) -> float:
        """The largest reported acceleration, in SI units."""
        return max((abs(self.in_si(name, a)) for name, a in self._reported.items()), default=0.0)

    def largest(self) -> tuple[str, float, str]:
        """Return the largest reported acceleration: its name, its value in own units, and its SI unit."""
        reported = self._reported
        if not reported:
            return "", 0.0, ""
        name = max(reported, key=lambda name: abs(reported[name]))
        return name, reported[name], self.found.units.get(name, "1")

    @property
    def _reported(self) -> dict[str, float]:
        """Accelerations by name: of the plant's own independent velocities, or of the steady ones."""
        own = [name for name in self.minimal.names if not self.minimal.is_coordinate(name)]
        velocities = own if len(self.velocity_basis) else self.conditions
        return {self.found.rates[name]: self.minimal.rate(name)[2] for name in velocities}

    def in_si(self, name: str, value: float) -> float:
        """Convert the value of an input or reading to SI units."""
        return value * self.found.size(name)

    @property
    def sizes(self) -> Array:
        """Magnitudes of x, shape (unknowns,): 1 for coordinates, 1 + magnitude for velocities."""
        return np.array(
            [1.0 if self.minimal.is_coordinate(n) else 1 + abs(self.minimal.value(n)) for n in self.unknowns]
        )


def _rows(minimal: MinimalRealization, names: Sequence[str]) -> Array:
    return np.array([minimal.row(name) for name in names]).reshape(len(names), len(minimal.names))


def linearized_pose(found: Derivatives, conditions: Sequence[str] | None = None) -> LinearizedPose:
    """Return the pose at which derivatives were computed.

    Args:
        found: derivatives of the plant, in SI units.
        conditions: in steady motion, names of the velocities whose accelerations have to vanish; None: at
            rest.

    Raises:
        GelenkError: the plant's states do not determine its motion.
    """
    found = found.in_own_units()
    minimal = MinimalRealization(found)
    check_complete(minimal)
    unknowns, velocity_basis = minimal.names, np.empty((0, 0))
    basis = np.eye(len(unknowns))
    if conditions is None:
        n = sum(map(minimal.is_coordinate, minimal.names))
        known = [name for name in minimal.candidates if minimal.is_coordinate(name)]
        unknowns, by_coordinates = _best_determining(minimal, known, slice(n))
        speeds = [minimal.speed(name) for name in known]
        conditions, by_speeds = _best_determining(minimal, speeds, slice(n, None))
        basis = np.vstack([by_coordinates, np.zeros((len(minimal.names) - n, n))])
        rates_by_speeds = np.array([minimal.rate(q)[0][n:] for q in unknowns]).reshape(n, len(by_speeds))
        velocity_basis = rates_by_speeds @ by_speeds
    rates = [minimal.rate(name) for name in conditions]
    A = np.array([by_x for by_x, _, _ in rates]).reshape(len(rates), len(basis)) @ basis
    B = np.array([by_u for _, by_u, _ in rates]).reshape(len(rates), len(found.inputs))
    accelerations = np.array([a for _, _, a in rates])
    return LinearizedPose(
        found, minimal, tuple(unknowns), tuple(conditions), accelerations, A, B, basis, velocity_basis
    )


def _best_determining(
    minimal: MinimalRealization, known: Sequence[str], states: slice
) -> tuple[tuple[str, ...], Array]:
    """Choose the names that determine certain states best; return them and the derivatives of the states."""
    rows = _rows(minimal, known)[:, states]
    order = qr(rows.T, mode="r", pivoting=True)[1][: rows.shape[1]] if rows.size else []
    chosen = sorted(map(int, order))
    return tuple(known[i] for i in chosen), np.linalg.inv(rows[chosen])


class PosedPlant:
    """A plant that is assembled in given poses, as near to them as its loops allow, with zero velocities.

    In steady motion (`conditions` are given) velocities are start values, as coordinates are. All values are
    in the mechanism's own units.
    """

    def __init__(
        self,
        plant: Plant,
        size: Callable[[str], float],
        settings: Mapping[str, Value],
        hold: Mapping[str, float],
        speeds: Mapping[str, float] | None = None,
        conditions: Sequence[str] | None = None,
    ) -> None:
        """Prepare a plant.

        Args:
            plant: the plant.
            size: function that returns the SI value of 1 own unit of an input or output.
            settings: parameters other than start values.
            hold: coordinates that are held, and their values.
            speeds: velocities that are held, and their values.
            conditions: velocities whose accelerations have to vanish; None: all.
        """
        self.plant = plant
        self._size = size
        self._held = list(hold)
        self.hold = {**hold, **(speeds or {})}
        self.conditions = conditions
        known = set(plant.parameters)
        self._starts = [name for name in plant.readings if start_parameter(name) in known]
        flags: dict[str, Value] = {
            name: False for name in plant.parameters if name.endswith(".fixed") and self._starts_of(name)
        }
        self._settings = {**settings, **flags}
        self._settings.pop(START, None)
        self._has_equilibrium_search = START in known

    def _starts_of(self, flag: str) -> list[str]:
        joint = flag.removesuffix("fixed")
        return [name for name in self._starts if name.startswith(joint)]

    def check_hold(self, pose: LinearizedPose) -> None:
        """Check the names to be held, and set the `fixed` flags of joints with a single coordinate.

        Args:
            pose: a pose of the plant.

        Raises:
            UsageError: a name is not a coordinate that can be held.
        """
        holdable = [name for name in self._starts if name in pose.minimal.candidates]
        holdable = [name for name in holdable if pose.minimal.is_coordinate(name)]
        faults = []
        for name in [name for name in self._held if name not in holdable]:
            if name in self._starts:
                faults.append(
                    f"{name}: found a velocity or part of a quaternion, expected a coordinate of a joint"
                )
            else:
                faults.append(unknown(name, "coordinate", holdable))
        if faults:
            raise UsageError("\n".join(faults))
        for name in self._held:  # a single coordinate of a joint can be attained exactly
            joint = name.rpartition(".")[0]
            own = [n for n in holdable if n.startswith(f"{joint}.")]
            if own == [name] and f"{joint}.fixed" in self._settings:
                self._settings[f"{joint}.fixed"] = True

    def starts(self, pose: LinearizedPose, step: Array) -> dict[str, float]:
        """Return start values of all joints after a step of the unknowns, to first order.

        Args:
            pose: the pose before the step.
            step: change of its unknowns, shape (unknowns,).
        """
        out: dict[str, float] = {}
        by_component = {Q: of for of in pose.found.quaternions for Q in of.Q}
        for name in self._starts:
            quaternion = by_component.get(name)
            if quaternion and quaternion.theta[0] in pose.minimal.candidates:
                if name == quaternion.Q[0]:
                    out |= _rotated(pose, quaternion, step)
            elif quaternion or pose.minimal.is_coordinate(name) or self.conditions is not None:
                out[name] = pose.found.values[name]
                if not quaternion:
                    out[name] += float(pose.jacobian([name])[0] @ step)
            else:
                out[name] = 0.0  # a velocity
        return out

    def native_equilibrium(
        self, pose: LinearizedPose, begin: Mapping[str, Value] | None, inputs: Mapping[str, float]
    ) -> LinearizedPose:
        """Return the result of the plant's own equilibrium search, with which a simulation would start.

        The pose is returned unchanged if the plant has no such search, if it fails, or if something is held.

        Args:
            pose: initial pose.
            begin: parameters that bring the plant to it, if known.
            inputs: values of the inputs.
        """
        if not self._has_equilibrium_search or self.hold or self.conditions is not None:
            return pose
        try:
            if begin is None:
                begin = self.settings(self.starts(pose, np.zeros(len(pose.unknowns))))
            return self._put(begin, inputs, "equilibrium")
        except AssemblyError:
            return pose

    def put(self, starts: Mapping[str, float], inputs: Mapping[str, float]) -> LinearizedPose:
        """Assemble the plant in a pose.

        Args:
            starts: start values of coordinates and velocities.
            inputs: values of the inputs.

        Returns:
            LinearizedPose: the pose reached.

        Raises:
            AssemblyError: the loops cannot be closed.
            UsageError: the configuration is singular.
        """
        return self._put(self.settings(starts), inputs)

    def _put(
        self, settings: Mapping[str, Value], inputs: Mapping[str, float], start: str = "as_given"
    ) -> LinearizedPose:
        self.plant.reset()
        self.plant.set_parameters({**settings, **({START: start} if self._has_equilibrium_search else {})})
        self.plant.start(None, self.in_si(inputs))
        return linearized_pose(self.plant.derivatives(()), self.conditions)

    def settings(self, starts: Mapping[str, float]) -> dict[str, Value]:
        """Return the parameters, in SI units, that bring the plant to these start values."""
        return {
            **self._settings,
            **{start_parameter(name): value for name, value in self.in_si(starts).items()},
        }

    def in_si(self, values: Mapping[str, float]) -> dict[str, float]:
        """Convert values of inputs and outputs to SI units."""
        return {name: value * self._size(name) for name, value in values.items()}

    def rotations(self, pose: LinearizedPose, step: Array) -> Array:
        """Return the rotations of all angles in a step of the unknowns [rad], shape (angles,)."""
        angles = [n for n in pose.minimal.candidates if pose.minimal.unit(n) == "rad"]
        out: Array = pose.jacobian(angles) @ step
        return out

    def step_fraction(self, rotations: Array) -> float:
        """Return the fraction of a step, at most 1, that rotates no joint by more than `MAX_STEP_ANGLE`."""
        angle = float(np.abs(rotations).max(initial=0.0))
        return min(1.0, MAX_STEP_ANGLE / angle) if angle else 1.0


def _rotated(pose: LinearizedPose, of: Quaternion, step: Array) -> dict[str, float]:
    """Return the quaternion Q o exp(theta / 2) after a rotation about the frame's own axes."""
    theta = pose.jacobian(of.theta) @ step
    Q = np.array([pose.found.values[name] for name in of.Q])
    return dict(zip(of.Q, map(float, rotated(Q, theta)), strict=True))
