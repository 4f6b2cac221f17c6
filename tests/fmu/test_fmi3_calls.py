# SPDX-License-Identifier: BSD-3-Clause
"""Right and wrong calls of the functions of FMI 3.0, each scenario in a process of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

import gelenk

from .plants import crank_rocker, with_circuit
from .scenarios import EXCHANGE_OF_FMI_3, SCENARIOS_OF_FMI_3
from .test_calls import succeed


@pytest.fixture(scope="module", params=[crank_rocker, with_circuit])
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(request.param(), tmp_path_factory.mktemp("fmu") / "x.fmu", view=False, fmi=3)


@pytest.mark.parametrize("name", SCENARIOS_OF_FMI_3)
def test_calls(name: str, fmu: Path, tmp_path: Path) -> None:
    succeed(name, fmu, tmp_path)


@pytest.mark.parametrize("name", EXCHANGE_OF_FMI_3)
def test_calls_of_model_exchange(name: str, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", view=False, fmi=3)
    succeed(name, fmu, tmp_path)
