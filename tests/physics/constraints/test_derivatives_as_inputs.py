# SPDX-License-Identifier: BSD-3-Clause
"""Prescribed motions whose derivatives are inputs of their own."""

from __future__ import annotations

import numpy as np
import pytest
from models.driven_mass import END, TOLERANCE, driven_mass, place_of_mass, swing, swing_rate

import gelenk


@pytest.mark.parametrize("kind", ["position", "speed"])
def test_derivatives_as_variables_are_those_that_are_set(kind: str) -> None:
    """Speed and acceleration as inputs of their own give the bits of the same derivatives of the input."""
    first = 0 if kind == "position" else 1
    law = [swing, swing_rate, lambda t: -16.0 * swing(t)][first:]
    names = ["pos.s_ref", "pos.v_ref", "pos.a_ref"][first:]
    rows = []
    for as_variables in (False, True):
        extra = {"derivatives": "acceleration"} if as_variables else {}
        source = driven_mass("erk", input=kind, **extra)
        plant = gelenk.Simulation(gelenk.load(source))
        assert [s.name for s in plant.inputs] == (names if as_variables else names[:1])
        found = []
        for k in range(20):
            for order, d in enumerate(law):
                if as_variables or order == 0:
                    plant.set_input(names[order], d(0.01 * k))
                else:
                    plant.set_input_derivative(names[0], order, d(0.01 * k))
            if k == 0:
                plant.initialize(0.0, TOLERANCE)
                found.append(plant.values().tolist())
            plant.step_to(0.01 * (k + 1))
            found.append(plant.values().tolist())
        rows.append(found)
    assert rows[0] == rows[1]


def test_the_acceleration_of_a_position_is_estimated_from_its_speeds() -> None:
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (1e-2, 1e-3):
        plant = gelenk.Simulation(gelenk.load(driven_mass("erk", derivatives="speed")))
        for k in range(round(END / h)):
            plant.set_input("pos.s_ref", swing(k * h))
            plant.set_input("pos.v_ref", swing_rate(k * h))
            if k == 0:
                plant.initialize(0.0, TOLERANCE)
            plant.step_to((k + 1) * h)
        errors.append(abs(plant.output("x.s") + plant.output("y.s") - truth))
    assert errors[0] / errors[1] > 50, errors


def test_derivatives_as_variables_need_an_input_that_has_them() -> None:
    for motion, expected in (
        ({"input": "speed", "derivatives": "speed"}, "expected acceleration, with input: speed"),
        ({"polynomial": [0.0, 1.0], "derivatives": "speed"}, "pos"),
    ):
        source = driven_mass("erk")
        source["constraints"]["pos"] = {"type": "motion", "joint": "x"} | motion
        with pytest.raises(gelenk.SceneError, match=expected):
            gelenk.Simulation(gelenk.load(source))


def test_linear_model_has_columns_for_speed_and_acceleration() -> None:
    """By m (x'' + y'') = -k y - d y', y'' depends on x'' by -1, and on x and x' not at all."""
    model = gelenk.linearize(driven_mass("erk", derivatives="acceleration"), states=["y.s", "y.v"])
    assert list(model.input_labels) == ["pos_s_ref", "pos_v_ref", "pos_a_ref"]
    assert np.asarray(model.B) == pytest.approx(np.array([[0, 0, 0], [0, 0, -1]]), abs=1e-14)
    row = list(model.output_labels).index("pos_f")
    force = np.asarray(model.D)[row]
    assert force == pytest.approx([0, 0, 1.0], abs=1e-13)  # the load is free: only the end is accelerated
