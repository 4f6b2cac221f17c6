# SPDX-License-Identifier: BSD-3-Clause
"""Spatial linkages of the gallery: closed-form kinematics, forces by virtual work, a published motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from benchmarks.gallery import TILTING
from mechanisms import GRAVITY, Array, Scene, rotation
from models.bricard import P3
from models.meeting import angle_to_distance, turned
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import gelenk
from gallery.entries import assert_stated, file, position, ran, source, vectors, written

CLOSED = 1e-9  # m, rad: loops are closed to 1e-10 m, magnified by the angles between the links
Z = [0.0, 0.0, 1.0]


def orientations(run: gelenk.Result, name: str) -> Array:
    """Rotation matrices of a frame over time, shape (times, 3, 3)."""
    Q = np.array([run[f"{name}[{i}]"] for i in (1, 2, 3, 4)]).T  # scalar part last, as in SciPy
    out: Array = Rotation.from_quat(Q).as_matrix()
    return out


def test_bennett() -> None:
    """Bennett 1903: opposite angles are equal and tan(A/2) tan(B/2) is constant."""
    scene, run = source("bennett"), ran("bennett")
    a, b = position(scene, "B", "parent")[0], position(scene, "C", "parent")[0]
    alpha, beta = math.pi / 6, math.asin(0.8)
    assert a / math.sin(alpha) == pytest.approx(b / math.sin(beta), rel=1e-12)
    product = np.tan(run["A.phi"] / 2) * np.tan(run["B.phi"] / 2)
    constant = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
    # Where one of the factors passes a pole, the errors of the angles are magnified.
    tame = np.abs(np.log(np.abs(np.tan(run["A.phi"] / 2)))) < 3
    assert tame.mean() > 0.9
    np.testing.assert_allclose(product[tame], constant, rtol=1e-7)  # CLOSED times exp(3) and more
    np.testing.assert_allclose(np.cos(run["A.phi"]), np.cos(run["C.phi"]), rtol=0, atol=CLOSED)
    np.testing.assert_allclose(np.cos(run["B.phi"]), np.cos(run["D.phi"]), rtol=0, atol=CLOSED)
    plant = gelenk.Simulation(source("bennett"))
    plant.initialize()
    assert (plant.size.constraint_equations, plant.size.rank) == (5, 3)  # without the driven hinge
    assert_stated("bennett", constant, "")


def test_bricard() -> None:
    """An independent integration that agrees with the plot of the benchmark; eight digits."""
    run = ran("bricard")
    found = vectors(run, "P3.r")
    for time, expected in P3.items():
        k = int(np.argmin(np.abs(run.time - time)))
        if abs(run.time[k] - time) < 1e-9:
            # 100 tolerances of the scene; eight printed digits
            np.testing.assert_allclose(found[k], expected, rtol=0, atol=1e-7)
    assert_stated("bricard", P3[1.0][0], "m")


def test_stewart() -> None:
    """Lengths of the legs by inverse kinematics; the platform sinks to the least potential energy."""
    scene, run = written("stewart"), gelenk.simulate(file("stewart"), inputs=TILTING)
    r, R = vectors(run, "pose.r"), orientations(run, "pose.Q")
    center = np.array(scene["bodies"]["platform"]["pose"]["position"])
    for leg in range(1, 7):
        base, ball = (np.array(scene["joints"][f"{n}{leg}"]["at"]["position"]) for n in ("base", "ball"))
        length = np.linalg.norm(r + R @ (ball - center) - base, axis=1)
        # Directions of the legs have four digits: they miss the balls by up to e = 1e-4 rad, the lengths by
        # the travel (0.14 m) times e2 / 2 = 7e-10 m.
        np.testing.assert_allclose(
            length, run[f"leg{leg}.s"] + np.linalg.norm(ball - base), rtol=0, atol=CLOSED
        )
    found = gelenk.equilibrium(file("stewart"))
    reach = math.hypot(*(np.array([0.9848, -0.1736]) - [0.3214, -0.383]))

    def pull(z: float) -> float:  # dV/dz of platform, legs and springs
        rise = z / math.hypot(reach, z)
        stretched = math.hypot(reach, z) - math.hypot(reach, 1.1)
        by_rise = reach**2 / math.hypot(reach, z) ** 3
        legs = 6 * (5 * 0.3 * by_rise + 3 * (1 - 0.3 * by_rise))
        return GRAVITY * (20 + legs) + 6 * 5e3 * stretched * rise

    height = brentq(pull, 0.9, 1.1, xtol=1e-14)
    # Positions have four digits: half a unit of the last one, and as much from the other end of the leg.
    shorter = math.hypot(reach, height) - math.hypot(reach, 1.1)
    assert found.values["leg1.s"] == pytest.approx(shorter, abs=1e-4)
    assert_stated("stewart", 1000 * (1.1 - height), "mm")


def delta_arms(p: Array) -> list[tuple[Array, Array]]:
    """Position of the middle of the platform [m] in the planes of the three arms, and these planes' axes."""
    frames = [rotation(Z, angle).T for angle in (0.0, math.tau / 3, -math.tau / 3)]
    return [(R @ p, R) for R in frames]


def delta_angles(p: Array) -> list[float]:
    """Return the angles of the arms [rad] at a position of the platform: elbows are 0.7 m from the balls."""
    out = []
    for q, _ in delta_arms(p):
        x, y, z = q[0] + 0.06 - 0.2, q[1], q[2]
        # 0.6 (x c - z s) = x2 + y2 + z2 + 0.09 - 0.49, of which the elbow outside is wanted
        c = (x * x + y * y + z * z + 0.09 - 0.49) / 0.6
        out.append(math.atan2(-z, x) - math.acos(c / math.hypot(x, z)))
    return out


@warned.GUESSES
def test_delta_robot() -> None:
    """Inverse kinematics in closed form; torques that hold the arms by virtual work."""
    run = ran("delta_robot")
    r = vectors(run, "pose.r")
    for k in range(0, len(run.time), 20):
        found = [run[f"motor{i}.phi"][k] for i in (1, 2, 3)]
        assert found == pytest.approx(delta_angles(r[k]), abs=1e-8)  # positions of joints have ten digits
    np.testing.assert_allclose(
        orientations(run, "pose.Q"), np.broadcast_to(np.eye(3), (len(r), 3, 3)), atol=1e-8
    )
    scene = source("delta_robot")
    angles = (0.2, 0.5, 0.7)
    for drive, angle in zip(scene["constraints"].values(), angles, strict=True):
        drive["polynomial"] = [angle]
        del drive["sine"]
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    p = np.array([plant.output(f"pose.r[{i}]") for i in (1, 2, 3)])
    # Each pair of rods: (elbow - ball) . (d elbow - dp) = 0; half of its weight acts at either end.
    J, by_angle = np.zeros((3, 3)), np.zeros(3)
    for k, ((q, R), angle) in enumerate(zip(delta_arms(p), angles, strict=True)):
        elbow = np.array([0.2 + 0.3 * math.cos(angle), 0.0, -0.3 * math.sin(angle)])
        moved = np.array([-0.3 * math.sin(angle), 0.0, -0.3 * math.cos(angle)])
        rod = elbow - q - [0.06, 0.0, 0.0]
        J[k], by_angle[k] = rod @ R, rod @ moved
    fall = np.linalg.solve(J, np.diag(by_angle))[2]  # dz/dangle
    at_elbow, at_platform = 0.5 / 2 + 2 * 0.06 / 2, 0.6 + 6 * 0.06 / 2  # kg
    torques = GRAVITY * (at_platform * fall - at_elbow * 0.3 * np.cos(angles))
    found = [plant.output(f"drive{i}.tau") for i in (1, 2, 3)]
    assert found == pytest.approx(torques, rel=1e-7)  # ten digits
    assert_stated("delta_robot", torques[0], "N m")


def wishbone_carrier(scene: Scene, angle: float) -> tuple[Array, Array, Array]:
    """Lower and upper ball joint [m] and rotation of the wheel carrier at an angle of the lower wishbone:
    each next point is on a circle, at a known distance from the one before.
    """
    at = {name: np.array(joint["at"]["position"]) for name, joint in scene["joints"].items()}
    axis = {name: scene["joints"][f"{name}_pivot"]["axis"] for name in ("lower", "upper")}
    lower0, upper0, tie0 = at["lower_ball"], at["upper_ball"], at["tie_ball"]
    lower = turned(lower0, at["lower_pivot"], axis["lower"], angle)
    height = float(np.linalg.norm(upper0 - lower0))
    upper = turned(upper0, at["upper_pivot"], axis["upper"],
                   angle_to_distance(upper0, at["upper_pivot"], axis["upper"], lower, height))  # fmt: skip
    # First turn the line of the ball joints, then about it.
    before, after = (upper0 - lower0) / height, (upper - lower) / height
    across = np.cross(before, after)
    sine = float(np.linalg.norm(across))
    R = rotation(across, math.atan2(sine, before @ after)) if sine > 0 else np.eye(3)
    tie = lower + R @ (tie0 - lower0)
    length = float(np.linalg.norm(tie0 - at["rack_end"]))
    return lower, upper, rotation(after, angle_to_distance(tie, lower, after, at["rack_end"], length)) @ R


def test_double_wishbone() -> None:
    """Camber and toe over the travel of the wheel by compasses; wheel load by virtual work."""
    scene, run = written("double_wishbone"), ran("double_wishbone")
    R, hub = orientations(run, "carrier.Q"), vectors(run, "carrier.r")
    ball = np.array(scene["joints"]["lower_ball"]["at"]["position"])
    carrier = np.array(scene["bodies"]["knuckle"]["pose"]["position"])
    for k in range(0, len(run.time), 10):
        lower, _, expected = wishbone_carrier(scene, run["lower_pivot.phi"][k])
        np.testing.assert_allclose(R[k], expected, rtol=0, atol=CLOSED)
        np.testing.assert_allclose(hub[k], lower + expected @ (carrier - ball), rtol=0, atol=CLOSED)
    camber = np.degrees(np.arcsin(R[:, 2, 1]))  # of the axle, positive if the wheel leans inwards at its top
    highest = int(np.argmax(run["jack.s"]))
    assert run["jack.s"][highest] == pytest.approx(0.07, abs=1e-12)
    assert_stated("double_wishbone", camber[highest], "degrees")


def wishbone_statics(scene: Scene, angle: float) -> tuple[float, float]:
    """Height of the point of contact [m] and potential energy [J] at an angle of the lower wishbone."""
    at = {name: np.array(joint["at"]["position"]) for name, joint in scene["joints"].items()}
    body = scene["bodies"]
    lower, upper, R = wishbone_carrier(scene, angle)

    def carried(p: Array) -> Array:
        out: Array = lower + R @ (p - at["lower_ball"])
        return out

    def turned_with_lower(p: list[float]) -> Array:
        place = at["lower_pivot"]
        return turned(place + p, place, scene["joints"]["lower_pivot"]["axis"], angle)

    hub, tie = carried(at["hub"]), carried(at["tie_ball"])
    axle = R[2, 1]
    contact = hub[2] - 0.3 * math.sqrt(1 - axle * axle)
    # The center of the upper wishbone is between its axis and the foot of the normal from its ball joint.
    n = np.array(scene["joints"]["upper_pivot"]["axis"]) / np.linalg.norm(
        scene["joints"]["upper_pivot"]["axis"]
    )
    place = at["upper_pivot"]
    swing = angle_to_distance(at["upper_ball"], place, n, lower, float(np.linalg.norm(upper - lower)))
    com = turned(place + body["upper"]["com"], place, n, swing)
    moment = body["upper"]["mass"] * com[2] + body["wheel"]["mass"] * hub[2]
    moment += body["lower"]["mass"] * turned_with_lower(body["lower"]["com"])[2]
    moment += body["knuckle"]["mass"] * carried(np.array(body["knuckle"]["pose"]["position"]))[2]
    moment += body["tie_rod"]["mass"] * (tie + at["rack_end"])[2] / 2
    spring = scene["forces"]["spring"]
    length = np.linalg.norm(turned_with_lower(spring["to"]["position"]) - spring["from"]["position"])
    return contact, GRAVITY * moment + 0.5 * spring["stiffness"] * (length - spring["length"]) ** 2


def test_double_wishbone_at_rest() -> None:
    """The load of the wheel is dV/dz: by central differences over the angle of the lower wishbone."""
    scene = source("double_wishbone")
    scene["constraints"]["road"] = {"type": "motion", "joint": "jack", "polynomial": [0.0]}
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    angle, step = plant.output("lower_pivot.phi"), 6e-6  # rad: cube root of the rounding error
    up, down = (wishbone_statics(written("double_wishbone"), angle + sign * step) for sign in (1, -1))
    load = (up[1] - down[1]) / (up[0] - down[0])
    assert plant.output("contact.f_n") == pytest.approx(load, rel=1e-7)  # rounding of 1e3 J over the step
    assert_stated("double_wishbone", load / 1000, "kN")
