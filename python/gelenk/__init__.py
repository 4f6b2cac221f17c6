# SPDX-License-Identifier: BSD-3-Clause
"""Gelenk: from the description of a mechanism to a simulated plant.

>>> import gelenk
>>> scene = gelenk.load("scenes/four_bar.yaml")
>>> result = gelenk.simulate(scene, stop=1.0, inputs={"drive.tau": 3.0})
>>> fmu = gelenk.export_fmu(scene, "FourBar.fmu")

Packages: `model` (scenes), `io` (URDF import, FMU export), `simulation`, `linear` (linear models), `modal`
(modes of vibration), `equilibria`, `sweeps` (many runs), `batches` (instances that step together),
`gradients` (derivatives of runs, fits, designs), `learning`, `chart` (work-precision diagrams), `cli`;
each is imported at first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gelenk import _lazy, _moved

if TYPE_CHECKING:
    from gelenk.batches import Batch, batch
    from gelenk.equilibria import Equilibrium, equilibrium
    from gelenk.errors import (
        AssemblyError,
        EquilibriumError,
        ExportError,
        FileWarning,
        GelenkError,
        MissingFileError,
        OperatingPointWarning,
        SceneError,
        SceneWarning,
        StartWarning,
        StepBudgetError,
        StepError,
        UsageError,
    )
    from gelenk.gradients import (
        DifferentiatedRun,
        Fit,
        Optimum,
        fit,
        jvp,
        optimize,
        sensitivity,
        vjp,
    )
    from gelenk.io import export_fmu, export_ssp, import_urdf
    from gelenk.learning import environment, vector_environment
    from gelenk.linear import LinearModel, OperatingPoint, control_system, linearize
    from gelenk.modal import Mode, Modes, modes
    from gelenk.model import Assemblies, Branch, Inspection, Scene, assemblies, inspect, load
    from gelenk.simulation import Result, Simulation, live_view, simulate, view
    from gelenk.sweeps import sobol, sweep
    from gelenk.symbolic import Equations, equations
    from gelenk.viewer import View

    __version__: str

__all__ = [
    "Assemblies",
    "AssemblyError",
    "Batch",
    "Branch",
    "DifferentiatedRun",
    "Equations",
    "Equilibrium",
    "EquilibriumError",
    "ExportError",
    "FileWarning",
    "Fit",
    "GelenkError",
    "Inspection",
    "LinearModel",
    "MissingFileError",
    "Mode",
    "Modes",
    "OperatingPoint",
    "OperatingPointWarning",
    "Optimum",
    "Result",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Simulation",
    "StartWarning",
    "StepBudgetError",
    "StepError",
    "UsageError",
    "View",
    "__version__",
    "assemblies",
    "batch",
    "control_system",
    "environment",
    "equations",
    "equilibrium",
    "export_fmu",
    "export_ssp",
    "fit",
    "import_urdf",
    "inspect",
    "jvp",
    "linearize",
    "live_view",
    "load",
    "modes",
    "optimize",
    "sensitivity",
    "simulate",
    "sobol",
    "sweep",
    "vector_environment",
    "view",
    "vjp",
]

# A package must not have the name of a function, which it would hide: hence `simulation`, `equilibria`
# and `viewer`.
_get, _dir = _lazy.lazy(
    __name__,
    {
        ".batches": ["Batch", "batch"],
        ".equilibria": ["Equilibrium", "equilibrium"],
        ".errors": [name for name in __all__ if name.endswith(("Error", "Warning"))],
        ".gradients": ["DifferentiatedRun", "Fit", "Optimum", "fit", "jvp", "optimize", "sensitivity", "vjp"],
        ".io": ["export_fmu", "export_ssp", "import_urdf"],
        ".learning": ["environment", "vector_environment"],
        ".linear": ["LinearModel", "OperatingPoint", "control_system", "linearize"],
        ".modal": ["Mode", "Modes", "modes"],
        ".model": ["Assemblies", "Branch", "Inspection", "Scene", "assemblies", "inspect", "load"],
        ".simulation": ["Result", "Simulation", "live_view", "simulate", "view"],
        ".sweeps": ["sobol", "sweep"],
        ".symbolic": ["Equations", "equations"],
        ".viewer": ["View"],
    },
)

if not TYPE_CHECKING:  # type checkers would accept any attribute

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            from importlib.metadata import version

            return version("gelenk")
        return _get(name)

    def __dir__() -> list[str]:
        return sorted({*_dir(), "__version__"})


_moved.find_moved_modules()
