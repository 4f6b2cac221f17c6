# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives of outputs and states, by states and inputs and by time, against differences of plants
that are assembled independently, differences of tight runs, and closed forms.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import pytest
from fmu.plants import crank_rocker, gyroscope
from mechanisms import (
    GRAVITY,
    Scene,
    body,
    four_bar,
    frame,
    frame_sensor,
    joint,
    reaction,
    scene,
    with_sensors,
)

import gelenk
from gelenk.chart import mechanisms

from .differences import Array, Assembler, Linear, in_time, linearized, output_derivatives
from .modelica import fourbar1
from .rods import planar_four_bar, spatial_four_bar
from .running import assert_close

ENERGY = {"type": "energy"}


@dataclass(frozen=True)
class Case:
    make: Callable[[], Scene]
    times: tuple[float, ...] = (0.0, 0.3, 0.7)  # s
    inputs: Mapping[str, float] = field(default_factory=dict)
    step: float = 2e-3  # s, of the differences in time


def shipped(name: str) -> Callable[[], Scene]:
    return lambda: mechanisms.shipped(name)


def loaded_cut() -> Scene:
    """A four-bar whose coupler joint, which closes the loop, has a spring, a damper and a motor."""
    out = four_bar()
    out["joints"]["C"] |= {"stiffness": 20.0, "damping": 0.3, "spring_reference": 0.4}
    out["joints"]["A"]["damping"] = 0.0
    out["motors"] = {
        "drive": {"joint": "B", "gear_ratio": 3.0, "rotor_inertia": 0.02},
        "pull": {"joint": "C"},
    }
    return with_sensors(out, E=ENERGY, tip=frame_sensor("coupler", (0.3, 0.2, 0.1)))


def leaning() -> Scene:
    """A ball against a stop, held by a spring between two points."""
    return scene(
        {"ball": body(1.3)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("ball"),
                axis=[0, 0, 1],
                start={"s": -0.02, "v": 0.4, "fixed": True},
                stop={"lower": 0.0, "stiffness": 520.0, "damping": 3.0},
            )
        },
        gravity=[0, 0, -GRAVITY],
        forces={
            "tie": {
                "type": "spring_damper",
                "from": frame("ground", (0.3, 0, 0.5)),
                "to": frame("ball", (0.05, 0.1, 0)),
                "stiffness": 40.0,
                "damping": 0.8,
                "length": 0.4,
            }
        },
        sensors={"E": ENERGY, "R": reaction("J")},
    )


CASES = {
    "pendulum": Case(shipped("pendulum")),
    "cart-pole": Case(shipped("cart_pole"), inputs={"drive.f": 2.0}),
    "double pendulum": Case(shipped("double_pendulum")),
    "crank-rocker in space": Case(
        lambda: with_sensors(crank_rocker(), f=frame_sensor("coupler", (0.1, 0.2, 0))),
        inputs={"drive.tau": 3.0},
    ),
    "four-bar in its plane": Case(
        lambda: with_sensors(four_bar(), f=frame_sensor("coupler", (0.1, 0.2, 0)), E=ENERGY),
        inputs={"drive.tau": 3.0},
    ),
    "four-bar with a loaded cut": Case(loaded_cut, inputs={"drive.tau": 3.0, "pull.tau": -0.4}, step=1e-3),
    "five-bar": Case(shipped("five_bar")),
    "slider-crank": Case(shipped("slider_crank")),
    "free body": Case(shipped("free_body")),
    "heavy top": Case(shipped("heavy_top"), times=(0.0, 0.05, 0.1), step=5e-4),
    "gyroscope": Case(gyroscope, inputs={"push.f[1]": 0.7, "push.t[3]": -0.02}),
    "rod in a plane": Case(lambda: with_sensors(planar_four_bar(), f=frame_sensor("coupler"))),
    "rod in space": Case(
        lambda: with_sensors(spatial_four_bar(), f=frame_sensor("rod", (0.1, 0, 0.2))), step=1e-3
    ),
    "rod between balls": Case(lambda: spatial_four_bar("spherical"), step=1e-3),
    "spatial four-bar": Case(fourbar1),
    "Bricard's ring": Case(
        lambda: with_sensors(mechanisms.bricard(), P=frame_sensor("rod3"), R=reaction("J4"), E=ENERGY),
        step=8e-3,
    ),
    "Stewart platform": Case(shipped("stewart"), times=(0.0, 0.3)),
    "ball on its stop": Case(leaning, times=(0.0, 0.01), step=1e-3),
}


def started(case: Case, source: Scene, tolerance: float = 1e-11) -> gelenk.Simulation:
    plant = gelenk.Simulation(source)
    plant.initialize(tolerance=tolerance)
    for name, value in case.inputs.items():
        plant.set_input(name, value)
    return plant


def assert_relative(what: str, found: Array, expected: Array, bound: float) -> None:
    """Within `bound` of 1 and the size of each number."""
    error = np.abs(found - expected) / (1 + np.abs(expected))
    assert error.max(initial=0.0) < bound, f"{what}: {error.max():.2e} at {error.argmax()}"


# --- by states and inputs ---


@pytest.mark.parametrize("name", CASES)
def test_slopes_are_those_of_plants_set_beside(name: str) -> None:
    """1e-7 as promised; found: 7e-9 and better (differences of fourth order over 1 ms: h^4 f5 / 30)."""
    case = CASES[name]
    source = case.make()
    plant = started(case, source)
    inputs = [s.name for s in plant.inputs]
    for t in case.times:
        plant.step_to(t)
        found = linearized(plant)
        beside = Assembler(source, plant)
        assert_relative(f"values at {t} s", beside.outputs({}), plant.values(), 1e-9)
        for matrix, names in ((found.C, found.states), (found.D, inputs)):
            for k, known in enumerate(names):
                assert_relative(f"by {known} at {t} s", matrix[:, k], beside.column(known, 1e-3), 1e-7)


@pytest.mark.parametrize("name", CASES)
def test_rates_are_rows_of_the_outputs(name: str) -> None:
    """Speeds and accelerations are outputs; the rates of a quaternion are 1/2 Q (w, 0), moved likewise."""
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    _, derivatives = plant._core._states()
    values = plant.values()
    row = {name: k for k, name in enumerate(found.states)}
    for k, output in enumerate(derivatives):
        if output >= 0:
            assert np.array_equal(found.A[k], found.C[output])
            assert np.array_equal(found.B[k], found.D[output])
            assert found.xdot[k] == values[output]
            continue
        owner = found.states[k].partition(".")[0]
        turn = [row[f"{owner}.{x}[{i}]"] for x, n in (("Q", 4), ("w", 3)) for i in range(1, n + 1)]
        state = np.array([plant.output(found.states[i]) for i in turn])
        component = turn.index(k)
        assert found.xdot[k] == pytest.approx(quaternion_rate(state)[component], abs=1e-14)
        moved = found.C[[plant._output[found.states[i]] for i in turn]]  # what the seven do themselves
        for j in range(len(found.states)):
            step = 1e-20  # complex step: exact to rounding
            slope = quaternion_rate(state + 1j * step * moved[:, j]).imag[component] / step
            assert found.A[k, j] == pytest.approx(slope, abs=1e-13)
        assert not found.B[k].any()


def quaternion_rate(state: Array) -> Array:
    u, s, w = state[:3], state[3], state[4:]
    return 0.5 * np.array([*(s * w + np.cross(u, w)), -u @ w])


@pytest.mark.parametrize("name", ["gyroscope", "Stewart platform", "five-bar"])
def test_one_direction_is_a_combination_of_the_columns(name: str) -> None:
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    rng = np.random.default_rng(3)
    dx, du = rng.normal(size=len(found.states)), rng.normal(size=len(plant.inputs))
    outputs, rates = plant._core._slope_along(list(dx), list(du))
    assert_relative("outputs", outputs, found.C @ dx + found.D @ du, 1e-12)
    assert_relative("rates", rates, found.A @ dx + found.B @ du, 1e-12)


def test_a_quaternion_moves_as_if_it_were_normalised() -> None:
    """Along itself not at all, across itself by what was asked."""
    case = CASES["gyroscope"]
    plant = started(case, case.make())
    plant.step_to(0.4)
    found = linearized(plant)
    columns = [found.states.index(f"S.Q[{i}]") for i in (1, 2, 3, 4)]
    Q = np.array([plant.output(f"S.Q[{i}]") for i in (1, 2, 3, 4)])
    rows = [plant._output[f"S.Q[{i}]"] for i in (1, 2, 3, 4)]
    assert_relative("Q by Q", found.C[np.ix_(rows, columns)], np.eye(4) - np.outer(Q, Q), 1e-14)
    assert_relative("along Q", found.C[:, columns] @ Q, np.zeros(len(found.C)), 1e-12)


def test_reductions_change_no_slope() -> None:
    """Planar or spatial algebra, rows dropped or not: the crank stays the state."""
    source = with_sensors(four_bar(), f=frame_sensor("coupler", (0.1, 0.2, 0)), E=ENERGY)
    matrices = []  # agree to the rounding of other sums
    for on in (True, False):
        made = copy.deepcopy(source)
        made["solver"] = {"reductions": dict.fromkeys(("planar", "redundant_rows"), on)}
        plant = started(CASES["four-bar in its plane"], made)
        found = linearized(plant)
        assert found.states == ["A.phi", "A.w"]
        matrices.append((found.C, found.D, output_derivatives(plant)))
    for first, second in zip(*matrices, strict=True):
        assert_relative("with and without", first, second, 1e-11)


# --- closed forms ---


def test_pendulum_has_the_slopes_of_its_equation() -> None:
    """I phi'' = -m g l sin phi - d w + tau, about the pin."""
    m, length, inertia, d = 0.8, 0.3, 0.05, 0.2
    plant = gelenk.Simulation(
        scene(
            {"bob": body(m, (0, -length, 0), (inertia, 0, inertia))},
            {
                "A": joint(
                    "revolute",
                    frame("ground"),
                    frame("bob"),
                    axis=[0, 0, 1],
                    damping=d,
                    start={"phi": 0.9, "w": -1.3, "fixed": True},
                )
            },
            gravity=[0, -GRAVITY, 0],
            motors={"drive": {"joint": "A"}},
        )
    )
    plant.initialize()
    plant.set_input("drive.tau", 0.4)
    about_pin = inertia + m * length**2
    phi, w, a = plant.values()
    found = linearized(plant)
    stiffness = m * GRAVITY * length * math.cos(phi)
    assert_relative("A", found.A, np.array([[0, 1], [-stiffness / about_pin, -d / about_pin]]), 1e-14)
    assert_relative("B", found.B, np.array([[0], [1 / about_pin]]), 1e-14)
    udot, uddot = 1.7, -4.0
    jerk = (-stiffness * w - d * a + udot) / about_pin
    snap = (m * GRAVITY * length * math.sin(phi) * w**2 - stiffness * a - d * jerk + uddot) / about_pin
    assert_relative(
        "in time",
        output_derivatives(plant, [udot], [uddot]),
        np.array([[w, a, jerk], [a, jerk, snap]]),
        1e-14,
    )


def test_cart_pole_has_the_linearisation_of_the_textbook() -> None:
    """Upright, at rest: (M + m) s'' + m l phi'' = f - c s', m l s'' + (I + m l2) phi'' = m g l phi."""
    source = mechanisms.shipped("cart_pole")
    source["joints"]["hinge"]["start"]["phi"] = 0.0
    plant = gelenk.Simulation(source)
    plant.initialize()
    M, m, length, inertia, c, d = 1.0, 0.2, 0.3, 0.006, 0.1, 0.002
    mass = np.array([[M + m, m * length], [m * length, inertia + m * length**2]])
    by_q = np.linalg.solve(mass, np.diag([0, m * GRAVITY * length]))
    by_v = np.linalg.solve(mass, -np.diag([c, d]))
    found = linearized(plant)
    assert found.states == ["track.s", "hinge.phi", "track.v", "hinge.w"]
    assert_relative("A", found.A, np.block([[np.zeros((2, 2)), np.eye(2)], [by_q, by_v]]), 1e-13)
    assert_relative("B", found.B[:, 0], np.array([0, 0, *np.linalg.solve(mass, [1, 0])]), 1e-13)


def test_double_pendulum_has_the_slopes_of_lagranges_equations() -> None:
    """By complex step on the closed form, exact to rounding."""
    plant = gelenk.Simulation(mechanisms.shipped("double_pendulum"))
    plant.initialize(tolerance=1e-11)
    for t in (0.0, 0.4, 1.1):
        plant.step_to(t)
        found = linearized(plant)
        x = np.array([plant.output(name) for name in found.states])
        for k in range(4):
            moved = x + 1j * 1e-20 * np.eye(4)[k]
            expected = double_pendulum_accelerations(moved).imag / 1e-20
            assert_relative(f"by {found.states[k]}", found.A[2:, k], expected, 1e-12)


def double_pendulum_accelerations(x: Array) -> Array:
    """Of shoulder and elbow; angles from the horizontal, the elbow's against the upper rod."""
    m, l1, c, inertia = (1.0, 0.6), 0.7, (0.35, 0.25), (0.0408333333333333, 0.0125)
    a, b = x[0], x[0] + x[1]  # of the rods
    wa, wb = x[2], x[2] + x[3]
    cross = m[1] * l1 * c[1]
    mass = np.array(
        [
            [inertia[0] + m[0] * c[0] ** 2 + m[1] * l1**2, cross * np.cos(a - b)],
            [cross * np.cos(a - b), inertia[1] + m[1] * c[1] ** 2],
        ]
    )
    weight = GRAVITY * np.array([(m[0] * c[0] + m[1] * l1) * np.cos(a), m[1] * c[1] * np.cos(b)])
    turn = cross * np.sin(a - b) * np.array([wb**2, -(wa**2)])
    rods: Array = np.linalg.solve(mass, -turn - weight)
    return np.array([rods[0], rods[1] - rods[0]])


# --- by time ---


@pytest.mark.parametrize("name", CASES)
def test_time_derivatives_are_those_of_a_tight_run(name: str) -> None:
    """Differences of eighth order at tolerance 1e-13: rounding over h2 and h^8 f10 / 3150, 1e-6."""
    case = CASES[name]
    source = case.make()
    t = max(case.times[-1], 5 * case.step)
    plant = started(case, source, 1e-13)
    plant.step_to(t)
    found = output_derivatives(plant)

    def run_to(time: float) -> Array:
        other = started(case, source, 1e-13)
        other.step_to(time)
        return other.values()

    expected = in_time(run_to, t, case.step)
    assert_relative("first", found[0], expected[0], 1e-7)
    assert_relative("second", found[1], expected[1], 1e-6)


@pytest.mark.parametrize("name", CASES)
def test_first_time_derivatives_are_slopes_along_the_motion(name: str) -> None:
    """dy/dt = C xdot + D udot: two ways through the equations, with the same sums: 1e-10 of them."""
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    udot = np.linspace(-1, 2, len(plant.inputs))
    along = found.C @ found.xdot + found.D @ udot
    assert_relative("first", output_derivatives(plant, udot)[0], along, 1e-9)
    # The second is affine in u'', with the same slopes.
    uddot = np.linspace(3, -1, len(plant.inputs))
    second = [output_derivatives(plant, udot, x)[1] for x in (uddot, 0 * uddot)]
    assert_relative("second", second[0] - second[1], found.D @ uddot, 1e-9)


def test_symmetric_top_has_the_time_derivatives_of_its_precession() -> None:
    """Without torques w1' = -k w2, w2' = k w1, w3' = 0 with k = (C - A) w3 / A (Euler's equations)."""
    A, C = 0.03, 0.05
    plant = gelenk.Simulation(
        scene(
            {"top": body(1.0, (0, 0, 0), (A, A, C))},
            {"F": joint("free", frame("ground"), frame("top"), start={"w": [0.7, -0.3, 5.0]})},
        )
    )
    plant.initialize()
    plant.step_to(0.37)
    k = (C - A) / A * 5.0
    w = np.array([plant.output(f"F.w[{i}]") for i in (1, 2)])
    rows = [plant._output[f"F.{x}[{i}]"] for x in "wz" for i in (1, 2)]
    turned = np.array([-w[1], w[0]])
    first, second = output_derivatives(plant)
    assert_relative("w', z'", first[rows], np.array([*(k * turned), *(-(k**2) * w)]), 1e-12)
    assert_relative("w'', z''", second[rows], np.array([*(-(k**2) * w), *(-(k**3) * turned)]), 1e-12)


# --- singular positions, other states, and the run ---


def test_singular_position_is_told() -> None:
    """The flat parallelogram: its rows have lost rank, two branches meet."""
    plant = gelenk.Simulation(mechanisms.parallelogram(0.0, 1.0))
    plant.initialize()
    for ask in (plant._core._linearize, lambda: plant._core._output_derivatives([], [])):
        with pytest.raises(gelenk.UsageError, match="t = 0 s: a loop stands in a singular position"):
            ask()


def test_dead_centre_is_told_for_the_states_that_do_not_lead_over_it() -> None:
    """Crank and coupler in one line: the rocker stands for a moment, so its angle cannot tell theirs."""
    crank, coupler, rocker, ground = 0.5, 1.75, 1.5, 2.0
    reach = crank + coupler
    phi = math.acos((ground**2 + reach**2 - rocker**2) / (2 * ground * reach))
    plant = gelenk.Simulation(four_bar(phi))
    plant.initialize()
    assert_relative(
        "the crank leads over it", linearized(plant).C[plant._output["D.w"], 1:], np.zeros(1), 1e-7
    )
    plant._core._take_states([plant._output["D.phi"]])
    with pytest.raises(gelenk.UsageError, match=r"the states D\.phi do not determine the other coordinates"):
        plant._core._linearize()
    assert np.isfinite(output_derivatives(plant)).all()  # the motion goes on all the same
    plant.step_to(0.3)
    linearized(plant)


def test_other_states_give_the_inverse_slopes() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    plant.step_to(0.4)
    rows = [plant._output["A.phi"], plant._output["D.phi"]]
    by_crank = linearized(plant)
    plant._core._take_states([rows[1]])
    by_rocker = linearized(plant)
    assert by_rocker.states == ["D.phi", "D.w"]
    assert by_crank.C[rows[1], 0] * by_rocker.C[rows[0], 0] == pytest.approx(1, abs=1e-13)
    assert_relative("D", by_rocker.D, by_crank.D, 1e-13)
    # The chain rule: y by (D.phi, D.w) is y by (A.phi, A.w), times these by those.
    rows_A = [plant._output["A.phi"], plant._output["A.w"]]
    assert_relative("C", by_rocker.C, by_crank.C @ by_rocker.C[rows_A], 1e-11)


def test_a_joint_that_closes_the_loop_is_no_state() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    cut = next(j for j in "BC" if f"{j}.phi" not in tree_coordinates(plant))
    with pytest.raises(gelenk.UsageError, match=rf"{cut}\.phi is no state"):
        plant._core._take_states([plant._output[f"{cut}.phi"]])


def tree_coordinates(plant: gelenk.Simulation) -> list[str]:
    out = []
    for j in "ABCD":
        try:
            plant._core._take_states([plant._output[f"{j}.phi"]])
            out.append(f"{j}.phi")
        except gelenk.UsageError:
            continue
    return out


@pytest.mark.parametrize("integrator", ["auto", "erk", "ida", "cvode", "generalized-alpha"])
@pytest.mark.parametrize("formulation", ["projection", "independent", "baumgarte"])
def test_asking_changes_no_bit(integrator: str, formulation: str) -> None:
    runs = []
    for asked in (True, False):
        source = with_sensors(four_bar(), E=ENERGY)
        source["solver"] = {"integrator": integrator, "formulation": formulation}
        plant = started(CASES["four-bar in its plane"], source, 1e-8)
        rows = []
        for k in range(1, 31):
            plant.step_to(k * 0.02)
            if k % 3 == 0:
                plant.set_input("drive.tau", math.sin(k))
            if asked:
                linearized(plant)
                output_derivatives(plant)
            if k % 5 == 0:
                rows.append([*plant.values(), *plant.diagnostics.values()])
        runs.append(rows)
    assert runs[0] == runs[1]


def test_asking_near_singular_positions_changes_no_bit() -> None:
    """The parallelogram passes its change point, where the accelerations are carried on."""
    runs = []
    for asked in (True, False):
        plant = gelenk.Simulation(mechanisms.parallelogram(1.0, -3.0))
        plant.initialize(tolerance=1e-9)
        rows = []
        for k in range(1, 101):
            plant.step_to(k * 0.01)
            if asked:
                linearized(plant)
            rows.append(list(plant.values()))
        assert plant.diagnostic("solver.singular_positions") > 0
        runs.append(rows)
    assert runs[0] == runs[1]


def test_finite_numbers_come_out_everywhere() -> None:
    """Sizes: nothing moves, nothing is an input, nothing is an output of a joint."""
    still = scene(
        {"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))}, sensors={"E": ENERGY}
    )
    plant = gelenk.Simulation(still)
    plant.initialize()
    found: Linear = linearized(plant)
    assert found.states == []
    assert found.C.shape == (3, 0)
    assert not output_derivatives(plant).any()
    assert_close("energy", np.array([plant.output("E.kinetic")]), np.zeros(1), 1e-15, "it stands")
