# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of bodies that only have joints and inertia."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array, body, frame, joint, scene

import gelenk
from gelenk.viewer.shapes import Shapes, shapes_of

SIZE = 1.0  # m


def shapes(*args: Any, **fields: Any) -> dict[str, Shapes]:
    return shapes_of(gelenk.load(scene(*args, **fields)).to_dict(), SIZE)


def extent(found: Shapes) -> Array:
    vertices, _ = found.meshes[0]
    return np.ptp(vertices, axis=0)


def volume(found: Shapes) -> float:
    """Of a closed mesh whose triangles are seen counterclockwise from outside."""
    vertices, triangles = found.meshes[0]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_a_body_with_two_joints_is_a_link(four_bar: gelenk.Scene) -> None:
    found = shapes_of(four_bar.to_dict(), SIZE)
    links = [tube for tube in found["coupler"].tubes if not tube["role"]]
    assert [(tube["a"], tube["b"]) for tube in links] == [([0, 0, 0], [1.75, 0, 0])]


def test_a_free_body_is_the_block_of_its_inertia() -> None:
    """Edges 0.2, 0.3 and 0.4 m: Ixx = m (b^2 + c^2) / 12."""
    inertia = tuple(2.0 / 12 * np.array([0.3**2 + 0.4**2, 0.2**2 + 0.4**2, 0.2**2 + 0.3**2]))
    found = shapes(
        {"block": body(2.0, inertia=inertia)}, {"J": joint("free", frame("ground"), frame("block"))}
    )
    assert extent(found["block"]) == pytest.approx([0.2, 0.3, 0.4], rel=1e-12)
    assert volume(found["block"]) == pytest.approx(0.2 * 0.3 * 0.4, rel=1e-12)


def lone(**fields: Any) -> Shapes:
    """The shapes of a free body of 2 kg."""
    return shapes({"body": body(2.0, **fields)}, {"J": joint("free", frame("ground"), frame("body"))})["body"]


@pytest.mark.parametrize(("radius", "length", "spokes"), [(0.2, 0.1, 2), (0.2, 0.39, 2), (0.1, 0.3, 0)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_body_with_the_inertia_of_a_cylinder_is_one(
    axis: int, radius: float, length: float, spokes: int
) -> None:
    """Along its axis m r^2 / 2, across m (3 r^2 + h^2) / 12; a flat one has a spoke on either face."""
    inertia = [2.0 * (3 * radius**2 + length**2) / 12] * 3
    inertia[axis] = 2.0 * radius**2 / 2
    found = lone(inertia=inertia)
    assert found.meshes == []
    cylinder, *marks = found.tubes
    assert cylinder["r"] == pytest.approx(radius, rel=1e-12)
    way = np.abs(np.subtract(cylinder["b"], cylinder["a"]))
    assert way == pytest.approx(length * np.eye(3)[axis], abs=1e-12)
    assert len(marks) == spokes


@pytest.mark.parametrize(("moments", "is_cylinder"), [
    ((1.0, 1.0, 1.0), False),  # a cube
    ((0.08, 0.1, 0.1019), True),  # equal within two digits
    ((0.08, 0.1, 0.1025), False),
    ((0.1, 0.1019, 0.16), True),
    ((0.1, 0.1035, 0.16), False),
])  # fmt: skip
def test_moments_of_a_cylinder_are_equal_within_two_digits(
    moments: tuple[float, ...], is_cylinder: bool
) -> None:
    assert (lone(inertia=moments).meshes == []) == is_cylinder


def test_three_joints_span_a_plate_of_which_all_triangles_face_outwards() -> None:
    corners = [(0.0, 0, 0), (1, 0, 0), (0, 1, 0)]
    bodies = {"plate": body(1.0)} | {f"arm{k}": body(1.0) for k in range(3)}
    joints = {f"J{k}": joint("revolute", frame("plate", p), frame(f"arm{k}")) for k, p in enumerate(corners)}
    joints["F"] = joint("free", frame("ground"), frame("plate"))
    found = shapes(bodies, joints)["plate"]
    assert extent(found) == pytest.approx([1, 1, 0.012])
    assert volume(found) == pytest.approx(0.5 * 0.012)


def test_rounding_removes_no_corner_of_a_plate() -> None:
    """A turned square, some of whose joints lie in line on its edges; 16 joints give its area, 1 m2."""
    turn = 0.7  # rad
    places = [(i / 4, j / 4) for i in range(5) for j in range(5) if {i, j} & {0, 4}]
    corners = [
        (x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), 0) for x, y in places
    ]
    bodies = {"plate": body(1.0)} | {f"arm{k}": body(1.0) for k in range(len(corners))}
    joints = {f"J{k}": joint("revolute", frame("plate", p), frame(f"arm{k}")) for k, p in enumerate(corners)}
    joints["F"] = joint("free", frame("ground"), frame("plate"))
    found = shapes(bodies, joints)["plate"]
    assert volume(found) == pytest.approx(0.012, rel=1e-6)


def test_joints_out_of_one_plane_span_their_hull() -> None:
    """A tetrahedron."""
    corners = [(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    bodies = {"plate": body(1.0)} | {f"arm{k}": body(1.0) for k in range(4)}
    joints = {f"J{k}": joint("revolute", frame("plate", p), frame(f"arm{k}")) for k, p in enumerate(corners)}
    joints["F"] = joint("free", frame("ground"), frame("plate"))
    found = shapes(bodies, joints)["plate"]
    assert volume(found) == pytest.approx(1 / 6)


def test_three_joints_in_line_are_a_link() -> None:
    places = [0.5, 0.0, 1.0]
    bodies = {"bar": body(1.0)} | {f"arm{k}": body(1.0) for k in range(3)}
    joints = {
        f"J{k}": joint("revolute", frame("bar", (x, 0, 0)), frame(f"arm{k}")) for k, x in enumerate(places)
    }
    joints["F"] = joint("free", frame("ground"), frame("bar"))
    found = shapes(bodies, joints)["bar"]
    ends = sorted(tube[end][0] for tube in found.tubes if not tube["role"] for end in "ab")
    assert ends == [0, 1]
    assert found.meshes == []


@pytest.mark.parametrize(("height", "seen"), [(0.0, False), (0.149, False), (0.151, True)])
@pytest.mark.parametrize("joints", [2, 3])
def test_center_of_mass_far_from_the_line_of_the_joints_is_seen(
    height: float, seen: bool, joints: int
) -> None:
    """An inverted pendulum on an axle; 0.15 of the size of the mechanism is far."""
    places = [0.0, 1.0, 0.4][:joints]
    found = shapes(
        {"a": body(1.0, (0.3, 0, height), (0.1, 0.2, 0.25))} | {f"b{k}": body(1.0) for k in range(joints)},
        {f"J{k}": joint("revolute", frame("a", (x, 0, 0)), frame(f"b{k}")) for k, x in enumerate(places)}
        | {"F": joint("free", frame("ground"), frame("a"))},
    )["a"]
    _, *struts = [tube for tube in found.tubes if not tube["role"]]
    assert [(tube["a"], tube["b"]) for tube in struts] == ([([0.3, 0, 0], [0.3, 0, height])] if seen else [])
    assert len(found.meshes) == seen


@pytest.mark.parametrize("name", ["revolute", "prismatic", "universal", "spherical", "cylindrical", "planar"])
def test_joints_have_symbols(name: str) -> None:
    found = shapes({"a": body(1.0)}, {"J": joint(name, frame("ground"), frame("a", (0.1, 0, 0)))})
    symbols = [part for of in found.values() for part in (*of.tubes, *of.balls) if part["role"]]
    assert len(symbols) == {"universal": 2, "cylindrical": 2, "planar": 0}.get(name, 1)
