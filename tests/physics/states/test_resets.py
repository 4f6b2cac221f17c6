# SPDX-License-Identifier: BSD-3-Clause
"""Jumps of element states where conditions become true: closed forms, inputs, saved states, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from circuits import rotor, values

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
HEATED, COOLED = 1.0, 0.2  # thresholds of the relay
TAU = 0.5  # s


def relay(**more: Any) -> dict[str, Any]:
    """A first order plant x' = (on - x)/tau with drive 1.5, switched off at 1 and on at 0.2 (hysteresis)."""
    return rotor(
        states={
            "on": {
                "rate": "0",
                "start": 1,
                "resets": [{"when": f"x1 > {HEATED}", "to": "0"}, {"when": f"x1 < {COOLED}", "to": 1}],
            },
            "x1": f"(1.5*on - x1)/{TAU}",
        },
        **more,
    )


def relay_exact(t: float) -> tuple[float, float]:
    """State and switch, piece by piece."""
    x, on, now = 0.0, 1.0, 0.0
    while True:
        goal, end = (1.5, HEATED) if on else (0.0, COOLED)
        duration = TAU * math.log((x - goal) / (end - goal))
        if now + duration > t:
            return goal + (x - goal) * math.exp(-(t - now) / TAU), on
        now, x, on = now + duration, end, 1 - on


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_relay_with_hysteresis(integrator: str, tolerance: float) -> None:
    times = [0.3, 0.7, 1.9, 5.0, 10.0]
    found = values(relay(solver={"integrator": integrator}), ["x1", "on"], times, tolerance)
    expected = np.array([relay_exact(t) for t in times])
    assert np.array_equal(found[:, 1], expected[:, 1])
    assert np.abs(found[:, 0] - expected[:, 0]).max() <= 100 * tolerance  # errors add up over 20 switchings


@pytest.mark.parametrize("integrator", ["rk4", "generalized-alpha", "hht", "euler"])
def test_fixed_steps_locate_the_switching(integrator: str) -> None:
    order = {"rk4": 4, "euler": 1}.get(integrator, 2)
    errors = []
    for step in (0.02, 0.01):
        source = relay(solver={"integrator": integrator, "step": step})
        errors.append(abs(values(source, ["x1"], [2.5], 1e-6)[0, 0] - relay_exact(2.5)[0]))
    assert errors[1] < 2e-2**order + 1e-9
    assert errors[0] > 1.5 * errors[1] or errors[0] < 1e-9


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode"])
def test_ball_that_bounces(integrator: str) -> None:
    """As states alone: height h, speed u, u to -0.8 u where h becomes negative; 1 m high."""
    source = rotor(
        states={
            "h": {"rate": "u1", "start": 1.0},
            "u1": {"rate": "-9.81", "resets": [{"when": "h < 0", "to": "-0.8*u1"}]},
        },
        solver={"integrator": integrator},
    )
    times = [0.4, 0.9, 1.5, 2.4]
    expected = []
    for t in times:
        start, speed, height = 0.0, 0.0, 1.0
        while True:
            flight = (speed + math.sqrt(speed**2 + 2 * 9.81 * height)) / 9.81
            if start + flight > t:
                break
            speed, height, start = 0.8 * (9.81 * flight - speed), 0.0, start + flight
        expected.append(height + speed * (t - start) - 9.81 / 2 * (t - start) ** 2)
    found = values(source, ["h"], times, 1e-9)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)


def test_sample_and_hold() -> None:
    """The angle of a rotor at 2 rad/s, sampled where a clock of 0.1 s starts anew."""
    source = rotor(
        start={"phi": 0.0, "w": 2.0},
        states={
            "clock": {"rate": "1", "resets": [{"when": "clock > 0.1", "to": "0"}]},
            "sampled": {"rate": "0", "resets": [{"when": "clock > 0.1", "to": "A.phi"}]},
        },
    )
    for t, found in zip(
        [0.05, 0.13, 0.99], values(source, ["sampled"], [0.05, 0.13, 0.99], 1e-9), strict=True
    ):
        assert found[0] == pytest.approx(0.2 * int(t / 0.1), abs=1e-8)


def test_input_that_makes_a_condition_true() -> None:
    """Once for each time that it becomes true, at the communication point."""
    source = rotor(
        inputs={"trigger": {"start": 1.0}},
        states={"count": {"rate": "0", "resets": [{"when": "trigger > 0.5", "to": "count + 1"}]}},
    )
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    counts = []
    for k, trigger in enumerate([1, 1, 0, 1, 1, 0, 0, 1]):
        simulation.set_input("trigger", trigger)
        simulation.step_to(0.1 * (k + 1))
        counts.append(simulation.output("count"))
    assert counts == [0, 0, 0, 1, 1, 1, 1, 2]  # not at the start, where it holds already


def test_jumps_at_one_instant_take_the_values_before() -> None:
    """Two states that are exchanged, and a third that follows from the jump of the first."""
    when = "t > 0.25"
    source = rotor(
        states={
            "one": {"rate": "0", "start": 3, "resets": [{"when": when, "to": "two"}]},
            "two": {"rate": "0", "start": 5, "resets": [{"when": when, "to": "one"}]},
            "third": {"rate": "0", "resets": [{"when": "one > 4", "to": "10*one + two"}]},
        }
    )
    assert values(source, ["one", "two", "third"], [0.3], 1e-6)[0].tolist() == [5, 3, 53]


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_saved_state_repeats_the_run(integrator: str) -> None:
    simulation = gelenk.Simulation(relay(solver={"integrator": integrator}))
    simulation.initialize(0.0, 1e-7)
    for k in range(10):
        simulation.step_to(0.1 * (k + 1))
    saved = simulation.save()
    runs = []
    for _ in range(2):
        run = []
        for k in range(10, 30):
            simulation.step_to(0.1 * (k + 1))
            run.append([simulation.output(name) for name in ("x1", "on")])
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


def test_joint_is_driven_by_a_relay() -> None:
    """From rest to 0.4 rad by 0.3 N m, then decelerated over the same angle to rest."""
    source = rotor(
        effort="if(on > 0.5, 0.3, -0.3)",
        states={
            "on": {
                "rate": "0",
                "start": 1,
                "resets": [{"when": "A.phi > 0.4", "to": 0}, {"when": "A.phi < -0.4", "to": 1}],
            }
        },
    )
    J = 0.5
    t = 2 * math.sqrt(2 * 0.4 * J / 0.3)
    phi, w = values(source, ["A.phi", "A.w"], [t], 1e-9)[0]
    assert phi == pytest.approx(0.8, abs=1e-6)
    assert w == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4", "generalized-alpha"])
@pytest.mark.parametrize("step", [0.1, 3.0, 5.0])
def test_rest_by_friction_triggers_at_its_instant(integrator: str, step: float) -> None:
    """A rotor that 1 N m decelerates at 2 rad/s2: at rest, its speed is exactly 0, and never negative."""
    for start in (0.9, 2.0, 4.4):
        states = {
            "hit": {"rate": "0", "start": -1, "resets": [{"when": "A.w <= 0", "to": "t"}]},
            "passed": {"rate": "0", "resets": [{"when": "A.w < 0", "to": "1"}]},
        }
        solver = {"integrator": integrator, "step": 0.01}
        source = rotor(start={"phi": 0.0, "w": start}, states=states, solver=solver)
        source["joints"]["A"]["friction"] = {"coulomb": 1.0}
        times = [step * (k + 1) for k in range(math.ceil(3 / step))]
        hit, passed = values(source, ["hit", "passed"], times, 1e-6)[-1]
        assert hit == pytest.approx(start / 2, abs=1e-6)
        assert passed == 0


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize("step", [0.1, 3.0])
def test_impact_triggers_at_its_instant(integrator: str, step: float) -> None:
    source = rotor(
        start={"phi": 0.0, "w": 1.4},
        states={"hit": {"rate": "0", "start": -1, "resets": [{"when": "A.w < 0", "to": "t"}]}},
        solver={"integrator": integrator, "step": 0.01},
    )
    source["joints"]["A"]["limit"] = {"upper": 1.0, "restitution": 0.5}
    times = [step * (k + 1) for k in range(math.ceil(3 / step))]
    assert values(source, ["hit"], times, 1e-6)[-1, 0] == pytest.approx(1 / 1.4, abs=1e-6)


def test_relay_that_friction_stops() -> None:
    """5 N m for 0.5 s against friction of 1 N m, on again at rest: 4 rad/s, then 2 s to rest."""
    states = {
        "on": {
            "rate": "0",
            "start": 1,
            "resets": [{"when": "clock > 0.5", "to": 0}, {"when": "A.w <= 0", "to": 1}],
        },
        "clock": {"rate": "1", "resets": [{"when": "A.w <= 0", "to": 0}]},
    }
    for times in ([20.3], [0.7 * (k + 1) for k in range(29)]):
        source = rotor(states=states, effort="5*on")
        source["joints"]["A"]["friction"] = {"coulomb": 1.0}
        w = values(source, ["A.w"], times, 1e-8)[-1, 0]
        assert w == pytest.approx(8 * (times[-1] - 20), abs=1e-5)


def test_a_jump_to_no_number_is_refused() -> None:
    source = rotor(states={"x1": {"rate": "1", "resets": [{"when": "x1 > 0.5", "to": "log(-x1)"}]}})
    with pytest.raises(gelenk.StepError, match="a reset of an element state has no finite value"):
        values(source, ["x1"], [1.0], 1e-6)


def test_the_first_reset_of_a_state_applies() -> None:
    resets = [{"when": "t > 0.5", "to": 3}, {"when": "t > 0.5", "to": 7}]
    assert values(rotor(states={"x1": {"rate": "0", "resets": resets}}), ["x1"], [1.0], 1e-6)[0, 0] == 3


def test_endless_jumps_are_refused() -> None:
    resets = [{"when": "x1 > 1", "to": 0}, {"when": "x1 < 0.5", "to": 2}]
    source = rotor(states={"x1": {"rate": "1", "start": 0.7, "resets": resets}})
    with pytest.raises(gelenk.StepError, match="cause each other again and again"):
        values(source, ["x1"], [1.0], 1e-6)


MISTAKES = {
    "no condition": ([{"to": 0}], "resets[1].when: found nothing"),
    "no value": ([{"when": "x1 > 1"}], "resets[1].to: found nothing"),
    "a number as a condition": ([{"when": "x1", "to": 0}], "resets[1].when"),
    "an unknown name": ([{"when": "x2 > 1", "to": 0}], "x2"),
    "no list": ({"when": "x1 > 1", "to": 0}, "a list of {when, to}"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_answered(mistake: str) -> None:
    resets, told = MISTAKES[mistake]
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(rotor(states={"x1": {"rate": "1", "resets": resets}}))
    assert "states.x1" in str(error.value)
    assert told in str(error.value)


def test_steps_with_impulses_are_refused() -> None:
    with pytest.raises(gelenk.SceneError, match="an integrator and contacts that locate events"):
        gelenk.load(relay(solver={"integrator": "moreau-jean"}))


def test_each_state_that_steps_cannot_advance_is_named() -> None:
    reset = [{"when": "x1 > 1", "to": "0"}]
    states = {name: {"rate": "1", "resets": reset} for name in ("x1", "x2")} | {"x3": {"rate": "A.a"}}
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(rotor(states=states, solver={"integrator": "moreau-jean"}))
    assert all(name in str(error.value) for name in ("states.x1.resets", "states.x2.resets", "states.x3:"))


def test_saved_scene_has_the_resets() -> None:
    loaded = gelenk.load(relay())
    assert gelenk.load(loaded.to_dict()).to_dict() == loaded.to_dict()
    assert [r["when"] for r in loaded.to_dict()["states"]["on"]["resets"]] == ["x1 > 1.0", "x1 < 0.2"]


def test_equilibria_are_refused() -> None:
    """A relay has none: rates alone would vanish halfway between its positions."""
    with pytest.raises(gelenk.UsageError, match="there may be no equilibrium where states jump"):
        gelenk.equilibrium(relay())
    with pytest.raises(gelenk.SceneError, match="as_given"):
        gelenk.load(relay(solver={"start": "equilibrium"}))


@warned.MOVING
def test_linear_model_is_that_between_jumps() -> None:
    found = gelenk.linearize(relay())
    rates = found.A[found.state_labels.index("x1")]
    assert rates[found.state_labels.index("x1")] == pytest.approx(-1 / TAU)
    assert rates[found.state_labels.index("on")] == pytest.approx(1.5 / TAU)


@pytest.mark.parametrize("integrator", ["auto", "dirk", "ida", "rk4"])
def test_a_motion_that_jumps_triggers_at_the_communication_point(integrator: str) -> None:
    """The state is projected onto the new motion, which makes the condition true."""
    source = rotor(
        constraints={"drive": {"type": "motion", "joint": "A", "input": "position"}},
        states={"hit": {"rate": "0", "start": -1, "resets": [{"when": "A.phi > 0.5", "to": "t"}]}},
        solver={"integrator": integrator},
    )
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    simulation.step_to(0.1)
    simulation.set_input("drive.phi_ref", 1.0)
    simulation.step_to(0.2)
    assert simulation.output("A.phi") == pytest.approx(1)
    assert simulation.output("hit") == pytest.approx(0.1)
