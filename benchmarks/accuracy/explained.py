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


EXPLANATIONS: tuple[Explanation, ...] = ()


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
