# SPDX-License-Identifier: BSD-3-Clause
"""Whatever a URDF file contains is converted, or listed in the scene's report as not converted."""

from __future__ import annotations

from pathlib import Path

import pytest

import gelenk

pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")

LINK = (
    '<link name="{}"><inertial><origin xyz="0 0 0.1" rpy="0 0 0"/><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
JOINT = (
    '<joint name="j" type="{}"><parent link="base"/><child link="arm"/><origin xyz="0 0 0" rpy="0 0 0"/>'
    '<axis xyz="0 0 1"/>{}</joint>'
)


def report(tmp_path: Path, text: str) -> list[str]:
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    return [line for line in gelenk.import_urdf(path).report if "is not converted" in line]


def robot(inside: str = "", kind: str = "continuous", in_joint: str = "", attributes: str = "") -> str:
    links = LINK.format("base") + LINK.format("arm")
    return f'<robot name="r"{attributes}>{links}{JOINT.format(kind, in_joint)}{inside}</robot>'


def test_nothing_is_listed_where_everything_is_converted(tmp_path: Path) -> None:
    assert report(tmp_path, robot(in_joint='<dynamics damping="0.1" friction="0.2"/>')) == []
    assert report(tmp_path, robot("<!-- <gazebo/> -->", kind="prismatic")) == []


LOOPS = (
    '<gazebo><joint name="C" type="revolute"><parent>arm</parent></joint></gazebo>'
    '<gazebo reference="arm"><mu1>0.2</mu1></gazebo>'
    '<loop_joint name="D"><link1 link="arm"/></loop_joint>'
)


def test_loops_of_other_tools_are_listed(tmp_path: Path) -> None:
    assert report(tmp_path, robot(LOOPS)) == [
        "<gazebo> is not converted (2 times): arm; it contained <joint> C, <mu1>",
        "<loop_joint> is not converted: D; it contained <link1>",
    ]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (robot(attributes=' color="red"'), "attribute color of <robot> is not converted"),
        (robot(in_joint="<calibration/>"), "<joint><calibration> is not converted: j"),
        (robot(in_joint='<dynamics mu="1"/>'), "attribute mu of <joint><dynamics> is not converted: j"),
        (robot(in_joint='<axis xyz="1 0 0"/>'), "second <joint><axis> is not converted: j"),
        (robot(in_joint="free"), "text in <joint> is not converted: j"),
        (
            robot().replace("<inertial>", "<inertial><bias/>", 1),
            "<link><inertial><bias> is not converted: base",
        ),
        (
            robot().replace('mass value="1"', 'mass value="1" unit="g"', 1),
            "attribute unit of <link><inertial><mass> is not converted: base",
        ),
        (
            robot(in_joint='<limit lower="-1" upper="0" effort="1" velocity="1"/>'),
            "attribute lower of <joint><limit> of a continuous joint is not converted: j",
        ),
        (
            robot(kind="fixed", in_joint='<dynamics friction="0" damping="2"/>'),
            "attribute damping of <joint><dynamics> of a fixed joint is not converted: j",
        ),
    ],
)
def test_what_is_ignored_is_listed_with_its_owner(text: str, line: str, tmp_path: Path) -> None:
    assert report(tmp_path, text) == [line]
