# SPDX-License-Identifier: BSD-3-Clause
"""Modules that were renamed or moved into packages: the old names work for one release, with a warning.

They are found by a finder at the end of `sys.meta_path`: by imports, as attributes of `gelenk` and its
packages, and by pickled results.
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
    "chart.turning": "chart.quadrature",
    "cli.errors": "cli.command",
    "cli.points": "cli.analysis",
    "cli.progress": "simulation.progress",
    "cli.told": "cli.command",
    "cli.values": "cli.arguments",
    "cli_points": "cli.analysis",
    "cli_values": "cli.arguments",
    "derivatives": "simulation.derivatives",
    "export": "io.export",
    "fmu_plant": "simulation.fmu_plant",
    "fmu_slave": "simulation.fmu_slave",
    "foreign": "model.other_formats",
    "inputs": "simulation.inputs",
    "inspection": "model.inspection",
    "linear.minimal": "linear.minimal_realization",
    "linearization": "linear.linearization",
    "modal.posing": "modal.body_poses",
    "modal.spectrum": "modal.eigenvalues",
    "mode": "modal.mode",
    "mode_shapes": "modal.shapes",
    "mode_table": "modal.table",
    "model.foreign": "model.other_formats",
    "model.given": "model.source_text",
    "model.places": "model.line_numbers",
    "places": "model.line_numbers",
    "plant": "simulation.plant",
    "posing": "modal.body_poses",
    "progress": "simulation.progress",
    "result": "simulation.result",
    "run": "simulation.run",
    "scales": "model.scales",
    "scene": "model.scene",
    "scene_plant": "simulation.scene_plant",
    "spectrum": "modal.eigenvalues",
    "state_basis": "linear.state_basis",
    "steady": "equilibria.steady",
    "told": "cli.command",
    "urdf": "io.urdf",
    "urdf_inertia": "io.urdf_inertia",
    "viewer.between": "viewer.interpolation",
    "viewer.endings": "viewer.file_types",
    "yaml12": "model.yaml12",
    "yaml_faults": "model.yaml_faults",
}

# Warnings are attributed to the first caller outside these files: the one that uses the old name.
_SKIPPED_FILES = (os.path.dirname(__file__), os.path.dirname(import_module.__code__.co_filename))  # noqa: PTH120


class MovedModules:
    """Finder and loader of modules under their old names."""

    @staticmethod
    def find_spec(name: str, *_path_and_target: object) -> ModuleSpec | None:
        """Return a spec for the old name of a module, else None; see `importlib.abc.MetaPathFinder`."""
        package, _, old = name.partition(".")
        return ModuleSpec(name, MovedModules()) if package == "gelenk" and old in MOVED else None  # type: ignore[arg-type]

    @staticmethod
    def create_module(_: ModuleSpec) -> None:
        """Return None, for a default module, which `exec_module` replaces; see `importlib.abc.Loader`."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        """Import the module by its new name, enter it in `sys.modules` under the old one, and warn."""
        old = module.__name__
        new = f"gelenk.{MOVED[old.removeprefix('gelenk.')]}"
        sys.modules[old] = import_module(new)
        warnings.warn(
            f"{old} is deprecated and will be removed in the next release; use {new}",
            DeprecationWarning,
            stacklevel=2,
            skip_file_prefixes=_SKIPPED_FILES,
        )


def find_moved_modules() -> None:
    """Install the finder of old module names, unless it is installed already."""
    if MovedModules not in sys.meta_path:
        sys.meta_path.append(MovedModules)
