# SPDX-License-Identifier: BSD-3-Clause
"""Robots from URDF: real ones against Pinocchio, small ones for every corner of the format."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk

pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")

ROBOTS = {
    "panda": "panda_description/urdf/panda.urdf",
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "z1": "z1_description/urdf/z1.urdf",  # with dry friction
}


# Hands with many fingers and dry friction: fingertips leave their limits where an arm slips for an instant.
HANDS = {
    "tiago_pro": "tiago_pro_description/robots/tiago_pro.urdf",
    "talos": "talos_data/robots/talos_reduced.urdf",
}


def robot_file(name: str) -> Path:
    """A URDF of the package example-robot-data."""
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    return Path(str(next(file.locate() for file in files if str(file).endswith((ROBOTS | HANDS)[name]))))


def write(tmp_path: Path, body: str, name: str = "robot") -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<?xml version="1.0"?>\n<robot name="{name}">\n{body}\n</robot>\n')
    return path


LINK = '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'


def link(name: str) -> str:
    return LINK.format(name)


def joint(name: str, kind: str, parent: str, child: str, inside: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'
    )


@pytest.mark.parametrize("name", ROBOTS)
def test_forward_dynamics_of_real_arms_equal_pinocchios(name: str) -> None:
    """Accelerations at 100 random states and torques. 1e-10 relative; measured 2e-14, which is
    round-off in a chain of nine joints. A transposed inertia or rotation gives differences of order one.
    """
    pin = pytest.importorskip("pinocchio", reason="pinocchio (PyPI: pin) is not installed")
    path = robot_file(name)
    scene = gelenk.import_urdf(path, limits=False)  # the random positions are beyond them
    content = scene.to_dict()
    followers = [entry["joint"] for entry in content.pop("constraints", {}).values()]  # free in pinocchio
    content["motors"] |= {f"{name}_motor": {"joint": name} for name in followers}
    scene = gelenk.load(content)
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    names = list(model.names)[1:]
    kinds = scene.to_dict()["joints"]
    damping = np.array([kinds[n].get("damping", 0.0) for n in names])
    friction = np.array([kinds[n].get("friction", {"coulomb": 0.0})["coulomb"] for n in names])
    letters = [
        {"revolute": ("phi", "w", "tau"), "prismatic": ("s", "v", "f")}[kinds[n]["type"]] for n in names
    ]
    at = [model.joints[model.getJointId(n)].idx_v for n in names]
    assert model.nq == model.nv == len(names)
    assert sorted(n for n in kinds if kinds[n]["type"] != "weld") == sorted(names)
    rng = np.random.default_rng(20)
    for _ in range(100):
        q, v, tau = (rng.uniform(-a, a, model.nv) for a in (np.pi, 2.0, 40.0))
        settings: dict[str, Any] = {}
        for n, (x, w, _), i in zip(names, letters, at, strict=True):
            settings |= {f"{n}.{x}_start": q[i], f"{n}.{w}_start": v[i], f"{n}.fixed": True}
        plant = gelenk.Simulation(scene.with_parameters(settings))
        for n, (_, _, effort), i in zip(names, letters, at, strict=True):
            plant.set_input(f"{n}_motor.{effort}", tau[i])
        plant.initialize()
        # aba has neither damping nor friction: they are added as torques
        drag = np.zeros(model.nv)
        drag[at] = damping * v[at] + friction * np.sign(v[at])
        expected = pin.aba(model, data, q, v, tau - drag)[at]
        found = plant.values([f"{n}.a" for n in names])
        assert np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("name", ROBOTS)
def test_real_arms_become_fmus_that_run(name: str, tmp_path: Path) -> None:
    scene = gelenk.import_urdf(robot_file(name))
    fmu = gelenk.export_fmu(scene, tmp_path / f"{name}.fmu")
    result = gelenk.simulate(fmu, stop=0.1)
    assert np.isfinite(result.table.view(float)).all()
    moved = [n for n in result.names if n.endswith(".phi") and abs(result[n][-1]) > 1e-3]
    assert moved  # they fall


def test_panda_tells_what_it_left_out() -> None:
    report = gelenk.import_urdf(robot_file("panda")).report
    assert report[0] == (
        "joint panda_finger_joint2: follows panda_finger_joint1 (mimic) by a constraint, and has no motor"
    )
    assert report[1].startswith("joints with hard limits: panda_joint1, ")
    assert report[2] == "joint panda_joint4: starts at -1.5708 rad, since its limits do not contain 0"
    assert report[3].startswith("limits of velocity and effort are not modeled: panda_joint1, ")
    assert report[4] == "links without mass: panda_link8, panda_hand_tcp"
    assert report[5].startswith("shapes and meshes are not converted: ")


def test_saved_import_is_the_same_scene(tmp_path: Path) -> None:
    scene = gelenk.import_urdf(robot_file("ur5"))
    scene.save(tmp_path / "ur5.yaml")
    assert gelenk.load(tmp_path / "ur5.yaml").to_dict() == scene.to_dict()


def test_root_is_welded_or_floats() -> None:
    welded = gelenk.Simulation(gelenk.import_urdf(robot_file("ur5")))
    floating = gelenk.Simulation(gelenk.import_urdf(robot_file("ur5"), floating=True))
    for plant in (welded, floating):
        plant.initialize()
    assert welded.size.degrees_of_freedom == 6
    assert floating.size.degrees_of_freedom == 12


def test_every_kind_of_joint_has_its_counterpart(tmp_path: Path) -> None:
    kinds = {
        "revolute": "revolute",
        "continuous": "revolute",
        "prismatic": "prismatic",
        "fixed": "weld",
        "floating": "free",
        "planar": "planar",
    }
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    body = link("base") + "".join(link(f"l_{k}") + joint(k, k, "base", f"l_{k}", limit) for k in kinds)
    scene = gelenk.import_urdf(write(tmp_path, body)).to_dict()
    assert {n: scene["joints"][n]["type"] for n in kinds} == kinds
    assert scene["motors"].keys() == {"revolute_motor", "continuous_motor", "prismatic_motor"}
    assert scene["joints"]["revolute"]["axis"] == [1, 0, 0]  # URDF's default is x, not z
    assert scene["gravity"] == [0, 0, -9.81]


def test_inertia_is_turned_from_the_inertial_frame_into_the_links(tmp_path: Path) -> None:
    """A quarter turn about z exchanges xx and yy and turns com with nothing: it is told in the link."""
    inertial = (
        '<inertial><origin xyz="0.1 0.2 0.3" rpy="0 0 1.5707963267948966"/><mass value="2"/>'
        '<inertia ixx="1" iyy="2" izz="2.5" ixy="0.3" ixz="0.1" iyz="-0.2"/></inertial>'
    )
    path = write(tmp_path, f'<link name="a">{inertial}</link>')
    body = gelenk.import_urdf(path).to_dict()["bodies"]["a"]
    assert body["com"] == [0.1, 0.2, 0.3]
    # R = (y, -x, z): J_xx = iyy, J_yy = ixx, J_xy = -ixy, J_xz = -iyz, J_yz = ixz
    assert body["inertia"] == pytest.approx([2, 1, 2.5, -0.3, 0.2, 0.1], abs=4 * 2.2e-16)


@pytest.mark.parametrize(
    "rpy",
    [
        (0.1, -0.7, 2.9),
        (1.3, np.pi / 2, 0.4),
        (0.2, -np.pi / 2, -1.1),
        (np.pi, 0.3, -np.pi),
        (0, 1.57079632679, 0),
    ],
)
def test_frame_of_a_joint_is_the_one_of_the_file(rpy: tuple[float, float, float], tmp_path: Path) -> None:
    """Turns about the fixed axes x, y, z in this order, also where roll and yaw cannot be told apart."""
    origin = f'<origin xyz="0.3 -0.2 0.5" rpy="{rpy[0]!r} {rpy[1]!r} {rpy[2]!r}"/>'
    body = link("base") + link("tip") + joint("j", "fixed", "base", "tip", origin)
    scene = gelenk.import_urdf(write(tmp_path, body)).to_dict()
    scene["sensors"] = {"s": {"type": "frame", "body": "tip"}}
    scene["joints"]["base_to_ground"]["type"] = "free"  # something has to move
    plant = gelenk.Simulation(scene)
    plant.initialize()
    x, y, z, w = plant.values([f"s.Q[{i}]" for i in (1, 2, 3, 4)])
    found = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    (a, b, c), (p, q, r) = np.cos(rpy), np.sin(rpy)
    X = np.array([[1, 0, 0], [0, a, -p], [0, p, a]])
    Y = np.array([[b, 0, q], [0, 1, 0], [-q, 0, b]])
    Z = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
    assert np.abs(found - Z @ Y @ X).max() < 1e-14  # round-off of some 40 operations
    assert plant.values(["s.r[1]", "s.r[2]", "s.r[3]"]).tolist() == pytest.approx([0.3, -0.2, 0.5], abs=1e-15)


def test_names_become_identifiers_each_used_once(tmp_path: Path) -> None:
    body = (
        link("base link") + link("2nd") + link("ground") + link("arm")
        + joint("arm", "revolute", "base link", "2nd")
        + joint("a-b", "revolute", "2nd", "ground")
        + joint("a b", "revolute", "ground", "arm")
    )  # fmt: skip
    scene = gelenk.import_urdf(write(tmp_path, body, "my robot"))
    data = scene.to_dict()
    assert data["name"] == "my_robot"
    assert list(data["bodies"]) == ["base_link", "_2nd", "ground_link", "arm"]
    assert list(data["joints"])[1:] == ["arm_joint", "a_b", "a_b_joint"]
    assert list(data["motors"]) == ["arm_joint_motor", "a_b_motor", "a_b_joint_motor"]
    assert [line for line in scene.report if "renamed to" in line] == [
        "link base link: renamed to base_link",
        "link 2nd: renamed to _2nd",
        "link ground: renamed to ground_link",
        "joint arm: renamed to arm_joint",
        "joint a-b: renamed to a_b",
        "joint a b: renamed to a_b_joint",
    ]


def test_friction_mimic_and_transmissions_are_told(tmp_path: Path) -> None:
    body = (
        link("base") + link("a") + link("b")
        + joint("j", "revolute", "base", "a", '<dynamics damping="0.5" friction="0.0"/>')
        + joint("k", "planar", "a", "b", '<dynamics damping="0.3" friction="0.2"/><mimic joint="j"/>')
    )  # fmt: skip
    scene = gelenk.import_urdf(write(tmp_path, body))
    assert scene.to_dict()["joints"]["j"]["damping"] == 0.5
    assert "friction" not in scene.to_dict()["joints"]["j"]
    assert list(scene.report) == [
        "joint k: follows j in the file (mimic); here it moves freely",
        "joint k: its dry friction of 0.2 is not modeled",
        "joint k: its damping of 0.3 is not modeled",
    ]


@pytest.mark.parametrize(
    ("kind", "push", "speed"), [("revolute", "tau", "w"), ("continuous", "tau", "w"), ("prismatic", "f", "v")]
)
def test_friction_holds_a_joint_and_brakes_its_motion(
    kind: str, push: str, speed: str, tmp_path: Path
) -> None:
    """Unit mass and inertia on a horizontal axis through the center of mass: only the motor acts."""
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    body = link("base") + link("a") + joint("j", kind, "base", "a", f'{limit}<dynamics friction="0.2"/>')
    scene = gelenk.import_urdf(write(tmp_path, body))
    assert scene.to_dict()["joints"]["j"]["friction"]["coulomb"] == 0.2
    assert scene.report[0] == (
        "joints with dry friction: j; linear models at rest are those of locked joints, "
        "and equilibria are those without friction; gelenk.equilibrium(..., friction='present') determines "
        "whether it holds a pose"
    )
    plant = gelenk.Simulation(scene)
    plant.set_input(f"j_motor.{push}", 0.19)
    plant.initialize()
    plant.step_to(1.0)
    assert plant.output(f"j.{speed}") == 0
    plant.set_input(f"j_motor.{push}", 0.7)
    plant.step_to(2.0)
    assert plant.output(f"j.{speed}") == pytest.approx(0.7 - 0.2, rel=1e-6)  # the default tolerance


LIMITED = '<limit lower="{}" upper="{}" effort="9" velocity="9"/>'


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_limits_stop_a_joint(kind: str, tmp_path: Path) -> None:
    """A constant force drives a joint to its limit, where it remains."""
    body = link("base") + link("a") + joint("j", kind, "base", "a", LIMITED.format(-0.5, 1.25))
    scene = gelenk.import_urdf(write(tmp_path, body))
    limit = scene.to_dict()["joints"]["j"]["limit"]
    assert (limit["lower"], limit["upper"]) == (-0.5, 1.25)
    assert list(scene.report) == [
        "joints with hard limits: j",
        "limits of velocity and effort are not modeled: j",
    ]
    q, effort = {"revolute": ("phi", "tau"), "prismatic": ("s", "f")}[kind]
    plant = gelenk.Simulation(scene)
    for push, bound in ((1.0, 1.25), (-2.0, -0.5)):
        plant.set_input(f"j_motor.{effort}", push)
        if push > 0:
            plant.initialize()
        plant.step_to(plant.time + 5.0)
        assert plant.output(f"j.{q}") == pytest.approx(
            bound, abs=5e-11
        )  # located within rounding of a step of 5 s
        assert plant.output(f"j.limit.{effort}") == pytest.approx(-push, rel=1e-12)


@pytest.mark.parametrize(
    ("lower", "upper", "limited", "start"),
    [
        (-3.0, -1.0, True, -2.0),
        (0.0, 1.0, True, None),  # starts at its bound
        (0.0, 0.0, False, None),  # the default: none is given
        (1.0, -1.0, False, None),
        (0.5, 0.5, False, None),
    ],
)
def test_limits_around_the_start(
    lower: float, upper: float, limited: bool, start: float | None, tmp_path: Path
) -> None:
    body = link("base") + link("a") + joint("j", "revolute", "base", "a", LIMITED.format(lower, upper))
    scene = gelenk.import_urdf(write(tmp_path, body))
    entry = scene.to_dict()["joints"]["j"]
    assert ("limit" in entry) == limited
    assert entry.get("start", {}).get("phi") == start
    assert ("its lower limit exceeds" in " ".join(scene.report)) == (lower > upper)
    assert (f"its lower limit equals its upper one, {lower:g}" in " ".join(scene.report)) == (lower == upper)
    gelenk.Simulation(scene).initialize()
    without = gelenk.import_urdf(write(tmp_path, body), limits=False)
    assert "limit" not in without.to_dict()["joints"]["j"]
    if limited:
        assert without.report[0] == "limits of position are left out, as requested: j"


@pytest.mark.parametrize(
    ("name", "most_impacts"), [*((name, 100) for name in ROBOTS), *((name, 500) for name in HANDS)]
)
def test_robots_fall_onto_their_limits(name: str, most_impacts: int) -> None:
    """Within their limits for a second, with as many impacts as a chain of inelastic ones needs."""
    scene = gelenk.import_urdf(robot_file(name), repair_inertia=True)
    plant = gelenk.Simulation(scene)
    plant.initialize()
    for k in range(10):
        plant.step_to(0.1 * (k + 1))
    for joint, entry in scene.to_dict()["joints"].items():
        if "limit" in entry:
            at = plant.output(f"{joint}.{'phi' if entry['type'] == 'revolute' else 's'}")
            assert entry["limit"]["lower"] - 1e-9 <= at <= entry["limit"]["upper"] + 1e-9
    assert plant.diagnostic("solver.impacts") < most_impacts


def robot(*parts: str) -> str:
    return f"<robot name='r'>{''.join(parts)}</robot>"


def one_link(inertial: str) -> str:
    return robot(f"<link name='a'><inertial>{inertial}</inertial></link>")


BASE, A = link("base"), link("a")
HEAVY = "<link name='a'><inertial><mass value='1'/><inertia ixx='9' iyy='1' izz='1'/></inertial></link>"
WELDED_TWICE = joint("j", "fixed", "base", "a") + joint("k", "fixed", "base", "a")
XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>'
KINDS = "revolute, continuous, prismatic, fixed, floating, planar"


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("<robot", [":1:1: not XML: unclosed token"]),
        (
            "<sdf/>",
            [
                ":1: found an SDF model of Gazebo, expected a URDF robot description (<robot>); "
                "convert it to URDF and use `gelenk import`, or write a scene (docs/scene-format.md)"
            ],
        ),
        (robot(), [": found no links, expected at least one"]),
        (XACRO, [": contains xacro macros; expand it with xacro first"]),
        (robot(BASE, BASE), [": link base: found twice, expected once"]),
        (robot(BASE, joint("j", "hinge", "base", "tip")),
         [f": joint j: found type 'hinge', expected one of {KINDS}",
          ": joint j: child: found 'tip', expected the name of a link"]),
        (one_link("<mass value='1'/><inertia ixx='1'/>"),
         [f": link a: inertia: found no {key}, expected one" for key in ("iyy", "izz")]),
        (one_link(""), [": link a: inertial: found no mass value, expected one"]),
        (robot(BASE, A, joint("j", "continuous", "base", "a", '<dynamics friction="-1"/>')),
         [": joints.j.friction.coulomb: found -1 N m, expected 0 N m or more"]),
        (robot(BASE, A, joint("j", "continuous", "base", "a", '<dynamics damping="low" friction=""/>')),
         [": joint j: dynamics: damping: found 'low', expected a number",
          ": joint j: dynamics: friction: found '', expected a number"]),
        (one_link("<mass value='heavy'/>"), [": could not convert string to float: 'heavy'"]),
        (robot(BASE, A, WELDED_TWICE), [": link a: is the child of 2 joints, expected at most one"]),
        (robot(BASE, A),
         [": found the root links base, a, expected exactly one (a link that is not the child of a joint)"]),
        (robot(BASE, HEAVY, joint("j", "continuous", "base", "a")),
         [": bodies.a.inertia: xx = 9 exceeds yy + zz = 2 kg m2; no rigid body has such moments",
          ": --repair-inertia (repair_inertia=True) replaces impossible inertias by the nearest "
          "possible ones"]),
    ],
)  # fmt: skip
def test_description_that_is_wrong_is_refused(text: str, messages: list[str], tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(gelenk.SceneError) as caught:
        gelenk.import_urdf(path)
    assert list(caught.value.lines) == [f"{path}{message}" for message in messages]


def test_missing_file_is_the_systems_own_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        gelenk.import_urdf(tmp_path / "none.urdf")
