# SPDX-License-Identifier: BSD-3-Clause
"""Assembly: loops close exactly, initial guesses are kept by weighted least squares and select the branch."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, four_bar, four_bar_angles, reordered
from scipy.optimize import brentq

import gelenk
from gelenk.chart import mechanisms as shipped

pytestmark = warned.GUESSES

LINKS = (0.5, 1.75, 1.5, 2.0)
JOINTS = "ABCD"
# Closed forms and assembly are both exact to some tens of rounding errors of angles of order 1.
ROUNDING = 1e-13


def angles(phi: float, open_branch: bool = True) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Joint angles A, B, C, D [rad] of the four-bar, C above or below the line from the crank's tip to D."""
    theta, psi = four_bar_angles(phi, LINKS)
    if not open_branch:  # the mirror image in the diagonal
        crank, _, _, ground = LINKS
        diagonal = math.atan2(-crank * math.sin(phi), ground - crank * math.cos(phi))
        theta, psi = 2 * diagonal - theta, 2 * diagonal - psi
        psi += 2 * math.pi * round((math.pi / 2 - psi) / (2 * math.pi))
    return np.array([phi, theta - phi, psi - theta, psi])


def rates(phi: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Derivatives of the joint angles by phi, from the velocity of the rocker's pin."""
    crank, coupler, rocker, _ = LINKS
    theta, psi = four_bar_angles(phi, LINKS)
    dtheta = crank * math.sin(psi - phi) / (coupler * math.sin(theta - psi))
    dpsi = crank * math.sin(phi - theta) / (rocker * math.sin(psi - theta))
    return np.array([1, dtheta - 1, dpsi - dtheta, dpsi])


def bare() -> Scene:
    """The four-bar without start values."""
    out = four_bar()
    for joint in JOINTS:
        out["joints"][joint]["start"] = {}
    return out


def with_starts(source: Scene, **starts: dict[str, Any]) -> Scene:
    """A copy of the scene with other start values of these joints."""
    out = copy.deepcopy(source)
    for joint, start in starts.items():
        out["joints"][joint]["start"] = start
    return out


def assembled(source: Any, quantity: str = "phi") -> np.ndarray[Any, np.dtype[np.float64]]:
    plant = gelenk.Simulation(source)
    plant.initialize()
    return np.array([plant.output(f"{joint}.{quantity}") for joint in JOINTS])


GUESSES = np.array([1.3, -0.1, 1.0, 2.1])
WEIGHTS = np.array([2.0, 0.5, 3.0, 10.0])


def nearest(guesses: Any, weights: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The angles at which the derivative of the weighted squared distance by the crank angle vanishes."""
    gradient: Callable[[float], float] = lambda phi: float(weights @ ((angles(phi) - guesses) * rates(phi)))  # noqa: E731
    return angles(brentq(gradient, 0.3, 2.5, xtol=1e-15, rtol=1e-14))


def test_rates_of_the_reference_are_the_derivatives_of_its_angles() -> None:
    """Central differences: the error is h^2 times third derivatives of order 1, plus eps / h."""
    h = 1e-5
    assert np.abs((angles(1.1 + h) - angles(1.1 - h)) / (2 * h) - rates(1.1)).max() < 1e-9


@pytest.mark.parametrize("seed", [None, 1, 2, 3, 4])
def test_inconsistent_guesses_are_met_by_least_squares_and_the_loop_closes_exactly(seed: int | None) -> None:
    """Residuals exceed a tenth of a radian. The order of the file determines which joint is cut."""
    source = with_starts(
        bare(),
        **{j: {"phi": GUESSES[i], "weight": WEIGHTS[i]} for i, j in enumerate(JOINTS)},
    )
    if seed is not None:
        source = reordered(source, seed) | {"solver": {"reductions": {"cut_choice": False}}}
    truth = nearest(GUESSES, WEIGHTS)
    assert np.abs(truth - GUESSES).max() > 0.1
    # At the minimum: the gradient is exact, differences of 1e-5 give second derivatives to 1e-10.
    assert np.abs(assembled(source) - truth).max() < 1e-12


def test_default_weight_of_guesses_is_one() -> None:
    plain = with_starts(bare(), **{j: {"phi": GUESSES[i]} for i, j in enumerate(JOINTS)})
    weighed = with_starts(bare(), **{j: {"phi": GUESSES[i], "weight": 1} for i, j in enumerate(JOINTS)})
    assert (assembled(plain) == assembled(weighed)).all()
    assert np.abs(assembled(plain) - nearest(GUESSES, np.ones(4))).max() < 1e-12


def test_guess_with_a_large_weight_is_nearly_kept_and_one_of_weight_zero_is_ignored() -> None:
    heavy = with_starts(bare(), A={"phi": 1.3, "weight": 1e6}, D={"phi": 2.1, "weight": {"phi": 1}})
    moved = assembled(heavy)[0] - 1.3
    # To first order weight * moved + residual of D * rate of D = 0; joints without a guess have weight 1e-4.
    assert moved == pytest.approx(-(angles(1.3)[3] - 2.1) * rates(1.3)[3] / 1e6, rel=5e-3)
    forgotten = with_starts(bare(), A={"phi": 1.3, "weight": 0}, D={"phi": 2.1})
    assert assembled(forgotten)[3] == pytest.approx(2.1, abs=2e-3)  # others: weight 1e-4, up to 2 rad


def test_least_squares_gradient_of_the_five_bar_vanishes_along_its_free_motions() -> None:
    """The sum of weight * change * velocity over all joints vanishes for both free motions."""
    source = shipped.shipped("five_bar")
    names = list(source["joints"])
    rng = np.random.default_rng(3)
    start = gelenk.Simulation(source)
    start.initialize()
    guesses = {j: start.output(f"{j}.phi") + rng.uniform(-0.3, 0.3) for j in names}
    weights = {j: float(rng.uniform(0.2, 5)) for j in names}
    for pattern in ((1.0, 0.0), (0.0, 1.0)):
        moving = copy.deepcopy(source)
        for j in names:
            moving["joints"][j]["start"] = {"phi": guesses[j], "weight": weights[j]}
        for j, w in zip(driven(source), pattern, strict=True):
            moving["joints"][j]["start"] |= {"w": w, "fixed": ["w"]}
        plant = gelenk.Simulation(moving)
        plant.initialize()
        changes = {j: plant.output(f"{j}.phi") - guesses[j] for j in names}
        assert max(map(abs, changes.values())) > 0.02
        across = sum(weights[j] * changes[j] * plant.output(f"{j}.w") for j in names)
        assert abs(across) < 1e-11  # changes of 0.1, weights of 1, some tens of rounding errors


def driven(source: Scene) -> list[str]:
    return [motor["joint"] for motor in source["motors"].values()]


@pytest.mark.parametrize("joint", ["B", "C", "D"])
@pytest.mark.parametrize("open_branch", [True, False])
@pytest.mark.parametrize("seed", [None, 1, 2, 5])
def test_one_guess_at_any_joint_selects_the_branch(joint: str, open_branch: bool, seed: int | None) -> None:
    """The crank is fixed, the guess differs from the solution by 0.05 rad. Some order cuts each joint."""
    truth = angles(1.1, open_branch)
    guess = float(truth[JOINTS.index(joint)] + 0.05)
    source = with_starts(bare(), A={"phi": 1.1, "fixed": True}, **{joint: {"phi": guess}})
    if seed is not None:
        source = reordered(source, seed) | {"solver": {"reductions": {"cut_choice": False}}}
    apart = np.remainder(assembled(source) - truth + math.pi, 2 * math.pi) - math.pi
    assert np.abs(apart).max() < ROUNDING * 10


def test_velocity_guesses_are_met_by_weighted_least_squares() -> None:
    """Along the only motion s: v = s (sum weight s guess) / (sum weight s^2)."""
    speeds = np.array([2.0, 1.0, -3.0, 0.4])
    values = angles(1.1)
    source = with_starts(
        bare(),
        **{
            j: {"phi": values[i], "w": speeds[i], "weight": {"phi": 1, "w": WEIGHTS[i]}}
            for i, j in enumerate(JOINTS)
        },
    )
    s = rates(1.1)
    truth = s * (WEIGHTS @ (s * speeds)) / (WEIGHTS @ (s * s))
    assert np.abs(assembled(source, "w") - truth).max() < ROUNDING * 10


def test_weights_are_written_as_they_were_read() -> None:
    source = with_starts(
        bare(),
        A={"phi": 1.0, "w": 2.0, "weight": 5},
        B={"phi": 1.0, "w": 2.0, "weight": {"w": 0.5}},
        C={"phi": 1.0, "weight": 1, "fixed": True},
    )
    joints = gelenk.load(source).to_dict()["joints"]
    assert joints["A"]["start"] == {"phi": 1.0, "w": 2.0, "weight": {"phi": 5, "w": 5}}
    assert joints["B"]["start"] == {"phi": 1.0, "w": 2.0, "weight": {"w": 0.5}}
    assert joints["C"]["start"] == {"phi": 1.0, "fixed": True}


def test_branch_is_kept_for_all_fixed_crank_angles() -> None:
    """The guesses of the other joints belong to one crank angle; at others they are wrong by radians."""
    source = gelenk.load(shipped.shipped("four_bar"))
    for phi in np.linspace(0, 2 * math.pi, 60):
        assert math.sin(assembled(source.with_parameters({"A.phi_start": float(phi)}))[2]) > 0
