# SPDX-License-Identifier: BSD-3-Clause
"""The core as WebAssembly in Node, for tests."""

from __future__ import annotations

import json
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from gelenk.viewer.computing import core_file, has_core

PROGRAM = Path(__file__).parent / "run_core.js"
WITHOUT = "the core for pages has not been built: make page-core"


def answers(*jobs: dict[str, Any]) -> list[Any]:
    """Return what Node answers to jobs of run_core.js. Skips the test without the core or Node."""
    if not has_core():
        pytest.skip(WITHOUT)
    node = shutil.which("node")
    if node is None:
        pytest.skip("Node is not installed (Debian: nodejs)")
    worker = str(files("gelenk.viewer") / "worker")
    done = subprocess.run(
        [node, str(PROGRAM), str(core_file()), worker],
        input=json.dumps(jobs), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert isinstance(out, list)
    return out
