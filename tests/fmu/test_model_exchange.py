# SPDX-License-Identifier: BSD-3-Clause
"""FMUs for model exchange: an importer integrates their states."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import gelenk

from .host import Fmu

# s: runs beyond are so sensitive that start values which differ by rounding change them by more than the
# bound (docs/fmu.md, Other platforms). With these torques, the lower links of the five-bar are in line at
# 0.95 s, where the angles of its motors do not determine its position.
PREDICTABLE = {"five_bar": 0.9, "free_body": 10.0}
# N m: what would be at rest otherwise
TORQUES = {
    "balancing_robot": {"motor_left.tau": 0.02, "motor_right.tau": 0.013},
    "five_bar": {"motor_left.tau": 0.003, "motor_right.tau": -0.002},
}
TOLERANCE = 1e-9


def extracted(source: object, folder: Path) -> Fmu:
    found = gelenk.export_fmu(source, folder / "x.fmu")  # type: ignore[arg-type]
    return Fmu(fmpy.extract(str(found), str(folder / "extracted")))


def scenes(root: Path) -> list[Path]:
    return sorted((root / "scenes").glob("*.yaml"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "shipped" in metafunc.fixturenames:
        files = scenes(Path(__file__).resolve().parents[2])
        metafunc.parametrize("shipped", files, ids=lambda file: file.stem)


def test_cvode_outside_agrees_with_co_simulation(shipped: Path, tmp_path: Path) -> None:
    """All shipped scenes, in fmpy's own loop for model exchange and in that of gelenk.simulate.

    The backward differentiation formulas of CVODE need a tolerance of 1e-12 for errors of 1e-7; at 1e-9 these
    are up to 2e-5.
    """
    fmu = gelenk.export_fmu(shipped, tmp_path / "x.fmu")
    assert validate_fmu(str(fmu)) == []
    description = fmpy.read_model_description(str(fmu))
    stop = PREDICTABLE.get(shipped.stem, float(description.defaultExperiment.stopTime))
    step = stop / 200  # CVODE of fmpy makes at most 500 steps in each
    torques = TORQUES.get(shipped.stem, {})
    inside, outside = (
        gelenk.simulate(fmu, stop=stop, step=step, tolerance=TOLERANCE, inputs=torques, kind=kind)
        for kind in ("cs", "me")
    )
    by_fmpy = fmpy.simulate_fmu(
        str(fmu),
        fmi_type="ModelExchange",
        start_values=torques,
        stop_time=stop,
        output_interval=step,
        relative_tolerance=TOLERANCE / 1000,
        output=list(inside.names),
    )
    for name in inside.names:
        bound = 100 * TOLERANCE * max(1.0, np.abs(inside[name]).max())
        np.testing.assert_allclose(outside[name], inside[name], rtol=0, atol=bound, err_msg=name)
        np.testing.assert_allclose(by_fmpy[name], inside[name], rtol=0, atol=bound, err_msg=name)
