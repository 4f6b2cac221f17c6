# SPDX-License-Identifier: BSD-3-Clause
"""Runs whose bodies are recorded, for pictures that move."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import StepError, UsageError
from gelenk.model.scene import Scene, known_parameters, load
from gelenk.simulation.result import Result
from gelenk.simulation.run import simulate
from gelenk.viewer.pages import view_of

type Array = NDArray[np.float64]

SENSOR = "recorded__"  # begins the names of the sensors that are added for each body
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
    """

    scene: Mapping[str, Any]
    time: Array
    poses: Array
    result: Result
    rows: NDArray[np.intp]

    @property
    def signals(self) -> list[str]:
        """Names of the outputs, without those that record poses."""
        return [name for name in self.result.names if not name.startswith(SENSOR)]


def scene_of(plant: Scene | str | PathLike[str] | Mapping[str, Any]) -> Scene:
    """Return the scene of an FMU, or load one.

    Raises:
        UsageError: the FMU does not contain a scene.
        SceneError: the scene is invalid.
        OSError: the file cannot be read.
    """
    if isinstance(plant, str | PathLike) and str(plant).endswith(".fmu"):
        try:
            with zipfile.ZipFile(plant) as archive:
                return load(json.loads(archive.read("resources/scene.json")))
        except (zipfile.BadZipFile, KeyError):
            raise UsageError(f"{Path(plant)}: found no scene in it, expected an FMU made by Gelenk") from None
    return plant if isinstance(plant, Scene) else load(plant)


def record(scene: Scene, **run: Any) -> Recording:
    """Simulate a scene and record the poses of its bodies.

    Args:
        scene: the scene.
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
    if "outputs" in data:
        data["outputs"] = [*data["outputs"], f"{SENSOR}*"]
    # Positions of joints may be parameters.
    drawn = scene.with_parameters(known_parameters(scene, run.get("parameters") or {})).to_dict()
    try:
        return _recording_of(drawn, simulate(load(data), **run))
    except StepError as e:
        if e.result is not None:
            e.result.events += ((float(e.result.time[-1]), f"the run ended: {e}"),)
            e.view = view_of(_recording_of(drawn, e.result))
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


def _recording_of(scene: Mapping[str, Any], result: Result) -> Recording:
    """Return the recording of a run whose outputs are those that `record` adds, or of a part of it."""
    rows = _frames(len(result))
    return Recording(scene, result.time[rows], _poses(result, rows, len(scene["bodies"])), result, rows)


def _frames(rows: int) -> NDArray[np.intp]:
    """Return at most MAX_FRAMES row numbers at equal distances, with the first and the last."""
    return np.unique(np.linspace(0, rows - 1, min(rows, MAX_FRAMES)).round().astype(np.intp))


def _poses(result: Result, rows: Sequence[int] | NDArray[np.intp], bodies: int) -> Array:
    parts = [*(f"r[{k}]" for k in (1, 2, 3)), *(f"Q[{k}]" for k in (1, 2, 3, 4))]
    out = np.empty((len(rows), bodies, 7))
    for body in range(bodies):
        for k, part in enumerate(parts):
            out[:, body, k] = result[f"{SENSOR}{body}.{part}"][rows]
    return out
