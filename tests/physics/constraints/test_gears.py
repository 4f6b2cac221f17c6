# SPDX-License-Identifier: BSD-3-Clause
"""Gears and racks in shafts, planetary gears, differentials and linkages, against Lagrange's equations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, reaction, scene
from models.driven import Array, run
from models.geared_five_bar import five_bar, five_bar_bodies
from models.one_dof import OneDofMechanism
from models.running import assert_close, started
from scipy.integrate import solve_ivp

ABOUT_Z: dict[str, Any] = {"axis": [0, 0, 1]}
EXACT = 1e-12  # rounding of accelerations in closed form


def disc(mass: float, moment: float) -> dict[str, Any]:
    return body(mass, (0, 0, 0), (moment / 2, moment / 2, moment))


def shafts(ratio: float, offset: float = 0.0, **fields: Any) -> Scene:
    """Two geared wheels of 0.5 and 0.2 kg m2 in bearings on the ground, with a motor each."""
    return scene(
        {"a": disc(3.0, 0.5), "b": disc(2.0, 0.2)},
        {
            "A": joint("revolute", frame("ground"), frame("a"), **ABOUT_Z),
            "B": joint("revolute", frame("ground", (0.4, 0, 0)), frame("b"), **ABOUT_Z, **fields),
        },
        motors={"left": {"joint": "A"}, "right": {"joint": "B"}},
        constraints={"mesh": {"type": "gear", "joint": "A", "with": "B", "ratio": ratio, "offset": offset}},
        sensors={"at_A": reaction("A"), "at_B": reaction("B"), "meter": {"type": "energy"}},
    )


@pytest.mark.parametrize("ratio", [-2.5, 0.4, 1.0, -1.0, 40.0])
def test_two_shafts_move_as_one_with_the_effective_inertia(ratio: float) -> None:
    """(I_b + n^2 I_a) b'' = tau_b + n tau_a; the mesh torque follows from the balance of the first shaft."""
    plant = started(shafts(ratio), left__tau=0.7, right__tau=-0.3)
    b = (-0.3 + ratio * 0.7) / (0.2 + ratio**2 * 0.5)
    assert_close("B.a", plant.output("B.a"), b, EXACT, "closed form")
    assert_close("A.a", plant.output("A.a"), ratio * b, EXACT, "closed form")
    mesh = 0.5 * ratio * b - 0.7
    assert_close("mesh", plant.output("mesh.tau"), mesh, EXACT, "closed form")
    # Reaction sensors measure all torques in the joint, including those of mesh and motor.
    assert_close("at A", plant.output("at_A.t[3]"), mesh + 0.7, EXACT, "all that turns a")
    assert_close("at B", plant.output("at_B.t[3]"), 0.2 * b, EXACT, "all that turns b")
    plant.step_to(2.0)
    for name, expected in (("phi", 2 * b), ("w", 2 * b)):
        assert_close(name, plant.output(f"B.{name}"), expected, 1e-6, "the tolerance, ten times")
        assert_close(name, plant.output(f"A.{name}"), ratio * plant.output(f"B.{name}"), 1e-12, "rounding")


def test_offset_is_the_first_angle_when_the_second_is_zero() -> None:
    source = shafts(-3.0, 0.6)
    source["joints"]["B"]["start"] = {"phi": 0.25, "w": 1.5, "fixed": True}
    plant = started(source)
    assert plant.output("A.phi") == pytest.approx(0.6 - 3.0 * 0.25, abs=1e-13)
    assert plant.output("A.w") == pytest.approx(-4.5, abs=1e-13)


def test_gear_conserves_energy_and_counts_revolutions() -> None:
    source = shafts(-7.0)
    source["joints"]["B"] |= {"stiffness": 12.0, "start": {"phi": 4.0, "fixed": True}}
    found = run(source, np.linspace(0, 20, 201), 1e-10)
    assert np.abs(found["A.phi"]).max() > 27.9
    assert_close("ratio", found["A.phi"], -7.0 * found["B.phi"], 1e-12 * 28, "rounding")
    assert_close("energy", found["meter.total"], 12.0 * 16 / 2, 1e-6, "of 96 J, tolerance 1e-10 over 20 s")


# A planetary gear: numbers of teeth; moments of inertia; mass of the planet and its distance from the axis.
SUN, PLANET, RING = 24, 18, 60
I_SUN, I_ARM, I_RING, I_PLANET, M_PLANET, ARM = 0.02, 0.05, 0.3, 0.004, 0.6, 0.21


def planetary(ring: bool = True) -> Scene:
    """A planetary gear whose planet is on the arm and all other wheels on the ground, with Willis' equations:

    (sun - arm) Z_S = -planet Z_P and (ring - arm) Z_R = planet Z_P, the planet's angle against the arm.
    """
    out = scene(
        {
            "sun": disc(1.0, I_SUN),
            "arm": disc(1.5, I_ARM),
            "planet": disc(M_PLANET, I_PLANET),
            "ring": disc(2.0, I_RING),
        },
        {
            "S": joint("revolute", frame("ground"), frame("sun"), **ABOUT_Z),
            "C": joint("revolute", frame("ground"), frame("arm"), **ABOUT_Z),
            "P": joint("revolute", frame("arm", (ARM, 0, 0)), frame("planet"), **ABOUT_Z),
            "R": joint("revolute", frame("ground"), frame("ring"), **ABOUT_Z),
        },
        motors={"at_sun": {"joint": "S"}, "at_arm": {"joint": "C"}, "at_ring": {"joint": "R"}},
    )
    out["constraints"] = {
        "outer": {"type": "gear", "joint": "S", "with": "P", "carrier": "C", "ratio": -PLANET / SUN},
        "inner": {"type": "gear", "joint": "R", "with": "P", "carrier": "C", "ratio": PLANET / RING},
    }
    if not ring:
        out["constraints"]["held"] = {"type": "motion", "joint": "R", "polynomial": [0.3]}
    return out


def inertias(rows: Array) -> Array:
    """M for the velocities of sun and arm; `rows` gives those of sun, arm, ring and planet (absolute)."""
    moments = np.diag([I_SUN, I_ARM + M_PLANET * ARM**2, I_RING, I_PLANET])
    out: Array = rows.T @ moments @ rows
    return out


def test_planetary_gear_follows_willis_and_lagrange_equations() -> None:
    """Two degrees of freedom, sun and arm. Absolute velocity of the planet: arm - (sun - arm) Z_S / Z_P."""
    n, m = SUN / PLANET, SUN / RING
    rows = np.array([[1, 0], [0, 1], [-m, 1 + m], [-n, 1 + n]])
    forces = np.array([0.8, -0.5]) + np.array([-m, 1 + m]) * 0.3
    sun, arm = np.linalg.solve(inertias(rows), forces)
    plant = started(planetary(), at_sun__tau=0.8, at_arm__tau=-0.5, at_ring__tau=0.3)
    expected = {"S.a": sun, "C.a": arm, "R.a": rows[2] @ [sun, arm], "P.a": rows[3] @ [sun, arm] - arm}
    for name, value in expected.items():
        assert_close(name, plant.output(name), value, 1e-11, "of 30, rounding")
    # Torques of the meshes, from the balance of ring and sun.
    ring = I_RING * expected["R.a"] - 0.3
    assert_close("inner", plant.output("inner.tau"), ring, 1e-11, "the ring's balance")
    assert_close("outer", plant.output("outer.tau"), I_SUN * sun - 0.8, 1e-11, "the sun's balance")
    assert len(plant.independent_coordinates) == 2
    plant.step_to(1.0)
    w = {name: plant.output(f"{name}.w") for name in "SCPR"}
    assert w["S"] - w["C"] == pytest.approx(-(RING / SUN) * (w["R"] - w["C"]), abs=1e-12)


def test_planetary_gear_with_held_ring_has_the_classical_ratio() -> None:
    """One degree of freedom is left, with the ratio 1 + Z_R / Z_S."""
    n, total = SUN / PLANET, 1 + RING / SUN
    rows = np.array([[1], [1 / total], [0], [1 / total - n * (1 - 1 / total)]])
    plant = started(planetary(ring=False), at_sun__tau=0.8, at_arm__tau=-0.5)
    sun = (0.8 - 0.5 / total) / inertias(rows)[0, 0]
    assert_close("S.a", plant.output("S.a"), sun, 1e-11, "of 30, rounding")
    assert_close("C.a", plant.output("C.a"), sun / total, 1e-11, "of 10, rounding")
    assert plant.output("R.phi") == pytest.approx(0.3, abs=1e-13)


def test_angles_of_wheels_on_the_ground_are_relative_to_the_carrier() -> None:
    """Sun and ring without a planet, as an ideal planetary gear: (sun - arm) = -Z_R / Z_S (ring - arm)."""
    source = planetary()
    del source["bodies"]["planet"], source["joints"]["P"]
    source["constraints"] = {
        "train": {"type": "gear", "joint": "S", "with": "R", "carrier": "C", "ratio": -RING / SUN}
    }
    m = SUN / RING
    rows = np.array([[1, 0], [0, 1], [-m, 1 + m]])
    M = rows.T @ np.diag([I_SUN, I_ARM, I_RING]) @ rows
    sun, arm = np.linalg.solve(M, [0.8, -0.5])
    plant = started(source, at_sun__tau=0.8, at_arm__tau=-0.5)
    assert_close("S.a", plant.output("S.a"), sun, 1e-11, "of 30, rounding")
    assert_close("C.a", plant.output("C.a"), arm, 1e-11, "of 10, rounding")


def test_gear_between_two_wheels_on_a_swinging_arm() -> None:
    """A pendulum arm that carries two geared wheels: their absolute velocities are arm + wheel."""
    arm_moment, wheel, other, ratio = 0.4, 0.03, 0.01, -3.0
    source = scene(
        {
            "arm": body(2.0, (0.3, 0, 0), (arm_moment, arm_moment, arm_moment)),
            "a": disc(0.5, wheel),
            "b": disc(0.2, other),
        },
        {
            "C": joint(
                "revolute", frame("ground"), frame("arm"), **ABOUT_Z, start={"phi": 0.4, "fixed": True}
            ),
            "A": joint("revolute", frame("arm", (0.5, 0, 0)), frame("a"), **ABOUT_Z),
            "B": joint("revolute", frame("arm", (0.7, 0, 0)), frame("b"), **ABOUT_Z),
        },
        gravity=[0, -GRAVITY, 0],
        motors={"drive": {"joint": "B"}},
        constraints={"mesh": {"type": "gear", "joint": "A", "with": "B", "ratio": ratio}},
    )
    total = arm_moment + 2.0 * 0.09 + 0.5 * 0.25 + 0.2 * 0.49 + wheel + other
    coupled = ratio * wheel + other
    M = np.array([[total, coupled], [coupled, ratio**2 * wheel + other]])
    weight = -GRAVITY * math.cos(0.4) * (2.0 * 0.3 + 0.5 * 0.5 + 0.2 * 0.7)
    arm, b = np.linalg.solve(M, [weight, 0.6])
    plant = started(source, drive__tau=0.6)
    assert_close("C.a", plant.output("C.a"), arm, 1e-11, "of 10, rounding")
    assert_close("B.a", plant.output("B.a"), b, 1e-11, "of 10, rounding")


def test_differential_shares_torque_evenly() -> None:
    """2 cage = left + right: the differential of an axle is a gear of ratio -1 with the cage as carrier."""
    source = scene(
        {"cage": disc(1.0, 0.02), "left": disc(4.0, 0.5), "right": disc(4.0, 0.8)},
        {
            "K": joint("revolute", frame("ground"), frame("cage"), axis=[0, 1, 0]),
            "L": joint("revolute", frame("ground", (0, 0.7, 0)), frame("left"), axis=[0, 1, 0]),
            "R": joint("revolute", frame("ground", (0, -0.7, 0)), frame("right"), axis=[0, 1, 0]),
        },
        motors={"engine": {"joint": "K"}, "brake": {"joint": "L"}},
        constraints={"bevel": {"type": "gear", "joint": "L", "with": "R", "carrier": "K", "ratio": -1}},
    )
    # The discs' moments about y are half of those about z.
    moments = np.diag([0.02, 0.5, 0.8]) / 2
    rows = np.array([[0.5, 0.5], [1, 0], [0, 1]])
    left, right = np.linalg.solve(rows.T @ moments @ rows, rows.T @ [5.0, -1.0, 0.0])
    plant = started(source, engine__tau=5.0, brake__tau=-1.0)
    assert_close("L.a", plant.output("L.a"), left, 1e-11, "of 10, rounding")
    assert_close("R.a", plant.output("R.a"), right, 1e-11, "of 10, rounding")
    share = plant.output("bevel.tau")
    assert_close("on the left", moments[1, 1] * left + 1.0, share, 1e-11, "the wheel's balance")
    assert_close("on the right", moments[2, 2] * right, share, 1e-11, "as much")
    assert_close("on the cage", moments[0, 0] * plant.output("K.a"), 5.0 - 2 * share, 1e-11, "both")


@pytest.mark.parametrize("radius", [0.05, -0.05])
def test_falling_rack_rotates_its_pinion(radius: float) -> None:
    """It falls at g / (1 + I / (m r^2)), as in ADAMS' RackPinion; the teeth carry the rest of its weight."""
    mass, moment = 0.8, 3e-3
    source = scene(
        {"rack": body(mass), "wheel": disc(1.0, moment)},
        {
            "slide": joint("prismatic", frame("ground"), frame("rack"), axis=[0, -1, 0]),
            "hinge": joint("revolute", frame("ground", (0.05, 0, 0)), frame("wheel"), **ABOUT_Z),
        },
        gravity=[0, -GRAVITY, 0],
        constraints={
            "teeth": {"type": "rack", "rack": "slide", "pinion": "hinge", "radius": radius, "offset": 0.1}
        },
    )
    fall = GRAVITY / (1 + moment / (mass * radius**2))
    plant = started(source)
    assert plant.output("slide.s") - radius * plant.output("hinge.phi") == pytest.approx(0.1, abs=1e-14)
    assert_close("slide.a", plant.output("slide.a"), fall, EXACT, "closed form")
    assert_close("hinge.a", plant.output("hinge.a"), fall / radius, 1e-10, "of 100, rounding")
    assert_close("teeth.f", plant.output("teeth.f"), mass * (fall - GRAVITY), EXACT, "closed form")
    start = plant.output("slide.s")
    plant.step_to(1.0)
    assert_close("slide.s", plant.output("slide.s") - start, fall / 2, 1e-6, "the tolerance, ten times")


def test_pinion_on_a_carriage_that_is_driven_along_its_rack() -> None:
    """A wheel rolls on a rack that is at rest, while the carriage of the pinion moves: r phi = -s."""
    mass, moment, radius = 1.2, 2e-3, 0.04
    source = scene(
        {"cart": body(mass), "wheel": disc(0.3, moment)},
        {
            "slide": joint("prismatic", frame("ground"), frame("cart"), axis=[1, 0, 0], stiffness=30.0,
                           start={"s": 0.2, "v": 0.0, "fixed": True}),
            "hinge": joint("revolute", frame("cart"), frame("wheel"), **ABOUT_Z),
        },
        constraints={"teeth": {"type": "rack", "rack": "slide", "pinion": "hinge", "radius": -radius}},
    )  # fmt: skip
    omega = math.sqrt(30.0 / (mass + 0.3 + moment / radius**2))
    times = np.linspace(0, 3, 31)
    found = run(source, times, 1e-10)
    assert_close("slide.s", found["slide.s"], 0.2 * np.cos(omega * times), 1e-8, "100 times the tolerance")
    assert_close("hinge.phi", found["hinge.phi"], -found["slide.s"] / radius, 1e-12, "rounding")


@pytest.mark.parametrize(("ratio", "offset"), [(-1.0, math.pi), (-2.0, 2.0), (1.0, 0.3)])
def test_geared_five_bar_matches_its_reduced_equation_of_motion(ratio: float, offset: float) -> None:
    times = np.linspace(0, 2, 41)
    phi, w = OneDofMechanism(five_bar_bodies(ratio, offset), (0, -GRAVITY, 0)).motion(1.9, 0.0, times)
    found = run(five_bar(1.9, ratio, offset), times, 1e-11)
    assert_close("A.phi", found["A.phi"], phi, 1e-8, "errors of both runs, 2 s")
    assert_close("A.w", found["A.w"], w, 1e-7, "errors of both runs, 2 s")
    assert_close("E.phi", found["E.phi"], ratio * found["A.phi"] + offset, 1e-12 * 30, "rounding")


def three_shafts(last: float) -> Scene:
    """Gears between A and B, B and C, C and A: a ring, which is closed by the ratio `last`."""
    out = shafts(-2.0)
    out["bodies"]["c"] = disc(1.0, 0.1)
    out["joints"]["C"] = joint("revolute", frame("ground", (0.8, 0, 0)), frame("c"), **ABOUT_Z)
    out["constraints"] |= {
        "next": {"type": "gear", "joint": "B", "with": "C", "ratio": 1.5},
        "last": {"type": "gear", "joint": "C", "with": "A", "ratio": last},
    }
    return out


def test_consistent_ring_of_gears_rotates() -> None:
    """A = -2 B, B = 1.5 C, hence C = -A / 3: the third constraint is redundant; meshes share the torque."""
    plant = started(three_shafts(-1 / 3), left__tau=0.7)
    moment = 0.5 + 0.2 / 4 + 0.1 / 9
    assert_close("A.a", plant.output("A.a"), 0.7 / moment, EXACT, "closed form")
    assert plant.independent_speeds == ("A.w",) or len(plant.independent_speeds) == 1
    # However the torque is shared, the balance of each wheel holds: that of C with two meshes.
    on_c = plant.output("last.tau") - 1.5 * plant.output("next.tau")
    assert_close("C", 0.1 * plant.output("C.a"), on_c, 1e-12, "the wheel's balance")
    plant.step_to(3.0)
    assert_close("A.w", plant.output("A.w"), 0.7 / moment * 3, 1e-6, "the tolerance, ten times")
    assert plant.diagnostics["constraints.position"] < 1e-12


def test_inconsistent_ring_of_gears_locks() -> None:
    """Only zero velocity is possible: the teeth bear the torque of the motor."""
    plant = started(three_shafts(1 / 3), left__tau=0.7)
    assert plant.size.degrees_of_freedom == 0
    for name in "ABC":
        assert plant.output(f"{name}.a") == pytest.approx(0, abs=1e-13)
    held = plant.output("mesh.tau") - plant.output("last.tau") / 3
    assert held == pytest.approx(-0.7, abs=1e-12)
    plant.step_to(1.0)
    assert plant.output("A.phi") == pytest.approx(0, abs=1e-12)


def test_gear_and_prescribed_motion_drive_the_other_shaft() -> None:
    """The torque of the motion accelerates both: (I_a + I_b / n^2) a'' - tau_b / n."""
    source = shafts(-2.5)
    source["constraints"]["turn"] = {
        "type": "motion",
        "joint": "A",
        "sine": {"amplitude": 0.5, "frequency": 0.4},
    }
    times = np.linspace(0, 3, 31)
    found = run(source, times, 1e-9)
    omega = 2 * math.pi * 0.4
    a = -0.5 * omega**2 * np.sin(omega * times)
    assert_close("turn.tau", found["turn.tau"], (0.5 + 0.2 / 6.25) * a, 1e-12, "rounding")
    assert_close("mesh.tau", found["mesh.tau"], -0.2 / 6.25 * a, 1e-12, "rounding")
    assert_close("B.phi", found["B.phi"], found["A.phi"] / -2.5, 1e-13, "rounding")


def test_pendulum_that_drives_a_flywheel_through_gears() -> None:
    """A long run, compared with SciPy: (I + m l^2 + n^2 J) phi'' = -m g l sin phi - d phi'."""
    moment, mass, reach, wheel, ratio = 0.02, 1.0, 0.4, 0.004, 6.0
    source = scene(
        {"rod": body(mass, (0, -reach, 0), (moment, 0, moment)), "wheel": disc(0.5, wheel)},
        {
            "P": joint("revolute", frame("ground"), frame("rod"), **ABOUT_Z, damping=0.01,
                       start={"phi": 2.5, "w": 0.0, "fixed": True}),
            "W": joint("revolute", frame("ground", (0.2, 0, 0)), frame("wheel"), **ABOUT_Z, damping=0.0005),
        },
        gravity=[0, -GRAVITY, 0],
        constraints={"train": {"type": "gear", "joint": "W", "with": "P", "ratio": ratio}},
    )  # fmt: skip
    inertia, loss = moment + mass * reach**2 + ratio**2 * wheel, 0.01 + ratio**2 * 0.0005

    def rates(_t: float, x: Array) -> list[float]:
        return [x[1], (-mass * GRAVITY * reach * math.sin(x[0]) - loss * x[1]) / inertia]

    times = np.linspace(0, 10, 101)
    truth = solve_ivp(rates, (0, 10), [2.5, 0.0], "DOP853", times, rtol=1e-12, atol=1e-13).y
    found = run(source, times, 1e-11)
    assert_close("P.phi", found["P.phi"], truth[0], 1e-9, "errors of both runs")
    assert_close("W.w", found["W.w"], ratio * truth[1], 1e-8, "errors of both runs")
