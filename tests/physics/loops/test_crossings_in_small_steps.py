# SPDX-License-Identifier: BSD-3-Clause
"""Singular configurations are crossed with the requested accuracy,
however close to one a communication point is.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned

import gelenk
from gelenk.chart.mechanisms import equal_slider_crank
from gelenk.chart.scenes import equal_slider_crank_truth


@warned.TIGHT
@pytest.mark.parametrize("step", [1e-3, 1e-2])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "ida", "cvode", "cvode-adams"])
def test_slider_crank_with_equal_links_crosses_its_singularity_accurately(
    integrator: str, step: float
) -> None:
    """At 90 degrees, at 1.1814 s, the slider may continue or remain at rest. 0.3 ms from there, the closure
    error is divided by the distance to the singularity, and extrapolated values come from 0.1 s earlier.
    """
    times = np.linspace(step, 2, round(2 / step))
    truth = equal_slider_crank_truth(times)
    plant = gelenk.Simulation(equal_slider_crank(0.3, 2.0) | {"solver": {"integrator": integrator}})
    plant.initialize(0.0, 1e-10)
    worst = 0.0
    for k, t in enumerate(times):
        plant.step_to(float(t))
        for name, values in truth.items():
            scale = max(1.0, float(np.abs(values).max()))
            worst = max(worst, abs(plant.output(name) - float(values[k])) / scale)
    assert plant.diagnostics["solver.singular_positions"] == 1
    assert worst < 100 * 1e-10, f"{worst:.3g}"
