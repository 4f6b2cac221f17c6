# SPDX-License-Identifier: BSD-3-Clause
"""Sensors of motion: accelerations by differences, moving observers, Euler angles."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from scipy.spatial.transform import Rotation

import gelenk

SEQUENCES = ["xyz", "yzx", "zxy", "xzy", "zyx", "yxz", "xyx", "yzy", "zxz", "xzx", "zyz", "yxy"]
R_TIP = Rotation.from_rotvec([0.4, -0.2, 0.9])
G = np.array([1.0, -2.0, -9.0])


def tumbling(**more: Any) -> dict[str, Any]:
    """A body on a ball joint that carries another one on a hinge, with frames off their origins."""
    return scene(
        {
            "one": body(1.3, (0.2, 0.1, -0.1), (0.05, 0.08, 0.06)),
            "two": body(0.7, (-0.1, 0.3, 0.2), (0.03, 0.02, 0.04)),
        },
        {
            "ball": joint("spherical", frame("ground"), frame("one"), start={"w": [1.0, -2.0, 1.5]}),
            "hinge": joint(
                "revolute", frame("one", (0.5, 0, 0.1)), frame("two"), axis=[0, 0.6, 0.8], start={"w": 3.0}
            ),
        },
        gravity=G.tolist(),
        solver={"integrator": "erk"},
    ) | {
        "sensors": {
            "tip": {
                "type": "frame", "body": "two", "position": [0.2, -0.3, 0.1],
                "rotation": {"matrix": R_TIP.as_matrix().tolist()},
            },
            "imu": {
                "type": "imu", "body": "two", "position": [0.2, -0.3, 0.1],
                "rotation": {"matrix": R_TIP.as_matrix().tolist()},
            },
            "base": {"type": "frame", "body": "one", "position": [-0.1, 0.2, 0.4]},
            "seen": {
                "type": "relative", "body": "two", "position": [0.2, -0.3, 0.1],
                "rotation": {"matrix": R_TIP.as_matrix().tolist()},
                "to": {"body": "one", "position": [-0.1, 0.2, 0.4]},
            },
        }
        | more
    }  # fmt: skip


def vector(simulation: gelenk.Simulation, name: str, size: int = 3) -> np.ndarray:
    return np.array([simulation.output(f"{name}[{i}]") for i in range(1, size + 1)])


def rotation(simulation: gelenk.Simulation, name: str) -> Rotation:
    return Rotation.from_quat(vector(simulation, f"{name}.Q", 4))


def at_times(
    times: list[float], description: dict[str, Any], names: dict[str, int]
) -> list[dict[str, np.ndarray]]:
    simulation = gelenk.Simulation(description)
    simulation.initialize(0.0, 1e-12)
    out = []
    for t in times:
        simulation.step_to(t)
        out.append({name: vector(simulation, name, size) for name, size in names.items()})
    return out


def rate(rows: list[dict[str, np.ndarray]], name: str, h: float) -> np.ndarray:
    """At the middle of five times, by the difference of fourth order."""
    x = [row[name] for row in rows]
    return np.asarray((x[0] - 8 * x[1] + 8 * x[3] - x[4]) / (12 * h))


NAMES = {
    "tip.v": 3, "tip.w": 3, "tip.Q": 4, "imu.a": 3, "imu.specific_force": 3, "imu.w": 3, "imu.alpha": 3,
    "seen.r": 3, "seen.v": 3, "seen.w": 3, "seen.a": 3, "seen.alpha": 3, "seen.Q": 4,
    "tip.r": 3, "base.r": 3, "base.Q": 4, "base.w": 3,
}  # fmt: skip


def test_accelerations_are_the_rates_of_velocities() -> None:
    """Each by differences over 2 ms; the specific force is the acceleration less gravity."""
    h = 1e-3
    rows = at_times([0.5 + k * h for k in (-2, -1, 0, 1, 2)], tumbling(), NAMES)
    now = rows[2]
    R = Rotation.from_quat(now["tip.Q"])
    near = 1e-7  # fourth order: h^4 of derivatives of up to 1e4, and rounding of 1e-12/h
    assert R.apply(now["imu.a"]) == pytest.approx(rate(rows, "tip.v", h), abs=near)
    assert now["imu.specific_force"] == pytest.approx(now["imu.a"] - R.inv().apply(G), abs=1e-12)
    assert now["imu.w"] == pytest.approx(now["tip.w"], abs=1e-13)
    assert now["imu.alpha"] == pytest.approx(rate(rows, "imu.w", h), abs=near)
    assert now["seen.v"] == pytest.approx(rate(rows, "seen.r", h), abs=near)
    assert now["seen.a"] == pytest.approx(rate(rows, "seen.v", h), abs=near)
    assert now["seen.alpha"] == pytest.approx(rate(rows, "seen.w", h), abs=near)


def test_relative_frame_is_that_of_two_frames() -> None:
    (now,) = at_times([0.7], tumbling(), NAMES)
    observer, seen = Rotation.from_quat(now["base.Q"]), Rotation.from_quat(now["tip.Q"])
    assert now["seen.r"] == pytest.approx(observer.inv().apply(now["tip.r"] - now["base.r"]), abs=1e-13)
    assert (observer.inv() * seen * Rotation.from_quat(now["seen.Q"]).inv()).magnitude() < 1e-13
    w = observer.inv().apply(seen.apply(now["tip.w"])) - now["base.w"]
    assert now["seen.w"] == pytest.approx(w, abs=1e-12)


def test_accelerometers_at_rest_and_in_free_fall() -> None:
    """On the ground upward by g; in free fall 0 at the center of mass, and w x (w x r) beside it."""
    out = scene(
        {"falling": body(1.0, (0, 0, 0), (0.1, 0.1, 0.1)), "still": body(1.0)},
        {
            "F": joint("free", frame("ground"), frame("falling"), start={"w": [0, 0, 5.0]}),
            "S": joint("prismatic", frame("ground"), frame("still"), axis=[1, 0, 0]),
        },
        gravity=[0, 0, -9.81],
    )
    out["sensors"] = {
        "on_ground": {"type": "imu", "body": "ground", "rotation": {"axis": [1, 0, 0], "angle": math.pi / 2}},
        "on_slide": {"type": "imu", "body": "still"},
        "center": {"type": "imu", "body": "falling"},
        "beside": {"type": "imu", "body": "falling", "position": [0.2, 0, 0]},
    }
    simulation = gelenk.Simulation(out)
    simulation.initialize(0.0, 1e-9)
    simulation.step_to(0.3)
    assert vector(simulation, "on_ground.specific_force") == pytest.approx([0, 9.81, 0], abs=1e-14)
    assert vector(simulation, "on_slide.specific_force") == pytest.approx([0, 0, 9.81], abs=1e-14)
    assert vector(simulation, "center.specific_force") == pytest.approx([0, 0, 0], abs=1e-12)
    assert vector(simulation, "center.a") == pytest.approx([0, 0, -9.81], abs=1e-12)
    assert vector(simulation, "beside.specific_force") == pytest.approx([-0.2 * 25, 0, 0], abs=1e-9)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_in_all_sequences(sequence: str) -> None:
    """Fixed frames in 40 orientations, half and quarter turns among them, against the rotations."""
    rng = np.random.default_rng(3)
    special = [Rotation.from_euler("XYZ", turns, degrees=True) for turns in product((0, 90, 180), repeat=3)]
    for number, R in enumerate([*special, *(Rotation.random(random_state=rng) for _ in range(13))]):
        base = Rotation.random(random_state=rng)
        turned = base * R
        out = scene({"b": body(1.0)}, {"S": joint("prismatic", frame("ground"), frame("b"), axis=[1, 0, 0])})
        out["sensors"] = {
            "e": {
                "type": "euler_angles", "sequence": sequence, "body": "b",
                "rotation": {"matrix": turned.as_matrix().tolist()},
                "to": {"body": "ground", "rotation": {"matrix": base.as_matrix().tolist()}},
            }
        }  # fmt: skip
        simulation = gelenk.Simulation(out)
        simulation.initialize()
        found = vector(simulation, "e.angle")
        assert (Rotation.from_euler(sequence.upper(), found) * R.inv()).magnitude() < 1e-7, number
        if number >= len(special):
            exact = R.as_euler(sequence.upper())
            assert found == pytest.approx(exact, abs=1e-12)


def test_expressions_name_angles_and_relative_motion() -> None:
    """A spring on an Euler angle is that of the hinge; accelerations cannot be named."""
    out = scene(
        {"b": body(1.0, (0.1, 0, 0), (0.1, 0.1, 0.1))},
        {
            "H": joint(
                "revolute", frame("ground"), frame("b"), axis=[0, 0, 1], start={"phi": 0.4},
                law={"effort": "-5*e.angle[3] - 0.2*rel.w[3]"},
            )
        },
        gravity=[0, 0, 0],
    )  # fmt: skip
    out["sensors"] = {
        "e": {"type": "euler_angles", "body": "b"},
        "rel": {"type": "relative", "body": "b", "to": "ground"},
    }
    plain = scene(
        {"b": body(1.0, (0.1, 0, 0), (0.1, 0.1, 0.1))},
        {
            "H": joint(
                "revolute", frame("ground"), frame("b"), axis=[0, 0, 1], start={"phi": 0.4},
                stiffness=5.0, damping=0.2,
            )
        },
        gravity=[0, 0, 0],
    )  # fmt: skip
    one, two = gelenk.Simulation(out), gelenk.Simulation(plain)
    for simulation in (one, two):
        simulation.initialize(0.0, 1e-10)
        simulation.step_to(1.5)
    assert one.output("H.phi") == pytest.approx(two.output("H.phi"), abs=1e-9)
    out["joints"]["H"]["law"]["effort"] = "rel.a[1]"
    with pytest.raises(gelenk.SceneError, match="accelerations and forces can be named only"):
        gelenk.load(out)


def test_linear_models_have_accelerations_of_frames() -> None:
    """C and D of a hanging pendulum with a torque, by closed form."""
    out = scene(
        {"b": body(2.0, (0, 0, -0.5), (0.01, 0.01, 0.01))},
        {"H": joint("revolute", frame("ground"), frame("b"), axis=[0, -1, 0])},
        gravity=[0, 0, -9.81],
    )
    out["motors"] = {"drive": {"joint": "H"}}
    out["sensors"] = {"imu": {"type": "imu", "body": "b", "position": [0, 0, -0.8]}}
    model = gelenk.linearize(out, outputs=["imu.a[1]", "imu.alpha[2]", "imu.specific_force[1]"])
    inertia = 0.01 + 2 * 0.25
    by_phi = -2 * 9.81 * 0.5 / inertia
    assert np.asarray(model.C)[:, 0] == pytest.approx([0.8 * by_phi, -by_phi, 0.8 * by_phi + 9.81], abs=1e-12)
    assert np.asarray(model.D)[:, 0] == pytest.approx([0.8 / inertia, -1 / inertia, 0.8 / inertia], abs=1e-12)


def test_no_specific_force_in_a_gravity_field() -> None:
    out = scene({"b": body(1.0)}, {"F": joint("free", frame("ground"), frame("b"), start={"r": [7e6, 0, 0]})})
    out |= {"gravity": {"mu": 4e14, "center": [0, 0, 0]}, "sensors": {"imu": {"type": "imu", "body": "b"}}}
    with pytest.raises(gelenk.SceneError, match="uniform gravity"):
        gelenk.load(out)
