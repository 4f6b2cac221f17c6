# SPDX-License-Identifier: BSD-3-Clause
"""Points that stay on surfaces given by expressions: beads, bowls and cams against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
G = 9.81
MASS = 2.0


def bead(
    surfaces: list[str], start: list[float], on: dict[str, Any] | None = None, **more: Any
) -> dict[str, Any]:
    """A small body that gravity pulls along -z, free but for one point on each surface."""
    out = scene(
        {"bead": body(MASS, com=(0, 0, 0), inertia=(1e-2, 1e-2, 1e-2))},
        {"F": joint("free", frame("ground"), frame("bead"), start={"r": start})},
        gravity=more.pop("gravity", [0, 0, -G]),
        solver=more.pop("solver", {}),
    )
    out["constraints"] = {
        f"c{k}": {"type": "point_on_surface", "body": "bead", "surface": surface} | ({"on": on} if on else {})
        for k, surface in enumerate(surfaces)
    }
    return out | more


def started(description: dict[str, Any], tolerance: float) -> gelenk.Simulation:
    simulation = gelenk.Simulation(description)
    simulation.initialize(0.0, tolerance)
    return simulation


def position(simulation: gelenk.Simulation) -> np.ndarray:
    return np.array([simulation.output(f"F.r[{i}]") for i in (1, 2, 3)])


def along_parabola(end: float) -> Any:
    """Of z = x^2/2 from rest at x = 1: x'' (1 + x^2) + x x'^2 + G x = 0."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -(y[0] * y[1] ** 2 + G * y[0]) / (1 + y[0] ** 2)]

    return solve_ivp(rates, [0, end], [1, 0], method="DOP853", rtol=1e-13, atol=1e-14, dense_output=True).sol


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        *((name, tolerance) for name in ADAPTIVE for tolerance in (1e-6, 1e-8)),
        ("erk", 1e-10),
        ("dirk", 1e-10),
    ],
)
def test_bead_on_a_parabola(integrator: str, tolerance: float) -> None:
    """Ten tolerances, and as much per second; on both surfaces to rounding; the normal force."""
    simulation = started(
        bead(["y", "z - 0.5*x^2"], [1, 0, 0.5], solver={"integrator": integrator}), tolerance
    )
    exact = along_parabola(3.0)
    for t in (0.3, 1.0, 2.2, 3.0):
        simulation.step_to(t)
        x, v = exact(t)
        r = position(simulation)
        assert r[0] == pytest.approx(x, abs=10 * tolerance * (1 + t))
        assert abs(r[1]) < 1e-14
        assert abs(r[2] - r[0] ** 2 / 2) < 1e-14
        force = MASS * (G + v**2) / math.sqrt(1 + x**2)
        assert simulation.output("c1.f") == pytest.approx(force, abs=1e3 * tolerance)
        assert simulation.output("c0.f") == pytest.approx(0, abs=1e-8)


def test_bead_on_a_helix() -> None:
    """Along a helix it falls with a constant acceleration; two surfaces make the curve."""
    simulation = started(bead(["x - cos(z/0.2)", "y - sin(z/0.2)"], [1, 0, 0]), 1e-10)
    for t in (0.5, 1.0, 3.0):
        simulation.step_to(t)
        z = -G * 0.2**2 / (1 + 0.2**2) * t * t / 2
        assert position(simulation) == pytest.approx([math.cos(z / 0.2), math.sin(z / 0.2), z], abs=1e-8)


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6, -1.0])
def test_conical_pendulum_whatever_the_scale_of_the_expression(factor: float) -> None:
    """On a sphere at a height h below its center with sqrt(G/h); the sign of f follows that of the factor."""
    h, radius = 0.6, 0.8
    speed = radius * math.sqrt(G / h)
    description = bead([f"{factor}*(x^2 + y^2 + z^2 - 1)"], [radius, 0, -h])
    description["joints"]["F"]["start"] |= {"v": [0, speed, 0], "fixed": ["r", "v"]}
    simulation = started(description, 1e-10)
    for t in (0.5, 2.0):
        simulation.step_to(t)
        angle = t * math.sqrt(G / h)
        assert position(simulation) == pytest.approx(
            [radius * math.cos(angle), radius * math.sin(angle), -h], abs=1e-8
        )
        # Toward the center, against the gradient.
        assert simulation.output("c0.f") == pytest.approx(-math.copysign(MASS * G / h, factor), abs=1e-6)


def test_turned_and_moved_in_space() -> None:
    """The bowl of a body that is anywhere, with gravity and start turned as it: the same motion."""
    R = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    p = np.array([0.7, -2.0, 1.3])
    surface = "z - 0.3*x^2 - 0.2*y^2 - 0.1*sin(3*x)*y"
    plain = started(bead([surface], [0.6, 0.4, 0.3]), 1e-10)
    on = {"body": "ground", "position": p.tolist(), "rotation": {"matrix": R.tolist()}}
    start = p + R @ position(plain)
    turned = started(bead([surface], start.tolist(), on, gravity=(R @ [0, 0, -G]).tolist()), 1e-10)
    for t in (0.4, 1.1):
        plain.step_to(t)
        turned.step_to(t)
        assert R.T @ (position(turned) - p) == pytest.approx(position(plain), abs=1e-8)
        assert turned.output("c0.f") == pytest.approx(plain.output("c0.f"), abs=1e-6)


def test_frequencies_of_a_bowl() -> None:
    """At the bottom of z = (a x^2 + b y^2)/2: sqrt(G a) and sqrt(G b)."""
    description = bead(["z - (2*x^2 + 5*y^2)/2"], [0, 0, 0])
    model = gelenk.linearize(description)
    found = np.sort(np.abs(np.linalg.eigvals(np.asarray(model.A)).imag))[-4:]
    assert found == pytest.approx(np.sqrt(G * np.array([2, 2, 5, 5])), rel=1e-12)


def test_linear_model_beside_the_bottom() -> None:
    """Away from rest: finite differences of accelerations along the curve, in a plane of a bowl."""
    description = bead(["y", "z - 0.5*x^2"], [1, 0, 0.5])
    description["joints"]["F"]["start"] |= {"v": [0.3, 0, 0.3], "fixed": ["r"]}
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(description, states=["F.r[1]", "F.v[1]"])
    x, v = 1.0, 0.3

    def acceleration(x: float, v: float) -> float:
        return -(x * v * v + G * x) / (1 + x * x)

    h = 1e-5
    by_x = (acceleration(x + h, v) - acceleration(x - h, v)) / (2 * h)
    by_v = (acceleration(x, v + h) - acceleration(x, v - h)) / (2 * h)
    assert np.asarray(model.A)[1] == pytest.approx([by_x, by_v], abs=1e-8)


@pytest.mark.parametrize("integrator", ["auto", "cvode", "generalized-alpha", "rk4"])
def test_knife_edge_follower_of_an_eccentric_cam(integrator: str) -> None:
    """A disc of radius R with eccentricity e, at 5 rad/s: s = e cos phi + sqrt(R^2 - e^2 sin^2 phi)."""
    e, radius, speed = 0.03, 0.1, 5.0
    description = scene(
        {"cam": body(1.0, com=(0, 0, 0), inertia=(0.1, 0.1, 0.1)), "follower": body(0.5, com=(0, 0, 0))},
        {
            "shaft": joint("revolute", frame("ground"), frame("cam"), axis=[0, 0, 1]),
            "lift": joint("prismatic", frame("ground"), frame("follower"), axis=[1, 0, 0], start={"s": 0.13}),
        },
        gravity=[0, 0, 0],
        solver={"integrator": integrator, "step": 1e-3},
        constraints={
            "drive": {"type": "motion", "joint": "shaft", "speed": speed},
            "edge": {
                "type": "point_on_surface", "body": "follower", "on": "cam",
                "surface": f"hypot(x - {e}, y) - {radius}",
            },
        },
    )  # fmt: skip
    simulation = started(description, 1e-9)
    for t in (0.2, 0.5, 1.3):
        simulation.step_to(t)
        phi = speed * t
        root = math.sqrt(radius**2 - e**2 * math.sin(phi) ** 2)
        assert simulation.output("lift.s") == pytest.approx(e * math.cos(phi) + root, abs=1e-11)
        rate = speed * (-e * math.sin(phi) - e**2 * math.sin(2 * phi) / (2 * root))
        assert simulation.output("lift.v") == pytest.approx(rate, abs=1e-9)
        # Virtual work: the drive moves the follower against its inertia.
        power = 0.5 * simulation.output("lift.a") * rate
        assert simulation.output("drive.tau") * speed == pytest.approx(power, abs=1e-7)


@pytest.mark.parametrize(
    ("surface", "start", "answer"),
    [
        ("abs(x)", [1, 0, 0], "which has kinks"),
        ("t*x", [1, 0, 0], "found 't'"),
        ("3", [0, 0, 0], "an expression that names x, y or z"),
        ("x^2 + y^2", [0, 0, 0], "whose gradient is 0"),
        ("sqrt(x - 5)", [0, 0, 0], "whose gradient is 0, or no number"),
        ("x^2 + y^2 + 1", [0.1, 0, 0], "c0"),
    ],
)
def test_what_is_no_surface_is_refused(surface: str, start: list[float], answer: str) -> None:
    with pytest.raises(gelenk.GelenkError, match=answer):
        started(bead([surface], start), 1e-6)


def test_start_values_are_closed_onto_the_surface() -> None:
    """The nearest point of a sphere, whose guess was inside."""
    simulation = started(bead(["x^2 + y^2 + z^2 - 4"], [1, 0.5, 0.5]), 1e-6)
    assert position(simulation) == pytest.approx(2 * np.array([1, 0.5, 0.5]) / math.sqrt(1.5), abs=1e-7)


def test_saved_and_restored_to_the_bit() -> None:
    one, two = (started(bead(["z - 0.3*x^2 - 0.2*y^4"], [0.6, 0.4, 0.3]), 1e-8) for _ in range(2))
    one.step_to(0.7)
    two.restore(one.save())
    for t in (0.9, 2.0):
        one.step_to(t)
        two.step_to(t)
        assert np.array_equal(position(one), position(two))
