# SPDX-License-Identifier: BSD-3-Clause
"""Export for other platforms than this one, whose libraries are in the package gelenk-runtimes."""

from __future__ import annotations

import gzip
import sys
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.io import export

NAMES = {"aarch64-linux": "FourBar.so", "win64": "FourBar.dll", "darwin64": "FourBar.dylib"}


def binaries(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        return {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}


def licenses_in(fmu: Path) -> set[str]:
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
    assert len(set(names)) == len(names)
    return {name.rpartition("/")[2] for name in names if name.startswith("documentation/licenses/")}


@pytest.fixture
def nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which gelenk-runtimes can be put; it is not installed."""
    folder = tmp_path / "installed"
    folder.mkdir()
    monkeypatch.setitem(sys.modules, export.RUNTIMES_PACKAGE, None)
    return folder


@pytest.fixture
def runtimes(nothing: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """In the place of gelenk-runtimes: its folder, with something that is no library."""
    package = nothing / export.RUNTIMES_PACKAGE
    for platform in NAMES:
        (package / platform / "licenses").mkdir(parents=True)
        (package / platform / export.LIBRARIES[platform]).write_bytes(gzip.compress(platform.encode()))
        (package / platform / "licenses" / "LLVM.txt").write_text("of the C++ library")
    (package / "win64" / "licenses" / "MinGW-w64.txt").write_text("of the C library")
    (package / "__init__.py").write_text(f"__version__ = {gelenk.__version__!r}\n")
    monkeypatch.delitem(sys.modules, export.RUNTIMES_PACKAGE)
    monkeypatch.syspath_prepend(nothing)
    return package


@pytest.mark.usefixtures("runtimes")
def test_an_fmu_has_a_library_for_each_platform(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(four_bar, tmp_path / "x.fmu", "all")
    own = {"binaries/linux64/FourBar.so": gzip.decompress(export.runtime_library().read_bytes())}
    others = {f"binaries/{name}/{file}": name.encode() for name, file in NAMES.items()}
    assert binaries(fmu) == own | others
    assert {"LLVM.txt", "MinGW-w64.txt", "Eigen.txt"} <= licenses_in(fmu)
    gelenk.export_fmu(four_bar, fmu, ["darwin64", "linux64", "darwin64"])
    assert set(binaries(fmu)) == {"binaries/darwin64/FourBar.dylib", "binaries/linux64/FourBar.so"}
    assert "MinGW-w64.txt" not in licenses_in(fmu)
    assert list(binaries(gelenk.export_fmu(four_bar, fmu))) == ["binaries/linux64/FourBar.so"]
    assert "LLVM.txt" not in licenses_in(fmu)


@pytest.mark.usefixtures("nothing")
def test_a_platform_that_is_missing_is_reported(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    sentence = (
        "win64: found no library for it in this installation of gelenk; "
        "`make runtimes` in the repository of gelenk builds and installs it"
    )
    with pytest.raises(gelenk.ExportError) as told:
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", ["linux64", "win64"])
    assert str(told.value) == sentence
    with pytest.raises(gelenk.ExportError) as told:
        export.runtime_library("win64")
    assert str(told.value) == sentence
    with pytest.raises(gelenk.ExportError) as told:
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", "all")
    assert [line.partition(":")[0] for line in told.value.lines] == list(NAMES)
    with pytest.raises(
        gelenk.ExportError, match="platforms: found 'solaris', expected linux64, aarch64-linux, "
    ):
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", ["solaris"])
    with pytest.raises(gelenk.ExportError, match="platforms: found none"):
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", [])
    assert not (tmp_path / "x.fmu").exists()


def test_libraries_of_another_version_are_refused(
    runtimes: Path, four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    """The library reads the scene as its own version writes it."""
    (runtimes / "__init__.py").write_text("__version__ = '0.0.7'\n")
    with pytest.raises(gelenk.ExportError) as told:
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", "all")
    assert "found version 0.0.7 of gelenk-runtimes, expected" in str(told.value)
    assert not (tmp_path / "x.fmu").exists()
    gelenk.export_fmu(four_bar, tmp_path / "x.fmu")  # needs none of them


@pytest.mark.usefixtures("nothing")
def test_the_command_writes_nothing_if_a_platform_is_missing(four_bar_file: Path, tmp_path: Path) -> None:
    fmu = tmp_path / "x.fmu"
    call = ["export", str(four_bar_file), "-o", str(fmu), "--platforms"]
    run = CliRunner().invoke(app, [*call, "all"])
    assert run.exit_code == 1
    assert [line.split(":")[0] for line in run.stderr.splitlines()] == list(NAMES)
    assert "pip install" not in run.stderr  # of a package that is not published
    assert not fmu.exists()
    run = CliRunner().invoke(app, [*call, "win64"])
    assert run.exit_code == 1
    assert run.stderr.startswith("win64: ")
    assert not fmu.exists()
    run = CliRunner().invoke(app, [*call, "linux64,solaris"])
    assert run.exit_code == 1
    assert run.stderr.startswith("platforms: found 'solaris', expected linux64, ")


@pytest.mark.usefixtures("runtimes")
def test_the_command_takes_a_list_with_spaces(four_bar_file: Path, tmp_path: Path) -> None:
    fmu = tmp_path / "x.fmu"
    run = CliRunner().invoke(
        app, ["export", str(four_bar_file), "-o", str(fmu), "--platforms", "linux64, win64"]
    )
    assert (run.exit_code, run.stderr) == (0, "")
    assert len(binaries(fmu)) == 2


def test_a_library_with_the_ending_of_another_platform_is_refused(
    four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    from gelenk import _core

    library = export.runtime_library()
    for platform, told in (
        ("win64", r"found the extension '\.so', expected \.dll"),
        ("solaris", "platform: found"),
    ):
        with pytest.raises(gelenk.ExportError, match=told):
            _core.export_fmu(four_bar._core, [(platform, library)], tmp_path / "x.fmu", tmp_path, None)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have their own folder in an FMU")
def test_on_arm_the_library_for_arm_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, four_bar: gelenk.Scene
) -> None:
    """There, fmpy takes that of x86-64."""
    fmu = gelenk.export_fmu(four_bar, tmp_path / "x.fmu")
    monkeypatch.setattr("platform.machine", lambda: "aarch64")
    with pytest.raises(gelenk.UsageError, match=r"Cannot find .*/binaries/aarch64-linux/FourBar\.so"):
        gelenk.simulate(fmu, stop=0.1)
