# SPDX-License-Identifier: BSD-3-Clause
"""Cases in which tunable parameters of laws are changed in mid-run, for `both_schemes`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from .both_schemes import GRID, Case
from .contact_law_cases import contact_case, falling, inclined, on_floor, turntable
from .joint_law_cases import between_stops, block
from .laws_that_meet import box_on_a_cart, braked_wheel

EARLY, LATE = 6 * GRID, 15 * GRID  # s


def tuned(case: Case, time: float = LATE, **values: float) -> Case:
    """The case with changed parameters from a time on [s]; J__friction__static is J.friction.static."""
    return replace(case, tuned={time: {name.replace("__", "."): value for name, value in values.items()}})


def dragged(force: float = 1.4, v: float = 0.3, **friction: float) -> Case:
    """A block that a constant force drags over dry friction."""
    return block(lambda _: force, v=v, friction={"coulomb": 0.5, **friction})


def on_a_spring(**fields: float) -> Case:
    return block(lambda _: 0.4, v=0.5, damping=0.7, stiffness=20.0, spring_reference=0.03, **fields)


def sliding() -> Case:
    return contact_case(on_floor("box", {"friction": 0.3, "static": 0.4}, {"v": [0.8, 0.3, 0]}), 0.5)


def spun(law: dict[str, float]) -> Case:
    """A ball that rolls and spins."""
    return contact_case(on_floor("sphere", law, {"v": [0.5, 0, 0], "w": [0, 5, 4]}), 0.9)


ROLLING = {"friction": 0.4, "rolling": 0.004, "spinning": 0.002}
CASES: dict[str, Callable[[], Case]] = {
    "damping": lambda: tuned(on_a_spring(), J__damping=5.0),
    "stiffness": lambda: tuned(on_a_spring(), J__stiffness=50.0),
    "spring reference": lambda: tuned(on_a_spring(), J__spring_reference=-0.1),
    "stiffness of a stop": lambda: tuned(between_stops(), J__stop__stiffness=900.0),
    "damping of a stop": lambda: tuned(between_stops(damping=5.0), J__stop__damping=20.0),
    "sliding friction": lambda: tuned(dragged(static=3.0), J__friction__coulomb=2.0),
    "sliding friction, released": lambda: tuned(dragged(), J__friction__coulomb=0.0),
    "static friction lets go": lambda: tuned(dragged(0.9, 0.0, static=1.1), J__friction__static=0.7),
    "Stribeck velocity": lambda: tuned(dragged(static=1.2, stribeck=0.1), J__friction__stribeck=0.8),
    "restitution of a limit": lambda: tuned(
        block(lambda _: 0.9, v=0.9, limit={"upper": 0.11, "restitution": 0.3}),
        EARLY,
        J__limit__restitution=0.9,
    ),
    "sliding friction of a contact": lambda: tuned(sliding(), EARLY, floor__friction=0.1),
    "sliding friction of a contact, removed": lambda: tuned(sliding(), EARLY, floor__friction=0.0),
    "static friction of a contact lets go": lambda: tuned(
        inclined("box", {"friction": 0.1, "static": 0.3}), EARLY, floor__static=0.15
    ),
    "rolling friction": lambda: tuned(spun(ROLLING), EARLY, floor__rolling=0.02),
    "spinning friction": lambda: tuned(spun(ROLLING), EARLY, floor__spinning=0.01),
    "restitution of a contact": lambda: tuned(
        falling("sphere", {"friction": 0.3, "restitution": 0.3}), 3 * GRID, floor__restitution=0.9
    ),
    "velocity of a belt along x": lambda: tuned(sliding(), EARLY, **{"floor.velocity[1]": -0.4}),
    "velocity of a belt along y": lambda: tuned(sliding(), EARLY, **{"floor.velocity[2]": 0.4}),
    "velocity of a belt along z, which is not up": lambda: tuned(
        turntable(2.0, {"friction": 0.3, "velocity": [0.3, 0, -0.1]}, upright=False),
        2 * GRID,
        **{"top.velocity[3]": 0.4},
    ),
    "friction of a brake beside a sliding contact": lambda: tuned(
        braked_wheel(), 9 * GRID, hub__friction__coulomb=0.5
    ),
    "friction of a contact beside a brake that holds": lambda: tuned(
        braked_wheel(), 9 * GRID, tire__friction=0.1
    ),
    # The box moves little relative to the cart, so that errors are a larger part of that.
    "friction of a contact beside a guide with friction": lambda: replace(
        tuned(box_on_a_cart(), EARLY, top__friction=0.05), error=0.03
    ),
    "friction of a guide beside a contact": lambda: tuned(box_on_a_cart(), EARLY, P__friction__coulomb=0.5),
}
