# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of a scene that it does not list as parameters, but which sweeps and derivatives may set."""

from __future__ import annotations

from collections.abc import Iterable

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.scene import Scene, from_dict
from gelenk.model.values import elements


def with_listed(scene: Scene, names: Iterable[str]) -> tuple[Scene, dict[str, str]]:
    """Return a scene in which numbers are parameters, and the names of these parameters.

    Args:
        scene: the scene.
        names: paths in the file ("crank.mass", "B.parent.position[1]"), and other names, which are ignored.

    Raises:
        UsageError: a path is that of an array.
    """
    known = scene.parameters
    sizes = dict(_core.list_settables(scene._core))
    renamed: dict[str, str] = {}
    for name in names:
        path = name.partition("[")[0]
        if name in known or path not in sizes:
            continue
        if sizes[path] > 1 and name == path:
            listed = ", ".join(elements(path, sizes[path]))
            raise UsageError(f"{name}: found an array of {sizes[path]} numbers, expected one of {listed}")
        data = scene.to_dict()
        if path in data.get("parameters", []) or name in data.get("parameters", []):
            parameter = _parameter_of(scene, name)
        else:
            data["parameters"] = [*data.get("parameters", []), name]
            listed_scene = from_dict(data, scene.file)
            parameter = next(new for new in listed_scene.parameters if new not in scene.parameters)
            scene = listed_scene
        renamed[name] = parameter
    return scene, renamed


def _parameter_of(scene: Scene, path: str) -> str:
    """Return the name of the parameter of a number that the scene lists by its path."""
    data = scene.to_dict()
    alone = from_dict({**data, "parameters": [path]}, scene.file)
    always = from_dict({**data, "parameters": []}, scene.file).parameters
    return next(name for name in alone.parameters if name not in always)
