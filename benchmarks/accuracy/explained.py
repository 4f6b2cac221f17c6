# SPDX-License-Identifier: BSD-3-Clause
"""Explanations of runs that are not good, written by hand."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatch


@dataclass(frozen=True)
class Explanation:
    """An explanation for the runs that match all patterns (wildcards as in file names)."""

    why: str
    integrator: str = "*"
    scene: str = "*"
    inputs: str = "*"
    outcome: str = "*"
    saved: bool | None = None  # either


UNDAMPED = "2500 undamped periods at 3e4 rad/s: the errors of all steps accumulate"
ROUNDING = (
    "rounding limits the error test: `ida` and `cvode` make the same steps at all tolerances below 4e-10 "
    "and 1e-9"
)
EXPLANATIONS = (
    Explanation(UNDAMPED, scene="two-masses", outcome="wrong"),
    Explanation("timeout: about 1e5 steps at 3e4 rad/s", scene="two-masses", outcome="failed"),
    *(
        Explanation(ROUNDING, integrator=name, scene=scene, outcome="wrong")
        for name in ("ida", "cvode") for scene in ("heavy-top*", "v6", "spatial-slider-crank")
    ),
    *(
        Explanation("the history of a multistep method is invalid across a singular configuration",
                    integrator=name, scene=scene, outcome="refused")
        for name in ("ida", "cvode") for scene in ("equal-slider-crank", "n-four-bar-*", "parallelogram")
    ),
    *(
        Explanation("the history is kept across the input jump", integrator=name, inputs="jumping")
        for name in ("ida", "cvode")
    ),
)  # fmt: skip


def explanation(integrator: str, scene: str, inputs: str, saved: bool, outcome: str) -> str:
    """Return the first matching explanation, or **unexplained**."""
    for known in EXPLANATIONS:
        pairs = (
            (integrator, known.integrator),
            (scene, known.scene),
            (inputs, known.inputs),
            (outcome, known.outcome),
        )
        if all(fnmatch(name, pattern) for name, pattern in pairs) and known.saved in (None, saved):
            return known.why
    return "**unexplained**"
