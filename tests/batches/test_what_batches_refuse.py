# SPDX-License-Identifier: BSD-3-Clause
"""What lanes cannot do is refused by name, and so are wrong calls; nothing is left out in silence."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk import Batch
from gelenk.errors import AssemblyError, GelenkError, SceneError, UsageError

ROOT = Path(__file__).resolve().parents[2]
FOUR_BAR = ROOT / "scenes/four_bar.yaml"
PENDULUM = ROOT / "scenes/pendulum.yaml"


def lever(**fields: Any) -> dict[str, Any]:
    """A lever on a joint A with these fields, or sections of the scene."""
    sections: dict[str, Any] = {
        name: fields.pop(name) for name in ("states", "tables", "constraints") if name in fields
    }
    joint = {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "lever"}
    return {
        "gelenk": 1,
        "name": "Lever",
        "gravity": [0, 0, -9.81],
        "bodies": {"lever": {"mass": 2.0, "com": [0.3, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
        "joints": {"A": {**joint, **fields}},
        **sections,
    }


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (lever(friction={"coulomb": 1.0}), "A.phi: friction acts as in sliding"),
        (lever(limit={"lower": -0.5, "upper": 0.5}), "A.phi: its limit is left out"),
        (lever(law={"effort": "-abs(phi)"}), "found expressions with branches"),
        (
            lever(tables={"load": {"x": [0, 1], "values": [2, 3]}}, law={"effort": "table(load, phi)"}),
            "A.phi: found a law with branches or a table",
        ),
        (
            lever(constraints={"turn": {"type": "motion", "joint": "A", "speed": 1.0}}),
            "turn: found a prescribed motion",
        ),
        (ROOT / "docs/gallery/cam/scene.yaml", "contact: found contacts between shapes"),
        (ROOT / "docs/gallery/car/scene.yaml", "tire_fl: found a law with branches"),
        (ROOT / "docs/gallery/worm_hoist/scene.yaml", "motor.phi: found friction that depends on the forces"),
    ],
)
def test_scenes_that_need_events_are_refused_by_the_name_of_the_element(source: Any, message: str) -> None:
    with pytest.raises(SceneError) as refusal:
        gelenk.batch(source, 4)
    assert message in str(refusal.value)


def test_a_start_at_an_equilibrium_is_refused() -> None:
    """It would be another state than that of `gelenk.simulate`."""
    scene = gelenk.load(FOUR_BAR).with_parameters({"solver.start": "equilibrium"})
    with pytest.raises(SceneError, match=r"solver\.start: found equilibrium, expected as_given"):
        gelenk.batch(scene, 2)


def varying(effort: str, k: float, **fields: Any) -> dict[str, Any]:
    """A lever of which the law of A depends on a constant k."""
    return lever(law={"effort": effort}, **fields) | {"constants": {"k": k}, "parameters": ["k"]}


@pytest.mark.parametrize(
    ("effort", "k", "lanes", "which"),
    [
        ("-30*phi^k", 2.0, [2.0, 3.0], "k: changes more"),
        ("-30*u^k", 2.0, [2.0, 3.0], "k: changes more"),
        ("-if(k > 0, 1, 0)*30*phi^3", 1.0, [1.0, 0.0], "lane 1: k = 0: changes more"),
        ("-if(k > 0, 1, 0)*30*phi^3", 0.0, [0.0], "lane 0: k = 0: changes more"),
        ("-sign(k)*30*phi^3", 0.0, [0.0], "lane 0: k = 0: changes more"),
        ("-if(k > 0, 4, 2)*phi", -1.0, [0.3], "lane 0: k = 0.3: changes more"),
    ],
)
def test_what_changes_more_than_numbers_is_refused_by_name(
    effort: str, k: float, lanes: list[float], which: str
) -> None:
    """At phi = 0 and u = 0, where the terms vanish; as many constants are recorded."""
    source = varying(effort, k, start={"phi": 0.0, "w": 3.0}) | {"inputs": {"u": {}}}
    with pytest.raises(SceneError, match=which):
        gelenk.batch(source, len(lanes), {"k": lanes, "lever.mass": 2.5})


def test_all_reasons_are_given_at_once() -> None:
    with pytest.raises(SceneError) as refusal:
        gelenk.batch(lever(friction={"coulomb": 1.0}, law={"effort": "-abs(phi)"}), 4)
    assert len(refusal.value.lines) == 2


def chain(count: int) -> dict[str, Any]:
    """A chain of so many links in the plane."""
    link = {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}
    hinge = {"type": "revolute", "axis": [0, 1, 0]}
    joints = {
        f"J{k}": {
            **hinge,
            "parent": {"body": f"b{k - 1}", "position": [1, 0, 0]} if k else "ground",
            "child": f"b{k}",
            "start": {"phi": 0.1},
        }
        for k in range(count)
    }
    bodies = {f"b{k}": link for k in range(count)}
    return {"gelenk": 1, "name": "Chain", "gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints}


def test_large_mechanisms_are_refused() -> None:
    batch = gelenk.batch(chain(64), 1, step=1e-3)
    batch.step(2)
    assert not batch.errors
    with pytest.raises(SceneError, match="found 65 velocities of joints, expected at most 64"):
        gelenk.batch(chain(65), 1, step=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gelenk.batch(PENDULUM, 0), "lanes: found 0, expected at least 1"),
        (lambda: gelenk.batch(PENDULUM, 3.0), "lanes: found 3.0, expected a whole number"),  # type: ignore[arg-type]
        (lambda: gelenk.batch(PENDULUM, 2**31), "lanes: found 2147483648, expected at most 2147483583"),
        (lambda: gelenk.batch(PENDULUM, 2, threads=1.5), "threads: found 1.5, expected a whole number"),  # type: ignore[arg-type]
        (lambda: gelenk.batch(PENDULUM, 2, step="a"), "step: found 'a'"),  # type: ignore[arg-type]
        (lambda: gelenk.batch(PENDULUM, 2, {"rod.mass": "heavy"}), "rod.mass: found 'heavy', expected one"),
        (lambda: gelenk.batch(PENDULUM, 2, [1.0]), "parameters: found list, expected values by name"),  # type: ignore[arg-type]
        (lambda: gelenk.batch(PENDULUM, 2, {"rod.mass": 1, "rod.m": 2}), "found two names of one parameter"),
        (lambda: gelenk.batch(PENDULUM, 2, threads=0), "threads: found 0, expected at least 1"),
        (lambda: gelenk.batch(PENDULUM, 2, step=0.0), "step: found 0.0 s, expected more than 0 s"),
        (lambda: gelenk.batch(PENDULUM, 2, step=np.inf), "step: found inf, expected a finite number"),
        (lambda: gelenk.batch(PENDULUM, 2, {"bob.mass": 1.0}), "bob.mass: no such parameter"),
        (
            lambda: gelenk.batch(PENDULUM, 2, {"solver.tolerance": 1e-6}),
            "solver.tolerance: the same for all lanes; expected a number of the mechanism",
        ),
        (lambda: gelenk.batch(PENDULUM, 2, {"pin.fixed": 1.0}), "pin.fixed: the same for all lanes"),
        (
            lambda: gelenk.batch(PENDULUM, 2, {"rod.mass": [1.0, 2.0, 3.0]}),
            r"rod.mass: found an array of shape \(3,\), expected one number or \(2,\)",
        ),
        (
            lambda: gelenk.batch(PENDULUM, 2, {"rod.mass": [1.0, np.nan]}),
            "rod.mass: found a value that is not",
        ),
        (lambda: gelenk.batch(PENDULUM, 2, {"rod.mass": [1.0, -1.0]}), "lane 1: rod.m"),
    ],
)
def test_wrong_arguments_are_refused(call: Callable[[], Batch], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        call()


def test_values_that_contradict_each_other_are_refused_with_the_number_of_the_lane() -> None:
    inertia = [0.01, 0.5]  # kg m2: the second one exceeds the sum of the others
    with pytest.raises(SceneError, match=r"lane 1: .*no rigid body"):
        gelenk.batch(ROOT / "scenes/double_pendulum.yaml", 2, {"upper.inertia[1]": inertia})


def test_loops_that_do_not_close_are_refused_with_the_number_of_the_lane() -> None:
    length = "B.parent.position[1]"
    with pytest.raises(GelenkError, match="lane 2: ") as refusal:
        gelenk.batch(FOUR_BAR, 3, {length: [0.5, 0.5, 9.0]})
    assert isinstance(refusal.value, AssemblyError)


@pytest.fixture
def batch() -> Batch:
    return gelenk.batch(FOUR_BAR, 3, {"crank.mass": [1.0, 1.5, 2.0]}, step=1e-3)


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda b: b.set({"rocker.mass": 1.0}), "rocker.mass: not among the parameters that may vary"),
        (lambda b: b.set({"crank.mass": [1.0, 2.0]}), r"crank.mass: found an array of shape \(2,\)"),
        (lambda b: b.step(-1), "count: found -1, expected 0 or more"),
        (lambda b: b.step(2.5), "count: found 2.5, expected a whole number"),
        (
            lambda b: b.inputs.__setitem__("drive.tau", [1.0, 2.0]),
            r"drive.tau: found an array of shape \(2,\)",
        ),
        (lambda b: b.run(0.0015), "stop: found 0.0015 s, expected a multiple of the step"),
        (lambda b: b.run(np.nan), "stop: found nan s"),
        (lambda b: (b.step(3), b.run(0.002)), "stop: found 0.002 s, .*from 0.003 s on"),
        (lambda b: b.states["A.angle"], "A.angle: no such state"),
        (lambda b: b.inputs["drive"], "drive: no such input"),
    ],
)
def test_wrong_calls_are_refused(batch: Batch, use: Callable[[Batch], Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        use(batch)


def test_an_input_that_is_not_finite_is_refused_with_its_lane(batch: Batch) -> None:
    before = batch.array.copy()
    batch.inputs["drive.tau"][1] = np.nan
    with pytest.raises(UsageError, match=r"drive.tau: found nan in lane 1, expected a finite number"):
        batch.step()
    assert np.array_equal(batch.array, before)
    batch.inputs["drive.tau"][1] = 0
    batch.step()
    assert not batch.errors


def test_a_parameter_that_is_set_puts_lanes_to_their_starts(batch: Batch) -> None:
    batch.step(100)
    batch.set({"crank.mass": 1.5})
    assert batch.time == 0
    batch.step(100)
    assert np.ptp(batch.array, axis=1).max() == 0  # three times the same
    assert batch.parameters["crank.mass"].tolist() == [1.5, 1.5, 1.5]
    assert repr(batch) == "<Batch of 3 FourBar: t = 0.1 s, 0 stopped>"


def test_a_set_that_is_refused_changes_nothing(batch: Batch) -> None:
    other = gelenk.batch(FOUR_BAR, 3, {"crank.mass": [1.0, 1.5, 2.0]}, step=1e-3)
    for each in (batch, other):
        each.step(30)
    with pytest.raises(UsageError, match="lane 1: "):
        batch.set({"crank.mass": [1.7, -1.0, 2.0]})
    for each in (batch, other):
        each.step(30)
    assert np.array_equal(batch.array, other.array)
    assert batch.time == other.time
    batch.reset()
    other.reset()
    assert np.array_equal(batch.array, other.array)


def test_the_step_is_that_of_the_scene_by_default() -> None:
    scene = gelenk.load(PENDULUM)
    assert gelenk.batch(scene, 1).step_size == scene.step
    assert gelenk.batch(scene.with_parameters({"solver.step": 2e-4}), 1).step_size == 2e-4


def test_evaluations_are_counted() -> None:
    """Four in a step, by each lane; a block that renews factors counts them, too."""
    batch = gelenk.batch(PENDULUM, 5, step=1e-3)
    batch.step(10)
    assert batch.evaluations == 4 * 10 * 5
    assert batch.lanes == 5
    assert batch.running.all()


def test_batches_are_not_copied(batch: Batch) -> None:
    with pytest.raises(TypeError, match="a Batch cannot be copied or pickled"):
        copy.deepcopy(batch)
