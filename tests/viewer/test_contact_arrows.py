# SPDX-License-Identifier: BSD-3-Clause
"""Forces of contacts as arrows, and their changes as marks on the time slider."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from models.touching import inertia_of_box, on_plane, stack

import gelenk
from gelenk.model.skeleton import placed
from gelenk.simulation.recording import Recording, contact_events, record
from gelenk.viewer.arrows import Arrow
from gelenk.viewer.data import page_data

G = 9.81  # m/s2
SIZE = [0.4, 0.3, 0.1]  # m
POINTS = [[x, y, z] for x in (-0.2, 0.2) for y in (-0.1, 0.1) for z in (-0.3, 0.3)]


def contacts(recording: Recording) -> list[Arrow]:
    return [arrow for arrow in recording.arrows if arrow.kind == "contact" and arrow.unit == "N"]


def at_rest(shape: dict[str, Any], height: float, **start: Any) -> Recording:
    """A body of 2 kg on a plane."""
    scene = on_plane(shape, 2, [0.1] * 3, {"r": [0.5, 0, height], **start}, {"friction": 0.5})
    return record(gelenk.load(scene), stop=0.1, step=0.05)


SIDEWAYS = {"Q": [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}  # z of the shape is horizontal


@warned.STILL
@pytest.mark.parametrize(
    ("shape", "height", "start"),
    [
        ({"sphere": 0.1}, 0.1, {}),
        ({"box": SIZE}, 0.05, {}),
        ({"capsule": {"radius": 0.1, "length": 0.4}}, 0.3, {}),
        ({"capsule": {"radius": 0.1, "length": 0.4}}, 0.1, SIDEWAYS),
        ({"cylinder": {"radius": 0.1, "length": 0.4}}, 0.2, {}),
        ({"cylinder": {"radius": 0.1, "length": 0.4}}, 0.1, SIDEWAYS),
        ({"wheel": {"radius": 0.3, "crown": 0.1}}, 0.3, SIDEWAYS),
        ({"hull": POINTS}, 0.3, {}),
    ],
)
def test_the_weight_of_a_body_is_carried_below_its_middle(
    shape: dict[str, Any], height: float, start: dict[str, Any]
) -> None:
    recording = at_rest(shape, height, **start)
    (arrow,) = contacts(recording)
    assert arrow.name == "floor"
    assert arrow.vectors[-1] == pytest.approx([0, 0, 2 * G], rel=1e-8, abs=1e-8)
    place = placed(recording.poses[:, 0], arrow.points)
    assert place[-1] == pytest.approx([0.5, 0, 0], abs=1e-8)


def test_the_force_on_a_tilted_box_acts_at_its_edge() -> None:
    """Turned by 30 deg about y, its lowest edge is that of x = 0.2, z = -0.05."""
    height = 0.2 * np.sin(np.pi / 6) + 0.05 * np.cos(np.pi / 6)
    recording = at_rest({"box": SIZE}, height, Q=[0, np.sin(np.pi / 12), 0, np.cos(np.pi / 12)])
    (arrow,) = contacts(recording)
    assert arrow.points[0] == pytest.approx([0.2, 0, -0.05], abs=1e-12)


def test_two_bodies_push_each_other() -> None:
    """Two cubes, the lower one welded: the upper one pushes back."""
    scene = stack(2, edge=0.1, mass=3)
    scene["joints"]["j0"] = {
        "type": "weld", "parent": {"body": "ground", "position": [0, 0, 0.05]}, "child": "b0",
    }  # fmt: skip
    scene["bodies"]["b0"]["shapes"]["cube"]["surface"] = "stone"
    scene["contacts"]["wooden"]["between"] = ["wood", "stone"]
    del scene["ground"]
    recording = record(gelenk.load(scene), stop=0.1, step=0.05)
    found = {arrow.body: arrow for arrow in contacts(recording)}
    assert found["b1"].vectors[-1] == pytest.approx([0, 0, 3 * G], abs=1e-7)
    assert found["b0"].vectors[-1] == pytest.approx([0, 0, -3 * G], abs=1e-7)
    assert found["b1"].points[-1] == pytest.approx([0, 0, -0.05], abs=1e-9)
    assert found["b0"].points == pytest.approx([0, 0, 0.05], abs=1e-9)


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean"])
def test_each_pair_of_bodies_of_one_contact_has_its_arrows(integrator: str) -> None:
    """A stack of three: each carries what is above it, and is carried."""
    recording = record(gelenk.load(stack(3, edge=0.1, mass=3)), stop=0.02, step=0.01, integrator=integrator)
    found = sorted(
        (arrow.body, arrow.points.flat[-1].round(9), (arrow.vectors[-1] / (3 * G)).round(6).tolist())
        for arrow in contacts(recording)
    )
    assert found == [
        ("b0", -0.05, [0, 0, 3]), ("b0", 0.05, [0, 0, -2]),
        ("b1", -0.05, [0, 0, 2]), ("b1", 0.05, [0, 0, -1]),
        ("b2", -0.05, [0, 0, 1]),
    ]  # fmt: skip


def test_a_bounce_is_marked_when_it_closes_and_opens() -> None:
    """Dropped from 0.2 m, a ball strikes after 0.2019 s."""
    ball = on_plane({"sphere": 0.1}, 1, [0.004] * 3, {"r": [0, 0, 0.3]}, {"restitution": 0.5})
    events = page_data(record(gelenk.load(ball), stop=0.3, step=0.001))["events"]
    assert [event["text"] for event in events] == ["floor closes", "floor opens"]
    assert events[0]["t"] == pytest.approx(np.sqrt(0.4 / G), abs=0.002)


def test_a_block_that_comes_to_rest_is_marked() -> None:
    """At 1 m/s with mu = 0.5 it stops after 0.2039 s."""
    start: dict[str, list[float]] = {"r": [0, 0, 0.05], "v": [1, 0, 0]}
    block = on_plane({"box": SIZE}, 2, inertia_of_box(2, SIZE), start, {"friction": 0.5})
    events = record(gelenk.load(block), stop=0.3, step=0.001).events
    assert [text for _, text in events][-1] == "floor sticks"
    assert events[-1][0] == pytest.approx(1 / (0.5 * G), abs=0.002)


@pytest.mark.parametrize(("changes", "marks"), [(100, 100), (101, 0)])
def test_a_contact_that_changes_too_often_has_no_marks(changes: int, marks: int) -> None:
    modes = np.array([1.0 + k % 2 for k in range(changes + 1)])
    scene: dict[str, Any] = {"contacts": {"c": {}, "silent": {}}}
    time = np.array([0.5 * k for k in range(changes + 1)])
    found = contact_events(scene, time, {"c.mode": modes})
    assert len(found) == marks
    if found:
        assert found[0] == (0.5, "c slides")
        assert found[1] == (1.0, "c sticks")
