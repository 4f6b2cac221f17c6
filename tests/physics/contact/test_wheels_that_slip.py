# SPDX-License-Identifier: BSD-3-Clause
"""Wheels on a plane that skid, roll, turn and leave it, to the tolerance, against independent solutions."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin
from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from models.running import assert_restored_run_continues
from models.skidding import DISC, Course, G, Wheel, course, on_the_plane, scene_of
from scipy.spatial.transform import Rotation

import gelenk

TOLERANCES = pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])


def assert_same_motion(wheel: Wheel, y: Array, truth: Course, times: Array, tolerance: float) -> None:
    names = [f"J.{name}[{k}]" for name, n in (("r", 3), ("Q", 4)) for k in range(1, n + 1)]
    run = gelenk.simulate(
        scene_of(wheel, y),
        stop=times[-1],
        step=times[1],
        tolerance=tolerance,
        integrator="erk",
        outputs=[*names, "energy.total"],
    )
    found = np.stack([run[name] for name in names], axis=1)
    sign = np.sign(np.sum(found[:, 3:] * truth.states[:, 3:7], axis=1))
    found[:, 3:] *= sign[:, None]
    assert np.abs(found - truth.states[:, :7]).max() <= 100 * tolerance
    assert len(run.events) == len(truth.events)
    for (t, _), (exact, _) in zip(run.events, truth.events, strict=True):
        assert t == pytest.approx(exact, abs=1000 * tolerance)  # accelerations are up to 10 m/s2
    loss = np.diff(run["energy.total"])
    assert (loss <= 100 * tolerance * run["energy.total"][0]).all()


# Wobbling with side slip, spinning against the motion, a tire of the width of a bicycle's, a ball.
WOBBLES = {
    "disc that skids sideways": (DISC, 0.2, (2.0, 0.7), (0.3, 5.0, 0.5)),
    "disc with back-spin": (DISC, 0.02, (1.5, 0.0), (0.0, -1.0, 0.1)),
    "crowned tire": (replace(DISC, crown=0.05), 0.25, (2.0, -0.5), (0.2, 5.0, 0.4)),
    "ball": (
        Wheel(2.0, (0.072, 0.072, 0.072), 0.3, 0.3, 0.25), 0.3, (1.0, 0.5), (1.0, -3.0, 0.7)
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=WOBBLES)
def wobble(request: pytest.FixtureRequest) -> tuple[Wheel, Array, Course, Array]:
    wheel, lean, v, w = WOBBLES[request.param]
    times = np.linspace(0, 0.45, 10)
    y = on_the_plane(wheel, lean, v, w)
    truth = course(wheel, y, times)
    assert [mode for _, mode in truth.events] == ["roll"]
    return wheel, y, truth, times


@TOLERANCES
def test_skidding_wheels_follow_newton_and_euler(
    wobble: tuple[Wheel, Array, Course, Array], tolerance: float
) -> None:
    """Normal and slip force depend on each other, and the direction of slip turns in the plane."""
    assert_same_motion(*wobble, tolerance)


@TOLERANCES
def test_rolling_ends_where_friction_does_not_suffice(tolerance: float) -> None:
    """A disc falls over from rest: its contact breaks away and slides, at first without speed."""
    wheel = replace(DISC, friction=0.35)
    y = on_the_plane(wheel, 0.3, (0, 0), (0, 0, 0))
    times = np.linspace(0, 0.36, 10)
    truth = course(wheel, y, times, mode="roll")
    assert [mode for _, mode in truth.events] == ["slide"]
    assert_same_motion(wheel, y, truth, times, tolerance)


@TOLERANCES
def test_a_wheel_with_a_heavy_side_leaves_the_ground(tolerance: float) -> None:
    """Its center of mass, off center, is thrown up; before, the contact slides since its force is small."""
    e = 0.15
    wheel = Wheel(2.0, (0.06, 0.12, 0.06), 0.3, 0.02, 0.8, center=(0.0, 0.0, e))
    w = 18.0
    y = on_the_plane(wheel, 0.0, (w * (wheel.radius - e), 0), (0, w, 0))
    times = np.linspace(0, 0.3, 31)
    truth = course(wheel, y, times, mode="roll")
    assert truth.events[-1][1] == "fly"
    stop = times[times > truth.events[-1][0]][1]  # in flight, before it lands
    keep = times <= stop
    truth = Course(truth.states[keep], truth.events)
    assert_same_motion(wheel, y, truth, times[keep], tolerance)


def test_a_ball_is_a_wheel_whose_crown_is_its_radius() -> None:
    """It slides, then rolls with 5/7 of its speed, as a sphere does."""
    v, mu, radius = 3.0, 0.3, 0.05
    ball = Wheel(0.2, (0.4 * 0.2 * radius**2,) * 3, radius, radius, mu)
    y = on_the_plane(ball, 0.4, (v, 0), (0, 0, 0))
    run = gelenk.simulate(scene_of(ball, y), stop=1, step=0.1, tolerance=1e-10, integrator="erk")
    ((event, text),) = run.events
    assert text == "tire: wheel stops sliding on the ground"
    assert event == pytest.approx(2 / 7 * v / (mu * G), abs=1e-10)
    assert run["J.v[1]"][-1] == pytest.approx(5 / 7 * v, abs=1e-10)


@TOLERANCES
@pytest.mark.parametrize("spin", [0.0, -20.0, 30.0])
def test_an_upright_disc_skids_then_rolls(spin: float, tolerance: float) -> None:
    """As PlanarMechanics.CounterSpin: a = -+mu g until v = r w, at t = |u| / (mu g (1 + m r^2 / I))."""
    v, (_, moment, _), m, r, mu = 2.0, DISC.moments, DISC.mass, DISC.radius, DISC.friction
    y = on_the_plane(DISC, 0.0, (v, 0), (0, spin, 0))
    run = gelenk.simulate(scene_of(DISC, y), stop=4, step=0.5, tolerance=tolerance, integrator="erk")
    u = v - r * spin
    until = abs(u) / (mu * G * (1 + m * r**2 / moment))
    a = -np.sign(u) * mu * G
    t = np.minimum(run.time, until)
    speed = v + a * until
    x = v * t + a * t**2 / 2 + speed * (run.time - t)
    assert np.abs(run["J.r[1]"] - x).max() <= 100 * tolerance
    assert run.events[0][0] == pytest.approx(until, abs=100 * tolerance)
    assert run["J.w[2]"][-1] == pytest.approx(speed / r, abs=1000 * tolerance)
    assert np.abs(run["J.r[2]"]).max() <= 1e-12  # what is symmetric remains so, up to rounding


def braked() -> dict[str, Any]:
    """A wheel that carries a load through a brake; upright, since the load slides along x and z only."""
    scene = scene_of(DISC, on_the_plane(DISC, 0, (0, 0), (0, 0, 0)))
    scene["bodies"] |= {"sledge": {"mass": 0}, "load": {"mass": 8.0, "inertia": [0.1, 0.1, 0.1]}}
    scene["joints"] = {
        "x": {
            "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "sledge",
            "start": {"s": 0, "v": 6, "fixed": True},
        },
        "z": {
            "type": "prismatic", "axis": [0, 0, 1], "parent": "sledge", "child": "load",
            "start": {"s": 0.3, "v": 0, "fixed": True},
        },
        "hub": {
            "type": "revolute", "axis": [0, 1, 0], "parent": "load", "child": "wheel",
            "start": {"phi": 0, "w": 20, "fixed": True}, "friction": {"coulomb": 40, "input": "engagement"},
        },
    }  # fmt: skip
    return scene


BRAKE = {"hub.friction.engagement": lambda t: 1.0 if 0.2 <= t < 1.0 - 1e-9 else 0.0}


@TOLERANCES
def test_braking_to_lock_and_release(tolerance: float) -> None:
    """It slows by mu g; the wheel is locked after I w / (T - mu m g r), and rolls again by friction."""
    m, moment, r, mu, torque = 10.0, DISC.moments[1], DISC.radius, DISC.friction, 40.0
    run = gelenk.simulate(braked(), stop=2, step=0.1, tolerance=tolerance, integrator="erk", inputs=BRAKE)
    a = mu * G
    locked = 0.2 + moment * 20 / (torque - m * a * r)
    slow = 6 - a * 0.8  # at the release
    rolls = 1 + slow / (a + m * a * r**2 / moment)
    events = [t for t, _ in run.events]
    assert events == pytest.approx([0.2, locked, 1.0, rolls], abs=100 * tolerance)
    v = np.interp(run.time, [0, 0.2, rolls, 9], [6, 6, 6 - a * (rolls - 0.2), 6 - a * (rolls - 0.2)])
    assert np.abs(run["x.v"] - v).max() <= 100 * tolerance
    during = (run.time > locked) & (run.time < 0.95)
    assert (run["hub.w"][during] == 0).all()
    assert run["hub.w"][-1] == pytest.approx(v[-1] / r, abs=1000 * tolerance)


@pytest.mark.parametrize("time", [0.25, 0.5, 1.05])
@pytest.mark.parametrize("integrator", ["erk", "cvode", "rk4"])
def test_a_run_restored_in_a_skid_continues_with_the_same_bits(integrator: str, time: float) -> None:
    wheel, lean, v, w = WOBBLES["disc that skids sideways"]
    scene = scene_of(wheel, on_the_plane(wheel, lean, v, w))
    scene["solver"] = {"integrator": integrator}
    assert_restored_run_continues(scene, time * 0.2, [0.1, 0.4])


@pytest.mark.parametrize("excess", [-1e-6, 1e-6])
def test_a_torque_at_the_limit_of_friction(excess: float) -> None:
    """From rest it rolls up to mu m g r (1 + I / (m r^2)), and slips beyond.

    The wheel is guided: a free disc that slips at 1e-6 m/s turns its slip so fast that steps are refused.
    """
    m, (_, moment, _), r, mu = 10.0, DISC.moments, DISC.radius, DISC.friction
    limit = mu * m * G * r * (1 + moment / (m * r**2))
    scene = braked()
    scene["joints"]["x"]["start"]["v"] = scene["joints"]["hub"]["start"]["w"] = 0
    del scene["joints"]["hub"]["friction"]
    scene["motors"] = {"engine": {"joint": "hub"}}
    inputs = {"engine.tau": limit * (1 + excess)}
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-10, integrator="erk", inputs=inputs)
    slip = run["hub.w"] * r - run["x.v"]
    if excess < 0:
        assert np.abs(slip).max() <= 1e-14
        assert run["tire.mode"][-1] == 1
    else:
        gain = (limit * (1 + excess) - mu * m * G * r) * r / moment - mu * G
        assert slip[-1] == pytest.approx(gain, rel=1e-6)
        assert run["tire.mode"][-1] == 2
    assert run["x.v"][-1] == pytest.approx(mu * G, rel=3e-6)


@pytest.mark.parametrize("crown", [0.0, 0.05])
def test_without_slip_it_moves_as_a_rolling_wheel(crown: float) -> None:
    """As the constraint `rolling` of the same crown does, with its forces."""
    wheel = replace(DISC, friction=5.0, crown=crown)
    w = np.array([0.3, 6.0, 1.0])
    R = Rotation.from_euler("x", 0.2).as_matrix()
    v = -np.cross(w, wheel.arm(R, w)[0])
    y = on_the_plane(wheel, 0.2, (v[0], v[1]), tuple(w))
    scene = scene_of(wheel, y)
    run = gelenk.simulate(scene, stop=2, step=0.05, tolerance=1e-10, integrator="erk")
    assert not run.events
    del scene["contacts"], scene["ground"], scene["bodies"]["wheel"]["shapes"]
    scene["constraints"] = {"tire": {"type": "rolling", "body": "wheel", "radius": 0.3, "crown": crown}}
    scene["joints"]["J"]["start"]["fixed"] = ["r", "Q", "w"]
    names = [*(f"J.r[{k}]" for k in (1, 2, 3)), "tire.f_n", "energy.total"]
    ideal = gelenk.simulate(scene, stop=2, step=0.05, tolerance=1e-10, integrator="erk", outputs=names)
    for k in (1, 2, 3):
        assert np.abs(run[f"J.r[{k}]"] - ideal[f"J.r[{k}]"]).max() <= 1e-8
    assert np.abs(run["tire.f[3]"] - ideal["tire.f_n"]).max() <= 1e-7  # m (10 rad/s)^2 times errors of angles
    assert np.ptp(ideal["energy.total"]) <= 1e-8  # forces of rolling do no work, crowned or not


def test_a_crown_larger_than_the_radius_is_refused() -> None:
    scene = scene_of(replace(DISC, crown=0.4), on_the_plane(DISC, 0, (0, 0), (0, 0, 0)))
    with pytest.raises(
        gelenk.SceneError, match=r"tire\.crown: found 0\.4, expected at most the radius, 0\.3"
    ):
        gelenk.load(scene)


def test_time_stepping_has_the_same_skid() -> None:
    """Steps of 1 ms: of order 1 where velocities jump in their derivatives; here the error is 1e-4."""
    wheel, lean, v, w = WOBBLES["crowned tire"]
    y = on_the_plane(wheel, lean, v, w)
    scene = scene_of(wheel, y)
    events = gelenk.simulate(scene, stop=0.5, step=0.5, tolerance=1e-9, integrator="erk")
    steps = gelenk.simulate(scene, stop=0.5, step=0.5, integrator="moreau-jean")
    for k in (1, 2, 3):
        assert steps[f"J.r[{k}]"][-1] == pytest.approx(events[f"J.r[{k}]"][-1], abs=1e-3)


def test_lying_down_is_refused_with_a_sentence() -> None:
    """A disc that falls flat has no lowest point in the end."""
    y = on_the_plane(DISC, 0.6, (0, 0), (0, 0, 0))
    with pytest.raises(gelenk.StepError, match="flat"):
        gelenk.simulate(scene_of(DISC, y), stop=3, step=0.05, tolerance=1e-8, integrator="erk")


def test_angles_of_lean_near_zero() -> None:
    """An upright wheel and one that leans by 1e-9 rad roll alike."""
    ends = []
    for lean in (0.0, 1e-9):
        y = on_the_plane(DISC, lean, (2 * cos(0.0), sin(0.0)), (0, 0, 0))
        run = gelenk.simulate(scene_of(DISC, y), stop=0.3, step=0.1, tolerance=1e-10, integrator="erk")
        ends.append([run[f"J.r[{k}]"][-1] for k in (1, 2, 3)])
    # Falling over multiplies the lean by at most exp(sqrt(m g r / (A + m r^2)) t) = 5.
    assert np.abs(np.diff(ends, axis=0)).max() <= 1e-8
