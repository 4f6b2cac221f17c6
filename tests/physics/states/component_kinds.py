# SPDX-License-Identifier: BSD-3-Clause
"""A component of each kind with all that it can have, and the same by hand."""

from __future__ import annotations

from typing import Any

from mechanisms import body, frame, joint, scene

Fields = dict[str, Any]

# Between two points of which one moves around the axle.
LINE: Fields = {"from": frame("ground", (1.2, 0.4, 0.1)), "to": frame("rotor", (0.5, 0, 0))}

# One of each kind, and the same by hand: states, expressions, and the effort on the joint.
# Names that a scene cannot use have a final underscore there.
KINDS: dict[str, Fields] = {
    "dc_motor": {
        "joint": "axle",
        "voltage": "u - 0.1*w",
        "resistance": 1.2,
        "inductance": 0.05,
        "constant": 0.4,
        "current_limit": 3.0,
        "gear_ratio": 2.0,
        "rotor_inertia": 0.01,
        "start": {"i": 0.5},
    },
    "synchronous_motor": {
        "joint": "axle",
        "voltage_d": "0.2*u",
        "voltage_q": "u",
        "pole_pairs": 4,
        "resistance": 0.5,
        "inductance_d": 2e-3,
        "inductance_q": 3e-3,
        "flux": 0.05,
        "current_limit": 6.0,
        "gear_ratio": 1.5,
        "rotor_inertia": 0.002,
    },
    "engine": {
        "joint": "axle",
        "torque": "u - 0.2*w",
        "time_constant": 0.1,
        "gear_ratio": 0.5,
        "rotor_inertia": 0.03,
    },
    "speed_servo": {
        "joint": "axle",
        "target": "u",
        "feedforward": "0.1*phi",
        "gain": 0.4,
        "reset_time": 0.2,
        "limit": 0.5,
        "tracking_time": 0.05,
    },
    "position_servo": {
        "joint": "axle",
        "target": "u*t",
        "target_speed": "u",
        "feedforward": "0.1*w",
        "gain": 3.0,
        "damping": 0.2,
        "reset_time": 0.4,
        "limit": 0.8,
        "tracking_time": 0.1,
    },
    "series_elastic_drive": {
        "joint": "axle",
        "torque": "0.1*u",
        "stiffness": 20.0,
        "damping": 0.05,
        "rotor_inertia": 1e-3,
        "rotor_damping": 1e-3,
        "gear_ratio": 5.0,
    },
    "maxwell": {"joint": "axle", "stiffness": 4.0, "damping": 0.5},
    "line_maxwell": {**LINE, "stiffness": 4.0, "damping": 0.5},
    "pneumatic_chamber": {
        "joint": "axle",
        "flow": "1e-4*u",
        "area": -1e-3,
        "volume": 5e-4,
        "exponent": 1.2,
        "gas_constant": 280.0,
        "temperature": 300.0,
        "ambient_pressure": 1e5,
        "start": {"pressure": 1.01e5},
    },
    "hydraulic_chamber": {
        "joint": "axle",
        "flow": "1e-6*u",
        "area": 1e-4,
        "volume": 5e-4,
        "bulk_modulus": 1e7,
        "leakage": 1e-11,
        "ambient_pressure": 1e5,
        "start": {"pressure": 1.1e5},
    },
    "first_order": {"input": "u + axle.phi", "time_constant": 0.1, "start": {"y": 0.3}},
    "second_order": {
        "input": "u + axle.phi",
        "natural_frequency": 8.0,
        "damping_ratio": 0.4,
        "start": {"y": 0.3},
    },
    "rate_limiter": {
        "input": "3*sin(4*t) + u",
        "rise": 4.0,
        "fall": 6.0,
        "time_constant": 0.01,
        "start": {"y": 0.3},
    },
    "thermal_mass": {
        "heat": "u^2 + 0.1*axle.w^2",
        "capacity": 5.0,
        "resistance": 0.4,
        "ambient_temperature": 280.0,
        "start": {"temperature": 290.0},
    },
}
OF_LINES = {"line_maxwell"}
OF_SLIDES = {"pneumatic_chamber", "hydraulic_chamber"}
START = 1.5  # of the input u
Hand = tuple[dict[str, Any], dict[str, str], str]  # states, expressions, effort

HAND: dict[str, Hand] = {
    "dc_motor": (
        {"i": {"rate": "(applied - 0.8*axle.w - 1.2*i)/0.05", "start": 0.5}},
        {
            "applied": "min(max(u - 0.1*axle.w, 0.8*axle.w - 3.6), 0.8*axle.w + 3.6)",
            "power": "applied*i",
            "loss": "1.2*i*i",
            "emf": "0.8*axle.w",
        },
        "0.8*i",
    ),
    "synchronous_motor": (
        {
            "id": {"rate": "(applied_d + 6*axle.w*3e-3*iq - 0.5*id)/2e-3"},
            "iq": {"rate": "(applied_q - 6*axle.w*(2e-3*id + 0.05) - 0.5*iq)/3e-3"},
        },
        {
            "applied_d": "min(max(0.2*u, -6*axle.w*3e-3*iq - 3), -6*axle.w*3e-3*iq + 3)",
            "applied_q": "min(max(u, 6*axle.w*(2e-3*id + 0.05) - 3), 6*axle.w*(2e-3*id + 0.05) + 3)",
            "power": "1.5*(applied_d*id + applied_q*iq)",
            "loss": "0.75*(id^2 + iq^2)",
        },
        "9*(0.05*iq - 1e-3*id*iq)",
    ),
    "engine": (
        {"developed": {"rate": "(u - 0.2*axle.w - developed)/0.1"}},
        {"power": "0.5*developed*axle.w"},
        "0.5*developed",
    ),
    "speed_servo": (
        {"integral": {"rate": "0.4*(u - axle.w)/0.2 + (out - unlimited)/0.05"}},
        {"unlimited": "0.4*(u - axle.w) + integral + 0.1*axle.phi", "out": "min(max(unlimited, -0.5), 0.5)"},
        "out",
    ),
    "position_servo": (
        {"integral": {"rate": "3*(u*t - axle.phi)/0.4 + (out - unlimited)/0.1"}},
        {
            "unlimited": "3*(u*t - axle.phi) + 0.2*(u - axle.w) + integral + 0.1*axle.w",
            "out": "min(max(unlimited, -0.8), 0.8)",
        },
        "out",
    ),
    "series_elastic_drive": (
        {
            "deflection": {"rate": "rotor_speed/5 - axle.w"},
            "rotor_speed": {"rate": "(0.1*u - 1e-3*rotor_speed - spring/5)/1e-3"},
        },
        {"spring": "20*deflection + 0.05*(rotor_speed/5 - axle.w)"},
        "spring",
    ),
    "maxwell": (
        {"elongation": {"rate": "axle.w - 8*elongation"}},
        {"loss": "32*elongation^2"},
        "-4*elongation",
    ),
    "line_maxwell": (
        {"elongation": {"rate": "gap.v - 8*elongation"}},
        {"loss": "32*elongation^2", "pull": "4*elongation"},
        "",
    ),
    "pneumatic_chamber": (
        {
            "pressure": {
                "rate": "1.2*(280*300*1e-4*u + pressure*1e-3*axle.v)/(5e-4 - 1e-3*axle.s)",
                "start": 1.01e5,
                "nominal": 1e5,
            }
        },
        {},
        "(1e5 - pressure)*1e-3",
    ),
    "hydraulic_chamber": (
        {
            "pressure": {
                "rate": "1e7*(1e-6*u - 1e-4*axle.v - 1e-11*(pressure - 1e5))/(5e-4 + 1e-4*axle.s)",
                "start": 1.1e5,
                "nominal": 1e5,
            }
        },
        {},
        "(pressure - 1e5)*1e-4",
    ),
    "first_order": ({"y_": {"rate": "(u + axle.phi - y_)/0.1", "start": 0.3}}, {}, ""),
    "second_order": (
        {"y_": {"rate": "rate_", "start": 0.3}, "rate_": {"rate": "64*(u + axle.phi - y_) - 6.4*rate_"}},
        {},
        "",
    ),
    "rate_limiter": ({"y_": {"rate": "min(max(100*(3*sin(4*t) + u - y_), -6), 4)", "start": 0.3}}, {}, ""),
    "thermal_mass": (
        {
            "temperature": {
                "rate": "(u^2 + 0.1*axle.w^2 - (temperature - 280)/0.4)/5",
                "start": 290.0,
                "nominal": 100,
            }
        },
        {},
        "",
    ),
}


def plant(kind: str, **more: Any) -> dict[str, Any]:
    """A rotor or a slide with damping, moving, and the input u."""
    slides = kind in OF_SLIDES
    about = joint(
        "prismatic" if slides else "revolute",
        frame("ground"),
        frame("rotor"),
        axis=[0, 0, 1],
        damping=0.02,
        start={"v" if slides else "w": 0.4},
    )
    return scene(
        {"rotor": body(0.3, inertia=(0.05, 0.05, 0.05))},
        {"axle": about},
        **{"gravity": [0, 0, 0], "inputs": {"u": {"start": START}}} | more,
    )


def with_component(kind: str, **more: Any) -> dict[str, Any]:
    return plant(kind, components={"M": {"type": kind, **KINDS[kind]}}, **more)


def by_hand(kind: str) -> dict[str, Any]:
    states, expressions, effort = HAND[kind]
    source = plant(kind, states=states, expressions=expressions)
    if effort:
        source["joints"]["axle"]["law"] = {"effort": effort}
    if kind in OF_LINES:
        source["sensors"] = {"gap": {"type": "distance", **LINE}}
        source["forces"] = {"along": {"type": "line_force", **LINE, "tension": "pull"}}
    if "rotor_inertia" in KINDS[kind] and kind != "series_elastic_drive":
        drive = {name: KINDS[kind][name] for name in ("gear_ratio", "rotor_inertia")}
        source["motors"] = {"rotor_of_the_motor": {"joint": "axle", **drive}}
    return source
