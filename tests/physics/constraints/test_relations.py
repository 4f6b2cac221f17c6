# SPDX-License-Identifier: BSD-3-Clause
"""Relations of coordinates that the user writes: exact solutions, energy, virtual work, other constraints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, scene
from models.running import assert_continues_to_the_bit
from scipy.integrate import solve_ivp

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "ida"]
FORMULATIONS = ["projection", "independent", "baumgarte", "udwadia-kalaba", "augmented-lagrangian", "index3",
                "stabilized-index2"]  # fmt: skip


def plant(relation: dict[str, Any], size: float = 1.0, **solver: Any) -> dict[str, Any]:
    """A wheel of 0.5 kg m2 with a torque, and a slide of 2 kg against gravity; lengths times `size`."""
    return scene(
        {"wheel": body(1.0, inertia=(0.5 * size**2,) * 3), "slide": body(2.0)},
        {
            "A": joint("revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1],
                       start={"phi": 0.3, "w": 2.0, "fixed": True}),
            "S": joint("prismatic", frame("ground", (2 * size, 0, 0)), frame("slide"), axis=[1, 0, 0]),
        },
        constraints={"r": {"type": "relation", **relation}},
        gravity=[-9.81 * size, 0, 0],
        solver=solver,
    )  # fmt: skip


def run(of: dict[str, Any], stop: float = 1.0, step: float = 0.1, tolerance: float = 1e-9) -> gelenk.Result:
    return gelenk.simulate(of, stop=stop, step=step, tolerance=tolerance)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4", "generalized-alpha"])
@pytest.mark.parametrize(
    "relation",
    [
        {"joint": "S", "gives": "0.4*A.phi + 0.1"},
        {"joint": "S", "zero": "7*(S.s - 0.4*A.phi - 0.1)"},
        {"joint": "S", "zero": "S.v - 0.4*A.w"},
    ],
)
def test_a_linear_relation_is_a_rack(relation: dict[str, Any], integrator: str) -> None:
    rack = plant({"joint": "S", "gives": "0"}, integrator=integrator)
    rack["constraints"] = {"r": {"type": "rack", "rack": "S", "pinion": "A", "radius": 0.4, "offset": 0.1}}
    related = plant(relation, integrator=integrator)
    if "w" in relation.get("zero", ""):
        related["joints"]["S"]["start"] = {"s": 0.22, "fixed": True}
    expected, found = run(rack), run(related)
    for name in ("A.phi", "A.w", "A.a", "S.s", "S.v", "S.a", "r.f"):
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=2e-8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_cam_conserves_energy_in_all_formulations(formulation: str) -> None:
    """With s = 0.3 cos phi + 0.1 cos 2 phi the energy of both depends on phi."""
    of = plant({"joint": "S", "gives": "0.3*cos(A.phi) + 0.1*cos(2*A.phi)"}, formulation=formulation)
    result = run(of, stop=3.0, tolerance=1e-9)
    phi, w = result["A.phi"], result["A.w"]
    s = 0.3 * np.cos(phi) + 0.1 * np.cos(2 * phi)
    slope = -0.3 * np.sin(phi) - 0.2 * np.sin(2 * phi)
    loose = formulation in ("augmented-lagrangian", "udwadia-kalaba", "baumgarte", "index3")
    np.testing.assert_allclose(result["S.s"], s, atol=1e-6 if loose else 1e-9)
    np.testing.assert_allclose(result["S.v"], slope * w, atol=1e-5 if loose else 1e-8)
    energy = 0.5 * w**2 / 2 + result["S.v"] ** 2 + 2 * 9.81 * result["S.s"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5 if loose else 1e-7)


@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize("size", [1e-3, 1.0, 40.0])
def test_an_implicit_relation_against_independent_integration(integrator: str, size: float) -> None:
    """An ellipse (s/0.5)^2 + (phi/2)^2 = 1 in the plane of both coordinates, at any length."""
    zero = f"(S.s/{0.5 * size})^2 + (A.phi/2)^2 - 1"
    of = plant({"joint": "S", "zero": zero}, size, integrator=integrator)
    of["joints"]["S"]["start"] = {"s": 0.5 * size}
    result = run(of, stop=2.0)

    def rate(_: float, y: Any) -> list[float]:
        phi, w = y
        s = 0.5 * math.sqrt(1 - phi**2 / 4)
        slope = -(0.25 * phi / 4) / s
        bend = -(0.25 / 4 + slope**2) / s
        # (0.5 + 2 slope^2) w' = -2 slope bend w^2 - 2 g slope
        return [w, -(2 * slope * bend * w**2 + 2 * 9.81 * slope) / (0.5 + 2 * slope**2)]

    # Until the slide comes near the end of the ellipse, where phi has no function.
    exact = solve_ivp(rate, (0, 0.5), [0.3, 2.0], method="DOP853", rtol=1e-12, atol=1e-13, t_eval=[0.5])
    assert result["A.phi"][5] == pytest.approx(exact.y[0, -1], abs=1e-8)
    circle = (result["S.s"] / (0.5 * size)) ** 2 + (result["A.phi"] / 2) ** 2
    np.testing.assert_allclose(circle, 1, atol=1e-9)
    assert max(abs(result["A.phi"])) > 1.9  # it passes the place where dS/dphi is infinite


def cycloid(amplitude: float, **solver: Any) -> dict[str, Any]:
    """A bead on x = a (p + sin p), y = a (1 - cos p), a = 0.7 m, where p is the angle of a massless wheel."""
    start = {"phi": amplitude, "fixed": True}
    return scene(
        {"cart": body(0.0), "bead": body(1.3), "wheel": body(0.0)},
        {
            "X": joint("prismatic", frame("ground"), frame("cart"), axis=[1, 0, 0]),
            "Y": joint("prismatic", frame("cart"), frame("bead"), axis=[0, 0, 1]),
            "P": joint("revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1], start=start),
        },
        constraints={
            "x": {"type": "relation", "joint": "X", "gives": "0.7*(P.phi + sin(P.phi))"},
            "y": {"type": "relation", "joint": "Y", "gives": "0.7*(1 - cos(P.phi))"},
        },
        gravity=[0, 0, -9.81],
        solver=solver,
    )


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize("amplitude", [0.5, 2.5])
def test_a_bead_on_a_cycloid_swings_in_the_same_time(
    amplitude: float, integrator: str, tolerance: float
) -> None:
    """Huygens: the way 4 a sin(p/2) is harmonic, with g/(4 a); nearly up to the cusp. Ten tolerances."""
    if tolerance < 1e-9 and integrator in ("cvode", "ida"):
        pytest.skip("below what it can achieve")
    simulation = gelenk.Simulation(cycloid(amplitude, integrator=integrator))
    simulation.initialize(0.0, tolerance)
    rate = math.sqrt(9.81 / (4 * 0.7))
    for k in range(1, 21):
        simulation.step_to(0.4 * k)
        exact = 2 * math.asin(math.sin(amplitude / 2) * math.cos(rate * 0.4 * k))
        assert abs(simulation.output("P.phi") - exact) < 10 * tolerance


def test_forces_do_virtual_work() -> None:
    """Force f on the slide, and -f ds/dphi on the wheel: 0.5 a = -f s'."""
    result = run(plant({"joint": "S", "gives": "0.3*sin(A.phi)"}))
    slope = 0.3 * np.cos(result["A.phi"])
    np.testing.assert_allclose(result["r.f"], 2 * (result["S.a"] + 9.81), rtol=1e-9)
    np.testing.assert_allclose(0.5 * result["A.a"], -result["r.f"] * slope, rtol=1e-9, atol=1e-12)
    other = run(plant({"joint": "A", "zero": "S.s - 0.3*sin(A.phi)"}))
    np.testing.assert_allclose(other["r.tau"], 0.5 * other["A.a"], rtol=1e-9, atol=1e-12)


def test_three_joints_and_a_redundant_name() -> None:
    """A differential hoist: s = 0.2 (phi - psi), the sum of torques as by virtual work; A.phi named twice."""
    of = plant({"joint": "S", "zero": "S.s - 0.2*(2*A.phi - A.phi - B.phi)"})
    of["bodies"]["other"] = body(1.0, inertia=(0.3, 0.3, 0.3))
    of["joints"]["B"] = joint("revolute", frame("ground"), frame("other"), axis=[0, 0, 1],
                              start={"phi": 0.1, "w": -1.0, "fixed": True})  # fmt: skip
    result = run(of)
    np.testing.assert_allclose(result["S.s"], 0.2 * (result["A.phi"] - result["B.phi"]), atol=1e-9)
    np.testing.assert_allclose(0.5 * result["A.a"], -0.2 * result["r.f"], rtol=1e-9)
    np.testing.assert_allclose(0.3 * result["B.a"], 0.2 * result["r.f"], rtol=1e-9)


def test_several_relations_of_one_joint() -> None:
    """Both say the same: it is redundant, and the forces share in what one alone exerts."""
    of = plant({"joint": "S", "gives": "0.3*cos(A.phi)"})
    alone = run(of)
    of["constraints"]["again"] = {"type": "relation", "joint": "S", "zero": "2*S.s - 0.6*cos(A.phi)"}
    result = run(of)
    np.testing.assert_allclose(result["A.phi"], alone["A.phi"], atol=1e-8)
    np.testing.assert_allclose(result["r.f"] + result["again.f"], alone["r.f"], rtol=1e-6)


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_a_nonholonomic_relation_of_rates(integrator: str) -> None:
    """A gear whose ratio depends on a third coordinate: v = 0.1 (1 + psi^2) w, linear in the rates."""
    of = plant({"joint": "S", "zero": "S.v - 0.1*(1 + B.phi^2)*A.w"}, integrator=integrator)
    of["bodies"]["shift"] = body(1.0, inertia=(0.3, 0.3, 0.3))
    of["joints"]["B"] = joint("revolute", frame("ground"), frame("shift"), axis=[0, 0, 1],
                              start={"phi": 0.1, "w": 1.5, "fixed": True})  # fmt: skip
    of["joints"]["S"]["start"] = {"s": 0.2, "fixed": True}
    result = run(of)

    def rate(t: float, y: Any) -> list[float]:
        psi = 0.1 + 1.5 * t
        k, kdot = 0.1 * (1 + psi**2), 0.2 * psi * 1.5
        w = y[1]
        return [w, -k * (2 * kdot * w + 2 * 9.81) / (0.5 + 2 * k**2), k * w]

    exact = solve_ivp(rate, (0, 1), [0.3, 2.0, 0.2], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert result["A.phi"][-1] == pytest.approx(exact[0], abs=1e-8)
    assert result["S.s"][-1] == pytest.approx(exact[2], abs=1e-8)


def test_linear_models_are_exact() -> None:
    """About phi = pi, where s = 0.3 cos phi is least: 0.5 dphi'' = -2 g s'' dphi."""
    of = plant({"joint": "S", "gives": "0.3*cos(A.phi)"})
    of["joints"]["A"]["start"] = {"phi": math.pi, "fixed": True}
    model = gelenk.linearize(of)
    mode = max(np.linalg.eigvals(model.A).imag)
    assert mode == pytest.approx(math.sqrt(2 * 9.81 * 0.3 / 0.5), rel=1e-10)


def test_it_may_close_a_loop_of_its_own_with_others() -> None:
    """A four-bar whose crank also drives a slide: one degree of freedom, energy is conserved."""
    of = four_bar(damping=0.0)
    of["bodies"]["slide"] = body(0.5)
    of["joints"]["S"] = joint("prismatic", frame("ground", (3, 0, 0)), frame("slide"), axis=[1, 0, 0])
    of["constraints"] = {"r": {"type": "relation", "joint": "S", "gives": "0.1*sin(2*A.phi)"}}
    of["sensors"] = {"e": {"type": "energy"}}
    result = gelenk.simulate(of, stop=2.0, step=0.1, tolerance=1e-10, inputs={"drive.tau": 0.0})
    np.testing.assert_allclose(result["S.s"], 0.1 * np.sin(2 * result["A.phi"]), atol=1e-10)
    np.testing.assert_allclose(result["e.total"], result["e.total"][0], atol=1e-7)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "cvode", "dirk"])
def test_saved_states_lead_on_to_the_bit(integrator: str) -> None:
    of = plant({"joint": "S", "gives": "0.3*cos(A.phi)"}, integrator=integrator)
    assert_continues_to_the_bit(of, 0.31, 0.31 + 0.07 * np.arange(1, 6), 1e-7)


@pytest.mark.parametrize(
    ("relation", "message"),
    [
        ({"joint": "S"}, "found none of gives, zero"),
        ({"joint": "S", "gives": "A.phi", "zero": "S.s"}, "gives, zero together"),
        ({"joint": "S", "gives": "0.2"}, "names coordinates"),
        ({"joint": "S", "gives": "0.2*t"}, "'t'.*coordinates of joints and constants only"),
        ({"joint": "S", "gives": "abs(A.phi)"}, "smooth"),
        ({"joint": "S", "gives": "0.1*A.w"}, "found a rate in gives"),
        ({"joint": "S", "zero": "A.phi - 1"}, "no coordinate of joint S in zero"),
        ({"joint": "S", "zero": "S.v - A.w^2"}, "not linear in the rates"),
        ({"joint": "S", "gives": "0.1*B.phi"}, "B.phi"),
        ({"joint": "S", "gives": "log(-1 - A.phi^2)"}, "no finite value"),
    ],
)
def test_mistakes_are_answered_in_words(relation: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=f"(?s){message}"):
        gelenk.Simulation(plant(relation)).initialize(0.0, 1e-6)
