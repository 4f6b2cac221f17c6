# SPDX-License-Identifier: BSD-3-Clause
"""Motions that follow element states: filtered set-points, held exactly, with the forces that they need."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import warned
from fmu.derivatives import in_time
from fmu.host import Fmu, Slave
from mechanisms import body, four_bar, frame, joint, scene
from scipy.integrate import solve_ivp

import gelenk

OMEGA, DAMPING, INERTIA = 8.0, 0.7, 0.28
FILTER = {"ref": "turn", "turn": f"{OMEGA}^2*(u - ref) - 2*{DAMPING}*{OMEGA}*turn"}
ADAPTIVE = ["erk", "dirk", "cvode", "cvode-adams", "ida", "auto"]


def arm(**sections: Any) -> dict[str, Any]:
    """An arm of 0.28 kg m2 about its joint follows a set-point through a filter of second order."""
    axle = joint("revolute", frame("ground"), frame("arm"), axis=[0, 0, 1], damping=0.3)
    return scene(
        {"arm": body(2.0, (0.3, 0, 0), (0, 0.1, 0.1))}, {"A": axle}, gravity=[0, -9.81, 0],
        inputs={"u": {"unit": "rad", "start": 1.0}}, states=FILTER,
        constraints={"M": {"type": "motion", "joint": "A", "law": "ref"}},
    ) | sections  # fmt: skip


def driven(law: str, key: str = "law") -> dict[str, Any]:
    return {"constraints": {"M": {"type": "motion", "joint": "A", key: law}}}


def step_response(t: Any) -> Any:
    fast, decay = OMEGA * np.sqrt(1 - DAMPING**2), -DAMPING * OMEGA
    return 1 - np.exp(decay * t) * (np.cos(fast * t) - decay / fast * np.sin(fast * t))


def torque(result: Any) -> Any:
    gravity = 2.0 * 9.81 * 0.3 * np.cos(result["A.phi"])
    return INERTIA * result["A.a"] + 0.3 * result["A.w"] + gravity


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_step_of_the_set_point(integrator: str, tolerance: float) -> None:
    """The filter's step response (closed form), and the torque of Newton's equation at each instant."""
    of = arm(solver={"integrator": integrator})
    result = gelenk.simulate(of, stop=2.0, step=0.01, tolerance=tolerance)
    bound = 1e-9 if integrator == "rk4" else 10 * tolerance
    np.testing.assert_allclose(result["A.phi"], step_response(result["time"]), atol=bound)
    np.testing.assert_allclose(result["A.phi"], result["ref"], atol=1e-12)
    np.testing.assert_allclose(result["A.w"], result["turn"], atol=1e-12)
    np.testing.assert_allclose(result["A.a"], result["turn.rate"], atol=1e-11)
    np.testing.assert_allclose(result["M.tau"], torque(result), atol=1e-10)


@pytest.mark.parametrize(
    "formulation",
    ["projection", "baumgarte", "udwadia-kalaba", "penalty", "augmented-lagrangian", "independent"],
)
@pytest.mark.parametrize("integrator", ["erk", "dirk"])
def test_formulations_agree(formulation: str, integrator: str) -> None:
    """A crank follows the filter: the rocker is where the same motion as a function of time brings it."""
    of, by_time = (four_bar(damping=0.2) for _ in range(2))
    fast, decay = OMEGA * (1 - DAMPING**2) ** 0.5, -DAMPING * OMEGA
    for one, law in (
        (of, "1.1 + ref"),
        (by_time, f"2.1 - exp({decay!r}*t)*(cos({fast!r}*t) - {decay / fast!r}*sin({fast!r}*t))"),
    ):
        one.pop("motors")
        one["constraints"] = {"M": {"type": "motion", "joint": "A", "law": law}}
        one["joints"]["A"]["start"] = {"phi": 1.1}
    of |= {"inputs": {"u": {"start": 1.0}}, "states": FILTER}
    of["solver"] = {"formulation": formulation, "integrator": integrator}
    found, expected = (gelenk.simulate(one, stop=1.0, step=0.01, tolerance=1e-9) for one in (of, by_time))
    accuracy = {"penalty": 1e-4, "baumgarte": 1e-6, "udwadia-kalaba": 1e-6}.get(formulation, 1e-7)
    for name in ("D.phi", "D.w"):
        np.testing.assert_allclose(found[name], expected[name], atol=accuracy)
    if formulation == "projection":
        np.testing.assert_allclose(found["M.tau"], expected["M.tau"], atol=1e-5)


@pytest.mark.parametrize("integrator", ["auto", "dirk", "rk4"])
def test_speed_of_a_first_order_filter(integrator: str) -> None:
    """Modelica's Speed with exact=false: w' = (u - w)/T, any start value of the angle."""
    of = arm(
        states={"w_ref": "(u - w_ref)/0.2"},
        constraints={"M": {"type": "motion", "joint": "A", "speed_law": "w_ref"}},
        solver={"integrator": integrator},
    )  # fmt: skip
    of["joints"]["A"]["start"] = {"phi": 0.4}
    result = gelenk.simulate(of, stop=2.0, step=0.01, tolerance=1e-9)
    t = result["time"]
    np.testing.assert_allclose(result["A.w"], 1 - np.exp(-t / 0.2), atol=1e-8)
    np.testing.assert_allclose(result["A.phi"], 0.4 + t - 0.2 * (1 - np.exp(-t / 0.2)), atol=1e-8)
    np.testing.assert_allclose(result["M.tau"], torque(result), atol=1e-9)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_limited_acceleration_is_located(integrator: str) -> None:
    """A bang-bang motion: 2 rad/s2, then -2 rad/s2: a triangle of the speed. Jumps are events."""
    of = arm(
        inputs={}, states={"ref": "turn", "turn": "if(t < 1.05, 2, if(t < 2.1, -2, 0))"},
        solver={"integrator": integrator},
    )  # fmt: skip
    result = gelenk.simulate(of, stop=3.0, step=0.1, tolerance=1e-8)
    t = result["time"]
    w = np.where(t < 1.05, 2 * t, np.where(t < 2.1, 2.1 - 2 * (t - 1.05), 0))
    np.testing.assert_allclose(result["A.w"], w, atol=1e-9)
    np.testing.assert_allclose(result["A.phi"][-1], 1.05 * 2.1, atol=1e-9)
    np.testing.assert_allclose(result["M.tau"], torque(result), atol=1e-9)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_friction_of_the_driven_joint(integrator: str) -> None:
    """At rest until the set-point jumps; from then on friction opposes the motion of the filter."""
    of = arm(solver={"integrator": integrator})
    of["joints"]["A"]["friction"] = {"coulomb": 1.0}
    result = gelenk.simulate(
        of, inputs={"u": lambda t: 0.0 if t < 0.495 else 1.0}, stop=1.5, step=0.01, tolerance=1e-9
    )
    t = result["time"]
    moving = t > 0.505
    expected = np.where(t > 0.5, step_response(np.maximum(t - 0.5, 0)), 0)
    np.testing.assert_allclose(result["A.phi"], expected, atol=1e-8)
    np.testing.assert_allclose(result["A.friction.tau"][moving], -np.sign(result["A.w"][moving]), atol=1e-9)
    with_friction = torque(result)[moving] - result["A.friction.tau"][moving]
    np.testing.assert_allclose(result["M.tau"][moving], with_friction, atol=1e-8)


def test_motions_that_friction_holds_back_are_named() -> None:
    of = arm(states={}, inputs={}, constraints={"M": {"type": "motion", "joint": "A", "law": "t^3"}})
    of["joints"]["A"]["friction"] = {"coulomb": 1.0}
    with pytest.raises(
        gelenk.StepError, match="friction may be holding at rest what a prescribed motion moves"
    ):
        gelenk.simulate(of, stop=0.1, step=0.01)


@pytest.mark.parametrize(("integrator", "step"), [("erk", 3.0), ("dirk", 0.1), ("cvode", 0.1), ("rk4", 0.01)])
def test_accelerations_that_jump_at_points_of_tables(integrator: str, step: float) -> None:
    """A pendulum on a cart whose speed is a linear table and a state that is 0, piece by piece with SciPy."""
    points, values = [0.0, 0.5, 1.1, 2.0, 3.0], [0.0, 0.0, 1.0, 1.0, 0.5]
    of = scene(
        {"cart": body(1.0), "bob": body(1.0, (0, -0.5, 0), (0, 0, 0.02))},
        {
            "S": joint("prismatic", frame("ground"), frame("cart"), axis=[1, 0, 0]),
            "P": joint("revolute", frame("cart"), frame("bob"), axis=[0, 0, 1], start={"phi": 0.3}),
        },
        gravity=[0, -9.81, 0], states={"ref": "-ref"},
        tables={"T": {"x": points, "values": values, "interpolation": "linear"}},
        constraints={"M": {"type": "motion", "joint": "S", "speed_law": "table(T, t) + ref"}},
        solver={"integrator": integrator},
    )  # fmt: skip
    y = np.array([0.3, 0.0])
    for k, begin in enumerate(points[:-1]):
        a = (values[k + 1] - values[k]) / (points[k + 1] - begin)

        def rate(_: float, y: Any, a: float = a) -> list[float]:
            return [y[1], -0.5 * (9.81 * np.sin(y[0]) + a * np.cos(y[0])) / 0.27]

        y = solve_ivp(rate, (begin, points[k + 1]), y, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    result = gelenk.simulate(of, stop=3.0, step=step, tolerance=1e-9)
    np.testing.assert_allclose([result["P.phi"][-1], result["P.w"][-1]], y, atol=1e-7)
    np.testing.assert_allclose(result["S.s"][-1], 0.3 + 0.9 + 0.75, atol=1e-9)


def test_components_and_inputs_that_jump() -> None:
    """Of a second_order component; the torque jumps with the input, position and speed do not."""
    of = arm(
        states={}, components={"F": {"type": "second_order", "input": "u", "natural_frequency": 8.0}},
        constraints={"M": {"type": "motion", "joint": "A", "law": "F.y"}},
    )  # fmt: skip
    result = gelenk.simulate(of, inputs={"u": lambda t: 1.0 if t < 0.5 else -1.0}, stop=1.0, step=0.005)
    np.testing.assert_allclose(result["M.tau"], torque(result), atol=1e-9)
    assert np.diff(result["M.tau"]).min() < -2 * INERTIA * OMEGA**2 + 5
    assert np.abs(np.diff(result["A.w"])).max() < 2.1 * OMEGA**2 * 0.005


@warned.MOVING
def test_linear_model() -> None:
    """The coordinate is no state: those of the filter are, and the torque by hand."""
    model = gelenk.linearize(arm(), outputs=["A.phi", "A.w", "M.tau"])
    assert list(model.state_labels) == ["ref", "turn"]
    np.testing.assert_allclose(model.A, np.array([[0, 1], [-(OMEGA**2), -2 * DAMPING * OMEGA]]), rtol=1e-13)
    np.testing.assert_allclose(model.B, np.array([[0], [OMEGA**2]]), rtol=1e-13)
    of_rate = 0.3 - INERTIA * 2 * DAMPING * OMEGA
    C = np.array([[1, 0], [0, 1], [-INERTIA * OMEGA**2, of_rate]])
    np.testing.assert_allclose(model.C, C, rtol=1e-12)
    np.testing.assert_allclose(model.D, np.array([[0], [0], [INERTIA * OMEGA**2]]), rtol=1e-12)


def test_equilibrium() -> None:
    rest = gelenk.equilibrium(arm(inputs={"u": {"unit": "rad", "start": 0.6}}))
    assert rest.values["A.phi"] == pytest.approx(0.6, abs=1e-9)
    assert rest.values["M.tau"] == pytest.approx(2 * 9.81 * 0.3 * np.cos(0.6), rel=1e-9)


def test_derivatives_in_time(tmp_path: Path) -> None:
    """First and second time derivatives of outputs, against those of the filter."""
    path = gelenk.export_fmu(arm(), tmp_path / "arm.fmu")
    s = Slave(Fmu(fmpy.extract(str(path), str(tmp_path / "arm")))).start()
    s.run(20)
    for pair in (("A.phi", "ref"), ("A.w", "turn"), ("A.a", "turn.rate")):
        for order in (1, 2):
            found, expected = in_time(s, pair, order)
            assert found == pytest.approx(expected, rel=1e-10, abs=1e-10), (pair, order)


def test_gradients() -> None:
    of = arm(experiment={"stop": 1.0, "step": 0.1, "tolerance": 1e-11}, parameters=["arm.mass"])
    exact = gelenk.sensitivity(of, ["arm.mass", "u"], outputs=["M.tau", "A.phi"])
    runs = [gelenk.simulate(of, parameters={"arm.mass": 2.0 + h})["M.tau"] for h in (-1e-3, 1e-3)]
    np.testing.assert_allclose(exact.derivative("M.tau", "arm.mass"), (runs[1] - runs[0]) / 2e-3, rtol=1e-6)
    np.testing.assert_allclose(exact.derivative("A.phi", "u"), step_response(exact.time), atol=1e-7)


@pytest.mark.parametrize("integrator", ["auto", "dirk", "cvode"])
def test_saved_states_go_on_to_the_bit(integrator: str) -> None:
    simulation = gelenk.Simulation(arm(solver={"integrator": integrator}))
    simulation.initialize(0.0, 1e-7)
    simulation.step_to(0.2)
    saved, runs = simulation.save(), []
    for _ in range(2):
        simulation.set_input("u", -0.5)
        run = []
        for k in range(10):
            simulation.step_to(0.2 + 0.05 * (k + 1))
            run.append([simulation.output(name) for name in ("A.phi", "A.w", "ref", "M.tau")])
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


def test_time_and_states_together(tmp_path: Path) -> None:
    """Both in one law; and an FMU that runs as the scene."""
    of = arm(experiment={"stop": 1.0, "step": 0.05, "tolerance": 1e-9})
    of["constraints"]["M"]["law"] = "ref*t/(1 + t)"
    expected = gelenk.simulate(of)
    gelenk.export_fmu(of, tmp_path / "arm.fmu")
    found = fmpy.simulate_fmu(
        str(tmp_path / "arm.fmu"),
        stop_time=1.0,
        step_size=0.05,
        output_interval=0.05,
        output=["A.phi", "M.tau"],
    )
    for name in ("A.phi", "M.tau"):
        np.testing.assert_allclose(found[name], expected[name], atol=1e-7)
    t = expected["time"]
    np.testing.assert_allclose(expected["A.phi"], step_response(t) * t / (1 + t), atol=1e-8)


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        (driven("u"), "M.law: found the input 'u' in its value"),
        ({"states": {"ref": "u - ref"}}, "M.law: found the input 'u' in its speed.*second_order"),
        (driven("abs(ref)"), "a kink in its value"),
        (driven("A.w*ref"), "'A.w', which moves with"),
        ({"states": {"ref": "turn", "turn": "A.w"}}, "'A.w', which moves with"),
        ({"states": {"ref": "turn", "turn": "M.tau - turn"}}, "'turn', whose rate names forces"),
        (
            {"states": FILTER | {"turn": {"rate": "u", "resets": [{"when": "ref > 1", "to": "0"}]}}},
            "jumps at its resets",
        ),
        (
            {
                "tables": {"T": {"x": [0, 1, 2], "values": [0, 1, 1], "interpolation": "linear"}},
                "constraints": {"M": {"type": "motion", "joint": "A", "law": "ref + table(T, t)"}},
            },
            "a table in its value whose derivative jumps",
        ),
        ({"solver": {"formulation": "index3", "integrator": "ida"}}, "'index3' with constraints.M, which"),
        ({"solver": {"integrator": "moreau-jean"}}, "constraints.M: found a motion that follows states with"),
        (driven("u", "speed_law"), "the input 'u' in its speed"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_said(sections: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=f"(?s){message}"):
        gelenk.load(arm(**sections))
