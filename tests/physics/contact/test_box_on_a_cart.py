# SPDX-License-Identifier: BSD-3-Clause
"""A box that a cart carries along, sliding and sticking, against the exact solution between events.

Its corners all stop and begin to slide together, as far as rounding permits: what friction makes of the rest
decides whether methods keep the motion straight.
"""

from __future__ import annotations

from math import exp, inf

import numpy as np
import pytest
from models.touching import SceneData, box_on_a_cart
from samples import thorough_beyond
from scipy.optimize import brentq

import gelenk

G, MU, CART, BOX, DAMPING = 9.81, 0.4, 1.0, 0.5, 1.0  # of box_on_a_cart
EDGE = 0.1  # m
STEP = 0.005  # s: the force jumps, 4 steps up and 3 steps down
STEPS = 200


def force(k: int, size: float) -> float:
    return 1.5 * size if k % 7 < 4 else -2.5 * size


class Exact:
    """Positions and speeds of cart and box; the number of events."""

    def __init__(self) -> None:
        self.x, self.v = np.zeros(2), np.zeros(2)
        self.slides = 0  # sign of the box's speed relative to the cart
        self.events = 0

    def mode(self, f: float) -> int:
        """That of rest, in which friction holds or does not."""
        holding = BOX * (f - DAMPING * self.v[0]) / (CART + BOX)
        return 0 if abs(holding) <= MU * BOX * G else -int(np.sign(holding))

    def at(self, t: float, f: float) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and speeds after a time in the present mode."""
        friction = -self.slides * MU * BOX * G  # on the box
        mass, drive = (CART, f - friction) if self.slides else (CART + BOX, f)
        rate, last = DAMPING / mass, drive / DAMPING
        decay = exp(-rate * t)
        v = last + (self.v[0] - last) * decay
        x = self.x[0] + last * t + (self.v[0] - last) * (1 - decay) / rate
        if not self.slides:
            return np.array([x, self.x[1] + x - self.x[0]]), np.array([v, v])
        a = friction / BOX
        return np.array([x, self.x[1] + self.v[1] * t + a / 2 * t * t]), np.array([v, self.v[1] + a * t])

    def change(self, mode: int) -> None:
        self.events += mode != self.slides
        self.slides = mode

    def advance(self, h: float, f: float) -> None:
        if not self.slides:
            self.change(self.mode(f))
        while h > 0:
            end = self.stop(h, f) if self.slides else inf
            self.x, self.v = self.at(min(end, h), f)
            h -= min(end, h)
            if h > 0:
                self.v[1] = self.v[0]
                self.change(self.mode(f))

    def stop(self, h: float, f: float) -> float:
        """Return when the box stops on the cart, if it does within h. Its acceleration is monotonic."""

        def slip(t: float) -> float:
            v = self.at(t, f)[1]
            return self.slides * float(v[1] - v[0])

        early = 1e-9
        if slip(early) < 0 or slip(h) >= 0:
            return inf
        return float(brentq(slip, early, h, xtol=1e-16))


def exact(size: float) -> tuple[np.ndarray, int]:
    out = Exact()
    out.slides = out.mode(force(0, size))  # the start is no event
    courses = []
    for k in range(STEPS):
        out.advance(STEP, force(k, size))
        courses.append([*out.x, *out.v])
    return np.array(courses), out.events


def simulated(scene: SceneData, size: float, integrator: str, tolerance: float) -> tuple[np.ndarray, int]:
    plant = gelenk.Simulation(gelenk.load({**scene, "solver": {"integrator": integrator}}))
    plant.initialize(tolerance=tolerance)
    courses, events = [], 0
    for k in range(STEPS):
        plant.set_input("drive.f", force(k, size))
        plant.step_to((k + 1) * STEP)
        events += len(plant.events)
        courses.append(plant.values(["P.s", "J.r[1]", "P.v", "J.v[1]"]))
        assert plant.diagnostics.get("solver.scheme", 0) == 0  # `auto` has no reason to leave located events
        others = plant.values(["J.r[2]", "J.r[3]", "J.v[2]", "J.v[3]"]) - [
            0,
            scene["joints"]["J"]["start"]["r"][2],
            0,
            0,
        ]
        assert np.abs(others).max() <= 100 * tolerance
    return np.array(courses), events


@pytest.mark.parametrize("size", thorough_beyond([3.0, 5.0, 20.0], [5.0]))
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "cvode-adams"])
def test_to_the_tolerance(integrator: str, tolerance: float, size: float) -> None:
    expected, _ = exact(size)
    found, _ = simulated(box_on_a_cart(), size, integrator, tolerance)
    assert np.abs(found - expected).max() <= 100 * tolerance


@pytest.mark.parametrize("size", [3.0, 5.0, 20.0])
def test_fixed_steps_keep_the_motion_straight(size: float) -> None:
    """Rates are 1/s and steps 5 ms, so that the method's error is far below 1e-10."""
    expected, events = exact(size)
    found, logged = simulated(box_on_a_cart(), size, "rk4", 1e-6)
    assert np.abs(found - expected).max() <= 1e-9
    assert logged == events


@pytest.mark.parametrize("size", [3.0, 5.0, 20.0])
def test_each_event_is_logged_once(size: float) -> None:
    _, events = exact(size)
    _, logged = simulated(box_on_a_cart(), size, "erk", 1e-8)
    assert events > 50
    assert logged == events


@pytest.mark.parametrize("thickness", [1e-3, 0.1, 0.5])
@pytest.mark.parametrize("width", [0.3, 3.0])
def test_plates_of_any_thickness(thickness: float, width: float) -> None:
    """Upper corners of the box are not on the lower face of a plate that is thinner than the box."""
    expected, _ = exact(3.0)
    found, _ = simulated(box_on_a_cart(thickness, width), 3.0, "erk", 1e-8)
    inside = np.abs(expected[:, 1] - expected[:, 0]) < width / 2 - EDGE / 2
    first_outside = len(inside) if inside.all() else int(np.argmin(inside))
    assert first_outside > 100
    assert np.abs(found - expected)[:first_outside].max() <= 1e-6
