# SPDX-License-Identifier: BSD-3-Clause
"""Old public names work for one release, with a warning that gives the new name; so do old keys of JSON."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gelenk
from gelenk.linear import linear_model

# Class, old name, new name; the objects are those of `objects`.
RENAMED = [
    ("Mode", "hertz", "frequency_hz"),
    ("Mode", "frequency", "natural_frequency"),
    ("Mode", "damping", "damping_ratio"),
    ("Mode", "swings", "is_oscillatory"),
    ("Mode", "length", "chain_length"),
    ("Mode", "coasts", "grows_in_position_only"),
    ("Mode", "error", "error_bound"),
    ("LinearModel", "unrest", "residual_rates"),
    ("LinearModel", "unrest_of_states", "residual_state_rates"),
    ("Inspection", "freedoms", "degrees_of_freedom"),
    ("Inspection", "counted_freedoms", "counted_degrees_of_freedom"),
    ("Inspection", "momentary_freedoms", "initial_degrees_of_freedom"),
    ("Inspection", "redundant_rows", "redundant_constraints"),
    ("Branch", "freedoms", "degrees_of_freedom"),
    ("Branch", "flat", "is_not_isolated"),
    ("Branch", "chosen", "is_default"),
    ("Branch", "part", "island"),
    ("ModelSize", "speeds", "velocities"),
    ("ModelSize", "rows", "constraint_equations"),
    ("ModelSize", "freedoms", "degrees_of_freedom"),
]


@pytest.fixture(scope="module")
def objects(root: Path) -> dict[str, Any]:
    scene = gelenk.load(root / "scenes" / "four_bar.yaml")
    held = gelenk.equilibrium(scene, at={"A.phi": -1.0})
    report = gelenk.inspect(scene)
    return {
        "Mode": gelenk.modes(scene, at=held.at).modes[0],
        "LinearModel": linear_model(scene),
        "Inspection": report,
        "Branch": gelenk.assemblies(scene)[1],
        "ModelSize": report.described,
    }


def deprecated(sentence: str, use: Callable[[], Any]) -> Any:
    """What the use of an old name gives; the warning is checked, and that it names this file."""
    with pytest.warns(DeprecationWarning, match="is deprecated") as caught:
        found = use()
    assert [(str(w.message), w.filename) for w in caught] == [(sentence, __file__)]
    return found


@pytest.mark.parametrize(("owner", "old", "new"), RENAMED)
def test_an_old_name_gives_the_same_with_a_warning(
    owner: str, old: str, new: str, objects: dict[str, Any]
) -> None:
    thing = objects[owner]
    sentence = f"{owner}.{old} is deprecated and will be removed in the next release; use {owner}.{new}"
    found = deprecated(sentence, lambda: getattr(thing, old))
    expected = getattr(thing, new)
    assert found == expected
    assert type(found) is type(expected)


def test_a_renamed_method_can_be_called(objects: dict[str, Any], root: Path) -> None:
    branch = objects["Branch"]
    sentence = "Branch.put_into is deprecated and will be removed in the next release; use Branch.apply_to"
    found = deprecated(sentence, lambda: branch.put_into(root / "scenes" / "four_bar.yaml"))
    assert found.to_dict() == branch.apply_to(root / "scenes" / "four_bar.yaml").to_dict()


def test_reading_an_alias_from_its_class_does_not_warn() -> None:
    """As pydoc and inspect do, which list the members of classes."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gelenk.Mode.hertz is vars(gelenk.Mode)["hertz"]


def same(a: Any, b: Any) -> bool:
    return a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b))


def test_json_has_old_keys_beside_the_new_ones(objects: dict[str, Any], root: Path) -> None:
    report = objects["Inspection"].to_dict()
    mode = objects["Mode"].to_dict()
    assemblies = gelenk.assemblies(root / "scenes" / "four_bar.yaml").to_dict()
    renamed = {
        "Inspection": report,
        "Mode": mode,
        "Branch": assemblies["islands"][0]["branches"][0],
        "ModelSize": report["described"],
    }
    checked = 0
    for owner, old, new in RENAMED:
        data = renamed.get(owner, {})
        if new in data:
            assert same(data[old], data[new])
            checked += 1
    assert checked == 13
    assert report["mobility"]["freedoms"] == report["mobility"]["degrees_of_freedom"] == 1
    assert assemblies["parts"] == assemblies["islands"]
