# SPDX-License-Identifier: BSD-3-Clause
"""What an FMU warns of: singular positions that were passed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy

import gelenk
from gelenk.chart.mechanisms import four_bar_chain


def test_singular_positions_are_logged_as_warnings(tmp_path: Path) -> None:
    """A falling parallelogram has its bars in line at 0.7088 and 1.2160 s (its pendulum by quadrature)."""
    fmu = gelenk.export_fmu(four_bar_chain(1), tmp_path / "w.fmu")
    said: list[tuple[int, bytes, str]] = []

    def logger(_env: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
        said.append((status, category, message.decode()))

    found = fmpy.simulate_fmu(str(fmu), stop_time=2, logger=logger, output=["solver.singular_positions"])
    assert found["solver.singular_positions"][-1] == 2
    warnings = [
        message for status, category, message in said if (status, category) == (1, b"logStatusWarning")
    ]
    assert [round(float(w.split()[2]), 2) for w in warnings] == [0.71, 1.22]
    assert all("singular configuration" in w for w in warnings)
    step = 0.01
    times = gelenk.simulate(fmu, stop=2, step=step).singular_positions
    # Told at the point after an evaluation beyond it, which may be the next step's.
    assert [0 < told - passed < 2 * step for told, passed in zip(times, (0.7088, 1.2160), strict=True)] == [
        True
    ] * 2
