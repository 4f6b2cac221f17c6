# SPDX-License-Identifier: BSD-3-Clause
"""Inspections as notebooks show them: sizes, reductions, mobility."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk import _html
from gelenk._deprecated import OLD_KEYS

if TYPE_CHECKING:
    from gelenk.model.inspection import Inspection


def inspection_html(report: Inspection, mobility: str) -> str:
    """Return an inspection as HTML.

    Args:
        report: the inspection.
        mobility: its degrees of freedom and their reasons, as a sentence.
    """
    parts: list[_html.Cell] = [_html.heading(report.name), _sizes(report), _reductions(report)]
    if report.left_out:
        parts.append(_html.paragraph(f"outputs: {report.left_out}"))
    parts.append(_html.paragraph(f"mobility: {mobility}"))
    if report.moved_frames:
        rows = (
            (f"{joint} in {body}", _html.number(turn, 3), _html.number(shift, 3))
            for joint, body, turn, shift in report.moved_frames
        )
        titles = ("frame moved so that the loops close", "rotation [rad]", "shift [m]")
        parts.append(_html.table(titles, rows))
    return _html.joined(parts)


def _sizes(report: Inspection) -> _html.Fragment:
    data = report.to_dict()
    rows = [
        (key.replace("_", " "), str(value), str(data["reduced"][key]))
        for key, value in data["described"].items()
        if key not in OLD_KEYS and key != "evaluation"
    ]
    rows.append(("evaluation", report.cost_literal.text, report.cost.text))
    return _html.table(("", "as described", "as computed"), rows)


def _reductions(report: Inspection) -> _html.Fragment:
    rows = []
    for name, reduction in report.reductions.items():
        notes = list(reduction.notes) if reduction.on else ["switched off", *reduction.notes]
        effect = _html.Fragment("<br/>".join(_html.text(note) for note in notes or ["nothing to do"]))
        rows.append((name, report.cost_without[name].text, effect))
    return _html.table(("reduction", "evaluation without it", "effect"), rows, (False, True, False))
