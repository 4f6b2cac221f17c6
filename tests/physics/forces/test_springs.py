# SPDX-License-Identifier: BSD-3-Clause
"""Springs and dampers in joints and between points compared with closed-form solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, matrix, placed, rotation, scene
from models.running import assert_close, run
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

TIMES = np.linspace(0, 4, 41)


def damped_oscillation(x0: float, v0: float, omega0: float, D: float) -> tuple[np.ndarray, np.ndarray]:
    """Solution of x'' + 2 D x' + omega0^2 x = 0 and its derivative,
    D < omega0 (Landau & Lifshitz, section 25).
    """
    ring = math.sqrt(omega0**2 - D**2)
    c, s, decay = np.cos(ring * TIMES), np.sin(ring * TIMES), np.exp(-D * TIMES)
    b = (v0 + D * x0) / ring
    x = decay * (x0 * c + b * s)
    return x, decay * ((b * ring - D * x0) * c - (x0 * ring + D * b) * s)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_joint_spring_and_damper_form_a_linear_oscillator(kind: str) -> None:
    """With tau = -k (q - q_ref) - d v on an inertia,
    q oscillates about q_ref with omega0^2 = k/I, D = d/(2 I).
    """
    q, v = {"revolute": ("phi", "w"), "prismatic": ("s", "v")}[kind]
    mass, moment, k, d, rest = 1.7, 0.31, 7.3, 0.4, 0.23
    inertia = moment if kind == "revolute" else mass
    source = scene(
        {"b": body(mass, (0, 0, 0.4), (0.2, 0.25, moment))},
        {
            "J": joint(
                kind,
                frame("ground", (1, 2, 3)),
                frame("b"),
                axis=[0, 0, 1],
                stiffness=k,
                damping=d,
                spring_reference=rest,
                start={q: 0.9, v: -0.5},
            )
        },
    )
    found = run(source, TIMES, tolerance=1e-12)
    x, rate = damped_oscillation(0.9 - rest, -0.5, math.sqrt(k / inertia), d / (2 * inertia))
    assert_close(f"J.{q}", found[f"J.{q}"], rest + x, 1e-9, "1000 rtol")
    assert_close(f"J.{v}", found[f"J.{v}"], rate, 5e-9, "omega0 times as much")


def test_springs_of_a_cylindrical_joint_act_independently() -> None:
    """Translation and rotation oscillate independently, each with its element of the lists."""
    mass, moment = 1.7, 0.31
    k, d = (11.0, 2.3), (0.6, 0.05)
    source = scene(
        {"b": body(mass, (0, 0, 0.4), (0.2, 0.25, moment))},
        {
            "J": joint(
                "cylindrical",
                frame("ground"),
                frame("b"),
                axis=[0, 0, 1],
                stiffness=list(k),
                damping=list(d),
                start={"s": 0.3, "phi": -0.8},
            )
        },
    )
    found = run(source, TIMES, tolerance=1e-12)
    s, _ = damped_oscillation(0.3, 0, math.sqrt(k[0] / mass), d[0] / (2 * mass))
    phi, _ = damped_oscillation(-0.8, 0, math.sqrt(k[1] / moment), d[1] / (2 * moment))
    assert_close("J.s", found["J.s"], s, 1e-9, "1000 rtol")
    assert_close("J.phi", found["J.phi"], phi, 1e-9, "1000 rtol")


def test_damped_spherical_joint_decays_exponentially() -> None:
    """A ball of moment of inertia I with damping d about each axis:
    w decays as exp(-d t / I) in a constant direction.
    """
    I_ball, d = 0.4, 0.15
    w0 = np.array([1.0, -2.0, 0.5])
    source = scene(
        {"b": body(2.0, (0, 0, 0), (I_ball, I_ball, I_ball))},
        {
            "J": joint(
                "spherical",
                frame("ground"),
                frame("b"),
                damping=[d, d, d],
                start={"w": w0.tolist()},
            )
        },
    )
    found = run(source, TIMES, tolerance=1e-12).vector("J.w")
    assert_close("J.w", found, np.exp(-d / I_ball * TIMES)[:, None] * w0, 1e-10, "100 rtol")


def test_two_free_bodies_on_a_spring_oscillate_with_the_reduced_mass() -> None:
    """Length L(t) = L0 + x, x'' = -(k x + d x')/mu, mu = m1 m2/(m1 + m2);
    the common center of mass is at rest.
    """
    m1, m2, k, d, rest = 1.3, 2.9, 17.0, 0.8, 0.6
    mu = m1 * m2 / (m1 + m2)
    direction = np.array([0.48, -0.6, 0.64])
    place1, length = np.array([0.3, 0.1, -0.2]), 0.85
    place2 = place1 + length * direction
    start1 = {"r": place1.tolist()}
    start2 = {"r": place2.tolist()}
    source = scene(
        {"a": body(m1, (0, 0, 0), (0.1, 0.2, 0.15)), "b": body(m2, (0, 0, 0), (0.3, 0.2, 0.4))},
        {
            "A": joint("free", frame("ground"), frame("a"), start=start1),
            "B": joint("free", frame("ground"), frame("b"), start=start2),
        },
        forces={
            "spring": {
                "type": "spring_damper",
                "from": frame("a"),
                "to": frame("b"),
                "stiffness": k,
                "damping": d,
                "length": rest,
            }
        },
    )
    found = run(source, TIMES, tolerance=1e-12)
    a, b = found.vector("A.r"), found.vector("B.r")
    x, _ = damped_oscillation(length - rest, 0, math.sqrt(k / mu), d / (2 * mu))
    assert_close("length", np.linalg.norm(b - a, axis=1), rest + x, 1e-9, "1000 rtol")
    center = (m1 * place1 + m2 * place2) / (m1 + m2)
    assert_close("center", (m1 * a + m2 * b) / (m1 + m2), np.tile(center, (len(a), 1)), 1e-11, "10 rtol")


def eccentric_spring() -> Scene:
    """A planar body on a frictionless plane, held by a spring at a point away from its center of mass."""
    return scene(
        {"b": body(1.4, (0.1, 0.05, 0), (0.2, 0.2, 0.3))},
        {
            "J": joint(
                "planar",
                frame("ground"),
                frame("b"),
                axis=[0, 0, 1],
                start={"s_x": 0.2, "s_y": -0.3, "phi": 0.4, "w": 0.6},
            )
        },
        forces={
            "spring": {
                "type": "spring_damper",
                "from": frame("ground", (1.0, 0.5, 0)),
                "to": frame("b", (0.35, -0.2, 0)),
                "stiffness": 23.0,
                "damping": 1.1,
                "length": 0.5,
            }
        },
    )


def test_eccentric_spring_matches_newton_euler_equations() -> None:
    """Compared with the Newton-Euler equations for the plane, integrated by SciPy at 1e-12."""
    m, J, c, at = 1.4, 0.3, np.array([0.1, 0.05]), np.array([0.35, -0.2])
    anchor, k, d, rest = np.array([1.0, 0.5]), 23.0, 1.1, 0.5

    def rates(_t: float, y: np.ndarray) -> np.ndarray:
        """The state y: center of mass, angle, and their rates."""
        phi, w = y[2], y[5]
        R = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
        arm = R @ (at - c)
        span = y[:2] + arm - anchor
        rate = y[3:5] + w * np.array([-arm[1], arm[0]])
        length = np.linalg.norm(span)
        F = -(k * (length - rest) + d * (span @ rate) / length) * span / length
        return np.concatenate([y[3:], F / m, [(arm[0] * F[1] - arm[1] * F[0]) / J]])

    R0 = rotation([0, 0, 1], 0.4)[:2, :2]
    off = R0 @ c
    y0 = np.concatenate([np.array([0.2, -0.3]) + off, [0.4], 0.6 * np.array([-off[1], off[0]]), [0.6]])
    truth = solve_ivp(rates, (0, 4), y0, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=TIMES).y
    found = run(eccentric_spring(), TIMES, tolerance=1e-12)
    assert_close("J.phi", found["J.phi"], truth[2], 1e-8, "10^4 rtol: the motion is irregular")
    off_t = np.array(
        [c[0] * np.cos(truth[2]) - c[1] * np.sin(truth[2]), c[0] * np.sin(truth[2]) + c[1] * np.cos(truth[2])]
    )
    assert_close("J.s_x", found["J.s_x"], truth[0] - off_t[0], 1e-8, "as above")
    assert_close("J.s_y", found["J.s_y"], truth[1] - off_t[1], 1e-8, "as above")


def test_exchanging_spring_ends_does_not_change_the_motion() -> None:
    """With `from` and `to` exchanged, and the scene rotated as a whole, nothing changes."""
    plain = run(eccentric_spring(), TIMES, tolerance=1e-12)
    source = eccentric_spring()
    spring = source["forces"]["spring"]
    spring["from"], spring["to"] = spring["to"], spring["from"]
    turned = placed(source, Rotation.random(random_state=8).as_matrix(), (1, -2, 0.5))
    found = run(turned, TIMES, tolerance=1e-12)
    for name in ("J.phi", "J.s_x", "J.s_y"):
        assert_close(name, found[name], plain[name], 1e-9, "two integrations at 1e-12")


def test_spring_energy_is_part_of_the_conserved_total() -> None:
    """Potential energy includes gravity, joint springs and point springs: undamped, the total is constant."""
    source = eccentric_spring()
    source["forces"]["spring"]["damping"] = 0.0
    source["joints"]["J"].update(stiffness=[3.0, 5.0, 0.7], spring_reference=[0.1, -0.2, 0.3])
    source["gravity"] = [0.4, -9.81, 0]
    source["sensors"] = {"E": {"type": "energy"}}
    found = run(source, TIMES, tolerance=1e-12)
    total = found["E.total"]
    assert_close("energy", total, total[0], 1e-10 * float(np.ptp(found["E.kinetic"])) + 1e-10, "100 rtol")
    assert np.ptp(found["E.kinetic"]) > 1  # J: the mechanism does move


def test_spring_reference_is_a_joint_coordinate() -> None:
    """A revolute joint with frames rotated relative to each other has its
    equilibrium at phi = spring_reference.
    """
    R = matrix(rotation([0, 0, 1], 0.9))
    source = scene(
        {"b": body(1.0, (0, 0, 0.1), (0.1, 0.1, 0.2))},
        {
            "J": joint(
                "revolute",
                frame("ground"),
                {**frame("b"), "rotation": R},
                axis=[0, 0, 1],
                stiffness=4.0,
                damping=3.0,
                spring_reference=0.5,
            )
        },
    )
    found = run(source, np.array([0.0, 60.0]), tolerance=1e-10)
    # damped above critical: 1/tau = 1.5 /s at the slowest, e^-90 left
    assert_close("J.phi", found["J.phi"][-1], 0.5, 1e-9, "10 rtol")
