# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria as notebooks show them: tables of outputs, inputs and of what is held."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gelenk import _html

if TYPE_CHECKING:
    from gelenk.equilibria.trim import Equilibrium

MAX_NAMES = 40


def trim_html(found: Equilibrium) -> str:
    """Return an equilibrium as HTML."""
    title, _, how = str(found).partition("\n")[0].removeprefix(f"{found.name}: ").partition("; ")
    parts: list[_html.Cell] = [_html.heading(found.name, title), _html.paragraph(how)]
    for what, values in (("input", found.inputs), ("output", found.values)):
        if values:
            parts.append(_values(what, values, found.units))
    if found.held:
        rows = [(name, str(holding)) for name, holding in found.held.items()]
        parts.append(_html.table(("held", "by"), rows, (False, False)))
    if found.contact_points:
        rows = [(point.contact, str(point)) for point in found.contact_points]
        parts.append(_html.table(("contact", "point"), rows, (False, False)))
    return _html.joined(parts)


def _values(what: str, values: Mapping[str, float], units: Mapping[str, str]) -> _html.Fragment:
    rows = [
        (name, _html.number(value), _html.unit(units.get(name, "1")))
        for name, value in list(values.items())[:MAX_NAMES]
    ]
    parts: list[_html.Cell] = [_html.table((what, "value", "unit"), rows, (False, True, False))]
    if len(values) > MAX_NAMES:
        parts.append(_html.paragraph(f"and {len(values) - MAX_NAMES} more"))
    return _html.joined(parts)
