# SPDX-License-Identifier: BSD-3-Clause
"""Linear models, equilibria, derivatives and equations of mechanisms with engaged and released locks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.locks import LOCK, started
from models.running import assert_close

import gelenk
from gelenk.linear import linear_model

ENGAGED = {"B.lock.engagement": 1.0}
STEP = 1e-5  # of central differences: errors of some 1e-10
COMPLEX = {"a": (1.2, 0.3, 0.2), "b": (0.7, 0.2, 0.15)}  # kg, m, kg m2


def links(lock: dict[str, Any], w: tuple[float, float] = (0.4, 0.0), shoulder: Scene | None = None) -> Scene:
    """A double pendulum with a lock in its elbow."""
    return scene(
        {name: body(m, (c, 0, 0), (0.1, 0.1, inertia)) for name, (m, c, inertia) in COMPLEX.items()},
        {
            "A": joint(
                "revolute", frame("ground"), frame("a"), start={"phi": -0.7, "w": w[0]}, **(shoulder or {})
            ),
            "B": joint(
                "revolute", frame("a", (0.6, 0, 0)), frame("b"), start={"phi": 0.4, "w": w[1]}, lock=lock
            ),
        },
        gravity=[0, -GRAVITY, 0],
    )


def stiffness() -> tuple[float, float, float]:
    """Inertia about the shoulder, and moments of weight along x and y, of both links as one body."""
    (m_a, c_a, J_a), (m_b, c_b, J_b) = COMPLEX.values()
    x, y = 0.6 + c_b * math.cos(0.4), c_b * math.sin(0.4)
    J = J_a + m_a * c_a**2 + J_b + m_b * (x**2 + y**2)
    return J, GRAVITY * (m_a * c_a + m_b * x), GRAVITY * m_b * y


def test_engaged_it_is_one_pendulum() -> None:
    """Held rows leave the states of the tangent space: the elbow has none; inputs are the same."""
    model = linear_model(links(LOCK), input_values=ENGAGED)
    assert model.states == ("A.phi", "A.w")
    assert model.inputs == ("B.lock.engagement",)
    J, x, y = stiffness()
    slope = (x * math.sin(-0.7) + y * math.cos(-0.7)) / J  # of the torque -(x cos phi - y sin phi)
    np.testing.assert_allclose(model.A, np.array([[0.0, 1.0], [slope, 0.0]]), atol=1e-13)
    np.testing.assert_array_equal(model.B, 0)
    assert linear_model(links(LOCK)).states == ("A.phi", "B.phi", "A.w", "B.w")


@pytest.mark.parametrize("engaged", [0.0, 1.0])
def test_linear_models_are_central_differences_of_the_running_simulation(engaged: float) -> None:
    """Of the rates of states, in each condition, at a state in motion."""
    names = ("A.phi", "A.w") if engaged else ("A.phi", "B.phi", "A.w", "B.w")
    w = (0.4, 0.0 if engaged else -0.3)
    model = linear_model(links(LOCK, w), input_values={"B.lock.engagement": engaged})
    assert model.states == names

    def rates(displaced: str, by: float) -> list[float]:
        source = links(LOCK, w)
        name, _, key = displaced.partition(".")
        source["joints"][name]["start"][key] += by
        plant = gelenk.Simulation(source)
        plant.set_input("B.lock.engagement", engaged)
        plant.initialize(0.0, 1e-8)
        derivative = {"phi": "w", "w": "a"}
        return [plant.output(f"{n[:1]}.{derivative[n[2:]]}") for n in names]

    columns = [(np.array(rates(n, STEP)) - rates(n, -STEP)) / (2 * STEP) for n in names]
    assert_close("A", model.A, np.array(columns).T, 1e-8, "central differences")


def test_no_linear_model_before_the_impact() -> None:
    """Engaged in motion: the joint stops where the next step begins."""
    with pytest.raises(gelenk.UsageError, match=r"joints\.B\.lock is between two modes"):
        linear_model(links(LOCK, (0.4, 0.3)), input_values=ENGAGED)


def test_an_equilibrium_holds_what_is_locked() -> None:
    """As one pendulum, with the center of mass below the shoulder; the lock bears the forearm."""
    found = gelenk.equilibrium(links(LOCK), input_values=ENGAGED)
    _, x, y = stiffness()
    phi = -math.pi / 2 - math.atan2(y, x)
    assert_close("A.phi", found.values["A.phi"], phi, 1e-9, "the search")
    assert found.values["B.phi"] == 0.4
    m, c, _ = COMPLEX["b"]
    torque = m * GRAVITY * c * math.cos(phi + 0.4)
    assert_close("torque", found.values["B.lock.tau"], torque, 1e-9, "the search")
    holding = found.held["B.phi"]
    assert (holding.bound, holding.friction, holding.margin) == ("lock", 0.0, 1.0)
    assert_close("torque", holding.contact, torque, 1e-9, "the search")
    assert "lock" in str(holding)


def test_a_pose_with_friction_and_a_lock_is_held() -> None:
    source = links({"engaged": True}, (0.0, 0.0), {"friction": {"coulomb": 50.0}})
    found = gelenk.equilibrium(source, friction="present")
    _, x, y = stiffness()
    torque = x * math.cos(-0.7) - y * math.sin(-0.7)
    assert_close("friction", found.held["A.phi"].friction, torque, 1e-12, "rounding")
    assert found.held["B.phi"].bound == "lock"


def test_equations_leave_it_out_and_say_so() -> None:
    equations = gelenk.equations(links(LOCK))
    assert "B: its lock is left out; the equations hold while it is released." in equations.notes
    with pytest.raises(gelenk.SceneError, match=r"joints\.B\.lock: found a lock that is always engaged"):
        gelenk.equations(links({"engaged": True}))
    with pytest.raises(gelenk.SceneError, match="its lock is left out"):
        gelenk.batch(links(LOCK), 4)


@pytest.mark.parametrize("lock", [{}, {"engaged": False}])
def test_a_lock_that_is_never_engaged_is_refused(lock: dict[str, Any]) -> None:
    with pytest.raises(gelenk.SceneError, match=r"joints\.B\.lock: found a lock that is never engaged"):
        gelenk.load(links(lock))


def test_scenes_with_locks_are_written_as_they_were_read() -> None:
    source = links({"input": "engagement", "engaged": True})
    source["joints"]["B"] = joint(
        "free", frame("a", (0.6, 0, 0)), frame("b"), lock={"input": "engagement", "engaged": True}
    )
    written = gelenk.load(source).to_dict()
    assert written["joints"]["B"]["lock"] == {"input": "engagement", "engaged": True}
    assert gelenk.load(written).to_dict() == written
    names = [s.name for s in started(source).outputs if ".lock." in s.name]
    assert names == [*(f"B.lock.{k}[{i}]" for k in ("f", "tau") for i in (1, 2, 3)), "B.lock.mode"]


@warned.MOVING
@pytest.mark.parametrize("lock", [{"engaged": True}, LOCK])
@pytest.mark.parametrize(
    "kind", ["spherical", "universal", "cylindrical", "planar", "free", "screw", "prismatic"]
)
def test_models_of_joints_of_all_types_are_those_of_a_weld(kind: str, lock: dict[str, Any]) -> None:
    """Rotations of quaternion joints are no states, either; modes have the shapes of all bodies."""
    source = links(lock)
    ends = frame("a", (0.6, 0, 0)), frame("b")
    pitch: dict[str, Any] = {"pitch": 0.1} if kind == "screw" else {}
    source["joints"]["B"] = joint(kind, *ends, lock=lock, **pitch)
    values = {} if "engaged" in lock else ENGAGED
    welded = links(lock)
    welded["joints"]["B"] = joint("weld", *ends)
    model, expected = linear_model(source, input_values=values), linear_model(welded)
    assert model.states == expected.states == ("A.phi", "A.w")
    np.testing.assert_allclose(model.A, expected.A, atol=1e-13)
    poles, reference = (
        np.sort_complex([mode.eigenvalue for mode in gelenk.modes(s, at={"A.w": 0.0}, input_values=u).modes])
        for s, u in ((source, values), (welded, {}))
    )
    np.testing.assert_allclose(poles, reference, atol=1e-12)


def test_what_is_held_is_a_state_if_it_is_named() -> None:
    named = linear_model(links(LOCK), states=["A.phi", "B.phi"], input_values=ENGAGED)
    assert named.states == ("A.phi", "B.phi", "A.w", "B.w")
    np.testing.assert_array_equal(named.A[[1, 3]], 0)
    assert linear_model(links(LOCK), states=["A.phi"], input_values=ENGAGED).states == ("A.phi", "A.w")


@warned.MOVING
def test_modes_beside_friction_at_rest() -> None:
    """Those of one pendulum, too: whichever law holds the elbow."""
    source = links(LOCK)
    source["joints"]["B"] = source["joints"]["B"] | {"friction": {"coulomb": 100.0}}
    del source["joints"]["B"]["lock"]
    held = gelenk.modes(source, at={"A.w": 0.0})
    locked = gelenk.modes(links(LOCK), at={"A.w": 0.0}, input_values=ENGAGED)
    np.testing.assert_allclose(
        [mode.eigenvalue for mode in held.modes], [mode.eigenvalue for mode in locked.modes], atol=1e-12
    )


TIMES: dict[str, Any] = {"stop": 1.0, "step": 0.02}
ENDS = ("A.phi", "B.phi", "A.w")


@pytest.mark.parametrize("by", ["A.phi_start", "B.phi_start", "B.w_start"])
@pytest.mark.parametrize("rises", [True, False])
def test_derivatives_across_an_engagement_are_central_differences(by: str, rises: bool) -> None:
    """At a communication point, by a jump of the input; within a step, by one that rises."""
    inputs: Any = {"B.lock.engagement": (lambda t: 0.9 * t) if rises else (lambda t: float(t >= 0.5))}
    source = gelenk.load({**links(LOCK, (0.4, -1.0)), "solver": {"integrator": "erk"}})
    found = gelenk.sensitivity(source, [by], outputs=list(ENDS), inputs=inputs, **TIMES)
    value = float(source.parameters[by])
    ends = [
        [
            gelenk.simulate(source, inputs=inputs, parameters={by: value + side * STEP}, **TIMES)[n][-1]
            for n in ENDS
        ]
        for side in (-1, 1)
    ]
    expected = (np.array(ends[1]) - ends[0]) / (2 * STEP)
    assert_close("by", [found.derivative(n, by=by)[-1] for n in ENDS], expected, 1e-5, "central differences")


@pytest.mark.parametrize("held_by", ["lock", "friction"])
def test_no_derivatives_by_a_speed_that_is_held_at_the_start(held_by: str) -> None:
    """Otherwise it would appear as that of a motion when the joint is released."""
    source = links({"input": "engagement", "engaged": True})
    if held_by == "friction":
        del source["joints"]["B"]["lock"]
        source["joints"]["B"]["friction"] = {"coulomb": 100.0}
    with pytest.raises(
        gelenk.UsageError, match=r"B\.w_start: it changes B\.w, which friction, a limit or a lock"
    ):
        gelenk.sensitivity(source, ["B.w_start"], outputs=["A.phi"], stop=0.1, step=0.02)
    found = gelenk.sensitivity(source, ["B.phi_start"], outputs=["B.phi"], stop=0.1, step=0.02)
    assert found.derivative("B.phi", by="B.phi_start")[-1] == pytest.approx(1, rel=1e-9)
