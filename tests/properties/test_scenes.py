# SPDX-License-Identifier: BSD-3-Clause
"""Random trees with all joint types are unchanged by writing and reading, in C++ and in Python."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import warned
from elements.scenes import JOINTS, some_joint
from hypothesis import given
from hypothesis import strategies as st
from mechanisms import Scene, frame, rotation, scene

import gelenk

from .bounds import examples

LENGTH = st.floats(-10, 10)  # m
MASS = st.floats(1e-3, 1e3)  # kg
DIRECTION = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: max(map(abs, axis)) > 0.1)
ANGLE = st.floats(-4, 4)  # rad


@st.composite
def frames(draw: st.DrawFn, on: str) -> dict[str, Any]:
    position = draw(st.tuples(LENGTH, LENGTH, LENGTH))
    turned = draw(st.none() | st.tuples(DIRECTION, ANGLE))
    return frame(on, position, None if turned is None else rotation(*turned))


@st.composite
def bodies(draw: st.DrawFn) -> dict[str, Any]:
    """Principal moments satisfy the triangle inequality, as each is a sum of two second moments."""
    a, b, c = (draw(MASS) for _ in range(3))
    return {
        "mass": draw(MASS),
        "com": list(draw(st.tuples(LENGTH, LENGTH, LENGTH))),
        "inertia": [a + b, b + c, c + a],
    }


@st.composite
def trees(draw: st.DrawFn) -> Scene:
    """Up to six bodies, each on the ground or on a previous one."""
    count = draw(st.integers(1, 6))
    joints = {}
    for i in range(count):
        kind = draw(st.sampled_from(sorted(name for name in JOINTS if name != "rod")))
        before = draw(st.sampled_from(["ground", *(f"b{k}" for k in range(i))]))
        joints[f"j{i}"] = some_joint(kind, draw(frames(before)), draw(frames(f"b{i}")))
    gravity = draw(st.tuples(LENGTH, LENGTH, LENGTH))
    return scene({f"b{i}": draw(bodies()) for i in range(count)}, joints, gravity=list(gravity))


@warned.GYRATION
@examples(80)
@given(source=trees())
def test_tree_is_the_same_in_cpp_and_python(source: Scene, tmp_path: Path) -> None:
    first = gelenk.load(source)
    expected = first.to_dict()
    assert gelenk.load(expected).to_dict() == expected
    for ending in ("yaml", "json"):
        path = tmp_path / f"scene.{ending}"
        first.save(path)
        assert gelenk.load(path).to_dict() == expected
    plain = tmp_path / "plain.json"
    plain.write_text(json.dumps(source), "utf-8")
    assert gelenk.load(plain).to_dict() == expected


@warned.GYRATION
@examples(40)
@given(source=trees())
def test_saved_tree_moves_bitwise_identically(source: Scene, tmp_path: Path) -> None:
    first = gelenk.load(source)
    first.save(tmp_path / "scene.yaml")
    plants = [gelenk.Simulation(s) for s in (first, gelenk.load(tmp_path / "scene.yaml"))]
    for plant in plants:
        plant.initialize()
    found, again = ([plant.output(signal.name) for signal in plant.outputs] for plant in plants)
    assert found == again
    assert np.isfinite(found).all()
