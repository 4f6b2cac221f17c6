# SPDX-License-Identifier: BSD-3-Clause
"""Parts whose prescribed motions leave no degree of freedom are not integrated; outputs are the same."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.chart import mechanisms

ROOT = Path(__file__).parents[3]
CRANK, ROD = 0.3, 0.8  # m


def slider_crank(motion: dict[str, Any], rod: float = ROD, **solver: Any) -> dict[str, Any]:
    """Return a slider-crank whose crank angle is prescribed, without friction."""
    bodies = {"crank": mechanisms.rod(CRANK), "rod": mechanisms.rod(rod), "slider": mechanisms.body(1.5)}
    joints = {
        "A": mechanisms.hinge("ground", "crank", start={"phi": 0.2}),
        "B": mechanisms.hinge(
            mechanisms.at("crank", CRANK), "rod", start={"phi": -0.2 - math.asin(CRANK * math.sin(0.2) / rod)}
        ),
        "C": mechanisms.hinge(mechanisms.at("rod", rod), "slider"),
        "P": mechanisms.slide("ground", "slider", start={"s": CRANK + rod}),
    }
    joints["P"]["axis"] = [1, 0, 0]
    constraints = {"m": {"type": "motion", "joint": "A", **motion}}
    return mechanisms.scene(bodies, joints, constraints=constraints, solver=solver)


def position(phi: float, rod: float = ROD) -> float:
    """Return the position of the slider [m] at a crank angle [rad]."""
    return CRANK * math.cos(phi) + math.sqrt(rod**2 - (CRANK * math.sin(phi)) ** 2)


SWING = "0.2 + 3 * sin(5 * t)"


@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2, 0.1, 1.0])
def test_a_slider_crank_is_where_its_crank_puts_it(step: float) -> None:
    """Positions in closed form, whatever the communication step."""
    plant = gelenk.Simulation(slider_crank({"law": SWING}))
    plant.initialize(0.0, 1e-6)
    for k in range(1, 21):
        t = k * step
        plant.step_to(t)
        phi = 0.2 + 3 * math.sin(5 * t)
        assert plant.output("A.phi") == pytest.approx(phi, abs=1e-12)
        assert plant.output("P.s") == pytest.approx(position(phi), abs=1e-12)
        rate = (position(phi + 1e-6) - position(phi - 1e-6)) / 2e-6 * 15 * math.cos(5 * t)
        assert plant.output("P.v") == pytest.approx(rate, abs=1e-7)


def test_a_step_takes_two_evaluations() -> None:
    counts = []
    for on in (True, False):
        plant = gelenk.Simulation(slider_crank({"law": SWING}, reductions={"kinematic": on}))
        plant.initialize(0.0, 1e-6)
        begun = plant.diagnostics["solver.evaluations"]
        for k in range(1, 201):
            plant.step_to(k * 1e-3)
        counts.append((plant.diagnostics["solver.evaluations"] - begun) / 200)
    assert counts[0] <= 2
    assert counts[1] > 2 * counts[0]
    assert "not integrated" in str(gelenk.inspect(slider_crank({"law": SWING})))


def agree(scene: dict[str, Any], stop: float, bound: float) -> None:
    """Compare all outputs with those of the integrated scene at 1e-10."""
    runs = []
    for on in (True, False):
        plant = gelenk.Simulation({**scene, "solver": {"reductions": {"kinematic": on}}})
        plant.initialize(0.0, 1e-10)
        rows = []
        for k in range(1, 51):
            plant.step_to(k * stop / 50)
            rows.append(plant.values([one.name for one in plant.outputs]))
        runs.append(np.array(rows))
    scale = np.maximum(1, np.abs(runs[1]).max(axis=0))
    assert np.all(np.abs(runs[0] - runs[1]) <= bound * scale)


@pytest.mark.parametrize("name", ["delta_robot", "excavator", "jansen_leg", "windscreen_wiper", "gear_shift"])
def test_scenes_of_the_gallery(name: str) -> None:
    (path,) = (ROOT / "docs" / "gallery" / name).glob("*.yaml")
    source = gelenk.load(path).to_dict()
    agree({k: v for k, v in source.items() if k != "solver"}, source.get("stop", 1.0), 1e-7)


def test_restored_runs_have_the_same_bits() -> None:
    runs = []
    for restores in (False, True):
        plant = gelenk.Simulation(slider_crank({"law": SWING}))
        plant.initialize(0.0, 1e-6)
        found = []
        for k in range(1, 31):
            if restores:
                state = plant.save()
                plant.step_to(k * 0.07 + 0.3)
                plant.restore(state)
            plant.step_to(k * 0.07)
            found.append(plant.values([one.name for one in plant.outputs]).tolist())
        runs.append(found)
    assert runs[0] == runs[1]


def test_where_the_loop_cannot_follow_the_general_method_says_so() -> None:
    """At 1 rad the rod is perpendicular to the rail: the crank, which is longer, cannot continue."""
    messages = []
    for on in (True, False):
        scene = slider_crank({"law": "0.2 + t"}, rod=CRANK * math.sin(1.0), reductions={"kinematic": on})
        plant = gelenk.Simulation(scene)
        plant.initialize(0.0, 1e-6)
        plant.step_to(0.7)
        with pytest.raises(gelenk.GelenkError) as caught:
            plant.step_to(1.0)
        messages.append(str(caught.value).split(":", 1)[1].split("t =")[0])
        assert plant.time == 0.7
    assert messages[0] == messages[1]


def test_what_keeps_a_freedom_or_may_stick_is_integrated() -> None:
    free = slider_crank({"law": SWING})
    del free["constraints"]
    rubbing = slider_crank({"law": SWING})
    rubbing["joints"]["P"]["friction"] = {"coulomb": 1.0}
    asked = slider_crank({"law": SWING}, integrator="erk")
    for scene in (free, rubbing, asked):
        assert "not integrated" not in str(gelenk.inspect(copy.deepcopy(scene)))
