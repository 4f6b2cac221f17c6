# SPDX-License-Identifier: BSD-3-Clause
"""Initialization in and beside singular configurations: on a branch of the motion,
refused, or with a warning.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, rod, scene
from scipy.integrate import solve_ivp

import gelenk

ABOUT_Z: dict[str, Any] = {"axis": [0, 0, 1]}
DOWN_Y = [0, -GRAVITY, 0]
L, SPAN = 0.3, 0.8  # m: both cranks, coupler
CRANK, COUPLER, ROCKER = 1.0, 3.5, 3.0  # kg
SPEED = 16.0  # rad/s


def parallelogram(crank: dict[str, Any], rocker: dict[str, Any]) -> Scene:
    """A four-bar of two equal pairs of rods; at 0 rad all are in line, where it may continue crossed. The
    arguments are the start values of the joints on the ground.
    """
    return scene(
        {"crank": rod(CRANK, L), "coupler": rod(COUPLER, SPAN), "rocker": rod(ROCKER, L)},
        {
            "A": joint("revolute", frame("ground"), frame("crank"), **ABOUT_Z, start=crank),
            "B": joint("revolute", frame("crank", (L, 0, 0)), frame("coupler"), **ABOUT_Z),
            "C": joint("revolute", frame("coupler", (SPAN, 0, 0)), frame("rocker", (L, 0, 0)), **ABOUT_Z),
            "D": joint("revolute", frame("ground", (SPAN, 0, 0)), frame("rocker"), **ABOUT_Z, start=rocker),
        },
        gravity=DOWN_Y,
    )


def pendulum_acceleration(phi: float) -> float:
    """Acceleration of the cranks on the uncrossed branch, where the coupler only translates: a pendulum."""
    inertia = (CRANK + ROCKER) * L**2 / 3 + COUPLER * L**2
    return -GRAVITY * math.cos(phi) * L * ((CRANK + ROCKER) / 2 + COUPLER) / inertia


def pendulum_speed(phi: float, time: float) -> float:
    run = solve_ivp(
        lambda _t, y: [y[1], pendulum_acceleration(y[0])],
        (0, time),
        [phi, SPEED],
        "DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    return float(run.y[1, -1])


def started(source: Scene) -> tuple[gelenk.Simulation, list[str]]:
    plant = gelenk.Simulation(gelenk.load(source))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", gelenk.StartWarning)
        plant.initialize(0.0, 1e-10)
    return plant, [str(w.message) for w in caught]


# Round-off of 2e-16 in the closed loop leaves 2e-16 / ratio^2 of the velocities undetermined, and where these
# follow from the condition of the branch, the ratio itself: at worst 2e-5, at 3e-6 rad.
@pytest.mark.parametrize("guess", [1e-3, 0.0, 1e-6])
@pytest.mark.parametrize("phi", [0.0, 1e-12, 1e-8, 1e-7, 1e-6, 3e-6, 1e-5, 3e-5])
def test_start_beside_a_change_point_selects_the_intended_branch(phi: float, guess: float) -> None:
    """A regression test: this start gave D.w = 15.18 rad/s and accelerations of 1e7
    rad/s2 without a warning.
    """
    crank = {"phi": phi, "w": SPEED, "fixed": True}
    plant, warned = started(parallelogram(crank, {"phi": guess, "w": 15.0}))
    assert len(warned) == 1
    assert "singular configuration of the loop through" in warned[0]
    assert plant.output("A.w") == SPEED
    assert plant.output("D.w") == pytest.approx(SPEED, rel=3e-5)
    for name in ("A.a", "D.a"):
        assert plant.output(name) == pytest.approx(pendulum_acceleration(phi), rel=1e-3)
    energy = plant.diagnostics["energy.total"]
    plant.step_to(0.02)
    for name in ("A.w", "D.w"):
        assert plant.output(name) == pytest.approx(pendulum_speed(phi, 0.02), rel=1e-4)
    kinetic = plant.diagnostics["energy.kinetic"]
    assert plant.diagnostics["energy.total"] == pytest.approx(energy, abs=1e-4 * kinetic)


def test_start_at_a_regular_position_gives_no_warning() -> None:
    plant, warned = started(parallelogram({"phi": 1e-3, "w": SPEED, "fixed": True}, {"phi": 1e-3}))
    assert warned == []
    assert plant.output("D.w") == pytest.approx(SPEED, rel=1e-9)  # 2e-16 / 1e-6, and the factor of the
    # arithmetic
    assert plant.output("D.a") == pytest.approx(pendulum_acceleration(1e-3), rel=1e-5)


def test_fixed_speeds_inconsistent_with_all_branches_are_refused() -> None:
    """At the change point the velocity constraints permit any pair of speeds,
    but each branch has its own ratio.
    """
    fixed = {"phi": 0.0, "w": SPEED, "fixed": True}
    with pytest.raises(gelenk.AssemblyError) as caught:
        started(parallelogram(fixed, {"phi": 0.0, "w": 5.0, "fixed": ["w"]}))
    message = str(caught.value)
    assert "no branch has the fixed start velocities of A, D" in message
    assert "singular configuration of the loop through" in message


def test_both_branches_can_be_selected() -> None:
    """On the crossed branch the rocker turns the other way: the speeds of the two branches are the roots of
    one quadratic equation, determined here by closing the loop a small distance away.
    """
    h = 1e-4
    crank = np.array([L * math.cos(h), L * math.sin(h)])
    to = np.array([SPAN, 0]) - crank
    reach = float(np.linalg.norm(to))
    corner = math.acos((reach**2 + L**2 - SPAN**2) / (2 * reach * L))
    leans = [math.atan2(-to[1], -to[0]) + side * corner for side in (1, -1)]
    angles = [(math.remainder(lean, 2 * math.pi)) for lean in leans]
    for angle in angles:
        plant, warned = started(
            parallelogram({"phi": 0.0, "w": SPEED, "fixed": True}, {"phi": 0.0, "w": 0.9 * SPEED * angle / h})
        )
        assert warned
        # The chord of the branch differs from its tangent by h.
        assert plant.output("D.w") == pytest.approx(SPEED * angle / h, rel=10 * h)


def test_rest_in_a_singular_configuration_gives_a_warning() -> None:
    _, warned = started(parallelogram({"phi": 0.0, "fixed": True}, {"phi": 0.0}))
    assert len(warned) == 1
    assert "at rest nothing determines the branch" in warned[0]


@pytest.mark.parametrize("guess", [0.0, 1e-7, 1e-3, 0.3, -0.4])
def test_slider_speed_at_a_dead_center_is_refused(guess: float) -> None:
    """A slider-crank that is fully extended cannot move its slider. Divided by a pivot of the order of
    round-off, 1 m/s became 8.2e6 rad/s.
    """
    source = scene(
        {"crank": rod(1, 0.1), "rod": rod(1, 0.3), "slider": body(1, inertia=(0.01, 0.01, 0.01))},
        {
            "A": joint("revolute", frame("ground"), frame("crank"), **ABOUT_Z, start={"phi": guess}),
            "B": joint(
                "revolute", frame("crank", (0.1, 0, 0)), frame("rod"), **ABOUT_Z, start={"phi": -guess}
            ),
            "wrist": joint("revolute", frame("rod", (0.3, 0, 0)), frame("slider"), **ABOUT_Z),
            "track": joint(
                "prismatic", frame("ground"), frame("slider"), axis=[1, 0, 0],
                start={"s": 0.4, "v": 1.0, "fixed": True},
            ),
        },
        gravity=DOWN_Y,
    )  # fmt: skip
    with pytest.raises(gelenk.AssemblyError, match="fixed start velocities of track contradict the loops"):
        started(source)


def polygon(angles: list[float]) -> Scene:
    """A chain of rods of 1 m; the joint that pins the end of the last to the ground has no start values."""
    end = np.zeros(2)
    heading = 0.0
    bodies, joints = {}, {}
    for i, angle in enumerate(angles):
        bodies[f"rod{i}"] = rod(1, 1)
        at = frame("ground") if i == 0 else frame(f"rod{i - 1}", (1, 0, 0))
        joints[f"J{i}"] = joint("revolute", at, frame(f"rod{i}"), **ABOUT_Z, start={"phi": angle})
        heading += angle
        end += [math.cos(heading), math.sin(heading)]
    last = frame(f"rod{len(angles) - 1}", (1, 0, 0))
    joints["close"] = joint("revolute", frame("ground", (*end, 0)), last, **ABOUT_Z)
    return scene(bodies, joints, gravity=DOWN_Y)


@pytest.mark.parametrize("rods", [3, 61, 101])
def test_closed_start_configuration_is_not_changed(rods: int) -> None:
    """A regression test: the angle of the loop-closing joint, which has no start value,
    displaced the others by 1e-4 of itself.
    """
    angles = [1.2, -1.2, -1.2] + [0.3, -0.25] * ((rods - 3) // 2)
    plant, _ = started(polygon(angles))
    for i, angle in enumerate(angles):
        # Sums of this many unit vectors are rounded by 2e-16 each.
        assert plant.output(f"J{i}.phi") == pytest.approx(angle, abs=2e-16 * 10 * rods)


@pytest.mark.parametrize("phi", [0.0, 1e-7, 1e-6, 3e-6])
def test_speeds_consistent_with_a_branch_are_kept(phi: float) -> None:
    """With both speeds given consistently with the branch nothing remains to be solved for; J v = 0 alone,
    with a pivot of this size, would change the guess by 2e-16 / phi^2.
    """
    crank = {"phi": phi, "w": SPEED, "fixed": True}
    plant, _ = started(parallelogram(crank, {"phi": 1e-3 * phi, "w": SPEED}))
    assert plant.output("D.w") == pytest.approx(SPEED, rel=1e-9)  # Newton tolerance, 1e-10 of the square
