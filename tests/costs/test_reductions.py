# SPDX-License-Identifier: BSD-3-Clause
"""What reductions gain, counted in instructions of a controller's loop; `make clocks` has them in seconds."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
import scene_files
from models.reducible import without
from samples import sampled

import gelenk
from gelenk.model.inspection import REDUCTIONS

from .counting import instructions_of, prepared, valgrind
from .jobs import KERNELS, RK4, Job
from .test_costs import MARGIN

pytestmark = pytest.mark.skipif(sys.platform != "linux" or not valgrind(), reason="valgrind is not installed")
DRIVEN = {path.stem: path for path in scene_files.good() if gelenk.Simulation(gelenk.load(path)).inputs}


def instructions(source: dict[str, Any], host: Path, folder: Path) -> int:
    """Of a round: a torque set, a step of rk4, all outputs read; by the kernels."""
    return instructions_of(prepared(Job(lambda: source, 30, solver=RK4 | KERNELS), host, folder))


def gains(name: str, host: Path, folder: Path, *off: str) -> float:
    source = gelenk.load(DRIVEN[name]).to_dict()
    least = instructions(source, host, folder / "with")
    return instructions(without(source, *off), host, folder / "without") / least


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("off", "written"),
    [(REDUCTIONS, 2.13), (("planar",), 1.4)],  # as found here; an evaluation alone gains more
    ids=["all", "planar"],
)
def test_a_four_bar_is_stepped_with_fewer_instructions(
    off: tuple[str, ...], written: float, host: Path, tmp_path: Path
) -> None:
    assert gains("four_bar", host, tmp_path, *off) > (1 - MARGIN) * written


@pytest.mark.thorough
@pytest.mark.parametrize("name", sampled(DRIVEN, ["four_bar", "cart_pole"]))
def test_reductions_take_no_more_instructions_than_they_save(name: str, host: Path, tmp_path: Path) -> None:
    """All together. 2 %: where a master reads every output, there may be nothing to save."""
    assert gains(name, host, tmp_path, *REDUCTIONS) > 0.98
