# SPDX-License-Identifier: BSD-3-Clause
"""A rotor with states of elements: a DC motor with its closed form."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from mechanisms import body, frame, joint, scene
from scipy.linalg import expm

import gelenk

R, L, K, J, VOLTAGE = 1.0, 0.05, 0.4, 0.5, 12.0  # Ohm, H, N.m/A, kg.m2, V


def rotor(**more: Any) -> dict[str, Any]:
    """A rotor of 0.5 kg m2 about z; `effort`: the law of its joint A, `states` and other sections."""
    effort, start = more.pop("effort", None), more.pop("start", {"phi": 0.0})
    law = {} if effort is None else {"law": {"effort": effort}}
    return scene(
        {"rotor": body(2.0, inertia=(J, J, J))},
        {"A": joint("revolute", frame("ground"), frame("rotor"), axis=[0, 0, 1], start=start, **law)},
        **more,
    )


def dc_motor(**more: Any) -> dict[str, Any]:
    """L i' = u - R i - k w, J w' = k i."""
    return rotor(
        effort="k*i",
        states={"i": {"rate": "(u - R*i - k*A.w)/L", "unit": "A", "start": 0.5}},
        inputs={"u": {"unit": "V", "start": VOLTAGE}},
        constants={"R": R, "L": L, "k": K},
        **more,
    )


DC_MATRIX = np.array([[0, 1, 0], [0, 0, K / J], [0, -K / L, -R / L]])  # of phi, w, i


def dc_exact(t: float) -> np.ndarray:
    A = DC_MATRIX[1:, 1:]
    rest = -np.linalg.solve(A, [0, VOLTAGE / L])
    found: np.ndarray = rest + expm(A * t) @ (np.array([0, 0.5]) - rest)
    return found


def values(source: Any, names: list[str], times: list[float], tolerance: float) -> np.ndarray:
    simulation = gelenk.Simulation(source)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)  # 1e-10 is finer than cvode and ida can be
        simulation.initialize(0.0, tolerance)
    out = []
    for t in times:
        simulation.step_to(t)
        out.append([simulation.output(name) for name in names])
    return np.array(out)
