# SPDX-License-Identifier: BSD-3-Clause
"""Newton's method for poses and inputs at which the accelerations vanish."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gelenk.equilibria.pose import LinearizedPose, PosedPlant
from gelenk.errors import AssemblyError, EquilibriumError, UsageError
from gelenk.linear.model import equilibrium_rate_bounds

log = logging.getLogger(__name__)

Array = NDArray[np.float64]

MAX_STEPS = 200
MAX_STEPS_WITHOUT_PROGRESS = 5  # Newton steps in which the step length does not fall below the next factor
PROGRESS_FACTOR = 0.9  # of the smallest step length so far
MAX_DESCENT_STEPS = 100  # pseudo-transient steps, if Newton's method makes no progress
MIN_STEP_FRACTION = 1 / 64  # of a full step, before the step is rejected
# Singular values up to this value, or this fraction of the largest, are rounding errors: of directions
# without restoring force.
SINGULAR_VALUE_TOLERANCE = 1e-10
# rad, and relative to the mechanism's length or to an input. The error after a step of this length is its
# square.
STEP_TOLERANCE = 1e-9


class Search:
    """Search for a pose without accelerations: a + A dx + B du = 0, with held coordinates fixed.

    If the system is singular, dx and du of minimum norm minimize the accelerations. A step is shortened until
    the next step, with the same Jacobian, would be shorter (natural monotonicity test, Deuflhard 2004, ch.
    3).

    Attributes:
        plant: the plant.
        pose: the pose reached.
        starts: start values of its joints, in the mechanism's own units.
        inputs: values of all inputs, in own units.
        steps: number of steps taken.
        converged: whether the last step had length zero; the pose need not be an equilibrium.
    """

    def __init__(
        self, plant: PosedPlant, first: LinearizedPose, inputs: Mapping[str, float], solve_for: Sequence[str]
    ) -> None:
        self.plant = plant
        self.inputs = dict(inputs)
        self._free = [first.found.inputs.index(name) for name in solve_for]
        self._names = list(solve_for)
        self.steps = 0
        self.converged = False
        self._descent_steps = 0
        self.pose = first
        self.starts: dict[str, float] = {}

    def run(self) -> None:
        """Iterate until convergence, or until the maximum number of steps is reached.

        Raises:
            AssemblyError: the loops cannot be closed with the held values.
            EquilibriumError: the held values cannot be reached.
        """
        self.approach()
        shortest, in_vain = np.inf, 0  # step length since the last descent; steps without a shorter one
        while self.steps < MAX_STEPS and not self.converged:
            dq, du = self._newton(self.pose.accelerations, self._hold_error())
            size = self._step_length(dq, du)
            if size < STEP_TOLERANCE:
                self._try(dq, du, 1.0)
                self.converged = self._is_equilibrium() or not self._pseudo_transient_step()
                continue
            log.debug("step %d, of length %.3g", self.steps, size)
            # Shortened steps would oscillate for ever about a pose between two others at which A is singular.
            shorter = size < PROGRESS_FACTOR * shortest
            in_vain = 0 if shorter else in_vain + 1
            shortest = size if shorter else shortest
            if in_vain < MAX_STEPS_WITHOUT_PROGRESS and self._damped_step(dq, du):
                continue
            if not self._pseudo_transient_step():
                return
            shortest = np.inf
        if self._names:
            self._minimize_inputs()

    def approach(self) -> None:
        """Move to the held values in steps that remain on the branch.

        Raises:
            AssemblyError: the loops cannot be closed with the held values.
            EquilibriumError: the held values cannot be reached.
        """
        held = list(self.plant.hold)
        fraction = 0.0
        while fraction < 1:
            dq = self._min_norm_step(self._hold_error())
            fraction = self.plant.step_fraction(self.plant.rotations(self.pose, dq))
            starts = self.plant.starts(self.pose, fraction * dq)
            for name in held:
                start, end = self.pose.found.values[name], self.plant.hold[name]
                starts[name] = end if fraction == 1 else start + fraction * (end - start)
            self._accept(starts, self.plant.put(starts, self.inputs))
            if fraction < 1:
                self.steps += 1
            if self.steps >= MAX_STEPS:
                raise EquilibriumError(self.unreachable)

    def _hold_error(self) -> Array:
        return np.array([value - self.pose.found.values[name] for name, value in self.plant.hold.items()])

    def _min_norm_step(self, error: Array) -> Array:
        """Return the minimum-norm step that corrects an error of the held coordinates, shape (unknowns,)."""
        out: Array = (
            np.linalg.pinv(self.pose.jacobian(list(self.plant.hold)), SINGULAR_VALUE_TOLERANCE) @ error
        )
        return out

    def _free_directions(self) -> Array:
        """Return a basis of the steps that move no held coordinate, shape (unknowns, directions)."""
        return self._null_space(self.pose.jacobian(list(self.plant.hold)))

    def _free_velocities(self) -> Array:
        """Return a basis of the velocities that move no held coordinate, shape (conditions, directions)."""
        return self._null_space(self.pose.jacobian(list(self.plant.hold)) @ self.pose.velocity_basis)

    @staticmethod
    def _null_space(H: Array) -> Array:
        _, size, V = np.linalg.svd(H, full_matrices=True)
        rank = int((size > SINGULAR_VALUE_TOLERANCE * size.max(initial=0.0)).sum())
        return V[rank:].T

    def _newton(self, accelerations: Array, hold_error: Array) -> tuple[Array, Array]:
        held = self._min_norm_step(hold_error)
        N = self._free_directions()
        J = np.hstack([self.pose.A @ N, self.pose.B[:, self._free]])
        largest = float(np.linalg.norm(J, 2)) if J.size else 0.0
        tolerance = SINGULAR_VALUE_TOLERANCE * max(1.0, 1 / max(largest, SINGULAR_VALUE_TOLERANCE))
        found = np.linalg.pinv(J, tolerance) @ -(accelerations + self.pose.A @ held)
        return held + N @ found[: N.shape[1]], found[N.shape[1] :]

    def _step_length(self, dq: Array, du: Array) -> float:
        scale = np.array([1 + abs(self.inputs[name]) for name in self._names])
        return float(np.abs(np.concatenate([dq / self.pose.sizes, du / scale])).max(initial=0.0))

    def _damped_step(self, dq: Array, du: Array) -> bool:
        size = self._step_length(dq, du)
        fraction = self.plant.step_fraction(self.plant.rotations(self.pose, dq))
        smallest = MIN_STEP_FRACTION * fraction
        while fraction >= smallest:
            trial = self._try(dq, du, fraction, keep=False)
            if trial is not None:
                starts, inputs, pose = trial
                hold_error = (1 - fraction) * self._hold_error()
                next_step = self._newton(pose.accelerations_of(self.pose.conditions), hold_error)
                if self._step_length(*next_step) <= (1 - fraction / 4) * size:
                    self.inputs = inputs
                    self._accept(starts, pose)
                    self.steps += 1
                    return True
            fraction /= 2
        return False

    def _try(
        self, dq: Array, du: Array, fraction: float, keep: bool = True
    ) -> tuple[dict[str, float], dict[str, float], LinearizedPose] | None:
        """Return start values, inputs and pose after a step; None if the loops are open or singular."""
        starts = self.plant.starts(self.pose, fraction * dq) | self.plant.hold
        inputs = dict(self.inputs)
        for name, change in zip(self._names, du, strict=True):
            inputs[name] += fraction * float(change)
        try:
            pose = self.plant.put(starts, inputs)
        except (AssemblyError, UsageError):
            return None
        if keep:
            self.inputs = inputs
            self._accept(starts, pose)
            self.steps += 1
        return starts, inputs, pose

    def _is_equilibrium(self) -> bool:
        return self.pose.is_equilibrium and self.holds()

    @property
    def unreachable(self) -> str:
        """The message for held values that cannot be reached."""
        what = "the pose to hold" if self.plant.conditions is None else "this motion"
        return f"{', '.join(self.plant.hold)}: the mechanism cannot be brought to {what}"

    def holds(self) -> bool:
        """Whether all held coordinates and velocities have their values."""
        return float(np.abs(self._hold_error()).max(initial=0.0)) <= STEP_TOLERANCE

    def _pseudo_transient_step(self) -> bool:
        """Descend the potential energy by pseudo-transient continuation until the pose is stable.

        It is used if Newton's method makes no progress, and returns whether the pose has changed. Steps of
        implicit Euler for the overdamped motion dq/dt = v': (s - A) dq = v', with s above all eigenvalues of
        A. These are the eigenvalues of -M^-1 K, so that dq lowers the potential energy.
        """
        if self.plant.conditions is not None:  # a steady motion does not minimize a potential
            return False
        N = self._free_velocities()
        if not N.shape[1]:
            return False
        again = self._descent_steps > 0  # Newton's steps have led uphill again: descend to the minimum
        moved = False
        while self._descent_steps < MAX_DESCENT_STEPS:
            directions = self.pose.velocity_basis @ N
            A, a = N.T @ self.pose.A @ directions, N.T @ self.pose.accelerations
            largest = float(np.linalg.eigvals(A).real.max())
            size = float(np.abs(a).max())
            stable = largest < -SINGULAR_VALUE_TOLERANCE * max(1.0, float(np.abs(A).max()))
            if size <= equilibrium_rate_bounds(A, np.ones(len(A))).max() or (stable and moved and not again):
                return moved
            dq = directions @ np.linalg.solve((2 * max(largest, 0.0) + size) * np.eye(len(A)) - A, a)
            self._descent_steps += 1
            fraction = self.plant.step_fraction(self.plant.rotations(self.pose, dq))
            before = self.pose.largest()
            if self._try(dq, np.zeros(len(self._names)), fraction) is None:
                return moved
            if self.pose.largest() == before:  # a constant force in a direction without restoring force
                return False
            moved = True
            N = self._free_velocities()
        return moved

    def _minimize_inputs(self) -> None:
        """Replace the inputs by those of least norm with the same effect in this pose."""
        B = self.pose.B[:, self._free]
        u = np.array([self.inputs[name] for name in self._names])
        least = np.linalg.pinv(B, SINGULAR_VALUE_TOLERANCE) @ (B @ u)
        if np.abs(least - u).max(initial=0.0) > 1e-12 * np.abs(u).max(initial=0.0):
            self._try(np.zeros(len(self.pose.unknowns)), least - u, 1.0)

    def _accept(self, starts: dict[str, float], pose: LinearizedPose) -> None:
        self.starts, self.pose = starts, pose
