# SPDX-License-Identifier: BSD-3-Clause
"""Time and memory of initialization and export grow linearly with the size of a scene, and the time of
linearization with the entries of its matrices.
"""

from __future__ import annotations

import math
import time
import warnings
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from benchmarks.growth import FAMILIES, exponent, measured
from samples import sampled, thorough_beyond

import gelenk

SMALL, LARGE = 1024, 4096
MOST_MEMORY = 500  # MB
LINEAR = ["chain", "equipped chain", "tree", "N-four-bar", "ring"]


@pytest.mark.clock
@pytest.mark.parametrize("family", LINEAR)
def test_cost_grows_as_the_number_of_bodies(family: str) -> None:
    """Processor time, the smaller of two processes; initializing an N-four-bar was once cubic."""
    small, large = ([measured(family, n) for _ in range(2)] for n in (SMALL, LARGE))
    for what in ("initialize", "export"):
        times = [min(getattr(cost, what) for cost in costs) for costs in (small, large)]
        found = exponent(times[0], times[1], LARGE / SMALL)
        assert found < 1.5, f"{what}: from {times[0]:.2f} s to {times[1]:.2f} s; 1.3 on an idle machine"


def time_of_linearization(n: int) -> float:
    scene = gelenk.load(FAMILIES["tree"](n))
    taken = []
    for _ in range(2):
        before = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gelenk.OperatingPointWarning)  # it falls
            gelenk.linearize(scene)
        taken.append(time.process_time() - before)
    return min(taken)


@pytest.mark.clock
def test_linearization_grows_as_the_entries_of_its_matrices() -> None:
    """The square of the number of states; it was once their cube, 16 s for 1000 bodies."""
    time_of_linearization(10)  # imports
    small, large = time_of_linearization(400), time_of_linearization(1600)
    found = exponent(small, large, 4.0)
    assert found < 2.5, f"from {small:.2f} s to {large:.2f} s; 2.0 on an idle machine"


@pytest.mark.thorough
@pytest.mark.parametrize("family", sampled(LINEAR, ["chain", "tree"]))
def test_memory_of_many_bodies_has_a_bound(family: str) -> None:
    """A full matrix in their velocities alone would take 130 MB."""
    large = measured(family, LARGE)
    assert large.initialize_memory < MOST_MEMORY
    assert large.export_memory < MOST_MEMORY


@warned.GUESSES
@pytest.mark.parametrize("family", ["N-four-bar", "scissors"])
def test_many_loops_are_assembled_as_few_are(family: str) -> None:
    """More than 300 velocities use a sparse factorization: the assembly is the same."""
    source = FAMILIES[family](700)
    first = next(iter(source["joints"]))
    source["joints"][first]["start"] = {"phi": 1.1, "fixed": True}
    plant = gelenk.Simulation(source)
    plant.initialize()
    assert plant.output(f"{first}.phi") == 1.1
    few = FAMILIES[family](12)
    few["joints"][first]["start"] = {"phi": 1.1, "fixed": True}
    small = gelenk.Simulation(few)
    small.initialize()
    for signal in small.outputs:
        if not signal.name.endswith(".phi"):
            continue
        difference = plant.output(signal.name) - small.output(signal.name)
        assert abs(np.remainder(difference + np.pi, 2 * np.pi) - np.pi) < 1e-9, signal.name


@pytest.mark.parametrize("n", thorough_beyond([40, 400], [40]))
def test_assembly_of_many_degrees_of_freedom_is_the_least_change_of_the_guesses(n: int) -> None:
    """An arch of n rods between two pins has n - 2 degrees of freedom: up to 64 a basis of the null space is
    used, for more the sparse least-change equations. The change is orthogonal to the null space.
    """
    length, span = 1.0 / n, 0.6
    random = np.random.default_rng(3)
    guesses = np.full(n, -math.pi / n) + 0.02 * random.standard_normal(n)
    guesses[0] = 0.5 * math.pi
    hinge: dict[str, Any] = {"type": "revolute", "axis": [0, 0, 1]}
    joints: dict[str, Any] = {}
    for k in range(n):
        parent = {"body": f"b{k - 1}", "position": [length, 0, 0]} if k else "ground"
        joints[f"j{k}"] = {**hinge, "parent": parent, "child": f"b{k}", "start": {"phi": float(guesses[k])}}
    end = {"body": f"b{n - 1}", "position": [length, 0, 0]}
    joints["end"] = {**hinge, "parent": {"body": "ground", "position": [span, 0, 0]}, "child": end}
    rod = {"mass": length, "com": [length / 2, 0, 0], "inertia": [0, length**3 / 12, length**3 / 12]}
    plant = gelenk.Simulation(
        {"gelenk": 1, "name": "Arch", "bodies": {f"b{k}": rod for k in range(n)}, "joints": joints}
    )
    plant.initialize()
    q = np.array([plant.output(f"j{k}.phi") for k in range(n)])
    tips = length * np.exp(1j * np.cumsum(q))
    assert abs(tips.sum() - span) < 1e-13 * n  # rounding of n sums
    to_end = np.cumsum(tips[::-1])[::-1] * 1j  # derivatives of the end point of the arch
    jacobian = np.array([to_end.real, to_end.imag])
    change = q - guesses
    by_the_rows = np.linalg.lstsq(jacobian.T, change, rcond=None)[0] @ jacobian
    along = np.linalg.norm(change - by_the_rows)
    # The closing joint's angle has no guess and the weight 1e-8: its influence is below 1e-5.
    assert along < 1e-5 * np.linalg.norm(change)


def two_chains(n: int) -> dict[str, Any]:
    """Return two independent chains of n bodies on the ground."""
    out = FAMILIES["chain"](n)
    other = FAMILIES["chain"](n)
    out["bodies"] |= {f"other_{name}": body for name, body in other["bodies"].items()}
    for name, joint in other["joints"].items():
        parent = joint["parent"]
        if parent != "ground":
            parent = {**parent, "body": f"other_{parent['body']}"}
        out["joints"][f"other_{name}"] = {**joint, "parent": parent, "child": f"other_{joint['child']}"}
    return out


@pytest.mark.parametrize(("n", "listed"), [(40, True), (600, False)])
def test_dependency_lists_of_quadratic_size_are_omitted(n: int, listed: bool, tmp_path: Path) -> None:
    """An acceleration depends on the 2 n states of its chain, out of 4 n. All lists together have at least 6
    n^2
    numbers: beyond a million they are omitted, which means all dependencies in FMI.
    """
    gelenk.export_fmu(two_chains(n), tmp_path / "x.fmu")
    with zipfile.ZipFile(tmp_path / "x.fmu") as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    names = [variable.get("name") for variable in root.iter("ScalarVariable")]
    unknown = root.find(f"ModelStructure/Outputs/Unknown[@index='{names.index('j3.a') + 1}']")
    assert unknown is not None
    dependencies = unknown.get("dependencies")
    assert (dependencies is not None) == listed
    if dependencies is not None:
        assert len(dependencies.split()) == 2 * n
    position = root.find(f"ModelStructure/Outputs/Unknown[@index='{names.index('j3.phi') + 1}']")
    assert position is not None
    assert position.get("dependencies") == str(names.index("j3.phi") + 1), "short lists are kept"
