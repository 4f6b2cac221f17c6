# SPDX-License-Identifier: BSD-3-Clause
"""A free rigid body: conserved quantities and closed-form solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from mechanisms import body, frame, frame_sensor, joint, scene, with_sensors
from models.running import INTEGRATORS, Recording, assert_close, run
from scipy.spatial.transform import Rotation
from scipy.special import ellipj

pytestmark = warned.TIGHT

INERTIA = np.array([1.0, 2.0, 3.0])  # kg m2
MASS = 1.7  # kg


def flying(w: tuple[float, float, float], v: tuple[float, float, float] = (0, 0, 0), com=(0, 0, 0), **fields):
    """Return a free body with angular velocity w [rad/s, in body axes] and velocity v [m/s] of its frame."""
    start = {"w": list(w), "v": list(v)}
    out = scene(
        {"body": body(MASS, com, INERTIA)},
        {"J": joint("free", frame("ground"), frame("body"), start=start)},
        **fields,
    )
    return with_sensors(out, E={"type": "energy"}, com=frame_sensor("body", com))


def rotations(found: Recording) -> np.ndarray:
    """Return R_WB at each output. Q[1..4] has the scalar part last, as in SciPy."""
    R: np.ndarray = Rotation.from_quat(found.vector("J.Q")).as_matrix()
    return R


@pytest.fixture(scope="module", params=INTEGRATORS)
def tumbling(request: pytest.FixtureRequest) -> Recording:
    """Rotation about the intermediate principal axis, which is unstable: the body flips again and again."""
    return run(
        flying((1e-3, 3, 1e-3), (0.3, -0.2, 0.7)),
        np.linspace(0, 100, 401),
        tolerance=1e-12,
        integrator=request.param,
    )


def test_energy_is_conserved(tumbling: Recording) -> None:
    """To 1e-9 of 9 J over 100 s. Drift of the quaternion norm or a wrong gyroscopic term gives 1e-3."""
    energy = tumbling["E.kinetic"]
    w = np.array([1e-3, 3, 1e-3])
    v = np.array([0.3, -0.2, 0.7])
    assert_close("energy", energy[0], 0.5 * (INERTIA * w) @ w + 0.5 * MASS * v @ v, 1e-14, "round-off")
    assert_close("energy", energy, energy[0], 1e-9 * energy[0], "conserved")


def test_angular_momentum_is_conserved(tumbling: Recording) -> None:
    """R I w is constant in the world frame, to 1e-9 of 6 N m s."""
    L = np.einsum("tij,tj->ti", rotations(tumbling), INERTIA * tumbling.vector("J.w"))
    assert_close("angular momentum", L, L[0], 1e-9 * float(np.linalg.norm(L[0])), "conserved")


def test_momentum_is_conserved(tumbling: Recording) -> None:
    """The velocity of the center of mass is constant and its path is straight."""
    v = tumbling.vector("J.v")
    assert_close("speed", v, v[0], 1e-9, "no force acts")
    path = tumbling.time[:, None] * v[0]
    assert_close("path", tumbling.vector("J.r"), path, 1e-9 * 100, "speed error over 100 s")


def test_quaternion_norm_is_one(tumbling: Recording) -> None:
    """|Q| = 1 to 1e-12 at every output."""
    assert_close(
        "|Q|", np.linalg.norm(tumbling.vector("J.Q"), axis=1), 1, 1e-12, "normalized after each step"
    )


def test_rotation_about_intermediate_axis_is_unstable(tumbling: Recording) -> None:
    """Rotation about the intermediate axis is unstable (Poinsot):
    w[2] must come close to -3 rad/s and back to +3.
    """
    w = tumbling["J.w[2]"]
    assert w.min() < -2.99
    assert w[50:].max() > 2.99


def test_intermediate_axis_rotation_matches_elliptic_functions() -> None:
    """Euler's equations are solved by Jacobi's sn, cn, dn (Landau & Lifshitz, Mechanics, section 37).

    With I1 < I2 < I3 and L^2 > 2 E I2: w1 = a1 cn, w2 = a2 sn, w3 = a3 dn of tau = p t, starting at w2 =
    0.
    """
    I1, I2, I3 = INERTIA
    w0 = np.array([0.9, 0.0, 1.3])
    E2, L2 = float((INERTIA * w0) @ w0), float((INERTIA * w0) @ (INERTIA * w0))
    assert L2 > E2 * I2
    a2 = math.sqrt((E2 * I3 - L2) / (I2 * (I3 - I2)))
    p = math.sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3))
    m = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1))
    times = np.linspace(0, 20, 101)
    sn, cn, dn, _ = ellipj(p * times, m)
    expected = np.array([w0[0] * cn, a2 * sn, w0[2] * dn]).T
    found = run(flying(tuple(w0)), times, tolerance=1e-11).vector("J.w")
    assert_close(
        "w", found, expected, 1e-9, "100 x rtol over 20 s; the sign of w2 is that of Euler's equations"
    )


def test_symmetric_top_precesses_at_constant_rate() -> None:
    """For I1 = I2, w precesses about the symmetry axis at (I3 - I1)/I1 w3 (Landau & Lifshitz, section 36)."""
    source = flying((0.4, 0.0, 2.0))
    source["bodies"]["body"]["inertia"] = [1.3, 1.3, 2.1, 0, 0, 0]
    times = np.linspace(0, 30, 101)
    rate = (2.1 - 1.3) / 1.3 * 2.0
    expected = np.array([0.4 * np.cos(rate * times), 0.4 * np.sin(rate * times), 0 * times + 2.0]).T
    found = run(source, times, tolerance=1e-11).vector("J.w")
    assert_close("w", found, expected, 1e-9, "100 x rtol")


def test_center_of_mass_of_thrown_body_follows_a_parabola() -> None:
    """The center of mass, offset from the body frame of a tumbling body, falls like a point mass."""
    com = np.array([0.2, -0.1, 0.35])
    w, v = np.array([1.1, -0.7, 2.3]), np.array([1.0, 2.0, 5.0])
    g = np.array([0.3, -0.5, -9.81])
    found = run(
        flying(tuple(w), tuple(v), tuple(com), gravity=g.tolist()), np.linspace(0, 2, 21), tolerance=1e-12
    )
    t = found.time[:, None]
    expected = com + (v + np.cross(w, com)) * t + 0.5 * g * t**2
    assert_close("center of mass", found.vector("com.r"), expected, 1e-9, "solver, 100 x rtol x 10 m")


def test_frame_sensor_reports_velocity_of_its_point() -> None:
    """Sensor output v is the time derivative of r (central difference),
    w is the angular velocity in body axes.
    """
    com = (0.2, -0.1, 0.35)
    times = np.arange(0, 0.2, 1e-3)
    found = run(flying((1.1, -0.7, 2.3), (1.0, 2.0, 5.0), com), times, tolerance=1e-12)
    rate = (found.vector("com.r")[2:] - found.vector("com.r")[:-2]) / 2e-3
    # h^2/6 |r'''|, |r'''| < w^3 |com| = 9; and 1e-12 / h
    assert_close("com.v", found.vector("com.v")[1:-1], rate, 5e-6, "h^2/6 r'''")
    assert_close("com.w", found.vector("com.w"), found.vector("J.w"), 1e-14, "round-off")


def test_free_joint_velocities_are_derivatives_of_its_position() -> None:
    """J.v = der(J.r), J.a = der(J.v), J.z = der(J.w), by central differences over 1 ms."""
    times = np.arange(0, 0.2, 1e-3)
    found = run(flying((1.1, -0.7, 2.3), (1.0, 2.0, 5.0), (0.2, -0.1, 0.35)), times, tolerance=1e-12)
    for place, rate in (("J.r", "J.v"), ("J.v", "J.a"), ("J.w", "J.z")):
        quotient = (found.vector(place)[2:] - found.vector(place)[:-2]) / 2e-3
        assert_close(rate, found.vector(rate)[1:-1], quotient, 2e-5, "h^2/6 of the third derivative, < 100")
