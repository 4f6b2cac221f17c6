# SPDX-License-Identifier: BSD-3-Clause
"""Optional packages: the extra that installs each of them, and the error if one is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from gelenk.errors import UsageError

EXTRAS = {
    "PIL": "view",
    "SALib": "sobol",
    "casadi": "casadi",
    "cloudpickle": "sweep",
    "distributed": "sweep",
    "h5netcdf": "tables",
    "h5py": "tables",
    "gymnasium": "learning",
    "matplotlib": "charts",
    "pandas": "tables",
    "pebble": "sweep",
    "pyarrow": "tables",
    "sympy": "sympy",
    "tqdm": "progress",
    "trimesh": "mesh",
    "xarray": "tables",
    "yourdfpy": "urdf",
}  # package -> extra in pyproject.toml


def extra(package: str, use: str) -> Any:
    """Import an optional package.

    Args:
        package: one of `EXTRAS`.
        use: its purpose, as the beginning of a message: "charts are drawn with matplotlib".

    Returns:
        Any: the imported module.

    Raises:
        UsageError: the package is missing or cannot be imported. The message names the extra to install.
    """
    try:
        return import_module(package)
    except ImportError as e:
        missing = isinstance(e, ModuleNotFoundError) and e.name == package
        why = "" if missing else f", which cannot be imported here ({e})"
        raise UsageError(f"{use}{why}: pip install 'gelenk[{EXTRAS[package]}]'") from None


def pyplot() -> Any:
    """Return `matplotlib.pyplot` with a backend that draws into files.

    Raises:
        UsageError: matplotlib is not installed.
    """
    extra("matplotlib", "charts are drawn with matplotlib").use("Agg")
    return import_module("matplotlib.pyplot")
