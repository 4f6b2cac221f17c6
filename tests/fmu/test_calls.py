# SPDX-License-Identifier: BSD-3-Clause
"""Right and wrong calls of the FMI functions, each scenario in a process of its own."""

from __future__ import annotations

from pathlib import Path

import fmpy
import programs
import pytest

import gelenk

from .plants import crank_rocker
from .scenarios import SCENARIOS

TESTS = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def crank_rocker_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(crank_rocker(), tmp_path_factory.mktemp("fmu") / "crank_rocker.fmu")


@pytest.mark.parametrize("name", SCENARIOS)
def test_calls(name: str, crank_rocker_fmu: Path, tmp_path: Path) -> None:
    folder = Path(fmpy.extract(str(crank_rocker_fmu), str(tmp_path / "extracted")))
    run = programs.run("-m", "fmu.scenarios", name, folder, cwd=tmp_path, env={"PYTHONPATH": str(TESTS)})
    assert run.returncode == 0, f"exit code {run.returncode}\n{run.stdout}\n{run.stderr}"
    if run.stdout.startswith("skip: "):
        pytest.skip(run.stdout)
    assert run.stdout.endswith("done\n")
    assert run.stderr == ""  # nothing but the logger speaks
