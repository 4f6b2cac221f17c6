# SPDX-License-Identifier: BSD-3-Clause
"""Springs whose end points coincide: smooth there without free length, otherwise with undefined direction."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene, with_sensors

import gelenk

MASS, STIFFNESS = 2.0, 100.0  # kg, N/m


def held(kind: str, start: dict[str, Any], **spring: float) -> Scene:
    """A mass connected to the ground by one spring between the two origins."""
    return scene(
        {"mass": body(MASS, inertia=(0.5, 0.6, 0.7))},
        {"P": joint(kind, frame("ground"), frame("mass"), start={**start, "fixed": True})},
        forces={"spring": {"type": "spring_damper", "from": "ground", "to": "mass", **spring}},
    )


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-3, 0.2])
@pytest.mark.parametrize("kind", ["planar", "free"])
def test_spring_without_free_length_is_linear_at_any_length(kind: str, offset: float) -> None:
    """The force is the stiffness times the displacement between the ends. In the past the stiffness of
    coincident ends was missing from linear models: A was 0 instead of -50 /s2.
    """
    start = {"s_x": offset} if kind == "planar" else {"r": [offset, 0, 0]}
    names = ["s_x", "s_y"] if kind == "planar" else ["r[1]", "r[2]", "r[3]"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.OperatingPointWarning)
        found = gelenk.linearize(held(kind, start, stiffness=STIFFNESS), outputs=[f"P.{n}" for n in names])
    states = list(found.names.states)
    rows = [states.index(f"P.{n}") for n in names]
    speeds = [states.index(f"P.{n.replace('s_', 'v_').replace('r', 'v')}") for n in names]
    expected = -STIFFNESS / MASS * np.eye(len(names))
    assert found.A[np.ix_(speeds, rows)] == pytest.approx(expected, abs=1e-12)


def test_motion_through_coincident_ends_is_harmonic() -> None:
    source = with_sensors(held("planar", {"s_x": 0.0, "v_x": 1.0}, stiffness=STIFFNESS), E={"type": "energy"})
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-10)
    omega = np.sqrt(STIFFNESS / MASS)
    for time in (0.1, 0.5, 2.0):
        plant.step_to(time)
        assert plant.output("P.s_x") == pytest.approx(np.sin(omega * time) / omega, abs=1e-9)  # 10 tolerances
        assert plant.output("E.total") == pytest.approx(MASS / 2, abs=1e-9)


@pytest.mark.parametrize(
    "spring", [{"stiffness": STIFFNESS, "length": 0.3}, {"stiffness": 0.0, "damping": 3.0}]
)
def test_undefined_direction_gives_a_warning(spring: dict[str, float]) -> None:
    source = held("planar", {}, **spring)
    with pytest.warns(gelenk.StartWarning, match=r"forces\.spring: its ends coincide at the start"):
        gelenk.Simulation(gelenk.load(source)).initialize()
    with (
        pytest.warns(gelenk.StartWarning),
        pytest.raises(gelenk.UsageError, match=r"the ends of forces\.spring coincide"),
    ):
        gelenk.linearize(source)


def test_springs_with_distinct_ends_give_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", gelenk.StartWarning)
        gelenk.Simulation(
            gelenk.load(held("planar", {"s_x": 1e-6}, stiffness=STIFFNESS, length=0.3))
        ).initialize()
