# SPDX-License-Identifier: BSD-3-Clause
"""The assembly that is found depends on the start values, not on the order of the scene file."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import pytest
import scene_files
import warned
from benchmarks.speed.families import MAKERS
from benchmarks.speed.tree import to_scene
from mechanisms import Scene, frame, joint, reordered, rod, scene
from special.listed import started

import gelenk

pytestmark = [warned.AMBIGUOUS, warned.GUESSES, warned.STILL]

ORDERS = range(12)


def angles(source: Scene) -> dict[str, float]:
    """Angles of all hinges, modulo one revolution."""
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0)
    names = sorted(s.name for s in plant.outputs if s.name.endswith(".phi"))
    return {name: math.remainder(plant.output(name), 2 * math.pi) for name in names}


def five_bar() -> Scene:
    source = gelenk.load(scene_files.SCENES / "five_bar.yaml").to_dict()
    return started(source, dict.fromkeys(("left", "right"), -math.pi / 2))


def squeezer() -> Scene:
    return started(gelenk.load(to_scene(MAKERS["andrews"]())).to_dict(), {"j_K1": -math.pi / 2})


@pytest.mark.parametrize("make", [five_bar, squeezer])
def test_guesses_far_from_all_assemblies_lead_to_the_nearest(make: Callable[[], Scene]) -> None:
    """For every order of the file, although the cut joints and the first iterate depend on it."""
    expected = angles(make())
    for seed in ORDERS:
        found = angles(reordered(make(), seed))
        for name, value in expected.items():  # closed to 1e-14, over lever arms of some 0.01 m
            assert math.remainder(found[name] - value, 2 * math.pi) == pytest.approx(0, abs=1e-9), (
                seed,
                name,
            )


def mirrored() -> Scene:
    """Two upright cranks at a distance of 1 m. The guesses place two bars of 0.6 m on the line between the
    cranks' tips; the bars meet above or below it, equally far from the guesses.
    """
    about_z = {"axis": [0, 0, 1]}
    bodies = {name: rod(0.3, length) for name, length in (("a", 0.4), ("b", 0.4), ("c", 0.6), ("d", 0.6))}
    upright = {"phi": math.pi / 2, "fixed": True}
    joints = {
        "A": joint("revolute", frame("ground"), frame("a"), start=upright, **about_z),
        "B": joint("revolute", frame("ground", (1, 0, 0)), frame("b"), start=upright, **about_z),
        "C": joint("revolute", frame("a", (0.4, 0, 0)), frame("c"), start={"phi": -math.pi / 2}, **about_z),
        "D": joint("revolute", frame("b", (0.4, 0, 0)), frame("d"), start={"phi": math.pi / 2}, **about_z),
        "E": joint(
            "revolute", frame("c", (0.6, 0, 0)), frame("d", (0.6, 0, 0)), start={"phi": math.pi}, **about_z
        ),
    }
    return scene(bodies, joints, name="Mirrored")


def test_two_equally_close_assemblies_raise_a_warning() -> None:
    """In both, cos = 0.5 / 0.6 of the angle to the line; a closer guess selects one of them."""
    for source in [mirrored(), *(reordered(mirrored(), seed) for seed in ORDERS)]:
        with pytest.warns(
            gelenk.StartWarning, match="two positions that are equally close to the start values: with"
        ):
            gelenk.simulate(source, stop=1e-3)
        lean = abs(angles(source)["C.phi"] + math.pi / 2)
        assert lean == pytest.approx(math.acos(0.5 / 0.6), rel=1e-9)
        meant = reordered(source, 0)
        meant["joints"]["C"]["start"]["phi"] += 0.05
        with warnings.catch_warnings():
            warnings.filterwarnings("error", ".*equally close", gelenk.StartWarning)
            gelenk.simulate(meant, stop=1e-3)
            assert angles(meant)["C.phi"] == pytest.approx(lean - math.pi / 2, rel=1e-9)
