# SPDX-License-Identifier: BSD-3-Clause
"""Rotors of which one moment of inertia is given, about their axis, on carriers that move: a tensor J n nᵀ.

Such a rotor resists turns of its carrier about other axes by its gyroscopic torque only.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Array, Scene, body, frame, general_body, joint, matrix, placed, rotation, scene
from models.running import assert_close, run, started
from scipy.integrate import solve_ivp

import gelenk

pytestmark = warned.TIGHT

X, Y, Z = np.eye(3)
OBLIQUE = np.array([0.36, 0.48, 0.8])
INTEGRATORS = ("ida", "cvode", "erk", "dirk", "rk4", "generalized-alpha")
FIXED_STEPS = {"rk4": 1e-3, "generalized-alpha": 1e-3}  # s
REDUCTIONS = ("weld", "static", "cut_choice", "planar", "redundant_rows", "islands", "outputs", "massless")
TURN = rotation([1, 2, -0.5], 1.1)


def rotor(moment: float, axis: Array, across: float = 0.0) -> dict[str, Any]:
    """A body without mass: a moment [kg m2] about an axis, and one about all axes across it."""
    nn = np.outer(axis, axis)
    return general_body(0.0, np.zeros(3), moment * nn + across * (np.eye(3) - nn))


def bearing(
    axis: Array, speed: float | None = None, on: str = "carrier", of: str = "rotor"
) -> dict[str, Any]:
    start = {} if speed is None else {"start": {"phi": 0.0, "w": speed, "fixed": True}}
    return joint("revolute", frame(on), frame(of), axis=[float(x) for x in axis], **start)


def refused(source: Scene) -> str:
    with pytest.raises(gelenk.SceneError) as error:
        started(source)
    return str(error.value)


# A rotor that spins at a constant speed on a carrier turned at a prescribed rate ----------------------------

MOMENT, SPEED, RATE = 0.3, 40.0, 2.5  # kg m2, rad/s, rad/s
TORQUE = MOMENT * SPEED * RATE  # N m: 30


def turntable(axis: Array = X, about: Array = Z) -> Scene:
    """The carrier has no inertia at all; both axes are fixed in it and perpendicular."""
    return scene(
        {"carrier": body(0.0), "rotor": rotor(MOMENT, axis)},
        {"table": bearing(about, on="ground", of="carrier"), "spin": bearing(axis, SPEED)},
        constraints={"turn": {"type": "motion", "joint": "table", "law": f"{RATE}*t"}},
        sensors={"hold": {"type": "reaction", "joint": "spin"}, "meter": {"type": "energy"}},
    )


def assert_gyroscopic_torque(found: Any, axis: Array = X, about: Array = Z) -> None:
    """The rate of the angular momentum J w n is the rate of the table times it, in axes of the carrier."""
    expected = TORQUE * np.cross(about, axis)
    assert_close("torque", found.vector("hold.t"), expected, 1e-9 * TORQUE, "tolerance 1e-10")
    assert_close("force", found.vector("hold.f"), 0.0, 1e-9 * TORQUE, "no mass")
    assert_close("speed", found["spin.w"], SPEED, 1e-9 * SPEED, "no torque about the axis")
    assert_close("drive", found["turn.tau"], 0.0, 1e-9 * TORQUE, "the torque does no work")
    energy = MOMENT * SPEED**2 / 2
    assert_close("energy", found["meter.kinetic"], energy, 1e-9 * energy, "of the spin alone")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_gyroscopic_torque_is_moment_times_both_rates(integrator: str) -> None:
    step = FIXED_STEPS.get(integrator, 0.0)
    assert_gyroscopic_torque(run(turntable(), np.linspace(0, 2, 9), integrator=integrator, step=step))


@pytest.mark.parametrize("reduction", REDUCTIONS)
def test_gyroscopic_torque_without_a_reduction(reduction: str) -> None:
    assert_gyroscopic_torque(run(turntable(), np.linspace(0, 1, 3), reductions={reduction: False}))


def test_gyroscopic_torque_turned_in_space_and_about_an_oblique_axis() -> None:
    about = np.cross(OBLIQUE, X) / np.linalg.norm(np.cross(OBLIQUE, X))
    times = np.linspace(0, 2, 9)
    assert_gyroscopic_torque(run(turntable(OBLIQUE, about), times), OBLIQUE, about)
    assert_gyroscopic_torque(run(placed(turntable(), TURN, (1, -2, 3)), times))


def test_moment_across_the_axis_is_that_of_the_carrier() -> None:
    """The prescribed motion of a table that accelerates needs no torque: the rotor has no moment about it."""
    source = turntable()
    source["constraints"]["turn"]["law"] = f"{RATE}*t + 3*t^2"
    found = run(source, [0.0, 0.7])
    assert_close("drive", found["turn.tau"], 0.0, 1e-9 * TORQUE, "J n nᵀ has no moment about z")
    source["bodies"]["rotor"] = rotor(MOMENT, X, MOMENT / 2)
    found = run(source, [0.0, 0.7])
    assert_close(
        "drive", found["turn.tau"], 6 * MOMENT / 2, 1e-9 * TORQUE, "moment across times acceleration"
    )


# Free carriers ----------------------------------------------------------------------------------------------

CARRIER = np.diag([0.21, 0.34, 0.27]) + 0.02 * (np.ones((3, 3)) - np.eye(3))  # kg m2, about the joint
START: dict[str, Any] = {"w": [0.4, -0.7, 0.5], "fixed": True}


def gyroscope(across: float, axis: Array = OBLIQUE, moment: float = 0.4) -> Scene:
    """A rotor on a carrier that turns about a point, under its weight.

    across: moment of the rotor across its axis, which the carrier has in addition if the rotor has not.
    """
    nn = np.outer(axis, axis)
    carried = CARRIER + (moment / 2 - across) * (np.eye(3) - nn)
    com = np.array([0.02, -0.03, 0.05])
    weight = general_body(1.5, com, carried)
    return scene(
        {"carrier": weight, "rotor": rotor(moment, axis, across)},
        {
            "ball": joint("spherical", frame("ground"), frame("carrier"), start=START),
            "spin": bearing(axis, 25.0),
        },
        gravity=[0, 0, -9.81],
        motors={"drive": {"joint": "spin"}},
        sensors={"meter": {"type": "energy"}},
    )


@pytest.mark.parametrize("integrator", ["ida", "erk"])
def test_rotor_with_one_moment_moves_like_the_whole_one_whose_other_moments_its_carrier_has(
    integrator: str,
) -> None:
    """Moments across the axis are the same in both bodies, since a rotor is symmetric about its axis."""
    times = np.linspace(0, 3, 31)
    whole, one = (
        run(gyroscope(across), times, tolerance=1e-11, integrator=integrator, inputs={"drive.tau": 0.6})
        for across in (0.2, 0.0)
    )
    # 100 rtol of speeds up to 25 rad/s for erk; the errors of the many small steps of BDF add up to more
    bound = 3e-8 if integrator == "erk" else 1e-6
    for name in ("ball.w[1]", "ball.w[2]", "ball.w[3]", "ball.Q[1]", "spin.w", "spin.phi", "meter.total"):
        assert_close(name, one[name], whole[name], bound, "the same motion")


def test_motion_satisfies_the_equations_of_euler() -> None:
    """I w' + J n s' + w x (I w + J n s) = M and J (n.w' + s') = tau, by SciPy at 1e-12.

    I: moments of the carrier and of the rotor J n nᵀ about the point; s: speed of the rotor in the carrier.
    """
    J, tau, mass, com = 0.4, 0.6, 1.5, np.array([0.02, -0.03, 0.05])
    nn = np.outer(OBLIQUE, OBLIQUE)
    Ic = CARRIER + J / 2 * (np.eye(3) - nn) + mass * (com @ com * np.eye(3) - np.outer(com, com))
    M = np.zeros((4, 4))
    M[:3, :3], M[:3, 3], M[3, :3], M[3, 3] = Ic + J * nn, J * OBLIQUE, J * OBLIQUE, J

    def rates(_t: float, y: Array) -> Array:
        w, s, down = y[:3], y[3], y[4:7]  # down: direction of gravity in axes of the carrier
        L = Ic @ w + J * OBLIQUE * (OBLIQUE @ w + s)
        moment = mass * 9.81 * np.cross(com, down) - np.cross(w, L)
        return np.concatenate([np.linalg.solve(M, np.append(moment, tau)), np.cross(down, w)])

    times = np.linspace(0, 2, 21)
    y0 = [*START["w"], 25.0, 0, 0, -1]
    truth = solve_ivp(rates, (0, 2), y0, method="DOP853", rtol=1e-12, atol=1e-12, t_eval=times).y
    found = run(gyroscope(0.0), times, tolerance=1e-11, integrator="erk", inputs={"drive.tau": tau})
    assert_close("w", found.vector("ball.w"), truth[:3].T, 1e-8, "100 rtol of rates up to 10 rad/s")
    assert_close("s", found["spin.w"], truth[3], 3e-8, "100 rtol of 25 rad/s")


@pytest.mark.parametrize("reduction", REDUCTIONS)
def test_free_carrier_without_a_reduction(reduction: str) -> None:
    times = np.linspace(0, 0.5, 3)
    with_all = run(gyroscope(0.0), times, tolerance=1e-11)
    without = run(gyroscope(0.0), times, tolerance=1e-11, reductions={reduction: False})
    for name in ("ball.w[1]", "ball.w[2]", "spin.w"):
        assert_close(name, without[name], with_all[name], 1e-8, "1000 rtol")


def gyrostat() -> Scene:
    """A carrier without inertia of its own: three equal rotors about its axes, driven at constant speeds."""
    speeds = {"x": 3.0, "y": -2.0, "z": 6.0}  # rad/s
    rotors = {name: rotor(0.2, axis) for name, axis in zip("xyz", (X, Y, Z), strict=True)}
    return scene(
        {"carrier": body(0.0), **rotors},
        {
            "ball": joint("spherical", frame("ground"), frame("carrier"), start=START),
            **{f"J{name}": bearing(axis, of=name) for name, axis in zip("xyz", (X, Y, Z), strict=True)},
        },
        constraints={f"d{n}": {"type": "motion", "joint": f"J{n}", "speed": s} for n, s in speeds.items()},
    )


@pytest.mark.parametrize("integrator", ["ida", "erk"])
def test_carrier_whose_inertia_is_that_of_driven_rotors(integrator: str) -> None:
    """With J the same about all axes, J w' = -w x J (w + s): w turns about the vector s of the speeds of the
    rotors, at the rate |s|, in axes of the carrier.
    """
    s, w0 = np.array([3.0, -2.0, 6.0]), np.array(START["w"])
    times = np.linspace(0, 2, 21)
    found = run(gyrostat(), times, tolerance=1e-11, integrator=integrator)
    expected = [rotation(s, 7.0 * t) @ w0 for t in times]
    bound = 1e-9 if integrator == "erk" else 1e-7  # as above
    assert_close("w", found.vector("ball.w"), expected, bound, "100 rtol")


# Linear models ----------------------------------------------------------------------------------------------


def gimbals(across: float) -> Scene:
    """A rotor about z in two rings on springs: A about x and B about y, at right angles."""
    A, B, J, H = 0.5 - across, 0.8 - across, 0.1, 4.0  # kg m2, N m s
    spring = {"stiffness": 30.0, "start": {"phi": 0.0, "w": 0.0, "fixed": True}}
    return scene(
        {"outer": body(0.0), "inner": body(0.0, inertia=(A, B, A + B)), "rotor": rotor(J, Z, across)},
        {
            "a": joint("revolute", frame("ground"), frame("outer"), axis=[1, 0, 0], **spring),
            "b": joint("revolute", frame("outer"), frame("inner"), axis=[0, 1, 0], **spring),
            "spin": bearing(Z, H / J, on="inner"),
        },
        motors={"drive": {"joint": "a"}},
    )


@pytest.mark.parametrize("across", [0.0, 0.05])
def test_linear_model_has_the_frequencies_of_precession_and_nutation(across: float) -> None:
    """A a'' + H b' + k a = 0 and B b'' - H a' + k b = 0: the roots of (k - A r²)(k - B r²) = H² r²."""
    A, B, k, H = 0.5, 0.8, 30.0, 4.0
    model = gelenk.linear.linear_model(
        gelenk.load(gimbals(across)), states=["a.phi", "b.phi", "a.w", "b.w", "spin.w"]
    )
    squares = np.roots([A * B, -(k * (A + B) + H**2), k**2])
    found = np.sort(np.abs(np.linalg.eigvals(model.A).imag))[-4::2]
    assert_close("rates", found, np.sort(np.sqrt(squares)), 1e-11, "eigenvalues of five rows")
    i, j = model.states.index("a.w"), model.states.index("b.w")
    assert_close("gyroscopic", [model.A[i, j] * A, model.A[j, i] * B], [-H, H], 1e-12, "exact")


def test_linear_models_of_one_moment_and_of_the_whole_rotor_are_the_same() -> None:
    states = [
        "ball.theta[1]",
        "ball.theta[2]",
        "ball.theta[3]",
        "ball.w[1]",
        "ball.w[2]",
        "ball.w[3]",
        "spin.w",
    ]
    one, whole = (
        gelenk.linear.linear_model(gelenk.load(gyroscope(across)), states=states, outputs=["ball.w[1]"])
        for across in (0.0, 0.2)
    )
    size = np.abs(whole.A).max()
    assert_close("A", one.A, whole.A, 1e-12 * size, "round-off")
    assert_close("B", one.B, whole.B, 1e-12 * np.abs(whole.B).max(), "round-off")


# What is refused --------------------------------------------------------------------------------------------


def test_carrier_that_only_free_rotors_would_hold_is_refused() -> None:
    """Free rotors do not resist turns of their carrier about any axis: each may stand still in space."""
    source = gyrostat()
    del source["constraints"]
    assert "bodies.carrier: moves without inertia" in refused(source)
    source["bodies"]["carrier"] = body(0.0, inertia=(0.1, 0.1, 0.1))
    started(source)


@pytest.mark.parametrize("moment", np.random.default_rng(5).uniform(0.1, 2.0, 8))
def test_carrier_without_inertia_about_the_axis_of_its_rotor_is_refused_beyond_rounding(
    moment: float,
) -> None:
    """The rotor stands still while its carrier turns: J - J²/J is 0, or rounding that is no inertia."""
    coaxial = scene(
        {"carrier": body(0.0), "rotor": rotor(moment, OBLIQUE)},
        {"A": bearing(OBLIQUE, on="ground", of="carrier"), "B": bearing(OBLIQUE)},
    )
    assert "bodies.carrier: moves without inertia" in refused(coaxial)
    held = copy.deepcopy(coaxial)
    held["bodies"]["carrier"] = rotor(1e-9 * moment, OBLIQUE)
    started(held)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["spherical", "revolute"])
def test_three_rotors_about_any_axes_hold_their_carrier_only_if_they_are_driven(kind: str, seed: int) -> None:
    """Moments from 1e-3 to 1e3 kg m2 in one carrier, in turned frames: rounding neither holds nor refuses."""
    rng = np.random.default_rng(seed)
    axes = [n / np.linalg.norm(n) for n in rng.normal(size=(3, 3))]
    rotors = {f"r{i}": rotor(10 ** rng.uniform(-3, 3), n) for i, n in enumerate(axes)}
    hinge = {"axis": [float(x) for x in rng.normal(size=3)]} if kind == "revolute" else {}
    source = scene(
        {"carrier": body(0.0), **rotors},
        {"A": joint(kind, frame("ground", R=TURN), frame("carrier", (0.1, 0.2, 0.3)), **hinge)}
        | {f"J{i}": bearing(n, of=f"r{i}") for i, n in enumerate(axes)},
    )
    assert "bodies.carrier: moves without inertia" in refused(source)
    source["constraints"] = {f"d{i}": {"type": "motion", "joint": f"J{i}", "speed": 2.0} for i in range(3)}
    started(source).step_to(0.05)
    del source["constraints"]
    source["bodies"]["carrier"] = body(1e-3, (0.01, 0, 0.02), (1e-5, 1e-5, 1.5e-5))
    started(source).step_to(0.05)


def test_carrier_across_the_axis_is_refused_unless_it_is_driven() -> None:
    source = turntable()
    del source["constraints"]
    assert "bodies.carrier: moves without inertia" in refused(source)


@pytest.mark.parametrize("axis", [Z, OBLIQUE])
def test_one_moment_needs_a_bearing_about_its_axis(axis: Array) -> None:
    """No carrier supplies the other moments of a body on a ball joint, or on a hinge about another axis."""
    top = {"rotor": rotor(0.2, axis) | {"mass": 1.0, "com": [0, 0, 0.1]}}
    for held in (
        joint("spherical", frame("ground"), frame("rotor")),
        joint("revolute", frame("ground"), frame("rotor"), axis=[float(x) for x in axis + 1e-5 * X]),
        joint("universal", frame("ground"), frame("rotor"), axes=[[0, 0, 1], [1, 0, 0]]),
    ):
        message = refused(scene(top, {"A": held}))
        assert "no rigid body has such moments, and no joint lets the body rotate about its " in message
        assert message.endswith("z axis only" if axis is Z else "axis [0.36, 0.48, 0.8] only")


def test_what_a_body_carries_is_not_its_carrier() -> None:
    """A hand on a bearing about the axis of the moment does not hold the body that carries it."""
    source = scene(
        {"rotor": rotor(0.2, Z) | {"mass": 1.0, "com": [0, 0, 0.1]}, "hand": body(1.0, inertia=(1, 1, 1))},
        {"A": joint("spherical", frame("ground"), frame("rotor")), "B": bearing(Z, on="rotor", of="hand")},
    )
    assert "bodies.rotor.inertia: zz = 0.2 exceeds xx + yy = 0 kg m2" in refused(source)
    source["joints"]["A"] = joint("spherical", frame("ground"), frame("hand"))
    started(source)


def test_rotor_of_several_pieces_turns_about_the_bearing_of_one() -> None:
    """The moment is given of a piece that is welded to the shaft, in a frame of its own."""
    turned = frame("disc", R=TURN.T)
    source = turntable()
    source["bodies"]["rotor"] = body(0.0)
    source["bodies"]["disc"] = rotor(MOMENT, TURN.T @ X)
    source["joints"]["flange"] = joint("weld", frame("rotor"), {**turned, "rotation": matrix(TURN.T)})
    assert_gyroscopic_torque(run(source, [0.0, 0.5]))
