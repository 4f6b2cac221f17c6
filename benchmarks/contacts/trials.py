# SPDX-License-Identifier: BSD-3-Clause
"""Trials of the failure map of contacts: scenes at the thresholds of the laws, with exact solutions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from benchmarks.nonsmooth.trials import Trial
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

type Scene = dict[str, Any]
type Array = NDArray[np.float64]

GRAVITY = 9.81  # m/s2
NEAR = 1e-6
UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ContactTrial(Trial):
    """A trial whose motion has a largest speed, of which the error of steps with impulses is a multiple."""

    speed: float = 1.0  # m/s


def share(x: float) -> str:
    """Return a label: "1 - 1e-6" where the number is that near to 1."""
    if x != 1 and abs(x - 1) < 1e-3:
        return f"1 {'-' if x < 1 else '+'} {abs(x - 1):.0e}".replace("e-0", "e-")
    return f"{x:g}"


def sphere(radius: float) -> Scene:
    return {"sphere": radius}


def moments(shape: Scene, mass: float) -> list[float]:
    """Return the moments of inertia of a sphere or a box [kg m2]."""
    if "sphere" in shape:
        return [0.4 * mass * shape["sphere"] ** 2] * 3
    x, y, z = (length**2 for length in shape["box"])
    return [mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)]


def body(shape: Scene, mass: float) -> Scene:
    shapes = {"s": {**shape, "surface": "body"}}
    return {"mass": mass, "inertia": moments(shape, mass), "shapes": shapes}


def free(child: str, r: Sequence[float], **start: Any) -> Scene:
    values = {"r": list(r), **{k: list(v) for k, v in start.items()}, "fixed": True}
    return {"type": "free", "parent": "ground", "child": child, "start": values}


def on_plane(
    shape: Scene,
    r: Sequence[float],
    *,
    angle: float = 0.0,
    mass: float = 1.0,
    friction: float = 0.0,
    restitution: float = 0.0,
    gravity: float = GRAVITY,
    **start: Any,
) -> Scene:
    """Return a body on a plane through the origin that falls towards +x by an angle [rad]."""
    normal = [math.sin(angle), 0, math.cos(angle)]
    half = angle / 2
    turned = {"Q": [0, math.sin(half), 0, math.cos(half)]} if angle else {}
    contact = {"between": ["body", "floor"], "friction": friction, "restitution": restitution}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -gravity],
        "bodies": {"b": body(shape, mass)},
        "ground": {"shapes": {"floor": {"plane": normal, "surface": "floor"}}},
        "joints": {"J": free("b", r, **turned, **start)},
        "contacts": {"c": contact},
    }


def places(
    found: Sequence[Sequence[float]], joint: str = "J", axes: Sequence[int] = (1, 3)
) -> Mapping[str, list[float]]:
    return {f"{joint}.r[{k}]": [row[i] for row in found] for i, k in enumerate(axes)}


def sloping(
    family: str,
    row: str,
    column: str,
    shape: Scene,
    angle: float,
    height: float,
    way: Mapping[float, float],
    v: float,
    **fields: Any,
) -> ContactTrial:
    """A body that moves along a slope. way: by time [m]; v: its speed at the start, downwards [m/s]."""
    down = np.array([math.cos(angle), -math.sin(angle)])
    off = height * np.array([math.sin(angle), math.cos(angle)])
    scene = on_plane(shape, [off[0], 0, off[1]], angle=angle, v=[v * down[0], 0, v * down[1]], **fields)
    times = list(way)
    speed = max(abs(v), *(abs(s / t) for t, s in way.items()), 0.1)
    exact = places([list(off + s * down) for s in way.values()])
    return ContactTrial(family, row, column, scene, times, exact, speed=speed)


def on_slopes() -> Iterator[ContactTrial]:
    """A block with the friction of a slope, or nearly."""
    angle, times = math.radians(30), (0.1, 0.3, 1.0)
    pull, press = GRAVITY * math.sin(angle), GRAVITY * math.cos(angle)
    for v in (0.0, 1.0, -1.0):
        for ratio in (0.5, 1 - NEAR, 1.0, 1 + NEAR, 2.0, 10.0):
            friction = math.tan(angle) / ratio
            way = {}
            for t in times:
                down = pull - friction * press if v >= 0 else pull + friction * press
                after = max(0.0, pull - friction * press)
                stop = -v / down if v * down < 0 else (math.inf if v or down > 0 else 0.0)
                moving = min(t, stop)
                way[t] = v * moving + down / 2 * moving**2 + after / 2 * (t - moving) ** 2
            row = "at rest" if v == 0 else "downwards" if v > 0 else "upwards"
            block = {"box": [0.4, 0.3, 0.1]}
            yield sloping(
                "block on a slope, tan / friction",
                row,
                share(ratio),
                block,
                angle,
                0.05,
                way,
                v,
                friction=friction,
            )


def on_slopes_rolling() -> Iterator[ContactTrial]:
    """A ball rolls down a slope if friction is at least 2/7 of its tangent."""
    angle, radius = math.radians(20), 0.05
    for row in ("at rest", "rolling", "rolling up"):
        for ratio in (0.0, 0.5, 1 - NEAR, 1.0, 1 + NEAR, 2.0):
            v = {"at rest": 0.0, "rolling": 1.0, "rolling up": -1.0}[row]
            friction = 2 / 7 * math.tan(angle) / ratio if ratio else 10.0
            slips = ratio > 1
            pull = GRAVITY * math.sin(angle)
            a = pull - friction * GRAVITY * math.cos(angle) if slips else 5 / 7 * pull
            way = {t: v * t + a / 2 * t * t for t in (0.1, 0.3, 1.0)}
            yield sloping(
                "ball on a slope, (2/7) tan / friction",
                row,
                share(ratio),
                sphere(radius),
                angle,
                radius,
                way,
                v,
                friction=friction,
                w=[0, v / radius, 0],
            )


def bouncing() -> Iterator[ContactTrial]:
    """A ball falls on the floor until it rests."""
    radius = 0.1
    for e in (0.0, 0.1, 0.5, 0.9, 1.0):
        for height in (1e-9, 1e-6, 1e-3, 1.0, 100.0):
            first = math.sqrt(2 * height / GRAVITY)
            times = [first * k for k in (0.5, 1.5, 2.5, 4.2, 8.1, 16.3, 25.0)]
            found = []
            for t in times:
                left, speed = t - first, e * GRAVITY * first
                while left > 2 * speed / GRAVITY and speed > 1e-12:
                    left -= 2 * speed / GRAVITY
                    speed *= e
                z = max(0.0, speed * left - GRAVITY / 2 * left**2) if speed > 1e-12 else 0.0
                found.append([radius + (z if t > first else height - GRAVITY / 2 * t * t)])
            scene = on_plane(sphere(radius), [0, 0, radius + height], restitution=e)
            # Heights beyond that of a body lose digits with it; a series ends 2e-10 m above the floor.
            scale = max(height, 0.1)
            yield ContactTrial(
                "ball that bounces, from a height [m]",
                f"restitution {e:g}",
                f"{height:g}",
                scene,
                times,
                places(found, axes=[3]),
                bound=scale,
                speed=max(GRAVITY * first, 1.0),
            )


def struck() -> Iterator[ContactTrial]:
    """A ball strikes the floor obliquely, without gravity: it rolls off or slips."""
    radius, friction, fall = 0.05, 0.3, 1.0
    for e in (0.0, 0.5, 1.0):
        for ratio in (0.0, 0.5, 1 - NEAR, 1.0, 1 + NEAR, 2.0):
            v = 3.5 * ratio * friction * (1 + e) * fall
            after = v - min(2 / 7 * v, friction * (1 + e) * fall)
            scene = on_plane(
                sphere(radius),
                [0, 0, radius + 0.1],
                friction=friction,
                restitution=e,
                gravity=0.0,
                v=[v, 0, -fall],
            )
            times = [0.05, 0.15, 1.1]
            found = [[v * 0.05, radius + 0.05]]
            found += [[0.1 * v + after * (t - 0.1), radius + e * fall * (t - 0.1)] for t in times[1:]]
            yield ContactTrial(
                "oblique impact of a ball, slip / limit",
                f"restitution {e:g}",
                share(ratio),
                scene,
                times,
                places(found),
                speed=max(v, fall),
            )


def colliding() -> Iterator[ContactTrial]:
    """Two balls collide on a line, without gravity."""
    radius, times = 0.05, [0.1, 0.3, 1.0]
    for e in (0.0, 0.5, 1.0):
        for ratio in (1e-6, 1e-3, 1.0, 1e3, 1e6):
            both = {"a": body(sphere(radius), 1.0), "b": body(sphere(radius), ratio)}
            scene = {
                "gelenk": 1,
                "bodies": both,
                "joints": {
                    "A": free("a", [0, 0, 0], v=[1.0, 0, 0]),
                    "B": free("b", [2 * radius + 0.2, 0, 0]),
                },
                "contacts": {"c": {"between": ["body", "body"], "restitution": e}},
            }
            slower = 1 - (1 + e) * ratio / (1 + ratio)
            faster = (1 + e) / (1 + ratio)
            mine = [[t if t < 0.2 else 0.2 + slower * (t - 0.2)] for t in times]
            other = [[2 * radius + 0.2 + faster * max(0.0, t - 0.2)] for t in times]
            exact = {**places(mine, "A", [1]), **places(other, "B", [1])}
            yield ContactTrial(
                "two balls collide, ratio of masses",
                f"restitution {e:g}",
                f"{ratio:g}",
                scene,
                times,
                exact,
                speed=2.0,
            )


def slipping() -> Iterator[ContactTrial]:
    """A ball with a spin slides until it rolls."""
    radius, times = 0.05, [0.01, 0.1, 1.0]
    spins = {
        "none": 0.0,
        "rolls": 1.0,
        "nearly rolls": 1 - NEAR,
        "backwards": -1.0,
        "comes back": -5.0,
        "faster": 3.0,
    }
    for friction in (0.01, 0.2, 1.0, 5.0):
        for row, spin in spins.items():
            v = np.array([1.0, 0.3])
            slip = v * (1 - spin)
            size = float(np.linalg.norm(slip))
            brake = friction * GRAVITY * slip / size if size else np.zeros(2)
            end = 2 / 7 * size / (friction * GRAVITY)
            w = spin / radius * np.array([-v[1], v[0], 0.0])
            scene = on_plane(sphere(radius), [0, 0, radius], friction=friction, v=[*v, 0.0], w=w.tolist())
            found = [
                list(v * min(t, end) - brake / 2 * min(t, end) ** 2 + (v - brake * end) * max(0.0, t - end))
                for t in times
            ]
            yield ContactTrial(
                "ball that slides until it rolls, friction",
                f"spin: {row}",
                f"{friction:g}",
                scene,
                times,
                places(found, axes=[1, 2]),
                speed=5.0,
            )


BOX, BOX_MASS, BOX_FRICTION = (0.2, 0.3, 0.6), 2.0, 0.5


def tipping_box(force: float, lift: float, times: Sequence[float]) -> Array:
    """Return x and z of a box that slides on its front edge, pushed at a height above its center.

    Shape (times, 2). The force of friction is that of sliding; the equations are those of the plane.
    """
    half, high = BOX[0] / 2, BOX[2] / 2
    inertia = moments({"box": BOX}, BOX_MASS)[1]

    def rates(_: float, y: Array) -> list[float]:
        tilt, w = y[2:4]
        c, s = math.cos(tilt), math.sin(tilt)
        x, z = half * c - high * s, -half * s - high * c  # the edge, from the center
        arm = half * s + lift * c  # height of the force above the center; it acts on the rear face
        lever = -BOX_FRICTION * z - x  # of the normal force, about the center
        a = (arm * force + lever * BOX_MASS * (GRAVITY + w * w * z)) / (inertia - lever * BOX_MASS * x)
        normal = BOX_MASS * (GRAVITY + a * x + w * w * z)
        return [y[1], (force - BOX_FRICTION * normal) / BOX_MASS, w, a]

    found = solve_ivp(rates, (0, times[-1]), [0, 0, 0, 0], "DOP853", times, rtol=1e-13, atol=1e-15).y
    height = half * np.sin(found[2]) + high * np.cos(found[2])
    return np.column_stack([found[0], height])


def pushed() -> Iterator[ContactTrial]:
    """A box is pushed at a height: its weight is on its middle, its front edge, or it tips about that."""
    times = [0.05, 0.1, 0.2]
    half, high = BOX[0] / 2, BOX[2] / 2
    for push in (1.2, 2.0):
        for part in (0.0, 0.5, 1 - NEAR, 1.0, 1 + NEAR, 1.5):
            force = push * BOX_FRICTION * BOX_MASS * GRAVITY
            lift = (part * half - BOX_FRICTION * high) * BOX_MASS * GRAVITY / force
            a = (push - 1) * BOX_FRICTION * GRAVITY
            upright = [[a / 2 * t * t, high] for t in times]
            found = upright if part <= 1 else tipping_box(force, lift, times).tolist()
            scene = on_plane({"box": list(BOX)}, [0, 0, high], mass=BOX_MASS, friction=BOX_FRICTION)
            scene["forces"] = {
                "push": {"type": "wrench", "body": "b", "position": [-half, 0, lift], "force": [force, 0, 0]}
            }
            yield ContactTrial(
                "pushed box, weight on / front edge",
                f"force / friction {push:g}",
                share(part),
                scene,
                times,
                places(found),
                speed=2.0,
            )


def stacks() -> Iterator[ContactTrial]:
    """Boxes on each other, at rest."""
    side, times = 0.1, [0.1, 0.5, 1.0]
    for count in (1, 2, 4, 8):
        for ratio in (1e-6, 1e-3, 1.0, 1e3, 1e6):
            masses = [ratio ** (i / max(1, count - 1)) for i in range(count)]
            cube = {"box": [side] * 3}
            scene = {
                "gelenk": 1,
                "gravity": [0, 0, -GRAVITY],
                "bodies": {f"b{i}": body(cube, m) for i, m in enumerate(masses)},
                "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
                "joints": {f"J{i}": free(f"b{i}", [0, 0, (i + 0.5) * side]) for i in range(count)},
                "contacts": {
                    "floor": {"between": ["body", "floor"], "friction": 0.5},
                    "cubes": {"between": ["body", "body"], "friction": 0.5},
                },
            }
            exact = {
                f"J{i}.r[{k}]": [place] * len(times)
                for i in range(count)
                for k, place in ((1, 0.0), (3, (i + 0.5) * side))
            }
            yield ContactTrial(
                "stack at rest, mass of the top / bottom",
                f"{count} cubes",
                f"{ratio:g}",
                scene,
                times,
                exact,
                speed=1e-6,
            )


def rods() -> Iterator[ContactTrial]:
    """Painleve's rod slides with its lower end ahead; beyond the critical friction no forces exist."""
    half, tip = 1.0, 1e-6
    for theta in (0.5, math.atan(2), 1.3):
        critical = (1 + 3 * math.cos(theta) ** 2) / (3 * math.sin(theta) * math.cos(theta))
        for part in (0.0, 0.5, 0.9, 0.999, 1.001, 2.0):
            friction = part * critical
            # The normal force grows beyond all bounds towards the critical friction, and stops the rod.
            normal = GRAVITY / ((1 + 3 * math.cos(theta) ** 2) * max(1 - part, NEAR))
            times = [k * min(0.03, 1 / (friction * normal + GRAVITY)) for k in (0.1, 0.3)]
            found = sliding_rod(theta, friction, half, tip, times) if part < 1 else []
            turn = (math.pi / 2 - theta) / 2
            start = {"v": [-1.0, 0, 0], "Q": [0, math.sin(turn), 0, math.cos(turn)]}
            scene = on_plane(sphere(tip), [0, 0, 0], friction=friction)
            shape = {"sphere": tip, "position": [0, 0, -half], "surface": "body"}
            scene["bodies"] = {
                "b": {"mass": 1.0, "inertia": [half**2 / 3, half**2 / 3, 1e-6], "shapes": {"tip": shape}}
            }
            scene["joints"] = {
                "J": free("b", [half * math.cos(theta), 0, tip + half * math.sin(theta)], **start)
            }
            yield ContactTrial(
                "Painlevé's rod, friction / critical",
                f"at {math.degrees(theta):.0f}°",
                share(part),
                scene,
                times,
                places(found) if found else {},
                speed=1.0,
            )


def sliding_rod(
    theta: float, friction: float, half: float, tip: float, times: Sequence[float]
) -> list[list[float]]:
    """Return x and z of the center of a uniform rod of 1 kg whose end slides on the floor towards -x."""

    def rates(_: float, y: Array) -> list[float]:
        angle, w = y[0:2]  # of the rod above the floor
        c, s = math.cos(angle), math.sin(angle)
        # z = l sin + tip, so that N = g + l (a cos - w2 sin); friction mu N acts below the lower end.
        lever = -half * c + friction * (half * s + tip)
        a = lever * (GRAVITY - half * w * w * s) / (half**2 / 3 - lever * half * c)
        normal = GRAVITY + half * (a * c - w * w * s)
        return [w, a, y[3], friction * normal]

    start = [theta, 0, half * math.cos(theta), -1.0]
    found = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-15).y
    return np.column_stack([found[2], half * np.sin(found[0]) + tip]).tolist()


def trials() -> list[ContactTrial]:
    families = (on_slopes, on_slopes_rolling, bouncing, struck, slipping, colliding, pushed, stacks, rods)
    return [trial for family in families for trial in family()]
