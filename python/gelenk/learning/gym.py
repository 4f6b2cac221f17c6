# SPDX-License-Identifier: BSD-3-Clause
"""The environment of Gymnasium; imported only if Gymnasium is installed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, override

import gymnasium
import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.model.scene import Scene
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """What an agent does: see `gelenk.environment`.

    Attributes:
        actions: names of inputs.
        bounds: of the actions, shape (actions, 2).
        observations: names of outputs.
        reward: function of the observation after a step and of the action.
        terminated: whether an observation ends the episode.
        step: time between actions [s].
        stop: time after which an episode is truncated [s].
    """

    actions: tuple[str, ...]
    bounds: Array
    observations: tuple[str, ...]
    reward: Callable[[Array, Array], float]
    terminated: Callable[[Array], bool] | None
    step: float
    stop: float

    @property
    def steps(self) -> int:
        """Number of steps of an episode that is not terminated."""
        return math.ceil(self.stop / self.step * (1 - 1e-12))


type Start = tuple[Simulation, _core.Channels, bytes]


def prepared(scenes: Sequence[Scene], task: Task) -> list[Start]:
    """Return, for each start, a plant, its channels and its saved state."""
    found = []
    for scene in scenes:
        plant = Simulation(scene.with_outputs(list(task.observations)))
        plant.initialize()
        found.append((plant, plant.channels(task.actions, (), task.observations), plant.save()))
    return found


def spaces(task: Task) -> tuple[gymnasium.Space[Array], gymnasium.Space[Array]]:
    """Return the spaces of actions and of observations."""
    actions: Any = gymnasium.spaces.Box(task.bounds[:, 0], task.bounds[:, 1], dtype=np.float64)
    observations: Any = gymnasium.spaces.Box(-np.inf, np.inf, (len(task.observations),), dtype=np.float64)
    return actions, observations


class Environment(gymnasium.Env[Array, Array]):
    """A scene on whose inputs an agent acts."""

    def __init__(self, scenes: Sequence[Scene], task: Task) -> None:
        self._task = task
        self._starts = prepared(scenes, task)
        self._plant, self._channels, _ = self._starts[0]
        self._low, self._high = task.bounds[:, 0].copy(), task.bounds[:, 1].copy()
        self._count = 0
        self._steps = task.steps
        self.action_space, self.observation_space = spaces(task)

    @override
    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Restore a saved state; see `gelenk.environment`."""
        super().reset(seed=seed)
        start = (options or {}).get("start")
        if start is None:
            start = int(self.np_random.integers(len(self._starts))) if len(self._starts) > 1 else 0
        self._plant, self._channels, saved = self._starts[start]
        self._plant.restore(saved)
        self._count = 0
        return self._plant.values(self._task.observations), {"start": start}

    @override
    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold the action for a step; see `gelenk.environment`."""
        task = self._task
        given = np.minimum(np.maximum(np.asarray(action, np.float64), self._low), self._high)
        times = np.array([self._count, self._count + 1]) * task.step
        rows = np.empty((1, len(task.observations)))
        _, events, _, error = self._plant._core.record(self._channels, times, given.reshape(1, -1), rows, 0.0)
        info: dict[str, Any] = {"events": events} if events else {}
        if error:
            info["error"] = error
            rows[0] = self._plant.values(task.observations)
        self._count += 1
        seen = rows[0]
        ended = bool(error) or (task.terminated is not None and bool(task.terminated(seen)))
        return seen, float(task.reward(seen, given)), ended, self._count >= self._steps, info
