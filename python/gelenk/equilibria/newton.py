# SPDX-License-Identifier: BSD-3-Clause
"""Newton's method for accelerations that vanish, on the pose and on inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gelenk.equilibria.rest import Pose, Rest
from gelenk.errors import AssemblyError, EquilibriumError, UsageError
from gelenk.linear.model import standing

Array = NDArray[np.float64]

MOST_STEPS = 200
MOST_IN_VAIN = 5  # steps by which those to come do not become shorter by this factor
PROGRESS = 0.9
MOST_FALLS = 100  # steps downhill, where Newton's lead nowhere
SHORTEST = 1 / 64  # of a step, before it is given up
# Singular values up to this, or this part of the largest, are rounding: of directions that nothing holds.
SINGULAR = 1e-10
SETTLED = (
    1e-9  # rad, part of the mechanism's length or of an input: the error after such a step is its square
)


class Search:
    """From a pose to one without accelerations: dx and du with a + A dx + B du = 0, held ones apart.

    Where this is singular, the least dx and du that make a smallest. Steps are shortened until the next
    one, by the same derivatives, would be shorter (Deuflhard 2004, ch. 3: natural monotonicity).

    Attributes:
        pose: reached.
        starts: the start values of its joints.
        inputs: all of them, there; these and the start values in the mechanism's own units.
        steps: taken.
        settled: whether the last one was of no length, be it an equilibrium or not.
    """

    def __init__(
        self, rest: Rest, first: Pose, inputs: Mapping[str, float], solve_for: Sequence[str]
    ) -> None:
        self.rest = rest
        self.inputs = dict(inputs)
        self._free = [first.found.inputs.index(name) for name in solve_for]
        self._names = list(solve_for)
        self.steps = 0
        self.settled = False
        self._falls = 0
        self.pose = first
        self.starts: dict[str, float] = {}

    def run(self) -> None:
        """Goes on until the pose settles, or the steps are used up."""
        self._approach()
        least, in_vain = np.inf, 0  # of Newton's steps since the last fall; steps since then
        while self.steps < MOST_STEPS and not self.settled:
            dq, du = self._newton(self.pose.accelerations, self._gap())
            size = self._size(dq, du)
            if size < SETTLED:
                self._try(dq, du, 1.0)
                self.settled = self._stands() or not self._fall()
                continue
            # Shortened steps go on to and fro where A is singular between two poses.
            nearer = size < PROGRESS * least
            in_vain = 0 if nearer else in_vain + 1
            least = size if nearer else least
            if in_vain < MOST_IN_VAIN and self._shortened(dq, du):
                continue
            if not self._fall():
                return
            least = np.inf
        if self._names:
            self._least_inputs()

    def _approach(self) -> None:
        """To the values that are held, in steps that keep the branch."""
        held = list(self.rest.hold)
        share = 0.0
        while share < 1:
            dq = self._particular(self._gap())
            share = self.rest.share(self.rest.turns(self.pose, dq))
            starts = self.rest.starts(self.pose, share * dq)
            for name in held:
                start, end = self.pose.found.values[name], self.rest.hold[name]
                starts[name] = end if share == 1 else start + share * (end - start)
            self._take(starts, self.rest.put(starts, self.inputs))
            if share < 1:
                self.steps += 1
            if self.steps >= MOST_STEPS:
                raise EquilibriumError(self.unreached)

    def _gap(self) -> Array:
        return np.array([value - self.pose.found.values[name] for name, value in self.rest.hold.items()])

    def _particular(self, gap: Array) -> Array:
        out: Array = np.linalg.pinv(self.pose.slopes(list(self.rest.hold)), SINGULAR) @ gap
        return out

    def _free_directions(self) -> Array:
        """Of the unknowns, shape (n, what is not held)."""
        return self._across(self.pose.slopes(list(self.rest.hold)))

    def _free_speeds(self) -> Array:
        """Of the independent speeds, shape (n, those that move nothing held)."""
        return self._across(self.pose.slopes(list(self.rest.hold)) @ self.pose.ways)

    @staticmethod
    def _across(H: Array) -> Array:
        _, size, V = np.linalg.svd(H, full_matrices=True)
        rank = int((size > SINGULAR * size.max(initial=0.0)).sum())
        return V[rank:].T

    def _newton(self, accelerations: Array, gap: Array) -> tuple[Array, Array]:
        held = self._particular(gap)
        N = self._free_directions()
        J = np.hstack([self.pose.A @ N, self.pose.B[:, self._free]])
        stiffest = float(np.linalg.norm(J, 2)) if J.size else 0.0
        found = np.linalg.pinv(J, SINGULAR * max(1.0, 1 / max(stiffest, SINGULAR)))
        found = found @ -(accelerations + self.pose.A @ held)
        return held + N @ found[: N.shape[1]], found[N.shape[1] :]

    def _size(self, dq: Array, du: Array) -> float:
        scale = np.array([1 + abs(self.inputs[name]) for name in self._names])
        return float(np.abs(np.concatenate([dq / self.pose.sizes, du / scale])).max(initial=0.0))

    def _shortened(self, dq: Array, du: Array) -> bool:
        size = self._size(dq, du)
        share = self.rest.share(self.rest.turns(self.pose, dq))
        least = SHORTEST * share
        while share >= least:
            there = self._try(dq, du, share, keep=False)
            if there is not None:
                starts, inputs, pose = there
                gap = (1 - share) * self._gap()
                rest = self._newton(pose.accelerations_of(self.pose.conditions), gap)
                if self._size(*rest) <= (1 - share / 4) * size:
                    self.inputs = inputs
                    self._take(starts, pose)
                    self.steps += 1
                    return True
            share /= 2
        return False

    def _try(
        self, dq: Array, du: Array, share: float, keep: bool = True
    ) -> tuple[dict[str, float], dict[str, float], Pose] | None:
        """The pose after a step; None where the loops do not close, or are singular."""
        starts = self.rest.starts(self.pose, share * dq) | self.rest.hold
        inputs = dict(self.inputs)
        for name, change in zip(self._names, du, strict=True):
            inputs[name] += share * float(change)
        try:
            pose = self.rest.put(starts, inputs)
        except (AssemblyError, UsageError):
            return None
        if keep:
            self.inputs = inputs
            self._take(starts, pose)
            self.steps += 1
        return starts, inputs, pose

    def _stands(self) -> bool:
        return self.pose.stands and self.kept()

    @property
    def unreached(self) -> str:
        """What to say of a pose that is not attained."""
        what = "the pose to hold" if self.rest.conditions is None else "this motion"
        return f"{', '.join(self.rest.hold)}: the mechanism cannot be brought to {what}"

    def kept(self) -> bool:
        """Whether what is held is where it has to be."""
        return float(np.abs(self._gap()).max(initial=0.0)) <= SETTLED

    def _fall(self) -> bool:
        """Downhill, as through honey, where Newton's method is stuck: to where the pose is stable.

        Implicit Euler on dq/dt = v': (s - A) dq = v', with s above all eigenvalues of A, which are those of
        -M^-1 K: so dq lowers the potential energy.
        """
        if self.rest.conditions is not None:  # what holds a steady motion is no potential
            return False
        N = self._free_speeds()
        if not N.shape[1]:
            return False
        again = self._falls > 0  # from where Newton's steps have led up once more: down to the bottom
        moved = False
        while self._falls < MOST_FALLS:
            ways = self.pose.ways @ N
            A, a = N.T @ self.pose.A @ ways, N.T @ self.pose.accelerations
            steepest = float(np.linalg.eigvals(A).real.max())
            size = float(np.abs(a).max())
            stable = steepest < -SINGULAR * max(1.0, float(np.abs(A).max()))
            if size <= standing(A, np.ones(len(A))).max() or (stable and moved and not again):
                return moved
            dq = ways @ np.linalg.solve((2 * max(steepest, 0.0) + size) * np.eye(len(A)) - A, a)
            self._falls += 1
            share = self.rest.share(self.rest.turns(self.pose, dq))
            before = self.pose.largest()
            if self._try(dq, np.zeros(len(self._names)), share) is None:
                return moved
            if self.pose.largest() == before:  # a constant force that no coordinate changes
                return False
            moved = True
            N = self._free_speeds()
        return moved

    def _least_inputs(self) -> None:
        """Of all inputs that do the same in this pose those of the least sum of squares."""
        B = self.pose.B[:, self._free]
        u = np.array([self.inputs[name] for name in self._names])
        least = np.linalg.pinv(B, SINGULAR) @ (B @ u)
        if np.abs(least - u).max(initial=0.0) > 1e-12 * np.abs(u).max(initial=0.0):
            self._try(np.zeros(len(self.pose.unknowns)), least - u, 1.0)

    def _take(self, starts: dict[str, float], pose: Pose) -> None:
        self.starts, self.pose = starts, pose
