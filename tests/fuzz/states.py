# SPDX-License-Identifier: BSD-3-Clause
"""The seeds of fmu_state; `python -m fuzz.states` writes them anew.

What a state holds, and in which order, changes with the plant's code: of older code each would be refused for
its length. A seed is a byte, which tells the plant, and the words of a state: true ones, others forged.
"""

from __future__ import annotations

import ctypes
import json
import math
import random
import re
import struct
import tempfile
from ctypes import c_double, c_int, c_size_t, c_void_p
from pathlib import Path

import fmpy
from fmu.host import ERROR, LAST_SUCCESSFUL_TIME, OK, Fmu, Slave
from fmu.states import checksum, deserialize, get_state, serialized, set_state

import gelenk

HERE = Path(__file__).parent
SEEDS = HERE / "corpus" / "fmu_state"
HEAD = 64  # bytes before the words of a serialized state
WORD = 8  # bytes
STEP = 1e-3  # s, as size_of_step of fmu_state.cpp
SPECIAL = (
    *(struct.pack("<q", n) for n in (-1, 0, 1, 2, 7, 2**20, 2**40, -(2**63))),
    *(struct.pack("<d", x) for x in (math.nan, math.inf, -1.0, 1e-3, 1.0, 1e9, 1e300, 5e-324)),
)


def plants() -> list[str]:
    """Scenes with their integrators, by a state's first byte, as fmu_state.cpp has them."""
    text = (HERE / "fmu_state.cpp").read_text("utf-8")
    (names,) = re.findall(r"std::array plants = \{([^}]+)\}", text)
    return re.findall(r'"([\w/-]+)"', names)


def fuzzed(plant: str, folder: Path) -> Fmu:
    """The FMU of one of the plants."""
    scene, integrator = plant.split("/")
    data = json.loads((HERE / f"{scene}.json").read_text("utf-8"))
    data["solver"]["integrator"] = integrator
    made = gelenk.export_fmu(gelenk.load(data), folder / f"{scene}-{integrator}.fmu")
    return Fmu(fmpy.extract(str(made), str(folder / f"{scene}-{integrator}")))


def seed_name(plant: str, kind: str) -> str:
    """The file of a seed."""
    return f"{plant.replace('/', '-')}-{kind}"


class Host:
    """An instance that has made some steps, with a state to go back to, and the outputs
    of the step after it.
    """

    def __init__(self, fmu: Fmu) -> None:
        self.slave = Slave(fmu)
        self.stepped = 0  # steps from states of others
        assert self.drive(0.5) == OK
        self.slave.start()
        for k in range(5):
            assert self.slave.step(k * STEP, STEP) == OK, self.slave.said
        self.home = get_state(self.slave)
        whole = serialized(self.slave, self.home)
        self.head, self.words = whole[: HEAD - WORD], whole[HEAD:-WORD]  # less their number, and the checksum
        self.expected = self.go_home()

    def drive(self, effort: float) -> int:
        """Sets the motor, the only input."""
        (name,) = [v.name for v in self.slave.fmu.description.modelVariables if v.causality == "input"]
        return self.slave.set({name: effort})

    def go_home(self) -> bytes:
        set_state(self.slave, self.home)
        assert self.slave.step(5 * STEP, STEP) == OK, self.slave.said
        return struct.pack(f"{len(row := self.slave.outputs())}d", *row)

    def given(self, words: bytes, steps: int = 2) -> bool:
        """Whether these words of a state were taken, under a head and a checksum that are right."""
        state = c_void_p()
        inside = self.head + struct.pack("<Q", len(words) // WORD) + words
        whole = inside + struct.pack("<Q", checksum(inside))
        assert deserialize(self.slave, whole, state) == OK, self.slave.said
        self.slave.log.clear()
        status = self.slave.call("fmi2SetFMUstate", state)
        assert status in (OK, ERROR)
        if status == OK:
            for _ in range(steps):
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

    def later(self) -> bytes:
        """Words of a state further on, under another input."""
        self.go_home()
        assert self.drive(-3.0) == OK
        for k in range(6, 30):
            assert self.slave.step(k * STEP, STEP) == OK, self.slave.said
        return serialized(self.slave, get_state(self.slave))[HEAD:-WORD]


def forged(words: bytes, later: bytes, rng: random.Random) -> dict[str, bytes]:
    """States by what is wrong with them; whole and later are right."""
    count = len(words) // WORD
    numbers = struct.unpack(f"<{count}q", words)

    def replaced(k: int, word: bytes) -> bytes:
        return words[: k * WORD] + word + words[(k + 1) * WORD :]

    cut, split = (WORD * rng.randrange(count) for _ in range(2))
    out = {"whole": words, "later": later, "cut": words[:cut], "longer": words + bytes(WORD)}
    out["mixed"] = later[:split] + words[split:]
    for k in rng.sample(range(count), 5):
        out[f"word-{k}"] = replaced(k, rng.choice(SPECIAL))
    # Choices and counts, of which much depends.
    small = [k for k in range(count) if 0 <= numbers[k] < 64]
    for k in rng.sample(small, 10):
        out[f"choice-{k}"] = replaced(k, struct.pack("<q", (numbers[k] + rng.randint(1, 7)) % 8))
    return out


def main() -> None:
    """Writes all seeds anew."""
    for old in SEEDS.iterdir():
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        for i, plant in enumerate(plants()):
            host = Host(fuzzed(plant, Path(folder)))
            made = forged(host.words, host.later(), random.Random(plant))
            for kind, words in made.items():
                (SEEDS / seed_name(plant, kind)).write_bytes(bytes([i]) + words)
            taken = sum(host.given(words) for words in made.values())
            print(f"{plant}: {len(made)} seeds of {len(host.words) // WORD} words, {taken} taken")


if __name__ == "__main__":
    main()
