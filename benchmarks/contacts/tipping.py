# SPDX-License-Identifier: BSD-3-Clause
"""Trials of a box that tips and of Painlevé's rod, with references by integration in the plane."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from benchmarks.contacts.trial import (
    GRAVITY,
    NEAR,
    ContactTrial,
    free,
    moments,
    on_plane,
    places,
    share,
    sphere,
)
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

type Array = NDArray[np.float64]

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
    if not (found[1] > found[3] * height).all():
        raise ValueError("the edge slides back, so that friction has another direction")
    return np.column_stack([found[0], height])


def pushed() -> Iterator[ContactTrial]:
    """A box is pushed at a height: its weight is on its middle, its front edge, or it tips about that."""
    times = [0.04, 0.08, 0.12]
    half, high = BOX[0] / 2, BOX[2] / 2
    for push in (1.2, 2.0):
        for part in (0.0, 0.5, 1 - NEAR, 1.0, 1 + NEAR, 1.05):
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


def rods() -> Iterator[ContactTrial]:
    """Painleve's rod slides with its lower end ahead; beyond the critical friction no forces exist."""
    half, tip = 1.0, 1e-6
    for theta in (0.5, math.atan(2), 1.3):
        critical = (1 + 3 * math.cos(theta) ** 2) / (3 * math.sin(theta) * math.cos(theta))
        for part in (0.0, 0.5, 0.9, 0.999, 1.001, 2.0):
            friction = part * critical
            # The normal force grows beyond all bounds towards the critical friction, and stops the rod.
            normal = GRAVITY / ((1 + 3 * math.cos(theta) ** 2) * max(1 - part, NEAR))
            shortest = min(0.03, 1 / (friction * normal + GRAVITY))
            times = [0.1 * shortest, 0.3 * shortest] if part < 1 else [1e-3]
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
                refused=not found,
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
    return [[float(x), half * math.sin(angle) + tip] for angle, x in zip(found[0], found[2], strict=True)]
