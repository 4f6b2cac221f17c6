# SPDX-License-Identifier: BSD-3-Clause
"""Series of impacts of several limits, and joints with dry friction that they set in motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from models.coupled_limits import bouncing_slider, hand, stopped_carriage, with_unreachable_floor
from models.running import assert_close

import gelenk

from .test_joint_friction import plant, read

INTEGRATORS = ("erk", "cvode", "ida", "dirk")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_series_of_two_limits_ends_beside_contacts_as_without_them(integrator: str) -> None:
    """The slider bounces 12 times, with gravity towards its limit and the arm at rest at its own."""
    names = ("j0.phi", "j0.w", "j1.s", "j1.v")
    found = []
    for source in (bouncing_slider(), with_unreachable_floor(bouncing_slider(), "b0")):
        simulation = plant(source, 1e-8, integrator)
        simulation.step_to(0.62)
        counts = [simulation.diagnostic(f"solver.{name}") for name in ("events", "impacts", "zeno")]
        found.append((counts, [read(simulation, name) for name in names]))
    (alone, values), (beside, others) = found
    assert alone[:2] == beside[:2] == [13, 13]
    assert alone[2] >= 1  # series that have ended; the arm, which is struck by the last one, may count, too
    assert beside[2] >= 1
    assert_close("state", others, values, 1e-9, "10 times the tolerance per m")
    assert (values[1], values[3]) == (0, 0)


@pytest.mark.parametrize(
    ("slip", "floor", "resolved"),
    [(0.5e-9, False, False), (2e-9, False, True), (1.5e-11, True, False), (1e-10, True, True)],
)
def test_slip_that_an_impact_causes_is_resolved_to_a_thousandth_of_the_tolerance(
    slip: float, floor: bool, resolved: bool
) -> None:
    """A shorter slip is none: the impact stops what friction would stop so soon.

    The tolerance of 1e-6 is relative to the size of the scene: 1 m, or some 0.03 m with the ball.
    """
    source = stopped_carriage(slip)
    if floor:
        source = with_unreachable_floor(source, "block")
    simulation = plant(source, 1e-6, "erk")
    texts = []
    for k in range(1, 4):
        simulation.step_to(0.1 * k)
        texts += [event[1] for event in simulation.events if event[0] > 0]
    slips = ["A.s slips in its positive direction", "A.s sticks"] if resolved else []
    assert texts == ["B.s meets its upper limit", *slips]
    assert (read(simulation, "A.v"), read(simulation, "B.v")) == (0, 0)
    # 1e-12: the rounding of motions at 1e-3 m/s
    assert_close("A.s", read(simulation, "A.s"), slip if resolved else 0.0, 1e-12, "see above")


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_slip_left_out_follows_the_tolerance(tolerance: float) -> None:
    """The same slip of 5e-10 m is resolved where the tolerance asks for it."""
    simulation = plant(stopped_carriage(5e-10), tolerance, "erk")
    simulation.step_to(0.3)
    expected = 5e-10 if tolerance < 1e-7 else 0.0
    assert_close("A.s", read(simulation, "A.s"), expected, 1e-12, "rounding of a slow motion")


def course(source: dict[str, Any], **solver: Any) -> tuple[gelenk.Simulation, np.ndarray]:
    """Simulate for 0.2 s; return the energies."""
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver}))
    simulation.initialize()
    energy = [simulation.diagnostic("energy.total")]
    for k in range(1, 21):
        simulation.step_to(0.01 * k)
        energy.append(simulation.diagnostic("energy.total"))
    return simulation, np.array(energy)


@warned.TURNS
def test_hand_with_many_limits_falls() -> None:
    """Each impact of a finger would let six joints with friction slip for some nanoseconds, whose stop
    throws off other fingers.
    """
    simulation, energy = course(hand(5))
    assert simulation.diagnostic("solver.events") < 1000
    assert simulation.diagnostic("solver.evaluations") < 60_000
    assert np.diff(energy).max() <= 1e-6 * np.ptp(energy)  # the tolerance
