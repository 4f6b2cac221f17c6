# SPDX-License-Identifier: BSD-3-Clause
"""A scene of many parts that nothing couples, of six kinds: all that one part could do to another.

Start values are guesses, so that loops have to be closed; there are rods without mass and trusses, for which
parts are assembled twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, rod, scene

Part = dict[str, Any]
ABOUT_Y: dict[str, Any] = {"axis": [0, 1, 0]}


def _place(k: int) -> tuple[float, float, float]:
    return (3.0 * (k % 20), 2.5 * (k // 20), 0.1 * (k % 3))


def _four_bar(n: str, k: int) -> Part:
    """With a motor."""
    made = four_bar(0.7 + 0.003 * k)
    made["joints"]["A"]["start"] = {"phi": 0.75, "w": 0.7}
    bodies = {f"{n}_{name}": entry for name, entry in made["bodies"].items()}
    joints = {}
    for name, entry in made["joints"].items():
        ends = {
            end: entry[end] | {"body": b if (b := entry[end]["body"]) == "ground" else f"{n}_{b}"}
            for end in ("parent", "child")
        }
        joints[f"{n}_{name}"] = entry | ends
    return {"bodies": bodies, "joints": joints, "motors": {f"{n}_drive": {"joint": f"{n}_A"}}}


def _stopped(n: str, k: int) -> Part:
    """A pendulum that falls on a stop, standing on a block welded to the ground."""
    x, y, z = _place(k)
    stop = {"lower": -0.9, "stiffness": 800.0, "damping": 2.0}
    return {
        "bodies": {f"{n}_block": body(5.0), f"{n}_bob": body(0.4, (0, 0, -0.3), (0.01, 0.012, 0.003))},
        "joints": {
            f"{n}_W": joint("weld", frame("ground", (x, y, z)), frame(f"{n}_block", (0, 0, -0.2))),
            f"{n}_A": joint(
                "revolute",
                frame(f"{n}_block", (0, 0, 0.1)),
                frame(f"{n}_bob"),
                **ABOUT_Y,
                start={"phi": 1.2 + 0.001 * k},
                stop=stop,
            ),
        },
        "sensors": {f"{n}_tip": {"type": "frame", "body": f"{n}_bob", "position": [0, 0, -0.5]}},
    }


def _slider_crank(n: str, k: int) -> Part:
    """Driven by a given motion; its connecting rod has no mass and becomes a distance."""
    crank, length = 0.2, 0.7
    phi = 0.4
    slide = crank * math.cos(phi) + math.sqrt(length**2 - (crank * math.sin(phi)) ** 2)
    return {
        "bodies": {f"{n}_crank": rod(1.1, crank), f"{n}_rod": body(0.0), f"{n}_slider": body(0.6 + 0.01 * k)},
        "joints": {
            f"{n}_A": joint(
                "revolute", frame("ground"), frame(f"{n}_crank"), axis=[0, 0, 1], start={"phi": phi}
            ),
            f"{n}_B": joint(
                "revolute", frame(f"{n}_crank", (crank, 0, 0)), frame(f"{n}_rod"), axis=[0, 0, 1]
            ),
            f"{n}_C": joint(
                "revolute", frame(f"{n}_rod", (length, 0, 0)), frame(f"{n}_slider"), axis=[0, 0, 1]
            ),
            f"{n}_S": joint(
                "prismatic",
                frame("ground"),
                frame(f"{n}_slider"),
                axis=[1, 0, 0],
                start={"s": slide + 0.02},
                stiffness=40.0,
                spring_reference=slide,
                damping=0.5,
            ),
        },
        "constraints": {
            f"{n}_turn": {
                "type": "motion",
                "joint": f"{n}_A",
                "polynomial": [phi, 2.0 + 0.01 * k],
                "sine": {"amplitude": 0.1, "frequency": 1.3},
            }
        },
    }


def _gears(n: str, k: int) -> Part:
    """A motor, two wheels, and the reaction at one of them."""
    wheel = (0.02, 0.02, 0.04)
    return {
        "bodies": {
            f"{n}_pinion": body(1.0, (0.01, 0, 0), wheel),
            f"{n}_wheel": body(2.0, (0, 0.03, 0), wheel),
        },
        "joints": {
            f"{n}_P": joint("revolute", frame("ground", _place(k)), frame(f"{n}_pinion"), axis=[0, 0, 1]),
            f"{n}_Q": joint(
                "revolute",
                frame("ground", (9, 9, 9)),
                frame(f"{n}_wheel"),
                axis=[0, 0, 1],
                damping=0.05,
                stiffness=3.0 + 0.1 * k,
            ),
        },
        "motors": {f"{n}_drive": {"joint": f"{n}_P", "gear_ratio": 3.0, "rotor_inertia": 1e-4}},
        "constraints": {f"{n}_mesh": {"type": "gear", "joint": f"{n}_P", "with": f"{n}_Q", "ratio": -2.5}},
        "sensors": {f"{n}_load": {"type": "reaction", "joint": f"{n}_P"}},
    }


def _free(n: str, k: int) -> Part:
    """A tumbling body, its quaternion among the states, with a load from outside."""
    return {
        "bodies": {f"{n}_top": body(0.8, (0.01, 0.02, 0.0), (0.02, 0.03, 0.045))},
        "joints": {
            f"{n}_F": joint(
                "free",
                frame("ground", _place(k)),
                frame(f"{n}_top"),
                start={"w": [0.3, 2.0, 0.1 + 0.01 * k], "v": [0.1, 0.0, 1.0]},
            )
        },
        "forces": {f"{n}_push": {"type": "wrench", "body": f"{n}_top", "input": True}},
    }


def _sprung(n: str, k: int) -> Part:
    """Two trees that a spring joins, beside a truss whose bars loops hold still."""
    x, y, z = _place(k)
    third = (0.4, 0.3)
    bodies = {f"{n}_left": rod(0.5, 0.6), f"{n}_right": rod(0.7, 0.5)}
    joints = {
        f"{n}_L": joint(
            "revolute", frame("ground", (x, y, z)), frame(f"{n}_left"), **ABOUT_Y, start={"phi": 0.3}
        ),
        f"{n}_R": joint(
            "universal",
            frame("ground", (x + 1, y, z)),
            frame(f"{n}_right"),
            axes=[[0, 1, 0], [0, 0, 1]],
            start={"phi_a": 1.0 + 0.002 * k},
        ),
    }
    if k % 12 == 5:
        bars = {"m": math.hypot(*third), "o": math.hypot(1 - third[0], third[1])}
        bodies |= {f"{n}_{bar}": rod(1.0, length) for bar, length in bars.items()}
        hinge = {"axis": [0, 0, 1]}
        joints |= {
            f"{n}_T": joint(
                "revolute",
                frame("ground"),
                frame(f"{n}_m"),
                **hinge,
                start={"phi": math.atan2(third[1], third[0]) + 0.02},
            ),
            f"{n}_U": joint(
                "revolute",
                frame("ground", (1, 0, 0)),
                frame(f"{n}_o"),
                **hinge,
                start={"phi": math.pi - math.atan2(third[1], 1 - third[0])},
            ),
            f"{n}_V": joint(
                "revolute", frame(f"{n}_m", (bars["m"], 0, 0)), frame(f"{n}_o", (bars["o"], 0, 0)), **hinge
            ),
        }
    spring = {
        "type": "spring_damper",
        "stiffness": 60.0,
        "damping": 0.2,
        "length": 0.7,
        "from": frame(f"{n}_left", (0.5, 0, 0)),
        "to": frame(f"{n}_right", (0.4, 0, 0)),
    }
    return {"bodies": bodies, "joints": joints, "forces": {f"{n}_spring": spring}}


KINDS: tuple[Callable[[str, int], Part], ...] = (_four_bar, _stopped, _slider_crank, _gears, _free, _sprung)


def island(k: int) -> Part:
    """The k-th one: its names begin with `i<k>_`."""
    return KINDS[k % len(KINDS)](f"i{k}", k)


def many_islands(count: int, only: int | None = None, **fields: Any) -> Scene:
    """The first `count` ones, or one of them alone."""
    sections: dict[str, dict[str, Any]] = {}
    for k in range(count) if only is None else (only,):
        for name, entries in island(k).items():
            sections.setdefault(name, {}).update(entries)
    out: Mapping[str, Any] = scene(sections.pop("bodies"), sections.pop("joints"), gravity=[0, 0, -GRAVITY])
    return {**out, **sections, "experiment": {"stop": 0.2, "step": 0.01}, **fields}
