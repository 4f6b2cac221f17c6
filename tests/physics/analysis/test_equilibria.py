# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria and trim, compared with closed forms and independent solutions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, rod, scene
from models import linear_plants as plants
from models.derivative_cases import CASES
from models.one_dof import Jet
from scipy.optimize import brentq, root

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import linear_model
from physics.analysis.test_linear_models import BARS, TOP_WEIGHT, reduced

ROUNDING = 1e-12  # Newton's method converges quadratically: only rounding remains, measured below 1e-13


def equilibrium(source: Scene, tmp_path: Path, **arguments: Any) -> gelenk.Equilibrium:
    """The equilibrium of the scene; its FMU must have the same, and linearization there must not warn."""
    found = gelenk.equilibrium(source, **arguments)
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    by_fmu = gelenk.equilibrium(fmu, **arguments)
    for values, others in ((found.values, by_fmu.values), (found.inputs, by_fmu.inputs)):
        assert list(values) == list(others)
        # Rounding as above; in the accelerations times the largest stiffness here, about 1e3 1/s2.
        assert [*values.values()] == pytest.approx([*others.values()], rel=1e-11, abs=1e-9)
    assert found.residual < 1e-9
    assert found.residual == max((abs(x) for x in linear_model(source, at=found.at).rates), default=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error", gelenk.OperatingPointWarning)
        gelenk.linearize(source, at=found.at)
        gelenk.linearize(fmu, at=found.at)
    return found


def assert_values(found: Mapping[str, float], expected: Mapping[str, float], bound: float = ROUNDING) -> None:
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=bound, abs=bound), name


def pendulum(angle: float) -> Scene:
    """A bob of 0.8 kg at 0.3 m; phi is measured from the hanging position."""
    return scene(
        {"bob": body(0.8, (0, -0.3, 0), (0.05, 0, 0.05))},
        {
            "A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1],
                       start={"phi": angle, "w": 2.0, "fixed": True})
        },
        gravity=[0, -GRAVITY, 0], motors={"drive": {"joint": "A"}},
    )  # fmt: skip


@pytest.mark.parametrize(("start", "up"), [(0.1, False), (2.9, True), (math.pi / 2, False), (-1.5, False)])
def test_pendulum_under_a_constant_torque(start: float, up: bool, tmp_path: Path) -> None:
    """At m g l sin phi = tau; from the horizontal, where the gradient of gravity vanishes, it falls."""
    tau = 1.1
    angle = math.asin(tau / (0.8 * GRAVITY * 0.3))
    found = equilibrium(pendulum(start), tmp_path, input_values={"drive.tau": tau})
    assert_values(found.values, {"A.phi": math.pi - angle if up else angle, "A.w": 0.0})
    assert found.inputs == {"drive.tau": tau}


def test_newton_iterations_converge_quadratically() -> None:
    """From a start 0.05 rad away in a few iterations; without `hold`, the plant's own search would run."""
    assert gelenk.equilibrium(mechanisms.shipped("cart_pole"), hold={"track.s": 0.0}).iterations <= 4


@pytest.mark.parametrize(("stiffness", "reference"), [(15.0, 1.0), (4.0, -2.0), (200.0, 2.5)])
def test_four_bar_with_a_torsion_spring(stiffness: float, reference: float, tmp_path: Path) -> None:
    """Virtual work along the crank angle by triangle geometry: the torques of gravity and spring cancel."""
    source = four_bar(1.1)
    source["joints"]["D"] |= {"stiffness": stiffness, "spring_reference": reference}
    found = equilibrium(source, tmp_path)
    phi = Jet(found.values["A.phi"], 1.0)
    psi = BARS.angles(phi)[1]
    gravity = reduced(BARS.geometry()(phi), 1)[2]
    assert abs(gravity) > 1  # N m: the spring carries a load
    assert abs(gravity - stiffness * (psi.x - reference) * psi.d) < 1e-10  # N m, as documented


# --- a chain ---


def chain(ends: tuple[float, float], angles: np.ndarray, length: float = 0.1) -> Scene:
    """Uniform rods at these absolute angles from the origin to a second pin, which closes the loop."""
    n = len(angles)
    about_z = {"axis": [0, 0, 1]}
    joints = {}
    for i in range(n):
        before = frame("ground") if i == 0 else frame(f"rod{i - 1}", (length, 0, 0))
        turn = float(angles[i] - (angles[i - 1] if i else 0))
        joints[f"J{i}"] = joint("revolute", before, frame(f"rod{i}"), **about_z, start={"phi": turn})
    joints["end"] = joint(
        "revolute", frame("ground", (*ends, 0)), frame(f"rod{n - 1}", (length, 0, 0)), **about_z,
        start={"phi": float(angles[-1])},
    )  # fmt: skip
    rods = {f"rod{i}": rod(0.3, length) for i in range(n)}
    return scene(rods, joints, gravity=[0, -GRAVITY, 0], name="Chain")


def arc(ends: tuple[float, float], n: int, length: float = 0.1) -> np.ndarray:
    """Absolute angles of rods that hang along a circular arc between the ends."""
    middle = np.arange(n) - (n - 1) / 2
    chord = math.hypot(*ends)
    turn = brentq(lambda k: length * abs(np.exp(1j * k * middle).sum()) - chord, 1e-6, 2 * math.pi / n)
    out: np.ndarray = math.atan2(ends[1], ends[0]) + turn * middle
    return out


def two_straight_lines(ends: tuple[float, float], n: int, length: float = 0.1) -> np.ndarray:
    lean = math.acos(math.hypot(*ends) / (n * length))
    return math.atan2(ends[1], ends[0]) + np.repeat([-lean, lean], n // 2)


def discrete_catenary(ends: tuple[float, float], n: int, length: float = 0.1) -> np.ndarray:
    """Absolute angles of the rods. The horizontal force is the same in all rods, and the vertical force
    increases by the weight of a rod from midpoint to midpoint: tan(angle) = c i + d, where c and d follow
    from the positions of the ends.
    """

    def closure_error(x: np.ndarray) -> np.ndarray:
        angle = np.arctan(x[0] * np.arange(n) + x[1])
        return length * np.array([np.cos(angle).sum(), np.sin(angle).sum()]) - ends

    solution = root(closure_error, [4 / n, -2.0], tol=1e-15)
    assert np.abs(closure_error(solution.x)).max() < 1e-14  # m
    out: np.ndarray = np.arctan(solution.x[0] * np.arange(n) + solution.x[1])
    return out


@pytest.mark.parametrize("shape", [arc, two_straight_lines])
@pytest.mark.parametrize("ends", [(2.0, 0.0), (2.0, 0.3), (2.9, 0.3), (1.0, -0.4)])
def test_chain_of_32_links_hangs_in_the_discrete_catenary(
    shape: Any, ends: tuple[float, float], tmp_path: Path
) -> None:
    found = equilibrium(chain(ends, shape(ends, 32)), tmp_path)
    angles = np.cumsum([found.values[f"J{i}.phi"] for i in range(32)])
    # 1e-9 is documented; measured below 1e-13.
    assert np.abs(angles - discrete_catenary(ends, 32)).max() < 1e-11


# --- trim ---


def test_cart_pole_upright(tmp_path: Path) -> None:
    """Found from the scene's 0.05 rad; on an inclined track, the force m g sin(slope) holds the cart."""
    source = mechanisms.shipped("cart_pole")
    upright = equilibrium(source, tmp_path)
    assert_values(upright.values, {"hinge.phi": 0.0, "track.s": 0.0})
    model = linear_model(source, at=upright.at)
    assert np.linalg.eigvals(model.A).real.max() == pytest.approx(5.24, abs=0.005)  # an unstable equilibrium
    slope = 0.2
    source["gravity"] = [-GRAVITY * math.sin(slope), 0, -GRAVITY * math.cos(slope)]
    held = equilibrium(source, tmp_path, hold={"track.s": 0.3}, solve_for=["drive.f"])
    # The pole is vertical: relative to the normal of the track it leans by the slope.
    assert_values(held.values, {"track.s": 0.3, "hinge.phi": slope})
    assert_values(held.inputs, {"drive.f": 1.2 * GRAVITY * math.sin(slope)})


@pytest.mark.parametrize("phi", [0.7, -1.2, 2.0])
def test_slider_crank_held_by_its_motor(phi: float, tmp_path: Path) -> None:
    """Virtual work: gear tau + s' gas = dV/dphi, V = 0.45 g sin phi; the piston slides horizontally."""
    gas = -40.0
    found = equilibrium(
        mechanisms.shipped("slider_crank"), tmp_path, hold={"main.phi": phi}, solve_for=["starter.tau"],
        input_values={"gas.f[1]": gas},
    )  # fmt: skip
    weight, slide = slider_crank_work(phi)
    assert found.values["main.phi"] == phi
    assert_values(found.inputs, {"starter.tau": (weight - slide * gas) / 5, "gas.f[1]": gas})


def slider_crank_work(phi: float) -> tuple[float, float]:
    """Virtual work per crank angle of the weight, and of a unit force on the piston."""
    r, length = 0.3, 0.9
    drop = math.sqrt(length**2 - (r * math.sin(phi)) ** 2)
    return 0.45 * GRAVITY * math.cos(phi), -r * math.sin(phi) - r**2 * math.sin(phi) * math.cos(phi) / drop


def test_redundant_inputs_are_found_with_the_smallest_norm(tmp_path: Path) -> None:
    """The point of the line a tau + b f = w that is closest to the origin."""
    s = 1.1  # m, position of the piston, which is held; the crank angle follows from the law of cosines
    phi = math.acos((0.3**2 + s**2 - 0.9**2) / (2 * 0.3 * s))
    found = equilibrium(
        mechanisms.shipped("slider_crank"), tmp_path, hold={"cylinder.s": s},
        solve_for=["starter.tau", "gas.f[1]"], input_values={"gas.f[1]": -40.0},
    )  # fmt: skip
    weight, slide = slider_crank_work(phi)
    least = weight / (5**2 + slide**2)
    assert_values(found.values, {"main.phi": phi})
    assert_values(found.inputs, {"starter.tau": 5 * least, "gas.f[1]": slide * least})


def five_bar_potential(left: complex, right: complex) -> complex:
    """Potential energy [J] of five_bar in a vertical plane; its tool by two circles, elbows outward."""
    elbows = [(side * 0.15 + 0.25 * np.cos(x), 0.25 * np.sin(x)) for side, x in ((-1, left), (1, right))]
    (xl, yl), (xr, yr) = elbows
    dx, dy = xr - xl, yr - yl
    half = dx * dx + dy * dy
    rise = np.sqrt(0.35**2 / half - 0.25)
    tool = (yl + yr) / 2 + rise * dx
    return complex(GRAVITY * (0.8 * (yl + yr) / 2 + 0.6 * ((yl + tool) / 2 + (yr + tool) / 2)))


@pytest.mark.parametrize("names", [("left.phi", "right.phi"), ("elbow_left.phi", "tool.phi")])
def test_five_bar_held_by_two_motors(names: tuple[str, str], tmp_path: Path) -> None:
    """50 tau = dV/dphi, exact to rounding by complex steps; any two joints may determine the pose."""
    source = mechanisms.shipped("five_bar")
    source["gravity"] = [0, -GRAVITY, 0]
    start = gelenk.equilibrium(
        source, hold={"left.phi": 2.0, "right.phi": 0.8}, solve_for=["motor_left.tau", "motor_right.tau"]
    )
    found = equilibrium(
        source, tmp_path, hold={name: start.values[name] for name in names},
        solve_for=["motor_right.tau", "motor_left.tau"],
    )  # fmt: skip
    assert_values(found.values, {"left.phi": 2.0, "right.phi": 0.8}, 1e-11)  # other joints: 10 ulp
    h = 1e-20
    assert_values(
        found.inputs,
        {
            "motor_left.tau": five_bar_potential(2.0 + 1j * h, 0.8).imag / h / 50,
            "motor_right.tau": five_bar_potential(2.0, 0.8 + 1j * h).imag / h / 50,
        },
        1e-11,
    )


def test_body_on_a_spherical_joint_under_a_torque(tmp_path: Path) -> None:
    """With quaternions: it tilts by asin(tau / m g l); its rotation about the vertical remains unchanged."""
    source = plants.top(3.0, upright=False)
    source["joints"]["S"]["start"]["Q"] = [0.1, -0.2, 0.0, math.sqrt(0.95)]
    tau = 0.3
    found = equilibrium(source, tmp_path, input_values={"push.t[1]": tau})
    x, y, z, w = (found.values[f"S.Q[{i}]"] for i in (1, 2, 3, 4))
    down = 1 - 2 * (x * x + y * y)  # cosine of the tilt
    assert down == pytest.approx(math.sqrt(1 - (tau / TOP_WEIGHT) ** 2), rel=1e-12)
    # The torque of gravity has no component along y: the body's y axis remains horizontal.
    assert 2 * (y * z + w * x) == pytest.approx(tau / TOP_WEIGHT, rel=1e-12)
    assert 2 * (x * z - w * y) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("turn", [0.2, -0.07])
def test_one_coordinate_of_a_planar_joint_is_held(turn: float, tmp_path: Path) -> None:
    """The coupler's absolute angle is held, as a coordinate of a planar joint that does not constrain it."""
    theta = BARS.angles(Jet(1.1, 1.0))[0].x + turn
    source = four_bar(1.1)
    source["joints"]["P"] = joint("planar", frame("ground"), frame("coupler"))
    found = equilibrium(source, tmp_path, hold={"P.phi": theta}, solve_for=["drive.tau"])
    assert found.values["P.phi"] == pytest.approx(theta, abs=ROUNDING)
    phi = Jet(found.values["A.phi"], 1.0)
    assert BARS.angles(phi)[0].x == pytest.approx(theta, abs=ROUNDING)
    assert found.inputs["drive.tau"] == pytest.approx(-reduced(BARS.geometry()(phi), 1)[2], rel=1e-11)


def test_unattainable_angle_to_hold_is_rejected() -> None:
    """The angle of the coupler is at least 0.5235 rad."""
    least = min(BARS.angles(Jet(x, 1.0))[0].x for x in np.linspace(0, 2 * math.pi, 400))
    source = four_bar(1.1)
    source["joints"]["P"] = joint("planar", frame("ground"), frame("coupler"))
    with pytest.raises(gelenk.EquilibriumError) as error:
        gelenk.equilibrium(source, hold={"P.phi": least - 0.01}, solve_for=["drive.tau"])
    assert str(error.value) == "P.phi: the mechanism cannot be brought to the pose to hold"


@warned.PRESSED
@pytest.mark.parametrize(
    "name",
    ["spatial four-bar", "crank-rocker in space", "Bricard's ring", "rod between balls", "ball on its stop"],
)
def test_spatial_mechanisms_have_an_equilibrium(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    equilibrium(case.make(), tmp_path, input_values=case.inputs)
