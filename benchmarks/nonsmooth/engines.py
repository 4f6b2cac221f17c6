# SPDX-License-Identifier: BSD-3-Clause
"""Other engines on the pendulum and the four-bar: packages, if they are installed, and cited figures.

Both regularize: MuJoCo friction and limits as soft constraints, EXUDYN friction as a proportional zone,
limits as springs. Stiffness and zone follow the step; several ratios were tried, the better ones are kept.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from benchmarks.nonsmooth import laws, problems
from benchmarks.nonsmooth.problems import COUPLER, CRANK, GRAVITY, ROCKER, Problem
from benchmarks.nonsmooth.runs import Run, error_of
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]
STEPS = (1e-3, 1e-4, 1e-5)  # s
MOMENT = problems.PENDULUM_MOMENT + problems.PENDULUM_MASS * problems.PENDULUM_LENGTH**2

# MuJoCo 4.0.0 and EXUDYN 1.13.6, measured before with default settings and with the best of four to six
# tightened ones: error, CPU time.
CITED = {
    "pendulum": [("MuJoCo", 8.1e-2, 0.062), ("EXUDYN", 3.6e-2, 0.0036)],
    "four_bar": [("MuJoCo", 1.35, 0.0014), ("MuJoCo", 2.1e-2, 0.31), ("EXUDYN", 1.6e-3, 0.018),
                 ("EXUDYN", 3.8e-6, 1.0)],
}  # fmt: skip


def damping_ratio() -> float:
    """Return the ratio for the restitution of the pendulum, of contacts that end where the depth is zero."""
    e = math.log(problems.RESTITUTION)
    return float(brentq(lambda d: -math.pi * d / math.sqrt(1 - d * d) - e, 0.0, 0.9))


def start() -> tuple[Array, Array]:
    """Return angles and speeds of crank, coupler and rocker from the horizontal."""
    psi, rho, k2, k3, _, _ = laws.ratios(math.pi / 2)
    return np.array([math.pi / 2, psi, rho]), problems.FOUR_BAR_SPEED * np.array([1.0, k2, k3])


def mujoco_model(problem: Problem, h: float) -> tuple[Any, Any]:
    mujoco: Any = importlib.import_module("mujoco")
    inside = '"0.9999 0.9999 0.001 0.5 2"'
    head = f'<mujoco><compiler angle="radian"/><option timestep="{h}" gravity="0 0 {-GRAVITY}"'
    if problem.name == "pendulum":
        rate = 1 / (20 * h)  # 1/s, of the contact
        text = (
            f'{head}/><worldbody><body><joint type="hinge" axis="0 -1 0" limited="true" '
            f'range="{problems.PENDULUM_LIMIT} 100" solimplimit={inside} '
            f'solreflimit="{-(rate**2)} {-2 * damping_ratio() * rate}"/>'
            f'<inertial pos="0 0 {-problems.PENDULUM_LENGTH}" mass="{problems.PENDULUM_MASS}" '
            f'diaginertia="0.02 0.02 0.02"/></body></worldbody></mujoco>'
        )
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        data.qpos[0] = 1.5
        return model, data

    def hinge(k: int) -> str:
        return (
            f'<joint type="hinge" axis="0 -1 0" frictionloss="{problems.FOUR_BAR_FRICTION[k]}" '
            f'solreffriction="{2 * h} 1" solimpfriction={inside}/>'
        )

    def rod(length: float) -> str:
        across = 2 * length**3 / 12
        return (
            f'<inertial pos="{length / 2} 0 0" mass="{2 * length}" diaginertia="{across} {across} {across}"/>'
        )

    # A light last body is welded to the ground: the joint D.
    text = (
        f'{head} integrator="implicitfast" tolerance="1e-14"/><worldbody><body>{hinge(0)}{rod(CRANK)}'
        f'<body pos="{CRANK} 0 0">{hinge(1)}{rod(COUPLER)}<body pos="{COUPLER} 0 0">{hinge(2)}{rod(ROCKER)}'
        f'<body pos="{ROCKER} 0 0">{hinge(3)}<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-6 1e-6 1e-6"/>'
        f'<site name="end"/></body></body></body></body><site name="D" pos="{problems.GROUND} 0 0"/>'
        "</worldbody>"
        f'<equality><weld site1="end" site2="D" solref="{2 * h} 1" solimp={inside}/></equality></mujoco>'
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    (phi, psi, rho), (w1, w2, w3) = start()
    back = rho + math.pi  # the rocker points from C to D
    data.qpos[:] = [phi, psi - phi, back - psi, -back]
    data.qvel[:] = [w1, w2 - w1, w3 - w2, -w3]
    return model, data


def mujoco_run(problem: Problem, h: float) -> tuple[list[float], float]:
    """Return the angles at the reference times and the CPU time."""
    mujoco: Any = importlib.import_module("mujoco")
    model, data = mujoco_model(problem, h)
    found, done, begin = [], 0, time.process_time()
    for t in problem.times:
        steps = round(t / h)
        mujoco.mj_step(model, data, steps - done)
        found.append(float(data.qpos[0]))
        done = steps
    return found, time.process_time() - begin


def exudyn_bar(
    system: Any, items: Any, mass: float, inertia: float, place: Array, velocity: Array
) -> tuple[int, int]:
    """Add a planar body at x, y, angle and return its node and its number."""
    node = system.AddNode(
        items.NodeRigidBody2D(
            referenceCoordinates=[0, 0, 0], initialCoordinates=list(place), initialVelocities=list(velocity)
        )
    )
    body = system.AddObject(
        items.ObjectRigidBody2D(physicsMass=mass, physicsInertia=inertia, nodeNumber=node)
    )
    marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
    system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[0, -GRAVITY, 0]))
    return node, body


def exudyn_run(problem: Problem, h: float) -> tuple[list[float], float]:
    """Return the angles at the reference times and the CPU time."""
    exu: Any = importlib.import_module("exudyn")
    items: Any = importlib.import_module("exudyn.itemInterface")
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())
    fixed = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )

    def hinge(first: tuple[int, float], second: tuple[int, float]) -> None:
        ends = [
            system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0, 0]))
            for body, x in (first, second)
        ]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))

    def angle(node: int) -> int:
        return int(system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2)))

    connector = items.ObjectConnectorCoordinateSpringDamperExt
    if problem.name == "pendulum":
        # The angle of the line to the center of mass from the x axis is 1.5 - pi/2 at the start.
        place = np.array([0.0, 0.0, 1.5 - math.pi / 2])
        place[:2] = problems.PENDULUM_LENGTH * np.array([math.cos(place[2]), math.sin(place[2])])
        mass, moment = problems.PENDULUM_MASS, problems.PENDULUM_MOMENT
        node, body = exudyn_bar(system, items, mass, moment, place, np.zeros(3))
        hinge((ground, 0.0), (body, -problems.PENDULUM_LENGTH))
        data = system.AddNode(items.NodeGenericData(initialCoordinates=[0, 0, 0], numberOfDataCoordinates=3))
        stiffness = MOMENT / (20 * h) ** 2
        system.AddObject(connector(
            markerNumbers=[fixed, angle(node)], nodeNumber=data, useLimitStops=True,
            limitStopsLower=problems.PENDULUM_LIMIT - math.pi / 2, limitStopsUpper=100.0,
            limitStopsStiffness=stiffness,
            limitStopsDamping=2 * damping_ratio() * math.sqrt(stiffness * MOMENT),
        ))  # fmt: skip
        nodes, offset = [node], math.pi / 2
    else:
        nodes, offset = four_bar_in_exudyn(system, items, hinge, ground), 0.0
        turns = [fixed, *(angle(node) for node in nodes), fixed]
        pairs = [(turns[0], turns[1]), (turns[1], turns[2]), (turns[2], turns[3]), (turns[4], turns[3])]
        for pair, torque in zip(pairs, problems.FOUR_BAR_FRICTION, strict=True):
            system.AddObject(
                connector(markerNumbers=list(pair), fDynamicFriction=torque, frictionProportionalZone=h)
            )
    kind = exu.OutputVariableType.Coordinates
    sensor = system.AddSensor(
        items.SensorNode(nodeNumber=nodes[0], storeInternal=True, writeToFile=False, outputVariableType=kind)
    )
    system.Assemble()
    cpu = solved(exu, system, problem.times[-1], h)
    found = system.GetSensorStoredData(sensor)
    rows = [int(np.argmin(np.abs(found[:, 0] - t))) for t in problem.times]
    return [float(found[row, 3]) + offset for row in rows], cpu


def four_bar_in_exudyn(system: Any, items: Any, hinge: Callable[..., None], ground: int) -> list[int]:
    """Add bars and hinges; return the nodes of the bars."""
    angles, speeds = start()
    tip = CRANK * np.array([math.cos(angles[0]), math.sin(angles[0])])
    tip_speed = speeds[0] * CRANK * np.array([-math.sin(angles[0]), math.cos(angles[0])])
    bars = [
        (CRANK, np.zeros(2), np.zeros(2)),
        (COUPLER, tip, tip_speed),
        (ROCKER, np.array([problems.GROUND, 0]), np.zeros(2)),
    ]
    nodes, bodies = [], []
    for (length, foot, moving), phi, w in zip(bars, angles, speeds, strict=True):
        along = length / 2 * np.array([math.cos(phi), math.sin(phi)])
        turning = w * np.array([-along[1], along[0]])
        place, velocity = np.append(foot + along, phi), np.append(moving + turning, w)
        node, body = exudyn_bar(system, items, 2 * length, 2 * length**3 / 12, place, velocity)
        nodes.append(node)
        bodies.append(body)
    a, b, c = bodies
    hinge((ground, 0.0), (a, -CRANK / 2))
    hinge((a, CRANK / 2), (b, -COUPLER / 2))
    hinge((b, COUPLER / 2), (c, ROCKER / 2))
    hinge((ground, problems.GROUND), (c, -ROCKER / 2))
    return nodes


def solved(exu: Any, system: Any, stop: float, h: float) -> float:
    """Run with the generalized-alpha method and return the CPU time."""
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps, integration.verboseMode = stop, round(stop / h), 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 0.1
    settings.displayStatistics = settings.displayComputationTime = False
    settings.linearSolverType = exu.LinearSolverType.EigenDense
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-10
    integration.newton.useModifiedNewton = True
    integration.generalizedAlpha.spectralRadius = 0.9
    integration.generalizedAlpha.computeInitialAccelerations = True
    integration.automaticStepSize = False
    begin = time.process_time()
    system.SolveDynamic(settings, showHints=False, showCausingItems=False)
    return time.process_time() - begin


ENGINES: dict[str, Callable[[Problem, float], tuple[list[float], float]]] = {
    "MuJoCo": mujoco_run,
    "EXUDYN": exudyn_run,
}


def engines(problem: Problem, quick: bool) -> list[Run]:
    """Return the cited figures, and the runs of the engines that are installed."""
    found = [
        Run(problem.name, "cited", name, math.nan, error, cpu)
        for name, error, cpu in CITED.get(problem.name, [])
    ]
    if problem.name not in CITED:
        return found
    span = problem.times[-1]
    for name, runner in ENGINES.items():
        if importlib.util.find_spec(name.lower()) is None:
            continue
        for h in STEPS[:1] if quick else STEPS:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)
                try:
                    angles, cpu = runner(problem, h)
                except (RuntimeError, ValueError) as reason:
                    found.append(Run(problem.name, "engine", name, h, reason=str(reason)))
                    continue
            found.append(
                Run(problem.name, "engine", name, h, error_of(problem, {"A.phi": angles}), cpu / span)
            )
    return found
