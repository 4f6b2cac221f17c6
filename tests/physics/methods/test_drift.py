# SPDX-License-Identifier: BSD-3-Clause
"""An hour of a conservative four-bar: what accumulates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from models.running import assert_close, run

import gelenk

ROOT = Path(__file__).parents[3]


def test_an_hour_of_a_conservative_four_bar() -> None:
    source = gelenk.load(ROOT / "scenes" / "four_bar.yaml").to_dict()
    for joint in source["joints"].values():
        joint.pop("damping", None)
    found = run(source, np.linspace(0, 3600, 3601), tolerance=1e-10)
    assert found["constraints.position"].max() < 1e-10  # m; closed after every step, so 1e-14
    assert found["constraints.velocity"].max() < 1e-9  # m/s; likewise 1e-12
    total, swing = found["energy.total"], np.ptp(found["energy.potential"])
    assert_close("energy", total, total[0], 1e-7 * swing, "150,000 steps, each some 1e-11 of the range")
