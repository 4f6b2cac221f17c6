# SPDX-License-Identifier: BSD-3-Clause
"""The accuracy of a simulation does not depend on the size and mass of the mechanism,
from a micrometer to a kilometer.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import warned
from mechanisms import Array, Scene
from models.scaled import scaled, size

import gelenk

pytestmark = warned.GRAVITY

SCENES = sorted(path.stem for path in (Path(__file__).parents[3] / "scenes").glob("*.yaml"))
TOLERANCE = 1e-8
OUTPUTS = 5  # times at which all outputs are compared
# Time spans [s] in which the motion does not yet amplify errors, short ones for the fast scenes.
SPAN = {"andrews": 0.01, "free_body": 2.0, "heavy_top": 0.2}


def course(source: Scene, span: float, tolerance: float, length: float = 1, mass: float = 1) -> Array:
    """Return all outputs of a run in the units of the original: shape (times, outputs).
    The motor torques are 0.1 N (N m) times the scale.
    """
    plant = gelenk.Simulation(gelenk.load(scaled(source, length, mass)))
    for i, signal in enumerate(plant.inputs):
        plant.set_input(signal.name, 0.1 * (-1) ** i * size(signal.unit, length, mass))
    plant.initialize(0.0, tolerance)
    factors = np.array([size(signal.unit, length, mass) for signal in plant.outputs])
    rows = []
    for k in range(OUTPUTS):
        plant.step_to((k + 1) / OUTPUTS * span)
        rows.append([plant.output(signal.name) for signal in plant.outputs])
    found: Array = np.array(rows) / factors
    return found


def scales(plant: gelenk.Simulation, exact: Array) -> Array:
    """Return the largest value of each output, but at least a thousandth of the
    largest among outputs of the same unit.
    """
    largest = np.abs(exact).max(axis=0)
    of_unit: dict[str, float] = {}
    for signal, value in zip(plant.outputs, largest, strict=True):
        of_unit[signal.unit] = max(of_unit.get(signal.unit, 0.0), float(value))
    floors = np.array([of_unit[signal.unit] for signal in plant.outputs])
    out: Array = np.maximum(largest, np.where(floors > 0, 1e-3 * floors, 1.0))
    return out


@pytest.mark.parametrize("name", SCENES)
def test_accuracy_does_not_depend_on_size_or_mass(name: str, root: Path) -> None:
    """The error of each output relative to its largest value is at most ten times that of the original.
    Errors below 1e-12 count as zero, because the scaled numbers of the file are rounded.
    """
    source = gelenk.load(root / "scenes" / f"{name}.yaml").to_dict()
    span = SPAN.get(name, 0.5)
    exact = course(source, span, 1e-13)
    plant = gelenk.Simulation(gelenk.load(source))
    scale = scales(plant, exact)
    own = np.abs(course(source, span, TOLERANCE) - exact).max(axis=0) / scale
    for length, mass in (
        (1e-6, 1), (1e-3, 1), (1e3, 1), (1e6, 1), (1, 1e-12), (1, 1e-6), (1, 1e6), (1e-6, 1e-12), (1e3, 1e6),
    ):  # fmt: skip
        found = np.abs(course(source, span, TOLERANCE, length, mass) - exact).max(axis=0) / scale
        worst = int(np.argmax(found - 10 * own))
        assert found[worst] <= 10 * max(own.max(), 1e-12), (
            f"lengths x {length:g}, masses x {mass:g}: {plant.outputs[worst].name} errs by "
            f"{found[worst]:.2g}, the original by {own[worst]:.2g}"
        )
