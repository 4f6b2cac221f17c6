# SPDX-License-Identifier: BSD-3-Clause
"""Runs that start at equilibrium (solver.start), against gelenk.equilibrium, closed forms and the FMU."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene

import gelenk

RESIDUAL = 1e-9  # rad/s2, m/s2: residual acceleration at which the search ends
# rad: error of angles, an acceleration of RESIDUAL over the smallest stiffness here, 1 1/s2
POSITION = 1e-9


def at_rest(source: Scene) -> Scene:
    return source | {"solver": {"start": "equilibrium"}}


def started(source: Scene) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    return plant


def values(plant: gelenk.Simulation) -> dict[str, float]:
    return dict(zip((s.name for s in plant.outputs), plant.values().tolist(), strict=True))


def sprung_pendulum(phi: float) -> Scene:
    """M g l sin(phi) = k (reference - phi): 9.81 sin(phi) = 3 (1.2 - phi) with these."""
    return scene(
        {"bob": body(1.0, (0, -1, 0), (0, 0, 0))},
        {
            "A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], stiffness=3.0,
                       spring_reference=1.2, start={"phi": phi, "w": 0.7})
        },
        gravity=[0, -GRAVITY, 0], motors={"drive": {"joint": "A"}},
        experiment={"tolerance": 1e-11},  # so that a run remains there within POSITION
    )  # fmt: skip


def test_pendulum_with_a_spring_starts_at_the_balance_of_torques() -> None:
    plant = started(at_rest(sprung_pendulum(0.9)))
    phi = values(plant)["A.phi"]
    assert GRAVITY * math.sin(phi) == pytest.approx(3.0 * (1.2 - phi), abs=2 * RESIDUAL)  # 1 kg m2
    plant.step_to(5.0)
    assert values(plant)["A.phi"] == pytest.approx(phi, abs=POSITION)


def test_four_bar_starts_at_the_equilibrium_that_gelenk_equilibrium_finds() -> None:
    source = four_bar(1.0)
    source["joints"]["A"] |= {"stiffness": 4.0, "spring_reference": 0.4}
    found = gelenk.equilibrium(source)
    initial = values(started(at_rest(source)))
    assert initial == pytest.approx(found.values, abs=10 * POSITION)


def test_chain_of_ball_joints_hangs_straight() -> None:
    links = 4
    bodies = {f"link{i}": body(0.5, (0, 0, -0.1), (1e-3, 1e-3, 1e-4)) for i in range(links)}
    joints: dict[str, Any] = {}
    for i in range(links):
        parent = frame(f"link{i - 1}", (0, 0, -0.2)) if i else frame("ground")
        start = {"rotation": {"axis": [1, 0.3, 0], "angle": 0.4}}
        joints[f"J{i}"] = joint("spherical", parent, frame(f"link{i}"), start=start)
    source = scene(bodies, joints, gravity=[0, 0, -GRAVITY])
    source["sensors"] = {"tip": {"type": "frame", "body": f"link{links - 1}", "position": [0, 0, -0.2]}}
    tip = values(started(at_rest(source)))
    # Sideways errors are accelerations over g / length; that of the height is their square.
    assert [tip[f"tip.r[{i}]"] for i in (1, 2, 3)] == pytest.approx([0, 0, -0.8], abs=10 * POSITION)


def test_fmu_starts_at_equilibrium_under_its_initial_inputs(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(sprung_pendulum(0.9), tmp_path / "x.fmu")
    torque = 0.8
    run = fmpy.simulate_fmu(
        fmu, stop_time=1.0, output_interval=0.1, output=["A.phi", "A.w"],
        start_values={"solver.start": 2, "drive.tau": torque},
    )  # fmt: skip
    phi = run["A.phi"][0]
    assert GRAVITY * math.sin(phi) == pytest.approx(3.0 * (1.2 - phi) + torque, abs=2 * RESIDUAL)
    assert np.ptp(run["A.phi"]) < POSITION
    assert abs(run["A.w"]).max() < 10 * POSITION


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (
            scene({"b": body(1.0)}, {"S": joint("prismatic", frame("ground"), frame("b"), axis=[0, 0, 1])},
                  gravity=[0, 0, -GRAVITY]),
            r"solver\.start: found no equilibrium from the start values .*: the largest residual "
            r"acceleration is S\.a = 9\.81 m/s2",
        ),
        (
            sprung_pendulum(0.1) | {"constraints": {"turn": {"type": "motion", "joint": "A", "speed": 1.0}}},
            r"solver\.start: found equilibrium while constraints\.turn moves its joint at the start",
        ),
    ],
)  # fmt: skip
def test_missing_equilibrium_is_reported_with_the_reason(source: Scene, sentence: str) -> None:
    with pytest.raises(gelenk.AssemblyError, match=sentence):
        started(at_rest(source))


def test_equilibrium_with_a_joint_held_by_a_prescribed_motion() -> None:
    """The second of two pendulums hangs vertically from the first, which is held at an angle."""
    source = scene(
        {"a": body(1.0, (0, -0.5, 0), (0.1, 0, 0.1)), "b": body(1.0, (0, -0.5, 0), (0.1, 0, 0.1))},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 0, 1]),
            "B": joint("revolute", frame("a", (0, -1, 0)), frame("b"), axis=[0, 0, 1], start={"phi": 0.2}),
        },
        gravity=[0, -GRAVITY, 0],
    )
    source["constraints"] = {"held": {"type": "motion", "joint": "A", "polynomial": [0.6]}}
    found = values(started(at_rest(source)))
    assert found["A.phi"] == pytest.approx(0.6, abs=1e-12)  # closed to rounding
    assert found["B.phi"] == pytest.approx(-0.6, abs=POSITION)
    assert found["held.tau"] == pytest.approx(GRAVITY * math.sin(0.6) * (0.5 + 1.0), rel=1e-9)
