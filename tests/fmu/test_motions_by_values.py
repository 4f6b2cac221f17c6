# SPDX-License-Identifier: BSD-3-Clause
"""Masters that set the values of a prescribed motion alone: fmpy by default, libcosim always."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene
from scipy.integrate import solve_ivp

import gelenk

from .host import OK, WARNING, Fmu, Slave
from .states import everything, get_state, set_state

MASS, STIFFNESS, DAMPING = 2.0, 50.0, 8.0  # kg, N/m, N s/m
END = 0.5  # s


def driven_mass() -> Scene:
    """A mass on a spring and a damper, the other end of which is driven by an input."""
    y = joint("prismatic", frame("end"), frame("load"), axis=[1, 0, 0], stiffness=STIFFNESS, damping=DAMPING)
    out = scene(
        {"end": body(1.0), "load": body(MASS)},
        {"x": joint("prismatic", frame("ground"), frame("end"), axis=[1, 0, 0]), "y": y},
    )
    out["constraints"] = {"pos": {"type": "motion", "joint": "x", "input": "position"}}
    out["experiment"] = {"tolerance": 1e-9}
    return out


def motion(t: float) -> float:
    return math.sin(2.0 * t)


@pytest.fixture(scope="module")
def place() -> float:
    """Of the mass at END; it starts at the speed of the driven end."""
    found = solve_ivp(
        lambda t, z: [
            z[1], (STIFFNESS * (motion(t) - z[0]) + DAMPING * (2.0 * math.cos(2.0 * t) - z[1])) / MASS,
        ],
        (0.0, END), [0.0, 2.0], rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    return float(found.y[0, -1])


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(driven_mass(), tmp_path_factory.mktemp("fmu") / "x.fmu")


def by_fmpy(fmu: Path, h: float) -> float:
    times = h * np.arange(round(END / h) + 1)
    columns = [("time", float), ("pos.s_ref", float)]
    table = np.array([(t, motion(float(t))) for t in times], dtype=columns)
    run = fmpy.simulate_fmu(str(fmu), stop_time=END, output_interval=h, input=table, output=["x.s", "y.s"])
    return float(run["x.s"][-1] + run["y.s"][-1])


def by_libcosim(fmu: Path, h: float) -> float:
    execution_module = pytest.importorskip("libcosimpy.CosimExecution")
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    references = {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}
    execution = execution_module.CosimExecution.from_step_size(step_size=h * 1e9)
    index = execution.add_local_slave(local_slave=CosimLocalSlave(fmu_path=str(fmu), instance_name="plant"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator=manipulator)
    for k in range(round(END / h)):
        assert manipulator.slave_real_values(index, [references["pos.s_ref"]], [motion(k * h)])
        assert execution.step()
    return float(sum(observer.last_real_values(index, [references["x.s"], references["y.s"]])))


@pytest.mark.parametrize("master", [by_fmpy, by_libcosim])
def test_error_falls_with_the_square_of_the_step(
    master: Callable[[Path, float], float], fmu: Path, place: float
) -> None:
    """It is 0.3 m at any step if derivatives are taken as 0."""
    errors = [abs(master(fmu, h) - place) for h in (1e-2, 1e-3)]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] > 50, errors


def started(fmu: Path, folder: Path, *, logging_on: bool = False) -> Slave:
    s = Slave(Fmu(fmpy.extract(str(fmu), str(folder))), logging_on=logging_on)
    assert s.setup() == OK
    assert s.enter() == OK
    assert s.leave() == OK
    return s


def follow(s: Slave, first: int, steps: int, *, jump: float = 0.0) -> list[list[float]]:
    h = 0.01
    rows = []
    for k in range(first, first + steps):
        assert s.set({"pos.s_ref": motion(k * h) + jump}) == OK, s.said
        assert s.step(k * h, h) == OK, s.said
        rows.append(everything(s))
    return rows


@pytest.mark.parametrize("before", [0, 1, 2, 3, 10])
def test_a_restored_state_goes_on_to_the_bit(before: int, fmu: Path, tmp_path: Path) -> None:
    s = started(fmu, tmp_path)
    follow(s, 0, before)
    state = get_state(s)
    expected = follow(s, before, 5)
    for _ in range(3):
        set_state(s, state)
        assert s.set({"pos.s_ref": 7.0}) == OK  # replaced by the value that the step begins with
        assert follow(s, before, 5) == expected


@pytest.mark.parametrize("logging_on", [False, True])
def test_a_jump_is_a_warning(fmu: Path, tmp_path: Path, logging_on: bool) -> None:
    """Once in a run, at the communication point after it, whether events are logged or not."""
    s = started(fmu, tmp_path, logging_on=logging_on)
    follow(s, 0, 10)
    assert not [said for said in s.log if said[0] == WARNING]
    follow(s, 10, 5, jump=0.25)
    follow(s, 15, 5, jump=-0.25)
    [(_, category, text)] = [said for said in s.log if said[0] == WARNING]
    assert category == "logStatusWarning"
    assert text.startswith("t = 0.1 s: pos.s_ref has jumped by 0.25")
    assert "derivatives" in text


def test_the_input_reads_as_it_was_set(fmu: Path, tmp_path: Path) -> None:
    s = started(fmu, tmp_path)
    follow(s, 0, 6)
    assert s.get("pos.s_ref") == motion(0.05)
    assert s.get("x.s") == pytest.approx(motion(0.06), abs=1e-5)
