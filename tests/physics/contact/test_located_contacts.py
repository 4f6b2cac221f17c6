# SPDX-License-Identifier: BSD-3-Clause
"""Contacts whose changes are located, to the tolerance of adaptive integrators, against closed forms."""

from itertools import pairwise
from math import asin, atan, cos, radians, sin, sqrt, tan

import numpy as np
import pytest
import warned
from benchmarks.contacts.problems import Problem, problems
from models.running import assert_restored_run_continues
from models.touching import SceneData, inertia_of_box, on_plane

import gelenk

G = 9.81  # m/s2
PROBLEMS = problems()
INTEGRATORS = ["erk", "cvode", "ida", "dirk"]


def scene_of(problem: Problem) -> SceneData:
    """A problem as a scene."""
    position, quaternion = problem.start
    scene = on_plane(
        {"sphere": problem.size[0]} if problem.is_ball else {"box": list(problem.size)},
        problem.mass,
        problem.moments,
        {"r": position, "Q": quaternion, "v": problem.v, "w": problem.w},
        {"friction": problem.friction, "restitution": problem.restitution},
        normal=problem.normal,
    )
    if problem.force:
        push = {"type": "wrench", "frame": "world", "body": "body", "position": list(problem.at)}
        scene["forces"] = {"push": {**push, "force": [problem.force, 0, 0]}}
    return scene


def error(problem: Problem, integrator: str, tolerance: float) -> float:
    """The largest error of positions and angles at the times of the references [m, rad]."""
    run = gelenk.simulate(
        scene_of(problem), stop=problem.times[-1], step=0.05, tolerance=tolerance, integrator=integrator
    )
    rows = [int(np.abs(run.time - t).argmin()) for t in problem.times]
    names = [f"J.r[{k}]" for k in (1, 2, 3)] + [f"J.Q[{k}]" for k in (1, 2, 3, 4)]
    return problem.error(np.stack([run[name][rows] for name in names], axis=1))


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_problems_with_known_motions_to_the_tolerance(problem: Problem, tolerance: float) -> None:
    """Errors are at most 100 times the tolerance, as those of motions without contacts."""
    assert error(problem, "erk", tolerance) <= 100 * tolerance


@pytest.mark.parametrize("integrator", [*INTEGRATORS[1:], "cvode-adams"])
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_problems_with_other_integrators(problem: Problem, integrator: str) -> None:
    assert error(problem, integrator, 1e-8) <= 1e-6


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_fixed_steps_end_at_events(problem: Problem) -> None:
    """Of order 4, as the motion is smooth between events: steps of 1 ms leave far less than 1e-7."""
    assert error(problem, "rk4", 1e-8) <= 1e-7


@warned.TIGHT
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9, 0.99])
@pytest.mark.parametrize("integrator", ["auto", *INTEGRATORS])
def test_a_block_that_slides_up_returns_straight(integrator: str, share: float, tolerance: float) -> None:
    """Where it returns, its direction is one of rounding, and turns faster, the slower it slides. Implicit
    methods with the Jacobian of slower sliding let it veer off. share: friction over the weight along the
    incline.
    """
    angle = radians(30)
    down = np.array([cos(angle), 0, -sin(angle)])
    normal = np.array([sin(angle), 0, cos(angle)])
    start = {"r": list(0.05 * normal), "Q": [0, sin(angle / 2), 0, cos(angle / 2)], "v": list(-down)}
    size, law = [0.4, 0.3, 0.1], {"friction": share * tan(angle)}
    scene = on_plane({"box": size}, 1.0, inertia_of_box(1.0, size), start, law, normal=list(normal))
    pull = G * sin(angle)
    up = 1 / (pull * (1 + share))  # s: until it stops
    way = -up / 2 + pull * (1 - share) / 2 * (1 - up) ** 2
    for first in (0.05, 0.1, 0.11, 0.12, 0.13, 0.135):  # others have other steps at the return
        plant = gelenk.Simulation(gelenk.load({**scene, "solver": {"integrator": integrator}}))
        plant.initialize(0.0, tolerance)
        for t in (first, 0.3, 1.0):
            plant.step_to(t)
        error = plant.values(["J.r[1]", "J.r[2]", "J.r[3]"]) - 0.05 * normal - way * down
        assert np.abs(error).max() <= 100 * tolerance


def ball(radius: float, mass: float, start: SceneData, law: SceneData) -> SceneData:
    """A homogeneous ball above the floor."""
    return on_plane({"sphere": radius}, mass, [0.4 * mass * radius**2] * 3, start, law)


def test_impacts_are_located_and_lose_their_energy() -> None:
    """The k-th impact is at t1 (1 + 2 e (1 - e^(k-1)) / (1 - e)) and leaves e^2k of the energy."""
    e, t1 = 0.8, sqrt(2 / G)
    scene = ball(0.1, 0.7, {"r": [0, 0, 1.1]}, {"restitution": e})
    run = gelenk.simulate(
        scene, stop=1.8, step=0.01, tolerance=1e-9, integrator="erk", outputs=["energy.total", "J.r[3]"]
    )
    impacts = [t for t, text in run.events if text == "floor: body touches the ground"]
    exact = [t1 * (1 + 2 * e * (1 - e**k) / (1 - e)) for k in range(len(impacts))]
    assert len(impacts) >= 3
    assert impacts == pytest.approx(exact, abs=1e-11)
    energy = run["energy.total"] - 0.7 * G * 0.1
    for k, (start, end) in enumerate(pairwise(exact)):
        between = (run.time > start) & (run.time < end)
        assert np.abs(energy[between] - 0.7 * G * e ** (2 * k + 2)).max() <= 1e-10


def test_an_impact_within_a_step_is_found() -> None:
    """In one communication step of 0.5 s the ball touches, rebounds and is above again."""
    t1, e = sqrt(2 * 0.1 / G), 0.9
    scene = ball(0.1, 0.7, {"r": [0, 0, 0.2]}, {"restitution": e})
    run = gelenk.simulate(scene, stop=0.3, step=0.3, tolerance=1e-8, integrator="erk")
    left = 0.3 - t1
    assert run["J.r[3]"][-1] == pytest.approx(0.1 + e * G * t1 * left - G / 2 * left**2, abs=1e-8)


def test_an_approach_that_does_not_touch_is_no_event() -> None:
    """A ball on a spring-like parabola passes 1e-6 m above the floor; 1e-6 m lower, it touches."""
    for height, count in ((1e-6, 0), (-1e-6, 1)):
        scene = ball(0.1, 1.0, {"r": [0, 0, 0.1 + height + G / 2 * 0.04], "v": [0, 0, -G * 0.2]}, {})
        scene["gravity"] = [0, 0, G]  # upwards: the lowest point is after 0.2 s
        run = gelenk.simulate(scene, stop=0.5, step=0.5, tolerance=1e-8, integrator="erk")
        assert len(run.events) >= count
        assert (run["solver.impacts"][-1] if "solver.impacts" in run.names else count) == count


def test_a_series_of_impacts_ends_with_the_weight() -> None:
    """Infinitely many impacts until 3 t1, then rest without creep."""
    scene = ball(0.1, 0.7, {"r": [0, 0, 1.1]}, {"restitution": 0.5})
    run = gelenk.simulate(scene, stop=2, step=0.1, tolerance=1e-8, integrator="erk")
    assert run["floor.f[3]"][-1] == pytest.approx(0.7 * G, rel=1e-12)
    assert abs(run["J.v[3]"][-1]) <= 1e-15
    assert run["J.r[3]"][-1] == pytest.approx(0.1, abs=1e-15)
    assert run["floor.mode"][-1] == 2  # without friction


@pytest.mark.parametrize("friction", [0.365, 0.5, 2.0])
def test_a_block_sticks_without_creep(friction: float) -> None:
    """Above tan 20 deg = 0.36397."""
    angle = radians(20)
    normal = [sin(angle), 0, cos(angle)]
    start = {"r": [0.05 * n for n in normal], "Q": [0, sin(angle / 2), 0, cos(angle / 2)]}
    size = [0.4, 0.3, 0.1]
    scene = on_plane(
        {"box": size}, 2.5, inertia_of_box(2.5, size), start, {"friction": friction}, normal=normal
    )
    run = gelenk.simulate(scene, stop=10, step=1, tolerance=1e-6, integrator="erk")
    for k in (1, 2, 3):
        assert np.abs(run[f"J.v[{k}]"]).max() <= 1e-15
        assert run[f"floor.f[{k}]"][-1] == pytest.approx(2.5 * G if k == 3 else 0, abs=1e-11)


def test_a_ball_that_slides_rolls_in_the_end_with_five_sevenths() -> None:
    """Without spin at the start, a ball rolls with 5/7 of its speed, from 2/7 v / (mu g) on."""
    v, mu, radius = 3.0, 0.3, 0.05
    scene = ball(radius, 0.2, {"r": [0, 0, radius], "v": [v, 0, 0]}, {"friction": mu})
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-10, integrator="erk")
    (event,) = [t for t, text in run.events if text == "floor: body stops sliding on the ground"]
    assert event == pytest.approx(2 / 7 * v / (mu * G), abs=1e-10)
    assert run["J.v[1]"][-1] == pytest.approx(5 / 7 * v, abs=1e-10)
    assert run["J.w[2]"][-1] == pytest.approx(5 / 7 * v / radius, abs=1e-8)
    assert run["floor.mode"].tolist()[1:3] == [2, 2]
    assert run["floor.mode"][-1] == 1
    assert run["floor.f[1]"][-1] == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_sliding_across_a_slope_turns_downhill(integrator: str) -> None:
    """At the angle of friction, speed plus its part downhill is constant: in the end half of it is left.

    The direction of slip turns by 90 degrees, and the acceleration vanishes.
    """
    mu, speed = 0.5, 2.0
    angle = atan(mu)
    size = [0.3, 0.3, 0.1]
    normal = [sin(angle), 0, cos(angle)]
    start = {
        "r": [0.05 * n for n in normal],
        "Q": [0, sin(angle / 2), 0, cos(angle / 2)],
        "v": [0, speed, 0],
    }
    scene = on_plane({"box": size}, 1.0, inertia_of_box(1, size), start, {"friction": mu}, normal=normal)
    run = gelenk.simulate(scene, stop=4, step=0.1, tolerance=1e-9, integrator=integrator)
    down = run["J.v[1]"] * cos(angle) - run["J.v[3]"] * sin(angle)
    total = np.sqrt(sum(run[f"J.v[{k}]"] ** 2 for k in (1, 2, 3)))
    assert np.abs(total + down - speed).max() <= 1e-7
    assert down[-1] == pytest.approx(speed / 2, rel=1e-3)
    assert abs(run["J.v[2]"][-1]) < 0.05 * speed


def test_a_box_on_a_belt_reaches_its_speed() -> None:
    """After v / (mu g) it moves with the belt, exactly."""
    size, law = [0.2, 0.2, 0.2], {"friction": 0.4, "velocity": [1.0, 0, 0]}
    scene = on_plane({"box": size}, 3, inertia_of_box(3, size), {"r": [0, 0, 0.1]}, law)
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-8, integrator="erk")
    assert run["J.v[1]"][1] == pytest.approx(0.4 * G * 0.1, abs=1e-12)
    assert run["J.v[1]"][-1] == pytest.approx(1, abs=1e-14)
    assert run["J.r[1]"][-1] == pytest.approx(1 - 1 / (2 * 0.4 * G), abs=1e-10)


def test_static_friction_holds_more_than_sliding_friction() -> None:
    """At 30 deg, tan = 0.577: held by 0.6 at rest, but not by 0.4 once it slides."""
    angle, size = radians(30), [0.4, 0.3, 0.1]
    normal = [sin(angle), 0, cos(angle)]
    for speed in (0.0, 0.1):
        start = {
            "r": [0.05 * n for n in normal],
            "Q": [0, sin(angle / 2), 0, cos(angle / 2)],
            "v": [speed * cos(angle), 0, -speed * sin(angle)],
        }
        law = {"friction": 0.4, "static": 0.6}
        scene = on_plane({"box": size}, 2.5, inertia_of_box(2.5, size), start, law, normal=normal)
        run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-8, integrator="erk")
        expected = speed + G * (sin(angle) - 0.4 * cos(angle)) if speed > 0 else 0
        assert run["J.v[1]"][-1] * cos(angle) - run["J.v[3]"][-1] * sin(angle) == pytest.approx(
            expected, abs=1e-10
        )


def test_a_growing_force_breaks_a_box_away() -> None:
    """10 N/s on 2 kg: held until static friction is used up, then pulled against sliding friction."""
    static, sliding, mass, size = 0.5, 0.3, 2.0, [0.2, 0.3, 0.1]
    scene = on_plane(
        {"box": size},
        mass,
        inertia_of_box(mass, size),
        {"r": [0, 0, 0.05]},
        {"friction": sliding, "static": static},
    )
    rate = 10.0
    scene["forces"] = {
        "push": {"type": "wrench", "frame": "world", "body": "body", "position": [0, 0, -0.05], "input": True}
    }
    step = 1e-3
    run = gelenk.simulate(
        scene,
        stop=2,
        step=step,
        tolerance=1e-9,
        integrator="erk",
        inputs={"push.f[1]": lambda t: rate * t},
        hold=True,
    )
    start = static * mass * G / rate
    # The force is held over each step: it acts half a step later.
    first = step * (np.floor(start / step) + 1)
    forces = rate * np.arange(first, 2 - step / 2, step) - sliding * mass * G
    assert run["J.v[1]"][-1] == pytest.approx(forces.sum() * step / mass, abs=1e-7)
    assert np.abs(run["J.v[1]"][run.time < first]).max() <= 1e-14


def test_rolling_friction_stops_a_ball() -> None:
    """The moment f m g of rolling friction decelerates a rolling ball by f g / (1.4 R)."""
    radius, f, v = 0.05, 1e-3, 0.5
    start = {"r": [0, 0, radius], "v": [v, 0, 0], "w": [0, v / radius, 0]}
    scene = ball(radius, 0.17, start, {"friction": 0.5, "rolling": f})
    run = gelenk.simulate(scene, stop=5, step=0.5, tolerance=1e-9, integrator="erk")
    a = f * G / (1.4 * radius)
    assert run["J.v[1]"][2] == pytest.approx(v - a, rel=1e-9)
    assert run["J.r[1]"][-1] == pytest.approx(v * v / (2 * a), abs=1e-8)
    assert abs(run["J.v[1]"][-1]) <= 1e-14


def test_spinning_friction_stops_a_spin() -> None:
    """The spin about the normal falls by f m g / I per second."""
    radius, mass, f, w = 0.05, 0.17, 1e-4, 1.0
    scene = ball(radius, mass, {"r": [0, 0, radius], "w": [0, 0, w]}, {"friction": 0.5, "spinning": f})
    run = gelenk.simulate(scene, stop=2, step=0.25, tolerance=1e-9, integrator="erk")
    inertia = 0.4 * mass * radius**2
    assert run["J.w[3]"][1] == pytest.approx(w - f * mass * G / inertia * 0.25, abs=1e-9)
    assert abs(run["J.w[3]"][-1]) <= 1e-13


def test_a_particle_leaves_a_dome_at_two_thirds_of_its_height() -> None:
    """A small ball that slides on a fixed sphere without friction leaves it at cos = 2/3 of the angle."""
    big, small, start_angle = 1.0, 0.05, 0.1
    length = big + small
    scene = ball(
        small, 1.0, {"r": [length * sin(start_angle), 0, length * cos(start_angle)]}, {"friction": 0}
    )
    scene["ground"]["shapes"] = {"dome": {"sphere": big, "surface": "concrete"}}
    run = gelenk.simulate(scene, stop=2, step=0.001, tolerance=1e-10, integrator="erk")
    ((t, text),) = run.events
    assert text == "floor: body leaves the ground"
    row = int(np.searchsorted(run.time, t))
    height = np.interp(t, run.time[row - 1 : row + 1], run["J.r[3]"][row - 1 : row + 1])
    # A straight line between points 1 ms apart is off by a h2 / 8.
    assert height == pytest.approx(length * cos(start_angle) * 2 / 3, abs=G * 1e-6 / 8)


def test_balls_exchange_their_momenta_in_an_oblique_impact() -> None:
    """Equal smooth balls with e = 1: the components along the line of centers are exchanged."""
    radius, offset = 0.1, 0.1
    scene = ball(radius, 1.0, {"r": [-1, 0, 0], "v": [2, 0, 0]}, {})
    scene["gravity"] = [0, 0, 0]
    scene["bodies"]["other"] = {
        **scene["bodies"]["body"],
        "shapes": {"s": {"sphere": radius, "surface": "wood"}},
    }
    scene["joints"]["K"] = {
        "type": "free",
        "parent": "ground",
        "child": "other",
        "start": {"r": [0, offset, 0]},
    }
    del scene["ground"]
    scene["contacts"] = {"hit": {"between": ["wood", "wood"], "restitution": 1}}
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-10, integrator="erk")
    angle = asin(offset / (2 * radius))
    along = 2 * cos(angle)
    assert run["K.v[1]"][-1] == pytest.approx(along * cos(angle), abs=1e-12)
    assert run["K.v[2]"][-1] == pytest.approx(along * sin(angle), abs=1e-12)
    assert run["J.v[1]"][-1] == pytest.approx(2 - along * cos(angle), abs=1e-12)


def test_a_ball_bounces_off_with_friction() -> None:
    """A ball without spin strikes the floor obliquely: it rolls after the impact, or slips for small mu.

    Rolling: the impulse is 2/7 m v_t; slipping: mu (1 + e) m v_n (Coulomb's law for impulses).
    """
    radius, e, v_n, v_t = 0.05, 0.5, 2.0, 1.0
    for mu in (0.05, 0.5):
        scene = ball(
            radius, 0.2, {"r": [0, 0, 0.06], "v": [v_t, 0, -v_n]}, {"friction": mu, "restitution": e}
        )
        scene["gravity"] = [0, 0, 0]
        run = gelenk.simulate(scene, stop=0.1, step=0.1, tolerance=1e-10, integrator="erk")
        expected = v_t - min(2 / 7 * v_t, mu * (1 + e) * v_n)
        assert run["J.v[1]"][-1] == pytest.approx(expected, abs=1e-11)
        assert run["J.v[3]"][-1] == pytest.approx(e * v_n, abs=1e-12)


@pytest.mark.parametrize("force", [8.0, -5.0])
def test_forces_on_a_box_that_stands(force: float) -> None:
    """Their sum balances the force and the weight, although the forces of the corners are not unique."""
    size, mass, height = [0.4, 0.3, 0.2], 2.0, 0.15
    scene = on_plane({"box": size}, mass, inertia_of_box(mass, size), {"r": [0, 0, 0.1]}, {"friction": 0.6})
    scene["forces"] = {
        "push": {
            "type": "wrench",
            "frame": "world",
            "body": "body",
            "position": [0, 0, height - 0.1],
            "force": [force, 0, 0],
        }
    }
    run = gelenk.simulate(scene, stop=1, step=0.5, tolerance=1e-8, integrator="erk")
    assert run["floor.f[1]"][-1] == pytest.approx(-force, abs=1e-10)
    assert run["floor.f[3]"][-1] == pytest.approx(mass * G, abs=1e-10)
    assert run["floor.mode"][-1] == 1
    assert np.abs(run["J.v[1]"]).max() <= 1e-14


def test_oblique_push_within_the_base_does_not_tip() -> None:
    """The resultant stays within the square base but beyond the diamond of least-norm forces: the box stands.

    Pushed at the top along the diagonal with 0.7 of the force that would move the resultant onto an edge, in
    both directions: redundant corner forces of least norm would pull at a corner.
    """
    edge, mass = 0.2, 2.0
    scene = on_plane(
        {"box": [edge, edge, edge]},
        mass,
        inertia_of_box(mass, [edge] * 3),
        {"r": [0, 0, edge / 2]},
        {"friction": 2},
    )
    force = 0.7 * mass * G * (edge / 2) / edge
    scene["forces"] = {
        "push": {
            "type": "wrench",
            "frame": "world",
            "body": "body",
            "position": [0, 0, edge / 2],
            "force": [force, force, 0],
        }
    }
    run = gelenk.simulate(scene, stop=2, step=0.5, tolerance=1e-8, integrator="erk")
    for k in (1, 2, 3):
        assert np.abs(run[f"J.v[{k}]"]).max() <= 1e-13
        assert np.abs(run[f"J.w[{k}]"]).max() <= 1e-12


@pytest.mark.parametrize("integrator", ["erk", "cvode", "rk4"])
@pytest.mark.parametrize("time", [0.3, 0.6, 1.3546, 1.5])
def test_a_restored_run_continues_with_the_same_bits(integrator: str, time: float) -> None:
    """Saved in flight, in a slide after an impact, within a series of impacts, and at rest."""
    scene = ball(
        0.1, 0.7, {"r": [0, 0, 1.1], "v": [2, 1, 0], "w": [5, 0, 3]}, {"restitution": 0.5, "friction": 0.1}
    )
    scene["solver"] = {"integrator": integrator}
    assert_restored_run_continues(scene, time, [0.3, 0.7])
