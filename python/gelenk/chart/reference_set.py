# SPDX-License-Identifier: BSD-3-Clause
"""The test cases of `docs/work-precision.md`: example scenes, some of the stability map, laws and states."""

from __future__ import annotations

from dataclasses import replace

from gelenk.chart import mechanisms
from gelenk.chart.case import SAMPLES, Case
from gelenk.chart.laws import law_cases
from gelenk.chart.scenes import stability_cases

# The example scenes, their constant inputs [N m, N] and descriptions
READY: dict[str, tuple[dict[str, float], str]] = {
    "pendulum": ({}, "Damped pendulum: one degree of freedom, no loop."),
    "double_pendulum": ({}, "Double pendulum; chaotic, so that errors grow exponentially."),
    "free_body": ({}, "A free body rotates about its intermediate axis for 100 s and tumbles repeatedly."),
    "cart_pole": ({"drive.f": 0.7}, "A pole falls from a cart under a force of 0.7 N."),
    "four_bar": ({}, "A planar four-bar falls and swings."),
    "five_bar": (
        {"motor_left.tau": 0.004, "motor_right.tau": -0.003},
        "Planar parallel robot with two geared motors: one loop, two degrees of freedom.",
    ),
    "slider_crank": (
        {"starter.tau": 1.0, "gas.f[1]": -50.0},
        "A piston engine is accelerated to about 30 rad/s.",
    ),
    "stewart": (
        {f"drive{i}.f": 80.0 + 3 * i for i in range(1, 7)},
        "Stewart platform: five spatial loops, six degrees of freedom, dampers in the legs.",
    ),
    "andrews": ({}, "Seven bodies, three loops, 30 ms; starts at a dead center."),
}
# Scenes of the stability map and their durations here [s]
MORE = {
    "n-four-bar-2": 10.0,
    "bricard": 10.0,
    "governor": 10.0,
    "light-cart-pole": 10.0,
    "heavy-top": 2.0,
}


def reference_set() -> list[Case]:
    """Return all cases, with 20 samples each and constant inputs."""
    cases = []
    for name, (inputs, about) in READY.items():
        scene = mechanisms.shipped(name)
        stop = float(scene["experiment"]["stop"])
        cases.append(Case(name, about, scene, stop, stop / SAMPLES, inputs))
    known = {case.name: case for case in stability_cases()}
    cases += [replace(known[name], stop=stop, step=stop / SAMPLES) for name, stop in MORE.items()]
    cases += law_cases()
    published = known["andrews"]
    return [
        replace(case, published=published.published, source=published.source)
        if case.name == "andrews"
        else case
        for case in cases
    ]
