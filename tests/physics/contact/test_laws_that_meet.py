# SPDX-License-Identifier: BSD-3-Clause
"""Laws of joints and contacts that act on the same bodies, and their parameters changed in mid-run.

In both schemes: time steps of shrinking size converge to located events, and a restored run continues with
the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from models import contact_law_cases, joint_law_cases, laws_that_meet, registered_laws, tuned_law_cases
from models.both_schemes import GRID, STEPS, Case, Running, assert_steps_converge, deviations, located, run

CASES: dict[str, Callable[[], Case]] = {**laws_that_meet.CASES, **tuned_law_cases.CASES}
ALL = {**CASES, **joint_law_cases.CASES, **contact_law_cases.CASES}


@pytest.mark.parametrize("name", CASES)
def test_steps_converge_to_located_events(name: str) -> None:
    assert_steps_converge(CASES[name]())


@pytest.mark.parametrize(
    ("name", "contact", "law", "pairs"),
    [
        ("brake of a wheel on the ground", "tire", "hub.friction", {(1, 1), (2, 0), (2, 1)}),
        (
            "one-way clutch that drives a wheel on the ground",
            "tire",
            "hub.one_way",
            {(1, -1), (1, 0), (2, -1), (2, 0)},
        ),
        (
            "friction of a guide beside a box that slides",
            "top",
            "P.friction",
            {(1, 0), (1, 1), (2, -1), (2, 0), (2, 1)},
        ),
    ],
)
def test_modes_of_a_contact_and_of_a_joint_occur_together(
    name: str, contact: str, law: str, pairs: set[tuple[int, int]]
) -> None:
    """What sticks or slides in the contact, with what holds, slips or overruns in the joint."""
    outputs = located(CASES[name]()).values
    assert set(zip(outputs[f"{contact}.mode"], outputs[f"{law}.mode"], strict=True)) == pairs


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean"])
@pytest.mark.parametrize("name", tuned_law_cases.CASES)
def test_a_changed_parameter_has_an_effect(name: str, integrator: str) -> None:
    """Far beyond the errors of steps; without one, both schemes would agree as well."""
    case = tuned_law_cases.CASES[name]()
    changed, unchanged = (run(each, integrator, STEPS[0]) for each in (case, replace(case, tuned={})))
    assert max(deviations(case, changed, unchanged).values()) > 2 * case.error


def test_every_tunable_field_of_laws_is_changed() -> None:
    """Those of the registry, but for those of bearings, which steps refuse."""
    changed = {
        parameter.split(".", 1)[1]
        for case in tuned_law_cases.CASES.values()
        for values in case().tuned.values()
        for parameter in values
    }
    tunable = registered_laws.tunable("joints") | registered_laws.tunable("contacts")
    assert {name for name in tunable - changed if not name.startswith("friction.bearing.")} == set()
    assert changed <= tunable


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean"])
@pytest.mark.parametrize("name", ALL)
def test_a_restored_run_continues_with_the_same_bits(name: str, integrator: str) -> None:
    """Saved after each quarter, and restored to a plant that is elsewhere: first to one at its start."""
    case = ALL[name]()
    plant, other = (Running(case, integrator, STEPS[0]) for _ in range(2))
    times = case.times()
    saved: dict[int, bytes] = {}
    rows = []
    for k, t in enumerate(times):
        if k in {len(times) * part // 4 for part in (1, 2, 3)}:
            saved[k] = plant.plant.save()
        rows.append(plant.advance(t))
    for k, state in saved.items():
        other.restore(state, times[k] - GRID)
        continued = [other.advance(t) for t in times[k:]]
        assert np.array(continued).tobytes() == np.array(rows[k:]).tobytes(), times[k]
