# SPDX-License-Identifier: BSD-3-Clause
"""The module native_units, built incrementally on first use."""

from __future__ import annotations

import fcntl
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
SANITIZE = os.environ.get("GELENK_SANITIZE", "OFF")  # set by `make units`; the CMake option of that name
BUILD = HERE.parent.parent / "build" / ("native" if SANITIZE == "OFF" else f"native_{SANITIZE}")


@pytest.fixture(scope="session")
def units() -> Any:
    """The compiled module; building takes about 25 s of CPU time, during which other workers wait."""
    scripts = Path(sys.executable).parent
    environment = {**os.environ, "PATH": os.pathsep.join([str(scripts), os.environ.get("PATH", "")])}
    environment.pop("LD_PRELOAD", None)  # a sanitizer for this process only
    missing = [tool for tool in ("cmake", "ninja") if not shutil.which(tool, path=environment["PATH"])]
    missing += [name for name in ("nanobind", "sundials4py") if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed: pip install --group lint")
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        options = [f"-DPython_EXECUTABLE={sys.executable}", f"-DGELENK_SANITIZE={SANITIZE}"]
        configure = ["cmake", "-S", str(HERE), "-B", str(BUILD), "-G", "Ninja", *options]
        for command in (configure, ["cmake", "--build", str(BUILD), "-j", "2"]):
            done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stdout + done.stderr
    (library,) = BUILD.glob("native_units*.so")
    spec = importlib.util.spec_from_file_location("native_units", library)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
