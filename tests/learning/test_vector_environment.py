# SPDX-License-Identifier: BSD-3-Clause
"""Many environments that are stepped together."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk

gymnasium = pytest.importorskip("gymnasium")


@pytest.fixture
def task(root: Path) -> dict[str, Any]:
    return {
        "scene": root / "scenes" / "cart_pole.yaml", "actions": {"drive.f": (-10.0, 10.0)}, "step": 0.02,
        "stop": 1.0, "observations": ["track.s", "track.v", "hinge.phi", "hinge.w"],
        "starts": [{"hinge.phi_start": 0.02 * k} for k in range(4)],
    }  # fmt: skip


def upright(seen: Any, action: Any) -> Any:
    return np.cos(seen[..., 2]) - 1e-3 * action[..., 0] ** 2


def test_each_instance_is_an_environment_of_its_own(task: dict[str, Any]) -> None:
    """To the bit, over the ends of episodes, which come at different times."""
    ends: dict[str, Any] = {"reward": upright, "terminated": lambda seen: np.abs(seen[..., 2]) > 0.3}
    many = gelenk.vector_environment(instances=7, **task, **ends)
    single = [gelenk.environment(**task, **ends) for _ in range(7)]
    seen, info = many.reset(seed=3)
    assert set(info["start"]) <= set(range(4))
    for k, env in enumerate(single):
        assert env.reset(options={"start": int(info["start"][k])})[0].tolist() == seen[k].tolist()
    rng = np.random.default_rng(5)
    over = np.zeros(7, bool)
    episodes = 0
    for _ in range(120):
        actions = rng.uniform(-12, 12, size=(7, 1))
        seen, rewards, ended, truncated, _ = many.step(actions)
        for k, env in enumerate(single):
            if over[k]:  # the next episode; its start is that which the observation shows
                starts = [env.reset(options={"start": start})[0] for start in range(4)]
                start = next(i for i, row in enumerate(starts) if row.tolist() == seen[k].tolist())
                env.reset(options={"start": start})
                assert (rewards[k], ended[k], truncated[k]) == (0.0, False, False)
                episodes += 1
                continue
            row, reward, *flags, _ = env.step(actions[k])
            assert row.tolist() == seen[k].tolist()
            assert [reward, *flags] == [rewards[k], ended[k], truncated[k]]
        over = np.logical_or(ended, truncated)
    assert episodes > 7


def test_thousands_of_instances_are_as_one(task: dict[str, Any]) -> None:
    """Together they make 30,000 integrator steps in one plant, whose time hardly advances."""
    task["starts"] = [{}]
    many = gelenk.vector_environment(instances=3000, **task, reward=upright)
    many.reset(seed=1)
    rows = many.step(np.full((3000, 1), -9.4))[0]
    single = gelenk.environment(**task, reward=upright)
    single.reset(seed=1)
    row = single.step(np.array([-9.4]))[0]
    assert np.all(rows == row)


def test_equal_seeds_and_actions_give_equal_episodes(task: dict[str, Any]) -> None:
    def rows(seed: int) -> bytes:
        env = gelenk.vector_environment(instances=5, **task, reward=upright)
        found = [env.reset(seed=seed)[0]]
        found += [env.step(np.full((5, 1), 0.1 * k))[0] for k in range(60)]
        return np.array(found).tobytes()

    assert rows(1) == rows(1) != rows(2)


def test_it_is_a_vector_environment_of_gymnasium(task: dict[str, Any]) -> None:
    """Shapes and types are those of its spaces, and Gymnasium's own wrappers accept it."""
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(
        gelenk.vector_environment(instances=3, **task, reward=upright)
    )
    assert isinstance(env.unwrapped, gymnasium.vector.VectorEnv)
    seen, _ = env.reset(seed=0)
    assert seen in env.observation_space
    for _ in range(51):
        seen, rewards, ended, truncated, info = env.step(env.action_space.sample())
        assert seen in env.observation_space
        assert rewards.shape == ended.shape == truncated.shape == (3,)
        if truncated.any():
            assert info["episode"]["l"].tolist() == [50, 50, 50]
    env.close()


def test_selected_instances_are_reset(task: dict[str, Any]) -> None:
    env = gelenk.vector_environment(instances=3, **task, reward=upright)
    first, _ = env.reset(options={"start": 2})
    moved = env.step(np.ones((3, 1)))[0]
    mask = np.array([True, False, True])
    seen, info = env.reset(options={"reset_mask": mask, "start": 2})
    assert seen[mask].tolist() == first[mask].tolist()
    assert seen[1].tolist() == moved[1].tolist()
    assert info["_start"].tolist() == mask.tolist()


def test_a_step_that_fails_ends_the_episode_of_its_instance(task: dict[str, Any]) -> None:
    starts = [{}, {"solver.max_evaluations": 1}]
    env = gelenk.vector_environment(instances=20, **task | {"starts": starts}, reward=upright)
    _, info = env.reset(seed=0)
    bad = info["start"] == 1
    assert 0 < bad.sum() < 20
    _, _, ended, _, info = env.step(np.ones((20, 1)))
    assert ended.tolist() == bad.tolist() == info["_error"].tolist()
    assert "evaluations" in info["error"][np.flatnonzero(bad)[0]]


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda task: gelenk.vector_environment(instances=0, **task, reward=upright), "instances: found 0"),
        (
            lambda task: gelenk.vector_environment(instances=2, **task, reward=upright).step(
                np.zeros((2, 1))
            ),
            "before reset",
        ),
        (lambda task: made(task).reset(options={"start": 9}), "start: found 9, expected 0 to 3"),
        (
            lambda task: made(task, reward=lambda *_: 0.0).step(np.ones((2, 1))),
            "reward: found an array of shape ()",
        ),
        (lambda task: made(task).reset(seed=[1, 2]), "seed: expected one number"),
    ],
)
def test_wrong_calls_say_what_is_expected(task: dict[str, Any], call: Any, sentence: str) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        call(task)
    assert sentence in str(caught.value)


def made(task: dict[str, Any], **options: Any) -> Any:
    env = gelenk.vector_environment(instances=2, **task, **{"reward": upright} | options)
    env.reset(seed=1)
    return env


@pytest.mark.clock
def test_a_thousand_instances_make_250_000_steps_per_second(task: dict[str, Any]) -> None:
    env = gelenk.vector_environment(instances=1000, **task, reward=upright)
    env.reset(seed=1)
    actions = np.ones((1000, 1))

    def seconds(call: Any) -> float:
        start = time.process_time()
        call()
        return time.process_time() - start

    assert min(seconds(lambda: env.step(actions)) for _ in range(200)) < 1000 / 250_000
    assert min(seconds(lambda: env.reset(seed=1)) for _ in range(20)) < 1000 * 50e-6
