# SPDX-License-Identifier: BSD-3-Clause
"""Cases of the laws of contacts, on all shapes, for `both_schemes`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import cos, pi, sin
from typing import Any

from .both_schemes import Case
from .touching import SceneData, inertia_of_box, on_plane

G = 9.81  # m/s2
# Speeds of a body of 0.1 m that is as fast as by gravity in 10 ms, and accelerations by its weight: in steps
# of length h at the speed v, they err by those that its weight causes with the lever arm v h / 2.
SMALL = {"m/s": 0.1, "rad/s": 1.0, "m/s2": G, "rad/s2": G / 0.1}
QUARTER_TURN = {"axis": [1, 0, 0], "angle": pi / 2}  # turns z to -y

PUSH = {"type": "wrench", "frame": "world", "body": "body", "position": [0, 0, 0], "input": True}

CUBE = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]  # its corners [m]
# Shapes about the center of mass, which is 0.1 m above a plane on which they rest, and moments [kg m2].
SHAPES: dict[str, tuple[SceneData, list[float]]] = {
    "sphere": ({"sphere": 0.1}, [0.004] * 3),
    "box": ({"box": [0.2, 0.3, 0.2]}, inertia_of_box(1.0, [0.2, 0.3, 0.2])),
    "cylinder": ({"cylinder": {"radius": 0.1, "length": 0.3}, "rotation": QUARTER_TURN}, [0.01, 0.005, 0.01]),
    "capsule": ({"capsule": {"radius": 0.1, "length": 0.2}, "rotation": QUARTER_TURN}, [0.01, 0.005, 0.01]),
    "wheel": ({"wheel": {"radius": 0.1, "crown": 0.03}, "rotation": QUARTER_TURN}, [0.003, 0.005, 0.003]),
    "hull": ({"hull": CUBE}, [0.007] * 3),
}


def contact_case(source: SceneData, stop: float, **fields: Any) -> Case:
    """A case of bodies of 1 kg and 0.1 m."""
    return Case(source, stop, small=SMALL, **fields)


def on_floor(
    shape: str, law: Mapping[str, Any], start: Mapping[str, Sequence[float]] | None = None, **fields: Any
) -> SceneData:
    """A body of 1 kg on the floor, with any of the shapes."""
    shown, inertia = SHAPES[shape]
    scene = on_plane(shown, 1.0, inertia, {"r": [0, 0, 0.1], **(start or {})}, law)
    return {**scene, **fields}


def pushed(law: Mapping[str, Any], pulses: Sequence[float], shape: str = "box") -> Case:
    """A body on the floor that is pushed by a force at the height of its center, in pulses of 0.2 s."""
    scene = on_floor(shape, law, forces={"push": PUSH})
    # Its speed after the last pulse has the errors of all the times at which it stops.
    inputs = {"push.f[1]": lambda t: pulses[min(len(pulses) - 1, int(t / 0.2))]}
    return contact_case(scene, 0.9, inputs=inputs, error=0.03)


def growing() -> Case:
    """A force that grows breaks a box away; by less than 1 % in each communication step."""
    scene = on_floor("box", {"friction": 0.4, "static": 0.5}, forces={"push": PUSH})
    return contact_case(scene, 0.6, inputs={"push.f[1]": lambda t: 4.3 + 1.5 * t})


def lifted(shape: str) -> Case:
    """A sliding body that a force lifts off the floor, and that lands again."""
    scene = on_floor(shape, {"friction": 0.3}, {"v": [0.5, 0, 0]}, forces={"push": PUSH})
    return contact_case(scene, 0.43, inputs={"push.f[3]": lambda t: 14.0 if 0.1 < t < 0.2 else 0.0})


def tipped(friction: float) -> Case:
    """A box that slides while a force above its center tips it."""
    push = {**PUSH, "position": [0, 0, 0.08]}
    scene = on_floor("box", {"friction": friction}, forces={"push": push})
    return contact_case(scene, 0.4, inputs={"push.f[1]": lambda t: 8.0 if t < 0.2 else 0.0})


def inclined(shape: str, law: Mapping[str, Any]) -> Case:
    """A body that starts at rest on a plane that descends along x, by 0.2 rad."""
    scene = on_floor(shape, law, gravity=[G * sin(0.2), 0, -G * cos(0.2)])
    return contact_case(scene, 0.5)


def falling(shape: str, law: Mapping[str, Any], spin: Sequence[float] = (0, 0, 0), stop: float = 0.4) -> Case:
    start = {"r": [0, 0, 0.233], "v": [0.5, 0.2, 0], "w": spin}
    return contact_case(on_floor(shape, law, start), stop)


def colliding(restitution: float, friction: float = 0.0, offset: float = 0.0) -> Case:
    """Two balls of unlike mass in flight, the second one beside the way of the first one."""
    bodies = {
        name: {
            "mass": mass,
            "inertia": [0.4 * mass * 0.1**2] * 3,
            "shapes": {"ball": {"sphere": 0.1, "surface": name}},
        }
        for name, mass in (("a", 1.0), ("b", 1.7))
    }
    starts = {"a": {"r": [-0.2, 0, 0], "v": [1.0, 0, 0]}, "b": {"r": [0.2, offset, 0], "v": [-0.5, 0, 0]}}
    joints = {
        f"J{name}": {"type": "free", "parent": "ground", "child": name, "start": {**start, "fixed": True}}
        for name, start in starts.items()
    }
    law = {"friction": friction, "restitution": restitution}
    contacts = {"hit": {"between": ["a", "b"], **law}}
    return contact_case(
        {"gelenk": 1, "bodies": bodies, "joints": joints, "contacts": contacts, "experiment": {"step": 1e-3}},
        0.5,
    )


def on_a_body(
    shape: str, carrier: SceneData, law: Mapping[str, Any], start: Mapping[str, Sequence[float]], parent: str
) -> SceneData:
    """A body with any of the shapes, on a plate that moves; carrier: its joint; parent: of the free joint."""
    shown, inertia = SHAPES[shape]
    plate = {"box": [3, 3, 0.1], "position": [0, 0, -0.05], "surface": "steel"}
    hull = {**shown, "surface": "wood"}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "plate": {"mass": 5.0, "inertia": [1, 1, 1], "shapes": {"top": plate}},
            "body": {"mass": 1.0, "inertia": list(inertia), "shapes": {"hull": hull}},
        },
        "joints": {
            "A": {"parent": "ground", "child": "plate", **carrier},
            "J": {"type": "free", "parent": parent, "child": "body", "start": {**start, "fixed": True}},
        },
        "motors": {"drive": {"joint": "A"}},
        "contacts": {"top": {"between": ["wood", "steel"], **law}},
        "experiment": {"step": 1e-3},
    }


def turntable(
    speed: float, law: Mapping[str, Any], height: float = 0.1, stop: float = 0.6, *, upright: bool = True
) -> Case:
    """A ball on, or above, a plate that turns; with a velocity of its surface, a belt that turns.

    upright: whether the axes of the shape are those of the world, or y is up.
    """
    start = {"phi": 0.3, "w": speed, "fixed": True}
    carrier = {"type": "revolute", "axis": [0, 0, 1], "start": start, "damping": 0.2}
    source = on_a_body("sphere", carrier, law, {"r": [0.4, 0.1, height]}, "ground")
    if not upright:
        source["bodies"]["plate"]["shapes"]["top"] |= {"box": [3, 0.1, 3], "rotation": QUARTER_TURN}
    # The joint's torque is that of small forces in a scene with large ones, and speeds after an impact are
    # late by up to a step times gravity.
    return contact_case(source, stop, inputs={"drive.tau": lambda _: 1.0}, error=0.04)


def shaken(shape: str, restitution: float = 0.0) -> Case:
    """A body on a cart, on which it has its joint."""
    law = {"friction": 0.3, "adjacent": True, "restitution": restitution}
    carrier = {"type": "prismatic", "axis": [1, 0, 0], "start": {"s": 0.0, "v": 0.5, "fixed": True}}
    start = {"r": [0, 0, 0.1 if restitution == 0 else 0.17], "v": [-0.3, 0.2, 0]}
    source = on_a_body(shape, carrier, law, start, "plate")
    forces = (2.0, 9.0, -9.0, -20.0)
    stop = 0.8 if restitution == 0 else 0.33  # s: before its bounces follow too closely
    return contact_case(source, stop, inputs={"drive.f": lambda t: forces[min(3, int(t / 0.2))]}, error=0.03)


def dropped(upper: str, lower: str, restitution: float) -> Case:
    """A body that falls on another one, which lies on the floor."""
    (above, moments), (below, others) = SHAPES[upper], SHAPES[lower]
    source = on_floor(lower, {"friction": 0.25})
    source["bodies"] = {
        "body": {"mass": 1.0, "inertia": list(others), "shapes": {"hull": {**below, "surface": "wood"}}},
        "second": {"mass": 0.6, "inertia": list(moments), "shapes": {"hull": {**above, "surface": "rubber"}}},
    }
    start = {"r": [0, 0, 0.343], "v": [0.2, 0.05, 0], "fixed": True}
    source["joints"]["K"] = {"type": "free", "parent": "ground", "child": "second", "start": start}
    law = {"friction": 0.3, "restitution": restitution}
    source["contacts"]["on"] = {"between": ["rubber", "wood"], **law}
    # Speeds are late by up to a step times gravity, after one impact and then another one.
    return contact_case(source, 0.25, error=0.04)


SLIDING = {"friction": 0.3}
STICKING = {"friction": 0.4}
BELT = {"friction": 0.2, "velocity": [0.5, 0.0, 0.0]}
BOUNCING = {"friction": 0.3, "restitution": 0.6}
ALL_AT_ONCE = {"friction": 0.2, "static": 0.3, "rolling": 0.003, "spinning": 0.002}

CASES: dict[str, Callable[[], Case]] = {
    "ball that bounces with spin": lambda: falling(
        "sphere", {"friction": 0.3, "restitution": 0.8}, (3, -4, 5)
    ),
    "ball that bounces with spin and sticks": lambda: falling(
        "sphere", {"friction": 0.1, "static": 0.3, "restitution": 0.8}, (3, -4, 5)
    ),
    "ball that lands without friction": lambda: falling("sphere", {"restitution": 0.5}, stop=0.324),
    "two balls collide": lambda: colliding(0.7),
    "two balls collide without losses": lambda: colliding(1.0),
    "two balls collide and stay together": lambda: colliding(0.0),
    "two balls graze each other": lambda: colliding(0.7, friction=0.4, offset=0.07),
    "all kinds of friction on a belt": lambda: contact_case(
        on_floor("sphere", {**ALL_AT_ONCE, "velocity": [0.5, 0.3, 0]}, {"v": [0.2, 0, 0], "w": [0, 0, 4]}),
        0.6,
    ),
    "box on a belt that moves aside": lambda: contact_case(
        on_floor("box", {**BELT, "velocity": [0.5, 0.3, 0]}, {"v": [0.2, 0, 0]}), 0.6
    ),
    "ball on a turntable": lambda: turntable(0.3, SLIDING),
    "ball on a belt that turns": lambda: turntable(2.0, {**SLIDING, "velocity": [0.3, 0.1, 0]}),
    "ball on a belt that turns, its shape on its side": lambda: turntable(
        2.0, {**SLIDING, "velocity": [0.3, 0, -0.1]}, upright=False
    ),
    "ball that falls on a belt that turns": lambda: turntable(
        2.0, {**BOUNCING, "velocity": [0.3, 0.1, 0]}, 0.2, stop=0.5
    ),
    "all kinds of friction on a turntable": lambda: turntable(2.0, ALL_AT_ONCE),
    "ball on a cart": lambda: shaken("sphere"),
    "box on a cart": lambda: shaken("box"),
    "ball that bounces on a cart": lambda: shaken("sphere", 0.5),
    "ball lifted and dropped": lambda: lifted("sphere"),
    "box lifted and dropped": lambda: lifted("box"),
    "box under a force that grows": growing,
    "box tipped while it slides": lambda: tipped(0.2),
}
ROUND = ("sphere", "cylinder", "capsule", "wheel")


def of_shape(shape: str) -> dict[str, Callable[[], Case]]:
    """Cases for all shapes."""
    case = contact_case
    return {
        "slides to rest": lambda: case(on_floor(shape, SLIDING, {"v": [0.8, 0, 0]}), 0.5),
        "starts on an incline": lambda: inclined(shape, STICKING),
        "bounces": lambda: falling(shape, BOUNCING),
        "on a belt": lambda: case(on_floor(shape, BELT, {"v": [0.2, 0, 0]}), 0.2),
        "spins to rest": lambda: case(on_floor(shape, {**SLIDING, "spinning": 0.004}, {"w": [0, 0, 3]}), 0.9),
        "pushed with static friction": lambda: pushed(
            {"friction": 0.3, "static": 0.5}, (2.0, 4.8, 5.1, -3.9, -5.5), shape
        ),
    }


def of_round_shape(shape: str) -> dict[str, Callable[[], Case]]:
    """Cases for shapes that roll."""
    law = {"friction": 0.6, "rolling": 0.004}
    case = contact_case
    return {
        "rolls to rest": lambda: case(on_floor(shape, law, {"v": [0.2, 0, 0], "w": [0, 2, 0]}), 0.9),
        "slides, then rolls": lambda: case(
            on_floor(shape, {**law, "friction": 0.3}, {"v": [0.7, 0, 0], "w": [0, -2, 0]}), 0.9
        ),
    }


for _shape in SHAPES:
    CASES |= {f"{_shape} {name}": _case for name, _case in of_shape(_shape).items()}
for _shape in ROUND:
    CASES |= {f"{_shape} {name}": _case for name, _case in of_round_shape(_shape).items()}
for _upper in ("sphere", "box", "capsule"):
    for _lower in ("sphere", "box", "capsule"):
        CASES[f"{_upper} falls on {_lower}"] = partial(dropped, _upper, _lower, 0.5)
