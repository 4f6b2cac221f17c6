# SPDX-License-Identifier: BSD-3-Clause
"""The scenes of the study and the conditions of their runs; none is chaotic within its duration."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from benchmarks.accuracy import equations
from benchmarks.accuracy import mechanisms as made
from benchmarks.reductions import ball_first, coupled_by_a_rod, on_a_truss, welded_chain

from gelenk.chart import mechanisms as common
from gelenk.chart.case import Array, Case, Jumps, Smooth
from gelenk.chart.mechanisms import Scene, shipped
from gelenk.chart.scenes import FourBarChainTruth, equal_slider_crank_truth, parallelogram_truth

type Truth = Callable[[Array], dict[str, Array]]

INDEPENDENT: dict[str, Truth] = {
    "pendulum": equations.pendulum,
    "double_pendulum": equations.double_pendulum,
    "cart_pole": equations.cart_pole,
}
INPUTS = ("constant", "smooth", "jumping")
GRIDS = ("fine", "middle", "coarse", "irregular", "whole")
FINE = 1e-3  # s, communication step; 10 and 100 times as long for the middle and coarse grids
IRREGULAR = 60  # number of irregular communication steps; the longest is about 100 times the shortest


@dataclass(frozen=True)
class Plant:
    """A scene with its duration [s], and mean, amplitude and rate [rad/s] of each input."""

    name: str
    scene: Scene
    stop: float
    drives: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    truth: Truth | None = None  # closed form for inputs at their means
    fine: float = FINE

    def grid(self, kind: str) -> tuple[float, tuple[float, ...]]:
        """Return (communication step, communication points if these are not equidistant)."""
        steps = {"fine": self.fine, "middle": 10 * self.fine, "coarse": 100 * self.fine}
        if kind in steps:
            return steps[kind], ()
        if kind == "whole":
            return self.stop, ()
        lengths = [100.0 ** ((k * 0.6180339887498949) % 1.0) for k in range(IRREGULAR)]
        whole = sum(lengths)
        points = [self.stop * sum(lengths[: k + 1]) / whole for k in range(IRREGULAR - 1)]
        return self.stop / IRREGULAR, (*points, self.stop)

    def inputs(self, kind: str) -> dict[str, float | Jumps | Smooth]:
        """Return inputs: constant, sines with derivatives, or a new value at each communication point."""
        found: dict[str, float | Jumps | Smooth] = {}
        for name, (mean, amplitude, rate) in self.drives.items():
            wave, jumps = Smooth(mean, amplitude, rate), Jumps(mean, amplitude)
            found[name] = mean if kind == "constant" else wave if kind == "smooth" else jumps
        return found

    def cases(self) -> Iterator[Case]:
        """Yield all test cases, named scene/inputs/grid; `with_saving` derives those that save states."""
        for inputs in INPUTS if self.drives else INPUTS[:1]:
            for grid in GRIDS:
                if inputs != "constant" and grid == "whole":
                    continue  # in one communication step nothing jumps, and a cubic is no good sine
                step, times = self.grid(grid)
                yield Case(
                    f"{self.name}/{inputs}/{grid}", "", self.scene, self.stop, step, self.inputs(inputs),
                    truth=self.truth if inputs == "constant" else None, times=times,
                )  # fmt: skip


def with_saving(case: Case) -> Case:
    """Return the same test case with the state saved at each communication point."""
    return replace(case, name=case.name + "/saved", saved=True)


def _ready() -> Iterator[Plant]:
    """Yield the example scenes of the package."""
    for name, stop, drives in (
        ("pendulum", 3.0, {}),
        ("double_pendulum", 2.0, {}),
        ("free_body", 3.0, {}),
        ("cart_pole", 2.0, {"drive.f": (0.7, 3.0, 6.0)}),
        ("four_bar", 2.0, {"drive.tau": (3.0, 10.0, 9.0)}),
        ("five_bar", 1.0, {"motor_left.tau": (0.004, 0.004, 12.0), "motor_right.tau": (-0.003, 0.003, 17.0)}),
        ("slider_crank", 1.5, {"starter.tau": (1.0, 1.0, 10.0), "gas.f[1]": (-50.0, 100.0, 25.0)}),
        ("stewart", 1.0, {f"drive{i}.f": (80.0 + 3 * i, 40.0, 8.0 + i) for i in range(1, 7)}),
        ("balancing_robot", 0.8, {"motor_left.tau": (0.1, 0.5, 10.0), "motor_right.tau": (0.0, 0.5, 7.0)}),
        ("bicycle", 2.0, {"handlebar.tau": (0.0, 1.0, 5.0)}),
    ):
        yield Plant(name, shipped(name), stop, dict(drives), INDEPENDENT.get(name))
    yield Plant("andrews", shipped("andrews"), 0.03, fine=3e-5)


def _known() -> Iterator[Plant]:
    """Yield scenes of the charts and reductions."""
    top = common.heavy_top
    yield Plant("n-four-bar-1", common.four_bar_chain(1), 2.0, truth=FourBarChainTruth(1, 1.0))
    yield Plant("n-four-bar-3", common.four_bar_chain(3), 2.0, truth=FourBarChainTruth(3, 1.0))
    yield Plant("parallelogram", common.parallelogram(-math.pi / 2, 12.0), 2.0, truth=parallelogram_truth)
    yield Plant(
        "equal-slider-crank", common.equal_slider_crank(0.3, 2.0), 2.0, truth=equal_slider_crank_truth
    )
    yield Plant("bricard", common.bricard(), 2.0)
    yield Plant("governor", made.driven(common.governor(), "S"), 2.0, {"drive.tau": (0.0, 3.0, 5.0)})
    yield Plant("heavy-top", top(150.0), 1.0)
    yield Plant("heavy-top-200", top(200.0), 1.0)
    yield Plant("four-bar-undamped", common.four_bar(), 2.0, {"drive.tau": (0.0, 5.0, 7.0)})
    yield Plant("four-bar-inconsistent", common.contradictory_four_bar(False), 2.0)
    yield Plant("mass-ratio-1e4", common.uneven_four_bar(1e4), 2.0, {"drive.tau": (0.0, 5.0, 7.0)})
    yield Plant("four-bar-stopped", common.stopped_four_bar(), 1.5, {"drive.tau": (3.0, 2.0, 7.0)})
    yield Plant("blocked-crank", common.blocked_crank(), 1.0, {"idle.f": (0.0, 50.0, 9.0)})
    yield Plant("spatial-slider-crank", ball_first(), 2.0)
    yield Plant("massless-coupler", coupled_by_a_rod(), 2.0)
    yield Plant("on-a-truss", on_a_truss(), 2.0)
    yield Plant("welded-chain", welded_chain(6), 2.0)


def _more() -> Iterator[Plant]:
    """Yield scenes with stiff springs, dead centers, six loops, gears, given motions, wheels and stops."""
    torque = {"drive.tau": (0.0, 5.0, 7.0)}
    for name, k, c, phi in (("torsion-overdamped", 2e3, 500.0, 95.0), ("torsion-stiff", 3e4, 3.0, 95.0),
                            ("torsion-soft", 3.0, 0.01, 95.0)):  # fmt: skip
        yield Plant(name, made.torsion_spring(k, c, phi), 1.0, torque, made.torsion_truth(k, c, phi))
    for name, masses in (("two-masses", (1e9, 1e3, 0.0)), ("two-masses-damped", (1e9, 1e3, 2e3))):
        yield Plant(name, made.two_masses(*masses), 0.5, {"drive.f": (0.0, 20.0, 15.0)},
                    made.two_masses_truth(*masses), 5e-4)  # fmt: skip
    yield Plant("stiff-pendulum", made.stiff_pendulum(1e5), 1.0, {"drive.tau": (0.0, 1.0, 7.0)})
    yield Plant("slider-crank-fast", made.slider_crank(30.0), 1.0, {"drive.tau": (0.0, 2.0, 9.0)})
    yield Plant("v6", made.v6(50.0), 0.5, {"drive.tau": (2.0, 10.0, 15.0)}, fine=5e-4)
    yield Plant("chain-6", made.chain(6), 1.0, {"drive.tau": (0.0, 2.0, 7.0)})
    yield Plant("arm-6", made.arm(), 1.0, {"drive.tau": (3.0, 5.0, 7.0)})
    yield Plant("gears", made.gears(), 1.0, {"drive.tau": (0.0, 5.0, 7.0)})
    yield Plant("rack", made.rack(), 2.0, {"drive.f": (0.0, 20.0, 7.0)})
    sine = {"amplitude": 0.6, "frequency": 1.5}
    yield Plant("given-sine", made.given_crank(polynomial=[1.2, 0.5], sine=sine), 2.0)
    yield Plant("given-speed", made.given_crank(speed=8.0), 2.0)
    yield Plant("rolling-disc", made.rolling_disc(), 2.0)
    yield Plant("sleigh", made.sleigh(), 2.0)
    yield Plant("bouncing", made.bouncing(), 1.5)
    yield Plant("pendulum-at-stop", made.pendulum_at_stop(), 2.0, {"drive.tau": (0.0, 0.5, 7.0)})
    yield Plant("springs", made.spring_triangle(), 1.0, {"drive.f": (0.0, 10.0, 9.0)})


def plants() -> list[Plant]:
    """Return all scenes."""
    return [*_ready(), *_known(), *_more()]


QUICK = ("torsion-soft", "two-masses-damped", "pendulum", "four_bar")


def chosen(names: list[str] | None) -> list[Plant]:
    """Return scenes by name; None: all. Raises ValueError: a name is unknown."""
    found = {plant.name: plant for plant in plants()}
    unknown = [name for name in names or [] if name not in found]
    if unknown:
        raise ValueError(f"unknown scene {', '.join(unknown)}; known scenes: {', '.join(found)}")
    return [found[name] for name in names] if names else list(found.values())


def described(plant: Plant) -> Any:
    """Return name, duration and inputs for the page."""
    return plant.name, plant.stop, ", ".join(plant.drives)
