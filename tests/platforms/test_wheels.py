# SPDX-License-Identifier: BSD-3-Clause
"""The wheels of `make wheels` in an environment of their own, without a compiler."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from pages import blocks

pytestmark = pytest.mark.platforms
ROOT = Path(__file__).resolve().parents[2]
WHEELS = sorted((ROOT / "build" / "wheels").glob("gelenk-*.whl"))
RUNTIMES = sorted((ROOT / "build" / "runtimes" / "dist").glob("gelenk_runtimes-*.whl"))


@pytest.fixture(scope="module")
def wheel() -> Path:
    if not WHEELS:
        pytest.skip("build/wheels has no wheel: `make wheels` builds it")
    return WHEELS[-1]


def test_one_wheel_serves_all_pythons_and_old_systems(wheel: Path) -> None:
    """The tag that auditwheel has verified: Python 3.12 or later, a glibc of 2018 or older."""
    _, _, python, abi, platforms = wheel.stem.split("-")
    assert (python, abi) == ("cp312", "abi3")
    versions = [
        tuple(map(int, tag.split("_")[1:3])) for tag in platforms.split(".") if tag.startswith("manylinux_")
    ]
    assert min(versions) <= (2, 28)
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert "gelenk/_core.abi3.so" in names
    assert "gelenk/runtime/linux64/gelenk_fmu.so.gz" in names
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_the_readme_runs_where_there_is_no_compiler(wheel: Path, tmp_path: Path) -> None:
    """Only pip and the wheels; the libraries for other platforms, too, if `make runtimes` has built them."""
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "venv")], check=True)
    programs = tmp_path / "venv" / "bin"
    place = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    place |= {"PATH": str(programs), "CC": "/nonexistent", "CXX": "/nonexistent"}
    assert shutil.which("cc", path=place["PATH"]) is None

    def said(*command: str) -> str:
        done = subprocess.run(
            command, cwd=tmp_path, env=place, capture_output=True, text=True, timeout=600, check=False
        )
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        return done.stdout

    said(str(programs / "pip"), "install", "--only-binary=:all:", str(wheel), *map(str, RUNTIMES[-1:]))
    gelenk = str(programs / "gelenk")
    (tmp_path / "four_bar.yaml").write_text(blocks(ROOT / "README.md", "yaml")[0], encoding="utf-8")
    assert "1 degree of freedom" in said(gelenk, "check", "four_bar.yaml")
    wanted = ["--platforms", "all"] if RUNTIMES else []
    assert "FourBar" in said(gelenk, "export", "four_bar.yaml", "-o", "FourBar.fmu", *wanted)
    with zipfile.ZipFile(tmp_path / "FourBar.fmu") as archive:
        platforms = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert platforms == ({"linux64", "aarch64-linux", "win64", "darwin64"} if RUNTIMES else {"linux64"})
    assert "2001 rows" in said(
        gelenk, "simulate", "FourBar.fmu", "--stop", "2", "--set", "drive.tau=3", "--output", "run.csv"
    )
