# SPDX-License-Identifier: BSD-3-Clause
"""What fuzzing has found so far, given again to what is shipped: the seeds of `make fuzz`, without clang.

tests/fuzz/*.cpp says what must hold. A seed that ends the process takes pytest's worker with it; pytest then
names the test, and so the seed. Readers are those of the package and of the FMU; the YAML reader in C++ is in
gelenk-export only and is left to the fuzzer.
"""

from __future__ import annotations

import ctypes
import json
import re
import struct
import warnings
from collections.abc import Callable, Iterator
from ctypes import c_double, c_int, c_size_t, c_void_p
from functools import cache
from pathlib import Path

import fmpy
import pytest
from fmu.host import ERROR, LAST_SUCCESSFUL_TIME, OK, Fmu, Slave
from fmu.states import checksum, deserialize, get_state, serialized, set_state

import gelenk
from gelenk import _core

HERE = Path(__file__).parent
HEAD = 64  # bytes before the words of a serialized state
PART = 8 * 16  # bytes: 16 words
STEP = 1e-3  # s, as size_of_step of fmu_state.cpp


def seeds(fuzzer: str) -> list[str]:
    return sorted(path.name for path in (HERE / "corpus" / fuzzer).iterdir())


def content(fuzzer: str, seed: str) -> bytes:
    return (HERE / "corpus" / fuzzer / seed).read_bytes()


def test_every_fuzzer_has_seeds() -> None:
    fuzzers = {path.stem for path in HERE.glob("*.cpp")}
    assert fuzzers == {path.name for path in (HERE / "corpus").iterdir()} == {*SCENES, "fmu_state"}
    assert all(len(seeds(fuzzer)) > 50 for fuzzer in fuzzers)


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


@pytest.mark.parametrize(("fuzzer", "seed"), EVERY)
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


def integrators() -> list[str]:
    """By a state's first byte, as fmu_state.cpp has them."""
    text = (HERE / "fmu_state.cpp").read_text("utf-8")
    (names,) = re.findall(r"std::array integrators = \{([^}]+)\}", text)
    return re.findall(r'"([\w-]+)"', names)


class Host:
    """An instance that has made some steps, with a state to go back to, and the outputs
    of the step after it.
    """

    def __init__(self, fmu: Fmu) -> None:
        self.slave = Slave(fmu)
        self.stepped = 0  # steps from states of others
        assert self.slave.set_real(drive__tau=0.5) == OK
        self.slave.start()
        for k in range(5):
            assert self.slave.step(k * STEP, STEP) == OK, self.slave.said
        self.home = get_state(self.slave)
        whole = serialized(self.slave, self.home)
        self.head, self.words = (
            whole[: HEAD - 8],
            whole[HEAD:-8],
        )  # less the number of words, and the checksum
        self.expected = self.go_home()

    def go_home(self) -> bytes:
        set_state(self.slave, self.home)
        assert self.slave.step(5 * STEP, STEP) == OK, self.slave.said
        return struct.pack(f"{len(row := self.slave.outputs())}d", *row)

    def given(self, words: bytes) -> bool:
        """Whether these words of a state were taken, under a head and a checksum that are right."""
        state = c_void_p()
        inside = self.head + struct.pack("<Q", len(words) // 8) + words
        assert deserialize(self.slave, inside + struct.pack("<Q", checksum(inside)), state) == OK, (
            self.slave.said
        )
        self.slave.log.clear()
        status = self.slave.call("fmi2SetFMUstate", state)
        assert status in (OK, ERROR)
        if status == OK:
            for _ in range(2):
                self.stepped += self.slave.step(self.time(), STEP) == OK
            self.look()
        else:
            assert self.slave.said.startswith("fmi2SetFMUstate: "), self.slave.said
        assert self.slave.call("fmi2FreeFMUstate", ctypes.byref(state)) == OK
        return status == OK

    def time(self) -> float:
        """Where the plant stands."""
        found = c_double()
        self.slave.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(found))
        return found.value

    def look(self) -> None:
        """Reads all outputs, whatever the plant answers."""
        names = [v.name for v in self.slave.fmu.description.modelVariables if v.causality == "output"]
        values = (c_double * len(names))()
        self.slave.call("fmi2GetReal", self.slave.references(names), c_size_t(len(names)), values)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Fmu]:
    """The fuzzed plant's FMU, by integrator."""

    @cache
    def make(integrator: str) -> Fmu:
        folder = tmp_path_factory.mktemp("fuzzed")
        data = json.loads((HERE / "four_bar.json").read_text("utf-8"))
        data["solver"]["integrator"] = integrator
        made = gelenk.export_fmu(gelenk.load(data), folder / "Fuzzed.fmu")
        return Fmu(fmpy.extract(str(made), str(folder / "extracted")))

    return make


@pytest.fixture(scope="module")
def hosts(exported: Callable[[str], Fmu]) -> Callable[[int], Host]:
    names = integrators()
    made = cache(lambda which: Host(exported(names[which])))
    return lambda byte: made(byte % len(names))


def forged(seed: bytes, whole: bytes) -> Iterator[bytes]:
    """The words of a seed, and parts of them in a whole state: what a state holds and in which order changes
    with the plant's code, and by itself a seed of older code is refused for its length.
    """
    words = seed[: len(seed) // 8 * 8]
    yield words
    for start in range(0, min(len(words), len(whole)), PART):
        part = words[start : start + PART]
        yield (whole[:start] + part + whole[start + len(part) :])[: len(whole)]


@pytest.mark.parametrize("seed", seeds("fmu_state"))
def test_a_plant_finds_home_after_any_state(seed: str, hosts: Callable[[int], Host]) -> None:
    """To the bit, whether the state was taken or refused."""
    data = content("fmu_state", seed)
    host = hosts(data[0])
    state = c_void_p()
    assert deserialize(host.slave, data[1:], state) == ERROR  # its head is none
    for words in forged(data[1:], host.words):
        host.given(words)
    assert host.go_home() == host.expected


def test_seeds_of_states_are_of_both_kinds(hosts: Callable[[int], Host]) -> None:
    given = [content("fmu_state", seed) for seed in seeds("fmu_state")]
    used = [(hosts(data[0]), data[1:]) for data in given]
    taken = [host.given(words) for host, data in used for words in forged(data, host.words)]
    assert 5 < sum(taken) < len(taken) - 5
    assert sum({host: host.stepped for host, _ in used}.values()) > 5


@pytest.mark.parametrize("seed", seeds("scene_json"))
def test_fmus_refuse_any_bytes_for_their_scene(
    seed: str, exported: Callable[[str], Fmu], tmp_path: Path
) -> None:
    """The native reader gets them undecoded. No seed is the scene of this GUID."""
    (tmp_path / "scene.json").write_bytes(content("scene_json", seed))
    slave = Slave(exported("auto"), resources=tmp_path.as_uri())
    assert not slave.component
    assert slave.said.startswith("fmi2Instantiate: "), slave.said
