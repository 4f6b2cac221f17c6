# SPDX-License-Identifier: BSD-3-Clause
"""Runs that differ in masses and loads begin with the simulation of another run: the same bits and words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files
from mechanisms import body, four_bar, frame, joint, scene
from samples import sampled

import gelenk
from gelenk import _core
from gelenk.sweeps.design import designed
from gelenk.sweeps.plan import Plan
from gelenk.sweeps.planning import Request

SCENES = scene_files.gallery()
RUNS = 4


def planned(source: Any, columns: dict[str, list[float]], stop: float, step: float) -> tuple[Plan, Any]:
    request = Request(None, stop, step, None, {"integrator": None, "formulation": None}, (), None, 0.0)
    plan, values, _, _ = request.planned(gelenk.load(source), designed(columns, "list", None, 0))
    return plan, values


def made(plan: Plan, values: Any) -> tuple[np.ndarray, list[_core.RunReport]]:
    rows = np.full((len(values[0]), len(plan.signals), len(plan.times)), np.nan)
    return rows, list(plan.runner.run(*values, rows, 0.0))  # type: ignore[arg-type, call-arg]


def check_runs(
    source: Any, columns: dict[str, list[float]], stop: float = 0.05, step: float = 0.005
) -> list[bool]:
    """Compare runs with those of simulations of their own; return which began with that of another one."""
    plan, values = planned(source, columns, stop, step)
    rows, reports = made(plan, values)
    for i, report in enumerate(reports):
        alone = tuple(part[i : i + 1] for part in values)
        expected, (own,) = made(planned(source, columns, stop, step)[0], alone)
        assert not own.is_repeated
        assert rows[i].tobytes() == expected[0].tobytes(), f"run {i}"
        assert (report.error, report.warnings, report.events, report.steps) == (
            own.error, own.warnings, own.events, own.steps,
        )  # fmt: skip
    return [report.is_repeated for report in reports]


def varied(source: dict[str, Any], seed: int) -> dict[str, list[float]]:
    """All numbers that leave positions as they are, within a tenth; moments of a body together."""
    random = np.random.default_rng(seed)
    held = gelenk.load(source)._core
    of_moments: dict[str, Any] = {}
    out = {}
    for number in _core.list_parameters(held):
        value = number.value(held)
        if not number.keeps_positions or not np.isfinite(value) or value == 0:
            continue
        factors = 1 + 0.1 * random.random(RUNS)
        if ".inertia[" in number.name:
            factors = of_moments.setdefault(number.name.split(".")[0], factors)
        out[number.name] = (value * factors).tolist()
    return out


@pytest.mark.parametrize("name", sampled(SCENES, ["four_bar", "stewart", "cart_pole"]))
def test_all_masses_and_loads_of_the_gallery(name: str) -> None:
    source = gelenk.load(SCENES[name]).to_dict() | {"parameters": "all"}
    columns = varied(source, 1)
    step = min(0.005, gelenk.load(source).to_dict()["experiment"]["step"])
    check_runs(source, columns, 10 * step, step)


@pytest.mark.parametrize("name", ["four_bar", "stewart", "slider_crank", "double_pendulum"])
def test_the_simulation_of_the_first_run_is_used_again(name: str, root: Path) -> None:
    source = gelenk.load(root / f"scenes/{name}.yaml").to_dict() | {"parameters": "all"}
    repeated = check_runs(source, varied(source, 2))
    assert repeated == [False, True, True, True]


def falling() -> dict[str, Any]:
    """A four-bar with friction that falls onto a limit."""
    source = four_bar() | {"parameters": "all", "motors": {"drive": {"joint": "A"}}}
    source["joints"]["A"]["limit"] = {"lower": 0.9, "restitution": 0.5}
    source["joints"]["D"]["friction"] = {"coulomb": 0.02}
    return source


@pytest.mark.parametrize(
    "integrator", ["auto", "rk4", "cvode", "ida", "dirk", "generalized-alpha", "moreau-jean"]
)
def test_every_method_begins_as_in_a_new_simulation(integrator: str) -> None:
    source = falling() | {"solver": {"integrator": integrator}}
    repeated = check_runs(source, varied(source, 3), 0.4, 0.002)
    assert repeated[0] is False
    assert all(repeated[1:]) == (integrator != "moreau-jean")


def test_inputs_are_set_anew() -> None:
    source = falling()
    repeated = check_runs(source, {"drive.tau": [0.0, 5.0, -3.0, 0.0]})
    assert repeated == [False, True, True, True]


def test_positions_that_vary_take_new_simulations() -> None:
    source = falling()
    assert not any(check_runs(source, {"A.phi_start": [1.2, 1.3], "crank.m": [1.0, 1.1]}))


def test_wrong_values_are_refused_in_the_same_words() -> None:
    """Between runs that are not."""
    source = falling()
    masses = [1.0, 1.1, -1.0, 0.0, 1.1, 1.2]
    dampings = [0.1, 0.1, 0.1, 0.1, -0.1, 0.2]
    repeated = check_runs(source, {"crank.m": masses, "A.damping": dampings})
    assert repeated == [False, True, False, repeated[3], False, True]


def test_impossible_moments_are_refused_in_the_same_words() -> None:
    source = four_bar() | {"parameters": "all"}
    moments = {"crank.inertia[1]": [0.0, 0.0, 9.0, 0.0], "crank.inertia[2]": [0.02, 0.021, 0.02, 0.02]}
    check_runs(source, moments)


def swing(mass: float) -> dict[str, Any]:
    """A pendulum, and what hangs on it."""
    bodies = {"rod": body(1.0, (0.5, 0, 0), (0, 0.1, 0.1)), "tip": body(mass, (0.2, 0, 0), (0, 0.01, 0.01))}
    joints = {
        "A": joint("revolute", frame("ground"), frame("rod"), axis=(0.0, 1.0, 0.0), start={"phi": 0.3}),
        "B": joint("revolute", frame("rod", (1, 0, 0)), frame("tip"), axis=(0.0, 1.0, 0.0)),
    }
    return scene(bodies, joints, name="Swing") | {"parameters": "all"}


def test_a_body_that_loses_its_mass_takes_a_new_simulation() -> None:
    source = swing(0.3)
    repeated = check_runs(source, {"tip.m": [0.3, 0.4, 0.0, 0.5], "tip.inertia[2]": [0.01, 0.01, 0.0, 0.01],
                                   "tip.inertia[3]": [0.01, 0.01, 0.0, 0.01]})  # fmt: skip
    assert repeated == [False, True, False, True]


def test_masses_that_need_other_units_take_a_new_simulation() -> None:
    """Beyond 1024 kg, masses are no longer measured in kilograms (scene/unit_system.cpp)."""
    source = swing(0.3)
    assert check_runs(source, {"rod.m": [1.0, 1.1, 5000.0, 1.2, 1.3]}) == [False, True, False, False, True]


def test_a_spring_that_appears_takes_a_new_simulation() -> None:
    source = swing(0.3)
    source["joints"]["A"]["damping"] = 0.0
    assert check_runs(source, {"A.damping": [0.0, 0.0, 0.1, 0.2]}) == [False, True, False, True]


def test_bounds_that_vary_take_new_simulations() -> None:
    """The pendulum starts at 0.3 rad: one of them is passed."""
    source = swing(0.3)
    source["joints"]["A"]["limit"] = {"upper": 0.5}
    assert not any(check_runs(source, {"A.limit.upper": [0.5, 0.4, 0.2, 0.6]}))
