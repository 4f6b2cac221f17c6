# SPDX-License-Identifier: BSD-3-Clause
"""Fragments of HTML by which notebooks show results.

All text is escaped. There are no scripts, and only inline styles, since front ends remove others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape

LEFT = "text-align:left"
RIGHT = "text-align:right"


class Fragment(str):
    """Text that is HTML already."""

    __slots__ = ()


type Cell = str | Fragment


def text(content: Cell) -> Fragment:
    """Return a text as HTML."""
    return content if isinstance(content, Fragment) else Fragment(escape(content))


def paragraph(content: Cell) -> Fragment:
    """Return a paragraph."""
    return Fragment(f'<p style="margin:0.4em 0">{text(content)}</p>')


def heading(name: str, rest: str = "") -> Fragment:
    """Return a line that begins with a name in bold."""
    return paragraph(Fragment(f"<b>{text(name)}</b>{text(f': {rest}' if rest else '')}"))


def table(head: Sequence[Cell], rows: Iterable[Sequence[Cell]], numbers: Sequence[bool] = ()) -> Fragment:
    """Return a table.

    Args:
        head: titles of the columns.
        rows: their cells.
        numbers: of each column, whether it is aligned to the right; by default all but the first.
    """
    right = list(numbers) or [k > 0 for k in range(len(head))]

    def line(cells: Sequence[Cell], tag: str) -> str:
        return "".join(
            f'<{tag} style="{RIGHT if to_right else LEFT}">{text(cell)}</{tag}>'
            for cell, to_right in zip(cells, right, strict=True)
        )

    body = "".join(f"<tr>{line(row, 'td')}</tr>" for row in rows)
    return Fragment(f"<table><thead><tr>{line(head, 'th')}</tr></thead><tbody>{body}</tbody></table>")


def folded(title: str, content: Fragment) -> Fragment:
    """Return content that is shown after a click on its title."""
    return Fragment(f"<details><summary>{text(title)}</summary>{content}</details>")


def joined(parts: Iterable[Cell]) -> Fragment:
    """Return parts one below the other."""
    return Fragment(f"<div>{''.join(map(text, parts))}</div>")


def number(x: float, digits: int = 6) -> str:
    """Return a number with a true minus sign; a dash for NaN."""
    if math.isnan(x):
        return "–"
    return f"{x + 0.0:.{digits}g}".replace("-", "−").replace("inf", "∞")


def unit(name: str) -> str:
    """Return a unit as it is shown beside numbers: nothing for "1"."""
    return "" if name in ("", "1") else name


def sparkline(x: Sequence[float], y: Sequence[float], width: int = 160, height: int = 28) -> Fragment:
    """Return a small line chart as SVG, in the color of the text.

    Args:
        x: abscissas, ascending.
        y: values; NaN and infinity are gaps.
        width: of the chart [pixels].
        height: of the chart [pixels].
    """
    finite = [value for value in y if math.isfinite(value)]
    if not finite:
        return Fragment("")
    low, high = min(finite), max(finite)
    begin, span = x[0], (x[-1] - x[0]) or 1.0
    # Constant signals are in the middle; rounding errors of 1e-12 are not drawn as noise.
    flat = high - low <= 1e-12 * max(abs(low), abs(high))

    def place(t: float, value: float) -> str:
        share = 0.5 if flat else value / (high - low) - low / (high - low)
        return f"{2 + (t - begin) / span * (width - 4):.1f},{height - 3 - share * (height - 6):.1f}"

    runs: list[list[str]] = [[]]
    for t, value in zip(x, y, strict=True):
        if math.isfinite(value):
            runs[-1].append(place(t, value))
        elif runs[-1]:
            runs.append([])
    lines = "".join(
        f'<polyline points="{" ".join(run if len(run) > 1 else run * 2)}"/>' for run in runs if run
    )
    return Fragment(
        f'<svg width="{width}" height="{height}" viewBox="0 0 {width} {height}" fill="none" '
        f'stroke="currentColor" stroke-width="1.2" stroke-linecap="round" role="img">{lines}</svg>'
    )
