# SPDX-License-Identifier: BSD-3-Clause
"""`generalized-alpha` and its special cases: order 2 in positions and velocities,
damping of fast oscillations, refusals.

On x'' = -w^2 x a step multiplies (x, h v, h^2 a) by a matrix whose eigenvalues tend to -rho_inf as h w grows
(Chung & Hulbert 1993); for the trapezoidal rule two have modulus 1 for every h w.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene
from models.running import Recording, assert_close, record

import gelenk
from gelenk.chart.mechanisms import governor
from physics.loops.test_bricard import bricard
from physics.loops.test_parallelograms import falling, four_bar_chain
from physics.loops.test_singular_crossings import tip
from physics.methods.test_integrators import MOTIONS, states

ROOT = Path(__file__).parents[3]
MEMBERS = ("generalized-alpha", "hht", "newmark")


def simulate_to(
    source: dict[str, Any],
    times: Sequence[float],
    inputs: dict[str, float] | None = None,
    tolerance: float = 0.0,
    **solver: Any,
) -> Recording:
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver}))
    for name, value in (inputs or {}).items():
        simulation.set_input(name, value)
    simulation.initialize(0.0, tolerance)
    return record(simulation, times)


def errors(motion: str, found: Recording, truth: Recording) -> tuple[float, float]:
    """Largest errors of coordinates and of velocities at the last time."""
    ends = {name.split(".")[1][0]: 0.0 for name in states(motion, truth)}
    for name, value in states(motion, truth).items():
        kind = name.split(".")[1][0]
        ends[kind] = max(ends[kind], abs(float(found[name][-1] - value[-1])))
    speeds = [ends.pop(kind) for kind in ("w", "v") if kind in ends]
    return max(ends.values()), max(speeds)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("formulation", ["projection", "index3", "baumgarte", "independent"])
@pytest.mark.parametrize("member", MEMBERS)
def test_order_two_in_positions_and_speeds(motion: str, formulation: str, member: str) -> None:
    """error(h) / error(h/2) = 4 within 10 %, projection included; the heavy top has a quaternion."""
    source, inputs, _ = MOTIONS[motion]
    times = [0.0, 0.5]
    first = 2048 if motion == "heavy top" else 512
    truth = simulate_to(source(), times, dict(inputs), 1e-13, integrator="erk")
    solver: dict[str, Any] = {"integrator": member, "formulation": formulation}
    found = [
        errors(motion, simulate_to(source(), times, dict(inputs), step=1 / n, **solver), truth)
        for n in (first, 2 * first)
    ]
    for coarse, fine in zip(*found, strict=True):
        assert math.isclose(coarse / fine, 4, rel_tol=0.1), f"errors {found}"


@pytest.mark.parametrize("formulation", ["projection", "index3"])
@pytest.mark.parametrize("member", MEMBERS)
def test_order_two_across_jumps_of_the_input(formulation: str, member: str) -> None:
    """The torque changes every 1/16 s. If the auxiliary acceleration were kept across a jump, or
    reinitialized as the acceleration at the jump, each jump would add an error of order h.
    """
    source, _, _ = MOTIONS["four bar"]

    def end(tolerance: float = 0.0, **solver: Any) -> float:
        simulation = gelenk.Simulation(gelenk.load({**source(), "solver": solver}))
        simulation.initialize(0.0, tolerance)
        for k in range(8):
            simulation.set_input("drive.tau", 5.0 if k % 3 == 0 else -2.0)
            simulation.step_to((k + 1) / 16)
        return float(simulation.output("A.w"))

    truth = end(1e-13, integrator="erk")
    coarse, fine = (
        abs(end(integrator=member, formulation=formulation, step=1 / n) - truth) for n in (512, 1024)
    )
    assert math.isclose(coarse / fine, 4, rel_tol=0.1), f"errors {coarse}, {fine}"


def oscillator(rate: float) -> Scene:
    """2 kg on a spring, 0.1 m from its free length; rate [rad/s]."""
    return scene(
        {"b": body(2)},
        {
            "P": joint(
                "prismatic",
                frame("ground"),
                frame("b"),
                stiffness=2 * rate**2,
                start={"s": 0.1, "v": 0.0, "fixed": True},
            )
        },
    )


H = 1e-3


@pytest.mark.parametrize("formulation", ["projection", "index3"])
@pytest.mark.parametrize("rate", [10.0, 1e3, 1e6])
def test_trapezoidal_rules_conserve_spring_energy(rate: float, formulation: str) -> None:
    """Over 2000 steps; h w = 0.01, 1, 1000."""
    for member in MEMBERS:
        solver: dict[str, Any] = {} if member == "newmark" else {"rho_inf": 1}
        found = simulate_to(
            oscillator(rate),
            list(np.linspace(0, 2, 21)),
            step=H,
            integrator=member,
            formulation=formulation,
            **solver,
        )
        energy = found["energy.total"] / found["energy.total"][0]
        assert_close("energy", energy, 1, 1e-9, "2000 steps, each solved to 1e-13 (1 + |v|)")


@pytest.mark.parametrize(
    ("member", "rho"),
    [
        ("generalized-alpha", 0.0),
        ("generalized-alpha", 0.5),
        ("generalized-alpha", 0.8),
        ("hht", 0.6),
        ("hht", 0.8),
    ],
)
def test_fast_oscillations_are_damped_by_rho_inf(member: str, rho: float) -> None:
    """At h w = 1000: the amplitude late in the run. All eigenvalues are close to -rho,
    so the reduction per step only tends to it.
    """
    found = simulate_to(oscillator(1e6), [H * k for k in range(61)], step=H, integrator=member, rho_inf=rho)
    s = np.abs(found["P.s"])
    if rho == 0:
        assert s[10:].max() < 1e-6 * s[0]
        return
    shrunk = (s[50:60].max() / s[30:40].max()) ** (1 / 20)
    assert math.isclose(shrunk, rho, rel_tol=0.1), f"{shrunk} a step"


@pytest.mark.parametrize("member", ["generalized-alpha", "hht"])
def test_slow_oscillations_are_hardly_damped(member: str) -> None:
    """At h w = 0.05, over 16 periods, rho_inf = 0.8: the damping per period is of order (h w)^3."""
    found = simulate_to(oscillator(50.0), list(np.linspace(0, 2, 101)), step=H, integrator=member)
    energy = found["energy.total"] / found["energy.total"][0]
    assert_close("energy", energy, 1, 2e-3, "16 periods of (h w)^3 = 1.25e-4")


@pytest.mark.parametrize("member", MEMBERS)
def test_stiff_scene_is_integrated_with_long_steps(member: str) -> None:
    """The governor of test_integrators.py, for which erk needs 9000 steps,
    limited by stability. The order remains 2.
    """
    coarse, fine = (
        abs(simulate_to(governor(), [0.0, 10.0], step=step, integrator=member)["P.s"][-1] - 0.6196229171)
        for step in (1e-2, 5e-3)
    )
    assert coarse < 1e-2
    assert math.isclose(coarse / fine, 4, rel_tol=0.1), f"errors {coarse}, {fine}"


@pytest.mark.parametrize("formulation", ["projection", "index3"])
def test_loops_remain_closed(formulation: str) -> None:
    source, inputs, _ = MOTIONS["four bar"]
    times = list(np.linspace(0, 5, 51))
    found = simulate_to(
        source(), times, dict(inputs), step=H, integrator="generalized-alpha", formulation=formulation
    )
    assert found["constraints.position"].max() < 1e-11
    if formulation == "projection":
        assert found["constraints.velocity"].max() < 1e-11
    else:  # J v is constrained only by Phi = 0, to h^2 times the rates of the accelerations
        assert 1e-9 < found["constraints.velocity"].max() < 1e-3


def test_runs_are_bitwise_reproducible() -> None:
    source, inputs, _ = MOTIONS["four bar"]
    first, second = (
        simulate_to(
            source(), list(np.linspace(0, 1, 11)), dict(inputs), step=H, integrator="generalized-alpha"
        )
        for _ in range(2)
    )
    for name in states("four bar", first):
        assert np.array_equal(first[name], second[name]), name


@pytest.mark.parametrize("formulation", ["projection", "index3"])
def test_excessively_long_step_is_refused(formulation: str) -> None:
    """In 0.3 s the crank would turn by more than one radian under 100 N m.
    The state before the step is preserved.
    """
    source, _, _ = MOTIONS["four bar"]
    solver = {"integrator": "generalized-alpha", "formulation": formulation, "step": 0.3}
    simulation = gelenk.Simulation(gelenk.load({**source(), "solver": solver}))
    simulation.initialize(0.0)
    simulation.set_input("drive.tau", 100.0)
    before = simulation.values()
    with pytest.raises(gelenk.StepError, match=r"t = \S+ s: .*(Newton's method does not|closed again)"):
        simulation.step_to(30.0)
    assert simulation.time == 0
    assert_close("state", simulation.values(), before, 1e-9, "accelerations are recomputed")


@pytest.mark.parametrize("formulation", ["projection", "index3"])
@pytest.mark.parametrize("n", [1, 2])
def test_change_points_are_crossed(n: int, formulation: str) -> None:
    """28 times in 10 s (the N-four-bar of test_singular_crossings.py): steps of 1 ms cross them."""
    times = list(np.linspace(0, 10, 101))
    solver: dict[str, Any] = {"integrator": "generalized-alpha", "formulation": formulation}
    found = simulate_to(four_bar_chain(n, 0.0, 1.0), times, step=H, **solver)
    expected = tip(falling(n, 0.0, 1.0, np.array(times)))
    assert_close(
        "tip", found.vector("tip.r")[:, :2], expected, 1e-4, "ten times the observed error; h^2 is 1e-6"
    )


def test_index3_refuses_redundant_constraints() -> None:
    solver = {"integrator": "generalized-alpha", "formulation": "index3", "step": H}
    simulation = gelenk.Simulation(gelenk.load({**bricard(), "solver": solver}))
    simulation.initialize(0.0)
    with pytest.raises(gelenk.StepError, match=r"5 constraint equations of rank 4"):
        simulation.step_to(0.1)


def test_rho_inf_is_a_parameter(four_bar: gelenk.Scene) -> None:
    usual, damped = (
        gelenk.simulate(
            four_bar, stop=0.2, integrator="generalized-alpha", parameters={"solver.rho_inf": rho}
        )
        for rho in (0.8, 0.2)
    )
    difference = np.abs(usual["A.phi"] - damped["A.phi"]).max()
    assert 1e-12 < difference < 1e-4
    with pytest.raises(gelenk.UsageError, match=r"solver\.rho_inf: found 2, expected between 0 and 1"):
        gelenk.simulate(four_bar, stop=0.2, parameters={"solver.rho_inf": 2})
