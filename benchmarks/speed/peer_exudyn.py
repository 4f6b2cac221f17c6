# SPDX-License-Identifier: BSD-3-Clause
"""Exudyn: the tree in joint coordinates, loops closed by point joints."""

from __future__ import annotations

import contextlib
import io
import time
from typing import Any

import exudyn as exu
import numpy as np
from benchmarks.speed import peer
from benchmarks.speed.tree import Array, Tree
from exudyn import itemInterface as items  # noqa: N813

TURNS = (exu.JointType.RevoluteX, exu.JointType.RevoluteY, exu.JointType.RevoluteZ)
SLIDES = (exu.JointType.PrismaticX, exu.JointType.PrismaticY, exu.JointType.PrismaticZ)
SOLVERS = {
    "GenAlpha": exu.DynamicSolverType.GeneralizedAlpha,
    "RK44": exu.DynamicSolverType.RK44,
    "Euler": exu.DynamicSolverType.ExplicitEuler,
}


def turned_to(axis: Any) -> tuple[int, Array]:
    """Return the index of the nearest axis x, y or z, the only ones in Exudyn, and the rotation that takes it
    onto `axis`.
    """
    a = np.asarray(axis, float)
    k = int(np.argmax(np.abs(a)))
    e = np.eye(3)[k]
    if np.allclose(a, e):
        return k, np.eye(3)
    v, c = np.cross(e, a), float(e @ a)
    if c < -1 + 1e-12:  # rotation by pi about another axis
        return k, np.diag([1.0 if i == (k + 1) % 3 else -1.0 for i in range(3)])
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return k, np.eye(3) + K + K @ K / (1 + c)


class Model:
    """A mechanism assembled at its start. motors: the torques are the mechanism's sines; otherwise they are
    constant.
    """

    def __init__(self, tree: Tree, motors: bool = True) -> None:
        self.tree = tree
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.turns = [turned_to(b.axis) for b in tree.bodies]
        n = len(tree.bodies)
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * n,
                initialCoordinates=[b.q for b in tree.bodies],
                initialCoordinates_t=[b.v for b in tree.bodies],
                numberOfODE2Coordinates=n,
            )
        )
        self.object = self.system.AddObject(
            items.ObjectKinematicTree(nodeNumber=node, **self._fields(motors))
        )
        self._add_rest()
        kinds = exu.OutputVariableType.Coordinates
        self.sensor = self.system.AddSensor(
            items.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kinds)
        )
        self.system.Assemble()

    def _fields(self, motors: bool) -> dict[str, Any]:
        bodies, A = self.tree.bodies, [A for _, A in self.turns]
        before = [np.eye(3) if b.parent < 0 else A[b.parent] for b in bodies]
        numbered = list(enumerate(bodies))
        fields: dict[str, Any] = {
            "jointTypes": [
                (SLIDES if b.slides else TURNS)[k] for b, (k, _) in zip(bodies, self.turns, strict=True)
            ],
            "linkParents": [b.parent for b in bodies],
            "jointTransformations": exu.Matrix3DList([before[i].T @ b.R @ A[i] for i, b in numbered]),
            "jointOffsets": exu.Vector3DList(
                [before[i].T @ np.asarray(b.position, float) for i, b in numbered]
            ),
            "linkInertiasCOM": exu.Matrix3DList(
                [A[i].T @ np.asarray(b.inertia, float) @ A[i] for i, b in numbered]
            ),
            "linkCOMs": exu.Vector3DList([A[i].T @ np.asarray(b.com, float) for i, b in numbered]),
            "linkMasses": [float(b.mass) for b in bodies],
            "baseOffset": [0.0, 0.0, 0.0],
            "gravity": [float(x) for x in self.tree.gravity],
        }
        if any(b.damping or b.stiffness for b in bodies):
            fields |= {
                "jointPControlVector": [b.stiffness for b in bodies],
                "jointDControlVector": [b.damping for b in bodies],
                "jointPositionOffsetVector": [b.reference for b in bodies],
                "jointVelocityOffsetVector": [0.0] * len(bodies),
            }
        if motors and any(b.amplitude for b in bodies):
            fields["forceUserFunction"] = self._sines()
        else:
            fields["jointForceVector"] = [b.tau for b in bodies]
        return fields

    def _sines(self) -> Any:
        names = ("tau", "amplitude", "omega", "phase")
        tau, size, omega, phase = (np.array([getattr(b, n) for b in self.tree.bodies]) for n in names)
        return lambda _mbs, t, _i, _q, _v: tau + size * np.sin(omega * t + phase)

    def _marker(self, body: int, at: Any) -> int:
        if body < 0:
            ground = self.system.AddObject(items.ObjectGround())
            place = [float(x) for x in at]
            return int(self.system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=place)))
        own = self.turns[body][1].T @ np.asarray(at, float)
        link = items.MarkerKinematicTreeRigid(objectNumber=self.object, linkNumber=body, localPosition=own)
        return int(self.system.AddMarker(link))

    def _add_rest(self) -> None:
        for c in self.tree.closures:
            ends = [self._marker(c.first, c.at_first), self._marker(c.second, c.at_second)]
            rows = [int(axis in c.rows) for axis in "xyz"]
            self.system.AddObject(items.ObjectJointSpherical(markerNumbers=ends, constrainedAxes=rows))
        for s in self.tree.springs:
            ends = [self._marker(s.first, s.at_first), self._marker(s.second, s.at_second)]
            self.system.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=ends, stiffness=s.stiffness, damping=s.damping, referenceLength=s.length
                )
            )

    def solve(self, settings: Any, method: str, **more: Any) -> float:
        """Run and return the processor time [s]. Exudyn's exceptions are passed on."""
        with contextlib.redirect_stdout(io.StringIO()):
            begin = time.process_time()
            self.system.SolveDynamic(
                settings, solverType=SOLVERS[method], showHints=False, showCausingItems=False, **more
            )
            return time.process_time() - begin

    def samples(self) -> peer.Samples:
        """Return the joint coordinates at the samples; fewer if the run ended early."""
        data = self.system.GetSensorStoredData(self.sensor)
        out = []
        for k in range(round(self.tree.stop / self.tree.sample) + 1):
            i = int(np.argmin(np.abs(data[:, 0] - k * self.tree.sample)))
            if abs(data[i, 0] - k * self.tree.sample) < 1e-6:
                out.append([float(x) for x in data[i, 1:]])
        return out


def settings(stop: float, sample: float, step: float) -> Any:
    found = exu.SimulationSettings()
    time_integration = found.timeIntegration
    time_integration.endTime = stop
    time_integration.numberOfSteps = max(1, round(stop / step))
    time_integration.verboseMode = 0
    found.solutionSettings.writeSolutionToFile = False
    found.solutionSettings.sensorsWritePeriod = sample
    found.displayStatistics = found.displayComputationTime = False
    found.linearSolverType = exu.LinearSolverType.EigenDense
    found.linearSolverSettings.ignoreSingularJacobian = True
    time_integration.newton.relativeTolerance = 1e-10
    time_integration.newton.absoluteTolerance = 1e-9
    time_integration.newton.useModifiedNewton = True
    time_integration.generalizedAlpha.spectralRadius = 0.95
    time_integration.generalizedAlpha.computeInitialAccelerations = True
    time_integration.automaticStepSize = False
    return found


def forward(tree: Tree) -> None:
    """Time a step of explicit Euler or, with loops, of generalized-alpha: a run of many steps minus a run of
    one.
    """
    method = "GenAlpha" if tree.closures else "Euler"
    calls = max(20, min(500, 2000 // len(tree.bodies)))

    def once() -> float:
        many = Model(tree).solve(settings(1e-6 * calls, 1.0, 1e-6), method)
        return (many - Model(tree).solve(settings(1e-6, 1.0, 1e-6), method)) / (calls - 1)

    peer.print_time(tree.name, f"{method} step", peer.least(once, 3))


def step(tree: Tree) -> None:
    """Time a step of 1 ms with a new torque before each, set by the pre-step user function."""
    method = "GenAlpha" if tree.closures else "RK44"
    torques = peer.torques(tree, peer.ROUNDS + 1).tolist()
    end: list[float] = []

    def once() -> float:
        model = Model(tree, motors=False)

        def before(mbs: Any, t: float) -> bool:
            # t is the end of the next step.
            now = min(peer.ROUNDS, max(0, round(1000 * t) - 1))
            mbs.SetObjectParameter(model.object, "jointForceVector", torques[now])
            return True

        model.system.SetPreStepUserFunction(before)
        stop = 1e-3 * peer.ROUNDS
        taken = model.solve(settings(stop, stop, 1e-3), method) / peer.ROUNDS
        end[:] = [float(x) for x in model.system.GetSensorStoredData(model.sensor)[-1, 1:]]
        return taken

    peer.print_time(tree.name, method, peer.least(once, 3), end)


def run(tree: Tree, method: str, setting: float) -> None:
    def once() -> peer.Run:
        model = Model(tree)
        cpu = model.solve(settings(tree.stop, tree.sample, setting), method)
        samples = model.samples()
        return cpu, samples, len(samples) == round(tree.stop / tree.sample) + 1

    peer.print_fastest(tree, method, setting, once, 2)


if __name__ == "__main__":
    peer.main(forward, step, run)
