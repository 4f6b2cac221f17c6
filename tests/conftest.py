# SPDX-License-Identifier: BSD-3-Clause
"""Fixtures that several tests share."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import blocks

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


@pytest.fixture
def folder(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with the scenes of the repository and the scenes of README and the tutorials."""
    (tmp_path / "scenes").symlink_to(root / "scenes")
    (tmp_path / "car.yaml").symlink_to(root / "docs" / "gallery" / "car" / "scene.yaml")
    (tmp_path / "four_bar.yaml").write_text(blocks(root / "README.md", "yaml")[0], encoding="utf-8")
    pages = (
        ("tutorial-lqr", "balancer"),
        ("tutorial-wheels", "robot"),
        ("tutorial-stiction", "axis"),
        ("tutorial-gripper", "gripper"),
    )
    for page, name in pages:
        pieces = blocks(root / "docs" / f"{page}.md", "yaml")
        (tmp_path / f"{name}.yaml").write_text("".join(pieces), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path
