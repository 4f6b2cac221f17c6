# SPDX-License-Identifier: BSD-3-Clause
"""Wrenches on bodies, constant and from inputs, compared with Newton-Euler solutions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, frame_sensor, joint, scene
from models.running import assert_close, run
from scipy.spatial.transform import Rotation

import gelenk

TIMES = np.linspace(0, 2, 21)
MASS, COM = 1.6, np.array([0.15, -0.2, 0.1])
MOMENTS = (0.3, 0.4, 0.5)


def pushed(wrench: dict[str, Any], w: tuple[float, float, float] = (0, 0, 0)) -> Scene:
    """A free body under one wrench."""
    start = {"w": list(w)}
    return scene(
        {"b": body(MASS, COM, MOMENTS)},
        {"J": joint("free", frame("ground"), frame("b"), start=start)},
        forces={"push": {"type": "wrench", "body": "b", **wrench}},
        sensors={"com": frame_sensor("b", COM), "E": {"type": "energy"}},
    )


def test_world_force_moves_center_of_mass_on_a_parabola() -> None:
    """For any point of application and any rotation of the body,
    a force constant in the world gives a parabola.
    """
    F = np.array([1.2, -0.7, 2.1])
    w = np.array([0.8, 1.1, -0.6])
    found = run(pushed({"position": [0.4, 0.3, -0.2], "force": F.tolist()}, tuple(w)), TIMES, tolerance=1e-12)
    t = found.time[:, None]
    expected = COM + np.cross(w, COM) * t + 0.5 * F / MASS * t**2
    assert_close("com", found.vector("com.r"), expected, 1e-10, "100 rtol")


def test_work_of_a_world_force_is_the_energy_gain() -> None:
    """The work of a constant force is F . (displacement of its point); for a torque see the next test."""
    F, at = np.array([1.2, -0.7, 2.1]), (0.4, 0.3, -0.2)
    source = pushed({"position": list(at), "force": F.tolist()}, (0.8, 1.1, -0.6))
    source["sensors"]["point"] = frame_sensor("b", at)
    found = run(source, TIMES, tolerance=1e-12)
    work = (found.vector("point.r") - found.vector("point.r")[0]) @ F
    assert_close("energy", found["E.kinetic"] - found["E.kinetic"][0], work, 1e-9, "100 rtol x 10 J")


def test_world_torque_changes_the_angular_momentum() -> None:
    """The angular momentum L about the center of mass increases by n t,
    in world axes, while the body tumbles.
    """
    n, w = np.array([0.5, -0.3, 0.4]), np.array([0.8, 1.1, -0.6])
    source = pushed({"torque": n.tolist()}, tuple(w))
    found = run(source, TIMES, tolerance=1e-12)
    R = Rotation.from_quat(found.vector("com.Q")).as_matrix()
    L = np.einsum("tij,tj->ti", R, np.array(MOMENTS) * found.vector("com.w"))
    assert_close("L", L, np.array(MOMENTS) * w + found.time[:, None] * n, 1e-10, "100 rtol")


def test_body_torque_rotates_with_the_body() -> None:
    """About a principal axis a torque fixed in the body gives constant angular acceleration."""
    found = run(pushed({"torque": [0, 0.7, 0], "frame": "body"}), TIMES, tolerance=1e-12)
    w = found.vector("com.w")
    assert_close("w[2]", w[:, 1], 0.7 / MOMENTS[1] * found.time, 1e-10, "100 rtol")
    assert_close("w[1], w[3]", w[:, [0, 2]], 0, 1e-12, "exact zeros up to round-off")


def test_body_force_rotates_with_the_body() -> None:
    """At a constant rotation about z with rate W, a thrust along the body's x moves the center of mass by
    (1 - cos W t, W t - sin W t) F/(m W^2): Newton's law integrated twice.
    """
    W, F = 2.3, 1.9
    source = pushed({"position": COM.tolist(), "force": [F, 0, 0], "frame": "body"}, (0, 0, W))
    found = run(source, TIMES, tolerance=1e-12)
    t = found.time
    v0 = np.cross([0, 0, W], COM)
    expected = COM + v0 * t[:, None]
    expected[:, 0] += F / (MASS * W**2) * (1 - np.cos(W * t))
    expected[:, 1] += F / (MASS * W**2) * (W * t - np.sin(W * t))
    assert_close("com", found.vector("com.r"), expected, 1e-10, "100 rtol")


def test_force_with_offset_equals_force_and_torque() -> None:
    """A wrench is transferred to another point by r x F: the motion is the same, in body axes."""
    F, at = np.array([0.4, 1.0, -0.3]), np.array([0.3, 0.2, 0.5])
    off = run(pushed({"position": at.tolist(), "force": F.tolist(), "frame": "body"}), TIMES, tolerance=1e-12)
    moved = {
        "position": COM.tolist(),
        "force": F.tolist(),
        "torque": np.cross(at - COM, F).tolist(),
        "frame": "body",
    }
    same = run(pushed(moved), TIMES, tolerance=1e-12)
    assert_close("r", off.vector("com.r"), same.vector("com.r"), 1e-10, "two runs at 1e-12")
    assert_close("w", off.vector("com.w"), same.vector("com.w"), 1e-10, "two runs at 1e-12")


@pytest.mark.parametrize("frame_name", ["world", "body"])
def test_wrench_inputs_add_to_the_constants(frame_name: str) -> None:
    """Inputs f[1..3] and t[1..3] added to the constants act like constants of the same sum."""
    F, n = np.array([0.4, 1.0, -0.3]), np.array([0.1, -0.2, 0.15])
    whole = {"position": [0.3, 0.2, 0.5], "force": F.tolist(), "torque": n.tolist(), "frame": frame_name}
    half = {**whole, "force": (F / 2).tolist(), "torque": (n / 2).tolist(), "input": True}
    inputs = {f"push.f[{i + 1}]": F[i] / 2 for i in range(3)} | {
        f"push.t[{i + 1}]": n[i] / 2 for i in range(3)
    }
    constant = run(pushed(whole, (0.3, 0, 0.9)), TIMES, tolerance=1e-12)
    fed = run(pushed(half, (0.3, 0, 0.9)), TIMES, tolerance=1e-12, inputs=inputs)
    assert_close(
        "r", fed.vector("com.r"), constant.vector("com.r"), 1e-13, "the same numbers up to one rounding"
    )
    assert [s.name for s in gelenk.Simulation(gelenk.load(pushed(half))).inputs] == list(inputs)


def test_wrench_components_refer_to_the_given_frame() -> None:
    """Components in a frame rotated relative to the body are the rotated components
    in body axes: constants and inputs.
    """
    turn = Rotation.from_rotvec([0.4, -0.9, 0.7])
    f, n = np.array([1.2, -0.7, 2.1]), np.array([0.5, -0.3, 0.4])
    x, y, z, w = turn.as_quat()
    place = {"frame": "body", "position": [0.4, 0.3, -0.2]}
    turned = {**place, "rotation": {"quaternion": [w, x, y, z]}, "force": f.tolist(), "input": True}
    along = {**place, "force": turn.apply(f).tolist(), "torque": turn.apply(n).tolist()}
    inputs = {f"push.t[{i + 1}]": float(n[i]) for i in range(3)}
    found = run(pushed(turned, (0.8, 1.1, -0.6)), TIMES, tolerance=1e-12, inputs=inputs)
    expected = run(pushed(along, (0.8, 1.1, -0.6)), TIMES, tolerance=1e-12)
    assert_close("com", found.vector("com.r"), expected.vector("com.r"), 1e-10, "100 rtol")
