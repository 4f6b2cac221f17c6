# SPDX-License-Identifier: BSD-3-Clause
"""`assembly.tolerance`: overconstrained mechanisms whose numbers are rounded to four to eight digits."""

from __future__ import annotations

import copy
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from looped import looped
from mechanisms import Array, Scene
from models.rounded import (
    DEGREES_OF_FREEDOM,
    MECHANISMS,
    Placed,
    bennett,
    circles,
    four_bar,
    scene,
    three_cranks_in_line,
    tilted,
)
from samples import thorough_beyond

import gelenk

# The rounding error of a number from 1 to 10 is at most 0.5 * 10^(1 - digits); positions and angles here are
# no larger than pi, and a rotation has three of them. Twice that is sufficient.
DIGITS = (4, 5, 6, 8)
SMALL = {*MECHANISMS} - {"goldberg", "bennett", "trihedral_bricard"}


def tolerance(digits: int) -> float:
    return 10.0 ** (1 - digits)


# rad, m: closure error of all constraint equations, at every output; lengths are about 1 m.
CLOSED = 1e-13
# Error of joint coordinates in units of 10^-digits: some 50 numbers have random errors of up to 5 each, which
# add up to 20; transmission ratios between joints multiply that by a few. Measured: 40 at most.
MAX_ERROR = 100


def started(name: str, digits: int | None = None, **sections: Any) -> Scene:
    """The mechanism; its first joint has a start velocity, except in the Stewart platform."""
    joints = MECHANISMS[name]()
    fields = {} if name == "stewart" else {joints[0][0]: {"start": {"w": 1.0}}}
    return scene(joints, digits, fields=fields, **sections)


def rounded_scene(name: str, digits: int) -> Scene:
    return started(name, digits, assembly={"tolerance": tolerance(digits)})


def initialized(data: Scene | gelenk.Scene) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)
        plant.initialize()
    return plant


@pytest.mark.parametrize("name", thorough_beyond(MECHANISMS, SMALL))
@looped("digits", DIGITS)
@looped("without", [[], ["all"]])
def test_rounded_mechanism_keeps_its_degrees_of_freedom_and_stays_closed(
    name: str, digits: int, without: list[str]
) -> None:
    """Without reductions, the loops have all their spatial constraint equations: all must be satisfied."""
    plant = initialized(gelenk.load(rounded_scene(name, digits)).without(without))
    assert plant.size.degrees_of_freedom == DEGREES_OF_FREEDOM[name]
    for t in np.linspace(0.05, 1, 20):
        plant.step_to(float(t))
        assert plant.diagnostics["constraints.position"] < CLOSED
    moves = [max(m.turn, m.shift) for m in plant._core.moved_frames()]
    assert max(moves, default=0) <= tolerance(digits)


@looped("digits", DIGITS)
def test_mechanism_without_redundant_constraints_is_not_modified(digits: int) -> None:
    """A Stewart platform can be assembled with any rounding of its numbers."""
    with_tolerance = initialized(rounded_scene("stewart", digits))
    as_given = initialized(started("stewart", digits))
    assert not with_tolerance._core.moved_frames()
    for plant in (with_tolerance, as_given):
        plant.step_to(0.2)
    assert np.array_equal(with_tolerance.values(), as_given.values())


@pytest.mark.parametrize("name", thorough_beyond(MECHANISMS, SMALL))
def test_exact_mechanism_is_not_modified(name: str) -> None:
    """No frame moves, even with the largest tolerance that is permitted."""
    plant = initialized(started(name, assembly={"tolerance": 1e-2}))
    assert not plant._core.moved_frames()


def coordinates(data: Scene, drives: list[str]) -> Array:
    """All scalar coordinates while these joints rotate at 0.8 rad/s."""
    constraints = {
        f"drive_{joint}": {"type": "motion", "joint": joint, "polynomial": [0, 0.8]} for joint in drives
    }
    plant = initialized({**data, "constraints": constraints})
    names = [s.name for s in plant.outputs if s.name.endswith((".phi", ".s", ".phi_a", ".phi_b"))]
    rows = []
    for t in np.linspace(0.1, 0.5, 5):
        plant.step_to(float(t))
        rows.append(plant.values(names))
    return np.array(rows)


@pytest.mark.parametrize("name", [name for name in MECHANISMS if name != "stewart"])
@looped("digits", DIGITS)
def test_rounded_mechanism_follows_the_exact_one(name: str, digits: int) -> None:
    drives = {"double_parallelogram": ["A0", "E0"], "three_cranks": ["A0"]}.get(name, ["A"])
    exact = coordinates(scene(MECHANISMS[name]()), drives)
    data = scene(MECHANISMS[name](), digits, assembly={"tolerance": tolerance(digits)})
    error = np.abs(coordinates(data, drives) - exact).max()
    assert error < MAX_ERROR * 10.0**-digits, f"off by {error:.3g}"


@looped("digits", DIGITS)
def test_rounded_four_bar_follows_the_closed_form(digits: int) -> None:
    """The rocker's angle, from the intersection of the circles of coupler and rocker."""
    data = scene(tilted(four_bar(phi=1.1)), digits, assembly={"tolerance": tolerance(digits)})
    found = coordinates(data, ["A"])[:, 3]
    D = np.array([0.6, 0.0])

    def rocker(phi: float) -> float:
        C = circles(0.21 * np.array([math.cos(phi), math.sin(phi)]), 0.53, D, 0.43)
        return math.atan2(C[1] - D[1], C[0] - D[0])

    exact = [rocker(1.1 + 0.8 * t) - rocker(1.1) for t in np.linspace(0.1, 0.5, 5)]
    assert np.abs(found - exact).max() < MAX_ERROR * 10.0**-digits


@looped("digits", DIGITS)
def test_rounded_bennett_linkage_satisfies_its_closure_equation(digits: int) -> None:
    """tan(t1/2) tan(t2/2) = sin((beta + alpha)/2) / sin((beta - alpha)/2) (Bennett 1914), with t1 and t2 the
    angles between consecutive sides; the start determines the sign, and which of the twists is alpha.
    """
    joints = bennett()
    points, axes = [p for *_, p, _ in joints], [a for *_, a in joints]

    def angle(i: int) -> float:
        """The angle from the side that arrives at joint i to the side that leaves it."""
        after = np.array(points[(i + 1) % 4]) - points[i]
        before = np.array(points[i]) - points[i - 1]
        return math.atan2(float(np.dot(axes[i], np.cross(before, after))), float(before @ after))

    law = math.sin((1.3 + 0.7) / 2) / math.sin((1.3 - 0.7) / 2)
    data = scene(joints, digits, assembly={"tolerance": tolerance(digits)})
    found = coordinates(data, ["A"])
    # A turns the side that arrives (its child), B the side that leaves.
    product = np.tan((angle(0) - found[:, 0]) / 2) * np.tan((angle(1) + found[:, 1]) / 2)
    exact = product[0] / abs(product[0]) * min((law, 1 / law), key=lambda x: abs(x - abs(product[0])))
    # the derivative of tan is 1/2 to 5 at these angles
    assert np.abs(product - exact).max() < 5 * MAX_ERROR * 10.0**-digits


@pytest.mark.parametrize("name", [name for name in MECHANISMS if name != "stewart"])
@looped("digits", DIGITS)
def test_rejection_without_tolerance_states_a_sufficient_tolerance(name: str, digits: int) -> None:
    data = started(name, digits)
    with pytest.raises(gelenk.AssemblyError, match=r"assembly: \{tolerance: ") as refusal:
        initialized(data)
    sufficient = float(str(refusal.value).split("{tolerance: ")[1].split("}")[0])
    assert sufficient <= tolerance(digits)
    plant = initialized({**data, "assembly": {"tolerance": sufficient}})
    assert plant.size.degrees_of_freedom == DEGREES_OF_FREEDOM[name]


def disturbed(name: str, size: float) -> Scene:
    """The mechanism with all numbers of its frames changed by up to `size`, rad or m."""
    rng = np.random.default_rng(4)
    data = copy.deepcopy(started(name))
    for joint in data["joints"].values():
        for half in (joint["parent"], joint["child"]):
            half["position"] = list(half["position"] + size * rng.uniform(-1, 1, 3))
            half["rotation"]["rpy"] = list(half["rotation"]["rpy"] + size * rng.uniform(-1, 1, 3))
    return data


@pytest.mark.parametrize("name", thorough_beyond(MECHANISMS, SMALL - {"sarrus", "double_parallelogram"}))
@looped("exponent", range(-14, -3))
def test_disturbed_mechanism_runs_with_all_degrees_of_freedom_or_is_rejected(
    name: str, exponent: int
) -> None:
    """Disturbances below and above 1e-12, from which closure errors count as contradictions, and 1e-9, up to
    which these are removed without a tolerance in the scene.
    """
    refusal = ""
    try:
        plant = initialized(disturbed(name, 10.0**exponent))
    except gelenk.AssemblyError as e:
        refusal = str(e)
    if refusal:
        assert exponent > -10, "a permitted closure error is no reason for rejection"
        assert "assembly: {tolerance: " in refusal
        return
    assert plant.size.degrees_of_freedom == DEGREES_OF_FREEDOM[name]
    plant.step_to(1.0)
    # A mechanism that is not modified keeps its misfit: up to 1e-12 here, more at other positions.
    assert plant.diagnostics["constraints.position"] < 1e-11


@pytest.mark.parametrize("which", "ABCD")
@looped("axis", [(1, 0, 0), (0.6, 0.8, 0)])
@looped("exponent", np.arange(-13, -4.5, 0.5))
def test_four_bar_with_a_tilted_axis_runs_or_is_rejected(which: str, axis: Any, exponent: float) -> None:
    """The plane is found for tilts up to 1e-11; rejection begins above 1e-9, up to which frames may move."""
    data = scene(four_bar(), fields={"A": {"start": {"w": 1.0}}})
    parent = data["joints"][which]["parent"]
    rpy = np.array(parent["rotation"]["rpy"])
    parent["rotation"]["rpy"] = list(rpy + 10.0**exponent * np.array([*axis[:2], 0]))
    if exponent > -8:
        with pytest.raises(gelenk.AssemblyError, match=r"assembly: \{tolerance: "):
            initialized(data)
        data["assembly"] = {"tolerance": 10.0 ** math.ceil(exponent)}
    plant = initialized(data) if exponent > -8 or exponent <= -9 else None
    if plant is None:
        return
    assert plant.size.planar
    plant.step_to(1.0)
    assert plant.diagnostics["constraints.position"] < CLOSED


def change_point() -> list[Placed]:
    """The hinges of a parallelogram with all links in line."""
    places = zip(four_bar(), ((0, 0), (0.2, 0.03), (0.7, -0.02), (0.5, 0.05)), strict=True)
    return [(n, t, a, b, np.array([x, 0.0, z]), axis) for (n, t, a, b, _, axis), (x, z) in places]


@pytest.mark.parametrize(
    "joints",
    [four_bar(phi=0.0), four_bar(phi=math.pi), change_point()],
    ids=["crank outwards", "crank inwards", "change point"],
)
@looped("digits", DIGITS)
def test_rounded_four_bar_starts_with_its_links_in_line(joints: list[Placed], digits: int) -> None:
    fields = {"A": {"start": {"w": 1.0}}}
    plant = initialized(
        scene(tilted(joints), digits, fields=fields, assembly={"tolerance": tolerance(digits)})
    )
    assert plant.size.degrees_of_freedom == 1
    plant.step_to(1.0)
    assert plant.diagnostics["constraints.position"] < CLOSED


def test_tolerance_slightly_above_the_required_one_suffices_and_below_it_does_not() -> None:
    """The frames of a Bennett linkage disturbed by 1e-6 must move by nearly that much."""
    data = disturbed("bennett", 1e-6)
    plant = initialized({**data, "assembly": {"tolerance": 1e-2}})
    needed = max(max(m.turn, m.shift) for m in plant._core.moved_frames())
    assert 1e-7 < needed < 1e-6
    initialized({**data, "assembly": {"tolerance": 1.001 * needed}})
    with pytest.raises(gelenk.AssemblyError, match=r"assembly: \{tolerance: 1e-06\}"):
        initialized({**data, "assembly": {"tolerance": 0.999 * needed}})


def test_moved_frames_are_reported() -> None:
    data = rounded_scene("sarrus", 6)
    with pytest.warns(gelenk.StartWarning, match=r"assembly.tolerance = 1e-05: 12 joint frames were moved"):
        gelenk.Simulation(gelenk.load(data)).initialize()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)
        report = gelenk.inspect(data)
    assert len(report.moved_frames) == 12
    joint, body, turn, shift = report.moved_frames[0]
    assert (joint, body) == ("A", "ground")
    assert 0 < turn < 1e-5
    assert shift < 1e-5
    assert "frames moved so that the loops close" in str(report)
    assert report.degrees_of_freedom == 1


def test_tolerance_is_a_parameter_of_the_fmu(tmp_path: Path) -> None:
    """Its value in the scene is the default; with zero instead, the same FMU rejects the start."""
    data = rounded_scene("bennett", 6)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)
        fmu = gelenk.export_fmu(gelenk.load(data), tmp_path / "bennett.fmu")
        here = gelenk.simulate(data, stop=0.2)
        there = gelenk.simulate(fmu, stop=0.2)
    # The same code on the same scene; the FMU is compiled with other flags.
    assert np.abs(here["D.phi"] - there["D.phi"]).max() < 1e-9
    with pytest.raises(gelenk.AssemblyError, match=r"assembly: \{tolerance: "):
        gelenk.simulate(fmu, stop=0.2, parameters={"assembly.tolerance": 0.0})


def test_tolerance_is_written_to_scenes_and_set_by_keyword() -> None:
    data = rounded_scene("bennett", 6)
    assert gelenk.load(gelenk.load(data).to_dict()).to_dict()["assembly"] == {"tolerance": 1e-5}
    del data["assembly"]
    assert "assembly" not in gelenk.load(data).to_dict()
    with pytest.warns(gelenk.StartWarning, match="frames were moved"):
        gelenk.simulate(data, stop=0.01, assembly_tolerance=1e-5)


@pytest.mark.parametrize("value", [-1e-6, 0.0100001, math.inf])
def test_tolerance_out_of_range_is_rejected(value: float) -> None:
    data = started("bennett", assembly={"tolerance": value})
    with pytest.raises(gelenk.SceneError, match=r"assembly\.tolerance"):
        gelenk.load(data)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5])
def test_three_cranks_close_to_their_change_point_raise_a_warning(angle: float, turned: bool) -> None:
    """One angle is fixed, the others are guesses: close to the change point, loops close to rounding on any
    mixture of branches, on some of which nothing can move. This used to be reported as a mechanism without
    degrees of freedom, without a warning.
    """
    placed = three_cranks_in_line()
    data = scene(
        tilted(placed) if turned else placed, fields={"A0": {"start": {"phi": angle, "fixed": ["phi"]}}}
    )
    plant = gelenk.Simulation(data)
    with pytest.warns(gelenk.StartWarning, match="singular configuration"):
        plant.initialize()
    assert plant.output("A0.phi") == angle
    assert plant.diagnostics["constraints.position"] < 1e-14
    if plant.size.degrees_of_freedom == 0:
        assert "cannot move at all" in " ".join(plant._core.start_warnings())
