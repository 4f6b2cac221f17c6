# SPDX-License-Identifier: BSD-3-Clause
"""What equations cannot say is refused or stated, with the name of the element."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.errors import SceneError

SECTIONS = ("forces", "tables", "states", "sensors", "inputs", "constraints")


def lever(**fields: Any) -> dict[str, Any]:
    """A lever on a joint A with these fields, or sections of the scene."""
    joint: dict[str, Any] = {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "lever"}
    sections: dict[str, Any] = {name: fields.pop(name) for name in SECTIONS if name in fields}
    return {
        "gelenk": 1,
        "name": "Lever",
        "gravity": [0, 0, -9.81],
        "bodies": {"lever": {"mass": 2.0, "com": [0.3, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
        "joints": {"A": {**joint, **fields}},
        **sections,
    }


SOLID = 2.0 * 0.3**2 + 0.1  # kg m2
WEIGHT = 2.0 * 9.81 * 0.3  # N m

TABLE = {"load": {"x": [0, 1], "values": [2, 3]}}
BUSHING = {"mount": {"type": "bushing", "from": "ground", "to": "lever", "rotational_stiffness": [9, 9, 9]}}
TIRE = {
    "tire": {
        "type": "tire", "body": "lever", "position": [0.3, 0, 0], "radius": 0.32, "stiffness": 2e5,
        "slip_stiffness": 20, "cornering_stiffness": 14,
    }
}  # fmt: skip


@pytest.mark.parametrize(
    ("fields", "name"),
    [
        ({"forces": BUSHING}, "mount: found a law with branches"),
        ({"forces": TIRE}, "tire: found a law with branches"),
        (
            {"tables": TABLE, "law": {"effort": "table(load, phi)"}},
            "A.phi: found a law with branches or a table",
        ),
        (
            {"tables": TABLE, "states": {"lag": "table(load, A.phi)"}, "law": {"effort": "lag"}},
            "lag: found a law with branches or a table",
        ),
        (
            {"forces": BUSHING, "states": {"lag": "A.phi"}, "law": {"effort": "lag*w"}},
            "mount: found a law with branches",
        ),
        (
            {"sensors": {"tip": {"type": "frame", "body": "lever"}}, "law": {"effort": "tip.v[1]"}},
            r"A: found an expression that names the output 'tip.v\[1\]' of a sensor",
        ),
        (
            {"states": {"lag": "A.a - lag"}, "law": {"effort": "lag"}},
            "lag: found a rate that depends on forces or accelerations",
        ),
    ],
)
def test_hidden_branches_are_refused(fields: dict[str, Any], name: str) -> None:
    """Recorded, each would be the branch of one position, and silently wrong at others."""
    with pytest.raises(SceneError, match=name):
        gelenk.equations(lever(**fields))


def test_a_limit_is_left_out_with_a_note() -> None:
    found = gelenk.equations(lever(limit={"lower": -0.5, "upper": 0.5}))
    assert found.notes == ("A.phi: its limit is left out; the equations hold where it is not reached.",)
    assert "A.phi: its limit is left out" in found.to_c()
    plant = found.to_numpy()
    assert plant.M([2.0]) == pytest.approx(SOLID, rel=1e-15)
    assert plant.h([2.0], [0.0], []) == pytest.approx(-WEIGHT * np.cos(2.0), rel=1e-14)


def test_a_stop_is_left_out_but_its_energy_is_written() -> None:
    """The energy has no branch by modes: 0 between the bounds, k s^2/2 beyond them."""
    found = gelenk.equations(lever(stop={"lower": -0.5, "upper": 0.5, "stiffness": 800.0}))
    assert found.notes == ("A.phi: its stop is left out; the equations hold where it is not reached.",)
    plant = found.to_numpy()
    between = plant.potential([0.4]) + WEIGHT * np.sin(0.4)
    assert between == pytest.approx(0, abs=1e-14)
    for phi, depth in ((0.7, 0.2), (-0.8, 0.3)):
        assert plant.potential([phi]) + WEIGHT * np.sin(phi) == pytest.approx(400 * depth**2, rel=1e-12)


@pytest.mark.parametrize("exponent", [1, 2])
def test_friction_slides_in_either_direction(exponent: int) -> None:
    """Stribeck's curve, of the size of the speed, against it."""
    friction = {"coulomb": 1.5, "static": 2.0, "stribeck": 0.1, "exponent": exponent}
    found = gelenk.equations(lever(friction=friction))
    (note,) = found.notes
    assert note.startswith("A.phi: friction acts as in sliding")
    plant = found.to_numpy()
    for w in (0.05, -0.05, 0.2, -0.2):
        size = 1.5 + 0.5 * np.exp(-((abs(w) / 0.1) ** exponent))
        expected = np.sign(w) * size - WEIGHT * np.cos(0.2)
        assert plant.h([0.2], [w], []) == pytest.approx(expected, rel=1e-13)
