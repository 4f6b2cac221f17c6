# SPDX-License-Identifier: BSD-3-Clause
"""Scenes that offer as a parameter whatever can be one, and that are seen by every kind of sensor."""

from __future__ import annotations

import copy

from elements.scenes import with_sensors
from mechanisms import Scene

import gelenk
from gelenk import _core


def settable_paths(source: Scene) -> list[str]:
    """Paths of everything in a scene that `parameters` may list, gravity aside."""
    return [path for path, _ in _core.list_settables(gelenk.load(source)._core) if path != "gravity"]


def offering_all(source: Scene) -> Scene:
    """The same scene with all of them as parameters."""
    out = copy.deepcopy(source)
    out["parameters"] = settable_paths(source)
    return out


def observed(source: Scene) -> Scene:
    """The same scene with every sensor on every joint and body."""
    return with_sensors(source)
