# SPDX-License-Identifier: BSD-3-Clause
"""Friction proportional to the reaction of its joint, on which it acts back."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, reaction, scene, with_sensors
from models.bearing_friction import four_bar_truth, four_bar_with_bearings, slider_crank_with_guide
from models.running import assert_close

import gelenk

pytestmark = warned.GUESSES

INTEGRATORS = ("erk", "cvode", "cvode-adams", "ida", "dirk")

# Problem N07: event-driven extrapolation in 80-bit arithmetic; its own error is 2e-16.
N07_TIMES = (0.1, 0.2, 0.5, 1.0, 1.5)
N07_PHI = (1.4240335139300109, 2.0714176638895285, 5.165350031841773, 5.293286931392428, 5.0772583747202775)
N07_W = (6.579024140733766, 6.96626982970004, 6.427972039987262, -1.9418044073394678, 0.0)


def plant(source: Scene, integrator: str = "erk", tolerance: float = 1e-8) -> gelenk.Simulation:
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": {"integrator": integrator}}))
    simulation.initialize(0.0, tolerance)
    return simulation


@pytest.mark.filterwarnings("ignore:solver.tolerance")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ["auto", *INTEGRATORS])
def test_the_guide_of_a_slider_crank(integrator: str, tolerance: float) -> None:
    """N07: its force changes sides, and the slider stays stuck off its equilibrium."""
    simulation = plant(slider_crank_with_guide(0.3), integrator, tolerance)
    for t, phi, w in zip(N07_TIMES, N07_PHI, N07_W, strict=True):
        simulation.step_to(t)
        assert_close("phi", simulation.output("A.phi"), phi, 100 * tolerance, f"the tolerance, t = {t}")
        assert_close("w", simulation.output("A.w"), w, 1000 * tolerance, f"of speeds about 10, t = {t}")
    assert simulation.output("guide.v") == 0
    assert_close("w", simulation.output("A.w"), 0, 1e-13, "rounding of the loop")
    assert simulation.output("guide.friction.mode") == 0
    assert simulation.diagnostic("solver.events") == 3


FOUR_BAR_TIMES = np.linspace(0.25, 3.0, 12)


@cache
def truth() -> tuple[Array, int]:
    return four_bar_truth(FOUR_BAR_TIMES)


@pytest.mark.filterwarnings("ignore:solver.tolerance")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_four_bar_with_bearings_in_all_joints(integrator: str, tolerance: float) -> None:
    """Each joint reverses on its own; the reference has free bodies and joint forces."""
    simulation = plant(four_bar_with_bearings(), integrator, tolerance)
    expected, reversals = truth()
    for t, (phi, w) in zip(FOUR_BAR_TIMES, expected, strict=True):
        simulation.step_to(t)
        # Speeds are up to 16 rad/s.
        assert_close("phi", simulation.output("A.phi"), phi, 300 * tolerance, f"the tolerance, t = {t}")
        assert_close("w", simulation.output("A.w"), w, 3000 * tolerance, f"the tolerance, t = {t}")
    assert simulation.diagnostic("solver.events") == reversals


@pytest.mark.parametrize("phi", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_a_four_bar_starts_from_rest_at_special_positions(phi: float) -> None:
    """With the crank in line with the ground, C begins to move by the curvature of its motion alone."""
    simulation = plant(four_bar_with_bearings(phi, 0.0))
    times = np.array([0.1, 0.2, 0.3])
    expected, reversals = four_bar_truth(times, phi, 0.0)
    for t, (at, w) in zip(times, expected, strict=True):
        simulation.step_to(t)
        assert_close("phi", simulation.output("A.phi"), at, 1e-6, f"100 times the tolerance, t = {t}")
        assert_close("w", simulation.output("A.w"), w, 1e-5, f"the same of speeds about 10, t = {t}")
    # That C leaves its position of rest is seen where it moves, not as a reversal.
    assert simulation.diagnostic("solver.events") in (reversals, reversals + 1)


def reversed_joint(source: Scene) -> Scene:
    out = copy.deepcopy(source)
    B = out["joints"]["B"]
    B["parent"], B["child"] = B["child"], B["parent"]
    return out


def in_other_order(source: Scene) -> Scene:
    return {**source, "joints": dict(reversed(source["joints"].items()))}


def in_space(source: Scene) -> Scene:
    return {**source, "solver": {"reductions": {"planar": False}}}


@pytest.mark.parametrize("other", [reversed_joint, in_other_order, in_space])
def test_the_way_of_modeling_does_not_matter(other: Callable[[Scene], Scene]) -> None:
    """Another direction, another cut, redundant equations in space: radial forces are unique."""
    found = []
    for source in (four_bar_with_bearings(), other(four_bar_with_bearings())):
        simulation = gelenk.Simulation(gelenk.load(source))
        simulation.initialize(0.0, 1e-9)
        simulation.step_to(1.0)
        friction = [abs(simulation.output(f"{j}.friction.tau")) for j in "ABCD"]
        found.append([simulation.output("A.phi"), *friction])
    assert_close("run", found[0], found[1], 1e-7, "100 times the tolerance")


def pendulum(phi: float, w: float = 0.0, **bearing: float) -> Scene:
    """A point mass of 2 kg on a rod of 0.5 m, in the x-z plane; phi from below [rad]."""
    return scene(
        {"bob": body(2.0, (0, 0, -0.5))},
        {
            "pivot": joint(
                "revolute",
                frame("ground"),
                frame("bob"),
                axis=[0, -1, 0],
                friction={"coulomb": 0.0, "bearing": {"radius": 0.05, **bearing}},
                start={"phi": phi, "w": w, "fixed": True},
            )
        },
        gravity=[0, 0, -GRAVITY],
    )


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("share", [1 - 1e-6, 1 + 1e-6])
def test_a_pendulum_rests_within_its_friction_circle(share: float, side: int) -> None:
    """At rest the reaction is the weight: it stays where l sin(phi) is at most the radius of the circle."""
    phi = side * math.asin(share * 0.3 * 0.05 / 0.5)
    simulation = plant(pendulum(phi, coefficient=0.2, static=0.3))
    simulation.step_to(0.5)
    if share < 1:
        assert simulation.output("pivot.phi") == phi
        assert simulation.output("pivot.w") == 0
        held = 2 * GRAVITY * 0.5 * math.sin(phi)
        assert_close("tau", simulation.output("pivot.friction.tau"), held, 1e-14, "rounding")
    else:
        assert side * simulation.output("pivot.w") < 0


def test_friction_in_motion_follows_from_the_reaction_that_it_changes() -> None:
    """The reaction of a swinging point mass is known in closed form for any torque on it."""
    simulation = plant(with_sensors(pendulum(0.4, 3.0, coefficient=0.6), R=reaction("pivot")))
    force = math.hypot(simulation.output("R.f[1]"), simulation.output("R.f[3]"))
    torque = simulation.output("pivot.friction.tau")
    assert torque == pytest.approx(-0.6 * 0.05 * force, rel=1e-14)
    # Along the rod m (w^2 l + g cos phi), across it the torque over the length.
    along = 2.0 * (3.0**2 * 0.5 + GRAVITY * math.cos(0.4))
    assert force == pytest.approx(math.hypot(along, torque / 0.5), rel=1e-13)
    acceleration = -GRAVITY * math.sin(0.4) / 0.5 + torque / (2.0 * 0.5**2)
    assert simulation.output("pivot.a") == pytest.approx(acceleration, rel=1e-13)


@pytest.mark.parametrize("offset", [-1e-6, 0.0, 1e-6])
def test_a_guide_on_an_incline_holds_up_to_its_angle_of_friction(offset: float) -> None:
    angle = math.atan(0.5) + offset
    incline = scene(
        {"block": body(3.0)},
        {
            "guide": joint(
                "prismatic",
                frame("ground"),
                frame("block"),
                axis=[-math.cos(angle), 0, -math.sin(angle)],
                friction={"coulomb": 0.0, "bearing": {"coefficient": 0.4, "static": 0.5}},
            )
        },
        gravity=[0, 0, -GRAVITY],
    )
    simulation = plant(incline)
    simulation.step_to(1.0)
    if offset > 0:
        a = GRAVITY * (math.sin(angle) - 0.4 * math.cos(angle))
        assert_close("s", simulation.output("guide.s"), a / 2, 1e-12, "rounding of a constant acceleration")
    else:
        assert simulation.output("guide.s") == 0
        assert simulation.output("guide.friction.mode") == 0


def rates(source: Scene, phi: float, w: float) -> tuple[float, float]:
    """Return (w, acceleration) of the crank, started there."""
    moved = {**source, "joints": {**source["joints"]}}
    moved["joints"]["A"] = {**source["joints"]["A"], "start": {"phi": phi, "w": w, "fixed": True}}
    simulation = plant(moved)
    return simulation.output("A.w"), simulation.output("A.a")


@pytest.mark.parametrize("source", [four_bar_with_bearings(), slider_crank_with_guide(0.3)])
def test_linear_models_contain_the_change_of_the_load(source: Scene) -> None:
    """Against central differences of the accelerations."""
    start = source["joints"]["A"]["start"]
    found = gelenk.linear.linear_model(gelenk.load(source))
    assert found.states == ("A.phi", "A.w")
    h = 1e-5
    by_phi = np.subtract(
        rates(source, start["phi"] + h, start["w"]), rates(source, start["phi"] - h, start["w"])
    )
    by_w = np.subtract(
        rates(source, start["phi"], start["w"] + h), rates(source, start["phi"], start["w"] - h)
    )
    expected = np.column_stack([by_phi, by_w]) / (2 * h)
    # Differences: rounding 1e-13 / h of accelerations about 200, and h^2.
    assert_close("A", found.A, expected, 2e-6, "differences")
    without = {**source, "joints": {k: {**v} for k, v in source["joints"].items()}}
    for j in without["joints"].values():
        j.pop("friction", None)
    smooth = gelenk.linear.linear_model(gelenk.load(without)).A
    assert np.abs(smooth - found.A).max() > 0.1  # friction matters here


def test_a_saved_state_continues_to_the_same_bits() -> None:
    simulation = plant(four_bar_with_bearings())
    simulation.step_to(0.7)
    state = simulation.save()
    simulation.step_to(1.9)
    expected = [simulation.output(str(s.name)) for s in simulation.outputs]
    simulation.restore(state)
    simulation.step_to(1.9)
    assert [simulation.output(str(s.name)) for s in simulation.outputs] == expected


def test_energy_is_lost_by_friction_alone() -> None:
    """The power of friction, summed with Gauss's rule between events, against the energy."""
    source = with_sensors(four_bar_with_bearings(), E={"type": "energy"})
    simulation = plant(source, tolerance=1e-11)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    lost, before = 0.0, simulation.output("E.total")
    start = before
    edges = np.linspace(0.0, 0.17, 41)  # before the first reversal, at 0.178 s
    for a, b in itertools.pairwise(edges):
        for x, weight in zip(nodes, weights, strict=True):
            simulation.step_to((a + b) / 2 + x * (b - a) / 2)
            power = sum(simulation.output(f"{j}.friction.tau") * simulation.output(f"{j}.w") for j in "ABCD")
            lost -= weight * (b - a) / 2 * power
    simulation.step_to(0.17)
    assert lost > 0.1
    assert_close(
        "energy", simulation.output("E.total") + lost, start, 1e-8, "100 times the tolerance of 20 J"
    )


def test_friction_that_determines_no_motion_is_refused_by_name() -> None:
    """A slider-crank whose guide jams: beyond a coefficient, no force of the guide agrees with the law."""
    source = slider_crank_with_guide(20.0, 2.0, -12.0)
    with pytest.raises(gelenk.StepError, match=r"the friction of guide\.s depends so much on the load"):
        plant(source).step_to(2.0)
