# SPDX-License-Identifier: BSD-3-Clause
"""A mode's shape as a moving picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import AssemblyError, UsageError
from gelenk.extras import pyplot
from gelenk.modal.mode import Mode
from gelenk.modal.posing import Pose, Posed

type Array = NDArray[np.float64]

FRAMES, RATE = 40, 25  # of a period; 1/s
RIM, AXLE = 49, [0, 1, 0]  # points of a wheel's rim; its axis where none is given
NEGLIGIBLE = 1e-9  # mass, of the largest: of bodies that are there to carry joints
SEEN_ANGLE, SEEN_SHARE = 0.3, 0.2  # rad, of the mechanism's size: how far shapes are drawn
INK, GHOST, EARTH, WIRE = "#263240", "#c9d3de", "#828282", "#b0621e"
WRITERS = {".gif": "pillow", ".mp4": "ffmpeg", ".html": "html"}


@dataclass(frozen=True)
class _Part:
    """A line: points in bodies, as (body, position in it); the ground is body ""."""

    points: list[tuple[str, Array]]
    colour: str
    marker: str = ""
    width: float = 3.0


def animate(at: Posed, mode: Mode, file: Path, amplitude: float | None = None) -> Path:
    """See `gelenk.modal.Modes.animate`."""
    if file.suffix not in WRITERS:
        raise UsageError(f"{file}: found {file.suffix or 'no ending'}, expected .gif, .html or .mp4")
    moving = {name: x for name, x in mode.shape.items() if at.units.get(name, "rad") in ("rad", "m")}
    if not moving:
        raise UsageError(f"mode {mode.number}: a speed that is kept, no shape to be drawn")
    still = at.poses({})
    parts = _parts(at)
    size = _size([_placed(part, still) for part in parts])
    if amplitude is None:
        amplitude = _seen(at, moving, size)
    if not (np.isfinite(amplitude) and amplitude > 0):
        raise UsageError(f"amplitude: found {amplitude}, expected more than 0")
    try:
        frames = [
            at.poses({name: amplitude * float((x * turn).real) for name, x in moving.items()})
            for turn in np.exp(2j * np.pi * np.arange(FRAMES) / FRAMES)
        ]
    except AssemblyError as e:
        raise UsageError(f"amplitude: {amplitude:.4g} is too much: {e}") from e
    _write(at, mode, file, parts, still, frames)
    return file


def _seen(at: Posed, moving: Mapping[str, complex], size: float) -> float:
    room = {"rad": SEEN_ANGLE, "m": SEEN_SHARE * size}
    reach = (room[at.units.get(name, "rad")] / abs(x) for name, x in moving.items() if abs(x) > 0)
    return float(min(reach))


def _placed(part: _Part, poses: Mapping[str, Pose]) -> Array:
    """Shape (points, 3) [m] in the world."""
    out = []
    for body, p in part.points:
        R, origin = poses.get(body, (np.eye(3), np.zeros(3)))
        out.append(R @ p + origin)
    return np.array(out)


def _size(lines: Sequence[Array]) -> float:
    points = np.vstack(lines)
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) or 1.0


def _parts(at: Posed) -> list[_Part]:
    """Bodies as lines between where joints and springs take hold; supports; springs."""
    joints, springs = _joints(at), _springs(at)
    bodies = at.data["bodies"]
    ends = [_point(end) for pair in (*joints, *springs) for end in pair]
    wheels = _wheels(at)
    heavy = NEGLIGIBLE * max(body["mass"] for body in bodies.values())
    out = [_Part([_point(a), _point(b)], GHOST, width=1.0) for a, b in joints]
    out += [_Part([(body, p)], EARTH, "^") for body, p in ends if body not in bodies]
    out += [_Part([_point(a), _point(b)], WIRE, width=1.5) for a, b in springs]
    for name, body in bodies.items():
        marks = [p for owner, p in ends if owner == name]
        out += _body(name, body, marks, alone=body["mass"] > heavy and name not in wheels)
    return out + [_wheel(row) for row in wheels.values()]


def _joints(at: Posed) -> list[tuple[Any, Any]]:
    """Their frames in both bodies; without those that hold nothing."""
    return [
        (joint["parent"], joint["child"])
        for name, joint in at.data["joints"].items()
        if not {f"{name}.r[1]", f"{name}.Q[1]"} <= {*at.values}
    ]


def _springs(at: Posed) -> list[tuple[Any, Any]]:
    """And whatever else acts between two points."""
    forces = at.data.get("forces", {}).values()
    return [(force["from"], force["to"]) for force in forces if {"from", "to"} <= {*force}]


def _body(name: str, body: Mapping[str, Any], marks: Sequence[Array], alone: bool) -> list[_Part]:
    """Its centre of mass, and a line through the marks; axes of what has none to be seen by, if `alone`."""
    com = np.array(body["com"], float)
    lines: list[list[Array]] = []
    if marks and any(np.linalg.norm(p - marks[0]) > 1e-9 for p in (*marks, com)):
        back = [com] if len(marks) == 1 else marks[:1] if len(marks) > 2 else []
        lines.append([*marks, *back])
    elif alone:
        lines += [[com - axis, com + axis] for axis in _axes(body)]
    return [_Part([(name, com)], INK, "o"), *(_Part([(name, p) for p in line], INK) for line in lines)]


def _axes(body: Mapping[str, Any]) -> Array:
    """As long as the body is thick, so that it is seen to turn; none of a point."""
    radius = float(np.sqrt(sum(body["inertia"][:3]) / 2 / (body["mass"] or 1.0)))
    return np.eye(3)[: 3 if radius else 0] * radius


def _wheels(at: Posed) -> dict[str, Mapping[str, Any]]:
    """By their bodies: discs, whatever holds them, as constraints about an axis of one body have them."""
    constraints = at.data.get("constraints", {}).values()
    return {row["body"]: row for row in constraints if {"body", "axis", "radius"} <= {*row}}


def _wheel(row: Mapping[str, Any]) -> _Part:
    """Its rim, closed, and back to the hub along a spoke."""
    axis, centre = (
        np.array(row.get(key, given), float) for key, given in (("axis", AXLE), ("position", 3 * [0]))
    )
    across = np.linalg.svd(axis[None])[2][1:]
    turn = np.linspace(0, 2 * np.pi, RIM)
    rim = centre + row["radius"] * np.column_stack([np.cos(turn), np.sin(turn)]) @ across
    return _Part([(row["body"], p) for p in (*rim, centre)], INK, width=2.0)


def _point(end: Mapping[str, Any]) -> tuple[str, Array]:
    return end["body"], np.array(end["position"], float)


def _view(points: Array, gravity: Sequence[float]) -> Array:
    """Directions of the picture's axes in the world, shape (2, 3): of what is flat, those of its plane."""
    up = -np.array(gravity, float)
    up = up / np.linalg.norm(up) if up.any() else np.array([0.0, 0.0, 1.0])
    _, extent, V = np.linalg.svd(points - points.mean(axis=0), full_matrices=True)
    flat = len(extent) < 3 or extent[2] < 1e-6 * max(extent[0], 1e-300)
    towards = V[2] if flat and extent[1] > 1e-6 * extent[0] else np.array([0.5, -0.8, 0.45])
    if flat and towards @ [0.5, -0.8, 0.45] < 0:
        towards = -towards
    towards = towards / np.linalg.norm(towards)
    if abs(up @ towards) > 0.99:
        up = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    up = up - (up @ towards) * towards
    up /= np.linalg.norm(up)
    return np.array([np.cross(up, towards), up])


def _write(
    at: Posed, mode: Mode, file: Path, parts: list[_Part], still: Mapping[str, Pose],
    frames: Sequence[Mapping[str, Pose]],
) -> None:  # fmt: skip
    plt = pyplot()
    from matplotlib import animation

    everywhere = [np.array([_placed(part, poses) for poses in (*frames, still)]) for part in parts]
    points = np.vstack([line.reshape(-1, 3) for line in everywhere])
    view = _view(points, at.data.get("gravity", [0, 0, 0]))
    flat = points @ view.T
    figure, axis = plt.subplots(figsize=(4.8, 3.6), dpi=100)
    room = 0.08 * max(float(np.ptp(flat, axis=0).max()), 1e-9)
    axis.set(xlim=(flat[:, 0].min() - room, flat[:, 0].max() + room),
             ylim=(flat[:, 1].min() - room, flat[:, 1].max() + room), aspect="equal")  # fmt: skip
    axis.set_axis_off()
    axis.set_title(_title(at, mode), fontsize=9)
    lines = []
    for part, line in zip(parts, everywhere, strict=True):
        seen = line @ view.T
        axis.plot(*seen[-1].T, color=GHOST, marker=part.marker, linewidth=part.width, zorder=1)
        lines.append(axis.plot([], [], color=part.colour, marker=part.marker, linewidth=part.width)[0])

    def show(k: int) -> list[Any]:
        for drawn, line in zip(lines, everywhere, strict=True):
            drawn.set_data(*(line[k] @ view.T).T)
        return lines

    film = animation.FuncAnimation(figure, show, frames=FRAMES, interval=1000 / RATE, blit=False)
    try:
        _save(film, file, animation)
    finally:
        plt.close(figure)


def _save(film: Any, file: Path, animation: Any) -> None:
    if file.suffix == ".html":
        file.write_text(film.to_jshtml(fps=RATE, default_mode="loop"), encoding="utf-8")
        return
    writer = WRITERS[file.suffix]
    if not animation.writers.is_available(writer):
        raise UsageError(f"{file}: {file.suffix} is written by {writer}, which is not installed")
    film.save(str(file), writer=animation.writers[writer](fps=RATE))


def _title(at: Posed, mode: Mode) -> str:
    what = f"{mode.frequency:.4g} rad/s, {mode.kind}" if mode.frequency else mode.kind
    return f"{at.data.get('name', '')}  mode {mode.number}: {what}"
