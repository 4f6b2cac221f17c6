# SPDX-License-Identifier: BSD-3-Clause
"""Cases in which laws of joints and of contacts act on the same bodies, for `both_schemes`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from .both_schemes import Case
from .contact_law_cases import QUARTER_TURN, SHAPES, G, contact_case
from .touching import SceneData, inertia_of_box

RADIUS = 0.1  # m, of all wheels and balls
ALONG, UP, ACROSS = [1, 0, 0], [0, 0, 1], [0, 1, 0]


def guided(child: str, axis: list[int], parent: Any = "ground", **fields: Any) -> SceneData:
    """A guide that starts at s = 0."""
    start = {"s": 0.0, "fixed": True, **fields.pop("start", {})}
    return {"type": "prismatic", "parent": parent, "child": child, "axis": axis, "start": start, **fields}


def ball(mass: float, surface: str) -> SceneData:
    return {
        "mass": mass,
        "inertia": [0.4 * mass * RADIUS**2] * 3,
        "shapes": {"ball": {"sphere": RADIUS, "surface": surface}},
    }


def touching(bodies: SceneData, joints: SceneData, contacts: SceneData, **fields: Any) -> SceneData:
    """A scene with gravity and a floor."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": bodies,
        "joints": joints,
        "ground": {"shapes": {"plane": {"plane": UP, "surface": "floor"}}},
        "contacts": contacts,
        "experiment": {"step": 1e-3},
        **fields,
    }


def car(speed: float, friction: float, hub: SceneData, *, shaft: bool = False) -> SceneData:
    """A load that slides along x and z on one wheel, which its hub drives and brakes.

    shaft: whether a shaft with a motor is between the load and the hub; the motor is on the hub otherwise.
    """
    turning = {"type": "revolute", "axis": ACROSS, "child": "wheel"}
    bodies = {
        "sled": {"mass": 0.5, "inertia": [0.01] * 3},
        "load": {"mass": 3.0, "inertia": [0.05] * 3},
        "wheel": {
            "mass": 1.0,
            "inertia": [0.003, 0.005, 0.003],
            "shapes": {"tire": {**SHAPES["wheel"][0], "surface": "rubber"}},
        },
    }
    joints = {
        "X": guided("sled", ALONG, {"body": "ground", "position": [0, 0, RADIUS]}, start={"v": speed}),
        "Z": guided("load", UP, "sled"),
    }
    spin = {"start": {"phi": 0.0, "w": speed / RADIUS, "fixed": True}}
    if shaft:
        bodies["shaft"] = {"mass": 0.2, "inertia": [0.002] * 3}
        joints["shaft"] = {**turning, "parent": "load", "child": "shaft", **spin}
        spin = {"start": {"phi": 0.0, "w": 0.0, "fixed": True}}
    joints["hub"] = {**turning, "parent": "shaft" if shaft else "load", **spin, **hub}
    motor = "shaft" if shaft else "hub"
    contacts = {"tire": {"between": ["rubber", "floor"], "friction": friction, "static": 1.2 * friction}}
    return touching(bodies, joints, contacts, motors={"push": {"joint": "X"}, "motor": {"joint": motor}})


def at(t: float, values: tuple[float, ...], width: float = 0.2) -> float:
    """One of the values after the other, each for a time [s]; the last one for ever."""
    return values[min(len(values) - 1, int(t / width))]


# A wheel bears four times the weight of the bodies of the other cases: so much more are accelerations off in
# steps, see SMALL.
ERROR = 0.03


def braked_wheel() -> Case:
    """It rolls, is locked by its brake and skids, is let go and rolls again, and is held by its brake."""
    source = car(2.0, 0.3, {"friction": {"coulomb": 3.0, "static": 4.0, "input": "engagement"}})
    return contact_case(
        source,
        0.9,
        error=ERROR,
        inputs={
            "hub.friction.engagement": lambda t: at(t, (0.1, 1.0, 0.0, 1.0)),
            "push.f": lambda t: at(t, (0.0, 0.0, 5.0, 0.0)),
        },
    )


def driven_wheel() -> Case:
    """A motor lets it slip on the ground, is let go, is overrun, and slips again."""
    source = car(0.5, 0.3, {"one_way": {"free": "positive"}}, shaft=True)
    torque = (1.0, 2.5, -1.5, 0.4, 3.0)
    return contact_case(source, 0.9, error=ERROR, inputs={"motor.tau": lambda t: at(t, torque)})


def loaded_axle() -> Case:
    """A wheel turns in a bearing that carries the load; brakes so hard that it skids, and rolls again."""
    bearing = {"coefficient": 0.15, "static": 0.2, "radius": 0.03}
    source = car(1.0, 0.3, {"friction": {"coulomb": 0.05, "bearing": bearing}})
    return contact_case(
        source,
        0.9,
        error=ERROR,
        inputs={
            "motor.tau": lambda t: at(t, (0.5, -2.5, 0.0, 1.0)),
            "push.f": lambda t: at(t, (0.0, 3.0, -2.0)),
        },
    )


def box_on_a_cart(friction: SceneData | None = None) -> Case:
    """A cart with dry friction in its guide; a box on it slides, sticks, and slides the other way."""
    bodies = {
        "cart": {
            "mass": 3.0,
            "inertia": [0.1] * 3,
            "shapes": {"top": {"box": [2, 1, 0.1], "position": [0, 0, 0.25], "surface": "steel"}},
        },
        "box": {
            "mass": 1.0,
            "inertia": inertia_of_box(1.0, [0.2] * 3),
            "shapes": {"hull": {"box": [0.2] * 3, "surface": "wood"}},
        },
    }
    start = {"r": [0, 0, 0.4], "v": [0.4, 0, 0], "fixed": True}
    joints = {
        "P": guided("cart", ALONG, friction=friction or {"coulomb": 4.0, "static": 6.0}),
        "J": {"type": "free", "parent": "ground", "child": "box", "start": start},
    }
    contacts = {"top": {"between": ["wood", "steel"], "friction": 0.2, "static": 0.3}}
    source = touching(bodies, joints, contacts, motors={"push": {"joint": "P"}})
    return contact_case(source, 0.9, inputs={"push.f": lambda t: at(t, (3.0, 20.0, 0.0, -9.0))})


def buffers(bound: float, restitution: float, limit: float, law: str = "newton") -> Case:
    """A ball on a guide strikes another one, which a limit stops; a motor presses them together."""
    bodies = {"first": ball(1.0, "first"), "second": ball(2.0, "second")}
    joints = {
        "A": guided("first", ALONG, {"body": "ground", "position": [-0.3, 0, 1]}, start={"v": 1.3}),
        "B": guided(
            "second",
            ALONG,
            {"body": "ground", "position": [0, 0, 1]},
            limit={"upper": bound, "restitution": limit, "law": law},
            friction={"coulomb": 0.8},
        ),
    }
    contacts = {"hit": {"between": ["first", "second"], "restitution": restitution}}
    source = touching(bodies, joints, contacts, motors={"push": {"joint": "A"}})
    return contact_case(source, 0.4, inputs={"push.f": lambda _: 1.7})


def landing(left: float, right: float) -> Case:
    """Two feet of one body, level, land at once on surfaces of unlike restitution."""
    feet = {
        name: {"sphere": RADIUS, "position": [x, 0, 0], "surface": name}
        for name, x in (("left", -0.2), ("right", 0.2))
    }
    bodies = {"body": {"mass": 1.0, "inertia": [0.01, 0.05, 0.05], "shapes": feet}}
    upright = {"rotation": QUARTER_TURN}
    start = {"s_x": 0.0, "s_y": 0.0, "phi": 0.0, "fixed": True}
    plane = {
        "type": "planar",
        "parent": {"body": "ground", "position": [0, 0, 0.211], **upright},
        "child": {"body": "body", **upright},
        "start": start,
    }
    contacts = {
        name: {"between": [name, "floor"], "friction": 0.3, "restitution": e}
        for name, e in (("left", left), ("right", right))
    }
    # It bounces twice until then.
    return contact_case(touching(bodies, {"J": plane}, contacts), 0.2)


def landing_at_a_limit(restitution: float, limit: float) -> Case:
    """A ball on a guide meets the floor and a limit of the guide at the same place."""
    law = {"lower": -0.111, "restitution": limit}
    guide = guided("ball", UP, {"body": "ground", "position": [0, 0, 0.111 + RADIUS]}, limit=law)
    contacts = {"floor": {"between": ["ball", "floor"], "restitution": restitution}}
    return contact_case(touching({"ball": ball(1.0, "ball")}, {"J": guide}, contacts), 0.3)


CASES: dict[str, Callable[[], Case]] = {
    "brake of a wheel on the ground": braked_wheel,
    "one-way clutch that drives a wheel on the ground": driven_wheel,
    "friction of a guide beside a box that slides": box_on_a_cart,
    "friction of a guide under a box that slides": lambda: box_on_a_cart(
        {"coulomb": 0.5, "bearing": {"coefficient": 0.1, "static": 0.15}}
    ),
    "bearing of a wheel on the ground": loaded_axle,
    "unlike restitutions of two feet": lambda: landing(0.8, 0.2),
    "unlike restitutions of two feet, the other way": lambda: landing(0.2, 0.9),
    "like restitutions of two feet": lambda: landing(0.5, 0.5),
    "floor and limit, which throws less far": lambda: landing_at_a_limit(0.7, 0.2),
    "floor and limit, which throws farther": lambda: landing_at_a_limit(0.2, 0.7),
    "floor that does not throw, and limit": lambda: landing_at_a_limit(0.0, 0.5),
}
for _bound in (0.0, 0.05, 0.0333):
    for _e, _limit in ((0.0, 0.0), (0.0, 0.5), (0.6, 0.0), (0.6, 0.5)):
        CASES[f"limit at {_bound} m struck through a contact, {_e} and {_limit}"] = partial(
            buffers, _bound, _e, _limit
        )
    for _e in (0.0, 0.6):
        CASES[f"limit at {_bound} m struck through a contact, {_e} and 0.5 by Poisson's law"] = partial(
            buffers, _bound, _e, 0.5, "poisson"
        )
