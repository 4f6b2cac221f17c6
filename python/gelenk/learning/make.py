# SPDX-License-Identifier: BSD-3-Clause
"""Environments of Gymnasium made of scenes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.model.scene import Scene, Source, load
from gelenk.model.values import Value, check_names

if TYPE_CHECKING:
    import gymnasium

    from gelenk.learning.fleets import Fleet
    from gelenk.learning.gym import Task

type Array = NDArray[np.float64]


def environment(
    scene: Source,
    *,
    actions: Mapping[str, tuple[float, float]],
    observations: Sequence[str],
    reward: Callable[[Array, Array], float],
    terminated: Callable[[Array], bool] | None = None,
    step: float | None = None,
    stop: float | None = None,
    starts: Sequence[Mapping[str, Value]] = ({},),
) -> gymnasium.Env[Array, Array]:
    """Return an environment of Gymnasium, in which an agent acts on the inputs of a scene.

    Each reset restores a saved state, and equal seeds and actions give equal episodes, to the bit. A step
    that fails ends the episode, with the message in `info["error"]`.

    Args:
        scene: anything `gelenk.load` accepts.
        actions: inputs that the agent sets, and their bounds; an action outside of them is limited to them.
        observations: outputs that it sees.
        reward: function of the observation after a step and of the action.
        terminated: whether an observation ends the episode; None: never.
        step: time between actions [s]; by default the communication step of the scene.
        stop: time after which an episode is truncated [s]; by default that of the scene.
        starts: parameters and start values of the episodes. One of them is drawn at each reset, or is
            selected by `reset(options={"start": NUMBER})`.

    Returns:
        gymnasium.Env: with boxes of the observations and of the actions.

    Raises:
        SceneError, AssemblyError, UsageError: the scene, a name or a value is invalid, or Gymnasium is not
            installed.
    """
    extra("gymnasium", "environments are those of Gymnasium")
    from gelenk.learning.gym import Environment

    return Environment(*_task(scene, actions, observations, reward, terminated, step, stop, starts))


def vector_environment(
    scene: Source,
    instances: int,
    *,
    actions: Mapping[str, tuple[float, float]],
    observations: Sequence[str],
    reward: Callable[[Array, Array], Array],
    terminated: Callable[[Array], NDArray[np.bool_]] | None = None,
    step: float | None = None,
    stop: float | None = None,
    starts: Sequence[Mapping[str, Value]] = ({},),
    lanes: bool = False,
    threads: int = 1,
) -> gymnasium.vector.VectorEnv[Array, Array, Array]:
    """Return many environments of Gymnasium that are stepped together, in one process.

    Each instance is what `gelenk.environment` makes, to the bit; an instance is a saved state, not a plant
    of its own. An episode that has ended is followed by the next one in the next step, whose action is not
    used (`AutoresetMode.NEXT_STEP`). Integrators with a memory (ida, cvode) repeat their last steps when an
    instance is restored, so that rk4 and the explicit methods are faster.

    Args:
        scene: anything `gelenk.load` accepts.
        instances: how many.
        actions: as in `gelenk.environment`.
        observations: as in `gelenk.environment`.
        reward: function of the observations after a step, shape (instances, observations), and of the
            actions, shape (instances, actions); returns the rewards, shape (instances,).
        terminated: function of the observations that returns which of them end their episode.
        step: time between actions [s].
        stop: time after which an episode is truncated [s].
        starts: as in `gelenk.environment`; each instance draws one at each of its resets.
        lanes: whether instances are the lanes of a `gelenk.batch`, whose method is rk4: millions of steps per
            second, for smooth mechanisms, and observations that are coordinates and velocities of joints on
            the spanning trees. They are then what `gelenk.environment` makes with rk4, up to rounding.
        threads: with lanes, the number of threads.

    Returns:
        gymnasium.vector.VectorEnv: with boxes of observations and of actions; `reset(seed=NUMBER)`.

    Raises:
        SceneError, AssemblyError, UsageError: the scene, a name or a value is invalid, or Gymnasium is not
            installed; with lanes, the scene has an element that lanes refuse.
    """
    extra("gymnasium", "environments are those of Gymnasium")
    from gelenk.learning.fleets import Lanes, saved_states
    from gelenk.learning.vector import VectorEnvironment

    if instances < 1:
        raise UsageError(f"instances: found {instances}, expected at least 1")
    scenes, task = _task(scene, actions, observations, reward, terminated, step, stop, starts)

    def fleet() -> Fleet:
        if lanes:
            return Lanes(load(scene), starts, task, instances, threads)
        return saved_states(scenes, task, instances)

    return VectorEnvironment(fleet, len(starts), task, instances)


def _task(
    scene: Source, actions: Mapping[str, tuple[float, float]], observations: Sequence[str],
    reward: Callable[[Array, Array], Any], terminated: Callable[[Array], Any] | None,
    step: float | None, stop: float | None, starts: Sequence[Mapping[str, Value]],
) -> tuple[list[Scene], Task]:  # fmt: skip
    from gelenk.learning.gym import Task

    loaded = load(scene)
    if not starts:
        raise UsageError(
            "starts: found none, expected at least one mapping of parameters, which may be empty"
        )
    for name, (low, high) in actions.items():
        if not (np.isfinite([low, high]).all() and low < high):
            raise UsageError(f"{name}: found the bounds {low} and {high}, expected two numbers, low < high")
    scenes = [loaded.with_parameters(start) for start in starts]
    interval = loaded.step if step is None else step
    end = loaded.stop if stop is None else stop
    if not 0 < interval <= end:
        raise UsageError(f"step: found {interval} s, expected more than 0 s and at most the stop, {end} s")
    bounds = np.array([*actions.values()], np.float64).reshape(-1, 2)
    task = Task(tuple(actions), bounds, tuple(observations), reward, terminated, interval, end)
    check_names(list(observations), _outputs(loaded), "output")
    return scenes, task


def _outputs(scene: Any) -> list[str]:
    from gelenk.simulation.simulation import Simulation

    return [signal.name for signal in Simulation(scene.with_outputs(None)).outputs]
