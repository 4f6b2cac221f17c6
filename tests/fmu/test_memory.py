# SPDX-License-Identifier: BSD-3-Clause
"""A host whose memory runs out, allocation by allocation."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest

import gelenk

from .plants import crank_rocker

HOST = Path(__file__).with_name("starved_host.c")
HEADERS = Path(fmpy.__file__).parent / "c-code"


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    out = tmp_path_factory.mktemp("host") / "starved_host"
    # -rdynamic: the library's malloc is then the host's.
    subprocess.run(
        [compiler, "-O1", "-rdynamic", f"-I{HEADERS}", str(HOST), "-o", str(out), "-ldl"], check=True
    )
    return out


@pytest.mark.parametrize("integrator", ["auto", "erk", "rk4", "ida", "cvode", "dirk", "generalized-alpha"])
def test_allocations_that_fail_are_survived(integrator: str, host: Path, tmp_path: Path) -> None:
    source = crank_rocker()
    source["solver"] = {"integrator": integrator}
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    folder = Path(fmpy.extract(str(fmu), str(tmp_path / "extracted")))
    description = fmpy.read_model_description(str(fmu))
    (library,) = (folder / "binaries" / "linux64").glob("*.so")
    outputs = [v.valueReference for v in description.modelVariables if v.causality == "output"]
    inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
    assert outputs == list(range(outputs[0], outputs[0] + len(outputs)))
    run = subprocess.run(
        [
            str(host),
            str(library),
            description.guid,
            (folder / "resources").as_uri(),
            *(str(n) for n in (inputs[0], outputs[0], len(outputs))),
        ],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    found = re.match(r"(\d+) lives, (\d+) not born, (\d+) with refused calls, (\d+) sentences", run.stdout)
    assert found
    lives, unborn, refused, sentences = map(int, found.groups())
    assert lives > 100
    assert unborn > 20
    assert refused > 20
    assert sentences > 20
