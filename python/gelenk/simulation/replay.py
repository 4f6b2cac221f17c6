# SPDX-License-Identifier: BSD-3-Clause
"""The motion of a result: poses of bodies from the joint coordinates that it contains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gelenk.errors import AssemblyError, UsageError
from gelenk.model.scene import Scene, load
from gelenk.model.skeleton import joint_kind, loop_joints
from gelenk.model.values import Value, start_parameter
from gelenk.simulation.recording import Recording, frame_rows, poses_of
from gelenk.simulation.result import Result
from gelenk.simulation.simulation import Simulation

MAX_FRAMES = 300  # some milliseconds each, in which the loops are closed
MAX_LISTED = 5


def replayed(scene: Scene, result: Result) -> Recording:
    """Return the motion of a result, whose loops are closed again in each frame.

    Args:
        scene: the mechanism, with the parameters of the run.
        result: with the coordinates of all joints but those that close loops.

    Raises:
        UsageError: a coordinate is missing, or the loops cannot be closed, as with another scene.
    """
    data = scene.to_dict()
    bare = load(
        {key: value for key, value in data.items() if key not in ("sensors", "parameters", "outputs")}
    )
    coordinates = _coordinates(data, result)
    free: dict[str, Value] = {
        name: False for name, value in bare.parameters.items() if name.endswith(".fixed") and value is True
    }
    rows = frame_rows(len(result), MAX_FRAMES)
    poses = np.empty((len(rows), len(data["bodies"]), 7))
    for k, row in enumerate(rows):
        starts: dict[str, Value] = {start_parameter(name): float(result[name][row]) for name in coordinates}
        plant = Simulation(bare.with_parameters(starts | free))
        try:
            plant.initialize()
        except AssemblyError as e:
            raise UsageError(
                f"the result is not one of this scene: at t = {result.time[row]:g} s, {e}"
            ) from None
        poses[k] = poses_of(plant)
    return Recording(data, result.time[rows], poses, result, rows)


def _coordinates(data: Mapping[str, Any], result: Result) -> list[str]:
    """Return the names of the joint coordinates in a result.

    Raises:
        UsageError: some are missing on which positions depend.
    """
    found, missing = [], []
    loops = loop_joints(data)
    for name, joint in data["joints"].items():
        own = [f"{name}.{q}" for q in joint_kind(joint)["q"]]
        if all(q in result.names for q in own):
            found += own
        elif name not in loops:
            missing.append(name)
    if missing:
        more = f" and {len(missing) - MAX_LISTED} more" if len(missing) > MAX_LISTED else ""
        raise UsageError(
            f"found no coordinates of {', '.join(missing[:MAX_LISTED])}{more} in the result, from which its "
            "motion could be shown; record all outputs, or view the scene"
        )
    return found
