# SPDX-License-Identifier: BSD-3-Clause
"""Four problems with dry friction or impacts and known solutions, as scenes.

The belt and the clutch are solved in closed form. The references of the others were computed by event-driven
Gragg-Bulirsch-Stoer extrapolation in 80-bit arithmetic, repeated with another step and with DOP853; their own
errors are below 1e-12.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

Scene = dict[str, Any]
GRAVITY = 9.81


@dataclass(frozen=True)
class Problem:
    """A problem; its errors are those of `positions` [m, rad] at the reference times."""

    name: str
    title: str
    about: str
    scene: Scene
    positions: Mapping[str, tuple[float, ...]]  # by output, at `times`
    times: tuple[float, ...]  # s
    events: int  # until the last of the times
    start: float = 0.0  # s
    inputs: Mapping[float, Mapping[str, float]] = field(default_factory=dict)  # by time, from which they hold


def joint(kind: str, parent: Any, child: str, axis: list[float], **fields: Any) -> Scene:
    return {"type": kind, "axis": axis, "parent": parent, "child": {"body": child}, **fields}


def at(body: str, x: float = 0.0) -> Scene:
    return {"body": body, "position": [x, 0, 0]}


def exactly(**values: float) -> Scene:
    """Return start values that are kept."""
    return {**values, "fixed": True}


def bar(mass: float, length: float) -> Scene:
    """Return a slender uniform bar along x, with its frame at one end."""
    across = mass * length**2 / 12
    return {"mass": mass, "com": [length / 2, 0, 0], "inertia": [0, across, across]}


BELT_SPEED, STATIC, SLIDING = 0.2, 0.6 * GRAVITY, 0.3 * GRAVITY  # m/s; N, of a block of 1 kg
SPRING = 100.0  # N/m


def belt_scene(speed: float = BELT_SPEED, static: float = STATIC) -> Scene:
    """Return the block on a belt, whose speed is prescribed; the spring is 10 m long, along the belt."""
    friction = {"coulomb": SLIDING, "static": static}
    sticks = exactly(s=0.0, v=0.0)
    spring = {"from": at("ground", -10.0), "to": at("block"), "stiffness": SPRING, "length": 10.0}
    return {
        "gelenk": 1,
        "name": "belt",
        "bodies": {"belt": {"mass": 1.0}, "block": {"mass": 1.0}},
        "joints": {
            "drum": joint("prismatic", at("ground"), "belt", [1, 0, 0], start={"s": 0.0}),
            "contact": joint("prismatic", at("belt"), "block", [1, 0, 0], friction=friction, start=sticks),
        },
        "constraints": {"run": {"type": "motion", "joint": "drum", "speed": speed}},
        "forces": {"spring": {"type": "spring_damper", **spring}},
        "sensors": {"where": {"type": "frame", "body": "block"}},
    }


def belt_phases(speed: float, static: float) -> tuple[float, float]:
    """Return for how long the block sticks in its limit cycle, and for how long it slips."""
    rate = math.sqrt(SPRING)
    far = (static - SLIDING) / SPRING
    return 2 * far / speed, (math.pi + 2 * math.atan2(speed / rate, far)) / rate


def belt_solution(
    times: tuple[float, ...], speed: float = BELT_SPEED, static: float = STATIC
) -> tuple[tuple[float, ...], int]:
    """Return positions of the block and the number of events until the last time.

    It sticks until the spring pulls with the static friction, and slips as an oscillation about the sliding
    friction until it has the speed of the belt again.
    """
    rate, middle, far = math.sqrt(SPRING), SLIDING / SPRING, static / SPRING
    amplitude = math.hypot(far - middle, speed / rate)
    phase = math.atan2(speed / rate, far - middle)
    sticking, slipping = belt_phases(speed, static)
    found, events = [], 0
    for t in times:
        local = t - far / speed
        if local <= 0:
            found.append(speed * t)
            continue
        cycles, local = divmod(local, sticking + slipping)
        events = 1 + 2 * int(cycles) + (local > slipping)
        if local <= slipping:
            found.append(middle + amplitude * math.cos(rate * local - phase))
        else:
            found.append(2 * middle - far + speed * (local - slipping))
    return tuple(found), events


def belt() -> Problem:
    times = (0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)
    positions, events = belt_solution(times)
    about = "A block on a belt is held by a spring; its static friction is twice its sliding friction."
    return Problem("belt", "Block on a belt", about, belt_scene(), {"where.r[1]": positions}, times, events)


CLUTCH_INERTIAS, CLUTCH_LOAD, CLUTCH_SLIDING, CLUTCH_STATIC = (0.5, 2.0), -10.0, 80.0, 96.0
CLUTCH_TORQUES = {0.5: 20.0, 3.0: 130.0, 4.0: -20.0}  # N m, from these times [s]


def clutch_scene() -> Scene:
    friction = {"coulomb": CLUTCH_SLIDING, "static": CLUTCH_STATIC}
    one, two = ({"mass": 1.0, "inertia": [0, 0, inertia]} for inertia in CLUTCH_INERTIAS)
    fast, slower = exactly(phi=0.0, w=120.0), exactly(phi=0.0, w=-122.5)
    return {
        "gelenk": 1,
        "name": "clutch",
        "bodies": {"one": one, "two": two},
        "joints": {
            "shaft": joint("revolute", at("ground"), "one", [0, 0, 1], start=fast),
            "clutch": joint("revolute", at("one"), "two", [0, 0, 1], friction=friction, start=slower),
        },
        "motors": {"engine": {"joint": "shaft"}},
        "forces": {"load": {"type": "wrench", "body": "two", "torque": [0, 0, CLUTCH_LOAD]}},
    }


def clutch() -> Problem:
    """Closed form: parabolas between locking, input jumps and breaking away."""
    J1, J2 = CLUTCH_INERTIAS
    times = (1.0, 1.5, 2.0, 2.9, 3.5, 4.0, 4.2, 4.5, 5.0)
    first: list[float] = []
    second: list[float] = []
    t, phi1, w1, phi2, w2, locked, events = 0.5, 0.0, 120.0, 0.0, -2.5, False, 0
    marks = sorted({*times, *CLUTCH_TORQUES} - {0.5})
    engine = CLUTCH_TORQUES[0.5]
    while marks:
        carried = (engine * J2 - CLUTCH_LOAD * J1) / (J1 + J2)
        if locked and abs(carried) > CLUTCH_STATIC:
            locked, events = False, events + 1
        tau = carried if locked else math.copysign(CLUTCH_SLIDING, w1 - w2 or carried)
        a1, a2 = (engine - tau) / J1, (CLUTCH_LOAD + tau) / J2
        meet = math.inf if locked or a1 == a2 else t - (w1 - w2) / (a1 - a2)
        meets = not locked and t < meet <= marks[0]
        end = meet if meets else marks.pop(0)
        h = end - t
        phi1, phi2 = phi1 + h * w1 + a1 * h * h / 2, phi2 + h * w2 + a2 * h * h / 2
        w1, w2, t = w1 + a1 * h, w2 + a2 * h, end
        if meets:
            w2, locked, events = w1, True, events + 1
        else:
            engine = CLUTCH_TORQUES.get(t, engine)
            if t in times:
                first.append(phi1)
                second.append(phi2 - phi1)
    about = "Friction between two wheels: they slip, lock, break away under a larger torque, lock again."
    inputs = {t: {"engine.tau": torque} for t, torque in CLUTCH_TORQUES.items()}
    positions = {"shaft.phi": tuple(first), "clutch.phi": tuple(second)}
    return Problem("clutch", "Clutch", about, clutch_scene(), positions, times, events, 0.5, inputs)


PENDULUM_MASS, PENDULUM_LENGTH, PENDULUM_MOMENT = 1.2, 0.4, 0.02  # kg, m, kg m2
PENDULUM_LIMIT, RESTITUTION = -0.3, 0.7


def pendulum_scene(**joint_fields: Any) -> Scene:
    """Return the pendulum with its hard limit, or with the given fields of its joint instead."""
    fields = joint_fields or {"limit": {"lower": PENDULUM_LIMIT, "restitution": RESTITUTION}}
    inertia = [PENDULUM_MOMENT] * 3
    p = {"mass": PENDULUM_MASS, "com": [0, 0, -PENDULUM_LENGTH], "inertia": inertia}
    start = exactly(phi=1.5, w=0.0)
    return {
        "gelenk": 1,
        "name": "pendulum",
        "gravity": [0, 0, -GRAVITY],
        "bodies": {"p": p},
        "joints": {"A": joint("revolute", at("ground"), "p", [0, -1, 0], start=start, **fields)},
    }


def pendulum() -> Problem:
    times = (0.3, 0.5, 0.8, 1.0, 2.0, 3.0, 5.0)
    phi = (
        0.5453382991036296, -0.0023764758975950875, 0.9911038379216447, 0.8319367479805393,
        0.20284344950118818, -0.11350936169573407, -0.09604863525306835,
    )  # fmt: skip
    about = f"A pendulum strikes a hard limit at {PENDULUM_LIMIT} rad, with a restitution of {RESTITUTION}."
    return Problem("pendulum", "Pendulum and limit", about, pendulum_scene(), {"A.phi": phi}, times, 5)


CRANK, COUPLER, ROCKER, GROUND = 0.5, 1.75, 1.5, 2.0  # m; bars of 2 kg/m
FOUR_BAR_FRICTION = (0.4, 0.3, 0.5, 0.2)  # N m in A, B, C, D
FOUR_BAR_SPEED = 8.0  # rad/s, of the crank at the start


def four_bar_scene() -> Scene:
    def hinge(parent: Scene, child: str, torque: float, **fields: Any) -> Scene:
        return joint("revolute", parent, child, [0, -1, 0], friction={"coulomb": torque}, **fields)

    a, b, c, d = FOUR_BAR_FRICTION
    start = exactly(phi=math.pi / 2, w=FOUR_BAR_SPEED)
    return {
        "gelenk": 1,
        "name": "four_bar",
        "gravity": [0, 0, -GRAVITY],
        "bodies": {
            "crank": bar(2 * CRANK, CRANK), "coupler": bar(2 * COUPLER, COUPLER),
            "rocker": bar(2 * ROCKER, ROCKER),
        },
        "joints": {
            "A": hinge(at("ground"), "crank", a, start=start),
            "B": hinge(at("crank", CRANK), "coupler", b),
            "C": hinge(at("coupler", COUPLER), "rocker", c) | {"child": at("rocker", ROCKER)},
            "D": hinge(at("ground", GROUND), "rocker", d, start={"phi": 1.9}),
        },
    }  # fmt: skip


def four_bar() -> Problem:
    times = (0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
    phi = (
        3.4344422980515996, 6.974484436417667, 12.097955627078191, 16.48850681830029, 20.79950242974041,
        28.480270101943024, 34.95853316514847, 33.61464192001791,
    )  # fmt: skip
    about = (
        "A four-bar with friction in all joints, which reverse at different times; once, all come to rest."
    )
    return Problem("four_bar", "Four-bar", about, four_bar_scene(), {"A.phi": phi}, times, 32)


def problems() -> list[Problem]:
    makers: tuple[Callable[[], Problem], ...] = (belt, clutch, pendulum, four_bar)
    return [make() for make in makers]
