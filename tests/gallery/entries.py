# SPDX-License-Identifier: BSD-3-Clause
"""The mechanisms of docs/gallery: their scenes, runs, and the numbers that their pages state."""

from __future__ import annotations

import functools
import re
from pathlib import Path

import numpy as np
import yaml
from mechanisms import Array, Scene

import gelenk

ROOT = Path(__file__).resolve().parents[2]
GALLERY = ROOT / "docs" / "gallery"
NAMES = sorted(path.parent.name for path in GALLERY.glob("*/README.md"))


def file(name: str) -> Path:
    """Return the scene file of a mechanism: in its folder, or among the scenes of the package."""
    own = GALLERY / name / "scene.yaml"
    return own if own.exists() else ROOT / "scenes" / f"{name}.yaml"


def source(name: str) -> Scene:
    """Return the scene of a mechanism as a dictionary."""
    return gelenk.load(file(name)).to_dict()


def written(name: str) -> Scene:
    """Return the scene of a mechanism as its file has it: with poses and `at`."""
    out: Scene = yaml.safe_load(file(name).read_text(encoding="utf-8"))
    return out


@functools.cache
def ran(name: str) -> gelenk.Result:
    """Return the run of a mechanism as the gallery shows it."""
    return gelenk.simulate(file(name))


def vectors(result: gelenk.Result, name: str) -> Array:
    """Return three outputs name[1..3] as columns, shape (times, 3)."""
    return np.array([result[f"{name}[{i}]"] for i in (1, 2, 3)]).T


def position(scene: Scene, joint: str, end: str) -> Array:
    """Return the position of a joint frame in the body at its end `parent` or `child` [m]."""
    return np.array(scene["joints"][joint][end].get("position", (0, 0, 0)), float)


def assert_stated(name: str, value: float, unit: str) -> None:
    """Check that the page of a mechanism states a value with this unit, in at least three correct digits."""
    text = " ".join((GALLERY / name / "README.md").read_text(encoding="utf-8").split())
    after = rf" {re.escape(unit)}(?!\w)" if unit else r"(?![\w.])"
    found = re.findall(rf"(?<![\w.])(-?\d+(?:\.(\d+))?){after}", text)
    stated = [(float(number), len(digits)) for number, digits in found if sum(map(str.isdigit, number)) > 2]
    assert any(abs(number - value) <= 0.5000001 * 10.0**-digits for number, digits in stated), (
        f"{name}: the page does not state {value:.8g} {unit}, but {[number for number, _ in found]}"
    )
