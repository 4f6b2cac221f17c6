# SPDX-License-Identifier: BSD-3-Clause
"""Accumulated errors of a conservative four-bar simulated for an hour."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from models.running import assert_close, run

import gelenk

ROOT = Path(__file__).parents[3]


def test_conservative_four_bar_runs_for_an_hour_without_drift() -> None:
    source = gelenk.load(ROOT / "scenes" / "four_bar.yaml").to_dict()
    for joint in source["joints"].values():
        joint.pop("damping", None)
    found = run(source, np.linspace(0, 3600, 3601), tolerance=1e-10)
    assert found["constraints.position"].max() < 1e-10  # m; closed after every step, so 1e-14
    assert found["constraints.velocity"].max() < 1e-9  # m/s; 1e-12 for the same reason
    total, swing = found["energy.total"], np.ptp(found["energy.potential"])
    assert_close("energy", total, total[0], 1e-7 * swing, "150,000 steps, each about 1e-11 of the range")
