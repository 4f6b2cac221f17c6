# SPDX-License-Identifier: BSD-3-Clause
"""Distance and power sensors compared with positions and with the rate of change of energy."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk


def arm(**sensors: object) -> Scene:
    """Two links in space with a drive, damping and springs."""
    return scene(
        {"a": body(1.0, (0.2, 0, 0.1), (0.01, 0.02, 0.02)), "b": body(0.5, (0.1, 0, 0), (0.01, 0.01, 0.012))},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 1, 0], damping=0.1,
                       start={"phi": 0.4, "w": 1.0}),
            "B": joint("revolute", frame("a", (0.4, 0, 0)), frame("b", (0.05, 0, 0)), axis=[1, 1, 0],
                       stiffness=2.0, damping=0.05, start={"phi": -0.9, "w": 2.0}),
        },
        gravity=[0, 0, -GRAVITY],
        motors={"m": {"joint": "A"}, "n": {"joint": "B", "gear_ratio": 3}},
        sensors=sensors,
        experiment={"stop": 1, "step": 0.01, "tolerance": 1e-11},
    )  # fmt: skip


def frame_at(body_name: str, position: tuple[float, float, float]) -> dict[str, object]:
    return {"type": "frame", "body": body_name, "position": list(position)}


def test_distance_and_its_rate_match_positions_and_velocities() -> None:
    p, q = (0.1, 0.2, 0.3), (0.3, -0.1, 0.0)
    source = arm(
        d={"type": "distance", "from": frame("a", p), "to": frame("b", q)},
        at_a=frame_at("a", p), at_b=frame_at("b", q),
    )  # fmt: skip
    run = gelenk.simulate(source, inputs={"m.tau": 1.0})
    way = np.array([run[f"at_b.r[{i}]"] - run[f"at_a.r[{i}]"] for i in (1, 2, 3)])
    v = np.array([run[f"at_b.v[{i}]"] - run[f"at_a.v[{i}]"] for i in (1, 2, 3)])
    np.testing.assert_allclose(run["d.d"], np.linalg.norm(way, axis=0), rtol=1e-14)
    np.testing.assert_allclose(run["d.v"], (way * v).sum(axis=0) / np.linalg.norm(way, axis=0), atol=1e-13)


def test_distance_between_points_at_rest_is_constant() -> None:
    source = arm(d={"type": "distance", "from": {"body": "ground", "position": [3, 0, 0]},
                    "to": {"body": "ground", "position": [0, 4, 0]}})  # fmt: skip
    run = gelenk.simulate(source)
    assert (run["d.d"] == 5).all()
    assert (run["d.v"] == 0).all()


def test_distance_sensor_does_not_couple_two_islands() -> None:
    """Two pendulums without connection move as if each were alone, although their distance is measured."""
    bodies = {n: body(1.0, (0.3, 0, 0), (0.01, 0.02, 0.02)) for n in "ab"}
    joints = {
        n.upper(): joint("revolute", frame("ground", (x, 0, 0)), frame(n), axis=[0, 1, 0], start={"phi": phi})
        for n, x, phi in (("a", 0.0, 0.3), ("b", 2.0, 1.0))
    }
    settings = {"experiment": {"stop": 1, "step": 0.1, "tolerance": 1e-10}, "gravity": [0, 0, -GRAVITY]}
    sensor = {"d": {"type": "distance", "from": "a", "to": {"body": "b", "position": [0.6, 0, 0]}}}
    apart = gelenk.simulate(scene(bodies, joints, **settings))
    both = gelenk.simulate(scene(bodies, joints, sensors=sensor, **settings))
    for name in ("A.phi", "B.phi"):
        np.testing.assert_allclose(both[name], apart[name], atol=1e-8)  # 100 x tolerance
    x, z = 2 + 0.6 * np.cos(both["B.phi"]), -0.6 * np.sin(both["B.phi"])
    np.testing.assert_allclose(both["d.d"], np.hypot(x, z), rtol=1e-13)


def test_distance_of_coincident_points_is_zero_and_grows() -> None:
    source = arm(d={"type": "distance", "from": {"body": "a", "position": [0.4, 0, 0]},
                    "to": {"body": "b", "position": [0.05, 0, 0]}})  # fmt: skip
    plant = gelenk.Simulation(source)
    plant.initialize()
    assert plant.output("d.d") == pytest.approx(0, abs=1e-15)
    assert plant.output("d.v") == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("reduced", [True, False])
def test_joint_power_is_that_of_drive_spring_and_damper(reduced: bool) -> None:
    """Of A: tau w - d w^2; of B: gear tau w - d w^2 - k phi w."""
    source = arm(A_P={"type": "power", "joint": "A"}, B_P={"type": "power", "joint": "B"},
                 Rb={"type": "reaction", "joint": "B"})  # fmt: skip
    if not reduced:
        source["solver"] = {"reductions": {"all": False}}
    run = gelenk.simulate(source, inputs={"m.tau": 1.0, "n.tau": 0.2})
    w_A, w_B = run["A.w"], run["B.w"]
    np.testing.assert_allclose(run["A_P.total"], 1.0 * w_A - 0.1 * w_A**2, atol=1e-11)
    np.testing.assert_allclose(run["B_P.total"], (3 * 0.2 - 0.05 * w_B - 2 * run["B.phi"]) * w_B, atol=1e-11)
    np.testing.assert_allclose(run["A_P.parent"], 0, atol=1e-13)  # the ground does not move
    np.testing.assert_allclose(run["A_P.child"] + run["A_P.parent"], run["A_P.total"], atol=1e-12)


def test_power_on_the_child_is_the_rate_of_its_energy() -> None:
    """The last link is subject only to gravity: P = d(T + m g z)/dt, by finite differences."""
    com = (0.1, 0.0, 0.0)
    source = arm(P={"type": "power", "joint": "B"}, at=frame_at("b", com))
    source["experiment"] |= {"stop": 0.1, "step": 1e-3}
    run = gelenk.simulate(source, inputs={"n.tau": 0.2})
    v = np.array([run[f"at.v[{i}]"] for i in (1, 2, 3)])
    w = np.array([run[f"at.w[{i}]"] for i in (1, 2, 3)])
    moments = np.array([0.01, 0.01, 0.012])
    energy = (
        0.25 * (v**2).sum(axis=0) + (moments[:, None] * w**2).sum(axis=0) / 2 + 0.5 * GRAVITY * run["at.r[3]"]
    )
    # Central differences of order four: their error is 3e-3 over 0.01 s, so 3e-7 over 0.001 s.
    rate = (energy[:-4] - 8 * energy[1:-3] + 8 * energy[3:-1] - energy[4:]) / (12 * 1e-3)
    np.testing.assert_allclose(run["P.child"][2:-2], rate, atol=1e-6)
