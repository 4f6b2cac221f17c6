# SPDX-License-Identifier: BSD-3-Clause
"""Where a scene's bodies are when its joints are moved a little from a point."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.linear.model import LinearModel
from gelenk.model.rotation import turned
from gelenk.model.scene import Scene, load
from gelenk.model.values import Value, elements, start_parameter
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]
type Pose = tuple[Array, Array]  # rotation matrix (3, 3) and position (3,) [m] of a body's frame in the world


@dataclass(frozen=True)
class Posed:
    """A scene at a point.

    Attributes:
        scene: with its parameters, without sensors.
        data: the scene as plain data.
        values: of the joints' coordinates at the point.
        units: of coordinates, `J.theta[1..3]` among them.
    """

    scene: Scene
    data: Mapping[str, Any]
    values: Mapping[str, float]
    units: Mapping[str, str]

    def poses(self, moved: Mapping[str, float]) -> dict[str, Pose]:
        """Of all bodies where coordinates are moved by so much, and the loops are closed from there.

        Raises:
            AssemblyError: they cannot be closed.
        """
        starts: dict[str, Value] = {}
        for name, value in self.values.items():
            joint, _, component = name.rpartition(".Q[")
            if joint and component == "1]":
                Q = np.array([self.values[n] for n in elements(f"{joint}.Q", 4)])
                theta = np.array([moved.get(n, 0.0) for n in elements(f"{joint}.theta", 3)])
                for n, part in zip(elements(f"{joint}.Q", 4), turned(Q, theta), strict=True):
                    starts[start_parameter(n)] = float(part)
            elif not joint:
                starts[start_parameter(name)] = value + moved.get(name, 0.0)
        plant = Simulation(self.scene.with_parameters(starts))
        plant.initialize()
        return {name: plant.pose(name) for name in self.data["bodies"]}


def posed(scene: Scene, settings: Mapping[str, Value], model: LinearModel) -> Posed:
    """settings: parameters of the point; others in it are of no interest. model: with all outputs."""
    data = copy.deepcopy(scene.with_parameters(_known(scene, settings)).to_dict())
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
    loose: dict[str, Value] = {name: False for name in parameters if name.endswith(".fixed")}
    still = {name: value for name, value in loose.items() if isinstance(parameters[name], bool)} | speeds
    return Posed(bare.with_parameters(still), data, values, model.units)


def _known(scene: Scene, settings: Mapping[str, Value]) -> dict[str, Value]:
    known = scene.parameters
    return {name: value for name, value in settings.items() if name in known}
