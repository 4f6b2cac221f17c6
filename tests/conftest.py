# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures that several tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

import gelenk

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def four_bar_file() -> Path:
    return ROOT / "scenes" / "four_bar.yaml"


@pytest.fixture(scope="session")
def four_bar(four_bar_file: Path) -> gelenk.Scene:
    return gelenk.load(four_bar_file)


@pytest.fixture(scope="session")
def four_bar_fmu(four_bar: gelenk.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(four_bar, tmp_path_factory.mktemp("fmu") / "FourBar.fmu")
