# SPDX-License-Identifier: BSD-3-Clause
from pathlib import Path

import pytest

from .c_hosts import compiled


@pytest.fixture(scope="module")
def host(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The host written in C that the module names as HOST."""
    found = compiled(request.module.HOST, tmp_path_factory.mktemp("host"))
    if found is None:
        pytest.skip("no C compiler")
    return found
