# SPDX-License-Identifier: BSD-3-Clause
"""Line numbers of the fields in a scene's text, for messages about a path (`joints.A.start.phi`)."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from yaml.nodes import MappingNode, Node, ScalarNode

from gelenk.model import yaml12

_TOKEN = re.compile(r'\n|"(?:[^"\\\n]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+')
_ENTRY = re.compile(r"\[(\d+)\]")


@dataclass
class _Value:
    line: int
    fields: dict[str, _Field] = field(default_factory=dict)
    items: list[_Value] = field(default_factory=list)


@dataclass
class _Field:
    line: int  # of the first field of this name
    last_line: int  # of the last field of this name, if it is repeated
    value: _Value


class Places:
    """Line numbers of the fields in a text, which is parsed at the first query."""

    def __init__(self, text: str, language: str, file: str) -> None:
        """Store a text.

        Args:
            text: text of a scene.
            language: "yaml" or "json".
            file: file name in messages.
        """
        self._text = text
        self._language = language
        self._file = file or "scene"

    def located(self, lines: Iterable[str], *, whole: bool = True) -> list[str]:
        """Add line numbers to messages: `file: path: ...` becomes `file:line: path: ...`.

        Args:
            lines: the messages.
            whole: whether messages whose path is not in the text get the line of the whole scene.
        """
        return [self._located(line, whole) for line in lines]

    def _located(self, message: str, whole: bool) -> str:
        start = f"{self._file}: "
        if not message.startswith(start):
            return message
        rest = message.removeprefix(start)
        found = self._line(rest, "found twice" in rest)
        if found is None:
            loop = re.match(r"loop through (\w+)", rest)
            found = self._line(f"joints.{loop[1]}", False) if loop else None
        if found is None:
            if not whole:
                return message
            found = self._root.line if self._root else 1
        return f"{self._file}:{found}: {rest}"

    def _line(self, rest: str, twice: bool) -> int | None:
        """Return the line of the longest path with which a message begins; None if it begins with none."""
        value, line = self._root, None
        at = 0
        while value is not None:
            entry = _ENTRY.match(rest, at)
            if entry and value.items:
                index = int(entry[1]) - 1
                if index >= len(value.items):
                    break
                value = value.items[index]
                line, at = value.line, entry.end()
                continue
            first = _first_field(rest, at + 1 if at else 0, value.fields)
            if first is None or (at and rest[at] != "."):
                break
            found, at = first
            value = found.value
            line = found.last_line if twice and rest.startswith(": found twice", at) else found.line
        return line

    @functools.cached_property
    def _root(self) -> _Value | None:
        return _yaml_tree(self._text) if self._language == "yaml" else _json_tree(self._text)


def _first_field(rest: str, at: int, fields: dict[str, _Field]) -> tuple[_Field, int] | None:
    """Return the field with the longest name at a place of a message, and the end of the name.

    Names may contain dots, brackets and colons. Names that are too long are abbreviated in messages with
    `...`.
    """
    ends = [at + end.start() for end in re.finditer(r"[.\[:]|$", rest[at : at + 500])]
    for end in reversed(ends):
        if rest[at:end] in fields:
            return fields[rest[at:end]], end
        if rest[at:end].endswith("..."):
            begun = [name for name in fields if name.startswith(rest[at : end - 3])]
            if begun:
                return fields[max(begun, key=len)], end
    return None


def _printable(name: str) -> str:
    """Return a name as in messages (text::printable): control characters escaped, about 60 bytes at most."""
    if len(name) < 60 and name.isascii() and name.isprintable():
        return name
    out = ""
    for c in name:
        if len(out.encode()) >= 60:
            return out + "..."
        out += c if c >= " " and c != "\x7f" else f"\\x{ord(c):02x}"
    return out


def _put(fields: dict[str, _Field], name: str, line: int, value: _Value) -> None:
    shown = _printable(name)
    if shown in fields:
        fields[shown].last_line = line
    else:
        fields[shown] = _Field(line, line, value)


def _yaml_tree(text: str) -> _Value | None:
    root = yaml12.compose(text)
    made: dict[int, _Value] = {}  # by identity, as aliases repeat nodes

    def tree(node: Node) -> _Value:
        if id(node) in made:
            return made[id(node)]
        value = made[id(node)] = _Value(node.start_mark.line + 1)
        if isinstance(node, MappingNode):
            for key, inner in node.value:
                if isinstance(key, ScalarNode):
                    _put(value.fields, key.value, key.start_mark.line + 1, tree(inner))
        elif not isinstance(node, ScalarNode):
            value.items = [tree(item) for item in node.value]
        return value

    return None if root is None else tree(root)


def _json_tree(text: str) -> _Value:
    """Return the lines of a JSON text that is known to be valid."""
    root = _Value(1)
    open_: list[tuple[_Value, bool]] = []  # open collections, and whether they are mappings
    line, name, name_line = 1, None, 1

    def put(value: _Value) -> None:
        nonlocal root
        if not open_:
            root = value
        elif open_[-1][1]:
            _put(open_[-1][0].fields, name or "", name_line, value)
        else:
            open_[-1][0].items.append(value)

    for found in _TOKEN.finditer(text):
        token = found[0]
        if token == "\n":
            line += 1
        elif token in "{[":
            value = _Value(line)
            put(value)
            open_.append((value, token == "{"))
            name = None
        elif token in "}]":
            open_.pop()
        elif token == ",":
            name = None
        elif token != ":":
            if open_ and open_[-1][1] and name is None:
                name, name_line = _unescaped(token), line
            else:
                put(_Value(line))
    return root


def _unescaped(token: str) -> str:
    import json

    return str(json.loads(token))
