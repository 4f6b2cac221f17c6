# SPDX-License-Identifier: BSD-3-Clause
"""Packages whose public names are imported at their first use (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any


def lazy(
    package: str, places: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package.

    Besides its public names, the modules of the package are available as attributes.

    Args:
        package: `__name__` of the package.
        places: module relative to the package (".scene") -> public names that are defined there.
    """
    modules = {name: module for module, names in places.items() for name in names}

    def get(name: str) -> Any:
        if name in modules:
            value = getattr(import_module(modules[name], package), name)
            setattr(sys.modules[package], name, value)  # further accesses do not come here
            return value
        if not name.startswith("__"):
            try:
                return import_module(f".{name}", package)
            except ModuleNotFoundError as e:
                if e.name != f"{package}.{name}":
                    raise
        raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name)

    def names() -> list[str]:
        from pkgutil import iter_modules

        here = sys.modules[package]
        return sorted({*vars(here), *modules, *(found.name for found in iter_modules(here.__path__))})

    return get, names
