# SPDX-License-Identifier: BSD-3-Clause
"""Runs scenes and compares results: the only module of these tests that calls gelenk."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gelenk

Array = NDArray[np.float64]

INTEGRATORS = ("ida", "erk")  # the adaptive ones


@dataclass(frozen=True)
class Recording:
    """Every output and diagnostic at every requested time."""

    time: Array
    values: dict[str, Array]
    units: dict[str, str]

    def __getitem__(self, name: str) -> Array:
        return self.values[name]

    def vector(self, name: str) -> Array:
        """Columns name[1], name[2], ...: shape (times, elements)."""
        columns: list[Array] = []
        while f"{name}[{len(columns) + 1}]" in self.values:
            columns.append(self.values[f"{name}[{len(columns) + 1}]"])
        assert columns, f"no output {name}[1] among {sorted(self.values)}"
        return np.array(columns).T

    def joint_states(self, source: Mapping[str, Any]) -> dict[str, Array]:
        """Outputs that belong to joints, not to sensors or diagnostics."""
        names = set(source["joints"])
        return {name: value for name, value in self.values.items() if name.split(".")[0] in names}


def run(
    source: Mapping[str, Any],
    times: Array | Sequence[float],
    *,
    tolerance: float = 1e-10,
    integrator: str = "auto",
    inputs: Mapping[str, float] | None = None,
    step: float = 0.0,
    reductions: Mapping[str, bool] | None = None,
) -> Recording:
    """Run from times[0] and record at each of the times [s]. step: of fixed-step methods [s]."""
    scene = copy.deepcopy(dict(source))
    scene["solver"] = {"integrator": integrator, **({"step": step} if step else {})}
    if reductions:
        scene["solver"]["reductions"] = dict(reductions)
    simulation = gelenk.Simulation(gelenk.load(scene))
    for name, value in (inputs or {}).items():
        simulation.set_input(name, value)
    simulation.initialize(float(times[0]), tolerance)
    return record(simulation, times)


def started(source: Mapping[str, Any], **inputs: float) -> gelenk.Simulation:
    """Return a plant after initialization, with the inputs set after it;
    `motor__tau` stands for motor.tau.
    """
    simulation = gelenk.Simulation(gelenk.load(dict(source)))
    simulation.initialize()
    for name, value in inputs.items():
        simulation.set_input(name.replace("__", "."), value)
    return simulation


def record(simulation: Any, times: Iterable[float]) -> Recording:
    """Continue from the current time and record."""
    outputs = {signal.name: signal.unit for signal in simulation.outputs}
    rows = []
    health = []
    for t in times:
        if t > simulation.time:
            simulation.step_to(float(t))
        rows.append(simulation.values())
        health.append(dict(simulation.diagnostics))
    values = {name: np.array(column) for name, column in zip(outputs, zip(*rows, strict=True), strict=True)}
    values.update({name: np.array([h[name] for h in health]) for name in health[0]})
    return Recording(np.array(list(times), float), values, outputs)


def assert_close(what: str, found: Any, expected: Any, bound: float, why: str) -> None:
    """Check that the largest difference is within the bound;
    otherwise report values, difference and bound.
    """
    a, b = np.broadcast_arrays(np.asarray(found, float), np.asarray(expected, float))
    difference = np.abs(a - b)
    worst = np.unravel_index(int(np.argmax(np.where(np.isnan(difference), np.inf, difference))), a.shape)
    assert difference[worst] <= bound, (
        f"{what}: found {a[worst]:.12g}, expected {b[worst]:.12g} at {tuple(map(int, worst))}, difference "
        f"{difference[worst]:.3g} exceeds {bound:.3g} ({why})"
    )


def assert_same(first: Mapping[str, Array], second: Mapping[str, Array], bound: float, why: str) -> None:
    """Check that both contain the same signals with the same values within the bound."""
    assert set(first) == set(second)
    for name, value in first.items():
        assert_close(name, value, second[name], bound, why)


def assert_restored_run_continues(source: Any, time: float, later: Sequence[float]) -> None:
    """Check that a run restored at a time has the same bits after steps to later times after it [s]."""
    first, second = gelenk.Simulation(source), gelenk.Simulation(source)
    for simulation in (first, second):
        simulation.initialize()
    first.step_to(time)
    second.restore(first.save())
    for simulation in (first, second):
        for step in later:
            simulation.step_to(time + step)
    assert list(first.values()) == list(second.values())


def assert_continues_to_the_bit(
    source: Mapping[str, Any], saved_at: float, times: Iterable[float], tolerance: float
) -> None:
    """The run that went straight on, and twice the same from the state that was saved [s]."""
    simulation = gelenk.Simulation(dict(source))
    simulation.initialize(0.0, tolerance)
    simulation.step_to(saved_at)
    saved = simulation.save()
    times = list(times)
    ends = []
    for goes_on in (True, False, False):
        if not goes_on:
            simulation.restore(saved)
        for time in times:
            simulation.step_to(time)
        ends.append(simulation.values())
    np.testing.assert_array_equal(ends[1], ends[0])
    np.testing.assert_array_equal(ends[2], ends[0])
