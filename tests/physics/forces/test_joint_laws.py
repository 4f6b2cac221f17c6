# SPDX-License-Identifier: BSD-3-Clause
"""Forces along joints by an expression: elliptic functions, energy, other elements, exact derivatives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import body, four_bar, frame, joint, rod, scene
from scipy.special import ellipj

import gelenk

LINEAR, CUBIC, START = 100.0, 1000.0, 0.5  # N/m, N/m3, m
ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]


def slide(effort: Any, size: float = 1.0, start: float = START, **solver: Any) -> dict[str, Any]:
    """A mass of 1 kg on a slide; lengths are `size` times those of the law."""
    return scene(
        {"mass": body(1.0, com=(0, 0, 0))},
        {
            "S": joint(
                "prismatic", frame("ground", (size, 0, 0)), frame("mass", (size, 0, 0)), axis=[1, 0, 0],
                start={"s": start * size, "fixed": True}, law={"effort": effort},
            )
        },
        gravity=[0, 0, 0],
        solver=solver,
    )  # fmt: skip


def duffing(t: float) -> tuple[float, float]:
    """Position and speed of x'' = -a x - b x^3 from rest: x0 cn(w t | m) (Abramowitz & Stegun, 16.16)."""
    omega = math.sqrt(LINEAR + CUBIC * START**2)
    sn, cn, dn, _ = ellipj(omega * t, CUBIC * START**2 / (2 * omega**2))
    return START * cn, -START * omega * sn * dn


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_hardening_spring_follows_the_elliptic_functions(integrator: str, tolerance: float) -> None:
    """Two seconds, six oscillations: ten tolerances, and as much for each radian of phase that has passed."""
    if tolerance < 1e-9 and integrator in ("cvode", "ida"):
        pytest.skip("below what it can achieve")
    simulation = gelenk.Simulation(slide(f"-{LINEAR}*s - {CUBIC}*s^3", integrator=integrator))
    simulation.initialize(0.0, tolerance)
    for k in range(1, 21):
        simulation.step_to(0.1 * k)
        x, v = duffing(0.1 * k)
        bound = 10 * tolerance * (1 + 20 * 0.1 * k)
        assert abs(simulation.output("S.s") - x) <= bound
        assert abs(simulation.output("S.v") - v) <= 40 * bound


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_laws_are_in_si_units_at_any_size(size: float) -> None:
    """The same oscillation in millimeters and kilometers, which are solved in units of their own."""
    law = f"-{LINEAR}*s - {CUBIC}/{size}^2*s^3"
    simulation = gelenk.Simulation(slide(law, size))
    simulation.initialize(0.0, 1e-10)
    simulation.step_to(1.0)
    x, v = duffing(1.0)
    assert simulation.output("S.s") == pytest.approx(size * x, abs=1e-7 * size)
    assert simulation.output("S.v") == pytest.approx(size * v, abs=1e-6 * size)


def test_gas_spring_keeps_its_energy() -> None:
    """Adiabatic: p V^1.4 is constant. With x = 1 + s, the energy is v^2/2 + x + x^-0.4/0.4."""
    simulation = gelenk.Simulation(slide("(1 + s)^-1.4 - 1", start=1.0))
    simulation.initialize(0.0, 1e-10)
    energies = []
    for k in range(60):
        simulation.step_to(0.2 * (k + 1))
        x, v = 1 + simulation.output("S.s"), simulation.output("S.v")
        energies.append(v * v / 2 + x + x**-0.4 / 0.4)
    assert np.ptp(energies) < 1e-8
    assert abs(energies[0] - (2 + 2**-0.4 / 0.4)) < 1e-8


PENDULUM = "-3*phi - 0.4*w"


def pendulum(**forces: Any) -> dict[str, Any]:
    hinge = joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 0.4}, **forces)
    return scene({"rod": rod(1.0, 0.5)}, {"A": hinge}, gravity=[0, -9.81, 0])


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida", "dirk", "generalized-alpha", "moreau-jean"])
def test_linear_law_is_a_spring_and_a_damper(integrator: str) -> None:
    """The same equations: rounding may change a step, and the results within their tolerance of 1e-8."""
    found = []
    for forces in ({"law": {"effort": PENDULUM}}, {"stiffness": 3.0, "damping": 0.4}):
        simulation = gelenk.Simulation(
            pendulum(**forces) | {"solver": {"integrator": integrator, "step": 1e-3}}
        )
        simulation.initialize(0.0, 1e-8)
        for k in range(1, 31):
            simulation.step_to(0.05 * k)
        found.append(simulation.values())
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-8)


BESIDE: dict[str, dict[str, Any]] = {
    "friction": {"friction": {"coulomb": 0.3, "static": 0.5}},
    "limit": {"limit": {"lower": -0.5, "upper": 1.2, "restitution": 0.5}},
    "friction and limit": {"friction": {"coulomb": 0.2}, "limit": {"lower": -0.2, "restitution": 0.4}},
    "stop": {"stop": {"lower": -0.4, "stiffness": 1e3, "damping": 2.0}},
}


@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida", "moreau-jean"])
def test_law_beside_friction_and_limits_under_a_torque_that_jumps(integrator: str, beside: str) -> None:
    """As a spring and a damper, with equally many events, and to the bit after a restore."""
    found = []
    for forces in ({"law": {"effort": PENDULUM}}, {"stiffness": 3.0, "damping": 0.4}):
        source = pendulum(**forces, **BESIDE[beside]) | {"motors": {"drive": {"joint": "A"}}}
        simulation = gelenk.Simulation(source | {"solver": {"integrator": integrator, "step": 1e-3}})
        simulation.initialize(0.0, 1e-8)
        ends = []
        saved = b""
        for k in [*range(60), *range(30, 60)]:
            if k == 30:
                saved = saved or simulation.save()
                simulation.restore(saved)
            simulation.set_input("drive.tau", 1.0 if k % 20 < 10 else -1.0)
            simulation.step_to(0.025 * (k + 1))
            if k == 59:
                ends.append(simulation.values())
        np.testing.assert_array_equal(ends[0], ends[1])
        events = simulation.diagnostic("solver.events")
        found.append([simulation.output("A.phi"), simulation.output("A.w"), events])
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-7)  # ten tolerances


@pytest.mark.parametrize("name", ["A", "B", "C", "D"])
def test_law_on_each_joint_of_a_loop_is_a_spring_there(name: str) -> None:
    """Also on the joint that closes the loop, whose coordinate is no state."""
    found = []
    for forces in ({"law": {"effort": "-3*(phi - 0.2) - 0.4*w"}},
                   {"stiffness": 3.0, "damping": 0.4, "spring_reference": 0.2}):  # fmt: skip
        source = four_bar(1.1, damping=0.0)
        source["joints"][name].update(forces)
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-10)
        for k in range(40):
            simulation.step_to(0.025 * (k + 1))
        found.append(simulation.values())
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-9)


def test_linear_model_has_the_derivatives_of_the_law() -> None:
    """At s = 0.5 m and rest: A = [[0, 1], [-a - 3 b s^2, -2 d]] for -a s - b s^3 - d v (1 + v) - d v."""
    plant = slide(f"-{LINEAR}*s - {CUBIC}*s^3 - 0.7*v*(1 + v) - 0.7*v")
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(plant, states=["S.s", "S.v"])
    truth = np.array([[0.0, 1.0], [-LINEAR - 3 * CUBIC * START**2, -1.4]])
    np.testing.assert_allclose(np.asarray(model.A), truth, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("effort", ["-s - 3*(s^2)^1.5", "-s - pow(s, 2.5) - v^3", "-s - s^1.5*exp(v)"])
def test_powers_have_derivatives_at_zero(effort: str) -> None:
    """At s = 0 and rest, where the logarithm of the base is infinite: A = [[0, 1], [-1, 0]]."""
    model = gelenk.linearize(slide(effort, start=0.0), states=["S.s", "S.v"])
    np.testing.assert_array_equal(np.asarray(model.A), [[0, 1], [-1, 0]])


@warned.MOVING
@pytest.mark.parametrize("effort", ["-hypot(s, v)", "-sqrt(s^2)", "-cbrt(s)*s"])
def test_law_without_derivatives_has_no_linear_model(effort: str) -> None:
    with pytest.raises(gelenk.UsageError, match=r"S\.a: found no derivatives at the operating point"):
        gelenk.linearize(slide(effort, start=0.0))
    moved = gelenk.linearize(slide(effort, start=0.1), states=["S.s", "S.v"])
    assert np.isfinite(np.asarray(moved.A)).all()


def test_law_is_part_of_the_state_machine_of_runs(tmp_path: Any) -> None:
    """Saved and restored to the bit, and the same in an FMU up to the rounding of its outputs."""
    plant = gelenk.load(slide("-100*sinh(s) - 2*v^3"))
    simulation = gelenk.Simulation(plant)
    simulation.initialize()
    simulation.step_to(0.3)
    saved = simulation.save()
    simulation.step_to(0.6)
    first = simulation.values()
    simulation.restore(saved)
    simulation.step_to(0.6)
    np.testing.assert_array_equal(simulation.values(), first)
    direct = gelenk.simulate(plant, stop=0.6, step=0.1)
    fmu = gelenk.simulate(gelenk.export_fmu(plant, tmp_path / "law.fmu"), stop=0.6, step=0.1)
    np.testing.assert_allclose(np.asarray(direct["S.s"]), np.asarray(fmu["S.s"]), rtol=0, atol=1e-12)
    assert plant.to_dict()["joints"]["S"]["law"] == {"effort": "-100*sinh(s) - 2*v^3"}


@pytest.mark.parametrize(
    ("effort", "message"),
    [
        ("-100*phi", r"column 6: found 'phi'.*expected.* s, v"),
        ("-k*s", "column 2: found 'k'"),
        ("-100 s", r"-?100\*s"),
        ({}, "an expression of s, v, t, inputs, states, coordinates of joints in N"),
    ],
)
def test_mistakes_are_errors_of_the_scene(effort: Any, message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=r"(?s)joints\.S\.law\.effort.*" + message):
        gelenk.load(slide(effort))


def test_law_needs_a_joint_with_one_coordinate() -> None:
    ball = joint("spherical", frame("ground"), frame("mass"), law={"effort": "1"})
    with pytest.raises(gelenk.SceneError, match=r"joints\.B\.law"):
        gelenk.load(scene({"mass": body(1.0)}, {"B": ball}))


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida"])
def test_force_that_is_not_finite_ends_the_run(integrator: str) -> None:
    """A logarithm whose argument reaches zero: the step is refused, and the state is that before it."""
    simulation = gelenk.Simulation(slide("-10 + 1e-3*log(s)", integrator=integrator, step=1e-3))
    simulation.initialize()
    simulation.step_to(0.1)
    with pytest.raises(gelenk.StepError):
        simulation.step_to(1.0)
    assert simulation.time == 0.1
