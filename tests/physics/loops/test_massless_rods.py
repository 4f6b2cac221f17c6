# SPDX-License-Identifier: BSD-3-Clause
"""A massless rod replaced by one distance constraint gives the same motion as the rod modeled as a body."""

from __future__ import annotations

import copy
from itertools import product
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import (
    GRAVITY,
    Array,
    Numbers,
    Scene,
    body,
    four_bar_angles,
    frame,
    frame_sensor,
    joint,
    reordered,
    rotation,
    scene,
    with_sensors,
)
from models.rods import LINKS, hung_plank, hung_platform, planar_four_bar, sizes, spatial_four_bar
from models.running import Recording, assert_close, assert_same, run

OFF = {"massless": False}
TIMES = np.linspace(0, 3, 61)


def with_and_without_reduction(
    source: Scene, times: Array = TIMES, tolerance: float = 1e-11
) -> tuple[Recording, Recording]:
    """Results with the rods as constraint equations, and as bodies."""
    return run(source, times, tolerance=tolerance), run(source, times, tolerance=tolerance, reductions=OFF)


def assert_agree(source: Scene, times: Array = TIMES, tolerance: float = 1e-11) -> Recording:
    """Compare all outputs with and without the reduction, to 1e-9 of the largest value of their unit."""
    rows, bodies = with_and_without_reduction(source, times, tolerance)
    largest: dict[str, float] = {}
    for name, unit in rows.units.items():
        largest[unit] = max(largest.get(unit, 1.0), float(np.abs(bodies[name]).max()))
    for name, unit in rows.units.items():
        assert_close(name, rows[name], bodies[name], 1e-9 * largest[unit], "100 rtol, some seconds")
    return rows


# --- the same motion, with and without the reduction ---


@pytest.mark.parametrize("seed", range(3))
def test_planar_four_bar_moves_as_with_coupler_as_body(seed: int) -> None:
    """Angles, speeds, accelerations of all joints and the coupler frame are compared,
    for any order in the file.
    """
    source = with_sensors(
        planar_four_bar(), F=frame_sensor("coupler", (0.3, 0.2, 0.1), rotation([1, 2, 3], 0.4))
    )
    assert_agree(reordered(source, seed))


@pytest.mark.parametrize(
    ("child", "axes"), list(product(product((True, False), repeat=2), [(1, 0, 0), (0.6, 0.8, 0)]))
)
def test_spatial_four_bar_moves_as_with_rod_as_body(child: tuple[bool, bool], axes: Numbers) -> None:
    """For both orientations of its joints. In some cases the rod passes a joint axis at 60 rad/s about it."""
    source = spatial_four_bar(rod_is_child=child, axes=axes)
    sensor = frame_sensor("rod", (0.1, 0.2, 0.3), rotation([1, 2, 3], 0.4))
    assert_agree(with_sensors(source, F=sensor), tolerance=1e-12)


@pytest.mark.parametrize("child", list(product((True, False), repeat=2)))
def test_order_in_the_file_does_not_change_results(child: tuple[bool, bool]) -> None:
    source = spatial_four_bar(rod_is_child=child)
    expected = run(source, TIMES, tolerance=1e-11)
    for seed in range(3):
        found = run(reordered(source, seed), TIMES, tolerance=1e-11)
        for name in expected.joint_states(source):
            bound = 1e-9 * max(1.0, float(np.abs(expected[name]).max()))
            assert_close(name, found[name], expected[name], bound, "100 rtol, 3 s")


def test_angles_of_a_hinged_rod_count_full_turns() -> None:
    """Nine turns of the crank: B and C are compared with the crank and rocker angles, in closed form."""
    source = planar_four_bar()
    source["joints"]["A"]["start"]["w"] = 12.0
    found = run(source, np.linspace(0, 6, 121), tolerance=1e-10)
    phi = found["A.phi"]
    assert abs(phi[-1] - phi[0]) > 9 * 2 * np.pi
    theta, psi = np.array([four_bar_angles(angle, LINKS) for angle in phi]).T
    assert_close("B.phi", found["B.phi"], np.unwrap(theta) - phi, 1e-8, "100 rtol")
    assert_close("C.phi", found["C.phi"], np.unwrap(psi) - np.unwrap(theta), 1e-8, "100 rtol")


@warned.GUESSES
def test_initial_guesses_at_the_ends_of_a_rod_select_the_branch() -> None:
    """Only the initial guess of the coupler angle is given: below the diagonal instead of above it."""
    source = planar_four_bar()
    for name in "CD":
        del source["joints"][name]["start"]
    for theta in (0.9, -0.9):
        source["joints"]["B"]["start"] = {"phi": theta - 1.1}
        rows, bodies = with_and_without_reduction(source, np.array([0.0]))
        assert np.sign(rows["D.phi"][0]) == np.sign(theta)
        assert_same(rows.joint_states(source), bodies.joint_states(source), 1e-12, "closure")


def test_fixed_start_value_at_the_end_of_a_rod_is_exact() -> None:
    source = planar_four_bar()
    source["joints"]["A"]["start"] = {"phi": 1.1, "w": 0.0}
    source["joints"]["B"]["start"] = {"phi": -0.5, "w": 2.0, "fixed": True}
    assert sizes(source) == (2, 1, 1)
    found = run(source, np.array([0.0]))
    assert_close("B.phi", found["B.phi"], -0.5, 1e-9, "closure")
    assert_close("B.w", found["B.w"], 2.0, 1e-9, "closure")
    assert_agree(source)


# --- comparison with independent solutions ---


def test_rod_with_mass_converges_to_massless_rod() -> None:
    """The error is proportional to the mass: a tenth of the mass gives a tenth of the difference."""
    times = np.linspace(0, 1, 11)
    massless = run(spatial_four_bar(), times, tolerance=1e-11)
    differences = [
        np.abs(run(spatial_four_bar(mass=mass), times, tolerance=1e-11)["D.phi"] - massless["D.phi"]).max()
        for mass in (1e-3, 1e-4, 1e-5)
    ]
    assert differences[0] < 1e-2
    assert_close("ratios", np.array(differences[:2]) / differences[1:], 10, 0.2, "linear in the mass")


def test_two_spherical_ends_and_a_universal_end_give_equal_motion() -> None:
    spherical = run(spatial_four_bar("spherical"), TIMES, tolerance=1e-11)
    universal = run(spatial_four_bar("universal"), TIMES, tolerance=1e-11)
    for name in ("A.phi", "A.w", "A.a", "D.phi", "D.w", "D.a"):
        bound = 1e-9 * max(1.0, float(np.abs(universal[name]).max()))
        assert_close(name, spherical[name], universal[name], bound, "100 rtol, 3 s")


def test_rod_between_spherical_joints_does_not_spin() -> None:
    """Q of the first joint is the rotation with the smallest angle; Q,
    w and z of both joints are consistent derivatives.
    """
    source = spatial_four_bar("spherical", (True, False))
    h = 1e-4
    times = np.concatenate([t + h * np.array([-1, 0, 1]) for t in np.linspace(0.1, 2, 20)])
    found = run(source, np.concatenate([[0.0], times]), tolerance=1e-12)
    for name in "US":
        Q, w, z = (found.vector(f"{name}.{s}")[1:].reshape(20, 3, -1) for s in "Qwz")
        u, s = Q[:, 1, :3], Q[:, 1, 3:]
        Qdot = (Q[:, 2] - Q[:, 0]) / (2 * h)
        w_of_Q = 2 * (s * Qdot[:, :3] - Qdot[:, 3:] * u - np.cross(u, Qdot[:, :3]))
        # third derivatives of about (10 rad/s)^3, times h^2
        assert_close(f"{name}.w", w_of_Q, w[:, 1], 1e-3, "finite differences")
        assert_close(f"{name}.z", (w[:, 2] - w[:, 0]) / (2 * h), z[:, 1], 1e-1, "finite differences")
    # The axis of the smallest rotation is perpendicular to the rod, which lies along z of the joint frame.
    assert_close("twist", found["U.Q[3]"], 0, 1e-12, "round-off")


def test_parallelogram_with_massless_coupler_is_one_pendulum() -> None:
    """Cranks of equal length connected by a massless rod rotate equally: one pendulum with both inertias."""
    about_z = {"axis": [0, 0, 1]}
    length, left, right = 0.8, 1.3, 0.4

    def bob(mass: float) -> dict[str, Any]:
        return body(mass, (0, -length, 0), [0.02 * mass] * 3)

    start = {"phi": 0.7, "w": 0.3, "fixed": True}
    pair = scene(
        {"left": bob(left), "right": bob(right), "rod": body(0)},
        {
            "A": joint("revolute", frame("ground"), frame("left"), **about_z, start=start),
            "D": joint(
                "revolute", frame("ground", (1.1, 0, 0)), frame("right"), **about_z, start={"phi": 0.7}
            ),
            "B": joint(
                "revolute", frame("left", (0, -length / 2, 0)), frame("rod"), **about_z, start={"phi": -0.7}
            ),
            "C": joint("revolute", frame("rod", (1.1, 0, 0)), frame("right", (0, -length / 2, 0)), **about_z),
        },
        gravity=[0, -GRAVITY, 0],
    )
    assert sizes(pair) == (2, 1, 1)
    single = scene(
        {"bob": bob(left + right)},
        {"A": joint("revolute", frame("ground"), frame("bob"), **about_z, start=start)},
        gravity=[0, -GRAVITY, 0],
    )
    found, expected = run(pair, TIMES, tolerance=1e-11), run(single, TIMES, tolerance=1e-11)
    for signal in ("phi", "w", "a"):
        for name in "AD":
            assert_close(name, found[f"{name}.{signal}"], expected[f"A.{signal}"], 1e-8, "100 rtol, 3 s")
        other = 0.0 if signal != "phi" else found["C.phi"][0] + found["B.phi"][0]
        assert_close(
            "rod", found[f"B.{signal}"] + found[f"C.{signal}"], other, 1e-8, "the rod remains horizontal"
        )


@pytest.mark.parametrize("rods", [2, 3])
def test_platform_on_equal_rods_is_a_point_pendulum(rods: int) -> None:
    """The platform does not rotate, so each of its points moves like the far end of one of the rods."""
    start = {"phi_a": 0.5, "w_a": 0.3, "w_b": 0.7, "fixed": True}
    platform = hung_platform(rods, {"phi_a": 0.5, "w_a": 0.3, "w_b": 0.7})
    platform["joints"]["U0"]["start"] = start
    # Initially level; no moment rotates it while all rods pull equally: S cancels the rotations of U.
    for i in range(rods):
        platform["joints"][f"S{i}"]["start"] = {"Q": [-np.sin(0.25), 0, 0, np.cos(0.25)]}
    platform["bodies"]["platform"]["com"] = [0.0, 0.0, 0.0]
    point = scene(
        {"bob": body(3.0, (0, 0, -1.3), (1e-12, 1e-12, 1e-12))},
        {"U": joint("universal", frame("ground"), frame("bob"), axes=[[1, 0, 0], [0, 1, 0]], start=start)},
        gravity=[0, 0, -GRAVITY],
    )
    times = np.linspace(0, 1, 11)
    found, expected = run(platform, times, tolerance=1e-11), run(point, times, tolerance=1e-11)
    for i, name in product(range(rods), ("phi_a", "phi_b", "w_a", "w_b", "a_a", "a_b")):
        bound = 1e-6 if rods == 2 else 1e-7
        assert_close(
            f"U{i}.{name}", found[f"U{i}.{name}"], expected[f"U.{name}"], bound, "start closed to 1e-9"
        )


@pytest.mark.parametrize("rods", [2, 3])
def test_plank_on_equal_hinged_rods_is_a_point_pendulum(rods: int) -> None:
    """The first rod is in the tree; the third is redundant with the second."""
    source = hung_plank(rods)
    assert sizes(source) == (2, 1, 1)
    point = scene(
        {"bob": body(2.0, (0, -1, 0))},
        {
            "A": joint(
                "revolute",
                frame("ground"),
                frame("bob"),
                axis=[0, 0, 1],
                start=source["joints"]["A0"]["start"],
            )
        },
        gravity=[0, -GRAVITY, 0],
    )
    found, expected = run(source, TIMES, tolerance=1e-11), run(point, TIMES, tolerance=1e-11)
    for i, name in product(range(rods), ("phi", "w", "a")):
        assert_close(f"A{i}.{name}", found[f"A{i}.{name}"], expected[f"A.{name}"], 1e-8, "100 rtol, 3 s")


def test_rod_crosses_the_axis_of_its_joint() -> None:
    """A planar four-bar whose coupler has its first axis in the plane:
    phi_b makes full turns, phi_a is constant.
    """
    hinged = planar_four_bar()
    crossing = copy.deepcopy(hinged)
    crossing["joints"]["B"] = joint(
        "universal",
        frame("crank", (LINKS[0], 0, 0)),
        frame("coupler"),
        axes=[[0, 1, 0], [0, 0, 1]],
        start={"phi_b": hinged["joints"]["B"]["start"]["phi"]},
    )
    crossing["joints"]["C"] = joint(
        "spherical", hinged["joints"]["C"]["parent"], hinged["joints"]["C"]["child"]
    )
    assert sizes(crossing) == (2, 1, 1)
    times = np.linspace(0, 6, 121)
    found, expected = run(crossing, times, tolerance=1e-11), run(hinged, times, tolerance=1e-11)
    assert abs(expected["B.phi"][-1]) > 2 * np.pi
    assert_close("A.phi", found["A.phi"], expected["A.phi"], 1e-8, "100 rtol, 6 s")
    assert_close("B.phi_b", found["B.phi_b"], expected["B.phi"], 1e-8, "100 rtol, 6 s")
    assert_close("B.phi_a", found["B.phi_a"], 0, 1e-8, "the rod remains in the plane")


# --- rods that are required, rods that cannot move ---


def test_rod_remains_a_body_if_its_neighbor_needs_it_for_inertia() -> None:
    """A crank whose center of mass lies on its axis drives only the rod."""
    source = planar_four_bar()
    source["bodies"]["crank"] = body(1.0)
    assert sizes(source) == (3, 2, 1)
    assert_agree(source, np.linspace(0, 1, 11))


def test_rods_between_immobile_bodies_are_removed() -> None:
    """A triangle of two bars and a rod is immobile; the pendulum beside it continues to swing."""
    about_z = {"axis": [0, 0, 1]}
    source = scene(
        {
            "bar": body(1.0, (0.2, 0, 0), (0.1, 0.1, 0.1)),
            "rod": body(0),
            "bob": body(1.0, (0, -1, 0), (0.1, 0.1, 0.1)),
        },
        {
            "A": joint("revolute", frame("ground"), frame("bar"), **about_z),
            "B": joint("revolute", frame("bar", (1, 0, 0)), frame("rod"), **about_z, start={"phi": 2.2}),
            "C": joint("revolute", frame("rod", (1, 0, 0)), frame("ground", (0.5, 0.8, 0)), **about_z),
            "P": joint("revolute", frame("bar", (0.5, 0, 0)), frame("bob"), **about_z, start={"phi": 0.4}),
        },
        gravity=[0, -GRAVITY, 0],
    )
    assert sizes(source) == (1, 0, 1)
    assert_agree(source)
