# SPDX-License-Identifier: BSD-3-Clause
"""Mode shapes in motion: pages, and films of single modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import AssemblyError, UsageError
from gelenk.modal.body_poses import Pose, PoseEvaluator
from gelenk.modal.mode import Mode
from gelenk.model.skeleton import joint_ends, placed, point, springs
from gelenk.simulation.recording import Recording
from gelenk.simulation.result import Result
from gelenk.viewer.data import page_data
from gelenk.viewer.pages import View

type Array = NDArray[np.float64]

FRAMES_PER_PERIOD, FRAME_RATE = 40, 20  # of films: 1, 1/s
PAGE_FRAMES = 24  # per period on a page, which interpolates
MAX_MODES = 30  # on a page
# Default amplitude of the coordinate that reaches its limit first: rad; relative to the size of the
# mechanism.
VISIBLE_ANGLE, VISIBLE_DISPLACEMENT_RATIO = 0.3, 0.2
HALVINGS = 6  # of a default amplitude at which loops cannot be closed
ENDINGS = (".gif", ".html", ".mp4")
STILL = 2.0  # s; shown as the period of a mode that does not oscillate


def animate(at: PoseEvaluator, mode: Mode, file: Path, amplitude: float | None = None) -> Path:
    """Write an animation of a mode shape; see `gelenk.modal.Modes.animate`."""
    if file.suffix not in ENDINGS:
        raise UsageError(f"{file}: found {file.suffix or 'no ending'}, expected .gif, .html or .mp4")
    if not _moving(at, mode):
        raise UsageError(
            f"mode {mode.number}: no mode shape to draw, since no joint is displaced in it: a velocity is "
            "conserved, or only states of elements change"
        )
    if amplitude is not None and not (np.isfinite(amplitude) and amplitude > 0):
        raise UsageError(f"amplitude: found {amplitude}, expected more than 0")
    if file.suffix == ".html":
        return view_of_modes(at, [mode], amplitude).save(file)
    poses = _poses(at, mode, amplitude, FRAMES_PER_PERIOD)
    time = np.arange(FRAMES_PER_PERIOD + 1) / FRAME_RATE
    return View(_data(at, time, poses) | {"caption": _title(at, mode), "periodic": True}).save(
        file, frame_rate=FRAME_RATE, speed=1.0
    )


def view_of_modes(at: PoseEvaluator, modes: Sequence[Mode], amplitude: float | None = None) -> View:
    """Return a page of mode shapes; see `gelenk.modal.Modes.view`."""
    shown = [mode for mode in modes if _moving(at, mode)][:MAX_MODES]
    if not shown:
        raise UsageError("found no mode with a shape to draw: no joint is displaced in any")
    rows: list[dict[str, Any]] = []
    for mode in shown:
        period = 2 * np.pi / mode.eigenvalue.imag if mode.is_oscillatory else STILL
        rows.append({
            "number": mode.number, "label": _label(mode), "text": _text(mode),
            "time": np.linspace(0, period, PAGE_FRAMES + 1),
            "poses": _poses(at, mode, amplitude, PAGE_FRAMES).astype(np.float32),
        })  # fmt: skip
    return View(_data(at, rows[0]["time"], rows[0]["poses"]) | {"modes": rows, "periodic": True})


def _moving(at: PoseEvaluator, mode: Mode) -> dict[str, complex]:
    """Return the part of a mode shape that consists of positions of joints; empty if none of them moves."""
    positions = {
        name: x
        for name, x in mode.shape.items()
        if "." in name and at.units.get(name, "rad") in ("rad", "m")  # states of elements have no point
    }
    return positions if any(abs(x) > 0 for x in positions.values()) else {}


def _poses(at: PoseEvaluator, mode: Mode, amplitude: float | None, frames: int) -> Array:
    """Return the poses of a period, the first frame again at its end, shape (frames + 1, bodies, 7)."""
    moving = _moving(at, mode)
    given = amplitude is not None
    size = amplitude if amplitude is not None else _visible_amplitude(at, moving)
    for attempt in range(HALVINGS + 1):
        try:
            turns = np.exp(2j * np.pi * np.arange(frames) / frames)
            period = [
                _array(at.poses({name: size * float((x * turn).real) for name, x in moving.items()}))
                for turn in turns
            ]
            return np.array([*period, period[0]])
        except AssemblyError as e:
            if given or attempt == HALVINGS:
                raise UsageError(f"amplitude: {size:.4g} is too large: {e}") from e
            size /= 2
    raise AssertionError  # the last attempt returns or raises


def _array(poses: Mapping[str, Pose]) -> Array:
    """Return poses as positions and quaternions (x, y, z, w), shape (bodies, 7)."""
    from scipy.spatial.transform import Rotation

    return np.array([[*p, *Rotation.from_matrix(R).as_quat()] for R, p in poses.values()])


def _visible_amplitude(at: PoseEvaluator, moving: Mapping[str, complex]) -> float:
    limit = {"rad": VISIBLE_ANGLE, "m": VISIBLE_DISPLACEMENT_RATIO * _size(at)}
    amplitudes = (limit[at.units.get(name, "rad")] / abs(x) for name, x in moving.items() if abs(x) > 0)
    return float(min(amplitudes))


def _size(at: PoseEvaluator) -> float:
    """Return the diagonal of the box around the joints, springs and centers of mass [m]."""
    poses = dict(zip(at.data["bodies"], _array(at.poses({})), strict=True))
    places = [point(end) for pair in (*joint_ends(at.data), *springs(at.data)) for end in pair]
    places += [(name, np.array(body["com"], float)) for name, body in at.data["bodies"].items()]
    points = [placed(poses[body][None], p)[0] if body in poses else p for body, p in places]
    return float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0


def _data(at: PoseEvaluator, time: Array, poses: Array) -> dict[str, Any]:
    """Return what pages and films show: the motion, and translucent, the operating point."""
    result = Result([], time[:, None], {})
    data = page_data(Recording(at.data, time, poses, result, np.arange(len(time))))
    rest = np.repeat(_array(at.poses({}))[None], len(time), axis=0)
    keys = ("bodies", "ground", "springs", "colors")
    second = {"name": "operating point", "poses": rest.astype(np.float32), **{k: data[k] for k in keys}}
    return {**data, "second": second}


def _label(mode: Mode) -> str:
    size = f"{mode.natural_frequency:.4g} rad/s, " if mode.natural_frequency else ""
    return f"{size}{mode.kind}"


def _text(mode: Mode) -> str:
    """Return what is known of a mode besides its shape."""
    parts = []
    if mode.natural_frequency:
        parts += [f"{mode.frequency_hz:.4g} Hz", f"damping ratio {mode.damping_ratio:.3g}"]
    if np.isfinite(mode.time_constant):
        parts.append(f"{'grows' if mode.eigenvalue.real > 0 else 'decays'} in {mode.time_constant:.3g} s")
    return ", ".join([*parts, f"mainly {', '.join(mode.names)}"])


def _title(at: PoseEvaluator, mode: Mode) -> str:
    return f"{at.data.get('name', '')}  mode {mode.number}: {_label(mode)}".strip()
