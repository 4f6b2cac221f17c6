# SPDX-License-Identifier: BSD-3-Clause
"""The code of docs/gradients.md runs as printed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import executed

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def names(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("page"))
        return executed(root / "docs" / "gradients.md")


def test_the_gradient_of_the_last_value_is_the_last_derivative(names: dict[str, Any]) -> None:
    run, by_parameter, by_input = names["run"], names["by_parameter"], names["by_input"]
    for name, value in by_parameter.items():
        assert value == pytest.approx(run.derivative("D.phi", name)[-1], rel=1e-12)
    assert by_input["drive.tau"].sum() == pytest.approx(run.derivative("D.phi", "drive.tau")[-1], rel=1e-12)


def test_the_fit_finds_what_the_measurements_were_made_with(names: dict[str, Any]) -> None:
    found = names["found"]
    for name, value in {"coupler.mass": 3.5, "A.damping": 0.1}.items():
        assert abs(found.values[name] - value) < 4 * found.deviations[name]  # 4 standard deviations: 6e-5
        assert found.deviations[name] < 0.2 * value


def test_the_design_is_the_one_with_which_the_path_was_made(names: dict[str, Any]) -> None:
    assert names["best"].values["B.parent.position[1]"] == pytest.approx(0.5, abs=1e-6)


def test_the_filter_is_consistent_and_better_than_the_encoders(names: dict[str, Any]) -> None:
    """The mean of chi-squared with 4 degrees of freedom is 4; successive errors are correlated over some 10
    steps, so that 100 of them have the deviation sqrt(8 / 10) = 0.9 of ten independent ones: three of these
    are allowed.
    """
    assert np.mean(names["consistency"]) == pytest.approx(4.0, abs=2.7)
    measured = np.std(names["measurements"], axis=0)
    assert (np.std(names["errors"], axis=0)[:2] < 0.6 * measured).all()
