# SPDX-License-Identifier: BSD-3-Clause
"""Rates of states that name forces and accelerations: heat of losses, impulses, control by sensors."""

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

import gelenk

ADAPTIVE = ["erk", "dirk", "cvode", "cvode-adams", "ida", "auto"]


def slide(**sections: Any) -> dict[str, Any]:
    """2 kg on a spring and a guide with friction 1 N + 0.5 N s/m |v|, heat of which is a state."""
    guide = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0],
        start={"v": 3.0, "fixed": True}, friction={"law": "1 + 0.5*v"},
    )  # fmt: skip
    spring = {"type": "spring_damper", "from": frame("ground", (-9, 0, 0)), "to": frame("mass"),
              "stiffness": 2.0, "length": 9.0}  # fmt: skip
    return scene(
        {"mass": body(2.0)}, {"S": guide}, gravity=[0, 0, 0], forces={"spring": spring},
        states={"heat": {"rate": "loss", "unit": "J"}, "p": {"rate": "2*S.a", "unit": "N.s"}},
        expressions={"loss": "abs(S.friction.f*S.v)"},
    ) | sections  # fmt: skip


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_heat_is_the_energy_lost(integrator: str) -> None:
    """And the integral of the acceleration is the velocity, until friction holds the mass."""
    of = slide(solver={"integrator": integrator})
    step = 0.01 if integrator == "rk4" else 0.1
    result = gelenk.simulate(of, stop=12.0, step=step, tolerance=1e-9)
    assert result["S.v"][-1] == 0
    energy = result["S.v"] ** 2 + result["S.s"] ** 2
    np.testing.assert_allclose(energy + result["heat"], 9.0, rtol=1e-9)
    np.testing.assert_allclose(result["p"], 2 * (result["S.v"] - 3), atol=1e-8)
    np.testing.assert_array_equal(result["heat.rate"], result["loss"])


@pytest.mark.parametrize(
    ("formulation", "integrator", "accuracy"),
    [
        ("projection", "erk", 1e-8),
        ("projection", "dirk", 1e-8),
        ("projection", "ida", 1e-8),
        ("independent", "cvode", 1e-8),
        ("baumgarte", "erk", 1e-6),
        ("udwadia-kalaba", "erk", 1e-6),
        ("penalty", "erk", 1e-5),
        ("augmented-lagrangian", "erk", 1e-6),
        ("index3", "ida", 1e-5),
        ("stabilized-index2", "ida", 1e-6),
    ],
)
def test_loops_in_all_formulations(formulation: str, integrator: str, accuracy: float) -> None:
    """What a motor does, and what a loop loses in the joint that closes it: the energy of the rest."""
    of = four_bar(damping=0.0)
    of["solver"] = {"formulation": formulation, "integrator": integrator}
    friction = formulation == "projection"
    if friction:
        of["joints"]["C"]["friction"] = {"coulomb": 0.02}
    of["constraints"] = {"spin": {"type": "motion", "joint": "A", "law": "1.1 + 3*t + 0.1*sin(5*t)"}}
    of["joints"]["A"]["start"] = {"phi": 1.1, "w": 3.5}
    of.pop("motors", None)
    of["states"] = {"work": "spin.tau*A.w"} | ({"heat": "-C.friction.tau*C.w"} if friction else {})
    of["sensors"] = {"all": {"type": "energy"}}
    result = gelenk.simulate(of, stop=2.0, step=0.01, tolerance=1e-9)
    total = result["all.total"] - result["work"] + (result["heat"] if friction else 0)
    scale = np.ptp(result["work"]) + np.ptp(result["all.total"])
    assert np.ptp(total) <= accuracy * scale
    if friction:
        assert result["heat"][-1] > 0.02


def test_control_by_acceleration_has_its_poles() -> None:
    """M s'' = z - k s - d s', z' = K (r - s''): characteristic polynomial m x^3 + (d + K) x^2 + k x."""
    m, k, d, K = 2.0, 3.0, 0.4, 1.5
    guide = joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], stiffness=k, damping=d)
    of = scene(
        {"mass": body(m)}, {"S": guide | {"law": {"effort": "pull"}}}, gravity=[0, 0, 0],
        inputs={"r": {}}, states={"pull": f"{K}*(r - S.a)"},
    )  # fmt: skip
    model = gelenk.linearize(of)
    assert list(model.state_labels) == ["S_s", "S_v", "pull"]
    A = np.array([[0, 1, 0], [-k / m, -d / m, 1 / m], [K * k / m, K * d / m, -K / m]])
    np.testing.assert_allclose(model.A, A, atol=1e-14)
    np.testing.assert_allclose(model.B[:, 0], [0, 0, K], atol=1e-14)
    np.testing.assert_allclose(np.poly(model.A), [1, (d + K) / m, k / m, 0], atol=1e-12)


def test_force_control_against_a_spring() -> None:
    """The axial force that a sensor shows follows its set-point: z' = (F - f)/T is one pole at -1/T."""
    spring = {"type": "spring_damper", "from": frame("ground", (-1, 0, 0)), "to": frame("mass"),
              "stiffness": 50.0, "length": 1.0}  # fmt: skip
    of = scene(
        {"base": body(1.0), "mass": body(1.0)},
        {
            "S": joint("prismatic", frame("ground"), frame("base"), axis=[1, 0, 0], damping=20.0,
                       law={"effort": "pull"}),
            "W": joint("weld", frame("base"), frame("mass")),
        },
        gravity=[0, 0, 0], forces={"spring": spring}, sensors={"load": {"type": "reaction", "joint": "W"}},
        inputs={"F": {"start": 4.0}}, states={"pull": "5*(F - load.f[1])"},
    )  # fmt: skip
    result = gelenk.simulate(of, stop=40.0, step=0.5, tolerance=1e-9)
    np.testing.assert_allclose(abs(result["load.f[1]"][-1]), 4.0, rtol=1e-6)
    np.testing.assert_allclose(50 * result["S.s"][-1], 4.0, rtol=1e-6)


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_what_friction_holds_is_measured(integrator: str) -> None:
    """The integral of a force that holds a growing load, 1.5 t up to t = 2, and 3 N after."""
    guide = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], friction={"coulomb": 3.0, "static": 3.0}
    )
    of = scene(
        {"mass": body(2.0)}, {"S": guide | {"law": {"effort": "1.5*t"}}}, gravity=[0, 0, 0],
        states={"impulse": "-S.friction.f"}, solver={"integrator": integrator},
    )  # fmt: skip
    result = gelenk.simulate(of, stop=4.0, step=0.25, tolerance=1e-9)
    t = result["time"]
    np.testing.assert_allclose(
        result["impulse"], np.where(t < 2, 0.75 * t**2, 3 + 3 * (t - 2)), rtol=1e-8, atol=1e-9
    )


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "ida"])
def test_contacts_act_on_what_is_measured(integrator: str) -> None:
    """A ball on an arm of 0.3 m falls onto the floor: the moment in the guide, and the acceleration's sum."""
    guide = joint("prismatic", frame("ground"), frame("ram"), axis=[0, 0, 1], start={"s": 0.5, "fixed": True})
    ram = body(2.0) | {"shapes": {"tip": {"sphere": 0.1, "position": [0.3, 0, 0], "surface": "rubber"}}}
    of = scene(
        {"ram": ram}, {"S": guide}, gravity=[0, 0, -9.81],
        ground={"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        contacts={"touch": {"between": ["rubber", "floor"], "friction": 0.0, "restitution": 0.0}},
        sensors={"load": {"type": "reaction", "joint": "S"}},
        states={"moment": "abs(load.t[2])", "gained": "S.a"},
        solver={"integrator": integrator},
    )  # fmt: skip
    result = gelenk.simulate(of, stop=1.0, step=0.05, tolerance=1e-9)
    assert result["S.v"][-1] == 0
    g, t = 9.81, result["time"]
    landed = np.sqrt(2 * 0.4 / g)
    np.testing.assert_allclose(result["gained"], -g * np.minimum(t, landed), atol=1e-8)
    expected = 2 * g * 0.3 * np.maximum(t - landed, 0)
    np.testing.assert_allclose(result["moment"], expected, atol=1e-7)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize(
    ("rate", "exact"),
    [
        ("if(t > 3.03 and t < 3.04, S.a, 0)", 0.02),
        ("clip(S.s, 0, 4)*S.a", 2 * 2**3 / 3 + 8 * 2.0),
        ("if(S.s > 4, S.a, 0)*max(t, 3)", 2 * (3 + (16 - 9) / 2)),
    ],
)
def test_kinks_that_forces_do_not_decide_on_are_events(rate: str, exact: float, integrator: str) -> None:
    """2 m/s2 for 4 s in one step: a pulse of 10 ms, and kinks, of the time and the coordinate."""
    guide = joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], law={"effort": "4"})
    of = scene({"mass": body(2.0)}, {"S": guide}, gravity=[0, 0, 0], states={"gained": rate})
    of["solver"] = {"integrator": integrator, "step": 0.1}
    result = gelenk.simulate(of, stop=4.0, step=4.0, tolerance=1e-8)
    # s = t^2; the clip: up to 2 s the integral of 2 t^2, then of 8.
    np.testing.assert_allclose(result["gained"][-1], exact, atol=1e-6)


def test_points_of_tables_of_forces_keep_the_tolerance() -> None:
    """Force and coordinate decide on one expression: a table of the former, a kink of the latter."""
    of = slide(
        states={"sum": "table(T, S.a)*if(S.s > 0, 1, 2)"}, expressions={},
        tables={"T": {"x": [-4, 0, 4], "values": [8, 0, 4], "interpolation": "linear"}},
    )  # fmt: skip
    of["joints"]["S"].pop("friction")
    result = gelenk.simulate(of, stop=2 * np.pi, step=np.pi, tolerance=1e-8)
    # a = -3 sin(t): for s > 0 the table is 2 * 3 sin(t), for s < 0 it is 3 |sin(t)|, and counts twice.
    np.testing.assert_allclose(result["sum"], [0, 12, 24], atol=1e-5)


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_jumps_of_rates_keep_the_tolerance(integrator: str) -> None:
    """The time during which a mass on a spring accelerates forward, which no event locates."""
    of = slide(
        states={"forward": "if(S.a > 0, 1, 0)", "way": "max(S.a, 0)"}, expressions={},
        solver={"integrator": integrator},
    )  # fmt: skip
    of["joints"]["S"].pop("friction")
    tolerance = 1e-7
    result = gelenk.simulate(of, stop=10 * np.pi, step=np.pi, tolerance=tolerance)
    np.testing.assert_allclose(result["forward"][-1], 5 * np.pi, atol=100 * tolerance * 5 * np.pi)
    np.testing.assert_allclose(result["way"][-1], 30.0, atol=100 * tolerance * 30)


def test_derivatives_along_directions_and_in_time(tmp_path: Path) -> None:
    """Of the FMU, against the same by hand: heat = (1 + v/2) v while v > 0."""
    by_hand = slide(states={"heat": "(1 + 0.5*S.v)*S.v", "p": "-2*S.s - 1 - 0.5*S.v"}, expressions={})
    found = {}
    for name, of in {"named": slide(), "by_hand": by_hand}.items():
        fmu = Fmu(fmpy.extract(str(gelenk.export_fmu(of, tmp_path / f"{name}.fmu")), str(tmp_path / name)))
        s = Slave(fmu).start()
        s.run(20)
        outputs = ["heat", "p", "heat.rate", "p.rate"]
        found[name] = [in_time(s, outputs, order) for order in (1, 2)] + [[s.get(one) for one in outputs]]
    np.testing.assert_allclose(found["named"], found["by_hand"], rtol=1e-9, atol=1e-12)


@warned.MOVING
def test_linear_model_is_that_by_hand() -> None:
    by_hand = slide(states={"heat": "(1 + 0.5*S.v)*S.v", "p": "-2*S.s - 1 - 0.5*S.v"}, expressions={})
    a, b = (gelenk.linearize(of, friction="present") for of in (slide(), by_hand))
    np.testing.assert_allclose(a.A, b.A, rtol=1e-12, atol=1e-14)


def test_gradients_beside_friction() -> None:
    """By a constant, an input and a mass, while friction opposes the motion: k u (v - 3), a = -1/2."""
    guide = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], start={"v": 3.0, "fixed": True},
        friction={"coulomb": 1.0},
    )  # fmt: skip
    of = scene(
        {"mass": body(2.0)}, {"S": guide}, gravity=[0, 0, 0], constants={"k": 1.0},
        inputs={"u": {"start": 1.0}},
        parameters=["k", "mass.mass"], states={"gained": "k*u*S.a", "heat": "-k*S.friction.f*S.v"},
        experiment={"stop": 0.5, "step": 0.1, "tolerance": 1e-9},
    )  # fmt: skip
    run = gelenk.sensitivity(of, ["k", "u", "mass.mass"], outputs=["gained", "heat"])
    t = run.time
    np.testing.assert_allclose(run.derivative("gained", "k"), -t / 2, atol=1e-8)
    np.testing.assert_allclose(run.derivative("gained", "u"), -t / 2, atol=1e-8)
    np.testing.assert_allclose(run.derivative("gained", "mass.mass"), t / 4, atol=1e-8)
    np.testing.assert_allclose(run.derivative("heat", "k"), 3 * t - t**2 / 4, atol=1e-8)


def test_gradients_of_heat() -> None:
    """d(heat)/d(parameter) against differences."""
    of = slide(parameters=["mass.mass"])
    del of["joints"]["S"]["friction"]
    of["joints"]["S"]["damping"] = 0.7
    of["expressions"] = {"loss": "2*S.a*S.v"}
    of["states"] = {"heat": {"rate": "loss", "unit": "J"}}
    of["experiment"] = {"stop": 1.0, "step": 0.1, "tolerance": 1e-11}
    exact = gelenk.sensitivity(of, ["mass.mass", "S.v_start"], outputs=["heat"])
    for name, value in {"mass.mass": 2.0, "S.v_start": 3.0}.items():
        runs = [gelenk.simulate(of, parameters={name: value + h})["heat"] for h in (-1e-3, 1e-3)]
        np.testing.assert_allclose(
            exact.derivative("heat", name), (runs[1] - runs[0]) / 2e-3, rtol=1e-5, atol=1e-8
        )


@pytest.mark.parametrize("integrator", ["auto", "dirk", "ida", "rk4"])
def test_saved_states_go_on_to_the_bit(integrator: str) -> None:
    of = slide(solver={"integrator": integrator})
    simulation = gelenk.Simulation(of)
    simulation.initialize(0.0, 1e-7)
    for k in range(9):
        simulation.step_to(0.3 * (k + 1))
    saved, runs = simulation.save(), []
    for _ in range(2):
        run = []
        for k in range(9, 25):
            simulation.step_to(0.3 * (k + 1))
            run.append([simulation.output(name) for name in ("heat", "p", "heat.rate", "S.s", "S.v")])
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


def test_losses_warm_a_thermal_mass() -> None:
    """The signal of a component may be an expression of forces, also by a name of the scene."""
    of = slide(components={"M": {"type": "thermal_mass", "capacity": 3.0, "heat": "loss"}})
    result = gelenk.simulate(of, stop=4.0, step=0.1, tolerance=1e-9)
    np.testing.assert_allclose(3 * (result["M.temperature"] - 293.15), result["heat"], atol=1e-8)
    of["components"]["M"]["heat"] = "-S.friction.f*S.v"
    again = gelenk.simulate(of, stop=4.0, step=0.1, tolerance=1e-9)
    np.testing.assert_allclose(again["M.temperature"], result["M.temperature"], atol=1e-9)


def test_fmu_runs_as_the_scene(tmp_path: Path) -> None:
    of = slide(experiment={"stop": 4.0, "step": 0.05, "tolerance": 1e-8})
    gelenk.export_fmu(of, tmp_path / "slide.fmu")
    expected = gelenk.simulate(of, outputs=["heat", "p"])
    fmu = fmpy.simulate_fmu(
        str(tmp_path / "slide.fmu"), stop_time=4.0, step_size=0.05, output_interval=0.05, output=["heat", "p"]
    )
    for name in ("heat", "p"):
        np.testing.assert_allclose(fmu[name], expected[name], atol=1e-6)


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        (
            {"solver": {"integrator": "moreau-jean"}},
            "states.heat: found a rate that names forces with the integrator",
        ),
        ({"solver": {"start": "equilibrium"}}, "no equilibrium is searched for where rates name forces"),
        ({"states": {"x": {"rate": "1", "resets": [{"when": "S.a > 1", "to": "0"}]}}}, "'S.a'"),
        (
            {"states": {"x": "S.b"}},
            "states.x: .*'S.b', expected an expression of t, inputs, states, coordinates of",
        ),
        (
            {"components": {"M": {"type": "speed_servo", "joint": "S", "target": "S.a", "gain": 1.0}}},
            "components.M",
        ),
    ],
)
def test_what_cannot_be_is_said(sections: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=f"(?s){message}"):
        gelenk.load(slide(**sections))


@pytest.mark.parametrize("what", ["rate", "motion"])
def test_piles_that_need_time_steps_are_refused(what: str) -> None:
    """More pairs of features than are located: no crash, and no steps in which such rates mean nothing."""
    shape = {"box": [0.1, 0.1, 0.1], "surface": "steel"}
    bodies = {f"b{i}": body(1.0, inertia=(0.004, 0.004, 0.004)) | {"shapes": {"s": shape}} for i in range(4)}
    joints = {f"K{i}": joint("planar", frame("ground"), frame(f"b{i}"), axis=[0, 1, 0]) for i in range(4)}
    of = scene(
        bodies, joints, gravity=[0, 0, -9.81],
        ground={"shapes": {"floor": {"plane": [0, 0, 1], "surface": "steel"}}},
        contacts={"touch": {"between": ["steel", "steel"], "friction": 0.4}}, states={"p": "K0.a_x"},
    )  # fmt: skip
    for i in range(4):
        of["joints"][f"K{i}"]["start"] = {"s_y": -0.051 - 0.11 * i}
    if what == "motion":
        of["bodies"]["plate"] = body(1.0, inertia=(0, 0, 0.1))
        of["joints"]["P"] = joint("revolute", frame("ground"), frame("plate"), axis=[0, 0, 1])
        of |= {"states": {"p": "-p"}, "constraints": {"M": {"type": "motion", "joint": "P", "law": "p"}}}
    with pytest.raises(
        gelenk.SceneError, match="contacts that are solved in time steps: more than 1500 pairs"
    ):
        gelenk.load(of)


def test_no_equilibrium_is_searched_for() -> None:
    with pytest.raises(gelenk.GelenkError, match=r"states\.heat: its rate names forces"):
        gelenk.equilibrium(slide())
