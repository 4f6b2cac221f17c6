# SPDX-License-Identifier: BSD-3-Clause
"""What is set between two steps counts from there on, outputs read or not, and whatever failed before."""

from __future__ import annotations

import math
from pathlib import Path

import fmpy
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

from .host import DISCARD, OK, Fmu, Slave

STEP = 0.01
BOB = body(1.0, (0.5, 0, 0), (0.01, 0.1, 0.1))
INERTIA = 0.1 + 1.0 * 0.5**2  # kg m2, about the pin


def exported(source: Scene, folder: Path) -> Fmu:
    return Fmu(fmpy.extract(str(gelenk.export_fmu(source, folder / "x.fmu")), str(folder / "extracted")))


def pendulum(integrator: str) -> Scene:
    start = {"phi": 0.3, "w": 1.0}
    pin = joint("revolute", frame("ground"), frame("bob"), axis=[0, 1, 0], start=start)
    out = scene({"bob": BOB}, {"A": pin}, gravity=[0, 0, -10.0])
    return {**out, "parameters": ["gravity"], "solver": {"integrator": integrator}}


def by_formula(slave: Slave, gravity: float) -> float:
    return gravity * 0.5 * math.cos(slave.get("A.phi")) / INERTIA


INTEGRATORS = ["auto", "rk4", "erk", "dirk", "cvode", "ida", "generalized-alpha"]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_tuned_gravity_counts_at_once(integrator: str, tmp_path: Path) -> None:
    """Nothing else has changed; what has been computed for these speeds was so with another one."""
    fmu = exported(pendulum(integrator), tmp_path)
    ends = []
    for looks in (False, True):
        s = Slave(fmu).start()
        for k in range(10):
            assert s.step(k * STEP, STEP) == OK, s.said
            if k == 4:
                assert s.set({"gravity[3]": -20.0}) == OK, s.said
                if looks:
                    for gravity in (20.0, 10.0, 20.0):
                        assert s.set({"gravity[3]": -gravity}) == OK, s.said
                        assert s.get("A.a") == pytest.approx(
                            by_formula(s, gravity), rel=1e-13
                        )  # some ten roundings
        ends.append(s.outputs())
    assert ends[0] == ends[1]


def led(kind: str) -> Scene:
    """A double pendulum whose first joint an input leads."""
    joints = {
        "A": joint("revolute", frame("ground"), frame("crank"), axis=[0, 1, 0]),
        "B": joint("revolute", frame("crank", (1, 0, 0)), frame("bob"), axis=[0, 1, 0], start={"phi": 0.3}),
    }
    out = scene({"crank": BOB, "bob": BOB}, joints, gravity=[0, 0, -10.0])
    out["motors"] = {"drive": {"joint": "B"}}
    out["constraints"] = {"lead": {"type": "motion", "joint": "A", "input": kind}}
    return {**out, "experiment": {"tolerance": 1e-11}}


@pytest.mark.parametrize(("kind", "signal"), [("position", "lead.phi_ref"), ("speed", "lead.w_ref")])
def test_a_led_joint_jumps_again_after_a_refused_step(kind: str, signal: str, tmp_path: Path) -> None:
    """A jump is an impact: the joint that is free takes part in it. The step that brought it was refused,
    for a torque without bounds; made again it brings it again, as where nothing failed.
    """
    fmu = exported(led(kind), tmp_path)
    ends = []
    for fails in (False, True):
        s = Slave(fmu).start()
        for k in range(5):
            assert s.step(k * STEP, STEP) == OK, s.said
        assert s.set({signal: 0.2}) == OK
        if fails:
            assert s.set_real(drive__tau=1e300) == OK
            assert s.step(5 * STEP, STEP) == DISCARD
            assert s.set_real(drive__tau=0.0) == OK
        assert s.step(5 * STEP, STEP) == OK, s.said
        ends.append(s.outputs())
    assert ends[1] == pytest.approx(
        ends[0], rel=1e-9, abs=1e-9
    )  # 100 times the tolerance: methods begin anew
    assert ends[0] != pytest.approx([0.0] * len(ends[0]), abs=1e-3)
