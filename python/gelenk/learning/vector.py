# SPDX-License-Identifier: BSD-3-Clause
"""Many environments that are stepped together; imported only if Gymnasium is installed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, override

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.learning.fleets import Fleet
from gelenk.learning.gym import Task, spaces

type Array = NDArray[np.float64]
type Flags = NDArray[np.bool_]


class VectorEnvironment(gymnasium.vector.VectorEnv[Array, Array, Array]):
    """Instances of a scene, each with its own agent. The loop over them is compiled."""

    def __init__(self, make: Callable[[], Fleet], starts: int, task: Task, instances: int) -> None:
        """See `gelenk.vector_environment`. make: what steps the instances; starts: how many there are."""
        self.metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}
        self.num_envs = instances
        self._task = task
        self._starts = starts
        self._fleet = make()
        self._low, self._high = task.bounds[:, 0].copy(), task.bounds[:, 1].copy()
        self._count = np.zeros(instances, np.int64)
        self._ended: Flags = np.zeros(instances, np.bool_)
        self._begun = False
        self._seen: Array = np.zeros((instances, len(task.observations)))
        self.single_action_space, self.single_observation_space = spaces(task)
        self.action_space = batch_space(self.single_action_space, instances)
        self.observation_space = batch_space(self.single_observation_space, instances)

    @override
    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Restore saved states; see `gelenk.vector_environment`."""
        if seed is not None and not isinstance(seed, int):
            raise UsageError("seed: expected one number, from which all instances draw their starts")
        super().reset(seed=seed)
        chosen = dict(options or {})
        mask = np.asarray(chosen.get("reset_mask", np.ones(self.num_envs, np.bool_)), np.bool_)
        if mask.shape != (self.num_envs,) or not (self._begun or mask.all()):
            raise UsageError(
                f"reset_mask: expected {self.num_envs} flags, all of them set at the first reset"
            )
        rows = np.empty((self.num_envs, len(self._task.observations))) if mask.all() else self._seen.copy()
        starts = self._reset(np.flatnonzero(mask), rows, chosen.get("start"))
        self._seen, self._begun = rows, True
        numbers = np.zeros(self.num_envs, np.int64)
        numbers[mask] = starts
        return rows.copy(), {"start": numbers, "_start": mask}

    @override
    def step(self, actions: Array) -> tuple[Array, Array, Any, Any, dict[str, Any]]:
        """Hold the actions for a step; see `gelenk.vector_environment`."""
        if not self._begun:
            raise UsageError("step: called before reset")
        task, n = self._task, self.num_envs
        given = np.asarray(actions, np.float64)
        if given.size != n * len(task.actions):
            raise UsageError(
                f"actions: found an array of shape {given.shape}, expected ({n}, {len(task.actions)})"
            )
        given = np.clip(given.reshape(n, -1), self._low, self._high)
        rows = np.empty((n, len(task.observations)))
        events, errors = self._fleet.step(given, rows)
        self._count += 1
        over = self._ended.copy()
        resets = bool(over.any())
        if resets:  # its last episode has ended: a new one begins, and the action is not used
            self._reset(np.flatnonzero(over), rows, None)
        info: dict[str, Any] = {}
        rewards = np.asarray(task.reward(rows, given), np.float64)
        if rewards.shape != (n,):
            raise UsageError(f"reward: found an array of shape {rewards.shape}, expected ({n},)")
        ended = np.zeros(n, np.bool_)
        if task.terminated is not None:
            ended = np.array(task.terminated(rows), np.bool_)
            if ended.shape != (n,):
                raise UsageError(f"terminated: found an array of shape {ended.shape}, expected ({n},)")
        for instance, text in errors:
            if not over[instance]:
                ended[instance] = True
                _note(info, "error", n, instance, text)
        for instance, time, text in events:
            if not over[instance]:
                _note(info, "events", n, instance, [*_noted(info, "events", instance), (time, text)])
        truncated = self._count >= task.steps
        if resets:
            rewards, ended = np.where(over, 0.0, rewards), ended & ~over
            truncated &= ~over
        self._ended = ended | truncated
        self._seen = rows
        return rows.copy(), rewards, ended, truncated, info

    def _reset(self, instances: NDArray[np.intp], rows: Array, start: int | None) -> NDArray[np.int64]:
        if start is None:
            starts = self.np_random.integers(self._starts, size=len(instances))
        else:
            if not 0 <= start < self._starts:
                raise UsageError(f"start: found {start}, expected 0 to {self._starts - 1}")
            starts = np.full(len(instances), start, np.int64)
        self._fleet.reset(instances.astype(np.int32), starts.astype(np.int32), rows)
        self._count[instances] = 0
        self._ended[instances] = False
        return starts


def _note(info: dict[str, Any], key: str, count: int, instance: int, value: Any) -> None:
    """Enter a value for one instance, as Gymnasium's vector environments do."""
    if key not in info:
        info[key], info[f"_{key}"] = np.full(count, None, object), np.zeros(count, np.bool_)
    info[key][instance], info[f"_{key}"][instance] = value, True


def _noted(info: dict[str, Any], key: str, instance: int) -> list[Any]:
    return (info[key][instance] or []) if key in info else []
