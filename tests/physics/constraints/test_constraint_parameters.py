# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of constraints as parameters: runs are the same as those of a scene with these numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk


def shafts(**constraints: Any) -> Scene:
    """Two hinges and a slide, each with a body under gravity."""
    return scene(
        {name: body(1.0, (0.1, 0, 0), (0.02, 0.03, 0.03)) for name in "abc"},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 1, 0]),
            "B": joint("revolute", frame("ground"), frame("b"), axis=[0, 1, 0]),
            "C": joint("prismatic", frame("ground"), frame("c"), axis=[0, 0, 1]),
        },
        gravity=[0, 0, -GRAVITY], constraints=constraints, parameters="all",
        experiment={"stop": 0.5, "step": 0.05, "tolerance": 1e-9},
    )  # fmt: skip


SINE = {"type": "motion", "joint": "A", "polynomial": [0.1, 0.2], "sine": {"amplitude": 0.3, "frequency": 2}}
GEAR = {"type": "gear", "joint": "A", "with": "B", "ratio": 2.0}
RACK = {"type": "rack", "rack": "C", "pinion": "B", "radius": 0.1}


@pytest.mark.parametrize(
    ("constraint", "other", "parameters"),
    [
        (SINE, SINE | {"polynomial": [0.1, 0.5]}, {"x.polynomial[2]": 0.5}),
        (
            SINE,
            SINE | {"sine": {"amplitude": 0.2, "frequency": 3, "phase": 0.4}},
            {"x.sine.amplitude": 0.2, "x.sine.frequency": 3.0, "x.sine.phase": 0.4},
        ),
        ({"type": "motion", "joint": "A", "speed": 1.0}, {"type": "motion", "joint": "A", "speed": 2.0},
         {"x.speed": 2.0}),
        (GEAR, GEAR | {"ratio": -3.0, "offset": 0.3}, {"x.ratio": -3.0, "x.offset": 0.3}),
        (RACK, RACK | {"radius": 0.2, "offset": 0.05}, {"x.radius": 0.2, "x.offset": 0.05}),
    ],
)  # fmt: skip
def test_parameter_has_the_effect_of_the_number_in_the_scene(
    constraint: dict[str, Any], other: dict[str, Any], parameters: dict[str, float], tmp_path: Path
) -> None:
    written = gelenk.simulate(shafts(x=other))
    for source in (shafts(x=constraint), gelenk.export_fmu(shafts(x=constraint), tmp_path / "x.fmu")):
        found = gelenk.simulate(source, parameters=parameters)
        for name in written.names:
            assert found[name].tolist() == written[name].tolist(), name  # the same calls: bitwise identical


@warned.STILL
def test_wheel_of_radius_zero_is_rejected(tmp_path: Path) -> None:
    upright = {"r": [0, 0, 0.3], "Q": [0, 0, 0, 1], "fixed": ["Q"]}
    source = scene(
        {"wheel": body(1.0, (0, 0, 0), (0.01, 0.02, 0.01))},
        {"F": joint("free", frame("ground"), frame("wheel"), start=upright)},
        constraints={"tyre": {"type": "rolling", "body": "wheel", "radius": 0.3}}, parameters=["tyre.radius"],
    )  # fmt: skip
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    (radius,) = (v for v in fmpy.read_model_description(fmu).modelVariables if v.name == "tyre.radius")
    assert (float(radius.start), radius.declaredType.unit) == (0.3, "m")
    with pytest.raises(gelenk.GelenkError, match=r"tyre\.radius: found 0 m, expected more than 0 m"):
        gelenk.simulate(fmu, stop=0.1, parameters={"tyre.radius": 0.0})
    larger = gelenk.simulate(fmu, stop=0.1, parameters={"tyre.radius": 0.4})
    assert larger["F.r[3]"] == pytest.approx(0.4, abs=1e-12)  # upright, so the hub's height
