# SPDX-License-Identifier: BSD-3-Clause
"""What sweeps add to the cost of their steps; `make clocks` runs these on an idle machine."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk

pytestmark = pytest.mark.clock

RUNS = 2000
STEPS = 1000


@pytest.fixture
def scene(four_bar: gelenk.Scene) -> gelenk.Scene:
    return four_bar.with_parameters({"solver.integrator": "rk4"})


def study(scene: gelenk.Scene, **options: Any) -> Any:
    parameters = {"crank.m": np.linspace(0.9, 1.1, RUNS), "drive.tau": 3.0}
    return gelenk.sweep(scene, parameters, outputs={"A.phi": "max"}, stop=1.0, step=1e-3, **options)


def test_a_sweep_has_four_fifths_of_the_throughput_of_its_steps(scene: gelenk.Scene) -> None:
    """The steps alone: a loop of compiled code, over and over from the same state."""
    plant = gelenk.Simulation(scene.with_outputs(["A.phi"]))
    plant.set_input("drive.tau", 3.0)
    plant.initialize()
    saved = plant.save()
    channels = plant.channels(["drive.tau"], [], ["A.phi"])
    times, torque, rows = np.linspace(0, 1, STEPS + 1), np.full((STEPS, 1), 3.0), np.empty((STEPS, 1))

    def steps() -> float:
        start = time.process_time()
        for _ in range(RUNS // 4):
            plant.restore(saved)
            plant._core.record(channels, times, torque, rows, 0.0)
        return 4 * (time.process_time() - start)

    before = steps()
    start = time.process_time()
    study(scene)
    taken = time.process_time() - start
    alone = (before + steps()) / 2  # the speed of the machine changes
    assert alone / taken >= 0.8


def test_a_cluster_adds_less_than_a_twentieth(scene: gelenk.Scene) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        study(scene, cluster=client)  # imports
        walls: dict[bool, list[float]] = {}
        for where in (None, client, None, client):
            start = time.perf_counter()
            study(scene, cluster=where, workers=1)
            walls.setdefault(where is None, []).append(time.perf_counter() - start)
    assert min(walls[False]) <= 1.05 * min(walls[True])


def test_environments_reset_in_microseconds(root: Path) -> None:
    pytest.importorskip("gymnasium")
    env = gelenk.environment(
        root / "scenes" / "cart_pole.yaml", actions={"drive.f": (-1.0, 1.0)}, observations=["hinge.phi"],
        reward=lambda *_: 0.0,
    )  # fmt: skip
    start = time.process_time()
    for _ in range(1000):
        env.reset()
    assert (time.process_time() - start) / 1000 < 50e-6
