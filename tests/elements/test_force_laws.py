# SPDX-License-Identifier: BSD-3-Clause
"""Laws that every force between bodies obeys, whatever its kind: the registry lists them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gelenk._core import elements

from . import laws
from .laws import QUOTIENT, ROUND_OFF, STEP, Array, Case, Place, places

CASES = laws.all_cases("forces")
every_force = pytest.mark.parametrize("case", CASES, ids=str)
GENERAL = [case for kind in laws.KINDS["forces"] for case in laws.general_cases(kind)]
every_kind = pytest.mark.parametrize("case", GENERAL, ids=str)
between_two = pytest.mark.parametrize(
    "case", [case for case in CASES if len(case.kind["ports"]) == 2], ids=str
)


def test_there_are_forces_of_both_sorts() -> None:
    """At one port and between two: else some laws here would hold of nothing."""
    assert {len(kind["ports"]) for kind in laws.KINDS["forces"]} == {1, 2}


@between_two
def test_action_is_reaction(case: Case) -> None:
    """The wrenches on both bodies together are none, about any point."""
    for place in places(case.force):
        F = place.act(case.force)
        assert_allclose(F[0][3:] + F[1][3:], 0, atol=ROUND_OFF * laws.scale_of(F, place))
        about_origin = sum(
            n_f[:3] + np.cross(X[:3, 3], n_f[3:]) for n_f, X in zip(F, place.poses, strict=True)
        )
        assert_allclose(about_origin, 0, atol=ROUND_OFF * laws.scale_of(F, place))


def turned(place: Place, X: Array, with_the_world: bool) -> Place:
    """All bodies carried along by a motion X, at rest afterwards."""
    R = X[:3, :3]
    V = [np.concatenate([R @ v[:3], R @ v[3:]]) for v in place.velocities]
    R_0W = R @ place.R_0W if with_the_world else place.R_0W
    return replace(place, poses=[X @ X_P for X_P in place.poses], velocities=V, R_0W=R_0W)


def assert_turned(found: list[Array], before: list[Array], R: Array, atol: float) -> None:
    for new, old in zip(found, before, strict=True):
        assert_allclose(new, np.concatenate([R @ old[:3], R @ old[3:]]), atol=atol)


@every_force
def test_no_frame_is_special(case: Case) -> None:
    """All turned and shifted, the world's axes too: the wrenches turn with it."""
    X = laws.random_pose(np.random.default_rng(2))
    for place in places(case.force):
        before = place.act(case.force)
        after = turned(place, X, with_the_world=True)
        assert_turned(after.act(case.force), before, X[:3, :3], 10 * ROUND_OFF * laws.scale_of(before, after))


@between_two
def test_only_how_two_bodies_are_against_each_other_counts(case: Case) -> None:
    """Both carried along in the world, and moving with a common motion besides."""
    rng = np.random.default_rng(3)
    X, V = laws.random_pose(rng), rng.uniform(-2, 2, 6)
    for place in places(case.force):
        before = place.act(case.force)
        after = turned(place, X, with_the_world=False)
        rates = [
            v + np.concatenate([V[:3], V[3:] + np.cross(V[:3], X_P[:3, 3])])
            for v, X_P in zip(after.velocities, after.poses, strict=True)
        ]
        after = replace(after, velocities=rates)
        assert_turned(after.act(case.force), before, X[:3, :3], 40 * ROUND_OFF * laws.scale_of(before, after))


def lost(case: Case, place: Place) -> tuple[float, float]:
    """Power that is lost, -(sum F . V + dE/dt) [W], and the scale of its error."""
    F = place.act(case.force)
    power = sum(float(f @ v) for f, v in zip(F, place.velocities, strict=True))
    force = case.force
    rate = (force.energy(place.after(STEP)) - force.energy(place.after(-STEP))) / (2 * STEP)
    return -(power + rate), laws.scale_of(F, place) * (1 + abs(force.energy(place.poses)))


def passive(case: Case) -> Case:
    """Without what is a load itself."""
    return case.without(*(f["name"] for f in case.fields if laws.is_load(f)))


@every_force
def test_energy_is_lost_to_dampers_alone(case: Case) -> None:
    """Without loads and inputs power + dE/dt <= 0, and = 0 without dampers."""
    if laws.is_formula(case):
        pytest.skip("its power is the user's")
    case = passive(case)
    undamped = case.without(*(f["name"] for f in case.fields if laws.is_damping(f)))
    for place in places(case.force):
        place = replace(place, inputs=np.zeros_like(place.inputs))
        loss, scale = lost(case, place)
        # third derivatives of a stiff rotational spring near half a turn: up to some hundred of its stiffness
        assert loss >= -100 * QUOTIENT * scale
        if case.force.undefined(place.poses) or undamped.force.undefined(place.poses):
            continue
        assert lost(undamped, place)[0] == pytest.approx(0, abs=100 * QUOTIENT * lost(undamped, place)[1])


@pytest.mark.parametrize(
    ("case", "name"),
    [(c, f["name"]) for c in GENERAL for f in c.fields if laws.is_damping(f)],
    ids=str,
)
def test_each_damper_takes_energy(case: Case, name: str) -> None:
    """Alone, in general motion; one that a load presses to something, with loads, and where it touches."""
    others = [f for f in case.fields if f["name"] != name and f["range"] != "positive"]
    found: list[float] = []
    for kept in (lambda _: False, laws.is_load):
        alone = case.without(*(f["name"] for f in others if not kept(f)))
        without = alone.without(name)
        for place in places(alone.force)[:4]:
            place = replace(place, inputs=np.zeros_like(place.inputs))
            if (np.array(place.act(alone.force)) == place.act(without.force)).all():
                continue
            loss, scale = lost(alone, place)
            found.append((loss - lost(without, place)[0]) / scale)
        if found:
            break
    # of a speed of about 1
    assert min(found) > 1e-3


def from_first(place: Place) -> Place:
    """The last port's motion as seen from the first, which stands still."""
    if len(place.poses) == 1:
        return place
    d = place.poses[1][:3, 3] - place.poses[0][:3, 3]
    (w_a, v_a), (w_b, v_b) = ((v[:3], v[3:]) for v in place.velocities)
    return replace(place, velocities=[np.zeros(6), np.concatenate([w_b - w_a, v_b - v_a - np.cross(w_a, d)])])


def displaced(place: Place, i: int, h: float) -> Place:
    """The last port displaced (i < 3) or turned by h, its body's motion kept; i from 6 on: rates instead."""
    change = np.zeros(6)
    change[i % 6] = h
    shift, turn = change[:3], change[3:]
    X, V = place.poses[-1], place.velocities[-1].copy()
    if i < 6:
        V[3:] += np.cross(V[:3], shift)
        X = laws.moved(X, np.concatenate([turn, shift]), 1.0)
    else:
        V += np.concatenate([turn, shift])
    return replace(place, poses=[*place.poses[:-1], X], velocities=[*place.velocities[:-1], V])


def by_differences(case: Case, place: Place) -> tuple[Array, Array]:
    """Return d (f, n) / d (p, a, rates of these), to the one side and to the other: 6 x 12 each."""
    place = from_first(place)
    here = place.act(case.force)[-1]
    sides = [
        [(displaced(place, i, h).act(case.force)[-1] - here) / h for i in range(12)] for h in (STEP, -STEP)
    ]
    above, below = (np.roll(np.array(columns), 3, axis=1).T for columns in sides)
    return above, below


def as_matrix(slopes: dict[str, Array]) -> Array:
    return np.vstack([np.hstack([slopes[f"{of}_{by}"] for by in "pavw"]) for of in "fn"])


@every_force
def test_derivatives_are_those_of_what_it_does(case: Case) -> None:
    """By dual numbers and by differences. At rest |v| has no second derivative, so differences err by h.

    Where a force has a kink, as that of a damper that never pulls at rest, those of one of its sides.
    """
    for place in places(case.force):
        found = as_matrix(place.derivatives_by_duals(case.force))
        F = place.act(case.force)
        scale = laws.scale_of(F, place) * (1 + float(np.abs(found).max()))
        still = not any(v.any() for v in place.velocities)
        bound = (10 * STEP if still else 100 * QUOTIENT) * scale
        above, below = by_differences(case, place)
        expected = (above + below) / 2
        if still:
            kinks = np.abs(above - below) > 2 * bound
            one_side = np.where(np.abs(found - above) < np.abs(found - below), above, below)
            expected = np.where(kinks, one_side, expected)
        assert_allclose(found, expected, atol=bound, err_msg=place.name)


def test_derivatives_that_a_header_supplies_are_used(root: Path) -> None:
    """Recursive Jacobians use them; otherwise they would silently fall back on dual numbers."""
    headers = [path.read_text("utf-8") for path in (root / "src" / "element").rglob("*.h")]
    supplying = [text for text in headers if "PortJacobians jacobians(" in text]
    supplied = {
        case.kind["name"]
        for case in CASES
        if any(place.jacobians(case.force) is not None for place in places(case.force))
    }
    assert supplied == {
        kind for text in supplying for kind in re.findall(r'string_view kind = "(\w+)"', text)
    }
    assert supplied


@every_force
def test_derivatives_by_hand_are_those_by_dual_numbers(case: Case) -> None:
    """And what they say of themselves: of points alone, without damping."""
    for place in places(case.force):
        by_hand = place.jacobians(case.force)
        if by_hand is None:
            pytest.skip("it has none by hand")
        by_duals = as_matrix(place.derivatives_by_duals(case.force))
        scale = 1 + float(np.abs(by_duals).max())
        if by_hand["of_points"]:
            assert (as_matrix(by_hand)[3:] == 0).all()
            assert (as_matrix(by_hand)[:, 3:6] == 0).all()
        if not by_hand["damped"]:
            assert (as_matrix(by_hand)[:, 6:] == 0).all()
        # a direction d/|d| of points 1e-3 apart is known to 1e3 eps
        assert_allclose(as_matrix(by_hand), by_duals, atol=1e3 * ROUND_OFF * scale, err_msg=place.name)


@pytest.mark.parametrize(
    ("case", "name", "component"),
    [
        (case, f["name"], i)
        for case in GENERAL
        for f in case.fields
        for i in range(3 if f["type"] == "vector" else 1)
    ],
    ids=str,
)
def test_each_number_has_an_effect(case: Case, name: str, component: int) -> None:
    """On what it does somewhere, in general motion, well above rounding."""
    value = case.numbers[name]
    other = list(value) if isinstance(value, list) else value * 1.5
    if isinstance(other, list):
        other[component] *= 1.5
    changed = case.with_number(name, other).force
    effects = []
    for place in places(case.force)[:8]:
        before, after = np.array(place.act(case.force)), np.array(place.act(changed))
        effects.append(np.abs(after - before).max() / np.abs(before).max())
    assert max(effects) > 1e-3


@every_kind
def test_each_word_and_flag_and_input_has_an_effect(case: Case) -> None:
    others = [c for c in GENERAL if c.kind is case.kind and c is not case]
    place = places(case.force)[0]
    for other in others:
        there = places(other.force)[0]
        assert not np.allclose(there.act(other.force), place.act(case.force), rtol=1e-3)
    for i in range(len(place.inputs)):
        inputs = place.inputs.copy()
        inputs[i] += 1.0
        assert not np.allclose(
            replace(place, inputs=inputs).act(case.force), place.act(case.force), rtol=1e-3
        )


@every_kind
def test_ports_say_what_of_a_body_counts(case: Case) -> None:
    """Of a point not how it is turned, of a body only how it turns; of a frame both do."""
    rng = np.random.default_rng(17)
    for place in places(case.force)[:3]:
        before = place.act(case.force)
        for k, port in enumerate(case.kind["ports"]):
            turn, shift = place.poses[k].copy(), place.poses[k].copy()
            turn[:3, :3] = laws.rotation(rng.normal(size=3), 0.9) @ turn[:3, :3]
            shift[:3, 3] += rng.uniform(0.1, 1, 3)
            acts = {}
            for what, X in (("turn", turn), ("shift", shift)):
                poses = [*place.poses[:k], X, *place.poses[k + 1 :]]
                acts[what] = (
                    np.abs(np.array(replace(place, poses=poses).act(case.force)) - before).max() > 1e-6
                )
            if port["kind"] == "point":
                assert not acts["turn"], f"port {k} is a point, and is turned"
            if port["kind"] == "body":
                assert not acts["shift"], f"port {k} is a body, and is shifted"


@pytest.mark.parametrize("kind", laws.KINDS["forces"], ids=lambda kind: kind["name"])
def test_ports_ask_for_no_more_than_counts(kind: laws.Kind) -> None:
    """What a scene can say of a frame, its rotation, has an effect, with some word of the element's."""
    for k, port in enumerate(kind["ports"]):
        if port["kind"] != "frame":
            continue
        effects = []
        for case in laws.general_cases(kind):
            place = places(case.force)[0]
            X = place.poses[k].copy()
            X[:3, :3] = X[:3, :3] @ laws.rotation([0.3, -1, 0.6], 0.4)
            other = replace(place, poses=[*place.poses[:k], X, *place.poses[k + 1 :]])
            effects.append(np.abs(np.array(other.act(case.force)) - place.act(case.force)).max())
        assert max(effects) > 1e-3, f"port {k} is a frame, whose rotation has no effect: a point"


def power_of_two(unit: str, angle: bool = True) -> float:
    """What a number of that unit is multiplied by with lengths by 4, masses by 1/8, times by 2."""
    length, mass, time = laws.dimension(unit, angle)
    return 2.0 ** (2 * length - 3 * mass + time)


@every_force
def test_units_agree(case: Case) -> None:
    """In other units of length, mass and time all is as before, to the bit: these are powers of two."""
    if laws.is_formula(case):
        pytest.skip("SI units, with any power: test_element_sizes.py")
    numbers = dict(case.numbers)
    for field in case.fields:
        by = power_of_two(field["unit"])
        value = numbers[field["name"]]
        numbers[field["name"]] = [by * x for x in value] if isinstance(value, list) else by * value
    scaled = elements.Force(case.kind["name"], numbers)
    per_input = [power_of_two(g["unit"]) for g in case.force.inputs for _ in range(g["size"])]
    of_motion = np.repeat([power_of_two("rad/s"), power_of_two("m/s")], 3)
    of_wrench = np.repeat([power_of_two("N.m"), power_of_two("N")], 3)
    for place in places(case.force):
        poses = [X.copy() for X in place.poses]
        for X in poses:
            X[:3, 3] *= power_of_two("m")
        other = replace(
            place,
            poses=poses,
            velocities=[of_motion * v for v in place.velocities],
            inputs=place.inputs * np.array(per_input),
        )
        for found, before in zip(other.act(scaled), place.act(case.force), strict=True):
            assert (found == of_wrench * before).all()
        assert scaled.energy(poses) == power_of_two("J") * case.force.energy(place.poses)


def test_the_law_of_units_sees_a_wrong_one() -> None:
    """N.s/m read as N/m would be told apart by a factor of 2, and so would rad for m."""
    assert power_of_two("N.s/m") == 2 * power_of_two("N/m")
    assert power_of_two("N.m.s2/rad2") == 4 * power_of_two("N.m")
    assert power_of_two("{f}/{q}", angle=False) == power_of_two("N/m")
    assert power_of_two("{f}/{q}") == power_of_two("N.m/rad") != power_of_two("N/m")
