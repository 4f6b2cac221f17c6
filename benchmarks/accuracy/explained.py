# SPDX-License-Identifier: BSD-3-Clause
"""Why runs are not good: what is known of each, by hand."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatch


@dataclass(frozen=True)
class Explanation:
    """Of those runs that match all patterns (as of file names)."""

    why: str
    integrator: str = "*"
    scene: str = "*"
    inputs: str = "*"
    outcome: str = "*"
    saved: bool | None = None  # either


UNDAMPED = (
    "2500 undamped periods of 3e4 rad/s: errors of all steps add up. With `dirk` at 1e-8 they are 10, 21, "
    "34, 60 and 94 times the tolerance after 250, 500, 1000, 1250 and 2000 periods, at 30 steps each"
)
ROUNDING = (
    "one step's test, a difference of order six, meets rounding: `ida` and `cvode` make the same steps "
    "at all tolerances below 4e-10 and 1e-9. `erk`, `dirk` and "
    "`cvode-adams` hold such tolerances"
)
EXPLANATIONS = (
    Explanation(UNDAMPED, scene="two-masses", outcome="wrong"),
    Explanation("some 1e5 steps of 3e4 rad/s: the time allowed", scene="two-masses", outcome="failed"),
    *(
        Explanation(ROUNDING, integrator=name, scene=scene, outcome="wrong")
        for name in ("ida", "cvode") for scene in ("heavy-top*", "v6", "spatial-slider-crank")
    ),
    *(
        Explanation("a history of steps does not lead through a position at which the loop loses rank",
                    integrator=name, scene=scene, outcome="refused")
        for name in ("ida", "cvode") for scene in ("equal-slider-crank", "windows-*", "parallelogram")
    ),
    *(
        Explanation("the history is carried across the jump of the inputs", integrator=name, inputs="jumping")
        for name in ("ida", "cvode")
    ),
)  # fmt: skip


def explanation(integrator: str, scene: str, inputs: str, saved: bool, outcome: str) -> str:
    """The first that matches; what nobody has explained is said to be so."""
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
