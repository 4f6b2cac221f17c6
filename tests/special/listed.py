# SPDX-License-Identifier: BSD-3-Clause
"""Shipped scenes, benchmark families and scenes of other tests, each started at special positions."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import mechanisms
import scene_files
from benchmarks.speed.families import MAKERS
from benchmarks.speed.tree import to_scene
from mechanisms import Scene, rotation
from models import reducible

import gelenk
from gelenk.chart import mechanisms as charted

from .drawn import Case, at_rest

QUARTERS = {"0": 0.0, "90": math.pi / 2, "180": math.pi, "-90": -math.pi / 2}
FAMILIES: dict[str, Callable[[], Scene]] = {
    "windows 1": lambda: charted.four_bar_chain(1, 0.3),
    "windows 3": lambda: charted.four_bar_chain(3, 0.3, 0.0),
    "parallelogram": lambda: charted.parallelogram(0.7, 2.0),
    "equal slider-crank": lambda: charted.equal_slider_crank(0.7, 1.0),
    "bricard": charted.bricard,
    "governor": charted.governor,
    "blocked crank": charted.blocked_crank,
    "uneven four-bar": lambda: charted.uneven_four_bar(10.0),
    "light cart-pole": charted.light_cart_pole,
    "tilted four-bar": reducible.tilted_four_bar,
    "ball four-bar": reducible.ball_four_bar,
    "triple crank": lambda: reducible.triple_crank(True),
    "door": reducible.door,
    "guided": reducible.guided,
    "triangle": reducible.triangle,
    "tripod on universal joints": lambda: reducible.tripod("universal"),
    "tripod on balls": lambda: reducible.tripod("spherical"),
    "welded chain": lambda: reducible.welded_chain(4),
    "two mechanisms": reducible.two_mechanisms,
    "platform on balls": reducible.platform_on_balls,
    "four-bar": lambda: mechanisms.four_bar(1.1),
    "four-bar, rocker driven": lambda: mechanisms.four_bar(1.1, (1.5, 1.75, 0.5, 2.0)),
    "double rocker": lambda: mechanisms.four_bar(1.1, (1.5, 0.5, 1.75, 2.0)),
    "drag link": lambda: mechanisms.four_bar(1.1, (1.5, 1.75, 2.0, 0.5)),
    "rhombus": lambda: mechanisms.four_bar(1.1, (1.0, 1.0, 1.0, 1.0)),
    **{
        f"speed: {name}": lambda name=name: to_scene(MAKERS[name]())  # type: ignore[misc]
        for name in ("fourbar", "slidercrank", "stewart", "bricard", "governor", "andrews", "chain_p_4",
                     "chain_s_4", "nfourbar_2", "nfourbar_5")
    },
}  # fmt: skip


def families() -> Iterator[tuple[str, Scene]]:
    for path in scene_files.good():
        yield path.stem, gelenk.load(path).to_dict()
    for name, make in FAMILIES.items():
        yield name, gelenk.load(make()).to_dict()


def listed() -> list[Case]:
    """Return all of them."""
    return [case for name, source in families() for case in starts(name, source)]


def starts(name: str, source: Scene) -> Iterator[Case]:
    """As given; driven angles at right angles, one at a time and all; at rest, without gravity; tilted."""
    yield Case(name, source)
    for choice in choices(source):
        words = ", ".join(f"{joint} at {math.degrees(x):.0f}°" for joint, x in choice.items())
        moved = started(source, choice)
        yield Case(f"{name}: {words}", moved)
        yield Case(f"{name}: {words}, at rest", at_rest(moved))
        yield Case(f"{name}: {words}, at rest without gravity", {**at_rest(moved), "gravity": [0, 0, 0]})
        if "constraints" not in source:
            R = rotation([0.3, -0.7, 0.5], 1.3)
            yield Case(f"{name}: {words}, tilted", mechanisms.placed(moved, R, (0.3, -0.2, 0.7)))


def choices(source: Scene) -> list[Mapping[str, float]]:
    """Angles of the drivers of the mechanism: one after the other at right angles, and all of them."""
    drivers = [
        joint
        for joint, entry in source["joints"].items()
        if entry["type"] == "revolute" and entry.get("start", {}).get("fixed")
    ]
    drivers = drivers or [joint for joint, e in source["joints"].items() if e["type"] == "revolute"][:1]
    out: list[Mapping[str, float]] = [{d: x} for d in drivers for x in QUARTERS.values()]
    if len(drivers) > 1:
        out += [dict.fromkeys(drivers, x) for x in QUARTERS.values()]
    return out


def started(source: Scene, angles: Mapping[str, float]) -> Scene:
    """The scene with these angles fixed and other coordinates as guesses."""
    out = copy.deepcopy(source)
    for joint, x in angles.items():
        start: dict[str, Any] = out["joints"][joint].setdefault("start", {})
        fixed = start.get("fixed")
        start["phi"] = x
        start["fixed"] = ["phi"] if not isinstance(fixed, list) else sorted({*fixed, "phi"})
        if fixed is True and "w" in start:
            start["fixed"] = ["phi", "w"]
    return out
