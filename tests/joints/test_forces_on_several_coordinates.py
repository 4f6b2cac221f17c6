# SPDX-License-Identifier: BSD-3-Clause
"""Motors, friction, limits, stops, one-way clutches and laws on each coordinate of universal, cylindrical and
planar joints: closed forms, and the same mechanisms with joints of one coordinate and bodies without mass.
"""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import gelenk
from gelenk.io import export

Source = dict[str, Any]
INTEGRATORS = ["auto", "erk", "dirk", "cvode", "ida"]

BODY: Source = {"mass": 1.3, "com": [0.2, 0.05, -0.1], "inertia": [0.03, 0.05, 0.06, 0.001, 0, 0.002]}
# The coordinates of a joint in order, each with the joint of one coordinate that does the same.
PARTS: dict[str, dict[str, tuple[str, list[float]]]] = {
    "universal": {"phi_a": ("revolute", [1, 0, 0]), "phi_b": ("revolute", [0, 1, 0])},
    "cylindrical": {"s": ("prismatic", [0, 0, 1]), "phi": ("revolute", [0, 0, 1])},
    "planar": {
        "s_x": ("prismatic", [1, 0, 0]),
        "s_y": ("prismatic", [0, 1, 0]),
        "phi": ("revolute", [0, 0, 1]),
    },
}
# The speeds of these coordinates.
SPEEDS = {"phi_a": "w_a", "phi_b": "w_b", "phi": "w", "s": "v", "s_x": "v_x", "s_y": "v_y"}
STARTS = {"phi_a": 0.3, "phi_b": -0.4, "phi": 0.2, "s": 0.1, "s_x": 0.05, "s_y": -0.1}
START_SPEEDS = {"phi_a": 1.5, "phi_b": -2.0, "phi": 3.0, "s": -0.7, "s_x": 0.9, "s_y": -0.6}
GROUPS: dict[str, dict[str, dict[str, Any]]] = {
    "friction": {
        "friction": {"coulomb": 0.15, "static": 0.2, "stribeck": 0.1},
        "limit": {"lower": -0.6, "upper": 0.6, "restitution": 0.5},
    },
    "one_way": {"one_way": {"free": "positive"}, "friction": {"coulomb": 0.1}},
    "stop": {"stop": {"lower": -0.5, "upper": 0.5, "stiffness": 200.0, "damping": 2.0}},
}


def skeleton(**more: Any) -> Source:
    return {"gelenk": 1, "gravity": [0.3, -2.0, -9.81], "bodies": {"b": dict(BODY)}, **more}


def whole(kind: str, groups: str, *, is_driven: bool = True, swapped: bool = False) -> Source:
    """A body on a joint with several coordinates."""
    names = list(PARTS[kind])
    start: Source = {name: STARTS[name] for name in names}
    start |= {SPEEDS[name]: START_SPEEDS[name] for name in names}
    joint: Source = {"type": kind, "parent": "ground", "child": "b", "start": {**start, "fixed": True}}
    if swapped:  # which changes the order of rotations of a universal joint
        joint |= {"parent": "b", "child": "ground"}
    for group, entry in GROUPS[groups].items():
        joint[group] = {name: dict(entry) for name in names}
    joint["stiffness"] = [4.0] * len(names)
    joint["damping"] = [0.02] * len(names)
    source = skeleton(joints={"J": joint})
    if is_driven:
        source["motors"] = {
            f"drive_{name}": {"joint": "J", "coordinate": name, "gear_ratio": 2.0, "rotor_inertia": 0.003}
            for name in names
        }
    return source


def parts(kind: str, groups: str, *, is_driven: bool = True) -> Source:
    """The same with joints of one coordinate, and bodies without mass between them."""
    source = skeleton(joints={})
    parent = "ground"
    names = list(PARTS[kind])
    for name, (part, axis) in PARTS[kind].items():
        child = "b" if name == names[-1] else f"between_{name}"
        source["bodies"].setdefault(child, {"mass": 0})
        own, speed = ("phi", "w") if part == "revolute" else ("s", "v")
        joint = {
            "type": part,
            "axis": axis,
            "parent": parent,
            "child": child,
            "start": {own: STARTS[name], speed: START_SPEEDS[name], "fixed": True},
            "stiffness": 4.0,
            "damping": 0.02,
        }
        source["joints"][f"J_{name}"] = joint | copy.deepcopy(GROUPS[groups])
        if is_driven:
            drive = {"joint": f"J_{name}", "gear_ratio": 2.0, "rotor_inertia": 0.003}
            source.setdefault("motors", {})[f"drive_{name}"] = drive
        parent = child
    return source


def inputs(kind: str) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for k, (name, (part, _)) in enumerate(PARTS[kind].items()):
        effort = "tau" if part == "revolute" else "f"
        out[f"drive_{name}.{effort}"] = lambda t, k=k: 0.4 * math.sin(5 * t + k)
    return out


def coordinates(kind: str) -> tuple[list[str], list[str]]:
    """Names of coordinates and speeds in both."""
    of_whole, of_parts = [], []
    for name, (part, _) in PARTS[kind].items():
        own, speed = ("phi", "w") if part == "revolute" else ("s", "v")
        of_whole += [f"J.{name}", f"J.{SPEEDS[name]}"]
        of_parts += [f"J_{name}.{own}", f"J_{name}.{speed}"]
    return of_whole, of_parts


def run(source: Source, integrator: str, names: list[str], drives: dict[str, Any], **more: Any) -> Any:
    source = {**source, "solver": {"integrator": integrator, **more}}
    result = gelenk.simulate(source, stop=1.0, step=0.01, tolerance=1e-9, inputs=drives)
    return np.column_stack([result[name] for name in names]), result


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("groups", list(GROUPS))
@pytest.mark.parametrize("kind", list(PARTS))
def test_as_joints_of_one_coordinate(kind: str, groups: str, integrator: str) -> None:
    of_whole, of_parts = coordinates(kind)
    found, result = run(whole(kind, groups), integrator, of_whole, inputs(kind))
    expected, other = run(parts(kind, groups), integrator, of_parts, inputs(kind))
    # Errors of both runs; where speeds jump, events may be on either side of a point.
    deviations = np.abs(found - expected).max(axis=1)
    assert np.sum(deviations > 1e-6) <= 1
    assert len(result.events) == len(other.events)
    assert groups == "stop" or len(result.events) > 3


@pytest.mark.parametrize("kind", list(PARTS))
def test_as_joints_of_one_coordinate_in_time_steps(kind: str) -> None:
    of_whole, of_parts = coordinates(kind)
    found, _ = run(whole(kind, "friction"), "moreau-jean", of_whole, inputs(kind), step=1e-3)
    expected, _ = run(parts(kind, "friction"), "moreau-jean", of_parts, inputs(kind), step=1e-3)
    assert np.abs(found - expected).max() < 1e-9


def test_cylindrical_joint_in_closed_form() -> None:
    """A nut slides against friction and turns against friction into a limit."""
    m, inertia, rotor = 1.0, 0.4, 0.1
    source: Source = {
        "gelenk": 1,
        "bodies": {"nut": {"mass": m, "inertia": [0.3, 0.2, inertia]}},
        "joints": {
            "C": {
                "type": "cylindrical",
                "parent": "ground",
                "child": "nut",
                "start": {"s": 0, "v": 1, "phi": 0, "w": 2, "fixed": True},
                "friction": {"s": {"coulomb": 1.0}, "phi": {"coulomb": 0.2}},
                "limit": {"phi": {"upper": 0.5, "restitution": 0.5}},
            }
        },
        "motors": {"m": {"joint": "C", "coordinate": "phi", "rotor_inertia": rotor}},
    }
    result = gelenk.simulate(source, stop=1.5, step=0.01, tolerance=1e-10)
    assert result["C.s"][-1] == pytest.approx(1 / (2 * 1.0 / m), abs=1e-9)
    a = 0.2 / (inertia + rotor)
    strikes = (2 - math.sqrt(4 - 4 * a / 2 * 0.5)) / a
    back = 0.5 * (2 - a * strikes)
    t = 1.5 - strikes
    assert result["C.phi"][-1] == pytest.approx(0.5 - back * t + a * t**2 / 2, abs=1e-9)
    texts = [text for _, text in result.events]
    assert texts[0] == "C.phi meets its upper limit"
    assert "C.s sticks" in texts
    assert result["C.friction.phi.tau"][-1] == pytest.approx(0.2)
    assert result["C.friction.s.mode"][-1] == 0


def test_reversed_joints() -> None:
    """With the bodies of the joint exchanged, the coordinates are those of the motion of the ground."""
    source = whole("cylindrical", "friction", swapped=True)
    expected = whole("cylindrical", "friction")
    for name, speed in (("s", "v"), ("phi", "w")):
        start = expected["joints"]["J"]["start"]
        start[name], start[speed] = -STARTS[name], -START_SPEEDS[name]
    drives = inputs("cylindrical")
    names, _ = coordinates("cylindrical")
    found, _ = run(source, "erk", names, drives)
    opposite = {name: lambda t, f=f: -f(t) for name, f in drives.items()}
    wanted, _ = run(expected, "erk", names, opposite)
    assert np.sum(np.abs(found + wanted).max(axis=1) > 1e-6) <= 1


def test_a_joint_that_closes_a_loop() -> None:
    """A slider-crank whose slider is a cylindrical joint, with friction of the slider, held and moving."""

    def crank(kind: str) -> Source:
        friction = {"coulomb": 10.0}
        slider: Source = {"type": kind, "axis": [1, 0, 0], "parent": "ground", "child": "slider"}
        slider["friction"] = {"s": friction} if kind == "cylindrical" else friction
        rod = {"mass": 0.5, "com": [0.3, 0, 0], "inertia": [0.001, 0.02, 0.02]}
        return {
            "gelenk": 1,
            "gravity": [0, 0, -9.81],
            "bodies": {
                "crank": {"mass": 1, "com": [0.1, 0, 0], "inertia": [0.001, 0.01, 0.01]},
                "rod": rod,
                "slider": {"mass": 0.8, "inertia": [0.01, 0.01, 0.01]},
            },
            "joints": {
                "A": {
                    "type": "revolute",
                    "axis": [0, 1, 0],
                    "parent": "ground",
                    "child": "crank",
                    "start": {"phi": 0.4, "w": 0, "fixed": True},
                },
                "B": {
                    "type": "revolute",
                    "axis": [0, 1, 0],
                    "parent": {"body": "crank", "position": [0.2, 0, 0]},
                    "child": "rod",
                },
                "C": {
                    "type": "revolute",
                    "axis": [0, 1, 0],
                    "parent": {"body": "rod", "position": [0.6, 0, 0]},
                    "child": "slider",
                },
                "D": slider,
            },
            "motors": {"drive": {"joint": "A"}},
        }

    def drive(t: float) -> float:
        return 3 * math.sin(4 * t)

    runs = [
        gelenk.simulate(crank(kind), stop=2.0, step=0.01, tolerance=1e-9, inputs={"drive.tau": drive})
        for kind in ("cylindrical", "prismatic")
    ]
    assert np.abs(runs[0]["A.phi"] - runs[1]["A.phi"]).max() < 1e-6
    assert any("D.s sticks" in text for _, text in runs[0].events)
    assert len(runs[0].events) == len(runs[1].events)


@pytest.mark.parametrize("kind", list(PARTS))
def test_restored_to_the_bit(kind: str) -> None:
    names, _ = coordinates(kind)
    plant = gelenk.Simulation(whole(kind, "friction"))
    plant.initialize(0, 1e-8)
    states, values = [], []
    for k in range(60):
        states.append(plant.save())
        plant.step_to(0.02 * (k + 1))
        values.append(plant.values(names))
    for k in (50, 3, 20, 59, 0):
        plant.restore(states[k])
        plant.step_to(0.02 * (k + 1))
        assert np.array_equal(plant.values(names), values[k])


def test_held_coordinates_are_locked_in_linear_models_and_equilibria() -> None:
    source = whole("universal", "friction", is_driven=False)
    source["gravity"] = [0, 0, 0]
    del source["joints"]["J"]["stiffness"]
    start = {"phi_a": 0.3, "phi_b": -0.4, "w_a": 0, "w_b": 0, "fixed": True}
    source["joints"]["J"]["start"] = start
    both = gelenk.linearize(source, friction="present")
    assert both.nstates == 0
    assert gelenk.linearize(source, friction="off").nstates == 4
    del source["joints"]["J"]["friction"]["phi_b"]
    assert set(gelenk.linearize(source, friction="present").state_labels) == {"J_phi_b", "J_w_b"}

    source = whole("cylindrical", "friction", is_driven=False)
    source["gravity"] = [0, 0, -0.1]
    joint = source["joints"]["J"]
    del joint["stiffness"]
    joint["start"] = {"s": 0.2, "v": 0, "phi": 0.1, "w": 0, "fixed": True}
    found = gelenk.equilibrium(source, friction="present")
    assert found.held["J.s"].friction == pytest.approx(0.1 * BODY["mass"])
    assert found.held["J.phi"].friction == pytest.approx(0, abs=1e-12)
    source["gravity"] = [0, 0, -1.0]
    with pytest.raises(gelenk.EquilibriumError, match=r"J\.s"):
        gelenk.equilibrium(source, friction="present")


def test_names_parameters_and_files(tmp_path: Path) -> None:
    source = whole("universal", "friction")
    source["parameters"] = ["J.friction.phi_b.coulomb", "J.limit.phi_a.upper"]
    scene = gelenk.load(source)
    heavier = scene.with_parameters({"J.friction.phi_b.coulomb": 0.18, "J.limit.phi_a.upper": 0.55})
    joint = heavier.to_dict()["joints"]["J"]
    assert joint["friction"]["phi_b"]["coulomb"] == 0.18
    assert joint["friction"]["phi_a"]["coulomb"] == 0.15
    assert joint["limit"]["phi_a"]["upper"] == 0.55
    heavier.save(tmp_path / "scene.yaml")
    again = gelenk.load(tmp_path / "scene.yaml")
    assert again.to_dict()["joints"]["J"] == joint


def test_as_an_fmu(tmp_path: Path) -> None:
    source = whole("universal", "friction")
    source["parameters"] = ["J.friction.phi_a.coulomb", "J.limit.phi_b.restitution"]
    path = tmp_path / "universal.fmu"
    gelenk.export_fmu(gelenk.load(source), path)
    names, _ = coordinates("universal")
    changed = {"J.friction.phi_a.coulomb": 0.19}
    found = gelenk.simulate(path, stop=1.0, step=0.01, tolerance=1e-8, parameters=changed)
    source["joints"]["J"]["friction"]["phi_a"]["coulomb"] = 0.19
    expected = gelenk.simulate(source, stop=1.0, step=0.01, tolerance=1e-8)
    for name in names:
        assert np.array_equal(found[name], expected[name])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"friction": {"coulomb": 1}},
            r"joints\.J\.friction: found 'coulomb', expected a mapping with coordinates of a universal "
            r"joint: phi_a, phi_b, as \{phi_a: \{coulomb: \.\.\.\}\}",
        ),
        (
            {"friction": {"phi": {"coulomb": 1}}},
            r"joints\.J\.friction\.phi: found an unknown field, expected one of phi_a, phi_b",
        ),
        ({"limit": {"phi_b": {"lower": 1, "upper": 0}}}, r"joints\.J\.limit\.phi_b\.lower: found 1 rad"),
        ({"friction": {"phi_a": {"coulomb": -1}}}, r"joints\.J\.friction\.phi_a\.coulomb: found -1 N m"),
        (
            {"friction": {"phi_a": {"coulomb": 0, "bearing": {"coefficient": 0.1, "radius": 0.01}}}},
            r"joints\.J\.friction\.phi_a\.bearing: found a bearing of a universal joint",
        ),
        (
            {"friction": 3},
            r"joints\.J\.friction: found 3, expected a mapping with coordinates of a universal",
        ),
    ],
)
def test_errors(change: Source, message: str) -> None:
    source = whole("universal", "friction")
    source["joints"]["J"] |= change
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(source)


def test_errors_of_motors_and_other_joints(tmp_path: Path) -> None:
    source = whole("universal", "friction")
    del source["motors"]["drive_phi_a"]["coordinate"]
    with pytest.raises(gelenk.SceneError, match=r"coordinate: found nothing, expected one of phi_a, phi_b"):
        gelenk.load(source)
    source = whole("universal", "friction")
    source["motors"]["again"] = {"joint": "J", "coordinate": "phi_a"}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(source))
    with pytest.warns(gelenk.SceneWarning, match="already driven by 'drive_phi_a'"):
        gelenk.load(path)
    for kind, group in (("spherical", "one_way"), ("free", "friction")):
        source = skeleton(joints={"J": {"type": kind, "parent": "ground", "child": "b"}})
        source["joints"]["J"][group] = {"phi": {"coulomb": 1}}
        with pytest.raises(gelenk.SceneError, match=f"a {kind} joint has no angles or lengths"):
            gelenk.load(source)


def test_gears_with_losses_need_a_joint_with_one_coordinate() -> None:
    source = whole("cylindrical", "friction", is_driven=False)
    source["bodies"]["wheel"] = {"mass": 1, "inertia": [0.1, 0.1, 0.1]}
    at = {"body": "ground", "position": [1, 0, 0]}
    source["joints"]["W"] = {"type": "revolute", "axis": [0, 0, 1], "parent": at, "child": "wheel"}
    gear = {"type": "gear", "joint": "J", "with": "W", "ratio": 1.0, "efficiency": 0.8}
    source["constraints"] = {"mesh": gear}
    with pytest.raises(gelenk.SceneError, match=r"mesh\.efficiency: found 'J', a cylindrical joint"):
        gelenk.load(source)


def test_the_schema_accepts_what_the_reader_accepts() -> None:
    schema = json.loads(export.schema())
    for kind in PARTS:
        for groups in GROUPS:
            jsonschema.validate(whole(kind, groups), schema)
    wrong = whole("universal", "friction")
    wrong["joints"]["J"]["friction"] = {"coulomb": 1.0}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, schema)
