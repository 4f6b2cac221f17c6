# SPDX-License-Identifier: BSD-3-Clause
"""Regularized laws of friction and impact on the same problems, for comparison.

The equations of motion are written by hand in minimal coordinates and integrated with SciPy's LSODA; Python's
time is meaningless, so their cost is counted in evaluations. Spring stops are Gelenk's own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from benchmarks.nonsmooth import loaded_problems, problems
from benchmarks.nonsmooth.problems import GRAVITY, Problem
from benchmarks.nonsmooth.runs import Run, error_of, run, with_solver
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]
WIDTHS = tuple(10.0**-k for k in range(1, 8))  # rad/s, m/s: the speed of full friction
STIFFNESSES = tuple(10.0**k for k in range(2, 10))  # N m/rad
EVALUATIONS = 200_000  # a run ends after so many
BEND = (
    0.1  # s2/rad, s2/m: a bristle bends by this * width^2, so that the static limit is reached below `width`
)


class BudgetError(Exception):
    """A run takes too many evaluations."""


@dataclass(frozen=True)
class Contact:
    """Friction of one coordinate: sliding and static limit [N m, N]."""

    coulomb: float
    static: float


Law = Callable[[Contact, float, float, float], tuple[float, float]]
# (contact, width, speed, bristle) -> friction, rate of the bristle


def tanh(contact: Contact, width: float, v: float, _z: float) -> tuple[float, float]:
    """Brown & McPhee 2016: friction is largest at the speed `width`; without static excess, a tanh."""
    x = v / width
    excess = (contact.static - contact.coulomb) * x / (x * x / 4 + 0.75) ** 2
    return -(contact.coulomb * math.tanh(4 * x) + excess), 0.0


def zone(contact: Contact, width: float, v: float, _z: float) -> tuple[float, float]:
    """Proportional to the speed up to `width`, then a gradual transition from static to sliding friction."""
    x = abs(v) / width
    excess = (contact.static - contact.coulomb) * math.exp(-min((x - 1) ** 2, 700.0))
    return -math.copysign(min(x, 1.0) * contact.static if x < 1 else contact.coulomb + excess, v), 0.0


def bristle(contact: Contact, width: float, v: float, z: float) -> tuple[float, float]:
    """Canudas de Wit et al. 1995 (LuGre); its damping is nearly critical for 1 kg, 1 kg m2."""
    stiffness = contact.coulomb / (BEND * width**2)
    level = contact.coulomb + (contact.static - contact.coulomb) * math.exp(-min((v / width) ** 2, 700.0))
    rate = v - stiffness * abs(v) / level * z
    return -(stiffness * z + math.sqrt(stiffness) * rate), rate


LAWS: dict[str, Law] = {"tanh": tanh, "proportional zone": zone, "bristle": bristle}


@dataclass(frozen=True)
class Model:
    """Equations of motion: the speeds of the contacts, and the accelerations under their friction."""

    contacts: Sequence[Contact]
    start: Sequence[float]  # positions, then speeds
    slip: Callable[[Array], Sequence[float]]
    accelerations: Callable[[float, Array, Sequence[float]], Sequence[float]]
    outputs: Callable[[Array], dict[str, Array]]  # of an array of states by time


def belt() -> Model:
    return Model(
        [Contact(problems.SLIDING, problems.STATIC)], [0.0, problems.BELT_SPEED],
        lambda y: [y[1] - problems.BELT_SPEED], lambda _t, y, f: [f[0] - problems.SPRING * y[0]],
        lambda y: {"where.r[1]": y[0]},
    )  # fmt: skip


def clutch() -> Model:
    J1, J2 = problems.CLUTCH_INERTIAS

    def accelerations(t: float, _y: Array, f: Sequence[float]) -> list[float]:
        engine = problems.CLUTCH_TORQUES[max(begin for begin in problems.CLUTCH_TORQUES if begin <= t)]
        return [(engine - f[0]) / J1, (problems.CLUTCH_LOAD + f[0]) / J2]

    return Model(
        [Contact(problems.CLUTCH_SLIDING, problems.CLUTCH_STATIC)], [0.0, 0.0, 120.0, -2.5],
        lambda y: [y[3] - y[2]], accelerations, lambda y: {"shaft.phi": y[0], "clutch.phi": y[1] - y[0]},
    )  # fmt: skip


def ratios(phi: float) -> tuple[float, float, float, float, float, float]:
    """Return the angles of coupler and rocker, their first and their second derivatives in phi."""
    a, b, c, d = problems.CRANK, problems.COUPLER, problems.ROCKER, problems.GROUND
    dx, dy = a * math.cos(phi) - d, a * math.sin(phi)
    far = math.hypot(dx, dy)
    rocker = math.atan2(dy, dx) - math.acos((c * c + far * far - b * b) / (2 * c * far))
    coupler = math.atan2(c * math.sin(rocker) - dy, c * math.cos(rocker) - dx)
    sine, cosine = math.sin(rocker - coupler), math.cos(rocker - coupler)
    k2 = a * math.sin(rocker - phi) / (-b * sine)
    k3 = a * math.sin(coupler - phi) / (-c * sine)
    turn = cosine / sine * (k3 - k2)
    k2_rate = a * math.cos(rocker - phi) * (k3 - 1) / (-b * sine) - k2 * turn
    k3_rate = a * math.cos(coupler - phi) * (k2 - 1) / (-c * sine) - k3 * turn
    return coupler, rocker, k2, k3, k2_rate, k3_rate


def four_bar() -> Model:
    a, b, c = problems.CRANK, problems.COUPLER, problems.ROCKER
    own, middle, other = 2 * a**3 / 3, 2 * b**3 / 12, 2 * c**3 / 3  # kg m2; bars of 2 kg/m

    def slip(y: Array) -> list[float]:
        _, _, k2, k3, _, _ = ratios(y[0])
        return [y[1], (k2 - 1) * y[1], (k3 - k2) * y[1], k3 * y[1]]

    def accelerations(_t: float, y: Array, f: Sequence[float]) -> list[float]:
        phi, w = y[0], y[1]
        psi, rho, k2, k3, r2, r3 = ratios(phi)
        cosine, sine = math.cos(phi - psi), math.sin(phi - psi)
        whole = 2 * b * (b * b / 4) + middle
        inertia = own + 2 * b * (a * a + a * b * k2 * cosine) + whole * k2 * k2 + other * k3 * k3
        change = (
            2 * b * a * b * (r2 * cosine - k2 * sine * (1 - k2)) + 2 * whole * k2 * r2 + 2 * other * k3 * r3
        )
        weight = GRAVITY * (
            a * a * math.cos(phi)
            + 2 * b * (a * math.cos(phi) + b / 2 * k2 * math.cos(psi))
            + c * c * k3 * math.cos(rho)
        )
        torque = f[0] + (k2 - 1) * f[1] + (k3 - k2) * f[2] + k3 * f[3]
        return [(torque - weight - change * w * w / 2) / inertia]

    contacts = [Contact(torque, torque) for torque in problems.FOUR_BAR_FRICTION]
    start = [math.pi / 2, problems.FOUR_BAR_SPEED]
    return Model(contacts, start, slip, accelerations, lambda y: {"A.phi": y[0]})


def hoist() -> Model:
    """The losses of a gear, whose direction is smoothed: the contact is a smooth sign of the speed."""
    gear = loaded_problems.HOIST
    J1, J2 = gear.inertias

    def accelerations(t: float, _y: Array, f: Sequence[float]) -> list[float]:
        torque = loaded_problems.HOIST_TORQUES[
            max(begin for begin in loaded_problems.HOIST_TORQUES if begin <= t)
        ]
        direction = -f[0]
        found = []
        for sign in (1, -1):
            k = 1 + direction * gear.loss(1 if direction >= 0 else -1, sign) * sign
            a = (torque + k * gear.load / gear.ratio) / (J1 + k * J2 / gear.ratio**2)
            mesh = (J2 * a / gear.ratio - gear.load) / gear.ratio
            if sign * mesh >= 0:
                return [a]
            found.append((abs(mesh), a))
        return [min(found)[1]]

    return Model([Contact(1.0, 1.0)], [0.0, 0.0], lambda y: [y[1]], accelerations,
                 lambda y: {"first.phi": y[0]})  # fmt: skip


MODELS: dict[str, Callable[[], Model]] = {
    "belt": belt, "clutch": clutch, "four_bar": four_bar, "hoist": hoist
}  # fmt: skip


def smooth_run(problem: Problem, name: str, width: float, tolerance: float, most: int = EVALUATIONS) -> Run:
    """Return a run with a regularized law, integrated with the given tolerance."""
    model, law, count = MODELS[problem.name](), LAWS[name], 0
    n, m = len(model.start), len(model.contacts)

    def rates(t: float, y: Array) -> list[float]:
        nonlocal count
        count += 1
        if count > most:
            raise BudgetError
        speeds = model.slip(y)
        pairs = [
            law(contact, width, v, z) for contact, v, z in zip(model.contacts, speeds, y[n:], strict=True)
        ]
        forces = [f for f, _ in pairs]
        return [*y[n // 2 : n], *model.accelerations(t, y, forces), *(rate for _, rate in pairs)]

    marks = [problem.start, *sorted({*problem.times, *problem.inputs} - {problem.start})]
    state, states = np.concatenate([model.start, np.zeros(m)]), []
    try:
        for begin, end in pairwise(marks):
            # Inputs jump at `end`, and are those of before within the interval.
            inside: Any = solve_ivp(
                lambda t, y, end=end: rates(min(t, math.nextafter(end, 0)), y), (begin, end), state, "LSODA",
                rtol=tolerance, atol=tolerance * min(1.0, width),
            )  # fmt: skip
            if not inside.success:
                return Run(problem.name, "regularized", name, width, reason=str(inside.message))
            state = inside.y[:, -1]
            if end in problem.times:
                states.append(state)
    except BudgetError:
        return Run(problem.name, "regularized", name, width, reason=f"more than {most} evaluations")
    error = error_of(problem, {name: list(x) for name, x in model.outputs(np.array(states).T).items()})
    return Run(problem.name, "regularized", name, width, error, math.nan, count / (marks[-1] - marks[0]))


def restitution_of(damping_ratio: float) -> float:
    """Restitution of a spring and damper that do not pull: Schwager & Poeschel 2007."""
    return math.exp(-damping_ratio / math.sqrt(1 - damping_ratio**2) * math.acos(2 * damping_ratio**2 - 1))


def stop_run(problem: Problem, stiffness: float, rounds: int) -> Run:
    """Return a run of the pendulum with a spring stop whose damping gives the restitution."""
    moment = problems.PENDULUM_MOMENT + problems.PENDULUM_MASS * problems.PENDULUM_LENGTH**2
    ratio = float(brentq(lambda d: restitution_of(d) - problems.RESTITUTION, 0.0, 0.7))
    damping = 2 * ratio * math.sqrt(stiffness * moment)
    stop = {"lower": problems.PENDULUM_LIMIT, "stiffness": stiffness, "damping": damping}
    scene = with_solver(problems.pendulum_scene(stop=stop), integrator="auto")
    return run(problem, "spring stop", stiffness, scene, 1e-9, rounds)


def regularized(problem: Problem, quick: bool) -> list[Run]:
    """Return the runs of all regularized laws over their widths or stiffnesses."""
    if problem.name == "pendulum":
        stiffnesses = STIFFNESSES[::4] if quick else STIFFNESSES
        return [stop_run(problem, stiffness, 1 if quick else 3) for stiffness in stiffnesses]
    if problem.name not in MODELS:
        return []
    # The tolerance is well below the error of the law, which is of the order of its width.
    return [
        smooth_run(problem, name, width, max(1e-3 * width, 1e-10), EVALUATIONS // (20 if quick else 1))
        for name in LAWS
        for width in (WIDTHS[:2] if quick else WIDTHS)
    ]
