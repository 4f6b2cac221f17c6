# SPDX-License-Identifier: BSD-3-Clause
"""Bars fully extended between two pins: at this one position a constraint
equation is redundant, yet each is required.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import Scene, frame, joint, rod, scene
from samples import thorough_beyond

import gelenk


def stretched(count: int, slack: float) -> Scene:
    """Bars that are longer [m] in total by `slack` than the distance of one meter
    between the pins, deflected in the middle.
    """
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
    out["solver"] = {"integrator": "rk4"}  # which does not reduce its step size
    return out


def closure_error_and_range(count: int, slack: float) -> tuple[float, float]:
    """Return the closure error at the end pin [m], computed from the angles,
    and the range of the first bar's angle [rad].
    """
    found = gelenk.simulate(stretched(count, slack), stop=0.5, step=0.01, inputs={"pull.tau": 0.3})
    angles = np.cumsum([found[f"j{i}.phi"] for i in range(count)], axis=0)
    ends = (1 + slack) / count * np.exp(1j * angles).sum(axis=0)
    return float(np.abs(ends - 1).max()), float(np.ptp(found["j0.phi"]))


@warned.CONTRADICTING
@warned.SINGULAR
@pytest.mark.parametrize("count", thorough_beyond([2, 3], [2]))
def test_fully_extended_chain_remains_closed(count: int) -> None:
    """Constraint equations are classified as redundant only if they are at several positions, and here there
    is only one. With one of them removed the bars swung round by half a meter and more.
    """
    size = gelenk.inspect(gelenk.load(stretched(count, 0.0))).to_dict()["reduced"]
    assert size["constraint_equations"] == 2
    with pytest.raises(gelenk.StepError, match="constraint projection did not converge"):
        closure_error_and_range(count, 0.0)


@warned.AMBIGUOUS
@pytest.mark.parametrize("count", [3, 4, 5])
def test_chain_with_slack_moves_and_remains_closed(count: int) -> None:
    gap, turned = closure_error_and_range(count, 0.01)
    assert turned > 0.05
    assert gap < 1e-12  # as loops close
