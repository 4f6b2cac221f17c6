# SPDX-License-Identifier: BSD-3-Clause
"""Rolling wheels that are not symmetric discs: Newton-Euler equations, scaling, assembly on the ground."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import (
    GRAVITY,
    Array,
    Scene,
    body,
    frame,
    frame_sensor,
    inertia_matrix,
    joint,
    matrix,
    numbers,
    rotation,
    scene,
)
from models.disc import ACROSS, AXIAL, MASS, RADIUS, WOBBLING, disc, truth
from models.running import Recording, assert_close, run
from scipy.spatial.transform import Rotation

import gelenk

pytestmark = warned.GUESSES

UP = np.array([0, 0, 1.0])
AXIS = np.array([0.3, 0.8, -0.2]) / np.linalg.norm([0.3, 0.8, -0.2])
HUB, COM = np.array([0.1, -0.2, 0.05]), np.array([0.13, -0.18, 0.02])
LUMP = body(2.0, COM, (0.06, 0.09, 0.08, 0.01, -0.005, 0.008))
STEP = 1e-3  # s


def lump_on_a_wheel() -> Scene:
    """A spinning wheel whose hub, axis and center of mass are not at the body frame's origin and axes."""
    level = rotation(np.cross(AXIS, [0, 1, 0]), float(np.arccos(AXIS[1])))
    R = rotation([1, 0, 0], 0.2) @ level
    start = {
        "r": numbers([0, 0, RADIUS * np.cos(0.2)] - R @ HUB),
        "rotation": matrix(R),
        "w": numbers(R.T @ [0.3, 6.0, 0.5]),
        "fixed": ["r", "Q", "w"],
    }
    return scene(
        {"wheel": LUMP},
        {"free": joint("free", frame("ground"), frame("wheel"), start=start)},
        gravity=[0, 0, -GRAVITY],
        constraints={
            "tyre": {
                "type": "rolling", "body": "wheel", "radius": RADIUS,
                "axis": numbers(AXIS), "position": numbers(HUB),
            }
        },
        sensors={"com": frame_sensor("wheel", COM), "hub": frame_sensor("wheel", HUB)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def found() -> Recording:
    return run(lump_on_a_wheel(), np.linspace(0, 2000 * STEP, 2001), tolerance=1e-11)


def turns(found: Recording) -> Rotation:
    return Rotation.from_quat(found.vector("hub.Q"))


def contact_force(found: Recording) -> Array:
    """The contact force in the world frame, from its normal, longitudinal and lateral components."""
    heading = np.cross(turns(found).apply(AXIS), UP)
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    parts = {"f_n": UP, "f_long": heading, "f_lat": np.cross(UP, heading)}
    out: Array = sum(found[f"tyre.{name}"][:, None] * direction for name, direction in parts.items())
    return out


def integrated(rates: Array) -> Array:
    """The integral over each two steps, by Simpson's rule."""
    out: Array = (rates[:-2:2] + 4 * rates[1::2] + rates[2::2]) * STEP / 3
    return out


def test_contact_force_accelerates_the_center_of_mass(found: Recording) -> None:
    change = np.diff(2.0 * found.vector("com.v")[::2], axis=0)
    force = contact_force(found) - 2.0 * GRAVITY * UP
    # h^5 / 90 times fourth derivatives, about 10 N (20 rad/s)^4: 2e-11; more where forces change by 100 N/s.
    assert_close("momentum", change, integrated(force), 1e-9, "Simpson's rule")


def test_contact_moment_changes_the_angular_momentum_about_the_center_of_mass(found: Recording) -> None:
    spin = turns(found).apply(found.vector("hub.w") @ inertia_matrix(LUMP))
    moment = np.cross(found.vector("tyre.r") - found.vector("com.r"), contact_force(found))
    assert_close("spin", np.diff(spin[::2], axis=0), integrated(moment), 1e-9, "Simpson's rule")


def test_wheel_rolls_on_its_rim_and_conserves_energy(found: Recording) -> None:
    arm = found.vector("tyre.r") - found.vector("hub.r")
    slip = found.vector("hub.v") + np.cross(turns(found).apply(found.vector("hub.w")), arm)
    assert_close("slip", slip, 0, 1e-11, "projected")
    assert_close("height", found["tyre.r[3]"], 0, 1e-12, "projected")
    assert_close("rim", np.linalg.norm(arm, axis=1), RADIUS, 1e-13, "round-off")
    assert_close("disc", np.sum(arm * turns(found).apply(AXIS), axis=1), 0, 1e-13, "round-off")
    assert np.ptp(found["energy.total"]) < 1e-10 * found["energy.total"][0]  # 10 rtol


@pytest.mark.parametrize("scale", [1e-3, 0.1, 100.0])
def test_motion_is_invariant_under_scaling(scale: float) -> None:
    """Lengths times `scale`, durations times its root, masses times its cube, from 0.3 mm to 30 m."""
    source = disc()
    source["bodies"]["wheel"] = body(
        MASS * scale**3, (0, 0, 0), [scale**5 * moment for moment in (ACROSS, AXIAL, ACROSS)]
    )
    source["constraints"]["tyre"]["radius"] *= scale
    source["joints"]["height"]["start"]["s"] *= scale
    for name in ("base", "lean", "spin"):
        source["joints"][name]["start"]["w"] /= np.sqrt(scale)
    times = np.linspace(0, 4, 41)
    found = run(source, times * np.sqrt(scale), tolerance=1e-11)
    expected = truth(WOBBLING, times)
    for name, unit in {"lean.phi": 1.0, "base.s_x": scale, "tyre.f_n": scale**3}.items():
        assert_close(name, found[name] / unit, expected[name], 1e-9, "100 rtol")


def test_lean_is_found_from_a_fixed_height() -> None:
    """A height that cannot be reached is rejected."""
    source = disc()
    source["joints"]["height"]["start"] = {"s": 0.25, "fixed": True}
    source["joints"]["lean"]["start"] = {"phi": 0.3, "w": 0.3}
    assert_close("lean", run(source, [0.0])["lean.phi"], np.arccos(0.25 / RADIUS), 1e-9, "closed to 1e-9 m")
    source["joints"]["height"]["start"]["s"] = 0.35
    with pytest.raises(gelenk.AssemblyError, match=r"constraints\.tyre cannot be closed.*height\.s"):
        gelenk.Simulation(gelenk.load(source)).initialize()
