# SPDX-License-Identifier: BSD-3-Clause
"""FMUs on Windows (Wine) and 64-bit ARM (QEMU): the results of linux64, and states that change machines.

`make platforms` runs these tests; `make runtimes` builds what they need.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import gelenk

from .machines import ARM, HERE, HERE_ITSELF, OTHERS, WINDOWS, Life, Machine, Plant, extracted, host

pytestmark = pytest.mark.platforms

SCENES = sorted((HERE.parents[1] / "scenes").glob("*.yaml"))
# Ends of runs [s] where rounding alone changes results by more than the bound: a test below shows it here.
# Differences of start values grow by a factor of 10,600 over the run of the five-bar and 390 up to 1.4 s, of
# 7300 over the run of the body that tumbles about its middle axis and 1800 up to 10 s (tolerance 1e-13).
# Rounding changes the steps that error control chooses, i.e. results by a fraction of the tolerance, and that
# grows in the same way: start values that differ by 1e-15 changed the five-bar by up to 212 times 1e-8 (150
# runs), the body by up to 38,600 times 1e-10 (40 runs).
ENDS = {"five_bar": 1.4, "free_body": 10.0}
WORST = {"five_bar": 1e-8, "free_body": 1e-10}  # tolerances at which these scenes differ most
STEPS = 50


@pytest.fixture(scope="session")
def plants(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Plant]:
    folder = tmp_path_factory.mktemp("a room, Ünïcode")
    wanted = ["linux64", *(m.platform for m in (WINDOWS, ARM) if not m.missing)]
    return {
        scene.stem: extracted(
            gelenk.export_fmu(gelenk.load(scene), folder / f"{scene.stem}.fmu", wanted, view=False),
            folder / scene.stem,
        )
        for scene in SCENES
    }


@pytest.mark.parametrize("machine", OTHERS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.stem)
def test_outputs_are_those_of_linux64_and_states_change_machines(
    scene: Path, tolerance: float, machine: Machine, plants: dict[str, Plant], hosts: Path, wine: Path,
    tmp_path: Path,
) -> None:  # fmt: skip
    """Within 100 times the tolerance, relative to the largest value: both integrate with this tolerance.

    A state saved there in the middle goes on here, and the other way round, as it would have at home.
    """
    stop = ENDS.get(scene.stem, gelenk.load(scene).stop)
    life = Life(tolerance, stop, STEPS)
    assert life.differences(plants[scene.stem], machine, hosts, wine, tmp_path) < 100 * tolerance


def run_here(scene: Path, tolerance: float, stop: float, seed: int | None) -> NDArray[np.float64]:
    """What `life_host` prints, without an FMU. seed: start values differ by up to 1e-15."""
    data = gelenk.load(scene).to_dict()
    data["experiment"]["tolerance"] = tolerance
    if seed is not None:
        rng = np.random.default_rng(seed)
        for joint in data["joints"].values():
            start = joint.get("start", {})
            for key in start.keys() - {"fixed", "weight"}:
                value = np.asarray(start[key], float)
                start[key] = (value + 1e-15 * rng.uniform(-1, 1, value.shape)).tolist()
    plant = gelenk.Simulation(gelenk.load(data))
    names = [output.name for output in plant.outputs]
    rows = []
    for k in range(STEPS):
        for given in plant.inputs[:1]:
            plant.set_input(given.name, 0.1 * (k // 10 % 3 - 1))
        if k == 0:
            plant.initialize()
        plant.step_to((k + 1) * stop / STEPS)
        rows.append(plant.values(names))
    return np.array(rows)


@pytest.mark.parametrize("name", ENDS)
def test_runs_end_early_only_where_rounding_alone_exceeds_the_bound(name: str) -> None:
    """Start values that differ by 1e-15: over the whole run some differ by more, up to the early end none."""
    (scene,) = (scene for scene in SCENES if scene.stem == name)
    largest = {}
    for stop in (gelenk.load(scene).stop, ENDS[name]):
        plain = run_here(scene, WORST[name], stop, None)
        scale = 1 + np.abs(plain).max(axis=0)
        runs = (run_here(scene, WORST[name], stop, seed) for seed in range(150 if name == "five_bar" else 10))
        largest[stop] = max((np.abs(run - plain) / scale).max() / WORST[name] for run in runs)
    whole, cut = largest.values()
    assert whole > 100
    assert cut < 100 / 2  # both of two compilers round


@pytest.mark.parametrize("machine", OTHERS)
def test_the_host_with_many_instances_is_content(
    machine: Machine, plants: dict[str, Plant], hosts: Path, wine: Path
) -> None:
    """The same as on Linux: instances in turns and in threads, states, wrong calls."""
    plant, tasks = plants["four_bar"], ["crowd=20", "threads=4", "states=3", "wrong=3"]
    said = {
        where.platform: where.output(
            host("multithreaded_host", where, hosts), [*plant.on(where), *tasks], wine
        ).splitlines()
        for where in (HERE_ITSELF, machine)
    }
    assert said[machine.platform][:3] == ["crowd 20", "threads 4", "states 3"]
    assert said[machine.platform] == said["linux64"]


@pytest.mark.parametrize("machine", OTHERS)
def test_a_program_ends_after_the_library_was_unloaded(
    machine: Machine, plants: dict[str, Plant], hosts: Path, wine: Path
) -> None:
    """Nothing of the library is called where it no longer is; on ARM, all programs crashed at their end."""
    for where in (HERE_ITSELF, machine):
        arguments = [*plants["four_bar"].on(where), "5"]
        said = where.output(host("unload_host", where, hosts), arguments, wine)
        assert said.split() == ["5", "cycles", "end"]
