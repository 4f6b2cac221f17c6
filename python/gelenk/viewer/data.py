# SPDX-License-Identifier: BSD-3-Clause
"""The data of a viewer's page: shapes, poses, signals and events of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import (
    GROUND,
    axis_of,
    constraining_joints,
    frame_rotation,
    joint_ends,
    loop_joints,
    placed,
    point,
    springs,
    uniform_gravity,
    upwards,
    view_axes,
    wheel_axes,
    wheels,
)
from gelenk.viewer.hatching import add_hatching
from gelenk.viewer.shapes import LINK_RADIUS, Shapes, marks_of, shapes_of, slides

if TYPE_CHECKING:
    from gelenk.simulation.recording import Recording
    from gelenk.viewer.arrows import Arrow

type Array = NDArray[np.float64]

COLORS = ("#4c78a8", "#f28e2b", "#59a14f", "#b07aa1", "#e15759", "#76b7b2", "#9c755f", "#edc948")
GROUND_COLOR = "#8a8f96"
MAX_SIGNALS = 150
SHOWN_SIGNALS = 3  # in plots at first
ROLE_COLORS = {"joint": "#59626e", "loop": "#c2255c"}  # of the symbols of joints
NEGLIGIBLE = 1e-7  # forces and torques, relative to the largest
LARGEST_INTEGER = 32767  # of 16 bits
UNITS = {"N": "N", "N.m": "N m"}
EVENT_KINDS = {"singular": "singular configuration", "end": "the run ended"}  # by what their texts contain
LONGEST = 6.0  # links; in longer mechanisms, links do not become thicker, or pins would cover them
RAIL_RADIUS = 0.4  # in radii of links


def page_data(recording: Recording) -> dict[str, Any]:
    """Return what pages and pictures of a recording show: plain data for JSON, but for arrays."""
    from gelenk import __version__

    scene = recording.scene
    points = _points(recording)
    size = _size(scene, points[0])
    thick = min(size, LONGEST * _link_length(scene, size))
    shapes = shapes_of(scene, thick)
    rails = _add_rails(shapes, recording, thick)
    gravity = uniform_gravity(scene)
    axes, is_flat = view_axes(points.reshape(-1, 3), gravity)
    if is_flat:
        add_hatching(shapes[GROUND], scene, axes, LINK_RADIUS * thick, rails, _springs_on_ground(recording))
    names = list(scene["bodies"])
    return {
        "name": scene.get("name", "") or "mechanism",
        "version": f"Gelenk {__version__}",
        # In space, what is level stays level in all views.
        "up": (axes[1] if is_flat else upwards(gravity)).tolist(),
        "towards": axes[2].tolist(),
        "flat": is_flat,
        "time": np.asarray(recording.time, np.float64),
        "bodies": [
            {"name": name, "color": COLORS[k % len(COLORS)], **_plain(shapes[name])}
            for k, name in enumerate(names)
        ],
        "ground": {"name": GROUND, "color": GROUND_COLOR, **_plain(shapes[GROUND])},
        "poses": np.asarray(recording.poses, np.float32),
        "joints": _joints(scene, names),
        "springs": [{"from": _end(a, names), "to": _end(b, names)} for a, b in springs(scene)],
        **_signals(recording),
        "events": [{"t": t, "text": text, "kind": _kind_of(text)} for t, text in recording.events],
        "arrows": [_arrow(arrow, names) for arrow in _visible(recording.arrows, size)],
        "colors": ROLE_COLORS,
        "frames": _frames(scene, names),
    }


def size_of(recording: Recording) -> float:
    """Return the size of a mechanism at the start of a run [m]."""
    return _size(recording.scene, _points(recording)[0])


def _points(recording: Recording) -> Array:
    """Return centers of mass, joints, ends of springs and rims in the world [m], (frames, points, 3)."""
    scene, names = recording.scene, list(recording.scene["bodies"])
    places = [(name, np.array(body["com"], float)) for name, body in scene["bodies"].items()]
    places += [point(end) for pair in (*joint_ends(scene), *springs(scene)) for end in pair]
    for name, row in wheels(scene).items():
        center, _, across = wheel_axes(row)
        places += [(name, center + sign * row["radius"] * side) for side in across for sign in (-1, 1)]
    frames = len(recording.time)
    out = [
        np.broadcast_to(p, (frames, 3))
        if body == GROUND
        else placed(recording.poses[:, names.index(body)], p)
        for body, p in places
    ]
    return np.stack(out, axis=1)


def _size(scene: Mapping[str, Any], points: Array) -> float:
    """Return the diagonal of the box around points, shape (points, 3), or that of the largest body [m]."""
    extents = [float(np.linalg.norm(np.ptp(points, axis=0)))]
    for body in scene["bodies"].values():
        if body["mass"]:
            extents.append(2 * float(np.sqrt(sum(body["inertia"][:3]) / 2 / body["mass"])))
    return max(extents) or 1.0


def _link_length(scene: Mapping[str, Any], size: float) -> float:
    """Return the median length of bodies with several joints [m]; `size` without any."""
    lengths = [
        float(np.linalg.norm(np.ptp(points, axis=0)))
        for name, points in marks_of(scene).items()
        if name != GROUND and len(points) > 1
    ]
    return float(np.median(lengths)) if lengths else size


def _springs_on_ground(recording: Recording) -> list[tuple[Array, Array]]:
    """Return the end on the ground of each spring, and its other end at the start [m]."""
    names = list(recording.scene["bodies"])

    def in_world(end: Mapping[str, Any]) -> Array:
        body, p = point(end)
        out: Array = p if body == GROUND else placed(recording.poses[:1, names.index(body)], p)[0]
        return out

    pairs = [ends for pair in springs(recording.scene) for ends in (pair, pair[::-1])]
    return [(in_world(end), in_world(other)) for end, other in pairs if point(end)[0] == GROUND]


def _add_rails(shapes: Mapping[str, Shapes], recording: Recording, size: float) -> list[tuple[Array, Array]]:
    """Add the rails on which joints slide, as long as their way in this run; return the ends of those on the
    ground.
    """
    out = []
    names = list(recording.scene["bodies"])
    frames = len(recording.time)
    for joint in recording.scene["joints"].values():
        if not slides(joint):
            continue
        (parent, p_F), (child, p_M) = point(joint["parent"]), point(joint["child"])
        still = np.tile([0.0, 0, 0, 0, 0, 0, 1], (frames, 1))
        of = [still if body == GROUND else recording.poses[:, names.index(body)] for body in (parent, child)]
        axis = axis_of(joint)
        origin, along = placed(of[0], p_F), placed(of[0], p_F + axis) - placed(of[0], p_F)
        way = np.einsum("ij,ij->i", placed(of[1], p_M) - origin, along)
        margin = 0.03 * size
        ends = p_F + axis * min(way.min() - margin, 0.0), p_F + axis * max(way.max() + margin, 0.0)
        shapes[parent].add_tube(*ends, RAIL_RADIUS * LINK_RADIUS * size)
        if parent == GROUND:
            out.append(ends)
    return out


def _joints(scene: Mapping[str, Any], names: list[str]) -> list[dict[str, Any]]:
    driven = {name for motor in scene.get("motors", {}).values() for name in _driven_by(motor)}
    loops = loop_joints(scene)
    return [
        {
            "name": name, "type": joint["type"], "driven": name in driven, "loop": name in loops,
            **_end(joint["parent"], names),
        }
        for name, joint in constraining_joints(scene).items()
    ]  # fmt: skip


def _frames(scene: Mapping[str, Any], names: list[str]) -> list[dict[str, Any]]:
    """Return the frames of bodies, and of joints in both bodies, with their axes as columns."""
    own = [{"name": name, "body": k, "p": [0.0] * 3, "R": np.eye(3).tolist()} for k, name in enumerate(names)]
    return own + [
        {"name": name, **_end(joint[side], names), "R": frame_rotation(joint[side]).tolist(), "joint": True}
        for name, joint in constraining_joints(scene).items()
        for side in ("parent", "child")
    ]


def _visible(arrows: Sequence[Arrow], size: float) -> list[Arrow]:
    """Return the arrows without those that are rounding errors of others."""
    largest = {"N": 0.0, "N.m": 0.0}
    for arrow in arrows:
        largest[arrow.unit] = max(largest[arrow.unit], float(np.abs(np.nan_to_num(arrow.vectors)).max()))
    least = {unit: NEGLIGIBLE * value for unit, value in largest.items()}
    least["N.m"] = max(least["N.m"], NEGLIGIBLE * largest["N"] * size)
    return [arrow for arrow in arrows if np.abs(np.nan_to_num(arrow.vectors)).max() > least[arrow.unit]]


def _arrow(arrow: Arrow, names: list[str]) -> dict[str, Any]:
    """Return an arrow whose components are integers of 16 bits, which are enough for a picture."""
    vectors = np.nan_to_num(arrow.vectors)
    scale = float(np.abs(vectors).max())
    points = arrow.points.tolist() if arrow.points.ndim == 1 else None
    return {
        "name": arrow.name, "kind": arrow.kind, "unit": UNITS[arrow.unit],
        "body": -1 if arrow.body == GROUND else names.index(arrow.body), "p": points,
        "points": None if points else np.asarray(arrow.points, np.float32),
        "scale": scale / LARGEST_INTEGER,
        "vectors": np.rint(vectors * (LARGEST_INTEGER / (scale or 1.0))).astype(np.int16),
    }  # fmt: skip


def _kind_of(event: str) -> str:
    return next((kind for kind, text in EVENT_KINDS.items() if text in event), "event")


def _driven_by(motor: Mapping[str, Any]) -> list[str]:
    joints = motor.get("joints", motor.get("joint", []))
    return [joints] if isinstance(joints, str) else list(joints)


def _end(end: Mapping[str, Any], names: list[str]) -> dict[str, Any]:
    body, p = point(end)
    return {"body": -1 if body == GROUND else names.index(body), "p": p.tolist()}


def _signals(recording: Recording) -> dict[str, Any]:
    """Return the outputs that have a unit of position, speed, force or torque first, up to MAX_SIGNALS."""
    result = recording.result
    order = {"rad": 0, "m": 0, "rad/s": 1, "m/s": 1}
    names = sorted(result.names, key=lambda name: order.get(result.units.get(name, "1"), 2))[:MAX_SIGNALS]
    return {
        "signals": [
            {
                "name": name,
                "unit": result.units.get(name, "1"),
                "values": np.asarray(result[name][recording.rows], np.float32),
            }
            for name in names
        ],
        "shown": names[:SHOWN_SIGNALS],
    }


def _plain(shapes: Shapes) -> dict[str, Any]:
    return {
        "tubes": shapes.tubes,
        "balls": shapes.balls,
        "meshes": [
            {"vertices": np.asarray(vertices, np.float32), "triangles": np.asarray(triangles, np.uint32)}
            for vertices, triangles in shapes.meshes
        ],
    }
