# SPDX-License-Identifier: BSD-3-Clause
"""A run that begins at rest (solver.start) begins where gelenk.equilibrium finds one, whichever there are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files
from hypothesis import given
from hypothesis import strategies as st
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from properties.bounds import examples
from properties.test_scenes import trees
from special.drawn import at_rest, drawn
from special.listed import starts

import gelenk
from gelenk.equilibria.pose import LinearizedPose, PosedPlant

# rad, m. After Newton's last step what is left is rounding, 1e-14 by the closure of loops, over pivots of
# 1e-6 at least; along directions that nothing holds neither moves.
SAME = 1e-8
# What neither of them can find: no derivatives exist, nothing closes, or a joint tells no states.
REFUSED = (gelenk.UsageError, gelenk.AssemblyError, gelenk.EquilibriumError, gelenk.GelenkError)


def begun(source: Scene, start: str = "equilibrium") -> dict[str, float]:
    """All outputs at the start of a run."""
    plant = gelenk.Simulation(gelenk.load({**source, "solver": {**source.get("solver", {}), "start": start}}))
    plant.initialize()
    return dict(zip((s.name for s in plant.outputs), plant.values().tolist(), strict=True))


def own_search(source: Any, monkeypatch: pytest.MonkeyPatch, **arguments: Any) -> gelenk.Equilibrium:
    """That of Python alone, as for an FMU of others."""

    def stay(_plant: PosedPlant, pose: LinearizedPose, *_: Any) -> LinearizedPose:
        return pose

    with monkeypatch.context() as m:
        m.setattr(PosedPlant, "native_equilibrium", stay)
        return gelenk.equilibrium(source, **arguments)


def apart(found: Mapping[str, float], other: Mapping[str, float]) -> float:
    """The largest difference of a coordinate; Q and -Q are the same."""
    out = 0.0
    for name, value in found.items():
        quantity = name.rpartition(".")[2]
        if ".Q[" in name:
            out = max(out, min(abs(value - other[name]), abs(value + other[name])))
        elif quantity.startswith(("phi", "s")) and "[" not in quantity:
            out = max(out, abs(value - other[name]))
    return out


def outcome(source: Scene) -> float | str:
    """By how much both differ, or what neither finds."""
    try:
        run: Any = begun(source)
    except REFUSED as e:
        run = e
    try:
        found = gelenk.equilibrium(source)
    except REFUSED as e:
        # At a change point a mechanism may well stand still; only derivatives do not exist there.
        undefined = "derivatives do not exist" in str(e) or "cannot provide states" in str(e)
        if isinstance(run, Exception) or undefined:
            return "none"
        return f"a run begins at rest, but: {e}"
    if isinstance(run, Exception):
        return f"found {found.values}, but of the run: {run}"
    return apart(found.values, run)


def assert_same(cases: Mapping[str, Scene], least: float) -> None:
    """least: the share of them in which there is one."""
    outcomes = {name: outcome(source) for name, source in cases.items()}
    found = {name: x for name, x in outcomes.items() if x != "none"}
    assert {name: x for name, x in found.items() if isinstance(x, str) or x > SAME} == {}
    assert len(found) >= least * len(outcomes)


@pytest.mark.parametrize("path", scene_files.good(), ids=lambda path: path.stem)
def test_shipped_scenes_come_to_the_same_rest(path: Path) -> None:
    """As they are, and from other angles."""
    cases = list(starts(path.stem, gelenk.load(path).to_dict()))[::4]
    assert_same({case.name: at_rest(case.source) for case in cases}, 0)


def test_random_linkages_come_to_the_same_rest() -> None:
    """Planar and spatial, at special positions, far from any rest: many have several, some none."""
    assert_same({(case := drawn(seed)).name: at_rest(case.source) for seed in range(60)}, 0.75)


@examples(40)
@given(source=trees(), angle=st.floats(-1, 1))
def test_random_trees_come_to_the_same_rest(source: Scene, angle: float) -> None:
    for entry in source["joints"].values():
        if entry["type"] == "revolute":
            entry |= {"stiffness": 5.0, "spring_reference": angle}
    found = outcome(source)
    assert found == "none" or (isinstance(found, float) and found <= SAME), found


# --- several rests ---


def soft_spring(phi: float) -> Scene:
    """A bob upright on a torsion spring that is too soft for it: g sin(phi) = 4 phi, unstable at 0."""
    pin = joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], stiffness=4.0, start={"phi": phi})
    return scene({"bob": body(1.0, (0, 1, 0))}, {"A": pin}, gravity=[0, -GRAVITY, 0])


def snap_through(s: float) -> Scene:
    """A slider between two pins, on springs that are too long for it to stand between them."""
    spring = {"type": "spring_damper", "to": frame("slider"), "stiffness": 200.0, "length": 0.5}
    out = scene(
        {"slider": body(1.0)},
        {"S": joint("prismatic", frame("ground"), frame("slider"), axis=[0, 1, 0], start={"s": s})},
        gravity=[0, -GRAVITY, 0],
    )
    out["forces"] = {
        "left": spring | {"from": frame("ground", (-0.4, 0, 0))},
        "right": spring | {"from": frame("ground", (0.4, 0, 0))},
    }
    return out


def sprung_four_bar(phi: float) -> Scene:
    out = four_bar(phi)
    out["joints"]["A"] |= {"stiffness": 4.0, "spring_reference": 0.4}
    return out


SEVERAL = {
    "bob on a soft spring": (soft_spring, (-3.0, -1.0, -0.3, -1e-3, 1e-3, 0.4, 1.4, 3.0)),
    "snap-through": (snap_through, (-0.6, -0.25, -0.01, 0.0, 0.02, 0.25, 0.4, 0.8)),
    "sprung four-bar": (sprung_four_bar, (-2.5, -1.0, 0.0, 0.7, 1.5, 2.2, 3.1)),
}


@pytest.mark.parametrize("name", SEVERAL)
def test_of_several_rests_all_searches_take_the_same(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run, gelenk.equilibrium, and its own search, which poses and inputs to be found are left to."""
    make, places = SEVERAL[name]
    found = []
    for place in places:
        source = make(place)
        run = begun(source)
        assert apart(gelenk.equilibrium(source).values, run) < SAME, place
        assert apart(own_search(source, monkeypatch).values, run) < SAME, place
        found.append(next(iter(run.values())))
    assert np.ptp(found) > 0.1  # there are several


@pytest.mark.parametrize(("start", "expected"), [(1e-3, 0.0), (0.4, None), (-1.9, None)])
def test_rests_of_the_bob_on_a_spring(start: float, expected: float | None) -> None:
    phi = begun(soft_spring(start))["A.phi"]
    assert GRAVITY * math.sin(phi) == pytest.approx(4 * phi, abs=SAME)
    if expected is not None:
        assert phi == pytest.approx(expected, abs=SAME)  # next to the upright it is found, though unstable


def test_from_the_upright_a_chain_of_pendulums_stays_there() -> None:
    """Exactly there nothing pulls; a little beside it the unstable rest is the nearest."""
    rods = {f"rod{i}": body(0.5, (0, 0.1, 0), (1e-3, 1e-4, 1e-3)) for i in range(3)}
    for tilt in (0.0, 1e-3):
        joints = {
            f"J{i}": joint(
                "revolute", frame(f"rod{i - 1}", (0, 0.2, 0)) if i else frame("ground"), frame(f"rod{i}"),
                axis=[0, 0, 1], start={"phi": tilt},
            )
            for i in range(3)
        }  # fmt: skip
        source = scene(rods, joints, gravity=[0, -GRAVITY, 0])
        assert [begun(source)[f"J{i}.phi"] for i in range(3)] == pytest.approx([0, 0, 0], abs=SAME)
        assert apart(gelenk.equilibrium(source).values, begun(source)) < SAME


# --- what used to go wrong ---


def test_dead_centres_of_a_motor_are_no_rests() -> None:
    """A driven joint's acceleration vanishes at its dead centre, whatever the rest does there."""
    source = at_rest(drawn(54).source)
    assert source["motors"]["push"]["joint"] == "J0"
    assert apart(gelenk.equilibrium(source).values, begun(source)) < SAME


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_springs_of_joints_that_close_loops_are_wound_up(turns: int) -> None:
    """Without weight the crank goes where its spring is slack, however often round, though the pose of a
    joint that closes a loop tells its angle within a turn only.
    """
    slack = 1.4 + 2 * math.pi * turns
    source = four_bar(1.0, gravity=[0, 0, 0])
    source["joints"]["A"] |= {"stiffness": 8.0, "spring_reference": slack}
    source["joints"]["A"] = source["joints"].pop("A")  # behind the others it is the one that is cut
    source["solver"] = {"reductions": {"cut_choice": False}}
    del source["motors"]  # it would be none that is cut
    assert begun(source)["A.phi"] == pytest.approx(slack, abs=SAME)
    assert gelenk.equilibrium(source).values["A.phi"] == pytest.approx(slack, abs=SAME)


def test_where_nothing_pulls_a_start_stays_to_the_bit() -> None:
    source = four_bar(1.0, gravity=[0, 0, 0])
    assert begun(source) == begun(source, "as_given")


def test_poses_are_held_in_a_scene_that_begins_at_rest() -> None:
    """The plant's own search would leave the pose to be held."""
    source = four_bar(1.0)
    expected = gelenk.equilibrium(source, hold={"A.phi": 0.3}, solve_for="drive.tau")
    source["solver"] = {"start": "equilibrium"}
    found = gelenk.equilibrium(source, hold={"A.phi": 0.3}, solve_for="drive.tau")
    assert found.values["A.phi"] == 0.3
    assert found.inputs == pytest.approx(expected.inputs, rel=1e-12)
    assert found.residual < 1e-8
