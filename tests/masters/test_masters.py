# SPDX-License-Identifier: BSD-3-Clause
"""Every shipped scene in masters of other people: the same bits as without an FMU, and no warning.

Those from PyPI run with all tests, those in Java by `make masters`.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from samples import thorough_beyond

from .jobs import METHODS, SCENES, Job, expected, jobs
from .masters import MASTERS, MASTERS_OF_FMI_3, Master, outcome


@pytest.fixture(scope="module")
def all_jobs(tmp_path_factory: pytest.TempPathFactory) -> list[Job]:
    return jobs(tmp_path_factory.mktemp("fmus"))


@pytest.mark.parametrize("master", thorough_beyond(MASTERS, MASTERS[1:2]), ids=lambda master: master.name)
def test_every_scene_with_three_methods_has_the_bits_of_gelenk(
    master: Master, all_jobs: list[Job], tmp_path: Path
) -> None:
    if master.missing:
        pytest.skip(master.missing)
    found = outcome(master, all_jobs, tmp_path)
    assert found.different == []
    assert found.warnings == []


@pytest.fixture(scope="module")
def all_jobs_of_fmi_3(tmp_path_factory: pytest.TempPathFactory) -> list[Job]:
    return jobs(tmp_path_factory.mktemp("fmus"), fmi=3)


@pytest.mark.parametrize("master", MASTERS_OF_FMI_3, ids=lambda master: master.name)
def test_every_scene_has_the_bits_of_gelenk_with_fmi_3(
    master: Master, all_jobs_of_fmi_3: list[Job], tmp_path: Path
) -> None:
    if master.missing:
        pytest.skip(master.missing)
    knows_choices = master.name != "Ecos"
    chosen = all_jobs_of_fmi_3 if knows_choices else all_jobs_of_fmi_3[:: len(METHODS)]
    found = outcome(master, chosen, tmp_path)
    assert found.different == []
    told = (
        r"Variable named 'solver\.(formulation|integrator|start|equations)' is of unsupported type, skipping"
    )
    others = [line for line in found.warnings if not re.search(told, line)]
    assert others == []
    assert len(found.warnings) == (0 if knows_choices else 4 * len(SCENES))


def test_the_methods_that_masters_set_make_a_difference(all_jobs: list[Job]) -> None:
    """Else a master that drops the parameters would pass."""
    assert len(all_jobs) == len(METHODS) * len(SCENES) >= 36
    for k in range(0, len(all_jobs), len(METHODS)):
        runs = [expected(job) for job in all_jobs[k : k + len(METHODS)]]
        for a, b in ((0, 1), (0, 2), (1, 2)):
            assert not np.array_equal(runs[a], runs[b]), all_jobs[k]["title"]
