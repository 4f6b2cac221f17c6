# SPDX-License-Identifier: BSD-3-Clause
"""Runs whose bodies are recorded, for pictures that move."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import StepError, UsageError
from gelenk.model.scene import Scene, known_parameters, load
from gelenk.model.skeleton import constraining_joints
from gelenk.simulation.fmu_file import SCENE, text_in
from gelenk.simulation.inputs import functions_and_constants
from gelenk.simulation.loads import Motion, arrows_of
from gelenk.simulation.result import Result
from gelenk.simulation.run import open_plant, simulate
from gelenk.simulation.touching import contact_events
from gelenk.viewer.arrows import Arrow
from gelenk.viewer.pages import view_of

type Array = NDArray[np.float64]

SENSOR = "recorded__"  # begins the names of the sensors that are added for each body
POSE = (*(f"r[{k}]" for k in (1, 2, 3)), *(f"Q[{k}]" for k in (1, 2, 3, 4)))  # outputs of a sensor
VELOCITY = (*(f"v[{k}]" for k in (1, 2, 3)), *(f"w[{k}]" for k in (1, 2, 3)))
MAX_FRAMES = 1000


@dataclass(frozen=True)
class Recording:
    """A mechanism in motion.

    Attributes:
        scene: the scene as plain data, with the parameters of the run, without the sensors that have
            recorded it.
        time: times of the frames [s], shape (frames,).
        poses: of the bodies' frames in the world: position [m] and quaternion (x, y, z, w), shape (frames,
            bodies, 7), bodies in the order of the scene.
        result: all outputs, at the times of the frames and between.
        rows: the rows of the result that are frames.
        arrows: forces and torques at the times of the frames.
    """

    scene: Mapping[str, Any]
    time: Array
    poses: Array
    result: Result
    rows: NDArray[np.intp]
    arrows: Sequence[Arrow] = ()

    @property
    def signals(self) -> list[str]:
        """Names of the outputs, without those that record poses."""
        return [name for name in self.result.names if not name.startswith(SENSOR)]

    @property
    def events(self) -> list[tuple[float, str]]:
        """Times [s] and descriptions of events, those of contacts included."""
        modes = [f"{name}.mode" for name in self.scene.get("contacts", {})]
        signals = {name: self.result[name] for name in modes if name in self.result.names}
        return sorted([*self.result.events, *contact_events(self.scene, self.result.time, signals)])


def scene_of(plant: Scene | str | PathLike[str] | Mapping[str, Any]) -> Scene:
    """Return the scene of an FMU, or load one.

    Raises:
        UsageError: the FMU does not contain a scene.
        SceneError: the scene is invalid.
        OSError: the file cannot be read.
    """
    if isinstance(plant, str | PathLike) and str(plant).endswith(".fmu"):
        try:
            content = json.loads(text_in(plant, SCENE))
        except (KeyError, ValueError, RecursionError):
            content = None
        if not isinstance(content, Mapping):
            raise UsageError(f"{Path(plant)}: found no scene in it, expected an FMU made by Gelenk")
        return load(content)
    return plant if isinstance(plant, Scene) else load(plant)


def record(scene: Scene, *, reactions: bool = False, **run: Any) -> Recording:
    """Simulate a scene and record the poses of its bodies.

    Args:
        scene: the scene.
        reactions: whether forces and torques of joints are recorded, too; without it, only those of joints
            that have a sensor.
        run: arguments of `gelenk.simulate`.

    Raises:
        SceneError, AssemblyError, UsageError: see `gelenk.simulate`.
        StepError: a step failed; its `view` shows the motion up to this step.
    """
    plain = scene.to_dict()
    outputs = run.get("outputs")
    if outputs is not None:
        run["outputs"] = [*([outputs] if isinstance(outputs, str) else outputs), f"{SENSOR}*"]
    data = {**plain, "sensors": dict(plain.get("sensors", {}))}
    for number, body in enumerate(plain["bodies"]):
        data["sensors"][f"{SENSOR}{number}"] = {"type": "frame", "body": body}
    if reactions:
        for number, joint in enumerate(constraining_joints(plain)):
            data["sensors"][f"{SENSOR}joint{number}"] = {"type": "reaction", "joint": joint}
    if "outputs" in data:
        data["outputs"] = [*data["outputs"], f"{SENSOR}*"]
    # Positions of joints may be parameters.
    drawn = scene.with_parameters(known_parameters(scene, run.get("parameters") or {})).to_dict()
    recorded = load(data)
    try:
        return _recording_of(drawn, recorded, simulate(recorded, **run), run)
    except StepError as e:
        if e.result is not None:
            e.result.events += ((float(e.result.time[-1]), f"the run ended: {e}"),)
            e.view = view_of(_recording_of(drawn, recorded, e.result, run))
        raise


def still(scene: Mapping[str, Any], poses: Sequence[float] | Array) -> Recording:
    """Return a mechanism at rest, without outputs.

    Args:
        scene: as plain data.
        poses: positions and quaternions of its bodies, as in a recording of one frame, in any shape.
    """
    rows = np.zeros(1, np.intp)
    return Recording(
        scene, np.zeros(1), np.reshape(np.asarray(poses, float), (1, len(scene["bodies"]), 7)),
        Result((), np.zeros((1, 1)), {}), rows,
    )  # fmt: skip


def _recording_of(
    scene: Mapping[str, Any], recorded: Scene, result: Result, run: Mapping[str, Any]
) -> Recording:
    """Return the recording of a run whose outputs are those that `record` adds, or of a part of it."""
    rows = frame_rows(len(result))
    bodies = len(scene["bodies"])
    time, poses = result.time[rows], _numbers(result, rows, bodies, POSE)
    sensors = recorded.to_dict().get("sensors", {})
    reactions = {
        name: row["joint"]
        for name, row in sensors.items()
        if "joint" in row and f"{name}.f[1]" in result.names
    }
    # A joint may have a sensor of its own.
    reactions = {
        sensor: joint for joint, sensor in {joint: name for name, joint in reactions.items()}.items()
    }
    outputs = [f"{name}.{letter}[{k}]" for name in reactions for letter in "ft" for k in (1, 2, 3)]
    of_contacts = [f"{name}.f[{k}]" for name in scene.get("contacts", {}) for k in (1, 2, 3)]
    outputs += [name for name in of_contacts if name in result.names]
    signals = {name: result[name][rows] for name in outputs} | _inputs(recorded, run, time)
    motion = Motion(scene, poses, _numbers(result, rows, bodies, VELOCITY), signals)
    return Recording(scene, time, poses, result, rows, arrows_of(motion, reactions))


def _inputs(scene: Scene, run: Mapping[str, Any], time: Array) -> dict[str, Array]:
    """Return the inputs of a run at its frames, by name; those that are not named are 0."""
    plant = open_plant(scene, (), whole=True)
    try:
        known = [*plant.inputs, *plant.idle]
        signals = functions_and_constants(
            run.get("inputs"), dict(run.get("parameters") or {}), known, "twice"
        )
    finally:
        plant.close()
    return {name: np.array([signal(float(t)) for t in time]) for name, signal in signals.items()}


def frame_rows(rows: int, most: int = MAX_FRAMES) -> NDArray[np.intp]:
    """Return at most `most` row numbers at equal distances, with the first and the last."""
    return np.unique(np.linspace(0, rows - 1, min(rows, most)).round().astype(np.intp))


def _numbers(
    result: Result, rows: Sequence[int] | NDArray[np.intp], bodies: int, parts: Sequence[str]
) -> Array:
    """Return what the sensors of all bodies have recorded, shape (rows, bodies, parts)."""
    out = np.empty((len(rows), bodies, len(parts)))
    for body in range(bodies):
        for k, part in enumerate(parts):
            out[:, body, k] = result[f"{SENSOR}{body}.{part}"][rows]
    return out
