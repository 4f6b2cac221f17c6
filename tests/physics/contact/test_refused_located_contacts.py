# SPDX-License-Identifier: BSD-3-Clause
"""What located contacts cannot do yet is refused by a message that names it."""

import pytest
from models.touching import SceneData, on_plane

import gelenk

from .test_located_contacts import ball

TETRAHEDRON = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]  # m


def test_too_many_impacts_are_refused() -> None:
    scene = ball(0.1, 0.7, {"r": [0, 0, 1.1]}, {"restitution": 0.9})
    scene["solver"] = {"integrator": "erk", "max_events": 5}
    with pytest.raises(gelenk.StepError, match="more than 5 events"):
        gelenk.simulate(scene, stop=5, step=5)


@pytest.mark.parametrize(
    ("shape", "other", "said"),
    [
        ({"cylinder": [0.1, 0.2]}, {"sphere": 1}, "a cylinder and a sphere"),
        ({"cylinder": [0.1, 0.2]}, {"cylinder": [0.1, 0.2]}, "two shapes of kind cylinder"),
        ({"hull": TETRAHEDRON}, {"box": [1, 1, 1]}, "a hull and a box"),
    ],
)
def test_other_pairs_are_refused(shape: SceneData, other: SceneData | None, said: str) -> None:
    scene = on_plane(shape, 1, [1, 1, 1], {"r": [0, 0, 2]}, {})
    if other is not None:
        scene["ground"]["shapes"] = {"block": {**other, "surface": "concrete"}}
    scene["solver"] = {"integrator": "erk"}
    with pytest.raises(gelenk.SceneError) as refused:
        gelenk.simulate(scene, stop=1)
    assert said in str(refused.value)
    assert "auto or moreau-jean" in str(refused.value)
