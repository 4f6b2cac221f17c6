# SPDX-License-Identifier: BSD-3-Clause
"""More examples of the Modelica Standard Library: springs, gyroscopes, an engine, a rolling wheel.

Each is compared with an independent solution (modelica_truths), which also determines the accuracy of the
published curves, and with those curves: Dymola 2020x, DASSL, tolerance 1e-6 (GyroscopicEffects: 1e-9).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
import warned
from mechanisms import Array, Scene
from models import modelica, modelica_truths
from models.running import Recording, assert_close, run
from scipy.spatial.transform import Rotation

pytestmark = warned.TIGHT


def vector(theirs: str, ours: str) -> dict[str, str]:
    return {f"{theirs}[{i}]": f"{ours}[{i}]" for i in (1, 2, 3)}


@dataclass(frozen=True)
class Example:
    make: Callable[[], Scene]
    truth: Callable[[Array], dict[str, Array]]
    signals: dict[str, str]  # name in the curve: Gelenk's name
    stop: float  # s
    last: dict[str, float]  # the curve's last row, given here so that the test can run without the files
    bounds: dict[str, float]  # by Gelenk's joint or sensor and quantity: distance of the curve from the
    # reference, rounded up


EXAMPLES = {
    "Constraints.SphericalConstraint": Example(
        modelica.spherical_constraint,
        modelica_truths.spherical_constraint,
        vector("bodyOfConstraint.body.w_a", "ball.w"),
        10.0,
        {"ball.w[1]": 0.0, "ball.w[2]": -1.214240150, "ball.w[3]": -0.5029927000},
        {"ball.w": 1.4e-4},
    ),
    "Constraints.PrismaticConstraint": Example(
        modelica.prismatic_constraint,
        modelica_truths.prismatic_constraint,
        vector("bodyOfConstraint.r_0", "body_moves.r")
        | vector("bodyOfConstraint.v_0", "body_moves.v")
        | {f"jointPrismatic_{x}.{q}": f"{x}.{q}" for x in "xy" for q in "sv"},
        10.0,
        {
            "body_moves.r[1]": 0.2129541787,
            "body_moves.r[2]": -0.4357877154,
            "body_moves.r[3]": 0.1572710779,
            "x.v": -1.413201037,
            "y.v": -0.8521940955,
        },
        {"body_moves.r": 1.3e-5, "body_moves.v": 6e-5, "x.s": 1.2e-5, "y.s": 7e-6, "x.v": 5e-5, "y.v": 3e-5},
    ),
    "Elementary.SpringDamperSystem": Example(
        modelica.spring_damper_system,
        modelica_truths.spring_damper_system,
        vector("body1.frame_a.r_0", "free.r")
        | vector("body1.v_0", "free.v")
        | vector("body1.w_a", "free.w")
        | {"p2.s": "p2.s", "p2.v": "p2.v"},
        10.0,
        {
            "free.r[1]": 0.3005915201,
            "free.r[2]": -0.4269005793,
            "free.w[3]": -0.003013133562,
            "p2.s": 0.4936176194,
            "p2.v": -1.752568695,
        },
        {"free.r": 1e-6, "free.v": 6e-6, "free.w": 5e-6, "p2.s": 4e-5, "p2.v": 1.7e-4},
    ),
    "Loops.Engine1a": Example(
        modelica.engine1a,
        modelica_truths.engine1a,
        {"inertia.phi": "bearing.phi", "inertia.w": "bearing.w"},
        5.0,
        {"bearing.phi": 53.41519735, "bearing.w": 11.64035849},
        {"bearing.phi": 1.6e-4, "bearing.w": 2.2e-4},
    ),
    "Rotational3DEffects.GyroscopicEffects": Example(
        modelica.gyroscopic_effects,
        modelica_truths.gyroscopic_effects,
        vector("bodyCylinder2.body.w_a", "rotor.w")
        | vector("bodyCylinder3.body.w_a", "arm.w")
        | {"revolute.phi": "revolute.phi", "revolute.w": "revolute.w"},
        5.0,
        {
            "rotor.w[1]": 10.0,
            "rotor.w[2]": -6.629391430,
            "rotor.w[3]": 4.387947571,
            "arm.w[1]": 3.583794526,
            "arm.w[2]": -7.949303057,
            "arm.w[3]": -3.734452790,
            "revolute.phi": 50.86357343,
            "revolute.w": 4.825247835,
        },
        # The curve has the scene twice, and its two rotor angles differ by 1.3e-5 rad at the end.
        {"rotor.w": 1.1e-4, "arm.w": 7e-6, "revolute.phi": 1.3e-5, "revolute.w": 3e-5},
    ),
}


def bound(example: Example, name: str) -> float:
    return example.bounds[name.split("[")[0]]


@pytest.mark.parametrize("name", EXAMPLES)
def test_final_values_match_the_published_curve(name: str) -> None:
    example = EXAMPLES[name]
    found = run(example.make(), [0.0, example.stop], tolerance=1e-11)
    for signal, value in example.last.items():
        assert_close(signal, found[signal][-1], value, bound(example, signal), "Dymola")


@pytest.mark.parametrize("name", EXAMPLES)
def test_motion_matches_the_published_curve(name: str) -> None:
    """All rows if the files are available, otherwise selected rows."""
    example = EXAMPLES[name]
    curve = modelica.published(name)
    found = run(example.make(), curve["time"], tolerance=1e-11)
    for theirs, ours in example.signals.items():
        assert_close(ours, found[ours], curve[theirs], bound(example, ours), "Dymola")


@pytest.mark.parametrize("integrator", ["ida", "erk"])
@pytest.mark.parametrize("name", EXAMPLES)
def test_motion_matches_the_independent_solution(name: str, integrator: str) -> None:
    """1000 rtol of values up to 50 rad, 20 rad/s, for erk;
    the errors of BDF's many small steps accumulate to more.
    """
    example = EXAMPLES[name]
    times = np.linspace(0, example.stop, 101)
    found = run(example.make(), times, tolerance=1e-11, integrator=integrator)
    for signal, value in example.truth(times).items():
        assert_close(signal, found[signal], value, 1e-8 if integrator == "erk" else 1e-7, "rtol 1e-11")


def test_prismatic_joints_in_a_loop_and_as_constraints() -> None:
    """As in the Modelica example: with joints alone, and as constraints on a free body."""
    times = np.linspace(0, 10, 21)
    cut = modelica.prismatic_constraint()
    tree = modelica.prismatic_constraint()
    del tree["joints"]["body_moves"]
    a, b = (run(source, times, tolerance=1e-11) for source in (cut, tree))
    for signal in ("x.s", "y.s", "x.v", "y.v"):
        assert_close(signal, a[signal], b[signal], 1e-9, "two runs at 1e-11")


# Where three springs meet Modelica has a massless point; a point of mass m moves like it up to c m.
THREE = vector("body1.frame_a.r_0", "free.r") | vector("body1.v_0", "free.v") | vector("body1.w_a", "free.w")
THREE_LAST = {"free.r[1]": -0.01991224874, "free.r[2]": -0.8415323891, "free.r[3]": 0.2570034426}


def without_mass(times: Array) -> dict[str, Array]:
    """Extrapolates from two small masses to zero: errors proportional to the mass cancel."""

    def at(mass: float) -> Recording:
        source = modelica.three_springs(mass)
        start = modelica_truths.node_at_rest(np.array([0.5, -0.3, 0]), np.array([0.3, -0.15, 0.1]))
        source["joints"]["n"]["start"]["r"] = list(start)
        return run(source, times, tolerance=1e-9)

    heavy, light = at(2e-4), at(1e-4)
    return {name: 2 * light[name] - heavy[name] for name in THREE.values()}


@pytest.mark.thorough
def test_three_springs_match_modelica() -> None:
    """Elementary.ThreeSprings: the error of Dymola's curve is 1.1e-5 m, 5.3e-5 m/s, 1.1e-4 rad/s."""
    bounds = {"free.r": 1.2e-5, "free.v": 6e-5, "free.w": 1.1e-4}
    times = np.linspace(0, 10, 51)
    found = without_mass(times)
    for signal, value in modelica_truths.three_springs(times).items():
        assert_close(signal, found[signal], value, 1e-5, "of second order in the mass")
    for signal, last in THREE_LAST.items():
        assert_close(
            signal,
            found[signal][-1],
            last,
            bounds[signal[:6]] + 1e-5,
            "Dymola, and extrapolation to zero mass",
        )
    curve = modelica.published("Elementary.ThreeSprings")
    truth = modelica_truths.three_springs(curve["time"])
    for theirs, ours in THREE.items():
        assert_close(ours, truth[ours], curve[theirs], bounds[ours[:6]], "Dymola at 1e-6")


WHEEL_LAST = {"x": 0.1625467804, "y": -2.237784807, "angles": (0.6687549467, -0.9654649849, 2.091683139)}


def wheel_turn(angles: Array) -> Rotation:
    """Rotations about z, then the new y, then the new x."""
    return Rotation.from_euler("ZYX", angles)


def test_published_rolling_wheel_curve_satisfies_rolling() -> None:
    """Dymola's curve compared with the independent solution: rates of its angles reach 58 rad/s."""
    curve = modelica.published("Elementary.RollingWheel")
    truth = modelica_truths.rolling_wheel(curve["time"])
    turn = wheel_turn(np.array([curve[f"wheel1.angles[{i}]"] for i in (1, 2, 3)]).T)
    assert_close("x", curve["wheel1.x"], truth["free.r[1]"], 5e-4, "Dymola at 1e-6")
    assert_close("y", curve["wheel1.y"], truth["free.r[2]"], 7e-4, "Dymola at 1e-6")
    apart = (turn * Rotation.from_matrix(truth["R"]).inv()).magnitude()
    assert_close("turn", apart, 0, 1.2e-3, "Dymola at 1e-6")


def test_rolling_wheel_matches_independent_solution() -> None:
    """Elementary.RollingWheel, four seconds."""
    times = np.linspace(0, 4, 81)
    found = run(modelica.rolling_wheel(), times, tolerance=1e-11)
    truth = modelica_truths.rolling_wheel(times)
    for name in ("r", "w"):
        expected = np.array([truth[f"free.{name}[{i}]"] for i in (1, 2, 3)]).T
        assert_close(name, found.vector(f"free.{name}"), expected, 1e-7, "10^4 rtol")
    turn = Rotation.from_quat(found.vector("free.Q"))
    assert_close("turn", (turn * Rotation.from_matrix(truth["R"]).inv()).magnitude(), 0, 1e-7, "10^4 rtol")
    assert_close("x", found["free.r[1]"][-1], WHEEL_LAST["x"], 5e-4, "Dymola at 1e-6")
    assert_close("y", found["free.r[2]"][-1], WHEEL_LAST["y"], 7e-4, "Dymola at 1e-6")
    apart = (turn[-1] * wheel_turn(np.array(WHEEL_LAST["angles"])).inv()).magnitude()
    assert_close("turn", apart, 0, 1.2e-3, "Dymola at 1e-6")
