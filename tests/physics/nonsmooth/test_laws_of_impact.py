# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Poisson's laws of impact where several limits are struck together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.running import assert_close

import gelenk

from .test_joint_friction import plant, read
from .test_joint_limits import ball


def two_blocks(law: str, lower: float, upper: float, masses: tuple[float, float]) -> Scene:
    """A block that rests on its lower limit, and one that flies towards it at 2 m/s; no gravity."""

    def guide(parent: str, child: str, restitution: float, v: float) -> dict[str, Any]:
        limit = {"lower": 0.0, "restitution": restitution, "law": law}
        return joint(
            "prismatic", frame(parent), frame(child), limit=limit, start={"s": 0.0, "v": v, "fixed": True}
        )

    source = scene(
        {"low": body(masses[0]), "high": body(masses[1])},
        {"A": guide("ground", "low", lower, 0.0), "B": guide("low", "high", upper, -2.0)},
    )
    source["joints"]["B"]["start"]["s"] = 1e-3
    return source


@pytest.mark.parametrize(("lower", "upper"), [(0.8, 0.5), (0.5, 0.5), (0.3, 0.9), (0.0, 0.5), (1.0, 1.0)])
def test_laws_of_impact_of_two_blocks(lower: float, upper: float) -> None:
    """Newton: the lower block stays. Poisson: both impulses of compression, m v, grow by restitution."""
    m, M, v = 0.5, 2.0, 2.0
    newton = plant(two_blocks("newton", lower, upper, (M, m)))
    newton.step_to(0.001)
    assert (read(newton, "A.v"), newton.diagnostic("solver.impacts")) == (0, 1)
    assert_close("B.v", read(newton, "B.v"), upper * v, 1e-12, "rounding")
    poisson = plant(two_blocks("poisson", lower, upper, (M, m)))
    poisson.step_to(0.001)
    # The lower limit may need more than its part, lest the block passes it.
    of_block = max(0.0, (lower - upper) * m * v / M)
    assert_close("A.v", read(poisson, "A.v"), of_block, 1e-12, "rounding")
    assert_close("B.v", read(poisson, "B.v"), upper * v - of_block, 1e-12, "rounding")


def test_both_laws_agree_for_a_single_bound() -> None:
    source = ball(0.7)
    found = []
    for law in ("newton", "poisson"):
        source["joints"]["J"]["limit"]["law"] = law
        simulation = plant(source)
        simulation.step_to(3.0)
        found.append(
            (read(simulation, "J.s"), read(simulation, "J.v"), simulation.diagnostic("solver.impacts"))
        )
    assert found[0] == pytest.approx(found[1], abs=1e-9)  # the rounding of some ten impacts


@pytest.mark.parametrize(("law", "most"), [("newton", 25), ("poisson", 900)])
def test_impacts_of_two_blocks_under_gravity_come_to_rest(law: str, most: int) -> None:
    """With Newton's law the lower block stays; with Poisson's, each of some 20 impacts throws it up, and
    it bounces some 40 times.
    """
    source = two_blocks(law, 0.8, 0.5, (2.0, 0.5))
    source["gravity"] = [0, 0, -GRAVITY]
    source["joints"]["B"]["start"]["s"] = 0.3
    simulation = plant(source)
    energy = [simulation.diagnostic("energy.total")]
    for k in range(1, 81):
        simulation.step_to(0.05 * k)
        energy.append(simulation.diagnostic("energy.total"))
    assert np.diff(energy).max() <= 1e-11  # the weight times what counts as contact
    assert (read(simulation, "A.v"), read(simulation, "B.v")) == (0, 0)
    assert_close("A", read(simulation, "A.limit.f"), 2.5 * GRAVITY, 1e-11, "rounding")
    assert_close("B", read(simulation, "B.limit.f"), 0.5 * GRAVITY, 1e-11, "rounding")
    assert 10 < simulation.diagnostic("solver.impacts") < most


def test_a_series_under_constant_push_with_poisson() -> None:
    source = ball(0.5)
    source["joints"]["J"]["limit"]["law"] = "poisson"
    simulation = plant(source)
    simulation.step_to(3.0)
    assert read(simulation, "J.v") == 0
    assert_close("J.s", read(simulation, "J.s"), 0.1, 1e-11, "what counts as contact")
    assert simulation.diagnostic("solver.zeno") == 1


def test_unknown_law_of_impact_is_refused() -> None:
    source = ball(0.5)
    source["joints"]["J"]["limit"]["law"] = "hertz"
    with pytest.raises(gelenk.SceneError, match=r"limit.law: found 'hertz', expected .*newton.*poisson"):
        plant(source)


def test_inelastic_limits_that_throw_each_other_off_come_to_rest() -> None:
    """Two links pressed onto their limits, each thrown off by impacts of the other: an infinite series.

    The impacts shrink geometrically, by the square of the coupling of the two joints in the mass matrix.
    Its end is found where rebounds are as small as the rounding of positions, not after thousands of events.
    """
    link = body(1.0, com=(0.5, 0, 0), inertia=(0.01, 0.01, 0.01))
    hinge = {"axis": [0, 0, 1]}
    source = scene(
        {"upper": link, "lower": link},
        {
            "A": joint(
                "revolute", frame("ground"), frame("upper"), limit={"lower": 0.0}, **hinge,
                start={"phi": 0.0, "w": 0.0, "fixed": True},
            ),
            "B": joint(
                "revolute", frame("upper", (1, 0, 0)), frame("lower"), limit={"lower": 0.0}, **hinge,
                start={"phi": 0.3, "w": 0.0, "fixed": True},
            ),
        },
        motors={"a": {"joint": "A"}, "b": {"joint": "B"}},
    )  # fmt: skip
    simulation = plant(source, a__tau=-5.0, b__tau=-4.0)
    simulation.step_to(2.0)
    assert (read(simulation, "A.w"), read(simulation, "B.w")) == (0, 0)
    assert_close("A", read(simulation, "A.limit.tau"), 5.0, 1e-11, "rounding")
    assert_close("B", read(simulation, "B.limit.tau"), 4.0, 1e-11, "rounding")
    assert simulation.diagnostic("solver.impacts") < 200


@pytest.mark.parametrize("way", ["alone", "beside a contact", "in steps"])
def test_reduced_restitution_keeps_the_other_laws(way: str) -> None:
    """A carriage with a one-way clutch, and a block on it, at rest in space until its limit strikes.

    With a restitution of 0.9 the carriage would be thrown back, which the clutch prevents, and energy would
    be gained. Without a gain, the clutch holds the carriage, and the block has all energy: v = w sqrt(M / m).
    """
    M, m, w = 0.19, 0.81, 1.0

    def guide(parent: str, child: str, v: float, **laws: Any) -> dict[str, Any]:
        start = {"s": 0.0, "v": v, "fixed": True}
        return joint("prismatic", frame(parent), frame(child), axis=[1, 0, 0], start=start, **laws)

    source = scene(
        {"carriage": body(M), "block": body(m)},
        {
            "A": guide("ground", "carriage", w, one_way={"free": "positive"}),
            "B": guide("carriage", "block", -w, limit={"lower": -0.05, "restitution": 0.9}),
        },
    )
    if way == "beside a contact":
        source["bodies"]["ball"] = {"mass": 1.0, "shapes": {"s": {"sphere": 0.1, "surface": "ball"}}}
        start = {"s": 0.1, "fixed": True}
        source["joints"]["C"] = joint(
            "prismatic", frame("ground", (0, 3, 0)), frame("ball"), axis=[0, 0, 1], start=start
        )
        source["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}
        source["contacts"] = {"k": {"between": ["ball", "floor"], "friction": 0.3}}
        source["solver"] = {"reductions": {"all": False}}
    elif way == "in steps":
        source["solver"] = {"integrator": "moreau-jean", "step": 1e-3}
    simulation = gelenk.Simulation(source)
    simulation.initialize(tolerance=1e-10)
    simulation.step_to(0.0525)
    # m/s: the part of the restitution is found to rounding; in time steps to 1e-6.
    tolerance = 1e-11 if way != "in steps" else 1e-5
    assert abs(read(simulation, "A.v")) < tolerance
    assert_close("B.v", read(simulation, "B.v"), w * np.sqrt(M / m), tolerance, "bisection")
