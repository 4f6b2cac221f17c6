# SPDX-License-Identifier: BSD-3-Clause
"""Corners that land together: how the impulse is shared among them is not unique, and decides on friction."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve

import gelenk

SIZE = np.array([0.2, 0.15, 0.1])  # m
INERTIA = np.array([0.004, 0.005, 0.006])  # kg m2, of 1 kg
MU = 0.4
EVENTS = ["auto", "erk", "cvode", "dirk"]


def dropped(r: list[float], Q: list[float], v: list[float], w: list[float], **more: Any) -> dict[str, Any]:
    box = {
        "mass": 1.0,
        "inertia": list(INERTIA),
        "shapes": {"hull": {"box": list(SIZE), "surface": "wood"}},
    }
    start = {"r": r, "Q": Q, "v": v, "w": w, "fixed": True}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"box": box},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "joints": {"free": {"type": "free", "parent": "ground", "child": "box", "start": start}},
        "contacts": {"hit": {"between": ["wood", "floor"], "friction": MU}},
        **more,
    }


def yaw_after_five_impacts(tolerance: float, nudge: float = 0.0, integrator: str = "auto") -> float:
    tilted = [0.9689124217106447, 0.2, 0.1, 0.1]
    scene = dropped([0, 0, 0.5], tilted, [0.5, nudge, 0], [1, 2, 0])
    scene["contacts"]["hit"]["restitution"] = 0.2
    scene["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(scene)
    plant.initialize(0.0, tolerance)
    for k in range(1, 54):
        plant.step_to(k / 100)
    return float(plant.output("free.w[3]"))


def test_the_yaw_of_a_dropped_box_does_not_depend_on_rounding() -> None:
    """Starts that differ by rounding, and tolerances, change it by no more than their errors do."""
    at_last = [yaw_after_five_impacts(1e-9, nudge) for nudge in (0.0, 1e-15, -1e-15, 1e-14, 1e-13, -1e-13)]
    assert np.ptp(at_last) < 1e-7 * abs(at_last[0])
    found = [yaw_after_five_impacts(tolerance) for tolerance in (1e-7, 1e-8, 1e-10, 1e-11)]
    assert np.ptp(found) < 1e-5 * abs(found[0])


@pytest.mark.parametrize("integrator", EVENTS)
@pytest.mark.parametrize(
    ("v", "yaw"), [((0.9, 0.0), 6.0), ((0.3, 0.5), -8.0), ((0.0, 0.0), 9.0), ((1.2, -0.4), 0.7)]
)
def test_a_box_that_lands_flat_shares_its_impulse_with_least_norm(
    integrator: str, v: tuple[float, float], yaw: float
) -> None:
    """Without restitution: normal impulses n = N/4 + a x + b y, and friction against the slip that remains.

    The part of normal impulses that changes sign from corner to corner is free; without it they have the
    least norm.
    """
    fall = 1.0  # m/s
    turned = yaw * 0.01  # rad, until it lands
    turn = np.array([[cos(turned), sin(turned)], [-sin(turned), cos(turned)]])
    corners = np.array([(x, y) for x in (-1, 1) for y in (-1, 1)]) * SIZE[:2] / 2 @ turn

    def impulses(after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        vx, vy, w, a, b = after
        n = fall / 4 + a * corners[:, 0] + b * corners[:, 1]
        u = np.array([vx, vy]) + w * np.stack([-corners[:, 1], corners[:, 0]], axis=1)
        return n, -MU * n[:, None] * u / np.linalg.norm(u, axis=1)[:, None]

    def balance(after: np.ndarray) -> list[float]:
        n, f = impulses(after)
        moment = corners[:, 0] @ f[:, 1] - corners[:, 1] @ f[:, 0]
        arm = SIZE[2] / 2
        return [
            v[0] + f[:, 0].sum() - after[0],
            v[1] + f[:, 1].sum() - after[1],
            INERTIA[2] * (yaw - after[2]) + moment,
            corners[:, 0] @ n + arm * f[:, 0].sum(),
            corners[:, 1] @ n + arm * f[:, 1].sum(),
        ]

    exact = fsolve(balance, [v[0] / 2 + 1e-3, v[1] / 2 - 1e-3, 0.7 * yaw, 0, 0], xtol=1e-13)
    assert (impulses(exact)[0] > 0).all()
    scene = dropped([0, 0, SIZE[2] / 2 + 0.01], [0, 0, 0, 1], [*v, -fall], [0, 0, yaw], gravity=[0, 0, 0])
    scene["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(scene)
    plant.initialize(tolerance=1e-9)
    plant.step_to(0.0101)
    found = np.array([plant.output(name) for name in ("free.v[1]", "free.v[2]", "free.w[3]")])
    # What the contacts yield while impulses are determined is 1e-4 of what the box does.
    assert np.abs(found - exact[:3]).max() < 1e-4


def after(scene: dict[str, Any], time: float, names: list[str], **solver: Any) -> np.ndarray:
    plant = gelenk.Simulation(scene | {"solver": solver})
    plant.initialize(tolerance=1e-9)
    plant.step_to(time)
    return np.array([plant.output(name) for name in names])


def test_a_box_that_slides_and_turns_does_so_alike_in_both_schemes() -> None:
    """Time steps kept the share of the step before: later the box turned faster by 28 %."""
    flat = dropped([0, 0, SIZE[2] / 2], [0, 0, 0, 1], [3, 0, 0], [0, 0, 5])
    flat["contacts"]["hit"]["friction"] = 0.2
    names = ["free.v[1]", "free.v[2]", "free.w[3]"]
    exact = after(flat, 0.6, names, integrator="erk")
    errors = [
        np.abs(after(flat, 0.6, names, integrator="moreau-jean", step=h) - exact).max()
        for h in (1e-2, 1e-3, 1e-4)
    ]
    assert errors[0] < 2e-2
    assert errors[1] < 2e-3
    # Shares differ by what the contacts yield while impulses are determined.
    assert errors[2] < 2e-4


def test_another_box_elsewhere_changes_nothing() -> None:
    flat = dropped([0, 0, SIZE[2] / 2], [0, 0, 0, 1], [3, 0, 0], [0, 0, 5])
    alone = after(flat, 0.3, ["free.w[3]"], integrator="moreau-jean", step=1e-3)
    for k in range(6):
        flat["bodies"][f"b{k}"] = {
            "mass": 1.0,
            "inertia": list(INERTIA),
            "shapes": {"hull": {"box": list(SIZE), "surface": f"b{k}"}},
        }
        start = {"r": [k, 2.0, SIZE[2] / 2], "v": [1.0, k, 0.0], "w": [0.0, 0.0, 1.0], "fixed": True}
        flat["joints"][f"j{k}"] = {"type": "free", "parent": "ground", "child": f"b{k}", "start": start}
        flat["contacts"][f"c{k}"] = {"between": [f"b{k}", "floor"], "friction": MU}
    assert after(flat, 0.3, ["free.w[3]"], integrator="moreau-jean", step=1e-3) == pytest.approx(
        alone, abs=1e-12
    )


def test_a_box_that_rolls_over_its_edge_lands_alike_in_both_schemes() -> None:
    """It slides and turns on its edge; when the others land, the share of those that rest decides.

    Steps in which corners at rest were some 1e-8 m above the ground let them exert no impulse, others let
    them: the yaw rate of 2.3 rad/s differed by 0.1 rad/s to either side.
    """
    tilt = 0.3  # rad, about the edge
    height = SIZE[2] / 2 * cos(tilt) + SIZE[1] / 2 * sin(tilt)
    turn = [sin(tilt / 2), 0, 0, cos(tilt / 2)]
    start = {"r": [0, 0, height], "Q": turn, "v": [1.0, 0.4, 0], "w": [-1.0, 0, 3.0]}
    rolled = dropped(start["r"], start["Q"], start["v"], start["w"])
    names = ["free.v[1]", "free.v[2]", "free.w[3]"]
    exact = after(rolled, 0.2, names, integrator="erk")
    assert after(rolled, 0.2, ["hit.gap"], integrator="erk") == pytest.approx(0, abs=1e-9)  # it has landed
    for h in (1e-3, 3e-4, 1e-4, 3e-5):
        found = after(rolled, 0.2, names, integrator="moreau-jean", step=h)
        assert np.abs(found - exact).max() < 6 * h + 1e-4, f"{h}: {found} instead of {exact}"
