# SPDX-License-Identifier: BSD-3-Clause
"""With one island of two hundred selected by the requested outputs,
a simulation costs as much as that island alone.
"""

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
MARGIN = 1.2  # of CPU times: memory placement, and other load on the machine


def cpu(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def cpu_time_ratio(one: Callable[[], object], other: Callable[[], object]) -> float:
    """CPU time of `one` divided by that of `other`, the minimum of up to 40 alternating measurements each."""
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
def test_initialization_and_steps_take_the_same_time(k: int) -> None:
    plants = [gelenk.Simulation(source) for source in sources(k)]
    assert cpu_time_ratio(plants[0].initialize, plants[1].initialize) <= MARGIN
    for plant in plants:
        plant.initialize()
    ends = [0.0, 0.0]

    def step(i: int) -> None:
        ends[i] += 1e-3
        plants[i].step_to(ends[i])

    assert cpu_time_ratio(lambda: step(0), lambda: step(1)) <= MARGIN


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
@pytest.mark.filterwarnings(
    "ignore:.*a guess with which the loops cannot be closed:gelenk.errors.StartWarning"
)
def test_evaluation_of_the_whole_scene_costs_more() -> None:
    """Verifies that the comparisons above are meaningful:
    two hundred islands take at least twenty times as long as one.
    """
    wanted, _ = sources(0)
    whole, part = evaluation_cost(wanted, ["outputs"]).seconds, evaluation_cost(wanted).seconds
    assert (whole or 0.0) > 20 * (part or math.inf)


def test_fmu_has_the_same_size(tmp_path: Path) -> None:
    """The FMU also contains the list of requested outputs and the size of the remainder: some 400 bytes."""
    sizes = []
    for source in sources(0):
        with zipfile.ZipFile(gelenk.export_fmu(source, tmp_path / "x.fmu")) as archive:
            sizes.append(sum(member.file_size for member in archive.infolist()))
    assert abs(sizes[0] - sizes[1]) < 1000


@pytest.mark.clock
def test_fmu_export_takes_the_same_time(tmp_path: Path) -> None:
    wanted, alone = sources(0)
    least = [math.inf, math.inf]
    for _ in range(10):
        for i, source in enumerate((wanted, alone)):
            out = tmp_path / "again.fmu"
            least[i] = min(least[i], cpu(functools.partial(gelenk.export_fmu, source, out)))
        if least[0] <= MARGIN * least[1]:
            break
    assert least[0] <= MARGIN * least[1]


def test_unrequested_outputs_of_an_island_cost_nothing() -> None:
    """Outputs are computed when they are read; the steps and evaluations are identical."""
    counts = []
    for outputs in (["i3_P.phi"], ["i3_*"]):
        plant = gelenk.Simulation(gelenk.load(many_islands(COUNT)).with_outputs(outputs))
        plant.initialize()
        plant.step_to(0.3)
        plant.values(["i3_P.phi"])
        counts.append(plant.diagnostics["solver.evaluations"])
    assert counts[0] == counts[1] > 0
