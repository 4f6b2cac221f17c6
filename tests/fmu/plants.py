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


def with_circuit() -> Scene:
    """The crank-rocker with a current at the crank, a limited controller of the rocker's angle, a damper by a
    sensor, and heat; expressions name the joint that closes the loop.
    """
    out = crank_rocker()
    out["sensors"]["gap"] = {
        "type": "distance",
        "from": frame("crank", (0.5, 0, 0)),
        "to": frame("ground", (2, 1, 0)),
    }
    out["constants"] = {"R": 1.0, "k": 0.6}
    out["states"] = {
        "i": {"rate": "(voltage - R*i - k*A.w)/0.02", "unit": "A", "start": 0.2},
        "sum": "D.phi - 1.9 + (voltage - wanted)/0.1",
        "heat": {"rate": "loss", "unit": "J", "nominal": 10.0},
    }
    out["expressions"] = {
        "wanted": "8*(1.9 - D.phi) - 2*C.w - 3*sum",
        "voltage": {"value": "clip(wanted, -6, 6)", "unit": "V"},
        "loss": {"value": "R*i^2", "unit": "W"},
    }
    out["joints"]["A"]["law"] = {"effort": "k*i - 0.1*gap.v"}
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


def driven() -> Scene:
    """Two parts: a four-bar driven at its crank by a position, with a bob on its rocker, which a motor turns;
    a slide that shakes by itself, with a pendulum on it, and a gear and a rack on that.
    """
    out = four_bar(0.7)
    about_z = {"axis": [0, 0, 1]}
    out["joints"]["A"]["start"] = {"phi": 0.7}
    out["bodies"] |= {
        "bob": body(0.3, (0.1, 0, 0), (0.001, 0.001, 0.001)),
        "table": body(0.5),
        "rod": body(0.4, (0.2, 0, 0), (0.002, 0.002, 0.002)),
        "wheel": body(0.2, (0, 0, 0), (1e-4, 1e-4, 2e-4)),
        "bar": body(0.1),
    }
    out["joints"] |= {
        "bobs": joint("revolute", frame("rocker", (0.7, 0.1, 0)), frame("bob"), damping=0.02, **about_z),
        "shakes": joint("prismatic", frame("ground", (5, 0, 0)), frame("table"), axis=[1, 0, 0]),
        "swings": joint(
            "revolute",
            frame("table"),
            frame("rod"),
            damping=0.01,
            start={"phi": -1.2, "fixed": True},
            **about_z,
        ),
        "turns": joint("revolute", frame("table", (0, 0.3, 0)), frame("wheel"), **about_z),
        "runs": joint("prismatic", frame("table", (0, 0.4, 0)), frame("bar"), axis=[1, 0, 0]),
    }
    out["motors"] = {"drive": {"joint": "bobs"}}
    out["constraints"] = {
        "crank": {"type": "motion", "joint": "A", "input": "position"},
        "shake": {"type": "motion", "joint": "shakes", "sine": {"amplitude": 0.05, "frequency": 2.0}},
        "mesh": {"type": "gear", "joint": "turns", "with": "swings", "ratio": -3},
        "teeth": {"type": "rack", "rack": "runs", "pinion": "turns", "radius": 0.04},
    }
    out["sensors"] = {
        "pin": reaction("C"),
        "axle": reaction("turns"),
        "tip": {"type": "frame", "body": "bob", "position": [0.2, 0, 0]},
        "energy_meter": {"type": "energy"},
    }
    out["parameters"] = ["bobs.damping", "wheel.mass", "coupler.mass"]
    out["name"] = "Driven"
    return out


def cranked() -> Scene:
    """A four-bar whose crank turns at the speed of an input, with a bob on its rocker."""
    out = driven()
    for name in ("table", "rod", "wheel", "bar"):
        del out["bodies"][name]
    for name in ("shakes", "swings", "turns", "runs"):
        del out["joints"][name]
    del out["motors"], out["sensors"]["axle"]
    out["constraints"] = {"crank": {"type": "motion", "joint": "A", "input": "speed"}}
    out["joints"]["A"]["start"] = {"phi": 0.7, "fixed": ["phi"]}
    out["parameters"] = ["bobs.damping"]
    out["name"] = "Cranked"
    return out


def weightless() -> Scene:
    """`driven`, its crank, table, wheel and bar without mass: constraints say how they move."""
    out = driven()
    for name in ("crank", "table", "wheel", "bar"):
        out["bodies"][name] = body(0.0)
    return out


def touching(boxes: int) -> Scene:
    """Boxes that a paddle on a spring, which a motor shakes, tosses up, above a floor."""
    lengths = [0.1, 0.1, 0.1]
    cube = {"box": lengths, "surface": "wood"}
    out = scene(
        {
            "paddle": body(1.0, (0, 0, 0), (0.1, 0.1, 0.1))
            | {"shapes": {"plate": {"box": [1, 1, 0.02], "surface": "steel"}}},
            **{
                f"b{i}": body(0.5, (0, 0, 0), (8e-4, 8e-4, 8e-4)) | {"shapes": {"cube": cube}}
                for i in range(boxes)
            },
        },
        {
            "P": joint(
                "prismatic",
                frame("ground", (0, 0, 0.1)),
                frame("paddle"),
                axis=[0, 0, 1],
                stiffness=2e3,
                damping=5,
            ),
            **{
                f"J{i}": joint(
                    "free", frame("ground"), frame(f"b{i}"), start={"r": [0.03 * i, 0, 0.17 + 0.11 * i]}
                )
                for i in range(boxes)
            },
        },
        name="Touching",
        motors={"drive": {"joint": "P", "gear_ratio": 50}},
        contacts={
            "hit": {"between": ["wood", "steel"], "friction": 0.4, "restitution": 0.3},
            "pile": {"between": ["wood", "wood"], "friction": 0.4, "restitution": 0.3},
            "floor": {"between": ["wood", "stone"], "friction": 0.4},
        },
        parameters=["hit.friction"],
    )
    out["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "stone"}}}
    out["gravity"] = [0, 0, -9.81]
    out["experiment"] = {"step": 0.005}
    return out


def two_cylinders() -> Scene:
    """Shapes whose contacts are solved in time steps only."""
    return {
        "gelenk": 1,
        "name": "Cylinders",
        "bodies": {
            name: {
                "mass": 1,
                "inertia": [0.1, 0.1, 0.1],
                "shapes": {"s": {"cylinder": {"radius": 0.1, "length": 0.4}, "surface": name}},
            }
            for name in ("a", "b")
        },
        "joints": {
            name: {"type": "free", "parent": "ground", "child": name, "start": {"r": [0, 0, z]}}
            for name, z in (("a", 0.0), ("b", 1.0))
        },
        "contacts": {"c": {"between": ["a", "b"]}},
    }
