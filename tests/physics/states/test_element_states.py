# SPDX-License-Identifier: BSD-3-Clause
"""States of elements in runs: closed forms, loops, events, saved states, other units, mistakes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from circuits import VOLTAGE, J, dc_exact, dc_motor, rotor, values
from mechanisms import body, four_bar, frame, joint, scene
from scipy.linalg import expm

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
FORMULATIONS = ["projection", "independent", "baumgarte", "penalty", "augmented-lagrangian"]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_step_of_a_filter_and_of_a_motor(integrator: str, tolerance: float) -> None:
    """Ten tolerances, relative to the largest value."""
    times = [0.01, 0.05, 0.1, 0.3, 1.0, 3.0]
    source = dc_motor(solver={"integrator": integrator})
    source["states"]["slow"] = "(u - slow)/0.2"
    found = values(source, ["A.w", "i", "slow"], times, tolerance)
    exact = np.array([[*dc_exact(t), VOLTAGE * (1 - math.exp(-t / 0.2))] for t in times])
    finest = 1e-10 if integrator in ("auto", "erk", "dirk") else 1e-9
    assert np.abs(found - exact).max() <= 10 * max(tolerance, finest) * np.abs(exact).max()


@pytest.mark.parametrize(
    ("integrator", "order"), [("rk4", 4), ("generalized-alpha", 2), ("hht", 2), ("euler", 1)]
)
def test_fixed_steps_keep_their_order(integrator: str, order: int) -> None:
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        source = dc_motor(solver={"integrator": integrator, "step": step})
        errors.append(np.abs(values(source, ["A.w", "i"], [0.2], 1e-6)[0] - dc_exact(0.2)).max())
    assert errors[0] / errors[1] > 0.85 * 2**order
    assert errors[1] / errors[2] > 0.85 * 2**order


@pytest.mark.parametrize("formulation", [*FORMULATIONS, "index3", "stabilized-index2"])
@pytest.mark.parametrize("integrator", ["dirk", "ida", "cvode", "generalized-alpha"])
def test_motor_in_a_loop_is_the_same_by_all_formulations(formulation: str, integrator: str) -> None:
    """A driven four-bar: the explicit method without index reduction is the reference."""
    if formulation == "index3" and integrator in ("dirk", "cvode"):
        pytest.skip("not combined")
    if formulation == "stabilized-index2" and integrator != "ida":
        pytest.skip("not combined")

    def driven(**solver: Any) -> dict[str, Any]:
        source = four_bar(1.1, damping=0.0)
        source.pop("motors", None)
        source["joints"]["A"]["law"] = {"effort": "0.8*i"}
        return source | {"states": {"i": "(6 - i - 0.8*A.w + C.w)/0.01"}, "solver": solver}

    names = ["i", "A.phi", "A.w", "C.phi", "C.w"]
    times = [0.1, 0.2, 0.4]
    truth = values(driven(integrator="erk"), names, times, 1e-11)
    source = driven(formulation=formulation, integrator=integrator, step=1e-4)
    loose = integrator == "generalized-alpha" or formulation in ("baumgarte", "penalty", "index3")
    found = values(source, names, times, 1e-9)
    np.testing.assert_allclose(found, truth, rtol=0, atol=3e-4 if loose else 3e-7)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4", "generalized-alpha"])
def test_saved_state_repeats_the_run(integrator: str) -> None:
    source = dc_motor(solver={"integrator": integrator})
    names = ["A.phi", "A.w", "A.a", "i"]
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-7)
    for k in range(20):
        simulation.step_to(0.01 * (k + 1))
    saved = simulation.save()
    runs = []
    for _ in range(2):
        simulation.set_input("u", -5.0)
        run = []
        for k in range(20, 40):
            simulation.step_to(0.01 * (k + 1))
            run.append([simulation.output(name) for name in names])
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


@pytest.mark.parametrize("nominal", [1e-6, None])
def test_nominal_value_scales_the_tolerance(nominal: float | None) -> None:
    """An oscillation of 1e-6 C: without its size the tolerance of 1e-4 does not see it."""
    size = {} if nominal is None else {"nominal": nominal}
    states = {
        "charge": {"rate": "9*other", "unit": "A.s", "start": 1e-6} | size,
        "other": {"rate": "-9*charge", "unit": "A.s"} | size,
    }
    found = values(rotor(states=states), ["charge"], [5.0], 1e-4)[0, 0]
    error = abs(found / 1e-6 - math.cos(45))
    assert (error < 0.05) == (nominal is not None)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_states_are_in_si_units_at_any_size(size: float) -> None:
    """A series spring and damper (Maxwell) on a mass: x' = (s - x)/T, force -k (s - x)."""
    k, T = 100.0, 0.3
    source = scene(
        {"mass": body(size**3)},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("mass", (size, 0, 0)), axis=[1, 0, 0],
                start={"s": 0.5 * size},
                law={"effort": f"-{k * size**3}*(s - x1)"},
            )
        },
        states={"x1": {"rate": f"(S.s - x1)/{T}", "unit": "m", "nominal": size}},
    )  # fmt: skip
    A = np.array([[0, 1, 0], [-k, 0, k], [1 / T, 0, -1 / T]])
    for t, found in zip([0.2, 1.0], values(source, ["S.s", "S.v", "x1"], [0.2, 1.0], 1e-10), strict=True):
        np.testing.assert_allclose(found / size, expm(A * t) @ [0.5, 0, 0], rtol=0, atol=1e-8)


def test_states_alone_move_where_no_body_does() -> None:
    """Bodies that are fixed, and one that moves apart from the states."""
    source = scene(
        {"plate": body(1.0)},
        {"W": joint("weld", frame("ground"), frame("plate"))},
        states={"c": {"rate": "w0*sn", "start": 1.0}, "sn": "-w0*c"},
        constants={"w0": 3.0},
    )
    found = values(source, ["c", "sn"], [1.0, 2.0], 1e-10)
    exact = [[math.cos(3 * t), -math.sin(3 * t)] for t in (1.0, 2.0)]
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9)


def test_integral_with_a_limit_is_switched_at_events() -> None:
    """Speed control with a limited torque and an integral that waits there: pieces of linear motion."""
    kp, ki, most, target = 4.0, 8.0, 1.5, 2.0
    wanted = f"{kp}*({target} - A.w) + {ki}*e"
    source = rotor(
        effort=f"clip({wanted}, -{most}, {most})",
        states={"e": f"if(({wanted} > {most}) or ({wanted} < -{most}), 0, {target} - A.w)"},
    )
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-9)
    leaves = J * (target - most / kp) / most  # saturated from rest until kp (target - w) = most
    simulation.step_to(leaves)
    assert simulation.output("A.w") == pytest.approx(most / J * leaves, abs=1e-9)
    assert simulation.output("e") == pytest.approx(0, abs=1e-9)
    A = np.array([[-kp / J, ki / J], [-1, 0]])
    for t in (0.1, 0.5, 2.0):
        simulation.step_to(leaves + t)
        error = [simulation.output("A.w") - target, simulation.output("e")]
        np.testing.assert_allclose(error, expm(A * t) @ [most / J * leaves - target, 0], rtol=0, atol=1e-8)
    assert simulation.diagnostic("solver.events") <= 4  # two conditions name this instant twice
    assert simulation.diagnostic("solver.evaluations") < 3000


@pytest.mark.parametrize(
    ("states", "message"),
    [
        ({"q1": "2*nothing"}, "states.q1.*nothing"),
        ({"q1": {"start": 1.0}}, "states.q1.*rate"),
        ({"q1": "A.psi"}, "A.psi.*did you mean 'A.phi'"),
        ({"R": "1"}, "states.R.*constants.R"),
        ({"phi": "1"}, "the name 'phi', which has a meaning of its own"),
        ({"q1": {"rate": "1", "unit": "furlong"}}, "states.q1.unit.*furlong"),
        ({"q1": {"rate": "1", "nominal": 0}}, "states.q1.nominal"),
        ({"q1": 3}, "states.q1.*an expression"),
    ],
)
def test_mistakes_are_errors_of_the_scene(states: dict[str, Any], message: str) -> None:
    source = rotor(states=states, constants={"R": 1.0})
    with pytest.raises(gelenk.SceneError, match=r"(?s)" + message):
        gelenk.Simulation(source)


@pytest.mark.parametrize("integrator", ["dirk", "cvode", "auto"])
def test_kink_that_is_approached_and_not_passed_costs_nothing(integrator: str) -> None:
    """A follower of the time, 0.01 s behind, near the limit of its rate: x = t - 0.01 (1 - exp(-100 t))."""
    source = rotor(states={"lag": "min(100*(t - lag), 1.01)"}, solver={"integrator": integrator})
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    simulation.step_to(1.0)
    assert simulation.output("lag") == pytest.approx(0.99, abs=1e-6)
    assert simulation.diagnostic("solver.evaluations") < 2000


@pytest.mark.parametrize("integrator", ["auto", "dirk", "ida"])
def test_state_that_grows_without_bound_is_named(integrator: str) -> None:
    """The solution 1/(1 - t) ends at 1 s; and a rate that is not defined at the start."""
    source = rotor(states={"q1": {"rate": "q1^2", "start": 1.0}}, solver={"integrator": integrator})
    with pytest.raises(gelenk.StepError, match=r"the state q1 grows without bound"):
        values(source, ["q1"], [2.0], 1e-6)
    source = rotor(states={"q1": "1/q1"}, solver={"integrator": integrator})
    with pytest.raises(gelenk.GelenkError, match=r"the rate of the state q1 is not finite"):
        values(source, ["q1"], [2.0], 1e-6)
