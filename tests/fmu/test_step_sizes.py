# SPDX-License-Identifier: BSD-3-Clause
"""Ten steps of 1 ms and one of 10 ms: the master's choice is no part of the physics."""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest

import gelenk

from .host import OK, Fmu, Slave

SCENES = ("four_bar", "slider_crank", "double_pendulum", "heavy_top", "cart_pole")
FIXED = ("rk4", "euler", "generalized-alpha")
VARIABLE = ("auto", "erk", "ida", "cvode", "dirk")
FINE, COARSE = 1e-3, 1e-2  # s


def exported(scene: str, solver: dict[str, object], root: Path, folder: Path) -> Fmu:
    source = gelenk.load(root / "scenes" / f"{scene}.yaml").to_dict()
    source["solver"] = {**source.get("solver", {}), **solver}
    fmu = gelenk.export_fmu(source, folder / "x.fmu")
    return Fmu(fmpy.extract(str(fmu), str(folder / "x")))


def started(fmu: Fmu, start: float, tolerance: float | None = None) -> Slave:
    """Pushed by each of its inputs."""
    s = Slave(fmu)
    assert s.setup(start, tolerance=tolerance) == OK
    assert s.enter() == OK
    inputs = {v.name: 0.3 for v in fmu.description.modelVariables if v.causality == "input"}
    if inputs:
        assert s.set(inputs) == OK
    assert s.leave() == OK, s.said
    return s


def both(
    fmu: Fmu, steps: int, start: float = 0.0, tolerance: float | None = None
) -> tuple[list[list[float]], ...]:
    """Outputs every 10 ms, of a master with fine steps and of one with coarse steps."""
    fine, coarse = started(fmu, start, tolerance), started(fmu, start, tolerance)
    rows: tuple[list[list[float]], ...] = ([], [])
    for k in range(steps):
        for j in range(10):
            assert fine.step(start + (10 * k + j) * FINE, FINE) == OK, fine.said
        assert coarse.step(start + k * COARSE, COARSE) == OK, coarse.said
        rows[0].append(fine.outputs())
        rows[1].append(coarse.outputs())
    fine.free()
    coarse.free()
    return rows


@pytest.mark.parametrize("integrator", FIXED)
@pytest.mark.parametrize("scene", SCENES)
def test_steps_on_one_grid_give_the_same_bits(
    integrator: str, scene: str, root: Path, tmp_path: Path
) -> None:
    fmu = exported(scene, {"integrator": integrator, "step": FINE}, root, tmp_path)
    fine, coarse = both(fmu, 50)
    assert fine == coarse
    assert fine[0] != fine[-1]
    # After a day, when times are rounded to 1e-11 s.
    fine, coarse = both(fmu, 20, 86400.0)
    assert fine == coarse


@pytest.mark.parametrize("formulation", ["baumgarte", "augmented-lagrangian", "penalty", "independent"])
def test_so_do_rival_formulations(formulation: str, root: Path, tmp_path: Path) -> None:
    solver = {"integrator": "rk4", "step": FINE, "formulation": formulation}
    fine, coarse = both(exported("four_bar", solver, root, tmp_path), 30)
    assert fine == coarse


@pytest.mark.parametrize("integrator", VARIABLE)
@pytest.mark.parametrize("scene", SCENES)
def test_other_steps_agree_within_the_tolerance(
    integrator: str, scene: str, root: Path, tmp_path: Path
) -> None:
    tolerance = 1e-6
    fmu = exported(scene, {"integrator": integrator}, root, tmp_path)
    fine, coarse = both(fmu, 50, tolerance=tolerance)
    assert fine != coarse  # other steps are made
    # The tolerance bounds the error of one step, and one-step methods with steps as long as these stay below
    # it. What hundreds of smaller steps of other methods add up to was up to 4.4 of it.
    bound = tolerance * (1 if integrator in ("auto", "erk") else 10)
    for i in range(len(fine[0])):
        scale = max(1.0, *(abs(row[i]) for row in fine))
        assert max(abs(a[i] - b[i]) for a, b in zip(fine, coarse, strict=True)) <= bound * scale
