# SPDX-License-Identifier: BSD-3-Clause
"""Motions whose time derivatives are inputs, too: `up_to: speed` and `up_to: acceleration`.

A mass on a spring and a damper whose other end is driven: m y'' = -k y - c y' - m x''.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
import warned
from models.driven_mass import (
    DAMPING,
    END,
    MASS,
    STIFFNESS,
    TOLERANCE,
    driven_mass,
    equal_steps,
    place_of_mass,
    swing,
    swing_rate,
    unequal_steps,
)

import gelenk

type Steps = Callable[[float], list[float]]


def swing_acceleration(t: float) -> float:
    return -16.0 * swing(t)


COURSES = {"pos.s_ref": swing, "pos.v_ref": swing_rate, "pos.a_ref": swing_acceleration}
NAMES = {"speed": ("pos.s_ref", "pos.v_ref"), "acceleration": tuple(COURSES)}


def driven(plant: gelenk.Simulation, names: tuple[str, ...], times: list[float]) -> float:
    """Drive by the values of these inputs alone; return the final place of the mass [m]."""
    for name in names:
        plant.set_input(name, COURSES[name](times[0]))
    plant.initialize(times[0], TOLERANCE)
    for t, later in itertools.pairwise(times):
        for name in names:
            plant.set_input(name, COURSES[name](t))
        plant.step_to(later)
    return plant.output("x.s") + plant.output("y.s")


@warned.TIGHT
@pytest.mark.parametrize("steps", [equal_steps, unequal_steps])
@pytest.mark.parametrize(("up_to", "ratio"), [("speed", 60), ("acceleration", 300)])
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "ida", "rk4"])
def test_error_falls_with_the_step(integrator: str, up_to: str, ratio: float, steps: Steps) -> None:
    """In third order, but for the acceleration at the start, which speeds alone do not tell."""
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (5e-2, 5e-3):
        plant = gelenk.Simulation(driven_mass(integrator, up_to=up_to))
        errors.append(abs(driven(plant, NAMES[up_to], steps(h)) - truth))
    assert errors[0] < 1e-2
    assert errors[0] / errors[1] > ratio, errors


def test_prescribed_speed_with_its_acceleration() -> None:
    source = driven_mass(input="speed", up_to="acceleration")
    source["joints"]["x"]["start"] = {"s": swing(0.0)}
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (5e-2, 5e-3):
        plant = gelenk.Simulation(source)
        assert [signal.name for signal in plant.inputs] == ["pos.v_ref", "pos.a_ref"]
        errors.append(abs(driven(plant, ("pos.v_ref", "pos.a_ref"), equal_steps(h)) - truth))
    assert errors[0] / errors[1] > 300, errors


def test_linear_model_has_a_column_for_each_derivative() -> None:
    """The position alone would have none of velocity and acceleration: its model lacks s and s^2."""
    model = gelenk.linearize(gelenk.load(driven_mass(up_to="acceleration")))
    assert model.input_labels == ["pos_s_ref", "pos_v_ref", "pos_a_ref"]
    np.testing.assert_allclose(
        model.A, np.array([[0.0, 1], [-STIFFNESS / MASS, -DAMPING / MASS]]), atol=1e-13
    )
    np.testing.assert_allclose(model.B, [[0, 0, 0], [0, 0, -1]], atol=1e-13)
    force = model.D[model.output_labels.index("pos_f")]
    np.testing.assert_allclose(
        force, [0, 0, 1], atol=1e-13, err_msg="the end has 1 kg; spring and damper are states"
    )


def test_a_position_without_its_derivatives_is_reported_once() -> None:
    """A master that knows nothing of the inputs v_ref and a_ref sends a motion in jumps."""
    plant = gelenk.Simulation(driven_mass(up_to="acceleration"))
    plant.initialize(0.0, 1e-8)
    found = []
    for k in range(6):
        plant.set_input("pos.s_ref", 0.1 * k)
        if k == 3:  # a saved state knows that it has been reported
            plant.restore(plant.save())
        plant.step_to(0.1 * (k + 1))
        found.append([words for _, words in plant.events])
    assert [len(words) for words in found] == [0, 1, 0, 0, 0, 0]
    assert "pos.s_ref has jumped by 0.1 m" in found[1][0]
    quiet = gelenk.Simulation(driven_mass(up_to="acceleration"))
    driven(quiet, NAMES["acceleration"], equal_steps(5e-2))
    assert not quiet.events


def test_an_unknown_derivative_is_refused() -> None:
    with pytest.raises(gelenk.errors.SceneError, match="expected one of speed, acceleration") as caught:
        gelenk.Simulation(driven_mass(up_to="jerk"))
    assert "constraints.pos.up_to" in str(caught.value)


def test_a_speed_up_to_the_speed_has_no_derivatives() -> None:
    plant = gelenk.Simulation(driven_mass(input="speed", up_to="speed"))
    assert [signal.name for signal in plant.inputs] == ["pos.v_ref"]


def test_fmu_has_the_variables(tmp_path: Path) -> None:
    """The master fmpy sends values alone, as libcosim does."""
    path = gelenk.export_fmu(gelenk.load(driven_mass(up_to="acceleration")), tmp_path / "driven.fmu")
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (5e-2, 5e-3):
        times = np.arange(0, END + h / 2, h)
        columns = [(name, np.float64) for name in COURSES]
        values = np.array(
            [(t, *(f(t) for f in COURSES.values())) for t in times], [("time", float), *columns]
        )
        found = fmpy.simulate_fmu(
            str(path),
            stop_time=END,
            step_size=h,
            output_interval=h,
            input=values,
            start_values={name: f(0.0) for name, f in COURSES.items()},
            output=["x.s", "y.s"],
            relative_tolerance=1e-10,
        )
        errors.append(abs(found["x.s"][-1] + found["y.s"][-1] - truth))
    assert errors[0] / errors[1] > 300, errors


def slide(up_to: str) -> gelenk.Simulation:
    """A mass of 1 kg whose position is prescribed."""
    plant = gelenk.Simulation(
        {
            "gelenk": 1,
            "bodies": {"mass": {"mass": 1}},
            "joints": {"P": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "mass"}},
            "constraints": {"pos": {"type": "motion", "joint": "P", "input": "position", "up_to": up_to}},
        }
    )
    plant.initialize(0.0, 1e-9)
    return plant


@pytest.mark.parametrize("order", ["values first", "derivative first"])
def test_derivatives_may_be_set_before_and_after_values(order: str) -> None:
    """FMI prescribes no order."""
    plant = slide("speed")
    plant.step_to(0.1)
    steps = [lambda: plant.set_input("pos.s_ref", 0.0), lambda: plant.set_input("pos.v_ref", 0.0)]
    derivative = [lambda: plant.set_input_derivative("pos.v_ref", 1, 6.0)]
    for act in steps + derivative if order == "values first" else derivative + steps:
        act()
    plant.step_to(0.2)
    found = [plant.output(name) for name in ("P.s", "P.v", "pos.f")]
    assert found == pytest.approx([0.03, 0.6, 6.0], abs=1e-12)


@pytest.mark.parametrize("sent", ["all values and first derivatives", "the position and its derivatives"])
def test_what_masters_send_is_a_cubic(sent: str) -> None:
    """Some send first derivatives of all inputs; others know nothing of the inputs v_ref and a_ref."""
    plant = slide("acceleration")
    for k in range(4):
        t = 0.1 * k
        orders = (t**3, 3 * t * t, 6 * t, 6.0)
        if sent.startswith("all"):
            for i, name in enumerate(COURSES):
                plant.set_input(name, orders[i])
                plant.set_input_derivative(name, 1, orders[i + 1])
        else:
            plant.set_input("pos.s_ref", orders[0])
            for order in (1, 2, 3):
                plant.set_input_derivative("pos.s_ref", order, orders[order])
        plant.step_to(t + 0.1)
        assert plant.output("P.s") == pytest.approx((t + 0.1) ** 3, abs=1e-14)
        assert plant.output("pos.f") == pytest.approx(6 * (t + 0.1), abs=1e-12)
