# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of the measurements; SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from benchmarks.speed.tree import Array, Body, Closure, Spring, Tree

CHAINS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
WINDOWS = (1, 2, 5, 10, 20, 40, 100, 300, 1000)
GRAVITY_Z = (0.0, 0.0, -9.81)
Z = (0.0, 0.0, 1.0)


def rod(mass: float, length: float) -> Array:
    """Return the inertia of a thin rod along x about its center; 1e-4 m L^2 about its axis."""
    across = mass * length**2 / 12
    return np.diag([1e-4 * mass * length**2, across, across])


def chain(n: int, spatial: bool) -> Tree:
    """Return n rods of 1 m and 1 kg in a line; spatial: every second axis is tilted by 60 degrees."""
    tree = Tree(f"chain_{'s' if spatial else 'p'}_{n}", 2.0, 0.1)
    inertia = rod(1, 1) + (np.diag([0.01, 0, 0]) if spatial else 0)
    for i in range(n):
        leans = spatial and i % 2 == 1
        axis = (0, math.sin(math.pi / 3), math.cos(math.pi / 3)) if leans else Z
        tree.add(Body(f"b{i}", i - 1, False, axis, (1 if i else 0, 0, 0), 1, (0.5, 0, 0), inertia))
    return tree


def four_bar() -> Tree:
    """Return a four-bar: crank 0.5, coupler 1.75, rocker 1.5, ground 2 m; 2 kg/m; constant torque and
    friction on the crank.
    """
    a, b, c, d, density = 0.5, 1.75, 1.5, 2.0, 2.0
    crank = math.pi / 2
    to_rocker = np.array([d, 0.0]) - a * np.array([math.cos(crank), math.sin(crank)])
    span = float(np.hypot(*to_rocker))
    coupler = math.atan2(to_rocker[1], to_rocker[0]) + math.acos(
        (b * b + span * span - c * c) / (2 * b * span)
    )
    pin = np.array([b * math.cos(coupler), b * math.sin(coupler)]) - to_rocker
    tree = Tree("fourbar", 5.0, 0.1)

    def bar(name: str, parent: int, x: float, length: float, q: float) -> Body:
        mass = density * length
        return Body(name, parent, False, Z, (x, 0, 0), mass, (length / 2, 0, 0), rod(mass, length), q=q)

    first = tree.add(bar("crank", -1, 0, a, crank))
    tree.bodies[first].tau, tree.bodies[first].damping = 3.0, 0.1
    second = tree.add(bar("coupler", first, a, b, coupler - crank))
    third = tree.add(bar("rocker", -1, d, c, math.atan2(pin[1], pin[0])))
    tree.closures.append(Closure(second, (b, 0, 0), third, (c, 0, 0), "xy"))
    return tree


def slider_crank() -> Tree:
    """Return a slider-crank: crank 0.3, rod 0.9 m; constant torque and friction on the crank."""
    r, length, crank = 0.3, 0.9, math.pi / 4
    lean = -math.asin(r * math.sin(crank) / length)
    tree = Tree("slidercrank", 5.0, 0.1)
    tree.add(Body("crank", -1, False, Z, (0, 0, 0), 1, (r / 2, 0, 0), rod(1, r), q=crank, tau=2.0,
                  damping=0.05))  # fmt: skip
    tree.add(Body("rod", 0, False, Z, (r, 0, 0), 2, (length / 2, 0, 0), rod(2, length), q=lean - crank))
    place = r * math.cos(crank) + length * math.cos(lean)
    tree.add(Body("slider", -1, True, (1, 0, 0), (0, 0, 0), 1.5, (0, 0, 0), 0.01 * np.eye(3), q=place))
    tree.closures.append(Closure(1, (length, 0, 0), 2, (0, 0, 0), "xy"))
    return tree


def windows(n: int) -> Tree:
    """Return the N-four-bar (IFToMM A02): n + 1 upright cranks at -1 rad/s, n couplers; 1 m and 1 kg each."""
    tree = Tree(f"nfourbar_{n}", 10.0, 0.1)
    cranks, couplers = [], []
    for i in range(n + 1):
        crank = Body(f"V{i}", -1, False, Z, (i, 0, 0), 1, (0.5, 0, 0), rod(1, 1), q=math.pi / 2, v=-1.0)
        cranks.append(tree.add(crank))
        if i < n:
            coupler = Body(f"H{i}", cranks[i], False, Z, (1, 0, 0), 1, (0.5, 0, 0), rod(1, 1), q=-math.pi / 2,
                           v=1.0)  # fmt: skip
            couplers.append(tree.add(coupler))
    tree.closures += [Closure(couplers[i], (1, 0, 0), cranks[i + 1], (1, 0, 0), "xy") for i in range(n)]
    return tree


def _leg_frame(base: Array, top: Array, angle: float) -> tuple[Array, float]:
    along = top - base
    length = float(np.linalg.norm(along))
    along = along / length
    y = np.cross([0, 0, 1.0], [math.cos(angle), math.sin(angle), 0])
    x = np.cross(y, along)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(along, x), along], axis=1), length


def stewart() -> Tree:
    """Return a Stewart platform: six legs of two hinges and a slide; the first carries the platform by three
    hinges, the others end in ball joints at it. Springs, dampers and sinusoidal forces along the legs.
    """
    tree = Tree("stewart", 2.0, 0.1, GRAVITY_Z)
    height, platform = 1.0, 40.0
    base = np.deg2rad([-10.0, 10, 110, 130, 230, 250])
    top = np.deg2rad([-50.0, 50, 70, 170, 190, 290])
    feet = np.stack([np.cos(base), np.sin(base), 0 * base], axis=1)
    heads = np.stack([0.6 * np.cos(top), 0.6 * np.sin(top), height + 0 * top], axis=1)
    tops, plate = [], -1
    small = 1e-3 * np.eye(3)
    for j in range(6):
        R, length = _leg_frame(feet[j], heads[j], float(base[j]))
        foot = tree.add(Body(f"u{j}", -1, False, (1, 0, 0), feet[j], 0.5, (0, 0, 0), small, R))
        lower = tree.add(Body(f"low{j}", foot, False, (0, 1, 0), (0, 0, 0), 5.0, (0, 0, 0.3),
                              np.diag([0.15, 0.15, 0.005])))  # fmt: skip
        weight = (platform + 6 * 4) * 9.81 / 6 / R[2, 2]
        tops.append(tree.add(Body(
            f"up{j}", lower, True, Z, (0, 0, 0), 3.0, (0, 0, -0.3), np.diag([0.09, 0.09, 0.002]), q=length,
            tau=float(weight), amplitude=60.0, omega=2 * math.pi * (1 + 0.15 * j), phase=0.7 * j,
            damping=200.0, stiffness=5000.0, reference=length,
        )))  # fmt: skip
        if j == 0:
            s1 = tree.add(Body("s1", tops[0], False, (1, 0, 0), (0, 0, 0), 0.1, (0, 0, 0), small, R.T))
            s2 = tree.add(Body("s2", s1, False, (0, 1, 0), (0, 0, 0), 0.1, (0, 0, 0), small))
            middle = np.array([0, 0, height]) - heads[0]
            plate = tree.add(Body("platform", s2, False, Z, (0, 0, 0), platform, middle,
                                  np.diag([4.0, 4.0, 8.0])))  # fmt: skip
    for j in range(1, 6):
        tree.closures.append(Closure(tops[j], (0, 0, 0), plate, heads[j] - heads[0], "xyz"))
    return tree


# Franka Emika's Panda, hand and fingers fixed to its last link: position of the joint in its parent, rotation
# about x in quarter turns (0, 1, -1), mass, center of mass, inertia about it (xx, yy, zz, xy, xz, yz). From
# the URDF of the Python package example-robot-data, by pinocchio.buildReducedModel.
PANDA: Sequence[tuple[Sequence[float], int, float, Sequence[float], Sequence[float]]] = (
    ((0, 0, 0.333), 0, 4.970684, (0.003875, 0.002081, -0.04762),
     (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    ((0, 0, 0), -1, 0.646926, (-0.003141, -0.02872, 0.003495),
     (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    ((0, -0.316, 0), 1, 3.228604, (0.027518, 0.039252, -0.066502),
     (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    ((0.0825, 0, 0), 1, 3.587895, (-0.05317, 0.104419, 0.027454),
     (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    ((-0.0825, 0.384, 0), -1, 1.225946, (-0.011953, 0.041065, -0.038437),
     (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)),
    ((0, 0, 0), 1, 1.666555, (0.060149, -0.014117, -0.010517),
     (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    ((0.088, 0, 0), 1, 1.495522, (0.0017208742976286579, 0.00136035441716123, 0.1004852811486558),
     (0.016529853712634626, 0.014107248642161839, 0.006676955556640956, 0.0003948922971191777,
      -0.0007066957106145017, -0.001051105327046708)),
)  # fmt: skip


def arm() -> Tree:
    """Return the Panda arm with sinusoidal torques and friction in all seven joints."""
    tree = Tree("arm7", 2.0, 0.1, GRAVITY_Z)
    starts = (0, -0.785, 0, -2.356, 0, 1.571, 0.785)
    amplitudes = (20, 20, 15, 15, 3, 3, 2)
    for j, (place, turn, mass, com, moments) in enumerate(PANDA):
        xx, yy, zz, xy, xz, yz = moments
        R = [[1, 0, 0], [0, 0, -turn], [0, turn, 0]] if turn else None
        tree.add(Body(
            f"link{j + 1}", j - 1, False, Z, place, mass, com, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], R,
            q=starts[j], amplitude=amplitudes[j], omega=3.0 + j, phase=0.3 * (j + 1), damping=0.5,
        ))  # fmt: skip
    return tree


def governor() -> Tree:
    """Return the flyball governor (IFToMM benchmark A05): a shaft at 1 revolution/s, a slider on it, two rods
    with balls, springs and dampers of 8e5 N/m and 4e4 N s/m between the rods and the slider.
    """
    tree = Tree("governor", 10.0, 0.1)
    m = 3000 * 0.01**2
    along, across = m * 0.01**2 / 6, m * (1 + 0.01**2) / 12
    tree.add(Body("shaft", -1, False, (0, 1, 0), (0, 0, 0), m, (0, 0.5, 0), np.diag([across, along, across]),
                  v=2 * math.pi))  # fmt: skip
    sleeve = 3000 * 0.1**3
    tree.add(Body("slider", 0, True, (0, 1, 0), (0, 0, 0), sleeve, (0, 0, 0),
                  np.eye(3) * sleeve * 0.01 / 6, q=0.5))  # fmt: skip
    whole = m + 5.0
    low = -(m * 0.5 + 5.0) / whole
    moment = across + m * (low + 0.5) ** 2 + 5 * (low + 1) ** 2
    for k, side in enumerate((1, -1)):
        body = Body(f"rod{k + 1}", 0, False, (0, 0, side), (0.05 * side, 1, 0), whole, (0, low, 0),
                    np.diag([moment, along, moment]), q=math.radians(60))  # fmt: skip
        i = tree.add(body)
        tree.springs.append(Spring(i, (0, -0.5, 0), 1, (0.05 * side, 0, 0), 8e5, 4e4, 0.5))
    return tree


def bricard() -> Tree:
    """Return the rectangular Bricard mechanism (IFToMM benchmark A04): rods of 1 m, 1 kg, 0.1 m thick."""
    tree = Tree("bricard", 10.0, 0.1)
    points = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1.0]])
    axes = [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    last = -1
    for i in range(5):
        span = points[i + 1] - points[i]
        inertia = np.eye(3) * (1 + 0.01) / 12
        k = int(np.argmax(np.abs(span)))
        inertia[k, k] = 0.01 / 6
        before = points[i - 1] if i else np.zeros(3)
        last = tree.add(Body(f"rod{i}", last, False, axes[i], points[i] - before, 1, span / 2, inertia))
    tip, beside = points[5] - points[4], np.array([0.5, 0, 0])
    tree.closures.append(Closure(last, tip, -1, points[5], "xyz"))
    tree.closures.append(Closure(last, tip + beside, -1, points[5] + beside, "yz"))
    return tree


def andrews() -> Tree:
    """Return Andrews' squeezer (Schiehlen 1990; Test Set for IVP Solvers): seven bodies, three loops."""
    tree = Tree("andrews", 0.03, 1e-3, (0.0, 0.0, 0.0))

    def bar(name: str, parent: int, place: tuple[float, float], mass: float, com: tuple[float, float],
            about: float, q: float) -> int:  # fmt: skip
        inertia = np.diag([about / 2, about / 2, about])
        return tree.add(Body(name, parent, False, Z, (*place, 0), mass, (*com, 0), inertia, q=q))

    A, B = (-0.06934, -0.00227), (-0.03635, 0.03273)
    k1 = bar("K1", -1, (0, 0), 0.04325, (0.00092, 0), 2.194e-6, -0.06171389001427645)
    tree.bodies[k1].tau = 0.033
    k2 = bar("K2", k1, (0.007, 0), 0.00365, (-0.0115, 0), 4.41e-7, 0.0)
    k3 = bar("K3", -1, B, 0.02373, (0.01043, -0.01874), 5.255e-6, 0.45527981916307037)
    k5 = bar("K5", -1, A, 0.0705, (0.02308, 0.00916), 1.169e-5, 0.48736497954384256)
    k4 = bar("K4", k5, (0.04, 0), 0.00706, (0, -0.00579), 5.667e-7, 0.22266839016588588)
    k7 = bar("K7", -1, A, 0.05498, (0.00449, -0.01228), 1.912e-5, 1.2305474445498212)
    k6 = bar("K6", k7, (0, -0.04), 0.00706, (0.00579, 0), 5.667e-7, -0.22266839016588588)
    for i, tip in ((k3, (0, -0.035, 0)), (k4, (0, -0.02, 0)), (k6, (0.02, 0, 0))):
        tree.closures.append(Closure(k2, (-0.028, 0, 0), i, tip, "xy"))
    tree.springs.append(Spring(k3, (0.02, -0.018, 0), -1, (0.014, 0.072, 0), 4530, 0, 0.07785))
    return tree


SINGLE: dict[str, Callable[[], Tree]] = {
    "fourbar": four_bar,
    "slidercrank": slider_crank,
    "arm7": arm,
    "stewart": stewart,
    "bricard": bricard,
    "governor": governor,
    "andrews": andrews,
}
FAMILIES: dict[str, dict[int, Callable[[], Tree]]] = {
    "chain_p": {n: partial(chain, n, False) for n in CHAINS},
    "chain_s": {n: partial(chain, n, True) for n in CHAINS},
    "nfourbar": {n: partial(windows, n) for n in WINDOWS},
}
MAKERS: dict[str, Callable[[], Tree]] = SINGLE | {
    f"{family}_{n}": make for family, members in FAMILIES.items() for n, make in members.items()
}


def make(name: str) -> Tree:
    """Return the mechanism with this name."""
    return MAKERS[name]()
