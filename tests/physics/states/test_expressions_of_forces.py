# SPDX-License-Identifier: BSD-3-Clause
"""Named expressions of forces and accelerations, which are outputs only: losses, reactions, measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, scene

import gelenk


def slide(**sections: Any) -> dict[str, Any]:
    """2 kg on a guide with friction 1 N + 0.5 N s/m |v|, an accelerometer, and a spring to the ground."""
    guide = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0],
        start={"v": 3.0, "fixed": True}, friction={"law": "1 + 0.5*v"},
    )  # fmt: skip
    return scene(
        {"mass": body(2.0)}, {"S": guide}, gravity=[0, 0, 0],
        sensors={
            "imu": {"type": "imu", "body": "mass"},
            "R": {"type": "reaction", "joint": "S"},
            "whole": {"type": "energy"},
        },
        forces={"spring": {"type": "spring_damper", "from": frame("ground", (-1, 0, 0)), "to": frame("mass"),
                           "stiffness": 2.0, "length": 1.0}},
    ) | sections  # fmt: skip


EXPRESSIONS = {
    "loss": {"value": "-S.friction.f*S.v", "unit": "W"},
    "balance": "2*S.a - S.friction.f + 2*S.s",
    "measured": "imu.a[1] - S.a",
    "carried": "R.f[1] + 2*loss",
}


def test_losses_and_balances_of_forces() -> None:
    result = gelenk.simulate(slide(expressions=EXPRESSIONS), stop=4.0, step=0.1, tolerance=1e-9)
    moving = result["S.v"] != 0
    loss = (1 + 0.5 * np.abs(result["S.v"])) * np.abs(result["S.v"])
    np.testing.assert_allclose(result["loss"][moving], loss[moving], rtol=1e-12)
    assert np.all(result["loss"][~moving] == 0)
    np.testing.assert_allclose(result["balance"][moving], 0, atol=1e-12)
    np.testing.assert_allclose(result["measured"], 0, atol=1e-12)
    np.testing.assert_allclose(result["carried"], result["R.f[1]"] + 2 * result["loss"], rtol=1e-12)


def test_derivatives_of_losses_are_exact() -> None:
    """d((1 + v/2) v)/dv = 1 + v, and of 2 loss + a also -(1/2)/m."""
    of = slide(expressions={"loss": "-S.friction.f*S.v", "sum": "2*loss + S.a"})
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(of, friction="present", outputs=["loss", "sum"])
    np.testing.assert_allclose(model.C, np.array([[0.0, 4.0], [-1.0, 8 - 0.25]]), rtol=1e-12)


@pytest.mark.parametrize("closes", ["A", "C"])
def test_joints_of_a_loop_in_all_ways(closes: str, tmp_path: Path) -> None:
    """As two outputs multiplied by hand, as the only output, and of an FMU."""
    of = four_bar()
    of["joints"][closes]["friction"] = {"coulomb": 0.1, "bearing": {"coefficient": 0.05, "radius": 0.01}}
    of["expressions"] = {
        "loss": f"-{closes}.friction.tau*{closes}.w",
        "swing": f"{closes}.a*2",
    }
    whole = gelenk.simulate(of, stop=1.0, step=0.1)
    expected = -whole[f"{closes}.friction.tau"] * whole[f"{closes}.w"]
    np.testing.assert_array_equal(whole["loss"], expected)
    np.testing.assert_array_equal(whole["swing"], 2 * whole[f"{closes}.a"])
    alone = gelenk.simulate(of, stop=1.0, step=0.1, outputs=["loss"])
    np.testing.assert_array_equal(alone["loss"], expected)
    gelenk.export_fmu(of, tmp_path / "loop.fmu")
    fmu = fmpy.simulate_fmu(str(tmp_path / "loop.fmu"), stop_time=1.0, output_interval=0.1)
    np.testing.assert_allclose(fmu["loss"], expected, rtol=1e-9, atol=1e-12)
    described = fmpy.read_model_description(str(tmp_path / "loop.fmu"))
    loss = next(unknown for unknown in described.outputs if unknown.variable.name == "loss")
    names = {variable.name for variable in loss.dependencies or []}
    assert loss.dependencies is None or "drive.tau" in names


def test_gears_and_driven_joints() -> None:
    """Of the power of a motion, what a gear leaves: tau of both constraints."""
    shaft = joint("revolute", frame("ground"), frame("shaft"), friction={"coulomb": 0.0})
    load = joint("revolute", frame("ground"), frame("load"), damping=2.0)
    of = scene(
        {"shaft": body(0, inertia=(0, 0, 0.1)), "load": body(0, inertia=(0, 0, 3.0))},
        {"shaft": shaft, "load": load}, gravity=[0, 0, 0],
        constraints={
            "mesh": {"type": "gear", "joint": "shaft", "with": "load", "ratio": 4.0, "efficiency": 0.8},
            "spin": {"type": "motion", "joint": "shaft", "law": "3*t"},
        },
    )  # fmt: skip
    of["expressions"] = {
        "in": "spin.tau*shaft.w",
        "lost": "-shaft.friction.tau*shaft.w",
        "out": "-4*mesh.tau*load.w",
    }
    result = gelenk.simulate(of, stop=1.0, step=0.25)
    np.testing.assert_allclose(result["out"], 2.0 * 0.75**2, rtol=1e-10)
    np.testing.assert_allclose(result["in"], result["out"] / 0.8, rtol=1e-10)
    np.testing.assert_allclose(result["lost"], result["out"] * (1 / 0.8 - 1), rtol=1e-10)


def test_what_does_not_move_measures_constants() -> None:
    of = slide()
    of["bodies"]["wall"] = body(1.0)
    of["joints"]["W"] = joint("weld", frame("ground"), frame("wall"))
    of["expressions"] = {"still": "5 + fixed_imu.a[1]"}
    of["sensors"] = {"fixed_imu": {"type": "imu", "body": "wall"}}
    result = gelenk.simulate(of, stop=0.1, step=0.05, outputs=["still"])
    np.testing.assert_array_equal(result["still"], 5.0)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ({"S": {"effort": "loss"}}, "effort.*'S.friction.f'.*named only by rates of states"),
        ({"S": {"effort": "S.a"}}, "effort.*'S.a'.*named only by rates of states"),
    ],
)
def test_laws_cannot_wait_for_forces(where: dict[str, Any], message: str) -> None:
    of = slide(expressions=EXPRESSIONS)
    for name, law in where.items():
        of["joints"][name]["law"] = law
    with pytest.raises(gelenk.SceneError, match=f"(?s){message}"):
        gelenk.load(of)


@pytest.mark.parametrize("name", ["whole.total", "S.b", "spring.x"])
def test_what_has_no_value_of_one_island_cannot_be_named(name: str) -> None:
    with pytest.raises(gelenk.SceneError, match=rf"(?s)expressions.x.*'{name}'"):
        gelenk.load(slide(expressions={"x": name}))
