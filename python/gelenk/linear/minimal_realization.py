# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a plant at an operating point with respect to a minimal set of states.

A quaternion Q has four components for three degrees of freedom. It is replaced by the small rotation dtheta
of the joint's frame M from its nominal motion, along the axes of M: dQ = 1/2 Q o (dtheta, 0). theta is zero
at the operating point, and d(dtheta)/dt = dw - w x dtheta: with R the nominal rotation and S = R (1 +
dtheta~) the perturbed one, this follows to first order from dS/dt = S (w + dw)~ and dR/dt = R w~.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import GelenkError, UsageError
from gelenk.linear.held_states import holds, independent, permitted, unchanged
from gelenk.model.values import check_names, unknown
from gelenk.simulation.derivatives import LOCKED_ROUNDING, Derivatives, Quaternion

Array = NDArray[np.float64]

DEPENDENCY_TOLERANCE = (
    1e-10  # of entries of A and C, relative to the largest in the row or 1: rounding errors
)


@dataclass(frozen=True)
class _Rotation:
    """A joint whose quaternion can be read."""

    of: Quaternion
    Q: list[int]  # indices of the quaternion's components in the readings
    w: list[int]  # indices of the angular velocity's components
    G: Array  # shape (4, 3): dQ = G dtheta; dtheta = 4 G' dQ


def _rotates(rotation: _Rotation, change: Array) -> bool:
    """Return whether a joint rotates if the readings change so: not if its loop forbids it."""
    return bool(np.abs(4 * rotation.G.T @ change[rotation.Q]).max() > 0.5)  # of 1 rad


class MinimalRealization:
    """Derivatives with respect to minimal states: three rotation coordinates replace each quaternion.

    Attributes:
        of: the plant's derivatives.
        names: names of the states, coordinates first: those of the plant with J.theta[1..3] for J.Q[1..4].
        C: derivatives of the readings with respect to the states, shape (readings, states).
        D: derivatives of the readings with respect to the inputs, shape (readings, inputs).
        is_held: whether contacts hold some of the states of the plant, so that these are fewer.
    """

    def __init__(self, of: Derivatives) -> None:
        self.of = of
        self._row = {name: i for i, name in enumerate(of.readings)}
        # Without accelerations, the velocities cannot be states.
        self._rotations = [
            self._rotation(one)
            for one in of.quaternions
            if one.w[0] in of.rates and {*one.Q, *one.w} <= {*self._row}
        ]
        self._theta = {
            theta: (rotation, i)
            for rotation in self._rotations
            for i, theta in enumerate(rotation.of.theta)
            if theta not in self._row
        }
        self.D = of.D
        self._set_columns(self._columns(lambda rotation, column: _rotates(rotation, column)))
        self.is_held = holds(self._projector()) or bool(self._immobile())
        if self.is_held:
            self._set_columns(self._columns(lambda _rotation, _column: True))
            self._take_permitted()

    def _columns(self, takes: Callable[[_Rotation, Array], bool]) -> dict[str, Array]:
        """Return the columns of C for states, and for those rotation coordinates that are to be taken."""
        columns: dict[str, Array] = {}
        of = self.of
        own = dict(zip(of.states, of.C.T, strict=True))
        by_component = {Q: rotation for rotation in self._rotations for Q in rotation.of.Q}
        for name in of.states:
            rotation = by_component.get(name)
            if rotation is None:
                columns[name] = own[name]
            elif name == rotation.of.Q[0]:
                across = rotation.G.T @ np.array([own[Q] for Q in rotation.of.Q])
                turns = zip(rotation.of.theta, across, strict=True)
                columns |= {theta: column for theta, column in turns if takes(rotation, column)}
        return columns

    def _set_columns(self, columns: dict[str, Array]) -> None:
        self.names = tuple(sorted(columns, key=lambda name: not self.is_coordinate(name)))
        self.C: Array = (
            np.array([columns[name] for name in self.names]).reshape(len(columns), len(self.of.C)).T
        )

    def _immobile(self) -> list[str]:
        """Return the states that cannot change, and are not velocities of coordinates that could."""
        free = dict(zip(self.names, np.diag(self._projector()) > 0.5, strict=True))
        with_coordinates = {
            self.speed(name) for name in self.names if self.is_coordinate(name) and free[name]
        }
        return [name for name in self.names if not free[name] and name not in with_coordinates]

    def _projector(self) -> Array:
        """Return the changes of the states by their changes, shape (states, states)."""
        n = len(self.names)
        return np.array([self.row(name) for name in self.names]).reshape(n, n)

    def _take_permitted(self) -> None:
        """Take as states those that determine all changes that contacts permit."""
        names = self.names
        coordinates = [name for name in names if self.is_coordinate(name)]
        elements = [name for name in names if self.is_of_element(name)]
        velocities = [name for name in names if self.is_velocity(name)]
        by_coordinates, by_velocities, by_elements = permitted(
            self._projector(), [name in coordinates for name in names], [name in elements for name in names]
        )
        locked = [names.index(name) for name in coordinates if name in self.locked]
        by_coordinates = unchanged(by_coordinates, locked)
        chosen = independent(by_coordinates, names, coordinates, lambda _name: True)
        speeds = {self.speed(name) for name in chosen}
        chosen += independent(by_velocities, names, velocities, lambda name: name in speeds)
        chosen += elements
        changes = np.hstack([by_coordinates, by_velocities, by_elements])
        places = [names.index(name) for name in chosen]
        self.C = np.linalg.solve(changes[places].T, (self.C @ changes).T).T
        self.names = tuple(chosen)
        # An input may move the states, as that of a motion on which something lies; they are given.
        moved = np.array([self._by_inputs(name) for name in chosen]).reshape(len(chosen), self.D.shape[1])
        self.D = self.D - self.C @ moved

    def _by_inputs(self, name: str) -> Array:
        """Return the derivatives of a reading or rotation coordinate with respect to the inputs."""
        if name not in self._theta:
            return np.asarray(self.D[self._row[name]])
        rotation, i = self._theta[name]
        return np.asarray(4 * rotation.G[:, i] @ self.D[rotation.Q])

    def _rotation(self, of: Quaternion) -> _Rotation:
        x, y, z, s = (self.of.values[n] for n in of.Q)
        G = 0.5 * np.array([[s, -z, y], [z, s, -x], [-y, x, s], [-x, -y, -z]])
        return _Rotation(of, [self._row[n] for n in of.Q], [self._row[n] for n in of.w], G)

    @property
    def locked(self) -> set[str]:
        """Names of the coordinates that friction, a limit or a lock holds, and of their velocities."""
        out = {name for q in self.of.locked for name in (q, self.of.rates[q])}
        for rotation in self._rotations:
            # What is at rest keeps no velocity that it is given.
            if np.abs(self.of.C[rotation.w]).max(initial=0.0) <= LOCKED_ROUNDING:
                out |= {*rotation.of.theta, *rotation.of.w}
        return out

    def leave_locked(self) -> None:
        """Leave out the states that are locked, which remain what they are, but for idle rotations."""
        locked = self.locked.difference(*self.idle_rotations)
        kept = [i for i, name in enumerate(self.names) if name not in locked]
        self.names, self.C = tuple(self.names[i] for i in kept), self.C[:, kept]

    @property
    def incomplete_joints(self) -> list[str]:
        """Names of joints with a quaternion that is not among the states."""
        return [rotation.of.joint for rotation in self._rotations if not self._own(rotation.of.theta)]

    def _own(self, names: Sequence[str]) -> list[str]:
        return [name for name in names if name in self.names]

    @property
    def idle_rotations(self) -> list[Sequence[str]]:
        """Names of the states of each joint that spins idly, such as a rod between two ball joints.

        Only some rotations of such a joint are states, and no acceleration depends on them, their own
        included, nor the rate of another state.
        """
        idle: list[Sequence[str]] = []
        if self.is_held:  # the spin of what rolls is no idle one
            return idle
        for rotation in self._rotations:
            own = self._own(rotation.of.theta)
            if len(own) not in (1, 2):
                continue
            others = [name for name in self.names if name not in own]  # and its own accelerations
            own += self._own(rotation.of.w)
            columns = [self.names.index(name) for name in own]
            rates = np.array([self.rate(name)[0] for name in others]).reshape(len(others), len(self.names))
            size = np.maximum(1.0, np.abs(rates).max(axis=1, initial=0.0))
            if np.all(np.abs(rates[:, columns]) <= DEPENDENCY_TOLERANCE * size[:, None]):
                idle.append(own)
        return idle

    @property
    def candidates(self) -> list[str]:
        """Names of all quantities that can be states: those whose time derivative is a reading."""
        quaternions = {name for rotation in self._rotations for name in rotation.of.Q}
        out = [name for name in self.of.readings if name in self.of.rates and name not in quaternions]
        return out + [theta for rotation in self._rotations for theta in rotation.of.theta]

    def speed(self, coordinate: str) -> str:
        """Return the name of a coordinate's velocity: A.w for A.phi, S.w[1] for S.theta[1]."""
        if coordinate not in self._theta:
            return self.of.rates[coordinate]
        rotation, i = self._theta[coordinate]
        return rotation.of.w[i]

    def is_coordinate(self, name: str) -> bool:
        """Whether the second time derivative of a quantity is a reading, so that it is a coordinate."""
        return name in self._theta or self.of.rates.get(name) in self.of.rates

    def is_of_element(self, name: str) -> bool:
        """Whether a state is that of an element, whose rate is given by an expression."""
        return self.of.rates.get(name) == f"{name}.rate"

    def is_velocity(self, name: str) -> bool:
        """Whether a quantity with a rate is a velocity, neither a coordinate nor a state of an element."""
        return not self.is_coordinate(name) and not self.is_of_element(name)

    def row(self, name: str) -> Array:
        """Return the derivatives of a reading or rotation coordinate with respect to the states, shape
        (states,).
        """
        if name not in self._theta:
            row: Array = self.C[self._row[name]]
            return row
        rotation, i = self._theta[name]
        return np.asarray(4 * rotation.G[:, i] @ self.C[rotation.Q])

    def rate(self, name: str) -> tuple[Array, Array, float]:
        """Return the derivatives of a state's rate with respect to the states and the inputs, and the rate
        itself.
        """
        if name not in self._theta:
            row = self._row[self.of.rates[name]]
            return self.C[row], self.D[row], self.of.values[self.of.rates[name]]
        rotation, i = self._theta[name]
        w = np.array([self.of.values[self.of.readings[k]] for k in rotation.w])
        w_cross_theta = np.cross(w, 4 * (rotation.G.T @ self.C[rotation.Q]).T).T[i]
        return self.C[rotation.w[i]] - w_cross_theta, self.D[rotation.w[i]], float(w[i])

    def unit(self, name: str) -> str:
        """Return the unit of a state."""
        return "rad" if name in self._theta else self.of.units.get(name, "1")

    def value(self, name: str) -> float:
        """Return the value of a state at the operating point; 0 for a rotation coordinate."""
        return 0.0 if name in self._theta else self.of.values[name]


def chosen_states(
    minimal: MinimalRealization, wanted: Sequence[str] | None, idle: Sequence[str] = ()
) -> list[str]:
    """Return the states that a user has named, with their velocities if only coordinates are named.

    Args:
        minimal: the plant's derivatives.
        wanted: names of states, fewer than the mechanism has if coordinates and velocities are named; None:
            all but the idle ones. States of elements are always among those returned.
        idle: states that need not be named.

    Raises:
        UsageError: names that cannot be states, too many names, or too few coordinates without velocities.
    """
    if wanted is None:
        return [name for name in minimal.names if name not in idle]
    known = minimal.candidates
    check_names(wanted, known, "state", lambda name: _no_state(name, known, minimal.of.quaternions))
    elements = [name for name in minimal.names if minimal.is_of_element(name)]
    wanted = [name for name in wanted if name not in elements]  # which are all states
    of_motion = [name for name in minimal.names if name not in elements]
    out = list(wanted)
    if all(minimal.is_coordinate(name) for name in wanted):
        out += [minimal.speed(name) for name in wanted]
    needed = [name for name in of_motion if name not in idle]
    if len(wanted) > sum(map(minimal.is_coordinate, needed)):  # idle ones, too, or velocities
        needed = of_motion
    n = len(needed)
    coordinates = sum(map(minimal.is_coordinate, needed))
    if len(wanted) == coordinates and len(out) > n:  # fewer velocities than coordinates: use the plant's
        out = [*wanted, *needed[coordinates:]]
    if len(out) > n or (len(out) < n and all(map(minimal.is_coordinate, wanted))):
        velocities = f"their {n - coordinates}" if 2 * coordinates == n else f"{n - coordinates}"
        raise UsageError(
            f"states: found {len(wanted)}, expected {coordinates} coordinates, or these and {velocities} "
            "velocities"
        )
    return [*out, *elements]


def check_complete(minimal: MinimalRealization) -> None:
    """Check that the states determine the whole motion.

    Raises:
        GelenkError: a quaternion is only partly among the states.
    """
    found = minimal.of
    if minimal.is_held:
        return
    names, joints = ", ".join(minimal.names), ", ".join(minimal.incomplete_joints)
    sentence = (
        f"not all rotations of a joint with a quaternion are free{f' ({joints})' if joints else ''}, so that "
        f"it cannot provide states; the other states, {names}, do not determine the motion"
    )
    if found.order is not None:
        if len(minimal.names) != found.order:
            raise GelenkError(
                f"{sentence}: there are {len(minimal.names)} of {found.order}. If the loop is cut at this "
                "joint, it needs no states: list it after the loop's other joints, or leave the reduction "
                "cut_choice on"
            )
        return
    # FMUs of other tools do not state the number of states. Readings must then change as dy/dt = C dx/dt.
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    for i, name in enumerate(found.readings):
        speed = found.rates.get(name)
        if speed is None:
            continue
        terms = minimal.C[i] * rates
        scale = 1 + np.abs(terms).sum() + abs(found.values[speed])
        if (
            abs(terms.sum() - found.values[speed]) > 1e-4 * scale
        ):  # loops closed by a penalty have small errors
            raise GelenkError(f"{sentence}: the rate of {name} does not follow from theirs")


def _no_state(name: str, known: Sequence[str], quaternions: Sequence[Quaternion]) -> str:
    for of in quaternions:
        if name in (*of.Q, f"{of.joint}.Q") and of.theta[0] in known:
            return f"{name}: a quaternion has one component too many for states; use {of.joint}.theta[1..3]"
    return unknown(name, "state", known)
