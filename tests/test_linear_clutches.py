# SPDX-License-Identifier: BSD-3-Clause
"""Linear models with clutches and brakes: released, engaged a little, and fully engaged."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk.linear import linear_model

J, K = (0.7, 0.2), (90.0, 40.0)  # kg m2, N m/rad
ABOUT_X = {"axis": [1, 0, 0]}


def clutch(load: float = 0.0, friction: dict[str, Any] | None = None) -> dict[str, Any]:
    """Two disks on springs, joined by a clutch; `load` turns the springs' references against each other."""
    bodies = {
        name: body(1, inertia=(inertia, 1, 1)) for name, inertia in zip(("disk_a", "disk_b"), J, strict=True)
    }
    friction = friction or {"coulomb": 5, "static": 6, "input": "engagement"}
    joints = {
        name: joint("revolute", frame("ground"), frame(f"disk_{name}"), stiffness=k,
                    spring_reference=sign * load / k, start={"phi": 0.0, "w": 0.0, "fixed": True}, **ABOUT_X)
        for name, k, sign in zip("ab", K, (1, -1), strict=True)
    }  # fmt: skip
    joints["c"] = joint("revolute", frame("disk_a"), frame("disk_b"), friction=friction, **ABOUT_X)
    return scene(bodies, joints, name="Clutch")


def frequencies(poles: Any) -> list[float]:
    """Of the oscillations; where the clutch holds, the disks' relative position has a pole of 0."""
    poles = np.asarray(poles)
    assert abs(poles.real).max() < 1e-6 * abs(poles).max()  # double poles of 0: square root of rounding
    return sorted(float(x) for x in poles.imag if x > 1e-6 * abs(poles).max())


FREE = sorted(math.sqrt(k / j) for j, k in zip(J, K, strict=True))
LOCKED = [math.sqrt(sum(K) / sum(J))]


@pytest.mark.parametrize(
    ("engagement", "expected"),
    [(None, FREE), (0.0, FREE), (-0.5, FREE), (1e-6, LOCKED), (0.3, LOCKED), (1.0, LOCKED)],
)
def test_open_clutch_is_released_and_a_closed_one_locked(
    engagement: float | None, expected: list[float]
) -> None:
    """At rest without load, the slightest engagement holds; a disengaged clutch holds nothing."""
    values = {} if engagement is None else {"c.friction.engagement": engagement}
    model = linear_model(clutch(), input_values=values)
    assert frequencies(np.linalg.eigvals(model.A)) == pytest.approx(expected, rel=1e-12)
    assert not model.residual_rates
    found = gelenk.modes(clutch(), input_values=values)
    assert frequencies([m.eigenvalue for m in found.modes]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("load", "engagement"), [(2.0, 0.0), (2.0, 0.34)])
def test_loaded_clutch_is_locked_where_it_holds(load: float, engagement: float) -> None:
    """Each disk is turned by 2 N m: static friction, 6 N m, holds that from an engagement of 1/3 on.

    Both disks rest at their start while it holds only if what the springs exert on the locked disks cancels.
    """
    model = linear_model(clutch(load), input_values={"c.friction.engagement": engagement})
    assert frequencies(np.linalg.eigvals(model.A)) == pytest.approx(
        LOCKED if engagement > 1 / 3 else FREE, rel=1e-12
    )
    assert bool(model.residual_rates) == (engagement < 1 / 3)


def test_clutch_that_begins_to_slip_has_no_derivatives() -> None:
    with pytest.raises(gelenk.UsageError, match=r"joints\.c\.friction is between two modes"):
        linear_model(clutch(2.0), input_values={"c.friction.engagement": 0.32})


def test_friction_of_zero_is_none() -> None:
    assert frequencies(np.linalg.eigvals(linear_model(clutch(friction={"coulomb": 0})).A)) == pytest.approx(
        FREE, rel=1e-12
    )


def test_fmu_of_an_open_clutch_has_directional_derivatives(tmp_path: Any) -> None:
    fmu = gelenk.export_fmu(clutch(), tmp_path / "Clutch.fmu")
    assert frequencies(np.linalg.eigvals(linear_model(fmu).A)) == pytest.approx(FREE, rel=1e-12)


@pytest.mark.parametrize("engagement", [0.0, 1e-6, 1.0])
def test_released_treatment_does_not_depend_on_engagement(engagement: float) -> None:
    model = linear_model(clutch(), friction="off", input_values={"c.friction.engagement": engagement})
    assert frequencies(np.linalg.eigvals(model.A)) == pytest.approx(FREE, rel=1e-12)
