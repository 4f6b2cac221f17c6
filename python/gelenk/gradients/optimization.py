# SPDX-License-Identifier: BSD-3-Clause
"""Designs: the values of parameters with which a run is best."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import AssemblyError, SceneError, StepError, UsageError
from gelenk.gradients.differentiation import sensitivity
from gelenk.gradients.run import DifferentiatedRun, vjp
from gelenk.model.scene import Source, load
from gelenk.model.values import Value
from gelenk.simulation.inputs import Inputs

type Array = NDArray[np.float64]
type Objective = Callable[[DifferentiatedRun], tuple[float, Mapping[str, ArrayLike]]]


@dataclass(frozen=True)
class Optimum:
    """The best design that was found.

    Attributes:
        values: of the parameters, by name.
        objective: its value there.
        gradient: its derivatives by the parameters.
        at_bounds: names of the parameters that are at a bound.
        run: the simulation with these values.
        runs: number of simulations with derivatives.
        failed: number of designs that could not be simulated or differentiated.
        success: whether the search has converged.
        message: how it ended.
    """

    values: dict[str, float]
    objective: float
    gradient: dict[str, float]
    at_bounds: tuple[str, ...]
    run: DifferentiatedRun
    runs: int
    failed: int
    success: bool
    message: str


def optimize(
    scene: Source,
    variables: Mapping[str, tuple[float, float, float]],
    objective: Objective,
    *,
    outputs: list[str],
    parameters: Mapping[str, Value] | None = None,
    inputs: Inputs | None = None,
    stop: float | None = None,
    step: float | None = None,
    accuracy: float = 1e-7,
) -> Optimum:
    """Find values of parameters that minimize a function of the outputs of a run.

    Uses `scipy.optimize.minimize` (L-BFGS-B) with the derivatives of `gelenk.sensitivity`. It finds a local
    minimum near the guess. Designs that cannot be assembled or simulated are avoided.

    Args:
        scene: anything `gelenk.load` accepts.
        variables: for each parameter a guess, and its lower and upper bound.
        objective: function of a run that returns a number, and its derivatives by the values of outputs, by
            name; outputs that it does not name have no influence.
        outputs: names and patterns of the outputs.
        parameters: values that differ from those of the scene, by name.
        inputs: as in `gelenk.simulate`.
        stop: end of the run [s]; by default that of the scene.
        step: communication step [s].
        accuracy: as in `gelenk.sensitivity`.

    Returns:
        Optimum: values and the run with them.

    Raises:
        SceneError, AssemblyError, StepError, UsageError: an argument is invalid, or the guess cannot be
            simulated.

    >>> def fast(run):  # the crank at the end of the run
    ...     weights = np.zeros(len(run.time))
    ...     weights[-1] = -1
    ...     return -run["A.phi"][-1], {"A.phi": weights}
    >>> best = gelenk.optimize(
    ...     four_bar,
    ...     {"crank.m": (1.0, 0.5, 2.0)},
    ...     fast,
    ...     outputs=["A.phi"],
    ...     inputs={"drive.tau": 5.0},
    ...     stop=0.2,
    ...     step=0.02,
    ... )
    >>> best.values["crank.m"], best.at_bounds
    (0.5, ('crank.m',))
    """
    from scipy.optimize import Bounds, minimize

    loaded = load(scene)
    names = tuple(variables)
    if not names:
        raise UsageError("variables: found none, expected at least one parameter")
    for name, given in variables.items():
        if len(given) != 3 or not given[1] < given[2] or not given[1] <= given[0] <= given[2]:
            raise UsageError(f"{name}: found {given}, expected (guess, low, high) with low <= guess <= high")
    guess, low, high = np.array([variables[name] for name in names], np.float64).T
    sizes = high - low
    tried: dict[bytes, tuple[float, Array, DifferentiatedRun]] = {}
    counts = {"runs": 0, "failed": 0}
    worst = -np.inf

    def evaluated(x: Array) -> tuple[float, Array]:
        nonlocal worst
        values = dict(zip(names, np.clip(x * sizes, low, high).tolist(), strict=True))
        try:
            run = sensitivity(
                loaded, names, outputs=outputs, parameters={**(parameters or {}), **values}, inputs=inputs,
                stop=stop, step=step, accuracy=accuracy,
            )  # fmt: skip
        except (SceneError, AssemblyError, StepError, UsageError):
            counts["failed"] += 1
            if not tried:
                raise
            return worst + 10 * (1 + abs(worst)), np.zeros(len(names))
        counts["runs"] += 1
        value, weights = objective(run)
        by_parameter, _ = vjp(run, weights)
        gradient = np.array([by_parameter[name] for name in names])
        tried[x.tobytes()] = (float(value), gradient, run)
        worst = max(worst, float(value))
        return float(value), gradient * sizes

    found = minimize(
        evaluated, guess / sizes, jac=True, method="L-BFGS-B", bounds=Bounds(low / sizes, high / sizes),
        options={"ftol": 1e-14, "gtol": 1e-9},
    )  # fmt: skip
    key = min(tried, key=lambda k: tried[k][0])
    value, gradient, run = tried[key]
    x = np.clip(np.frombuffer(key) * sizes, low, high)
    margin = 1e-9 * sizes
    return Optimum(
        dict(zip(names, x.tolist(), strict=True)), value, dict(zip(names, gradient.tolist(), strict=True)),
        tuple(np.array(names)[(x - low <= margin) | (high - x <= margin)].tolist()),
        run, counts["runs"], counts["failed"], bool(found.success), str(found.message),
    )  # fmt: skip
