# SPDX-License-Identifier: BSD-3-Clause
"""Errors of multistep methods are proportional to the tolerance;
round-off in closing loops does not act as noise.

Multistep methods estimate errors by differences of high order, which amplify noise. The reference is the
one-step method of order 8 at 1e-13, which does not.
"""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, joint, scene
from models.running import Recording, run

import gelenk
from gelenk.chart.mechanisms import equal_slider_crank, shipped

BDF = ("ida", "cvode")


def engine(rate: float = 100.0) -> Scene:
    """A V6 engine: one crankshaft with three pins, two connecting rods on each, pistons in two banks."""
    radius, length, phi = 0.05, 0.16, 0.3
    bodies = {"crank": body(8, (0, 0, 0), (0.05, 0.06, 0.05))}
    joints = {"A": joint("revolute", frame("ground"), frame("crank"), axis=[0, 1, 0],
                         start={"phi": phi, "w": rate, "fixed": True})}  # fmt: skip
    for i in range(6):
        at, bank = 2 * math.pi / 3 * (i // 2), math.radians(30) * (1 if i % 2 else -1)
        pin = np.array([radius * math.cos(at), 0, radius * math.sin(at)])
        along = np.array([math.sin(bank), 0, math.cos(bank)])
        p = np.array(
            [radius * math.cos(at - phi), 0, radius * math.sin(at - phi)]
        )  # the pin, in ground coordinates
        s = p @ along + math.sqrt(length**2 - (p @ p - (p @ along) ** 2))
        rod = (s * along - p) / length
        turn = math.atan2(-rod[2], rod[0])
        bodies[f"rod{i}"] = body(0.6, (length / 2, 0, 0), (1e-4, 2e-3, 2e-3))
        bodies[f"piston{i}"] = body(0.5, (0, 0, 0), (1e-3, 1e-3, 1e-3))
        on_pin, in_piston = frame("crank", pin), frame(f"rod{i}", (length, 0, 0))
        axis = [0, 1, 0]
        joints[f"B{i}"] = joint("revolute", on_pin, frame(f"rod{i}"), axis=axis, start={"phi": turn - phi})
        joints[f"C{i}"] = joint("revolute", in_piston, frame(f"piston{i}"), axis=axis, start={"phi": -turn})
        joints[f"S{i}"] = joint("prismatic", frame("ground"), frame(f"piston{i}"), axis=along.tolist(),
                                start={"s": float(s)})  # fmt: skip
    return scene(bodies, joints, gravity=[0, 0, -9.81])


def largest_error(source: Scene, found: Recording, truth: Recording) -> float:
    """Largest error of coordinates and velocities, in the unit of each."""
    names = [n for n in found.joint_states(source) if n.split(".")[1][0] not in "azft"]
    return max(float(np.abs(found[n] - truth[n]).max()) for n in names)


@pytest.mark.parametrize(
    ("integrator", "finest"), [("ida", 4e-10), ("cvode", 1e-9), ("cvode-adams", 6.7e-11)]
)
def test_tolerance_limited_by_round_off_gives_a_warning(integrator: str, finest: float) -> None:
    """The values are those of docs/methods.md, where the test of one step reaches 2e-13."""
    plant = gelenk.Simulation(shipped("four_bar") | {"solver": {"integrator": integrator}})
    with warnings.catch_warnings(action="error"):
        plant.initialize(0.0, 1.1 * finest)
    with pytest.warns(
        gelenk.StartWarning, match=f"is below the accuracy that '{integrator}' can achieve"
    ) as caught:
        plant.initialize(0.0, 0.9 * finest)
    named = re.search("errors will be those of tolerance ([^;]*);", str(caught[0].message))
    assert named is not None
    assert math.isclose(float(named[1]), finest, rel_tol=0.05), "the figures are rounded"


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "rk4"])
def test_other_methods_accept_any_tolerance(integrator: str) -> None:
    plant = gelenk.Simulation(shipped("four_bar") | {"solver": {"integrator": integrator}})
    with warnings.catch_warnings(action="error"):
        plant.initialize(0.0, 1e-13)


@pytest.mark.parametrize("integrator", BDF)
def test_heavy_top_errors_are_proportional_to_the_tolerance(integrator: str) -> None:
    """The number of steps of order 5 grows as tolerance^(-1/6), and their errors accumulate: with a fixed
    share of the tolerance for each the error was 60 times the tolerance at 1e-4 and 300 to 400 times at 1e-8,
    in 2 s.
    """
    source = shipped("heavy_top")
    times = np.linspace(0, 2, 201)
    truth = run(source, times, tolerance=1e-13, integrator="erk")
    for tolerance in (1e-4, 1e-6, 1e-8):
        error = largest_error(source, run(source, times, tolerance=tolerance, integrator=integrator), truth)
        assert error < 100 * tolerance, f"{error / tolerance:.3g} times {tolerance}"


@warned.TIGHT
@pytest.mark.parametrize("integrator", BDF)
def test_closing_six_loops_adds_no_noise(integrator: str) -> None:
    """A fifth of a second at 1e-10, three turns: about 3000 steps. With the noise of projection, a closure
    error of 1e-14 m over a crank of 5 cm, runs took hundreds of thousands of steps or did not terminate. The
    engine itself amplifies errors by a factor of about 20.
    """
    source = engine()
    times = np.linspace(0, 0.2, 201)
    truth = run(source, times, tolerance=1e-13, integrator="erk")
    found = run(source, times, tolerance=1e-10, integrator=integrator)
    assert found["solver.steps"][-1] < 10_000
    assert largest_error(source, found, truth) < 1000 * 1e-10


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-9])
@pytest.mark.parametrize("integrator", BDF)
def test_slider_crank_crosses_its_change_points(integrator: str, tolerance: float) -> None:
    """Crank and rod are equally long: `cvode` was refused there at 1e-8. 5 s, compared with `erk`."""
    source = equal_slider_crank(0.5, 4.0)
    times = np.linspace(0, 5, 101)
    truth = run(source, times, tolerance=1e-13, integrator="erk")
    found = run(source, times, tolerance=tolerance, integrator=integrator)
    assert largest_error(source, found, truth) < 100 * tolerance
    assert found["solver.steps"][-1] < 20_000


@warned.TIGHT
@pytest.mark.parametrize("tolerance", [1e-8, 1e-9, 1e-10])
@pytest.mark.parametrize("integrator", BDF)
def test_andrews_mechanism_terminates(integrator: str, tolerance: float) -> None:
    """Andrews' mechanism, with a size of some centimeters, in steps of 0.03 ms: at 1e-8 `cvode` did not
    finish within a minute, and at 1e-9 it took 3 million steps, whose errors accumulated to 1000 times the
    tolerance.
    """
    source = shipped("andrews")
    times = np.linspace(0, 0.03, 1001)
    truth = run(source, times, tolerance=1e-13, integrator="erk")
    found = run(source, times, tolerance=tolerance, integrator=integrator)
    names = [n for n in found.joint_states(source) if n.split(".")[1][0] not in "azft"]
    # relative to the largest value: speeds reach 1e4 rad/s
    scales = {n: max(1.0, float(np.abs(truth[n]).max())) for n in names}
    worst = max(float(np.abs(found[n] - truth[n]).max()) / scales[n] for n in names)
    assert worst < 100 * tolerance, f"{worst / tolerance:.3g} times {tolerance}"
    assert found["solver.steps"][-1] < 60_000
