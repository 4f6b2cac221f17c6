# SPDX-License-Identifier: BSD-3-Clause
"""A tighter tolerance gives a smaller error, also where the integrator takes another method for it."""

from __future__ import annotations

import numpy as np
import pytest
import scene_files
from numpy.typing import NDArray

import gelenk

TOLERANCES = (1e-5, 1e-6, 3.1e-7, 2.9e-7, 1e-7, 1e-8, 1e-9)  # order 8 takes over at 3e-7


STARTS = [k * 1e-13 for k in range(15)]  # rad or rad/s, beside the start: rounding


def positions(
    name: str, step: float, stop: float, tolerance: float, integrator: str, beside: float = 0.0
) -> NDArray[np.float64]:
    source = gelenk.load(scene_files.SCENES / f"{name}.yaml").to_dict()
    source.setdefault("solver", {})["integrator"] = integrator
    for entry in source["joints"].values():
        for quantity in set(entry.get("start", {})) & {"phi", "w"}:
            entry["start"][quantity] = np.add(entry["start"][quantity], beside).tolist()
    run = gelenk.simulate(source, stop=stop, step=step, tolerance=tolerance)
    return np.array(
        [run[n] for n in run.names if n.rpartition(".")[2].partition("[")[0] in ("phi", "s", "w", "v")]
    )


@pytest.mark.parametrize("integrator", ["auto", "erk"])
@pytest.mark.parametrize(("name", "step"), [("four_bar", 0.1), ("four_bar", 1.0), ("heavy_top", 0.5)])
def test_error_falls_with_the_tolerance(name: str, step: float, integrator: str) -> None:
    """Within a factor of 3: the errors of the steps have chance signs; with equal steps they vary by 2.5.

    Rounding decides on which steps are rejected, and the error with it, up to a factor of 7 at 1e-7: so the
    largest error of 15 starts counts that differ by rounding. Without calibration of the pair of order 8, the
    factor was 20 to 40. The reference has a hundredth of the smallest tolerance.
    """
    stop = 5.0
    exact = positions(name, step, stop, 1e-11, "erk")
    errors = [
        max(np.abs(positions(name, step, stop, t, integrator, d) - exact).max() for d in STARTS)
        for t in TOLERANCES
    ]
    for k, tight in enumerate(errors):
        assert tight <= 3 * min(errors[:k], default=np.inf), dict(zip(TOLERANCES, errors, strict=True))
