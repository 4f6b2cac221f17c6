# SPDX-License-Identifier: BSD-3-Clause
"""When `auto` leaves located events for steps with impulses, and when it returns: at each threshold."""

from typing import Any

import pytest


def test_points_of_contact(units: Any) -> None:
    watch = units.SchemeWatch()
    assert not watch.are_too_many(16)
    assert watch.are_too_many(17)


@pytest.mark.parametrize(("events", "evaluations"), [(100, 0), (0, 30_000), (100, 30_000)])
def test_events_and_evaluations(units: Any, events: int, evaluations: int) -> None:
    watch = units.SchemeWatch()
    watch.located(1, events, evaluations)
    assert not watch.are_too_many(0)
    watch.located(0, int(events > 0), int(evaluations > 0))
    assert watch.are_too_many(0)


def test_what_is_long_ago_does_not_count(units: Any) -> None:
    """Forty events every hundred steps add up to 40 / (1 - exp(-1/2)) = 101.7, 39 to 99.1."""
    for events, too_many in ((39, False), (40, True)):
        watch = units.SchemeWatch()
        for _ in range(50):
            watch.located(100, events, 0)
        assert watch.are_too_many(0) == too_many


def test_quiet_steps(units: Any) -> None:
    watch = units.SchemeWatch()
    watch.leave_events()
    assert not watch.stepped(49, False, 12)
    assert watch.stepped(1, False, 12)
    watch.return_to_events()
    watch.located(200, 0, 0)
    watch.leave_events()
    assert not watch.stepped(49, False, 12)
    assert not watch.stepped(1, True, 12)
    assert not watch.stepped(49, False, 12)
    assert watch.stepped(1, False, 12)


def test_points_of_contact_that_are_many_are_not_quiet(units: Any) -> None:
    watch = units.SchemeWatch()
    watch.leave_events()
    assert not watch.stepped(1000, False, 13)
    assert watch.stepped(50, False, 12)


def test_short_returns_need_twice_the_quiet(units: Any) -> None:
    watch = units.SchemeWatch()
    watch.leave_events()
    for quiet in (50, 100, 200, 400, 800, 1600, 3200, 3200):
        assert not watch.stepped(quiet - 1, False, 0)
        assert watch.stepped(1, False, 0)
        watch.return_to_events()
        watch.located(199, 0, 0)
        watch.leave_events()
    watch.stepped(3200, False, 0)
    watch.return_to_events()
    watch.located(200, 0, 0)
    watch.leave_events()
    assert watch.stepped(50, False, 0)
