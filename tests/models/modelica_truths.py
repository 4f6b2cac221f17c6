# SPDX-License-Identifier: BSD-3-Clause
"""Independent solutions for examples of the Modelica Standard Library:
Newton-Euler equations, SciPy at 1e-12.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from mechanisms import Array, box, cylinder, inertia_matrix, rotation
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from models.modelica import G_N, TURNED
from models.one_dof import Jet, Moving, OneDofMechanism, atan2, cos, jet, sin, sqrt

DOWN = np.array([0, -G_N, 0])


def solved(rates: Callable[[float, Array], Array], y0: Array, times: Array, rtol: float = 1e-12) -> Array:
    """Shape (states, times)."""
    span = (times[0], times[-1])
    found = solve_ivp(rates, span, y0, method="DOP853", t_eval=times, rtol=rtol, atol=rtol)
    assert found.success, found.message
    y: Array = found.y
    return y


def quaternion_rate(q: Array, w: Array) -> Array:
    """Derivative of the quaternion x, y, z, w, with w in body axes."""
    v, s = q[:3], q[3]
    return 0.5 * np.append(s * w + np.cross(v, w), -v @ w)


def hanging_body(
    mass: float,
    moment: float,
    com: Array,
    pull: Callable[[Array, Array], Array],
    y0: Array,
    times: Array,
    rtol: float,
) -> Array:
    """A body with equal principal moments, loaded at its frame: rows r, v, Q, w (in body axes)."""

    def rates(_t: float, y: Array) -> Array:
        r, v, q, w = y[:3], y[3:6], y[6:10], y[10:]
        R = Rotation.from_quat(q).as_matrix()
        force = pull(r, v)
        dw = np.cross(-com, R.T @ force) / moment
        dv = force / mass + DOWN - R @ (np.cross(dw, com) + np.cross(w, np.cross(w, com)))
        return np.concatenate([v, dv, quaternion_rate(q, w), dw])

    return solved(rates, y0, times, rtol)


def spring(a: Array, b: Array, stiffness: float) -> Array:
    """Force of a spring of 0.1 m on its end b."""
    length = float(np.linalg.norm(a - b))
    force: Array = stiffness * (length - 0.1) * (a - b) / length
    return force


def spring_damper_system(times: Array) -> dict[str, Array]:
    top = np.array([0.3, 0, 0])

    def pull(r: Array, v: Array) -> Array:
        along = (r - top) / np.linalg.norm(r - top)
        out: Array = spring(top, r, 30.0) - 2.0 * (v @ along) * along
        return out

    y0 = np.array([0.3, -0.2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0.03490658503988659])
    y = hanging_body(1.0, 0.1, np.array([0, -0.2, 0]), pull, y0, times, 1e-12)
    rest, rate = 0.1 + G_N / 30, np.sqrt(30)
    slide = {
        "p2.s": rest + (0.1 - rest) * np.cos(rate * times),
        "p2.v": -(0.1 - rest) * rate * np.sin(rate * times),
    }
    return vectors({"free.r": y[:3], "free.v": y[3:6], "free.w": y[10:]}) | slide


def node_at_rest(r: Array, guess: Array) -> Array:
    """Equilibrium of the node of the three springs, for body1's frame at r."""
    ends = ((np.array([0.3, 0, 0]), 20.0), (np.array([0, 0, 0.3]), 20.0), (r, 40.0))
    found = root(lambda n: sum(spring(end, n, c) for end, c in ends), guess, tol=1e-14)
    out: Array = found.x
    return out


def three_springs(times: Array) -> dict[str, Array]:
    """Accurate to 1e-9: each evaluation of the rates solves an equation."""
    node = [np.array([0.3, -0.15, 0.1])]

    def pull(r: Array, _v: Array) -> Array:
        node[0] = node_at_rest(r, node[0])
        return spring(node[0], r, 40.0)

    y0 = np.array([0.5, -0.3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0])
    y = hanging_body(0.8, 0.1, np.array([0, -0.2, 0]), pull, y0, times, 1e-9)
    return vectors({"free.r": y[:3], "free.v": y[3:6], "free.w": y[10:]})


def vectors(rows: dict[str, Array]) -> dict[str, Array]:
    return {f"{name}[{i + 1}]": row for name, block in rows.items() for i, row in enumerate(block)}


FOOT, END, ANCHOR = np.array([0.2, -0.3, 0.2]), np.array([0.4, 0, 0]), np.array([0.8, 0, 0.3])


def prismatic_constraint(times: Array) -> dict[str, Array]:
    """Along each prismatic joint s'' = -20 (s - rest)."""
    R, rate = TURNED, np.sqrt(20)
    rest = (R.T @ (ANCHOR - FOOT + DOWN / 20) - END)[:2]
    s = np.outer(rest, 1 - np.cos(rate * times))
    v = np.outer(rest, rate * np.sin(rate * times))
    r = FOOT[:, None] + R[:, :2] @ s
    slides = {"x.s": s[0], "y.s": s[1], "x.v": v[0], "y.v": v[1]}
    return vectors({"body_moves.r": r, "body_moves.v": R[:, :2] @ v}) | slides


def spherical_constraint(times: Array) -> dict[str, Array]:
    """Euler's equation about the ball joint, as a rotation relative to TURNED."""
    J, com = np.diag([1, 1.04, 1.04]), END / 2

    def rates(_t: float, y: Array) -> Array:
        q, w = y[:4], y[4:]
        R = TURNED @ Rotation.from_quat(q).as_matrix()
        pull = 20 * (ANCHOR - FOOT - R @ END)
        moment = np.cross(END, R.T @ pull) + np.cross(com, R.T @ DOWN)
        dw = np.linalg.solve(J, moment - np.cross(w, J @ w))
        return np.concatenate([quaternion_rate(q, w), dw])

    return vectors({"ball.w": solved(rates, np.array([0, 0, 0, 1.0, 0, 0, 0]), times)[4:]})


def gyroscopic_effects(times: Array) -> dict[str, Array]:
    """A gyrostat: the rotor, symmetric about its axis n, keeps its spin of 10 rad/s about it."""
    arm, rotor = cylinder((0.25, 0, 0), 0.05), cylinder((0.2, 0, 0), 0.1)
    S = rotation([0, 1, 0], np.radians(45))
    n, center = S[:, 0], np.array([0.25, 0, 0])  # the rotor's center is at the joint
    J = inertia_matrix(arm) + S @ inertia_matrix(rotor) @ S.T
    for part, c in ((arm, np.array(arm["com"])), (rotor, center)):
        J += part["mass"] * (c @ c * np.eye(3) - np.outer(c, c))
    axial = rotor["inertia"][0]
    J -= axial * np.outer(n, n)
    first = arm["mass"] * np.array(arm["com"]) + rotor["mass"] * center

    def rates(_t: float, y: Array) -> Array:
        q, w = y[:4], y[4:7]
        R = Rotation.from_quat(q).as_matrix()
        spin = 10 * axial * n
        dw = np.linalg.solve(J, np.cross(first, R.T @ DOWN) - np.cross(w, J @ w + spin))
        return np.concatenate([quaternion_rate(q, w), dw, [10 - n @ w]])

    y = solved(rates, np.array([0, 0, 0, 1.0, 0, 0, 0, 0]), times)
    w, phi = y[4:7], y[7]
    across = (S.T @ w)[1:]  # of the rotor, in axes that do not spin with it
    turned = [
        np.cos(phi) * across[0] + np.sin(phi) * across[1],
        np.cos(phi) * across[1] - np.sin(phi) * across[0],
    ]
    out = vectors({"arm.w": w, "rotor.w": np.array([np.full_like(phi, 10.0), *turned])})
    return out | {"revolute.phi": phi, "revolute.w": 10 - n @ w}


def engine1a(times: Array) -> dict[str, Array]:
    """A slider-crank in the y-z plane, here x-y: crank 0.1 m, rod 0.2 m."""
    pieces = [
        (cylinder((0.1, 0, 0), 0.05), 0.0),
        (box((0, 0.1, 0), 0.02, 0.05), 0.0),
        (cylinder((0.1, 0, 0), 0.03), 0.1),
        (box((0, -0.1, 0), 0.02, 0.05), 0.1),
    ]
    at = [height + part["com"][1] for part, height in pieces]
    mass = sum(part["mass"] for part, _ in pieces)
    center = sum(part["mass"] * y for (part, _), y in zip(pieces, at, strict=True)) / mass
    moment = 1 + sum(
        p["inertia"][0] + p["mass"] * (y - center) ** 2 for (p, _), y in zip(pieces, at, strict=True)
    )
    rod, piston = box((0, -0.2, 0), 0.02, 0.06), cylinder((0, -0.1, 0), 0.1)

    def bodies(phi: Jet) -> Iterator[Moving]:
        y, z = 0.1 * cos(phi), 0.1 * sin(phi)
        up = sqrt(0.04 - z * z)
        yield Moving(mass, (center * cos(phi), center * sin(phi), jet(0)), phi, moment)
        yield Moving(rod["mass"], (y + up / 2, z / 2, jet(0)), atan2(-z, up), rod["inertia"][0])
        yield Moving(piston["mass"], (y + up + 0.05, jet(0), jet(0)), jet(0), 1.0)

    phi, w = OneDofMechanism(bodies, (-G_N, 0, 0)).motion(0.0, 10.0, times)
    return {"bearing.phi": phi, "bearing.w": w}


def rolling_wheel(times: Array) -> dict[str, Array]:
    """Angular momentum about the contact point, at rho from the center, which does not slip."""
    mass, radius, moments, z = 2.0, 0.3, np.diag([0.12, 0.06, 0.12]), np.array([0, 0, 1.0])
    weight = np.array([0, 0, -mass * G_N])

    def rates(_t: float, y: Array) -> Array:
        R = Rotation.from_quat(y[3:7]).as_matrix()
        w, e = R @ y[7:], R[:, 1]  # in world coordinates
        J, de = R @ moments @ R.T, np.cross(w, e)
        down = (z @ e) * e - z
        size = np.linalg.norm(down)
        d_down = (z @ de) * e + (z @ e) * de
        rho = radius * down / size
        d_rho = radius * (d_down / size - down * (down @ d_down) / size**3)
        K = np.array([[0, -rho[2], rho[1]], [rho[2], 0, -rho[0]], [-rho[1], rho[0], 0]])
        moment = -np.cross(w, J @ w) - np.cross(rho, mass * np.cross(w, d_rho) + weight)
        dw = np.linalg.solve(J - mass * K @ K, moment)
        return np.concatenate([-np.cross(w, rho), quaternion_rate(y[3:7], y[7:]), R.T @ dw])

    y = solved(rates, np.array([0.2, 0.2, 0.3, 0, 0, 0, 1.0, 1, 5, 0]), times)
    R = Rotation.from_quat(y[3:7].T)
    return vectors({"free.r": y[:3], "free.Q": y[3:7], "free.w": y[7:]}) | {"R": R.as_matrix()}
