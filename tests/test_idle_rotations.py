# SPDX-License-Identifier: BSD-3-Clause
"""Linear models of mechanisms with rods between two ball joints, which may spin about their axes.

A spin on which nothing depends is left out of the model, and the model says so; one that matters is a state.
"""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, body, frame, joint, placed, reordered, rotation, scene
from scipy.optimize import brentq
from special.plants import without

import gelenk
from gelenk.linear import linear_model

CRANK, ROD, ROCKER = 0.2, 0.9, 0.5  # m
STIFFNESS, J_CRANK, J_ROCKER, M_ROD, J_ROD = 30.0, 0.05, 0.12, 0.3, 0.02  # N m/rad, kg m2, kg, kg m2
PIVOT = np.array([0.3, 0.6, 0.0])
ANGLE = 0.5


def rocker_angle(q: float) -> float:
    """The crank turns about z at the origin, the rocker about x at its pivot; the rod has a fixed length."""
    tip = CRANK * np.array([math.cos(q), math.sin(q), 0])

    def excess(r: float) -> float:
        end = PIVOT + ROCKER * np.array([0, math.cos(r), math.sin(r)])
        return float(np.sum((end - tip) ** 2) - ROD**2)

    return float(brentq(excess, -0.2, 2.0, xtol=1e-15))


def natural_frequency() -> float:
    """Of the spring and the inertia reduced to the crank; nothing makes the rod spin about its axis."""
    h = 1e-5
    r, dr = rocker_angle(ANGLE), (rocker_angle(ANGLE + h) - rocker_angle(ANGLE - h)) / (2 * h)
    tip = CRANK * np.array([math.cos(ANGLE), math.sin(ANGLE), 0])
    end = PIVOT + ROCKER * np.array([0, math.cos(r), math.sin(r)])
    v_tip = CRANK * np.array([-math.sin(ANGLE), math.cos(ANGLE), 0])
    v_end = dr * ROCKER * np.array([0, -math.sin(r), math.cos(r)])
    center = (v_tip + v_end) / 2
    w = np.cross(end - tip, v_end - v_tip) / ROD**2
    inertia = J_CRANK + J_ROCKER * dr**2 + M_ROD * center @ center + J_ROD * w @ w
    return math.sqrt(STIFFNESS / inertia)


def rssr() -> dict[str, Any]:
    bodies = {
        "crank": body(1, inertia=(J_CRANK, J_CRANK, J_CRANK)),
        "rod": body(M_ROD, (ROD / 2, 0, 0), (1e-4, J_ROD, J_ROD)),
        "rocker": body(1, inertia=(J_ROCKER, 0.1, 0.1)),
    }
    spring = {"stiffness": STIFFNESS, "spring_reference": ANGLE}
    turned = {"rotation": {"axis": [0, -0.5, 0.9], "angle": 1.0}}
    joints = {
        "A": joint("revolute", frame("ground"), frame("crank"), axis=[0, 0, 1],
                   start={"phi": ANGLE, "w": 0, "fixed": True}, **spring),
        "B": joint("spherical", frame("crank", (CRANK, 0, 0)), frame("rod"), start=turned),
        "C": joint("spherical", frame("rod", (ROD, 0, 0)), frame("rocker", (0, ROCKER, 0))),
        "D": joint("revolute", frame("ground", PIVOT), frame("rocker"), axis=[1, 0, 0],
                   start={"phi": rocker_angle(ANGLE)}),
    }  # fmt: skip
    return scene(bodies, joints, name="RSSR", motors={"drive": {"joint": "A"}})


def oscillation(poles: np.ndarray) -> float:
    assert len(poles) == 2
    assert abs(poles.real).max() < 1e-9 * abs(poles).max()
    return float(abs(poles.imag).max())


@pytest.mark.parametrize(
    "source",
    [
        rssr(),
        without(rssr(), cut_choice=False),
        without(rssr(), all=False),
        reordered(rssr(), 1),
        reordered(rssr(), 4),
        placed(rssr(), rotation([1, 2, 3], 0.8)),
    ],
)
def test_rod_between_balls_has_the_linear_model_of_the_crank(source: dict[str, Any]) -> None:
    """1e-8: of the differences of the rocker's angle."""
    model = linear_model(source)
    assert model.states == ("A.phi", "A.w")
    assert oscillation(np.linalg.eigvals(model.A)) == pytest.approx(natural_frequency(), rel=1e-8)
    assert len(model.left_out) == 2
    assert all(name in str(model) for name in model.left_out)
    assert {"A.phi", "D.phi"} <= set(model.outputs)
    assert not {"B.Q[1]", "B.w[1]"} & set(model.outputs)  # they depend on the spin


def test_leaving_out_is_said_unless_states_are_chosen(recwarn: pytest.WarningsRecorder) -> None:
    with pytest.warns(gelenk.OperatingPointWarning, match=r"left out: \S*theta\[\d\], .* nothing depends"):
        gelenk.linearize(rssr())
    recwarn.clear()
    for states in (["A.phi"], ["D.phi"], ["A.phi", "A.w"]):
        model = gelenk.linearize(rssr(), states=states, outputs=["D.phi"])
        assert oscillation(model.poles()) == pytest.approx(natural_frequency(), rel=1e-8)
    assert not recwarn.list


def test_idle_spin_can_be_a_state_and_an_output() -> None:
    spin = linear_model(rssr()).left_out
    joint_name = spin[0].partition(".")[0]
    whole = linear_model(rssr(), states=["A.phi", spin[0]])
    assert whole.states == ("A.phi", spin[0], "A.w", spin[1])
    assert sorted(abs(np.linalg.eigvals(whole.A).imag))[2:] == pytest.approx(
        2 * [natural_frequency()], rel=1e-8
    )
    assert linear_model(rssr(), outputs=[f"{joint_name}.w[1]"]).left_out == ()
    with pytest.raises(gelenk.UsageError, match=r"depends on .*, which is not among them"):
        gelenk.linearize(rssr(), states=["A.phi"], outputs=[f"{joint_name}.w[1]"])


def test_fmu_has_the_same_model(tmp_path: Path) -> None:
    model, of_fmu = linear_model(rssr()), linear_model(gelenk.export_fmu(rssr(), tmp_path / "RSSR.fmu"))
    assert of_fmu.states == model.states
    assert of_fmu.left_out == model.left_out
    assert np.allclose(of_fmu.A, model.A, rtol=1e-9, atol=1e-9)


def hung() -> dict[str, Any]:
    """A body on two balls on the ground, with its center of mass beside the line between them."""
    bodies = {"bar": body(2.0, (0.5, 0, -0.3), (0.05, 0.1, 0.1))}
    R = rotation([0, 1, 0], 0.4)
    joints = {
        "B": joint("spherical", frame("ground", (0, 0, 0), R), frame("bar")),
        "C": joint("spherical", frame("ground", R @ [1.0, 0, 0], R), frame("bar", (1, 0, 0))),
    }
    return scene(bodies, joints, name="Hung", gravity=[0, 0, -GRAVITY])


@pytest.mark.parametrize("cut_choice", [True, False])
def test_spin_that_matters_is_a_state(cut_choice: bool) -> None:
    """A pendulum about an axis inclined by 0.4 rad; states had been refused, too."""
    model = linear_model(without(hung(), cut_choice=cut_choice))
    assert model.left_out == ()
    exact = math.sqrt(2.0 * GRAVITY * math.cos(0.4) * 0.3 / (0.05 + 2.0 * 0.3**2))
    assert oscillation(np.linalg.eigvals(model.A)) == pytest.approx(exact, rel=1e-12)
    assert gelenk.modes(hung()).modes[-1].eigenvalue.imag == pytest.approx(exact, rel=1e-12)


def hexapod(lower: str) -> dict[str, Any]:
    """A platform on six rods whose lower ends slide upright on springs; each has a ball at its upper end."""
    bodies = {"platform": body(5, inertia=(0.3, 0.4, 0.6))}
    joints: dict[str, Any] = {}
    for i in range(6):
        low = math.radians(60 * (i // 2) * 2 + (15 if i % 2 else -15))
        top = math.radians(60 * (i // 2) * 2 + (45 if i % 2 else -45))
        foot = np.array([math.cos(low), math.sin(low), 0.0])
        head = np.array([0.6 * math.cos(top), 0.6 * math.sin(top), 0.8])
        along = (head - foot) / np.linalg.norm(head - foot)
        side = np.cross(along, [0, 0, 1]) / np.linalg.norm(np.cross(along, [0, 0, 1]))
        R = np.column_stack([along, side, np.cross(along, side)])
        length = float(np.linalg.norm(head - foot))
        bodies[f"shoe{i}"] = body(0.5)
        bodies[f"rod{i}"] = body(0.2, (length / 2, 0, 0), (1e-9, 0.01, 0.01))
        joints[f"P{i}"] = joint("prismatic", frame("ground", foot), frame(f"shoe{i}"), axis=[0, 0, 1],
                                stiffness=800.0 + 100 * i, start={"s": 0.0, "fixed": True})  # fmt: skip
        axes = {"axes": [[0, 1, 0], [0, 0, 1]]} if lower == "universal" else {}
        joints[f"L{i}"] = joint(lower, frame(f"shoe{i}", (0, 0, 0), R), frame(f"rod{i}"), **axes)
        joints[f"U{i}"] = joint("spherical", frame(f"rod{i}", (length, 0, 0), R.T), frame("platform", head))
    return scene(bodies, joints, name="Hexapod")


def test_six_idle_rods_leave_the_poles_of_the_platform() -> None:
    """Universal joints instead of the lower balls prevent the spins; about the axes, rods have no inertia."""
    model = linear_model(hexapod("spherical"))
    assert len(model.left_out) == 12
    assert len(model.states) == 12
    expected = linear_model(hexapod("universal"))
    assert expected.left_out == ()
    found, exact = (sorted(abs(np.linalg.eigvals(m.A).imag)) for m in (model, expected))
    assert found == pytest.approx(exact, rel=1e-6)  # inertia about the rods' axes, relative to the others
    chosen = gelenk.linearize(hexapod("spherical"), states=[f"P{i}.s" for i in range(6)])
    assert sorted(abs(chosen.poles().imag)) == pytest.approx(found, rel=1e-9)


def test_spin_is_no_obstacle_to_an_equilibrium() -> None:
    loaded = copy.deepcopy(rssr())
    loaded["gravity"] = [0, 0, -GRAVITY]
    loaded["joints"]["A"]["start"] = {"phi": ANGLE}
    at = gelenk.equilibrium(loaded)
    assert at.residual < 1e-8
