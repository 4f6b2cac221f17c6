# SPDX-License-Identifier: BSD-3-Clause
"""Expressions of laws and friction on the coordinates of joints with several."""

from __future__ import annotations

import numpy as np
import pytest

import gelenk

OWN = {
    "universal": (("phi_a", "w_a"), ("phi_b", "w_b")),
    "cylindrical": (("phi", "w"), ("s", "v")),
    "planar": (("s_x", "v_x"), ("s_y", "v_y"), ("phi", "w")),
}


@pytest.mark.parametrize("kind", OWN)
def test_expressions_name_the_coordinate_and_its_speed(kind: str) -> None:
    """Those of laws, and of friction, in which the speed is its size: as signals of the joint, "J.phi_a"."""
    runs = []
    for own in (True, False):
        names = {q: (q, v) if own else (f"J.{q}", f"abs(J.{v})") for q, v in OWN[kind]}
        joint = {
            "type": kind,
            "parent": "ground",
            "child": "b",
            "law": {q: {"effort": f"-30*{of} - {of}^3"} for q, (of, _) in names.items()},
            "friction": {q: {"law": f"1 + 0.2*exp(-{v})"} for q, (_, v) in names.items()},
            "start": dict.fromkeys(names, 0.3),
        }
        source = {
            "gelenk": 1,
            "gravity": [1.0, 2.0, -9.81],
            "bodies": {"b": {"mass": 1.0, "com": [0.1, 0.2, 0.05], "inertia": [0.2, 0.3, 0.25]}},
            "joints": {"J": joint},
        }
        runs.append(gelenk.simulate(source, stop=1.0, step=0.1, tolerance=1e-9, integrator="erk"))
    for q, v in OWN[kind]:
        for name in (f"J.{q}", f"J.{v}"):
            np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=0, atol=1e-7, err_msg=name)
    assert max(np.abs(runs[0][f"J.{v}"]).max() for _, v in OWN[kind]) > 0.5


def test_a_variable_of_another_coordinate_is_refused() -> None:
    source = {
        "gelenk": 1,
        "bodies": {"b": {"mass": 1.0, "inertia": [0.2, 0.3, 0.25]}},
        "joints": {
            "J": {"type": "universal", "parent": "ground", "child": "b", "law": {"phi_a": {"effort": "-phi"}}}
        },
    }
    with pytest.raises(gelenk.SceneError, match="found 'phi', expected one of phi_a, w_a, t, "):
        gelenk.load(source)
