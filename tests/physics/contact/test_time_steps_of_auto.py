# SPDX-License-Identifier: BSD-3-Clause
"""`auto` leaves located events only where contacts of shapes pile up, and says how accurate it is then."""

from __future__ import annotations

import copy
import math
import re
from typing import Any

import numpy as np
import pytest
import warned
from models.running import assert_restored_run_continues
from models.touching import free_cubes
from models.vibrating import STEPPING_BOXES, conveyor, resting_boxes, vibration

import gelenk

SceneData = dict[str, Any]
EVENTS, STEPPING = 0, 1  # solver.scheme


def chattering_arms() -> SceneData:
    """Two arms with stiff springs, the second of which strikes its limits: 300 impacts in 0.6 s."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "b0": {"mass": 2.81, "com": [0.178, 0, 0], "inertia": [0.0468, 0.052, 0.052]},
            "b1": {"mass": 0.377, "com": [0.124, 0, 0], "inertia": [0.07794, 0.0866, 0.0866]},
        },
        "joints": {
            "j0": {
                "type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "b0",
                "stiffness": 3635.07, "start": {"phi": 0.626, "w": 0.42, "fixed": True},
            },
            "j1": {
                "type": "revolute", "axis": [0, 1, 0], "parent": {"body": "b0", "position": [0.348, 0, 0]},
                "child": "b1", "stiffness": 2214.26, "start": {"phi": 0.637, "w": -0.18, "fixed": True},
                "limit": {"lower": 0.259, "upper": 1.423, "restitution": 0.8},
            },
        },
        "experiment": {"stop": 0.6, "step": 0.01, "tolerance": 1e-8},
    }  # fmt: skip


def with_floor_below(scene: SceneData) -> SceneData:
    out = copy.deepcopy(scene)
    out["bodies"]["b0"]["shapes"] = {"s": {"sphere": 0.02, "surface": "wood"}}
    out["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "position": [0, 0, -5], "surface": "floor"}}}
    out["contacts"] = {"k": {"between": ["wood", "floor"], "friction": 0.2}}
    return out


def test_impacts_of_joints_are_no_reason_for_time_steps() -> None:
    """A floor that nothing reaches changes nothing; 300 impacts amplify errors of the tolerance."""
    alone = gelenk.simulate(chattering_arms())
    above = gelenk.simulate(with_floor_below(chattering_arms()))
    assert len(above.events) > 150
    assert above.warnings == ()
    for name in ("j0.phi", "j1.phi"):
        np.testing.assert_allclose(above[name], alone[name], rtol=0, atol=1e-6)


def test_stiffness_is_no_reason_for_time_steps() -> None:
    """A vibration of 1 kHz for a second: a phase of 6283 rad, with errors of some hundred tolerances."""
    run = gelenk.simulate(vibration(1000, 0.01, boxes=0), outputs=["s.s", "solver.scheme"], tolerance=1e-8)
    assert set(run["solver.scheme"]) == {EVENTS}
    assert run.warnings == ()
    exact = 0.01 * np.cos(2000 * math.pi * run.time)
    np.testing.assert_allclose(run["s.s"], exact, rtol=0, atol=1e-5)


@pytest.mark.parametrize(("frequency", "amplitude"), [(100, 0.01), (3, 0.3)])
def test_time_steps_know_their_error_in_a_vibration(frequency: float, amplitude: float) -> None:
    """Five boxes have 20 points of contact, so that steps are made; the error is that of the phase."""
    scene = vibration(frequency, amplitude, STEPPING_BOXES)
    run = gelenk.simulate(scene, outputs=["s.s", "solver.scheme", "solver.step_error"], stop=0.5)
    assert set(run["solver.scheme"][2:]) == {STEPPING}  # located events lead to the first point
    true = np.abs(run["s.s"] - amplitude * np.cos(2 * math.pi * frequency * run.time)).max()
    assert true < 0.1 * amplitude
    assert true / 10 < run["solver.step_error"][-1] < 10 * true


def test_time_steps_know_their_error_on_a_shaken_plate() -> None:
    """Boxes slide down a plate at 40 Hz; one alone, which is located, is the reference.

    The root of the tolerance, 1e-3, is what the estimate may grow by in a second (docs/time-stepping.md),
    after as much at the start; steps of 10 ms, which do not resolve 40 Hz, had an error of 3e-2.
    """
    located = gelenk.simulate(conveyor(1, integrator="erk"), outputs=["j0.r[1]"], tolerance=1e-8)
    names = ["j0.r[1]", "solver.scheme", "solver.step_error"]
    run = gelenk.simulate(conveyor(STEPPING_BOXES), outputs=names)
    assert set(run["solver.scheme"][2:]) == {STEPPING}  # located events lead to the first point
    true = np.abs(run["j0.r[1]"] - located["j0.r[1]"]).max()
    assert np.ptp(located["j0.r[1]"]) > 0.05
    assert true < 4e-3
    assert true / 10 < run["solver.step_error"][-1] < 10 * true


def test_time_steps_know_their_error_where_limits_chatter() -> None:
    """Boxes on the floor below make the arms move in steps; alone, they are located."""
    located = gelenk.simulate(chattering_arms(), outputs=["j0.phi", "j1.phi"], stop=0.3)
    scene = with_floor_below(chattering_arms())
    boxes = resting_boxes(STEPPING_BOXES, y=2.0)
    for k in range(STEPPING_BOXES):
        joint = boxes["joints"][f"j{k}"] | {"child": f"box{k}"}
        joint["start"]["r"][2] -= 5
        scene["bodies"][f"box{k}"] = boxes["bodies"][f"b{k}"]
        scene["joints"][f"free{k}"] = joint
    weak = {"type": "spring_damper", "stiffness": 1e-9, "length": 5.0}
    scene["forces"] = {f"c{k}": weak | {"from": "b0", "to": f"box{k}"} for k in range(STEPPING_BOXES)}
    names = ["j0.phi", "j1.phi", "solver.scheme", "solver.step_error"]
    run = gelenk.simulate(scene, outputs=names, stop=0.3, tolerance=1e-6)
    assert set(run["solver.scheme"][2:]) == {STEPPING}  # located events lead to the first point
    true = max(np.abs(run[name] - located[name]).max() for name in located)
    assert true < 0.02  # rad, of a range of 1.3; it was 0.66
    assert true / 10 < run["solver.step_error"][-1] < 10 * true


def test_few_boxes_on_a_shaken_plate_are_located() -> None:
    """Sticking and slipping 80 to 160 times a second is not very often; the tolerance is kept."""
    located = gelenk.simulate(conveyor(1, integrator="erk"), outputs=["j0.r[1]"], tolerance=1e-7)
    run = gelenk.simulate(conveyor(1), outputs=["j0.r[1]"], tolerance=1e-7)
    assert run.warnings == ()
    np.testing.assert_allclose(run["j0.r[1]"], located["j0.r[1]"], rtol=0, atol=1e-6)


def test_the_accuracy_follows_the_tolerance() -> None:
    """A hundredth of the tolerance means a tenth of the error of a pair of steps.

    As lengths are powers of two, less is gained at times.
    """
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        scene = vibration(10, 0.1, STEPPING_BOXES)
        run = gelenk.simulate(scene, outputs=["s.s"], stop=0.3, tolerance=tolerance)
        errors.append(np.abs(run["s.s"] - 0.1 * np.cos(20 * math.pi * run.time)).max())
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 3


def test_the_run_says_from_when_to_when_it_made_time_steps() -> None:
    """Boxes that are lifted from the floor at 0.3 s: located events again 50 steps of 1 ms later."""
    scene = vibration(3, 0.3, STEPPING_BOXES, step=1e-3)
    for k in range(2):
        scene["forces"][f"pull{k}"] = {"type": "wrench", "body": f"b{k}", "input": True}
    pull = {f"pull{k}.f[3]": lambda t: 10.0 if t >= 0.3 else 0.0 for k in range(2)}
    run = gelenk.simulate(scene, stop=0.5, inputs=pull, outputs=["s.s", "solver.scheme", "solver.step_error"])
    (sentence,) = run.warnings
    found = re.search(
        r"from t = (\S+) s to (\S+) s, with an estimated error of (\S+) \(m, rad\): (.*)", sentence
    )
    assert found is not None, sentence
    begin, end, error = map(float, found.group(1, 2, 3))
    assert 0 < begin <= 0.01
    assert 0.35 < end < 0.37
    assert error == pytest.approx(run["solver.step_error"][-1], rel=0.05)  # two digits
    assert found.group(4) == "very many points of contact are closed"
    assert set(run["solver.scheme"][run.time > end]) == {EVENTS}
    texts = [text for _, text in run.events]
    assert any(text.startswith("time steps with impulses from here on") for text in texts)
    assert any(text.startswith("located events from here on") for text in texts)


@pytest.mark.parametrize("time", [0.05, 0.2])
def test_a_restored_run_continues_with_the_same_steps_and_estimates(time: float) -> None:
    assert_restored_run_continues(conveyor(STEPPING_BOXES), time, [time + 0.01, time + 0.05])


@pytest.mark.parametrize(("angle", "stable"), [(1.9, True), (2.3, False)])
def test_fixed_steps_that_amplify_a_vibration_are_refused(angle: float, stable: bool) -> None:
    """Steps h of this scheme are stable up to h omega = 2; beyond, the largest number was soon exceeded."""
    frequency = 100.0
    step = angle / (2 * math.pi * frequency)
    scene = vibration(frequency, 0.01, 0, integrator="moreau-jean", step=step)
    stop = 100 * step
    if stable:
        run = gelenk.simulate(scene, stop=stop, step=step)
        # The phase is wrong, but these steps preserve omega^2 s^2 + (1 - (h omega / 2)^2) v^2.
        assert np.abs(run["s.s"]).max() < 1.001 * 0.01
    else:
        with pytest.raises(
            gelenk.StepError, match=r"unstable: the fastest vibration of the scene has 100 Hz"
        ):
            gelenk.simulate(scene, stop=stop, step=step)


@warned.GRAVITY
@pytest.mark.parametrize("integrator", ["moreau-jean", "auto", "erk"])
def test_numbers_too_large_are_refused(integrator: str) -> None:
    """Six balls in gravity of 1e300 m/s2: energies were infinite."""
    starts = [{"r": [0, 0.3 * k, 1.0]} for k in range(6)]
    scene = free_cubes(starts, ["wood"] * 6)
    for body in scene["bodies"].values():
        body["shapes"] = {"s": {"sphere": 0.1, "surface": "wood"}}
    scene |= {
        "gravity": [0, 0, -1e300],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["wood", "floor"]}},
        "solver": {"integrator": integrator},
    }
    simulation = gelenk.Simulation(gelenk.load(scene))
    with pytest.raises(gelenk.GelenkError):  # noqa: PT012
        simulation.initialize()
        for k in range(1, 6):
            simulation.step_to(0.01 * k)
            assert np.isfinite(simulation.values()).all()
            assert np.isfinite([simulation.diagnostic(s.name) for s in simulation.diagnostic_signals]).all()
        raise gelenk.GelenkError("all numbers are finite")
