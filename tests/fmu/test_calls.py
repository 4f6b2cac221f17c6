# SPDX-License-Identifier: BSD-3-Clause
"""Right and wrong calls of the FMI functions, each scenario in a process of its own."""

from __future__ import annotations

from pathlib import Path

import fmpy
import programs
import pytest

import gelenk

from .plants import crank_rocker, with_circuit
from .scenarios import SCENARIOS

TESTS = Path(__file__).resolve().parent.parent


# Scenarios that concern what has states of its own.
OF_STATES = [
    name for name, of in SCENARIOS.items() if of.__module__ in ("fmu.states", "fmu.runs", "fmu.derivatives")
]


@pytest.fixture(scope="module")
def crank_rocker_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(crank_rocker(), tmp_path_factory.mktemp("fmu") / "crank_rocker.fmu")


@pytest.fixture(scope="module")
def fmu_with_circuit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(with_circuit(), tmp_path_factory.mktemp("fmu") / "with_circuit.fmu")


def succeed(name: str, fmu: Path, folder: Path) -> None:
    extracted = Path(fmpy.extract(str(fmu), str(folder / "extracted")))
    run = programs.run("-m", "fmu.scenarios", name, extracted, cwd=folder, env={"PYTHONPATH": str(TESTS)})
    assert run.returncode == 0, f"exit code {run.returncode}\n{run.stdout}\n{run.stderr}"
    if run.stdout.startswith("skip: "):
        pytest.skip(run.stdout)
    assert run.stdout.endswith("done\n")
    assert run.stderr == ""  # nothing but the logger speaks


@pytest.mark.parametrize("name", SCENARIOS)
def test_calls(name: str, crank_rocker_fmu: Path, tmp_path: Path) -> None:
    succeed(name, crank_rocker_fmu, tmp_path)


@pytest.mark.parametrize("name", OF_STATES)
def test_calls_with_element_states(name: str, fmu_with_circuit: Path, tmp_path: Path) -> None:
    succeed(name, fmu_with_circuit, tmp_path)
