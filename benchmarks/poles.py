# SPDX-License-Identifier: BSD-3-Clause
"""Stiff electrical poles in docs/stability.md: a DC motor whose armature has L/R from 1 s to 1e-6 s.

The motor is linear, so that every run is compared with its closed form. Methods with error control run at
several tolerances, those with fixed steps at several steps. The voltage is constant, or jumps at every
communication step, after which the fast pole is excited again and multistep methods start anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gelenk.chart.case import Array, Case, Jumps
from gelenk.chart.measure import Reference, Run, Task, scales_of
from gelenk.chart.mechanisms import Scene, body, hinge, scene
from gelenk.chart.methods import DEFAULT, Method, all_methods
from gelenk.chart.work_precision import run_all
from gelenk.chart.workers import Failure

R, K, ROTOR, VOLTAGE = 1.2, 0.4, 0.05, 12.0  # Ohm, N.m/A, kg m², V
TIME_CONSTANTS = tuple(10.0**-n for n in range(7))  # s, L/R
TOLERANCES = tuple(10.0**-n for n in range(3, 11))
STEPS = tuple(10.0**-n for n in range(1, 7))  # s, of methods with fixed steps
VOLTAGES = Jumps(3.0, 10.0)  # V, those that jump
STOP, STEP, JUMP_STEP = 1.0, 0.1, 0.01  # s; the speed follows with a time constant of 0.4 s


@dataclass(frozen=True)
class Settings:
    """What is run; `limit` is the wall-clock time of one run [s]."""

    jumps: bool = False
    time_constants: tuple[float, ...] = TIME_CONSTANTS
    tolerances: tuple[float, ...] = TOLERANCES
    steps: tuple[float, ...] = STEPS
    limit: float = 20.0
    jobs: int = 1


QUICK = Settings(False, (1.0, 1e-3), (1e-4, 1e-6), (1e-1, 1e-2), 5.0)


@dataclass(frozen=True)
class PoleMap:
    """The runs of all methods."""

    settings: Settings
    methods: list[Method]
    runs: list[Run]

    def cell(self, method: Method, time_constant: float, asked: float) -> Run:
        """Return a run; asked: its tolerance, or its step [s] if that is fixed."""
        for run in self.runs:
            at = run.step if method.fixed_step else run.tolerance
            if run.method == method.name and run.scene == name_of(time_constant) and at == asked:
                return run
        raise KeyError(f"{method.name}, {time_constant}, {asked}")

    def asked(self, method: Method) -> tuple[float, ...]:
        """Return the tolerances or the steps [s] of a method."""
        return asked(method, self.settings)


def asked(method: Method, settings: Settings) -> tuple[float, ...]:
    """Return the tolerances of a method, or its steps [s], of which none exceeds the communication step."""
    if not method.fixed_step:
        return settings.tolerances
    return tuple(x for x in settings.steps if x <= (JUMP_STEP if settings.jumps else STEP))


def short_power(x: float) -> str:
    """Return a power of ten as 1e-3."""
    return f"{x:.0e}".replace("e-0", "e-").replace("e+00", "")


def name_of(time_constant: float) -> str:
    return f"armature-{short_power(time_constant)}"


def motor(time_constant: float) -> Scene:
    """Return a DC motor with an armature of this time constant L/R [s]; its voltage is an input."""
    return scene(
        {"rotor": body(1.0, inertia=(ROTOR, ROTOR, ROTOR))},
        {"axle": hinge("ground", "rotor", law={"effort": "k*i"})},
        constants={"R": R, "L": R * time_constant, "k": K},
        inputs={"u": {"unit": "V"}},
        states={"i": {"rate": "(u - R*i - k*axle.w)/L", "unit": "A"}},
    )


def response(time_constant: float, times: Array) -> Array:
    """Return angle, speed and current after a step of the voltage by 1 V at rest; shape (times, 3).

    The poles satisfy p + q = -R/L, p q = k²/(J L); the slow one from the product, without cancellation.
    """
    product = K * K / (ROTOR * R * time_constant)
    p = -(1 + np.sqrt(1 - 4 * product * time_constant**2 + 0j)) / (2 * time_constant)
    q = product / p
    fast, slow = np.expm1(p * times), np.expm1(q * times)
    angle = (times + (q / p * fast - p / q * slow) / (p - q)) / K
    speed = (q * fast - p * slow) / (p - q) / K
    current = ROTOR / K * product * (fast - slow) / (p - q) / K
    return np.stack([angle.real, speed.real, current.real], axis=1)


def motor_truth(time_constant: float, case: Case) -> Array:
    """Return angle, speed and current at the samples: the responses to all steps of the voltage, added up."""
    grid, u = case.grid, case.inputs["u"]
    if not isinstance(u, Jumps):
        return VOLTAGE * response(time_constant, grid[case.samples()])
    states = np.zeros((len(grid), 3))
    before = 0.0
    for k in range(len(grid) - 1):
        states[k:] += (u.at(k) - before) * response(time_constant, grid[k:] - grid[k])
        before = u.at(k)
    return states[case.samples()]


def case_of(time_constant: float, jumps: bool) -> Case:
    """Return the case of a time constant [s]."""
    about = f"A DC motor with L/R = {short_power(time_constant)} s."
    scene, name = motor(time_constant), name_of(time_constant)
    if jumps:
        return Case(name, about, scene, STOP, JUMP_STEP, {"u": VOLTAGES})
    return Case(name, about, scene, STOP, STEP, {"u": VOLTAGE})


def reference(time_constant: float, case: Case) -> Reference:
    """Return the closed form, accurate to rounding; without springs all energy is kinetic."""
    states = motor_truth(time_constant, case)
    kinetic = ROTOR / 2 * np.concatenate([[0.0], states[:, 1]]) ** 2
    digits = 100 * float(np.finfo(float).eps) * float(np.abs(states).max())
    return Reference(states, scales_of(states), kinetic, kinetic, digits, "closed form")


def methods() -> list[Method]:
    """Return `auto` and all integrators; without loops, all formulations are identical."""
    return [m for m in all_methods() if m.automatic or m.formulation == DEFAULT]


def pole_map(settings: Settings, progress: Callable[[float], None] | None = None) -> PoleMap:
    """Run all methods on all time constants."""
    chosen = methods()
    tasks: list[Task] = []
    truth: dict[str, Reference | Failure] = {}
    for time_constant in settings.time_constants:
        case = case_of(time_constant, settings.jumps)
        truth[case.name] = reference(time_constant, case)
        for method in chosen:
            fixed = method.fixed_step
            tasks += [
                Task(case, method, *((None, x) if fixed else (x, None))) for x in asked(method, settings)
            ]
    return PoleMap(settings, chosen, run_all(tasks, truth, settings.jobs, settings.limit, progress))
