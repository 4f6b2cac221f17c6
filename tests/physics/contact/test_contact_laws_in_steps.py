# SPDX-License-Identifier: BSD-3-Clause
"""Every law of contacts in both schemes: located events, and time steps of shrinking size.

As in test_laws_in_steps.py for the laws of joints: steps converge to events in all outputs.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from models import registered_laws
from models.both_schemes import assert_steps_converge, located
from models.contact_law_cases import CASES, SHAPES, on_floor

import gelenk
from gelenk import _core


@pytest.mark.parametrize("name", CASES)
def test_steps_converge_to_located_events(name: str) -> None:
    assert_steps_converge(CASES[name]())


def test_every_field_of_contacts_is_compared() -> None:
    """All numbers, components and flags of the registry have other values than the default ones."""
    compared = {
        setting
        for case in CASES.values()
        for contact in case().source["contacts"].values()
        for setting in registered_laws.settings(contact, "contacts")
    }
    assert registered_laws.wanted("contacts") == compared


def test_every_output_of_contacts_is_compared() -> None:
    """All modes occur, and every component of a force and every distance has large values."""
    (kind,) = registered_laws.KINDS["contacts"]
    modes: set[float] = set()
    largest: dict[str, float] = {}
    for case in CASES.values():
        outputs = located(case()).values
        for contact in case().source["contacts"]:
            modes |= set(outputs[f"{contact}.mode"].tolist())
            for name in registered_laws.output_names(kind):
                value = float(np.abs(outputs[f"{contact}.{name}"]).max())
                largest[name] = max(value, largest.get(name, 0.0))
    assert modes == {0, 1, 2}
    assert min(largest.values()) > 0.1  # N, m
    assert len(largest) == 5  # f[1..3], gap, mode


def test_every_shape_is_compared_or_has_no_located_events() -> None:
    """Of meshes, contacts are solved in steps only; a new shape is one of the cases."""
    known = set(json.loads(_core.scene_schema())["$defs"]["shapes"]["additionalProperties"]["properties"])
    placing = {"position", "rotation", "surface", "color"}
    others = known - placing - set(SHAPES) - {"plane"}
    assert others == {"mesh"}
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    scene = on_floor("box", {"friction": 0.3})
    shape = scene["bodies"]["body"]["shapes"]["hull"]
    del shape["box"]
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    shape["mesh"] = {"points": corners, "triangles": faces}
    plant = gelenk.Simulation({**scene, "solver": {"integrator": "auto"}})
    with pytest.warns(gelenk.StartWarning, match="contacts are solved in time steps"):
        plant.initialize()
