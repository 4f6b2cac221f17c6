# SPDX-License-Identifier: BSD-3-Clause
"""What sweeps keep of each run, compared with closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gelenk

W = 3.0  # rad/s
FLYWHEEL = {  # turns freely: phi = W t
    "gelenk": 1, "name": "Flywheel",
    "bodies": {"disc": {"mass": 1, "inertia": [0.1, 0.1, 0.1]}},
    "joints": {"A": {"type": "revolute", "axis": [0, 0, 1], "parent": "ground", "child": "disc",
                     "start": {"phi": 0, "w": W, "fixed": True}}},
}  # fmt: skip


def kept(outputs: Any, **options: Any) -> Any:
    return gelenk.sweep(
        FLYWHEEL, {"A.w_start": [W]}, outputs=outputs, **{"stop": 2.0, "step": 0.01} | options
    )


def test_reductions_of_a_linear_motion() -> None:
    """On phi = W t on [0, T]: mean W T / 2, rms W T / sqrt(3), beyond x at x / W."""
    how = ["last", "max", "min", "mean", "rms", "first>1", "first<-1", "first > -1"]
    found = kept({"A.phi": how, "A.w": "first<4"})
    phi = {name: float(found[f"A.phi.{name}"].values[0]) for name in how[:6]}
    # The integrator's tolerance is 1e-6; the trapezoidal rule with N = 200 steps exceeds the mean of
    # squares by 1 / (2 N^2) of it.
    assert phi["last"] == pytest.approx(2 * W, rel=1e-6)
    assert phi["max"] == phi["last"]
    assert phi["min"] == 0
    assert phi["mean"] == pytest.approx(W, rel=1e-6)
    assert phi["rms"] == pytest.approx(2 * W / math.sqrt(3), rel=1e-5)
    assert phi["first>1"] == pytest.approx(1 / W, rel=1e-6)
    assert math.isnan(found["A.phi.first<-1"].values[0])
    assert found["A.phi.first>-1"].values[0] == 0  # it is beyond it from the start
    assert found["A.w.first<4"].values[0] == 0
    assert {found[f"A.phi.{name}"].attrs["units"] for name in how[:5]} == {"rad"}
    assert found["A.phi.first>1"].attrs["units"] == "s"


def test_the_last_step_may_be_shorter() -> None:
    """Means weigh times, not rows: here the last of three steps has half the length."""
    found = kept({"A.phi": "mean"}, stop=1.0, step=0.4)
    assert found["A.phi.mean"].values[0] == pytest.approx(W / 2, rel=1e-6)


def test_own_functions_of_one_and_of_several_outputs() -> None:
    def span(_: Any, x: Any) -> float:
        return float(np.ptp(x))

    found = kept({"A.phi": [span, "last"], "product": (lambda t, x, w: (t * x * w)[-1], ["A.phi", "A.w"])})
    assert found["A.phi.span"].values[0] == found["A.phi.last"].values[0]
    assert found["product"].values[0] == pytest.approx(2 * 2 * W * W, rel=1e-6)


def test_patterns_name_several_outputs() -> None:
    found = kept({"A.*": "last"})
    assert {"A.phi.last", "A.w.last"} <= set(found)
    assert set(kept(["A.p*"])) == {"A.phi", "error", "warning"}


def test_events_are_counted_and_found() -> None:
    """A flywheel meets a stop at phi = 1.5, after 0.5 s."""
    joint = {**FLYWHEEL["joints"]["A"], "stop": {"lower": -6, "upper": 1.5, "stiffness": 1e4}}  # type: ignore[index]
    scene = {**FLYWHEEL, "joints": {"A": joint}}
    found = gelenk.sweep(
        scene, {"A.w_start": [W, -W]}, outputs={"events": ["count", "first:*upper*"]}, stop=1.0, step=0.01
    )
    assert found["events.first:*upper*"].values[0] == pytest.approx(0.5, abs=1e-6)  # the tolerance is 1e-6
    assert math.isnan(found["events.first:*upper*"].values[1])
    assert found["events.count"].values.tolist() == [2, 0]  # meets it, and leaves it


@pytest.mark.parametrize(
    ("outputs", "sentence"),
    [
        ({"A.phi": ["last", "last"]}, "A.phi.last: found twice, expected once"),
        ({"A.phi": "first>x"}, "A.phi: found the reduction 'first>x', expected trajectory, last, "),
        ({"events": "first:"}, "events: found 'first:', expected 'count' or 'first:PATTERN'"),
        ({"x": (max, ["A.z"])}, "A.z: no such output"),
        ([], "outputs: found none, expected at least one"),
    ],
)
def test_outputs_that_cannot_be_kept(outputs: Any, sentence: str) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        kept(outputs)
    assert sentence in str(caught.value)


def test_an_fmu_reports_no_events(four_bar_fmu: Any) -> None:
    with pytest.raises(gelenk.UsageError, match="events: found an FMU"):
        gelenk.sweep(four_bar_fmu, {"A.w_start": [1.0]}, outputs={"events": "count"}, stop=0.01)
