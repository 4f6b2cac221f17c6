# SPDX-License-Identifier: BSD-3-Clause
"""Four inertias in a row with three clutches, as in CoupledClutches of the Modelica Standard Library.

The reference goes from event to event with SciPy; at each one it looks through all modes of the three
clutches for those that are consistent.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
import warned
from mechanisms import Array, Scene, body, frame, joint, scene
from models.running import assert_close
from scipy.integrate import solve_ivp

import gelenk

pytestmark = warned.TIGHT

INERTIAS = np.array([1.0, 1.2, 0.8, 1.5])  # kg m2
SLIDING, STATIC = 10.0, 11.0  # N m, of each clutch fully engaged
SEGMENT = 0.1  # s; within each, inputs are linear
SEGMENTS = 15
REST = 1e-9  # rad/s: what is slower than this may stick

type Modes = tuple[int, ...]


def inputs(t: float) -> Array:
    """Return the torque on the first inertia, and the engagements of the clutches."""
    return np.array([
        10 * np.sin(10 * t),
        abs(np.cos(1.3 * t)),
        1.0 if t > 0.35 else 0.05,
        min(1.0, max(0.05, 2 * (t - 0.8))),
    ])  # fmt: skip


def at(t: float, k: int) -> Array:
    """Return the inputs at t in segment k: linear between the values at its ends."""
    start, end = inputs(k * SEGMENT), inputs((k + 1) * SEGMENT)
    return start + (end - start) * (t - k * SEGMENT) / SEGMENT


def torques(modes: Modes, given: Array) -> tuple[Array, Array]:
    """Return the torques of the clutches on their later inertia, and the accelerations.

    modes: by clutch, 1 and -1: it slips with a positive and a negative speed of the later inertia relative to
    the earlier one; 0: it sticks.
    """
    apart = np.diff(np.eye(4), axis=0)  # slips of unit speeds
    mobility = np.diag(1 / INERTIAS)
    found = -np.array(modes) * SLIDING * given[1:]
    stuck = [i for i in range(3) if modes[i] == 0]
    load = np.array([given[0], 0, 0, 0])
    if stuck:
        free = apart @ mobility @ (load + apart.T @ found)
        W = apart @ mobility @ apart.T
        found[stuck] = -np.linalg.solve(W[np.ix_(stuck, stuck)], free[stuck])
    return found, mobility @ (load + apart.T @ found)


def consistent(speeds: Array, given: Array) -> Iterator[Modes]:
    """Yield the modes that can follow."""
    choices = [[int(np.sign(s))] if abs(s) > 3 * REST else [0, 1, -1] for s in np.diff(speeds)]
    for modes in itertools.product(*choices):
        found, rates = torques(modes, given)
        apart = np.diff(rates)
        if all(
            abs(found[i]) <= given[1 + i] * STATIC * (1 + 1e-12)
            if modes[i] == 0
            else abs(np.diff(speeds)[i]) > 3 * REST or apart[i] * modes[i] > 0
            for i in range(3)
        ):
            yield modes


@dataclass
class Indicator:
    """Ends the integration where it becomes negative."""

    value: Callable[[float, Array], float]
    terminal: bool = True
    direction: float = -1

    def __call__(self, t: float, w: Array) -> float:
        return self.value(t, w)


def next_event(t: float, end: float, w: Array, modes: Modes, k: int) -> tuple[float, Array]:
    """Integrate in one set of modes to its end, or to the end of the segment."""

    def slips(i: int) -> Indicator:
        return Indicator(lambda _, w: float(modes[i] * (w[i + 1] - w[i]) + REST))

    def holds(i: int) -> Indicator:
        def value(t: float, _: Array) -> float:
            given = at(t, k)
            return float(given[1 + i] * STATIC * (1 + 1e-12) - abs(torques(modes, given)[0][i]))

        return Indicator(value)

    events = [slips(i) if modes[i] else holds(i) for i in range(3)]
    run = solve_ivp(
        lambda t, _: torques(modes, at(t, k))[1], (t, end), w, "DOP853", rtol=1e-13, atol=1e-13,
        events=events, max_step=0.01,
    )  # fmt: skip
    found = run.y[:, -1].copy()
    for i in range(3):
        if abs(found[i + 1] - found[i]) < 2 * REST:
            found[i + 1] = found[i]
    return float(run.t[-1]), found


@cache
def reference() -> tuple[Array, int]:
    """Return the speeds at the ends of the segments, and the number of changes of modes."""
    w = np.array([10.0, 0.0, 0.0, 0.0])
    out, changes = [w], 0
    modes: Modes | None = None
    for k in range(SEGMENTS):
        t, end = k * SEGMENT, (k + 1) * SEGMENT
        while t < end - 1e-12:
            after = t + 1e-9  # where an event at t has happened
            possible = list(consistent(w, at(after, k)))
            # What breaks away does so with the least number of clutches that begin to slip.
            chosen = modes if modes in possible else max(possible, key=lambda m: m.count(0))
            changes += sum(a != b for a, b in zip(modes or chosen, chosen, strict=True))
            modes = chosen
            t, w = next_event(t, end, w, modes, k)
        out.append(w)
    return np.array(out), changes


def drive_line() -> Scene:
    names = ["one", "two", "three", "four"]
    friction = {"coulomb": SLIDING, "static": STATIC, "input": "engagement"}
    joints = {
        "shaft": joint("revolute", frame("ground"), frame("one"), start={"phi": 0, "w": 10.0, "fixed": True})
    }
    slips = {2: -10.0, 3: 0.0, 4: 0.0}
    for k in (2, 3, 4):
        joints[f"clutch{k - 1}"] = joint(
            "revolute", frame(names[k - 2]), frame(names[k - 1]), friction=friction,
            start={"phi": 0, "w": slips[k], "fixed": True},
        )  # fmt: skip
    return scene(
        {name: body(1, inertia=(0, 0, J)) for name, J in zip(names, INERTIAS, strict=True)},
        joints,
        motors={"torque": {"joint": "shaft"}},
    )


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ["erk", "cvode", "ida", "dirk"])
def test_coupled_clutches(integrator: str, tolerance: float) -> None:
    """Clutches lock, break away and lock again while others change; inputs are linear in each segment."""
    expected, changes = reference()
    simulation = gelenk.Simulation({**drive_line(), "solver": {"integrator": integrator}})
    names = ["torque.tau", *(f"clutch{i}.friction.engagement" for i in (1, 2, 3))]
    for k in range(SEGMENTS):
        start, end = inputs(k * SEGMENT), inputs((k + 1) * SEGMENT)
        for name, value, later in zip(names, start, end, strict=True):
            simulation.set_input(name, value)
            simulation.set_input_derivative(name, 1, (later - value) / SEGMENT)
        if k == 0:
            simulation.initialize(0.0, tolerance)
        simulation.step_to((k + 1) * SEGMENT)
        speeds = np.cumsum([simulation.output(f"{n}.w") for n in ("shaft", "clutch1", "clutch2", "clutch3")])
        bound = 100 * max(tolerance, 1e-9 if integrator in ("cvode", "ida") else 0)
        assert_close(f"speeds in segment {k}", speeds, expected[k + 1], bound, "100 times the tolerance")
    assert changes == 5
    assert simulation.diagnostic("solver.events") == changes
