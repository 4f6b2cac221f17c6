# SPDX-License-Identifier: BSD-3-Clause
"""Linear models, equilibria and steady motions with states of elements."""

from __future__ import annotations

import math

import numpy as np
import pytest
from circuits import J, K, L, R, dc_motor, rotor
from mechanisms import body, frame, joint, scene

import gelenk


def test_linear_model_has_electrical_and_controller_poles() -> None:
    """DC motor with a PI controller of its speed: the characteristic polynomial to 1e-12."""
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


def test_equilibrium_finds_states_of_circuits_and_controllers() -> None:
    """A rod held at an angle by a motor with a controller: the integral that its weight requires."""
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
    source = dc_motor()
    source["joints"]["A"]["friction"] = {"coulomb": 8.0}
    with pytest.raises(gelenk.EquilibriumError, match=r"i\.rate"):
        gelenk.equilibrium(source, friction="present")


def test_more_than_eight_names_in_one_expression() -> None:
    """Full state feedback: twelve numbers in a law and in a rate; the linear model is exact."""
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
