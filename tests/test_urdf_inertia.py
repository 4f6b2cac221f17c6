# SPDX-License-Identifier: BSD-3-Clause
"""Inertias in URDF that no rigid body has: rounding, what stands still, and what has to be repaired.

The figures are those of links in the package example-robot-data, 69 robots, which is read where installed.
"""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import gelenk
from gelenk.io.urdf_inertia import MIN_INERTIA_RATIO, entries, matrix, nearest_inertia

pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")

Moments = tuple[float, float, float, float, float, float]  # xx yy zz xy xz yz

# By robot and link: mass [kg], center of mass [m], moments [kg m2].
ROUNDED: dict[str, tuple[float, tuple[float, float, float], Moments]] = {
    "icub head": (1.33687, (0.0185, -0.1108, 6.78454e-18), (0, 0, 0, 0, 2.40741e-35, 0)),
    "icub r_lower_leg": (
        1.264, (-0.1071, 0.00182, -0.00211), (1.10961e-18, 0, 0, 5.42101e-20, -5.42101e-20, 8.47033e-22)
    ),
    "icub r_hip_2": (0.526, (0, 0, 0.03045), (-5.42101e-20, -5.42101e-20, 0, 0, 0, 0)),
}  # fmt: skip
IMPOSSIBLE: dict[str, tuple[float, tuple[float, float, float], Moments]] = {
    "romeo body": (
        5.11337, (0.02825, 0, -0.16653),
        (0.0564204, 0.0521042, 0.021185, 7.26322e-05, -0.0575115, -3.39086e-05),
    ),
    "romeo_small RShoulderYawLink": (
        0.57151, (0.09367, -0.01373, 0.00103),
        (0.000742356, 0.00649989, 0.000664209, 0.000617202, 5.98521e-06, -1.07417e-06),
    ),
    "pr2 sensor_mount_link": (0.05, (0, 0, 0), (0.001, 0.001, 0.01, 0, 0, 0)),
    "hyq lf_foot": (1e-6, (0, 0, 0), (1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6)),
    "tiago base_antenna_left_link": (
        1e-6, (0, 0, 0), (2.371e-8, 2.833e-8, 3.849e-8, 6.119e-8, 1.179e-8, 7.74e-9)
    ),
}  # fmt: skip


def part(name: str, mass: float, com: tuple[float, float, float], moments: Moments) -> str:
    xyz = " ".join(map(repr, com))
    terms = " ".join(
        f'{k}="{x!r}"' for k, x in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), moments, strict=True)
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{xyz}"/><mass value="{mass!r}"/>'
        f"<inertia {terms}/></inertial></link>"
    )


def moving(tmp_path: Path, inner: str, kind: str = "revolute") -> Path:
    """A robot whose link `a` moves on a good one; about a slanted axis, which all moments enter."""
    path = tmp_path / "r.urdf"
    path.write_text(
        f'<robot name="r"><link name="base"/>{part("arm", 2.0, (0.2, 0, 0), (0.1, 0.2, 0.25, 0, 0.01, 0))}'
        f"{inner}"
        '<joint name="i" type="revolute"><parent link="base"/><child link="arm"/></joint>'
        f'<joint name="j" type="{kind}"><origin xyz="0.3 0.1 0"/><axis xyz="0.36 0.48 0.8"/>'
        '<parent link="arm"/><child link="a"/></joint></robot>'
    )
    return path


def runs(scene: gelenk.Scene, stop: float = 0.2) -> None:
    plant = gelenk.Simulation(scene)
    plant.initialize()
    plant.step_to(stop)
    assert np.isfinite(plant.values()).all()


@pytest.mark.parametrize("case", ROUNDED)
def test_rounding_is_no_fault_and_stays_to_the_bit(case: str, tmp_path: Path) -> None:
    """Programs tell moments about the center of mass as differences of such about the origin."""
    mass, com, moments = ROUNDED[case]
    for repair in (False, True):
        scene = gelenk.import_urdf(moving(tmp_path, part("a", *ROUNDED[case])), repair_inertia=repair)
        body = scene.to_dict()["bodies"]["a"]
        assert (body["mass"], tuple(body["com"]), tuple(body["inertia"])) == (mass, com, moments)
        assert not any("moments" in line for line in scene.report)
        runs(scene)


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_what_is_welded_to_the_ground_may_have_any_inertia(case: str, tmp_path: Path) -> None:
    """Nothing depends on it; where the robot floats, everything does."""
    path = tmp_path / "r.urdf"
    path.write_text(
        f'<robot name="r"><link name="base"/>{part("a", *IMPOSSIBLE[case])}'
        f"{part('arm', 1.0, (0.1, 0, 0), (0.1, 0.2, 0.2, 0, 0, 0))}"
        '<joint name="i" type="fixed"><parent link="base"/><child link="a"/></joint>'
        '<joint name="j" type="revolute"><parent link="a"/><child link="arm"/></joint></robot>'
    )
    scene = gelenk.import_urdf(path)
    assert tuple(scene.to_dict()["bodies"]["a"]["inertia"]) == IMPOSSIBLE[case][2]
    runs(scene)
    with pytest.raises(gelenk.SceneError, match="no rigid body has such moments"):
        gelenk.import_urdf(path, floating=True)


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_impossible_inertia_is_refused_and_repaired_with_a_line(case: str, tmp_path: Path) -> None:
    path = moving(tmp_path, part("a", *IMPOSSIBLE[case]))
    with pytest.raises(gelenk.SceneError) as refused:
        gelenk.import_urdf(path)
    assert "bodies.a.inertia: " in refused.value.lines[0]
    assert refused.value.lines[-1].startswith(f"{path}: --repair-inertia (repair_inertia=True) ")
    scene = gelenk.import_urdf(path, repair_inertia=True)
    told = [line for line in scene.report if "moments" in line]
    assert len(told) == 1
    assert told[0].startswith("link a: no rigid body has its principal moments ")
    given, found = matrix(IMPOSSIBLE[case][2]), matrix(scene.to_dict()["bodies"]["a"]["inertia"])
    second = [np.trace(J) / 2 * np.eye(3) - J for J in (given, found)]
    share = np.linalg.norm(second[1] - second[0]) / np.linalg.norm(second[0])
    assert told[0].endswith(f"the second moments change by {100 * share:.2g} %")
    bodies = scene.to_dict()["bodies"]
    assert bodies["arm"]["inertia"] == [0.1, 0.2, 0.25, 0, 0.01, 0]
    assert bodies["a"]["mass"] == IMPOSSIBLE[case][0]
    runs(scene)


@pytest.mark.parametrize("case", IMPOSSIBLE)
def test_repaired_inertia_is_physical_and_none_is_nearer(case: str) -> None:
    """Against 2000 physical inertias near it, and by what a projection onto a convex cone is: the change is
    orthogonal to the result, and ends outside of the cone (Moreau 1962); up to the least share.
    """
    given = matrix(IMPOSSIBLE[case][2])
    found = nearest_inertia(given)
    S, R = (np.trace(J) / 2 * np.eye(3) - J for J in (given, found))
    scale = np.linalg.eigvalsh(S).max()
    assert np.linalg.eigvalsh(R).min() >= MIN_INERTIA_RATIO * scale * (1 - 1e-9)
    principal = np.linalg.eigvalsh(found)
    assert principal[0] > 0
    assert principal[2] <= principal[0] + principal[1]
    assert abs(np.sum((R - S) * R)) <= 3 * MIN_INERTIA_RATIO * scale**2 * 3
    assert np.linalg.eigvalsh(R - S).min() >= -1e-15 * scale  # positive second moments stay
    distance = np.linalg.norm(R - S)
    rng = np.random.default_rng(5)
    for _ in range(2000):
        factor = np.linalg.cholesky(R + 1e-18 * scale * np.eye(3)) + rng.normal(0, 0.1, (3, 3)) * np.sqrt(
            scale
        )
        other = factor @ factor.T
        assert np.linalg.norm(other - S) >= distance - 3 * MIN_INERTIA_RATIO * scale


def test_physical_inertia_would_keep_its_value() -> None:
    J = matrix((0.1, 0.2, 0.25, 0.01, -0.02, 0.03))
    assert np.abs(nearest_inertia(J) - J).max() <= 8 * 2.2e-16  # a turn there and back
    assert entries(J) == [0.1, 0.2, 0.25, 0.01, -0.02, 0.03]
    assert not nearest_inertia(-np.eye(3)).any()


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_link_that_moves_without_inertia_is_given_a_millionth(kind: str, tmp_path: Path) -> None:
    """Romeo's RThumb3Link: mass 0 on a joint, and nothing beyond it but a frame."""
    tip = (
        '<link name="a"/><link name="tip"/>'
        '<joint name="f" type="fixed"><parent link="a"/><child link="tip"/></joint>'
    )
    path = moving(tmp_path, tip, kind)
    with pytest.raises(gelenk.SceneError, match=r"bodies\.a: moves without inertia"):
        gelenk.Simulation(gelenk.import_urdf(path)).initialize()
    (warned,) = (line for line in gelenk.import_urdf(path).report if line.startswith("link a: can move"))
    assert (
        "cannot be simulated; --repair-inertia (repair_inertia=True) gives it 1e-06 of those of arm" in warned
    )
    scene = gelenk.import_urdf(path, repair_inertia=True)
    line = next(line for line in scene.report if line.startswith("link a: can move"))
    largest = np.linalg.eigvalsh(matrix((0.1, 0.2, 0.25, 0, 0.01, 0)))[-1]
    assert line.endswith(f"it gets 1e-06 of those of arm: 2e-06 kg, {1e-6 * largest:.4g} kg m2")
    runs(scene)


def test_mass_zero_with_moments_is_taken_as_given(tmp_path: Path) -> None:
    """Bolt's FL_FOOT, on a joint of its own."""
    path = moving(tmp_path, part("a", 0.0, (0, 0, 0.00035767), (5.7e-7, 8.4e-7, 5.3e-7, 0, 0, 0)))
    scene = gelenk.import_urdf(path)
    assert scene.to_dict()["bodies"]["a"]["inertia"] == [5.7e-7, 8.4e-7, 5.3e-7, 0, 0, 0]
    runs(scene)


def shelf() -> list[Path]:
    """All URDF files of example-robot-data."""
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        return []
    return sorted(Path(str(f.locate())) for f in files if str(f).endswith(".urdf"))


@pytest.mark.study
def test_robots_of_the_package_import_and_run() -> None:
    """68 of 69: ur3.urdf has neither links nor joints. What is possible stays to the bit."""
    if not shelf():
        pytest.skip("example-robot-data is not installed")
    failed = {}
    for path in shelf():
        try:
            scene = gelenk.import_urdf(path, repair_inertia=True, limits=False)  # limits cost minutes
        except gelenk.SceneError as e:
            failed[path.name] = str(e)
            continue
        changes = (" replaced by the nearest possible ones", "; it gets 1e-06 of those of ")
        repaired = {line.split(":")[0][5:] for line in scene.report if any(c in line for c in changes)}
        try:
            plain = gelenk.import_urdf(path, limits=False).to_dict()["bodies"]
        except gelenk.SceneError:
            plain = {}
        for name, body in plain.items():
            assert name in repaired or body == scene.to_dict()["bodies"][name]
        runs(scene, 1.0)
    assert list(failed) == ["ur3.urdf"]
    assert failed["ur3.urdf"].endswith(": found no links, expected at least one")
