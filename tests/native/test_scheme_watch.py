# SPDX-License-Identifier: BSD-3-Clause
"""When `auto` leaves located events for steps with impulses, and when it returns: at each threshold."""

from typing import Any

import pytest

STEP = 1e-3  # s


def test_points_of_contact(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    assert not watch.are_too_many(16)
    assert watch.are_too_many(17)


def test_events_of_contacts(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    watch.located(STEP, 100)
    assert not watch.are_too_many(0)
    watch.located(0, 1)
    assert watch.are_too_many(0)


@pytest.mark.parametrize(("step", "counted"), [(1e-4, 1e-4), (1e-3, 1e-3), (1e-2, 1e-3)])
def test_what_is_long_ago_does_not_count(units: Any, step: float, counted: float) -> None:
    """Forty events every hundred steps add up to 40 / (1 - exp(-1/2)) = 101.7, 39 to 99.1.

    Steps of more than 1 ms do not count as such: 160 events per second are few, however long the steps.
    """
    for events, too_many in ((39, False), (40, True)):
        watch = units.SchemeWatch(step)
        for _ in range(50):
            watch.located(100 * counted, events)
        assert watch.are_too_many(0) == too_many


def test_quiet_steps(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    watch.leave_events()
    assert not watch.stepped(49 * STEP, False, 12)
    assert watch.stepped(STEP, False, 12)
    watch.return_to_events()
    watch.located(200 * STEP, 0)
    watch.leave_events()
    assert not watch.stepped(49 * STEP, False, 12)
    assert not watch.stepped(STEP, True, 12)
    assert not watch.stepped(49 * STEP, False, 12)
    assert watch.stepped(STEP, False, 12)


def test_short_steps_count_by_their_time(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    watch.leave_events()
    for _ in range(499):
        assert not watch.stepped(STEP / 10, False, 0)
    assert watch.stepped(STEP / 10, False, 0)


def test_points_of_contact_that_are_many_are_not_quiet(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    watch.leave_events()
    assert not watch.stepped(1000 * STEP, False, 13)
    assert watch.stepped(50 * STEP, False, 12)


def test_short_returns_need_twice_the_quiet(units: Any) -> None:
    watch = units.SchemeWatch(STEP)
    watch.leave_events()
    for quiet in (50, 100, 200, 400, 800, 1600, 3200, 3200):
        assert not watch.stepped((quiet - 1) * STEP, False, 0)
        assert watch.stepped(STEP, False, 0)
        watch.return_to_events()
        watch.located(199 * STEP, 0)
        watch.leave_events()
    watch.stepped(3200 * STEP, False, 0)
    watch.return_to_events()
    watch.located(200 * STEP, 0)
    watch.leave_events()
    assert watch.stepped(50 * STEP, False, 0)
