# SPDX-License-Identifier: BSD-3-Clause
"""What an FMU warns of: singular positions that were passed, time steps instead of located events."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
from models.vibrating import STEPPING_BOXES, vibration

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


def test_time_steps_are_logged_as_warnings(tmp_path: Path) -> None:
    """Boxes with 20 closed points of contact are solved in time steps, with events logged or not."""
    fmu = gelenk.export_fmu(vibration(3, 0.3, STEPPING_BOXES), tmp_path / "w.fmu")
    said: list[tuple[bytes, str]] = []

    def logger(_env: Any, _name: bytes, _status: int, category: bytes, message: bytes) -> None:
        said.append((category, message.decode()))

    fmpy.simulate_fmu(str(fmu), stop_time=0.1, logger=logger, debug_logging=False)
    warned = [message for category, message in said if category == b"logStatusWarning"]
    assert [
        w for w in warned if "time steps with impulses from here on, since very many points" in w
    ] == warned
    assert len(warned) == 1
    found = gelenk.simulate(fmu, stop=0.1, outputs=["solver.step_error"])
    begin, end = found.warnings
    assert begin.endswith(
        "time steps with impulses from here on, since very many points of contact are closed"
    )
    assert end == (
        "time steps with impulses at the end, with an estimated error of "
        f"{found['solver.step_error'][-1]:.2g} (m, rad)"
    )
    few = gelenk.export_fmu(vibration(3, 0.3, 1), tmp_path / "few.fmu")
    assert gelenk.simulate(few, stop=0.1).warnings == ()
