# SPDX-License-Identifier: BSD-3-Clause
"""Cases of the laws along joint coordinates, for `both_schemes`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from mechanisms import body, four_bar, frame, joint, scene

from .both_schemes import Case


def block(motor: Callable[[float], float], v: float = 0.0, s: float = 0.0, **laws: Any) -> Case:
    """A block on a guide, pushed by a motor."""
    guide = joint(
        "prismatic",
        frame("ground"),
        frame("block"),
        axis=[1, 0, 0],
        start={"s": s, "v": v, "fixed": True},
        **laws,
    )
    source = scene({"block": body(1.3)}, {"J": guide})
    source["motors"] = {"push": {"joint": "J"}}
    return Case(source, 1.0, {"push.f": motor})


def pulses(t: float) -> float:
    """Held by static friction, broken away, let go, pushed back."""
    return (0.6, 0.6, 1.4, 0.3, -1.5)[min(4, int(t / 0.22))]


def stribeck(exponent: int) -> Case:
    law = {"coulomb": 0.4, "static": 1.0, "stribeck": 0.3, "exponent": exponent}
    return block(pulses, v=0.21, friction=law)


def braked() -> Case:
    """A brake that slips, is let go, holds, and is released."""
    case = block(lambda _: 1.1, v=0.35, friction={"coulomb": 3.0, "input": "engagement"})
    engaged = {"J.friction.engagement": lambda t: (0.5, 0.1, 1.0, 0.0)[min(3, int(t / 0.26))]}
    return replace(case, inputs={**case.inputs, **engaged})


def locked() -> Case:
    """A block that a lock holds, lets go, and stops in motion."""
    case = block(pulses, v=0.0, lock={"input": "engagement", "engaged": True})
    engaged = {"J.lock.engagement": lambda t: 0.0 if 0.13 <= t < 0.63 else 1.0}
    return replace(case, inputs={**case.inputs, **engaged})


def chain(
    law: str, restitutions: tuple[float, ...], speeds: tuple[float, ...], bounds: tuple[float, ...]
) -> Case:
    """Blocks in line, each with an upper limit against the one before; no forces."""
    names = [f"b{i}" for i in range(len(bounds))]
    joints = {}
    for i, name in enumerate(names):
        limit = {"upper": bounds[i], "restitution": restitutions[i], "law": law}
        parent = frame(names[i - 1]) if i > 0 else frame("ground")
        joints[f"J{i}"] = joint(
            "prismatic",
            parent,
            frame(name),
            axis=[1, 0, 0],
            limit=limit,
            start={"s": 0.0, "v": speeds[i], "fixed": True},
        )
    source = scene({name: body(1.0 + 0.7 * i) for i, name in enumerate(names)}, joints)
    return Case(source, 0.3, {})


def turned_disc(sign: int = 1, **laws: Any) -> Case:
    """A disc that a motor brakes, turns forward and turns back; sign -1: the other way round."""
    hub = joint(
        "revolute",
        frame("ground"),
        frame("disc"),
        axis=[0, 0, 1],
        start={"phi": 0.0, "w": sign * 0.8, "fixed": True},
        **laws,
    )
    source = scene({"disc": body(1.0, [0.2, 0.2, 0.3])}, {"J": hub})
    source["motors"] = {"turn": {"joint": "J"}}
    return Case(source, 1.0, {"turn.tau": lambda t: sign * (-0.9, 0.5, -0.3)[min(2, int(t / 0.37))]})


def clutch() -> Case:
    """Two discs on one shaft: the joint between them is a clutch."""
    start = {"fixed": True, "phi": 0.0}
    source = scene(
        {"a": body(1.0, [0.2, 0.2, 0.3]), "b": body(1.0, [0.2, 0.2, 0.5])},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 0, 1], start={**start, "w": 5.0}),
            "B": joint(
                "revolute",
                frame("a"),
                frame("b"),
                axis=[0, 0, 1],
                start={**start, "w": -4.0},
                friction={"coulomb": 4.0, "static": 6.0, "input": "engagement"},
            ),
        },
    )
    source["motors"] = {"drive": {"joint": "A"}}
    engaged = [0.0, 0.5, 1.0, 0.25]
    return Case(
        source,
        1.2,
        {
            "B.friction.engagement": lambda t: engaged[min(3, int(t / 0.28))],
            "drive.tau": lambda t: 2.0 if t < 0.7 else 9.0,
        },
    )


def loop(bearing: dict[str, Any] | None = None, law: str | None = None, **fields: Any) -> Case:
    """A four-bar with dry friction in all joints, whose crank is driven and brakes; law: of joint C."""
    source = four_bar(damping=0.0)
    for name, coulomb in zip("ABCD", (0.4, 0.3, 0.5, 0.2), strict=True):
        source["joints"][name]["friction"] = {"coulomb": coulomb}
        if bearing is not None:
            source["joints"][name]["friction"]["bearing"] = bearing
    if law is not None:
        source["joints"]["C"]["friction"] = {"law": law}
    source["joints"]["A"]["start"]["w"] = 4.0
    return Case({**source, **fields}, 0.5, {"drive.tau": lambda t: 9.0 if t < 0.2 else 4.0})


def between_stops(**law: Any) -> Case:
    """A block that two stops throw back, the second of which it then rests on."""
    stop = {"lower": -0.17, "upper": 0.11, "stiffness": 400.0, **law}
    return block(lambda t: 0.3 if t < 0.5 else -2.0, v=1.2, stop=stop)


def geared(ratio: float = 3.0, **losses: Any) -> Case:
    """A motor drives a disc by a gear with losses, is switched off, and brakes it."""
    about = {"axis": [0, 0, 1], "start": {"phi": 0.0, "w": 0.0, "fixed": True}}
    source = scene(
        {"pinion": body(1.0, [0.1, 0.1, 0.02]), "wheel": body(1.0, [0.2, 0.2, 0.3])},
        {
            "A": joint("revolute", frame("ground"), frame("pinion"), friction={"coulomb": 0.02}, **about),
            "B": joint("revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1], damping=0.1),
        },
    )
    source["constraints"] = {"mesh": {"type": "gear", "joint": "A", "with": "B", "ratio": ratio, **losses}}
    source["motors"] = {"drive": {"joint": "A"}, "load": {"joint": "B"}}
    inputs = {
        "drive.tau": lambda t: (0.4, 0.05, -0.3)[min(2, int(t / 0.35))],
        "load.tau": lambda t: -0.5 if t < 0.6 else 0.2,
    }
    return Case(source, 1.0, inputs)


CASES: dict[str, Callable[[], Case]] = {
    "friction": lambda: block(pulses, v=0.21, friction={"coulomb": 0.5}),
    "static friction": lambda: block(pulses, v=0.21, friction={"coulomb": 0.5, "static": 1.1}),
    "more than static friction turns back": lambda: block(
        lambda _: -1.3, v=0.77, friction={"coulomb": 0.5, "static": 1.1}
    ),
    "Stribeck's curve": lambda: stribeck(2),
    "Stribeck's curve, exponent 1": lambda: stribeck(1),
    "a law of the speed": lambda: block(pulses, v=0.21, friction={"law": "0.4 + 0.6*exp(-v/0.3)"}),
    "a law that jumps as it slips": lambda: block(
        pulses, v=0.21, friction={"law": "0.4 + 0.2*v", "peak": 2.0}
    ),
    "a law of the way": lambda: block(pulses, v=0.21, friction={"law": "0.5 + 2*max(0, s)"}),
    "a law in a loop": lambda: loop(law="0.3 + 0.2*exp(-w)"),
    "brake": braked,
    "lock": locked,
    "clutch": clutch,
    "friction in a loop": loop,
    "friction in a loop, in its plane": lambda: loop(sensors={"E": {"type": "energy"}}),
    "limit": lambda: block(lambda _: 0.7, v=0.3, limit={"upper": 0.11, "lower": -0.2}),
    "lower limit": lambda: block(lambda _: -0.7, v=-0.3, limit={"upper": 0.11, "lower": -0.2}),
    "limit with restitution": lambda: block(
        lambda t: -0.4 if t < 0.6 else 0.5, v=0.9, limit={"upper": 0.11, "lower": -0.17, "restitution": 0.7}
    ),
    "limit with friction": lambda: block(
        lambda t: 1.9 if t < 0.5 else -1.6,
        v=0.9,
        limit={"upper": 0.127, "restitution": 0.5},
        friction={"coulomb": 0.5, "static": 0.8, "stribeck": 0.1},
    ),
    "limit with friction, spring and damper": lambda: block(
        lambda t: 3.9 if t < 0.5 else -1.6,
        v=0.9,
        limit={"upper": 0.127, "restitution": 0.5},
        friction={"coulomb": 0.5},
        damping=0.7,
        stiffness=20.0,
        spring_reference=0.03,
    ),
    "one-way clutch": lambda: turned_disc(one_way={"free": "positive"}),
    "one-way clutch, the other way": lambda: turned_disc(-1, one_way={"free": "negative"}),
    "one-way clutch and friction": lambda: turned_disc(
        one_way={"free": "positive"}, friction={"coulomb": 0.2, "static": 0.4}
    ),
    "one-way clutch of a guide": lambda: block(pulses, v=0.21, one_way={"free": "positive"}),
    "one-way clutch and limits": lambda: turned_disc(
        one_way={"free": "positive"}, limit={"lower": -0.1, "upper": 0.3}
    ),
    "one-way clutch, limits and friction": lambda: turned_disc(
        one_way={"free": "positive"},
        limit={"lower": -0.1, "upper": 0.15, "restitution": 0.4},
        friction={"coulomb": 0.1, "static": 0.2},
    ),
    "friction of a guide under load": lambda: block(
        pulses, v=0.21, friction={"coulomb": 0.1, "bearing": {"coefficient": 0.04, "static": 0.06}}
    ),
    "friction of a bearing under load": lambda: turned_disc(
        friction={"coulomb": 0.0, "bearing": {"coefficient": 0.1, "static": 0.14, "radius": 0.2}}
    ),
    "friction of bearings in a loop": lambda: loop(
        bearing={"coefficient": 0.2, "radius": 0.05, "reaction": "least_norm"}
    ),
    "gear with losses": lambda: geared(efficiency=0.7),
    "gear with losses by its speed": lambda: geared(efficiency="0.8 - 0.3*exp(-w)", backdriving="0.6"),
    "gear with losses, backwards": lambda: geared(ratio=-0.4, efficiency=0.8),
    "stops": between_stops,
    "damped stops": lambda: between_stops(damping=5.0),
    "stops of limited damping": lambda: between_stops(damping=30.0, law="limited"),
}


def stopped(v: float, **law: float) -> Case:
    """A force between sliding and static friction stops the block for good, a larger one turns it back."""
    return block(lambda t: -0.8 if t < 0.8 else -1.3, v=v, friction={"coulomb": 0.5, "static": 1.1, **law})


# The block stops at any place within a step: it loses 1 mm/s in one.
for _v in (0.31, 0.3102, 0.3104, 0.3106, 0.3108):
    CASES[f"static friction stops at {_v}"] = partial(stopped, _v)
    CASES[f"Stribeck's curve stops at {_v}"] = partial(stopped, _v, stribeck=1e-5)


def struck_together(law: str) -> dict[str, Callable[[], Case]]:
    """Limits that are struck at the same instant, at any place within a step."""
    out: dict[str, Callable[[], Case]] = {
        "limits struck together, of unlike speeds": partial(
            chain, law, (0.3, 0.8), (0.8, 0.4), (0.1003, 0.05015)
        ),
        "three limits struck together": partial(
            chain, law, (0.5, 0.0, 0.9), (1.0, 0.5, 0.25), (0.1, 0.05, 0.025)
        ),
        "a limit that rests is struck": partial(chain, law, (0.8, 0.5), (0.0, 1.0), (0.0, 0.1003)),
    }
    for bound in (0.1, 0.10003, 0.10006, 0.1001):
        out[f"two limits struck together at {bound}"] = partial(
            chain, law, (1.0, 0.0), (1.0, 1.0), (bound, bound)
        )
    return out


for _law in ("newton", "poisson"):
    CASES |= {f"{name}, {_law}": case for name, case in struck_together(_law).items()}
