# SPDX-License-Identifier: BSD-3-Clause
"""What is run: a scene, for how long, with which inputs, and against which truth."""

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

MOST_SAMPLES = 1000
SAMPLES = 20  # of a scene whose inputs never jump: few, for each cuts an integrator's step


@dataclass(frozen=True)
class Jumps:
    """Another value at every communication step, the same at every run: mean + amplitude x in [-1, 1],
    x by the golden ratio (Weyl's sequence), so that neighbours differ and nothing repeats.
    """

    mean: float
    amplitude: float

    def at(self, k: int) -> float:
        """The value held from communication step k on."""
        return self.mean + self.amplitude * (2.0 * ((k + 1) * 0.6180339887498949 % 1.0) - 1.0)


@dataclass(frozen=True)
class Smooth:
    """mean + amplitude sin(rate t), given at the start of each communication step with three time
    derivatives, so that within the step the input is a cubic polynomial.
    """

    mean: float
    amplitude: float
    rate: float  # rad/s

    def at(self, t: float) -> tuple[float, ...]:
        """Value and derivatives of orders 1 to 3 at t [s]."""
        waves = (self.amplitude * self.rate**n * math.sin(self.rate * t + n * math.pi / 2) for n in range(4))
        first, *others = waves
        return self.mean + first, *others


@dataclass(frozen=True)
class Case:
    """A run that every method is put through. Times in s."""

    name: str
    about: str
    scene: dict[str, Any]
    stop: float
    step: float  # communication step
    inputs: Mapping[str, float | Jumps | Smooth] = field(default_factory=dict)
    #: Joint states in closed form by output name, from the times; None: integrated, see `reference`.
    truth: Callable[[Array], dict[str, Array]] | None = None
    #: Published joint states (time, output, value) that a reference is checked against, and their source.
    published: tuple[tuple[float, str, float], ...] = ()
    source: str = ""
    expected: str = "good"  # or "refused": where equations have no solution
    times: tuple[float, ...] = ()  # communication points without 0; empty: every `step`
    saved: bool = False  # the state is saved after every communication step, and never restored
    by_energy: bool = False  # a run without a drive so long that its phase says little: its energy is judged

    @property
    def grid(self) -> Array:
        """Communication points [s], 0 and `stop` included."""
        return np.array([0.0, *self.times]) if self.times else grid(self.stop, self.step)

    @property
    def jumps(self) -> bool:
        """An input jumps at every communication point."""
        return any(isinstance(value, Jumps) for value in self.inputs.values())

    def samples(self) -> list[int]:
        """Communication points at which states are compared, by index; the start is not one of them."""
        count = len(self.grid) - 1
        every = -(-count // MOST_SAMPLES)
        return sorted({*range(every, count + 1, every), count})


def case_of(source: str | Path, inputs: Mapping[str, float] | None = None) -> Case:
    """A scene file as a case: its own experiment, sampled 20 times, its inputs constant.

    Raises:
        SceneError, OSError: the scene is wrong.
        UsageError: an input that it does not have.
    """
    scene = gelenk.load(source)
    known = [s.name for s in gelenk.Simulation(scene).inputs]
    faults = [unknown(name, "input", known) for name in inputs or {} if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    return Case(Path(source).stem, "", scene.to_dict(), scene.stop, scene.stop / SAMPLES, dict(inputs or {}))
