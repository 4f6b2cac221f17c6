# SPDX-License-Identifier: BSD-3-Clause
"""References of scenes with friction, limits, contacts and rolling, which one formulation solves."""

from __future__ import annotations

from pathlib import Path

import pytest

from gelenk.chart import reference
from gelenk.chart.case import Case, case_of
from gelenk.chart.measure import Reference

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize(
    ("name", "agreement"),
    [
        ("rolling_disc", 1e-9),  # velocity constraints
        ("gear_shift", 1e-9),  # friction
        ("backlash_drive", 1e-9),  # limits
        ("ratchet", 1e-8),  # contacts, with impacts
        ("car", 1e-8),  # massless links, which do not move without reductions
    ],
)
def test_references_of_scenes_that_one_formulation_solves(name: str, agreement: float) -> None:
    """With events located by another integrator, in a model without reductions where that exists."""
    case = case_of(ROOT / "docs" / "gallery" / name / "scene.yaml")
    found = reference.references([case], 2, 60.0, quick=True)[case.name]
    assert isinstance(found, Reference)
    assert found.digits < agreement
    assert "checked by projection+" in found.words
    assert ("without reductions" in found.words) == (name != "car")


def test_references_without_located_events_are_time_steps() -> None:
    """A cylinder falls on another one across it and rests; the error of such steps is of first order."""
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "roll": {
                "mass": 2.0,
                "inertia": [0.17, 0.17, 0.01],
                "shapes": {
                    "side": {
                        "cylinder": {"radius": 0.1, "length": 1.0},
                        "rotation": {"rpy": [0, 1.5707963267948966, 0]},
                        "surface": "wood",
                    }
                },
            }
        },
        "ground": {
            "shapes": {
                "side": {
                    "cylinder": {"radius": 0.1, "length": 1.0},
                    "rotation": {"rpy": [1.5707963267948966, 0, 0]},
                    "surface": "log",
                }
            }
        },
        "joints": {
            "j": {
                "type": "prismatic",
                "axis": [0, 0, 1],
                "parent": "ground",
                "child": "roll",
                "start": {"s": 0.21},
            }
        },
        "contacts": {"c": {"between": ["wood", "log"], "friction": 0.5}},
    }
    case = Case("crossed", "", scene, 0.1, 0.02)
    found = reference.references([case], 1, 60.0, quick=True)[case.name]
    assert isinstance(found, Reference), found.reason
    assert found.words.startswith("projection+moreau-jean at ")
    assert found.words.count("projection+moreau-jean") == 2
    assert found.states[-1] == pytest.approx([0.2, 0], abs=1e-9)
    assert found.digits < 1e-4
