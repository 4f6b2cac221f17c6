# SPDX-License-Identifier: BSD-3-Clause
"""Conversion of YAML 1.2 (core schema) to JSON, so that one reader checks scenes in both languages.

PyYAML implements YAML 1.1, in which `1e-6` is a string, `on` a boolean, `010` eight and `1:30` ninety.
Repeated keys are preserved; the scene reader reports them.
"""

from __future__ import annotations

import json
import math
import re
from importlib import import_module
from typing import Any

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from gelenk.errors import SceneError
from gelenk.model import yaml_faults

MAX_VALUES = 5_000_000  # aliases of aliases grow exponentially; a scene of 10 000 bodies has about 200 000

MAX_TEXT = 50_000_000  # characters of the JSON text; a scene may have fewer
MAX_EXPLAINED = 100_000  # characters before an error, up to which the slower parser may explain it

_TAG = "tag:yaml.org,2002:"
_PATTERNS = {  # YAML 1.2.2, section 10.3.2
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "bool": (r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    "int": (r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", list("-+0123456789")),
    "float": (
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
        r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
        list("-+.0123456789"),
    ),
}


class Loader(yaml.SafeLoader):
    """A YAML 1.2 loader, of which only the composer is used."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 (as in PyYAML)


if yaml.__with_libyaml__:
    _Parser: Any = import_module("yaml.cyaml").CParser

    class _FastLoader(_Parser, yaml.constructor.SafeConstructor, yaml.resolver.Resolver):  # type: ignore[misc]
        """The same with libyaml, which is ten times as fast, but explains errors less well."""

        yaml_implicit_resolvers = Loader.yaml_implicit_resolvers

        def __init__(self, text: str) -> None:
            _Parser.__init__(self, text)
            yaml.constructor.SafeConstructor.__init__(self)
            yaml.resolver.Resolver.__init__(self)


class _Dumper(yaml.SafeDumper):
    """A dumper that quotes strings which YAML 1.1 or 1.2 would read as other types."""

    yaml_implicit_resolvers = {  # noqa: RUF012
        first: list(rules) for first, rules in yaml.SafeDumper.yaml_implicit_resolvers.items()
    }

    def ignore_aliases(self, _data: Any) -> bool:
        """Write repeated lists in full: edits insert parts separately, so their anchors would clash."""
        return True


for _name, (_pattern, _first) in _PATTERNS.items():
    Loader.add_implicit_resolver(_TAG + _name, re.compile(f"^(?:{_pattern})$"), _first)
    _Dumper.add_implicit_resolver(_TAG + _name, re.compile(f"^(?:{_pattern})$"), _first)


def compose(text: str) -> Node | None:
    """Return the tree of nodes of a YAML document; None if it is empty.

    Raises:
        yaml.YAMLError: the document is not valid YAML.
        RecursionError: it is nested too deeply.
    """
    if yaml.__with_libyaml__:
        try:
            return _composed(text, _FastLoader)
        except yaml.YAMLError as e:
            mark = getattr(e, "problem_mark", None)
            if (mark.index if mark is not None else len(text)) > MAX_EXPLAINED:
                raise
    return _composed(text, Loader)


def _composed(text: str, loader: Any) -> Node | None:
    root: Node | None = yaml.compose(text, Loader=loader)
    return root


def to_json(text: str, file: str) -> str:
    """Convert a YAML document to JSON text.

    Args:
        text: the document.
        file: file name for messages.

    Raises:
        SceneError: the document is not valid YAML, or contains tags.
    """
    try:
        root = compose(text)
        return "null" if root is None else _Writer(file, _repeated(root)).write(root)
    except yaml.YAMLError as e:
        raise SceneError(yaml_faults.explained(e, text, file)) from None
    except RecursionError:
        raise SceneError(f"{file}: nested too deeply for a scene") from None


def _repeated(root: Node) -> set[int]:
    """Return the identities of the lists and mappings that aliases repeat."""
    seen: set[int] = set()
    found: set[int] = set()
    waiting = [root]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ScalarNode):
            continue
        if id(node) in seen:
            found.add(id(node))
            continue
        seen.add(id(node))
        if isinstance(node, MappingNode):
            waiting += [part for pair in node.value for part in pair]
        else:
            waiting += node.value
    return found


def dump(data: dict[str, Any]) -> str:
    """Return data as YAML text, with short lists and mappings on one line and keys in their order."""
    return str(yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=110))


def inline(value: Any) -> str:
    """Return a value as YAML text in one line, valid in blocks and between brackets."""
    text = yaml.dump([value], Dumper=_Dumper, sort_keys=False, default_flow_style=True, width=math.inf)
    return str(text).strip()[1:-1]


def _at(file: str, mark: Any, what: str) -> str:
    place = f"{file}:{mark.line + 1}:{mark.column + 1}" if mark is not None else file
    return f"{place}: {what}"


class _Writer:
    """Writer of a YAML node tree as JSON."""

    def __init__(self, file: str, repeated: set[int]) -> None:
        self._file = file
        self._above: set[int] = set()  # identities of the nodes that are being written, to detect recursion
        self._count = 0
        self._repeated = repeated
        self._written: dict[int, tuple[str, int]] = {}  # of repeated nodes: text, number of values
        self._kept = 0  # characters

    def write(self, node: Node) -> str:
        """Return the JSON text of a node. Raises SceneError."""
        self._count += 1
        if isinstance(node, ScalarNode):
            return self._scalar(node)
        if id(node) in self._above:
            raise SceneError(_at(self._file, node.start_mark, "contains itself through an alias"))
        text, count = self._written.get(id(node), ("", 0))
        if count:
            self._count += count - 1
        else:
            before = self._count - 1
            self._above.add(id(node))
            text = self._mapping(node) if isinstance(node, MappingNode) else self._sequence(node)
            self._above.remove(id(node))
            if id(node) in self._repeated:
                self._written[id(node)] = text, self._count - before
                self._kept += len(text)
        if self._count > MAX_VALUES:
            raise SceneError(f"{self._file}: its aliases expand to more than {MAX_VALUES} values")
        if len(text) + self._kept > MAX_TEXT:
            raise SceneError(f"{self._file}: its aliases expand to more than {MAX_TEXT / 1e6:.0f} MB")
        return text

    def _sequence(self, node: Node) -> str:
        if not isinstance(node, SequenceNode) or node.tag != _TAG + "seq":
            raise self._tagged(node)
        return "[" + ",".join(self.write(item) for item in node.value) + "]"

    def _mapping(self, node: MappingNode) -> str:
        if node.tag != _TAG + "map":
            raise self._tagged(node)
        return "{" + ",".join(f"{self._key(key)}:{self.write(value)}" for key, value in node.value) + "}"

    def _key(self, node: Node) -> str:
        if not isinstance(node, ScalarNode):
            raise SceneError(
                _at(self._file, node.start_mark, "found a list or mapping as key, expected a name")
            )
        return json.dumps(node.value)  # as written: a body may be called `on` or `1`

    def _scalar(self, node: ScalarNode) -> str:
        kind = node.tag.removeprefix(_TAG)
        value = node.value
        try:
            if kind == "str":
                return json.dumps(value)
            if kind == "null":
                return "null"
            if kind == "bool":
                return {"true": "true", "false": "false"}[value.lower()]
            if kind == "int":
                return str(int(value, 0) if value[:2] in ("0o", "0x") else int(value))
            if kind == "float":
                return json.dumps(float(re.sub(r"^([-+]?)\.(?=[inIN])", r"\1", value)))
        except (ValueError, KeyError):
            raise SceneError(_at(self._file, node.start_mark, f"found {value!r}, expected {kind}")) from None
        raise self._tagged(node)

    def _tagged(self, node: Node) -> SceneError:
        return SceneError(
            _at(self._file, node.start_mark, f"found the tag {node.tag}, expected a plain value")
        )
