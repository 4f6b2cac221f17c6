# SPDX-License-Identifier: BSD-3-Clause
"""Two more examples of the Modelica Standard Library 4.0.0: Translational.Examples.PreLoad and Vehicle."""

from __future__ import annotations

import math

import numpy as np
from mechanisms import Array, frame, joint

from models.drive_cases import Case
from models.drive_elements import Flanks, Friction, Rigid
from models.drive_trains import DriveTrain
from models.modelica_drives import G_N, JUST_BEFORE, masses, relative, rows, sliding


def preload(frequency: float = 2.5) -> Case:
    """Translational.Examples.PreLoad: a spool that holds its position up to a force, by one spring between
    two plates and four gaps; two of these are just closed at the start.

    frequency: of the force [Hz]; 0.01 in Modelica.
    """
    gap = {"stiffness": 1e6, "damping": 250.0, "law": "limited"}
    play = 0.00175
    source = masses(
        {"spool": 0.15, "a": 0.01, "b": 0.01},
        {
            "spool": sliding("ground", "spool", damping=2500.0),
            "a": sliding("ground", "a", stop={"lower": 0.0, **gap}),
            "b": sliding("ground", "b", stop={"upper": play, **gap}),
            "spring": joint("prismatic", frame("a"), frame("b"), axis=[1, 0, 0], stiffness=2e4,
                            spring_reference=0.00325),
            "inner_a": joint("prismatic", frame("spool"), frame("a"), axis=[1, 0, 0],
                             stop={"lower": 0.0, **gap}),
            "inner_b": joint("prismatic", frame("spool"), frame("b"), axis=[1, 0, 0],
                             stop={"upper": play, **gap}),
        },
        motors={"force": {"joint": "spool"}},
    )  # fmt: skip

    def forces(u: Array, q: Array, v: Array) -> Array:
        spring = 2e4 * (q[2] - q[1] - 0.00325)
        return np.array([u[0] - 2500 * v[0], spring, -spring])

    names = ("spool", "a", "b")
    return Case(
        source, {"force.f": 0}, lambda t: np.array([150 * math.sin(2 * math.pi * frequency * t)]),
        0.025 / frequency, 40, np.zeros(3),
        lambda: DriveTrain(
            np.array([0.15, 0.01, 0.01]),
            forces,
            [
                Flanks(rows(3)[1], 0.0, math.inf, 1e6, 250.0, limited=True),
                Flanks(rows(3)[2], -math.inf, play, 1e6, 250.0, limited=True),
                Flanks(relative(3, 0, 1), 0.0, math.inf, 1e6, 250.0, limited=True),
                Flanks(relative(3, 0, 2), -math.inf, play, 1e6, 250.0, limited=True),
            ],
        ),
        lambda s: np.array([s.output(f"{name}.v") for name in names]),
        positions=lambda s: np.array([s.output(f"{name}.s") for name in names]),
    )  # fmt: skip


# Until each time [s]: the drive [nominal forces] and the inclination.
COURSE = [(5, 0, 0), (10.8, 5.6, 0), (20, 1, 0), (25, 2.8, 0.05), (50, 1, 0), (55, -5, 0), (61, 0, 0)]


def vehicle() -> Case:
    """Translational.Examples.Vehicle: one alone, and one with a trailer, against air, rolling and gravity.

    Rolling resistance is dry friction here; Modelica's is proportional to speeds below 1 mm/s.
    """
    m, rolling, drag = 100.0, 0.01 * 100 * G_N, 0.5 * 1.2 / 2
    nominal = 0.5 * 1.18 * (25 / 3.5) ** 2 / 2 + rolling
    friction = {"coulomb": rolling, "input": "engagement"}
    names = ("alone", "tractor", "trailer")
    source = masses(
        dict.fromkeys(names, m),
        {
            **{name: sliding("ground", name, friction=friction) for name in names},
            "hitch": joint("weld", frame("tractor"), frame("trailer")),
        },
        motors={name: {"joint": name} for name in names},
        forces={f"drag_{name}": {"type": "drag", "body": name, "coefficient": drag} for name in names},
    )

    def given(t: float) -> Array:
        drive, incline = next((f, i) for end, f, i in COURSE if t + JUST_BEFORE / 10 < end)
        slope = math.atan(incline)
        down = -m * G_N * math.sin(slope)
        return np.array([drive * nominal + down, 2 * drive * nominal + down, down, math.cos(slope)])

    def resistance(u: Array) -> float:
        return float(rolling * u[3])

    return Case(
        source,
        {f"{name}.f": i for i, name in enumerate(names)} | {f"{n}.friction.engagement": 3 for n in names},
        given, 0.2, 300, np.zeros(3),
        lambda: DriveTrain(
            np.full(3, m),
            lambda u, _q, v: u[:3] - drag * v * np.abs(v),
            [*(Friction(row, resistance, resistance) for row in rows(3)), Rigid(relative(3, 1, 2))],
        ),
        lambda s: np.array([s.output(f"{name}.v") for name in names]),
        jump=JUST_BEFORE,
        positions=lambda s: np.array([s.output(f"{name}.s") for name in names]),
    )  # fmt: skip
