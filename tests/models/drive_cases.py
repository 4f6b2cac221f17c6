# SPDX-License-Identifier: BSD-3-Clause
"""A drive as a scene and as a DriveTrain, with inputs that are linear in segments, and runs of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, scene

import gelenk
from models.drive_trains import DriveTrain

INTEGRATORS = ("erk", "cvode", "cvode-adams", "ida", "dirk")


@dataclass(frozen=True)
class Case:
    source: Scene
    inputs: dict[str, int]  # index in `given` by name
    given: Callable[[float], Array]
    segment: float
    segments: int
    start: Array  # speeds of the inertias
    truth: Callable[[], DriveTrain]
    speeds: Callable[[gelenk.Simulation], Array]
    phi: Array | None = None  # angles at the start; None: 0
    jump: float = 0.0  # s: before the end of a segment, where inputs may jump
    positions: Callable[[gelenk.Simulation], Array] | None = None

    def set_inputs(self, simulation: gelenk.Simulation, k: int) -> None:
        """Set the values and rates of a segment."""
        start, end = self.given(k * self.segment), self.given((k + 1) * self.segment - self.jump)
        for name, i in self.inputs.items():
            simulation.set_input(name, float(start[i]))
            simulation.set_input_derivative(name, 1, float((end[i] - start[i]) / self.segment))


def shafts(inertias: dict[str, float], joints: dict[str, Any], **sections: Any) -> Scene:
    return scene(
        {name: body(1, inertia=(0, 0, J)) for name, J in inertias.items()},
        joints,
        gravity=[0, 0, 0],
        **sections,
    )


def backstop(free: str) -> Scene:
    """A mass on a guide with a one-way clutch and a motor; it moves up freely whatever the sign of `free`."""
    up = 1 if free == "positive" else -1
    guide = joint("prismatic", frame("ground"), frame("mass"), axis=[0, 0, up], one_way={"free": free})
    return scene(
        {"mass": body(2.0)},
        {"guide": guide},
        motors={"lift": {"joint": "guide"}},
        gravity=[0, 0, -GRAVITY],
    )


def turning(parent: str, child: str, w: float = 0.0, phi: float = 0.0, **fields: Any) -> dict[str, Any]:
    start = {"phi": phi, "w": w, "fixed": True}
    return joint("revolute", frame(parent), frame(child), start=start, **fields)


def truth_of(case: Case) -> tuple[Array, DriveTrain]:
    """Return angles and speeds at the ends of the segments, and the drive train with its counts."""
    train = case.truth()
    found = train.run(
        case.given, case.segment, case.segments, case.start, phi=case.phi, jump=case.jump
    )  # fmt: skip
    return np.array(list(found)), train


def different(times: list[float]) -> list[float]:
    """Return the instants among these times; nearer than 1e-8 s is the same, and 0 is none."""
    ordered = [0.0, *sorted(times)]
    return [t for before, t in pairwise(ordered) if t - before > 1e-8]


def run(case: Case, integrator: str, tolerance: float) -> tuple[Array, list[float]]:
    """Return the speeds, after positions if the case has them, at the ends of the segments, and the times of
    events.
    """
    simulation = gelenk.Simulation(gelenk.load({**case.source, "solver": {"integrator": integrator}}))
    found = []
    times: list[float] = []
    for k in range(case.segments):
        case.set_inputs(simulation, k)
        if k == 0:
            simulation.initialize(0.0, tolerance)
        simulation.step_to((k + 1) * case.segment)
        times += [t for t, _ in simulation.events]
        speeds = case.speeds(simulation)
        found.append(speeds if case.positions is None else [*case.positions(simulation), *speeds])
    return np.array(found), times
