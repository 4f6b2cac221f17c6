# SPDX-License-Identifier: BSD-3-Clause
"""Constant and fed wrenches on bodies."""

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


def test_world_force_moves_the_centre_of_mass() -> None:
    """Wherever it acts and however the body tumbles, a force fixed in the world gives a parabola."""
    F = np.array([1.2, -0.7, 2.1])
    w = np.array([0.8, 1.1, -0.6])
    found = run(pushed({"position": [0.4, 0.3, -0.2], "force": F.tolist()}, tuple(w)), TIMES, tolerance=1e-12)
    t = found.time[:, None]
    expected = COM + np.cross(w, COM) * t + 0.5 * F / MASS * t**2
    assert_close("com", found.vector("com.r"), expected, 1e-10, "100 rtol")


def test_world_force_does_the_work_that_the_body_gains() -> None:
    """Work of a constant force is F . (displacement of its point), a torque apart."""
    F, at = np.array([1.2, -0.7, 2.1]), (0.4, 0.3, -0.2)
    source = pushed({"position": list(at), "force": F.tolist()}, (0.8, 1.1, -0.6))
    source["sensors"]["point"] = frame_sensor("b", at)
    found = run(source, TIMES, tolerance=1e-12)
    work = (found.vector("point.r") - found.vector("point.r")[0]) @ F
    assert_close("energy", found["E.kinetic"] - found["E.kinetic"][0], work, 1e-9, "100 rtol x 10 J")


def test_world_torque_changes_the_angular_momentum() -> None:
    """L about the centre of mass grows by n t, along the world's axes, while the body tumbles."""
    n, w = np.array([0.5, -0.3, 0.4]), np.array([0.8, 1.1, -0.6])
    source = pushed({"torque": n.tolist()}, tuple(w))
    found = run(source, TIMES, tolerance=1e-12)
    R = Rotation.from_quat(found.vector("com.Q")).as_matrix()
    L = np.einsum("tij,tj->ti", R, np.array(MOMENTS) * found.vector("com.w"))
    assert_close("L", L, np.array(MOMENTS) * w + found.time[:, None] * n, 1e-10, "100 rtol")


def test_body_torque_turns_with_the_body() -> None:
    """About a principal axis a torque fixed in the body gives constant acceleration about it."""
    found = run(pushed({"torque": [0, 0.7, 0], "frame": "body"}), TIMES, tolerance=1e-12)
    w = found.vector("com.w")
    assert_close("w[2]", w[:, 1], 0.7 / MOMENTS[1] * found.time, 1e-10, "100 rtol")
    assert_close("w[1], w[3]", w[:, [0, 2]], 0, 1e-12, "exact zeros but for rounding")


def test_body_force_at_the_centre_follows_the_spin() -> None:
    """Spinning steadily about z at W, a thrust along the body's x moves the centre by
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


def test_force_off_the_centre_equals_force_and_torque_at_it() -> None:
    """A wrench is moved by r x F: the same motion either way, in the body's axes."""
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
def test_fed_wrench_adds_to_the_constant_one(frame_name: str) -> None:
    """f[1..3] and t[1..3] as inputs, on top of the constants, act like constants of the same sum."""
    F, n = np.array([0.4, 1.0, -0.3]), np.array([0.1, -0.2, 0.15])
    whole = {"position": [0.3, 0.2, 0.5], "force": F.tolist(), "torque": n.tolist(), "frame": frame_name}
    half = {**whole, "force": (F / 2).tolist(), "torque": (n / 2).tolist(), "input": True}
    inputs = {f"push.f[{i + 1}]": F[i] / 2 for i in range(3)} | {
        f"push.t[{i + 1}]": n[i] / 2 for i in range(3)
    }
    constant = run(pushed(whole, (0.3, 0, 0.9)), TIMES, tolerance=1e-12)
    fed = run(pushed(half, (0.3, 0, 0.9)), TIMES, tolerance=1e-12, inputs=inputs)
    assert_close(
        "r", fed.vector("com.r"), constant.vector("com.r"), 1e-13, "the same numbers but for one rounding"
    )
    assert [s.name for s in gelenk.Simulation(gelenk.load(pushed(half))).inputs] == list(inputs)


def test_body_wrench_follows_its_own_rotation() -> None:
    """Components along a frame turned in the body are those along its axes, turned: constants and inputs."""
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
