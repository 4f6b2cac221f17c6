# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of the gallery that touch things."""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import brentq

import gelenk

from .entries import assert_stated, file, source
from .test_planar_linkages import excavator_energy, excavator_pins


def test_gripper_presses_with_the_torque_over_the_length_of_its_arms() -> None:
    """Virtual work with vertical arms: 2 tau = 2 F L. Friction carries the weight m g."""
    torque = 0.8
    run = gelenk.simulate(file("gripper"), inputs={"grip1.tau": torque, "grip2.tau": torque})
    scene = source("gripper")
    arm = -scene["joints"]["tip1"]["parent"]["position"][2]
    weight = scene["bodies"]["box"]["mass"] * 9.81
    assert run["left.f[1]"][-1] == pytest.approx(torque / arm, rel=1e-8)
    assert run["right.f[1]"][-1] == pytest.approx(-torque / arm, rel=1e-8)
    # Means over the last step, which ends at 1.8 s, of m (g + a) with the palm at 0.05 (1 - cos(pi t)) m.
    acceleration = 0.05 * pi**2 * cos(pi * (1.8 - 0.5e-3))
    carried = run["left.f[3]"][-1] + run["right.f[3]"][-1]
    assert carried == pytest.approx(weight * (1 + acceleration / 9.81), rel=1e-6)
    assert_stated("gripper", torque / arm, "N")
    assert_stated("gripper", weight, "N")
    assert_stated("gripper", 1e3 * run["lift.s"].max(), "mm")


def test_cam_lifts_off_where_the_spring_cannot_hold_the_follower() -> None:
    """While they touch, the follower is at e sin(phi), and the force is m (g + a) + F + k s.

    It vanishes first near the top, at speeds above sqrt((m g + F + k e) / (m e)).
    """
    scene = source("cam")
    mass = scene["bodies"]["follower"]["mass"]
    eccentricity = scene["bodies"]["cam"]["shapes"]["ball"]["position"][0]
    stiffness = scene["joints"]["guide"]["stiffness"]
    preload = -stiffness * scene["joints"]["guide"]["spring_reference"]
    _, speed, half_rate = scene["constraints"]["drive"]["polynomial"]
    run = gelenk.simulate(scene)

    def force(t: float) -> float:
        phi, w = speed * t + half_rate * t * t, speed + 2 * half_rate * t
        s = eccentricity * sin(phi)
        a = eccentricity * (2 * half_rate * cos(phi) - w * w * sin(phi))
        return float(mass * (9.81 + a) + preload + stiffness * s)

    times = np.linspace(0, 1, 100_001)  # s; a turn takes 40 ms
    later = int(np.argmax([force(t) < 0 for t in times]))
    lift_off = brentq(force, times[later - 1], times[later], xtol=1e-15)
    found = next(time for time, text in run.events if text == "contact: cam leaves follower")
    assert found == pytest.approx(lift_off, abs=1e-9)  # the tolerance of the run is 1e-8
    limit = sqrt((mass * 9.81 + preload + stiffness * eccentricity) / (mass * eccentricity))
    assert speed + 2 * half_rate * lift_off > limit
    assert_stated("cam", limit, "rad/s")
    assert_stated("cam", 1e3 * lift_off, "ms")


@pytest.mark.parametrize("integrator", ["erk", "cvode"])
@pytest.mark.parametrize("step", [0.02, 0.005])
def test_cam_lifts_off_within_a_long_step(integrator: str, step: float) -> None:
    """A step of erk from 0.773 to 0.78 s would contain the first lift-off and the return of the force."""
    scene = source("cam")
    scene["solver"] = {"integrator": integrator}
    fine = gelenk.simulate(source("cam"), stop=0.9).events
    run = gelenk.simulate(scene, stop=0.9, step=step)
    assert [text for _, text in run.events] == [text for _, text in fine]
    # Both runs are within 100 times the tolerance, 1e-8; an impact multiplies errors by some tens.
    assert [t for t, _ in run.events] == pytest.approx([t for t, _ in fine], abs=1e-6)


@pytest.mark.parametrize(("part", "leaves"), [(0.999, False), (1.001, True)])
def test_cam_at_constant_speed(part: float, leaves: bool) -> None:
    """Just below the speed of lift-off the follower stays on the cam, just above it leaves."""
    scene = source("cam")
    speed = part * sqrt((0.2 * 9.81 + 20 + 2000 * 0.01) / (0.2 * 0.01))
    scene["constraints"]["drive"]["polynomial"] = [0, speed]
    scene["joints"]["shaft"]["start"]["w"] = speed
    scene["joints"]["guide"]["start"]["v"] = 0.01 * speed
    run = gelenk.simulate(scene, stop=0.2)
    assert any("leaves" in text for _, text in run.events) == leaves


def test_ratchet_is_caught_with_the_tip_between_two_teeth() -> None:
    """Where the tip touches both teeth follows from the triangle of axle, pivot and tip.

    The forces follow from the moments about axle and pivot.
    """
    scene = source("ratchet")
    load = 0.1  # N m
    run = gelenk.simulate(scene, inputs={"load.tau": -load})
    side, radius, pitch = 0.04, 0.003, pi / 6
    face = side * tan(pitch)  # where a tooth ends, along its back
    tip = scene["bodies"]["pawl"]["shapes"]["tip"]["position"]
    arm = np.array([tip[0], tip[2]])
    pivot = np.array(scene["joints"]["pivot"]["parent"]["position"])[[0, 2]]
    spring = scene["joints"]["pivot"]
    # In the axes of the tooth under the tip; the next one is turned by the pitch.
    x = side + radius
    z = (sin(pitch) * x - face - radius) / cos(pitch)
    at, far, length = hypot(x, z), hypot(*pivot), hypot(*arm)
    angle = atan2(pivot[1], pivot[0]) + acos((at**2 + far**2 - length**2) / (2 * at * far))
    place = at * np.array([cos(angle), sin(angle)])
    wheel = angle - atan2(z, x)
    turned = atan2(*(place - pivot)[::-1]) - atan2(*arm[::-1])
    # Positions of the teeth have eight digits in the file: 1e-8 m on 0.04 m.
    assert run["axle.phi"][-1] % pitch == pytest.approx(wheel % pitch, abs=2e-7)
    assert run["pivot.phi"][-1] == pytest.approx(turned, abs=2e-7)

    def cross(a: np.ndarray, b: np.ndarray) -> float:
        return float(a[0] * b[1] - a[1] * b[0])

    back = np.array([cos(wheel), sin(wheel)])
    end = np.array([sin(wheel + pitch), -cos(wheel + pitch)])
    moments = [
        [cross(place - pivot, back), cross(place - pivot, end)],
        [cross(place, back), cross(place, end)],
    ]
    torque = spring["stiffness"] * (spring["spring_reference"] - turned)
    on_back, on_end = np.linalg.solve(moments, [-torque, -load])
    force = on_back * back + on_end * end
    np.testing.assert_allclose([run["catch.f[1]"][-1], run["catch.f[3]"][-1]], force, rtol=1e-5)
    assert_stated("ratchet", hypot(*force), "N")
    assert_stated("ratchet", 30, "degrees")


def test_bucket_scrapes_with_the_weight_that_the_boom_does_not_carry() -> None:
    """Virtual work of a small turn of the boom, with the other cylinders at rest."""
    scene = source("bucket")
    run = gelenk.simulate(scene)
    q = np.array([run[f"{joint}.phi"][-1] for joint in "ABC"])
    step = 6e-6  # rad: cube root of the rounding error
    up, down = (excavator_energy(scene, q + np.array([sign * step, 0, 0])) for sign in (1, -1))
    by_angle = (up[1] - down[1]) / (2 * step)
    of_cylinder = (up[0][0] - down[0][0]) / (2 * step)
    resistance = -scene["joints"]["boom_cylinder"]["damping"] * run["boom_cylinder.v"][-1]
    teeth = excavator_pins(scene, q[0], q[0] + q[1], q[0] + q[1] + q[2])["teeth"]
    boom = np.array(scene["joints"]["A"]["parent"]["position"])[[0, 2]]
    friction = scene["contacts"]["scraping"]["friction"]
    # The bucket slides towards the machine, friction pulls it away; the lowest point of the edge turns with
    # the boom.
    x, z = teeth[0] - boom[0], -boom[1]
    normal = (by_angle - of_cylinder * resistance) / (x - friction * z)
    # Accelerations, of (0.07 m/s)2 over 3 m, are left out: 2e-4 of that of gravity.
    assert run["scraping.f[3]"][-1] == pytest.approx(normal, rel=5e-4)
    assert run["scraping.f[1]"][-1] == pytest.approx(friction * normal, rel=5e-4)
    assert_stated("bucket", normal / 1000, "kN")
