# SPDX-License-Identifier: BSD-3-Clause
"""Closed contacts of which no linear model is known: refused by name, never wrong."""

from __future__ import annotations

from typing import Any

import pytest

import gelenk

CART: dict[str, Any] = {
    "mass": 3,
    "inertia": [0.1, 0.1, 0.1],
    "shapes": {"plate": {"box": [1, 1, 0.1], "surface": "plate"}},
}


def on_a_cart(shape: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "cart": CART,
            "load": {"mass": 2, "inertia": [0.01] * 3, "shapes": {"skin": {**shape, "surface": "skin"}}},
            "pinion": {"mass": 0.3, "inertia": [1e-3] * 3},
        },
        "joints": {
            "rail": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "cart"},
            "P": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "ground",
                "child": "pinion",
                "friction": {"coulomb": 0.01},
            },
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "load",
                "start": {"r": [0, 0, 0.15], "fixed": True},
            },
        },
        "contacts": {"c": {"between": ["skin", "plate"], "friction": 0.6}},
        **keys,
    }


def test_losses_of_a_rack_beside_a_contact() -> None:
    """The losses depend on the force of the contact; without losses there is a model."""

    def source(efficiency: float) -> dict[str, Any]:
        rack = {"type": "rack", "rack": "rail", "pinion": "P", "radius": 0.05, "efficiency": efficiency}
        out = on_a_cart({"sphere": 0.1}, constraints={"rk": rack})
        out["joints"]["rail"]["start"] = {"v": 0.2, "fixed": True}
        out["joints"]["J"]["start"]["v"] = [0.2, 0, 0]
        return out

    with pytest.raises(
        gelenk.errors.UsageError, match=r"contacts\.c is closed beside a gear or rack with losses"
    ):
        gelenk.linear.linear_model(gelenk.load(source(0.8)))
    assert gelenk.linear.linear_model(gelenk.load(source(1.0))).states


def test_a_prescribed_speed_under_what_sticks() -> None:
    """The position of the cart is free, but none of the states; a prescribed position has a model."""

    def source(quantity: str) -> dict[str, Any]:
        motion = {"type": "motion", "joint": "rail", "input": quantity}
        return on_a_cart({"box": [0.2, 0.2, 0.2]}, constraints={"m": motion})

    with pytest.raises(
        gelenk.errors.UsageError, match=r"contacts\.c sticks at rest in a mechanism of which a speed"
    ):
        gelenk.linear.linear_model(gelenk.load(source("speed")))
    assert gelenk.linear.linear_model(gelenk.load(source("position"))) is not None


def on_spheres(*places: list[float]) -> dict[str, Any]:
    """Return a sphere of 0.1 m on fixed ones without friction."""
    fixed = {f"s{i}": {"sphere": 0.1, "position": place} for i, place in enumerate(places)}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "load": {
                "mass": 1,
                "inertia": [4e-3] * 3,
                "shapes": {"skin": {"sphere": 0.1, "surface": "skin"}},
            }
        },
        "ground": {"shapes": {name: {**shape, "surface": name} for name, shape in fixed.items()}},
        "joints": {
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "load",
                "start": {"r": [0, 0, 0], "fixed": True},
            }
        },
        "contacts": {f"on_{name}": {"between": ["skin", name]} for name in fixed},
    }


def test_a_sphere_wedged_among_three() -> None:
    """Along y it falls as an inverted pendulum, the faster the more the three press, which is undetermined.

    Between two spheres their forces are: 9.81 / 0.16 1/s2, from the height of its center above theirs.
    """
    model = gelenk.linearize(on_spheres([-0.12, 0, -0.16], [0.12, 0, -0.16]))
    fastest = max(model.poles().real)
    assert fastest**2 == pytest.approx(9.81 / 0.16, rel=1e-9)
    wedged = on_spheres([-0.12, 0, -0.16], [0.12, 0, -0.16], [0, 0, -0.2])
    with pytest.raises(gelenk.errors.UsageError, match=r"contacts\.on_s0 is wedged among others"):
        gelenk.linearize(wedged)
