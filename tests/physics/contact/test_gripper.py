# SPDX-License-Identifier: BSD-3-Clause
"""The gripper of the gallery, as an FMU with steps of 1 ms: it closes on a box, lifts it and lowers it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gelenk

SCENE = Path(__file__).resolve().parents[3] / "docs" / "gallery" / "gripper" / "scene.yaml"
STEP = 1e-3  # s
TORQUE = 0.8  # N m, of each motor
ARM = 0.1  # m
MASS = 0.5  # kg, of the box
G = 9.81  # m/s2
GRIPPED, STEPS = 300, 1800  # steps after which it is at rest between the pads, and of the run
LIFT, RATE = 0.05, np.pi  # m, rad/s: the palm is raised by LIFT (1 - cos(RATE t))


class Plant:
    """An instance of the FMU whose outputs are read by name."""

    def __init__(self, folder: str, name: str) -> None:
        from fmpy import read_model_description
        from fmpy.fmi2 import FMU2Slave

        description = read_model_description(folder)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.outputs = [v.name for v in description.modelVariables if v.causality == "output"]
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        torques = [self.references["grip1.tau"], self.references["grip2.tau"]]
        self.fmu.setReal(torques, [TORQUE, TORQUE])
        self.fmu.exitInitializationMode()

    def run(self, first: int, last: int, names: list[str]) -> NDArray[np.float64]:
        """Outputs after each of these steps."""
        references = [self.references[name] for name in names]
        rows = []
        for k in range(first, last):
            self.fmu.doStep(k * STEP, STEP)
            rows.append(self.fmu.getReal(references))
        return np.array(rows)

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> str:
    from fmpy import extract

    path = tmp_path_factory.mktemp("gripper")
    return str(extract(str(gelenk.export_fmu(gelenk.load(SCENE), path / "gripper.fmu")), str(path / "fmu")))


@pytest.fixture
def plants(folder: str) -> Iterator[tuple[Plant, Plant]]:
    both = Plant(folder, "one"), Plant(folder, "other")
    yield both
    for plant in both:
        plant.close()


@pytest.fixture(scope="module")
def run(folder: str) -> dict[str, Any]:
    plant = Plant(folder, "run")
    names = [*plant.outputs, "constraints.position", "solver.cone_residual", "solver.cone_iterations"]
    rows = plant.run(0, STEPS, names)
    plant.close()
    return dict(zip(names, rows.T, strict=True))


def test_grip_force_follows_from_the_torque(run: dict[str, Any]) -> None:
    """With vertical arms, virtual work gives 2 tau = 2 F L for both fingers, and friction carries the box."""
    force = TORQUE / ARM
    for name, sign in (("right", -1), ("left", 1)):
        assert run[f"{name}.f[1]"][GRIPPED:] == pytest.approx(sign * force, rel=1e-8)
        assert set(run[f"{name}.mode"][GRIPPED:]) == {1}
    carried = run["right.f[3]"] + run["left.f[3]"]
    middle = STEP * (np.arange(STEPS) + 0.5)  # forces are means over a step
    weight = MASS * (G + LIFT * RATE**2 * np.cos(RATE * middle))
    # 1e-6: the mean differs from the value in the middle by RATE2 STEP2 / 24 of the acceleration.
    assert carried[GRIPPED:] == pytest.approx(weight[GRIPPED:], rel=1e-6)


def test_box_does_not_creep_between_the_pads(run: dict[str, Any]) -> None:
    """It moves with the palm, whose position is prescribed; its own is the integral of the same velocity.

    By steps of order 2 it differs by h2 / 12 of the change of the acceleration, and by less than 1 nm where
    that is the same again.
    """
    raised = np.asarray(run["place.r[3]"]) - run["lift.s"]
    assert np.ptp(raised[GRIPPED:]) <= 1.1 * STEP**2 / 12 * 2 * LIFT * RATE**2
    later = 2 * 1000 - GRIPPED - 2  # rows begin after the first step; accelerations are symmetric about 1 s
    assert raised[later] == pytest.approx(raised[GRIPPED], abs=1e-9)
    for name in ("place.r[1]", "place.r[2]", "place.Q[2]"):
        assert np.ptp(run[name][GRIPPED:]) <= 1e-11
    assert np.ptp(run["lift.s"][GRIPPED:]) > 0.08


def test_loops_stay_closed_and_steps_are_bounded(run: dict[str, Any]) -> None:
    """The pads strike the box; 200 iterations are the bound of the solver."""
    assert {0, 1} <= set(run["right.mode"])
    assert run["constraints.position"].max() <= 1e-13
    assert run["solver.cone_iterations"].max() <= 100
    assert run["solver.cone_residual"].max() <= 1e-10


@pytest.mark.parametrize("first", ["impact", 200, 700])
def test_state_saved_in_contact_continues_with_the_same_bits(
    plants: tuple[Plant, Plant], run: dict[str, Any], first: str | int
) -> None:
    """In the step of the first impact, while the pads settle, and while the box is lifted."""
    start = int((np.asarray(run["right.mode"]) > 0).argmax()) if isinstance(first, str) else first
    one, other = plants
    names = [*one.outputs, "solver.cone_residual", "solver.cone_iterations", "solver.contact_points"]
    one.run(0, start, names)
    state = one.fmu.getFMUState()
    saved = one.fmu.serializeFMUState(state)
    expected = one.run(start, start + 50, names)
    other.fmu.setFMUState(other.fmu.deSerializeFMUstate(saved))
    assert np.array_equal(other.run(start, start + 50, names), expected)
    one.fmu.setFMUState(state)
    assert np.array_equal(one.run(start, start + 50, names), expected)
    one.fmu.freeFMUState(state)
