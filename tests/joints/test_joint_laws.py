# SPDX-License-Identifier: BSD-3-Clause
"""Laws that every kind of joint obeys, in every algebra it lives in.

Sources: Featherstone 2008, chapters 2 to 4 (motion spaces, virtual work); the conventions are
those of src/joint/base.h and rows.h.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from . import laws
from .laws import QUOTIENT, ROUND_OFF, Case, inverse, motion_space, quotient, rotated, written_in_F

CASES = laws.all_cases()
every_kind = pytest.mark.parametrize("case", CASES, ids=str)


def some_speeds(case: Case, number: int) -> list[laws.Array]:
    rng = np.random.default_rng(7)
    return [rng.uniform(-2, 2, case.kind["nv"]) for _ in range(number)]


@every_kind
def test_pose_is_a_rigid_motion(case: Case) -> None:
    """R^T R = 1, det R = 1, last row (0 0 0 1)."""
    joint = case.joint()
    for q in laws.coordinates(case):
        X = joint.X_FM(q)
        assert_allclose(X[:3, :3].T @ X[:3, :3], np.eye(3), atol=ROUND_OFF)
        assert np.linalg.det(X[:3, :3]) == pytest.approx(1, abs=ROUND_OFF)
        assert (X[3] == [0, 0, 0, 1]).all()


@every_kind
def test_reference_coordinates_bring_F_and_M_together(case: Case) -> None:
    """X_FM(q_zero) = 1, exactly."""
    assert (case.joint().X_FM(np.array(case.kind["q_zero"])) == np.eye(4)).all()


@every_kind
def test_velocity_is_the_rate_of_the_pose(case: Case) -> None:
    """[w]x = R^T dR/dt and v = R^T dp/dt, written in M."""
    joint = case.joint()
    for q in laws.coordinates(case):
        for v in some_speeds(case, 3):
            X = joint.X_FM(q)
            Xdot = quotient(joint.X_FM, q, joint.qdot_from_v(q, v))
            V = np.concatenate([laws.unskew(X[:3, :3].T @ Xdot[:3, :3]), X[:3, :3].T @ Xdot[:3, 3]])
            scale = 4 * (1 + np.abs(q[: case.kind["nv"]]).max(initial=0) * 1e-2)  # |v| <= 2 per speed
            assert_allclose(joint.V_FM(q, v), V, atol=QUOTIENT * scale)


@every_kind
def test_velocity_is_linear_in_the_speeds(case: Case) -> None:
    """V_FM(q, v) = S(q) v."""
    joint = case.joint()
    for q in laws.coordinates(case):
        S = motion_space(joint, q)
        for v in some_speeds(case, 2):
            assert_allclose(joint.V_FM(q, v), S @ v, atol=10 * ROUND_OFF)


@every_kind
def test_bias_is_the_rate_of_the_motion_space(case: Case) -> None:
    """The bias is (dS/dt) v, componentwise in M, along qdot = N v."""
    joint = case.joint()
    for q in laws.coordinates(case):
        for v in some_speeds(case, 3):
            expected = quotient(lambda x, v=v: joint.V_FM(x, v), q, joint.qdot_from_v(q, v))
            assert_allclose(
                joint.bias(q, v), expected, atol=QUOTIENT * 16
            )  # products of two speeds, up to 12


@every_kind
def test_virtual_work(case: Case) -> None:
    """Power: tau . v = F . V_FM for every F and v."""
    joint = case.joint()
    rng = np.random.default_rng(11)
    for q in laws.coordinates(case):
        for v in some_speeds(case, 3):
            F = rng.uniform(-5, 5, 6)
            assert joint.project(q, F) @ v == pytest.approx(F @ joint.V_FM(q, v), abs=100 * ROUND_OFF)


@every_kind
def test_speeds_are_found_from_the_velocity(case: Case) -> None:
    """speeds(S v) = v; a V outside the span gives the nearest, S^T (V - S v) = 0."""
    joint = case.joint()
    rng = np.random.default_rng(13)
    for q in laws.coordinates(case):
        S = motion_space(joint, q)
        for v in some_speeds(case, 3):
            assert_allclose(joint.speeds(q, S @ v), v, atol=20 * ROUND_OFF)
            V = rng.uniform(-1, 1, 6)
            assert_allclose(S.T @ (V - S @ joint.speeds(q, V)), 0, atol=20 * ROUND_OFF)


@every_kind
def test_rate_and_its_inverse_agree(case: Case) -> None:
    """The inverse gives v = unrate(N v); and N v keeps a unit quaternion's length."""
    joint = case.joint()
    for q in laws.coordinates(case):
        for v in some_speeds(case, 3):
            qdot = joint.qdot_from_v(q, v)
            assert_allclose(joint.v_from_qdot(q, qdot), v, atol=10 * ROUND_OFF)
            if case.kind["quaternion"]:
                assert q[-4:] @ qdot[-4:] == pytest.approx(0, abs=10 * ROUND_OFF)
            else:
                assert (qdot == v).all()


@every_kind
def test_normalising_changes_no_pose(case: Case) -> None:
    """X_FM of stretched redundant coordinates is that of the normalized ones."""
    joint = case.joint()
    for q in laws.coordinates(case):
        stretched = q.copy()
        if case.kind["quaternion"]:
            stretched[-4:] *= 1.37
        assert_allclose(joint.X_FM(joint.normalize(stretched)), joint.X_FM(stretched), atol=ROUND_OFF * 10)
        assert_allclose(joint.normalize(stretched), q, atol=ROUND_OFF)


@every_kind
def test_coordinates_are_found_from_the_pose(case: Case) -> None:
    """coordinates(X_FM(q)) = q up to whole turns of angles; near quaternions keep their sign."""
    joint = case.joint()
    angles = [i for i, name in enumerate(case.kind["q"]) if name.startswith("phi")]
    for q in laws.coordinates(case):
        found = joint.coordinates(joint.X_FM(q), q)
        difference = found - q
        difference[angles] -= 2 * np.pi * np.round(difference[angles] / (2 * np.pi))
        # an angle of n turns is known to n eps; a quaternion comes from square roots of R's entries
        assert_allclose(difference, 0, atol=ROUND_OFF * (1 + np.abs(q).max(initial=0)))
        if case.kind["quaternion"]:
            assert_allclose(joint.coordinates(joint.X_FM(q), -q)[-4:], -q[-4:], atol=ROUND_OFF * 10)


@every_kind
def test_exchanging_the_frames_inverts_everything(case: Case) -> None:
    """The same joint seen from the other side, its axes in reverse order, allows X_MF and V_MF = -V_FM."""
    joint = case.joint()
    back = Case(case.kind, case.axes[::-1], case.planar).joint()
    # From the joint's own frame to that of the exchanged one (they differ for two axes).
    T = rotated(joint.canonical().T @ back.canonical()) if not case.planar else np.eye(4)
    guess = np.array(case.kind["q_zero"])
    for q in laws.coordinates(case):
        X_FM = joint.X_FM(q)
        X_MF = inverse(T) @ inverse(X_FM) @ T
        q_back = back.coordinates(X_MF, guess)
        atol = ROUND_OFF * (1 + np.abs(q).max(initial=0))
        assert_allclose(back.X_FM(q_back), X_MF, atol=atol)
        assert_allclose(back.rows(X_MF)[1], 0, atol=atol)
        for v in some_speeds(case, 2):
            w, u = joint.V_FM(q, v)[:3], joint.V_FM(q, v)[3:]  # M in F, at M's origin, in M
            R, p = X_FM[:3, :3], X_FM[:3, 3]
            V_MF = -np.concatenate([R @ w, R @ u - np.cross(R @ w, p)])  # F in M, at F's origin, in F
            V_MF = np.concatenate([T[:3, :3].T @ V_MF[:3], T[:3, :3].T @ V_MF[3:]])
            v_back = back.speeds(q_back, V_MF)
            assert_allclose(back.V_FM(q_back, v_back), V_MF, atol=10 * atol)


@every_kind
def test_turning_both_frames_upside_down_flips_the_signs(case: Case) -> None:
    """With D half a turn about x, D X_FM(q) D = X_FM(flip q): what planar algebra uses for axes along -n."""
    if case.kind["planar"] != "normal":
        assert (case.joint().flip() == 1).all()
        return
    joint = case.joint()
    D = np.diag([1.0, -1, -1, 1])
    for q in laws.coordinates(case):
        assert_allclose(joint.X_FM(joint.flip() * q), D @ joint.X_FM(q) @ D, atol=ROUND_OFF)
        for v in some_speeds(case, 2):
            turned = np.kron(np.eye(2), np.diag([1, -1, -1])) @ joint.V_FM(q, v)
            assert_allclose(joint.V_FM(joint.flip() * q, joint.flip() * v), turned, atol=ROUND_OFF)


@pytest.mark.parametrize("case", [c for c in CASES if c.planar], ids=str)
def test_planar_algebra_agrees_with_space(case: Case) -> None:
    """A joint in a plane moves as in space; one with its axis in the plane has it along x instead of z."""
    plane = case.joint()
    space = Case(case.kind, case.axes, planar=False).joint()
    # z onto x and y onto y: written in the plane's frame, the joint's axis lies along x.
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]) if case.kind["planar"] == "in_plane" else np.eye(3)
    T = rotated(turn)
    T6 = np.kron(np.eye(2), turn)
    for q in laws.coordinates(case):
        assert_allclose(plane.X_FM(q), T @ space.X_FM(q) @ T.T, atol=ROUND_OFF)
        for v in some_speeds(case, 2):
            assert_allclose(plane.V_FM(q, v), T6 @ space.V_FM(q, v), atol=10 * ROUND_OFF)
            assert_allclose(plane.bias(q, v), T6 @ space.bias(q, v), atol=10 * ROUND_OFF)
            F = np.array([0, 0, 1.3, -0.7, 0.4, 0])
            assert_allclose(plane.project(q, F), space.project(q, T6.T @ F), atol=10 * ROUND_OFF)


def test_no_coordinate_is_left_out_of_its_velocity() -> None:
    """The registry's sizes fit its names, and every kind that scenes may name is there."""
    kinds = {kind["name"]: kind for kind in laws.kinds()}
    assert set(kinds) >= {
        "revolute",
        "prismatic",
        "cylindrical",
        "universal",
        "spherical",
        "planar",
        "free",
        "weld",
    }
    for kind in kinds.values():
        assert len(kind["q"]) == kind["nq"] == len(kind["q_zero"])
        assert len(kind["v"]) == len(kind["a"]) == kind["nv"]


def test_written_in_F_turns_both_halves() -> None:
    """The helper itself: a quarter turn about z takes x to y in the angular and the linear half."""
    X = rotated(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    assert (written_in_F(X, np.array([1.0, 0, 0, 2, 0, 0])) == [0, 1, 0, 0, 2, 0]).all()
