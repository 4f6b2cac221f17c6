# SPDX-License-Identifier: BSD-3-Clause
"""Lanes against closed forms: periods, invariants, the order of the method."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import gelenk
from gelenk import Batch


def pendulum(**sections: Any) -> dict[str, Any]:
    """A point mass of 2 kg on a rod of 0.7 m, in the plane of x and z."""
    return {
        "gelenk": 1,
        "name": "Pendulum",
        "gravity": [0, 0, -9.81],
        "bodies": {"bob": {"mass": 2.0, "com": [0, 0, -0.7], "inertia": [0.05, 0.05, 0.05]}},
        "joints": {
            "A": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "ground",
                "child": "bob",
                "start": {"phi": 1.2, "fixed": True},
                **sections.pop("joint", {}),
            }
        },
        **sections,
    }


def rises(batch: Batch, steps: int) -> np.ndarray:
    """The times at which speeds first become positive, between steps by the line between them [s]."""
    times = np.full(batch.lanes, np.nan)
    before = batch.states["A.w"].copy()
    for k in range(1, steps + 1):
        batch.step()
        after = batch.states["A.w"]
        crossed = np.isnan(times) & (before < 0) & (after >= 0)
        times[crossed] = ((k - 1 - before / (after - before)) * batch.step_size)[crossed]
        before = after.copy()
    return times


def test_each_pendulum_has_its_own_period() -> None:
    """Half of T = 4 K(sin a/2) sqrt(I / (m g l)) from one turning point to the next, for every mass, length,
    gravity and amplitude. The line between two speeds is wrong by less than (h w''/w')² h / 8, 1e-9 s.
    """
    rng = np.random.default_rng(4)
    n = 50
    m, length, g = rng.uniform(1, 3, n), rng.uniform(0.4, 1.2, n), rng.uniform(3, 12, n)  # kg, m, m/s2
    amplitude = rng.uniform(0.3, 2.5, n)  # rad
    parameters = {"bob.mass": m, "bob.com[3]": -length, "gravity[3]": -g, "A.phi_start": amplitude}
    batch = gelenk.batch(pendulum(), n, parameters, step=1e-3)
    inertia = 0.05 + m * length**2
    half = 2 * ellipk(np.sin(amplitude / 2) ** 2) * np.sqrt(inertia / (m * g * length))
    assert rises(batch, 6000) == pytest.approx(half, abs=2e-8)


def test_halving_the_step_divides_the_error_by_sixteen() -> None:
    """Of the energy of a four-bar without friction and input: order 4."""
    scene = gelenk.load("scenes/four_bar.yaml")
    free = {"A.damping": 0.0} if "A.damping" in scene.parameters else {}
    errors = []
    reference = gelenk.batch(scene, 1, free, step=0.005 / 16)
    reference.run(0.5)
    for step in (0.01, 0.005):
        batch = gelenk.batch(scene, 1, free, step=step)
        batch.run(0.5)
        errors.append(np.abs(batch.array - reference.array).max())
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.15)


def test_forces_of_many_laws_are_those_of_the_library() -> None:
    """sin, exp, tanh, sqrt, powers in an expression of the angle: the kinetic energy of each lane is the work
    of the force on its way, by quadrature.
    """
    law = "-2*sin(3*phi) - 0.5*tanh(phi) + 0.1*exp(-phi)*(1 + phi^3) - sqrt(1 + phi^2)^1.5"
    source = pendulum(joint={"law": {"effort": law}}, gravity=[0, 0, 0])
    starts = np.linspace(-1.5, 1.5, 40)  # rad
    batch = gelenk.batch(source, 40, {"A.phi_start": starts}, step=1e-3)
    batch.step(400)
    phi, w = batch.states["A.phi"], batch.states["A.w"]
    inertia = 0.05 + 2 * 0.7**2  # kg m2

    def effort(x: np.ndarray) -> np.ndarray:
        out: np.ndarray = -2 * np.sin(3 * x) - 0.5 * np.tanh(x) + 0.1 * np.exp(-x) * (1 + x**3)
        return out - np.sqrt(1 + x**2) ** 1.5

    nodes, weights = np.polynomial.legendre.leggauss(40)
    middle, half = (starts + phi) / 2, (phi - starts) / 2
    work = half * (weights @ effort(middle + half * nodes[:, None]))
    assert inertia * w**2 / 2 == pytest.approx(work, abs=1e-10)  # J: steps of 1 ms err by 1e-12


def test_angles_of_many_turns_are_those_of_the_library() -> None:
    """Beyond 1e6 rad the reduction of angles is that of the library; nearby it is our own: both are exact."""
    turns = 2 * np.pi * np.array([0, 1, 1000, 100_000, 159_000, 160_000, 1_000_000])
    exact = np.remainder(turns + 1.2, 2 * np.pi)  # to 1e-10 rad, the rounding of 6e6 rad
    batch = gelenk.batch(pendulum(), len(turns), {"A.phi_start": turns + 1.2}, step=1e-3)
    reference = gelenk.batch(pendulum(), len(turns), {"A.phi_start": exact}, step=1e-3)
    batch.step(100)
    reference.step(100)
    assert batch.states["A.w"] == pytest.approx(reference.states["A.w"], abs=1e-8)


def test_time_and_element_states_go_along() -> None:
    """X' = (cos(5 t) - x) / 0.1, x(0) = 0: x = (cos 5t + T 5 sin 5t - exp(-t/T)) / (1 + (5 T)²)."""
    source = pendulum(states={"lag": "(cos(5*t) - lag)/0.1"}, joint={"law": {"effort": "0.3*lag"}})
    batch = gelenk.batch(source, 3, step=1e-3)
    batch.step(700)
    t, T = 0.7, 0.1  # s
    exact = (np.cos(5 * t) + 5 * T * np.sin(5 * t) - np.exp(-t / T)) / (1 + (5 * T) ** 2)
    assert batch.states["lag"] == pytest.approx(exact, abs=1e-9)  # h^4 / T^5 t / 120


def test_unit_quaternions_remain_of_length_one() -> None:
    """A free body without forces keeps its energy and momentum of rotation."""
    batch = gelenk.batch("scenes/free_body.yaml", 4, step=1e-3)
    names = [name for name in batch.states if ".Q[" in name]
    before = [batch.states[name].copy() for name in names]
    batch.step(1000)
    after = np.array([batch.states[name] for name in names])
    assert (after**2).sum(axis=0) == pytest.approx(1, abs=4e-16)
    assert not np.allclose(after, before)


def test_parts_of_microscopic_mechanisms_differ_from_lane_to_lane() -> None:
    """A pendulum of 2e-12 kg and 0.7 µm, with a moment of inertia of 1e-25 kg m2: each has its own period."""
    source = pendulum()
    source["bodies"]["bob"] = {"mass": 2e-12, "com": [0, 0, -7e-7], "inertia": [1e-25, 1e-25, 1e-25]}
    inertia = np.array([1e-25, 1.03e-25, 4e-25, 1e-24])  # kg m2
    batch = gelenk.batch(source, 4, {f"bob.inertia[{k}]": inertia for k in (1, 2, 3)}, step=1e-6)
    total = inertia + 2e-12 * 7e-7**2
    half = 2 * ellipk(np.sin(0.6) ** 2) * np.sqrt(total / (2e-12 * 9.81 * 7e-7))
    assert rises(batch, 4000) == pytest.approx(half, rel=1e-9)
