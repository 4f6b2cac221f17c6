# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.equilibrium as users meet it: names, what cannot be, the command."""

from __future__ import annotations

import json
import math
import zipfile
from pathlib import Path
from typing import Any

import pytest
import warned
from mechanisms import GRAVITY, body, frame, joint, scene
from test_cli import call, faults, told

import gelenk
from gelenk.chart import mechanisms


@pytest.fixture
def cart_pole(root: Path) -> Path:
    return root / "scenes" / "cart_pole.yaml"


@pytest.fixture
def four_bar_by(four_bar: gelenk.Scene, four_bar_fmu: Path, request: pytest.FixtureRequest) -> Any:
    return {"scene": four_bar, "fmu": four_bar_fmu}[request.param]


BOTH = pytest.mark.parametrize("four_bar_by", ["scene", "fmu"], indirect=True)


def refusal(source: Any, **arguments: Any) -> str:
    with pytest.raises(gelenk.EquilibriumError) as told_to_user:
        gelenk.equilibrium(source, **arguments)
    return str(told_to_user.value)


# --- what cannot be ---


def test_a_force_that_nothing_balances_is_refused_with_what_remains(cart_pole: Path, tmp_path: Path) -> None:
    """2 N on 1.2 kg."""
    for source in (cart_pole, gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")):
        assert refusal(source, input_values={"drive.f": 2.0}) == (
            "no equilibrium near this pose; the largest residual acceleration is track.a = 1.66667 m/s2"
        )


def test_too_few_inputs_are_refused_with_what_remains(cart_pole: Path) -> None:
    """The leaning pole falls however the cart is pushed; the push leaves the least squares of both."""
    said = refusal(cart_pole, hold={"hinge.phi": 0.3}, solve_for=["drive.f"])
    assert said == (
        "drive.f cannot hold this pose; the largest residual acceleration is track.a = 2.58195 m/s2"
    )


@BOTH
def test_a_pose_that_is_no_equilibrium_is_refused(four_bar_by: Any) -> None:
    assert refusal(four_bar_by, hold={"A.phi": 0.3}).startswith(
        "the given inputs do not hold this pose; the largest residual acceleration is A.a = -22.3868 rad/s2"
    )


def test_a_torque_beyond_what_gravity_can_balance_is_refused() -> None:
    """Gravity's moment is 2.35 N m at the most: no angle has a sine of more than 1."""
    source = scene(
        {"bob": body(0.8, (0, -0.3, 0), (0.05, 0, 0.05))},
        {"A": joint("revolute", frame("ground"), frame("bob"), axis=[0, 0, 1])},
        gravity=[0, -GRAVITY, 0], motors={"drive": {"joint": "A"}},
    )  # fmt: skip
    said = refusal(source, input_values={"drive.tau": 3.0})
    assert said.startswith("no equilibrium")
    assert "A.a = " in said
    assert gelenk.equilibrium(source, input_values={"drive.tau": 2.3}).residual < 1e-9


@warned.GUESSES
@BOTH
def test_poses_that_the_loop_cannot_take_are_told(four_bar_by: Any) -> None:
    with pytest.raises(
        gelenk.AssemblyError, match=r"loop through C cannot be closed: smallest closure error"
    ):
        gelenk.equilibrium(four_bar_by, hold={"D.phi": 0.5}, solve_for=["drive.tau"])
    with pytest.raises(gelenk.AssemblyError, match=r"cannot be closed"):
        gelenk.equilibrium(four_bar_by, hold={"A.phi": 0.5, "D.phi": 2.5}, solve_for=["drive.tau"])


@BOTH
def test_wrong_names_are_told(four_bar_by: Any) -> None:
    for arguments, sentence in (
        ({"hold": {"A.ph": 0.3}}, "A.ph: no such coordinate; did you mean A.phi or D.phi or C.phi?"),
        (
            {"hold": {"A.w": 0.3}},
            "A.w: found a velocity or part of a quaternion, expected a coordinate of a joint",
        ),
        ({"solve_for": ["drive.ta"]}, "drive.ta: no such input; did you mean drive.tau?"),
        ({"solve_for": ["drive.tau", "drive.tau"]}, "drive.tau: found twice, expected once"),
        ({"hold": {"A.phi": math.inf}}, "A.phi: found inf, expected a finite number"),
        (
            {"at": {"A.pi": 1}},
            "A.pi: no such state, parameter or input; did you mean A.phi or D.phi or C.phi?",
        ),
        ({"at": -1.0}, "at: found -1 s, expected 0 or more"),
    ):
        with pytest.raises(gelenk.UsageError) as told_to_user:
            gelenk.equilibrium(four_bar_by, **arguments)
        assert str(told_to_user.value) == sentence


@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe{", b'{"gelenk": 1, "bodies": ['])
def test_an_fmu_without_a_readable_scene_is_refused(
    content: bytes | None, four_bar_fmu: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(four_bar_fmu) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            if name != "resources/scene.json":
                new.writestr(name, old.read(name))
            elif content is not None:
                new.writestr(name, content)
    with pytest.raises(gelenk.SceneError if content is not None else gelenk.UsageError) as told_to_user:
        gelenk.equilibrium(other)
    if content is None:
        assert str(told_to_user.value) == (
            f"{other}: found an FMU without a scene, expected one that Gelenk has exported"
        )


def test_a_quaternion_is_not_held_by_its_numbers() -> None:
    with pytest.raises(gelenk.UsageError, match=r"tip\.Q\[1\]: found a velocity or part of a quaternion"):
        gelenk.equilibrium(mechanisms.shipped("heavy_top"), hold={"tip.Q[1]": 0.0})


# --- what comes back ---


@BOTH
def test_the_first_pose_decides_which_equilibrium_is_found(four_bar_by: Any) -> None:
    hanging = gelenk.equilibrium(four_bar_by, at={"A.phi": -1.0})
    standing = gelenk.equilibrium(four_bar_by, at={"A.phi": 1.7})
    assert standing.values["A.phi"] - hanging.values["A.phi"] > 1
    for found in (hanging, standing):
        assert found.residual < 1e-9
        assert all(found.values[f"{name}.w"] == 0 for name in "ABCD")


@BOTH
def test_the_first_pose_may_be_one_of_the_motion(four_bar_by: Any) -> None:
    """Speeds there do not count; the pose held is that of the crank then."""
    run = gelenk.simulate(four_bar_by, stop=0.2, inputs={"drive.tau": 3.0})
    phi = float(run["A.phi"][-1])
    found = gelenk.equilibrium(
        four_bar_by, at=0.2, hold={"A.phi": phi}, solve_for=["drive.tau"], input_values={"drive.tau": 3.0}
    )
    assert found.values["A.phi"] == phi
    assert found.values["D.phi"] == pytest.approx(run["D.phi"][-1], abs=1e-9)  # both close the loop
    expected = gelenk.equilibrium(four_bar_by, hold={"A.phi": phi}, solve_for=["drive.tau"])
    assert found.inputs == pytest.approx(expected.inputs, rel=1e-9)


@BOTH
def test_what_is_held_stays_through_a_long_way(four_bar_by: Any) -> None:
    """In steps short enough to stay on the branch: the coupler is above all the way round."""
    for phi in (4.0, 2 * math.pi + 1.0, -5.0):
        found = gelenk.equilibrium(four_bar_by, hold={"A.phi": phi}, solve_for=["drive.tau"])
        assert found.values["A.phi"] == phi
        assert (
            found.inputs
            == gelenk.equilibrium(  # one name may stand alone
                four_bar_by, hold={"A.phi": phi}, solve_for="drive.tau"
            ).inputs
        )
        assert 1 < found.values["D.phi"] < 3  # rad: the rocker swings above, and would below to the negative


def test_parameters_are_part_of_the_point(cart_pole: Path) -> None:
    found = gelenk.equilibrium(
        cart_pole, parameters={"gravity[1]": -1.0, "pole.m": 0.5}, hold={"track.s": 0}, solve_for=["drive.f"]
    )
    assert found.inputs == pytest.approx({"drive.f": 1.5}, rel=1e-12)
    assert found.values["hinge.phi"] == pytest.approx(math.atan2(1.0, 9.81), rel=1e-12)
    assert found.at["pole.m"] == 0.5
    gelenk.linearize(cart_pole, at=found.at)


def test_nothing_that_moves_stands_still() -> None:
    source = scene({"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))})
    assert gelenk.equilibrium(source).residual == 0


# --- the command ---


def test_command_prints_the_equilibrium(cart_pole: Path) -> None:
    lines = told(
        "equilibrium", cart_pole, "--hold", "track.s=0.5", "--solve-for", "drive.f", "--set", "gravity[1]=-1"
    ).splitlines()
    assert lines[0].startswith("CartPole: equilibrium at rest; found in ")
    assert [line.split() for line in lines[2:4]] == [["outputs"], ["track.s", "0.5", "m"]]
    assert lines[-1].split() == ["drive.f", "1.2", "N"]


def test_command_tells_programs_all_digits(four_bar_file: Path, four_bar_fmu: Path) -> None:
    for source in (four_bar_file, four_bar_fmu):
        done = call("equilibrium", source, "--at", "A.phi=-1", "--input", "drive.tau=2", "--json")
        assert done.returncode == 0
        found = gelenk.equilibrium(source, at={"A.phi": -1}, input_values={"drive.tau": 2.0})
        assert json.loads(done.stdout) == found.to_dict()


def test_command_tells_what_is_wrong(cart_pole: Path) -> None:
    assert faults("equilibrium", cart_pole, "--input", "drive.f=2") == [
        "no equilibrium near this pose; the largest residual acceleration is track.a = 1.66667 m/s2"
    ]
    assert faults("equilibrium", cart_pole, "--hold", "hinge.phi") == [
        "--hold hinge.phi: expected NAME=VALUE"
    ]
    assert faults("equilibrium", cart_pole, "--solve-for", "drive.g") == [
        "drive.g: no such input; did you mean drive.f?"
    ]


def test_command_asks_whether_friction_holds(tmp_path: Path) -> None:
    file = tmp_path / "block.yaml"
    source = scene(
        {"block": body(2.0)},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("block"), axis=[0, 0, 1], friction={"coulomb": 20.0}
            )
        },
        gravity=[0, 0, -GRAVITY], name="Block",
    )  # fmt: skip
    file.write_text(json.dumps(source))
    lines = told("equilibrium", file, "--friction", "present").splitlines()
    assert lines[-2:] == ["held", "  S.s  friction 19.62 of 20 N, margin 0.019"]
    assert faults("equilibrium", file, "--friction", "present", "--set", "gravity[3]=-11") == [
        "friction does not hold this pose: S.s would need 22 N, and its limit is 20 N; S.a = -1 m/s2"
    ]


def test_command_finds_steady_motion(tmp_path: Path) -> None:
    """A point on a hinge that a shaft turns: g / l w^2 = cos(tilt); the speed given, or found for a tilt."""
    source = scene(
        {"shaft": body(1.0, (0, 0, 0), (0.1, 0.1, 0.1)), "bob": body(1.0, (0, 0, -0.5))},
        {"S": joint("revolute", frame("ground"), frame("shaft"), axis=[0, 0, 1]),
         "H": joint("revolute", frame("shaft"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.6})},
        gravity=[0, 0, -GRAVITY], name="Bead",
    )  # fmt: skip
    file = tmp_path / "bead.json"
    file.write_text(json.dumps(source))
    lines = told("equilibrium", file, "--steady", "S.w=6").splitlines()
    assert lines[0].startswith("Bead: steady motion, S.phi advances; found in ")
    done = told("equilibrium", file, "--steady", "S.w", "--at", "S.w=4", "--hold", "H.phi=0.9", "--json")
    found = json.loads(done)
    assert found == gelenk.equilibrium(file, steady=["S.w"], at={"S.w": 4}, hold={"H.phi": 0.9}).to_dict()
    assert found["advancing"] == {"S.phi": pytest.approx(math.sqrt(GRAVITY / (0.5 * math.cos(0.9))))}
    assert faults("equilibrium", file, "--steady", "H.w=3") == [
        "the motion does not remain steady: H.a changes at -58.86 rad/s2 per second as H.phi advances"
    ]
