# SPDX-License-Identifier: BSD-3-Clause
"""Demonstration: export a four-bar as an FMU, simulate it, and plot the results.

Run as `python -m gelenk.demo [FOLDER]`. The plot requires the extra `charts`.
"""

from __future__ import annotations

import math
import os
import sys
import sysconfig
import time
from importlib import resources
from pathlib import Path

import numpy as np

import gelenk
from gelenk.extras import pyplot
from gelenk.file_writing import writing

STOP, STEP = 5.0, 1e-3  # s
CLOSURE_ERRORS = ("constraints.position", "constraints.velocity")


def torque(t: float) -> float:
    """Return the torque of the crank's motor [N.m]: 3 N m and a sine of 2 N m with a period of 1.5 s."""
    return 3.0 + 2.0 * math.sin(2 * math.pi * t / 1.5)


def main(folder: Path) -> None:
    """Export, simulate and plot the four-bar; write all files to `folder`."""
    try:
        pyplot()
    except gelenk.UsageError as e:
        sys.exit(str(e))
    folder.mkdir(parents=True, exist_ok=True)
    scene = gelenk.load(Path(str(resources.files("gelenk") / "scenes/four_bar.yaml")))
    begun = time.perf_counter()
    fmu = gelenk.export_fmu(scene, folder / f"{scene.name}.fmu")
    exported = time.perf_counter()
    print(f"Exported {scene!r} to {fmu}: {fmu.stat().st_size / 1e6:.2f} MB in {exported - begun:.2f} s.")

    names = [name for joint in "ABCD" for name in (f"{joint}.phi", f"{joint}.w")]
    begun = time.perf_counter()
    result = gelenk.simulate(
        fmu, stop=STOP, step=STEP, inputs={"drive.tau": torque}, outputs=[*names, *CLOSURE_ERRORS]
    )
    took = time.perf_counter() - begun
    csv = folder / "four_bar.csv"
    result.to_csv(csv)
    plot = folder / "four_bar.png"
    draw(result, plot)

    crank = result["A.phi"]
    turns = (crank[-1] - crank[0]) / (2 * math.pi)
    print(f"Simulated the FMU in fmpy for {STOP:g} s in {len(result) - 1} steps of {STEP * 1e3:g} ms, "
          f"with the motor torque 3 N m + 2 N m sin(2 pi t / 1.5 s): {took:.2f} s.")  # fmt: skip
    print(f"The crank rotates from {crank[0]:.4f} rad to {crank[-1]:.4f} rad ({turns:.2f} turns), "
          f"at up to {np.abs(result['A.w']).max():.2f} rad/s.")  # fmt: skip
    print(f"The rocker swings between {result['D.phi'].min():.4f} rad and {result['D.phi'].max():.4f} rad.")
    print(f"Largest closure error of the loop: {result[CLOSURE_ERRORS[0]].max():.1e} m; "
          f"at velocity level: {result[CLOSURE_ERRORS[1]].max():.1e} m/s.")  # fmt: skip
    print(f"Results: {csv}. Plot of the joint states: {plot}.")
    print(*how_to_call("gelenk view", "four_bar.yaml"), sep="\n")


def how_to_call(command: str, scene: str) -> list[str]:
    """Return lines that state how the command `gelenk` is called in this terminal.

    Args:
        command: a command to try.
        scene: the scene of it, one of those in the folder `scenes`.
    """
    scripts = Path(sysconfig.get_path("scripts"))
    scripts = scripts.relative_to(Path.cwd()) if scripts.is_relative_to(Path.cwd()) else scripts
    file = Path("scenes", scene)
    if not file.exists():
        file = Path(str(resources.files("gelenk") / "scenes" / scene))
    lines = [f"Try: {command} {file}"]
    on_path = [Path(folder).absolute() for folder in os.get_exec_path()]
    if sys.prefix != sys.base_prefix and scripts.absolute() not in on_path:
        call = scripts / "activate"
        activate = f"source {call}" if sys.platform != "win32" else str(call)
        lines.insert(0, f"The command gelenk is found after: {activate} (or call {scripts / 'gelenk'})")
    return lines


def draw(result: gelenk.Result, path: Path) -> None:
    """Plot angles, angular velocities and torque over time, as a PNG file.

    Args:
        result: simulation of the four-bar.
        path: file to write.
    """
    plt = pyplot()
    t = result.time
    figure, axes = plt.subplots(4, 1, sharex=True, figsize=(9, 10), layout="constrained")
    labels = {"A": "A crank", "B": "B crank–coupler", "C": "C coupler–rocker", "D": "D rocker"}
    for color, (joint, label) in enumerate(labels.items()):
        turns, swings, speeds = axes[:3]
        style = {"label": label, "color": f"C{color}"}
        if joint in "AB":
            turns.plot(t, result[f"{joint}.phi"] / (2 * math.pi), **style)
        else:
            swings.plot(t, np.degrees(result[f"{joint}.phi"]), **style)
        speeds.plot(t, result[f"{joint}.w"], **style)
    axes[3].plot(t, [torque(x) for x in t], color="black")
    for axis, label in zip(
        axes, ("angle [turns]", "angle [deg]", "angular velocity [rad/s]", "torque [N m]"), strict=True
    ):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        axis.margins(x=0)
    for axis in axes[:3]:
        axis.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    axes[3].set_xlabel("time [s]")
    axes[0].set_title("Four-bar: joint states of the FMU under a time-varying motor torque")
    with writing(path) as file:
        figure.savefig(file, format="png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo"))
