# SPDX-License-Identifier: BSD-3-Clause
"""The core that runs in pages, in Node: the same runs, events and messages as natively."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files
from samples import sampled
from scipy.spatial.transform import Rotation

import gelenk
from gelenk import SceneError, _core
from gelenk.model import yaml12

from .cores import answers

STOP = 1.0  # s, or the end of the scene's own run
MOTION = ("rad", "m", "rad/s", "m/s")
STIFF = {"car"}  # accelerations and forces of its rolling wheels are not accurate to the tolerance
FRAMES = 50
# The version of SUNDIALS is another one natively, so that steps differ: runs of the same accuracy.
FACTOR = 10


def native(
    scene: gelenk.Scene, times: np.ndarray
) -> tuple[list[tuple[str, str]], np.ndarray, list[tuple[float, str]]]:
    """Outputs with their units, their values at the start and the times, and the events, without the core."""
    plant = gelenk.Simulation(scene)
    plant.initialize()
    names = [signal.name for signal in plant.outputs]
    rows = [plant.values(names)]
    events: list[tuple[float, str]] = []
    for time in times:
        plant.step_to(time)
        events += plant.events
        rows.append(plant.values(names))
    return [(signal.name, signal.unit) for signal in plant.outputs], np.array(rows), events


def scene_text(scene: gelenk.Scene) -> str:
    return _core.write_scene_json(scene._core)


@pytest.mark.parametrize(
    "name", sampled(scene_files.gallery(), ["four_bar", "ratchet", "gripper", "bicycle"])
)
def test_runs_are_those_without_the_core(name: str) -> None:
    """All outputs within 10 times the tolerance of their ranges; the same events."""
    scene = gelenk.load(scene_files.gallery()[name])
    times = np.linspace(0, min(STOP, scene.stop), FRAMES + 1)[1:]
    (found,) = answers({"job": "run", "scene": scene_text(scene), "file": "x", "times": times.tolist()})
    names, rows, events = native(scene, times)
    assert found["names"] == [name for name, _ in names]
    compared = [name not in STIFF or unit in MOTION for _, unit in names]
    expected, computed = rows[:, compared], np.array(found["rows"])[:, compared]
    assert [event["text"] for event in found["events"]] == [text for _, text in events]
    scale = np.maximum(np.abs(expected).max(axis=0), 1.0)
    assert (np.abs(computed - expected) <= FACTOR * scene.tolerance * scale).all()


def test_messages_are_those_of_the_native_reader() -> None:
    """Word for word, of all malformed scenes, one after the other in the same core."""
    texts = {}
    for file in scene_files.malformed():
        text = file.read_text(encoding="utf-8")
        if file.suffix == ".yaml":
            try:
                text = yaml12.to_json(text, file.name)
            except SceneError:
                continue  # which YAML itself refuses
        try:
            _core.read_scene_json(text, file.name)
        except SceneError as e:
            texts[file.name] = (text, "\n".join(e.lines))
    assert len(texts) > 100
    found = answers(*({"job": "fault", "scene": text, "file": name} for name, (text, _) in texts.items()))
    assert dict(zip(texts, found, strict=True)) == {name: message for name, (_, message) in texts.items()}


def test_saved_states_continue_with_the_same_bits(root: Path) -> None:
    scene = gelenk.load(root / "docs" / "gallery" / "ratchet" / "scene.yaml")
    (ends,) = answers({"job": "restored", "scene": scene_text(scene), "before": 0.4, "after": 0.9})
    assert ends[0] == ends[2] == ends[4]
    assert ends[1] == ends[3] == ends[5] == 0.4


def test_variables_are_those_of_an_fmu(four_bar: gelenk.Scene) -> None:
    (variables,) = answers({"job": "variables", "scene": scene_text(four_bar)})
    by_name = {row["name"]: row for row in variables}
    tau = by_name["drive.tau"]
    assert (tau["unit"], tau["causality"], tau["start"]) == ("N.m", "input", 0)
    mass = by_name["crank.m"]
    assert (mass["unit"], mass["variability"], mass["min"], mass["start"]) == ("kg", "fixed", 0, 1.0)
    assert by_name["A.damping"]["variability"] == "tunable"


def start_of(scene: gelenk.Scene) -> dict[str, Any]:
    """What a page gives a session at its start."""
    return {
        "scene": scene_text(scene), "file": "scene.json", "step": scene.step, "signals": ["A.phi", "A.w"],
        "settings": {}, "pull": {"mass": 7.5, "stiffness": 200.0}, "budget": 1e9,
    }  # fmt: skip


def session(scene: gelenk.Scene, *messages: Any) -> list[dict[str, Any]]:
    """Messages of a session of a page that receives the given ones; numbers are milliseconds that pass."""
    (out,) = answers({"job": "session", "start": start_of(scene), "messages": list(messages)})
    assert isinstance(out, list)
    return out


def test_a_session_advances_with_the_clock(four_bar: gelenk.Scene) -> None:
    play, pause = {"type": "play"}, {"type": "pause"}
    posted = session(four_bar, 100, play, 500, pause, 300, {"type": "setSpeed", "speed": 2}, play, 500)
    frames = [message for message in posted if message["type"] == "frame"]
    assert posted[-1]["time"] == pytest.approx(1.5, abs=0.02)
    assert len(frames) == 50
    plant = gelenk.Simulation(four_bar)
    plant.initialize()
    for k in range(500):
        plant.step_to((k + 1) * 1e-3)
    numbers = next(frame["numbers"] for frame in frames if frame["time"] == pytest.approx(0.5, abs=1e-9))
    assert numbers[-2:] == pytest.approx(plant.values(["A.phi", "A.w"]), abs=1e-5)


def test_inputs_change_a_run_and_parameters_begin_another(four_bar: gelenk.Scene) -> None:
    posted = session(
        four_bar, {"type": "play"}, 200,
        {"type": "set", "name": "drive.tau", "value": 3.0}, 200,
        {"type": "set", "name": "A.damping", "value": 0.4}, 200,
        {"type": "set", "name": "crank.m", "value": 2.0}, 100,
    )  # fmt: skip
    kinds = [message["type"] for message in posted if message["type"] != "frame"]
    assert kinds == ["accepted", "accepted", "restarted", "accepted", "end"]
    assert posted[-1]["time"] == pytest.approx(0.1, abs=0.02)
    restarted = next(message for message in posted if message["type"] == "restarted")
    assert restarted["settings"] == {"drive.tau": 3.0, "A.damping": 0.4, "crank.m": 2.0}


def test_what_is_refused_is_said_and_changes_nothing(four_bar: gelenk.Scene) -> None:
    posted = session(
        four_bar, {"type": "play"}, 200,
        {"type": "set", "name": "crank.m", "value": -1.0},
        {"type": "set", "name": "solver.tolerance", "value": 7.0}, 200,
    )  # fmt: skip
    refused = [message for message in posted if message["type"] == "refused"]
    assert [message["name"] for message in refused] == ["crank.m", "solver.tolerance"]
    assert "crank.m: found -1" in refused[0]["text"]
    assert posted[-1]["time"] == pytest.approx(0.4, abs=0.02)


def test_a_pointer_pulls_a_body_towards_it(four_bar: gelenk.Scene) -> None:
    """The rocker comes nearer to the pointer than by itself, and the run continues when let go."""
    tip, target = [1.5, 0, 0], [3.4, 0, 0.3]
    pull = {"type": "pull", "body": "rocker", "point": tip, "target": target}
    play, let_go = {"type": "play"}, {"type": "release"}
    gaps = []
    for messages in ([play, 1000], [play, pull, 1000]):
        frames = [m["numbers"] for m in session(four_bar, *messages) if m["type"] == "frame"]
        tips = [np.array(row[14:17]) + Rotation.from_quat(row[17:21]).apply(tip) for row in frames]
        gaps.append(np.linalg.norm(np.array(tips) - target, axis=1))
    assert gaps[1].mean() < gaps[0].min()
    posted = session(four_bar, play, 300, pull, 300, let_go, 300)
    assert "failed" not in [message["type"] for message in posted]
    assert posted[-1]["time"] == pytest.approx(0.9, abs=0.03)
    # No jump where plants change: a frame of 20 ms is as far from the next as the speed lets it be.
    phi, w = np.array([message["numbers"][-2:] for message in posted if message["type"] == "frame"]).T
    fastest = np.maximum(np.abs(w[1:]), np.abs(w[:-1]))
    assert (np.abs(np.diff(phi)) < 0.02 * 1.5 * fastest + 1e-3).all()


def test_a_run_returns_to_its_mark(four_bar: gelenk.Scene) -> None:
    """With the inputs and parameters that it had there, also after others have been chosen."""
    torque = {"type": "set", "name": "drive.tau", "value": 2.0}
    mass = {"type": "set", "name": "crank.m", "value": 2.0}
    play, mark, back = {"type": "play"}, {"type": "mark"}, {"type": "returnToMark"}
    posted = session(four_bar, play, torque, 300, mark, 200, mass, 100, back, 200)
    (returned,) = [message for message in posted if message["type"] == "returned"]
    assert returned["settings"] == {"drive.tau": 2.0}
    assert returned["time"] == pytest.approx(0.3)
    last = [message["numbers"] for message in posted if message["type"] == "frame"]
    times = [message["time"] for message in posted if message["type"] == "frame"]
    assert last[times.index(posted[-1]["time"])] == last[-1]


def test_a_scene_is_written_with_its_parameters(four_bar: gelenk.Scene) -> None:
    mass = {"type": "set", "name": "crank.m", "value": 2.0}
    posted = session(four_bar, mass, {"type": "writeScene"})
    (written,) = [message["text"] for message in posted if message["type"] == "written"]
    assert gelenk.load(json.loads(written)).to_dict() == four_bar.with_parameters({"crank.m": 2.0}).to_dict()


def test_another_core_follows_one_that_has_failed(four_bar: gelenk.Scene) -> None:
    (posted,) = answers({"job": "failing", "start": start_of(four_bar)})
    kinds = [message["type"] for message in posted]
    assert kinds == ["frame", "restarted", "frame", "failed", "frame"]
    assert [message["time"] for message in posted if message["type"] == "frame"][1:] == [
        0,
        pytest.approx(0.05),
    ]
    assert posted[3]["text"] == "the core has failed"


def test_memory_stays_flat(four_bar: gelenk.Scene) -> None:
    """Over new plants and long runs."""
    restart = [{"type": "set", "name": "crank.m", "value": 1.0 + k / 100} for k in range(100)]
    pull = {"type": "pull", "body": "rocker", "point": [1.5, 0, 0], "target": [3, 0, 0]}
    pulls = [pull, 100, {"type": "release"}, 100]
    once = session(four_bar, {"type": "play"}, 2000, *restart[:10], *pulls)[-1]["memory"]
    often = session(four_bar, {"type": "play"}, 20000, *restart, *(10 * pulls))[-1]["memory"]
    assert often <= 1.1 * once
