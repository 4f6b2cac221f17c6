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


KINK = (
    "a damped stop: its force jumps at the touch and breaks off at the release; undamped, `erk` errs "
    "by less than the tolerance in `bouncing`. Not examined further"
)
SINGULAR = "the loop loses rank: accelerations are extrapolated there, over a time that no tolerance shortens"
STOPPED = ("bouncing", "four-bar-stopped")
UNDAMPED = "2500 undamped periods of 3e4 rad/s: errors of all steps add up"
EXPLANATIONS = (
    Explanation(UNDAMPED, scene="two-masses", outcome="wrong"),
    Explanation("some 1e5 steps of 3e4 rad/s: the time allowed", scene="two-masses", outcome="failed"),
    *(Explanation(KINK, scene=name, outcome="wrong") for name in STOPPED),
    *(
        Explanation("a history of steps does not lead through a position at which the loop loses rank",
                    integrator=name, scene=scene, outcome="refused")
        for name in ("ida", "cvode") for scene in ("equal-slider-crank", "windows-*", "parallelogram")
    ),
    *(
        Explanation(SINGULAR, scene=scene, outcome="wrong")
        for scene in ("equal-slider-crank", "windows-*", "parallelogram")
    ),
    *(
        Explanation("saving begins a history anew at order 1, each time at an error of its own",
                    integrator=name, saved=True, outcome="wrong")
        for name in ("ida", "cvode", "cvode-adams")
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
