# SPDX-License-Identifier: BSD-3-Clause
"""The gallery, and drives, bearings, wheels and tires, on Windows (Wine) and 64-bit ARM (QEMU)."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from fmpy import read_model_description
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
    """What runs.

    pushed: the input that changes, otherwise the first. stop: if not that of the scene [s]. compared: pattern
    of the outputs.
    """

    scene: Callable[[], gelenk.Scene]
    pushed: str = ""
    stop: float | None = None
    compared: str = ""


def of_gallery(name: str, pushed: str = "", stop: float | None = None) -> Mechanism:
    return Mechanism(lambda: gelenk.load(GALLERY / name / "scene.yaml"), pushed, stop)


def built(source: Callable[[], Scene], stop: float) -> Mechanism:
    return Mechanism(lambda: gelenk.load({**source(), "experiment": {"step": 0.02}}), stop=stop)


# All bars of Bennett's linkage lie on a line at 1.36 s. Even 0.08 s later, accelerations have errors of 1e-4
# of their size on each machine, whatever the tolerance: that of a hinge, which is 0, is up to 6e-4 rad/s2.
BENNETT_STOP = 1.2


# Wheels that roll freely are stiff: errors of their speeds of 20 times the tolerance change the forces of
# tires, and with them accelerations, by 1e-3 of their size, on each machine: the motion is compared.
MOTION = r"\.(s|phi|v|w)(_\w)?$"
MECHANISMS = {
    name: of_gallery(name) for name in sorted(path.parent.name for path in GALLERY.glob("*/scene.yaml"))
} | {
    "bennett": of_gallery("bennett", stop=BENNETT_STOP),
    "car": replace(of_gallery("car"), compared=MOTION),
    "gear_shift": of_gallery("gear_shift", "clutch2.friction.engagement"),
    "bearings": built(four_bar_with_bearings, 1.5),
    "guide": built(lambda: slider_crank_with_guide(0.3), 1.5),
    "drive with a one-way clutch and losses": built(lambda: random_drive(3).source, 2.0),
    "wheel that slips": built(lambda: scene_of(DISC, on_the_plane(DISC, 0.1, (2, 0.5), (0, 0, 0))), 1.5),
    "tires": built(lambda: two_wheels(SingleTrack(1500, 2500, 1.2, 1.4, 8e4, 9e4, 20.0), -0.1), 2.0),
}


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
    stop = mechanism.stop or scene.stop
    life = Life(scene.tolerance, stop, round(stop / scene.step))
    outputs = [v.name for v in read_model_description(str(fmu)).modelVariables if v.causality == "output"]
    compared = [bool(re.search(mechanism.compared, name)) for name in outputs]
    difference = life.differences(plant, machine, hosts, wine, tmp_path, compared)
    print(f"{name}: {difference / life.tolerance:.3g} times the tolerance")
    assert difference < 100 * life.tolerance


def test_the_run_that_ends_early_does_so_before_accelerations_are_wrong_here() -> None:
    """Opposite hinges of Bennett's linkage turn equally fast, A without acceleration: so does C."""
    plant = gelenk.Simulation(MECHANISMS["bennett"].scene())
    plant.initialize()
    largest = {BENNETT_STOP: 0.0, 1.5: 0.0}
    for stop in largest:
        while plant.time < stop - 1e-9:
            plant.step_to(plant.time + 0.02)
            largest[stop] = max(largest[stop], abs(plant.output("C.a")))
    early, late = largest.values()
    assert early < 100 * 1e-8 < late
