# SPDX-License-Identifier: BSD-3-Clause
"""Shapes and contacts in scene files: masses by density, saving, errors, saved runs."""

from math import pi
from pathlib import Path
from typing import Any

import pytest
import warned
from models.touching import inertia_of_box, on_plane, stack

import gelenk

SHAPES: dict[str, tuple[Any, float]] = {
    "sphere": (0.2, 4 / 3 * pi * 0.2**3),
    "box": ([0.1, 0.2, 0.3], 0.006),
    "cylinder": ({"radius": 0.1, "length": 0.4}, pi * 0.004),
    "capsule": ({"radius": 0.1, "length": 0.4}, pi * 0.004 + 4 / 3 * pi * 0.001),
    "hull": ([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]], 0.0045),
}


def body_of(shape: dict[str, Any]) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "bodies": {"b": {"mass": {"density": 700}, "shapes": {"s": shape}}},
        "joints": {"j": {"type": "free", "parent": "ground", "child": "b"}},
    }


@pytest.mark.parametrize("kind", SHAPES)
def test_masses_follow_from_densities(kind: str) -> None:
    dimensions, volume = SHAPES[kind]
    mass = gelenk.load(body_of({kind: dimensions})).to_dict()["bodies"]["b"]["mass"]
    assert mass == pytest.approx(700 * volume, rel=1e-14)


def test_inertia_of_a_shape_that_is_displaced() -> None:
    """The center of mass moves with the shape, the moments about it do not."""
    body = gelenk.load(body_of({"box": [0.1, 0.2, 0.3], "position": [1, 2, 3]})).to_dict()["bodies"]["b"]
    assert body["com"] == pytest.approx([1, 2, 3], rel=1e-14)
    assert body["inertia"][:3] == pytest.approx(inertia_of_box(4.2, [0.1, 0.2, 0.3]), rel=1e-12)


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_are_written_back(kind: str) -> None:
    scene = gelenk.load(body_of({kind: SHAPES[kind][0], "position": [0, 0, 1], "surface": "wood"}))
    data = scene.to_dict()
    assert gelenk.load(data).to_dict() == data
    assert kind in data["bodies"]["b"]["shapes"]["s"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"contacts": {"c": {"between": ["wood", "stone"]}}}, "stone"),
        ({"contacts": {"c": {"between": ["wood"]}}}, "two surfaces"),
        ({"solver": {"integrator": "rk4", "formulation": "baumgarte"}}, "the formulation projection"),
        ({"solver": {"formulation": "baumgarte"}}, "projection"),
    ],
)
def test_mistakes_are_named(change: dict[str, Any], message: str) -> None:
    scene = on_plane({"sphere": 0.1}, 1, [0.004] * 3, {"r": [0, 0, 0.1]}, {})
    scene = {**scene, **change}
    if "contacts" not in change:
        scene["contacts"] = {"floor": {"between": ["wood", "concrete"]}}
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(scene)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ({"sphere": -1}, "more than 0"),
        ({"sphere": 1, "box": [1, 1, 1]}, "one shape"),
        ({"position": [0, 0, 0]}, "no shape"),
        ({"hull": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}, "volume"),
        ({"plane": [0, 0, 1]}, "finite size"),
        ({"ball": 1}, "ball"),
    ],
)
def test_wrong_shapes_are_named(shape: dict[str, Any], message: str) -> None:
    scene = body_of(shape)
    scene["bodies"]["b"]["mass"] = 1
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(scene)


@warned.MOVING
def test_contacts_that_are_closed_in_steps_have_no_derivatives() -> None:
    """Above the floor they exist, on it they are refused by the contact's name, but for located events."""
    high = on_plane({"sphere": 0.1}, 1, [0.004] * 3, {"r": [0, 0, 1.0]}, {})
    assert gelenk.linearize(high).nstates == 12
    low = on_plane({"sphere": 0.1}, 1, [0.004] * 3, {"r": [0, 0, 0.1]}, {})
    with pytest.raises(gelenk.GelenkError, match="floor is closed in time steps"):
        gelenk.linearize(low)


def test_fmu_continues_with_the_same_bits_after_restore(tmp_path: Path) -> None:
    """Saved in the air, while sliding and while rolling, and restored in another instance."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    ball = on_plane(
        {"sphere": 0.05},
        0.17,
        [1.7e-4] * 3,
        {"r": [0, 0, 0.06], "v": [2, 0.5, 0], "w": [0, -30, 5]},
        {"friction": 0.2, "restitution": 0.3},
    )
    folder = extract(str(gelenk.export_fmu(ball, tmp_path / "ball.fmu")), str(tmp_path / "fmu"))
    description = read_model_description(folder)
    outputs = [v.valueReference for v in description.modelVariables if v.causality == "output"]

    def started(name: str) -> FMU2Slave:
        fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        fmu.instantiate()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        return fmu

    def run(fmu: FMU2Slave, first: int, last: int) -> list[list[float]]:
        rows = []
        for k in range(first, last):
            fmu.doStep(k * 5e-3, 5e-3)
            rows.append(fmu.getReal(outputs))
        return rows

    whole, other = started("whole"), started("other")
    for first in (4, 40, 150):
        run(whole, 0 if first == 4 else {40: 4, 150: 40}[first], first)
        state = whole.getFMUState()
        saved = whole.serializeFMUState(state)
        expected = run(whole, first, first + 20)
        other.setFMUState(other.deSerializeFMUstate(saved))
        assert run(other, first, first + 20) == expected
        whole.setFMUState(state)
        whole.freeFMUState(state)
    for fmu in (whole, other):
        fmu.terminate()
        fmu.freeInstance()


def test_parameters_of_contacts_can_be_set_and_tuned() -> None:
    """Friction of 0 lets a sliding box go on at its speed."""
    size = [0.2, 0.2, 0.2]
    scene = on_plane(
        {"box": size}, 3, inertia_of_box(3, size), {"r": [0, 0, 0.1], "v": [1, 0, 0]}, {"friction": 0.4}
    )
    scene["parameters"] = ["floor.friction"]
    run = gelenk.simulate(scene, stop=0.1, step=0.05, parameters={"floor.friction": 0.0})
    assert run["J.v[1]"][-1] == pytest.approx(1, abs=1e-12)


def test_order_of_the_file_does_not_matter() -> None:
    """The same stack in the opposite order of bodies."""
    scene = stack(3)
    turned = {**scene, "bodies": dict(reversed(scene["bodies"].items()))}
    a, b = (gelenk.simulate(s, stop=0.1, step=0.05) for s in (scene, turned))
    assert a["j2.r[3]"][-1] == pytest.approx(b["j2.r[3]"][-1], abs=1e-10)
