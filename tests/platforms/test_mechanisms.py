# SPDX-License-Identifier: BSD-3-Clause
"""The gallery, and drives, bearings, wheels and tires, on Windows (Wine) and 64-bit ARM (QEMU)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from gallery.entries import GALLERY
from mechanisms import Scene
from models.bearing_friction import four_bar_with_bearings, slider_crank_with_guide
from models.random_drives import random_drive
from models.skidding import DISC, on_the_plane, scene_of
from models.tires import SingleTrack, two_wheels

import gelenk

from .machines import OTHERS, Life, Machine, extracted

pytestmark = pytest.mark.platforms


@dataclass(frozen=True)
class Mechanism:
    """What runs. pushed: the input that changes, otherwise the first; stop: if not that of the scene [s]."""

    scene: Callable[[], gelenk.Scene]
    pushed: str = ""
    stop: float | None = None


def of_gallery(name: str) -> Mechanism:
    return Mechanism(lambda: gelenk.load(GALLERY / name / "scene.yaml"), *GALLERY_RUNS.get(name, ()))


def built(source: Callable[[], Scene], stop: float, pushed: str = "") -> Mechanism:
    return Mechanism(lambda: gelenk.load(source()), pushed, stop)


GALLERY_RUNS: dict[str, tuple[str, float | None]] = {
    "gear_shift": ("clutch2.friction.engagement", None),
}
MECHANISMS = {
    path.parent.name: of_gallery(path.parent.name) for path in sorted(GALLERY.glob("*/scene.yaml"))
} | {
    "bearings": built(four_bar_with_bearings, 1.5),
    "guide": built(lambda: slider_crank_with_guide(0.3), 1.5),
    "drive with a one-way clutch and losses": built(lambda: random_drive(3).source, 2.0),
    "wheel that slips": built(lambda: scene_of(DISC, on_the_plane(DISC, 0.1, (2, 0.5), (0, 0, 0))), 1.5),
    "tires": built(lambda: two_wheels(SingleTrack(1500, 2500, 1.2, 1.4, 8e4, 9e4, 20.0), -0.1), 2.0),
}
STEPS = 50


@pytest.mark.parametrize("machine", OTHERS)
@pytest.mark.parametrize("name", MECHANISMS)
def test_mechanisms_move_as_on_linux_and_states_change_machines(
    name: str, machine: Machine, hosts: Path, wine: Path, tmp_path: Path
) -> None:
    """Within 100 times the tolerance, relative to the largest value: both integrate with this tolerance."""
    mechanism = MECHANISMS[name]
    scene = mechanism.scene()
    fmu = gelenk.export_fmu(scene, tmp_path / "x.fmu", ["linux64", machine.platform], view=False)
    plant = extracted(fmu, tmp_path / "x", mechanism.pushed)
    life = Life(scene.tolerance, mechanism.stop or scene.stop, STEPS)
    difference = life.differences(plant, machine, hosts, wine, tmp_path)
    print(f"{name}: {difference / life.tolerance:.3g} times the tolerance")
    assert difference < 100 * life.tolerance
