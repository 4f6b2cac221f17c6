# SPDX-License-Identifier: BSD-3-Clause
"""How many examples a property is tried with: the same ones each time, so that one fails for everybody."""

from __future__ import annotations

from hypothesis import HealthCheck, settings


def examples(count: int) -> settings:
    """Drawn from the test's own text; nothing is kept between runs. Fixtures of these tests have no state."""
    return settings(
        max_examples=count,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )
