# SPDX-License-Identifier: BSD-3-Clause
"""Starts scenes and evaluates them: values, a short run, the linear model, or the message of a refusal."""

from __future__ import annotations

import copy
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mechanisms import Array, Scene

import gelenk
from gelenk.linear import LinearModel, linear_model

type Refusal = str  # message of a refusal
CRASH = "crash: "  # before messages that are not meant for users
TOLERANCE = 1e-10
STOP, STEPS = 0.1, 4  # s: of the short run
EVALUATIONS = 20000  # a step of the short run takes some hundreds


def attempt[T](what: Callable[[], T]) -> T | Refusal:
    """Return the result, or the message of the refusal."""
    try:
        with warnings.catch_warnings(action="ignore", category=gelenk.StartWarning):
            return what()
    except gelenk.GelenkError as e:
        return f"{type(e).__name__}: {e}"
    except Exception as e:
        return f"{CRASH}{type(e).__name__}: {e}"


@dataclass
class Start:
    """A plant after initialization."""

    source: Scene
    label: str = ""
    tolerance: float = TOLERANCE

    @cached_property
    def plant(self) -> gelenk.Simulation | Refusal:
        return attempt(self._started)

    def _started(self) -> gelenk.Simulation:
        plant = gelenk.Simulation(self.source)
        plant.initialize(0.0, self.tolerance)
        return plant

    @cached_property
    def warned(self) -> str:
        """Warnings of the start; empty if none."""
        return " ".join(self._warnings)

    @property
    def warned_of_singularity(self) -> str:
        """Warnings of the start, except about loops that can be closed in two ways, and about guesses."""
        others = ("equally close", "a guess with which the loops cannot be closed")
        return " ".join(w for w in self._warnings if not any(text in w for text in others))

    @property
    def _warnings(self) -> list[str]:
        return [] if isinstance(self.plant, str) else self.plant._core.start_warnings()

    @cached_property
    def values(self) -> dict[str, float]:
        """All outputs of a plant that has started."""
        plant = self.plant
        assert not isinstance(plant, str)
        found = attempt(plant.values)
        if isinstance(found, str):
            return {}
        return dict(zip((s.name for s in plant.outputs), found.tolist(), strict=True))

    @cached_property
    def levels(self) -> dict[str, int]:
        """0: a coordinate, 1: a velocity, 2: an acceleration; other outputs have no level."""
        plant = self.plant
        assert not isinstance(plant, str)
        return {s.name: s.level for s in plant.outputs}

    @cached_property
    def run(self) -> dict[str, float] | Refusal:
        """Coordinates and velocities at the end of the short run."""
        return attempt(self._run)

    def _run(self) -> dict[str, float]:
        plant = gelenk.Simulation(budgeted(self.source))
        plant.initialize(0.0, self.tolerance)
        for k in range(STEPS):
            plant.step_to((k + 1) * STOP / STEPS)
        names = [s.name for s in plant.outputs if s.level in (0, 1)]
        return dict(zip(names, plant.values(names).tolist(), strict=True))

    def linear(self, states: Sequence[str] | None = None) -> LinearModel | Refusal:
        return attempt(lambda: linear_model(self.source, states=states))


def budgeted(source: Scene) -> Scene:
    """The scene with a bound on the cost of a step."""
    out = copy.deepcopy(source)
    out.setdefault("solver", {})["max_evaluations"] = EVALUATIONS
    return out


def without(source: Scene, **reductions: bool) -> Scene:
    out = copy.deepcopy(source)
    out.setdefault("solver", {}).setdefault("reductions", {}).update(reductions)
    return out


def beside(
    start: Start, states: Sequence[str], moves: dict[str, float], derivatives: dict[str, Array]
) -> Scene:
    """The scene started with these states changed and fixed, all others as guesses extrapolated accordingly.

    moves: by state, `J.theta[i]` rotating joint J's frame M about its own axis i. derivatives: of all
    outputs, by state.
    """
    out = copy.deepcopy(start.source)
    names = list(start.values)
    predicted = dict(start.values)
    for state, by in moves.items():
        for name, derivative in zip(names, derivatives[state].tolist(), strict=True):
            predicted[name] += by * derivative
    for state, by in moves.items():
        if ".theta[" not in state:
            predicted[state] = start.values[state] + by
    for joint, entry in out["joints"].items():
        entry["start"] = _start_of(start, joint, states, moves, predicted)
    return out


def _start_of(
    start: Start, joint: str, states: Sequence[str], moves: dict[str, float], predicted: dict[str, float]
) -> dict[str, object]:
    scalars: dict[str, object] = {}
    vectors: dict[str, list[float]] = {}
    fixed: list[str] = []
    for name, level in start.levels.items():
        owner, _, quantity = name.partition(".")
        if owner != joint or level not in (0, 1):
            continue
        bare = quantity.partition("[")[0]
        if bare == quantity:
            scalars[quantity] = predicted[name]
        else:
            vectors.setdefault(bare, []).append(predicted[name])
        state = name.replace(".Q[", ".theta[")
        if state in states and bare not in fixed:
            fixed.append(bare)
    if "Q" in vectors:
        Q = np.array([start.values[f"{joint}.Q[{i}]"] for i in (1, 2, 3, 4)])
        if "Q" in fixed:
            for i in range(3):
                Q = turned(Q, i, moves.get(f"{joint}.theta[{i + 1}]", 0.0))
        else:
            Q = np.array(vectors["Q"])
        vectors["Q"] = (Q / np.linalg.norm(Q)).tolist()
    return scalars | vectors | ({"fixed": fixed} if fixed else {})


def start_of(start: Start, joint: str) -> dict[str, object]:
    """All coordinates and velocities of a joint, as found."""
    out = _start_of(start, joint, (), {}, start.values)
    out.pop("fixed", None)
    return out


def turned(Q: Array, axis: int, angle: float) -> Array:
    """Q (x, y, z, scalar) times a rotation about one of its own axes."""
    v, s = Q[:3], Q[3]
    u, c = np.eye(3)[axis] * np.sin(angle / 2), np.cos(angle / 2)
    return np.append(s * u + c * v + np.cross(v, u), s * c - v @ u)


def whole_vectors(states: Sequence[str]) -> bool:
    """Whether vectors are among the states as a whole, which is required to fix them."""
    for state in states:
        bare, bracket, _ = state.partition("[")
        if bracket and not all(f"{bare}[{i}]" in states for i in (1, 2, 3)):
            return False
    return True


def same_sign(values: dict[str, float], near: Mapping[str, float]) -> dict[str, float]:
    """Q and -Q are the same rotation: return the closer one of the two."""
    out = dict(values)
    for name in values:
        if name.endswith(".Q[1]"):
            group = [f"{name[:-2]}{i}]" for i in (1, 2, 3, 4)]
            if sum(values[n] * near[n] for n in group) < 0:
                out |= {n: -values[n] for n in group}
    return out


def guess_error(source: Scene, start: Start) -> float:
    """Root of the sum of squared deviations from the guesses of coordinates, angles modulo full turns."""
    total = 0.0
    for joint, entry in source["joints"].items():
        for q, guess in entry.get("start", {}).items():
            name = f"{joint}.{q}"
            if start.levels.get(name) == 0:
                gap = start.values[name] - guess
                total += (math.remainder(gap, 2 * math.pi) if q.startswith("phi") else gap) ** 2
    return math.sqrt(total)
