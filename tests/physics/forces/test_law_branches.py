# SPDX-License-Identifier: BSD-3-Clause
"""Laws with kinks and jumps: closed forms on each branch, the same laws as elements, events, saved states."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, rod, scene
from scipy.integrate import solve_ivp

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
FIXED = ["rk4", "euler"]


def slide(effort: str, start: dict[str, Any], gravity: float = 0.0, **more: Any) -> dict[str, Any]:
    """A mass of 1 kg on a slide along x."""
    solver = more.pop("solver", {})
    out = scene(
        {"mass": body(1.0, com=(0, 0, 0))},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], start=start,
                law={"effort": effort}, **more.pop("joint", {}),
            )
        },
        gravity=[gravity, 0, 0],
        solver=solver,
    )  # fmt: skip
    return out | more


def final(description: dict[str, Any], times: list[float], tolerance: float) -> np.ndarray:
    simulation = gelenk.Simulation(description)
    simulation.initialize(0.0, tolerance)
    out = []
    for t in times:
        simulation.step_to(t)
        out.append([simulation.output("S.s"), simulation.output("S.v")])
    return np.array(out)


def bilinear(t: float, amplitude: float, k1: float, k2: float) -> tuple[float, float]:
    """An oscillation with k1 where s > 0 and k2 where s < 0, from rest at the amplitude (1 kg)."""
    w1, w2 = math.sqrt(k1), math.sqrt(k2)
    t %= math.pi / w1 + math.pi / w2
    first, second = math.pi / w1 / 2, math.pi / w2
    if t > first + second:
        t -= second + 2 * first  # before the maximum
    if t <= first:
        return amplitude * math.cos(w1 * t), -amplitude * w1 * math.sin(w1 * t)
    below = amplitude * w1 / w2
    return -below * math.sin(w2 * (t - first)), -below * w2 * math.cos(w2 * (t - first))


def assert_bilinear(law: dict[str, Any], tolerance: float) -> None:
    """With 100 and 400 N/m from rest at 0.5 m: ten tolerances, and as much for each radian."""
    times = [0.1 * k for k in range(1, 31)]
    found = final(law, times, tolerance)
    exact = np.array([bilinear(t, 0.5, 100.0, 400.0) for t in times])
    bound = 10 * tolerance * (1 + 20 * np.array(times))
    assert np.all(np.abs(found[:, 0] - exact[:, 0]) <= bound)
    assert np.all(np.abs(found[:, 1] - exact[:, 1]) <= 20 * bound)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_bilinear_spring(integrator: str, tolerance: float) -> None:
    """Ten tolerances, and as much for each radian of phase that has passed."""
    law = slide("-if(s > 0, 100*s, 400*s)", {"s": 0.5}, solver={"integrator": integrator})
    assert_bilinear(law, tolerance)


def test_fixed_steps_end_at_kinks_and_keep_their_order() -> None:
    """Halved steps: errors of rk4 fall by 16, those of steps that cross the kinks by 4 or less."""
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        law = slide("-if(s > 0, 100*s, 400*s)", {"s": 0.5}, solver={"integrator": "rk4", "step": step})
        found = final(law, [1.0], 1e-6)[0]
        errors.append(np.abs(found - bilinear(1.0, 0.5, 100.0, 400.0)).max())
    assert errors[0] / errors[1] > 14
    assert errors[1] / errors[2] > 14


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_quadratic_drag_through_rest(integrator: str) -> None:
    """Thrown up at 2 terminal speeds: v = vt tan(atan(2) - g t/vt), then -vt tanh(g (t - top)/vt)."""
    g, vt = 9.81, 3.0
    law = slide(
        f"-{g}/{vt}^2*v*abs(v)", {"s": 0.0, "v": 2 * vt}, -g, solver={"integrator": integrator, "step": 1e-3}
    )
    top = vt / g * math.atan(2)
    times = [0.1, 0.3, 0.6, 1.0, 3.0]
    found = final(law, times, 1e-9)
    for t, (_, v) in zip(times, found, strict=True):
        rises = t < top
        exact = vt * math.tan(math.atan(2) - g * t / vt) if rises else -vt * math.tanh(g * (t - top) / vt)
        assert v == pytest.approx(exact, abs=1e-7)


def test_rest_on_a_kink_costs_no_events() -> None:
    """A damped oscillation about the kink of v |v| dies out; rounding there is no change of branch."""
    law = slide("-100*s - 20*v - 3*v*abs(v)", {"s": 0.1})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(5.0)
    before = simulation.diagnostic("solver.events")
    simulation.step_to(50.0)
    assert simulation.diagnostic("solver.events") - before <= 2
    assert simulation.diagnostic("solver.evaluations") < 20_000


@pytest.mark.parametrize("integrator", [*ADAPTIVE, *FIXED])
def test_force_that_is_switched_on_at_a_time(integrator: str) -> None:
    """From rest, 3 N from 0.5037 s on: s = 3/2 (t - 0.5037)^2, exactly what every method of order 2 gives."""
    law = slide("if(t < 0.5037, 0, 3)", {"s": 0.0}, solver={"integrator": integrator, "step": 1e-2})
    times = [0.4, 0.5, 0.51, 0.7, 1.0]
    found = final(law, times, 1e-8)
    first_order = 2e-2 if integrator == "euler" else 1e-9
    for t, (s, v) in zip(times, found, strict=True):
        since = max(0.0, t - 0.5037)
        assert s == pytest.approx(1.5 * since**2, abs=first_order)
        assert v == pytest.approx(3 * since, abs=1e-9)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "cvode", "ida"])
def test_expression_of_a_stop_is_the_stop(integrator: str) -> None:
    """A damped stop pushes with max(0, ...) beyond its bound: kinks, and a jump where contact begins."""
    start = {"s": 0.4}
    by_law = slide(
        "if(s < 0, max(0, -2000*s - 10*v), 0)", start, -9.81, solver={"integrator": integrator, "step": 1e-3}
    )
    by_stop = slide(
        "0", start, -9.81, solver={"integrator": integrator, "step": 1e-3},
        joint={"stop": {"lower": 0.0, "stiffness": 2000.0, "damping": 10.0}},
    )  # fmt: skip
    times = [0.1 * k for k in range(1, 21)]
    found = final(by_law, times, 1e-9)
    expected = final(by_stop, times, 1e-9)
    assert np.abs(found - expected).max() < 2e-7


def test_events_name_the_law() -> None:
    law = slide("-if(s > 0, 100*s, 400*s)", {"s": 0.5})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(1.0)
    # Half periods of 0.314 and 0.157 s: zeros at 0.157, 0.314, 0.628, 0.785 s.
    assert simulation.diagnostic("solver.events") == 4


def test_law_that_jumps_back_and_forth_is_refused_by_name() -> None:
    """sign(v) as dry friction has no motion on either branch once it is at rest: friction is for that."""
    law = slide("-5*sign(v)", {"s": 0.0, "v": 1.0})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    with pytest.raises(gelenk.StepError, match=r"S\.law changes its branch"):
        simulation.step_to(1.0)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_saved_state_repeats_the_run(integrator: str) -> None:
    law = slide(
        "-if(s > 0, 100*s, 400*s) - 0.1*v*abs(v) + if(t < 0.7, 2*u, sin(5*t))", {"s": 0.5},
        solver={"integrator": integrator, "step": 1e-3}, inputs={"u": {"unit": "N"}},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-7)
    simulation.set_input("u", 1.5)
    simulation.step_to(0.3)
    saved = simulation.save()
    runs = []
    for _ in range(2):
        run = []
        for k in range(1, 12):
            simulation.set_input("u", 1.5 - 0.1 * k)
            simulation.step_to(0.3 + 0.07 * k)
            run.append(simulation.values().tobytes())
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


def controlled(**solver: Any) -> dict[str, Any]:
    """A pendulum with a limited controller of its angle, whose set-point is an input."""
    hinge = joint(
        "revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 0.1},
        law={"effort": "clip(k*(set - phi) - 2*d*w, -limit, limit)"},
    )  # fmt: skip
    out = scene({"rod": rod(1.0, 0.5)}, {"A": hinge}, gravity=[0, -9.81, 0], solver=solver)
    out["constants"] = {"k": 30.0, "d": 1.5, "limit": 6.0}
    out["inputs"] = {"set": {"unit": "rad", "start": 0.5, "text": "set-point of the angle"}}
    out["parameters"] = ["k", "limit", "rod.mass"]
    return out


def test_inputs_and_constants_of_expressions() -> None:
    """The same torque by a motor, which a master computes where it is smooth: held over 20 us."""
    simulation = gelenk.Simulation(controlled())
    assert [signal.name for signal in simulation.inputs] == ["set"]
    simulation.initialize(0.0, 1e-8)
    plain = scene(
        {"rod": rod(1.0, 0.5)},
        {"A": joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 0.1})},
        gravity=[0, -9.81, 0],
    )
    plain["motors"] = {"M": {"joint": "A"}}
    master = gelenk.Simulation(plain | {"solver": {"integrator": "rk4", "step": 2e-5}})
    master.initialize(0.0, 1e-8)
    steps, h = 25_000, 2e-5
    for k in range(steps):
        phi, w = master.output("A.phi"), master.output("A.w")
        master.set_input("M.tau", float(np.clip(30 * (0.5 - phi) - 3 * w, -6, 6)))
        master.step_to((k + 1) * h)
    simulation.step_to(steps * h)
    assert simulation.output("A.phi") == pytest.approx(master.output("A.phi"), abs=3e-5)


def test_linear_model_of_a_law_with_an_input() -> None:
    """At rest upright: A = [[0, 1], [-(k + m g l)/I, -2 d/I]], B = [0, k/I]; beyond the limit B is 0."""
    source = controlled()
    source["joints"]["A"]["start"] = {"phi": -math.pi / 2}
    source["inputs"]["set"]["start"] = -math.pi / 2
    model = gelenk.linearize(source, states=["A.phi", "A.w"], inputs=["set"])
    inertia = 1.0 * 0.5**2 / 3
    weight = 1.0 * 9.81 * 0.25
    truth = np.array([[0, 1], [-(30 + weight) / inertia, -3.0 / inertia]])
    np.testing.assert_allclose(np.asarray(model.A), truth, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(np.asarray(model.B), np.array([[0], [30 / inertia]]), rtol=1e-12)


def test_constants_are_parameters(tmp_path: Any) -> None:
    """Set before a run, they change the law: as if they had been written in the file; also in an FMU."""
    source = controlled()
    other = controlled()
    other["constants"]["k"] = 11.0
    expected = gelenk.simulate(gelenk.load(other), stop=0.5, step=0.1)
    plant = gelenk.load(source)
    direct = gelenk.simulate(plant, stop=0.5, step=0.1, parameters={"k": 11.0})
    fmu = gelenk.export_fmu(plant, tmp_path / "k.fmu")
    through_fmu = gelenk.simulate(fmu, stop=0.5, step=0.1, parameters={"k": 11.0})
    np.testing.assert_array_equal(np.asarray(direct["A.phi"]), np.asarray(expected["A.phi"]))
    np.testing.assert_allclose(
        np.asarray(through_fmu["A.phi"]), np.asarray(expected["A.phi"]), rtol=0, atol=1e-12
    )
    assert plant.to_dict()["constants"] == {"k": 30.0, "d": 1.5, "limit": 6.0}


# Hertz' contact and the like are not defined beyond their kinks.
UNDEFINED = {
    "hertz": ("1e4*max(0, -s)^1.5", {"s": 0.1}, -9.81),
    "hertz by if": ("if(s < 0, 1e4*(-s)^1.5, 0)", {"s": 0.1}, -9.81),
    "orifice": ("-5*s - 0.3*sqrt(abs(v))*sign(v)", {"s": 0.1}, 0.0),
    "logarithm": ("-20*s - if(s > 0.01, log(s), 0)*0.1", {"s": 0.1}, 0.0),
}


@pytest.mark.parametrize("name", UNDEFINED)
@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_branches_that_are_undefined_beyond_their_kink(integrator: str, name: str) -> None:
    """As by SciPy, which may pass the kinks, at 1e-12."""
    if (name, integrator) == ("orifice", "dirk"):
        pytest.skip("refuses the start at rest, where the derivative is infinite")
    effort, start, gravity = UNDEFINED[name]
    force = {
        "hertz": lambda s, _: 1e4 * max(0.0, -s) ** 1.5,
        "hertz by if": lambda s, _: 1e4 * max(0.0, -s) ** 1.5,
        "orifice": lambda s, v: -5 * s - 0.3 * math.copysign(math.sqrt(abs(v)), v),
        "logarithm": lambda s, _: -20 * s - (math.log(s) if s > 0.01 else 0.0) * 0.1,
    }[name]
    exact = solve_ivp(
        lambda _, y: [y[1], force(y[0], y[1]) + gravity], (0, 1), [start["s"], 0.0],
        rtol=1e-12, atol=1e-13, max_step=1e-3,
    )  # fmt: skip
    law = slide(effort, start, gravity, solver={"integrator": integrator, "step": 2e-4})
    found = final(law, [0.1 * k for k in range(1, 11)], 1e-8)[-1]
    np.testing.assert_allclose(found, exact.y[:, -1], rtol=0, atol=2e-5)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "cvode"])
@pytest.mark.parametrize("condition", ["1e-14*s > 0", "1e9*s > 0", "s^5 > 0"])
def test_unit_of_a_condition_does_not_matter(condition: str, integrator: str) -> None:
    law = slide(
        f"-if({condition}, 100*s, 400*s)", {"s": 0.5}, solver={"integrator": integrator, "step": 1e-3}
    )
    times = [0.1 * k for k in range(1, 21)]
    exact = np.array([bilinear(t, 0.5, 100.0, 400.0) for t in times])
    # The zero of s^5 is flat: within rounding, 1e-13 of the values at the start of the step, it is 1e-3 wide.
    assert np.abs(final(law, times, 1e-9) - exact).max() < (1e-5 if "^" in condition else 2e-6)


@pytest.mark.parametrize("integrator", ["generalized-alpha", "hht", "newmark", "rk4", "auto", "ida"])
@pytest.mark.parametrize("at", [0.3, 0.503, 0.5004])
def test_jump_at_the_end_of_a_step_restarts_the_method(at: float, integrator: str) -> None:
    """2 N until then: v = 2 t, and one event."""
    law = slide(f"if(t < {at}, 2, 0)", {"s": 0.0}, solver={"integrator": integrator, "step": 1e-3})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    for k in range(1, 11):
        simulation.step_to(0.1 * k)
    assert simulation.output("S.v") == pytest.approx(2 * at, abs=1e-9)
    assert simulation.diagnostic("solver.events") == 1


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida", "generalized-alpha"])
@pytest.mark.parametrize(
    ("effort", "acceleration"),
    [("if(s < 0, -1, 5)", 5), ("if(s >= 0, 2, -2)", 2), ("if(s <= 0, -1, 5)", -1), ("if(s > 0, 2, -2)", -2)],
)
def test_rest_on_a_jump_begins_as_the_formula_says(effort: str, acceleration: float, integrator: str) -> None:
    law = slide(effort, {"s": 0.0}, solver={"integrator": integrator, "step": 1e-3})
    assert final(law, [0.1], 1e-8)[0][1] == pytest.approx(0.1 * acceleration, abs=1e-9)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida"])
def test_rest_on_a_limit_at_a_jump(integrator: str) -> None:
    """Pressed on its limit at 0.3 m, which it cannot pass, the law is that of s = 0.3 m: no force."""
    law = slide(
        "if(s > 0.3, 5, 0)", {"s": 0.3}, 9.81, joint={"limit": {"upper": 0.3}},
        solver={"integrator": integrator, "step": 1e-3},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(1.0)
    assert simulation.output("S.limit.f") == pytest.approx(-9.81, abs=1e-9)


@pytest.mark.parametrize("integrator", ["rk4", "euler", "generalized-alpha"])
def test_friction_against_a_law_that_drives_back_is_refused(integrator: str) -> None:
    """At rest 8 N exceed the friction of 5 N, and in motion the law is zero: no motion agrees with both."""
    law = slide(
        "if(v <= 0, 8, 0)", {"s": 0.0, "v": 1.0}, joint={"friction": {"coulomb": 5.0}},
        solver={"integrator": integrator, "step": 1e-3, "max_events": 1000},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    with pytest.raises(gelenk.StepError):
        simulation.step_to(0.3)


def test_location_takes_no_more_than_that_of_a_stop() -> None:
    """A jump at 0.7003 m: some tens of evaluations, as for a stop there."""
    simulation = gelenk.Simulation(slide("if(s > 0.7003, 3, 0)", {"s": 0.0, "v": 1.0}))
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.69)
    before = simulation.diagnostic("solver.evaluations")
    simulation.step_to(0.71)
    assert simulation.diagnostic("solver.evaluations") - before < 100
