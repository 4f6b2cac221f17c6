# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria of mechanisms with hard limits: free, or at a bound with a contact force that pushes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import pytest
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene

import gelenk

from .test_holding import ROUNDING, crank_loop, pendulum

POSITION = (
    1e-9  # rad: error of a free equilibrium, its residual acceleration over a stiffness of about 10 1/s2
)
BOUND = 1e-12  # rad, m: what counts as contact (element/joint_forces/joint_limit.h)


def at_rest(source: Scene) -> gelenk.Simulation:
    """A run that starts at equilibrium."""
    plant = gelenk.Simulation(gelenk.load(source | {"solver": {"start": "equilibrium"}}))
    plant.initialize()
    return plant


def refusal(source: Any, **arguments: Any) -> str:
    with pytest.raises(gelenk.EquilibriumError) as told:
        gelenk.equilibrium(source, **arguments)
    return str(told.value)


@pytest.mark.parametrize("start", [0.2, 0.5, 1.4])
@pytest.mark.parametrize("side", [1, -1])
def test_pendulum_rests_against_its_limit(start: float, side: int) -> None:
    """From the bound and from beside it; gravity turns it against the bound, by m g l sin(bound)."""
    source = pendulum(side * start, limit={"lower" if side > 0 else "upper": side * 0.2})
    found = gelenk.equilibrium(source)
    assert found.values["A.phi"] == side * 0.2
    of = found.held["A.phi"]
    assert of.contact == pytest.approx(side * GRAVITY * math.sin(0.2), rel=ROUNDING)
    assert of.friction == 0
    plant = at_rest(source)
    plant.step_to(1.0)
    assert plant.values(["A.phi", "A.w"]).tolist() == [side * 0.2, 0]
    assert plant.events == []


@pytest.mark.parametrize("start", [0.2, 0.5])
@pytest.mark.parametrize("excess", [-1e-6, 0.0, 1e-6])
def test_threshold_between_contact_and_a_free_equilibrium(start: float, excess: float) -> None:
    """A torque that balances gravity at the bound up to an excess."""
    source = pendulum(start, limit={"lower": 0.2})
    found = gelenk.equilibrium(source, input_values={"drive.tau": GRAVITY * math.sin(0.2) + excess})
    if excess > 0:
        assert found.values["A.phi"] == pytest.approx(
            math.asin(math.sin(0.2) + excess / GRAVITY), abs=POSITION
        )
        assert found.values["A.phi"] > 0.2
        assert found.held == {}
    else:
        assert found.values["A.phi"] == 0.2
        assert found.held["A.phi"].contact == pytest.approx(-excess, abs=1e-14)  # rounding of 2 N m


@pytest.mark.parametrize("limit", [{"lower": -0.5}, {"lower": -0.5, "upper": 2.0}, {"upper": 1e-6}])
def test_limits_that_are_not_met_change_nothing(limit: dict[str, float]) -> None:
    start = min(1.0, limit.get("upper", 1.0))
    found = gelenk.equilibrium(pendulum(start, limit=limit))
    free = gelenk.equilibrium(pendulum(start))
    assert found.values["A.phi"] == pytest.approx(free.values["A.phi"], abs=POSITION)
    assert found.held == {}


def test_a_contact_that_would_pull_is_left() -> None:
    """At its bound, but gravity turns it away from it: it hangs."""
    found = gelenk.equilibrium(pendulum(0.2, limit={"upper": 0.2}))
    assert found.values["A.phi"] == pytest.approx(0, abs=POSITION)
    assert found.held == {}


def test_an_equilibrium_beyond_one_limit_is_replaced_by_the_other() -> None:
    """Upside down is beyond the upper bound, from which gravity turns it to the lower one."""
    found = gelenk.equilibrium(pendulum(2.9, limit={"lower": 0.2, "upper": 3.0}))
    assert found.values["A.phi"] == 0.2
    unstable = gelenk.equilibrium(pendulum(2.9, limit={"lower": 0.2, "upper": 3.2}))
    assert unstable.values["A.phi"] == pytest.approx(math.pi, abs=POSITION)


@pytest.mark.parametrize("height", [0.0, 0.7, 20.0])
def test_a_block_falls_to_its_limit(height: float) -> None:
    """Nothing but the bound balances its weight."""

    def block(side: str, at: float) -> Scene:
        return scene(
            {"block": body(2.0)},
            {"S": joint("prismatic", frame("ground"), frame("block"), axis=[0, 0, 1], limit={side: at})},
            gravity=[0, 0, -GRAVITY],
        )  # fmt: skip

    found = gelenk.equilibrium(block("lower", -height))
    assert found.values["S.s"] == -height
    assert found.held["S.s"].contact == pytest.approx(2 * GRAVITY, rel=ROUNDING)
    assert "no equilibrium" in refusal(block("upper", height))


def test_two_pendulums_at_their_limits() -> None:
    """The second hangs from the first; both rest against bounds, with the moments of what they carry."""
    a, b = 0.3, 0.4  # rad; the second is at a + b from the vertical
    source = pendulum(1.0, limit={"lower": a})
    source["bodies"]["other"] = body(1.0, (0, -1, 0))
    source["joints"]["B"] = joint(
        "revolute", frame("bob", (0, -1, 0)), frame("other"), axis=[0, 0, 1], start={"phi": 1.0},
        limit={"lower": b},
    )  # fmt: skip
    found = gelenk.equilibrium(source)
    assert [found.values["A.phi"], found.values["B.phi"]] == pytest.approx([a, b], abs=BOUND)
    outer = GRAVITY * math.sin(a + b)
    assert found.held["B.phi"].contact == pytest.approx(outer, rel=1e-11)  # positions are within BOUND
    assert found.held["A.phi"].contact == pytest.approx(outer + 2 * GRAVITY * math.sin(a), rel=1e-11)
    # With its own bound far away, the second hangs vertically.
    source["joints"]["B"]["limit"]["lower"] = -2.0
    found = gelenk.equilibrium(source)
    assert found.values["B.phi"] == pytest.approx(-a, abs=POSITION)
    assert list(found.held) == ["A.phi"]


def limited_four_bar(rocker: float) -> Scene:
    """Swinging up to this bound of its rocker as it falls."""
    source = four_bar(-1.0, damping=0.0)
    source["joints"]["D"]["limit"] = {"upper": rocker}
    return source


def test_a_loop_rests_against_a_limit() -> None:
    """The contact force is the torque of a motor that holds the same pose."""
    free = gelenk.equilibrium(four_bar(-1.0)).values["D.phi"]
    bound = free - 0.1
    found = gelenk.equilibrium(limited_four_bar(bound))
    assert found.values["D.phi"] == pytest.approx(bound, abs=BOUND)
    driven = four_bar(-1.0)
    driven["motors"] = {"rocker": {"joint": "D"}}
    trim = gelenk.equilibrium(driven, hold={"D.phi": bound}, solve_for="rocker.tau")
    assert found.held["D.phi"].contact == pytest.approx(trim.inputs["rocker.tau"], rel=1e-9)
    assert found.held["D.phi"].contact < 0
    assert gelenk.equilibrium(limited_four_bar(free + 0.1)).held == {}
    plant = at_rest(limited_four_bar(bound))
    plant.step_to(0.5)
    assert plant.values(["D.w"])[0] == 0


def test_cranks_share_a_redundant_contact() -> None:
    """Both cranks have the bound; together they bear the torque."""
    source = crank_loop(0.5, 2, 0.0)
    for of in source["joints"].values():
        del of["friction"]
    for name in ("A0", "A1"):
        source["joints"][name]["limit"] = {"upper": 0.7}
    found = gelenk.equilibrium(source, input_values={"drive.tau": 5.0})
    assert [found.values[f"{name}.phi"] for name in ("A0", "A1")] == pytest.approx([0.7, 0.7], abs=BOUND)
    forces = [of.contact for of in found.held.values()]
    assert sum(forces) == pytest.approx(-5, rel=1e-9)
    assert max(forces) <= 0


def test_friction_does_not_take_part() -> None:
    """Without it the pendulum hangs at the bound; with it, it stays where it is."""
    source = pendulum(0.25, limit={"lower": 0.2}, friction={"coulomb": 3.0})
    found = gelenk.equilibrium(source)
    assert found.values["A.phi"] == 0.2
    of = found.held["A.phi"]
    assert of.friction == 0
    assert of.contact == pytest.approx(GRAVITY * math.sin(0.2), rel=ROUNDING)
    assert gelenk.equilibrium(source, friction="present").values["A.phi"] == 0.25
    assert at_rest(source).output("A.phi") == 0.2


def test_trim_beyond_a_limit_is_refused() -> None:
    source = pendulum(0.5, limit={"lower": 0.2})
    assert refusal(source, hold={"A.phi": 0.1}, solve_for="drive.tau") == (
        "no equilibrium within the hard limits: the one found has A.phi = 0.1 rad, beyond its lower limit of "
        "0.2 rad"
    )
    found = gelenk.equilibrium(source, hold={"A.phi": 0.2}, solve_for="drive.tau")  # exactly at the bound
    assert found.inputs["drive.tau"] == pytest.approx(GRAVITY * math.sin(0.2), rel=1e-12)
    assert found.held["A.phi"].contact == pytest.approx(0, abs=1e-12)
    resting = gelenk.equilibrium(source, hold={"A.phi": 0.2})  # the contact does what the motor does not
    assert resting.held["A.phi"].contact == pytest.approx(GRAVITY * math.sin(0.2), rel=ROUNDING)
    assert "do not hold this pose" in refusal(source, hold={"A.phi": 0.3})


def arm_with_hand(limit: dict[str, float]) -> Scene:
    """The drive turns the first of two pendulums; the second, with this limit, hangs from it."""
    source = pendulum(0.5)
    source["bodies"]["other"] = body(1.0, (0, -1, 0))
    source["joints"]["B"] = joint(
        "revolute", frame("bob", (0, -1, 0)), frame("other"), axis=[0, 0, 1], start={"phi": 0.8}, limit=limit
    )
    return source


@pytest.mark.parametrize("excess", [-1e-6, 0.0, 1e-6, 0.7])
def test_what_a_held_joint_carries_may_rest_against_its_limit(excess: float) -> None:
    """The hand hangs vertically at -0.5, unless its limit holds it, whose moment the motor carries, too."""
    source, bound = arm_with_hand({"lower": -0.5 + excess}), max(-0.5, -0.5 + excess)
    found = gelenk.equilibrium(source, hold={"A.phi": 0.5}, solve_for="drive.tau")
    contact = GRAVITY * math.sin(0.5 + bound)
    assert found.values["A.phi"] == 0.5
    assert found.values["B.phi"] == pytest.approx(bound, abs=POSITION)
    assert found.inputs["drive.tau"] == pytest.approx(2 * GRAVITY * math.sin(0.5) + contact, rel=1e-9)
    assert [*found.held] == (["B.phi"] if excess >= 0 else [])
    if excess > 0:
        assert found.held["B.phi"].contact == pytest.approx(contact, rel=1e-6)  # bounds within BOUND
        alone = gelenk.equilibrium(source, hold={"A.phi": 0.5}, input_values=found.inputs)
        assert alone.values["B.phi"] == pytest.approx(bound, abs=BOUND)
        assert "do not hold this pose" in refusal(
            source, hold={"A.phi": 0.5}, input_values={"drive.tau": found.inputs["drive.tau"] - 1e-6}
        )


@pytest.mark.parametrize("excess", [1e-6, 0.0, -1e-6])
def test_values_to_hold_end_at_a_limit(excess: float) -> None:
    """At the bound contact carries what pushes, unless an input is asked for; beyond it nothing is found."""
    source = pendulum(0.5, limit={"lower": 0.3 + excess})
    for solve_for in ((), ("drive.tau",)):
        if excess > 0:
            assert refusal(source, hold={"A.phi": 0.3}, solve_for=solve_for) == (
                "no equilibrium within the hard limits: the one found has A.phi = 0.3 rad, beyond its lower "
                "limit of 0.300001 rad"
            )
        elif solve_for or excess == 0:
            found = gelenk.equilibrium(source, hold={"A.phi": 0.3}, solve_for=solve_for)
            carried = found.inputs["drive.tau"] if solve_for else found.held["A.phi"].contact
            assert carried == pytest.approx(GRAVITY * math.sin(0.3), rel=1e-12)
        else:
            assert "the given inputs do not hold this pose" in refusal(source, hold={"A.phi": 0.3})


def test_a_pose_that_a_limit_in_the_loop_prevents_cannot_be_held() -> None:
    """The crank reaches the angle at which its rocker meets the bound, but none beyond it."""
    free = gelenk.equilibrium(four_bar(-1.0), hold={"A.phi": -0.8}, solve_for="drive.tau")
    rocker = free.values["D.phi"]
    before = gelenk.equilibrium(four_bar(-1.0), hold={"A.phi": -0.9}, solve_for="drive.tau").values["D.phi"]
    side = "upper" if rocker > before else "lower"
    source = four_bar(-1.0)
    for bound, reached in ((rocker + 1e-6, True), (rocker - 1e-6, False)):
        source["joints"]["D"]["limit"] = {side: bound if side == "upper" else 2 * rocker - bound}
        if reached:
            found = gelenk.equilibrium(source, hold={"A.phi": -0.8}, solve_for="drive.tau")
            assert found.inputs == pytest.approx(free.inputs, rel=1e-9)
        else:
            assert refusal(source, hold={"A.phi": -0.8}, solve_for="drive.tau").startswith(
                f"A.phi: the mechanism cannot be brought to the pose to hold: joints.D.limit.{side}: "
            )


@pytest.mark.parametrize("start", [0.1, 0.2, 0.3])
def test_a_run_never_starts_outside(start: float, tmp_path: Path) -> None:
    """Start values beyond a limit are a guess like any other; an FMU starts there, too."""
    source = pendulum(start, limit={"lower": 0.2})
    assert at_rest(source).output("A.phi") == 0.2
    fmu = gelenk.export_fmu(source | {"solver": {"start": "equilibrium"}}, tmp_path / "x.fmu")
    run = fmpy.simulate_fmu(fmu, stop_time=0.1, output_interval=0.01, output=["A.phi"])
    assert set(run["A.phi"]) == {0.2}


def test_linear_model_at_the_equilibrium_is_that_of_the_contact() -> None:
    source = pendulum(0.5, limit={"lower": 0.2})
    found = gelenk.equilibrium(source)
    assert gelenk.linear.linear_model(gelenk.load(source), at=found.at).states == ()
