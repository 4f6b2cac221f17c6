# SPDX-License-Identifier: BSD-3-Clause
"""Floating-point modes.

The host's is as it was after each call and changes no bits; and no number is so small that the processor
takes a hundred times as long over it.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from mechanisms import body, frame, joint, scene

import gelenk

from .c_hosts import extracted

HOST = "floating_point_host"
NO_SUCH_MODES = 77


def lives(host: Path, fmu: Path, folder: Path, steps: int) -> tuple[int, int]:
    run = subprocess.run(
        [str(host), *extracted(fmu, folder), str(steps)],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    if run.returncode == NO_SUCH_MODES:
        pytest.skip("modes as x86-64 has them")
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    modes, small = map(int, run.stdout.split())
    return modes, small


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida"])
def test_modes_of_the_host_stay_and_change_nothing(
    integrator: str, four_bar: gelenk.Scene, host: Path, tmp_path: Path
) -> None:
    source = four_bar.to_dict()
    source["solver"] = {"integrator": integrator}
    modes, _ = lives(host, gelenk.export_fmu(source, tmp_path / "x.fmu"), tmp_path / "x", 50)
    assert modes > 5


def test_rest_is_reached_through_no_small_numbers(host: Path, tmp_path: Path) -> None:
    """Damped motion decays without end; from 2e-308 on, and from 1e-154 on for squares, to zero."""
    source = scene(
        {f"b{i}": body(1.0, (0.02, 0, 0.1), (0.01, 0.012, 0.01)) for i in range(2)},
        {
            "A": joint("revolute", frame("ground"), frame("b0"), axis=[0, 1, 0], damping=10,
                       start={"phi": 0, "w": 1e-303, "fixed": True}),
            "B": joint("revolute", frame("b0", (0, 0, 0.2)), frame("b1"), axis=[1, 0, 0], damping=10,
                       start={"phi": 0, "w": 1e-306, "fixed": True}),
        },
        motors={"drive": {"joint": "A"}},
        solver={"integrator": "rk4", "step": 1e-3},
    )  # fmt: skip
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    _, small = lives(host, fmu, tmp_path / "x", 300)
    assert small == 0
