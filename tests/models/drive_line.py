# SPDX-License-Identifier: BSD-3-Clause
"""An engine that drives a load by a clutch."""

from __future__ import annotations

from mechanisms import Scene, body, frame, joint, scene

ENGINE, LOAD = 0.5, 2.0  # kg m2
SLIDING, STATIC = 10.0, 12.0  # N m
ENGAGEMENT = "clutch.friction.engagement"


def drive_line(slip: float = 0.0) -> Scene:
    """An engine with a motor and, behind a clutch, a load that is ahead by `slip` [rad/s]."""
    return scene(
        {"engine": body(1, inertia=(0, 0, ENGINE)), "load": body(1, inertia=(0, 0, LOAD))},
        {
            "shaft": joint(
                "revolute", frame("ground"), frame("engine"), start={"phi": 0.0, "w": 50.0, "fixed": True}
            ),
            "clutch": joint(
                "revolute",
                frame("engine"),
                frame("load"),
                friction={"coulomb": SLIDING, "static": STATIC, "input": "engagement"},
                start={"phi": 0.0, "w": slip, "fixed": True},
            ),
        },
        motors={"torque": {"joint": "shaft"}},
    )
