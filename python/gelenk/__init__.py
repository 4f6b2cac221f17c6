# SPDX-License-Identifier: BSD-3-Clause
"""Gelenk: from the description of a mechanism to a running plant.

>>> import gelenk
>>> scene = gelenk.load("scenes/four_bar.yaml")
>>> result = gelenk.simulate(scene, stop=1.0, inputs={"drive.tau": 3.0})
>>> fmu = gelenk.export_fmu(scene, "FourBar.fmu")
"""

from __future__ import annotations

from importlib.metadata import version
from os import PathLike

from gelenk.branches import Assemblies, Branch, assemblies
from gelenk.equilibria import Equilibrium, equilibrium
from gelenk.errors import (
    AssemblyError,
    EquilibriumError,
    ExportError,
    GelenkError,
    OperatingPointWarning,
    SceneError,
    SceneWarning,
    StartWarning,
    StepBudgetError,
    StepError,
    UsageError,
)
from gelenk.export import export_fmu
from gelenk.inspection import Inspection, inspect
from gelenk.linear import LinearModel
from gelenk.linearization import linearize
from gelenk.modal import Modes, modes
from gelenk.mode import Mode
from gelenk.result import Result
from gelenk.run import simulate
from gelenk.scene import Scene, load
from gelenk.simulation import Simulation

__version__ = version("gelenk")

__all__ = [
    "Assemblies",
    "AssemblyError",
    "Branch",
    "Equilibrium",
    "EquilibriumError",
    "ExportError",
    "GelenkError",
    "Inspection",
    "LinearModel",
    "Mode",
    "Modes",
    "OperatingPointWarning",
    "Result",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Simulation",
    "StartWarning",
    "StepBudgetError",
    "StepError",
    "UsageError",
    "__version__",
    "assemblies",
    "equilibrium",
    "export_fmu",
    "import_urdf",
    "inspect",
    "linearize",
    "load",
    "modes",
    "simulate",
]


def import_urdf(
    path: str | PathLike[str],
    *,
    floating: bool = False,
    repair_inertia: bool = False,
    assembly_tolerance: float | None = None,
) -> Scene:
    """A scene from a URDF robot description, its root welded to the ground or `floating`.

    repair_inertia: take the nearest physical inertia where a link has one that no rigid body has.
    assembly_tolerance: the scene's `assembly.tolerance`. See `gelenk.urdf.import_urdf`.
    """
    from gelenk import urdf

    return urdf.import_urdf(
        path,
        floating=floating,
        repair_inertia=repair_inertia,
        assembly_tolerance=assembly_tolerance,
    )
