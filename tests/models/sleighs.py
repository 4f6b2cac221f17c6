# SPDX-License-Identifier: BSD-3-Clause
"""Bodies on a blade that does not slip sideways: Chaplygin's sleigh,
skates on an incline and on a turntable.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mechanisms import GRAVITY, Array, Scene, body, frame, frame_sensor, joint, scene
from mechanisms import rotation as turned

MASS, MOMENT, AHEAD = 3.0, 0.4, 0.25  # kg, kg m2 about the center of mass, m from the blade to it
TABLE_MOMENT = 2.0  # kg m2


def on_a_plane(com: float, start: dict[str, float], **fields: Any) -> Scene:
    """A body with a blade along x at its origin, on a planar joint with these start values."""
    given = start | {"fixed": [name for name in start if name != "v_y"]}
    return scene(
        {"sleigh": body(MASS, (com, 0, 0), (MOMENT, MOMENT, MOMENT))},
        {"floor": joint("planar", frame("ground"), frame("sleigh"), start=given)},
        constraints={"blade": {"type": "knife_edge", "body": "sleigh"}},
        sensors={"blade_at": frame_sensor("sleigh")},
        experiment={"stop": 4, "step": 0.01, "tolerance": 1e-11},
        **fields,
    )


def chaplygin_sleigh(u: float, w: float) -> Scene:
    """Gliding forward at u [m/s], turning at w [rad/s], with its center of mass in front of the blade."""
    return on_a_plane(AHEAD, {"s_x": 0.0, "s_y": 0.0, "phi": 0.0, "v_x": u, "w": w}, name="Sleigh")


def skate(slope: float, w: float) -> Scene:
    """Released at rest except for its spin w, heading downhill (x)
    on a plane inclined by `slope` about y [rad].
    """
    down = turned([0, 1, 0], slope)
    out = on_a_plane(0.0, {"s_x": 0.0, "s_y": 0.0, "phi": 0.0, "v_x": 0.0, "w": w}, gravity=[0, 0, -GRAVITY])
    out["joints"]["floor"]["parent"] = frame("ground", (0.2, 0.1, 1.5), down)
    return out


def on_a_turntable(turning: float, driven: bool) -> Scene:
    """A skate on a table that rotates about z at constant speed,
    or has a moment of inertia and is released.
    """
    out = on_a_plane(0.0, {"s_x": 0.4, "s_y": -0.1, "phi": 0.3, "v_x": 0.5 * np.cos(0.3), "w": 1.5})
    out["bodies"]["table"] = body(10.0, (0, 0, 0), (1.0, 1.0, TABLE_MOMENT))
    out["joints"]["table"] = joint(
        "revolute", frame("ground"), frame("table"), axis=[0, 0, 1], start={"phi": 0.0, "w": turning}
    )
    out["joints"]["floor"]["parent"] = frame("table")
    out["constraints"]["blade"]["on"] = "table"
    if driven:
        out["constraints"]["engine"] = {"type": "motion", "joint": "table", "polynomial": [0.0, turning]}
    else:
        out["joints"]["table"]["start"]["fixed"] = True
    return out


def gudermann(s: Any) -> Any:
    """The integral of 1/cosh."""
    return 2 * np.arctan(np.tanh(s / 2))


def sleigh_truth(u0: float, w0: float, times: Array) -> dict[str, Array]:
    """du/dt = a w^2, (I + m a^2) dw/dt = -m a u w, in closed form (Neimark & Fufaev 1972, ch. 2, sec. 5).

    Along the blade u = U tanh s, w = W / cosh s, s = k t + s0, m U^2 = J W^2 = 2 E, k = m a U / J.
    """
    J = MOMENT + MASS * AHEAD**2
    U = np.sqrt(u0**2 + J / MASS * w0**2)
    k = MASS * AHEAD * U / J
    s0 = np.arctanh(u0 / U)
    s = k * times + s0
    W = np.sign(w0) * np.sqrt(MASS / J) * U
    u, w = U * np.tanh(s), W / np.cosh(s)
    return {
        "u": u,
        "floor.w": w,
        "floor.phi": W / k * (gudermann(s) - gudermann(s0)),
        "blade.f": MASS * (u * w - AHEAD * MASS * AHEAD * u * w / J),
    }
