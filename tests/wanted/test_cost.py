# SPDX-License-Identifier: BSD-3-Clause
"""One island of two hundred costs what it costs alone."""

from __future__ import annotations

import functools
import math
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from many_islands import many_islands

import gelenk
from gelenk.model.inspection import evaluation_cost

COUNT = 200
MARGIN = 1.2  # of CPU times: where data come to lie, and what else the machine does


def cpu(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def compared(one: Callable[[], object], other: Callable[[], object]) -> float:
    """CPU time of `one` by that of `other`, the least of up to 40 turns each."""
    least = [math.inf, math.inf]
    for _ in range(40):
        for i, work in enumerate((one, other)):
            least[i] = min(least[i], sum(cpu(work) for _ in range(10)))
        if least[0] <= MARGIN * least[1]:
            break
    return least[0] / least[1]


def sources(k: int) -> tuple[gelenk.Scene, gelenk.Scene]:
    wanted = gelenk.load(many_islands(COUNT)).with_outputs([f"i{k}_*"])
    return wanted, gelenk.load(many_islands(COUNT, only=k))


@pytest.mark.clock
@pytest.mark.parametrize("k", range(5))
def test_start_and_steps_take_the_same_time(k: int) -> None:
    plants = [gelenk.Simulation(source) for source in sources(k)]
    assert compared(plants[0].initialize, plants[1].initialize) <= MARGIN
    for plant in plants:
        plant.initialize()
    ends = [0.0, 0.0]

    def step(i: int) -> None:
        ends[i] += 1e-3
        plants[i].step_to(ends[i])

    assert compared(lambda: step(0), lambda: step(1)) <= MARGIN


@pytest.mark.parametrize("k", range(6))
def test_counts_and_sizes_are_the_same(k: int) -> None:
    diagnostics = []
    for source in sources(k):
        plant = gelenk.Simulation(source)
        plant.initialize()
        plant.step_to(0.3)
        diagnostics.append(plant.diagnostics)
        assert plant.size.islands == 1
    assert diagnostics[0] == diagnostics[1]


@pytest.mark.clock
def test_evaluation_of_the_whole_costs_more() -> None:
    """So the comparisons above could fail: two hundred islands take at least twenty times as long as one."""
    wanted, _ = sources(0)
    whole, part = evaluation_cost(wanted, ["outputs"]).seconds, evaluation_cost(wanted).seconds
    assert (whole or 0.0) > 20 * (part or math.inf)


def test_fmu_is_as_large(tmp_path: Path) -> None:
    """The FMU also says what is wanted, and the size of the rest: some 400 bytes."""
    sizes = []
    for source in sources(0):
        with zipfile.ZipFile(gelenk.export_fmu(source, tmp_path / "x.fmu")) as archive:
            sizes.append(sum(member.file_size for member in archive.infolist()))
    assert abs(sizes[0] - sizes[1]) < 1000


@pytest.mark.clock
def test_fmu_is_made_as_fast(tmp_path: Path) -> None:
    wanted, alone = sources(0)
    least = [math.inf, math.inf]
    for _ in range(10):
        for i, source in enumerate((wanted, alone)):
            out = tmp_path / "again.fmu"
            least[i] = min(least[i], cpu(functools.partial(gelenk.export_fmu, source, out)))
        if least[0] <= MARGIN * least[1]:
            break
    assert least[0] <= MARGIN * least[1]


def test_unwanted_outputs_of_an_island_cost_nothing() -> None:
    """They are computed when they are read; the same steps and evaluations to the last one."""
    counts = []
    for outputs in (["i3_P.phi"], ["i3_*"]):
        plant = gelenk.Simulation(gelenk.load(many_islands(COUNT)).with_outputs(outputs))
        plant.initialize()
        plant.step_to(0.3)
        plant.values(["i3_P.phi"])
        counts.append(plant.diagnostics["solver.evaluations"])
    assert counts[0] == counts[1] > 0
