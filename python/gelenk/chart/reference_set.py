# SPDX-License-Identifier: BSD-3-Clause
"""The scenes on which `docs/work-precision.md` compares methods: the ready ones, and what these leave out."""

from __future__ import annotations

from dataclasses import replace

from gelenk.chart import mechanisms
from gelenk.chart.case import SAMPLES, Case
from gelenk.chart.scenes import stability_cases

# The ready scenes, what drives them [N m, N], and a sentence on each.
READY: dict[str, tuple[dict[str, float], str]] = {
    "pendulum": ({}, "A damped rod swings about a pin: one freedom, no loop."),
    "double_pendulum": ({}, "Two rods in a row, chaotic: errors grow by themselves."),
    "free_body": ({}, "A body turns about its middle axis for 100 s and tumbles over, again and again."),
    "cart_pole": ({"drive.f": 0.7}, "A pole falls from a cart that 0.7 N push."),
    "four_bar": ({}, "A planar loop falls and swings."),
    "five_bar": (
        {"motor_left.tau": 0.004, "motor_right.tau": -0.003},
        "A planar parallel robot, two geared motors: one loop, two freedoms.",
    ),
    "slider_crank": (
        {"starter.tau": 1.0, "gas.f[1]": -50.0},
        "A piston engine is turned up to some 30 rad/s.",
    ),
    "stewart": (
        {f"drive{i}.f": 80.0 + 3 * i for i in range(1, 7)},
        "Six legs push a platform: five loops in space, six freedoms, dampers in the legs.",
    ),
    "andrews": ({}, "Seven bars, three loops, all within 30 ms; starts in a dead point."),
}
# Of the stability map's scenes, and how long they run here [s].
MORE = {
    "n-four-bar-2": 10.0,
    "bricard": 10.0,
    "governor": 10.0,
    "light-cart-pole": 10.0,
    "heavy-top": 2.0,
}


def reference_set() -> list[Case]:
    """All cases, their states compared at 20 times each; inputs constant."""
    cases = []
    for name, (inputs, about) in READY.items():
        scene = mechanisms.shipped(name)
        stop = float(scene["experiment"]["stop"])
        cases.append(Case(name, about, scene, stop, stop / SAMPLES, inputs))
    known = {case.name: case for case in stability_cases()}
    cases += [replace(known[name], stop=stop, step=stop / SAMPLES) for name, stop in MORE.items()]
    published = known["andrews"]
    return [
        replace(case, published=published.published, source=published.source)
        if case.name == "andrews"
        else case
        for case in cases
    ]
