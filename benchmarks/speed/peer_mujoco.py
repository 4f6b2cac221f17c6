# SPDX-License-Identifier: BSD-3-Clause
"""MuJoCo: loop closures are equality constraints, as stiff as the step size allows."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from benchmarks.speed import peer
from benchmarks.speed.tree import Array, Body, Tree

RUNTIME = next(Path(mujoco.__file__).parent.glob("libmujoco.so*"))
CDLL = ctypes.CDLL(str(RUNTIME), mode=ctypes.RTLD_GLOBAL)
LOOP = peer.library("libmujoco_loop.so")
for _name in ("time_forward", "time_steps", "time_driven_steps"):
    getattr(LOOP, _name).restype = ctypes.c_double


def _words(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in np.asarray(numbers, float).reshape(-1))


def _opening(tree: Tree, i: int, b: Body) -> str:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, b.R.reshape(-1))
    I = np.asarray(b.inertia, float)  # noqa: E741 (inertia)
    moments = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
    return (
        f'<body name="b{i}" pos="{_words(b.position)}" quat="{_words(quaternion)}">'
        f'<joint name="j{i}" type="{"slide" if b.slides else "hinge"}" axis="{_words(b.axis)}" '
        f'damping="{b.damping}"/>'
        f'<inertial pos="{_words(b.com)}" mass="{b.mass}" fullinertia="{_words(moments)}"/>{_sites(tree, i)}'
    )


def _sites(tree: Tree, body: int) -> str:
    def site(name: str, at: Any) -> str:
        return f'<site name="{name}" pos="{_words(at)}"/>'

    ends: Iterable[tuple[str, Any]] = [("c", tree.closures), ("s", tree.springs)]
    return "".join(
        (site(f"{kind}{k}a", x.at_first) if x.first == body else "")
        + (site(f"{kind}{k}b", x.at_second) if x.second == body else "")
        for kind, group in ends
        for k, x in enumerate(group)
    )


def _bodies(tree: Tree) -> str:
    """Return the bodies depth first, without recursion: chains are deep."""
    children: dict[int, list[int]] = {}
    for i, b in enumerate(tree.bodies):
        children.setdefault(b.parent, []).append(i)
    parts, stack = [], [("open", i) for i in reversed(children.get(-1, []))]
    while stack:
        what, i = stack.pop()
        if what == "close":
            parts.append("</body>")
            continue
        parts.append(_opening(tree, i, tree.bodies[i]))
        stack.append(("close", i))
        stack += [("open", c) for c in reversed(children.get(i, []))]
    return "".join(parts)


def xml(tree: Tree, step: float, integrator: str) -> str:
    """Return the model; loops are as stiff as MuJoCo's documentation allows for the step size."""
    connects = "".join(
        f'<connect site1="c{k}a" site2="c{k}b" solref="{2 * step} 1" solimp="0.9999 0.9999 0.001 0.5 2"/>'
        for k in range(len(tree.closures))
    )
    tendons = "".join(
        f'<spatial stiffness="{s.stiffness}" damping="{s.damping}" springlength="{s.length}">'
        f'<site site="s{k}a"/><site site="s{k}b"/></spatial>'
        for k, s in enumerate(tree.springs)
    )
    return (
        '<mujoco><compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"/>'
        f'<option timestep="{step}" gravity="{_words(tree.gravity)}" integrator="{integrator}" '
        'solver="Newton" iterations="50" tolerance="1e-14"><flag contact="disable" limit="disable"/></option>'
        f'<size memory="400M"/><worldbody>{_sites(tree, -1)}{_bodies(tree)}</worldbody>'
        f"<equality>{connects}</equality><tendon>{tendons}</tendon></mujoco>"
    )


class Model:
    """A model at its start. motors: the torques are the mechanism's sines; otherwise they are set by the
    caller.
    """

    def __init__(self, tree: Tree, step: float, integrator: str = "RK4", motors: bool = True) -> None:
        self.tree = tree
        self.model = mujoco.MjModel.from_xml_string(xml(tree, step, integrator))
        self.data = mujoco.MjData(self.model)
        self.joints = [self.model.joint(f"j{i}").id for i in range(len(tree.bodies))]
        table = np.zeros((len(tree.bodies), 6))
        for joint, b in zip(self.joints, tree.bodies, strict=True):
            sine = b.amplitude if motors else 0.0
            table[joint] = [b.tau, sine, b.omega, b.phase, b.stiffness, b.reference]
        self.table: Array = table
        self.restart()
        moved = bool(np.any(table[:, [0, 1, 4] if motors else [4]]))
        LOOP.set_motors(len(table) if moved else 0, table.ctypes.data_as(ctypes.c_void_p))

    def restart(self) -> None:
        """Reset to the start."""
        mujoco.mj_resetData(self.model, self.data)
        for joint, b in zip(self.joints, self.tree.bodies, strict=True):
            self.data.qpos[joint], self.data.qvel[joint] = b.q, b.v

    def coordinates(self) -> list[float]:
        """Return the joint coordinates by body."""
        return [float(self.data.qpos[j]) for j in self.joints]

    @property
    def pointers(self) -> tuple[ctypes.c_void_p, ctypes.c_void_p]:
        """Pointers to the C structures of model and data."""
        return ctypes.c_void_p(self.model._address), ctypes.c_void_p(self.data._address)


def forward(tree: Tree) -> None:
    m = Model(tree, 1e-3, "Euler")
    once = LOOP.time_forward(*m.pointers, 3)
    calls = max(3, min(20000, int(3e-3 / once)))
    peer.print_time(tree.name, "mj_forward", peer.least(lambda: LOOP.time_forward(*m.pointers, calls), 15))


def step(tree: Tree) -> None:
    for integrator in ("RK4", "implicitfast"):
        m = Model(tree, 1e-3, integrator, motors=False)
        forces = peer.torques(tree, peer.ROUNDS)[:, np.argsort(m.joints)].copy()
        pointer = forces.ctypes.data_as(ctypes.c_void_p)

        def once(m: Model = m, pointer: ctypes.c_void_p = pointer) -> float:
            m.restart()
            return float(LOOP.time_driven_steps(*m.pointers, peer.ROUNDS, pointer))

        peer.print_time(tree.name, integrator, peer.least(once), m.coordinates())


def run(tree: Tree, method: str, setting: float) -> None:
    steps = round(tree.sample / setting)

    def once() -> peer.Run:
        m = Model(tree, setting, method)

        def advance(end: float) -> tuple[float, bool]:
            taken = float(LOOP.time_steps(*m.pointers, steps))
            return taken, abs(m.data.time - end) < 1e-6  # MuJoCo resets itself when the simulation diverges

        return peer.sampled(tree, m.coordinates, advance)

    peer.print_fastest(tree, method, setting, once, 3)


if __name__ == "__main__":
    peer.main(forward, step, run)
