# SPDX-License-Identifier: BSD-3-Clause
"""Environments for reinforcement learning."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk

gymnasium = pytest.importorskip("gymnasium")

CART_POLE = Path("scenes") / "cart_pole.yaml"


@pytest.fixture
def cart_pole(root: Path) -> Any:
    scene = gelenk.load(root / CART_POLE)
    names = [signal.name for signal in gelenk.Simulation(scene).outputs]
    coordinates = [name for name in names if name.endswith((".s", ".v", ".phi", ".w"))]
    inputs = [signal.name for signal in gelenk.Simulation(scene).inputs]
    angle = next(name for name in coordinates if name.endswith(".phi"))

    def made(**options: Any) -> Any:
        given: dict[str, Any] = {
            "actions": {inputs[0]: (-10.0, 10.0)}, "observations": coordinates, "step": 0.02, "stop": 1.0,
            "reward": lambda seen, action: math.cos(seen[coordinates.index(angle)]) - 1e-3 * action[0] ** 2,
        }  # fmt: skip
        return gelenk.environment(scene, **given | options)

    return made


@pytest.mark.filterwarnings("ignore:.*:UserWarning")  # advice about boxes without bounds
def test_gymnasiums_checker_finds_nothing(cart_pole: Any) -> None:
    from gymnasium.utils.env_checker import check_env

    check_env(cart_pole(), skip_render_check=True)


def test_equal_seeds_and_actions_give_equal_episodes(cart_pole: Any) -> None:
    env = cart_pole()

    def episode(seed: int) -> bytes:
        rows = [env.reset(seed=seed)[0]]
        env.action_space.seed(seed)
        over = False
        while not over:
            seen, _, ended, truncated, _ = env.step(env.action_space.sample())
            rows.append(seen)
            over = ended or truncated
        assert len(rows) == 51
        return np.array(rows).tobytes()

    assert episode(1) == episode(1) != episode(2)


def test_an_episode_is_a_run_of_simulate(cart_pole: Any, root: Path) -> None:
    env = cart_pole()
    scene = gelenk.load(root / CART_POLE)
    names, force = env._task.observations, env._task.actions[0]
    run = gelenk.simulate(scene, stop=0.2, step=0.02, inputs={force: 3.0}, outputs=list(names))
    env.reset()
    for k in range(1, 11):
        seen = env.step(np.array([3.0]))[0]
        assert seen.tolist() == [run[name][k] for name in names]


def test_starts_are_drawn_or_selected(cart_pole: Any, root: Path) -> None:
    parameters = gelenk.load(root / CART_POLE).parameters
    start = next(name for name in parameters if name.endswith(".phi_start"))
    env = cart_pole(starts=[{start: 0.01 * k} for k in range(5)])
    drawn = {env.reset(seed=seed)[1]["start"] for seed in range(40)}
    assert drawn == set(range(5))
    angle = env._task.observations.index(start.removesuffix("_start"))
    assert env.reset(options={"start": 3})[0][angle] == pytest.approx(0.03)


def test_an_episode_ends_where_it_is_asked_to(cart_pole: Any) -> None:
    env = cart_pole(terminated=lambda seen: abs(seen[0]) > 0.05)
    env.reset()
    ends = [env.step(np.array([10.0]))[2:4] for _ in range(50)]
    assert ends[0] == (False, False)
    assert ends[-1] == (True, True)


def test_a_step_that_fails_ends_the_episode(cart_pole: Any) -> None:
    env = cart_pole(starts=[{"solver.max_evaluations": 1}])
    env.reset()
    _, _, ended, _, info = env.step(np.array([1.0]))
    assert ended
    assert "evaluations" in info["error"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"starts": []}, "starts: found none"),
        ({"observations": ["x.y"]}, "x.y: no such output"),
        ({"actions": {"nothing": (0.0, 1.0)}}, "nothing: no such input"),
        ({"actions": {"nothing": (1.0, 0.0)}}, "nothing: found the bounds 1.0 and 0.0"),
        ({"step": 2.0}, "step: found 2.0 s, expected more than 0 s and at most the stop, 1.0 s"),
    ],
)
def test_wrong_calls_say_what_is_expected(cart_pole: Any, options: Any, sentence: str) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        cart_pole(**options)
    assert sentence in str(caught.value)
