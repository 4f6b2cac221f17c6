# SPDX-License-Identifier: BSD-3-Clause
"""Laws of the rows that a joint becomes when it closes a loop (src/joint/rows.h)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from . import laws
from .laws import QUOTIENT, ROUND_OFF, STEP, Case, motion_space, moved, written_in_F

every_kind = pytest.mark.parametrize("case", laws.all_cases(), ids=str)


@every_kind
def test_rows_vanish_on_allowed_poses(case: Case) -> None:
    """Phi(X_FM(q)) = 0."""
    joint = case.joint()
    for q in laws.coordinates(case):
        _, Phi = joint.rows(joint.X_FM(q))
        assert len(Phi) == len(case.directions) - joint.nv
        # n turns of an angle are known to n eps
        assert_allclose(Phi, 0, atol=ROUND_OFF * (1 + np.abs(q).max(initial=0)))


@every_kind
def test_motions_and_rows_span_all_directions(case: Case) -> None:
    """W S = 0 and [S W^T] has full rank: the rows are what S does not span, no more and no less."""
    joint = case.joint()
    for q in laws.coordinates(case):
        X = joint.X_FM(q)
        S = np.array([written_in_F(X, s) for s in motion_space(joint, q).T]).reshape(joint.nv, 6).T
        W, _ = joint.rows(X)
        assert_allclose(W @ S, 0, atol=ROUND_OFF)
        both = np.hstack([S, W.T])[case.directions]
        assert both.shape == (len(case.directions),) * 2
        # S and W hold unit directions, except the two axes of a universal joint, here at 116 degrees:
        # singular values sqrt(1 +- 0.44)
        assert np.linalg.svd(both, compute_uv=False).min() > 0.5


@every_kind
def test_rate_of_the_error_is_the_work_of_the_row(case: Case) -> None:
    """dPhi/dt = w . V_FM where Phi = 0, for motions in every direction, allowed or not."""
    joint = case.joint()
    for q in laws.coordinates(case):
        X = joint.X_FM(q)
        W, _ = joint.rows(X)
        for direction in np.eye(6)[case.directions]:
            up, down = joint.rows(moved(X, direction, STEP))[1], joint.rows(moved(X, direction, -STEP))[1]
            # positions up to 200 pi round by 1e-13, over 2 h: 1e-8 in what p adds to Phi
            atol = QUOTIENT * (1 + np.abs(X[:3, 3]).max())
            assert_allclose((up - down) / (2 * STEP), W @ direction, atol=atol)


@every_kind
def test_bias_of_the_rows_is_the_rate_of_the_wrenches(case: Case) -> None:
    """rows_bias = (dw/dt) . V_FM, along allowed motions and, off the constraint, along any."""
    joint = case.joint()
    rng = np.random.default_rng(5)
    for q in laws.coordinates(case):
        for _ in range(3):
            V = np.zeros(6)
            V[case.directions] = rng.uniform(-1, 1, len(case.directions))
            off = np.zeros(6)
            off[case.directions] = rng.uniform(-0.1, 0.1, len(case.directions))
            for X in (joint.X_FM(q), moved(joint.X_FM(q), off, 1.0)):
                W_dot = (joint.rows(moved(X, V, STEP))[0] - joint.rows(moved(X, V, -STEP))[0]) / (2 * STEP)
                assert_allclose(joint.rows_bias(X, V), W_dot @ V, atol=QUOTIENT * 4)


@every_kind
def test_error_leads_back_from_far_away(case: Case) -> None:
    """Following the error, V = -W^+ Phi, from a wide gap closes the joint: assembly's way home."""
    joint = case.joint()
    rng = np.random.default_rng(3)
    for q in laws.coordinates(case)[:6]:
        off = np.zeros(6)
        off[case.directions] = rng.uniform(-1.0, 1.0, len(case.directions))
        X = moved(joint.X_FM(q), off, 1.0)
        for _ in range(100):
            W, Phi = joint.rows(X)
            if len(Phi):
                X = moved(X, -0.5 * np.linalg.pinv(W) @ Phi, 1.0)
        # halved a hundred times: down to rounding
        assert_allclose(joint.rows(X)[1], 0, atol=ROUND_OFF * (1 + np.abs(X[:3, 3]).max()))


@pytest.mark.parametrize("half_turn", [[1, 0, 0], [0, 1, 0], [0.6, 0.8, 0]])
def test_an_axis_upside_down_is_an_error_of_half_a_turn(half_turn: list[float]) -> None:
    """Z of M along -z of F is as wrong as can be, |Phi| = pi, not right by accident (sin pi = 0)."""
    n = np.array(half_turn)
    X = laws.rotated(2 * np.outer(n, n) - np.eye(3))
    for case in laws.all_cases():
        if case.planar or case.kind["name"] not in ("revolute", "cylindrical", "planar"):
            continue
        _, Phi = case.joint().rows(X)
        assert np.linalg.norm(Phi) == pytest.approx(np.pi, abs=1e-7)  # atan2 near pi: sqrt(eps)
