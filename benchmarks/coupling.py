# SPDX-License-Identifier: BSD-3-Clause
"""Measure what a co-simulation master costs in accuracy: docs/coupling.md, `make coupling`.

A force law, or a controller, is closed by the master around an FMU: with its value held during a
communication step, with its first time derivative, with two, or inside the scene as a law. The plant itself
is at a tolerance of 1e-11, so that the errors are those of the coupling.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

import gelenk
from gelenk.chart.style import save

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "coupling.md"
PICTURE = ROOT / "docs" / "pictures" / "coupling.png"
BEGIN = "<!-- table: made by benchmarks/coupling.py -->\n"
END = "<!-- end of table -->"
TOLERANCE = 1e-11
STEPS = (1e-1, 5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4)  # s
SHOWN = (1e-2, 1e-3)
WAYS = ("held", "first derivative", "second derivative", "inside")
COLORS = {"held": "#D55E00", "first derivative": "#E69F00", "second derivative": "#009E73", "inside": "black"}
LINES = {"held": "-", "first derivative": "--", "second derivative": "-.", "inside": "-"}
LABELS = {
    "held": "held in each step",
    "first derivative": "with its first derivative",
    "second derivative": "with two derivatives",
    "inside": "a law of the scene",
}
FLOOR = 1e-12  # errors below are drawn here: rounding, and the accuracy of the reference
DIVERGED = 2.0  # rad, m
MARKERS = {"held": "s", "first derivative": "^", "second derivative": "D", "inside": "o"}


@dataclass(frozen=True)
class Loop:
    """A plant with one input, and the law that a master closes."""

    name: str
    title: str
    scene: dict[str, Any]  # with the input
    joint: str  # along which the force acts
    effort: str  # the law as an expression of the scene
    motor: str  # its input
    watched: str  # the output whose error counts
    unit: str
    stop: float  # s
    #: Value and first two time derivatives of the force, from t and those of position and speed.
    law: Callable[[float, Sequence[float], Sequence[float]], tuple[float, float, float]]

    @property
    def position(self) -> str:
        """Name of the coordinate of the joint."""
        return f"{self.joint}.{'phi' if self.unit == 'rad' else 's'}"

    @property
    def speed(self) -> str:
        """Name of its speed."""
        return f"{self.joint}.{'w' if self.unit == 'rad' else 'v'}"

    def inside(self) -> dict[str, Any]:
        """Return the scene with the law in place of the input."""
        joints = {**self.scene["joints"]}
        joints[self.joint] = {**joints[self.joint], "law": {"effort": self.effort}}
        return {**{k: v for k, v in self.scene.items() if k != "motors"}, "joints": joints}


def servo() -> Loop:
    scene = gelenk.load(ROOT / "scenes" / "four_bar.yaml").to_dict()
    stiffness, damping, target = 120.0, 12.0, 0.6  # N m/rad, N m s/rad, rad

    def law(_t: float, phi: Sequence[float], w: Sequence[float]) -> tuple[float, float, float]:
        return (
            stiffness * (target - phi[0]) - damping * w[0],
            -stiffness * phi[1] - damping * w[1],
            -stiffness * phi[2] - damping * w[2],
        )

    return Loop(
        "servo", "PD servo of a four-bar", scene, "A",
        f"{stiffness}*({target} - phi) - {damping}*w", "drive.tau", "A.phi", "rad", 1.0, law,
    )  # fmt: skip


def gas_spring() -> Loop:
    force, stroke = 400.0, 0.1  # N at s = 0; m
    scene: dict[str, Any] = {
        "gelenk": 1,
        "bodies": {"piston": {"mass": 2.0}},
        "joints": {
            "P": {"type": "prismatic", "axis": [0, 0, 1], "parent": "ground", "child": "piston",
                  "start": {"s": 0.05, "fixed": True}, "damping": 5.0},
        },
        "gravity": [0, 0, -9.81],
        "motors": {"gas": {"joint": "P"}},
    }  # fmt: skip
    n = 1.3

    def law(_t: float, s: Sequence[float], _v: Sequence[float]) -> tuple[float, float, float]:
        # f = F (stroke / (stroke + s))^n - F0, of which the weight is held at s = 0.
        x = max(stroke + s[0], 1e-3)  # a run that diverges passes through the cylinder's end
        f = force * (stroke / x) ** n
        return f - force + 2 * 9.81, -n * f / x * s[1], n * f / x * ((n + 1) * s[1] ** 2 / x - s[2])

    return Loop(
        "gas_spring", "gas spring", scene, "P",
        f"{force}*({stroke}/({stroke} + s))^{n} - {force} + {2 * 9.81}", "gas.f", "P.s", "m", 1.0, law,
    )  # fmt: skip


def stick_slip() -> Loop:
    stiffness, damping, speed = 300.0, 2.0, 0.1  # N/m, N s/m, m/s
    scene: dict[str, Any] = {
        "gelenk": 1,
        "bodies": {"sled": {"mass": 1.0}},
        "joints": {
            "P": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "sled",
                  "start": {"s": 0, "fixed": True},
                  "friction": {"coulomb": 4.0, "static": 6.0, "stribeck": 0.05}},
        },
        "gravity": [0, 0, 0],
        "motors": {"pull": {"joint": "P"}},
    }  # fmt: skip

    def law(t: float, s: Sequence[float], v: Sequence[float]) -> tuple[float, float, float]:
        return (
            stiffness * (speed * t - s[0]) + damping * (speed - v[0]),
            stiffness * (speed - s[1]) - damping * v[1],
            -stiffness * s[2] - damping * v[2],
        )

    return Loop(
        "stick_slip", "drive that sticks and slips", scene, "P",
        f"{stiffness}*({speed}*t - s) + {damping}*({speed} - v)", "pull.f", "P.s", "m", 2.0, law,
    )  # fmt: skip


LOOPS = (servo, gas_spring, stick_slip)


class Master:
    """A co-simulation master that closes the law of a loop around an FMU."""

    def __init__(self, loop: Loop, fmu: Path, folder: Path) -> None:
        self._loop = loop
        description = fmpy.read_model_description(str(fmu))
        self._references = {v.name: v.valueReference for v in description.modelVariables}
        self._inside = loop.motor not in self._references
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(fmu), str(folder)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=loop.name,
        )
        self.slave.instantiate()

    def run(self, step: float, derivatives: int) -> tuple[np.ndarray, float]:
        """Return the watched output at the ends of the steps and the evaluations of a run."""
        slave, of = self.slave, self._references
        slave.reset()
        slave.setupExperiment(tolerance=TOLERANCE)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        found = []
        for k in range(round(self._loop.stop / step)):
            t = k * step
            if not self._inside:
                self._close(t, derivatives)
            slave.doStep(t, step)
            found.append(slave.getReal([of[self._loop.watched]])[0])
        return np.array(found), slave.getReal([of["solver.evaluations"]])[0]

    def _close(self, t: float, derivatives: int) -> None:
        """Set the force and its derivatives; those of the outputs follow from what has been set before."""
        slave, of, loop = self.slave, self._references, self._loop
        names = [of[loop.position], of[loop.speed]]
        states = [[value] for value in slave.getReal(names)]
        for order in range(derivatives + 1):
            if order > 0:
                for state, rate in zip(
                    states, slave.getRealOutputDerivatives(names, [order] * 2), strict=True
                ):
                    state.append(rate)
            known = [state + [0.0] * (3 - len(state)) for state in states]
            value = loop.law(t, *known)[order]
            if order == 0:
                slave.setReal([of[loop.motor]], [value])
            else:
                slave.setRealInputDerivatives([of[loop.motor]], [order], [value])


@dataclass(frozen=True)
class Measured:
    """Of a run."""

    error: float  # largest, in the unit of the watched output
    evaluations: float  # a second


def measured(loop: Loop, steps: Sequence[float] = STEPS) -> dict[str, dict[float, Measured]]:
    """Return errors and evaluations by way and communication step."""
    out: dict[str, dict[float, Measured]] = {way: {} for way in WAYS}
    with tempfile.TemporaryDirectory() as folder:
        masters = {}
        for name, scene in (("outside", loop.scene), ("inside", loop.inside())):
            fmu = gelenk.export_fmu(scene, Path(folder) / f"{name}.fmu")
            masters[name] = Master(loop, fmu, Path(folder) / name)
        fine = min(steps) / 10
        truth, _ = masters["inside"].run(fine, 0)
        for step in steps:
            every = round(step / fine)
            exact = truth[every - 1 :: every]
            for derivatives, way in enumerate(WAYS):
                master = masters["inside" if way == "inside" else "outside"]
                values, evaluations = master.run(step, derivatives)
                error = float(np.abs(values - exact).max())
                out[way][step] = Measured(error, evaluations / loop.stop)
        for master in masters.values():
            master.slave.terminate()
            master.slave.freeInstance()
    return out


def drawn(all_found: dict[str, dict[str, dict[float, Measured]]], loops: Sequence[Loop]) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(1, len(loops), figsize=(4.2 * len(loops), 4.2), sharey=True)
    for ax, loop in zip(axes, loops, strict=True):
        for way in WAYS:
            points = all_found[loop.name][way]
            ax.loglog(
                [1e3 * step for step in points],
                [max(FLOOR, min(10.0, of.error)) for of in points.values()],
                color=COLORS[way], marker=MARKERS[way], linestyle=LINES[way], markersize=5, label=LABELS[way],
            )  # fmt: skip
        ax.set_title(loop.title)
        ax.set_xlabel("communication step [ms]")
        ax.grid(visible=True, which="major", alpha=0.3)
        ax.axhspan(DIVERGED, 30.0, color="0.92")
        ax.text(0.02, 0.965, "diverged", transform=ax.transAxes, fontsize=8, va="center", color="0.3")
        ax.set_ylim(FLOOR / 2, 30)
    axes[0].set_ylabel("largest error [rad, m]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.suptitle(
        "Each derivative that a master sends adds an order; a law inside the scene has no coupling error"
    )
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    save(figure, PICTURE, 110)
    plt.close(figure)


def table(all_found: dict[str, dict[str, dict[float, Measured]]], loops: Sequence[Loop]) -> list[str]:
    head = [f"{way}, {1e3 * step:g} ms" for way in WAYS[:-1] for step in SHOWN]
    lines = [
        "| loop | "
        + " | ".join([*head, f"inside, {1e3 * SHOWN[0]:g} ms", "evaluations a second: inside"])
        + " |",
        "|---" * (len(head) + 3) + "|",
    ]
    for loop in loops:
        found = all_found[loop.name]
        cells = [cell(found[way][step]) for way in WAYS[:-1] for step in SHOWN]
        cells.append(cell(found["inside"][SHOWN[0]]))
        cells.append(f"{found['inside'][SHOWN[0]].evaluations:.0f}")
        lines.append(f"| {loop.title} [{loop.unit}] | " + " | ".join(cells) + " |")
    return lines


def cell(of: Measured) -> str:
    if of.error > DIVERGED:
        return "diverged"
    return f"{of.error:.0e}" if of.error > FLOOR else f"< {FLOOR:.0e}"


def order(found: dict[float, Measured], long: float, short: float) -> float:
    """Return the observed order between two communication steps [s]."""
    return math.log(found[long].error / found[short].error) / math.log(long / short)


def main() -> None:
    loops = [make() for make in LOOPS]
    found = {loop.name: measured(loop) for loop in loops}
    for loop in loops:
        print(
            loop.name,
            {way: f"{order(found[loop.name][way], *SHOWN):.1f}" for way in WAYS[:-1]},
            file=sys.stderr,
        )
    drawn(found, loops)
    lines = table(found, loops)
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after, encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
