# SPDX-License-Identifier: BSD-3-Clause
"""Runs that start at equilibrium (solver.start) start at the one of several that gelenk.equilibrium finds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files
import warned
from hypothesis import given
from hypothesis import strategies as st
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from properties.bounds import examples
from properties.test_scenes import trees
from special.drawn import at_rest, drawn
from special.listed import starts

import gelenk

# rad, m. The error after Newton's last step is rounding, 1e-14 from the closure of loops, over pivots of at
# least 1e-6; along directions without a restoring force both searches leave the start unchanged.
POSITION_TOLERANCE = 1e-8
# Expected where neither finds an equilibrium: no derivatives, loops that do not close, no states.
EXPECTED_ERRORS = (gelenk.UsageError, gelenk.AssemblyError, gelenk.EquilibriumError, gelenk.GelenkError)


def start_values(source: Scene, start: str = "equilibrium") -> dict[str, float]:
    """All outputs at the start of a run that starts at equilibrium."""
    plant = gelenk.Simulation(gelenk.load({**source, "solver": {**source.get("solver", {}), "start": start}}))
    plant.initialize()
    return dict(zip((s.name for s in plant.outputs), plant.values().tolist(), strict=True))


def largest_difference(found: Mapping[str, float], other: Mapping[str, float]) -> float:
    """The largest difference between coordinates; Q and -Q are the same rotation."""
    out = 0.0
    for name, value in found.items():
        quantity = name.rpartition(".")[2]
        if ".Q[" in name:
            out = max(out, min(abs(value - other[name]), abs(value + other[name])))
        elif quantity.startswith(("phi", "s")) and "[" not in quantity:
            out = max(out, abs(value - other[name]))
    return out


def outcome(source: Scene) -> float | str:
    """By how much run and gelenk.equilibrium differ, "none" if neither succeeds, or which of them fails."""
    try:
        run: Any = start_values(source)
    except EXPECTED_ERRORS as e:
        run = e
    try:
        found = gelenk.equilibrium(source)
    except EXPECTED_ERRORS as e:
        # At a change point a mechanism may well stand still; only derivatives do not exist there.
        undefined = "derivatives do not exist" in str(e) or "cannot provide states" in str(e)
        if isinstance(run, Exception) or undefined:
            return "none"
        return f"a run begins at rest, but: {e}"
    if isinstance(run, Exception):
        return f"found {found.values}, but of the run: {run}"
    return largest_difference(found.values, run)


def assert_same(cases: Mapping[str, Scene], min_fraction: float) -> None:
    """Run and gelenk.equilibrium agree; at least this fraction of the cases has an equilibrium."""
    outcomes = {name: outcome(source) for name, source in cases.items()}
    found = {name: x for name, x in outcomes.items() if x != "none"}
    assert {name: x for name, x in found.items() if isinstance(x, str) or x > POSITION_TOLERANCE} == {}
    assert len(found) >= min_fraction * len(outcomes)


@warned.GUESSES
@pytest.mark.parametrize("path", scene_files.good(), ids=lambda path: path.stem)
def test_runs_of_shipped_scenes_start_at_the_equilibrium_found(path: Path) -> None:
    """The scenes as they are, and with other start angles."""
    cases = list(starts(path.stem, gelenk.load(path).to_dict()))[::4]
    assert_same({case.name: at_rest(case.source) for case in cases}, 0)


@pytest.mark.thorough
@warned.SINGULAR
def test_runs_of_random_linkages_start_at_the_equilibrium_found() -> None:
    """Planar and spatial, at special positions, far from equilibrium; many have several equilibria."""
    assert_same({(case := drawn(seed)).name: at_rest(case.source) for seed in range(60)}, 0.75)


@warned.GYRATION
@pytest.mark.thorough
@examples(40)
@given(source=trees(), angle=st.floats(-1, 1))
def test_runs_of_random_trees_start_at_the_equilibrium_found(source: Scene, angle: float) -> None:
    for entry in source["joints"].values():
        if entry["type"] == "revolute":
            entry |= {"stiffness": 5.0, "spring_reference": angle}
    found = outcome(source)
    assert found == "none" or (isinstance(found, float) and found <= POSITION_TOLERANCE), found


# --- several equilibria ---


def soft_spring(phi: float) -> Scene:
    """A bob upright on a torsion spring that is too soft to hold it: g sin(phi) = 4 phi, unstable at 0."""
    pin = joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], stiffness=4.0, start={"phi": phi})
    return scene({"bob": body(1.0, (0, 1, 0))}, {"A": pin}, gravity=[0, -GRAVITY, 0])


def snap_through(s: float) -> Scene:
    """A slider between two pins, on springs that are too long for a stable equilibrium in the middle."""
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


SEVERAL_EQUILIBRIA = {
    "bob on a soft spring": (soft_spring, (-3.0, -1.0, -0.3, -1e-3, 1e-3, 0.4, 1.4, 3.0)),
    "snap-through": (snap_through, (-0.6, -0.25, -0.01, 0.0, 0.02, 0.25, 0.4, 0.8)),
    "sprung four-bar": (sprung_four_bar, (-2.5, -1.0, 0.0, 0.7, 1.5, 2.2, 3.1)),
}


@pytest.mark.parametrize("name", SEVERAL_EQUILIBRIA)
def test_of_several_equilibria_run_and_search_find_the_same(name: str) -> None:
    make, places = SEVERAL_EQUILIBRIA[name]
    found = []
    for place in places:
        source = make(place)
        run = start_values(source)
        assert largest_difference(gelenk.equilibrium(source).values, run) < POSITION_TOLERANCE, place
        found.append(next(iter(run.values())))
    assert np.ptp(found) > 0.1  # several equilibria are found


@pytest.mark.parametrize(("start", "expected"), [(1e-3, 0.0), (0.4, None), (-1.9, None)])
def test_equilibria_of_the_bob_on_a_soft_spring(start: float, expected: float | None) -> None:
    phi = start_values(soft_spring(start))["A.phi"]
    assert GRAVITY * math.sin(phi) == pytest.approx(4 * phi, abs=POSITION_TOLERANCE)
    if expected is not None:
        assert phi == pytest.approx(expected, abs=POSITION_TOLERANCE)  # the closest one, though unstable


def test_upright_chain_of_pendulums_remains_upright() -> None:
    """Exactly upright it is in equilibrium; from a slight tilt, the unstable equilibrium is the closest."""
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
        assert [start_values(source)[f"J{i}.phi"] for i in range(3)] == pytest.approx(
            [0, 0, 0], abs=POSITION_TOLERANCE
        )
        assert (
            largest_difference(gelenk.equilibrium(source).values, start_values(source)) < POSITION_TOLERANCE
        )


# --- cases that used to fail ---


def test_dead_center_of_a_driven_joint_is_not_an_equilibrium() -> None:
    """The acceleration of a driven joint vanishes at its dead center even if other joints accelerate."""
    source = at_rest(drawn(54).source)
    assert source["motors"]["push"]["joint"] == "J0"
    assert largest_difference(gelenk.equilibrium(source).values, start_values(source)) < POSITION_TOLERANCE


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_springs_of_loop_closing_joints_count_revolutions(turns: int) -> None:
    """Without gravity the crank moves to the reference angle of its spring, even over several revolutions,
    although the pose of a loop-closing joint determines its angle only modulo one revolution.
    """
    reference = 1.4 + 2 * math.pi * turns
    source = four_bar(1.0, gravity=[0, 0, 0])
    source["joints"]["A"] |= {"stiffness": 8.0, "spring_reference": reference}
    source["joints"]["A"] = source["joints"].pop("A")  # listed last, this joint is cut
    source["solver"] = {"reductions": {"cut_choice": False}}
    del source["motors"]  # a driven joint would not be cut
    assert start_values(source)["A.phi"] == pytest.approx(reference, abs=POSITION_TOLERANCE)
    assert gelenk.equilibrium(source).values["A.phi"] == pytest.approx(reference, abs=POSITION_TOLERANCE)


def test_start_without_residual_forces_is_kept_bit_for_bit() -> None:
    source = four_bar(1.0, gravity=[0, 0, 0])
    assert start_values(source) == start_values(source, "as_given")


def test_poses_are_held_in_a_scene_that_starts_at_equilibrium() -> None:
    """The plant's own search would change the pose to hold."""
    source = four_bar(1.0)
    expected = gelenk.equilibrium(source, hold={"A.phi": 0.3}, solve_for="drive.tau")
    source["solver"] = {"start": "equilibrium"}
    found = gelenk.equilibrium(source, hold={"A.phi": 0.3}, solve_for="drive.tau")
    assert found.values["A.phi"] == 0.3
    assert found.inputs == pytest.approx(expected.inputs, rel=1e-12)
    assert found.residual < 1e-8
