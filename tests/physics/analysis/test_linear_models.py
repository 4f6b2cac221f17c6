# SPDX-License-Identifier: BSD-3-Clause
"""Linear models, compared with closed forms to rounding."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, body, four_bar, frame, joint, scene
from models import linear_plants as plants
from models.derivative_cases import CASES, assert_relative
from models.linear_plants import hidden_modes, mass_matrix_model
from models.one_dof import Jet, Moving, cos, jet, sin, sqrt
from models.planar_loops import FourBar, uniform
from scipy.optimize import brentq

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import LinearModel, linear_model
from physics.derivatives.test_derivatives import double_pendulum_accelerations

BOUND = 1e-12  # 1e-9 is documented; the difference is only rounding, measured below 1e-13


def assert_model(found: LinearModel, A: Any, B: Any = None) -> None:
    assert_relative("A", found.A, np.asarray(A, float), BOUND)
    if B is not None:
        assert_relative("B", found.B, np.asarray(B, float), BOUND)


@pytest.mark.parametrize("angle", [0.0, math.pi, 0.7])
def test_pendulum(angle: float) -> None:
    """I phi'' = m g l sin phi - d w + tau, phi from the upward vertical; also away from an equilibrium."""
    m, length, moment, d = 0.8, 0.3, 0.05, 0.2
    source = scene(
        {"bob": body(m, (0, length, 0), (moment, 0, moment))},
        {
            "A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1], damping=d,
                       start={"phi": angle, "w": 0.0, "fixed": True})
        },
        gravity=[0, -GRAVITY, 0], motors={"drive": {"joint": "A"}},
    )  # fmt: skip
    about_pin = moment + m * length**2
    found = linear_model(source)
    assert found.states == ("A.phi", "A.w")
    stiffness = m * GRAVITY * length * math.cos(angle)
    assert_model(found, [[0, 1], [stiffness / about_pin, -d / about_pin]], [[0], [1 / about_pin]])
    assert not hidden_modes(found, "B")
    assert found.rates == pytest.approx([0, m * GRAVITY * length * math.sin(angle) / about_pin], abs=1e-13)


@pytest.mark.parametrize(("angle", "up"), [(0.0, 1), (math.pi, -1)])
def test_cart_pole(angle: float, up: int) -> None:
    M, m, length, moment, c, d = 1.0, 0.2, 0.3, 0.006, 0.1, 0.002
    found = linear_model(plants.still_cart_pole(angle))
    assert found.states == ("track.s", "hinge.phi", "track.v", "hinge.w")
    mass = np.array([[M + m, up * m * length], [up * m * length, moment + m * length**2]])
    K = np.diag([0, -up * m * GRAVITY * length])
    A, B = mass_matrix_model(mass, K, np.diag([c, d]), np.array([[1.0], [0.0]]))
    assert_model(found, A, B)
    assert not hidden_modes(found, "B")
    assert not hidden_modes(found, "C")


def test_hanging_double_pendulum_matches_lagrange_equations() -> None:
    """Lagrange's equations are differentiated by complex steps, exact to rounding."""
    found = linear_model(
        mechanisms.shipped("double_pendulum"), at={"shoulder.phi": -math.pi / 2, "elbow.phi": 0}
    )
    assert_model(found, double_pendulum_jacobian(np.array([-math.pi / 2, 0, 0, 0])))
    assert np.abs(found.rates).max() < 1e-12  # rounding of pi / 2, times g / l
    poles = np.linalg.eigvals(found.A)
    assert np.abs(poles.real).max() < 1e-9  # no damping: purely imaginary
    assert (np.abs(poles.imag) > 1).all()


def test_moving_double_pendulum_matches_lagrange_equations() -> None:
    found = linear_model(mechanisms.shipped("double_pendulum"), at=0.4)
    assert np.abs(found.x0[2:]).min() > 0.1  # rad/s: it moves
    assert_model(found, double_pendulum_jacobian(found.x0))


def double_pendulum_jacobian(x: np.ndarray) -> np.ndarray:
    columns = [double_pendulum_accelerations(x + 1j * 1e-20 * e).imag / 1e-20 for e in np.eye(4)]
    return np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), np.array(columns).T])


@pytest.mark.parametrize(("angle", "up"), [(0.0, 1), (math.pi, -1)])
def test_furuta_pendulum(angle: float, up: int) -> None:
    """(Ja + m R2) a'' -+ m R l p'' = tau - c a' and -+ m R l a'' + (J + m l2) p'' = +- m g l p - d p'."""
    found = linear_model(plants.furuta(angle))
    assert found.states == ("pillar.phi", "tip.phi", "pillar.w", "tip.w")
    coupling = -up * plants.MASS * plants.ARM * plants.LENGTH
    mass = np.array(
        [
            [plants.ARM_MOMENT + plants.MASS * plants.ARM**2, coupling],
            [coupling, plants.MOMENT + plants.MASS * plants.LENGTH**2],
        ]
    )
    K = np.diag([0, -up * plants.MASS * GRAVITY * plants.LENGTH])
    damping = np.diag([plants.ARM_DAMPING, plants.ROD_DAMPING])
    A, B = mass_matrix_model(mass, K, damping, np.array([[1.0], [0.0]]))
    assert_model(found, A, B)
    assert not hidden_modes(found, "B")
    assert not hidden_modes(found, "C")


# --- loops, reduced to one degree of freedom by their geometry: I(phi) phi'' + 1/2 I' w^2 = Q ---

BARS = FourBar(uniform(2, 0.5), uniform(2, 1.75), uniform(2, 1.5), 2.0)


def reduced(bodies: Any, gravity: int) -> tuple[float, float, float, float]:
    """I, dI/dphi, the generalized force of gravity and its derivative; `gravity` is the index of its axis."""
    inertia = inertia_gradient = force = stiffness = 0.0
    for moving in bodies:
        more, dmore = moving.reduced()
        inertia, inertia_gradient = inertia + more, inertia_gradient + dmore
        force -= moving.mass * GRAVITY * moving.com[gravity].d
        stiffness -= moving.mass * GRAVITY * moving.com[gravity].dd
    return inertia, inertia_gradient, force, stiffness


def four_bar_at_rest(phi: float, torque: float) -> np.ndarray:
    """A and B side by side. At rest phi'' = Q / I, so its derivative is (dQ - dI phi'') / I."""
    inertia, inertia_gradient, force, stiffness = reduced(BARS.geometry()(Jet(phi, 1.0)), 1)
    a = (force + torque) / inertia
    return np.array([[0, 1, 0], [(stiffness - inertia_gradient * a) / inertia, -0.1 / inertia, 1 / inertia]])


def test_crank_driven_four_bar_at_its_equilibrium() -> None:
    phi = brentq(lambda x: reduced(BARS.geometry()(Jet(x, 1.0)), 1)[2], -2.0, -0.5, xtol=1e-15, rtol=1e-15)
    found = linear_model(four_bar(phi))
    assert found.states == ("A.phi", "A.w")
    assert found.residual_rates == ""  # the equilibrium of the geometry is one of the mechanism
    assert_relative("A, B", np.hstack([found.A, found.B]), four_bar_at_rest(phi, 0.0), BOUND)
    assert (np.linalg.eigvals(found.A).real < 0).all()  # it hangs
    assert not hidden_modes(found, "B")
    assert not hidden_modes(found, "C")


@pytest.mark.parametrize(("phi", "torque"), [(1.1, 0.0), (2.7, 20.0), (5.0, -3.0)])
def test_four_bar_at_rest_away_from_equilibrium(phi: float, torque: float) -> None:
    found = linear_model(four_bar(phi), input_values={"drive.tau": torque})
    assert_relative("A, B", np.hstack([found.A, found.B]), four_bar_at_rest(phi, torque), BOUND)
    theta, psi = BARS.angles(Jet(phi, 1.0))
    for name, angle in (("B", theta.d - 1), ("C", psi.d - theta.d), ("D", psi.d)):
        row = found.C[found.outputs.index(f"{name}.phi")], found.C[found.outputs.index(f"{name}.w")]
        assert_relative(name, np.array(row), np.array([[angle, 0], [0, angle]]), BOUND)


def test_four_bar_with_the_rocker_angle_as_state() -> None:
    """With states psi, psi': A' = T A T^-1 + dT/dt T^-1, at rest, where T' = psi'' phi' = 0."""
    phi, torque = 1.1, 7.0
    found = linear_model(four_bar(phi), input_values={"drive.tau": torque}, states=["D.phi"])
    assert found.states == ("D.phi", "D.w")
    by_crank = four_bar_at_rest(phi, torque)
    inertia, _, force, _ = reduced(BARS.geometry()(Jet(phi, 1.0)), 1)
    psi = BARS.angles(Jet(phi, 1.0))[1]
    # psi'' = psi_phi phi'' + psi_phiphi phi'^2. Derivative by phi, at rest:
    # psi_phiphi phi'' + psi_phi dphi''/dphi.
    stiffness = psi.dd * (force + torque) / inertia / psi.d + by_crank[1, 0]
    assert_relative("A", found.A, np.array([[0, 1], [stiffness, by_crank[1, 1]]]), BOUND)
    assert_relative("B", found.B, np.array([[0], [psi.d * by_crank[1, 2]]]), BOUND)


@pytest.mark.parametrize("phi", [0.7, -1.2, 2.0])
def test_crank_driven_slider_crank(phi: float) -> None:
    """The shipped scene: a motor with a gear ratio of 5, gas force, dampers at crank and piston."""
    r, rod = 0.3, 0.9
    gear, rotor, damping, slide_damping = 5.0, 2e-4, 0.05, 2.0
    x = Jet(phi, 1.0)
    drop = sqrt(rod**2 - r * r * sin(x) * sin(x))  # from crank pin to piston, along the slide
    lean = jet(0)
    lean.x = -math.asin(r * math.sin(phi) / rod)
    lean.d = -r * math.cos(phi) / drop.x  # from sin(lean) = -r sin(phi) / rod
    lean.dd = r * math.sin(phi) / drop.x + r * math.cos(phi) * drop.d / drop.x**2
    s = r * cos(x) + drop
    zero = jet(0)
    bodies = [
        Moving(1.0, (0.15 * cos(x), 0.15 * sin(x), zero), x, 0.0075),
        Moving(2.0, (r * cos(x) + 0.5 * drop, 0.5 * r * sin(x), zero), lean, 0.135),
        Moving(1.5, (s, zero, zero), zero, 0.003),
    ]
    inertia, inertia_gradient, force, stiffness = reduced(bodies, 1)
    inertia += gear**2 * rotor
    torque, gas = 0.8, -40.0
    a = (force + gear * torque + s.d * gas) / inertia
    by_phi = (stiffness + s.dd * gas - inertia_gradient * a) / inertia
    by_w = -(damping + slide_damping * s.d**2) / inertia
    found = linear_model(
        mechanisms.shipped("slider_crank"), at={"main.phi": phi},
        input_values={"starter.tau": torque, "gas.f[1]": gas}, inputs=["starter.tau", "gas.f[1]"],
        outputs=["cylinder.s", "cylinder.v", "cylinder.a"],
    )  # fmt: skip
    assert found.states == ("main.phi", "main.w")
    assert_model(found, [[0, 1], [by_phi, by_w]], [[0, 0], [gear / inertia, s.d / inertia]])
    # The piston: s'' = s_phi phi'' + s_phiphi phi'^2.
    C = [[s.d, 0], [0, s.d], [s.dd * a + s.d * by_phi, s.d * by_w]]
    assert_relative("C", found.C, np.array(C), BOUND)
    assert_relative("D", found.D[2], s.d * np.array([gear, s.d]) / inertia, BOUND)
    assert not hidden_modes(found, "B")
    assert not hidden_modes(found, "C")


# --- quaternions ---


def top_slopes(spin: float, up: int) -> tuple[np.ndarray, np.ndarray]:
    """A and B of Euler's equations in body axes about the vertical position; inputs are three torques."""
    weight = up * TOP_WEIGHT / plants.ACROSS
    gyro = (1 - plants.ALONG / plants.ACROSS) * spin
    carried = np.array([[0, spin, 0], [-spin, 0, 0], [0, 0, 0]])  # -w x theta
    turning = np.array([[0, gyro, 0], [-gyro, 0, 0], [0, 0, 0]])
    A = np.block([[carried, np.eye(3)], [np.diag([weight, weight, 0]), turning]])
    inverse = np.diag([1 / plants.ACROSS, 1 / plants.ACROSS, 1 / plants.ALONG])
    return A, np.vstack([np.zeros((3, 3)), inverse])


TOP_WEIGHT = plants.TOP_MASS * GRAVITY * plants.TOP_REACH
TORQUES = ["push.t[1]", "push.t[2]", "push.t[3]"]
CRITICAL_SPIN = 2 * math.sqrt(TOP_WEIGHT * plants.ACROSS) / plants.ALONG  # rad/s, of a sleeping top


def test_body_on_a_spherical_joint_has_six_states() -> None:
    """Hanging: two pendulum motions and a free rotation about the vertical; the quaternion adds no state."""
    found = linear_model(plants.top(0.0, upright=False), inputs=TORQUES, outputs=["S.Q[1]", "S.w[1]"])
    assert found.states == (*(f"S.theta[{i}]" for i in (1, 2, 3)), *(f"S.w[{i}]" for i in (1, 2, 3)))
    assert found.residual_rates == ""
    assert_model(found, *top_slopes(0.0, -1))
    assert_relative("C", found.C, np.array([[0.5, 0, 0, 0, 0, 0], [0, 0, 0, 1, 0, 0]]), BOUND)
    assert not hidden_modes(found, "B")
    sideways = linear_model(plants.top(0.0, upright=False), inputs=TORQUES[:2])
    assert hidden_modes(sideways, "B") == [0, 0]  # hidden_modes() does find the rotation about z
    everything = linear_model(plants.top(0.0, upright=False))
    assert not hidden_modes(everything, "C")


@pytest.mark.parametrize("spin_ratio", [0.0, 0.98, 1.02, 3.0])
def test_sleeping_top(spin_ratio: float) -> None:
    """Its steady rotation is stable if w I3 > 2 sqrt(m g l I1) (Klein & Sommerfeld 1910), unstable below."""
    spin = spin_ratio * CRITICAL_SPIN
    found = linear_model(plants.top(spin), inputs=TORQUES)
    assert_model(found, *top_slopes(spin, 1))
    growth = np.linalg.eigvals(found.A).real.max()
    if spin_ratio > 1:
        assert growth < 1e-6 * spin  # marginal: square root of rounding, for the double eigenvalues 0
    else:
        assert growth > 1.0
    if spin:
        assert (
            found.residual_rates == f"t = 0 s is not an equilibrium: S.theta[3] changes at {spin:.6g} rad/s"
        )


def test_linear_model_does_not_depend_on_the_heading_of_the_body() -> None:
    """The states are rotations and velocities in body axes, so the quaternion has no influence."""
    expected = linear_model(plants.top(0.0, upright=False), inputs=TORQUES)
    Q = [0, 0, math.sin(0.4), math.cos(0.4)]  # about the vertical
    source = plants.top(0.0, upright=False)
    source["joints"]["S"]["start"]["Q"] = Q
    found = linear_model(source, inputs=TORQUES)
    assert_model(found, expected.A, expected.B)
    assert found.C[found.outputs.index("S.Q[3]"), 2] == pytest.approx(0.5 * math.cos(0.4), abs=1e-14)


def test_free_body_under_a_wrench() -> None:
    """Newton-Euler equations at rest: m r'' = f in world axes; I w' = R' t - w x I w in body axes."""
    m, moments = 2.0, np.array([0.3, 0.5, 0.4])
    source = scene(
        {"box": body(m, (0, 0, 0), moments)},
        {"F": joint("free", frame("ground"), frame("box"), start={"Q": [0.5, 0.5, 0.5, 0.5], "fixed": True})},
        forces={"push": {"type": "wrench", "body": "box", "input": True}},
    )
    found = linear_model(source)
    names = [f"F.{x}[{i}]" for x in ("r", "theta", "v", "w") for i in (1, 2, 3)]
    assert list(found.states) == names
    A = np.zeros((12, 12))
    A[:6, 6:] = np.eye(6)
    R = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])  # for this Q: 120 degrees about the diagonal
    B = np.zeros((12, 6))
    B[6:9, :3] = np.eye(3) / m
    B[9:, 3:] = R.T / moments[:, None]
    assert_model(found, A, B)
    assert not hidden_modes(found, "B")
    assert not hidden_modes(found, "C")


# --- in general ---


@warned.PRESSED
@pytest.mark.parametrize("name", CASES)
def test_models_of_scene_and_fmu_have_two_states_per_degree_of_freedom_and_agree(
    name: str, tmp_path: Path
) -> None:
    """The FMU is called through fmpy; both agree to rounding, 1e-12, at the start and after some steps."""
    case = CASES[name]
    source = case.make()
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    plant = gelenk.Simulation(source)
    plant.initialize()
    for at in (None, case.times[1] / 4):
        found = linear_model(source, at=at, input_values=case.inputs)
        by_fmu = linear_model(fmu, at=at, input_values=case.inputs)
        assert len(found.states) == 2 * plant.size.degrees_of_freedom
        for names in ("states", "inputs", "outputs", "units"):
            assert getattr(found, names) == getattr(by_fmu, names)
        for numbers in ("A", "B", "C", "D", "x0", "u0", "y0", "rates"):
            assert_relative(numbers, getattr(by_fmu, numbers), getattr(found, numbers), 1e-12)


@pytest.mark.parametrize("name", ["cart_pole", "five_bar", "stewart"])
def test_shipped_mechanisms_have_no_pole_zero_cancellation(name: str) -> None:
    """All modes of driven mechanisms are controllable and observable."""
    model = linear_model(mechanisms.shipped(name))
    assert not hidden_modes(model, "C")
    assert not hidden_modes(model, "B") if model.inputs else name == "stewart"


@pytest.mark.filterwarnings("ignore:Badly conditioned:scipy.signal.BadCoefficients")  # leading zeros
def test_minreal_keeps_the_order_of_the_transfer_function() -> None:
    """From the force of the motor to the position of the cart: four poles, two zeros."""
    linear = gelenk.linearize(plants.still_cart_pole(), outputs=["track.s"])
    transfer = control.tf(linear)
    assert len(control.minreal(transfer, tol=1e-6, verbose=False).poles()) == 4
    assert np.sort(transfer.poles().real) == pytest.approx(np.sort(linear.poles().real), abs=1e-6)


@pytest.mark.parametrize(("torque", "told"), [(0.9e-8, False), (1.1e-8, True), (1e-5, True)])
def test_residual_rates_of_the_size_of_rounding_count_as_equilibrium(torque: float, told: bool) -> None:
    """A hanging pendulum of 1 kg m2 with scales m, kg and s: above 1e-8 it is not at equilibrium."""
    hanging = body(1.0, (0, 0, -0.5), (0.75, 0.75, 0.1))
    pin = joint("revolute", frame("ground"), frame("bob"), axis=[0, 1, 0], damping=0.5)
    source = scene({"bob": hanging}, {"A": pin}, gravity=[0, 0, -GRAVITY])
    source["motors"] = {"drive": {"joint": "A"}}
    found = linear_model(source, input_values={"drive.tau": torque})
    assert found.rates == pytest.approx([0.0, torque], rel=1e-12)
    assert ("A.w changes" in found.residual_rates) == told
