# SPDX-License-Identifier: BSD-3-Clause
"""Warnings that tests cause on purpose; any other is an error (pyproject.toml).

A test that is about a warning uses `pytest.warns`. These marks are for tests whose scenes are of a kind that
is warned of, which is beside their point.
"""

import pytest


def _ignored(message: str, category: str = "StartWarning") -> pytest.MarkDecorator:
    return pytest.mark.filterwarnings(f"ignore:{message}:gelenk.{category}")


GUESSES = _ignored(".*a guess with which the loops cannot be closed")
AMBIGUOUS = _ignored("the loops can be closed in two positions that are equally close")
SINGULAR = _ignored(".*the start is (close to )?a singular configuration")
CONTRADICTING = _ignored("the loops close at the start, but redundant constraint equations contradict")
STILL = _ignored(".*nothing moves")
TIGHT = _ignored("solver.tolerance. .* is below the accuracy")
IN_STEPS = _ignored("contacts are solved in time steps")
COINCIDING = _ignored(".* its ends coincide at the start")
PRESSED = _ignored(".* beyond it, the stop p", "SceneWarning")
TURNS = _ignored(".* turns, expected an angle in rad", "SceneWarning")
GYRATION = _ignored(".* a radius of gyration of", "SceneWarning")
GRAVITY = _ignored(".* gravity. found", "SceneWarning")
MOVING = _ignored(".* is not an equilibrium", "OperatingPointWarning")
