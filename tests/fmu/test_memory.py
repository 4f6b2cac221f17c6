# SPDX-License-Identifier: BSD-3-Clause
"""A host whose memory runs out, allocation by allocation."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from mechanisms import Scene

import gelenk

from .c_hosts import extracted
from .plants import crank_rocker, cranked, driven

HOST = "oom_host"


INTEGRATORS = ["auto", "erk", "rk4", "ida", "cvode", "dirk", "generalized-alpha"]
CASES = [
    (crank_rocker, "auto"),
    (crank_rocker, "ida"),
    *(
        pytest.param(*case, marks=pytest.mark.thorough)
        for case in (
            *((crank_rocker, name) for name in INTEGRATORS if name not in ("auto", "ida")),
            (driven, "auto"),
            (driven, "ida"),
            (cranked, "auto"),
        )
    ),
]


@pytest.mark.parametrize(("plant", "integrator"), CASES)
def test_allocations_that_fail_are_survived(
    plant: Callable[[], Scene], integrator: str, host: Path, tmp_path: Path
) -> None:
    source = plant()
    source["solver"] = {"integrator": integrator}
    arguments = extracted(gelenk.export_fmu(source, tmp_path / "x.fmu"), tmp_path / "extracted")
    run = subprocess.run(
        [str(host), *arguments],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    found = re.match(
        r"(\d+) cycles, (\d+) not instantiated, (\d+) with failed calls, (\d+) messages", run.stdout
    )
    assert found
    lives, unborn, refused, sentences = map(int, found.groups())
    assert lives > 100
    assert unborn > 20
    assert refused > 20
    assert sentences > 20
