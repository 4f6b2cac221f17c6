# SPDX-License-Identifier: BSD-3-Clause
"""The scenes that the tests of the FMU export."""

from __future__ import annotations

from mechanisms import Scene, body, four_bar, frame, joint, reaction, scene


def crank_rocker() -> Scene:
    """The four-bar with a motor, sensors and parameters of every kind of element."""
    out = four_bar()
    out["sensors"] = {
        "hinge": reaction("C"),
        "energy_meter": {"type": "energy"},
    }
    out["parameters"] = ["crank.mass", "coupler.com", "A.damping", "drive.gear_ratio"]
    return out


def gyroscope() -> Scene:
    """Quaternions: a top on a spherical joint, a free body tied to it by a spring, a wrench as input."""
    return scene(
        {
            "top": body(1.3, (0.05, -0.02, 0.21), (0.031, 0.027, 0.019, 0.001, -0.002, 0.0015)),
            "probe": body(0.7, (0.01, 0.03, -0.02), (0.011, 0.013, 0.017)),
        },
        {
            "S": joint("spherical", frame("ground"), frame("top"), start={"w": [0.3, -0.7, 11.0]}),
            "F": joint("free", frame("ground"), frame("probe"), start={"r": [0.9, 0.4, 0.7]}),
        },
        name="Gyroscope",
        forces={
            "tie": {
                "type": "spring_damper",
                "from": frame("top", (0, 0, 0.4)),
                "to": frame("probe"),
                "stiffness": 13.0,
                "damping": 0.3,
                "length": 0.5,
            },
            "push": {"type": "wrench", "body": "probe", "input": True},
        },
        parameters=["probe.mass", "tie.stiffness"],
    )
