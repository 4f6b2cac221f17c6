# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures that several tests share."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import ROOT

import gelenk


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


@pytest.fixture
def folder(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with the scenes of the repository."""
    (tmp_path / "scenes").symlink_to(root / "scenes")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, in which a page of the documentation finds only what it says itself."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
