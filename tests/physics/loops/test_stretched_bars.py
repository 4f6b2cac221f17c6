# SPDX-License-Identifier: BSD-3-Clause
"""Bars stretched in line between two pins: at that one position a row repeats another, and yet each holds."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import Scene, frame, joint, rod, scene

import gelenk


def stretched(count: int, slack: float) -> Scene:
    """Bars that are so much longer [m] in all than the metre between the pins, pulled aside in the middle."""
    length = (1 + slack) / count
    joints = {
        f"j{i}": joint(
            "revolute",
            frame(f"b{i - 1}", (length, 0, 0)) if i else frame("ground"),
            frame(f"b{i}"),
            axis=[0, 0, 1],
        )
        for i in range(count)
    }
    last = frame(f"b{count - 1}", (length, 0, 0))
    joints["end"] = joint("revolute", frame("ground", (1, 0, 0)), last, axis=[0, 0, 1])
    out = scene({f"b{i}": rod(1, length) for i in range(count)}, joints)
    out["motors"] = {"pull": {"joint": "j1"}}
    out["solver"] = {"integrator": "rk4"}  # which does not try ever shorter steps
    return out


def opened(count: int, slack: float) -> tuple[float, float]:
    """How far the bars' end leaves its pin [m], told by the angles; how far the first bar turns [rad]."""
    found = gelenk.simulate(stretched(count, slack), stop=0.5, step=0.01, inputs={"pull.tau": 0.3})
    angles = np.cumsum([found[f"j{i}.phi"] for i in range(count)], axis=0)
    ends = (1 + slack) / count * np.exp(1j * angles).sum(axis=0)
    return float(np.abs(ends - 1).max()), float(np.ptp(found["j0.phi"]))


@pytest.mark.parametrize("count", [2, 3])
def test_what_is_stretched_does_not_open(count: int) -> None:
    """Rows are told to repeat others only where that was seen at several positions, and here is but one. With
    one of them left out the bars swung round by half a metre and more.
    """
    size = gelenk.inspect(gelenk.load(stretched(count, 0.0))).to_dict()["reduced"]
    assert size["constraint_equations"] == 2
    with pytest.raises(gelenk.StepError, match="constraint projection did not converge"):
        opened(count, 0.0)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_what_is_slack_moves_and_stays_closed(count: int) -> None:
    gap, turned = opened(count, 0.01)
    assert turned > 0.05
    assert gap < 1e-12  # as loops close
