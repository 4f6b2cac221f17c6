# SPDX-License-Identifier: BSD-3-Clause
"""Every shipped scene in masters of other people: the same bits as without an FMU, and no warning.

Those from PyPI run with all tests, those in Java by `make masters`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from samples import thorough_beyond

from .jobs import METHODS, SCENES, Job, expected, jobs
from .masters import MASTERS, Master, outcome


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


def test_the_methods_that_masters_set_make_a_difference(all_jobs: list[Job]) -> None:
    """Else a master that drops the parameters would pass."""
    assert len(all_jobs) == len(METHODS) * len(SCENES) >= 36
    for k in range(0, len(all_jobs), len(METHODS)):
        runs = [expected(job) for job in all_jobs[k : k + len(METHODS)]]
        for a, b in ((0, 1), (0, 2), (1, 2)):
            assert not np.array_equal(runs[a], runs[b]), all_jobs[k]["title"]
