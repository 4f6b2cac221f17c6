# SPDX-License-Identifier: BSD-3-Clause
"""Examples of the Modelica Standard Library 4.0.0 with friction, brakes, backlash and stops, as scenes and as
drive trains: of Mechanics.Rotational and Mechanics.Translational.

Sines are linear between the ends of segments. In place of heat ports, power is an output.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mechanisms import Array, Scene, body, frame, joint, scene

import gelenk
from models.drive_cases import Case, shafts, turning
from models.drive_elements import Flanks, Friction, LossyGear, OneWay, Rigid
from models.drive_trains import DriveTrain

JUST_BEFORE = 1e-9  # s: where an input jumps, its value before
G_N = 9.80665


def rows(n: int) -> Array:
    return np.eye(n)


def relative(n: int, a: int, b: int) -> Array:
    """Return the row of b relative to a."""
    out: Array = np.eye(n)[b] - np.eye(n)[a]
    return out


def sliding(parent: str, child: str, s: float = 0.0, v: float = 0.0, **fields: Any) -> dict[str, Any]:
    start = {"s": s, "v": v, "fixed": True}
    return joint("prismatic", frame(parent), frame(child), start=start, axis=[1, 0, 0], **fields)


def masses(of: dict[str, float], joints: dict[str, Any], **sections: Any) -> Scene:
    return scene({name: body(m) for name, m in of.items()}, joints, gravity=[0, 0, 0], **sections)


def no_input(_t: float) -> Array:
    return np.zeros(1)


def backlash() -> Case:
    """Rotational.Examples.Backlash: a spring and damper, ElastoBacklash and ElastoBacklash2 side by side."""
    c, d, half = 2e4, 50.0, math.pi / 8
    stop = {"lower": -half, "upper": half, "stiffness": c, "damping": d}
    start = math.pi / 2
    source = shafts(
        {"one": 5.0, "two": 5.0, "three": 5.0},
        {
            "one": turning("ground", "one", phi=start, stiffness=c, damping=d),
            "two": turning("ground", "two", phi=start, stop={**stop, "law": "limited"}),
            "three": turning("ground", "three", phi=start, stop=stop),
        },
    )

    def torques(_u: Array, phi: Array, w: Array) -> Array:
        return np.array([-c * phi[0] - d * w[0], 0.0, 0.0])

    names = ["one", "two", "three"]
    return Case(
        source, {}, no_input, 0.05, 20, np.zeros(3),
        lambda: DriveTrain(
            np.full(3, 5.0),
            torques,
            [
                Flanks(rows(3)[1], -half, half, c, d, limited=True),
                Flanks(rows(3)[2], -half, half, c, d, limited=False),
            ],
        ),
        lambda s: np.array([s.output(f"{name}.w") for name in names]),
        phi=np.full(3, start),
        positions=lambda s: np.array([s.output(f"{name}.phi") for name in names]),
    )  # fmt: skip


def gear_shift(ring: float = 0.0) -> Case:
    """Rotational.Examples.SimpleGearShift: a planetary gear whose ring a brake holds at first; then a clutch
    connects it to the sun.

    ring: its inertia, 0 in Modelica.
    """
    ratio, rated = 1.5, 10.471975511966
    drag = 20 / rated**2
    friction = {"coulomb": 100.0, "input": "engagement"}
    source = shafts(
        {"sun": 1.0, "arm": 10.0, "ring": ring},
        {
            "sun": turning("ground", "sun"),
            "arm": turning("ground", "arm"),
            "ring": turning("ground", "ring", friction=friction),
            "clutch": joint("revolute", frame("sun"), frame("ring"), friction=friction),
        },
        motors={"engine": {"joint": "sun"}},
        forces={"load": {"type": "moment", "body": "arm", "coefficient": drag}},
        constraints={
            "planets": {"type": "gear", "joint": "sun", "with": "ring", "ratio": -ratio, "carrier": "arm"}
        },
    )

    def given(t: float) -> Array:
        t += JUST_BEFORE / 10
        engaged = min(1.0, max(0.0, (t - 2) / 0.1))
        return np.array([20.0 if t >= 0.5 else 0.0, engaged, 1 - engaged])

    def torques(u: Array, _phi: Array, w: Array) -> Array:
        return np.array([u[0], -drag * w[1] * abs(w[1]), 0.0])

    return Case(
        source,
        {"engine.tau": 0, "clutch.friction.engagement": 1, "ring.friction.engagement": 2},
        given, 0.1, 50, np.zeros(3),
        lambda: DriveTrain(
            np.array([1.0, 10.0, ring]),
            torques,
            [
                Rigid(np.array([1.0, -1 - ratio, ratio])),
                Friction(np.array([-1.0, 0, 1]), lambda u: 100 * u[1], lambda u: 100 * u[1]),
                Friction(np.array([0.0, 0, 1]), lambda u: 100 * u[2], lambda u: 100 * u[2]),
            ],
        ),
        lambda s: np.array([s.output(f"{name}.w") for name in ("sun", "arm", "ring")]),
        jump=JUST_BEFORE,
    )  # fmt: skip


def rotational_heat_losses(wheel: float = 0.0) -> Case:
    """Rotational.Examples.HeatLosses.

    The table of its gear falls from 0.8 at rest to 0.7 at 1 rad/s, and its bearing friction is that of the
    second wheel: 1 N m at rest and 2 N m at 1 rad/s of the first, reduced to this.

    wheel: inertia of the gear's second wheel, 0 in Modelica.
    """
    clutch = {"coulomb": 5.0, "input": "engagement"}
    source = shafts(
        {"one": 2.0, "two": 2.0, "three": 2.0, "four": 2.0, "wheel": wheel, "five": 2.0, "six": 2.0},
        {
            "one": turning("ground", "one", damping=10.0),
            "two": turning("one", "two", stiffness=1e4, damping=20.0),
            "three": turning("ground", "three", friction={"coulomb": 1.0}),
            "flanks": joint(
                "revolute",
                frame("two"),
                frame("three"),
                stop={"lower": -5e-4, "upper": 5e-4, "stiffness": 1e5, "damping": 100.0, "law": "limited"},
            ),
            "four": turning("ground", "four", friction={"coulomb": 0.0}),
            "spring": joint("revolute", frame("three"), frame("four"), stiffness=1e4),
            "wheel": turning("ground", "wheel", friction={"law": "2 + 4*w"}),
            "five": turning("wheel", "five", friction=clutch),
            "six": turning("ground", "six", friction={"coulomb": 1.0, "input": "engagement"}),
            "freewheel": joint(
                "revolute",
                frame("five"),
                frame("six"),
                one_way={"free": "positive"},
                friction={"coulomb": 0.5, "input": "engagement"},
            ),
        },
        motors={"drive": {"joint": "one"}},
        constraints={
            "mesh": {"type": "gear", "joint": "four", "with": "wheel", "ratio": 2.0,
                     "efficiency": "0.8 - 0.1*w",
                     "backdriving": "0.8 - 0.1*w"},
        },
        sensors={f"power_{name}": {"type": "power", "joint": name} for name in LOSSES},
    )  # fmt: skip

    def given(t: float) -> Array:
        return np.array([20 * math.sin(2 * math.pi * 5 * t), math.sin(2 * math.pi * 0.2 * t)])

    def torques(u: Array, phi: Array, w: Array) -> Array:
        first = 1e4 * (phi[1] - phi[0]) + 20 * (w[1] - w[0])
        second = 1e4 * (phi[3] - phi[2])
        return np.array([u[0] - 10 * w[0] + first, -first, second, -second, 0, 0, 0])

    n = 7

    def speeds(s: gelenk.Simulation) -> Array:
        one, wheel = s.output("one.w"), s.output("wheel.w")
        return np.array([
            one, one + s.output("two.w"), s.output("three.w"), s.output("four.w"), wheel,
            wheel + s.output("five.w"), s.output("six.w"),
        ])  # fmt: skip

    return Case(
        source,
        {"drive.tau": 0, **{f"{name}.friction.engagement": 1 for name in ("five", "six", "freewheel")}},
        given, 0.01, 100, np.zeros(n),
        lambda: DriveTrain(
            np.array([2.0, 2, 2, 2, wheel, 2, 2]),
            torques,
            [
                Flanks(relative(n, 1, 2), -5e-4, 5e-4, 1e5, 100.0, limited=True),
                Friction(rows(n)[2], lambda _u: 1.0, lambda _u: 1.0),
                LossyGear(3, 4, 2.0, 0.8, 0.8, worse=0.1),
                Friction(rows(n)[4], lambda _u: 2.0, lambda _u: 2.0, falling=lambda v: 4.0 * v),
                Friction(relative(n, 4, 5), lambda u: 5 * u[1], lambda u: 5 * u[1]),
                OneWay(relative(n, 5, 6), lambda u: 0.5 * u[1], lambda u: 0.5 * u[1]),
                Friction(rows(n)[6], lambda u: u[1], lambda u: u[1]),
            ],
        ),
        speeds,
    )  # fmt: skip


LOSSES = ("three", "five", "six", "freewheel")  # joints without motor and gear


def brake() -> Case:
    """Translational.Examples.Brake: pressed with twice its force at 0.1 s."""
    source = masses(
        {"mass": 1.0},
        {"mass": sliding("ground", "mass", v=1.0, friction={"coulomb": 0.5, "input": "engagement"})},
        sensors={"power": {"type": "power", "joint": "mass"}},
    )
    return Case(
        source, {"mass.friction.engagement": 0},
        lambda t: np.array([2.0 if t + JUST_BEFORE / 10 >= 0.1 else 0.0]), 0.1, 20, np.ones(1),
        lambda: DriveTrain(
            np.ones(1),
            lambda _u, _q, _v: np.zeros(1),
            [Friction(np.ones(1), lambda u: 0.5 * u[0], lambda u: 0.5 * u[0])],
        ),
        lambda s: np.array([s.output("mass.v")]),
        jump=JUST_BEFORE,
        positions=lambda s: np.array([s.output("mass.s")]),
    )  # fmt: skip


def elasto_gap() -> Case:
    """Translational.Examples.ElastoGap: a mass on springs and dampers, and one between two gaps."""
    stop = {"lower": -0.5, "upper": 0.5, "stiffness": 10.0, "damping": 1.5, "law": "limited"}
    source = masses(
        {"one": 1.0, "two": 1.0},
        {
            "one": sliding("ground", "one", s=2.0, stiffness=20.0, damping=3.0),
            "two": sliding("ground", "two", s=2.0, stop=stop),
        },
    )
    return Case(
        source, {}, no_input, 0.1, 50, np.zeros(2),
        lambda: DriveTrain(
            np.ones(2),
            lambda _u, q, v: np.array([-20 * q[0] - 3 * v[0], 0.0]),
            [Flanks(rows(2)[1], -0.5, 0.5, 10.0, 1.5, limited=True)],
        ),
        lambda s: np.array([s.output("one.v"), s.output("two.v")]),
        phi=np.full(2, 2.0),
        positions=lambda s: np.array([s.output("one.s"), s.output("two.s")]),
    )  # fmt: skip


def stribeck(coulomb: float, excess: float, decay: float) -> dict[str, Any]:
    return {"coulomb": coulomb, "static": coulomb + excess, "stribeck": 1 / decay, "exponent": 1}


def falling(excess: float, decay: float) -> Any:
    return lambda v: excess * math.exp(-decay * v)


def translational_friction() -> Case:
    """Translational.Examples.Friction: Stribeck's curve under a sine, and hard stops.

    Its mass with a table of friction is left out: interpolated linearly, it is the first mass.
    """
    source = masses(
        {"one": 1.0, "two": 1.0},
        {
            "one": sliding("ground", "one", friction=stribeck(5.0, 10.0, 2.0), damping=1.0,
                           limit={"lower": -24.5, "upper": 24.5}),
            "two": sliding("ground", "two", v=-5.0, friction=stribeck(3.0, 5.0, 2.0), damping=1.0,
                           limit={"lower": -0.4, "upper": 0.4}, stiffness=500.0, spring_reference=-0.25),
        },
        motors={"force": {"joint": "one"}},
    )  # fmt: skip
    return Case(
        source, {"force.f": 0}, lambda t: np.array([25 * math.sin(math.pi / 2 * t)]),
        0.05, 100, np.array([0.0, -5.0]),
        lambda: DriveTrain(
            np.ones(2),
            lambda u, q, v: np.array([u[0] - v[0], -500 * (q[1] + 0.25) - v[1]]),
            [
                Friction(rows(2)[0], lambda _u: 5.0, lambda _u: 15.0, falling(10.0, 2.0), -24.5, 24.5),
                Friction(rows(2)[1], lambda _u: 3.0, lambda _u: 8.0, falling(5.0, 2.0), -0.4, 0.4),
            ],
        ),
        lambda s: np.array([s.output("one.v"), s.output("two.v")]),
        positions=lambda s: np.array([s.output("one.s"), s.output("two.s")]),
    )  # fmt: skip


def translational_heat_losses() -> Case:
    """Translational.Examples.HeatLosses; positions are displacements from the start."""
    source = masses(
        {"one": 1.0, "two": 1.0, "three": 1.0, "four": 1.0},
        {
            "one": sliding("ground", "one", damping=10.0,
                           stop={"lower": 0.03, "stiffness": 100.0, "damping": 20.0, "law": "limited"}),
            "two": sliding("ground", "two", friction={"coulomb": 1.0}),
            "first": joint("prismatic", frame("one"), frame("two"), axis=[1, 0, 0], stiffness=100.0,
                           damping=10.0),
            "three": sliding("ground", "three", friction={"coulomb": 5.0, "input": "engagement"}),
            "second": joint("prismatic", frame("two"), frame("three"), axis=[1, 0, 0], stiffness=100.0),
            "four": sliding("ground", "four", friction=stribeck(1.0, 2.0, 2.0), damping=0.5,
                            limit={"lower": -0.25, "upper": 0.05}),
            "third": joint("prismatic", frame("three"), frame("four"), axis=[1, 0, 0], stiffness=1e4,
                           damping=1e3),
        },
        motors={"force": {"joint": "one"}},
    )  # fmt: skip

    def given(t: float) -> Array:
        pressed = max(0.0, round(10 * math.sin(2 * math.pi * 2 * t), 12))
        return np.array([20 * math.sin(2 * math.pi * t), pressed])

    def forces(u: Array, q: Array, v: Array) -> Array:
        first = 100 * (q[1] - q[0]) + 10 * (v[1] - v[0])
        second = 100 * (q[2] - q[1])
        third = 1e4 * (q[3] - q[2]) + 1e3 * (v[3] - v[2])
        return np.array([u[0] - 10 * v[0] + first, second - first, third - second, -third - 0.5 * v[3]])

    names = ("one", "two", "three", "four")
    return Case(
        source, {"force.f": 0, "three.friction.engagement": 1}, given, 0.01, 200, np.zeros(4),
        lambda: DriveTrain(
            np.ones(4),
            forces,
            [
                Flanks(rows(4)[0], 0.03, math.inf, 100.0, 20.0, limited=True),
                Friction(rows(4)[1], lambda _u: 1.0, lambda _u: 1.0),
                Friction(rows(4)[2], lambda u: 5 * u[1], lambda u: 5 * u[1]),
                Friction(rows(4)[3], lambda _u: 1.0, lambda _u: 3.0, falling(2.0, 2.0), -0.25, 0.05),
            ],
        ),
        lambda s: np.array([s.output(f"{name}.v") for name in names]),
        positions=lambda s: np.array([s.output(f"{name}.s") for name in names]),
    )  # fmt: skip
