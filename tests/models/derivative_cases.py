# SPDX-License-Identifier: BSD-3-Clause
"""Scenes whose derivatives are tested, and how to start and compare them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from fmu.plants import crank_rocker, gyroscope
from mechanisms import (
    GRAVITY,
    Scene,
    body,
    four_bar,
    frame,
    frame_sensor,
    joint,
    reaction,
    scene,
    with_sensors,
)

import gelenk
from gelenk.chart import mechanisms
from models.differences import Array
from models.modelica import fourbar1
from models.rods import planar_four_bar, spatial_four_bar

ENERGY = {"type": "energy"}


@dataclass(frozen=True)
class Case:
    make: Callable[[], Scene]
    times: tuple[float, ...] = (0.0, 0.3, 0.7)  # s
    inputs: Mapping[str, float] = field(default_factory=dict)
    step: float = 2e-3  # s, of the finite differences in time


def shipped(name: str) -> Callable[[], Scene]:
    return lambda: mechanisms.shipped(name)


def loaded_cut() -> Scene:
    """A four-bar whose loop-closing joint, at the coupler, has a spring, a damper and a motor."""
    out = four_bar()
    out["joints"]["C"] |= {"stiffness": 20.0, "damping": 0.3, "spring_reference": 0.4}
    out["joints"]["A"]["damping"] = 0.0
    out["motors"] = {
        "drive": {"joint": "B", "gear_ratio": 3.0, "rotor_inertia": 0.02},
        "pull": {"joint": "C"},
    }
    return with_sensors(out, E=ENERGY, tip=frame_sensor("coupler", (0.3, 0.2, 0.1)))


def leaning() -> Scene:
    """A ball in contact with a stop, held by a spring between two points."""
    return scene(
        {"ball": body(1.3)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("ball"),
                axis=[0, 0, 1],
                start={"s": -0.02, "v": 0.4, "fixed": True},
                stop={"lower": 0.0, "stiffness": 520.0, "damping": 3.0},
            )
        },
        gravity=[0, 0, -GRAVITY],
        forces={
            "tie": {
                "type": "spring_damper",
                "from": frame("ground", (0.3, 0, 0.5)),
                "to": frame("ball", (0.05, 0.1, 0)),
                "stiffness": 40.0,
                "damping": 0.8,
                "length": 0.4,
            }
        },
        sensors={"E": ENERGY, "R": reaction("J")},
    )


CASES = {
    "pendulum": Case(shipped("pendulum")),
    "cart-pole": Case(shipped("cart_pole"), inputs={"drive.f": 2.0}),
    "double pendulum": Case(shipped("double_pendulum")),
    "crank-rocker in space": Case(
        lambda: with_sensors(crank_rocker(), f=frame_sensor("coupler", (0.1, 0.2, 0))),
        inputs={"drive.tau": 3.0},
    ),
    "four-bar in its plane": Case(
        lambda: with_sensors(four_bar(), f=frame_sensor("coupler", (0.1, 0.2, 0)), E=ENERGY),
        inputs={"drive.tau": 3.0},
    ),
    "four-bar with a loaded cut": Case(loaded_cut, inputs={"drive.tau": 3.0, "pull.tau": -0.4}, step=1e-3),
    "five-bar": Case(shipped("five_bar")),
    "slider-crank": Case(shipped("slider_crank")),
    "free body": Case(shipped("free_body")),
    "heavy top": Case(shipped("heavy_top"), times=(0.0, 0.05, 0.1), step=5e-4),
    "gyroscope": Case(gyroscope, inputs={"push.f[1]": 0.7, "push.t[3]": -0.02}),
    "rod in a plane": Case(lambda: with_sensors(planar_four_bar(), f=frame_sensor("coupler"))),
    "rod in space": Case(
        lambda: with_sensors(spatial_four_bar(), f=frame_sensor("rod", (0.1, 0, 0.2))), step=1e-3
    ),
    "rod between balls": Case(lambda: spatial_four_bar("spherical"), step=1e-3),
    "spatial four-bar": Case(fourbar1),
    "Bricard's ring": Case(
        lambda: with_sensors(mechanisms.bricard(), P=frame_sensor("rod3"), R=reaction("J4"), E=ENERGY),
        step=1e-2,
    ),
    "Stewart platform": Case(shipped("stewart"), times=(0.0, 0.3)),
    "ball on its stop": Case(leaning, times=(0.0, 0.01), step=1e-3),
}


def started(case: Case, source: Scene, tolerance: float = 1e-11) -> gelenk.Simulation:
    plant = gelenk.Simulation(source)
    plant.initialize(tolerance=tolerance)
    for name, value in case.inputs.items():
        plant.set_input(name, value)
    return plant


def assert_relative(what: str, found: Array, expected: Array, bound: float) -> None:
    """Check that errors are within `bound` times the larger of 1 and the magnitude of each number."""
    error = np.abs(found - expected) / (1 + np.abs(expected))
    assert error.max(initial=0.0) < bound, f"{what}: {error.max():.2e} at {error.argmax()}"
