# SPDX-License-Identifier: BSD-3-Clause
"""Packages whose names are imported when they are first asked for (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any


def lazy(
    package: str, places: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    Besides the public names, the modules in the package are found as its attributes.

    Args:
        package: its `__name__`.
        places: module, as seen from the package (".scene") -> the public names that are found there.
    """
    modules = {name: module for module, names in places.items() for name in names}

    def get(name: str) -> Any:
        if name in modules:
            value = getattr(import_module(modules[name], package), name)
            setattr(sys.modules[package], name, value)  # asked for once
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
