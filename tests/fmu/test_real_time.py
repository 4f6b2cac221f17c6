# SPDX-License-Identifier: BSD-3-Clause
"""What a controller's loop asks of a plant: nothing of the heap."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import pytest
from costs.jobs import falling_on_a_limit, planar_four_bar
from mechanisms import Scene, frame
from models.touching import box_on_a_cart

import gelenk

from .c_hosts import extracted
from .host import Fmu
from .plants import crank_rocker, cranked, driven, touching, weightless, with_circuit
from .states import choice

HOST = "no_allocation_host"
ROOT = Path(__file__).parent.parent.parent
SHIPPED = sorted(
    path
    for path in [*ROOT.glob("scenes/*.yaml"), *ROOT.glob("docs/gallery/*/scene.yaml")]
    if "motors:" in path.read_text(encoding="utf-8")
)


def study(name: str) -> Any:
    return pytest.param(name, marks=pytest.mark.thorough)


def heap_calls(host: Path, fmu: Path, folder: Path, tunable: str, first: int = 0) -> dict[str, int]:
    arguments = extracted(fmu, folder)
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    (reference,) = (v.valueReference for v in variables if v.name == tunable)
    run = subprocess.run(
        [str(host), *arguments, str(reference), str(first)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    return dict(zip(("set", "step", "get", "tune"), map(int, run.stdout.split()), strict=True))


# The speed of `cranked` jumps, which is an impact. The position of `driven` jumps, too, first with a
# warning in step 5.
PLANTS = [
    (crank_rocker, "A.damping", 0),
    pytest.param(driven, "bobs.damping", 6, marks=pytest.mark.study),
    (cranked, "bobs.damping", 0),
    pytest.param(with_circuit, "A.damping", 0, marks=pytest.mark.study),
    pytest.param(weightless, "bobs.damping", 0, marks=pytest.mark.study),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("plant", "tunable", "first"), PLANTS)
def test_running_asks_nothing_of_the_heap(
    plant: Callable[[], Scene], tunable: str, first: int, host: Path, tmp_path: Path
) -> None:
    """With every pair of methods."""
    source = plant()
    fmu = gelenk.export_fmu(source, tmp_path / "any.fmu")
    table = Fmu(fmpy.extract(str(fmu), str(tmp_path / "any")))
    found = {}
    for formulation in choice(table, "solver.formulation"):
        for integrator in choice(table, "solver.integrator"):
            source["solver"] = {"formulation": formulation, "integrator": integrator}
            try:
                fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
            except gelenk.SceneError:
                continue  # do not go together
            name = f"{formulation} {integrator}"
            found[name] = heap_calls(host, fmu, tmp_path / name, tunable, first)
    assert len(found) > 30
    noisy = {name: calls for name, calls in found.items() if any(calls.values())}
    assert not noisy, "\n".join(f"{name}: {calls}" for name, calls in noisy.items())


@pytest.mark.parametrize("integrator", ["auto", "dirk", "rk4"])
def test_element_states_ask_nothing_of_the_heap(integrator: str, host: Path, tmp_path: Path) -> None:
    """Through kinks, and with the joint that closes the loop and a sensor in expressions."""
    fmu = gelenk.export_fmu({**with_circuit(), "solver": {"integrator": integrator}}, tmp_path / "x.fmu")
    calls = heap_calls(host, fmu, tmp_path / "x", "A.damping")
    assert not any(calls.values()), calls


@pytest.mark.parametrize("boxes", [2, 10])
def test_contacts_ask_nothing_of_the_heap(boxes: int, host: Path, tmp_path: Path) -> None:
    """Memory for 200 rows of contacts is taken at the start, by steps with impulses.

    A paddle tosses the boxes up again and again, so that the number of contact points changes.
    """
    scene = {**touching(boxes), "solver": {"integrator": "moreau-jean"}}
    fmu = gelenk.export_fmu(scene, tmp_path / "x.fmu")
    calls = heap_calls(host, fmu, tmp_path / "x", "hit.friction")
    assert not any(calls.values()), calls


def tumbling() -> Scene:
    """A cube that falls onto an edge, turns over and comes to rest on a plate beside a motor."""
    source = box_on_a_cart()
    source["joints"]["J"]["start"] = {"r": [0, 0, 0.2], "rotation": {"axis": [1, 1, 0.3], "angle": 0.4}}
    return source


EVENTFUL = [pytest.param(planar_four_bar(40.0), id="held"), falling_on_a_limit, tumbling, box_on_a_cart]
ALL_SCHEMES = ["rk4", "auto", "moreau-jean", "erk", "cvode", "dirk"]


@pytest.mark.parametrize("integrator", [*ALL_SCHEMES[:3], *(study(name) for name in ALL_SCHEMES[3:])])
@pytest.mark.parametrize("plant", EVENTFUL)
def test_events_ask_nothing_of_the_heap(
    plant: Callable[[], Scene], integrator: str, host: Path, tmp_path: Path
) -> None:
    """Impacts, sticking, sliding, contacts that close and open: they take it from the memory for steps."""
    source = {**plant(), "solver": {"integrator": integrator}}
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    calls = heap_calls(host, fmu, tmp_path / "x", "gravity[1]")
    assert not any(calls.values()), calls


@pytest.mark.thorough
@pytest.mark.parametrize("integrator", ALL_SCHEMES)
@pytest.mark.parametrize("scene", SHIPPED, ids=lambda path: path.parent.name + "/" + path.stem)
def test_shipped_scenes_ask_nothing_of_the_heap(
    scene: Path, integrator: str, host: Path, tmp_path: Path
) -> None:
    source = gelenk.load(scene).to_dict()
    source["solver"] = {**source.get("solver", {}), "integrator": integrator}
    try:
        fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    except gelenk.SceneError:
        pytest.skip("they do not go together")
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    if not any(v.causality == "input" for v in variables):
        pytest.skip("the host sets an input")
    calls = heap_calls(host, fmu, tmp_path / "x", "gravity[1]")
    assert not any(calls.values()), calls


@pytest.mark.parametrize(
    "force",
    [
        {"type": "spring_damper", "from": frame("ground"), "to": frame("crank", (0.3, 0, 0))},
        {"type": "drag", "body": "crank"},
    ],
    ids=["of two ports", "of one"],
)
def test_tuned_forces_ask_nothing_of_the_heap(force: dict[str, Any], host: Path, tmp_path: Path) -> None:
    """Loads are collected anew when a number of theirs changes."""
    source = crank_rocker()
    source["forces"] = {"force": {**force, "damping": 2.0}}
    source["parameters"].append("force.damping")
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    calls = heap_calls(host, fmu, tmp_path / "x", "force.damping")
    assert not any(calls.values()), calls
