# SPDX-License-Identifier: BSD-3-Clause
"""`gelenk equations` prints what the function of Python returns."""

from __future__ import annotations

import json
from pathlib import Path

import programs
import pytest

import gelenk

from .test_traced_scenes import SCENES

FOUR_BAR = SCENES["four_bar"]


@pytest.mark.parametrize("language", ["c", "numpy", "sympy", "latex", "casadi"])
def test_the_command_prints_the_text(language: str) -> None:
    found = gelenk.equations(FOUR_BAR)
    texts = {
        "c": found.to_c,
        "numpy": found.numpy_text,
        "sympy": found.sympy_text,
        "latex": found.to_latex,
        "casadi": found.casadi_text,
    }
    done = programs.gelenk("equations", FOUR_BAR, "--to", language)
    assert done.returncode == 0, done.stderr
    assert done.stdout == texts[language]()


def test_numbers_can_be_set_and_files_written(tmp_path: Path) -> None:
    file = tmp_path / "bar.c"
    done = programs.gelenk("equations", FOUR_BAR, "--set", "crank.m=7", "-o", file, "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["language"] == "c"
    assert report["text"] == file.read_text(encoding="utf-8")
    assert report["text"] != gelenk.equations(FOUR_BAR).to_c()
