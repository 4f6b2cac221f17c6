# SPDX-License-Identifier: BSD-3-Clause
"""What fuzzing has found so far, given again to what is shipped: the seeds of `make fuzz`, without clang.

tests/fuzz/*.cpp says what must hold. A seed that ends the process takes pytest's worker with it; pytest then
names the test, and so the seed. Readers are those of the package and of the FMU; the YAML reader in C++ is in
gelenk-export only and is left to the fuzzer.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from ctypes import c_void_p
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from fmu.host import ERROR, Fmu, Slave
from fmu.states import deserialize
from looped import looped
from mechanisms import four_bar

import gelenk
from gelenk import _core

from .states import Host, fuzzed, plants, seed_name

HERE = Path(__file__).parent


def seeds(fuzzer: str) -> list[str]:
    return sorted(path.name for path in (HERE / "corpus" / fuzzer).iterdir())


def content(fuzzer: str, seed: str) -> bytes:
    return (HERE / "corpus" / fuzzer / seed).read_bytes()


def test_every_fuzzer_has_seeds() -> None:
    fuzzers = {path.stem for path in HERE.glob("*.cpp")}
    assert (
        fuzzers == {path.name for path in (HERE / "corpus").iterdir()} == {*SCENES, "fmu_state", "expression"}
    )
    assert all(len(seeds(fuzzer)) > 50 for fuzzer in fuzzers)


# --- expressions ---


@pytest.mark.parametrize("seed", seeds("expression"))
def test_texts_are_expressions_or_mistakes(seed: str) -> None:
    """As the force of a joint, of which a step is made."""
    text = content("expression", seed).decode("utf-8", "replace")
    source = four_bar()
    source["joints"]["A"]["law"] = {"effort": text}
    with suppress(gelenk.GelenkError):
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-6)
        simulation.step_to(1e-3)


# --- scenes ---

SCENES = {"scene_json": "scene.json", "scene_yaml": "scene.yaml"}
EVERY = [(fuzzer, seed) for fuzzer in SCENES for seed in seeds(fuzzer)]


def read(path: Path) -> gelenk.Scene | None:
    """The scene; None where it is refused, in words that name the file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.SceneWarning)  # of numbers that are hardly meant
        try:
            return gelenk.load(path)
        except gelenk.SceneError as error:
            said = str(error)
    assert all(line.startswith((str(path), "  ")) for line in said.splitlines()), said
    return None


@pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")
@looped(("fuzzer", "seed"), EVERY)
def test_scenes_are_refused_or_come_back_the_same(fuzzer: str, seed: str, tmp_path: Path) -> None:
    path = tmp_path / SCENES[fuzzer]
    path.write_bytes(content(fuzzer, seed))
    scene = read(path)
    if scene is not None:
        first = _core.write_scene_json(scene._core)
        assert _core.write_scene_json(_core.read_scene_json(first, "first.json")) == first
        assert gelenk.load(scene.to_dict()).to_dict() == scene.to_dict()


@pytest.mark.parametrize("fuzzer", SCENES)
def test_seeds_of_scenes_are_of_both_kinds(fuzzer: str, tmp_path: Path) -> None:
    """Else a reader that refuses everything passed all of the above."""
    path = tmp_path / SCENES[fuzzer]
    taken = 0
    for seed in seeds(fuzzer):
        path.write_bytes(content(fuzzer, seed))
        taken += read(path) is not None
    assert 5 < taken < len(seeds(fuzzer)) - 5


# --- states, and scenes, of FMUs ---


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Fmu]:
    """FMUs of the fuzzed plants."""
    folder = tmp_path_factory.mktemp("fuzzed")
    return cache(lambda plant: fuzzed(plant, folder))


@pytest.fixture(scope="module")
def hosts(exported: Callable[[str], Fmu]) -> Callable[[int], Host]:
    names = plants()
    made = cache(lambda which: Host(exported(names[which])))
    return lambda byte: made(byte % len(names))


@looped("seed", seeds("fmu_state"))
def test_a_plant_finds_home_after_any_state(seed: str, hosts: Callable[[int], Host]) -> None:
    """To the bit, whether the state was taken or refused."""
    which, *_ = words = content("fmu_state", seed)
    host = hosts(which)
    state = c_void_p()
    assert deserialize(host.slave, words[1:], state) == ERROR  # its head is none
    host.given(words[1:])
    assert host.go_home() == host.expected


def test_seeds_of_states_are_of_both_kinds(hosts: Callable[[int], Host]) -> None:
    given = [content("fmu_state", seed) for seed in seeds("fmu_state")]
    taken = [hosts(data[0]).given(data[1:]) for data in given]
    assert 5 < sum(taken) < len(taken) - 5
    assert sum(hosts(which).stepped for which in {data[0] for data in given}) > 5


@pytest.mark.parametrize("plant", plants())
def test_seeds_of_states_are_of_today(plant: str, hosts: Callable[[int], Host]) -> None:
    """Else they all would be refused by their length: `make states` writes them anew."""
    data = content("fmu_state", seed_name(plant, "whole"))
    host = hosts(data[0])
    assert host.given(data[1:], steps=1)
    # Compilers round otherwise; ten short steps under tolerances of 1e-6 make less of it.
    np.testing.assert_allclose(host.slave.outputs(), np.frombuffer(host.expected), rtol=1e-6, atol=1e-6)


@looped("seed", seeds("scene_json"))
def test_fmus_refuse_any_bytes_for_their_scene(
    seed: str, exported: Callable[[str], Fmu], tmp_path: Path
) -> None:
    """The native reader gets them undecoded. No seed is the scene of this GUID."""
    (tmp_path / "scene.json").write_bytes(content("scene_json", seed))
    slave = Slave(exported("four_bar/auto"), resources=tmp_path.as_uri())
    assert not slave.component
    assert slave.said.startswith("fmi2Instantiate: "), slave.said
