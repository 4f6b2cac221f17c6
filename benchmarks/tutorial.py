# SPDX-License-Identifier: BSD-3-Clause
"""Draws the figures of the tutorials from the results of the code on these pages: `make tutorial`.

Arguments: pages; none: all of them.
"""

from __future__ import annotations

import contextlib
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from gelenk.chart.style import save
from gelenk.extras import pyplot

ROOT = Path(__file__).resolve().parent.parent
PAGES = {  # page -> its scene file
    "tutorial-lqr": "balancer.yaml",
    "tutorial-wheels": "robot.yaml",
    "tutorial-stiction": "axis.yaml",
    "tutorial-gripper": "gripper.yaml",
    "tutorial-vehicle": "car.yaml",
}
CAR = ROOT / "docs" / "gallery" / "car" / "scene.yaml"
BLUE, RED, GREEN, GRAY = "#0072B2", "#D55E00", "#009E73", "#4B4B4B"
UPPER, LOWER, STICK = 0.25, 0.35, 0.6  # m
PUSHED = (0.5, 0.6)  # s


def computed(page: str) -> dict[str, Any]:
    """Run the code of a page in a temporary folder and return the names that it defines."""
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")

    def blocks(language: str) -> list[str]:
        return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.M)

    names: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        scene = "".join(blocks("yaml")) or CAR.read_text(encoding="utf-8")
        Path(PAGES[page]).write_text(scene, encoding="utf-8")
        for block in blocks("python"):
            exec(compile(block, page, "exec"), names)
    return names


def along(start: np.ndarray, length: float, angle: float) -> np.ndarray:
    end: np.ndarray = start + length * np.array([np.cos(angle), np.sin(angle)])
    return end


def draw_pose(axis: Any, values: dict[str, float]) -> None:
    """Draw the mechanism in its equilibrium pose, x and z in meters."""
    hands = []
    for side, x in (("left", -0.15), ("right", 0.15)):
        motor = np.array([x, 0.0])
        upper = values[f"{side}.phi"]
        elbow = along(motor, UPPER, upper)
        lower = upper + values[f"elbow_{side}.phi"]
        hands.append((along(elbow, LOWER, lower), lower))
        axis.plot(*np.array([motor, elbow, hands[-1][0]]).T, "-", color=GRAY, lw=4, solid_capstyle="round")
        axis.plot(*elbow, "o", color="white", mec=GRAY, ms=6, zorder=3)
        axis.plot(*motor, "o", color=BLUE, ms=13, zorder=3)
    hand, lower = hands[0]
    top = along(hand, STICK, lower + values["foot.phi"])
    axis.plot(*np.array([hand, top]).T, "-", color=RED, lw=4, solid_capstyle="round")
    axis.plot(*hand, "o", color="white", mec=RED, ms=6, zorder=3)
    axis.annotate("push", top, (top[0] - 0.3, top[1]), va="center", arrowprops={"arrowstyle": "->"})
    axis.axhline(-0.03, color=GRAY, lw=1)
    axis.set(aspect="equal", xlim=(-0.5, 0.5), xlabel="x [m]", ylabel="z [m]", title="Equilibrium pose")


def draw_lean(axis: Any, names: dict[str, Any]) -> None:
    runs = (
        ("hard", "1 N", RED, "-"),
        ("calm", "0.5 N", BLUE, "-"),
        ("counted", "0.5 N, encoders only", GREEN, "--"),
    )
    for run, label, color, line in runs:
        axis.plot(names[run]["time"], names["lean"](names[run]), line, color=color, label=label)
    axis.axvspan(*PUSHED, color="#eeeeee")
    axis.legend(title="push for 0.1 s", frameon=False)
    axis.set(xlabel="time [s]", title="Inclination of the stick [degrees]")


def draw_decay(axis: Any, names: dict[str, Any]) -> None:
    """Draw the modal coordinate of the slowest mode over time and the decay predicted by its pole."""
    time = names["calm"]["time"]
    size = abs(names["x"] @ names["left_eigenvector"])
    shown = time > PUSHED[1]
    predicted = names["predicted"].real
    at = int(np.searchsorted(time, 2.0))
    axis.semilogy(time[shown], size[shown], color=BLUE, label="FMU, push of 0.5 N")
    line = size[at] * np.exp(predicted * (time[shown] - time[at]))
    axis.semilogy(time[shown], line, "--", color="black", label=f"predicted, exp({predicted:.2f} t)")
    axis.legend(frameon=False)
    axis.set(xlabel="time [s]", title="Modal coordinate |ξ| of the slowest mode")


def balancer(axes: Any) -> None:
    names = computed("tutorial-lqr")
    draw_pose(axes[0], names["trim"].values)
    draw_lean(axes[1], names)
    draw_decay(axes[2], names)


# --- the robot on two wheels ---


def robot(axes: Any) -> None:
    names = computed("tutorial-wheels")
    for run, label, color in (("near", "from 0.5 m", BLUE), ("far", "from 1 m", RED)):
        axes[0].plot(names[run]["ride.s_x"], names[run]["ride.s_y"], color=color, label=label)
        axes[1].plot(names[run]["time"], names[run]["tyre_right.f_n"], color=color, label=label)
    axes[0].axhline(0, color=GRAY, lw=1)
    axes[0].set(xlabel="x [m]", title="Path to the line, y [m]", xlim=(0, 4))
    axes[0].legend(frameon=False)
    axes[1].axhspan(-40, 0, color="#eeeeee")
    axes[1].text(2.9, -20, "the wheel has lifted off", ha="right", va="center", color=GRAY)
    axes[1].set(xlabel="time [s]", title="Normal force of the right wheel [N]", xlim=(0, 3), ylim=(-40, 80))
    pushed = names["pushed"]
    for name, scale, label, color in (
        ("pitch.phi", 180 / np.pi, "pitch, forward [degrees]", GREEN),
        ("ride.s_x", 100, "x, forward [cm]", BLUE),
        ("ride.s_y", 100, "y, to the left [cm]", RED),
    ):
        axes[2].plot(pushed["time"], scale * pushed[name], color=color, label=label)
    axes[2].axvspan(1.0, 1.2, color="#eeeeee")
    axes[2].legend(frameon=False)
    axes[2].set(xlabel="time [s]", title="Standing, pushed at the left shoulder")


# --- the axis that hunts ---


def error(result: Any) -> Any:
    """Return the distance of the carriage from its final set point in millimeters."""
    return 1e3 * (0.02 - result["guide.s"])


def axis_with_friction(axes: Any) -> None:
    names = computed("tutorial-stiction")
    hunting = names["hunting"]
    shown = (hunting["time"] > 0.4) & (hunting["time"] < 10)
    predicted = 1e3 * names["amplitude"]
    axes[0].plot(hunting["time"][shown], error(hunting)[shown], color=BLUE)
    for y in (-predicted, predicted):
        axes[0].axhline(y, color="black", ls="--", lw=1)
    axes[0].text(9.9, predicted + 0.01, f"predicted: {predicted:.3f} mm", ha="right", va="bottom")
    axes[0].set(xlabel="time [s]", title="PID: position error [mm]", xlim=(0, 10), ylim=(-0.3, 0.3))
    force = hunting["motor.tau"] / names["pitch"]
    axes[1].plot(hunting["time"], force, color=BLUE, lw=1, label="at rest")
    slipping = np.where(hunting["guide.v"] == 0, np.nan, force)
    axes[1].plot(hunting["time"], slipping, color=RED, lw=3, label="slipping")
    for y in (-names["Fs"], names["Fs"]):
        axes[1].axhline(y, color="black", ls="--", lw=1)
    axes[1].text(5.1, names["Fs"] + 4, "static friction", va="bottom")
    axes[1].legend(frameon=False, loc="lower left")
    axes[1].set(xlabel="time [s]", title="PID: force on the carriage [N]", xlim=(5, 10), ylim=(-120, 120))
    for run, label, color in (("coarse", "dead band", BLUE), ("fine", "reset", GREEN)):
        axes[2].plot(names[run]["time"], error(names[run]), color=color, label=label)
    axes[2].axvspan(4.0, 4.1, color="#eeeeee")
    axes[2].legend(frameon=False, loc="lower right")
    axes[2].annotate("push", (3.95, -0.9), (2.2, -0.9), va="center", arrowprops={"arrowstyle": "->"})
    axes[2].set(xlabel="time [s]", title="Both cures: position error [mm]", xlim=(0, 8), ylim=(-1.4, 0.8))


# --- the gripper ---


def gripper(axes: Any) -> None:
    names = computed("tutorial-gripper")
    predicted = names["predicted"]
    axes[0].plot(names["begin"] + predicted.t, 1e3 * predicted.y[0], "--", color="black", label="predicted")
    runs = (("weak", "0.9 of the required grip", RED), ("careful", "with the reflex", BLUE))
    for run, label, color in runs:
        axes[0].plot(names[run]["time"], names["slip"](names[run]), color=color, label=label)
        axes[1].plot(names[run]["time"], names[run]["left_grip.f"], color=color, label=label)
        axes[2].plot(
            names[run]["time"], 1e3 * (names[run]["place.r[3]"] - 0.03), color=color, label=f"box, {label}"
        )
    axes[0].set(xlabel="time [s]", title="Slip in the jaws [mm]", xlim=(0.2, 0.8))
    axes[1].axhline(names["needed"], color="black", ls="--", lw=1)
    axes[1].text(1.19, names["needed"] + 0.02, "needed", ha="right", va="bottom")
    axes[1].set(xlabel="time [s]", title="Force of each jaw [N]", ylim=(6, 8))
    axes[2].plot(names["weak"]["time"], 1e3 * names["weak"]["lift.s"], color=GRAY, ls=":", label="palm")
    axes[2].set(xlabel="time [s]", title="Height [mm]")
    for axis in axes:
        axis.legend(frameon=False, fontsize=8)


# --- the car ---


def car(axes: Any) -> None:
    names = computed("tutorial-vehicle")
    dry = names["dry"]
    target = [names["path"](time)[0] for time in dry["time"]]
    axes[0].plot(dry["ride.s_x"], target, "--", color="black", label="target")
    for run, label, color in (
        ("dry", "friction 1", BLUE), ("snow", "friction 0.35", GREEN), ("ice", "friction 0.30", RED)
    ):  # fmt: skip
        axes[0].plot(names[run]["ride.s_x"], names[run]["ride.s_y"], color=color, label=label)
    axes[0].set(xlabel="x [m]", title="Path, y [m]", xlim=(40, 200), ylim=(-1, 7))
    for name, label, color in (
        ("tire_fl", "front left", BLUE), ("tire_fr", "front right", RED), ("tire_rl", "rear left", GREEN)
    ):  # fmt: skip
        axes[1].plot(dry["time"], 1e-3 * dry[f"{name}.f_n"], color=color, lw=1, label=label)
    axes[1].annotate("bump", (0.95, 8.5), (1.6, 8.5), va="center", arrowprops={"arrowstyle": "->"})
    axes[1].set(xlabel="time [s]", title="Friction 1: loads of tires [kN]", xlim=(0, 6), ylim=(0, 10))
    axes[2].plot(dry["time"], dry["ride.v_x"], color=BLUE, label="speed [m/s]")
    axes[2].plot(dry["time"], dry["engine.tau"], color=RED, label="torque of the engine [N m]")
    axes[2].axvspan(7, 15, color="#eeeeee")
    axes[2].text(11, 12, "uphill, 5 %", ha="center")
    axes[2].set(xlabel="time [s]", title="Friction 1: speed and torque", xlim=(0, 15), ylim=(0, 40))
    for axis in axes:
        axis.legend(frameon=False, fontsize=8)


def main() -> None:
    pages = (
        ("tutorial-lqr", balancer),
        ("tutorial-wheels", robot),
        ("tutorial-stiction", axis_with_friction),
        ("tutorial-gripper", gripper),
        ("tutorial-vehicle", car),
    )
    wanted = sys.argv[1:] or PAGES
    for page, draw in pages:
        if page not in wanted:
            continue
        figure, axes = pyplot().subplots(1, 3, figsize=(12, 4), width_ratios=(0.8, 1.2, 1))
        draw(axes)
        for axis in axes:
            axis.grid(alpha=0.25)
        figure.tight_layout()
        picture = ROOT / "docs" / "pictures" / f"{page}.png"
        save(figure, picture, 100)
        print(picture)


if __name__ == "__main__":
    main()
