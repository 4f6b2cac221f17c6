# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates of joints and outputs of sensors in expressions of other elements."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from circuits import dc_exact, dc_motor, rotor, values
from mechanisms import body, four_bar, frame, joint, scene

import gelenk


def moved(source: dict[str, Any]) -> tuple[gelenk.Simulation, list[float]]:
    """Return a run of 1 s, and what all joints do at its end, followed by A of a linear model."""
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-10)
    for k in range(20):
        simulation.step_to(0.05 * (k + 1))
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(source, states=["A.phi", "A.w"])
    reached = [simulation.output(f"{of}.{q}") for of in "ABCD" for q in ("phi", "w", "a")]
    return simulation, reached + list(np.asarray(model.A).ravel())


@pytest.mark.parametrize("reduced", [True, False])
@pytest.mark.parametrize("name", ["A", "B", "C", "D"])
def test_coordinates_of_any_joint_of_a_loop_are_named(name: str, reduced: bool) -> None:
    """Torques on both bodies of a joint, by its coordinate and speed, are a spring and a damper there."""
    found, evaluations = [], []
    for by_names in (True, False):
        source = four_bar(1.1, damping=0.0)
        if not reduced:
            source["solver"] = {"reductions": {"planar": False, "cut_choice": False, "massless": False}}
        at = source["joints"][name]
        if by_names:
            torque = f"3*({name}.phi - 0.2) + 0.4*{name}.w"
            forces = {}
            for i, (side, sign) in enumerate((("parent", ""), ("child", "-"))):
                on = at[side]["body"]
                if on != "ground":
                    forces[f"torque{i}"] = {
                        "type": "body_force",
                        "body": on,
                        "torque": ["0", "0", f"{sign}({torque})"],
                    }
            source["forces"] = forces
        else:
            at.update({"stiffness": 3.0, "damping": 0.4, "spring_reference": 0.2})
        source["solver"] = source.get("solver", {}) | {"integrator": "dirk"}
        simulation, reached = moved(source)
        found.append(reached)
        evaluations.append(simulation.diagnostic("solver.evaluations"))
    assert (
        abs(evaluations[0] - evaluations[1]) < 0.05 * evaluations[1]
    )  # Newton's method has exact derivatives
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-8)


@pytest.mark.parametrize("planar", [True, False])
def test_distance_by_name_is_a_line_force(planar: bool) -> None:
    """A spring and damper between two points of a loop: as an element, and from the sensor of its length."""
    found = []
    for by_names in (True, False):
        source = four_bar(1.1, damping=0.0)
        crank, point = source["joints"]["A"]["child"]["body"], [2.0, 1.0, 0]
        tip = {"body": crank, "position": [0.5, 0, 0]}
        if by_names:
            # of the line from the tip at (0.5 cos phi, 0.5 sin phi) to the point, about the origin
            lever = "0.5*(1*cos(A.phi) - 2*sin(A.phi))/gap.d"
            source["sensors"] = {
                "gap": {"type": "distance", "from": {"body": "ground", "position": point}, "to": tip}
            }
            source["joints"]["A"]["law"] = {"effort": f"(30*(gap.d - 1) + 2*gap.v)*{lever}"}
        else:
            source["forces"] = {
                "spring": {
                    "type": "spring_damper", "from": {"body": "ground", "position": point}, "to": tip,
                    "stiffness": 30, "damping": 2, "length": 1,
                }
            }  # fmt: skip
        source["solver"] = {"integrator": "dirk", "reductions": {"planar": planar}}
        found.append(moved(source)[1])
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=2e-8)


def test_what_an_expression_names_is_in_one_island() -> None:
    """Two pendulums that only a law couples: the same as with a spring between their angles."""
    rod = body(1.0, (0.25, 0, 0), (0.02, 0.02, 0.02))

    def pendulums(laws: list[str]) -> dict[str, Any]:
        joints = {}
        for name, law, phi in zip("AB", laws, (0.3, -0.2), strict=True):
            joints[name] = joint(
                "revolute", frame("ground"), frame(f"rod{name}"), axis=[0, 0, 1], start={"phi": phi},
                law={"effort": law},
            )  # fmt: skip
        return scene({"rodA": rod, "rodB": rod}, joints, gravity=[9.81, 0, 0])

    source = pendulums(["-4*(phi - B.phi)", "-4*(phi - A.phi)"])
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-10)
    assert simulation.size.islands == 1
    mean, difference = pendulums(["0", "0"]), pendulums(["-8*phi", "-8*phi"])
    for small in (source, mean, difference):
        for name, phi in zip("AB", (3e-6, -2e-6), strict=True):
            small["joints"][name]["start"] = {"phi": phi}
    coupled, free, stiff = (
        values(one, ["A.phi", "B.phi"], [0.7], 1e-12)[0] for one in (source, mean, difference)
    )
    modes = [(free[0] + free[1]) / 2, (stiff[0] - stiff[1]) / 2]
    np.testing.assert_allclose(coupled, [modes[0] + modes[1], modes[0] - modes[1]], rtol=0, atol=1e-11)


def test_wanted_outputs_keep_what_their_expressions_name() -> None:
    source = dc_motor(outputs=["A.w"])
    source["bodies"]["idle"] = body(1.0, inertia=(1, 1, 1))
    source["joints"]["Z"] = joint("revolute", frame("ground"), frame("idle"), axis=[0, 0, 1])
    source["states"]["other"] = "Z.phi - other"
    assert values(source, ["A.w"], [0.3], 1e-9)[0, 0] == pytest.approx(dc_exact(0.3)[0], abs=1e-8)
    simulation = gelenk.Simulation(source)
    assert [getattr(signal, "name", signal) for signal in simulation.outputs] == ["A.w"]
    only = gelenk.Simulation(source | {"outputs": ["other"]})
    only.initialize(0.0, 1e-8)
    only.step_to(1.0)
    assert only.output("other") == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("integrator", ["auto", "dirk", "cvode", "ida"])
def test_thresholds_of_sensors_are_found_in_slow_motion(integrator: str) -> None:
    """An oscillation sin t: the times below a distance and above a speed of a point, in one step."""
    source = rotor(
        effort="-0.5*phi", start={"phi": 0.0, "w": 1.0},
        states={"near": "if(gap.d < 1.0005, 1, 0)", "fast": "if(tip.v[2] > 0.999, 1, 0)"},
        sensors={
            "gap": {"type": "distance", "from": {"body": "ground", "position": [2, 0, 0]},
                    "to": {"body": "rotor", "position": [1, 0, 0]}},
            "tip": {"type": "frame", "body": "rotor", "position": [1, 0, 0]},
        },
        solver={"integrator": integrator},
    )  # fmt: skip
    found = values(source, ["near", "fast"], [10 * math.pi], 1e-8)[0]
    t = np.linspace(0, 10 * math.pi, 2_000_001)
    phi, w = np.sin(t), np.cos(t)
    near = np.mean((2 - np.cos(phi)) ** 2 + np.sin(phi) ** 2 < 1.0005**2) * 10 * math.pi
    fast = np.mean(np.cos(phi) * w > 0.999) * 10 * math.pi
    np.testing.assert_allclose(found, [near, fast], rtol=0, atol=1e-4)  # of the sum over so many instants
