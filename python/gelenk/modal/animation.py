# SPDX-License-Identifier: BSD-3-Clause
"""Animations of mode shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import AssemblyError, UsageError
from gelenk.extras import pyplot
from gelenk.modal.body_poses import Pose, PoseEvaluator
from gelenk.modal.mode import Mode
from gelenk.model.skeleton import joint_ends, point, springs, view_axes, wheel_axes, wheels

type Array = NDArray[np.float64]

FRAMES_PER_PERIOD, FRAME_RATE = 40, 25  # 1, 1/s
RIM_POINTS = 49  # of the polygon that represents a wheel
NEGLIGIBLE_MASS_RATIO = (
    1e-9  # relative to the heaviest body; lighter bodies only connect joints and get no axes
)
# Default amplitude of the coordinate that reaches its limit first: rad; relative to the size of the
# mechanism.
VISIBLE_ANGLE, VISIBLE_DISPLACEMENT_RATIO = 0.3, 0.2
BODY_COLOR, REST_COLOR, GROUND_COLOR, SPRING_COLOR = "#263240", "#c9d3de", "#828282", "#b0621e"
WRITERS = {".gif": "pillow", ".mp4": "ffmpeg", ".html": "html"}


@dataclass(frozen=True)
class _Part:
    """A polyline through points fixed in bodies: (body, position in its frame [m]); the ground is body ""."""

    points: list[tuple[str, Array]]
    color: str
    marker: str = ""
    width: float = 3.0


def animate(at: PoseEvaluator, mode: Mode, file: Path, amplitude: float | None = None) -> Path:
    """Write an animation of a mode shape; see `gelenk.modal.Modes.animate`."""
    if file.suffix not in WRITERS:
        raise UsageError(f"{file}: found {file.suffix or 'no ending'}, expected .gif, .html or .mp4")
    moving = {name: x for name, x in mode.shape.items() if at.units.get(name, "rad") in ("rad", "m")}
    if not moving:
        raise UsageError(f"mode {mode.number}: a conserved velocity, without a mode shape to draw")
    rest = at.poses({})
    parts = _parts(at)
    size = _size([_placed(part, rest) for part in parts])
    if amplitude is None:
        amplitude = _visible_amplitude(at, moving, size)
    if not (np.isfinite(amplitude) and amplitude > 0):
        raise UsageError(f"amplitude: found {amplitude}, expected more than 0")
    try:
        frames = [
            at.poses({name: amplitude * float((x * turn).real) for name, x in moving.items()})
            for turn in np.exp(2j * np.pi * np.arange(FRAMES_PER_PERIOD) / FRAMES_PER_PERIOD)
        ]
    except AssemblyError as e:
        raise UsageError(f"amplitude: {amplitude:.4g} is too large: {e}") from e
    _write(at, mode, file, parts, rest, frames)
    return file


def _visible_amplitude(at: PoseEvaluator, moving: Mapping[str, complex], size: float) -> float:
    limit = {"rad": VISIBLE_ANGLE, "m": VISIBLE_DISPLACEMENT_RATIO * size}
    amplitudes = (limit[at.units.get(name, "rad")] / abs(x) for name, x in moving.items() if abs(x) > 0)
    return float(min(amplitudes))


def _placed(part: _Part, poses: Mapping[str, Pose]) -> Array:
    """Return the points of a part in the world frame, shape (points, 3) [m]."""
    out = []
    for body, p in part.points:
        R, origin = poses.get(body, (np.eye(3), np.zeros(3)))
        out.append(R @ p + origin)
    return np.array(out)


def _size(lines: Sequence[Array]) -> float:
    points = np.vstack(lines)
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) or 1.0


def _parts(at: PoseEvaluator) -> list[_Part]:
    """Return joints, supports, springs and bodies as polylines between the frames of joints and springs."""
    joints = joint_ends(at.data)
    forces = springs(at.data)
    bodies = at.data["bodies"]
    ends = [point(end) for pair in (*joints, *forces) for end in pair]
    rolling = wheels(at.data)
    min_mass = NEGLIGIBLE_MASS_RATIO * max(body["mass"] for body in bodies.values())
    out = [_Part([point(a), point(b)], REST_COLOR, width=1.0) for a, b in joints]
    out += [_Part([(body, p)], GROUND_COLOR, "^") for body, p in ends if body not in bodies]
    out += [_Part([point(a), point(b)], SPRING_COLOR, width=1.5) for a, b in forces]
    for name, body in bodies.items():
        marks = [p for owner, p in ends if owner == name]
        out += _body(name, body, marks, alone=body["mass"] > min_mass and name not in rolling)
    return out + [_wheel(row) for row in rolling.values()]


def _body(name: str, body: Mapping[str, Any], marks: Sequence[Array], alone: bool) -> list[_Part]:
    """Return the center of mass and a polyline through `marks`; inertia axes if `alone` without marks."""
    com = np.array(body["com"], float)
    lines: list[list[Array]] = []
    if marks and any(np.linalg.norm(p - marks[0]) > 1e-9 for p in (*marks, com)):
        back = [com] if len(marks) == 1 else marks[:1] if len(marks) > 2 else []
        lines.append([*marks, *back])
    elif alone:
        lines += [[com - axis, com + axis] for axis in _axes(body)]
    return [
        _Part([(name, com)], BODY_COLOR, "o"),
        *(_Part([(name, p) for p in line], BODY_COLOR) for line in lines),
    ]


def _axes(body: Mapping[str, Any]) -> Array:
    """Return axes of the length of the radius of gyration, which make rotations visible; none for a point
    mass.
    """
    radius = float(np.sqrt(sum(body["inertia"][:3]) / 2 / (body["mass"] or 1.0)))
    return np.eye(3)[: 3 if radius else 0] * radius


def _wheel(row: Mapping[str, Any]) -> _Part:
    """Return the rim of a wheel with one spoke."""
    center, _, across = wheel_axes(row)
    turn = np.linspace(0, 2 * np.pi, RIM_POINTS)
    rim = center + row["radius"] * np.column_stack([np.cos(turn), np.sin(turn)]) @ across
    return _Part([(row["body"], p) for p in (*rim, center)], BODY_COLOR, width=2.0)


def _write(
    at: PoseEvaluator, mode: Mode, file: Path, parts: list[_Part], rest: Mapping[str, Pose],
    frames: Sequence[Mapping[str, Pose]],
) -> None:  # fmt: skip
    plt = pyplot()
    from matplotlib import animation

    everywhere = [np.array([_placed(part, poses) for poses in (*frames, rest)]) for part in parts]
    points = np.vstack([line.reshape(-1, 3) for line in everywhere])
    view = view_axes(points, at.data.get("gravity", [0, 0, 0]))[0][:2]
    flat = points @ view.T
    figure, axis = plt.subplots(figsize=(4.8, 3.6), dpi=100)
    margin = 0.08 * max(float(np.ptp(flat, axis=0).max()), 1e-9)
    axis.set(xlim=(flat[:, 0].min() - margin, flat[:, 0].max() + margin),
             ylim=(flat[:, 1].min() - margin, flat[:, 1].max() + margin), aspect="equal")  # fmt: skip
    axis.set_axis_off()
    axis.set_title(_title(at, mode), fontsize=9)
    lines = []
    for part, line in zip(parts, everywhere, strict=True):
        seen = line @ view.T
        axis.plot(*seen[-1].T, color=REST_COLOR, marker=part.marker, linewidth=part.width, zorder=1)
        lines.append(axis.plot([], [], color=part.color, marker=part.marker, linewidth=part.width)[0])

    def show(k: int) -> list[Any]:
        for drawn, line in zip(lines, everywhere, strict=True):
            drawn.set_data(*(line[k] @ view.T).T)
        return lines

    film = animation.FuncAnimation(
        figure, show, frames=FRAMES_PER_PERIOD, interval=1000 / FRAME_RATE, blit=False
    )
    try:
        _save(film, file, animation)
    finally:
        plt.close(figure)


def _save(film: Any, file: Path, animation: Any) -> None:
    if file.suffix == ".html":
        file.write_text(film.to_jshtml(fps=FRAME_RATE, default_mode="loop"), encoding="utf-8")
        return
    writer = WRITERS[file.suffix]
    if not animation.writers.is_available(writer):
        raise UsageError(f"{file}: {file.suffix} files require {writer}, which is not installed")
    film.save(str(file), writer=animation.writers[writer](fps=FRAME_RATE))


def _title(at: PoseEvaluator, mode: Mode) -> str:
    what = f"{mode.natural_frequency:.4g} rad/s, {mode.kind}" if mode.natural_frequency else mode.kind
    return f"{at.data.get('name', '')}  mode {mode.number}: {what}"
