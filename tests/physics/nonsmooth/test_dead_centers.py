# SPDX-License-Identifier: BSD-3-Clause
"""Limits of a slider-crank at its dead center and beside it: there, forces on the slider move nothing."""

from __future__ import annotations

from typing import Any

import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

from .test_joint_friction import plant, read
from .test_joint_limits import INTEGRATORS


def slider_crank(w: float, **limit: float) -> Scene:
    """The slider S is 1.5 m from the crank's axis, as far as it can be."""
    joints: dict[str, Any] = {
        "A": joint("revolute", frame("ground"), frame("crank"), axis=[0, -1, 0],
                   start={"phi": 0.0, "w": w, "fixed": True}),
        "B": joint("revolute", frame("crank", (0.5, 0, 0)), frame("rod"), axis=[0, -1, 0]),
        "S": joint("prismatic", frame("ground"), frame("slider"), axis=[1, 0, 0], start={"s": 1.5},
                   limit=limit),
        "C": joint("revolute", frame("rod", (1, 0, 0)), frame("slider"), axis=[0, -1, 0]),
    }  # fmt: skip
    return scene({"crank": body(1.0), "rod": body(1.0), "slider": body(1.0)}, joints)


def test_start_that_nothing_can_keep_within_a_limit_is_refused() -> None:
    with pytest.raises(
        gelenk.SceneError, match=r"joints\.S\.limit\.lower: found a start with s at it, from which the"
    ):
        plant(slider_crank(1.0, lower=1.5))


@pytest.mark.parametrize(
    ("w", "limit"), [(1.0, {"upper": 1.5}), (0.0, {"lower": 1.5}), (1.0, {"lower": 1.49})]
)
def test_other_starts_at_a_dead_center_run(w: float, limit: dict[str, float]) -> None:
    simulation = plant(slider_crank(w, **limit))
    simulation.step_to(1.0)
    assert limit.get("lower", 0) - 1e-12 <= read(simulation, "S.s") <= 1.5 + 1e-12  # rounding of the loop


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_prescribed_motion_into_a_limit_is_refused(restitution: float, integrator: str) -> None:
    source = slider_crank(0.0, lower=1.4, restitution=restitution)
    source["joints"]["A"]["start"] = {"phi": 0.0}
    source["constraints"] = {"drive": {"type": "motion", "joint": "A", "polynomial": [0, 1.0]}}
    simulation = plant(source, 1e-8, integrator)
    reason = r"t = 0\.527\d* s: S\.s meets its lower limit, where no force can stop it"
    with pytest.raises(gelenk.StepError, match=reason):
        simulation.step_to(1.0)
    assert simulation.time == 0
