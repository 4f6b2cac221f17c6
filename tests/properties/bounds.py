# SPDX-License-Identifier: BSD-3-Clause
"""Settings for property-based tests: each run uses the same examples, so that failures are reproducible."""

from __future__ import annotations

from hypothesis import HealthCheck, settings


def examples(count: int) -> settings:
    """Examples are derived from the test's own source; nothing is stored between runs.
    Fixtures of these tests have no state.
    """
    return settings(
        max_examples=count,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )
