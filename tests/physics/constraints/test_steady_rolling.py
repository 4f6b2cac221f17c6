# SPDX-License-Identifier: BSD-3-Clause
"""Wheels in steady rolling: a disc on a circle, and a wheel held on a slope."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk

CLOSE = 1e-11  # Newton's method has converged; rounding of sums of a few terms

RADIUS, HOOP = 0.3, 2.0  # m, kg


def disc(tilt: float) -> Scene:
    """A thin disc on a chain of joints; the bodies between them have masses below rounding."""
    axes = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1], "yaw": [0, 0, 1], "tilt": [1, 0, 0]}
    bodies: dict[str, Any] = {f"b_{name}": body(1e-30, (0, 0, 0), (1e-30,) * 3) for name in axes}
    across = HOOP * RADIUS**2 / 4
    bodies["disc"] = body(HOOP, (0, 0, 0), (across, 2 * across, across))
    joints = {}
    before = "ground"
    for name, axis in (axes | {"spin": [0, 1, 0]}).items():
        child = f"b_{name}" if name in axes else "disc"
        kind = "prismatic" if name in "xyz" else "revolute"
        joints[name] = joint(kind, frame(before), frame(child), axis=axis)
        before = child
    joints["z"]["start"] = {"s": RADIUS * math.cos(tilt)}
    joints["tilt"]["start"] = {"phi": tilt}
    return scene(
        bodies, joints, gravity=[0, 0, -GRAVITY],
        constraints={"tyre": {"type": "rolling", "body": "disc", "radius": RADIUS}},
    )  # fmt: skip


@pytest.mark.parametrize(("tilt", "spin"), [(0.2, 12.0), (0.5, -8.0), (-0.3, 5.0), (0.0, 4.0), (0.0, 2.0)])
def test_disc_rolls_on_a_circle(tilt: float, spin: float) -> None:
    """Newton-Euler equations along tangent, axle, spoke, w = (tilt', spin + yaw' sin, yaw' cos), k = m r^2:

    (I + k) w1' = (J + k) w2 w3 - I w3^2 tan + m g r sin, (J + k) w2' = -k w1 w3,
    I w3' = w1 (I w3 tan - J w2).
    The last two give the dependence of w2 and w3 on the tilt, hence the stiffness of the first.
    """
    source = disc(tilt)
    found = gelenk.equilibrium(
        source, steady={"spin.w": spin, "tilt.w": 0.0, "yaw.w": None}, hold={"tilt.phi": tilt},
        at={"yaw.w": -math.copysign(0.5, tilt * spin) if tilt else 0.0},
    )  # fmt: skip
    k = HOOP * RADIUS**2
    across, along = k / 4, k / 2
    s, c, t = math.sin(tilt), math.cos(tilt), math.tan(tilt)
    w3 = found.values["yaw.w"] * c
    w2 = spin + w3 * t
    weight = HOOP * GRAVITY * RADIUS
    assert (along + k) * w2 * w3 - across * w3**2 * t + weight * s == pytest.approx(0, abs=1e-10 * weight)
    by_tilt_2, by_tilt_3 = -k * w3 / (along + k), w3 * t - along * w2 / across
    slope = (along + k) * (by_tilt_2 * w3 + w2 * by_tilt_3) - 2 * across * w3 * by_tilt_3 * t
    slope += weight * c - across * (w3 / c) ** 2
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        modes = gelenk.modes(source, at=found.at)
    *zeros, last = modes.modes
    rate = math.sqrt(abs(slope) / (across + k))
    if slope < 0:
        assert modes.stability == "marginal"
        assert last.natural_frequency == pytest.approx(rate, rel=1e-10)
        # Heading drifts in a wider circle, the place across as t^2 with it, the place along with the spin.
        kinds = [(mode.kind, mode.chain_length) for mode in zeros]
        assert kinds == [("drifting", 3), ("drifting", 2), ("rigid-body", 1)]
        assert zeros[0].grows_in_position_only
        assert zeros[0].names == ["y.s"]
    else:  # too slow to be stable
        assert modes.stability == "unstable"
        assert modes.decided_by is not None
        assert modes.decided_by.eigenvalue == pytest.approx(rate, rel=1e-10)
    # On its heading depends where x and y go; the wheel's own angle is nothing to warn of.
    named = [str(warning.message).partition("equilibrium: ")[2] for warning in caught]
    assert [name.split()[0] for name in named] == (["yaw.phi"] if tilt else [])
    # Without the cyclic coordinates there is no warning, and no mode drifts.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        few = gelenk.modes(source, at=found.at, states=["tilt.phi", "tilt.w", "yaw.w", "spin.w"])
    assert few.stability == modes.stability
    assert few.modes[-1].natural_frequency == pytest.approx(last.natural_frequency, rel=CLOSE)
    assert {mode.kind for mode in few.modes} == (
        {"rigid-body", "undamped"} if slope < 0 else {"rigid-body", "unstable", "damped"}
    )
    assert {*few.modes[-1].shape} == {"tilt.phi", "z.s"}
    assert {*found.advancing} == {"x.s", "spin.phi", *(["yaw.phi"] if tilt else [])}


def unicycle(slope: float) -> Scene:
    """A motor between a wheel and its hub, from which a bob hangs; downhill is along x."""
    return scene(
        {"hub": body(0.5), "wheel": body(2.0, (0, 0, 0), (0.05, 0.1, 0.05)), "bob": body(1.5, (0, 0, -0.2))},
        {"x": joint("prismatic", frame("ground", (0, 0, RADIUS)), frame("hub"), axis=[1, 0, 0]),
         "spin": joint("revolute", frame("hub"), frame("wheel"), axis=[0, 1, 0]),
         "swing": joint("revolute", frame("hub"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.3})},
        gravity=[GRAVITY * math.sin(slope), 0, -GRAVITY * math.cos(slope)],
        motors={"drive": {"joint": "spin"}},
        constraints={"tyre": {"type": "rolling", "body": "wheel", "radius": RADIUS}},
    )  # fmt: skip


@pytest.mark.parametrize("speed", [0.0, 2.0])
def test_motor_torque_holds_a_wheel_on_a_slope(speed: float, tmp_path: Path) -> None:
    """The torque is m g r sin(slope), at rest and at constant speed; the bob hangs vertically."""
    source = unicycle(0.04)
    steady_speed = {"x.v": speed} if speed else None
    found = gelenk.equilibrium(source, steady=steady_speed, solve_for="drive.tau")
    by_fmu = gelenk.equilibrium(
        gelenk.export_fmu(source, tmp_path / "x.fmu"), steady=steady_speed, solve_for="drive.tau"
    )
    torque = 4.0 * GRAVITY * math.sin(0.04) * RADIUS
    for each in (found, by_fmu):
        assert each.inputs["drive.tau"] == pytest.approx(-torque, rel=CLOSE)
        assert each.values["swing.phi"] == pytest.approx(-0.04, rel=CLOSE)
        assert each.values["spin.w"] == pytest.approx(speed / RADIUS, abs=1e-12)
