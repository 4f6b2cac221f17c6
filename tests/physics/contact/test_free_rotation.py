# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that rotate freely, as fast as they do in flight between contacts, against closed forms.

The contact of each scene is far below: it selects time stepping, and nothing touches.
"""

from itertools import pairwise
from math import atan2, cos, sin, sqrt

import numpy as np
import pytest
from models.touching import SceneData, on_plane
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipkinc

import gelenk

STEP = 1e-3  # s
ASYMMETRIC = [1.0, 2.0, 2.5]  # kg m2


def free_body(
    rate: list[float], moments: list[float], *, step: float = STEP, com: list[float] | None = None
) -> SceneData:
    """A body of 2 kg in weightlessness; rate: its angular velocity [rad/s]."""
    scene = on_plane({"box": [0.1, 0.2, 0.3]}, 2, moments, {"r": [0, 0, 500], "w": rate}, {}, step=step)
    scene["gravity"] = [0, 0, 0]
    if com is not None:
        scene["bodies"]["body"]["com"] = com
    return scene


def states(run: gelenk.Result, joint: str = "J") -> tuple[Rotation, np.ndarray]:
    """Orientations and angular velocities in the body [rad/s]."""
    Q = np.stack([run[f"{joint}.Q[{k}]"] for k in (1, 2, 3, 4)], axis=1)
    w = np.stack([run[f"{joint}.w[{k}]"] for k in (1, 2, 3)], axis=1)
    return Rotation.from_quat(Q), w


@pytest.mark.parametrize("com", [None, [0.1, -0.05, 0.2]])
@pytest.mark.parametrize("angle", [0.01, 0.3, 0.6, 0.99])
def test_energy_and_angular_momentum_are_conserved(angle: float, com: list[float] | None) -> None:
    """Up to rounding of 1000 steps, in each of which the body turns by this angle [rad]."""
    rate = angle / STEP * np.array([0.6, 0.3, 0.7]) / sqrt(0.94)
    scene = free_body(rate.tolist(), ASYMMETRIC, com=com)
    outputs = ["energy.kinetic", *(f"J.{x}[{k}]" for x in "rvwQ" for k in (1, 2, 3)), "J.Q[4]"]
    run = gelenk.simulate(scene, stop=1, step=0.01, outputs=outputs)
    R, w = states(run)
    L = R.apply(np.array(ASYMMETRIC) * w)
    energy = run["energy.kinetic"]
    assert np.abs(energy / energy[0] - 1).max() <= 1e-12
    assert np.linalg.norm(L - L[0], axis=1).max() <= 1e-12 * np.linalg.norm(L[0])
    if com is not None:  # its center of mass moves straight on
        r, v = (np.stack([run[f"J.{x}[{k}]"] for k in (1, 2, 3)], axis=1) for x in "rv")
        p = 2 * (v + R.apply(np.cross(w, com)))
        size = np.linalg.norm(rate) * np.linalg.norm(com)
        assert np.abs(p - p[0]).max() <= 1e-12 * 2 * size
        assert np.abs(r + R.apply(com) - r[0] - com - run.time[:, None] * p / 2).max() <= 1e-12 * size


def test_rotation_about_a_principal_axis_is_exact() -> None:
    """By 0.9 rad per step. An angle of 900 rad is rounded to 1e-13 rad, 1000 steps to less than 1e-11."""
    R, _ = states(gelenk.simulate(free_body([900, 0, 0], ASYMMETRIC), stop=1, step=0.1))
    exact = Rotation.from_rotvec([[900 * t, 0, 0] for t in np.linspace(0, 1, 11)])
    assert (R * exact.inv()).magnitude().max() <= 1e-11


def orders(errors: list[float]) -> list[float]:
    """Of errors of steps of 4, 2 and 1 ms."""
    return [float(np.log2(coarse / fine)) for coarse, fine in pairwise(errors)]


def test_symmetric_body_precesses_regularly() -> None:
    """The symmetry axis turns about L with L / J1, the body about its axis with (1 - J3 / J1) w3 more."""
    J1, J3, w1, w3, t = 1.0, 1.8, 30.0, 40.0, 1.0
    L = np.array([J1 * w1, 0, J3 * w3])
    exact = Rotation.from_rotvec(L / J1 * t) * Rotation.from_rotvec([0, 0, (1 - J3 / J1) * w3 * t])
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        R, w = states(gelenk.simulate(free_body([w1, 0, w3], [J1, J1, J3], step=step), stop=t, step=t))
        assert w[-1, 2] == pytest.approx(w3, rel=1e-13)
        errors.append((R[-1] * exact.inv()).magnitude())
    assert min(orders(errors)) > 1.95
    # A rotation by the angle a per step is in error by less than a^3 / 12: 1000 steps of 0.08 rad.
    assert errors[-1] < 1000 * 0.08**3 / 12


def test_rotation_about_the_middle_axis_turns_over() -> None:
    """Euler's equations of unequal moments (Dzhanibekov): elliptic functions (Landau & Lifshitz, 37)."""
    A, B, C = ASYMMETRIC
    w0, t = np.array([0.3, 40.0, 0.5]), 2.0
    E2, L2 = float(w0**2 @ ASYMMETRIC), float((w0 * ASYMMETRIC) @ (w0 * ASYMMETRIC))
    assert L2 > E2 * B  # the third component keeps its sign
    rate = sqrt((C - B) * (L2 - E2 * A) / (A * B * C))
    m = (B - A) * (E2 * C - L2) / ((C - B) * (L2 - E2 * A))
    largest = np.sqrt(
        [(E2 * C - L2) / (A * (C - A)), (E2 * C - L2) / (B * (C - B)), (L2 - E2 * A) / (C * (C - A))]
    )

    def exact(phase: float) -> np.ndarray:
        sn, cn, dn, _ = ellipj(phase, m)
        return np.array([cn, sn, dn]) * largest

    start = float(ellipkinc(atan2(w0[1] / largest[1], w0[0] / largest[0]), m))
    assert exact(start) == pytest.approx(w0, rel=1e-9)
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        _, w = states(gelenk.simulate(free_body(w0.tolist(), ASYMMETRIC, step=step), stop=t, step=t / 50))
        assert w[:, 1].min() < -39  # it has turned over
        errors.append(np.abs(w - [exact(start + rate * time) for time in np.linspace(0, t, 51)]).max())
    assert min(orders(errors)) > 1.9
    # The phase is in error by less than h2 w2 / 12 of itself.
    assert errors[-1] < (STEP * 40) ** 2 / 12 * rate * t * 40


def test_heavy_top_precesses_steadily() -> None:
    """On a fixed point, with (C w3 - A W cos(tilt)) W = m g l (Euler): order 2 of azimuth and tilt."""
    m, g, length, tilt, spin, t = 2.0, 9.81, 0.3, 0.7, 60.0, 1.0
    A, C = 0.4, 0.25  # kg m2, about the fixed point
    half, weight = C * spin / (2 * A * cos(tilt)), m * g * length / (A * cos(tilt))
    W = half - sqrt(half * half - weight)  # the slow one
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        scene = free_body([0, 0, 0], [A - m * length**2, A - m * length**2, C], com=[0, 0, length], step=step)
        scene["gravity"] = [0, 0, -g]
        start = {"Q": [sin(tilt / 2), 0, 0, cos(tilt / 2)], "w": [0, W * sin(tilt), spin], "fixed": True}
        joint = {"type": "spherical", "parent": {"body": "ground", "position": [0, 0, 500]}, "child": "body"}
        scene["joints"] = {"J": {**joint, "start": start}}
        R, w = states(gelenk.simulate(scene, stop=t, step=t / 10))
        axis = R.apply([0, 0, 1])
        exact = Rotation.from_rotvec([[0, 0, W * time] for time in np.linspace(0, t, 11)]).apply(axis[0])
        errors.append(np.linalg.norm(axis - exact, axis=1).max())
        assert w[:, 2] == pytest.approx(spin, rel=1e-12)  # no torque about the axis
    assert min(orders(errors)) > 1.9
    assert errors[-1] < (STEP * spin) ** 2 / 12


def evaluations(scene: SceneData) -> float:
    """Of the forces, in a step in the middle of a run."""
    simulation = gelenk.Simulation(scene)
    simulation.initialize()
    counts = []
    for k in (1, 2):
        simulation.step_to(k * STEP)
        counts.append(simulation.diagnostics["solver.evaluations"])
    return counts[1] - counts[0]


def test_steps_are_divided_where_a_body_turns_by_more_than_a_radian() -> None:
    """Into up to 16 parts, in which it may turn by 2 rad; balls have no gyroscopic moment and any speed."""
    few = evaluations(free_body([0, 0, 1], ASYMMETRIC))
    assert evaluations(free_body([0, 999, 0], ASYMMETRIC)) == few
    assert evaluations(free_body([0, 1001, 0], ASYMMETRIC)) > 1.5 * few
    assert evaluations(free_body([0, 31.9e3, 0], ASYMMETRIC)) > 8 * few
    with pytest.raises(gelenk.StepError, match="do not converge"):
        evaluations(free_body([0, 32.1e3, 0], ASYMMETRIC))
    assert evaluations(free_body([0, 50e3, 0], [2, 2, 2])) == few


def test_hinged_bodies_keep_their_energy() -> None:
    """At 0.3 rad per step, forces are evaluated until they converge: three evaluations lose 3e-2.

    What remains is the error of the midpoint rule, whose mass matrix changes: 4e-3 here.
    """
    rate = 0.3 / STEP * np.array([0.6, 0.3, 0.7]) / sqrt(0.94)
    scene = free_body(rate.tolist(), ASYMMETRIC, com=[0.3, 0, 0])
    scene["bodies"]["other"] = scene["bodies"]["body"]
    hinge = {"type": "revolute", "axis": [0, 0, 1], "parent": {"body": "body", "position": [0.7, 0, 0]}}
    scene["joints"]["K"] = {**hinge, "child": "other"}
    run = gelenk.simulate(scene, stop=1, step=0.01, outputs=["energy.kinetic"])
    energy = run["energy.kinetic"]
    assert np.abs(energy / energy[0] - 1).max() < 1e-2
