# SPDX-License-Identifier: BSD-3-Clause
"""Joint reactions: force and torque of a joint on its child body, at the joint frame M, resolved in F."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mechanisms import (
    GRAVITY,
    HINGE_AXES,
    body,
    cylinder,
    four_bar,
    frame,
    frame_sensor,
    joint,
    reaction,
    rotation,
    scene,
    with_sensors,
)
from models.running import Recording, assert_close, run
from scipy.spatial.transform import Rotation

Z = np.array([0, 0, 1.0])


def about_z(angle: np.ndarray) -> np.ndarray:
    R: np.ndarray = Rotation.from_rotvec(np.outer(angle, Z)).as_matrix()
    return R


def cross_z(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """(0, 0, w) x r for each time."""
    return np.stack([-w * r[:, 1], w * r[:, 0], 0 * w], axis=1)


@pytest.mark.parametrize("kind", ["revolute", "spherical", "universal", "cylindrical", "weld", "free"])
def test_joints_of_a_hanging_chain_carry_the_weight_below(kind: str) -> None:
    """At rest each joint carries the weight of all links below it (a free joint carries nothing,
    and its link falls). Three links along -z; each joint frame is rotated such that z of F is along the world
    y-axis.
    """
    axes = HINGE_AXES.get(kind, {})
    R = rotation([1, 0, 0], -math.pi / 2)
    masses = [1.3, 0.7, 2.1]
    names = ["a", "b", "c"]
    bodies = {n: body(m, (0, 0, -0.3), (0.1, 0.1, 0.02)) for n, m in zip(names, masses, strict=True)}
    joints = {}
    for i, name in enumerate(names):
        parent = frame("ground", (0, 0, 1), R) if i == 0 else frame(names[i - 1], (0, 0, -0.6), R)
        joints[f"J{name}"] = joint(kind, parent, frame(name, (0, 0, 0), R), **axes)
    sensors = {f"R{name}": reaction(f"J{name}") for name in names}
    found = run(scene(bodies, joints, gravity=[0, 0, -GRAVITY], sensors=sensors), [0.0, 0.5])
    for i, name in enumerate(names):
        weight = 0.0 if kind == "free" else sum(masses[i:]) * GRAVITY
        expected = R.T @ np.array([0, 0, weight])
        assert_close(
            f"R{name}.f", found.vector(f"R{name}.f"), np.tile(expected, (2, 1)), 1e-9, "at rest, 10 rtol"
        )
        assert_close(f"R{name}.t", found.vector(f"R{name}.t"), 0, 1e-9, "the weights hang below the joints")


def test_cantilever_reaction_is_weight_and_moment() -> None:
    """A weld holds a body with its center of mass 0.4 m out along x: force m g up, moment m g 0.4 about -y
    (world), about M, which is on the body at (0.1, 0, 0).
    """
    source = scene(
        {"beam": body(1.9, (0.5, 0.2, 0), (0.1, 0.1, 0.1))},
        {"W": joint("weld", frame("ground", (1, 2, 3)), frame("beam", (0.1, 0, 0)))},
        gravity=[0, 0, -GRAVITY],
        sensors={"R": reaction("W")},
    )
    found = run(source, [0.0, 0.1])
    f = np.array([0, 0, 1.9 * GRAVITY])
    assert_close("f", found.vector("R.f")[0], f, 1e-13, "round-off")
    assert_close("t", found.vector("R.t")[0], np.cross([0.4, 0.2, 0], f), 1e-13, "round-off")


def test_pendulum_pin_force_satisfies_newton_s_law() -> None:
    """F = m (a - g) at the center of mass, with the simulated phi, w, a (Newton's law); the pin
    transmits no torque about its axis.
    """
    m, c, J = 1.3, 0.37, 0.21
    source = scene(
        {"bob": body(m, (0, -c, 0), (0.3, 0.25, J))},
        {"P": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], start={"phi": 2.0})},
        gravity=[0, -GRAVITY, 0],
        sensors={"R": reaction("P")},
    )
    found = run(source, np.linspace(0, 2, 21), tolerance=1e-11)
    phi, w, a = found["P.phi"], found["P.w"], found["P.a"]
    r = c * np.stack([np.sin(phi), -np.cos(phi), 0 * phi], axis=1)
    expected = m * (cross_z(a, r) + cross_z(w, cross_z(w, r)) + [0, GRAVITY, 0])
    assert_close("f", found.vector("R.f"), expected, 1e-11, "round-off: the same state on both sides")
    assert_close("t", found.vector("R.t"), 0, 1e-12, "round-off")
    assert_close("a", a, -m * GRAVITY * c * np.sin(phi) / (J + m * c * c), 1e-12, "round-off")


def test_slider_on_an_incline_has_normal_force_and_moment() -> None:
    """On an incline of 0.6 rad without friction: s'' = g sin, normal force m g cos, and the moment due to the
    offset of the center of mass. x points down the incline, z is its normal.
    """
    m, slope = 2.3, 0.6
    R = rotation([0, 1, 0], slope)
    source = scene(
        {"b": body(m, (0.1, 0.05, 0.3), (0.1, 0.2, 0.3))},
        {"S": joint("prismatic", frame("ground", (0, 0, 0), R), frame("b"), axis=[1, 0, 0])},
        gravity=[0, 0, -GRAVITY],
        sensors={"R": reaction("S")},
    )
    found = run(source, np.linspace(0, 1, 5))
    assert_close("a", found["S.a"], GRAVITY * math.sin(slope), 1e-13, "round-off")
    f = np.array([0, 0, m * GRAVITY * math.cos(slope)])
    # no rotation: the moment about the center of mass vanishes, so t = c x f; c at M, axes of F
    assert_close("f", found.vector("R.f"), np.tile(f, (5, 1)), 1e-12, "round-off")
    assert_close("t", found.vector("R.t"), np.tile(np.cross([0.1, 0.05, 0.3], f), (5, 1)), 1e-12, "round-off")


@pytest.fixture(scope="module", params=[None, "A", "B", "C", "D"])
def four_bar_run(request: pytest.FixtureRequest) -> Recording:
    """The driven four-bar, cut by default or at the named joint (idle motors at the others)."""
    source = with_sensors(four_bar(torque=3.0), **{f"R{j}": reaction(j) for j in "ABCD"})
    if request.param:
        source["motors"] = {f"m{j}": {"joint": j} for j in "ABCD" if j != request.param}
    return run(source, np.linspace(0, 3, 31), tolerance=1e-11)


def test_newton_s_law_holds_for_every_bar(four_bar_run: Recording) -> None:
    """Newton and Euler: m a = sum of forces, J alpha = sum of moments about the center of mass, for crank,
    coupler and rocker, from angles, speeds, accelerations and the four reactions. Damping acts at A, the
    drive on the crank.
    """
    found = four_bar_run
    g = np.array([0, -GRAVITY, 0])
    angle = {"crank": found["A.phi"], "coupler": found["A.phi"] + found["B.phi"], "rocker": found["D.phi"]}
    w = {"crank": found["A.w"], "coupler": found["A.w"] + found["B.w"], "rocker": found["D.w"]}
    a = {"crank": found["A.a"], "coupler": found["A.a"] + found["B.a"], "rocker": found["D.a"]}
    length = {"crank": 0.5, "coupler": 1.75, "rocker": 1.5}
    F_of = {"A": None, "B": "crank", "C": "coupler", "D": None}  # the body to which F belongs
    f, t = {}, {}
    for j, holder in F_of.items():
        R = np.broadcast_to(np.eye(3), (len(found.time), 3, 3)) if holder is None else about_z(angle[holder])
        f[j] = np.einsum("tij,tj->ti", R, found.vector(f"R{j}.f"))
        t[j] = np.einsum("tij,tj->ti", R, found.vector(f"R{j}.t"))

    def acceleration(name: str, share: float) -> np.ndarray:
        """Of the point at that fraction of the bar's length, relative to its first end."""
        r = share * length[name] * np.stack([np.cos(angle[name]), np.sin(angle[name]), 0 * w[name]], axis=1)
        found_there: np.ndarray = cross_z(a[name], r) + cross_z(w[name], cross_z(w[name], r))
        return found_there

    at_start = {"crank": np.zeros(3), "coupler": acceleration("crank", 1.0), "rocker": np.zeros(3)}
    pulls = {
        "crank": [("A", 1, 0.0), ("B", -1, 1.0)],
        "coupler": [("B", 1, 0.0), ("C", -1, 1.0)],
        "rocker": [("D", 1, 0.0), ("C", 1, 1.0)],
    }
    for name, ends in pulls.items():
        m = 2 * length[name]
        total = m * g + sum(sign * f[j] for j, sign, _ in ends)
        assert_close(
            f"forces on the {name}",
            total,
            m * (at_start[name] + acceleration(name, 0.5)),
            1e-9,
            "closure 1e-12 in the accelerations x 100 N",
        )
        along = length[name] * np.stack([np.cos(angle[name]), np.sin(angle[name]), 0 * w[name]], axis=1)
        moment = sum(sign * (t[j] + np.cross((share - 0.5) * along, f[j])) for j, sign, share in ends)
        moment = moment + (3.0 * Z if name == "crank" else 0.0)
        assert_close(
            f"moments on the {name}",
            moment,
            np.outer(a[name], Z) * m * length[name] ** 2 / 12,
            1e-9,
            "as above; t[3] of A is the damper's torque",
        )


def test_weld_reaction_accelerates_the_outer_half() -> None:
    """A pendulum divided in two welded halves: the weld transmits the force and
    torque that accelerate the outer half.
    """
    m, phi0 = 0.8, 1.2
    outer = body(m, (0.2, 0.05, 0), (0.01, 0.02, 0.03))
    source = scene(
        {"inner": body(1.1, (0.25, 0, 0), (0.01, 0.05, 0.06)), "outer": outer},
        {
            "P": joint("revolute", frame("ground"), frame("inner"), axis=[0, 0, 1], start={"phi": phi0}),
            "W": joint("weld", frame("inner", (0.5, 0, 0)), frame("outer")),
        },
        gravity=[0, -GRAVITY, 0],
        sensors={"R": reaction("W"), "c": frame_sensor("outer", (0.2, 0.05, 0))},
    )
    found = run(source, np.linspace(0, 1, 11), tolerance=1e-11)
    phi, w, a = found["P.phi"], found["P.w"], found["P.a"]
    R = about_z(phi)
    r = found.vector("c.r")
    f_world = m * (cross_z(a, r) + cross_z(w, cross_z(w, r)) + [0, GRAVITY, 0])
    arm = np.einsum("tij,j->ti", R, [0.2, 0.05, 0])
    t_world = np.outer(0.03 * a, Z) + np.cross(arm, f_world)
    assert_close("f", np.einsum("tij,tj->ti", R, found.vector("R.f")), f_world, 1e-11, "round-off")
    assert_close("t", np.einsum("tij,tj->ti", R, found.vector("R.t")), t_world, 1e-11, "round-off")


def test_bearing_reaction_of_an_unbalanced_rotor() -> None:
    """An oblique cylinder rotating steadily about z: the bearing carries m w x (w x c) and w x J w
    (Euler's equation without acceleration).
    """
    W, part = 7.0, cylinder((0.2, 0.1, 0.4), 0.05)
    J = np.array(part["inertia"])
    J = np.array([[J[0], J[3], J[4]], [J[3], J[1], J[5]], [J[4], J[5], J[2]]])
    c, m = np.array(part["com"]), part["mass"]
    source = scene(
        {"rotor": part},
        {"B": joint("revolute", frame("ground"), frame("rotor"), axis=[0, 0, 1], start={"w": W})},
        sensors={"R": reaction("B")},
    )
    found = run(source, [0.0, 0.3, 0.7], tolerance=1e-11)
    w = W * Z
    f = m * np.cross(w, np.cross(w, c))
    t = np.cross(w, J @ w) + np.cross(c, f)
    R = about_z(found["B.phi"])
    assert_close("f", found.vector("R.f"), R @ f, 1e-8, "round-off of 500 N; w to 1e-11")
    assert_close("t", found.vector("R.t"), R @ t, 1e-8, "as above")
