# SPDX-License-Identifier: BSD-3-Clause
"""The table of joints in docs/scene-format.md; `python tests/joint_table.py` writes it anew."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import element_tables

import gelenk
from gelenk import _core
from gelenk.io import export

DOC = Path(__file__).parent.parent / "docs" / "scene-format.md"
BEGIN = "<!-- joints: made from the registry by tests/joint_table.py -->\n"
END = "<!-- end of joints -->"


def table() -> str:
    """One line per kind of joint: what it does, and its states with their units."""
    definitions = json.loads(export.schema())["$defs"]
    lines = ["| type | motion | coordinates | velocities | accelerations |", "|---|---|---|---|---|"]
    for kind in _core.joints.kinds():
        name = kind["name"]
        summary = definitions[f"joint_{name}"]["properties"]["type"]["description"]
        units = _units(name)
        cells = [", ".join(_with_unit(q, units[q]) for q in _short(kind[level], units)) for level in "qva"]
        for number in kind["fields"]:
            unit = element_tables.unit(number["units"])
            summary += f"; {_with_unit(number['name'], unit)}: {number['text']}"
        lines.append(f"| `{name}` | {summary} | " + " | ".join(cell or "none" for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def section(text: str) -> tuple[str, str, str]:
    """What stands before, in and after the generated part of the page."""
    before, rest = text.split(BEGIN)
    inside, after = rest.split(END)
    return before + BEGIN, inside, END + after


def _units(kind: str) -> dict[str, str]:
    """Of the states of a joint of this kind: by name, arrays by `Q[1..4]`."""
    fields = next(each["fields"] for each in _core.joints.kinds() if each["name"] == kind)
    own = {number["name"]: 1 for number in fields if number["required"]}
    data: dict[str, Any] = {
        "gelenk": 1,
        "bodies": {"b": {"mass": 1}},
        "joints": {"A": {"type": kind, "parent": "ground", "child": "b", **own}},
    }
    signals = gelenk.Simulation(data).outputs
    return {s.name.removeprefix("A."): s.unit for s in signals if s.name.startswith("A.")}


def _short(names: list[str], units: dict[str, str]) -> list[str]:
    """Arrays once: Q[1], Q[2], ... is Q[1..4]."""
    out: list[str] = []
    for name in names:
        base, bracket, _ = name.partition("[")
        if not bracket:
            out.append(name)
        elif name.endswith("[1]"):
            count = sum(other.startswith(base + "[") for other in names)
            out.append(f"{base}[1..{count}]")
            units[out[-1]] = units[name]
    return out


def _with_unit(name: str, unit: str) -> str:
    return f"`{name}`" if unit in ("", "1") else f"`{name}` [{unit}]"


if __name__ == "__main__":
    page = DOC.read_text(encoding="utf-8")
    head, _, tail = section(page)
    DOC.write_text(head + table() + tail, encoding="utf-8")
