# SPDX-License-Identifier: BSD-3-Clause
"""A thin disc that rolls without slip, as scenes and as equations of motion in three velocities.

In axes that do not spin with the disc, x heading, y its axis, z up in its plane, leaning by q about x, the
normal of the ground is n = (0, sin q, cos q). The disc rotates with w = (p, w2, w3), the axes with (p, w3 tan
q, w3), p = dq/dt. Its center, R above the contact, moves with v = R (w2, -p, 0). Force F = m (dv/dt + g n)
and moment (R F2, -R F1, 0) about the center, with moments of inertia C about the axis and A about a diameter,
give (Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. 2)

    (A + m R^2) dp/dt = (C + m R^2) w3 w2 - A w3^2 tan q + m g R sin q
    (C + m R^2) dw2/dt = -m R^2 p w3                A dw3/dt = p (A w3 tan q - C w2)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import (
    GRAVITY,
    Array,
    Numbers,
    Scene,
    body,
    frame,
    frame_sensor,
    joint,
    matrix,
    numbers,
    scene,
)
from scipy.integrate import solve_ivp

MASS, RADIUS, AXIAL, ACROSS = 2.0, 0.3, 0.12, 0.06  # kg, m, kg m2
ROLLED_AXIAL, ROLLED_ACROSS = AXIAL + MASS * RADIUS**2, ACROSS + MASS * RADIUS**2
WHEEL = body(MASS, (0, 0, 0), (ACROSS, AXIAL, ACROSS))


@dataclass(frozen=True)
class Rolling:
    """Lean [rad] and its rate, yaw rate, and spin about the axis relative to the leaning frame [rad/s]."""

    lean: float = 0.2
    lean_rate: float = 0.3
    yaw_rate: float = 1.0
    spin: float = 6.0


WOBBLING = Rolling()


def disc(motion: Rolling = WOBBLING, R: Array | None = None, p: Numbers = (0, 0, 0), **fields: Any) -> Scene:
    """A chain: yaw, height, lean, spin. The plane is z = 0 of a frame R at p in the ground."""
    place = np.eye(3) if R is None else R
    starts = {
        "base": {"phi": 0.0, "w": motion.yaw_rate, "fixed": ["phi", "w"]},
        "height": {"s": RADIUS},
        "lean": {"phi": motion.lean, "w": motion.lean_rate, "fixed": True},
        "spin": {"w": motion.spin, "fixed": ["w"]},
    }
    plane = {} if R is None else {"on": frame("ground", p, place)}
    return scene(
        {"a": body(0), "b": body(0), "c": body(0), "wheel": WHEEL},
        {
            "base": joint("planar", frame("ground", p, R), frame("a"), start=starts["base"]),
            "height": joint("prismatic", frame("a"), frame("b"), axis=[0, 0, 1], start=starts["height"]),
            "lean": joint("revolute", frame("b"), frame("c"), axis=[1, 0, 0], start=starts["lean"]),
            "spin": joint("revolute", frame("c"), frame("wheel"), axis=[0, 1, 0], start=starts["spin"]),
        },
        name="Disc",
        gravity=numbers(place @ [0, 0, -GRAVITY]),
        constraints={"tyre": {"type": "rolling", "body": "wheel", "radius": RADIUS, **plane}},
        sensors={"hub": frame_sensor("wheel")},
        experiment={"stop": 4, "step": 0.01, "tolerance": 1e-11},
        **fields,
    )


def flying_disc(motion: Rolling = WOBBLING) -> Scene:
    """The same disc on a joint of type `free`."""
    q = motion.lean
    lean = np.array([[1, 0, 0], [0, np.cos(q), -np.sin(q)], [0, np.sin(q), np.cos(q)]])
    up = lean.T @ [0, 0, 1]
    w = np.array([motion.lean_rate, motion.spin, 0]) + motion.yaw_rate * up
    start = {
        "r": [0, 0, RADIUS * np.cos(q)],
        "rotation": matrix(lean),
        "v": numbers(lean @ np.cross(w, [0, 0, RADIUS])),
        "w": numbers(w),
        "fixed": True,
    }
    out = disc(motion)
    return out | {
        "bodies": {"wheel": WHEEL},
        "joints": {"free": joint("free", frame("ground"), frame("wheel"), start=start)},
    }


def speeds(motion: Rolling) -> tuple[float, float]:
    """Return w2, w3."""
    return motion.spin + motion.yaw_rate * np.sin(motion.lean), motion.yaw_rate * np.cos(motion.lean)


def rates(q: Any, p: Any, w2: Any, w3: Any) -> tuple[Any, Any, Any]:
    """Return dp/dt, dw2/dt, dw3/dt, for numbers or arrays over time."""
    gravity = MASS * GRAVITY * RADIUS * np.sin(q)
    dp = (ROLLED_AXIAL * w3 * w2 - ACROSS * w3**2 * np.tan(q) + gravity) / ROLLED_ACROSS
    return dp, -MASS * RADIUS**2 * p * w3 / ROLLED_AXIAL, p * (w3 * np.tan(q) - AXIAL / ACROSS * w2)


def truth(motion: Rolling, times: Array) -> dict[str, Array]:
    """Integrate the reduced equations independently;
    return the scene outputs computed from their solution.
    """

    def derivative(_t: float, y: Array) -> list[float]:
        q, p, w2, w3, yaw = y[:5]
        yaw_rate = w3 / np.cos(q)
        back = RADIUS * p * np.cos(q)  # of the center, across the heading
        vx = RADIUS * w2 * np.cos(yaw) + back * np.sin(yaw)
        vy = RADIUS * w2 * np.sin(yaw) - back * np.cos(yaw)
        return [p, *rates(q, p, w2, w3), yaw_rate, w2 - yaw_rate * np.sin(q), vx, vy]

    first = [motion.lean, motion.lean_rate, *speeds(motion), 0, 0, 0, 0]
    # Small compared with rtol: of angles and velocities around 1.
    y = solve_ivp(derivative, (times[0], times[-1]), first, "DOP853", times, rtol=1e-12, atol=1e-13).y
    q, p, w2, w3, yaw, turned, x, y_ = y
    dp, dw2, _ = rates(q, p, w2, w3)
    heading = MASS * RADIUS * (dw2 + p * w3)
    across = MASS * (RADIUS * (-dp + w3 * w2) + GRAVITY * np.sin(q))  # along the axis
    up = MASS * (-RADIUS * (p**2 + w3 * w2 * np.tan(q)) + GRAVITY * np.cos(q))  # in the plane of the disc
    return {
        "lean.phi": q, "lean.w": p, "lean.a": dp,
        "base.phi": yaw, "base.w": w3 / np.cos(q), "base.s_x": x, "base.s_y": y_,
        "spin.phi": turned, "spin.w": w2 - w3 * np.tan(q),
        "height.s": RADIUS * np.cos(q),
        "tyre.f_long": heading,
        "tyre.f_lat": across * np.cos(q) - up * np.sin(q),
        "tyre.f_n": across * np.sin(q) + up * np.cos(q),
        "tyre.r[1]": x - RADIUS * np.sin(q) * np.sin(yaw),
        "tyre.r[2]": y_ + RADIUS * np.sin(q) * np.cos(yaw),
        "tyre.r[3]": 0 * q,
    }  # fmt: skip


def steady(lean: float, spin: float) -> Rolling:
    """Rolling in a circle at this lean and spin: dp/dt = 0 is quadratic in the yaw rate;
    returns its slower solution.
    """
    s, c = np.sin(lean), np.cos(lean)
    square, linear = (ROLLED_AXIAL - ACROSS) * s * c, ROLLED_AXIAL * c * spin
    constant = MASS * GRAVITY * RADIUS * s
    root = np.sqrt(linear**2 - 4 * square * constant)
    return Rolling(lean, 0.0, float(-2 * constant / (linear + np.copysign(root, linear))), spin)


def frequency_squared(motion: Rolling) -> float:
    """Squared frequency of small wobbles [rad2/s2]: w2 and w3 are functions of the lean alone,
    dw/dq being their rate / p.
    """
    q = motion.lean
    w2, w3 = speeds(motion)
    _, dw2, dw3 = rates(q, 1.0, w2, w3)
    derivative = ROLLED_AXIAL * (dw3 * w2 + w3 * dw2)
    derivative -= ACROSS * (2 * w3 * dw3 * np.tan(q) + w3**2 / np.cos(q) ** 2)
    derivative += MASS * GRAVITY * RADIUS * np.cos(q)
    return float(-derivative / ROLLED_ACROSS)


def disc_on_a_table(turning: float, moment: float | None, start: dict[str, Any]) -> Scene:
    """The disc on a table rotating about z: driven at `turning` rad/s, or,
    given a moment of inertia, released at it.
    """
    out = flying_disc()
    out["bodies"]["table"] = body(5.0, (0, 0, -0.1), (1, 1, moment or 1.0))
    out["joints"]["free"]["start"] = start | {"fixed": ["Q", "w"]}
    out["joints"]["table"] = joint(
        "revolute", frame("ground"), frame("table"), axis=[0, 0, 1], start={"phi": 0.0, "w": turning}
    )
    out["constraints"]["tyre"]["on"] = "table"
    if moment is None:
        out["constraints"]["engine"] = {"type": "motion", "joint": "table", "polynomial": [0.0, turning]}
    else:
        out["joints"]["table"]["start"]["fixed"] = True
    return out
