# SPDX-License-Identifier: BSD-3-Clause
"""The code of the tutorials runs as printed, and its results are the numbers on the page."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models.car import axle_loads, car, steering_per_rack
from pages import blocks, create_files, executed

import gelenk

pytestmark = pytest.mark.thorough


@pytest.mark.usefixtures("empty_folder")
@pytest.mark.filterwarnings("error::gelenk.OperatingPointWarning")
def test_tutorial_balances_the_stick(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers of the page, to the digits they have there."""
    names = executed(root / "docs" / "tutorial-lqr.md")
    trim, plant, poles, lean = (names[n] for n in ("trim", "plant", "poles", "lean"))
    assert list(trim.inputs.values())[:2] == pytest.approx([-2.31, 2.84], abs=0.005)  # N m
    assert trim.values["foot.phi"] == pytest.approx(1.06, abs=0.005)
    assert (plant.poles().real > 0).sum() == 3
    assert plant.poles().real.max() == pytest.approx(7.3, abs=0.05)
    slow = min(np.log(poles) / names["step"], key=lambda s: abs(s.real))
    assert (slow.real, abs(slow.imag)) == pytest.approx((-2.3, 1.6), abs=0.05)
    assert "\n6\n" in capsys.readouterr().out  # the rank
    calm, hard, counted = (names[n] for n in ("calm", "hard", "counted"))
    assert abs(lean(calm)).max() == pytest.approx(5.7, abs=0.05)
    assert np.ptp(calm["bottom.r[1]"]) == pytest.approx(0.07, abs=0.005)
    assert abs(lean(calm)[-1]) < 1e-4
    assert abs(lean(hard)).max() == pytest.approx(18.8, abs=0.05)
    assert np.ptp(hard["bottom.r[1]"]) == pytest.approx(0.32, abs=0.005)
    assert abs(lean(hard)[-1]) < 0.1
    assert abs(names["measured"] / names["predicted"] - 1) < 0.01
    assert abs(lean(counted)).max() == pytest.approx(6.1, abs=0.3)  # noise: counts of the encoders
    assert 0.01 < abs(lean(counted)[-200:]).max() < 0.3


def test_scene_of_the_tutorial_with_wheels_is_the_one_of_scenes(empty_folder: Path, root: Path) -> None:
    create_files(root / "docs" / "tutorial-wheels.md", empty_folder)
    ready = gelenk.load(root / "scenes" / "balancing_robot.yaml")
    assert gelenk.load("robot.yaml").to_dict() == ready.to_dict()


@pytest.fixture
def wheels(empty_folder: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """What the code of the tutorial with wheels leaves behind, and in "told" what it printed."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", gelenk.OperatingPointWarning)
        names = executed(root / "docs" / "tutorial-wheels.md")
    assert empty_folder == Path.cwd()
    return names | {"told": capsys.readouterr().out}


def test_tutorial_with_wheels_stands_and_follows_the_line(wheels: dict[str, Any]) -> None:
    """Numbers of the page, to the digits they have there."""
    lines = wheels["told"].splitlines()
    assert lines[0] == str(wheels["plant"].names.states)
    assert float(lines[1]) == pytest.approx(7.3, abs=0.05)
    ranks = [line for line in lines if line in {"6", "7"}]
    assert ranks == ["6", "6", "7", "6"]  # the last one are the states on contacts
    pushed, near = wheels["pushed"], wheels["near"]
    assert np.degrees(abs(pushed["pitch.phi"]).max()) == pytest.approx(14, abs=0.5)
    assert np.degrees(abs(pushed["ride.phi"]).max()) == pytest.approx(6, abs=0.5)
    assert abs(pushed["ride.s_x"]).max() == pytest.approx(0.28, abs=0.005)
    assert pushed["ride.s_x"][-1] == pytest.approx(5e-5, abs=5e-6)
    assert abs(pushed["ride.phi"][-1]) < 1e-6
    assert pushed["ride.s_y"][-1] == pytest.approx(-0.0198, abs=5e-5)
    assert wheels["drive"].inputs["motor_left.tau"] == pytest.approx(0.2, abs=1e-9)
    advancing = {"ride.s_x": 1.0, "hub_left.phi": 10.0, "hub_right.phi": 10.0}
    assert wheels["drive"].advancing == pytest.approx(advancing, rel=1e-9)
    assert wheels["moving"].A[1, 2] == pytest.approx(1, abs=1e-12)
    assert np.degrees(near["ride.phi"].min()) == pytest.approx(-37, abs=0.5)
    assert 0 < near["ride.s_y"][-1] < 1e-5
    poles = np.sort(np.log(wheels["poles"]).real / wheels["step"])
    assert poles == pytest.approx([-60.7, -14.6, -10.7, -4.91, -2.06, -1.66], rel=5e-3)
    seen = float(lines[-8])
    assert seen == pytest.approx(poles[-2], rel=1e-3)


def test_tutorial_with_wheels_balances_on_contacts(wheels: dict[str, Any]) -> None:
    same, _, loads, lean, falls = wheels["told"].splitlines()[-5:]
    assert max(map(float, same.split())) <= 1e-11
    assert [float(load) for load in loads.strip("[]").split(",")] == pytest.approx([45.1, 45.1], abs=0.05)
    assert float(lean) == pytest.approx(0.0039, abs=5e-5)
    assert falls == "True"


def test_tutorial_with_wheels_shows_when_one_lifts_off(wheels: dict[str, Any]) -> None:
    assert wheels["near"]["tyre_right.f_n"].min() == pytest.approx(9.4, abs=0.05)
    assert wheels["far"]["tyre_right.f_n"].min() == pytest.approx(-26, abs=0.5)


@pytest.fixture
def stiction(empty_folder: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """What the code of the tutorial on static friction leaves behind, and in "printed" what it printed."""
    names = executed(root / "docs" / "tutorial-stiction.md")
    assert empty_folder == Path.cwd()
    return names | {"printed": capsys.readouterr().out}


def test_tutorial_on_static_friction_prints_what_it_shows(stiction: dict[str, Any], root: Path) -> None:
    """The lines of the phases at rest, to the last digit but one: times to 2 ms, errors to 2 um."""

    def numbers(text: str) -> list[list[float]]:
        lines = re.findall(r"at rest from +([-.\d]+) s for +([-.\d]+) s, error +([-.\d]+) mm", text)
        return [[float(number) for number in line] for line in lines]

    printed = numbers(stiction["printed"])
    shown = numbers((root / "docs" / "tutorial-stiction.md").read_text(encoding="utf-8"))
    assert len(shown) >= 10
    for line in shown:
        assert any(line == pytest.approx(other, abs=2.1e-3) for other in printed), line


def test_tutorial_on_static_friction_hunts_as_predicted_until_cured(stiction: dict[str, Any]) -> None:
    """Numbers of the page, to the digits they have there."""
    rests, hunting, fine = (stiction[n] for n in ("rests", "hunting", "fine"))
    assert stiction["Kp"] * 0.84e-3 == pytest.approx(80, abs=0.5)  # N
    assert hunting["solver.events"][-1] == 22
    assert len(rests(hunting)) == 11
    amplitude, wait = stiction["amplitude"], stiction["wait"]
    assert 1e3 * amplitude == pytest.approx(0.158, abs=5e-4)
    assert (stiction["slip"], wait) == pytest.approx((0.120, 1.274), abs=5e-4)
    assert amplitude * stiction["M"] * 400 / 30 == pytest.approx(0.166, abs=5e-4)
    late = np.array(rests(hunting)[-5:-1])
    assert 1e-3 * abs(late[:, 2]).mean() == pytest.approx(amplitude, rel=3e-3)
    assert late[:, 1].mean() == pytest.approx(wait, rel=3e-3)
    assert re.findall(r"^\d+$", stiction["printed"], re.MULTILINE) == ["11", "11"]
    (start, duration, error), before = rests(fine)[-1], rests(fine)[-2][2]
    assert start + duration == pytest.approx(15.0, abs=2e-3)
    assert abs(error) < 0.02
    assert abs(error) < 0.6 * abs(before)  # (Fs - Fc) / Fc


@pytest.mark.parametrize(("stribeck", "error"), [(0.002, 0.152), (0.01, 0.0)])
def test_tutorial_on_static_friction_with_a_stribeck_speed(
    stribeck: float, error: float, empty_folder: Path, root: Path
) -> None:
    """The last error of the hunting run, in mm."""
    create_files(root / "docs" / "tutorial-stiction.md", empty_folder)
    scene = (empty_folder / "axis.yaml").read_text(encoding="utf-8")
    changed = scene.replace("static: 80}", f"static: 80, stribeck: {stribeck}}}")
    assert changed != scene
    (empty_folder / "axis.yaml").write_text(changed, encoding="utf-8")
    names: dict[str, Any] = {}
    for block in blocks(root / "docs" / "tutorial-stiction.md", "python")[:2]:
        exec(compile(block, "tutorial-stiction.md", "exec"), names)
    assert abs(0.02 - names["hunting"]["guide.s"][-1]) * 1e3 == pytest.approx(error, abs=1e-3)


def test_tutorial_with_a_gripper(empty_folder: Path, root: Path) -> None:
    """Numbers of the page, to the digits they have there."""
    names = executed(root / "docs" / "tutorial-gripper.md")
    assert empty_folder == Path.cwd()
    slip = names["slip"]
    assert names["a"] == pytest.approx(3.95, abs=0.005)
    assert names["needed"] == pytest.approx(6.88, abs=0.005)
    # Steps of 1 ms solve for velocities to 1e-11 of the largest one.
    assert abs(slip(names["firm"])).max() < 1e-9
    assert 1e3 * names["predicted"].y[0, -1] == pytest.approx(19.67, abs=0.005)
    assert slip(names["weak"])[-1] == pytest.approx(19.64, abs=0.005)
    careful = names["careful"]
    assert slip(careful)[-1] == pytest.approx(0.13, abs=0.005)
    assert careful["left_grip.f"][-1] / names["needed"] == pytest.approx(1.09, abs=0.005)


@pytest.mark.filterwarnings("error::gelenk.OperatingPointWarning")
def test_tutorial_with_a_car(empty_folder: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers of the page, to the digits they have there."""
    names = executed(root / "docs" / "tutorial-vehicle.md")
    assert empty_folder == Path.cwd()
    lines = capsys.readouterr().out.splitlines()
    drag = 0.4 * 25**2 * 0.3 / 9
    assert [names["torque"], drag] == pytest.approx([8.33, 8.33], abs=0.005)
    assert "30 25" in lines
    poles = np.sort_complex(names["lane"].poles())
    assert poles[[0, 2]] == pytest.approx([-15.00 - 12.87j, -1.93 - 5.73j], abs=0.005)
    assert abs(poles[4:]).max() < 1e-5  # a double pole at 0, to the root of rounding
    scene = car()
    assert steering_per_rack(scene) == pytest.approx(7.344, abs=5e-4)
    assert names["K"] == pytest.approx(
        (1 / scene["forces"]["tire_fl"]["cornering_stiffness"]
         - 1 / scene["forces"]["tire_rl"]["cornering_stiffness"]) / 9.81
    )  # fmt: skip
    textbook = names["ratio"] * 25 / (2.7 + names["K"] * 25**2)
    assert [names["yaw_gain"], textbook] == pytest.approx([0.382, 0.390], abs=5e-4)
    front = sum(names["cruising"].values[f"tire_{corner}.f_n"] for corner in ("fl", "fr"))
    assert axle_loads(scene)[0] - front == pytest.approx(53, abs=0.5)
    assert [1 / names["per_torque"], names["phase_margin"]] == pytest.approx([50.1, 79], abs=0.1)
    assert (np.log(names["poles"]) / 0.01).real.max() == pytest.approx(-4.14, abs=0.005)
    assert np.sort(names["closed"].real)[-3:] == pytest.approx([-1.65, -1.65, -0.0133], abs=0.005)


def test_the_car_of_the_tutorial_keeps_its_lane_while_friction_permits(
    empty_folder: Path, root: Path
) -> None:
    """Numbers of the page, to the digits they have there."""
    names = executed(root / "docs" / "tutorial-vehicle.md")
    assert empty_folder == Path.cwd()

    def deviation(run: Any) -> Any:
        return abs(run["ride.s_y"] - [names["path"](time)[0] for time in run["time"]])

    dry, snow, ice = names["dry"], names["snow"], names["ice"]
    assert deviation(dry).max() == pytest.approx(0.22, abs=0.005)
    assert deviation(dry)[-1] < 1e-3
    assert [dry["ride.v_x"].min(), dry["ride.v_x"][-1]] == pytest.approx([24.66, 24.89], abs=0.005)
    assert np.degrees(abs(dry["roll.phi"]).max()) == pytest.approx(3.8, abs=0.05)
    assert all(dry[f"tire_{corner}.f_n"].min() == 0 for corner in names["corners"])
    assert names["width"] / 2 * names["rate"] ** 2 == pytest.approx(2.76, abs=0.005)
    assert deviation(snow).max() == pytest.approx(0.34, abs=0.005)
    assert deviation(ice).max() > 5
    names |= {"duration": 3.5, "rate": np.pi / 3.5}
    assert deviation(names["drive"](0.30)).max() < 0.2


def test_lines_of_the_car_on_the_page_are_those_of_its_scene(root: Path) -> None:
    (piece,) = blocks(root / "docs" / "tutorial-vehicle.md", "text")
    scene = (root / "docs" / "gallery" / "car" / "scene.yaml").read_text(encoding="utf-8")
    assert piece in scene
