# SPDX-License-Identifier: BSD-3-Clause
"""VDMCheck, the formal model of FMI 2.0 by INTO-CPS, finds nothing. CONTRIBUTING.md tells how to get it."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
import scene_files

import gelenk

from .plants import crank_rocker, gyroscope

HOME = Path(os.environ.get("GELENK_VDMCHECK", ""))
JARS = ("vdmcheck2", "vdmj", "annotations", "xsd2vdm", "fmuReader")
SOURCES = {"crank_rocker": crank_rocker(), "gyroscope": gyroscope()} | {f.stem: f for f in scene_files.good()}

pytestmark = pytest.mark.skipif(
    "GELENK_VDMCHECK" not in os.environ or shutil.which("java") is None,
    reason="GELENK_VDMCHECK names no folder with VDMCheck, or there is no java",
)


def checked(program: str, file: Path) -> str:
    path = os.pathsep.join([*(f"{jar}.jar" for jar in JARS), "."])
    start = ["-jar", "vdmcheck2.jar"] if program == "VDMCheck" else ["-cp", path, program]
    run = subprocess.run(
        ["java", *start, str(file)],
        cwd=HOME,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return run.stdout + run.stderr


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.parametrize("program", ["VDMCheck", "VDMCheckPlus"])
def test_vdmcheck_finds_nothing(program: str, name: str, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(SOURCES[name], tmp_path / "x.fmu")
    assert checked(program, fmu) == "No errors found.\n"


@pytest.mark.parametrize("program", ["VDMCheck", "VDMCheckPlus"])
def test_vdmcheck_finds_what_is_wrong(program: str, tmp_path: Path) -> None:
    """So the test above means something."""
    fmu = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("modelDescription.xml").decode()
    spoilt = tmp_path / "modelDescription.xml"
    spoilt.write_text(text.replace('<Unknown index="2" dependencies="2"/>\n', "", 1))
    assert "Outputs" in checked(program, spoilt)
