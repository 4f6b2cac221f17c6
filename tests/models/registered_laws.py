# SPDX-License-Identifier: BSD-3-Clause
"""The fields of the laws of joints and contacts, from the registry, and which of them scenes set."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from gelenk._core import elements, scene_schema

KINDS: dict[str, list[dict[str, Any]]] = elements.kinds()
INTEGRATORS: list[str] = json.loads(scene_schema())["properties"]["solver"]["properties"]["integrator"][
    "enum"
]
Path = tuple[str, ...]  # of a field: group, name; of a word or an element: this, too
Setting = tuple[Path, Any]


def _fields(fields: Iterable[Mapping[str, Any]], within: Path) -> Iterator[tuple[Path, Mapping[str, Any]]]:
    for field in fields:
        path = (*within, field["name"])
        if field["type"] == "group":
            yield from _fields(field["fields"], path)
        else:
            yield path, field


def fields(section: str) -> dict[Path, Mapping[str, Any]]:
    """All fields of the laws in "joints" or "contacts"; those in a group of a joint under its name."""
    out: dict[Path, Mapping[str, Any]] = {}
    for kind in KINDS[section]:
        out |= dict(_fields(kind["fields"], (kind["group"],) if kind.get("group") else ()))
    return out


def _variants(path: Path, field: Mapping[str, Any]) -> set[Setting]:
    """What has to be set of a field: every word of a choice, every component of a vector, one other value."""
    if field["type"] == "choice":
        return {(path, word) for word in field["words"]}
    if field["type"] == "vector":
        return {(path, i) for i in range(field["size"])}
    return {(path, True)}


def wanted(section: str) -> set[Setting]:
    """Everything that can be set of the laws in "joints" or "contacts"."""
    return {each for path, field in fields(section).items() for each in _variants(path, field)}


def _value(entry: Mapping[str, Any], path: Path) -> Any:
    for key in path:
        if key not in entry:
            return None
        entry = entry[key]
    return entry


def settings(entry: Mapping[str, Any], section: str) -> set[Setting]:
    """What a joint or a contact of a scene sets to other values than the default ones."""
    out: set[Setting] = set()
    for path, field in fields(section).items():
        value = _value(entry, path)
        if field["type"] == "choice":
            out.add((path, value if value is not None else _default_word(field)))
        elif field["type"] == "vector":
            out |= {(path, i) for i, x in enumerate(value or []) if x != field["default"][i]}
        elif value is not None and value != field["default"]:
            out.add((path, True))
    return out


def _default_word(field: Mapping[str, Any]) -> str | None:
    index = field["default"]
    return field["words"][index] if index is not None and index >= 0 else None


def tunable(section: str) -> set[str]:
    """Names of all fields that can be changed in mid-run, as parameters have them after the element's."""
    out = set()
    for path, field in fields(section).items():
        if field["tunable"]:
            name = ".".join(path)
            out |= {f"{name}[{i + 1}]" for i in range(field["size"])} if field["size"] else {name}
    return out


def output_names(kind: Mapping[str, Any]) -> list[str]:
    """Names of the outputs of a kind of element, as they are after the element's."""
    return [
        f"{group['name']}[{i + 1}]" if group["is_array"] else group["name"]
        for group in kind["outputs"]
        for i in range(group["size"] if group["is_array"] else 1)
    ]
