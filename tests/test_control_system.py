# SPDX-License-Identifier: BSD-3-Clause
"""Scenes as nonlinear systems of python-control."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

import gelenk


def test_a_simulation_of_python_control_agrees_with_ours(four_bar: gelenk.Scene) -> None:
    """Through a loop, over more than one revolution."""
    system = gelenk.control_system(four_bar, outputs=["A.phi", "D.phi", "C.phi"])
    times = np.linspace(0, 1.0, 101)
    ours = gelenk.simulate(
        four_bar.with_parameters({"solver.tolerance": 1e-11}), stop=1.0, step=0.01,
        inputs={"drive.tau": 10.0},        outputs=["A.phi", "D.phi", "C.phi"],
    )  # fmt: skip
    theirs = control.input_output_response(
        system, times, np.full((1, 101), 10.0), system.x0, solve_ivp_method="DOP853",
        solve_ivp_kwargs={"rtol": 1e-10, "atol": 1e-10},
    )  # fmt: skip
    assert ours["A.phi"][-1] > 2 * np.pi
    for name, row in zip(["A.phi", "D.phi", "C.phi"], theirs.outputs, strict=True):
        assert row == pytest.approx(
            ours[name], abs=1e-7
        )  # tolerances of 1e-10, which errors exceed by two orders


@pytest.mark.parametrize(
    ("name", "at", "u"),
    [
        ("cart_pole", {"hinge.phi": 0.3, "hinge.w": -1.0, "track.v": 0.4}, {"drive.f": 2.0}),
        ("four_bar", {"A.phi": 2.2, "A.w": 1.3}, {"drive.tau": 4.0}),
    ],
)
def test_its_linearization_is_ours(root: Path, name: str, at: dict[str, float], u: dict[str, float]) -> None:
    scene = gelenk.load(root / "scenes" / f"{name}.yaml")
    system = gelenk.control_system(scene)
    with pytest.warns(gelenk.OperatingPointWarning):
        ours = gelenk.linearize(
            scene,
            at={**at, **u},
            states=system.names.states,
            outputs=[s.name for s in gelenk.Simulation(scene).outputs],
        )
    x = [at.get(label, start) for label, start in zip(system.names.states, system.x0, strict=True)]
    theirs = system.linearize(x, list(u.values()), eps=1e-6)
    for matrix in "ABCD":  # one-sided differences of python-control
        ours_, theirs_ = getattr(ours, matrix), getattr(theirs, matrix)
        assert theirs_ == pytest.approx(ours_, abs=1e-4 * (1 + np.abs(ours_).max()))


def test_evaluations_have_no_side_effects(four_bar: gelenk.Scene) -> None:
    """To the bit, in any order, and by another system of the same scene."""
    system, other = gelenk.control_system(four_bar), gelenk.control_system(four_bar)
    rng = np.random.default_rng(2)
    points = [(rng.uniform(0, 1), rng.uniform(-8, 8, 2), rng.uniform(-5, 5, 1)) for _ in range(20)]

    def at(made: Any, t: float, x: Any, u: Any) -> bytes:
        return bytes(made.dynamics(t, x, u).tobytes() + made.output(t, x, u).tobytes())

    first = [at(system, *point) for point in points]
    assert [at(system, *point) for point in reversed(points)] == first[::-1]
    assert [at(other, *point) for point in reversed(points)] == first[::-1]


def test_states_that_cannot_be_reached_are_named(root: Path) -> None:
    """Pivots 3.2 m apart: the crank of 0.5 m cannot point away from bars of 1.75 m and 1.5 m, 3.25 m
    together.
    """
    data = gelenk.load(root / "scenes" / "four_bar.yaml").to_dict()
    data["joints"]["D"]["parent"]["position"] = [3.2, 0, 0]
    system = gelenk.control_system(data, outputs=["A.phi"])
    assert system.state_labels == ["A_phi", "A_w"]
    with pytest.raises(gelenk.UsageError, match="the mechanism cannot be moved to the given states"):
        system.dynamics(0.0, [np.pi, 0.0], [0.0])
    assert np.isfinite(system.dynamics(0.0, [1.2, 1.0], [0.0])).all()
    assert np.isfinite(system.dynamics(0.0, system.x0, [0.0])).all()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"friction": {"coulomb": 0.3}}, "the scene has friction or limits"),
        ({"limit": {"lower": -2.0}}, "the scene has friction or limits"),
    ],
)
def test_what_has_events_is_refused(root: Path, change: dict[str, Any], sentence: str) -> None:
    data = gelenk.load(root / "scenes" / "cart_pole.yaml").to_dict()
    data["joints"]["track"] |= change
    with pytest.raises(gelenk.UsageError, match=sentence):
        gelenk.control_system(data)


def test_wrong_names_are_reported(four_bar: gelenk.Scene) -> None:
    with pytest.raises(gelenk.UsageError, match=r"nothing\.x: no such output"):
        gelenk.control_system(four_bar, outputs=["nothing.x"])
    with pytest.raises(gelenk.UsageError, match=r"nothing\.x: no such input"):
        gelenk.control_system(four_bar, inputs=["nothing.x"])
