# SPDX-License-Identifier: BSD-3-Clause
"""Laws of whatever acts along a coordinate: motors, and what joints have of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gelenk._core import elements

from . import laws
from .laws import QUOTIENT, ROUND_OFF, STEP, Case
from .test_force_laws import power_of_two

SECTIONS = ("motors", "joints")
CASES = [case for section in SECTIONS for case in laws.all_cases(section)]
GENERAL = [case for section in SECTIONS for kind in laws.KINDS[section] for case in laws.general_cases(kind)]
every_case = pytest.mark.parametrize("case", CASES, ids=str)

# Where it stands and how it moves: random, zero, round, far beyond any bound.
RNG = np.random.default_rng(19)
STATES = [
    (0.0, 0.0),
    (0.0, 1.3),
    (np.pi, -1.0),
    (-4.1, 0.7),
    (-4.1, -0.7),
    (5.3, 0.9),
    (5.3, -0.9),
    (-5.0, 0.0),
]
STATES += [(float(q), float(v)) for q, v in RNG.uniform(-3, 3, (24, 2))]


def inputs_of(along: Any) -> laws.Array:
    count = sum(group["size"] for group in along.inputs)
    return np.array(np.random.default_rng(5).uniform(-2, 2, count))


def has_a_kink(along: Any, q: float, v: float, u: laws.Array) -> bool:
    """Whether the effort or its derivatives jump within a step of differences."""
    near = [(q + a, v + b) for a in (-STEP, 0, STEP) for b in (-STEP, 0, STEP)]
    about = [along.derivatives_by_duals(*at, u) for at in near]
    efforts = [along.effort(*at, u) for at in near]
    slope = 1 + float(np.abs(about).max())
    return not np.allclose(about, about[0], atol=1e-3) or np.ptp(efforts) > 10 * STEP * slope


def test_damper_and_spring_supply_their_derivatives() -> None:
    """Recursive Jacobians use them; without them they would silently fall back on dual numbers."""
    supplied = {case.kind["name"] for case in CASES if case.along.jacobians(0.3, 0.2) is not None}
    assert supplied == {"damping", "stiffness"}


@every_case
def test_derivatives_are_those_of_the_effort(case: Case) -> None:
    """By hand, by dual numbers and by differences, the inputs' too."""
    along = case.along
    u = inputs_of(along)
    smooth = 0
    for q, v in STATES:
        by_duals = np.array(along.derivatives_by_duals(q, v, u))
        scale = 1 + abs(along.effort(q, v, u)) + float(np.abs(by_duals).max())
        by_hand = along.jacobians(q, v)
        if by_hand is not None:
            assert_allclose(by_hand, by_duals[:2], atol=ROUND_OFF * scale)
        if has_a_kink(along, q, v, u):
            continue
        smooth += 1
        x = np.array([q, v, *u])
        quotients = []
        for unit in STEP * np.eye(len(x)):
            up, down = (along.effort(y[0], y[1], y[2:]) for y in (x + unit, x - unit))
            quotients.append((up - down) / (2 * STEP))
        assert_allclose(by_duals, quotients, atol=QUOTIENT * scale)
    assert smooth > len(STATES) / 2


@every_case
def test_energy_is_lost_to_dampers_alone(case: Case) -> None:
    """Without inputs effort v + dE/dt <= 0, and = 0 without dampers."""
    if laws.is_formula(case):
        pytest.skip("its power is the user's")
    undamped = case.without(*(f["name"] for f in case.fields if laws.is_damping(f)))
    for of in (case, undamped):
        u = np.zeros_like(inputs_of(of.along))
        for q, v in STATES:
            rate = (of.along.energy(q + STEP * v) - of.along.energy(q - STEP * v)) / (2 * STEP)
            given = of.along.effort(q, v, u) * v + rate
            # an energy with a jump in its second derivative within the step: differences err by h
            bound = (STEP if has_a_kink(of.along, q, v, u) else QUOTIENT) * (1 + of.along.energy(q)) * 10
            assert given <= bound
            if of is undamped:
                assert given >= -bound


# The force of a limit follows from the equations of motion, peak acts at rest: test_friction_laws.py.
EFFECTIVE = [
    (c, f["name"]) for c in GENERAL if c.kind["name"] != "limit" for f in c.fields if f["name"] != "peak"
]


@pytest.mark.parametrize(("case", "name"), EFFECTIVE, ids=str)
def test_each_number_has_an_effect(case: Case, name: str) -> None:
    """On the effort at some state, or on the inertia that it adds."""
    changed = case.with_number(name, case.numbers[name] * (2 if name == "exponent" else 1.25)).along
    along = case.along
    u = inputs_of(along)
    efforts = [changed.effort(q, v, u) - along.effort(q, v, u) for q, v in STATES]
    assert max(np.abs(efforts)) > 1e-3 or abs(changed.inertia - along.inertia) > 1e-3


@pytest.mark.parametrize("angle", [True, False], ids=["angle", "length"])
@every_case
def test_units_agree(case: Case, angle: bool) -> None:
    """In other units all is as before, to the bit: these are powers of two."""
    if laws.is_formula(case):
        pytest.skip("test_joint_laws.py has lengths from millimeters to kilometers")
    numbers = dict(case.numbers)
    for field in case.fields:
        numbers[field["name"]] *= power_of_two(field["unit"], angle)
    scaled = elements.Along(case.kind["name"], numbers)
    along = case.along
    u = inputs_of(along)
    per_input = np.array([power_of_two(g["unit"], angle) for g in along.inputs for _ in range(g["size"])])
    for q, v in STATES:
        found = scaled.effort(power_of_two("{q}", angle) * q, power_of_two("{v}", angle) * v, per_input * u)
        assert found == power_of_two("{f}", angle) * along.effort(q, v, u)
        assert scaled.energy(power_of_two("{q}", angle) * q) == power_of_two("J") * along.energy(q)
    assert scaled.inertia == power_of_two("{J}", angle) * along.inertia
