# SPDX-License-Identifier: BSD-3-Clause
"""A mechanism whose geometry and guesses have occurred before in the process is not searched again.

The start must be the same, bit for bit, as in a process that has seen nothing before, and a scene that
differs in anything on which the search depends must not get the start of another.
"""

from __future__ import annotations

import copy
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned

import gelenk
from gelenk.model.scene import from_dict

pytestmark = warned.GUESSES

REPOSITORY = Path(__file__).parents[3]
DELTA = gelenk.load(REPOSITORY / "docs/gallery/delta_robot/scene.yaml").to_dict()


def changed(*path: str, to: Any) -> dict[str, Any]:
    """Return the delta robot with another value at this path."""
    scene: dict[str, Any] = copy.deepcopy(DELTA)
    at = scene
    for key in path[:-1]:
        at = at.setdefault(key, {}) if isinstance(at, dict) else at[int(key)]
    at[path[-1]] = to
    return scene


def just_above(x: float) -> float:
    return math.nextafter(x, math.inf)


VARIANTS = {
    "as it is": DELTA,
    "another mass": changed("bodies", "platform", "mass", to=6.0),
    "longer by a rounding": changed("joints", "ball1l", "parent", "position", to=[just_above(0.7), 0, 0]),
    "another length": changed("joints", "ball1l", "parent", "position", to=[0.71, 0, 0]),
    "another guess": changed("joints", "elbow1l", "start", to={"phi_a": -1.8}),
    "another guess by a rounding": changed("joints", "elbow1l", "start", to={"phi_a": just_above(1.8)}),
    "a guess less": changed("joints", "elbow1l", "start", to={}),
    "a weight": changed("joints", "elbow3l", "start", to={"phi_a": -1.9, "weight": 100}),
    "another motion": changed("constraints", "drive1", "polynomial", to=[0.45]),
    "all bodies": DELTA | {"solver": {"reductions": {"all": False}}},
}


def starts(names: list[str]) -> dict[str, list[str]]:
    """Return the values of all outputs at the start, as hexadecimal numbers, computed in this order."""
    out = {}
    for name in names:
        simulation = gelenk.Simulation(from_dict(VARIANTS[name]))
        simulation.initialize()
        out[name] = [float(x).hex() for x in simulation.values()]
    return out


def in_a_process(names: list[str]) -> dict[str, list[str]]:
    command = (
        "import json, sys, warnings; warnings.simplefilter('ignore'); "
        "from physics.assembly.test_repeated_starts import starts; "
        "print(json.dumps(starts(json.loads(sys.argv[1]))))"
    )
    paths = [str(REPOSITORY / "tests"), str(REPOSITORY / "tests/models")]
    program = f"import sys; sys.path[:0] = {paths!r}; {command}"
    done = subprocess.run(
        [sys.executable, "-c", program, json.dumps(names)], capture_output=True, text=True, check=True
    )
    found: dict[str, list[str]] = json.loads(done.stdout)
    return found


def test_starts_do_not_depend_on_those_before_in_the_process() -> None:
    """Each variant first and last, and twice, gives the same bits."""
    names = list(VARIANTS)
    there = in_a_process(names)
    back = in_a_process([*reversed(names), *names])
    for name in names:
        assert there[name] == back[name], name


def test_variants_of_the_geometry_and_the_guesses_have_other_starts() -> None:
    """Otherwise the test above could not see one that is confused with another."""
    found = starts(list(VARIANTS))
    for name, values in found.items():
        same = {"as it is", "another mass", "all bodies"}
        if name in same or "rounding" in name or name == "a guess less":
            continue
        assert values != found["as it is"], name


def cpu_of_start(length: float) -> float:
    simulation = gelenk.Simulation(
        from_dict(changed("joints", "ball1l", "parent", "position", to=[length, 0, 0]))
    )
    before = time.process_time()
    simulation.initialize()
    return time.process_time() - before


def test_repeated_start_is_not_searched() -> None:
    """The search takes four fifths of the first start, here of a few lengths."""
    lengths = [0.7 + 1e-9 * k for k in range(1, 6)]
    first = min(cpu_of_start(length) for length in lengths)
    repeated = min(cpu_of_start(length) for length in lengths)
    assert repeated < first / 2, (first, repeated)


@pytest.mark.parametrize("count", [1, 200], ids=["one", "more than are kept"])
def test_what_is_forgotten_is_searched_again(count: int) -> None:
    """The store has room for 64 starts; the result is the same with 200 others in between."""
    before = starts(["as it is"])
    for k in range(count):
        cpu_of_start(0.69 + 1e-6 * k)
    assert starts(["as it is"]) == before
    assert np.all(np.isfinite([float.fromhex(x) for x in before["as it is"]]))
