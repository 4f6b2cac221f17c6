# SPDX-License-Identifier: BSD-3-Clause
"""The tables of elements in docs/scene-format.md; `python tests/element_tables.py` writes them anew."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from gelenk import _core

DOC = Path(__file__).parent.parent / "docs" / "scene-format.md"
SECTIONS = ("motors", "forces", "constraints", "contacts", "sensors", "components")
HEAD = "| type | key | description | unit | default | remark |\n|---|---|---|---|---|---|\n"


def begin(section: str) -> str:
    return f"<!-- {section}: made from the registry by tests/element_tables.py -->\n"


def end(section: str) -> str:
    return f"<!-- end of {section} -->\n"


def table(section: str) -> str:
    """Each kind of a section: its keys with their units and defaults, and its outputs."""
    lines: list[Sequence[str]] = []
    for kind in _core.elements.kinds()[section]:
        lines.append((f"**`{kind['name']}`**", "", kind["summary"], "", "", ""))
        lines += [("", *cells) for port in kind["ports"] for cells in _port(port)]
        lines += [("", *cells) for cells in _fields(kind["fields"], "")]
        lines += [("", *_output(group)) for group in kind["outputs"]]
    return HEAD + "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def parts(text: str, section: str) -> tuple[str, str, str]:
    """What stands before, in and after a section's table of the page."""
    before, rest = text.split(begin(section))
    inside, after = rest.split(end(section))
    return before + begin(section), inside, end(section) + after


def unit(units: Sequence[str]) -> str:
    """As people write it: `N m/rad`; about an angle or a length: `N m (N)`."""
    first, *others = ["" if u == "1" else re.sub(r"\b\.\b", " ", u) for u in dict.fromkeys(units)]
    return first + "".join(f" ({u})" for u in others)


def _unit(field: dict[str, Any]) -> str:
    """Of lists by powers of time that of each place: `rad, rad/s, ...`."""
    units = field["units"]
    return unit([f"{u}, {u}/s, ..." for u in units] if field["by_time"] else units)


def default(field: dict[str, Any]) -> str:
    """What a field is where it is not given."""
    if field["required"]:
        return "required"
    if field["alternative"]:
        return "alternative"
    value = field["default"]
    if field["type"] == "choice":
        return f"`{field['words'][value]}`"
    if value in (None, "") or value != value:
        return "none"
    if isinstance(value, list):
        return f"`[{', '.join(f'{x:g}' for x in value)}]`"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"{value:g}"


def _port(port: dict[str, Any]) -> Iterator[Sequence[str]]:
    text = port["text"][:1].lower() + port["text"][1:]
    if not port["name"]:
        keys = {"frame": "`body`, `position`, `rotation`", "point": "`body`, `position`", "body": "`body`"}
        place = "" if port["kind"] == "body" else "; the body's frame"
        yield keys[port["kind"]], text, "", "required" + place, ""
        return
    missing = {"joint": "none"}.get(port["kind"], "the ground") if port["optional"] else "required"
    told = "" if text.startswith(port["kind"]) else f": a {port['kind']}"
    yield f"`{port['name']}`", text + told, "", missing, ""
    if port["has_coordinate"]:
        yield "`coordinate`", "name of the coordinate", "", "the only one", ""


def _fields(fields: Sequence[dict[str, Any]], within: str) -> Iterator[Sequence[str]]:
    for field in fields:
        name = within + field["name"]
        text = field["text"]
        words = ", ".join(f"`{word}`" for word in field["words"])
        yield (
            f"`{name}`", text + (f": {words}" if words else ""), _unit(field), default(field),
            "tunable" if field["tunable"] else "",
        )  # fmt: skip
        yield from _fields(field["fields"], name + ".")


def _output(group: dict[str, Any]) -> Sequence[str]:
    name = group["name"] + (f"[1..{group['size']}]" if group["is_array"] else "")
    names = ["tau", "f"] if name == "{effort}" else [name]
    shown = " (".join(f"`.{n}`" for n in names) + ")" * (len(names) - 1)
    return shown, group["text"], unit(group["units"]), "", "output"


if __name__ == "__main__":
    page = DOC.read_text(encoding="utf-8")
    for each in SECTIONS:
        head, _, tail = parts(page, each)
        page = head + table(each) + tail
    DOC.write_text(page, encoding="utf-8")
