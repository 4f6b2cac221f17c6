# SPDX-License-Identifier: BSD-3-Clause
"""Blocks and balls on planes, in steps of 1 ms, against closed forms."""

from math import cos, radians, sin, sqrt

import numpy as np
import pytest
from models.touching import SceneData, inertia_of_box, on_plane

import gelenk

G = 9.81  # m/s2
STEP = 1e-3  # s


def slope(angle: float, friction: float, speed: float) -> SceneData:
    """A block of 0.4 x 0.3 x 0.1 m that starts up a slope with this speed [m/s]; angle [rad]."""
    normal = [sin(angle), 0, cos(angle)]
    return on_plane(
        {"box": [0.4, 0.3, 0.1]},
        2.5,
        inertia_of_box(2.5, [0.4, 0.3, 0.1]),
        {
            "r": [0.05 * n for n in normal],
            "Q": [0, sin(angle / 2), 0, cos(angle / 2)],
            "v": [-speed * cos(angle), 0, speed * sin(angle)],
        },
        {"friction": friction},
        normal=normal,
    )


def along_slope(run: gelenk.Result, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity down the slope [m, m/s]."""
    down = np.array([cos(angle), 0, -sin(angle)])
    r = np.stack([run[f"J.r[{k}]"] for k in (1, 2, 3)], axis=1) - 0.05 * np.array([sin(angle), 0, cos(angle)])
    v = np.stack([run[f"J.v[{k}]"] for k in (1, 2, 3)], axis=1)
    return r @ down, v @ down


@pytest.mark.parametrize("friction", [0.365, 0.37, 0.5, 2.0])
def test_block_sticks_without_creep(friction: float) -> None:
    """The block rests at every margin above tan 20 deg = 0.36397. 1e-12 m/s is the bound of creep."""
    angle = radians(20)
    s, v = along_slope(gelenk.simulate(slope(angle, friction, 0), stop=2, step=0.1), angle)
    assert np.abs(v).max() <= 1e-12
    assert np.abs(s).max() <= 1e-12


def test_block_slides_below_the_limit_of_friction() -> None:
    """Below tan 20 deg, the acceleration is g (sin - mu cos), which steps of order 2 follow to rounding."""
    angle = radians(20)
    s, v = along_slope(gelenk.simulate(slope(angle, 0.363, 0), stop=2, step=0.1), angle)
    a = G * (sin(angle) - 0.363 * cos(angle))
    assert a > 0
    assert s[-1] == pytest.approx(a / 2 * 4, abs=1e-9)  # residuals of 1e-11 of the velocities over 2000 steps
    assert v[-1] == pytest.approx(a * 2, abs=1e-9)


def test_block_that_slides_up_stops_and_stays() -> None:
    """At 30 deg and mu = 0.6 it stops after 3 / (g (sin + mu cos)) s.

    In the step in which it stops, friction acts until its end: an error of at most a h2 / 2 = 5e-6 m.
    """
    angle = radians(30)
    s, v = along_slope(gelenk.simulate(slope(angle, 0.6, 3), stop=1, step=0.1), angle)
    a = G * (sin(angle) + 0.6 * cos(angle))
    assert s[-1] == pytest.approx(-9 / (2 * a), abs=5e-6)
    assert abs(v[-1]) <= 1e-12


def test_block_that_slides_up_slides_back() -> None:
    """The instant of reversal is uncertain by a step: at 2 s an error of up to a h t = 1.2e-3 m."""
    angle = radians(30)
    s, v = along_slope(gelenk.simulate(slope(angle, 0.5, 3), stop=2, step=0.1), angle)
    up, down = (G * (sin(angle) + sign * 0.5 * cos(angle)) for sign in (1, -1))
    t = 2 - 3 / up
    assert s[-1] == pytest.approx(down / 2 * t * t - 9 / (2 * up), abs=down * STEP * t)
    assert v[-1] == pytest.approx(down * t, abs=down * STEP)


def test_bouncing_ball_comes_to_rest_with_its_weight() -> None:
    """Dropped from 1 m with e = 0.5, it strikes infinitely often until 3 t1 = 1.3546 s, t1 that of the fall.

    The first one is up to a step early or late, at a speed of 4.4 m/s.
    """
    ball = on_plane({"sphere": 0.1}, 0.7, [0.4 * 0.7 * 0.01] * 3, {"r": [0, 0, 1.1]}, {"restitution": 0.5})
    run = gelenk.simulate(ball, stop=2, step=STEP)
    t1 = sqrt(2 / G)
    apex = run["J.r[3]"][(run.time > t1) & (run.time < 2 * t1)].max() - 0.1
    assert apex == pytest.approx(0.25, abs=4.4 * STEP)
    assert run["J.r[3]"][-1] == pytest.approx(0.1, abs=1e-9)
    assert abs(run["J.v[3]"][-1]) <= 1e-12
    assert run["floor.f[3]"][-1] == pytest.approx(0.7 * G, rel=1e-9)
    assert run["J.r[3]"].min() >= 0.1 - 1e-9  # penetration is removed in the step in which it arises


def test_ball_that_slides_rolls_in_the_end() -> None:
    """The slip keeps its direction; rolling begins after 2/7 of it over mu g, with v = v0 - 2/7 slip.

    Both phases are integrated exactly; the transition within one step leaves 2 mu g h2.
    """
    R, m, mu = 0.05, 0.17, 0.2
    v0, w0 = np.array([2.0, 0.5]), np.array([0.0, -30.0, 5.0])
    ball = on_plane(
        {"sphere": R},
        m,
        [0.4 * m * R * R] * 3,
        {"r": [0, 0, R], "v": [*v0.tolist(), 0], "w": w0.tolist()},
        {"friction": mu},
    )
    run = gelenk.simulate(ball, stop=1, step=0.1)
    slip = v0 + R * np.array([-w0[1], w0[0]])
    t = 2 / 7 * np.linalg.norm(slip) / (mu * G)
    final = v0 - 2 / 7 * slip
    position = v0 * t - mu * G * t * t / 2 * slip / np.linalg.norm(slip) + final * (1 - t)
    for k in (0, 1):
        assert run[f"J.v[{k + 1}]"][-1] == pytest.approx(final[k], abs=1e-10)
        assert run[f"J.r[{k + 1}]"][-1] == pytest.approx(position[k], abs=2 * mu * G * STEP**2)
    assert run["J.w[3]"][-1] ** 2 + run["J.w[2]"][-1] ** 2 + run["J.w[1]"][-1] ** 2 == pytest.approx(
        25 + (np.linalg.norm(final) / R) ** 2, rel=1e-6
    )  # spin about the normal remains


@pytest.mark.parametrize(("force", "height", "a"), [(3, 0.3, 0), (12, 0.2, 12 / 2 - 0.5 * G)])
def test_pushed_box_stands_or_slides_upright(force: float, height: float, a: float) -> None:
    """A box of 2 kg slides if the force exceeds mu m g = 9.81 N, and does not tip at these heights."""
    size = [0.2, 0.3, 0.6]
    scene = on_plane({"box": size}, 2, inertia_of_box(2, size), {"r": [0, 0, 0.3]}, {"friction": 0.5})
    scene["forces"] = {
        "push": {
            "type": "wrench",
            "body": "body",
            "position": [-0.1, 0, height - 0.3],
            "force": [force, 0, 0],
        }
    }
    run = gelenk.simulate(scene, stop=2, step=0.1)
    assert run["J.r[1]"][-1] == pytest.approx(2 * a, abs=1e-9)
    assert run["J.Q[2]"][-1] == pytest.approx(0, abs=1e-10)
    assert run["floor.f[1]"][-1] == pytest.approx(-min(force, 0.5 * 2 * G), rel=1e-8)
    assert run["floor.mode"][-1] == (2 if a > 0 else 1)


def test_box_on_a_belt_reaches_its_speed() -> None:
    """After mu g t = 1 m/s the box moves with the belt. The instant is uncertain by a step."""
    size = [0.2, 0.2, 0.2]
    law = {"friction": 0.4, "velocity": [1.0, 0, 0]}
    scene = on_plane({"box": size}, 3, inertia_of_box(3, size), {"r": [0, 0, 0.1]}, law)
    run = gelenk.simulate(scene, stop=1, step=0.1)
    assert run["J.v[1]"][1] == pytest.approx(0.4 * G * 0.1, abs=1e-9)
    assert run["J.v[1]"][-1] == pytest.approx(1, abs=1e-10)
    assert run["J.r[1]"][-1] == pytest.approx(1 - 1 / (2 * 0.4 * G), abs=0.4 * G * STEP**2)


def test_static_friction_holds_more_than_sliding_friction() -> None:
    """At 30 deg, tan = 0.577: held by 0.6 at rest, but not by 0.4 once it slides."""
    angle = radians(30)
    law = {"friction": 0.4, "static": 0.6}
    rest, moving = (slope(angle, 0.4, -speed) for speed in (0, 0.1))
    for scene in (rest, moving):
        scene["contacts"]["floor"].update(law)
    assert np.abs(along_slope(gelenk.simulate(rest, stop=1, step=0.1), angle)[1]).max() <= 1e-12
    v = along_slope(gelenk.simulate(moving, stop=1, step=0.1), angle)[1]
    assert v[-1] == pytest.approx(0.1 + G * (sin(angle) - 0.4 * cos(angle)), abs=1e-9)


def test_rolling_friction_stops_a_ball() -> None:
    """The moment f m g of rolling friction decelerates a rolling ball by f g / (1.4 R)."""
    R, m, f, v = 0.05, 0.17, 1e-3, 0.5
    start = {"r": [0, 0, R], "v": [v, 0, 0], "w": [0, v / R, 0]}
    ball = on_plane({"sphere": R}, m, [0.4 * m * R * R] * 3, start, {"friction": 0.5, "rolling": f})
    run = gelenk.simulate(ball, stop=5, step=0.5)
    a = f * G / (1.4 * R)
    assert run["J.v[1]"][2] == pytest.approx(v - a, rel=1e-8)
    assert run["J.r[1]"][-1] == pytest.approx(v * v / (2 * a), abs=a * STEP**2)
    assert abs(run["J.v[1]"][-1]) <= 1e-11


def test_spinning_friction_stops_a_spin() -> None:
    """A ball that spins about the normal with spinning friction f: w falls by f m g / I per second."""
    R, m, f, w = 0.05, 0.17, 1e-4, 1.0
    inertia = 0.4 * m * R * R
    ball = on_plane(
        {"sphere": R}, m, [inertia] * 3, {"r": [0, 0, R], "w": [0, 0, w]}, {"friction": 0.5, "spinning": f}
    )
    run = gelenk.simulate(ball, stop=2, step=0.5)
    assert run["J.w[3]"][1] == pytest.approx(w - f * m * G / inertia * 0.5, rel=1e-8)
    assert abs(run["J.w[3]"][-1]) <= 1e-9


def test_errors_of_a_tipping_box_are_of_the_order_of_the_step() -> None:
    """Under 9 N at 0.5 m a box tips about its front edge: its moments are integrated independently."""
    size = [0.2, 0.3, 0.6]
    inertia = inertia_of_box(2, size)
    edge = 2 * (0.1**2 + 0.3**2) + inertia[1]

    def truth(stop: float) -> float:
        from scipy.integrate import solve_ivp

        def rhs(_: float, y: np.ndarray) -> list[float]:
            c, s = cos(y[0]), sin(y[0])
            # From the front edge, the center of mass is at (-0.1, 0.3), the force acts at (-0.2, 0.5).
            push = 9 * (0.5 * c + 0.2 * s)
            weight = 2 * G * (-0.1 * c + 0.3 * s)
            return [y[1], (push + weight) / edge]

        return float(solve_ivp(rhs, (0, stop), [0, 0], method="DOP853", rtol=1e-12, atol=1e-12).y[0, -1])

    def error(step: float) -> float:
        scene = on_plane({"box": size}, 2, inertia, {"r": [0, 0, 0.3]}, {"friction": 0.5}, step=step)
        scene["forces"] = {
            "push": {
                "type": "wrench",
                "frame": "world",
                "body": "body",
                "position": [-0.1, 0, 0.2],
                "force": [9, 0, 0],
            }
        }
        run = gelenk.simulate(scene, stop=0.2, step=0.1)
        tilt = 2 * np.arctan2(run["J.Q[2]"][-1], run["J.Q[4]"][-1])
        return float(abs(tilt - truth(0.2)))

    coarse, fine = error(2e-3), error(1e-3)
    assert coarse < 1e-3
    assert coarse / fine > 1.6
