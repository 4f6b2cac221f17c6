# SPDX-License-Identifier: BSD-3-Clause
"""Branches of assembly as notebooks show them: for each island a table with a column for each branch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gelenk import _html

if TYPE_CHECKING:
    from gelenk.model.branches import Assemblies, Branch

MAX_BRANCHES = 12
MAX_NAMES = 40


def assemblies_html(found: Assemblies, searches: Sequence[str]) -> str:
    """Return branches as HTML.

    Args:
        found: the branches.
        searches: for each island, a sentence about the searches.
    """
    parts: list[_html.Cell] = []
    for island, sentence in enumerate(searches):
        listed = [(k, branch) for k, branch in enumerate(found.branches, 1) if branch.island == island]
        parts += [_html.heading(*sentence.split(": ", 1)), _branches(listed[:MAX_BRANCHES], found)]
        if len(listed) > MAX_BRANCHES:
            parts.append(_html.paragraph(f"and {len(listed) - MAX_BRANCHES} more"))
    return _html.joined(parts)


def _branches(listed: Sequence[tuple[int, Branch]], found: Assemblies) -> _html.Fragment:
    branches = [branch for _, branch in listed]
    head = ["", "unit", *(f"{k}{' (start values)' if branch.is_default else ''}" for k, branch in listed)]
    names = list(branches[0].values) if branches else []
    rows: list[Sequence[_html.Cell]] = [
        ("distance", "", *(_html.number(branch.distance) for branch in branches)),
        ("found", "", *(f"{branch.hits} times" for branch in branches)),
    ]
    rows += [
        (name, _html.unit(found.units.get(name, "1")), *(_html.number(b.values[name]) for b in branches))
        for name in names[:MAX_NAMES]
    ]
    parts: list[_html.Cell] = [_html.table(head, rows, [False, False, *[True] * len(branches)])]
    if len(names) > MAX_NAMES:
        parts.append(_html.paragraph(f"and {len(names) - MAX_NAMES} more coordinates"))
    return _html.joined(parts)
