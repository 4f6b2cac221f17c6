# SPDX-License-Identifier: BSD-3-Clause
"""Modules under the names that they had before there were packages: for one release, with a warning.

A finder behind all others, so that imports, attributes of `gelenk` and pickled results find them alike.
"""

from __future__ import annotations

import os
import sys
import warnings
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    "animation": "modal.animation",
    "branches": "model.branches",
    "chart.cli": "cli.chart",
    "cli_points": "cli.points",
    "cli_values": "cli.values",
    "derivatives": "simulation.derivatives",
    "export": "io.export",
    "fmu_plant": "simulation.fmu_plant",
    "fmu_slave": "simulation.fmu_slave",
    "foreign": "model.foreign",
    "inputs": "simulation.inputs",
    "inspection": "model.inspection",
    "linearization": "linear.linearization",
    "mode": "modal.mode",
    "mode_shapes": "modal.shapes",
    "mode_table": "modal.table",
    "newton": "equilibria.newton",
    "places": "model.places",
    "plant": "simulation.plant",
    "posing": "modal.posing",
    "progress": "cli.progress",
    "rest": "equilibria.rest",
    "result": "simulation.result",
    "run": "simulation.run",
    "scales": "model.scales",
    "scene": "model.scene",
    "scene_plant": "simulation.scene_plant",
    "spectrum": "modal.spectrum",
    "state_basis": "linear.state_basis",
    "steady": "equilibria.steady",
    "told": "cli.told",
    "urdf": "io.urdf",
    "urdf_inertia": "io.urdf_inertia",
    "yaml12": "model.yaml12",
    "yaml_faults": "model.yaml_faults",
}

# Whoever stands behind these asked for the old name.
_BETWEEN = (os.path.dirname(__file__), os.path.dirname(import_module.__code__.co_filename))  # noqa: PTH120


class MovedModules:
    """Finds the old names, and loads in their place the modules that stand for them."""

    @staticmethod
    def find_spec(name: str, *_path_and_target: object) -> ModuleSpec | None:
        """As `importlib.abc.MetaPathFinder` has it."""
        package, _, old = name.partition(".")
        return ModuleSpec(name, MovedModules()) if package == "gelenk" and old in MOVED else None  # type: ignore[arg-type]

    @staticmethod
    def create_module(_: ModuleSpec) -> None:
        """As `importlib.abc.Loader` has it: any module, which the next call replaces."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        """Puts the module that has the name now where the old one is looked for."""
        old = module.__name__
        new = f"gelenk.{MOVED[old.removeprefix('gelenk.')]}"
        sys.modules[old] = import_module(new)
        warnings.warn(
            f"{old} is called {new}; the old name goes with the next release",
            DeprecationWarning,
            stacklevel=2,
            skip_file_prefixes=_BETWEEN,
        )


def find_moved_modules() -> None:
    """From here on the old names are found."""
    if MovedModules not in sys.meta_path:
        sys.meta_path.append(MovedModules)
