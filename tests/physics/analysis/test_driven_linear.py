# SPDX-License-Identifier: BSD-3-Clause
"""Linear models and time derivatives of plants with prescribed motions and gears, against finite differences.

The linear model of the FMU is compared with that of the scene.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmu.plants import cranked, driven
from mechanisms import Scene
from models.differences import CENTRAL, FIRST, SECOND, Array, Linear, linearized, output_derivatives
from models.driven import Law, Slave, polynomial, sine
from models.hybrid import Chain
from models.running import assert_close

import gelenk
from physics.constraints.test_gears import planetary, three_shafts

# Coefficients of the crank angle, 0.7 rad + 1.3 rad/s t + ...; each plant uses the laws of the inputs it has.
CRANK = [0.7, 1.3, -0.8, 0.5, 0.2]
LAWS: dict[str, Law] = {
    "crank.phi_ref": polynomial(CRANK),
    "crank.w_ref": polynomial(CRANK, 1),
    "drive.tau": sine(0.4, 1.0, 0.3),
    "at_sun.tau": sine(0.2, 1.0, 0.5),
    "at_arm.tau": sine(0.1, 0.7, 0.1),
    "left.tau": sine(0.3, 0.5, 0.2),
}


def shaken_chain() -> Scene:
    """A chain whose cylindrical joint slides along a spline; its rotation and the hinge are free."""
    table = {"time": [0.0, 0.3, 0.5, 0.9, 1.2], "value": [0.0, 0.1, 0.06, 0.12, 0.02]}
    chain = Chain("cylindrical", "s")
    return chain.scene({"table": table}, {"phi": 0.3, "w": 0.5, "fixed": True})


# Plant, states, time.
PLANTS: list[tuple[Callable[[], Scene], int, float]] = [
    (driven, 4, 0.0),
    (driven, 4, 0.37),
    (cranked, 3, 0.0),
    (cranked, 3, 0.37),
    (planetary, 4, 0.25),
    (shaken_chain, 4, 0.42),
    (lambda: three_shafts(-1 / 3), 2, 0.3),
]
IDS = ["driven", "driven later", "cranked", "cranked later", "planetary", "spline", "ring of gears"]


def set_inputs(plant: gelenk.Simulation, t: float, offsets: Mapping[str, float] | None = None) -> None:
    """Set the inputs and their derivatives to their laws at t, with these offsets of the values."""
    for signal in plant.inputs:
        value, *derivatives = LAWS[signal.name](t) if signal.name in LAWS else [0.0]
        plant.set_input(signal.name, value + (offsets or {}).get(signal.name, 0.0))
        for order, d in enumerate(derivatives, 1):
            plant.set_input_derivative(signal.name, order, d)


def run_to(source: Scene, t: float) -> gelenk.Simulation:
    """Run to time t in steps over which the Taylor polynomials of the inputs are exact to rounding."""
    plant = gelenk.Simulation(gelenk.load(source))
    set_inputs(plant, 0.0)
    plant.initialize(0.0, 1e-11)
    steps = round(100 * t)
    for k in range(steps):
        set_inputs(plant, k * t / steps)
        plant.step_to((k + 1) * t / steps)
    set_inputs(plant, t)
    return plant


def displaced_outputs(source: Scene, plant: gelenk.Simulation, offsets: Mapping[str, float]) -> Array:
    """Outputs of a second plant, assembled at the state of `plant` with offsets of some states and inputs."""
    states = [*plant.independent_coordinates, *plant.independent_speeds]
    scene = copy.deepcopy(source)
    for name, entry in scene["joints"].items():
        start: dict[str, Any] = {}
        fixed = []
        for signal in plant.outputs:
            owner, _, quantity = signal.name.partition(".")
            if owner == name and signal.level in (0, 1):
                start[quantity] = plant.output(signal.name) + offsets.get(signal.name, 0.0)
                if signal.name in states:
                    fixed.append(quantity)
        entry["start"] = {**start, **({"fixed": fixed} if fixed else {})}
    other = gelenk.Simulation(gelenk.load(scene))
    set_inputs(other, plant.time, offsets)
    other.initialize(plant.time)
    set_inputs(other, plant.time, offsets)
    return other.values()


@pytest.mark.parametrize(("plant", "order", "time"), PLANTS, ids=IDS)
def test_linear_model_has_the_expected_states_and_matches_finite_differences(
    plant: Callable[[], Scene], order: int, time: float
) -> None:
    """Derivatives of a position input are held constant: B and D are derivatives by its value only."""
    source = plant()
    here = run_to(source, time)
    found: Linear = linearized(here)
    assert len(found.states) == order
    names = [s.name for s in here.outputs]
    h = 1e-3  # fourth order: the error is h^4 times the fifth derivative
    columns = dict(zip(found.states, found.C.T, strict=True))
    columns |= dict(zip((s.name for s in here.inputs), found.D.T, strict=True))
    for name, derivatives in columns.items():
        expected = (
            sum((w * displaced_outputs(source, here, {name: k * h}) for k, w in CENTRAL.items()), np.zeros(1))
            / h
        )
        bound = 1e-7 * (1 + np.abs(expected).max())
        for output, derivative, wanted in zip(names, derivatives, expected, strict=True):
            assert_close(f"{output} by {name}", derivative, wanted, bound, "differences")


@pytest.mark.parametrize(("plant", "order", "time"), PLANTS, ids=IDS)
def test_state_equations_repeat_the_output_rows_of_the_state_derivatives(
    plant: Callable[[], Scene], order: int, time: float
) -> None:
    """A and B repeat rows of C and D: the row of w for the state phi, the row of a for the state w."""
    here = run_to(plant(), time)
    found = linearized(here)
    names = [s.name for s in here.outputs]
    rate = {"phi": "w", "w": "a", "s": "v", "v": "a"}
    for i, state in enumerate(found.states):
        joint, quantity = state.split(".")
        other = f"{joint}.{rate[quantity]}"
        if f"{joint}.{quantity}d" in names:  # of a joint with several velocities
            other = f"{joint}.{quantity}d"
        row = names.index(other)
        assert found.xdot[i] == pytest.approx(here.output(other), abs=1e-10)
        assert_close(
            state, found.A[i], found.C[row], 1e-9 * (1 + np.abs(found.C[row]).max()), "the same rows"
        )
        bound = 1e-9 * (1 + np.abs(found.D[row]).max(initial=0))
        if here.inputs:
            assert_close(state, found.B[i], found.D[row], bound, "the same rows")
    assert order == len(found.states)


@pytest.mark.parametrize(
    ("plant", "time"), [(driven, 0.37), (cranked, 0.37), (planetary, 0.25), (shaken_chain, 0.42)]
)
def test_time_derivatives_match_finite_differences_of_runs(plant: Callable[[], Scene], time: float) -> None:
    """Finite differences of eighth order of a run through that time; inputs are set with two derivatives."""
    source = plant()
    h = 2e-3
    offsets = range(-4, 5)
    start = run_to(source, time - 4 * h)
    rows = [start.values()]
    for k in list(offsets)[1:]:
        start.step_to(time + k * h)
        rows.append(start.values())
        set_inputs(start, time + k * h)
    samples = np.array(rows)
    here = run_to(source, time)
    laws = [LAWS[s.name](time) if s.name in LAWS else [0.0, 0.0, 0.0] for s in here.inputs]
    found = output_derivatives(here, [law[1] for law in laws], [law[2] for law in laws])
    unknown = third_derivatives(here)
    for order, weights, bound in ((1, FIRST, 1e-6), (2, SECOND, 1e-3)):
        expected = weights @ samples / h**order
        for k, signal in enumerate(here.outputs):
            if signal.name in unknown[order - 1]:
                continue
            size = 1 + abs(expected[k])
            assert_close(
                f"{order}. of {signal.name}", found[order - 1][k], expected[k], bound * size, "differences"
            )


def third_derivatives(plant: gelenk.Simulation) -> list[Sequence[str]]:
    """Outputs whose first and second derivatives depend on higher derivatives of an input than the second."""
    names = [s.name for s in plant.inputs]
    if "crank.phi_ref" not in names:
        return [[], [s.name for s in plant.outputs if "crank.w_ref" in names and s.level not in (0, 1)]]
    fast = [s.name for s in plant.outputs if s.level not in (0, 1)]
    return [fast, [s.name for s in plant.outputs if s.level != 0]]


@pytest.mark.parametrize("plant", [driven, cranked, planetary])
def test_linear_model_of_the_fmu_is_that_of_the_scene(plant: Callable[[], Scene], tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(gelenk.load(plant()), tmp_path / "x.fmu")
    values = {name: law(0.0)[0] for name, law in LAWS.items() if name in
              {s.name for s in gelenk.Simulation(gelenk.load(plant())).inputs}}  # fmt: skip
    scene = gelenk.linear.linear_model(plant(), at=values)
    by_fmu = gelenk.linear.linear_model(fmu, at=values)
    assert by_fmu.states == scene.states
    assert by_fmu.inputs == scene.inputs
    for name in "ABCD":
        matrix = getattr(scene, name)
        assert_close(
            name, getattr(by_fmu, name), matrix, 1e-12 * (1 + np.abs(matrix).max()), "the same numbers"
        )


def test_directional_derivatives_of_the_fmu_on_a_trajectory_are_those_of_the_scene(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(gelenk.load(driven()), tmp_path / "x.fmu")
    slave = Slave(fmu, tmp_path / "unpacked")
    law = LAWS["crank.phi_ref"]
    slave.start(1e-11, {"crank.phi_ref": law(0.0)})
    for k in range(37):
        slave.give("crank.phi_ref", law(k * 0.01))
        slave.give("drive.tau", LAWS["drive.tau"](k * 0.01))
        slave.fmi.doStep(k * 0.01, 0.01)
    slave.give("crank.phi_ref", law(0.37))
    slave.give("drive.tau", LAWS["drive.tau"](0.37))
    here = run_to(driven(), 0.37)
    found = linearized(here)
    outputs = [s.name for s in here.outputs]
    references = [slave.reference[n] for n in outputs]
    for name, column in [
        *zip(found.states, found.C.T, strict=True),
        *zip((s.name for s in here.inputs), found.D.T, strict=True),
    ]:
        derivatives = slave.fmi.getDirectionalDerivative(references, [slave.reference[name]], [1.0])
        assert_close(
            name, derivatives, column, 1e-7 * (1 + np.abs(column).max()), "start and steps differ by rounding"
        )
    slave.free()
