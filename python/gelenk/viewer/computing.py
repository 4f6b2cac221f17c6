# SPDX-License-Identifier: BSD-3-Clause
"""Pages that compute: they contain the core as WebAssembly, and the scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.model.skeleton import uniform_gravity
from gelenk.viewer.data import size_of

if TYPE_CHECKING:
    from gelenk.simulation.recording import Recording

MAX_REACH = 60  # frames by which the page knows where the mechanism gets to
MAX_SIGNALS = 60
_CORE = Path(str(files("gelenk") / "runtime" / "wasm32" / "gelenk.wasm.gz"))
FREQUENCY = 1.0  # Hz, at least, of the whole mechanism on the pointer's spring


def has_core() -> bool:
    """Whether this installation has the core as WebAssembly."""
    return _CORE.is_file()


def core_file() -> Path:
    """Return the core as WebAssembly, compressed. Raises UsageError if it has not been built."""
    if not has_core():
        raise UsageError(
            "this installation has no core for pages that compute: "
            "`make page-core` in the repository of gelenk builds and installs it"
        )
    return _CORE


def computing(
    data: Mapping[str, Any], recording: Recording, scene: str, step: float, settings: Mapping[str, float]
) -> dict[str, Any]:
    """Return `gelenk.viewer.data.page_data` of a page that computes.

    Args:
        data: of a run, which determines what the camera shows and how long rails are.
        recording: the run.
        scene: as JSON.
        step: of communication [s].
        settings: values of inputs at the start, in SI units.
    """
    rows = np.unique(np.linspace(0, len(recording.time) - 1, MAX_REACH).round().astype(np.intp))
    signals = [{**row, "values": row["values"][:1]} for row in data["signals"][:MAX_SIGNALS]]
    return {
        **data,
        "time": recording.time[:1],
        "poses": np.asarray(recording.poses[:1], np.float32),
        "signals": signals,
        "events": [],
        "arrows": [],
        "live": True,
        "reach": np.asarray(recording.poses[rows], np.float32),
        "computes": {
            "scene": scene,
            "file": f"{data['name']}.json",
            "step": step,
            "signals": [row["name"] for row in signals],
            "settings": dict(settings),
            **_scales(recording),
        },
    }


def _scales(recording: Recording) -> dict[str, Any]:
    """Return the pointer's spring, and by their units the ranges of sliders whose values are 0."""
    scene = recording.scene
    mass = sum(body["mass"] for body in scene["bodies"].values()) or 1.0  # kg
    size = size_of(recording)  # m
    gravity = float(np.linalg.norm(uniform_gravity(scene)))  # m/s2
    acceleration = max(gravity, size * (2 * math.pi * FREQUENCY) ** 2 / 4)
    speed = 2 * math.sqrt(acceleration * size)
    return {
        "pull": {"mass": mass, "stiffness": 4 * mass * acceleration / size},
        "scales": {
            "m": size,
            "m/s": speed,
            "m/s2": 2 * acceleration,
            "rad": math.pi,
            "rad/s": speed / size * 2,
            "rad/s2": 4 * acceleration / size,
            "N": 2 * mass * acceleration,
            "N.m": mass * acceleration * size,
        },
    }
