# SPDX-License-Identifier: BSD-3-Clause
"""The auditor of reported forces finds each broken law, and on the other side of each bound nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

INF = float("inf")
STICKING = 2.0  # N
FRACTION = 1e-6  # of a limit
FAR = -0.1  # m: depth of what is away from a limit
SLACKS = 1e4  # of the rounding of the forces
STOP = 1e-4  # of velocities


def audited(units: Any, **of: Any) -> tuple[str, float]:
    """What a slider at rest between its limits breaks, and by how much."""
    free = {
        "forces": [0.0, 0.0],
        "speed": 0.0,
        "sticking": STICKING,
        "sliding": STICKING,
        "upper": FAR,
        "lower": FAR,
        "one_way": False,
        "rounding": 0.0,
        "largest": np.inf,
    }
    law, excess = units.broken_law(**(free | of))
    return str(law), float(excess)


def broken(units: Any, **of: Any) -> str:
    return audited(units, **of)[0]


@pytest.mark.parametrize("sign", [1, -1])
def test_friction(units: Any, sign: int) -> None:
    assert not broken(units, forces=[sign * STICKING * (1 + 0.9 * FRACTION), 0.0])
    assert broken(units, forces=[sign * STICKING * (1 + 1.1 * FRACTION), 0.0]) == "friction exceeded"
    rounding = 1e-3 / SLACKS
    assert not broken(units, forces=[sign * (STICKING + 0.9e-3), 0.0], rounding=rounding)
    assert broken(units, forces=[sign * (STICKING + 1.1e-3), 0.0], rounding=rounding)


@pytest.mark.parametrize("sign", [1, -1])
def test_no_force_beyond_all_others_is_rounding(units: Any, sign: int) -> None:
    """Where constraint equations hardly permit a motion, no force has an effect."""
    for rounding in (1e12, np.inf):
        hardly = {"rounding": rounding, "largest": 10.0}
        assert not broken(units, forces=[sign * (STICKING + 9.9), 0.0], **hardly)
        assert broken(units, forces=[sign * 3e9, 0.0], **hardly) == "friction exceeded"
        assert broken(units, forces=[0.0, sign * 3e9], **hardly) == "limit not reached"


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_opposes_the_motion(units: Any, sign: int) -> None:
    assert not broken(units, forces=[-sign * STICKING, 0.0], speed=sign * 1.0)
    assert broken(units, forces=[sign * STICKING, 0.0], speed=sign * 1.0) == "friction along motion"
    assert not broken(units, forces=[sign * STICKING, 0.0], speed=sign * 0.9e-8)  # at rest but for rounding
    assert broken(units, forces=[sign * STICKING, 0.0], speed=sign * 1.1e-8)


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_in_motion_may_exceed_static_friction(units: Any, sign: int) -> None:
    larger = {"speed": sign * 1.0, "sliding": 2 * STICKING}
    assert not broken(units, forces=[-sign * 2 * STICKING * (1 + 0.9 * FRACTION), 0.0], **larger)
    assert (
        broken(units, forces=[-sign * 2 * STICKING * (1 + 1.1 * FRACTION), 0.0], **larger)
        == "friction exceeded"
    )
    at_rest = larger | {"speed": 0.0}
    assert not broken(units, forces=[-sign * STICKING, 0.0], **at_rest)
    assert broken(units, forces=[-sign * 1.1 * STICKING, 0.0], **at_rest) == "friction exceeded"


def test_limits_push_where_they_are_reached(units: Any) -> None:
    assert not broken(units, forces=[0.0, -5.0], upper=0.0)
    assert not broken(units, forces=[0.0, 5.0], lower=0.0)
    assert broken(units, forces=[0.0, 5.0], upper=0.0) == "limit pulls"
    assert broken(units, forces=[0.0, -5.0], lower=0.0) == "limit pulls"
    assert broken(units, forces=[0.0, -5.0]) == "limit not reached"
    assert not broken(units, forces=[0.0, -5.0], upper=-0.9e-8)
    assert broken(units, forces=[0.0, -5.0], upper=-1.1e-8) == "limit not reached"
    assert not broken(units, upper=0.9e-6)
    assert broken(units, upper=1.1e-6) == "limit passed"
    assert broken(units, lower=1.1e-6) == "limit passed"


def test_a_one_way_clutch_holds_in_one_direction(units: Any) -> None:
    assert not broken(units, forces=[0.0, 5.0], upper=-INF, lower=0.0, one_way=True)
    assert broken(units, forces=[0.0, -5.0], upper=-INF, lower=0.0, one_way=True) == "limit pulls"


def test_excess_is_relative_to_what_is_permitted(units: Any) -> None:
    assert audited(units, forces=[STICKING, 0.0])[1] == 0
    for part in (0.5, 0.9, 3.0):
        found = audited(units, forces=[STICKING * (1 + part * FRACTION), 0.0])[1]
        assert found == pytest.approx(part, rel=1e-3)  # a force of 1e-9 is rounding, too
        assert audited(units, upper=part * 1e-6)[1] == pytest.approx(part)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("size", [1e-3, 1.0, 50.0])
def test_what_stops_changes_no_other_velocity(units: Any, sign: int, size: float) -> None:
    largest = STOP * max(size, 1.0)
    before = [size, 1e-12]
    assert units.excess_of_stop(before, [size + sign * 0.99 * largest, 0.0]) < 1
    assert units.excess_of_stop(before, [size + sign * 1.01 * largest, 0.0]) > 1
    assert units.excess_of_stop(before, before) == 0
    rebound = 2 * largest  # one that is too low to matter
    assert units.excess_of_stop(before, [size + sign * 0.99 * rebound, 0.0], rebound) < 1
    assert units.excess_of_stop(before, [size + sign * 1.01 * rebound, 0.0], rebound) > 1
