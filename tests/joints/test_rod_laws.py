# SPDX-License-Identifier: BSD-3-Clause
"""Laws of the rod without mass (src/joint/rod.h): a chain of two joints, taken as one that closes a loop."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gelenk._core import joints

from .laws import QUOTIENT, ROUND_OFF, STEP, Array, moved, rotated, skew, unskew

LENGTH = 0.7
POINTS = 12  # random poses for each law


def turned(rng: np.random.Generator) -> Array:
    Q = rng.normal(size=4)
    return np.array(joints.Joint("spherical", [], False).X_FM(Q / np.linalg.norm(Q)))


@dataclass(frozen=True)
class Chain:
    first: str
    second: str
    first_reversed: bool
    second_reversed: bool

    def __str__(self) -> str:
        arrow = {False: "", True: "-reversed"}
        return f"{self.first}{arrow[self.first_reversed]}-{self.second}{arrow[self.second_reversed]}"

    @property
    def planar(self) -> bool:
        return self.first == "revolute"

    @property
    def axes(self) -> list[Array]:
        return {"revolute": [np.eye(3)[2]], "universal": [np.eye(3)[0], np.eye(3)[1]]}.get(self.first, [])

    @property
    def spins(self) -> bool:
        """Nothing holds the rod's turn about itself."""
        return self.first == "spherical"

    def X_12(self) -> Array:
        """The second joint lies in a direction at right angles to the universal joint's axis on the rod."""
        direction = np.array([0.6, 0.8, 0.0])
        if self.first == "universal":
            direction = np.array([0.0, 0.6, 0.8]) if self.first_reversed else np.array([0.6, 0.0, 0.8])
        turn = np.eye(4)
        if self.planar:
            turn[:2, :2] = [[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]]
        else:
            turn = turned(np.random.default_rng(2))
        turn[:3, 3] = LENGTH * direction
        return turn

    def rod(self) -> Any:
        return joints.Rod(
            self.first,
            self.axes,
            self.first_reversed,
            self.second,
            self.second_reversed,
            self.X_12(),
            self.planar,
        )

    def ends(self) -> list[Any]:
        second_axes = self.axes if self.planar else []
        return [
            joints.Joint(self.first, self.axes, self.planar),
            joints.Joint(self.second, second_axes, self.planar),
        ]

    @property
    def directions(self) -> list[int]:
        return [2, 3, 4] if self.planar else [0, 1, 2, 3, 4, 5]

    def poses(self) -> list[Array]:
        """Random X_FM with both points at the rod's length."""
        rng = np.random.default_rng(7)
        out = []
        for _ in range(POINTS):
            angle = rng.uniform(-np.pi, np.pi)
            X = turned(rng)
            direction = rng.normal(size=3)
            if self.planar:
                c, s = np.cos(angle), np.sin(angle)
                X = rotated(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
                direction[2] = 0
            X[:3, 3] = LENGTH * direction / np.linalg.norm(direction)
            out.append(X)
        return out

    def some_q(self, seed: int) -> Array:
        rod = self.rod()
        q: Array = np.random.default_rng(seed).uniform(-1, 1, rod.nq)
        for first, size in quaternions(self):
            q[first : first + size] /= np.linalg.norm(q[first : first + size])
        return q

    def motion(self, X: Array, seed: int) -> Array:
        """A random allowed V_FM, written in F as in rows.h."""
        V = np.zeros(6)
        V[self.directions] = np.random.default_rng(seed).uniform(-1, 1, len(self.directions))
        e = X[:3, 3] / np.linalg.norm(X[:3, 3])
        V[3:] -= e * (e @ V[3:])
        return V


def quaternions(chain: Chain) -> list[tuple[int, int]]:
    """Where in q there are quaternions: (first, 4)."""
    sizes = {"revolute": 1, "universal": 2, "spherical": 4}
    out, at = [], 0
    for kind in (chain.first, chain.second):
        if kind == "spherical":
            out.append((at, 4))
        at += sizes[kind]
    return out


ENDS = [("revolute", "revolute"), ("universal", "spherical"), ("spherical", "spherical")]
CHAINS = [Chain(a, b, ra, rb) for (a, b), ra, rb in product(ENDS, (False, True), (False, True))]
every_chain = pytest.mark.parametrize("chain", CHAINS, ids=str)


def in_M(X: Array, V_F: Array) -> Array:
    """Of a motion as in rows.h, written in F: the same in M."""
    return np.concatenate([X[:3, :3].T @ V_F[:3], X[:3, :3].T @ V_F[3:]])


@every_chain
def test_coordinates_give_the_pose_back(chain: Chain) -> None:
    """X_FM(coordinates(X)) = X for every X with the two points at the rod's length."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        q = rod.coordinates(X, chain.some_q(i))
        assert_allclose(rod.X_FM(q), X, atol=ROUND_OFF)


@every_chain
def test_pose_of_the_rod_joins_both_points(chain: Chain) -> None:
    """Its far end, X_FR p_12, is M's origin; the near one F's."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        X_FR = rod.rod_pose(rod.coordinates(X, chain.some_q(i)))
        assert_allclose(X_FR @ chain.X_12()[:, 3], X[:, 3], atol=ROUND_OFF)
        assert_allclose(X_FR[:3, 3], 0, atol=ROUND_OFF)


@every_chain
def test_row_keeps_the_distance(chain: Chain) -> None:
    """Phi = |p| - length, its rate is w . V, rows_bias the rate of w times V, at the length and off it."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        assert_allclose(rod.row(X)[1], 0, atol=ROUND_OFF)
        far = X.copy()
        far[:3, 3] *= 1.3
        assert rod.row(far)[1] == pytest.approx(0.3 * LENGTH, abs=ROUND_OFF)
        V = np.zeros(6)
        V[chain.directions] = np.random.default_rng(i).uniform(-1, 1, len(chain.directions))
        for at in (X, far):
            up, down = moved(at, V, STEP), moved(at, V, -STEP)
            (w_up, Phi_up), (w_down, Phi_down) = rod.row(up), rod.row(down)
            assert_allclose((Phi_up - Phi_down) / (2 * STEP), rod.row(at)[0] @ V, atol=QUOTIENT)
            # third derivatives of p/|p| grow as 1/length^3: some 10 here
            bias = (w_up - w_down) / (2 * STEP) @ V
            assert_allclose(rod.row_bias(at, V), bias, atol=10 * QUOTIENT)


@every_chain
def test_speeds_give_the_motion_back(chain: Chain) -> None:
    """S speeds(V) = V for allowed V; where the rod's turn is held, speeds(S v) = v too."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        q = rod.coordinates(X, chain.some_q(i))
        V = in_M(X, chain.motion(X, i))
        v = rod.speeds(q, V)
        # near the universal joint's second axis speeds are larger than V by some 10
        assert_allclose(rod.V_FM(q, v), V, atol=ROUND_OFF * (1 + np.abs(v).max()))
        if not chain.spins:
            v = np.random.default_rng(i).uniform(-1, 1, rod.nv)
            assert_allclose(rod.speeds(q, rod.V_FM(q, v)), v, atol=100 * ROUND_OFF)


@every_chain
def test_speeds_are_the_rates_of_the_coordinates(chain: Chain) -> None:
    """X_FR moves with rod_velocity along allowed motions: coordinates() and speeds() choose alike."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        V_F = chain.motion(X, i)
        q = rod.coordinates(X, chain.some_q(i))
        v = rod.speeds(q, in_M(X, V_F))
        pose = rod.rod_pose(q)
        up, down = (rod.rod_pose(rod.coordinates(on_sphere(X, V_F, h), q)) for h in (STEP, -STEP))
        Xdot = (up - down) / (2 * STEP)
        w = unskew(pose[:3, :3].T @ Xdot[:3, :3])
        # the angles of a universal joint near its second axis have large third derivatives
        assert_allclose(rod.rod_velocity(q, v)[:3], w, atol=QUOTIENT * (1 + np.abs(v).max()) ** 3 * 10)


@every_chain
def test_derivatives_carried_along_are_the_rates_of_the_coordinates(chain: Chain) -> None:
    """Coordinates for numbers that carry derivatives: dq/dt = N(q) speeds."""
    rod, ends = chain.rod(), chain.ends()
    for i, X in enumerate(chain.poses()):
        V_F = chain.motion(X, i)
        q = rod.coordinates(X, chain.some_q(i))
        v = rod.speeds(q, in_M(X, V_F))
        k, n = ends[0].nq, ends[0].nv
        expected = np.concatenate([ends[0].qdot_from_v(q[:k], v[:n]), ends[1].qdot_from_v(q[k:], v[n:])])
        rate = np.zeros((4, 4))
        rate[:3, :3] = skew(V_F[:3]) @ X[:3, :3]
        rate[:3, 3] = V_F[3:]
        bound = 1000 * ROUND_OFF * (1 + np.abs(v).max())
        assert_allclose(rod.coordinate_rates(X, rate, q), expected, atol=bound)


def on_sphere(X: Array, V_F: Array, dt: float) -> Array:
    """X moved by V dt, p kept at its length: p turns about p x pdot."""
    out = moved(X, V_F, dt)
    p, pdot = X[:3, 3], V_F[3:]
    rate = np.linalg.norm(pdot) / np.linalg.norm(p)
    out[:3, 3] = np.cos(rate * dt) * p + (np.sin(rate * dt) / rate if rate > 0 else dt) * pdot
    return out


@every_chain
def test_bias_is_the_rate_of_the_motion_space(chain: Chain) -> None:
    """V_FM(q, v) changes by bias where v is constant, componentwise in M."""
    rod, ends = chain.rod(), chain.ends()
    for i, X in enumerate(chain.poses()):
        q = rod.coordinates(X, chain.some_q(i))
        v = np.random.default_rng(i).uniform(-1, 1, rod.nv)
        k, n = ends[0].nq, ends[0].nv
        qdot = np.concatenate([ends[0].qdot_from_v(q[:k], v[:n]), ends[1].qdot_from_v(q[k:], v[n:])])
        rate = (rod.V_FM(q + STEP * qdot, v) - rod.V_FM(q - STEP * qdot, v)) / (2 * STEP)
        assert_allclose(rod.bias(q, v), rate, atol=20 * QUOTIENT)


@pytest.mark.parametrize("chain", [chain for chain in CHAINS if not chain.spins], ids=str)
def test_effort_does_the_work_of_the_speeds(chain: Chain) -> None:
    """V_FM(q, v) . effort(tau) = v . tau. Where the rod may spin, a torque along it has nothing to act on."""
    rod = chain.rod()
    for i, X in enumerate(chain.poses()):
        q = rod.coordinates(X, chain.some_q(i))
        rng = np.random.default_rng(i)
        v, tau = rng.uniform(-1, 1, rod.nv), rng.uniform(-1, 1, rod.nv)
        F = rod.wrench_from_tau(q, tau)
        assert_allclose(rod.V_FM(q, v) @ F, v @ tau, atol=100 * ROUND_OFF * (1 + np.abs(F).max()))


def turning_error(angle: float, expected: float) -> float:
    """Difference of two angles, whole turns left out."""
    return float(np.remainder(angle - expected + np.pi, 2 * np.pi) - np.pi)


def test_rod_straight_across_the_axis_keeps_its_angle() -> None:
    """In a plane through axis a the rod goes on beyond it: phi_b past a quarter turn, phi_a as it was."""
    for first_reversed in (False, True):
        chain = Chain("universal", "spherical", first_reversed, False)
        X_12 = np.eye(4)
        X_12[2, 3] = LENGTH  # along z: at right angles to both axes at zero
        rod = joints.Rod("universal", chain.axes, first_reversed, "spherical", False, X_12, False)
        q = np.array([0.0, 0, 0, 0, 0, 1])
        for angle in np.linspace(0, 2 * np.pi, 41):
            X = np.eye(4)
            s, c = np.sin(angle), np.cos(angle)
            X[:3, 3] = LENGTH * np.array([0, s, c] if first_reversed else [s, 0, c])
            q = rod.coordinates(X, q)
            turning, resting = (q[0], q[1]) if first_reversed else (q[1], q[0])
            assert_allclose([turning_error(resting, 0), turning_error(turning, angle)], 0, atol=1e-9)


def test_rod_that_passes_the_axis_turns_about_it() -> None:
    """A rod that passes axis a at a small distance swings about it by half a turn, and keeps to its side."""
    chain = Chain("universal", "spherical", False, False)
    X_12 = np.eye(4)
    X_12[2, 3] = LENGTH
    rod = joints.Rod("universal", chain.axes, False, "spherical", False, X_12, False)
    q = np.array([0.0, 0, 0, 0, 0, 1])
    for angle in np.linspace(0, np.pi, 7):  # none of them near the axis
        X = np.eye(4)
        X[:3, 3] = [np.sin(angle), 0.001, np.cos(angle)]
        X[:3, 3] *= LENGTH / np.linalg.norm(X[:3, 3])
        q = rod.coordinates(X, q)
        assert abs(q[1]) < np.pi / 2
    assert_allclose(turning_error(q[0], np.pi), 0, atol=0.01)


@pytest.mark.parametrize(
    ("first", "axes", "second", "p"),
    [
        ("universal", [[1, 0, 0], [0, 1, 0]], "spherical", [0, 0, 0]),  # no length
        ("universal", [[1, 0, 0], [0, 1, 0]], "spherical", [0, 1, 0]),  # along the joint's own axis
        ("universal", [[1, 0, 0], [0.1, 1, 0]], "spherical", [0, 0, 1]),  # axes askew: a cone is out of reach
        ("universal", [[1, 0, 0], [0, 1, 0]], "revolute", [0, 0, 1]),
        ("revolute", [[0, 0, 1]], "spherical", [1, 0, 0]),
        ("spherical", [], "prismatic", [1, 0, 0]),
        ("weld", [], "spherical", [1, 0, 0]),
    ],
)
def test_what_holds_more_or_less_than_a_length_is_no_rod(first: str, axes: Any, second: str, p: Any) -> None:
    X_12 = np.eye(4)
    X_12[:3, 3] = p
    unit = [np.array(a, float) / np.linalg.norm(a) for a in axes]
    with pytest.raises(ValueError, match="a rod cannot be formed"):
        joints.Rod(first, unit, False, second, False, X_12, False)
