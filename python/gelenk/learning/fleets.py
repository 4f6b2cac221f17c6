# SPDX-License-Identifier: BSD-3-Clause
"""What steps the instances of a vector environment: saved states of plants, or the lanes of a batch."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.batches.lanes import batch
from gelenk.errors import UsageError
from gelenk.learning.gym import Task, prepared
from gelenk.model.scene import Scene, by_parameter
from gelenk.model.values import Value, check_names

type Numbers = NDArray[np.float64]
type Indices = NDArray[np.int32]
type Outcome = tuple[list[tuple[int, float, str]], list[tuple[int, str]]]


class Fleet(Protocol):
    """Many instances of a scene."""

    def reset(self, instances: Indices, starts: Indices, rows: Numbers) -> None:
        """Put instances to starts, and write what is observed there into their rows."""

    def step(self, actions: Numbers, rows: Numbers) -> Outcome:
        """Hold the actions for a step; return events (instance, time, text) and errors (instance, text)."""


def saved_states(scenes: Sequence[Scene], task: Task, instances: int) -> Fleet:
    """Return instances that are saved states of a plant for each start."""
    plants, channels, _ = zip(*prepared(scenes, task), strict=True)
    return _core.Fleet([plant._core for plant in plants], list(channels), instances, task.step)


class Lanes:
    """Instances that are the lanes of a batch."""

    def __init__(
        self, scene: Scene, starts: Sequence[Mapping[str, Value]], task: Task, instances: int, threads: int
    ) -> None:
        """Make a batch of the starts, too, whose lanes the instances become at a reset.

        Raises:
            SceneError: the scene has an element that is refused in lanes.
            UsageError: what is observed is no state, or a start sets anything but a number of the mechanism.
        """
        own = float(scene.parameters["solver.step"]) or scene.step
        self._steps = max(1, math.ceil(task.step / own * (1 - 1e-12)))
        names = sorted({name for start in starts for name in start})
        step = task.step / self._steps
        values = {name: _values(scene, name, starts) for name in names}
        self._source = batch(scene, len(starts), values, step=step, threads=threads)
        first: dict[str, Any] = {name: of[0] for name, of in values.items()}
        self._batch = batch(scene, instances, first, step=step, threads=threads)
        check_names(list(task.observations), list(self._batch.states), "state of a lane")
        check_names(list(task.actions), list(self._batch.inputs), "input")
        if self._batch._core.reads_time:
            raise UsageError(
                f"{scene.name}: forces depend on the time, which differs from episode to episode"
            )
        rows = list(self._batch.states)
        self._seen = [rows.index(name) for name in task.observations]
        self._inputs = [self._batch.inputs[name] for name in task.actions]

    def reset(self, instances: Indices, starts: Indices, rows: Numbers) -> None:
        """Put instances to starts; see `Fleet`."""
        self._batch._core.start_as(instances.tolist(), self._source._core, starts.tolist())
        rows[instances] = self._batch.array[self._seen][:, instances].T

    def step(self, actions: Numbers, rows: Numbers) -> Outcome:
        """Hold the actions for a step; see `Fleet`. There are no events."""
        for row, of in zip(self._inputs, actions.T, strict=True):
            row[:] = of
        before = len(self._batch._core.stopped)
        self._batch._advance(self._steps)
        rows[:] = self._batch.array[self._seen].T
        wrong = set(np.flatnonzero(~np.isfinite(actions).all(axis=1)).tolist())
        why = "an action is not a finite number"
        stopped = self._batch._core.stopped[before:]
        return [], [(stop.lane, why if stop.lane in wrong else stop.text) for stop in stopped]


def _values(scene: Scene, name: str, starts: Sequence[Mapping[str, Value]]) -> Numbers:
    """Return the values of a parameter at the starts."""
    own = next(iter(by_parameter(scene, {name: 0.0})))
    values = [start.get(name, scene.parameters[own]) for start in starts]
    if not all(isinstance(value, float | int) for value in values):
        raise UsageError(f"{name}: the same for all lanes; expected a number of the mechanism")
    return np.array(values, np.float64)
