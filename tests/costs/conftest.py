# SPDX-License-Identifier: BSD-3-Clause
from pathlib import Path

import pytest
from fmu.c_hosts import compiled

from .counting import HERE


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """cost_host.c, compiled."""
    found = compiled("cost_host", tmp_path_factory.mktemp("host"), where=HERE)
    if found is None:
        pytest.skip("no C compiler")
    return found
