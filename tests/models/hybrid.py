# SPDX-License-Identifier: BSD-3-Clause
"""Reference: open chains with one coordinate prescribed, by Pinocchio's equations of motion and SciPy.

With M v' + h = -damping v - stiffness q + e f and s = q[driven] known, the other equations determine the
other accelerations, and the driven one the force f: hybrid dynamics (Featherstone 2008, section 9.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
from mechanisms import HINGE_AXES, Scene, body, frame, general_body, inertia_matrix, joint, rotation, scene
from scipy.integrate import solve_ivp

from models.driven import Array, Law

# The motion of a joint as a sequence of rotations and translations: names of coordinate, speed and
# acceleration, whether it is a rotation, the axis.
STEPS: dict[str, list[tuple[str, str, str, bool, Sequence[float]]]] = {
    "revolute": [("phi", "w", "a", True, (0, 0, 1))],
    "prismatic": [("s", "v", "a", False, (0, 0, 1))],
    "universal": [("phi_a", "w_a", "a_a", True, (0, 0, 1)), ("phi_b", "w_b", "a_b", True, (1, 0, 0))],
    "cylindrical": [("s", "v", "a", False, (0, 0, 1)), ("phi", "w", "wd", True, (0, 0, 1))],
    "planar": [
        ("s_x", "v_x", "a_x", False, (1, 0, 0)),
        ("s_y", "v_y", "a_y", False, (0, 1, 0)),
        ("phi", "w", "wd", True, (0, 0, 1)),
    ],
}
GRAVITY = np.array([1.2, -8.1, -4.9])  # m/s2
GROUND = (np.array([0.1, -0.2, 0.3]), rotation([1, 2, -1], 0.7))  # the first joint's frame there
FIRST = (np.array([0.04, 0.07, -0.05]), rotation([-2, 1, 1], 0.4))  # and in the first body
LINK = (np.array([0.31, -0.12, 0.22]), rotation([1, 1, 3], -0.9))  # the second joint's frame in the first
# body
TIP = (np.array([0.02, 0.11, 0.06]), rotation([0, 1, 1], 0.5))  # and in the second
BODIES = {
    "first": general_body(
        1.7, np.array([0.1, 0.05, -0.08]), rotation([1, 0, 2], 0.6) @ np.diag([0.05, 0.04, 0.03])
        @ rotation([1, 0, 2], 0.6).T,
    ),
    "second": body(0.9, (0.15, -0.22, 0.09), (0.02, 0.017, 0.025, 0.001, -0.002, 0.0015)),
}  # fmt: skip
STIFFNESS, DAMPING = 3.0, 0.4  # of each coordinate of the first joint
SECOND_DAMPING = 0.05


@dataclass
class Chain:
    """A body on the joint under test, and a second body on a revolute joint on it."""

    kind: str
    coordinate: str
    reversed: bool = False  # the ground is the joint's child
    angle: float = 0.4  # of the revolute joint at the start [rad]

    def __post_init__(self) -> None:
        steps = STEPS[self.kind]
        if self.reversed:  # the inverse of a product
            steps = [(q, v, a, turns, [-x for x in n]) for q, v, a, turns, n in reversed(steps)]
        self.steps = steps
        self.driven = [s[0] for s in steps].index(self.coordinate)
        self.names = [f"J.{s[0]}" for s in steps] + ["H.phi"]
        self.speeds = [f"J.{s[1]}" for s in steps] + ["H.w"]
        self.accelerations = [f"J.{s[2]}" for s in steps] + ["H.a"]
        self.n = len(steps) + 1
        self.damping = np.array([DAMPING] * (self.n - 1) + [SECOND_DAMPING])
        self.stiffness = np.array([STIFFNESS] * (self.n - 1) + [0.0])
        self.model = self._model()
        self.data = self.model.createData()

    @property
    def force_name(self) -> str:
        return "drive.tau" if self.steps[self.driven][3] else "drive.f"

    def _model(self) -> Any:
        model = pin.Model()
        model.gravity.linear = GRAVITY
        last, at = 0, _pose(GROUND)
        for name, _, _, turns, axis in self.steps:
            kind = pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned
            last = model.addJoint(last, kind(np.array(axis, float)), at, name)
            at = pin.SE3.Identity()
        into = _pose(FIRST).inverse()
        model.appendBodyToJoint(last, _inertia(BODIES["first"]), into)
        hinge = model.addJoint(last, pin.JointModelRZ(), into * _pose(LINK), "hinge")
        model.appendBodyToJoint(hinge, _inertia(BODIES["second"]), _pose(TIP).inverse())
        return model

    def scene(self, motion: dict[str, Any], start: dict[str, Any] | None = None, **fields: Any) -> Scene:
        ends = (frame("ground", *GROUND), frame("first", *FIRST))
        parent, child = reversed(ends) if self.reversed else ends
        return scene(
            BODIES,
            {
                "J": joint(
                    self.kind, parent, child, **HINGE_AXES.get(self.kind, {"axis": [0, 0, 1]}),
                    damping=[DAMPING] * (self.n - 1) if self.n > 2 else DAMPING,
                    stiffness=[STIFFNESS] * (self.n - 1) if self.n > 2 else STIFFNESS,
                    **({"start": start} if start else {}),
                ),
                "H": joint(
                    "revolute", frame("first", *LINK), frame("second", *TIP), axis=[0, 0, 1],
                    damping=SECOND_DAMPING, start={"phi": self.angle, "w": 0.0, "fixed": True},
                ),
            },
            name="Chain",
            gravity=GRAVITY.tolist(),
            constraints={
                "drive": {"type": "motion", "joint": "J", "coordinate": self.coordinate, **motion}
            },
            sensors={"meter": {"type": "energy"}},
            **fields,
        )  # fmt: skip

    def terms(self, q: Array, v: Array) -> tuple[Array, Array]:
        """M and h, dampers and springs included."""
        M = pin.crba(self.model, self.data, q)
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(self.model, self.data, q, v)
        return M, h + self.damping * v + self.stiffness * q

    def acceleration(self, q: Array, v: Array, driven: float) -> tuple[Array, float]:
        """All v' and the force along the driven coordinate, whose acceleration is given."""
        M, h = self.terms(q, v)
        free = [k for k in range(self.n) if k != self.driven]
        vdot = np.empty(self.n)
        vdot[self.driven] = driven
        vdot[free] = np.linalg.solve(M[np.ix_(free, free)], -h[free] - M[free, self.driven] * driven)
        return vdot, float(M[self.driven] @ vdot + h[self.driven])

    def motion(self, law: Law, times: Array, kinks: Sequence[float] = ()) -> dict[str, Array]:
        """Coordinates, velocities, accelerations and the force at the times, by the names of their outputs.

        kinks: times at which the prescribed motion is not smooth; no integration step crosses one.
        """
        free = [k for k in range(self.n) if k != self.driven]

        def place(t: float, x: Array) -> tuple[Array, Array, float]:
            s = law(t)
            q, v = np.empty(self.n), np.empty(self.n)
            q[self.driven], v[self.driven] = s[0], s[1]
            q[free], v[free] = x[: len(free)], x[len(free) :]
            return q, v, s[2]

        def rates(t: float, x: Array) -> Array:
            q, v, a = place(t, x)
            vdot, _ = self.acceleration(q, v, a)
            return np.concatenate([v[free], vdot[free]])

        x = np.zeros(2 * len(free))
        x[len(free) - 1] = self.angle
        inner = [k for k in kinks if times[0] < k < times[-1]]
        states = [x]  # at the times
        for begin, end in pairwise([times[0], *inner, times[-1]]):
            within = times[(times > begin) & (times <= end)]
            found = solve_ivp(
                rates, (begin, end), x, "DOP853", np.unique([*within, end]), rtol=1e-12, atol=1e-13
            )
            assert found.success
            x = found.y[:, -1]
            states += list(found.y.T[: len(within)])
        rows = []
        for t, x in zip(times, states, strict=True):
            q, v, a = place(float(t), x)
            vdot, force = self.acceleration(q, v, a)
            rows.append([*q, *v, *vdot, force])
        names = [*self.names, *self.speeds, *self.accelerations, self.force_name]
        return dict(zip(names, np.array(rows).T, strict=True))


def _pose(at: tuple[Array, Array]) -> Any:
    return pin.SE3(at[1], at[0])


def _inertia(entry: dict[str, Any]) -> Any:
    return pin.Inertia(entry["mass"], np.array(entry["com"]), inertia_matrix(entry))
