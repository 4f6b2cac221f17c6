# SPDX-License-Identifier: BSD-3-Clause
"""What not every user needs comes by extras, and is asked for by name where it is missing."""

from __future__ import annotations

import sys
from importlib.metadata import requires
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

import gelenk
from gelenk import extras
from gelenk.io.urdf import import_urdf
from gelenk.simulation import progress


def read_mesh() -> None:
    scene = gelenk.load(Path(__file__).parent.parent / "scenes" / "four_bar.yaml").to_dict()
    scene["bodies"]["crank"]["shapes"] = {"s": {"mesh": "m.stl"}}
    Path("m.stl").touch()
    gelenk.load(scene)


@pytest.mark.parametrize(
    ("ending", "package"),
    [
        (".parquet", "pandas"),
        (".parquet", "pyarrow"),
        (".nc", "xarray"),
        (".nc", "h5py"),
        (".nc", "h5netcdf"),
    ],
)
def test_readers_of_results_name_their_extra(
    ending: str, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also if the file is missing, or no result."""
    monkeypatch.setitem(sys.modules, package, None)
    for path in (tmp_path / f"none{ending}", tmp_path / f"some{ending}"):
        (tmp_path / f"some{ending}").write_bytes(b"nothing of use")
        with pytest.raises(gelenk.UsageError) as caught:
            gelenk.Result.read(path)
        assert str(caught.value) == (
            f"{ending} files are read and written with {package}: pip install 'gelenk[tables]'"
        )


def test_meshes_name_their_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(gelenk.SceneError, match=r"trimesh: pip install 'gelenk\[mesh\]'"):
        read_mesh()


@pytest.mark.parametrize(
    ("package", "use", "sentence"),
    [
        ("matplotlib", extras.pyplot, "charts are drawn with matplotlib: pip install 'gelenk[charts]'"),
        (
            "yourdfpy",
            lambda: import_urdf(Path("robot.urdf")),
            "importing URDF needs yourdfpy: pip install 'gelenk[urdf]'",
        ),
    ],
)
def test_without_an_extra_its_name_is_told(
    package: str, use: Any, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robot.urdf").write_text("<robot name='r'><link name='a'/></robot>")
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(gelenk.UsageError) as caught:
        use()
    assert str(caught.value) == sentence


def test_an_extra_that_is_broken_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "yourdfpy.py").write_text("import a_mesh_library_that_is_not_there")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "yourdfpy", raising=False)
    with pytest.raises(gelenk.UsageError, match=r"cannot be imported here \(No module named 'a_mesh_library"):
        extras.extra("yourdfpy", "importing URDF needs yourdfpy")


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def test_without_tqdm_a_run_goes_on_and_its_extra_is_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setattr(progress, "QUIET", 0.0)
    monkeypatch.setattr(progress, "PERIOD", 0.0)
    stream = Terminal()
    with progress.terminal_bar(stream) as reached:
        assert reached is not None
        for k in range(5):
            reached(0.2 * k, 1.0)
    assert stream.getvalue() == "progress is shown by tqdm: pip install 'gelenk[progress]'\n"


def test_extras_are_those_of_the_package() -> None:
    given = {line.partition(";")[0].rstrip(" >=.0123456789"): line for line in requires("gelenk") or []}
    for package, name in extras.EXTRAS.items():
        distribution = {"PIL": "pillow"}.get(package, package)
        assert f'extra == "{name}"' in given[distribution].replace("'", '"')
    needed = {name for name, line in given.items() if "extra ==" not in line}
    assert needed == {"numpy", "fmpy", "control", "scipy", "pyyaml", "typer"}
