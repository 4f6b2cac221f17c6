# SPDX-License-Identifier: BSD-3-Clause
"""Problems with friction that depends on loads: a hoist with a lossy gear, a four-bar with bearings."""

from __future__ import annotations

from benchmarks.nonsmooth import problems
from benchmarks.nonsmooth.exact_drives import Gear, gear_course
from benchmarks.nonsmooth.loaded_trials import geared
from benchmarks.nonsmooth.problems import Problem

HOIST = Gear((0.1, 1.5), 4.0, 0.6, 1 / 3, -10.0)
# By time [s]: the motor raises the load, holds it, lets it down, brakes it, raises it again.
HOIST_TORQUES = {0.0: 6.0, 1.0: 2.0, 2.5: 0.5, 3.5: 4.0, 5.0: 8.0}


def hoist() -> Problem:
    """Closed form: parabolas between instants at which the load stops and input jumps."""
    times = (0.5, 1.0, 1.5, 2.5, 3.0, 4.0, 5.0, 6.0)
    marks = sorted({*times, *HOIST_TORQUES} - {0.0})
    torques = [HOIST_TORQUES[max(begin for begin in HOIST_TORQUES if begin < t)] for t in marks]
    found, events = gear_course(HOIST, 0.0, marks, torques)
    phi = tuple(x for t, (x, _) in zip(marks, found, strict=True) if t in times)
    about = "A gear with losses raises a load, holds it, lets it down and brakes it; constant torques."
    inputs = {t: {"drive.tau": torque} for t, torque in HOIST_TORQUES.items()}
    return Problem(
        "hoist", "Hoist", about, geared(HOIST, rack=False), {"first.phi": phi}, times, events, 0.0, inputs
    )


COEFFICIENTS = {"A": 0.2, "B": 0.15, "C": 0.25, "D": 0.1}
RADIUS = 0.02  # m


def bearings() -> Problem:
    """The reference was computed with the bars as free bodies (tests/models/bearing_friction.py), by DOP853.

    Its steps had 2.3 ms at the most; with 5 ms, it differs by less than 1e-12.
    """
    scene = problems.four_bar_scene()
    for name, coefficient in COEFFICIENTS.items():
        bearing = {"coefficient": coefficient, "radius": RADIUS}
        scene["joints"][name]["friction"] = {"coulomb": 0.0, "bearing": bearing}
    times = (0.2, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
    phi = (
        3.44975670230915, 6.866338556015055, 11.776047688511005, 15.24006463396691, 19.779569610508396,
        23.022105616908487, 26.286068038899685,
    )  # fmt: skip
    about = (
        "A four-bar with friction in its four bearings in proportion to their reactions, which depend on it."
    )
    return Problem("bearings", "Four-bar with bearings", about, scene, {"A.phi": phi}, times, 16)


def loaded_problems() -> list[Problem]:
    return [hoist(), bearings()]
