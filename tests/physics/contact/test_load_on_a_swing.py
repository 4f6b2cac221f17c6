# SPDX-License-Identifier: BSD-3-Clause
"""A block on the coupler of a swinging parallelogram: all normals point up or down but for rounding."""

import numpy as np
import pytest
from models.touching import SceneData
from scipy.integrate import solve_ivp

import gelenk

G, ARM, START = 9.81, 0.5, 0.3  # m/s2, m, rad
LOAD, TRAY, LINK, LINK_INERTIA = 4.0, 3.0, 1.0, 0.02  # kg, kg m2
STEP = 1e-3  # s


def swing(between: list[str]) -> SceneData:
    pivot = {"type": "revolute", "axis": [0, -1, 0]}
    link = {"mass": LINK, "com": [0, 0, -ARM / 2], "inertia": [LINK_INERTIA, LINK_INERTIA, 1e-3]}
    joints = {}
    for name, x in (("left", -0.15), ("right", 0.15)):
        joints[f"{name}_pivot"] = {
            **pivot, "parent": {"body": "ground", "position": [x, 0, 1]}, "child": name,
            "start": {"phi": START, "fixed": name == "left"},
        }  # fmt: skip
        joints[f"{name}_end"] = {
            **pivot, "parent": {"body": name, "position": [0, 0, -ARM]},
            "child": {"body": "tray", "position": [x, 0, 0]}, "start": {"phi": -START},
        }  # fmt: skip
    place = [ARM * np.sin(START), 0, 1 - ARM * np.cos(START) + 0.125]
    joints["place"] = {
        "type": "free",
        "parent": "ground",
        "child": "load",
        "start": {"r": place, "fixed": True},
    }
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "left": link,
            "right": link,
            "tray": {
                "mass": TRAY, "inertia": [0.1, 0.1, 0.1],
                "shapes": {"board": {"box": [0.3, 0.4, 0.05], "surface": "board"}},
            },
            "load": {
                "mass": LOAD, "inertia": [0.02, 0.02, 0.02],
                "shapes": {"hull": {"box": [0.2, 0.2, 0.2], "surface": "hull"}},
            },
        },
        "joints": joints,
        "contacts": {"touch": {"between": between, "friction": 0.5}},  # more than tan(START): the load sticks
        "solver": {"integrator": "moreau-jean", "step": STEP},
    }  # fmt: skip


@pytest.mark.parametrize("between", [["hull", "board"], ["board", "hull"]])
def test_the_load_presses_with_its_weight_and_inertia(between: list[str]) -> None:
    """All bodies but the links move alike: a pendulum, whose motion tells the force on the load."""
    carried = LOAD + TRAY
    inertia = carried * ARM**2 + 2 * (LINK_INERTIA + LINK * ARM**2 / 4)
    stiffness = (carried * ARM + 2 * LINK * ARM / 2) * G

    def acceleration(angle: float) -> float:
        return -stiffness * float(np.sin(angle)) / inertia

    times = np.arange(1, 801) * STEP
    exact = solve_ivp(
        lambda _, y: [y[1], acceleration(y[0])], (0, times[-1]), [START, 0], t_eval=times - STEP / 2,
        rtol=1e-10, atol=1e-12,
    ).y  # fmt: skip
    plant = gelenk.Simulation(gelenk.load(swing(between)))
    plant.initialize()
    sign = 1 if between[0] == "hull" else -1  # outputs are the forces on the first
    for t, angle, speed in zip(times, *exact, strict=True):
        plant.step_to(t)
        along, up, gap = plant.values(["touch.f[1]", "touch.f[3]", "touch.gap"])
        a = acceleration(angle)
        ax = ARM * (a * np.cos(angle) - speed**2 * np.sin(angle))
        az = ARM * (a * np.sin(angle) + speed**2 * np.cos(angle))
        # Mean forces of steps of 1 ms; forces change by up to 160 N/s, and the phase lags by a few 1e-5 s.
        assert [sign * along, sign * up] == pytest.approx([LOAD * ax, LOAD * (G + az)], abs=0.01)
        # Both surfaces move along the same arcs, of which the loops' bodies are projected onto theirs.
        assert abs(gap) < 1e-6
