# SPDX-License-Identifier: BSD-3-Clause
"""Planar linkages of the gallery: positions by circles that meet, forces by virtual work."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Array, Scene, four_bar_angles
from models.meeting import meet

import gelenk
from gallery.entries import assert_stated, position, ran, source, vectors

CLOSED = 1e-9  # m, rad: loops are closed to 1e-10 m, magnified by the angles between the links
XZ = [0, 2]  # the vertical plane


def unit(phi: float) -> Array:
    return np.array([math.cos(phi), math.sin(phi)])


def bearing(p: Array) -> float:
    """The angle of a vector from x."""
    return math.atan2(p[1], p[0])


def test_four_bar() -> None:
    """Triangles give the rocker for each angle of the crank (Freudenstein)."""
    run = ran("four_bar")
    angles = [four_bar_angles(phi, (0.5, 1.75, 1.5, 2.0))[1] for phi in run["A.phi"][::50]]
    np.testing.assert_allclose(run["D.phi"][::50], angles, rtol=0, atol=CLOSED)
    assert_stated("four_bar", math.degrees(angles[0]), "degrees")
    # Freudenstein's equation: d/a cos r - d/c cos a + (a2 - b2 + c2 + d2)/(2 a c) = cos(a - r)
    a, b, c, d = 0.5, 1.75, 1.5, 2.0
    crank, rocker = run["A.phi"], run["D.phi"]
    left = d / a * np.cos(rocker) - d / c * np.cos(crank) + (a * a - b * b + c * c + d * d) / (2 * a * c)
    np.testing.assert_allclose(left, np.cos(crank - rocker), rtol=0, atol=10 * CLOSED)  # coefficients up to 4


@warned.STILL
def test_five_bar() -> None:
    """The tool is where circles about the elbows meet."""
    run = ran("five_bar")
    hand = vectors(run, "hand.r")[:, :2]
    for k in range(0, len(run.time), 100):
        elbows = [
            np.array([x, 0.0]) + 0.25 * unit(run[f"{side}.phi"][k])
            for side, x in (("left", -0.15), ("right", 0.15))
        ]
        np.testing.assert_allclose(hand[k], meet(elbows[0], 0.35, elbows[1], 0.35, 1), rtol=0, atol=CLOSED)
    assert_stated("five_bar", hand[0, 1], "m")


def test_slider_crank() -> None:
    """Position of the piston s = r cos + sqrt(l2 - r2 sin2); torque that holds it, by virtual work."""
    r, rod = 0.3, 0.9
    run = ran("slider_crank")
    phi = run["main.phi"]
    root = np.sqrt(rod**2 - (r * np.sin(phi)) ** 2)
    np.testing.assert_allclose(run["cylinder.s"], r * np.cos(phi) + root, rtol=0, atol=CLOSED)
    held = gelenk.equilibrium(
        source("slider_crank"),
        hold={"main.phi": 0.7},
        solve_for="starter.tau",
        input_values={"gas.f[1]": -1000.0},
    )
    sine, cosine = math.sin(0.7), math.cos(0.7)
    travel = -r * sine - r * r * sine * cosine / math.sqrt(rod**2 - (r * sine) ** 2)  # ds/dphi
    # The crank's center is at half of its length, and so is the rod's: its pin at the piston does not rise.
    weight = GRAVITY * (1.0 * 0.15 + 2.0 * 0.15) * cosine
    torque = (1000 * travel + weight) / 5
    assert held.inputs["starter.tau"] == pytest.approx(torque, rel=1e-9)  # Newton's method has converged
    assert_stated("slider_crank", torque, "N m")


# Lengths of Theo Jansen's leg in centimeters, as published by him (The Great Pretender, 2007).
JANSEN = {"a": 38, "b": 41.5, "c": 39.3, "d": 40.1, "e": 55.8, "f": 39.4, "g": 36.7, "h": 65.7, "i": 49,
          "j": 50, "k": 61.9, "l": 7.8, "m": 15}  # fmt: skip


def jansen_foot(crank: float) -> Array:
    """The foot [m] relative to the shaft of the crank, from the published lengths alone."""
    a, b, c, d, e, f, g, h, i, j, k, low, m = (x / 100 for x in JANSEN.values())
    B, C = np.array([-a, -low]), m * unit(crank)
    P1, P2 = meet(B, b, C, j, 1), meet(B, c, C, k, -1)
    P3 = meet(B, d, P1, e, 1)
    P4 = meet(P3, f, P2, g, -1)
    return meet(P4, h, P2, i, -1)


def test_jansen_leg() -> None:
    run = ran("jansen_leg")
    foot = vectors(run, "tip.r")[:, XZ]
    expected = np.array([jansen_foot(-math.pi * t) for t in run.time])
    np.testing.assert_allclose(foot, expected, rtol=0, atol=1e-8)  # the scene has lengths to 1 nm
    on_ground = foot[foot[:, 1] < foot[:, 1].min() + 0.01]
    assert_stated("jansen_leg", float(np.ptp(on_ground[:, 0])), "m")
    assert_stated("jansen_leg", float(np.ptp(foot[:, 0])), "m")


def test_windscreen_wiper() -> None:
    """Both arms by circles that meet; the wipe by the law of cosines, with crank and link in line."""
    scene, run = source("windscreen_wiper"), ran("windscreen_wiper")
    left, right = (position(scene, f"{side}_pivot", "parent")[:2] for side in ("left", "right"))
    pin = position(scene, "link_pin", "child")[:2]
    right_pin = position(scene, "tie_right", "child")[:2]
    for k in range(0, len(run.time), 20):
        at = meet(0.045 * unit(run["O.phi"][k]), 0.285, left, math.hypot(*pin), -1)
        other = meet(at, 0.6, right, math.hypot(*right_pin), 1)
        for side, pivot, end, own in (("left", left, at, pin), ("right", right, other, right_pin)):
            found = math.remainder(
                run[f"{side}_pivot.phi"][k] - bearing(end - pivot) + bearing(own), math.tau
            )
            assert found == pytest.approx(0, abs=CLOSED)
    ground, rocker = math.hypot(*left), math.hypot(*pin)
    ends = [math.acos((ground**2 + rocker**2 - reach**2) / (2 * ground * rocker)) for reach in (0.24, 0.33)]
    swept = np.ptp(run["left_pivot.phi"])
    # The nearest of 200 outputs a turn misses either end by up to 0.016 rad of the crank, from which the arm
    # has turned by half of its second derivative (below 2 at these lengths) times the square, 2.5e-4 rad.
    assert swept == pytest.approx(ends[1] - ends[0], abs=5e-4)
    assert_stated("windscreen_wiper", math.degrees(ends[1] - ends[0]), "degrees")


def excavator_pins(scene: Scene, boom: float, stick: float, bucket: float) -> dict[str, Array]:
    """Pins [m] in the vertical plane, by the angles of boom, stick and bucket from the horizontal [rad]."""

    def on(origin: Array, angle: float, p: Array) -> Array:
        x, _, z = p
        out: Array = origin + x * unit(angle) + z * unit(angle + math.pi / 2)
        return out

    A = position(scene, "A", "parent")[XZ]
    B = on(A, boom, position(scene, "B", "parent"))
    C = on(B, stick, position(scene, "C", "parent"))
    out = {"B": B, "C": C, "boom": A}
    out["boom_foot"] = position(scene, "boom_foot", "parent")[XZ]
    out["boom_eye"] = on(A, boom, position(scene, "boom_eye", "child"))
    out["stick_foot"] = on(A, boom, position(scene, "stick_foot", "parent"))
    out["stick_eye"] = on(B, stick, position(scene, "stick_eye", "child"))
    out["bucket_foot"] = on(B, stick, position(scene, "bucket_foot", "parent"))
    out["rocker_foot"] = on(B, stick, position(scene, "rocker_foot", "parent"))
    out["link_end"] = on(C, bucket, position(scene, "link_bucket", "child"))
    out["bucket_eye"] = meet(out["rocker_foot"], 0.62, out["link_end"], 0.58, 1)
    for name, origin, angle in (("boom", A, boom), ("stick", B, stick), ("bucket", C, bucket)):
        out[f"{name}_com"] = on(origin, angle, np.array(scene["bodies"][name]["com"]))
    out["teeth"] = on(C, bucket, position(scene, "edge", "parent"))
    return out


def excavator_energy(scene: Scene, q: Array) -> tuple[Array, float]:
    """Lengths of the three cylinders [m] and potential energy [J]."""
    pins = excavator_pins(scene, q[0], q[0] + q[1], q[0] + q[1] + q[2])
    mass = {name: body["mass"] for name, body in scene["bodies"].items()}
    com = {name: body["com"][0] for name, body in scene["bodies"].items()}
    moment = sum(mass[n] * pins[f"{n}_com"][1] for n in ("boom", "stick", "bucket"))
    moment += mass["teeth"] * pins["teeth"][1]
    lengths = []
    for name in ("boom", "stick", "bucket"):
        foot, eye = pins[f"{name}_foot"], pins[f"{name}_eye"]
        length = math.hypot(*(eye - foot))
        for part, share in (("barrel", com[f"{name}_barrel"]), ("rod", length + com[f"{name}_rod"])):
            moment += mass[f"{name}_{part}"] * (foot + (eye - foot) * share / length)[1]
        lengths.append(length)
    for name, foot, eye in (
        ("rocker", pins["rocker_foot"], pins["bucket_eye"]), ("link", pins["bucket_eye"], pins["link_end"])
    ):  # fmt: skip
        moment += mass[name] * (foot + eye)[1] / 2
    return np.array(lengths), GRAVITY * moment


def test_excavator() -> None:
    """Forces of the cylinders that hold the first pose: dV/dq = J^T f, J = dL/dq, by central differences."""
    scene = source("excavator")
    for name in ("boom", "stick", "bucket"):
        motion = scene["constraints"][name]
        motion["polynomial"] = [motion.pop("table")["value"][0]]
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    q = np.array([plant.output(f"{joint}.phi") for joint in "ABC"])
    lengths, _ = excavator_energy(scene, q)
    rods = [1.6, 1.7, 1.35]
    strokes = [plant.output(f"{name}_cylinder.s") for name in ("boom", "stick", "bucket")]
    np.testing.assert_allclose(lengths, np.add(strokes, rods), rtol=0, atol=CLOSED)
    step = 6e-6  # rad: cube root of the rounding error
    sides = [[excavator_energy(scene, q + sign * step * e) for sign in (1, -1)] for e in np.eye(3)]
    J = np.array([(up[0] - down[0]) / (2 * step) for up, down in sides])
    by_angle = np.array([(up[1] - down[1]) / (2 * step) for up, down in sides])
    forces = np.linalg.solve(J, by_angle)
    found = [plant.output(f"{name}.f") for name in ("boom", "stick", "bucket")]
    np.testing.assert_allclose(found, forces, rtol=1e-8)  # rounding of 1e5 J over the step: 2e-6 N m
    assert_stated("excavator", forces[0] / 1000, "kN")
