# SPDX-License-Identifier: BSD-3-Clause
"""Poses of bodies if joint coordinates are displaced from an operating point, for animations."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.linear.model import LinearModel
from gelenk.model.rotation import rotated
from gelenk.model.scene import Scene, known_parameters, load
from gelenk.model.values import Value, start_parameter
from gelenk.simulation.derivatives import quaternions_of
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]
type Pose = tuple[Array, Array]  # rotation matrix (3, 3), position (3,) [m] of a body frame in the world


@dataclass(frozen=True)
class PoseEvaluator:
    """Computes the poses of a scene's bodies near an operating point.

    Attributes:
        scene: the scene with the parameters of the operating point, without sensors.
        data: the scene as plain data, with its sensors.
        values: joint coordinates at the operating point, by name [rad, m].
        units: units of the coordinates, including rotation coordinates `J.theta[1..3]`.
    """

    scene: Scene
    data: Mapping[str, Any]
    values: Mapping[str, float]
    units: Mapping[str, str]

    def poses(self, displacements: Mapping[str, float]) -> dict[str, Pose]:
        """Return the poses of all bodies after coordinates are displaced and the loops are closed.

        Args:
            displacements: by coordinate name [rad, m]; coordinates that are not named start at their values
                at the operating point.

        Raises:
            AssemblyError: the loops cannot be closed.
        """
        starts: dict[str, Value] = {}
        for name, value in self.values.items():
            starts[start_parameter(name)] = value + displacements.get(name, 0.0)
        for of in quaternions_of(self.scene):
            if of.Q[0] not in self.values:
                continue
            Q = np.array([self.values[name] for name in of.Q])
            theta = np.array([displacements.get(name, 0.0) for name in of.theta])
            for name, part in zip(of.Q, rotated(Q, theta), strict=True):
                starts[start_parameter(name)] = float(part)
        plant = Simulation(self.scene.with_parameters(starts))
        plant.initialize()
        return {name: plant.pose(name) for name in self.data["bodies"]}


def pose_evaluator(scene: Scene, settings: Mapping[str, Value], model: LinearModel) -> PoseEvaluator:
    """Return an evaluator for the operating point of a linear model.

    Args:
        scene: the scene.
        settings: values of the operating point by name; those that are not parameters are ignored.
        model: linear model at the point, with all outputs of the scene.
    """
    data = copy.deepcopy(scene.with_parameters(known_parameters(scene, settings)).to_dict())
    bare = load({**data, "sensors": {}, "parameters": []})
    values, speeds = {}, {}
    parameters = bare.parameters
    for name, value in zip(model.outputs, model.y0, strict=True):
        if start_parameter(name) not in parameters:
            continue
        if model.units.get(name) in ("rad/s", "m/s"):
            speeds[start_parameter(name)] = 0.0
        else:
            values[name] = float(value)
    not_fixed: dict[str, Value] = {name: False for name in parameters if name.endswith(".fixed")}
    at_rest = {
        name: value for name, value in not_fixed.items() if isinstance(parameters[name], bool)
    } | speeds
    return PoseEvaluator(bare.with_parameters(at_rest), data, values, model.units)
