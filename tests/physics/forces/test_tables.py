# SPDX-License-Identifier: BSD-3-Clause
"""Tables in laws: interpolations against SciPy's by energy, knots as events, times, periods."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

import gelenk

from .test_law_branches import ADAPTIVE, FIXED, assert_bilinear, final, slide

X = [-1.0, -0.4, 0.0, 0.3, 1.2]
Y = [9.0, 2.0, 0.5, -1.0, -7.0]
PERIODIC_X = np.linspace(0, 4 * math.pi, 25)
PERIODIC_Y = 20 * np.exp(-(((PERIODIC_X - 2) / 0.6) ** 2)) - 3 * np.exp(-((PERIODIC_X - 8) ** 2))
PERIODIC_Y[-1] = PERIODIC_Y[0]


def repeated(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Five periods of which the third one is the table."""
    starts = [k * x[-1] + x[:-1] for k in range(-2, 3)]
    return np.append(np.concatenate(starts), 3 * x[-1]), np.append(np.tile(y[:-1], 5), y[-1])


def as_scipy(kind: str, x: Any, y: Any, periodic: bool = False) -> Any:
    if kind == "spline":
        return CubicSpline(x, y, bc_type="periodic" if periodic else "natural")
    around = repeated(x, y) if periodic else (x, y)
    return {"pchip": PchipInterpolator, "akima": Akima1DInterpolator}[kind](*around)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_linear_table_is_a_bilinear_spring(integrator: str, tolerance: float) -> None:
    """Ten tolerances, and as much for each radian of phase that has passed; straight beyond its ends."""
    table = {
        "x": [-0.1, 0, 0.1],
        "values": [40, 0, -10],
        "interpolation": "linear",
        "extrapolation": "linear",
    }
    law = slide("table(k, s)", {"s": 0.5}, solver={"integrator": integrator}, tables={"k": table})
    assert_bilinear(law, tolerance)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize("kind", ["pchip", "akima", "spline"])
def test_smooth_tables_conserve_the_energy_of_scipys_integral(kind: str, integrator: str) -> None:
    law = slide(
        "table(k, s)", {"s": 1.1}, solver={"integrator": integrator, "step": 1e-3},
        tables={"k": {"x": X, "values": Y, "interpolation": kind}},
    )  # fmt: skip
    work = as_scipy(kind, X, Y).antiderivative()
    found = final(law, [0.25 * k for k in range(1, 40)], 1e-8)
    energy = found[:, 1] ** 2 / 2 - (work(found[:, 0]) - work(1.1))
    # 40 oscillations at a tolerance of 1e-8, with forces of up to 9 N.
    assert np.abs(energy).max() < 1e-7


def test_fixed_steps_keep_their_order_across_knots() -> None:
    """Errors of rk4 at half the step fall by 16; were the knots not events, by 8 at most."""
    errors = []
    for step in (2e-2, 1e-2, 5e-3):
        law = slide(
            "table(k, s)", {"s": 1.1}, solver={"integrator": "rk4", "step": step},
            tables={"k": {"x": X, "values": Y}},
        )  # fmt: skip
        work = as_scipy("pchip", X, Y).antiderivative()
        s, v = final(law, [2.0], 1e-6)[0]
        errors.append(abs(v * v / 2 - (work(s) - work(1.1))))
    assert errors[0] / errors[1] > 13
    assert errors[1] / errors[2] > 13


@pytest.mark.parametrize("integrator", [*ADAPTIVE, *FIXED])
def test_no_pulse_of_the_time_is_missed(integrator: str) -> None:
    """1 N s within 2 ms, in one communication step of 5 s: the velocity is 1 m/s, exactly if linear."""
    table = {"x": [0, 1, 1.001, 1.002, 5], "values": [0, 0, 1000, 0, 0], "interpolation": "linear"}
    solver = {"integrator": integrator, "step": 1e-3}
    law = slide("table(p, t)", {"s": 0.0}, solver=solver, tables={"p": table})
    s, v = final(law, [5.0], 1e-6)[0]
    assert v == pytest.approx(1, abs=1e-8)
    assert s == pytest.approx(5 - 1.001, abs=1e-3 if integrator == "euler" else 1e-7)


@pytest.mark.parametrize(
    "expression", ["table(p, t)", "table(q, 3 - 2*t)", "table(r, (t - 0.5)/0.25)", "table(w, t)"]
)
def test_tables_of_the_time_end_steps_at_their_points(expression: str) -> None:
    """A table forward, backward, shifted and scaled, and repeated: the same three pulses of 0.1 N s."""
    up = np.array([0.5, 0.6, 0.7, 1.0, 1.1, 1.2, 1.5, 1.6, 1.7])
    force = np.tile([0.0, 1.0, 0.0], 3)
    tables: dict[str, dict[str, Any]] = {
        "p": {"x": up, "values": force},
        "q": {"x": (3 - 2 * up)[::-1], "values": force[::-1]},
        "r": {"x": (up - 0.5) / 0.25, "values": force},
        "w": {"x": [0, 0.1, 0.2, 0.5], "values": [0, 1, 0, 0], "extrapolation": "periodic"},
    }
    for table in tables.values():
        table["interpolation"] = "linear"
    law = slide(expression, {"s": 0.0}, tables={expression[6]: tables[expression[6]]})
    times = [0.4999, 0.55, 0.6, 0.65, 0.9, 2.0] if expression[6] != "w" else [0.05, 0.1, 0.15, 0.4, 1.4]
    rise = {0.4999: 0.0, 0.55: 0.0125, 0.6: 0.05, 0.65: 0.0875, 0.9: 0.1, 2.0: 0.3}
    again = {0.05: 0.0125, 0.1: 0.05, 0.15: 0.0875, 0.4: 0.1, 1.4: 0.3}
    found = final(law, times, 1e-8)[:, 1]
    exact = [(again if expression[6] == "w" else rise)[t] for t in times]
    assert found == pytest.approx(exact, abs=1e-12)


def turned(kind: str, speed: float, integrator: str) -> tuple[np.ndarray, Callable[[float], float]]:
    """Positions and speeds of a mass of 1 kg under table(p, 10 s + 1), and the work from s = 0."""
    table = {
        "x": PERIODIC_X, "values": PERIODIC_Y, "interpolation": kind, "extrapolation": "periodic",
    }  # fmt: skip
    law = slide(
        "table(p, 10*s + 1)", {"s": 0.0, "v": speed}, solver={"integrator": integrator, "step": 1e-3},
        tables={"p": table},
    )  # fmt: skip
    integral = as_scipy(kind, PERIODIC_X, PERIODIC_Y, periodic=True).antiderivative()
    period = PERIODIC_X[-1]

    def work_to(x: float) -> float:
        turns = math.floor(x / period)
        return float(turns * (integral(period) - integral(0)) + integral(x - turns * period))

    found = final(law, [0.25 * k for k in range(1, 13)], 1e-8)
    return found, lambda s: (work_to(10 * s + 1) - work_to(1)) / 10


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize("speed", [8.0, -12.0])
@pytest.mark.parametrize("kind", ["pchip", "akima", "spline"])
def test_periodic_tables_over_many_turns(kind: str, speed: float, integrator: str) -> None:
    """Twenty periods and more, forward and backward: the energy is the work of SciPy's interpolation."""
    found, work = turned(kind, speed, integrator)
    assert abs(found[-1, 0]) * 10 > 20 * PERIODIC_X[-1] or speed < 0
    for s, v in found:
        # 500 knots at a tolerance of 1e-8
        assert v * v / 2 - speed**2 / 2 == pytest.approx(work(s), abs=2e-5 if integrator == "rk4" else 2e-6)


@pytest.mark.parametrize("kind", ["linear", "pchip", "akima", "spline"])
def test_two_arguments(kind: str) -> None:
    """The values along a line of points, and between four points the tensor product of the interpolations."""
    x, y = np.array([0.0, 0.5, 1.2, 2.0]), np.array([-1.0, 0.0, 0.4, 1.0, 3.0])
    z = np.sin(x)[:, None] * np.cos(y)[None, :] + 0.1 * y[None, :]
    law = slide(
        "0*s", {"s": 0.0}, tables={"map": {"x": x, "y": y, "values": z, "interpolation": kind}},
        inputs={"a": {}, "b": {}}, expressions={"f": "table(map, a, b)"},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)

    def value(a: float, b: float) -> float:
        simulation.set_input("a", a)
        simulation.set_input("b", b)
        return simulation.output("f")

    def along(points: np.ndarray, values: np.ndarray) -> Any:
        return (
            (lambda q: np.interp(q, points, values)) if kind == "linear" else as_scipy(kind, points, values)
        )

    for i, a in enumerate(x):
        for b in (-1.0, -0.3, 0.2, 0.7, 2.9, 3.0):
            assert value(a, b) == pytest.approx(float(along(y, z[i])(b)), abs=1e-14)
    for j, b in enumerate(y):
        assert value(0.8, b) == pytest.approx(float(along(x, z[:, j])(0.8)), abs=1e-14)
    if kind == "spline":  # linear in the values, so that the order does not matter
        exact = float(along(x, np.array([along(y, row)(0.7) for row in z]))(0.8))
        assert value(0.8, 0.7) == pytest.approx(exact, abs=1e-14)
    assert value(5.0, -7.0) == pytest.approx(z[-1, 0], abs=1e-14)  # both held


@pytest.mark.parametrize("how", ["hold", "linear", "refuse"])
def test_beyond_the_ends(how: str) -> None:
    table = {"x": X, "values": Y, "interpolation": "pchip", "extrapolation": how}
    law = slide("table(k, s)", {"s": 1.1, "v": 3.0}, tables={"k": table})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    if how == "refuse":
        with pytest.raises(gelenk.StepError, match="k"):
            simulation.step_to(0.2)
        return
    simulation.step_to(0.2)
    s, v = simulation.output("S.s"), simulation.output("S.v")
    assert s > 1.3
    curve = as_scipy("pchip", X, Y)
    rate = float(curve(1.2, 1)) if how == "linear" else 0.0
    work = float(curve.integrate(1.1, 1.2)) + Y[-1] * (s - 1.2) + rate * (s - 1.2) ** 2 / 2
    assert v * v / 2 - 4.5 == pytest.approx(work, abs=1e-8)


def test_rest_on_a_knot_costs_nothing() -> None:
    """At an unstable and at a stable equilibrium on a knot; the damped one comes to rest there."""
    table = {"x": [-1, 0, 1], "values": [3, 0, -1], "interpolation": "linear"}
    law = slide("table(k, s) - 2*v", {"s": 0.4}, tables={"k": table})
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(20.0)
    before = simulation.diagnostic("solver.evaluations")
    simulation.step_to(100.0)
    assert simulation.diagnostic("solver.evaluations") - before < 5000
    assert abs(simulation.output("S.s")) < 1e-9


def test_linear_model_has_the_derivative_of_the_table() -> None:
    """At rest at s = 0.2 under the force that the table balances: A from the derivative of SciPy's curve."""
    curve = as_scipy("akima", X, Y)
    law = slide(
        f"table(k, s) - {float(curve(0.2))!r}", {"s": 0.2},
        tables={"k": {"x": X, "values": Y, "interpolation": "akima"}},
    )  # fmt: skip
    model = gelenk.linearize(law)
    assert np.asarray(model.A)[1, 0] == pytest.approx(float(curve(0.2, 1)), rel=1e-13)


@pytest.mark.parametrize("integrator", ["auto", "cvode", "rk4", "dirk"])
def test_saved_between_knots_and_restored_to_the_bit(integrator: str) -> None:
    table = {"x": PERIODIC_X, "values": PERIODIC_Y, "extrapolation": "periodic"}
    pulses = {"x": [0, 0.1, 0.2, 0.5], "values": [0, 1, 0, 0], "extrapolation": "periodic"}
    law = slide(
        "table(p, 10*s) + 3*table(w, t) - 0.3*v", {"s": 0.0, "v": 4.0},
        solver={"integrator": integrator, "step": 1e-3}, tables={"p": table, "w": pulses},
    )  # fmt: skip
    one, two = gelenk.Simulation(law), gelenk.Simulation(law)
    for simulation in (one, two):
        simulation.initialize(0.0, 1e-7)
    one.step_to(0.77)
    two.restore(one.save())
    for t in (0.9, 1.3, 2.6):
        one.step_to(t)
        two.step_to(t)
        assert one.output("S.s") == two.output("S.s")
        assert one.output("S.v") == two.output("S.v")


def test_held_by_friction_until_a_table_of_the_time_exceeds_it() -> None:
    """A ramp of 1 N/s from t = 1 s on against 0.5 N: it slips at 1.5 s, wherever communication points are."""
    law = slide(
        "table(p, t)", {"s": 0.0},
        joint={"friction": {"coulomb": 0.5}},
        tables={"p": {"x": [0, 1, 3], "values": [0, 0, 2], "interpolation": "linear"}},
    )  # fmt: skip
    found = final(law, [1.4, 1.5, 2.0], 1e-9)
    assert np.abs(found[:2]).max() < 1e-12
    # v' = t - 1.5
    assert found[2] == pytest.approx([0.5**3 / 6, 0.5**2 / 2], abs=1e-8)


@pytest.mark.parametrize("steps", [1, 10, 100, 1000])
@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_no_pulse_is_missed_where_friction_holds(integrator: str, steps: int) -> None:
    """100 N for some milliseconds against 10 N of friction: 1 kg moves by what the triangle leaves."""
    table = {"x": [0, 3.3, 3.305, 3.31, 5], "values": [0, 0, 100, 0, 0], "interpolation": "linear"}
    solver = {"integrator": integrator, "step": 1e-3}
    law = slide(
        "table(p, t)", {"s": 0.0}, joint={"friction": {"coulomb": 10.0}}, solver=solver, tables={"p": table}
    )
    found = final(law, [5 * (k + 1) / steps for k in range(steps)], 1e-8)[-1]
    # From 3.3005 s on, F - 10 = 2e4 t - 10: 0.2025 N s until 3.3095 s, and 10 N s/s brake from there.
    rise, fall, end = 0.0045, 0.0045, 3.31
    top = 90.0
    v1 = top * rise / 2
    s1 = top * rise**2 / 6
    v2 = v1 + top * fall / 2
    s2 = s1 + v1 * fall + top * fall**2 / 3
    t3 = end - 3.3095  # from -0 to -10 N
    v3 = v2 - 10 * t3 / 2
    s3 = s2 + v2 * t3 - 10 * t3**2 / 6
    assert found[0] == pytest.approx(s3 + v3**2 / 20, abs=1e-8)
    assert found[1] == 0


@pytest.mark.parametrize("law", ["table(p, t)", "max(table(p, t), 0)"])
@pytest.mark.parametrize("formulation", ["projection", "stabilized-index2", "index3"])
def test_no_pulse_is_missed_by_differential_algebraic_equations(formulation: str, law: str) -> None:
    """0.5 N s within 10 ms on two coupled slides of 1 kg, in a step of 5 s: 0.25 m/s for 1.695 s."""
    slides = {
        name: joint("prismatic", frame("ground"), frame(name), axis=[1, 0, 0], **fields)
        for name, fields in (("a", {"law": {"effort": law}}), ("b", {}))
    }
    out = scene(
        {"a": body(1.0, com=(0, 0, 0)), "b": body(1.0, com=(0, 0, 0))},
        slides,
        gravity=[0, 0, 0],
        solver={"integrator": "ida", "formulation": formulation},
        constraints={"c": {"type": "coupling", "joint": "b", "with": "a", "ratio": 1}},
    )
    out["tables"] = {
        "p": {"x": [0, 3.3, 3.305, 3.31, 5], "values": [0, 0, 100, 0, 0], "interpolation": "linear"}
    }
    simulation = gelenk.Simulation(out)
    simulation.initialize(0.0, 1e-7)
    simulation.step_to(5.0)
    # index3 has errors of the velocity that its error test does not see.
    assert simulation.output("a.s") == pytest.approx(
        0.25 * 1.695, abs=1e-4 if formulation == "index3" else 1e-7
    )
    assert simulation.diagnostic("solver.steps") > 10


@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize("step", [0.1, 0.05, 0.01])
def test_points_at_communication_times_but_for_rounding(integrator: str, step: float) -> None:
    """0.3 and 3 times 0.1 differ by rounding: no steps of this length, and no point passed twice."""
    table = {"x": [0, 0.1, 0.3, 0.6, 0.7, 1], "values": [0, 1, 0, 2, 1, 0], "interpolation": "linear"}
    law = slide("table(p, t)", {"s": 0.0}, solver={"integrator": integrator}, tables={"p": table})
    found = gelenk.simulate(law, stop=1, step=step)
    impulse = 0.1 / 2 + 0.2 / 2 + 0.3 + 0.15 + 0.3 / 2
    assert found["S.v"][-1] == pytest.approx(impulse, abs=1e-6)
    moved = {"time": [0, 0.1, 0.4], "value": [0, 1, 0], "interpolation": "pchip", "periodic": True}
    out = scene(
        {"mass": body(2.0, com=(0, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0])},
        solver={"integrator": integrator},
    ) | {"constraints": {"M": {"type": "motion", "joint": "S", "table": moved}}}
    assert gelenk.simulate(out, stop=4, step=step)["S.s"][-1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("steps", [1, 100])
def test_cost_of_many_points_does_not_depend_on_the_length_of_steps(steps: int) -> None:
    """About ninety points are crossed, in one communication step or in a hundred."""
    x = np.linspace(-1, 1, 5001)
    law = slide(
        "table(p, s)", {"s": 0.9},
        tables={"p": {"x": x, "values": -100 * np.sin(x), "interpolation": "linear"}},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-6)
    for k in range(steps):
        simulation.step_to(0.03 * (k + 1) / steps)
    assert simulation.diagnostic("solver.evaluations") < 4000


def test_motion_that_follows_a_table_exactly() -> None:
    """The driving force is the mass times the second derivative of SciPy's curve, beside its jumps."""
    times, values = [0, 1, 1.1, 3, 4], [0, 0, 1, 1, 1]
    curve = PchipInterpolator(times, values)
    out = scene(
        {"mass": body(2.0, com=(0, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0])},
        gravity=[0, 0, 0],
    )
    for motion, tables in (
        ({"table": {"time": times, "value": values, "interpolation": "pchip"}}, {}),
        ({"law": "table(p, t)"}, {"tables": {"p": {"x": times, "values": values}}}),
    ):
        simulation = gelenk.Simulation(
            out | {"constraints": {"M": {"type": "motion", "joint": "S"} | motion}} | tables
        )
        simulation.initialize(0.0, 1e-8)
        for t in (0.5, 0.999, 1.0, 1.02, 1.05, 1.0999, 1.1, 2.0, 3.0, 3.5):
            simulation.step_to(t)
            assert simulation.output("S.s") == pytest.approx(float(curve(t)), abs=1e-11)
            assert simulation.output("S.v") == pytest.approx(float(curve(t, 1)), abs=1e-9)
            if t not in times:
                assert simulation.output("M.f") == pytest.approx(2 * float(curve(t, 2)), abs=1e-6)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_what_hangs_on_a_motion_does_not_see_its_knots(integrator: str) -> None:
    """A mass on a spring, moved with accelerations that jump: piecewise closed form."""
    times, values = [0, 0.5, 0.8, 2.0], [0.0, 0.0, 1.0, 1.0]
    curve = PchipInterpolator(times, values)
    out = scene(
        {"mass": body(2.0, com=(0, 0, 0)), "tail": body(1.0, com=(0, 0, 0))},
        {
            "S": joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0]),
            "P": joint("prismatic", frame("mass"), frame("tail"), axis=[1, 0, 0], stiffness=100.0),
        },
        gravity=[0, 0, 0],
        solver={"integrator": integrator, "step": 1e-3},
    )
    table = {"time": times, "value": values, "interpolation": "pchip"}
    simulation = gelenk.Simulation(
        out | {"constraints": {"M": {"type": "motion", "joint": "S", "table": table}}}
    )
    simulation.initialize(0.0, 1e-9)
    simulation.step_to(2.0)
    # u'' = -100 u - a(t), a = a0 + a1 t' in each piece: u = -(a0 + a1 t')/100 + c cos(10 t') + d sin(10 t')
    u, w = 0.0, 0.0
    for start, end in itertools.pairwise(times):
        h = end - start
        first, last = (float(curve(start + part * h, 2)) for part in (0.25, 0.75))
        a1 = (last - first) / (0.5 * h)
        a0 = first - 0.25 * h * a1
        c, d = u + a0 / 100, (w + a1 / 100) / 10
        u = -(a0 + a1 * h) / 100 + c * math.cos(10 * h) + d * math.sin(10 * h)
        w = -a1 / 100 + 10 * (d * math.cos(10 * h) - c * math.sin(10 * h))
    assert simulation.output("P.s") == pytest.approx(u, abs=2e-7)
    assert simulation.output("P.v") == pytest.approx(w, abs=2e-6)
