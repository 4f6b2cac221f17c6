# SPDX-License-Identifier: BSD-3-Clause
"""Joint stops (unilateral springs with dampers)
compared with closed-form and one-coordinate reference solutions.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, reaction, scene, with_sensors
from models.one_dof import Jet, OneDofMechanism
from models.planar_loops import FourBar, uniform
from models.reducible import triangle
from models.running import assert_close, run

import gelenk
from physics.methods.test_formulations import directional_derivative

pytestmark = warned.PRESSED

Array = np.ndarray[Any, np.dtype[np.float64]]

MASS, STIFFNESS, HEIGHT = 1.3, 5200.0, 0.45  # kg, N/m, m: contacts of 0.05 s
OMEGA = math.sqrt(STIFFNESS / MASS)


def ball(height: float = HEIGHT, speed: float = 0.0, gravity: float = GRAVITY, **stop: float) -> Scene:
    """A ball that moves vertically, with a stop for its height s."""
    return scene(
        {"ball": body(MASS)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("ball"),
                axis=[0, 0, 1],
                start={"s": height, "v": speed, "fixed": True},
                stop={"stiffness": STIFFNESS, **stop},
            )
        },
        gravity=[0, 0, -gravity],
        sensors={"E": {"type": "energy"}, "R": reaction("J")},
    )


def bouncing(times: Array) -> tuple[Array, Array]:
    """Height and velocity of the undamped ball: free fall, then slightly more than half an oscillation about
    the static equilibrium height -m g / k, and up again (Landau & Lifshitz, section 21).
    """
    fall = math.sqrt(2 * HEIGHT / GRAVITY)
    v1 = GRAVITY * fall
    sag = GRAVITY / OMEGA**2
    contact = 2 / OMEGA * (math.pi - math.atan(v1 * OMEGA / GRAVITY))
    tau = times % (2 * fall + contact)
    c, s = np.cos(OMEGA * (tau - fall)), np.sin(OMEGA * (tau - fall))
    in_contact = (tau > fall) & (tau < fall + contact)
    since = np.where(tau > fall, tau - 2 * fall - contact, tau)  # relative to the nearest apex
    height = np.where(in_contact, sag * (c - 1) - v1 / OMEGA * s, HEIGHT - GRAVITY / 2 * since**2)
    speed = np.where(in_contact, -sag * OMEGA * s - v1 * c, -GRAVITY * since)
    return height, speed


# In multiples of the tolerance: the largest error over 4 s, six bounces of 0.45 m, outputs every 0.01 s. At
# the begin and the end of contact the force has a kink, at which steps end; a missed bounce would cause
# errors of meters.
BOUNCES = 100


@warned.TIGHT
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ["erk", "dirk", "ida", "cvode", "cvode-adams"])
def test_bouncing_ball_matches_closed_form(integrator: str, tolerance: float) -> None:
    times = np.linspace(0, 4, 401)
    height, speed = bouncing(times)
    bound = BOUNCES * tolerance
    found = run(ball(lower=0.0), times, tolerance=tolerance, integrator=integrator)
    assert_close("J.s", found["J.s"], height, bound, "see BOUNCES")
    # 63 1/s times as much in contact
    assert_close("J.v", found["J.v"], speed, OMEGA * bound, "see BOUNCES")
    total = found["E.total"]
    # d(m g h) of the bounce, if the whole error is in its height
    assert_close("energy", total, MASS * GRAVITY * HEIGHT, 2 * MASS * GRAVITY * bound, "see BOUNCES")


@pytest.mark.parametrize("over", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("integrator", ["erk", "ida", "dirk"])
def test_short_contact_between_outputs_is_detected(integrator: str, over: float) -> None:
    """Thrown up to touch a ceiling for 9, 23 or 39 ms, outputs every 10 ms, which bounds the step. A missed
    contact would change the height at the end by 1.3 mm, 29 mm or 290 mm.
    """
    v0, vb = math.sqrt(2 * GRAVITY * (1 + over)), math.sqrt(2 * GRAVITY * over)
    contact = 2 / OMEGA * math.atan(vb * OMEGA / GRAVITY)
    since = 1.0 - (v0 - vb) / GRAVITY - contact
    height = 1 - vb * since - GRAVITY / 2 * since**2
    found = run(ball(0.0, v0, upper=1.0), np.linspace(0, 1, 101), tolerance=1e-8, integrator=integrator)
    assert_close("J.s", found["J.s"][-1], height, 1e-6, "100 rtol")


def test_contact_without_gravity_lasts_half_a_period() -> None:
    """The body contacts the stop at 0 s and leaves it after pi sqrt(m / k) with the opposite velocity."""
    half = math.pi / OMEGA
    found = run(ball(0.0, -2.0, 0.0, lower=0.0), [0.0, half, half + 0.3], tolerance=1e-11)
    assert_close("J.s", found["J.s"], [0, 0, 0.6], 1e-9, "100 rtol")
    assert_close("J.v", found["J.v"], [-2, 2, 2], 1e-8, "1000 rtol: speeds are 100 times the depths")


@pytest.mark.parametrize("damping", [0.0, 15.0, 82.0, 160.0, 400.0])
@pytest.mark.parametrize("integrator", ["erk", "ida", "dirk"])
def test_restitution_matches_damper_without_adhesion(integrator: str, damping: float) -> None:
    """From x = 0, x' = v: x = v/W e^(-D t) sin W t, D = d / 2m, W^2 = omega^2 - D^2, until k x + d x' = 0.
    Then the ball is free, with the stop still compressed: tan(W t) = -2 D W / (omega^2 - 2 D^2). Above
    critical damping, D > omega: sinh, cosh and atanh, with W^2 = D^2 - omega^2.
    """
    D = damping / (2 * MASS)
    W = math.sqrt(abs(OMEGA**2 - D**2))
    if D < OMEGA:
        leave = math.atan2(2 * D * W, 2 * D**2 - OMEGA**2) / W
        rest = math.exp(-D * leave) * (D / W * math.sin(W * leave) - math.cos(W * leave))
    else:
        leave = math.atanh(2 * D * W / (2 * D**2 - OMEGA**2)) / W
        rest = math.exp(-D * leave) * (D / W * math.sinh(W * leave) - math.cosh(W * leave))
    source = ball(0.2, -2.0, 0.0, lower=0.0, damping=damping)
    found = run(source, np.linspace(0, 0.5, 101), tolerance=1e-8, integrator=integrator)
    assert (found["J.a"] >= 0).all()  # the stop never pulls
    assert found["J.a"].max() > 30  # m/s2, and it has pushed
    assert_close("J.v", found["J.v"][-1], 2 * rest, 2e-6, "100 rtol")


def test_stop_never_pulls_a_departing_ball() -> None:
    """Pulled out fast against a strong damper: k depth - d v would be negative, so the force is zero."""
    source = ball(-0.1, 3.0, 0.0, lower=0.0, damping=400.0)  # 520 N against 1200 N
    found = run(source, np.linspace(0, 0.05, 11), tolerance=1e-11)
    assert (found["J.a"] == 0).all()
    assert_close("J.v", found["J.v"], 3.0, 1e-15, "no force acts")
    assert found["E.potential"][0] == pytest.approx(STIFFNESS / 2 * 0.01, rel=1e-15)


@pytest.mark.parametrize("bound", ["lower", "upper"])
def test_stop_carries_the_weight_of_a_resting_ball(bound: str) -> None:
    """The stop's force is part of the joint reaction, and k depth = m g."""
    sag, side = MASS * GRAVITY / STIFFNESS, {"lower": 1, "upper": -1}[bound]
    source = ball(-side * sag, 0.0, side * GRAVITY, **{bound: 0.0})
    found = run(source, [0.0, 0.1], tolerance=1e-10)
    assert_close("J.a", found["J.a"], 0, 1e-12, "round-off of 10 m/s2 and of the start")
    assert_close("R.f[3]", found["R.f[3]"], side * MASS * GRAVITY, 1e-11, "round-off of 13 N")
    assert_close("potential", found["E.potential"], -0.5 * STIFFNESS * sag**2, 1e-13, "m g s + k s^2 / 2")


def swing(**J: Any) -> Scene:
    """A pendulum that swings between two different stops."""
    fields: dict[str, Any] = {
        "axis": [0, 0, 1],
        "start": {"phi": 0.1, "w": 3.0, "fixed": True},
        "stop": {"lower": -0.3, "upper": 0.5, "stiffness": 90.0, "damping": 0.2},
    }
    return scene(
        {"b": body(0.7, (0, -0.4, 0.1), (0.02, 0.02, 0.03))},
        {"J": joint("revolute", frame("ground"), frame("b"), **{**fields, **J})},
        gravity=[0, -GRAVITY, 0],
        sensors={"E": {"type": "energy"}},
    )


def test_limits_refer_to_the_joint_coordinate() -> None:
    """About the opposite axis, or with the bodies exchanged, angles and limits have the opposite sign."""
    times = np.linspace(0, 3, 31)
    mirrored = {
        "start": {"phi": -0.1, "w": -3.0, "fixed": True},
        "stop": {"lower": -0.5, "upper": 0.3, "stiffness": 90.0, "damping": 0.2},
    }
    plain = run(swing(), times)
    assert plain["J.phi"].max() > 0.55
    assert plain["J.phi"].min() < -0.35
    against = swing(axis=[0, 0, -1], **mirrored)
    swapped = swing(**mirrored)
    J = swapped["joints"]["J"]
    J["parent"], J["child"] = J["child"], J["parent"]
    for source in (against, swapped):
        for reductions in ({}, {"planar": False}):
            found = run(source, times, reductions=reductions)
            assert_close("J.phi", -found["J.phi"], plain["J.phi"], 1e-8, "100 rtol")
            assert_close("energy", found["E.total"], plain["E.total"], 1e-8, "100 rtol")


# --- stops in loops ---

BAR = FourBar(uniform(2, 0.5), uniform(2, 1.75), uniform(2, 1.5), 2.0)


def stopped_four_bar(stops: dict[str, dict[str, float]], cut: str, **fields: Any) -> Scene:
    """The four-bar, cut at the named joint: motors keep the others in the tree."""
    source = four_bar(damping=0.0, **fields)
    for name, stop in stops.items():
        source["joints"][name]["stop"] = stop
    source["motors"] = {f"m{j}": {"joint": j} for j in "ABCD" if j != cut}
    return with_sensors(source, E={"type": "energy"})


class Stopped:
    """Reference: the one-coordinate equation of the crank with an undamped stop at
    B or C, and its total energy.
    """

    def __init__(self, name: str, stop: dict[str, float], gravity: tuple[float, float, float]) -> None:
        self.name, self.stop = name, stop
        self.motion = OneDofMechanism(BAR.geometry(), gravity, self.on_crank)

    def angle(self, phi: float) -> Jet:
        theta, psi = BAR.angles(Jet(phi, 1.0))
        return theta - Jet(phi, 1.0) if self.name == "B" else psi - theta

    def depth(self, angle: float) -> float:
        """Negative below the lower limit."""
        above = angle - self.stop.get("upper", math.inf)
        below = self.stop.get("lower", -math.inf) - angle
        return max(above, 0.0) - max(below, 0.0)

    def on_crank(self, _t: float, phi: float, _w: float) -> float:
        angle = self.angle(phi)
        return -self.stop["stiffness"] * self.depth(angle.x) * angle.d

    def energy(self, phi: float, w: float) -> float:
        return self.motion.energy(phi, w) + self.stop["stiffness"] / 2 * self.depth(self.angle(phi).x) ** 2


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["erk", "ida", "dirk"])
@pytest.mark.parametrize("cut", ["C", "B"])
def test_stop_on_a_joint_of_a_loop(cut: str, integrator: str) -> None:
    """The motion is the same whether the joint is cut or in the tree;
    without stops C ranges from 0.95 to 1.74 rad.
    """
    stop = {"lower": 1.0, "upper": 1.6, "stiffness": 3000.0}
    source = stopped_four_bar({"C": stop}, cut)
    (note,) = gelenk.inspect(source).reductions["cut_choice"].notes
    assert f"cut at {cut} " in note
    truth = Stopped("C", stop, (0, -GRAVITY, 0))
    times = np.linspace(0, 2, 101)
    phi, _ = truth.motion.motion(1.1, 0, times)
    found = run(source, times, tolerance=1e-10, integrator=integrator)
    energy = truth.energy(1.1, 0)
    bound = 3e-9  # 30 rtol; found: up to 6, of all three
    assert found["C.phi"].min() < 0.96  # both limits were reached
    assert found["C.phi"].max() > 1.65
    assert_close("A.phi", found["A.phi"], phi, bound, "30 rtol")
    assert_close("energy", found["E.total"], energy, 10 * bound, "of 50 J, as above")


@warned.TURNS
@pytest.mark.parametrize("cut", ["B", "C"])
def test_stop_angle_counts_full_turns(cut: str) -> None:
    """The crank makes full turns until B, after two turns in the opposite direction, reaches its limit."""
    stop = {"lower": -13.0, "stiffness": 60.0}
    source = stopped_four_bar({"B": stop}, cut, gravity=(0, 0, 0))
    source["joints"]["A"]["start"]["w"] = 8.0
    times = np.linspace(0, 4, 101)
    truth = Stopped("B", stop, (0, 0, 0))
    phi, _ = truth.motion.motion(1.1, 8.0, times)
    found = run(source, times, tolerance=1e-10)
    assert found["B.phi"].min() < -13.5
    assert_close("A.phi", found["A.phi"], phi, 3e-9, "30 rtol")


@pytest.mark.parametrize("cut", ["C", "B"])
@pytest.mark.parametrize("push", [-0.05, 0.05])
def test_jacobian_is_exact_inside_a_stop(cut: str, push: float) -> None:
    """Beyond the lower limit of a damped stop, compressing and releasing it: against central differences."""
    source = stopped_four_bar({"C": {"lower": 1.3, "stiffness": 3000.0, "damping": 7.0}}, cut)
    source["joints"]["A"]["start"] = {"phi": 1.1, "w": push, "fixed": True}
    simulation = gelenk.Simulation(gelenk.load(source))
    simulation.initialize(0.0, 1e-8)
    core = simulation._core
    y = np.array(core._state(0))
    n = len(y)
    exact = np.array(core._state_jacobian(0, y.tolist(), True)).reshape(n, n).T
    found = np.array([directional_derivative(core, y, e, 1e-5) for e in np.eye(n)]).T
    assert np.abs(exact).max() > 1e3  # 1/s2: it includes the stop stiffness divided by an inertia
    assert_close("df/dy", exact, found, 1e-6 * np.abs(exact).max(), "finite differences: round-off / h, h^4")


@warned.GUESSES
@pytest.mark.parametrize("off", [(), ("static",)], ids=["dropped", "computed"])
def test_stop_of_an_immobile_joint_contributes_to_the_energy(off: tuple[str, ...]) -> None:
    """A triangle of rods; the joint at the left foot is 0.1 rad beyond its limit."""
    source = triangle()
    plain = gelenk.Simulation(gelenk.load(source).without(off))
    plain.initialize(0.0, 1e-11)
    source["joints"]["L"]["stop"] = {"upper": plain.output("L.phi") - 0.1, "stiffness": 300.0}
    plant = gelenk.Simulation(gelenk.load(source).without(off))
    plant.initialize(0.0, 1e-11)
    stored = plant.output("E.potential") - plain.output("E.potential")
    assert_close("energy", stored, 1.5, 1e-12, "round-off of 30 J")
    assert plant.diagnostics["energy.potential"] == plant.output("E.potential")


# --- parameters ---


@pytest.mark.parametrize("as_fmu", [False, True], ids=["scene", "fmu"])
def test_stop_data_are_parameters(as_fmu: bool, tmp_path: Path) -> None:
    """A limit set before the run is the limit of the run."""
    source = ball(lower=-1.0)
    source["parameters"] = ["J.stop.lower", "J.stop.stiffness", "J.stop.damping"]
    plant: Any = gelenk.load(source)
    if as_fmu:
        plant = gelenk.export_fmu(plant, tmp_path / "ball.fmu")
    values = {"J.stop.lower": 0.1, "J.stop.stiffness": 1300.0, "J.stop.damping": 3.0}
    found = gelenk.simulate(plant, stop=1.0, step=0.01, tolerance=1e-9, parameters=values)
    expected = ball(lower=0.1, damping=3.0)
    expected["joints"]["J"]["stop"]["stiffness"] = 1300.0
    again = gelenk.simulate(gelenk.load(expected), stop=1.0, step=0.01, tolerance=1e-9)
    assert (found["J.s"] == again["J.s"]).all()
    assert found["J.s"].min() < 0.1


def test_invalid_stop_parameter_is_refused() -> None:
    source = ball(lower=-1.0)
    source["parameters"] = ["J.stop.stiffness"]
    with pytest.raises(gelenk.SceneError, match=r"J\.stop\.stiffness: found 0 N/m, expected more than 0 N/m"):
        gelenk.simulate(gelenk.load(source), stop=0.1, parameters={"J.stop.stiffness": 0.0})


@pytest.mark.parametrize("begin", [0.0, 3.0])
@pytest.mark.parametrize("given_as", ["stop", "law"])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_what_rests_at_a_stop_is_pushed_into_it(integrator: str, given_as: str, begin: float) -> None:
    """Wherever rounding puts it: phi = -tau/k (1 - cos(w t)) from the time at which the torque sets in."""
    stiffness, inertia, torque = 560.0, 0.05, 8.0  # N m/rad, kg m2, N m
    rate = (stiffness / inertia) ** 0.5
    laws: dict[str, dict[str, Any]] = {
        "stop": {"lower": 0.0, "stiffness": stiffness, "damping": 0.0},
        "law": {"effort": f"if(phi < 0, -{stiffness}*phi, 0)"},
    }
    for start in (0.0, 1e-40, 1e-30, 1e-20, 1e-16, 1e-13):
        plant = gelenk.Simulation(
            scene(
                {"a": body(1.0, inertia=(inertia,) * 3)},
                {
                    "A": joint(
                        "revolute", frame("ground"), frame("a"), axis=[0, 1, 0],
                        start={"phi": start, "w": 0.0, "fixed": True},
                        **{given_as: laws[given_as]},
                    )
                },
                motors={"M": {"joint": "A"}},
                gravity=[0, 0, 0],
                solver={"integrator": integrator},
            )
        )  # fmt: skip
        plant.initialize(begin, 1e-9)
        plant.step_to(begin + 0.12)
        plant.set_input("M.tau", -torque)
        plant.step_to(begin + 0.16)
        exact = -torque / stiffness * (1 - np.cos(rate * 0.04))
        assert plant.output("A.phi") == pytest.approx(exact, abs=1e-8), start
