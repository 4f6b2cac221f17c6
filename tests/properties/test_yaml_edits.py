# SPDX-License-Identifier: BSD-3-Clause
"""Editing a YAML text preserves unchanged values in their lines, with their comments."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from gelenk.model import yaml12, yaml_edits

from .bounds import examples

KEY = st.sampled_from("abcde")
LEAF = st.integers(0, 9) | st.sampled_from(
    [0.0, -0.0, 1e-6, True, None, "a", "1", "a: b", "#", "", [1, 2], ["a"]]
)
TREE = st.recursive(LEAF, lambda inner: st.dictionaries(KEY, inner, min_size=1, max_size=4), max_leaves=12)
TREES = st.dictionaries(KEY, TREE, min_size=1, max_size=4)
type Path = tuple[str, ...]


@st.composite
def pairs(draw: st.DrawFn) -> tuple[dict[str, Any], dict[str, Any]]:
    """A tree and a modified version: entries are kept, removed, changed or added."""

    def varied(tree: dict[str, Any]) -> dict[str, Any]:
        out = {}
        for key, value in tree.items():
            fate = draw(st.sampled_from(["stays", "changes", "goes"]))
            if fate == "changes":
                out[key] = varied(value) if isinstance(value, dict) else draw(TREE)
            elif fate == "stays":
                out[key] = value
        return out | draw(st.dictionaries(KEY, TREE, max_size=1))

    before = draw(TREES)
    return before, varied(before)


def written(tree: dict[str, Any], braced: set[str], path: Path = (), inside: bool = False) -> Iterator[str]:
    """Lines of YAML, each value in one, with its path as a comment; values of these keys are in braces."""
    for key, value in tree.items():
        here = (*path, key)
        start, end = "  " * len(path) + f"{key}:", f"{',' if inside else ''}  # {'.'.join(here)}"
        if not isinstance(value, dict):
            yield f"{start} {yaml12.inline(value)}{end}"
        elif inside or key in braced:
            yield f"{start} {{"
            yield from written(value, braced, here, True)
            yield f"{'  ' * len(here)}}}{end}"
        else:
            yield f"{start}  # {'.'.join(here)}"
            yield from written(value, braced, here)


def kept(before: dict[str, Any], after: dict[str, Any], path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Values that are in both trees, with their paths."""
    for key in before.keys() & after.keys():
        values = before[key], after[key]
        if all(isinstance(value, dict) for value in values):
            yield from kept(*values, (*path, key))
        elif json.dumps(values[0]) == json.dumps(values[1]):
            yield (*path, key), values[0]


def test_a_list_that_occurs_twice_is_written_twice() -> None:
    """Not as an anchor and an alias, whose names would clash between the parts that are inserted."""
    twice = [1, 2]
    after = {"a": {"a": twice, "b": twice}, "b": {"a": twice, "b": twice}}
    found = yaml_edits.changed("a: 0\nb: 0  # kept\n", {"a": 0, "b": 0}, after)
    assert found is not None
    assert json.loads(yaml12.to_json(found, "")) == after
    assert "&" not in found


@examples(400)
@given(pair=pairs(), braced=st.sets(KEY, min_size=2))
def test_unchanged_values_stay_in_their_lines(
    pair: tuple[dict[str, Any], dict[str, Any]], braced: set[str]
) -> None:
    before, after = pair
    text = "\n".join(written(before, braced)) + "\n"
    assert json.loads(yaml12.to_json(text, "")) == before
    found = yaml_edits.changed(text, before, after)
    assert found is not None
    assert json.dumps(json.loads(yaml12.to_json(found, "")), sort_keys=True) == json.dumps(
        after, sort_keys=True
    )
    for path, value in kept(before, after):
        lines = [line for line in found.splitlines() if line.endswith(f"  # {'.'.join(path)}")]
        assert len(lines) == 1
        assert f"{path[-1]}: {yaml12.inline(value)}" in lines[0]
