# SPDX-License-Identifier: BSD-3-Clause
"""Edits of a YAML text that preserve comments, order, layout and spelling of everything that is not changed.

Emitters that preserve comments, such as that of ruamel.yaml, reformat the rest: they join the lines of
`{...}` and lose comments in them and aligned columns. Here values are replaced in the text.
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
    """Change a YAML text.

    Args:
        text: the text.
        before: its data.
        after: the new data.

    Returns:
        str | None: the new text; None if replacing single values and entries is not sufficient.
    """
    edits = _Edits(text)
    root = yaml.compose(text, Loader=_Loader)
    assert root is not None
    edits.change(root, before, after)
    found = edits.applied()
    try:
        result = json.loads(yaml12.to_json(found, ""))
    except SceneError:
        return None
    return found if _plain(result) == _plain(after) else None


def _plain(value: Any) -> str:
    """Return a text that differs for 1, 1.0 and true, and for 0.0 and -0.0."""
    return json.dumps(value, sort_keys=True)


class _Alias(Node):
    """An alias `*name` in the tree; its value is the node with the anchor."""


class _Loader(yaml12.Loader):
    """A loader that keeps aliases in the tree."""

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        """Compose the next node of the tree."""
        alias = self.peek_event() if self.check_event(AliasEvent) else None  # type: ignore[no-untyped-call]
        node = super().compose_node(parent, index)
        return node if alias is None else _Alias("", node, alias.start_mark, alias.end_mark)


class _Entry(NamedTuple):
    key: str | int
    start: int  # start of its name or its dash
    end: int
    value: Node


class _Edits:
    def __init__(self, text: str) -> None:
        self._text = text
        self._newline = "\r\n" if "\n" in text and text.count("\r\n") == text.count("\n") else "\n"
        self._edits: list[tuple[int, int, str]] = []  # start, end, replacement
        self._after: dict[int, Any] = {}  # by identity of a node: its new data

    def applied(self) -> str:
        """Return the text with all edits."""
        parts, at = [], 0
        for start, end, new in sorted(
            self._edits, key=lambda edit: edit[0]
        ):  # at equal places in order of creation: inner nodes first
            parts += [self._text[at:start], new]
            at = max(at, end)
        return "".join([*parts, self._text[at:]])

    def change(self, node: Node, before: Any, after: Any) -> None:
        """Change the data of a node from `before` to `after`."""
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
        """Remove entries from `{...}` or `[...]`, and add new ones after the last."""
        last = max(k for k, entry in enumerate(entries) if entry.key in new)
        end = entries[last].end
        self._edits += [
            (entry.start, following.start, "")
            for entry, following in pairwise(entries[: last + 1])
            if entry.key not in new
        ]
        if last + 1 < len(entries):
            start, stop = entries[last + 1].start, entries[-1].end
            if "#" in self._text[end:start]:  # a comment, which is kept with the comma before it
                comma = re.match(r"\s*,", self._text[stop:])
                self._edits.append((start, stop + (comma.end() if comma else 0), ""))
            else:
                self._edits.append((end, stop, ""))
        self._edits.append((end, end, "".join(f", {entry}" for entry in added)))

    def _change_block(self, entries: list[_Entry], new: dict[Any, Any], added: list[str]) -> None:
        """Remove and add entries that have lines of their own."""
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
        """Return the entries of a collection with their keys, in this order; nothing if there are no keys."""
        return [
            _Entry(key, self._start(node, item), self._end(_value(item)), _value(item))
            for key, item in zip(keys, node.value, strict=True)
        ] if keys else []  # fmt: skip

    def _entry(self, node: CollectionNode, key: Any, value: Any) -> str:
        if isinstance(node, MappingNode):
            return yaml12.inline({key: value})[1:-1]
        return yaml12.inline(value) if node.flow_style else f"- {yaml12.inline(value)}"

    def _start(self, node: CollectionNode, item: Any) -> int:
        """Return the start of an entry of a collection: of its name, its dash, or its value."""
        start: int = (item[0] if isinstance(item, tuple) else item).start_mark.index
        is_dashed = not isinstance(node, MappingNode) and not node.flow_style
        return self._text.rindex("-", 0, start) if is_dashed else start

    def _end(self, node: Node) -> int:
        """Return the end of a node's text; for a block that of its last entry, without comments after it."""
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
    """Return the value of an entry of a mapping (a pair with its name) or of a list."""
    return item[1] if isinstance(item, tuple) else item


def _matched(before: Any, after: Any) -> tuple[dict[Any, Any], dict[Any, Any]]:
    """Return the entries of two collections by their keys: names, words of a list, or indices in lists of
    equal length.

    The results are empty if replacing, removing and adding entries does not turn one into the other.
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
