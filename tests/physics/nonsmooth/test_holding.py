# SPDX-License-Identifier: BSD-3-Clause
"""Poses held by dry friction and contact, and their margin to break-away, against closed forms and runs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.drive_cases import backstop

import gelenk

from .test_joint_friction import four_bar_with_friction

ROUNDING = 1e-13  # some tens of operations on numbers about 1, among them a factorization


def held(source: Any, **arguments: Any) -> gelenk.Equilibrium:
    return gelenk.equilibrium(source, friction="present", **arguments)


def refusal(source: Any, **arguments: Any) -> str:
    with pytest.raises(gelenk.EquilibriumError) as told:
        held(source, **arguments)
    return str(told.value)


def block(incline: float, friction: dict[str, float], **fields: Any) -> Scene:
    """2 kg on a slope; s is measured uphill."""
    return scene(
        {"block": body(2.0, inertia=(0.1, 0.1, 0.1))},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("block"), axis=[math.cos(incline), 0, math.sin(incline)],
                friction=friction, **fields
            )
        },
        gravity=[0, 0, -GRAVITY], motors={"push": {"joint": "S"}},
    )  # fmt: skip


def pendulum(phi: float, **fields: Any) -> Scene:
    """1 kg at 1 m, hanging at phi = 0."""
    return scene(
        {"bob": body(1.0, (0, -1, 0))},
        {"A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], start={"phi": phi}, **fields)},
        gravity=[0, -GRAVITY, 0], motors={"drive": {"joint": "A"}},
    )  # fmt: skip


def crank_loop(phi: float, cranks: int, friction: float) -> Scene:
    """A bar on parallel cranks of 1 m, with friction in all joints and a motor on the first crank."""
    bodies = {"bar": body(2.0, (1, 0, 0), (0, 0, 0.1))}
    joints = {}
    for i in range(cranks):
        bodies[f"crank{i}"] = body(1.0, (0.5, 0, 0), (0, 0, 0.1))
        dry = {"axis": [0, 0, 1], "friction": {"coulomb": friction}}
        joints[f"A{i}"] = joint(
            "revolute", frame("ground", (2 * i, 0, 0)), frame(f"crank{i}"), start={"phi": phi}, **dry
        )
        joints[f"B{i}"] = joint(
            "revolute", frame(f"crank{i}", (1, 0, 0)), frame("bar", (2 * i, 0, 0)), start={"phi": -phi}, **dry
        )
    return scene(bodies, joints, motors={"drive": {"joint": "A0"}})


def four_bar(factor: float = 1.0, stronger: float = 20.0) -> Scene:
    """At rest under gravity times a factor."""
    source = four_bar_with_friction()
    source["gravity"] = [0, 0, -GRAVITY * factor]
    source["joints"]["A"]["start"]["w"] = 0.0
    for of in source["joints"].values():
        of["friction"] = {name: stronger * value for name, value in of["friction"].items()}
    return source


def moves(source: Scene) -> bool:
    """Whether a run leaves the start at once."""
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    start = plant.values(["A.phi"])[0]
    plant.step_to(1e-3)
    return bool(plant.values(["A.phi"])[0] != start)


# --- one joint ---


@pytest.mark.parametrize("incline", [0.1, 0.3, -0.7])
@pytest.mark.parametrize("fraction", [0.0, 0.4, 1 - 1e-9, 1.0])
def test_block_on_a_slope_has_the_margin_of_its_weight(incline: float, fraction: float) -> None:
    """M g sin(incline) of the static friction, whatever the sliding friction is."""
    weight = 2 * GRAVITY * math.sin(incline)
    static = abs(weight) / (fraction or math.inf) if fraction else 5.0
    source = block(incline if fraction else 0.0, {"coulomb": static / 2, "static": static})
    found = held(source)
    assert found.margin == pytest.approx(1 - fraction, abs=ROUNDING)
    assert found.residual == 0
    of = found.held["S.s"]
    assert of.friction == pytest.approx(weight if fraction else 0.0, rel=ROUNDING)
    assert (of.limit, of.contact, of.bound, of.unit) == (static, 0, "", "N")
    if fraction:
        assert found.load_factor == pytest.approx(1 / fraction, rel=ROUNDING)
    else:
        assert found.load_factor == math.inf


@pytest.mark.parametrize("incline", [0.3, -0.7])
def test_a_slope_steeper_than_friction_is_told(incline: float) -> None:
    static = 2 * GRAVITY * math.sin(abs(incline)) * (1 - 1e-9)
    assert refusal(block(incline, {"coulomb": static})).startswith("friction does not hold this pose: S.s")
    told = refusal(block(0.3, {"coulomb": 4.0, "static": 5.0}))
    assert told == (
        "friction does not hold this pose: S.s would need 5.79811 N, and its limit is 5 N; "
        "S.a = -0.899053 m/s2"  # beyond its limit it slips with its sliding friction
    )


def test_inputs_add_to_the_load() -> None:
    """Held while the motor is within the friction of the weight."""
    weight, static = 2 * GRAVITY * math.sin(0.3), 8.0
    source = block(0.3, {"coulomb": static})
    for push in (weight - static, weight, weight + static):
        found = held(source, input_values={"push.f": push})
        assert found.margin == pytest.approx(1 - abs(push - weight) / static, abs=10 * ROUNDING)
        assert found.inputs == {"push.f": push}
    for push in (weight - static - 1e-6, weight + static + 1e-6):
        refusal(source, input_values={"push.f": push})


@pytest.mark.parametrize("phi", [0.3, -0.3, 2.9])
def test_pendulum_off_the_vertical(phi: float) -> None:
    found = held(pendulum(phi, friction={"coulomb": 3.0}))
    assert found.values["A.phi"] == phi
    assert found.margin == pytest.approx(1 - GRAVITY * math.sin(abs(phi)) / 3, rel=10 * ROUNDING)
    assert refusal(pendulum(0.5, friction={"coulomb": 3.0})).startswith("friction does not hold this pose")


def test_held_coordinates_are_approached_first() -> None:
    source = pendulum(0.5, friction={"coulomb": 3.0})
    found = held(source, hold={"A.phi": 0.25})
    assert found.values["A.phi"] == 0.25
    assert found.margin == pytest.approx(1 - GRAVITY * math.sin(0.25) / 3, rel=10 * ROUNDING)


def test_speeds_of_the_start_do_not_count() -> None:
    source = pendulum(0.3, friction={"coulomb": 3.0})
    source["joints"]["A"]["start"]["w"] = 2.0
    found = held(source)
    assert found.values["A.w"] == 0
    assert found.at["A.w_start"] == 0


def test_what_nothing_holds_is_told() -> None:
    """A second pendulum without friction hangs from the first."""
    source = pendulum(0.2, friction={"coulomb": 9.0})
    source["bodies"]["other"] = body(1.0, (0, -1, 0))
    source["joints"]["B"] = joint(
        "revolute", frame("bob", (0, -1, 0)), frame("other"), axis=[0, 0, 1], start={"phi": 0.3}
    )
    assert refusal(source).startswith("friction and limits do not hold this pose; B.a = ")
    assert refusal(source, hold={"B.phi": 0.0}).startswith(
        "friction and limits do not hold this pose; B.a = "
    )
    assert held(source, hold={"B.phi": -0.2}).margin == pytest.approx(1 - 2 * GRAVITY * math.sin(0.2) / 9)


def test_without_friction_only_equilibria_are_at_rest() -> None:
    assert held(pendulum(0.0)).margin == 1
    assert refusal(pendulum(0.1)) == "friction and limits do not hold this pose; A.a = -0.979366 rad/s2"


def test_the_default_is_the_equilibrium_without_friction() -> None:
    source = pendulum(0.3, friction={"coulomb": 3.0})
    for friction in (None, "off"):
        found = gelenk.equilibrium(source, input_values={"drive.tau": 1.0}, friction=friction)
        assert found.values["A.phi"] == pytest.approx(math.asin(1 / GRAVITY), rel=1e-9)
        assert found.held == {}
    trim = gelenk.equilibrium(source, hold={"A.phi": 0.4}, solve_for="drive.tau")
    assert trim.inputs["drive.tau"] == pytest.approx(GRAVITY * math.sin(0.4), rel=1e-12)


# --- loops that hold redundantly ---


def test_four_bar_breaks_away_at_the_load_factor() -> None:
    """Found by bisection with runs under multiples of gravity."""
    found = held(four_bar())
    low, high = 1.0, 10.0
    while high - low > 1e-8:
        middle = (low + high) / 2
        low, high = (low, middle) if moves(four_bar(middle)) else (middle, high)
    assert found.load_factor == pytest.approx(low, rel=1e-7)  # the bisection's interval
    used = [of.friction / of.limit for of in found.held.values()]
    assert {round(abs(x) * found.load_factor, 9) for x in used} == {1.0}  # all four slip at once
    assert held(four_bar(found.load_factor * (1 - 1e-8))).margin == pytest.approx(1e-8, rel=1e-4)
    refusal(four_bar(found.load_factor * (1 + 1e-8)))


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
@pytest.mark.parametrize("cranks", [2, 3])
@pytest.mark.parametrize("phi", [0.7, -2.0, 1e-6])
def test_all_joints_of_parallel_cranks_hold_alike(phi: float, cranks: int) -> None:
    """The bar does not rotate, so that all joints rotate alike."""
    friction = 1.5
    limit = 2 * cranks * friction
    source = crank_loop(phi, cranks, friction)
    for torque in (0.3 * limit, -0.3 * limit, (1 - 1e-7) * limit):
        found = held(source, input_values={"drive.tau": torque})
        assert found.margin == pytest.approx(1 - abs(torque) / limit, abs=1e-12)
        assert len(found.held) == 2 * cranks
    refusal(source, input_values={"drive.tau": (1 + 1e-7) * limit})


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
def test_without_a_load_nothing_is_used() -> None:
    for source in (crank_loop(0.7, 3, 1.0), crank_loop(0.0, 2, 1.0), four_bar(0.0), block(0, {"coulomb": 1})):
        found = held(source)
        assert found.margin == 1
        assert found.load_factor == math.inf


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
def test_links_in_line_are_held_against_all_motions_of_first_order() -> None:
    """Cranks at the rates 1 and 0 need the least friction, 3 times that of a joint. No branch has these."""
    assert held(crank_loop(0.0, 2, 1.0), input_values={"drive.tau": 1.0}).load_factor == pytest.approx(3)


def test_a_heavily_loaded_joint_does_not_change_the_margins_of_a_loop() -> None:
    """A linkage on a boom whose bearing uses nine tenths of its friction."""
    source = four_bar()
    source["bodies"]["boom"] = body(20.0, (1.0, 0, 0), (0, 1, 0))
    for name in "AD":
        source["joints"][name]["parent"]["body"] = "boom"
    dry = {"coulomb": 1e4}
    source["joints"]["bearing"] = joint(
        "revolute", frame("ground"), frame("boom"), axis=[0, -1, 0], friction=dry
    )
    dry["coulomb"] = abs(held(source).held["bearing.phi"].friction) / 0.9
    found = held(source)
    assert found.margin == found.held["bearing.phi"].margin == pytest.approx(0.1, rel=1e-12)
    alone = held(four_bar())
    for name in "ABCD":
        expected = alone.held[f"{name}.phi"].friction
        assert found.held[f"{name}.phi"].friction == pytest.approx(expected, rel=1e-9)


# --- contact ---


@pytest.mark.parametrize(("side", "bound"), [("lower", 1), ("upper", -1)])
def test_friction_helps_where_contact_would_pull(side: str, bound: int) -> None:
    phi = 0.2
    load = GRAVITY * math.sin(phi)
    pushed = held(pendulum(bound * phi, limit={side: bound * phi}, friction={"coulomb": 3.0}))
    of = pushed.held["A.phi"]
    assert of.contact == pytest.approx(bound * load, rel=1e-13)
    assert (of.friction, of.margin, of.bound) == (0, 1, side)
    pulled = held(pendulum(-bound * phi, limit={side: -bound * phi}, friction={"coulomb": 3.0}))
    of = pulled.held["A.phi"]
    assert of.contact == 0
    assert of.friction == pytest.approx(-bound * load, rel=1e-13)
    assert of.margin == pytest.approx(1 - load / 3, rel=1e-13)
    weak = refusal(pendulum(-bound * phi, limit={side: -bound * phi}, friction={"coulomb": 1.0}))
    assert weak.startswith("friction does not hold this pose: A.phi would need 1.94895 N m")


def test_contact_alone_holds_in_one_direction() -> None:
    found = held(pendulum(0.2, limit={"lower": 0.2}))
    assert found.held["A.phi"].contact == pytest.approx(GRAVITY * math.sin(0.2), rel=1e-13)
    assert (found.margin, found.load_factor) == (1, math.inf)
    assert refusal(pendulum(0.2, limit={"upper": 0.2})) == (
        "friction and limits do not hold this pose: A.phi leaves its upper limit; A.a = -1.94895 rad/s2"
    )
    touching = held(pendulum(0.0, limit={"lower": 0.0}))  # without a force
    assert touching.held["A.phi"].contact == 0
    assert touching.held["A.phi"].bound == "lower"


# --- what is refused, and other sources ---


def test_wrong_questions_are_refused() -> None:
    source = pendulum(0.3, friction={"coulomb": 3.0})
    with pytest.raises(gelenk.UsageError, match="friction: found 'sliding', expected one of off, present"):
        gelenk.equilibrium(source, friction="sliding")
    with pytest.raises(gelenk.UsageError, match=r"solve_for: found drive\.tau with friction='present'"):
        held(source, solve_for="drive.tau")
    source["constraints"] = {"turn": {"type": "motion", "joint": "A", "speed": 1.0}}
    assert refusal(source) == "no pose at rest: a prescribed motion moves A.w = 1 rad/s"


def test_an_fmu_gives_the_same_answer(tmp_path: Path) -> None:
    source = four_bar()
    del source["joints"]["C"]["friction"]
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "x.fmu")
    assert held(fmu).to_dict() == held(source).to_dict()
    assert gelenk.equilibrium(fmu).values == gelenk.equilibrium(source).values


def test_units_do_not_matter() -> None:
    """A linkage of micrometers, solved in units of its own."""
    source = scene(
        {"bob": body(1e-15, (0, -1e-6, 0), (0, 0, 1e-28))},
        {"A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], start={"phi": 0.3},
                    friction={"coulomb": 3e-21})},
        gravity=[0, -GRAVITY, 0],
    )  # fmt: skip
    found = held(source)
    assert found.held["A.phi"].friction == pytest.approx(1e-21 * GRAVITY * math.sin(0.3), rel=1e-12)
    assert found.margin == pytest.approx(1 - GRAVITY * math.sin(0.3) / 3, rel=1e-12)


def test_result_as_text_and_data() -> None:
    found = held(pendulum(0.3, friction={"coulomb": 3.0}, limit={"lower": 0.3}))
    assert str(found).splitlines()[-2:] == [
        "held",
        "  A.phi  friction 0 of 3 N m, contact at its lower limit 2.89905 N m, margin 1",
    ]
    data = found.to_dict()
    assert data["held"]["A.phi"]["bound"] == "lower"
    assert data["margin"] == 1
    assert "held" not in gelenk.equilibrium(pendulum(0.3)).to_dict()


@pytest.mark.parametrize("free", ["positive", "negative"])
def test_a_one_way_clutch_holds_by_its_name(free: str) -> None:
    """A backstop carries the weight, or with friction beside it all that friction cannot; it never pulls."""
    up = 1 if free == "positive" else -1
    source = backstop(free)
    found = held(source).held["guide.s"]
    assert found.bound == "one_way"
    assert found.contact == pytest.approx(up * 2 * GRAVITY, rel=ROUNDING)
    assert str(found) == f"one-way clutch {up * 2 * GRAVITY:.6g} N, margin 1"
    # Exactly balanced it carries nothing; lifted, it overruns.
    assert held(source, input_values={"lift.f": up * 2 * GRAVITY}).held["guide.s"].contact == pytest.approx(
        0.0, abs=20 * ROUNDING
    )
    told = refusal(source, input_values={"lift.f": up * 20.0})
    assert "guide.s overruns its one-way clutch" in told
    source["joints"]["guide"]["friction"] = {"coulomb": 1.0}
    found = held(source, input_values={"lift.f": up * 20.0}).held["guide.s"]
    assert found.friction == pytest.approx(up * (2 * GRAVITY - 20), rel=1e-11)
    assert found.contact == 0.0
    assert found.bound == "one_way"
