# SPDX-License-Identifier: BSD-3-Clause
"""LQR controllers designed on linear models stabilize the nonlinear FMU, run by fmpy, after disturbances."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import control
import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from mechanisms import Scene
from models.differences import Array
from models.linear_plants import furuta, still_cart_pole

import gelenk
from gelenk.chart import mechanisms

SAMPLE = 1e-3  # s


@contextmanager
def instance(fmu: Path, start: Mapping[str, float], folder: Path) -> Iterator[tuple[Any, dict[str, int]]]:
    """An initialized slave of fmpy and its value references by name."""
    description = fmpy.read_model_description(str(fmu))
    unpacked = fmpy.extract(str(fmu), str(folder / "unpacked"))
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=unpacked,
        modelIdentifier=description.coSimulation.modelIdentifier, instanceName="plant",
    )  # fmt: skip
    refer = {v.name: v.valueReference for v in description.modelVariables}
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal([refer[f"{name}_start"] for name in start], list(start.values()))
    slave.exitInitializationMode()
    try:
        yield slave, refer
    finally:
        slave.freeInstance()
        shutil.rmtree(unpacked)


@dataclass(frozen=True)
class Control:
    make: Callable[[], Scene]
    at: Mapping[str, float]  # operating point of the design
    disturbed: Mapping[str, float]  # disturbed initial state
    weights: tuple[list[float], list[float]]  # of states and of inputs
    stop: float  # s
    late: float  # s, time after which only the slowest mode is left
    limit: float  # bound on the first coordinate named in `disturbed`


# With these weights one real pole is at least three times slower than the next: its decay can be measured.
CASES = {
    "cart-pole": Control(
        still_cart_pole, {"hinge.phi": 0.0}, {"hinge.phi": 0.35, "track.s": 0.2},
        ([10.0, 1.0, 10.0, 1.0], [0.1]), stop=12.0, late=6.0, limit=0.5,
    ),
    "Furuta pendulum": Control(
        furuta, {"tip.phi": 0.0}, {"tip.phi": 0.3, "pillar.phi": 0.4},
        ([1.0, 1.0, 3.0, 0.1], [10.0]), stop=20.0, late=10.0, limit=0.5,
    ),
    "five-bar": Control(
        lambda: mechanisms.shipped("five_bar"), {}, {"left.phi": 2.5, "right.phi": 1.1},
        ([1.0, 12.0, 0.3, 0.3], [10.0, 10.0]), stop=6.0, late=3.0, limit=2.6,
    ),
}  # fmt: skip


def closed_loop(case: Control, fmu: Path, K: Array, states: list[str], x0: Array, folder: Path) -> Array:
    """States minus x0 at every sample: shape (samples, states)."""
    rows = []
    with instance(fmu, case.disturbed, folder) as (slave, refer):
        description = fmpy.read_model_description(str(fmu))
        inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
        for k in range(round(case.stop / SAMPLE)):
            x = np.array(slave.getReal([refer[name] for name in states])) - x0
            rows.append(x)
            slave.setReal(inputs, list(-K @ x))
            slave.doStep(k * SAMPLE, SAMPLE)
    return np.array(rows)


@pytest.mark.parametrize("name", CASES)
def test_lqr_damps_a_large_disturbance(name: str, tmp_path: Path) -> None:
    """The final decay rate is that of the slowest pole within 5 %; only the FMU's linear model is used."""
    case = CASES[name]
    fmu = gelenk.export_fmu(case.make(), tmp_path / "plant.fmu")
    linear = gelenk.linearize(fmu, at=case.at, outputs=[])
    states = list(linear.names.states)
    Q, R = (np.diag(w) for w in case.weights)
    K, _, poles = control.lqr(linear, Q, R)
    start = gelenk.simulate(
        fmu, stop=0, parameters={f"{n}_start": v for n, v in case.at.items()}, outputs=states
    )
    x0 = np.array([start[n][0] for n in states])
    x = closed_loop(case, fmu, K, states, x0, tmp_path)
    assert np.abs(x[0]).max() > 0.1  # rad or m: the disturbance is not small
    assert np.abs(x + x0)[:, states.index(next(iter(case.disturbed)))].max() < case.limit
    slow = np.sort(np.abs(poles.real))
    slowest = poles[np.argmin(np.abs(poles.real))]
    assert slowest.imag == 0
    assert slow[1] > 3 * slow[0]
    late = round(case.late / SAMPLE)
    size = np.linalg.norm(x[late:], axis=1)
    assert 1e-9 < size.min() < size.max() < 1e-2  # in the linear range, and above the integration errors
    decay = -np.polyfit(SAMPLE * np.arange(len(size)), np.log(size), 1)[0]
    assert decay == pytest.approx(slow[0], rel=0.05)


def test_without_control_the_pole_falls(tmp_path: Path) -> None:
    """The disturbance of the test above, without a control force."""
    case = CASES["cart-pole"]
    fmu = gelenk.export_fmu(case.make(), tmp_path / "plant.fmu")
    linear = gelenk.linearize(fmu, at=case.at, outputs=[])
    x = closed_loop(case, fmu, np.zeros((1, 4)), list(linear.names.states), np.zeros(4), tmp_path)
    assert np.abs(x[:, 1]).max() > math.pi / 2
