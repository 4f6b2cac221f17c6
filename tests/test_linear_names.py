# SPDX-License-Identifier: BSD-3-Clause
"""Names of linear models: labels of python-control and names with dots, which are those of scene and FMU."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk.linear import linear_model

UPRIGHT = {"hinge.phi": 0.0}


def test_states_inputs_and_outputs_are_named_alike(root: Path) -> None:
    """With `_` for `.` in python-control, which allows no dots in inputs and outputs; the FMU has dots."""
    source = root / "scenes" / "cart_pole.yaml"
    point = gelenk.OperatingPoint(source, at=UPRIGHT)
    for found in (gelenk.linearize(point), gelenk.control_system(source)):
        for key in ("state", "input", "output"):
            labels, names = getattr(found, f"{key}_labels"), getattr(found.names, f"{key}s")
            assert labels == [name.replace(".", "_") for name in names]
            assert all("." in name for name in names)
        assert found.names.states == linear_model(point).states


def test_labels_of_python_control_are_accepted_as_names(root: Path) -> None:
    arm, states = root / "scenes" / "five_bar.yaml", ["right_phi", "left_phi", "right_w", "left_w"]
    labels: dict[str, Any] = {"inputs": ["motor_right_tau"], "outputs": ["left_phi", "right_phi"]}
    names: dict[str, Any] = {"inputs": ["motor_right.tau"], "outputs": ["left.phi", "right.phi"]}
    found = linear_model(arm, states=states, **labels)
    assert found.states == ("right.phi", "left.phi", "right.w", "left.w")
    same = linear_model(arm, states=found.states, **names)
    for matrix in "ABCD":
        assert np.array_equal(getattr(found, matrix), getattr(same, matrix))
    assert gelenk.control_system(arm, **labels).names == gelenk.control_system(arm, **names).names
    ball = scene(
        {"b": body(1.0, inertia=(0.1, 0.2, 0.25))}, {"S": joint("spherical", frame("ground"), frame("b"))}
    )
    turned = gelenk.linearize(ball)
    assert turned.state_labels[0] == "S_theta[1]"
    assert gelenk.linearize(ball, states=turned.state_labels).names == turned.names


def test_modes_of_a_state_space_have_its_names_with_dots(root: Path) -> None:
    model = gelenk.linearize(root / "scenes" / "cart_pole.yaml", at=UPRIGHT)
    assert [*gelenk.modes(model).modes[0].shape] == ["track.s", "hinge.phi", "track.v", "hinge.w"]
    model.set_states(["a", "b", "c", "d"])
    assert [*gelenk.modes(model).modes[0].shape] == ["a", "b", "c", "d"]
