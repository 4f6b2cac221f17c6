# SPDX-License-Identifier: BSD-3-Clause
"""Runs whose bodies are recorded, for pictures that move."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any, override

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import GelenkError, StepError, UsageError
from gelenk.model.scene import Scene, known_parameters, load
from gelenk.model.skeleton import constraining_joints
from gelenk.simulation.fmu_file import SCENE, text_in
from gelenk.simulation.inputs import SampledInputs
from gelenk.simulation.result import Result
from gelenk.simulation.run import grid, simulate
from gelenk.simulation.scene_plant import ScenePlant
from gelenk.simulation.simulation import Simulation
from gelenk.viewer.arrows import Arrow, Wrench, arrows_of
from gelenk.viewer.pages import view_of

type Array = NDArray[np.float64]

SENSOR = "recorded__"  # begins the names of the sensors by which the reactions of joints are known
MAX_FRAMES = 1000
MOST_CHANGES = 100  # of a contact; more marks would cover the time slider


@dataclass(frozen=True)
class Recording:
    """A mechanism in motion.

    Attributes:
        scene: the scene as plain data, with the parameters of the run.
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
    data = scene.to_dict()
    if reactions:
        sensors = {
            f"{SENSOR}{name}": {"type": "reaction", "joint": name} for name in constraining_joints(data)
        }
        data["sensors"] = {**data.get("sensors", {}), **sensors}
    # Positions of joints may be parameters.
    drawn = scene.with_parameters(known_parameters(scene, run.get("parameters") or {})).to_dict()
    stop, step = run.get("stop"), run.get("step")
    times = grid(scene.stop if stop is None else stop, scene.step if step is None else step)
    recorded = load(data) if reactions else scene
    outputs = scene.outputs if run.get("outputs") is None else ()
    plant = RecordedPlant(recorded.without(run.get("without", ())), frame_rows(len(times)), outputs)
    try:
        return plant.recording(drawn, simulate(plant, **run))  # type: ignore[arg-type]
    except StepError as e:
        if e.result is not None:
            e.result.events += ((float(e.result.time[-1]), f"the run ended: {e}"),)
            e.view = view_of(plant.recording(drawn, e.result))
        raise


class RecordedPlant(ScenePlant):
    """A scene that keeps, at some rows of a run, where its bodies are and what acts on them."""

    def __init__(self, scene: Scene, frames: NDArray[np.intp], outputs: Sequence[str]) -> None:
        """Make it of a scene with all its bodies.

        Args:
            scene: the scene.
            frames: numbers of rows at which the state is kept, ascending from 0.
            outputs: names and patterns of the outputs that are recorded by default; empty: all.
        """
        super().__init__(scene.with_outputs(None))
        patterns = outputs or ("*",)
        self.outputs = [
            name
            for name in self.outputs
            if not name.startswith(SENSOR) and any(_core.meets(pattern, name) for pattern in patterns)
        ]
        self._frames = frames
        self._rows: list[int] = []
        self._poses: list[Array] = []
        self._wrenches: list[list[Wrench]] = []

    def recording(self, scene: Mapping[str, Any], result: Result) -> Recording:
        """Return what was kept, with the scene as plain data, and the result of the run."""
        if self._rows[-1] < len(result) - 1:  # a step has failed
            with contextlib.suppress(StepError):
                self._keep(len(result) - 1)
        rows = np.array(self._rows)
        return Recording(
            scene, result.time[rows], np.array(self._poses), result, rows, arrows_of(self._wrenches)
        )

    @override
    def start(self, *arguments: Any) -> None:
        super().start(*arguments)
        self._keep(0)
        self._row = 0

    @override
    def record(
        self, times: Array, inputs: SampledInputs, rows: Array
    ) -> tuple[int, list[tuple[float, str]], GelenkError | None]:
        done = 0
        events: list[tuple[float, str]] = []
        error = None
        while done < len(rows) and error is None:
            frame = self._frames[np.searchsorted(self._frames, self._row, side="right")]
            end = min(len(rows), done + int(frame) - self._row)
            part = replace(inputs, table=inputs.table[done:end])
            steps, found, error = super().record(times[done : end + 1], part, rows[done:end])
            events += found
            done += steps
            self._row += steps
            if self._row == frame:
                self._keep(self._row)
        return done, events, error

    def _keep(self, row: int) -> None:
        self._rows.append(row)
        self._poses.append(poses_of(self._simulation))
        self._wrenches.append(_core.wrenches(self._simulation._core))


def poses_of(plant: Simulation) -> Array:
    """Return the poses of the bodies of a plant: positions [m] and quaternions (x, y, z, w), (bodies, 7)."""
    from scipy.spatial.transform import Rotation

    poses = [plant.pose(body) for body in plant.body_names]
    if not poses:
        return np.empty((0, 7))
    turns = Rotation.from_matrix(np.array([R for R, _ in poses])).as_quat()
    return np.column_stack([[p for _, p in poses], turns])


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


def frame_rows(rows: int, most: int = MAX_FRAMES) -> NDArray[np.intp]:
    """Return at most `most` row numbers at equal distances, with the first and the last."""
    return np.unique(np.linspace(0, rows - 1, min(rows, most)).round().astype(np.intp))


def contact_events(
    scene: Mapping[str, Any], time: Array, signals: Mapping[str, Array]
) -> list[tuple[float, str]]:
    """Return when contacts begin, end, stick and slide: times [s], and what happens.

    Args:
        scene: the scene as plain data.
        time: of the signals [s].
        signals: outputs by name; contacts without an output `mode` have no events.
    """
    found: list[tuple[float, str]] = []
    for name in scene.get("contacts", {}):
        if f"{name}.mode" not in signals:
            continue
        modes = np.asarray(signals[f"{name}.mode"]).round().astype(int)
        changes = [(k + 1, a, b) for k, (a, b) in enumerate(pairwise(modes.tolist())) if a != b]
        if len(changes) > MOST_CHANGES:
            continue
        for k, before, after in changes:
            what = (
                "opens" if after == 0 else "closes" if before == 0 else "sticks" if after == 1 else "slides"
            )
            found.append((float(time[k]), f"{name} {what}"))
    return sorted(found)
