# SPDX-License-Identifier: BSD-3-Clause
"""Exporting for other platforms than this one, as far as there is a library for them."""

from __future__ import annotations

import gzip
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.io import export


def binaries(fmu: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu) as archive:
        return {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}


@pytest.fixture
def dll(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """In the place of the library for Windows; not there yet."""
    place = tmp_path / "place" / "gelenk_fmu.dll.gz"
    place.parent.mkdir()
    monkeypatch.setitem(export.RUNTIMES, "win64", str(place))
    return place


def test_an_fmu_holds_a_library_for_each_platform(dll: Path, four_bar: gelenk.Scene, tmp_path: Path) -> None:
    dll.write_bytes(gzip.compress(b"MZ"))
    fmu = gelenk.export_fmu(four_bar, tmp_path / "x.fmu", ["win64", "linux64"])
    assert binaries(fmu) == {
        "binaries/linux64/FourBar.so": gzip.decompress(export.runtime_library().read_bytes()),
        "binaries/win64/FourBar.dll": b"MZ",
    }
    notice = "documentation/licenses/MinGW-w64.txt"
    with zipfile.ZipFile(fmu) as archive:
        assert b"winpthreads" in archive.read(notice)
    assert list(binaries(gelenk.export_fmu(four_bar, fmu, ["win64"]))) == ["binaries/win64/FourBar.dll"]
    assert list(binaries(gelenk.export_fmu(four_bar, fmu))) == ["binaries/linux64/FourBar.so"]
    with zipfile.ZipFile(fmu) as archive:
        assert notice not in archive.namelist()


@pytest.mark.usefixtures("dll")
def test_a_platform_that_is_not_there_is_told_in_a_sentence(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    with pytest.raises(gelenk.ExportError) as told:
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", ["linux64", "win64"])
    sentence = "win64: this installation of gelenk has no gelenk_fmu.dll"
    assert str(told.value).startswith(sentence)
    assert "make win64" in str(told.value)
    with pytest.raises(gelenk.ExportError, match="platforms: found 'darwin64', expected linux64 or win64"):
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", ["darwin64"])
    with pytest.raises(gelenk.ExportError, match="platforms: found none"):
        gelenk.export_fmu(four_bar, tmp_path / "x.fmu", [])
    assert not (tmp_path / "x.fmu").exists()


def test_the_command_packs_what_there_is_and_tells_what_there_is_not(
    dll: Path, four_bar_file: Path, tmp_path: Path
) -> None:
    fmu = tmp_path / "x.fmu"
    call = ["export", str(four_bar_file), "-o", str(fmu), "--platforms"]
    run = CliRunner().invoke(app, [*call, "linux64,win64"])
    assert run.exit_code == 0
    assert run.stderr.count("\n") == 1
    assert run.stderr.startswith("win64: this installation of gelenk has no gelenk_fmu.dll")
    assert list(binaries(fmu)) == ["binaries/linux64/FourBar.so"]
    fmu.unlink()
    run = CliRunner().invoke(app, [*call, "win64"])
    assert run.exit_code == 1
    assert run.stderr.startswith("win64: ")
    assert not fmu.exists()
    run = CliRunner().invoke(app, [*call, "linux64,solaris"])
    assert run.exit_code == 1
    assert run.stderr == "platforms: found 'solaris', expected linux64 or win64\n"
    dll.write_bytes(gzip.compress(b"MZ"))
    run = CliRunner().invoke(app, [*call, "linux64, win64"])
    assert (run.exit_code, run.stderr) == (0, "")
    assert len(binaries(fmu)) == 2
