# SPDX-License-Identifier: BSD-3-Clause
"""The cone that limits the swing of a ball joint: impacts, rest on it, precession along it, lift-off,
compared with closed forms, with conserved quantities, and by all integrators.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import warned
from scipy.integrate import quad

import gelenk

pytestmark = [warned.GUESSES, warned.TIGHT]

Source = dict[str, Any]
INTEGRATORS = ["auto", "erk", "dirk", "cvode", "ida", "rk4"]
G = 9.81
MASS, ARM = 1.3, 0.4  # of the pendulum: a point at the distance ARM below the joint, and an inertia about it
INERTIA = [0.05, 0.05, 0.02]  # about the center of mass; the last one about its axis
ABOUT_JOINT = INERTIA[0] + MASS * ARM**2


def turned_about(axis: list[float], angle: float) -> list[float]:
    x = math.sin(angle / 2) * np.array(axis) / np.linalg.norm(axis)
    return [*map(float, x), math.cos(angle / 2)]


def pendulum(
    swing: float,
    *,
    restitution: float = 0.0,
    angle: float = 0.0,
    w: list[float] | None = None,
    gravity: float = -G,
    axis: list[float] | None = None,
    **more: Any,
) -> Source:
    """A symmetric pendulum on a ball joint, its axis in a cone about the vertical; turned about `axis`."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, gravity],
        "bodies": {"rod": {"mass": MASS, "com": [0, 0, -ARM], "inertia": INERTIA}},
        "joints": {
            "J": {
                "type": "spherical",
                "parent": "ground",
                "child": "rod",
                "limit": {"swing": swing, "restitution": restitution},
                "start": {
                    "Q": turned_about(axis or [1, 0, 0], angle),
                    "w": w or [0, 0, 0],
                    "fixed": True,
                },
            }
        },
        **more,
    }


def swings(result: Any) -> np.ndarray:
    """The angle between the axis of the pendulum and the vertical."""
    x, y, z, s = (result[f"J.Q[{k}]"] for k in range(1, 5))
    return np.asarray(2 * np.arctan2(np.hypot(x, y), np.hypot(z, s)))


def run(
    source: Source, integrator: str = "erk", *, stop: float = 1.0, tolerance: float = 1e-10, **more: Any
) -> Any:
    solver = {"integrator": integrator, **more}
    return gelenk.simulate({**source, "solver": solver}, stop=stop, step=0.01, tolerance=tolerance)


def test_free_impact_in_closed_form() -> None:
    """Without gravity, the pendulum turns at a constant speed, strikes the cone and turns back."""
    for integrator in INTEGRATORS:
        result = run(pendulum(0.5, restitution=0.6, w=[2.0, 0, 0], gravity=0), integrator, stop=0.4)
        strikes = 0.5 / 2.0
        back = 0.5 - 0.6 * 2.0 * (0.4 - strikes)
        assert swings(result)[-1] == pytest.approx(back, abs=1e-9), integrator
        assert result["J.w[1]"][-1] == pytest.approx(-1.2, abs=1e-9)
        assert [text for _, text in result.events] == ["J meets its swing limit"]
        assert result.events[0][0] == pytest.approx(strikes, abs=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_planar_pendulum_strikes_as_a_revolute_one(integrator: str) -> None:
    """A swing through the axis of the cone is that of a revolute joint with a limit on both sides."""
    found = run(pendulum(0.4, restitution=0.7, angle=0.3, w=[2.5, 0, 0]), integrator, stop=2.0)
    source = pendulum(0.4)
    source["joints"]["J"] = {
        "type": "revolute",
        "axis": [1, 0, 0],
        "parent": "ground",
        "child": "rod",
        "limit": {"lower": -0.4, "upper": 0.4, "restitution": 0.7},
        "start": {"phi": 0.3, "w": 2.5, "fixed": True},
    }
    expected = run(source, integrator, stop=2.0)
    assert np.abs(swings(found) - np.abs(expected["J.phi"])).max() < (1e-7 if integrator != "rk4" else 1e-6)
    assert len(found.events) == len(expected.events) > 3
    times = [t for t, _ in expected.events]
    assert [t for t, _ in found.events] == pytest.approx(times, abs=1e-8 if integrator != "rk4" else 1e-6)


def precession(angle: float, spin: float) -> float:
    """The torque of the cone while the axis precesses along it at the rate `spin`, without turns about it:
    with gravity, it turns the angular momentum A spin sin(angle), across the axis, about the vertical.
    """
    weight = MASS * G * ARM * math.sin(angle)
    return ABOUT_JOINT * spin**2 * math.sin(angle) * math.cos(angle) - weight


def on_the_cone(angle: float, rate: float) -> Source:
    """The axis starts on the cone and precesses along it; the body does not turn about its own axis."""
    # The rate about the vertical without its part along the axis of the body, which is (0, 0, 1) in the body.
    w = [0.0, rate * math.sin(angle), 0.0]
    return pendulum(angle, angle=angle, w=w)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_precession_along_the_cone_in_closed_form(integrator: str) -> None:
    """A pendulum faster than a conical one presses against the cone and moves along it uniformly."""
    angle, rate = 0.7, 9.0
    result = run(on_the_cone(angle, rate), integrator, stop=1.0)
    torque = precession(angle, rate)
    assert torque > 1
    t = np.array(result["time"])
    assert np.abs(swings(result) - angle).max() < 1e-9
    assert np.abs(np.array(result["J.limit.tau"]) - torque).max() < 1e-7 * torque
    assert set(result["J.limit.mode"]) == {1.0}
    # The end of the axis is at the azimuth rate t.
    x, y, z, s = (result[f"J.Q[{k}]"] for k in range(1, 5))
    axis = np.array([2 * (x * z + y * s), 2 * (y * z - x * s)]) / math.sin(angle)
    expected = np.array([np.sin(rate * t), -np.cos(rate * t)])
    tolerance = 1e-7 if integrator != "rk4" else 1e-5
    assert np.abs(axis - expected).max() < tolerance
    assert not result.events


def test_lift_off_from_the_cone() -> None:
    """A slower motion than that of the conical pendulum leaves the cone at once, inwards."""
    angle = 0.7
    conical = math.sqrt(MASS * G * ARM / (ABOUT_JOINT * math.cos(angle)))
    result = run(on_the_cone(angle, 1.001 * conical), stop=0.5)
    assert np.abs(swings(result) - angle).max() < 1e-9
    result = run(on_the_cone(angle, 0.9 * conical), stop=0.5)
    assert swings(result)[5] < angle - 1e-4
    assert set(result["J.limit.mode"]) == {0.0}


def test_lift_off_where_the_torque_vanishes() -> None:
    """A weight that grows with time pulls the axis off the cone where it overcomes the centrifugal torque."""
    angle, rate = 0.7, 6.0
    source = on_the_cone(angle, rate)
    source["gravity"] = [0, 0, 0]
    at = [0, 0, -ARM]
    load = {"type": "wrench", "body": "rod", "position": at, "frame": "world", "input": True}
    source["forces"] = {"weight": load}
    result = gelenk.simulate(
        source, stop=1.0, step=0.01, tolerance=1e-10, inputs={"weight.f[3]": lambda t: -40.0 * t}
    )
    lifts = ABOUT_JOINT * rate**2 * math.cos(angle) / (40.0 * ARM)
    assert result.events[0][1] == "J leaves its swing limit"
    assert result.events[0][0] == pytest.approx(lifts, abs=1e-8)


def test_energy_and_angular_momentum_with_elastic_impacts() -> None:
    """Elastic impacts keep the energy, and no torque of the cone is about its axis."""
    source = pendulum(0.6, restitution=1.0, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    result = run(source, stop=3.0, tolerance=1e-11)
    assert sum(text == "J meets its swing limit" for _, text in result.events) > 5
    angular, energy = [], []
    for k in range(len(result["time"])):
        Q = [result[f"J.Q[{i}]"][k] for i in range(1, 5)]
        w = np.array([result[f"J.w[{i}]"][k] for i in (1, 2, 3)])
        x, y, z, s = Q
        R = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * s), 2 * (x * z + y * s)],
                [2 * (x * y + z * s), 1 - 2 * (x * x + z * z), 2 * (y * z - x * s)],
                [2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)],
            ]
        )
        J = np.diag([ABOUT_JOINT, ABOUT_JOINT, INERTIA[2]])
        angular.append((R @ J @ w)[2])
        energy.append(w @ J @ w / 2 - MASS * G * ARM * R[2, 2])
    assert np.ptp(angular) < 1e-9
    assert np.ptp(energy) < 1e-8  # of 2 J, over 10 impacts
    assert np.ptp(result["J.w[3]"]) < 1e-9  # the spin of a symmetric body


def test_time_between_impacts_by_quadrature() -> None:
    """Elastic bounces of a planar swing between both sides of the cone: an integral gives their period."""
    limit, speed = 0.5, 4.0
    result = run(pendulum(limit, restitution=1.0, w=[speed, 0, 0]), stop=2.0, tolerance=1e-11)
    frequency = MASS * G * ARM / ABOUT_JOINT

    def slowness(phi: float) -> float:
        return float(1 / math.sqrt(speed**2 - 2 * frequency * (1 - math.cos(phi))))

    quarter = quad(slowness, 0, limit, epsabs=1e-13)[0]
    times = [t for t, _ in result.events]
    expected = [(2 * n + 1) * quarter for n in range(len(times))]
    assert len(times) > 3
    assert times == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("overshoot", [1e-2, 1e-6])
def test_cone_touched_within_a_step(integrator: str, overshoot: float) -> None:
    """The axis of a ball turns along a circle that leaves the cone a little, for less than a step."""
    tilt, rate = 0.4, 7.0
    limit = 2 * tilt - overshoot
    source = pendulum(limit, restitution=0.5, gravity=0)
    source["bodies"]["rod"] = {"mass": 1.0, "inertia": [0.3, 0.3, 0.3]}
    source["joints"]["J"]["start"]["w"] = [rate * math.sin(tilt), 0, rate * math.cos(tilt)]
    result = run(source, integrator, tolerance=1e-8)
    cosine = (math.cos(limit) - math.cos(tilt) ** 2) / math.sin(tilt) ** 2
    assert result.events[0][0] == pytest.approx(math.acos(cosine) / rate, abs=1e-8)


@pytest.mark.parametrize("swing", [1e-3, 0.1, math.pi / 2, 3.0, math.pi - 1e-3])
def test_narrow_and_wide_cones(swing: float) -> None:
    """Impacts on cones with an apex angle near 0 and near a half turn."""
    speed = 2.0 * swing
    source = pendulum(swing, restitution=0.5, w=[speed, 0, 0], gravity=0)
    result = run(source, stop=1.0, tolerance=1e-10)
    back = swing - 0.5 * speed * (1.0 - 0.5)
    assert swings(result)[-1] == pytest.approx(back, abs=1e-9)
    assert result.events[0][0] == pytest.approx(0.5, abs=1e-8)


def test_spin_while_at_rest_on_the_cone() -> None:
    """An axis that rests on the cone, pressed by gravity, turns about itself as a free body does."""
    angle, spin = 0.4, 5.0
    source = pendulum(angle, angle=angle, gravity=+G)
    result = run(source, stop=1.0)
    assert np.abs(swings(result) - angle).max() < 1e-10
    assert np.abs(result["J.limit.tau"] - MASS * G * ARM * math.sin(angle)).max() < 1e-8
    assert np.abs(result["J.w[1]"]).max() < 1e-12
    source["joints"]["J"]["start"]["w"] = [0, 0, spin]
    # The torques of gravity and of the cone cancel: the spin remains, and precession does not begin.
    result = run(source, stop=1.0)
    assert np.abs(result["J.w[3]"] - spin).max() < 1e-9
    assert np.abs(swings(result) - angle).max() < 1e-9


@pytest.mark.parametrize("integrator", ["auto", "erk", "moreau-jean"])
def test_falls_onto_the_cone_and_rests(integrator: str) -> None:
    """An upright rod falls onto a cone without restitution and rests there."""
    source = pendulum(0.8, angle=0.2, gravity=+G)
    more = {"step": 1e-3} if integrator == "moreau-jean" else {}
    result = run(source, integrator, stop=2.0, **more)
    assert swings(result)[-1] == pytest.approx(0.8, abs=1e-9)
    assert np.abs([result[f"J.w[{k}]"][-1] for k in (1, 2, 3)]).max() < 1e-9
    assert result["J.limit.tau"][-1] == pytest.approx(MASS * G * ARM * math.sin(0.8), rel=1e-6)
    assert result["J.limit.mode"][-1] == 1


def test_time_steps_converge_to_located_events() -> None:
    source = pendulum(0.6, restitution=0.4, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    expected = run(source, "erk", stop=0.8)
    assert len(expected.events) == 2
    for step in (1e-3, 1e-4):
        found = run(source, "moreau-jean", stop=0.8, step=step)
        # An impact is up to a step too early or too late, at 4 rad/s.
        assert np.abs(swings(found) - swings(expected)).max() < 5 * step


def test_reversed_joint_and_turned_in_space() -> None:
    """The bodies of the joint exchanged; and the ground turned by any rotation."""
    source = pendulum(0.6, restitution=0.4, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    expected = run(source, stop=1.5)
    swapped = json.loads(json.dumps(source))
    joint = swapped["joints"]["J"]
    joint["parent"], joint["child"] = "rod", "ground"
    x, y, z, s = joint["start"]["Q"]
    joint["start"]["Q"] = [-x, -y, -z, s]
    R = rotation([x, y, z, s])
    joint["start"]["w"] = list(map(float, -R @ np.array(joint["start"]["w"])))
    found = run(swapped, stop=1.5)
    assert np.abs(swings(found) - swings(expected)).max() < 1e-7
    assert [text for _, text in found.events] == [text for _, text in expected.events]

    turn = turned_about([0.3, -1, 2], 1.1)
    turned = json.loads(json.dumps(source))
    turned["gravity"] = list(map(float, rotation(turn) @ np.array([0, 0, -G])))
    turned["joints"]["J"]["parent"] = {"body": "ground", "rotation": {"quaternion": [turn[3], *turn[:3]]}}
    found = run(turned, stop=1.5)
    assert np.abs(swings(found) - swings(expected)).max() < 1e-7


def rotation(Q: list[float]) -> np.ndarray:
    x, y, z, s = Q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * s), 2 * (x * z + y * s)],
            [2 * (x * y + z * s), 1 - 2 * (x * x + z * z), 2 * (y * z - x * s)],
            [2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_axes_of_the_cone() -> None:
    """Other axes are other joint frames."""
    source = pendulum(0.6, restitution=0.4, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    expected = run(source, stop=1.0)
    other = json.loads(json.dumps(source))
    # A quarter turn of both joint frames about y takes z to x.
    quarter = turned_about([0, 1, 0], math.pi / 2)
    for end, body in (("parent", "ground"), ("child", "rod")):
        other["joints"]["J"][end] = {"body": body, "rotation": {"quaternion": [quarter[3], *quarter[:3]]}}
    back = rotation(quarter).T
    Q = np.array(source["joints"]["J"]["start"]["Q"])
    other["joints"]["J"]["start"]["Q"] = [*map(float, back @ Q[:3]), float(Q[3])]
    other["joints"]["J"]["start"]["w"] = list(map(float, back @ [2.5, 4.0, 3.0]))
    for axis in ("parent_axis", "child_axis"):
        other["joints"]["J"]["limit"][axis] = list(map(float, back @ [0, 0, 2.0]))
    found = run(other, stop=1.0)
    for k in (1, 2, 3):
        mixed = sum(rotation(quarter)[k - 1, i] * np.array(found[f"J.w[{i + 1}]"]) for i in range(3))
        assert np.abs(mixed - expected[f"J.w[{k}]"]).max() < 1e-8


def test_a_joint_that_closes_a_loop() -> None:
    """A ball joint in a loop, whose swing a cone limits: as the limit of the crank that swings it."""

    def loop(limits: bool, restitution: float) -> Source:
        # A parallelogram: the coupler does not turn, and the angle of the rod at B is that of the cranks.
        crank = {"mass": 0.8, "com": [0, 0, -0.2], "inertia": [0.01, 0.01, 0.001]}
        revolute = {"type": "revolute", "axis": [0, 1, 0]}
        A: Source = {
            **revolute,
            "parent": "ground",
            "child": "left",
            "start": {"phi": 0.2, "w": 4.0, "fixed": True},
        }
        C: Source = {
            "type": "spherical",
            "parent": {"body": "coupler", "position": [0.5, 0, 0]},
            "child": {"body": "right", "position": [0, 0, -0.4]},
        }
        if limits:
            C["limit"] = {"swing": 0.5, "restitution": restitution}
        else:
            A["limit"] = {"lower": -0.5, "upper": 0.5, "restitution": restitution}
        return {
            "gelenk": 1,
            "gravity": [0, 0, -G],
            "bodies": {"left": crank, "right": crank, "coupler": {"mass": 1, "inertia": [0.01, 0.02, 0.02]}},
            "joints": {
                "A": A,
                "B": {**revolute, "parent": {"body": "left", "position": [0, 0, -0.4]}, "child": "coupler"},
                "D": {**revolute, "parent": {"body": "ground", "position": [0.5, 0, 0]}, "child": "right"},
                "C": C,
            },
        }

    found = run(loop(True, 0.6), stop=2.0)
    expected = run(loop(False, 0.6), stop=2.0)
    assert len(expected.events) > 2
    assert len(found.events) == len(expected.events)
    assert np.abs(found["A.phi"] - expected["A.phi"]).max() < 1e-7
