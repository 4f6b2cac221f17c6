# SPDX-License-Identifier: BSD-3-Clause
"""Guesses that assembly changes a lot are warned of, and a wrong axis is named."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import pytest

import gelenk

CHANGED = re.compile(
    r"(?:\S+: )?joints\.(\w+)\.start\.(\w+): found (\S+) rad, a guess with which the loops cannot be closed, "
    r"expected one near (\S+) rad, which is used; gelenk assemblies lists all positions"
)


@pytest.fixture(scope="module")
def closed(four_bar: gelenk.Scene) -> dict[str, Any]:
    """The four-bar with the angles of its closed position as guesses; that of the crank is fixed."""
    plant = gelenk.Simulation(four_bar)
    plant.initialize()
    scene = four_bar.to_dict()
    for joint in "BCD":
        scene["joints"][joint]["start"] = {"phi": plant.output(f"{joint}.phi")}
    return scene


def sentences(scene: Any, **parameters: Any) -> list[str]:
    """What a run warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gelenk.simulate(scene, stop=0.01, inputs={"drive.tau": 1.0}, parameters=parameters)
    assert {w.category for w in caught} <= {gelenk.StartWarning}
    return [str(w.message) for w in caught]


def moved(scene: dict[str, Any], joint: str, by: float) -> dict[str, Any]:
    start = {"phi": scene["joints"][joint]["start"]["phi"] + by}
    return scene | {"joints": scene["joints"] | {joint: scene["joints"][joint] | {"start": start}}}


@pytest.mark.parametrize("joint", ["B", "C", "D"])  # one of them closes the loop
@pytest.mark.parametrize(
    ("by", "warned"), [(0.0999, False), (-0.0999, False), (0.1001, True), (-0.1001, True)]
)
def test_a_guess_changed_by_more_than_a_tenth_is_warned_of(
    closed: dict[str, Any], joint: str, by: float, warned: bool
) -> None:
    """The crank is fixed, so that the position is unique nearby, and the change is that of the guess."""
    found = sentences(moved(closed, joint, by))
    assert len(found) == warned
    for sentence in found:
        changed = CHANGED.fullmatch(sentence)
        assert changed is not None, sentence
        assert (changed[1], changed[2]) == (joint, "phi")
        right = closed["joints"][joint]["start"]["phi"]
        assert float(changed[3]) == pytest.approx(right + by, rel=1e-5)  # six digits
        assert float(changed[4]) == pytest.approx(right, rel=1e-5)


def test_a_full_turn_is_no_change(closed: dict[str, Any]) -> None:
    assert sentences(moved(closed, "D", 6.283185307179586)) == []


def test_an_fmu_warns_alike(closed: dict[str, Any], tmp_path: Path) -> None:
    scene = moved(closed, "D", 0.3)
    fmu = gelenk.export_fmu(scene, tmp_path / "x.fmu")
    (inside,) = sentences(scene)
    (outside,) = sentences(fmu)
    assert CHANGED.fullmatch(inside)
    assert outside == f"{fmu}: {inside}"  # not the folder in which it is unpacked


def test_joints_that_follow_a_start_set_by_a_parameter_are_not_warned_of(
    closed: dict[str, Any], tmp_path: Path
) -> None:
    """The crank starts half a turn away, as the master wants; the guesses of the file are for its start."""
    away = {"A.phi_start": closed["joints"]["A"]["start"]["phi"] + 3.0}
    fmu = gelenk.export_fmu(closed, tmp_path / "x.fmu")
    for source in (closed, fmu):
        assert sentences(source, **away) == []
        assert sentences(source, **away, **{"A.fixed": True}) == []
    by_hand = closed | {"joints": closed["joints"] | {
        "A": closed["joints"]["A"] | {"start": {"phi": away["A.phi_start"], "fixed": True}}}}  # fmt: skip
    assert len(sentences(by_hand)) == 1  # in the file, the guesses are for this start


def test_a_guess_that_a_parameter_sets_is_warned_of_by_its_name(
    closed: dict[str, Any], tmp_path: Path
) -> None:
    """The crank is fixed: the rocker is where its guess was before."""
    right = closed["joints"]["D"]["start"]["phi"]
    fmu = gelenk.export_fmu(closed, tmp_path / "x.fmu")
    expected = (
        f"D.phi_start: found {right + 0.3:.6g} rad, a guess with which the loops cannot be closed, expected "
        f"one near {right:.6g} rad, which is used; D.fixed keeps it exactly"
    )
    for source in (closed, fmu):
        assert sentences(source, **{"D.phi_start": right + 0.3}) == [expected]
        assert sentences(source, **{"D.phi_start": right + 0.05}) == []


@pytest.mark.parametrize("joint", ["C", "D"])  # with others, the loop can be closed, in another position
def test_a_single_wrong_axis_is_named(four_bar: gelenk.Scene, joint: str) -> None:
    scene = four_bar.to_dict()
    scene["joints"]["A"]["start"] = {"phi": 1.2}
    scene["joints"][joint]["axis"] = [0.0, 0.0, 1.0]
    with pytest.raises(gelenk.AssemblyError) as refused:
        gelenk.Simulation(scene).initialize()
    assert str(refused.value).endswith(
        f"Check the axis of joint {joint}: those of all other joints in the loop are parallel."
    )
