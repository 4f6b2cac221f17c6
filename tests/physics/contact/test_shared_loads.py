# SPDX-License-Identifier: BSD-3-Clause
"""A held joint and a contact with friction share a load, of which rigid bodies determine no shares.

The forces that are found obey the laws, and a warning names the contact and the joint.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

G = 10.0  # m/s2
SLIDE, WHEEL, RADIUS, INERTIA = 5.0, 2.0, 0.2, 0.04  # kg, kg, m, kg m2
STEP = 1e-3  # s
LOCATED = ("auto", "erk", "cvode")
SCHEMES = (*LOCATED, "moreau-jean")
HELD: dict[str, dict[str, Any]] = {
    "lock": {"lock": {"engaged": True}},
    "friction": {"friction": {"coulomb": 1000}},
    "limit": {"limit": {"lower": 0.0}},
}


def wheel(integrator: str, held: dict[str, Any], *, friction: float = 0.5, w: float = 0.0) -> dict[str, Any]:
    """A carrier along x, on it a slide along z, on that a wheel with a motor on the ground."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "solver": {"integrator": integrator, "step": STEP},
        "bodies": {
            "carrier": {"mass": 0},
            "slide": {"mass": SLIDE},
            "wheel": {
                "mass": WHEEL, "inertia": [INERTIA] * 3,
                "shapes": {"ball": {"sphere": RADIUS, "surface": "wheel"}},
            },
        },
        "joints": {
            "x": {
                "type": "prismatic", "axis": [1, 0, 0], "child": "carrier",
                "parent": {"body": "ground", "position": [0, 0, RADIUS]},
                "start": {"s": 0.0, "v": -2.0, "fixed": True},
            },
            "z": {"type": "prismatic", "axis": [0, 0, 1], "parent": "carrier", "child": "slide", **held},
            "w": {
                "type": "revolute", "axis": [0, 1, 0], "parent": "slide", "child": "wheel",
                "start": {"phi": 0.0, "w": w, "fixed": True},
            },
        },
        "motors": {"m": {"joint": "w"}},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["wheel", "floor"], "friction": friction}},
    }  # fmt: skip


def said(result: gelenk.Result) -> list[str]:
    return [line for line in result.warnings if "more than one motion" in line]


def run(scene: dict[str, Any], torque: float = 20.0) -> gelenk.Result:
    outputs = ["x.v", "x.a", "w.a", "k.f[1]", "k.f[3]"]
    return gelenk.simulate(scene, stop=0.02, step=STEP, inputs={"m.tau": torque}, outputs=outputs)


@pytest.mark.parametrize("kind", HELD)
@pytest.mark.parametrize("integrator", SCHEMES)
def test_a_load_that_a_sliding_contact_shares_is_said(integrator: str, kind: str) -> None:
    """Normal forces from 0 to all of the weight obey the laws, and friction brakes the wheel by them."""
    result = run(wheel(integrator, HELD[kind]))
    assert any("k: how it shares its load with z" in line for line in said(result))
    normal, friction = result["k.f[3]"][-1], result["k.f[1]"][-1]
    assert -1e-6 <= normal <= (SLIDE + WHEEL) * G + 1e-6
    assert friction == pytest.approx(0.5 * normal, rel=1e-3, abs=1e-3)
    assert (SLIDE + WHEEL) * result["x.a"][-1] == pytest.approx(friction, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("integrator", SCHEMES)
def test_a_contact_that_holds_as_a_joint_presses_on_it_is_said(integrator: str) -> None:
    """Rolling takes more friction than the weight permits; time steps begin to slide with less."""
    needed = 20.0 / (RADIUS + INERTIA / ((SLIDE + WHEEL) * RADIUS))
    assert needed > 0.5 * (SLIDE + WHEEL) * G
    result = run(wheel(integrator, HELD["lock"], w=-10.0))
    if integrator in LOCATED:
        assert result["k.f[1]"][-1] == pytest.approx(needed, rel=1e-6)
    else:
        assert result["k.f[1]"][-1] == pytest.approx(0.5 * result["k.f[3]"][-1], rel=1e-6)
    assert said(result) != []


@pytest.mark.parametrize("integrator", LOCATED)
def test_a_contact_that_rolls_by_its_load_is_not(integrator: str) -> None:
    result = run(wheel(integrator, HELD["friction"], w=-10.0), torque=2.0)
    assert result["k.f[1]"][-1] == pytest.approx(
        2.0 / (RADIUS + INERTIA / ((SLIDE + WHEEL) * RADIUS)), rel=1e-6
    )
    assert said(result) == []


@pytest.mark.parametrize("integrator", SCHEMES)
def test_a_contact_without_friction_is_not(integrator: str) -> None:
    """Its share changes no motion."""
    result = run(wheel(integrator, HELD["lock"], friction=0.0))
    np.testing.assert_allclose(result["x.v"], -2.0, atol=1e-9)
    np.testing.assert_allclose(result["w.a"][1:], 20.0 / INERTIA, rtol=1e-6)
    assert said(result) == []


@pytest.mark.parametrize("integrator", SCHEMES)
def test_a_contact_that_bears_the_load_alone_is_not(integrator: str) -> None:
    result = run(wheel(integrator, {}))
    assert result["k.f[3]"][-1] == pytest.approx((SLIDE + WHEEL) * G, rel=1e-6)
    assert result["x.a"][-1] == pytest.approx(0.5 * G, rel=1e-6)
    assert said(result) == []


ARM, HEIGHT = 0.6, 0.3  # m: from the hinge to the contact, along x and z


def arm(integrator: str) -> dict[str, Any]:
    """The wheel does not turn, but hangs on an arm behind a hinge on the slide, which is held."""
    scene = wheel(integrator, HELD["lock"])
    scene["bodies"]["wheel"]["com"] = [0.0, 0.0, 0.0]
    scene["joints"]["z"]["parent"] = {"body": "carrier", "position": [0, 0, HEIGHT - RADIUS]}
    scene["joints"]["w"] = {
        "type": "revolute", "axis": [0, 1, 0], "parent": "slide",
        "start": {"phi": 0.0, "w": 0.0, "fixed": True},
        "child": {"body": "wheel", "position": [ARM, 0, HEIGHT - RADIUS]},
    }  # fmt: skip
    return scene


@pytest.mark.parametrize("integrator", SCHEMES)
def test_a_held_joint_beside_a_contact_with_a_force_of_its_own_is_not(integrator: str) -> None:
    """The moments about the hinge determine the normal force; unknown: the acceleration along x, and it.

    The wheel is at (-ARM, RADIUS - HEIGHT) from the hinge, its contact at (-ARM, -HEIGHT).
    """
    mu = 0.5
    A = [[SLIDE + WHEEL, -mu], [WHEEL * (RADIUS - HEIGHT), -(mu * -HEIGHT + ARM)]]
    acceleration, normal = np.linalg.solve(A, [0.0, -WHEEL * G * ARM])
    result = run(arm(integrator), torque=0.0)
    assert result["k.f[3]"][-1] == pytest.approx(normal, rel=1e-3)
    assert result["x.a"][-1] == pytest.approx(acceleration, rel=1e-3)
    assert said(result) == []
