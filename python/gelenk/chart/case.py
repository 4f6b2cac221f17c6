# SPDX-License-Identifier: BSD-3-Clause
"""Test cases: a scene with its duration, inputs and reference solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gelenk
from gelenk.errors import UsageError
from gelenk.model.values import unknown
from gelenk.simulation.run import grid

type Array = NDArray[np.float64]

MAX_SAMPLES = 1000
SAMPLES = 20  # of a scene without input jumps; few, because each truncates a step of the integrator


@dataclass(frozen=True)
class Jumps:
    """An input with a new value at every communication step, reproducible between runs.

    The values are mean + amplitude x, with x in [-1, 1] from Weyl's sequence of the golden ratio, so that
    neighbors differ and no value repeats.
    """

    mean: float
    amplitude: float

    def at(self, k: int) -> float:
        """Return the value during communication step k (from 0)."""
        return self.mean + self.amplitude * (2.0 * ((k + 1) * 0.6180339887498949 % 1.0) - 1.0)


@dataclass(frozen=True)
class Smooth:
    """The input mean + amplitude sin(rate t).

    It is set with three time derivatives at the start of each communication step, so that it is a cubic
    polynomial within the step.
    """

    mean: float
    amplitude: float
    rate: float  # rad/s

    def at(self, t: float) -> tuple[float, ...]:
        """Return the value and the time derivatives of orders 1 to 3 at time t [s]."""
        waves = (self.amplitude * self.rate**n * math.sin(self.rate * t + n * math.pi / 2) for n in range(4))
        first, *others = waves
        return self.mean + first, *others


@dataclass(frozen=True)
class Case:
    """A test case: one run that is repeated with every method. Times are in s."""

    name: str
    about: str
    scene: dict[str, Any]
    stop: float
    step: float  # communication step
    inputs: Mapping[str, float | Jumps | Smooth] = field(default_factory=dict)
    #: Closed-form solution: joint states by output name at given times; None: computed, see `reference`.
    truth: Callable[[Array], dict[str, Array]] | None = None
    #: Published joint states (time, output, value) for checking a reference, and their source.
    published: tuple[tuple[float, str, float], ...] = ()
    source: str = ""
    expected: str = "good"  # or "refused": the equations have no solution
    times: tuple[float, ...] = ()  # communication points except 0; empty: every `step`
    saved: bool = False  # the state is saved after every communication step but never restored
    by_energy: bool = False  # a long run without inputs is judged by its energy, not its states

    @property
    def grid(self) -> Array:
        """Communication points [s], including 0 and `stop`; shape (points,)."""
        return np.array([0.0, *self.times]) if self.times else grid(self.stop, self.step)

    @property
    def jumps(self) -> bool:
        """Whether an input jumps at every communication point."""
        return any(isinstance(value, Jumps) for value in self.inputs.values())

    def samples(self) -> list[int]:
        """Return the indices of the communication points, except the start, at which states are compared."""
        count = len(self.grid) - 1
        every = -(-count // MAX_SAMPLES)
        return sorted({*range(every, count + 1, every), count})


def case_of(source: str | Path, inputs: Mapping[str, float] | None = None) -> Case:
    """Return a scene file as a test case: its own experiment, 20 samples, constant inputs.

    Args:
        source: Path of the scene file.
        inputs: Values of inputs by name; the others are 0.

    Raises:
        SceneError: the scene is invalid.
        OSError: the file cannot be read.
        UsageError: the scene does not have one of the inputs.
    """
    scene = gelenk.load(source)
    known = [s.name for s in gelenk.Simulation(scene).inputs]
    faults = [unknown(name, "input", known) for name in inputs or {} if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    return Case(Path(source).stem, "", scene.to_dict(), scene.stop, scene.stop / SAMPLES, dict(inputs or {}))
