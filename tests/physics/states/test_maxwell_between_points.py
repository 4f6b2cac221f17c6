# SPDX-License-Identifier: BSD-3-Clause
"""A spring and a damper in series between two points: the same along a joint, closed forms, balances."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, joint, placed, rotation, scene
from models.running import assert_close, assert_restored_run_continues, run, started
from scipy.linalg import expm

import gelenk

pytestmark = warned.TIGHT

STIFFNESS, DAMPING, MASS = 90.0, 14.0, 1.3  # N/m, N s/m, kg
ELEMENT = {"stiffness": STIFFNESS, "damping": DAMPING}
INTEGRATORS = ("ida", "erk", "cvode", "dirk")


def slide(along: dict[str, Any], speed: float = 2.0, **more: Any) -> Scene:
    """A slide along an oblique axis whose distance from a point on the axis is 0.7 m at s = 0."""
    axis = [0.48, -0.6, 0.64]
    start = {"s": 0.0, "v": speed, "fixed": True}
    slides = joint("prismatic", frame("ground"), frame("slide"), axis=axis, start=start)
    if along["type"] == "line_maxwell":
        along = along | {"from": frame("ground", [-0.7 * x for x in axis]), "to": frame("slide")}
    return scene({"slide": body(MASS)}, {"J": slides}, components={"M": along | ELEMENT}, **more)


LINE = {"type": "line_maxwell"}
ALONG = {"type": "maxwell", "joint": "J"}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_free_slide_moves_as_the_linear_equations_say(integrator: str) -> None:
    """By Newton, m v' = -k x, and x' = v - k x/d, by the exponential of their matrix."""
    A = np.array([[0, 1, 0], [0, 0, -STIFFNESS / MASS], [0, 1, -STIFFNESS / DAMPING]])
    times = np.linspace(0, 1.5, 31)
    expected = np.array([expm(A * t) @ [0, 2.0, 0] for t in times]).T
    found = run(slide(LINE), times, tolerance=1e-11, integrator=integrator)
    assert_close("s", found["J.s"], expected[0], 1e-8, "1000 rtol of some tenths of a meter")
    assert_close("v", found["J.v"], expected[1], 1e-8, "1000 rtol of 2 m/s")
    assert_close("x", found["M.elongation"], expected[2], 1e-8, "as of s")
    assert_close("d", found["M.d"], 0.7 + expected[0], 1e-8, "the distance of the points")
    assert_close("f", found["M.f"], STIFFNESS * expected[2], 1e-6, "k times as much")
    assert_close(
        "loss", found["M.loss"], (STIFFNESS * expected[2]) ** 2 / DAMPING, 1e-5, "2 f/d times as much"
    )


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_points_that_part_steadily_are_held_by_the_damper_in_the_end(integrator: str) -> None:
    """At the speed v, f = d v (1 - exp(-k t/d)): of the spring at first, of the damper in the end."""
    source = slide(LINE, constraints={"pull": {"type": "motion", "joint": "J", "speed": 2.0}})
    times = np.linspace(0, 1.5, 16)
    found = run(source, times, tolerance=1e-11, integrator=integrator)
    expected = DAMPING * 2.0 * (1 - np.exp(-STIFFNESS * times / DAMPING))
    assert_close("f", found["M.f"], expected, 1e-7, "1000 rtol of the elongation, times k")
    assert_close("drive", found["pull.f"], expected, 1e-7, "the drive bears it")


def test_same_as_along_a_prismatic_joint() -> None:
    times = np.linspace(0, 1.5, 16)
    line, along = (run(slide(one), times, tolerance=1e-11) for one in (LINE, ALONG))
    for name in ("J.s", "J.v", "J.a", "M.elongation", "M.loss"):
        assert_close(name, line[name], along[name], 1e-7, "1000 rtol, accelerations k/m times as much")
    assert_close("f", line["M.f"], -along["M.f"], 1e-7, "pulls together, against the coordinate")
    models = [
        gelenk.linear.linear_model(gelenk.load(slide(one)), outputs=["J.s", "J.a"]) for one in (LINE, ALONG)
    ]
    assert models[0].states == models[1].states == ("J.s", "J.v", "M.elongation")
    for name in "ABCD":
        a, b = (getattr(model, name) for model in models)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * STIFFNESS)


def test_pushes_when_the_points_approach_each_other() -> None:
    found = run(slide(LINE, speed=-2.0), [0.0, 0.02])
    assert found["M.f"][-1] < -1.0
    assert found["J.a"][-1] > 1.0


def two_bodies() -> Scene:
    """Two free bodies, tied at points beside their centers of mass."""

    def free(r: list[float], v: list[float], w: list[float], of: str) -> dict[str, Any]:
        return joint("free", frame("ground"), frame(of), start={"r": r, "v": v, "w": w, "fixed": True})

    tie = {
        "type": "line_maxwell",
        "from": frame("a", (0.1, 0.2, 0)),
        "to": frame("b", (0, -0.1, 0.3)),
        **ELEMENT,
    }
    return scene(
        {"a": body(0.8, inertia=(0.1, 0.12, 0.15)), "b": body(1.7, inertia=(0.3, 0.25, 0.2))},
        {
            "A": free([0, 0, 0], [1.0, 0.5, 0], [0.4, 0, -1.0], "a"),
            "B": free([1, 0.2, 0.4], [-0.2, 0, 0.3], [0, 0.8, 0.2], "b"),
        },
        components={"tie": tie},
        states={"lost": {"rate": "tie.loss", "unit": "J"}},
        sensors={"meter": {"type": "energy"}, **{n: {"type": "frame", "body": n} for n in "ab"}},
    )


@pytest.mark.parametrize("integrator", ["ida", "erk"])
def test_momentum_and_energy_between_free_bodies(integrator: str) -> None:
    """Both forces are equal, opposite and on one line; what the damper takes is missing from the energy."""
    found = run(two_bodies(), np.linspace(0, 3, 31), tolerance=1e-11, integrator=integrator)
    momentum = 0.8 * found.vector("a.v") + 1.7 * found.vector("b.v")
    spin = sum(
        m * np.cross(found.vector(f"{n}.r"), found.vector(f"{n}.v"))
        + np.array(
            [
                turned(q) @ (np.array(moments) * w)
                for q, w in zip(found.vector(f"{n}.Q"), found.vector(f"{n}.w"), strict=True)
            ]
        )
        for n, m, moments in (("a", 0.8, (0.1, 0.12, 0.15)), ("b", 1.7, (0.3, 0.25, 0.2)))
    )
    kept = found["meter.kinetic"] + STIFFNESS * found["tie.elongation"] ** 2 / 2 + found["lost"]
    assert found["lost"][-1] > 0.1  # J: not idle
    bound = (
        1e-8 if integrator == "erk" else 1e-6
    )  # 1000 rtol of a few units; more steps of BDF add up to more
    assert_close("momentum", momentum, momentum[0], bound, "no force from outside")
    assert_close("angular momentum", spin, spin[0], bound, "no torque from outside")
    assert_close("energy", kept, kept[0], bound, "balance")


def turned(Q: Any) -> Any:
    """The rotation matrix of a quaternion (x, y, z, scalar)."""
    size = float(np.linalg.norm(Q[:3]))
    return rotation(Q[:3], 2 * np.arctan2(size, Q[3])) if size > 0 else np.eye(3)


def test_run_turned_in_space_and_a_restored_run() -> None:
    times = np.linspace(0, 1, 5)
    plain = run(slide(LINE), times, tolerance=1e-11)
    R, p = rotation([1, -1, 2], 0.9), np.array([3.0, -1, 2])
    moved = placed(slide(LINE), R, p)
    tie = moved["components"]["M"]["from"]
    tie["position"] = [float(x) for x in R @ np.array(tie["position"]) + p]
    assert_close(
        "x", run(moved, times, tolerance=1e-11)["M.elongation"], plain["M.elongation"], 1e-9, "100 rtol"
    )
    assert_restored_run_continues(gelenk.load(two_bodies()), 0.4, [0.5, 0.9])


def test_points_that_coincide_at_the_start_are_warned_of() -> None:
    source = slide(LINE)
    source["components"]["M"]["from"] = "ground"
    with pytest.warns(gelenk.StartWarning, match=r"components\.M: its ends coincide at the start"):
        started(source)


def test_scene_contains_the_component_alone() -> None:
    """Neither its sensor nor its force is written; names of theirs are taken."""
    source = slide(LINE)
    written = gelenk.load(source).to_dict()
    assert "M" in written["components"]
    assert not written.get("sensors")
    assert not written.get("forces")
    taken = copy.deepcopy(source)
    taken["sensors"] = {"M": {"type": "distance", "from": "ground", "to": "slide"}}
    with pytest.raises(gelenk.SceneError, match=r"the variable M\.d, which "):
        gelenk.load(taken)
    same = copy.deepcopy(source)
    same["components"]["M"]["from"] = frame("slide", (1, 0, 0))
    with pytest.raises(gelenk.SceneError, match=r"components\.M: found 'slide' twice"):
        gelenk.load(same)


def test_other_expressions_name_its_signals() -> None:
    """As of every component: a limit of the length as a law of another force."""
    source = slide(LINE, expressions={"half": "M.f/2", "stretched": "M.d - 0.7"})
    found = run(source, [0.0, 0.3])
    assert_close("half", found["half"], found["M.f"] / 2, 1e-12, "the same number")
    assert_close("stretched", found["stretched"], found["J.s"], 1e-12, "round-off")
