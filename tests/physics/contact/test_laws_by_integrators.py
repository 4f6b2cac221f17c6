# SPDX-License-Identifier: BSD-3-Clause
"""Laws of joints and contacts by every integrator that locates events: to its tolerance, or to its order."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import warned
from models import contact_law_cases, joint_law_cases, laws_that_meet
from models.both_schemes import STEPS, Case, Outputs, deviations, located, run
from models.registered_laws import INTEGRATORS

from gelenk.chart.methods import FIXED_STEP

ALL: dict[str, Callable[[], Case]] = {
    **joint_law_cases.CASES,
    **contact_law_cases.CASES,
    **laws_that_meet.CASES,
}
CASES = (
    "Stribeck's curve",
    "clutch",
    "friction in a loop",
    "limit with friction, spring and damper",
    "one-way clutch and friction",
    "stops of limited damping",
    "two limits struck together at 0.1, newton",
    "two limits struck together at 0.1, poisson",
    "ball that bounces with spin",
    "two balls graze each other",
    "sphere slides, then rolls",
    "box tipped while it slides",
    "box on a belt",
    "brake of a wheel on the ground",
    "one-way clutch that drives a wheel on the ground",
    "unlike restitutions of two feet",
    "limit at 0.05 m struck through a contact, 0.6 and 0.5",
)
# Located events in fixed steps; those of moreau-jean are compared in test_laws_in_steps.py.
LOCATING = FIXED_STEP - {"moreau-jean"}
ADAPTIVE = set(INTEGRATORS) - FIXED_STEP - {"auto"}
TOLERANCE = 1e-8
# Orders of those with fixed steps, and bounds of their errors in the coarse ones, which are largest at stops:
# of their vibration, with 17 rad/s and a damper of twice the critical damping, h k/d is 0.01.
ORDERS = {
    "euler": (1, 0.2),
    "rk4": (4, 1e-6),
    "generalized-alpha": (2, 1e-3),
    "hht": (2, 1e-3),
    "newmark": (2, 1e-3),
}
# Below a slip of 1e-6 in steps of fixed length, friction keeps its direction (docs/located-events.md).
FLOOR = 1e-6


@pytest.fixture(scope="module", params=CASES)
def followed(request: pytest.FixtureRequest) -> tuple[Case, Outputs]:
    """A case, and its outputs by `auto` at a tight tolerance."""
    case = ALL[request.param]()
    return case, located(case)


@warned.TIGHT
@pytest.mark.parametrize("integrator", sorted(ADAPTIVE))
def test_adaptive_integrators_agree_to_their_tolerance(
    followed: tuple[Case, Outputs], integrator: str
) -> None:
    """Errors are at most 100 times the tolerance, as those of motions without events."""
    case, exact = followed
    found = deviations(case, run(case, integrator, STEPS[0], TOLERANCE), exact)
    assert max(found.values()) <= 100 * TOLERANCE, max(found, key=lambda name: found[name])


@pytest.mark.parametrize("integrator", sorted(LOCATING))
def test_fixed_steps_agree_to_their_order(followed: tuple[Case, Outputs], integrator: str) -> None:
    """Events end steps, so that none of them reduces the order."""
    case, exact = followed
    order, bound = ORDERS[integrator]
    for step in STEPS:
        found = deviations(case, run(case, integrator, step), exact)
        allowed = max(FLOOR, bound * (step / STEPS[0]) ** order)
        assert max(found.values()) <= allowed, (step, max(found, key=lambda name: found[name]))


def test_every_integrator_with_fixed_steps_has_an_order() -> None:
    """All others that the schema lists choose their steps, but for `auto` and time stepping."""
    assert set(ORDERS) == LOCATING
    assert set(INTEGRATORS) == LOCATING | ADAPTIVE | {"auto", "moreau-jean"}
    assert len(ADAPTIVE) >= 5
