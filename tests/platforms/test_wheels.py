# SPDX-License-Identifier: BSD-3-Clause
"""The wheels of `make wheels` in an environment of their own, without a compiler."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from .machines import ARM

pytestmark = pytest.mark.platforms
ROOT = Path(__file__).resolve().parents[2]
BUILT = ROOT / "build" / "wheels"
WHEELS = sorted(BUILT.glob("gelenk-*x86_64.whl"))
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


class Environment:
    """A virtual environment of its own, in which programs find no compiler."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
        self.programs = folder / "venv" / "bin"
        place = {
            name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")
        }
        self.place = place | {"PATH": str(self.programs), "CC": "/nonexistent", "CXX": "/nonexistent"}
        assert shutil.which("cc", path=self.place["PATH"]) is None

    def said(self, program: str, *arguments: str) -> str:
        """What a program of the environment prints."""
        done = subprocess.run(
            [str(self.programs / program), *arguments], cwd=self.folder, env=self.place, capture_output=True,
            text=True, timeout=600, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        return done.stdout

    def first_fmu(self, wheel: Path) -> None:
        """Install Gelenk and export the scene of the first pages, for the platforms of `make runtimes`."""
        self.said("pip", "install", "--only-binary=:all:", str(wheel), *map(str, RUNTIMES[-1:]))
        scene = (ROOT / "scenes" / "four_bar.yaml").read_text(encoding="utf-8")
        (self.folder / "four_bar.yaml").write_text(scene, encoding="utf-8")
        wanted = ["--platforms", "all"] if RUNTIMES else []
        assert "FourBar" in self.said("gelenk", "export", "four_bar.yaml", "-o", "FourBar.fmu", *wanted)


def test_the_readme_runs_where_there_is_no_compiler(wheel: Path, tmp_path: Path) -> None:
    environment = Environment(tmp_path)
    environment.first_fmu(wheel)
    assert "1 degree of freedom" in environment.said("gelenk", "check", "four_bar.yaml")
    with zipfile.ZipFile(tmp_path / "FourBar.fmu") as archive:
        platforms = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert platforms == ({"linux64", "aarch64-linux", "win64", "darwin64"} if RUNTIMES else {"linux64"})
    assert "2001 rows" in environment.said(
        "gelenk", "simulate", "FourBar.fmu", "--stop", "2", "--set", "drive.tau=3", "--output", "run.csv"
    )


@pytest.mark.clock
def test_the_first_fmu_takes_less_than_a_minute(wheel: Path, tmp_path: Path) -> None:
    """From a new environment, with what pip downloads."""
    begin = time.perf_counter()
    Environment(tmp_path).first_fmu(wheel)
    seconds = time.perf_counter() - begin
    print(f"{seconds:.1f} s")
    assert seconds < 60


# The folder that tests/platforms/arm_python.sh fills: Python for ARM, and what gelenk requires.
ARM_PYTHON = Path(os.environ.get("GELENK_ARM_PYTHON", "/nonexistent"))
ARM_README = """
import sys
import gelenk
from gelenk.io import export

print(export.native_platform())
fmu = gelenk.export_fmu(gelenk.load(sys.argv[1]), sys.argv[2])
run = gelenk.simulate(fmu, stop=2.0)
print(run["A.phi"][-1].hex())
"""


@pytest.mark.skipif(bool(ARM.missing), reason=ARM.missing)
def test_the_wheel_for_arm_exports_and_runs_an_fmu(tmp_path: Path, four_bar_file: Path) -> None:
    """In QEMU, with the requirements from PyPI; the result is that of this machine."""
    wheels = sorted(BUILT.glob("gelenk-*aarch64.whl"))
    if not ARM_PYTHON.exists() or not wheels:
        pytest.skip(
            "GELENK_ARM_PYTHON names no folder of tests/platforms/arm_python.sh, or there is no wheel"
        )
    with zipfile.ZipFile(wheels[-1]) as archive:
        archive.extractall(tmp_path / "wheel")
    programs = [program for name in ARM.programs if (program := shutil.which(name))]
    python = [programs[0], "-L", str(ARM_PYTHON), str(ARM_PYTHON / "usr" / "bin" / "python3.13")]
    path = f"{tmp_path / 'wheel'}{os.pathsep}{ARM_PYTHON / 'site'}"
    found: list[float] = []
    for number, command in enumerate((python, [sys.executable])):
        done = subprocess.run(
            [*command, "-c", ARM_README, str(four_bar_file), str(tmp_path / f"{number}.fmu")],
            env=os.environ | ({"PYTHONPATH": path} if command is python else {}), capture_output=True,
            text=True, timeout=600, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        assert done.stdout.split()[0] == ("aarch64-linux" if command is python else "linux64")
        found.append(float.fromhex(done.stdout.split()[-1]))
    # Both integrate with a tolerance of 1e-6.
    assert found[0] == pytest.approx(found[1], abs=1e-4)
