# SPDX-License-Identifier: BSD-3-Clause
"""Vector environments whose instances are lanes of a batch."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.errors import UsageError

pytest.importorskip("gymnasium", reason="gymnasium (the extra learning) is not installed")


@pytest.fixture
def task(root: Path) -> dict[str, Any]:
    scene = gelenk.load(root / "scenes" / "cart_pole.yaml")
    names = list(gelenk.batch(scene, 1).states)
    fixed = scene.with_parameters({"solver.integrator": "rk4", "solver.step": 0.005})
    return {
        "scene": fixed, "actions": {"drive.f": (-10.0, 10.0)}, "step": 0.02, "stop": 0.4,
        "observations": names, "reward": lambda seen, _: seen[..., 0],
    }  # fmt: skip


def other_starts(task: dict[str, Any]) -> tuple[dict[str, float], ...]:
    """Starts that differ in a mass and an angle."""
    parameters = task["scene"].parameters
    mass = next(name for name in parameters if name.startswith("pole.m"))
    angle = next(name for name in parameters if name.endswith("phi_start"))
    return {}, {mass: 1.4 * parameters[mass]}, {angle: 0.2, mass: 0.8 * parameters[mass]}


def test_each_lane_is_an_environment_of_its_own(task: dict[str, Any]) -> None:
    """Up to the rounding of 320 evaluations in an episode; starts and the ends of episodes are equal."""
    starts = other_starts(task)
    many = gelenk.vector_environment(**task, instances=40, starts=starts, lanes=True)
    one = gelenk.environment(**task, starts=starts)
    rng = np.random.default_rng(5)
    seen, info = many.reset(seed=3)
    actions = rng.uniform(-12, 12, (25, 40, 1))
    rows = [many.step(of)[0] for of in actions]
    lanes = [int(np.flatnonzero(info["start"] == k)[0]) for k in range(3)]
    for k, lane in enumerate(lanes):
        first, _ = one.reset(options={"start": k})
        assert seen[lane] == pytest.approx(first, abs=1e-15)
        for step in range(20):
            expected, _, _, truncated, _ = one.step(actions[step, lane])
            assert rows[step][lane] == pytest.approx(expected, abs=1e-12)
        assert truncated
    again = [many.step(of)[3] for of in rng.uniform(-1, 1, (16, 40, 1))]
    assert [step for step, of in enumerate(again) if of.all()] == [15]  # 25 + 16 = 20 + 1 + 20


def test_equal_seeds_and_actions_give_equal_episodes_for_any_number_of_threads(task: dict[str, Any]) -> None:
    def episode(threads: int) -> np.ndarray:
        many = gelenk.vector_environment(
            **task, instances=100, starts=other_starts(task), lanes=True, threads=threads
        )
        many.reset(seed=8)
        return np.array([many.step(np.full((100, 1), 0.3 * k))[0] for k in range(10)])

    assert np.array_equal(episode(1), episode(3))


def test_selected_instances_are_reset(task: dict[str, Any]) -> None:
    many = gelenk.vector_environment(**task, instances=50, lanes=True)
    start, _ = many.reset(seed=1)
    moved = many.step(np.full((50, 1), 2.0))[0]
    mask = np.arange(50) % 3 == 0
    mixed, _ = many.reset(options={"reset_mask": mask})
    assert np.array_equal(mixed[mask], start[mask])
    assert np.array_equal(mixed[~mask], moved[~mask])


def test_a_lane_that_stops_ends_its_episode(task: dict[str, Any]) -> None:
    """Its error is reported, and it begins again; the others continue."""
    many = gelenk.vector_environment(
        **{**task, "actions": {"drive.f": (-1e300, 1e300)}}, instances=34, lanes=True
    )
    many.reset(seed=1)
    actions = np.zeros((34, 1))
    actions[33] = 1e300
    _, _, ended, _, info = many.step(actions)
    assert np.flatnonzero(ended).tolist() == [33]
    assert "not finite" in info["error"][33]
    seen, _, ended, _, info = many.step(np.zeros((34, 1)))
    assert not ended.any()
    assert "error" not in info
    assert np.isfinite(seen).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: {"observations": ["hinge.a"]}, "hinge.a: no such state of a lane"),
        (lambda task: {"observations": task["observations"] * 2}, "found twice"),
        (
            lambda _: {"starts": ({"solver.step": 1e-3},)},
            "solver.step: the same for all lanes; expected a number of the mechanism",
        ),
        (
            lambda _: {"starts": ({"solver.integrator": "ida"},)},
            "solver.integrator: the same for all lanes",
        ),
        (lambda _: {"threads": 0}, "threads: found 0"),
    ],
)
def test_wrong_calls_say_what_is_expected(
    task: dict[str, Any], change: Callable[[dict[str, Any]], dict[str, Any]], message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        gelenk.vector_environment(**{**task, **change(task)}, instances=4, lanes=True)


def test_forces_by_the_time_are_refused(task: dict[str, Any]) -> None:
    data = task["scene"].to_dict()
    data["joints"]["hinge"]["law"] = {"effort": "sin(t)"}
    with pytest.raises(UsageError, match="forces depend on the time, which differs from episode to episode"):
        gelenk.vector_environment(**{**task, "scene": data}, instances=4, lanes=True)


def test_an_action_that_is_no_number_ends_one_episode(task: dict[str, Any]) -> None:
    """As without lanes; the others are not affected."""
    many = gelenk.vector_environment(**task, instances=5, lanes=True)
    twin = gelenk.vector_environment(**task, instances=5, lanes=True)
    for of in (many, twin):
        of.reset(seed=1)
    actions = np.full((5, 1), 0.5)
    expected = twin.step(actions)[0]
    actions[3] = np.nan
    seen, _, ended, _, info = many.step(actions)
    assert ended.tolist() == [False, False, False, True, False]
    assert info["error"][3] == "an action is not a finite number"
    assert np.isfinite(seen).all()
    assert np.array_equal(np.delete(seen, 3, axis=0), np.delete(expected, 3, axis=0))
    assert np.isfinite(many.step(np.full((5, 1), 0.5))[0]).all()


@pytest.mark.parametrize("lanes", [False, True])
def test_actions_of_another_shape_are_refused(task: dict[str, Any], lanes: bool) -> None:
    many = gelenk.vector_environment(**task, instances=4, lanes=lanes)
    many.reset(seed=1)
    with pytest.raises(UsageError, match=r"actions: found an array of shape \(4, 2\), expected \(4, 1\)"):
        many.step(np.zeros((4, 2)))
