# SPDX-License-Identifier: BSD-3-Clause
"""Laws that the contact points of every pair of shapes obey."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from scipy.spatial.transform import Rotation

from native.contact_pairs import PAIRS, SHAPES, made, numbers, random_poses, special_poses

Contact = tuple[list[float], list[float], float, int]


class Pair:
    """Two shapes at poses, which can move as rigid bodies."""

    def __init__(self, units: Any, a: str, b: str, row: Array, scale: float = 1.0) -> None:
        self.units, self.A, self.B = units, made(units, a, scale), made(units, b, scale)
        self.R = [row[:9].reshape(3, 3), row[12:21].reshape(3, 3)]
        self.p = [scale * row[9:12], scale * row[21:]]

    def contacts(self, margin: float, exchanged: bool = False) -> list[Contact]:
        X_A, X_B = numbers(self.R[0], self.p[0]), numbers(self.R[1], self.p[1])
        if exchanged:
            return list(self.units.contacts(self.B, X_B, self.A, X_A, margin))
        return list(self.units.contacts(self.A, X_A, self.B, X_B, margin))

    def moved(self, V: Array, t: float) -> Pair:
        """After the time t with angular and linear velocities V[body]."""
        out = object.__new__(Pair)
        out.units, out.A, out.B = self.units, self.A, self.B
        out.R = [Rotation.from_rotvec(t * V[i][0]).as_matrix() @ self.R[i] for i in range(2)]
        out.p = [self.p[i] + t * V[i][1] for i in range(2)]
        return out

    def placed(self, direction: Array, gap: float) -> Pair | None:
        """B moved toward A until their distance is about `gap`; None if it cannot."""
        for _ in range(8):
            found = self.contacts(1e9)
            _, n, now, _ = min(found, key=lambda c: c[2])
            along = np.array(n) @ direction
            if abs(along) < 0.1:
                return None
            if abs(now - gap) < 1e-12:
                return self
            self.p[1] = self.p[1] + (gap - now) / along * direction
        return self


def at_rest(units: Any, a: str, b: str, rng: np.random.Generator, tilt: float, gap: float) -> Pair | None:
    """A flat, round or straight part of B on one of A, or an edge or corner, but for a small rotation."""
    row = special_poses(rng, 2)[1]
    pair = Pair(units, a, b, row)
    spin = Rotation.from_rotvec(rng.uniform(-3, 3) * pair.R[0][:, rng.integers(3)])
    pair.R[1] = (spin * Rotation.from_rotvec(tilt * rng.normal(size=3))).as_matrix() @ pair.R[1]
    direction = pair.R[0][:, 2] if a == "plane" else pair.R[0][:, rng.integers(3)] * rng.choice([-1, 1])
    if b == "plane":
        direction = -pair.R[1][:, 2]
    pair.p[1] = pair.p[0] + 3 * direction + 0.1 * rng.normal(size=3)
    return pair.placed(direction, gap)


def check_rates(pair: Pair, margin: float, rng: np.random.Generator) -> int:
    """The rate of each gap by finite differences of h = 1e-7 s at velocities of about 1 m/s and 1 rad/s.

    Rounding errors divided by h are 1e-9; the third derivatives are up to 1e4, of the lowest
    point of a rim at tilts of 1e-2, times h^2. Points at distances of the order of the motion have
    larger ones.
    """
    h, count = 1e-7, 0
    V = rng.normal(size=(2, 2, 3))
    later, before = ({c[3]: c for c in pair.moved(V, t).contacts(margin + 1e-4)} for t in (h, -h))
    for p, n, gap, feature in pair.contacts(margin):
        if feature not in later or feature not in before or 0 < gap < 1e-3:
            continue
        count += 1
        v = [V[i][1] + np.cross(V[i][0], np.array(p) - pair.p[i]) for i in range(2)]
        rate = (later[feature][2] - before[feature][2]) / (2 * h)
        assert rate == pytest.approx(np.array(n) @ (v[1] - v[0]), abs=1e-7)
    return count


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_gaps_change_at_the_relative_velocity_along_the_normal(units: Any, a: str, b: str) -> None:
    rng = np.random.default_rng(4)
    counts = [check_rates(Pair(units, a, b, row), 0.1, rng) for row in random_poses(rng, 30)]
    for k in range(30):
        pair = at_rest(units, a, b, rng, tilt=[1e-2, 0.05][k % 2], gap=-0.003)
        if pair is not None:
            counts.append(check_rates(pair, 0.02, rng))
    assert sum(counts) > 30
    if {a, b} <= {"box", "plane", "cylinder", "prism"}:
        assert max(counts) >= 2


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_points_are_halfway_between_surfaces_at_their_gap(units: Any, a: str, b: str) -> None:
    """Spheres of the size of a gap show where surfaces are: they touch the body that they are next to."""
    rng = np.random.default_rng(5)
    tiny = units.Shape("sphere", [1e-9])
    for row in [*random_poses(rng, 30), *special_poses(rng, 30)]:
        pair = Pair(units, a, b, row)
        contacts = pair.contacts(1e9)
        p, n, gap, _ = min(contacts, key=lambda c: c[2])
        assert np.linalg.norm(n) == pytest.approx(1, abs=1e-14)
        for body, sign in [(0, -1), (1, 1)]:
            surface = np.array(p) + sign * gap / 2 * np.array(n)
            shape, X = (pair.A, pair.B)[body], numbers(pair.R[body], pair.p[body])
            [(_, _, distance, _)] = units.contacts(tiny, numbers(np.eye(3), surface), shape, X, 1e9)
            # On cylinders an iteration ends with directions within 1e-7.
            assert distance == pytest.approx(-1e-9, abs=1e-6)


@pytest.mark.parametrize(("a", "b"), PAIRS)
@pytest.mark.parametrize("margin", [1e9, 0.0512, 1e-3])
def test_exchanged_bodies_have_opposite_normals(units: Any, a: str, b: str, margin: float) -> None:
    rng = np.random.default_rng(6)
    for row in [*random_poses(rng, 20), *special_poses(rng, 20)]:
        pair = Pair(units, a, b, row)
        forth, back = pair.contacts(margin), pair.contacts(margin, exchanged=True)
        assert forth == pair.contacts(margin)
        if SHAPES[a][0] != SHAPES[b][0]:
            assert forth == [(p, [-x for x in n], gap, f) for p, n, gap, f in back]
        elif forth or back:
            least = [min(c[2] for c in of) for of in (forth, back)]
            assert least[0] == pytest.approx(least[1], abs=1e-9)


@pytest.mark.parametrize(("a", "b"), PAIRS)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_contacts_scale_with_the_bodies(units: Any, a: str, b: str, scale: float) -> None:
    rng = np.random.default_rng(7)
    for row in random_poses(rng, 20):
        gap = min(c[2] for c in Pair(units, a, b, row).contacts(1e12))
        scaled = min(c[2] for c in Pair(units, a, b, row, scale).contacts(1e12))
        assert scaled / scale == pytest.approx(gap, abs=1e-9)


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_numbers_stay_finite_for_bodies_in_the_same_place(units: Any, a: str, b: str) -> None:
    """Concentric, with equal and with other axes, and bodies whose sizes differ by 1e12."""
    rng = np.random.default_rng(8)
    rows = special_poses(rng, 60)
    rows[:, 21:] = rows[:, 9:12]
    same = rows.copy()
    same[:, 12:21] = same[:, :9]
    for row in [*rows, *same]:
        contacts = Pair(units, a, b, row).contacts(0.0)
        assert contacts
        assert all(np.isfinite([*p, *n, gap]).all() for p, n, gap, _ in contacts)
        assert all(gap < 0 or "plane" in (a, b) for _, _, gap, _ in contacts)
    if "plane" in (a, b):
        return
    X = numbers(np.eye(3), np.zeros(3))
    for small, large in [
        (made(units, a, 1e-6), made(units, b, 1e6)),
        (made(units, a, 1e6), made(units, b, 1e-6)),
    ]:
        contacts = units.contacts(small, X, large, X, 0.0)
        assert contacts
        assert all(np.isfinite([*p, *n, gap]).all() for p, n, gap, _ in contacts)
        assert min(gap for _, _, gap, _ in contacts) < -1e4


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_points_appear_at_the_margin(units: Any, a: str, b: str) -> None:
    rng = np.random.default_rng(9)
    for row in random_poses(rng, 20):
        pair = Pair(units, a, b, row)
        least = min(c[2] for c in pair.contacts(1e9))
        assert pair.contacts(least - 1e-9) == []
        near = pair.contacts(least + 1e-9)
        assert min(c[2] for c in near) == pytest.approx(least, abs=1e-12)
        assert all(c[2] <= least + 1e-9 for c in near)
        assert len(near) <= 4
        assert [c[3] for c in near] == sorted(c[3] for c in near)
