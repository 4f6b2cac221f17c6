# SPDX-License-Identifier: BSD-3-Clause
"""The mechanisms of `make bench`: accelerations against Pinocchio's equations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from benchmarks.speed import families
from benchmarks.speed.tree import Array, Closure, Spring, Tree, to_scene, to_text

import gelenk

NAMES = [*families.SINGLE, "chain_p_1", "chain_p_8", "chain_s_2", "chain_s_32", "nfourbar_1", "nfourbar_5"]
FRAME = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Reference:
    """M vdot + h + J^T lambda = tau, J vdot = gamma with Pinocchio's M, h and accelerations of points."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.model: Any = pin.Model()
        self.model.gravity.linear = np.array(tree.gravity, float)
        for b in tree.bodies:
            kind = pin.JointModelPrismaticUnaligned if b.slides else pin.JointModelRevoluteUnaligned
            place = pin.SE3(b.R, np.array(b.position, float))
            joint = self.model.addJoint(b.parent + 1, kind(np.array(b.axis, float)), place, b.name)
            inertia = pin.Inertia(b.mass, np.array(b.com, float), np.array(b.inertia, float))
            self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        pairs: list[Closure | Spring] = [*tree.closures, *tree.springs]
        self.points = [(self._point(x.first, x.at_first), self._point(x.second, x.at_second)) for x in pairs]
        self.data = self.model.createData()

    def _point(self, body: int, at: Sequence[float]) -> int:
        place = pin.SE3(np.eye(3), np.array(at, float))
        name = f"point{self.model.nframes}"
        return int(self.model.addFrame(pin.Frame(name, body + 1, 0, place, pin.FrameType.OP_FRAME)))

    def _motion(self, frame: int) -> tuple[Array, Array, Array]:
        """Return position, Jacobian and acceleration for vdot = 0 of a point."""
        J = pin.getFrameJacobian(self.model, self.data, frame, FRAME)[:3]
        bias = pin.getFrameClassicalAcceleration(self.model, self.data, frame, FRAME).linear
        return self.data.oMf[frame].translation, J, bias

    def accelerations(self, q: Array, v: Array, torque: Array) -> Array:
        M = pin.crba(self.model, self.data, q)
        M = np.triu(M) + np.triu(M, 1).T
        force = torque - pin.nonLinearEffects(self.model, self.data, q, v)
        force -= np.array([b.damping for b in self.tree.bodies]) * v
        force -= np.array([b.stiffness * (x - b.reference) for b, x in zip(self.tree.bodies, q, strict=True)])
        pin.forwardKinematics(self.model, self.data, q, v, 0 * v)
        pin.computeJointJacobians(self.model, self.data)
        pin.updateFramePlacements(self.model, self.data)
        motions = [(self._motion(a), self._motion(b)) for a, b in self.points]
        closings = len(self.tree.closures)
        for s, (a, b) in zip(self.tree.springs, motions[closings:], strict=True):
            span, J = a[0] - b[0], a[1] - b[1]
            along = span / np.linalg.norm(span)
            pull = s.stiffness * (np.linalg.norm(span) - s.length) + s.damping * along @ J @ v
            force -= J.T @ along * pull
        rows, gamma = [np.zeros((0, len(q)))], []
        for c, (a, b), (_, second) in zip(self.tree.closures, motions[:closings], self.points, strict=False):
            axes = self.data.oMf[second].rotation.T[["xyz".index(r) for r in c.rows]]
            rows.append(axes @ (a[1] - b[1]))
            gamma += list(-axes @ (a[2] - b[2]))
        J = np.vstack(rows)
        whole = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
        # Least-norm solution: with redundant constraints lambda is not unique, but vdot is.
        solution: Array = np.linalg.lstsq(whole, np.concatenate([force, gamma]), rcond=1e-12)[0]
        return solution[: len(q)]


def readings(plant: gelenk.Simulation, tree: Tree, turning: str, sliding: str) -> Array:
    return np.array([plant.output(f"j_{b.name}.{sliding if b.slides else turning}") for b in tree.bodies])


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_at_the_start_and_later_are_pinocchios(name: str) -> None:
    tree = families.make(name)
    plant = gelenk.Simulation(to_scene(tree))
    torque = np.array([tree.torque(i, 0.0) for i in range(len(tree.bodies))])
    for signal in plant.inputs:
        (i,) = (i for i, b in enumerate(tree.bodies) if signal.name.startswith(f"m_{b.name}."))
        plant.set_input(signal.name, torque[i])
    plant.initialize(tolerance=1e-9)
    np.testing.assert_allclose(readings(plant, tree, "phi", "s"), [b.q for b in tree.bodies], atol=1e-12)
    np.testing.assert_allclose(readings(plant, tree, "w", "v"), [b.v for b in tree.bodies], atol=1e-12)
    reference = Reference(tree)
    for time in (0.0, tree.stop / 20):
        plant.step_to(time)
        q, v = readings(plant, tree, "phi", "s"), readings(plant, tree, "w", "v")
        expected = reference.accelerations(q, v, torque)
        found = readings(plant, tree, "a", "a")
        # Loops are closed to 1e-12, and accelerations of light parts lose digits to the forces of heavy ones.
        assert np.max(np.abs(found - expected)) <= 1e-9 * max(1.0, np.max(np.abs(expected)))


def test_the_text_for_other_programs_has_all_numbers() -> None:
    tree = families.make("stewart")
    first, *lines = to_text(tree).splitlines()
    assert first.split()[1:4] == [str(len(tree.bodies)), str(len(tree.closures)), str(len(tree.springs))]
    # Name, parent, kind; axis, position, R, mass, com, inertia; q, v, tau, sine, damping, spring.
    assert {len(line.split()) for line in lines[: len(tree.bodies)]} == {3 + 3 + 3 + 9 + 1 + 3 + 9 + 9}
    assert {len(line.split()) for line in lines[len(tree.bodies) :]} == {2 + 1 + 3 + 3}
