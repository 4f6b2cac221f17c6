# SPDX-License-Identifier: BSD-3-Clause
"""States of elements: closed forms, linear models, loops, events, saved states, other units."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, scene
from scipy.linalg import expm

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
FORMULATIONS = ["projection", "independent", "baumgarte", "penalty", "augmented-lagrangian"]

R, L, K, J, VOLTAGE = 1.0, 0.05, 0.4, 0.5, 12.0  # Ohm, H, N.m/A, kg.m2, V


def rotor(**more: Any) -> dict[str, Any]:
    """A rotor of 0.5 kg m2 about z; `effort`: the law of its joint A, `states` and other sections."""
    effort, start = more.pop("effort", None), more.pop("start", {"phi": 0.0})
    law = {} if effort is None else {"law": {"effort": effort}}
    return scene(
        {"rotor": body(2.0, inertia=(J, J, J))},
        {"A": joint("revolute", frame("ground"), frame("rotor"), axis=[0, 0, 1], start=start, **law)},
        **more,
    )


def dc_motor(**more: Any) -> dict[str, Any]:
    """L i' = u - R i - k w, J w' = k i."""
    return rotor(
        effort="k*i",
        states={"i": {"rate": "(u - R*i - k*A.w)/L", "unit": "A", "start": 0.5}},
        inputs={"u": {"unit": "V", "start": VOLTAGE}},
        constants={"R": R, "L": L, "k": K},
        **more,
    )


DC_MATRIX = np.array([[0, 1, 0], [0, 0, K / J], [0, -K / L, -R / L]])  # of phi, w, i


def dc_exact(t: float) -> np.ndarray:
    A = DC_MATRIX[1:, 1:]
    rest = -np.linalg.solve(A, [0, VOLTAGE / L])
    found: np.ndarray = rest + expm(A * t) @ (np.array([0, 0.5]) - rest)
    return found


def values(source: Any, names: list[str], times: list[float], tolerance: float) -> np.ndarray:
    simulation = gelenk.Simulation(source)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)  # 1e-10 is finer than cvode and ida can be
        simulation.initialize(0.0, tolerance)
    out = []
    for t in times:
        simulation.step_to(t)
        out.append([simulation.output(name) for name in names])
    return np.array(out)


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


@pytest.mark.parametrize("reduced", [True, False])
@pytest.mark.parametrize("name", ["A", "B", "C", "D"])
def test_coordinates_of_any_joint_of_a_loop_are_named(name: str, reduced: bool) -> None:
    """Torques on both bodies of a joint, by its coordinate and speed, are a spring and a damper there."""
    found, evaluations = [], []
    for by_names in (True, False):
        source = four_bar(1.1, damping=0.0)
        if not reduced:
            source["solver"] = {"reductions": {"planar": False, "cut_choice": False, "massless": False}}
        at = source["joints"][name]
        if by_names:
            torque = f"3*({name}.phi - 0.2) + 0.4*{name}.w"
            forces = {}
            for i, (side, sign) in enumerate((("parent", ""), ("child", "-"))):
                on = at[side]["body"]
                if on != "ground":
                    forces[f"torque{i}"] = {
                        "type": "body_force",
                        "body": on,
                        "torque": ["0", "0", f"{sign}({torque})"],
                    }
            source["forces"] = forces
        else:
            at.update({"stiffness": 3.0, "damping": 0.4, "spring_reference": 0.2})
        source["solver"] = source.get("solver", {}) | {"integrator": "dirk"}
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-10)
        for k in range(20):
            simulation.step_to(0.05 * (k + 1))
        with pytest.warns(gelenk.OperatingPointWarning):
            model = gelenk.linearize(source, states=["A.phi", "A.w"])
        found.append([simulation.output(f"{of}.{q}") for of in "ABCD" for q in ("phi", "w", "a")])
        found[-1] += list(np.asarray(model.A).ravel())
        evaluations.append(simulation.diagnostic("solver.evaluations"))
    assert (
        abs(evaluations[0] - evaluations[1]) < 0.05 * evaluations[1]
    )  # Newton's method has exact derivatives
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-8)


def test_linear_model_has_electrical_and_controller_poles() -> None:
    """DC motor with a PI controller of the speed: the characteristic polynomial to 1e-12 of its coefficients."""
    kp, ki = 3.0, 20.0
    source = rotor(
        effort="k*i",
        states={
            "e": "r - A.w",
            "i": {"rate": f"({kp}*(r - A.w) + {ki}*e - R*i - k*A.w)/L", "unit": "A"},
        },
        inputs={"r": {"unit": "rad/s"}},
        constants={"R": R, "L": L, "k": K},
    )
    model = gelenk.linearize(source, states=["A.phi", "A.w"])
    assert list(model.state_labels) == ["A_phi", "A_w", "e", "i"]
    A = np.array([[0, 1, 0, 0], [0, 0, 0, K / J], [0, -1, 0, 0], [0, -(kp + K) / L, ki / L, -R / L]])
    np.testing.assert_allclose(model.A, A, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(np.asarray(model.B).ravel(), [0, 0, 1, kp / L], rtol=1e-13, atol=1e-13)
    polynomial = [1, R / L, K * (kp + K) / (J * L), ki * K / (J * L), 0]
    np.testing.assert_allclose(np.poly(np.asarray(model.A)), polynomial, rtol=1e-12, atol=1e-10)
    rows = {str(name): np.asarray(model.C)[k] for k, name in enumerate(model.output_labels)}
    np.testing.assert_allclose(rows["i"], [0, 0, 0, 1])
    np.testing.assert_allclose(rows["A_a"], [0, 0, 0, K / J], rtol=1e-13, atol=1e-13)


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
    """A series spring and damper (Maxwell) on a mass: x' = (s - x)/T, force -k (s - x); s, x and forces scale."""
    k, T = 100.0, 0.3
    source = scene(
        {"mass": body(size**3)},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("mass", (size, 0, 0)), axis=[1, 0, 0], start={"s": 0.5 * size},
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
    """Speed control with a limited torque and an integral that waits there (anti-windup): pieces of linear motion."""
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


def driven_ball(integrator: str, **solver: Any) -> dict[str, Any]:
    """A ball of 1 kg on a floor, pulled along it by an actuator of first order with a set-point of 3 N at 0.1 s."""
    source = scene(
        {"ball": body(1.0, inertia=(0.004,) * 3) | {"shapes": {"skin": {"sphere": 0.1, "surface": "skin"}}}},
        {"F": joint("free", frame("ground"), frame("ball"), start={"r": [0, 0, 0.1]})},
        gravity=[0, 0, -10],
        ground={"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        contacts={"c": {"between": ["skin", "floor"], "friction": 0.0}},
        forces={"pull": {"type": "body_force", "body": "ball", "force": ["f1", "0", "0"]}},
        states={"f1": "(3 - f1)/0.1"},
        solver={"integrator": integrator, **solver},
    )
    return source


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean", "dirk"])
def test_states_beside_contacts(integrator: str) -> None:
    """x = 3/2 t^2 - 0.3 t + 0.03 (1 - exp(-10 t)), while the ball rests on the floor."""
    found = values(driven_ball(integrator, step=1e-3), ["F.r[1]", "F.v[1]", "f1"], [0.2, 1.0], 1e-8)
    accuracy = 1e-5 if integrator == "moreau-jean" else 1e-7
    for t, (x, v, f) in zip([0.2, 1.0], found, strict=True):
        decay = math.exp(-10 * t)
        assert x == pytest.approx(1.5 * t**2 - 0.3 * t + 0.03 * (1 - decay), abs=accuracy)
        assert v == pytest.approx(3 * t - 0.3 * (1 - decay), abs=accuracy)
        assert f == pytest.approx(3 * (1 - decay), abs=10 * accuracy)


def test_steps_with_impulses_are_of_second_order_between_impacts() -> None:
    errors = []
    for step in (4e-3, 2e-3):
        found = values(driven_ball("moreau-jean", step=step), ["F.v[1]", "f1"], [0.4], 1e-6)[0]
        decay = math.exp(-4)
        errors.append(np.abs(found - [1.2 - 0.3 * (1 - decay), 3 * (1 - decay)]).max())
    assert errors[0] / errors[1] > 3.6


def test_stiff_circuit_beside_contacts() -> None:
    """A time constant of 1 us at steps of 1 ms."""
    source = driven_ball("moreau-jean", step=1e-3)
    source["states"] = {"f1": {"rate": "(3 - f1)/1e-6", "start": 3.0}}
    x, v = values(source, ["F.r[1]", "F.v[1]"], [1.0], 1e-6)[0]
    assert x == pytest.approx(1.5, abs=1e-6)
    assert v == pytest.approx(3.0, abs=1e-6)


def test_equilibrium_finds_states_of_circuits_and_controllers() -> None:
    """A rod held at an angle by a motor with a controller: the integral that its weight requires, 2.4525 cos(phi)."""
    source = scene(
        {"rod": body(1.0, (0.25, 0, 0), (0.02, 0.02, 0.02))},
        {
            "A": joint(
                "revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 0.1},
                law={"effort": "0.5*i - 0.2*w"},
            )
        },
        gravity=[0, -9.81, 0],
        states={
            "e": "set - A.phi",
            "i": {"rate": "(20*(set - A.phi) + 30*e - 2*i - 0.5*A.w)/0.01", "unit": "A"},
        },
        inputs={"set": {"unit": "rad", "start": 0.4}},
        solver={"start": "equilibrium"},
    )  # fmt: skip
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-8)
    torque = 9.81 * 0.25 * math.cos(0.4)
    expected = {
        "A.phi": 0.4,
        "A.w": 0.0,
        "i": torque / 0.5,
        "e": 2 * torque / 0.5 / 30,
        "A.a": 0,
        "i.rate": 0,
    }
    for name, value in expected.items():
        assert simulation.output(name) == pytest.approx(value, abs=1e-9), name
    simulation.step_to(1.0)
    assert simulation.output("A.phi") == pytest.approx(0.4, abs=1e-9)
    model = gelenk.linearize(source)  # no warning that it is no equilibrium
    assert len(model.poles()) == 4


def test_steady_motion_finds_the_current() -> None:
    """At 7 rad/s with 0.3 N.m.s/rad of damping: k i = 2.1 N.m, u = R i + k w."""
    source = dc_motor()
    source["joints"]["A"]["damping"] = 0.3
    found = gelenk.equilibrium(source, steady={"A.w": 7.0}, solve_for=["u"])
    assert found.inputs["u"] == pytest.approx(R * 2.1 / K + K * 7.0, abs=1e-9)
    assert found.values["i"] == pytest.approx(2.1 / K, abs=1e-9)


@pytest.mark.parametrize("planar", [True, False])
def test_distance_by_name_is_a_line_force(planar: bool) -> None:
    """A spring and damper between two points of a loop: as an element, and by torques from the sensor of its length."""
    found = []
    for by_names in (True, False):
        source = four_bar(1.1, damping=0.0)
        crank, point = source["joints"]["A"]["child"]["body"], [2.0, 1.0, 0]
        tip = {"body": crank, "position": [0.5, 0, 0]}
        if by_names:
            # the line from the tip at (0.5 cos phi, 0.5 sin phi) to the point, about the crank's axis at the origin
            lever = "0.5*(1*cos(A.phi) - 2*sin(A.phi))/gap.d"
            source["sensors"] = {
                "gap": {"type": "distance", "from": {"body": "ground", "position": point}, "to": tip}
            }
            source["joints"]["A"]["law"] = {"effort": f"(30*(gap.d - 1) + 2*gap.v)*{lever}"}
        else:
            source["forces"] = {
                "spring": {
                    "type": "spring_damper", "from": {"body": "ground", "position": point}, "to": tip,
                    "stiffness": 30, "damping": 2, "length": 1,
                }
            }  # fmt: skip
        source["solver"] = {"integrator": "dirk", "reductions": {"planar": planar}}
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-10)
        for k in range(20):
            simulation.step_to(0.05 * (k + 1))
        with pytest.warns(gelenk.OperatingPointWarning):
            model = gelenk.linearize(source, states=["A.phi", "A.w"])
        found.append([simulation.output(f"{of}.{q}") for of in "ABCD" for q in ("phi", "w", "a")])
        found[-1] += list(np.asarray(model.A).ravel())
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=2e-8)


def test_what_an_expression_names_is_in_one_island() -> None:
    """Two pendulums that only a law couples: the same as with a spring between their angles."""
    rod = body(1.0, (0.25, 0, 0), (0.02, 0.02, 0.02))

    def pendulums(laws: list[str]) -> dict[str, Any]:
        joints = {}
        for name, law, phi in zip("AB", laws, (0.3, -0.2), strict=True):
            joints[name] = joint(
                "revolute", frame("ground"), frame(f"rod{name}"), axis=[0, 0, 1], start={"phi": phi},
                law={"effort": law},
            )  # fmt: skip
        return scene({"rodA": rod, "rodB": rod}, joints, gravity=[9.81, 0, 0])

    source = pendulums(["-4*(phi - B.phi)", "-4*(phi - A.phi)"])
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-10)
    assert simulation.size.islands == 1
    mean, difference = pendulums(["0", "0"]), pendulums(["-8*phi", "-8*phi"])
    for small in (source, mean, difference):
        for name, phi in zip("AB", (3e-6, -2e-6), strict=True):
            small["joints"][name]["start"] = {"phi": phi}
    coupled, free, stiff = (
        values(one, ["A.phi", "B.phi"], [0.7], 1e-12)[0] for one in (source, mean, difference)
    )
    modes = [(free[0] + free[1]) / 2, (stiff[0] - stiff[1]) / 2]
    np.testing.assert_allclose(coupled, [modes[0] + modes[1], modes[0] - modes[1]], rtol=0, atol=1e-11)


def test_wanted_outputs_keep_what_their_expressions_name() -> None:
    source = dc_motor(outputs=["A.w"])
    source["bodies"]["idle"] = body(1.0, inertia=(1, 1, 1))
    source["joints"]["Z"] = joint("revolute", frame("ground"), frame("idle"), axis=[0, 0, 1])
    source["states"]["other"] = "Z.phi - other"
    assert values(source, ["A.w"], [0.3], 1e-9)[0, 0] == pytest.approx(dc_exact(0.3)[0], abs=1e-8)
    simulation = gelenk.Simulation(source)
    assert [signal for signal in simulation.outputs] == ["A.w"] or "other" not in [
        getattr(signal, "name", signal) for signal in simulation.outputs
    ]
    only = gelenk.Simulation(source | {"outputs": ["other"]})
    only.initialize(0.0, 1e-8)
    only.step_to(1.0)
    assert only.output("other") == pytest.approx(0.0, abs=1e-9)


def test_equilibrium_against_a_limit() -> None:
    """A joint is pushed onto its limit, and a state follows it."""
    source = rotor(effort="-3", states={"e": "A.phi - e"})
    source["joints"]["A"]["limit"] = {"lower": -0.2}
    found = gelenk.equilibrium(source)
    assert found.values["A.phi"] == pytest.approx(-0.2, abs=1e-9)
    assert found.values["e"] == pytest.approx(-0.2, abs=1e-9)


def test_input_is_found_where_a_filter_beside_the_mechanism_reads_it() -> None:
    """The filter follows; an operating point contains its state."""
    source = rotor(effort="u - 2*phi", states={"slow": "(u - slow)/0.2"}, inputs={"u": {}})
    found = gelenk.equilibrium(source, hold={"A.phi": 0.7}, solve_for="u")
    assert found.inputs["u"] == pytest.approx(1.4, abs=1e-9)
    assert found.values["slow"] == pytest.approx(1.4, abs=1e-9)
    model = gelenk.linearize(source, at=found.at)
    np.testing.assert_allclose(sorted(model.poles().real), [-5, 0, 0], atol=1e-9)


def test_operating_point_may_give_a_state() -> None:
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(dc_motor(), at={"i": 2.0, "A.w": 3.0})
    assert len(model.state_labels) == 3
    with pytest.raises(gelenk.EquilibriumError, match="i.rate"):
        source = dc_motor()
        source["joints"]["A"]["friction"] = {"coulomb": 8.0}
        gelenk.equilibrium(source, friction="present")


@pytest.mark.parametrize("integrator", ["dirk", "cvode", "auto"])
def test_kink_that_is_approached_and_not_passed_costs_nothing(integrator: str) -> None:
    """A follower of the time, 0.01 s behind, near the limit of its rate: x = t - 0.01 (1 - exp(-100 t))."""
    source = rotor(states={"lag": "min(100*(t - lag), 1.01)"}, solver={"integrator": integrator})
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    simulation.step_to(1.0)
    assert simulation.output("lag") == pytest.approx(0.99, abs=1e-6)
    assert simulation.diagnostic("solver.evaluations") < 2000


def test_steps_with_impulses_damp_stiff_states_and_pass_jumps_of_rates() -> None:
    """An input that jumps before a time constant of 10 us; a rate that jumps at 0.5, with the steps of an event-free method."""
    source = rotor(
        effort="fast", states={"fast": "(u - fast)/1e-5"}, inputs={"u": {}},
        solver={"integrator": "moreau-jean", "step": 1e-3},
    )  # fmt: skip
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    simulation.step_to(0.1)
    simulation.set_input("u", 1.0)
    simulation.step_to(0.103)
    assert simulation.output("fast") == pytest.approx(1.0, abs=1e-3)
    for start in (0.0, 0.3e-3, 0.5e-3, 0.7e-3):
        states = {"q1": {"rate": "if(q1 > 0.5, 0.2, 1)", "start": start}}
        found = values(
            rotor(states=states, solver={"integrator": "moreau-jean", "step": 1e-3}), ["q1"], [1.0], 1e-6
        )
        reached = 0.5 - start
        assert found[0, 0] == pytest.approx(0.5 + 0.2 * (1 - reached), abs=1e-3)


def test_more_than_eight_names_in_one_expression() -> None:
    """Full state feedback: twelve numbers of four joints, in a law and in a state; the linear model is exact."""
    rotors = {f"rotor{k}": body(1.0, inertia=(1, 1, 1)) for k in range(4)}
    joints = {
        f"J{k}": joint("revolute", frame("ground"), frame(f"rotor{k}"), axis=[0, 0, 1]) for k in range(4)
    }
    gains = [1.5, 2.5, 3.5, 4.5]
    terms = [f"{g}*J{k}.phi + {10 * g}*J{k}.w + {100 * g}*z{k}" for k, g in enumerate(gains)]
    joints["J0"]["law"] = {"effort": " + ".join(terms)}
    states = {f"z{k}": f"J{k}.phi" for k in range(4)} | {"all": " + ".join(terms)}
    source = scene(rotors, joints, states=states)
    model = gelenk.linearize(source, states=[f"J{k}.phi" for k in range(4)])
    labels, A = list(model.state_labels), np.asarray(model.A)
    for row in ("J0_w", "all"):
        for k, g in enumerate(gains):
            columns = [labels.index(name) for name in (f"J{k}_phi", f"J{k}_w", f"z{k}")]
            np.testing.assert_allclose(A[labels.index(row), columns], [g, 10 * g, 100 * g], rtol=1e-14)
