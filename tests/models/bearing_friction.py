# SPDX-License-Identifier: BSD-3-Clause
"""Linkages with bearings: scenes, and a four-bar in other equations than those of Gelenk.

The reference has the three bars as free bodies and the eight components of the joint forces as unknowns;
friction follows from the sizes of these by iteration, and speeds change their sign at located events.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, rod, scene
from scipy.integrate import solve_ivp

LINKS = (0.5, 1.75, 1.5, 2.0)  # crank, coupler, rocker, ground [m]
MASSES = (1.0, 3.5, 3.0)  # kg
COEFFICIENTS = (0.2, 0.15, 0.25, 0.1)  # of A, B, C, D
RADIUS = 0.02  # m
START_PHI, START_W = math.pi / 2, 8.0  # of the crank [rad, rad/s]


def four_bar_with_bearings(phi: float = START_PHI, w: float = START_W) -> Scene:
    """Slender bars in the vertical plane with friction proportional to the reaction in every joint."""
    bearings = [{"coulomb": 0.0, "bearing": {"coefficient": c, "radius": RADIUS}} for c in COEFFICIENTS]
    about = {"axis": [0, -1, 0]}
    start = {"phi": phi, "w": w, "fixed": True}
    crank, coupler, rocker, ground = LINKS
    return scene(
        {
            "crank": rod(MASSES[0], crank),
            "coupler": rod(MASSES[1], coupler),
            "rocker": rod(MASSES[2], rocker),
        },
        {
            "A": joint(
                "revolute", frame("ground"), frame("crank"), friction=bearings[0], start=start, **about
            ),
            "B": joint(
                "revolute", frame("crank", (crank, 0, 0)), frame("coupler"), friction=bearings[1], **about
            ),
            "C": joint(
                "revolute",
                frame("coupler", (coupler, 0, 0)),
                frame("rocker", (rocker, 0, 0)),
                friction=bearings[2],
                **about,
            ),
            "D": joint(
                "revolute",
                frame("ground", (ground, 0, 0)),
                frame("rocker"),
                friction=bearings[3],
                start={"phi": 1.9},
                **about,
            ),
        },
        gravity=[0, 0, -GRAVITY],
    )


def slider_crank_with_guide(coefficient: float, phi: float = 0.6, w: float = 12.0) -> Scene:
    """Problem N07: a slider-crank of slender bars whose guide has friction, started at phi and w."""
    crank, rod_length = 0.15, 0.56
    tilt = math.asin(crank * math.sin(phi) / rod_length)
    about = {"axis": [0, -1, 0]}
    return scene(
        {"crank": rod(0.5, crank), "rod": rod(0.8, rod_length), "slider": body(1.5)},
        {
            "A": joint(
                "revolute",
                frame("ground"),
                frame("crank"),
                start={"phi": phi, "w": w, "fixed": True},
                **about,
            ),
            "B": joint(
                "revolute", frame("crank", (crank, 0, 0)), frame("rod"), start={"phi": -phi - tilt}, **about
            ),
            "guide": joint(
                "prismatic",
                frame("ground"),
                frame("slider"),
                axis=[1, 0, 0],
                start={"s": crank * math.cos(phi) + rod_length * math.cos(tilt)},
                friction={"coulomb": 0.0, "bearing": {"coefficient": coefficient}},
            ),
            "C": joint("revolute", frame("slider"), frame("rod", (rod_length, 0, 0)), **about),
        },
        gravity=[0, 0, -GRAVITY],
    )


@dataclass(frozen=True)
class Motion:
    """Angles of the bars, their rates, and their second derivatives by the crank's angle."""

    angles: Array
    rates: Array  # of each angle by the crank's
    curvatures: Array


def kinematics(phi: float) -> Motion:
    """Return the motion of the bars with the crank at phi [rad], coupler above the line to D."""
    a, b, c, g = LINKS
    to_D = np.array([g - a * math.cos(phi), -a * math.sin(phi)])
    diagonal = float(np.hypot(*to_D))
    opening = math.acos((b**2 + diagonal**2 - c**2) / (2 * b * diagonal))
    theta = math.atan2(to_D[1], to_D[0]) + opening
    tip = np.array([a * math.cos(phi) + b * math.cos(theta) - g, a * math.sin(phi) + b * math.sin(theta)])
    psi = math.atan2(tip[1], tip[0])
    # a e(phi) + b e(theta) = g + c e(psi), differentiated once and twice.
    across = [np.array([-math.sin(x), math.cos(x)]) for x in (phi, theta, psi)]
    along = [np.array([math.cos(x), math.sin(x)]) for x in (phi, theta, psi)]
    matrix = np.column_stack([b * across[1], -c * across[2]])
    first = np.linalg.solve(matrix, -a * across[0])
    rates = np.array([1.0, *first])
    second = np.linalg.solve(
        matrix, a * along[0] + b * rates[1] ** 2 * along[1] - c * rates[2] ** 2 * along[2]
    )
    return Motion(np.array([phi, theta, psi]), rates, np.array([0.0, *second]))


def joint_rates(motion: Motion) -> Array:
    """Return the rates of A, B, C, D by the crank's angle."""
    phi, theta, psi = motion.rates
    return np.array([phi, theta - phi, psi - theta, psi])


def accelerate(phi: float, w: float, directions: Array) -> tuple[float, Array]:
    """Return the crank's acceleration, and the friction torques in A, B, C, D on their later bar."""
    motion = kinematics(phi)
    lengths = np.array(LINKS[:3])
    e = [np.array([math.cos(x), math.sin(x)]) for x in motion.angles]
    n = [np.array([-math.sin(x), math.cos(x)]) for x in motion.angles]
    # The center of each bar: of the rocker from D, of the coupler from the crank's tip.
    from_bars = [[(0, 0.5)], [(0, 1.0), (1, 0.5)], [(2, 0.5)]]
    # Unknowns: acceleration; forces in A on the crank, in B on the coupler, in C on the rocker, in D on it.
    rows, right = np.zeros((9, 9)), np.zeros(9)
    on = [[(0, 1.0, 0.0), (1, -1.0, 1.0)], [(1, 1.0, 0.0), (2, -1.0, 1.0)], [(2, 1.0, 1.0), (3, 1.0, 0.0)]]
    torques_on = np.zeros((3, 4))
    torques_on[0, 0] = torques_on[1, 1] = torques_on[2, 2] = torques_on[2, 3] = 1
    torques_on[0, 1] = torques_on[1, 2] = -1
    for i in range(3):
        slope, bend = np.zeros(2), np.zeros(2)
        for k, part in from_bars[i]:
            r = part * lengths[k]
            slope += r * motion.rates[k] * n[k]
            bend += r * (motion.curvatures[k] * n[k] - motion.rates[k] ** 2 * e[k])
        inertia = MASSES[i] * lengths[i] ** 2 / 12
        rows[3 * i : 3 * i + 2, 0] = -MASSES[i] * slope
        right[3 * i : 3 * i + 2] = MASSES[i] * (bend * w**2 + np.array([0, GRAVITY]))
        rows[3 * i + 2, 0] = -inertia * motion.rates[i]
        right[3 * i + 2] = inertia * motion.curvatures[i] * w**2
        for k, sign, part in on[i]:
            arm = (part - 0.5) * lengths[i] * e[i]
            rows[3 * i : 3 * i + 2, 1 + 2 * k : 3 + 2 * k] += sign * np.eye(2)
            rows[3 * i + 2, 1 + 2 * k : 3 + 2 * k] += sign * np.array([-arm[1], arm[0]])
    torque = np.zeros(4)
    for _ in range(60):
        load = right.copy()
        load[2::3] -= torques_on @ torque
        found = np.linalg.solve(rows, load)
        sizes = np.hypot(found[1::2], found[2::2])
        after = -directions * RADIUS * np.array(COEFFICIENTS) * sizes
        if np.abs(after - torque).max() <= 1e-16 * max(1.0, np.abs(after).max()):
            break
        torque = after
    return float(found[0]), torque


def four_bar_truth(times: Array, phi: float = START_PHI, w: float = START_W) -> tuple[Array, int]:
    """Return (phi, w) of the crank at these times, and how often a joint reverses.

    The crank must not come to rest later.
    """
    t, y = 0.0, np.array([phi, w])
    out = np.zeros((len(times), 2))
    reversals = 0
    # From rest, joints move as they do a little later, also those that begin to do so by the curvature alone.
    forward = np.sign(w) if w != 0 else np.sign(accelerate(phi, 0.0, np.zeros(4))[0])
    later = phi if w != 0 else phi + 1e-6 * forward
    directions = np.sign(joint_rates(kinematics(later)) * forward)
    while t < times[-1]:

        def slow(k: int) -> Any:
            def event(_t: float, state: Array) -> float:
                return float(directions[k] * joint_rates(kinematics(state[0]))[k] * state[1])

            event.terminal = True  # type: ignore[attr-defined]
            event.direction = -1  # type: ignore[attr-defined]
            return event

        solution = solve_ivp(
            lambda _t, s: np.array([s[1], accelerate(s[0], s[1], directions)[0]]),
            (t, float(times[-1])),
            y,
            method="DOP853",
            rtol=1e-13,
            atol=1e-14,
            events=[slow(k) for k in range(4)],
            dense_output=True,
            max_step=0.02,
        )
        inside = (times >= t) & (times <= solution.t[-1])
        if inside.any():
            out[inside] = solution.sol(times[inside]).T
        t, y = float(solution.t[-1]), solution.y[:, -1]
        for k, found in enumerate(solution.t_events):
            if len(found) > 0:
                directions[k] = -directions[k]
                reversals += 1
    return out, reversals
