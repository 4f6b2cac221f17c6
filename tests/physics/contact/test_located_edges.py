# SPDX-License-Identifier: BSD-3-Clause
"""Located contacts of corners, edges and rims: boxes on boxes and capsules, cylinders on planes."""

from math import atan2, cos, pi, radians, sin, sqrt
from typing import Any

import numpy as np
import pytest
from models.touching import inertia_of_box, on_plane

import gelenk

SceneData = dict[str, Any]
G = 9.81  # m/s2


def on_block(
    shape: SceneData, mass: float, inertia: list[float], start: SceneData, law: SceneData, block: SceneData
) -> SceneData:
    """A free body above a box that stands still."""
    scene = on_plane(shape, mass, inertia, start, law)
    scene["ground"] = {"shapes": {"block": {**block, "surface": "concrete"}}}
    return scene


def cylinder(radius: float, length: float, mass: float) -> tuple[SceneData, list[float]]:
    across = mass * (radius**2 / 4 + length**2 / 12)
    return {"cylinder": {"radius": radius, "length": length}}, [across, across, mass * radius**2 / 2]


SIZE = [0.3, 0.2, 0.1]  # m


@pytest.mark.parametrize("integrator", ["erk", "cvode"])
@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_box_on_a_tilted_box(integrator: str, friction: float) -> None:
    """Slides with g (sin - mu cos), or sticks without creep."""
    angle, height = radians(20), 0.25
    up = np.array([sin(angle), 0, cos(angle)])
    turn = [0, sin(angle / 2), 0, cos(angle / 2)]
    block = {"box": [4, 1, 2 * height], "rotation": {"axis": [0, 1, 0], "angle": angle}}
    start = {"r": ((height + SIZE[2] / 2) * up).tolist(), "Q": turn}
    scene = on_block({"box": SIZE}, 2, inertia_of_box(2, SIZE), start, {"friction": friction}, block)
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-8, integrator=integrator)
    a = max(0.0, G * (sin(angle) - friction * cos(angle)))
    along = np.array([cos(angle), 0, -sin(angle)])
    way = np.stack([run[f"J.r[{k}]"] for k in (1, 2, 3)], axis=1) - start["r"]
    assert way @ along == pytest.approx(a * run.time**2 / 2, abs=1e-9)
    assert np.abs(way @ up).max() <= 1e-12
    assert run["floor.f[3]"][-1] * cos(angle) + run["floor.f[1]"][-1] * sin(angle) == pytest.approx(
        2 * G * cos(angle), abs=1e-9
    )
    assert run["floor.mode"][-1] == (2 if a > 0 else 1)


@pytest.mark.parametrize("sideways", [0.0, 0.13])
def test_a_box_slides_over_an_edge_and_tips(sideways: float) -> None:
    """Its energy is conserved without friction, and its edge leaves the block when its center is beyond it.

    Until the center of mass passes the edge, the box slides at its speed; the corners behind carry it.
    """
    speed = 0.5
    block = {"box": [2, 0.5, 1], "position": [-1, 0, -0.5]}  # ends at x = 0
    start = {"r": [-0.2, sideways, SIZE[2] / 2], "v": [speed, 0, 0]}
    scene = on_block({"box": SIZE}, 2, inertia_of_box(2, SIZE), start, {}, block)
    scene["sensors"] = {"E": {"type": "energy"}}
    run = gelenk.simulate(scene, stop=0.7, step=0.01, tolerance=1e-9, integrator="erk")
    over = run.time < 0.2 / speed
    assert run["J.r[1]"][over] == pytest.approx(-0.2 + speed * run.time[over], abs=1e-9)
    assert np.abs(run["J.r[3]"][over] - SIZE[2] / 2).max() <= 1e-12
    assert np.abs(run["floor.f[3]"][over] - 2 * G).max() <= 1e-9
    energy = run["E.kinetic"] + run["E.potential"]
    assert np.abs(energy - energy[0]).max() <= 1e-7
    assert run["J.w[2]"][-1] > 1  # it has tipped
    assert np.abs(run["J.w[1]"]).max() <= 1e-9


def test_crossed_boxes_touch_at_their_edges() -> None:
    """A bar turned by 45 degrees falls with its lower edge across the upper edge of a beam turned likewise.

    The balance on one point is not stable, but exact for a while.
    """
    edge = 0.4
    beam = {"box": [2, edge, edge], "rotation": {"axis": [1, 0, 0], "angle": pi / 4}}
    start = {"r": [0, 0, edge * sqrt(2) + 0.05], "Q": [0, sin(pi / 8), 0, cos(pi / 8)]}
    bar = [edge, 2, edge]
    scene = on_block({"box": bar}, 2, inertia_of_box(2, bar), start, {"friction": 0.5}, beam)
    run = gelenk.simulate(scene, stop=0.3, step=0.01, tolerance=1e-9, integrator="erk")
    touches = [t for t, text in run.events if "touches" in text]
    assert touches == pytest.approx([sqrt(2 * 0.05 / G)], abs=1e-10)
    after = run.time > touches[0]
    assert run["J.r[3]"][after] == pytest.approx(edge * sqrt(2), abs=1e-10)
    assert run["floor.f[3]"][-1] == pytest.approx(2 * G, abs=1e-8)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_capsule_across_a_narrow_box(turn: float) -> None:
    """It rolls on two edges: 2/3 of the acceleration of what slides, as of a solid cylinder."""
    radius, mass = 0.05, 1.0
    block = {"box": [4, 0.1, 0.2], "position": [0, 0, -0.1]}
    half = pi / 4
    start = {
        "r": [0, 0, radius],
        "Q": [sin(half), 0, 0, cos(half)],
        "v": [0.3, 0, 0],
        "w": [0, 0, -0.3 / radius],
    }
    shape = {"capsule": {"radius": radius, "length": 0.4}}
    inertia = [0.02, 0.02, mass * radius**2 / 2]
    scene = on_block(shape, mass, inertia, start, {"friction": 0.5}, block)
    scene["gravity"] = [G * sin(turn / 10), 0, -G * cos(turn / 10)]
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-9, integrator="erk")
    a = G * sin(turn / 10) * 2 / 3
    assert abs(run["J.v[1]"][0]) == pytest.approx(0.3)
    assert np.abs(run["J.r[3]"] - radius).max() <= 1e-11
    moving = run["J.v[1]"]
    rolled = np.diff(moving)
    assert rolled[2:] == pytest.approx(a * 0.1, abs=1e-7)


@pytest.mark.parametrize("integrator", ["erk", "cvode", "ida", "dirk"])
def test_a_cylinder_rolls_down_a_plane(integrator: str) -> None:
    """With 2/3 of g sin, if friction is more than a third of the slope; it keeps its direction."""
    angle, radius = radians(15), 0.1
    shape, inertia = cylinder(radius, 0.3, 2.0)
    normal = [sin(angle), 0, cos(angle)]
    start = {"r": [radius * n for n in normal], "Q": [sin(pi / 4), 0, 0, cos(pi / 4)]}
    scene = on_plane(shape, 2.0, inertia, start, {"friction": 0.3}, normal=normal)
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-9, integrator=integrator)
    down = run["J.r[1]"] * cos(angle) - run["J.r[3]"] * sin(angle)
    assert down == pytest.approx(G * sin(angle) / 3 * run.time**2, abs=1e-7)
    assert run["floor.mode"][-1] == 1


def test_a_sliding_cylinder_rolls_with_two_thirds_of_its_speed() -> None:
    radius, speed, mu = 0.1, 2.0, 0.2
    shape, inertia = cylinder(radius, 0.3, 2.0)
    start = {"r": [0, 0, radius], "Q": [sin(pi / 4), 0, 0, cos(pi / 4)], "v": [speed, 0, 0]}
    scene = on_plane(shape, 2.0, inertia, start, {"friction": mu})
    run = gelenk.simulate(scene, stop=1, step=0.1, tolerance=1e-9, integrator="erk")
    stops = [t for t, text in run.events if "stops sliding" in text]
    assert stops[0] == pytest.approx(speed / (3 * mu * G), abs=1e-9)
    assert run["J.v[1]"][-1] == pytest.approx(2 / 3 * speed, abs=1e-9)


def test_a_cylinder_falls_about_its_rim_and_lands_flat() -> None:
    """The energy gives its rate before it lands; then it stands on its end, which is refused in words."""
    radius, length, mass, tilt = 0.2, 0.1, 2.0, 0.5
    shape, inertia = cylinder(radius, length, mass)
    # The lowest point of the rim is below x > 0; tilted about y.
    reach = np.array([-radius, length / 2])  # from the lowest point to the center, along x and z of the body
    center = [0.0, 0.0, -reach[0] * sin(tilt) + reach[1] * cos(tilt)]
    start = {"r": center, "Q": [0, sin(tilt / 2), 0, cos(tilt / 2)]}
    scene = on_plane(shape, mass, inertia, start, {"friction": 20.0})
    scene["solver"] = {"integrator": "erk"}
    simulation = gelenk.Simulation(scene)
    simulation.initialize(tolerance=1e-10)
    moment = inertia[0] + mass * (radius**2 + length**2 / 4)
    refused = ""
    angle = tilt
    for k in range(1, 1000):
        try:
            simulation.step_to(k * 1e-3)
        except gelenk.StepError as error:
            refused = str(error)
            break
        angle = 2 * atan2(simulation.output("J.Q[2]"), simulation.output("J.Q[4]"))
        height = -reach[0] * sin(angle) + reach[1] * cos(angle)
        rate = sqrt(2 * mass * G * (center[2] - height) / moment)
        assert abs(simulation.output("J.w[2]")) == pytest.approx(rate, abs=1e-8)
        assert simulation.output("J.r[3]") == pytest.approx(height, abs=1e-10)
    assert "with a flat end, whose contacts are not located" in refused
    assert angle < 0.05
