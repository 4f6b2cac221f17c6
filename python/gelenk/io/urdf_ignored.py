# SPDX-License-Identifier: BSD-3-Clause
"""Contents of a URDF file that its conversion ignores: elements, attributes and text it does not read."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field


@dataclass(frozen=True)
class _Read:
    """What is read of an element, or has a note of its own (shapes, transmissions, limits of velocity)."""

    attributes: frozenset[str] = frozenset()
    children: dict[str, _Read] = field(default_factory=dict)
    repeated: bool = False  # any number of them; otherwise only the first one is read
    whole: bool = False  # with all that it contains


def _read(attributes: str = "", children: dict[str, _Read] | None = None, *, repeated: bool = False) -> _Read:
    return _Read(frozenset(attributes.split()), children or {}, repeated)


_NOTED = _Read(repeated=True, whole=True)
_ORIGIN = _read("xyz rpy")
_INERTIAL = _read(
    "", {"origin": _ORIGIN, "mass": _read("value"), "inertia": _read("ixx iyy izz ixy ixz iyz")}
)
_LINK = _read("name", {"inertial": _INERTIAL, "visual": _NOTED, "collision": _NOTED}, repeated=True)
_JOINT = _read(
    "name type",
    {
        "parent": _read("link"),
        "child": _read("link"),
        "origin": _ORIGIN,
        "axis": _read("xyz"),
        "dynamics": _read("damping friction"),
        "limit": _read("lower upper velocity effort"),
        "mimic": _read("joint multiplier offset"),
    },
    repeated=True,
)
_ROBOT = _read("name version", {"link": _LINK, "joint": _JOINT, "transmission": _NOTED})

# Numbers that mean nothing for a joint of these types, and have no note of their own.
_BOUNDS = (("limit", "lower"), ("limit", "upper"))
_MEANINGLESS = {
    "continuous": _BOUNDS,
    "planar": _BOUNDS,
    "floating": _BOUNDS,
    "fixed": (*_BOUNDS, ("limit", "velocity"), ("limit", "effort"), ("dynamics", "damping"),
              ("dynamics", "friction")),
}  # fmt: skip


@dataclass
class _Place:
    """A kind of ignored content: where it is found, by the names of the links and joints."""

    text: str
    owners: list[str] = field(default_factory=list)
    inside: list[str] = field(default_factory=list)  # elements that an ignored element contains


def ignored(root: ET.Element) -> list[str]:
    """Return a line for each kind of element, attribute and text of a robot that is not converted.

    Args:
        root: the element <robot>.
    """
    places: dict[str, _Place] = {}

    def add(text: str, owner: str, element: ET.Element | None = None) -> None:
        place = places.setdefault(text, _Place(text))
        place.owners.append(owner)
        place.inside += [_label(e) for e in (() if element is None else element)]

    def visit(element: ET.Element, known: _Read, path: str, owner: str) -> None:
        for name in element.attrib:
            if name not in known.attributes:
                add(f"attribute {name} of {path}", owner)
        texts = [element.text, *(child.tail for child in element)]
        if any(text and text.strip() for text in texts):
            add(f"text in {path}", owner)
        seen: set[str] = set()
        for child in element:
            inner = f"{path}<{child.tag}>" if path != "<robot>" else f"<{child.tag}>"
            of = known.children.get(str(child.tag))
            within = _owner(child) or owner
            if of is None:
                add(inner, _owner(child) if owner == "" else owner, child)
            elif child.tag in seen and not of.repeated:
                add(f"second {inner}", within, child)
            elif not of.whole:
                visit(child, of, inner, within)
            seen.add(str(child.tag))

    visit(root, _ROBOT, "<robot>", "")
    for joint in root.findall("joint"):
        for tag, name in _MEANINGLESS.get(joint.get("type") or "", ()):
            element = joint.find(tag)
            if element is not None and _is_not_zero(element.get(name)):
                add(f"attribute {name} of <joint><{tag}> of a {joint.get('type')} joint", _owner(joint))
    return [_line(place) for place in places.values()]


def _is_not_zero(text: str | None) -> bool:
    try:
        return float(text or 0.0) != 0.0
    except ValueError:
        return True


def _owner(element: ET.Element) -> str:
    return element.get("name") or element.get("reference") or ""


def _label(element: ET.Element) -> str:
    name = element.get("name")
    return f"<{element.tag}> {name}" if name else f"<{element.tag}>"


def _line(place: _Place) -> str:
    count = len(place.owners)
    times = f" ({count} times)" if count > 1 else ""
    where = _listed(": ", [name for name in place.owners if name])
    return f"{place.text} is not converted{times}{where}{_listed('; it contained ', place.inside)}"


def _listed(before: str, names: list[str]) -> str:
    return before + ", ".join(dict.fromkeys(names)) if names else ""
