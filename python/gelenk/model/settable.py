# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of a scene that it does not list as parameters, but which sweeps and derivatives may set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.scene import Scene, from_dict
from gelenk.model.values import Value, elements


def by_parameter(scene: Scene, settings: Mapping[str, Value]) -> dict[str, Value]:
    """Return settings by the names of parameters: paths that the scene lists are replaced by these.

    Args:
        scene: the scene.
        settings: values by name: of parameters ("crank.m"), paths in the file ("crank.mass"), and others,
            which are kept.

    Raises:
        UsageError: a path is not listed under `parameters`, is that of an array, or is given twice.
    """
    known = scene.parameters
    unknown = [name for name in settings if name not in known]
    sizes = dict(_core.list_settables(scene._core)) if unknown else {}
    paths = [name for name in unknown if name.partition("[")[0] in sizes]
    listed = scene.to_dict().get("parameters", []) if paths else []
    renamed = {}
    for name in paths:
        path = name.partition("[")[0]
        if sizes[path] > 1 and name == path:
            raise UsageError(_is_array(name, sizes[path]))
        if path not in listed and name not in listed:
            raise UsageError(
                f"{name}: a number of the scene that is no parameter; list it in the scene, "
                f"parameters: [{', '.join([*listed, name])}]"
            )
        renamed[name] = _parameter_of(scene, name)
        if renamed[name] in settings:
            raise UsageError(f"{name}: given twice, also as {renamed[name]}")
    return {renamed.get(name, name): value for name, value in settings.items()}


def _is_array(name: str, size: int) -> str:
    return f"{name}: found an array of {size} numbers, expected one of {', '.join(elements(name, size))}"


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
            raise UsageError(_is_array(path, sizes[path]))
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
