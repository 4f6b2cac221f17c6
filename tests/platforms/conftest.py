# SPDX-License-Identifier: BSD-3-Clause
"""Folders that the tests of other machines share."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def wine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where Wine keeps its files; filling it takes longer than a run."""
    return tmp_path_factory.mktemp("wine")


@pytest.fixture(scope="session")
def hosts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of compiled hosts."""
    return tmp_path_factory.mktemp("hosts")
