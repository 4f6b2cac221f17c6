# SPDX-License-Identifier: BSD-3-Clause
"""Changes in a YAML text: all that is not changed keeps its comments, its order, its layout and its spelling.

Emitters that keep comments (ruamel.yaml's) set the rest anew: they join the lines of `{...}`, and drop the
comments in them and the spaces that align columns. Here values are exchanged where they stand.
"""

from __future__ import annotations

import json
import re
from itertools import pairwise
from typing import Any, NamedTuple

import yaml
from yaml.events import AliasEvent
from yaml.nodes import CollectionNode, MappingNode, Node

from gelenk.errors import SceneError
from gelenk.model import yaml12

_GONE = object()


def changed(text: str, before: Any, after: Any) -> str | None:
    """The text of `before` so that it says `after`; None where single values and entries do not do it."""
    edits = _Edits(text)
    root = yaml.compose(text, Loader=_Loader)
    assert root is not None
    edits.change(root, before, after)
    found = edits.applied()
    try:
        said = json.loads(yaml12.to_json(found, ""))
    except SceneError:
        return None
    return found if _plain(said) == _plain(after) else None


def _plain(value: Any) -> str:
    """Text that tells 1 from 1.0 and from true, and 0.0 from -0.0."""
    return json.dumps(value, sort_keys=True)


class _Alias(Node):
    """Where `*name` stands; its value is the node that has the name."""


class _Loader(yaml12.Loader):
    """Keeps where aliases stand."""

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        """Of the tree, the node that comes next."""
        alias = self.peek_event() if self.check_event(AliasEvent) else None  # type: ignore[no-untyped-call]
        node = super().compose_node(parent, index)
        return node if alias is None else _Alias("", node, alias.start_mark, alias.end_mark)


class _Entry(NamedTuple):
    key: str | int
    start: int  # of its name or its dash
    end: int
    value: Node


class _Edits:
    def __init__(self, text: str) -> None:
        self._text = text
        self._newline = "\r\n" if "\n" in text and text.count("\r\n") == text.count("\n") else "\n"
        self._edits: list[tuple[int, int, str]] = []  # from, to, what stands there instead
        self._after: dict[int, Any] = {}  # of nodes, by identity: what they will say

    def applied(self) -> str:
        """The text with all changes."""
        parts, at = [], 0
        for start, end, new in sorted(self._edits, key=lambda edit: edit[0]):  # at one place the inner first
            parts += [self._text[at:start], new]
            at = max(at, end)
        return "".join([*parts, self._text[at:]])

    def change(self, node: Node, before: Any, after: Any) -> None:
        """Makes a node that says `before` say `after`."""
        if isinstance(node, _Alias):
            named = self._after.get(id(node.value), _GONE)
            if named is _GONE or _plain(named) != _plain(after):
                self._replace(node, after)
            return
        self._after[id(node)] = after
        old, new = _matched(before, after)
        entries = self._entries(node, old) if isinstance(node, CollectionNode) else []
        if not isinstance(node, CollectionNode) or not any(entry.key in new for entry in entries):
            if _plain(before) != _plain(after):
                self._replace(node, after)
            return
        for entry in entries:
            if entry.key in new:
                self.change(entry.value, old[entry.key], new[entry.key])
        added = [self._entry(node, key, value) for key, value in new.items() if key not in old]
        if node.flow_style:
            self._change_flow(entries, new, added)
        else:
            self._change_block(entries, new, added)

    def _change_flow(self, entries: list[_Entry], new: dict[Any, Any], added: list[str]) -> None:
        """Cuts entries that are gone out of `{...}` or `[...]`, and adds others behind the last."""
        last = max(k for k, entry in enumerate(entries) if entry.key in new)
        end = entries[last].end
        self._edits += [
            (entry.start, following.start, "")
            for entry, following in pairwise(entries[: last + 1])
            if entry.key not in new
        ]
        if last + 1 < len(entries):
            start, stop = entries[last + 1].start, entries[-1].end
            if "#" in self._text[end:start]:  # a comment: it stays, and so does the comma before it
                comma = re.match(r"\s*,", self._text[stop:])
                self._edits.append((start, stop + (comma.end() if comma else 0), ""))
            else:
                self._edits.append((end, stop, ""))
        self._edits.append((end, end, "".join(f", {entry}" for entry in added)))

    def _change_block(self, entries: list[_Entry], new: dict[Any, Any], added: list[str]) -> None:
        """The same with entries that each have lines of their own."""
        for k, entry in enumerate(entries):
            if entry.key in new:
                end = self._line_end(entry.end)
                continue
            start, stop = self._line_start(entry.start), self._line_end(entry.end)
            if self._text[start : entry.start].strip():  # the dash of a list that this mapping is in
                self._edits.append((entry.start, entries[k + 1].start, ""))
            elif start:
                self._edits.append((start - len(self._newline), stop, ""))
            else:
                self._edits.append((0, stop + len(self._newline), ""))
        indent = self._newline + " " * (entries[0].start - self._line_start(entries[0].start))
        self._edits.append((end, end, "".join(indent + entry for entry in added)))

    def _replace(self, node: Node, value: Any) -> None:
        start, end = node.start_mark.index, self._end(node)
        anchor = re.match(r"&\S+\s+", self._text[start:end])
        start += anchor.end() if anchor else 0
        self._edits.append((start, end, yaml12.inline(value) if start < end else f" {yaml12.inline(value)}"))

    def _entries(self, node: CollectionNode, keys: dict[Any, Any]) -> list[_Entry]:
        """keys: one for each, in their order; none: they are not asked for."""
        return [
            _Entry(key, self._start(node, item), self._end(_value(item)), _value(item))
            for key, item in zip(keys, node.value, strict=True)
        ] if keys else []  # fmt: skip

    def _entry(self, node: CollectionNode, key: Any, value: Any) -> str:
        if isinstance(node, MappingNode):
            return yaml12.inline({key: value})[1:-1]
        return yaml12.inline(value) if node.flow_style else f"- {yaml12.inline(value)}"

    def _start(self, node: CollectionNode, item: Any) -> int:
        """Where an entry of this collection begins: its name, its dash, or itself."""
        start: int = (item[0] if isinstance(item, tuple) else item).start_mark.index
        is_dashed = not isinstance(node, MappingNode) and not node.flow_style
        return self._text.rindex("-", 0, start) if is_dashed else start

    def _end(self, node: Node) -> int:
        """Where its text ends; of a block its last entry's, as the parser goes on to behind comments."""
        if isinstance(node, CollectionNode) and not node.flow_style and node.value:
            return self._end(_value(node.value[-1]))
        start = node.start_mark.index
        return start + len(self._text[start : node.end_mark.index].rstrip())  # block texts end with a line

    def _line_start(self, at: int) -> int:
        return self._text.rfind("\n", 0, at) + 1

    def _line_end(self, at: int) -> int:
        end = self._text.find(self._newline, at)
        return len(self._text) if end < 0 else end


def _value(item: Node | tuple[Node, Node]) -> Node:
    """Of an entry of a mapping, which is a pair with its name, or of a list."""
    return item[1] if isinstance(item, tuple) else item


def _matched(before: Any, after: Any) -> tuple[dict[Any, Any], dict[Any, Any]]:
    """The entries of both by what they are told by: names, a list's words, places in lists alike long.

    Empty where the one does not become the other by exchanging, leaving out and adding entries.
    """
    if isinstance(before, dict) and isinstance(after, dict):
        return before, after
    if isinstance(before, list) and isinstance(after, list):
        old, new = ({word: word for word in words if isinstance(word, str)} for words in (before, after))
        kept = [word for word in old if word in new]
        if (len(old), len(new)) == (len(before), len(after)) and [*new][: len(kept)] == kept:
            return old, new
        if len(before) == len(after):
            return dict(enumerate(before)), dict(enumerate(after))
    return {}, {}
