# SPDX-License-Identifier: BSD-3-Clause
"""Linear models with closed contacts, against closed forms: what rolls, rocks, slides and is held."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from models.standing import TURNED, UNTURNED, G, free_body, poles
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

import gelenk

# Positions are closed to 1e-10 m, of which derivatives depend with factors of order 1.
CLOSED_FORM = 1e-9

TURNS = pytest.mark.parametrize("turn", [UNTURNED, TURNED], ids=["upright", "turned"])


def model(source: dict[str, Any], **arguments: Any) -> gelenk.linear.LinearModel:
    return gelenk.linear.linear_model(gelenk.load(source), **arguments)


def assert_poles(found: Array, expected: list[complex]) -> None:
    assert len(found) == len(expected)
    distance = np.abs(found[:, None] - np.array(expected))
    rows, columns = linear_sum_assignment(distance)
    for i, k in zip(rows, columns, strict=True):
        # A pair at zero is a double eigenvalue, whose error is the root of that of the matrix.
        bound = 1e-5 if expected[k] == 0 else CLOSED_FORM * abs(expected[k])
        assert distance[i, k] <= bound, (found, expected)


@TURNS
def test_a_ball_on_a_ball_falls_off_as_curvatures_say(turn: Rotation) -> None:
    """It rolls on a fixed ball: 7/5 (R + r) phi'' = g phi, in both directions; it spins freely."""
    r, R = 0.1, 0.35  # m
    ball = free_body(
        {"sphere": r}, 2.0, [0.4 * 2.0 * r**2] * 3, [0, 0, R + r], turn=turn, on={"ball": {"sphere": R}}
    )
    found = model(ball)
    growth = sqrt(5 * G / (7 * (R + r)))
    assert_poles(poles(found.A), [growth, growth, -growth, -growth, 0, 0])
    assert found.residual_rates == ""


@TURNS
def test_a_roly_poly_swings(turn: Rotation) -> None:
    """The center of mass is e below the center of a ball on a plane: (I + m (r - e)^2) phi'' = -m g e phi."""
    m, r, e, inertia = 3.0, 0.2, 0.05, 0.03
    toy = free_body(
        {"sphere": r}, m, [inertia, inertia, 0.02], [0, 0, r], turn=turn, com=[0, 0, -e], friction=0.4
    )
    omega = sqrt(m * G * e / (inertia + m * (r - e) ** 2))
    assert_poles(poles(model(toy).A), [omega * 1j, omega * 1j, -omega * 1j, -omega * 1j, 0, 0])


@TURNS
@pytest.mark.parametrize("radius", [0.5, 0.05])
def test_a_box_on_a_ball_rocks_if_it_is_flat(turn: Rotation, radius: float) -> None:
    """Its center is h above the top of a ball of radius R: (I + m h^2) phi'' = -m g (R - h) phi."""
    m, size = 1.5, (0.4, 0.3, 0.2)
    h = size[2] / 2
    moments = [
        m / 12 * (b**2 + c**2) for b, c in ((size[1], size[2]), (size[0], size[2]), (size[0], size[1]))
    ]
    box = free_body(
        {"box": list(size)}, m, moments, [0, 0, radius + h], turn=turn, on={"ball": {"sphere": radius}}
    )
    roots = [np.sqrt(complex(-m * G * (radius - h) / (own + m * h**2))) for own in moments[:2]]
    assert_poles(poles(model(box).A), [*roots, *(-root for root in roots), 0, 0])


@TURNS
def test_an_upright_wheel_falls_over_its_crown(turn: Rotation) -> None:
    """It rolls on a crown of radius k across its tread: (I + m r^2) phi'' = m g (r - k) phi."""
    m, r, k, lean, spin = 2.0, 0.3, 0.04, 0.05, 0.09
    axis = {"rotation": {"axis": [1, 0, 0], "angle": np.pi / 2}}
    wheel = free_body(
        {"wheel": {"radius": r, "crown": k}, **axis}, m, [lean, spin, lean], [0, 0, r], turn=turn
    )
    growth = sqrt(m * G * (r - k) / (lean + m * r**2))
    assert_poles(poles(model(wheel).A), [growth, -growth, 0, 0, 0, 0])


@TURNS
def test_a_box_on_its_edge_is_an_inverted_pendulum(turn: Rotation) -> None:
    """Its two corners stick: it turns about the edge between them, at the distance d from its center."""
    m, a, b = 2.0, 0.3, 0.2  # kg, m: across, high
    d = sqrt(a**2 + b**2) / 2
    moments = [m / 12 * (0.25**2 + b**2), m / 12 * (a**2 + b**2), m / 12 * (a**2 + 0.25**2)]
    tilt = Rotation.from_euler("y", -np.arctan2(a, b))  # the corner (a, ., -b) / 2 is below the center
    box = free_body({"box": [a, 0.25, b]}, m, moments, [0, 0, d], turn=turn, own=tilt.inv())
    growth = sqrt(m * G * d / (moments[1] + m * d**2))
    found = model(box)
    assert_poles(poles(found.A), [growth, -growth])


def test_a_box_at_rest_has_no_states() -> None:
    """Four corners keep it, redundantly; the force of the floor follows the load."""
    box = free_body({"box": [0.4, 0.3, 0.2]}, 2.0, [0.1] * 3, [0, 0, 0.1], friction=0.5)
    found = model(box)
    assert found.states == ()
    to_force = found.D[[found.outputs.index(f"floor.f[{i}]") for i in (1, 2, 3)]]
    loads = [found.inputs.index(f"push.f[{i}]") for i in (1, 2, 3)]
    assert np.abs(to_force[:, loads] + np.eye(3)).max() <= CLOSED_FORM  # on the body: against the load


def on_rails(friction: float | Mapping[str, Any], *, speed: float = 0.0, **plane: Any) -> dict[str, Any]:
    """A block of 2 kg on two slides, along x with a spring and a damper and along z, on a plane or a belt."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "carrier": {"mass": 1.0, "inertia": [1, 1, 1]},
            "block": {
                "mass": 2.0, "inertia": [0.1] * 3, "shapes": {"foot": {"sphere": 0.1, "surface": "wood"}}
            },
        },
        "ground": {"shapes": {"plane": {"plane": [0, 0, 1], "surface": "floor", **plane}}},
        "joints": {
            "x": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "carrier",
                "stiffness": 30.0, "damping": 0.7, "start": {"s": 0.4, "v": speed, "fixed": True},
            },
            "z": {
                "type": "prismatic", "axis": [0, 0, 1], "parent": "carrier", "child": "block",
                "start": {"s": 0.1, "fixed": True},
            },
        },
        "motors": {"pull": {"joint": "x"}, "lift": {"joint": "z"}},
        "contacts": {"floor": {"between": ["wood", "floor"], **(
            friction if isinstance(friction, dict) else {"friction": friction}
        )}},
    }  # fmt: skip


@pytest.mark.parametrize("direction", [1, -1])
def test_a_sliding_block_has_a_friction_that_follows_its_load(direction: int) -> None:
    """3 x'' = -30 x - 0.7 x' - sign mu (2 g - lift) + pull."""
    found = model(on_rails(0.3, speed=0.5 * direction))
    assert found.states == ("x.s", "x.v")
    A = np.array([[0.0, 1], [-30 / 3, -0.7 / 3]])
    B = np.array([[0.0, 0], [1 / 3, 0.3 * direction / 3]])
    assert np.abs(found.A - A).max() <= CLOSED_FORM
    assert np.abs(found.B - B).max() <= CLOSED_FORM


def test_a_block_on_a_belt_oscillates_about_the_pull_of_friction() -> None:
    """At rest in space, it slides on a belt that moves along x: friction is constant."""
    source = on_rails({"friction": 0.3, "velocity": [1.0, 0, 0]})
    source["contacts"]["floor"]["between"] = ["wood", "floor"]
    source["joints"]["x"]["start"]["s"] = 0.3 * 2 * G / 30
    found = model(source)
    assert np.abs(found.A - np.array([[0.0, 1], [-30 / 3, -0.7 / 3]])).max() <= CLOSED_FORM
    assert found.residual_rates == ""


def test_friction_of_contacts_can_be_treated() -> None:
    source = on_rails(0.9)
    source["joints"]["x"]["start"]["s"] = 0.0
    assert model(source).states == ()
    free = np.array([[0.0, 1], [-30 / 3, -0.7 / 3]])
    for friction in ("sliding", "off"):
        found = model(source, friction=friction)
        assert found.states == ("x.s", "x.v")
        assert np.abs(found.A - free).max() <= CLOSED_FORM
    sliding = on_rails(0.3, speed=0.5)
    assert model(sliding, friction="locked").states == ()
    off = model(sliding, friction="off")
    assert np.abs(off.B - [[0, 0], [1 / 3, 0]]).max() <= CLOSED_FORM


def test_a_wheel_on_an_axle_rolls_with_its_carriage() -> None:
    """(M + m + I / r^2) x'' = -k x: the friction that keeps it rolling is inside."""
    source = on_rails(0.9)
    source["joints"]["x"]["start"]["s"] = 0.0
    source["joints"]["x"]["damping"] = 0.0
    wheel = {"mass": 0.5, "inertia": [0.01, 0.02, 0.01], "shapes": source["bodies"]["block"].pop("shapes")}
    source["bodies"]["wheel"] = wheel
    source["joints"]["axle"] = {
        "type": "revolute", "axis": [0, 1, 0], "parent": "block", "child": "wheel"
    }  # fmt: skip
    found = model(source)
    omega = sqrt(30 / (1 + 2 + 0.5 + 0.02 / 0.1**2))
    assert_poles(poles(found.A), [omega * 1j, -omega * 1j])


def disc(constraint: bool, speed: float) -> dict[str, Any]:
    """A disc of 0.3 m that rolls along x, by a contact or by the constraint `rolling`."""
    r, m = 0.3, 2.0
    axis = {"rotation": {"axis": [1, 0, 0], "angle": np.pi / 2}}
    moments = [m * r**2 / 4, m * r**2 / 2, m * r**2 / 4]
    out = free_body(
        {"wheel": {"radius": r}, **axis}, m, moments, [0, 0, r], v=[speed, 0, 0], w=[0, speed / r, 0]
    )
    if constraint:
        del out["contacts"], out["bodies"]["body"]["shapes"], out["ground"]
        out["constraints"] = {"rim": {"type": "rolling", "body": "body", "axis": [0, 1, 0], "radius": r}}
    return out


@pytest.mark.parametrize("speed", [0.0, 0.5, 2.0])
def test_a_rolling_disc_is_the_wheel_of_the_constraint(speed: float) -> None:
    """The constraint `rolling` holds without a contact what a contact holds that sticks."""
    found = model(disc(False, speed))
    coordinates = [name for name in found.states if ".v" not in name and ".w" not in name]
    assert len(coordinates) == (3 if speed == 0 else 5)
    same = model(disc(True, speed), states=model(disc(True, speed)).states)
    if speed > 0:
        other = model(disc(False, speed), states=same.states)
        assert np.abs(other.A - same.A).max() <= CLOSED_FORM * np.abs(same.A).max()
        assert np.abs(other.B - same.B).max() <= CLOSED_FORM * np.abs(same.B).max()
    else:  # at rest, what sticks keeps its position, which the constraint counts among the states
        kept = [pole for pole in poles(same.A) if abs(pole) > 1e-4]
        assert_poles(np.array([pole for pole in poles(found.A) if abs(pole) > 1e-4]), kept)


@pytest.mark.parametrize(
    ("why", "source"),
    [
        (
            "floor touches without a force",
            free_body({"sphere": 0.1}, 1.0, [0.01] * 3, [0, 0, 0.1], gravity=(0, 0, 0)),
        ),
        (
            "floor is about to be struck",
            free_body({"sphere": 0.1}, 1.0, [0.01] * 3, [0, 0, 0.1], v=(0, 0, -1)),
        ),
        (
            "floor is between sticking and sliding",
            free_body(
                {"box": [0.4, 0.3, 0.2]}, 2.0, [0.1] * 3, [0, 0, 0.1], friction=0.5,
                gravity=(0.5 * 8, 0, -8),
            ),
        ),
    ],
)  # fmt: skip
def test_at_the_edge_of_a_law_there_is_no_linear_model(why: str, source: dict[str, Any]) -> None:
    with pytest.raises(gelenk.UsageError, match=f"contacts.{why}.*derivatives do not exist"):
        model(source)


def test_a_box_that_is_about_to_tip_has_no_linear_model() -> None:
    """The resultant is at its edge: one more newton, and two corners open."""
    box = free_body({"box": [0.2, 0.2, 0.4]}, 1.0, [0.02] * 3, [0, 0, 0.2], gravity=(4.0, 0, -8.0))
    with pytest.raises(gelenk.UsageError, match=r"contacts.floor touches without a force"):
        model(box)
    for inside in (3.999, -3.999):
        assert model(box | {"gravity": [inside, 0, -8.0]}).states == ()


def test_an_fmu_has_the_same_linear_model(tmp_path: Path) -> None:
    """Its directional derivatives project the directions of its states as contacts permit."""
    r, R = 0.1, 0.35
    ball = free_body({"sphere": r}, 2.0, [0.008] * 3, [0, 0, R + r], turn=TURNED, on={"ball": {"sphere": R}})
    own = model(ball)
    fmu = gelenk.linear.linear_model(gelenk.export_fmu(gelenk.load(ball), tmp_path / "ball.fmu"))
    assert fmu.states == own.states
    for name in ("A", "B"):
        difference = np.abs(getattr(fmu, name) - getattr(own, name)).max()
        assert difference <= 1e-12 * np.abs(getattr(own, name)).max()


def test_modes_of_what_rolls_are_told() -> None:
    """Those of a roly-poly, of which the third is the spin about the normal."""
    m, r, e, inertia = 3.0, 0.2, 0.05, 0.03
    toy = free_body({"sphere": r}, m, [inertia, inertia, 0.02], [0, 0, r], com=[0, 0, -e], friction=0.4)
    found = gelenk.modes(gelenk.load(toy))
    omega = sqrt(m * G * e / (inertia + m * (r - e) ** 2))
    frequencies = sorted(mode.natural_frequency for mode in found.modes)
    assert frequencies[-2:] == pytest.approx([omega] * 2, rel=CLOSED_FORM)


def test_redundant_forces_have_no_derivatives() -> None:
    """A box between two fingers: how they share its weight is not determined, their motion is."""
    finger = {"box": [0.02, 0.1, 0.1], "surface": "rubber"}
    source = {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            **{k: {"mass": 0.2, "inertia": [1e-3] * 3, "shapes": {"pad": finger}} for k in "ab"},
            "part": {
                "mass": 0.5, "inertia": [1e-3] * 3,
                "shapes": {"skin": {"box": [0.06] * 3, "surface": "steel"}},
            },
        },
        "joints": {
            **{
                f"slide_{k}": {
                    "type": "prismatic", "axis": [sign, 0, 0], "parent": "ground", "child": k,
                    "stiffness": 50.0, "start": {"s": -0.04, "fixed": True},
                }
                for k, sign in (("a", 1), ("b", -1))
            },
            "J": {
                "type": "free", "parent": "ground", "child": "part", "start": {"r": [0, 0, 0], "fixed": True}
            },
        },
        "motors": {f"grip_{k}": {"joint": f"slide_{k}"} for k in "ab"},
        "contacts": {"pads": {"between": ["rubber", "steel"], "friction": 0.8}},
        "sensors": {"load_a": {"type": "reaction", "joint": "slide_a"}},
    }  # fmt: skip
    found = model(source, input_values={"grip_a.f": 10.0, "grip_b.f": 10.0})
    # Both fingers move with the part along x, against their springs.
    omega = sqrt(2 * 50 / (2 * 0.2 + 0.5))
    assert_poles(poles(found.A), [omega * 1j, -omega * 1j])
    assert not [name for name in found.outputs if name.startswith("load_a.")]


def test_boxes_stacked_exactly_are_at_rest() -> None:
    """Corners on corners and edges on edges: nothing can move, so that none leaves the other."""
    source = free_body({"box": [0.4, 0.3, 0.2]}, 2.0, [0.1] * 3, [0, 0, 0.1], friction=0.5)
    source["bodies"]["top"] = {**source["bodies"]["body"], "shapes": {"shape": {"box": [0.4, 0.3, 0.2]}}}
    source["bodies"]["top"]["shapes"]["shape"]["surface"] = "floor"
    start = {"r": [0, 0, 0.3], "fixed": True}
    source["joints"]["K"] = {"type": "free", "parent": "ground", "child": "top", "start": start}
    assert model(source).states == ()
    source["joints"]["K"]["start"]["v"] = [0.1, 0, 0]
    with pytest.raises(gelenk.UsageError, match=r"contacts.floor touches exactly at the end of a face"):
        model(source)
