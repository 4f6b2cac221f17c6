# SPDX-License-Identifier: BSD-3-Clause
"""Gelenk, MuJoCo, Drake and EXUDYN on the problems, each with its own default and with tightened settings.

Gelenk has two schemes: steps with impulses, and located events, whose accuracy is a tolerance. All others
regularize contact: stiffness and the speed below which friction is viscous follow the step in the tightened
settings. Each runner is called with a step [s], or a tolerance; it returns the poses at the times of the
problem, shape (times, 7), and the CPU time.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from benchmarks.contacts.problems import GRAVITY, Array, Problem
from scipy.optimize import brentq

type Found = tuple[Array, float]
type Runner = Callable[[Problem, float], Found]

TINY = (
    1e-6  # m, radius of the spheres at the corners of boxes where an engine has one point per pair of shapes
)


class NotOfferedError(Exception):
    """The engine cannot describe the problem."""


def damping_ratio(restitution: float) -> float:
    """Return that of a spring and damper with a restitution, whose contact ends where the depth is zero."""
    e = math.log(restitution)
    return float(brentq(lambda d: -math.pi * d / math.sqrt(1 - d * d) - e, 0.0, 0.99))


def scene(problem: Problem, solver: dict[str, Any]) -> dict[str, Any]:
    """Return the problem as a scene of Gelenk."""
    p, Q = problem.start
    kind = {"sphere": problem.size[0]} if problem.is_ball else {"box": list(problem.size)}
    out: dict[str, Any] = {
        "gelenk": 1,
        "gravity": [0, 0, -GRAVITY],
        "bodies": {
            "b": {
                "mass": problem.mass,
                "inertia": list(problem.moments),
                "shapes": {"s": {**kind, "surface": "b"}},
            }
        },
        "ground": {"shapes": {"s": {"plane": problem.normal, "surface": "ground"}}},
        "joints": {
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "b",
                "start": {"r": p, "Q": Q, "v": list(problem.v), "w": list(problem.w), "fixed": True},
            }
        },
        "contacts": {
            "c": {
                "between": ["b", "ground"],
                "friction": problem.friction,
                "restitution": problem.restitution,
            }
        },
        "solver": solver,
    }
    if problem.force:
        push = {"type": "wrench", "body": "b", "position": list(problem.at), "force": [problem.force, 0, 0]}
        out["forces"] = {"push": push}
    return out


def gelenk_steps(problem: Problem, h: float) -> Found:
    return gelenk_run(problem, {"integrator": "moreau-jean", "step": h})


def gelenk_events(problem: Problem, tolerance: float) -> Found:
    return gelenk_run(problem, {"integrator": "erk"}, tolerance)


def gelenk_run(problem: Problem, solver: dict[str, Any], tolerance: float = 1e-6) -> Found:
    import gelenk

    plant = gelenk.Simulation(gelenk.load(scene(problem, solver)))
    plant.initialize(tolerance=tolerance)
    names = [f"J.r[{k}]" for k in (1, 2, 3)] + [f"J.Q[{k}]" for k in (1, 2, 3, 4)]
    found, begin = [], time.process_time()
    for t in problem.times:
        plant.step_to(t)
        found.append(plant.values(names))
    return np.array(found, float), time.process_time() - begin


def mujoco_text(problem: Problem, h: float, contact_steps: int) -> str:
    p, (x, y, z, w) = problem.start
    option, geom = "", ""
    if contact_steps:
        option = 'cone="elliptic" impratio="100" noslip_iterations="20" tolerance="1e-14" iterations="200"'
        solref = f"{contact_steps * h} 1"
        if problem.restitution:
            rate = 1 / (2 * contact_steps * h)  # 1/s, of the contact
            solref = f"{-(rate**2)} {-2 * damping_ratio(problem.restitution) * rate}"
        geom = f'solref="{solref}" solimp="0.9999 0.9999 0.001 0.5 2"'
    size = " ".join(str(x) for x in (problem.size if problem.is_ball else np.array(problem.size) / 2))
    moments = " ".join(map(str, problem.moments))
    kind = "sphere" if problem.is_ball else "box"
    friction = f'friction="{problem.friction} 0 0" condim="{3 if problem.friction else 1}" {geom}'
    # A force that is constant in the world, at a point of the body.
    at = " ".join(map(str, problem.at))
    actuator = (
        '<actuator><general site="at" refsite="world" gear="1 0 0 0 0 0" biastype="none"/></actuator>'
        if problem.force
        else ""
    )
    return (
        f'<mujoco><option timestep="{h}" gravity="0 0 {-GRAVITY}" {option}/><worldbody><site name="world"/>'
        f'<geom type="plane" size="100 100 1" quat="{w} {x} {y} {z}" {friction}/>'
        f'<body pos="{p[0]} {p[1]} {p[2]}" quat="{w} {x} {y} {z}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{problem.mass}" diaginertia="{moments}"/><site name="at" pos="{at}"/>'
        f'<geom type="{kind}" size="{size}" {friction}/></body></worldbody>{actuator}</mujoco>'
    )


def mujoco_run(problem: Problem, h: float, contact_steps: int = 0) -> Found:
    """Run MuJoCo; contact_steps: time constant of contacts in steps, 0 for all defaults."""
    mujoco: Any = importlib.import_module("mujoco")
    model = mujoco.MjModel.from_xml_string(mujoco_text(problem, h, contact_steps))
    data = mujoco.MjData(model)
    data.qvel[:] = [*problem.v, *problem.w]
    if problem.force:
        data.ctrl[0] = problem.force
    found, done, begin = [], 0, time.process_time()
    for t in problem.times:
        steps = round(t / h)
        mujoco.mj_step(model, data, steps - done)
        done = steps
        r, (w, x, y, z) = data.qpos[:3], data.qpos[3:]
        found.append([*r, x, y, z, w])
    return np.array(found), time.process_time() - begin


def drake_run(problem: Problem, h: float, solver: str, tight: bool) -> Found:
    if problem.restitution:
        raise NotOfferedError("no restitution")
    parts: Any = {
        name: importlib.import_module(f"pydrake.{name}")
        for name in ("geometry", "math", "multibody.math", "multibody.plant", "multibody.tree",
                     "systems.analysis", "systems.framework")
    }  # fmt: skip
    geometry, pose, plants, tree = (
        parts[name] for name in ("geometry", "math", "multibody.plant", "multibody.tree")
    )
    builder = parts["systems.framework"].DiagramBuilder()
    plant, _ = plants.AddMultibodyPlantSceneGraph(builder, h)
    plant.set_discrete_contact_approximation(getattr(plants.DiscreteContactApproximation, solver))
    plant.set_contact_model(plants.ContactModel.kPoint)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    law = geometry.ProximityProperties()
    friction = plants.CoulombFriction(problem.friction, problem.friction)
    if tight:  # the best of six settings: a depth of 1e-5 m under its weight
        geometry.AddContactMaterial(
            friction=friction, point_stiffness=problem.mass * GRAVITY / 1e-5, dissipation=20.0, properties=law
        )
        law.AddProperty("material", "relaxation_time", 2 * h)
        plant.set_stiction_tolerance(1e-5)
    else:
        geometry.AddContactMaterial(friction=friction, properties=law)
    p, (x, y, z, w) = problem.start
    tilted = pose.RigidTransform(pose.RotationMatrix(_quaternion(w, x, y, z)), np.zeros(3))
    plant.RegisterCollisionGeometry(plant.world_body(), tilted, geometry.HalfSpace(), "ground", law)
    inertia = tree.SpatialInertia(
        problem.mass, np.zeros(3), tree.UnitInertia(*(m / problem.mass for m in problem.moments))
    )
    body = plant.AddRigidBody("b", inertia)
    if problem.is_ball:
        plant.RegisterCollisionGeometry(
            body, pose.RigidTransform(), geometry.Sphere(problem.size[0]), "s", law
        )
    else:
        half = np.array(problem.size) / 2 - [0, 0, TINY]
        for k in range(8):
            corner = half * [(-1) ** (k >> i) for i in range(3)]
            sphere = geometry.Sphere(TINY)
            plant.RegisterCollisionGeometry(body, pose.RigidTransform(corner), sphere, f"s{k}", law)
    plant.Finalize()
    diagram = builder.Build()
    simulator = parts["systems.analysis"].Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    start = pose.RigidTransform(pose.RotationMatrix(_quaternion(w, x, y, z)), p)
    plant.SetFreeBodyPose(context, body, start)
    velocity = parts["multibody.math"].SpatialVelocity(np.array(problem.w), np.array(problem.v))
    plant.SetFreeBodySpatialVelocity(context, body, velocity)
    if problem.force:
        push = plants.ExternallyAppliedSpatialForce()
        push.body_index, push.p_BoBq_B = body.index(), np.array(problem.at)
        push.F_Bq_W = parts["multibody.math"].SpatialForce(np.zeros(3), np.array([problem.force, 0, 0]))
        plant.get_applied_spatial_force_input_port().FixValue(context, [push])
    simulator.Initialize()
    found, begin = [], time.process_time()
    for t in problem.times:
        simulator.AdvanceTo(t)
        X = plant.EvalBodyPoseInWorld(context, body)
        q = X.rotation().ToQuaternion()
        found.append([*X.translation(), q.x(), q.y(), q.z(), q.w()])
    return np.array(found), time.process_time() - begin


def _quaternion(w: float, x: float, y: float, z: float) -> Any:
    return importlib.import_module("pydrake.common.eigen_geometry").Quaternion(
        np.array([w, x, y, z]) / math.sqrt(w * w + x * x + y * y + z * z)
    )


def exudyn_run(problem: Problem, h: float, tight: bool) -> Found:
    """Balls only, on two large triangles, with the explicit scheme that EXUDYN recommends for contacts."""
    if not problem.is_ball:
        raise NotOfferedError("contacts of spheres and triangles only")
    exu: Any = importlib.import_module("exudyn")
    items: Any = importlib.import_module("exudyn.itemInterface")
    utilities: Any = importlib.import_module("exudyn.utilities")
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())
    p, _ = problem.start
    inertia = utilities.RigidBodyInertia(mass=problem.mass, inertiaTensor=np.diag(problem.moments))
    made = system.CreateRigidBody(
        inertia=inertia, referencePosition=p, initialVelocity=list(problem.v),
        initialAngularVelocity=list(problem.w), gravity=[0, 0, -GRAVITY], returnDict=True,
        nodeType=exu.NodeType.RotationRotationVector,
    )  # fmt: skip
    contact = system.AddGeneralContact()
    contact.SetFrictionPairings(np.array([[problem.friction]]))
    contact.SetFrictionProportionalZone(h if tight else 1e-3)
    contact.SetSearchTreeCellSize(numberOfCells=[2, 2, 2])
    contact.SetSearchTreeBox(pMin=np.array([-20.0] * 3), pMax=np.array([20.0] * 3))
    rate = 1 / (20 * h if tight else 1e-2)  # 1/s
    stiffness = problem.mass * rate**2
    ratio = damping_ratio(problem.restitution) if problem.restitution else 1.0
    damping = 2 * ratio * math.sqrt(stiffness * problem.mass)
    # Springs of both surfaces act in series; their dampers add up, as bounces with several values show.
    stiffness, damping = 2 * stiffness, damping / 2
    mark = system.AddMarker(items.MarkerNodeRigid(nodeNumber=made["nodeNumber"]))
    contact.AddSphereWithMarker(
        mark, radius=problem.size[0], contactStiffness=stiffness, contactDamping=damping,
        frictionMaterialIndex=0,
    )  # fmt: skip
    corners = [[-10.0, -10, 0], [10, -10, 0], [10, 10, 0], [-10, 10, 0]]
    still = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
    contact.AddTrianglesRigidBodyBased(
        rigidBodyMarkerIndex=still, contactStiffness=stiffness, contactDamping=damping,
        frictionMaterialIndex=0, pointList=corners, triangleList=[[0, 1, 2], [0, 2, 3]],
    )  # fmt: skip
    kind = exu.OutputVariableType.Position
    sensor = system.AddSensor(
        items.SensorBody(
            bodyNumber=made["bodyNumber"], storeInternal=True, writeToFile=False, outputVariableType=kind
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = problem.times[-1], round(problem.times[-1] / h)
    integration.verboseMode, integration.automaticStepSize = 0, False
    integration.explicitIntegration.computeEndOfStepAccelerations = False
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 0.05
    settings.displayStatistics = settings.displayComputationTime = False
    begin = time.process_time()
    system.SolveDynamic(
        settings, solverType=exu.DynamicSolverType.ExplicitMidpoint, showHints=False, showCausingItems=False
    )
    cpu = time.process_time() - begin
    rows = system.GetSensorStoredData(sensor)
    chosen = [int(np.argmin(np.abs(rows[:, 0] - t))) for t in problem.times]
    poses = np.zeros((len(chosen), 7))
    poses[:, :3] = rows[chosen, 1:4]
    return poses, cpu


def _with(run: Callable[..., Found], *settings: Any) -> Runner:
    return lambda problem, h: run(problem, h, *settings)


#: The series whose settings are tolerances.
EVENTS = "Gelenk, events"
#: By series: the package, and its runner.
SERIES: dict[str, tuple[str, Runner]] = {
    "Gelenk, steps": ("gelenk", gelenk_steps),
    EVENTS: ("gelenk", gelenk_events),
    "MuJoCo": ("mujoco", mujoco_run),
    "MuJoCo, contacts of 2 steps": ("mujoco", _with(mujoco_run, 2)),
    "MuJoCo, contacts of 10 steps": ("mujoco", _with(mujoco_run, 10)),
    "Drake SAP": ("pydrake", _with(drake_run, "kSap", False)),
    "Drake lagged": ("pydrake", _with(drake_run, "kLagged", False)),
    "Drake SAP, tightened": ("pydrake", _with(drake_run, "kSap", True)),
    "Drake lagged, tightened": ("pydrake", _with(drake_run, "kLagged", True)),
    "EXUDYN": ("exudyn", _with(exudyn_run, False)),
    "EXUDYN, tightened": ("exudyn", _with(exudyn_run, True)),
}
