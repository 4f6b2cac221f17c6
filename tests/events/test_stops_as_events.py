# SPDX-License-Identifier: BSD-3-Clause
"""Times and number of events at joint stops compared with closed-form solutions, for every integrator."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk
from gelenk.chart.mechanisms import stopped_four_bar

MASS, STIFFNESS, HEIGHT = 1.3, 5200.0, 0.45  # kg, N/m, m: contacts of 0.05 s
OMEGA = math.sqrt(STIFFNESS / MASS)  # rad/s
FALL = math.sqrt(2 * HEIGHT / GRAVITY)  # s
SPEED = GRAVITY * FALL  # m/s, at contact
SAG = GRAVITY / OMEGA**2  # m
# In contact s = SAG (cos wt - 1) - SPEED/w sin wt until it is 0 again (Landau & Lifshitz, section 21).
CONTACT = 2 / OMEGA * (math.pi - math.atan(SPEED * OMEGA / GRAVITY))  # s
PERIOD = 2 * FALL + CONTACT
ADAPTIVE = ["auto", "erk", "dirk", "ida", "cvode", "cvode-adams"]
ORDERS = {"rk4": 4, "euler": 1, "generalized-alpha": 2, "hht": 2, "newmark": 2}
END = 2.1  # s: three bounces
TIMES = [n * PERIOD + t for n in range(3) for t in (FALL, FALL + CONTACT)]


def ball(**solver: Any) -> Scene:
    """A ball that falls on an undamped stop."""
    return scene(
        {"ball": body(MASS)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("ball"),
                axis=[0, 0, 1],
                start={"s": HEIGHT, "v": 0.0, "fixed": True},
                stop={"stiffness": STIFFNESS, "lower": 0.0},
            )
        },
        gravity=[0, 0, -GRAVITY],
        solver=solver,
    )


def height(t: float) -> float:
    """Height of the ball [m]."""
    tau = t % PERIOD
    if FALL < tau < FALL + CONTACT:
        x = OMEGA * (tau - FALL)
        return SAG * (math.cos(x) - 1) - SPEED / OMEGA * math.sin(x)
    since = tau if tau < FALL else tau - PERIOD
    return HEIGHT - GRAVITY / 2 * since**2


def event_messages(count: int) -> list[str]:
    return [f"J.s {('meets', 'leaves')[i % 2]} the stop at its lower bound" for i in range(count)]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize("step", [0.01, 0.35])
def test_event_times_of_a_bouncing_ball_match_closed_form(
    integrator: str, tolerance: float, step: float
) -> None:
    found = gelenk.simulate(ball(integrator=integrator), stop=END, step=step, tolerance=tolerance)
    assert [text for _, text in found.events] == event_messages(len(TIMES))
    times = np.array([t for t, _ in found.events])
    # s: an error of the height shifts the contact by 0.34 times as much, and accumulates over three bounces.
    assert np.abs(times - TIMES).max() < 10 * tolerance
    assert abs(found["J.s"][-1] - height(END)) < 30 * tolerance  # m, at up to 3 m/s


@pytest.mark.parametrize("integrator", ORDERS)
def test_fixed_step_methods_keep_their_order_across_events(integrator: str) -> None:
    """The step is halved starting from 1.25 ms, which is a fortieth of the oscillation in contact."""
    order = ORDERS[integrator]

    def error(step: float) -> float:
        found = gelenk.simulate(ball(integrator=integrator, step=step), stop=END, step=0.01)
        assert len(found.events) == len(TIMES)
        return float(np.abs(found["J.s"] - [height(t) for t in found.time]).max())

    # Euler's method reaches its order only where its error is a small fraction of the height.
    steps = [1.25e-3 / 2**k for k in ((4, 5, 6) if order == 1 else (0, 1, 2))]
    for coarse, fine in pairwise([error(step) for step in steps]):
        assert coarse / fine > 0.75 * 2**order


def test_energy_is_conserved_over_an_hour_of_bounces() -> None:
    """5500 bounces, each without loss."""
    found = gelenk.simulate(
        ball(), stop=3600, step=10, tolerance=1e-10, outputs=["energy.total", "solver.events"]
    )
    energy = found["energy.total"]
    assert np.abs(energy / (MASS * GRAVITY * HEIGHT) - 1).max() < 1e-8
    whole, part = divmod(3600, PERIOD)
    assert found["solver.events"][-1] == 2 * whole + (part > FALL) + (part > FALL + CONTACT)


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4", "generalized-alpha"])
def test_restored_states_continue_bitwise_identically_at_events(integrator: str) -> None:
    """Steps of 7 ms: some contain an event, some are in contact, some in flight."""

    def started() -> gelenk.Simulation:
        plant = gelenk.Simulation(gelenk.load(ball(integrator=integrator, step=1e-3)))
        plant.initialize(0.0, 1e-7)
        return plant

    plant = started()
    heights, events, saved = [], [], {}
    for k in range(1, 120):
        plant.step_to(0.007 * k)
        heights.append(plant.output("J.s"))
        events += plant.events
        if plant.events or k % 10 == 0:
            saved[k] = plant.save(), plant.diagnostic("solver.events")
    assert len(events) >= 2
    for k, (state, count) in saved.items():
        other = started()
        other.restore(state)
        again = []
        for j in range(k + 1, 120):
            other.step_to(0.007 * j)
            again.append(other.output("J.s"))
            if j == k + 1:
                assert other.diagnostic("solver.events") == count + len(other.events)
        assert again == heights[k:]


def test_step_with_too_many_events_is_refused() -> None:
    """Three bounces in one communication step cause six events."""
    for most, fits in ((6, True), (5, False)):
        source = ball(max_events=most)
        if fits:
            assert len(gelenk.simulate(source, stop=END, step=END).events) == most
            continue
        with pytest.raises(gelenk.StepError) as e:
            gelenk.simulate(source, stop=END, step=END)
        said = str(e.value)
        assert "more than 5 events (solver.max_events) since t = 0 s" in said
        assert "the last: J.s leaves the stop at its lower bound" in said


def test_no_contact_gives_no_event() -> None:
    """The ball starts 1 um above the height required to reach the stop, and 1 um below it."""
    reached = HEIGHT - GRAVITY / 2 * 0.3**2
    for gap, count in ((-1e-6, 0), (1e-6, 1)):
        source = ball()
        source["joints"]["J"]["stop"]["lower"] = reached + gap
        assert len(gelenk.simulate(source, stop=0.3, step=0.1, tolerance=1e-10).events) == count


def test_fmu_logs_its_events(tmp_path: Path) -> None:
    """Events are logged in the category logEvents, which is off unless requested by the master."""
    fmu = gelenk.export_fmu(ball(), tmp_path / "ball.fmu")
    for wanted in (True, False):
        said: list[tuple[bytes, str]] = []

        def logger(_env: Any, _name: bytes, _status: int, category: bytes, message: bytes) -> None:
            said.append((category, message.decode()))  # noqa: B023

        found = fmpy.simulate_fmu(
            str(fmu), stop_time=END, output_interval=0.01, logger=logger, debug_logging=wanted,
            output=["solver.events"],
        )  # fmt: skip
        assert found["solver.events"][-1] == len(TIMES)
        logged = [
            message for category, message in said if category == b"logEvents" and " the stop " in message
        ]
        times = [float(message.split()[2]) for message in logged]
        # s: printed with six digits
        assert times == (pytest.approx(TIMES, abs=1e-5) if wanted else [])
        assert [message.split(": ")[1] for message in logged] == (
            event_messages(len(TIMES)) if wanted else []
        )


@pytest.mark.parametrize("formulation", ["index3", "stabilized-index2"])
def test_multipliers_are_integrated_across_events(formulation: str) -> None:
    """A rocker strikes a stop: `ida` integrates across the event and reports the
    same events, at about the same times.
    """
    source = stopped_four_bar()
    found, truth = (
        gelenk.simulate(source | {"solver": solver}, stop=2, step=0.01, tolerance=1e-6)
        for solver in ({"formulation": formulation, "integrator": "ida"}, {"integrator": "erk"})
    )
    assert len(truth.events) >= 2
    assert [text for _, text in found.events] == [text for _, text in truth.events]
    times, true = (np.array([t for t, _ in run.events]) for run in (found, truth))
    assert np.abs(times - true).max() < 1e-3  # s: contacts of some milliseconds, several steps each
    # rad: about a hundred tolerances: only the error test reacts to the jump of the force
    assert np.abs(found["D.phi"] - truth["D.phi"]).max() < 1e-3


@pytest.mark.parametrize("integrator", ["erk", "rk4", "cvode"])
def test_there_are_no_events_before_the_first_step(integrator: str) -> None:
    """Also after restoring a saved state: preparatory steps do not count as steps of the run."""
    source = ball(integrator=integrator, step=1e-3)
    source["joints"]["J"]["start"].update({"s": 1e-4, "v": -1.0})  # contact begins after 0.1 ms
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    start = plant.save()
    assert (plant.events, plant.diagnostic("solver.events")) == ([], 0)
    plant.step_to(0.01)
    assert [text for _, text in plant.events] == event_messages(1)
    assert plant.diagnostic("solver.events") == 1
    plant.restore(start)
    assert (plant.events, plant.diagnostic("solver.events")) == ([], 0)


@pytest.mark.parametrize("integrator", ["erk", "cvode", "rk4"])
def test_interrupted_step_continues_counting_events(integrator: str) -> None:
    """One communication step over three bounces,
    interrupted at each exhausted evaluation budget, and continued.
    """
    plant = gelenk.Simulation(gelenk.load(ball(integrator=integrator, step=1e-3, max_evaluations=100)))
    plant.initialize(0.0, 1e-8)
    cut, events = 0, []
    while plant.time < END:
        try:
            plant.step_to(END)
        except gelenk.StepBudgetError:
            cut += 1
        events += plant.events
    assert cut > len(TIMES)
    assert plant.diagnostic("solver.events") == len(TIMES)
    assert [text for _, text in events] == event_messages(len(TIMES))
