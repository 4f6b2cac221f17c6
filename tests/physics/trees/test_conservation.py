# SPDX-License-Identifier: BSD-3-Clause
"""Conservation of momentum, angular momentum and energy of mechanisms without external forces,
open trees and closed loops.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import (
    Scene,
    body,
    four_bar,
    frame,
    frame_sensor,
    inertia_matrix,
    joint,
    matrix,
    rotation,
    scene,
    with_sensors,
)
from models.running import INTEGRATORS, Recording, assert_close, run
from scipy.spatial.transform import Rotation

pytestmark = warned.TIGHT


def with_center_sensors(source: Scene) -> Scene:
    """Add a frame sensor at every center of mass and an energy sensor."""
    sensors: dict[str, Any] = {f"c_{n}": frame_sensor(n, b["com"]) for n, b in source["bodies"].items()}
    return with_sensors(source, E={"type": "energy"}, **sensors)


def momenta(source: Scene, found: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return momentum and angular momentum about the world origin,
    summed over the bodies from the sensors.
    """
    P = L = np.zeros(3)
    for name, entry in source["bodies"].items():
        r, v, w = (found.vector(f"c_{name}.{x}") for x in "rvw")
        R = Rotation.from_quat(found.vector(f"c_{name}.Q")).as_matrix()
        spin = np.einsum("tij,jk,tk->ti", R, inertia_matrix(entry), w)
        P = P + entry["mass"] * v
        L = L + spin + entry["mass"] * np.cross(r, v)
    return P, L


def snake() -> Scene:
    """Return a free chain of six bodies connected by joints of every kind,
    tumbling, with internal springs.
    """
    kinds: list[tuple[str, dict[str, Any]]] = [
        (
            "universal",
            {
                "axes": [[1, 0, 0], [0.2, 0.9, 0.1]],
                "start": {"phi_a": 0.4, "w_b": 1.0},
                "stiffness": [1.5, 0.7],
            },
        ),
        ("prismatic", {"axis": [0.3, 0.5, 0.8], "start": {"v": 0.4}, "stiffness": 9.0}),
        ("spherical", {"start": {"w": [0.5, -1.1, 0.3]}}),
        ("cylindrical", {"axis": [0.7, -0.1, 0.4], "start": {"w": 1.2, "v": -0.2}, "stiffness": [4.0, 0.3]}),
        (
            "planar",
            {"axis": [0.1, 0.9, -0.4], "start": {"v_x": 0.3, "w": -0.6}, "stiffness": [3.0, 2.0, 0.4]},
        ),
    ]
    rng = np.random.default_rng(12)
    bodies = {
        f"b{i}": body(
            float(rng.uniform(0.5, 2)),
            rng.uniform(-0.1, 0.1, 3),
            (*rng.uniform(0.05, 0.09, 3), *rng.uniform(-0.01, 0.01, 3)),
        )
        for i in range(6)
    }
    start = {"r": [0.3, 0, -0.2], "v": [0, 0.4, 0], "w": [0.7, -0.4, 0.9]}
    joints = {"J0": joint("free", frame("ground"), frame("b0"), start=start)}
    for i, (kind, fields) in enumerate(kinds):
        R1, R2 = (rotation(rng.normal(size=3), 0.8) for _ in range(2))
        joints[f"J{i + 1}"] = joint(
            kind, frame(f"b{i}", (0.2, 0.1, 0.0), R1), frame(f"b{i + 1}", (-0.2, 0.05, 0.1), R2), **fields
        )
    joints["J6"] = joint(
        "revolute", frame("b5", (0.1, 0.2, 0)), frame("b6"), axis=[0.2, 0.3, 0.9], start={"w": 2.0}
    )
    bodies["b6"] = body(0.4, (0.05, 0.1, 0.0), (0.01, 0.012, 0.015))
    spring = {
        "type": "spring_damper",
        "from": frame("b0", (0, 0.1, 0)),
        "to": frame("b6", (0.1, 0, 0)),
        "stiffness": 2.0,
        "damping": 0.0,
        "length": 0.4,
    }
    return scene(bodies, joints, forces={"spring": spring})


def floating_four_bar() -> Scene:
    """Return the four-bar on a base plate that flies freely and tumbles."""
    source = four_bar(torque=None, damping=0.0, gravity=(0, 0, 0))
    source["motors"] = {}
    for name in "AD":
        source["joints"][name]["parent"]["body"] = "plate"
    source["joints"]["A"]["start"] = {"phi": 1.1, "w": 2.0, "fixed": True}
    source["bodies"]["plate"] = body(3.0, (1.0, -0.1, 0.05), (0.5, 0.9, 1.1))
    start = {"w": [0.6, -0.5, 0.8], "v": [0.3, 0, -0.2], "fixed": True}
    source["joints"]["F"] = joint(
        "free", {**frame("ground"), "rotation": matrix(rotation([1, 2, 3], 0.7))}, frame("plate"), start=start
    )
    return source


SCENES = {"snake": snake, "floating four-bar": floating_four_bar}


@pytest.fixture(scope="module", params=[(s, i) for s in SCENES for i in INTEGRATORS], ids="-".join)
def flight(request: pytest.FixtureRequest) -> tuple[Scene, Recording]:
    name, integrator = request.param
    source = with_center_sensors(SCENES[name]())
    return source, run(source, np.linspace(0, 3, 31), tolerance=1e-11, integrator=integrator)


def test_momentum_is_conserved(flight) -> None:
    """Internal forces cancel (Newton's third law).
    The bound is 1000 rtol of the sum of the parts, about 10 N s.
    """
    P, _ = momenta(*flight)
    assert_close("momentum", P, P[0], 1e-8, "1000 rtol")


def test_angular_momentum_is_conserved(flight) -> None:
    """Internal torques cancel as well. A wrong lever arm or Coriolis term gives 1e-1."""
    _, L = momenta(*flight)
    assert_close("angular momentum", L, L[0], 1e-8, "1000 rtol")


def test_energy_is_conserved(flight) -> None:
    """Kinetic energy plus potential energy of the springs is constant, and the kinetic energy computed from
    the sensors of the individual bodies equals the one reported by the core.
    """
    source, found = flight
    total = found["E.total"]
    assert_close("energy", total, total[0], 1e-8, "1000 rtol x 10 J")
    T = 0.0
    for name, entry in source["bodies"].items():
        v, w = found.vector(f"c_{name}.v"), found.vector(f"c_{name}.w")
        T = T + 0.5 * entry["mass"] * (v * v).sum(axis=1)
        T = T + 0.5 * np.einsum("ti,ij,tj->t", w, inertia_matrix(entry), w)
    assert_close("kinetic energy", found["E.kinetic"], T, 1e-12, "round-off of 10 J")
    moving = max(np.ptp(x) for x in found.joint_states(source).values())
    assert moving > 1  # rad, m or their rates: the bodies do exchange momentum
