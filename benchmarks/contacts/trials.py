# SPDX-License-Identifier: BSD-3-Clause
"""Trials of the failure map of contacts: scenes at the thresholds of the laws, with exact solutions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from benchmarks.contacts import tipping
from benchmarks.contacts.trial import (
    GRAVITY,
    NEAR,
    ContactTrial,
    Scene,
    body,
    free,
    on_plane,
    places,
    share,
    sphere,
)


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
    """A body that moves along an incline. way: by time [m]; v: its speed at the start, downwards [m/s]."""
    down = np.array([math.cos(angle), -math.sin(angle)])
    off = height * np.array([math.sin(angle), math.cos(angle)])
    scene = on_plane(shape, [off[0], 0, off[1]], angle=angle, v=[v * down[0], 0, v * down[1]], **fields)
    times = list(way)
    speed = max(abs(v), *(abs(s / t) for t, s in way.items()), 0.1)
    exact = places([list(off + s * down) for s in way.values()])
    return ContactTrial(family, row, column, scene, times, exact, speed=speed)


def on_slopes() -> Iterator[ContactTrial]:
    """A block with the friction of an incline, or nearly."""
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
                "block on an incline, tan / friction",
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
                "ball on an incline, (2/7) tan / friction",
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
        for height in (1e-9, 1e-6, 1e-3, 1.0, 10.0):
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


def stacks() -> Iterator[ContactTrial]:
    """Boxes on each other, at rest."""
    side, times = 0.1, [0.1, 0.5, 1.0]
    for count in (2, 4, 8):
        for ratio in (1e-6, 1e-3, 1.0, 1e3):
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


def trials() -> list[ContactTrial]:
    families = (
        on_slopes,
        on_slopes_rolling,
        bouncing,
        struck,
        slipping,
        colliding,
        tipping.pushed,
        stacks,
        tipping.rods,
    )
    return [trial for family in families for trial in family()]
