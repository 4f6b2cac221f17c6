# SPDX-License-Identifier: BSD-3-Clause
"""Every malformed scene is refused with exactly the sentences it deserves."""

from __future__ import annotations

import re
from math import cos, hypot, sin
from pathlib import Path

import pytest
import scene_files

import gelenk


@pytest.mark.parametrize("path", scene_files.malformed(), ids=lambda path: path.stem)
def test_malformed_scene_is_refused_in_these_words(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = scene_files.expected(path)
    assert expected, f"{path.name} does not say what it expects"
    monkeypatch.chdir(path.parent)  # the message has the name as it was given
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(path.name)
    assert list(error.value.lines) == expected


def test_there_are_enough_malformed_scenes() -> None:
    assert len(scene_files.malformed()) >= 40


def test_ready_scenes_are_not_refused() -> None:
    assert [gelenk.load(path).name for path in scene_files.good()]


def test_loop_that_cannot_close_says_by_how_much() -> None:
    """With the crank held, its pin stands off the rocker's; coupler and rocker stretched reach 0.4 m."""
    scene = gelenk.load(scene_files.FOLDER / "loop_too_short.yaml")
    with pytest.raises(gelenk.AssemblyError) as error:
        gelenk.Simulation(scene).initialize()
    gap = re.search(r"smallest closure error ([0-9.]+) m", str(error.value))
    assert gap, str(error.value)
    apart = hypot(0.7 - 0.15 * cos(0.52), 0.15 * sin(0.52))
    assert float(gap[1]) == pytest.approx(apart - 0.4, abs=1e-3)  # three digits are printed
    assert str(error.value).endswith(
        "loop_too_short.yaml:11: loop through C cannot be closed: "
        "smallest closure error 0.175 m at A.phi = 0.52 rad (allowed 1e-9 m). "
        "Check the positions in joints A, B, C, D, and the fixed start of A."
    )


def test_link_that_cannot_say_how_it_moves_is_named() -> None:
    scene = gelenk.load(scene_files.FOLDER / "link_without_mass.yaml")
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.Simulation(scene).initialize()
    assert str(error.value).endswith(
        "link_without_mass.yaml:6: bodies.coupler: moves without inertia: "
        "found mass and inertia 0 along a motion of its joint, expected mass > 0 (kg), "
        "or an inertia about the joint's axis > 0 (kg m2), here or on bodies it carries, or a gear, a rack, "
        "a prescribed motion or a loop that couples this motion to one with inertia (a spring is not "
        "sufficient: the body would be where its force is zero, at any velocity)"
    )


def faults(unknown: int) -> list[str]:
    """The lines of the error of a scene with this number of unknown fields, and without joints."""
    text = "gelenk: 1\nbodies: {b: {mass: 1}}\n" + "".join(f"k{i}: 1\n" for i in range(unknown))
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(text)
    return str(error.value).splitlines()


@pytest.mark.parametrize("others", [0, 1, 20_000])
def test_the_first_hundred_faults_are_told_and_the_number_of_the_others(others: int) -> None:
    found = faults(100 - len(faults(0)) + others)
    assert len(found) == 100 + (others > 0)
    assert re.match(r"scene:3: k0: found an unknown field", found[len(faults(0))])
    assert ("more faults" in found[-1]) == (others > 0)
    if others > 0:
        assert found[-1] == f"scene:1: {others} more faults"
