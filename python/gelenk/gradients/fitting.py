# SPDX-License-Identifier: BSD-3-Clause
"""Parameters from measured curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import AssemblyError, SceneError, StepError, UsageError
from gelenk.gradients.differentiation import sensitivity
from gelenk.gradients.run import DifferentiatedRun
from gelenk.model.scene import Source, load
from gelenk.model.settable import with_listed
from gelenk.model.values import Value, check_names
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]

# Relative change of the sum of squares at which the search ends: parameters are then within 1e-3 of their
# deviations.
FTOL = 1e-8
# Singular values of the Jacobian, scaled by the parameters, below this part of the largest one: derivatives
# are known to 1e-9, so a combination of parameters that acts so little may as well not act.
RANK_TOLERANCE = 1e-7
# Of a unit vector in the null space: a parameter with a smaller part in it does not belong to the
# combination.
SMALLEST_PART = 1e-3


@dataclass(frozen=True)
class Fit:
    """Parameters that were found from measurements.

    Attributes:
        values: by parameter.
        deviations: standard deviations by parameter; infinite if the measurements do not determine it.
        covariance: of the parameters, shape (parameters, parameters).
        intervals: confidence intervals by parameter: lower and upper bound.
        confidence: probability with which an interval contains the true value, if the model is right and the
            noise is normal, independent, and small enough for a linear model.
        unidentifiable: names of the parameters that the measurements do not determine, alone or together.
        at_bounds: names of the parameters that are at a bound; their intervals are those without the bound.
        noise: standard deviation of the residuals relative to `deviation` of `fit`.
        residuals: of each output, simulated minus measured, shape (points,).
        run: the simulation with the values found.
        runs: number of simulations with derivatives.
        message: how the search ended.
    """

    values: dict[str, float]
    deviations: dict[str, float]
    covariance: Array
    intervals: dict[str, tuple[float, float]]
    confidence: float
    unidentifiable: tuple[str, ...]
    at_bounds: tuple[str, ...]
    noise: float
    residuals: dict[str, Array]
    run: DifferentiatedRun
    runs: int
    message: str

    def __str__(self) -> str:
        """Return a table of the parameters."""
        rows = []
        for name, value in self.values.items():
            low, high = self.intervals[name]
            found = "not determined" if name in self.unidentifiable else f"{low:.6g} ... {high:.6g}"
            rows.append(f"{name}  {value:.6g}  ({100 * self.confidence:g} %: {found})")
        return "\n".join(rows)


def fit(
    scene: Source,
    measured: Mapping[str, ArrayLike],
    unknowns: Mapping[str, float | tuple[float, float, float]],
    *,
    step: float | None = None,
    deviation: Mapping[str, float] | float | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Inputs | None = None,
    confidence: float = 0.95,
    accuracy: float = 1e-7,
) -> Fit:
    """Find parameters with which a simulation follows measured curves: weighted nonlinear least squares.

    Uses `scipy.optimize.least_squares` with the derivatives of `gelenk.sensitivity`. Confidence intervals
    follow from the linear model at the solution and from the distribution of Student (Bates & Watts,
    Nonlinear Regression Analysis and Its Applications, 1988, ch. 2).

    Args:
        scene: anything `gelenk.load` accepts.
        measured: values by output, at the times 0, step, 2 step, ...; NaN where there is none.
        unknowns: parameters, start values, and inputs that are constant: an initial guess each, or the guess
            and the lower and upper bound.
        step: time between measured values [s]; by default the communication step of the scene.
        deviation: standard deviation of the noise of each output, in its unit, or of all. None: of all equal,
            and unknown.
        parameters: known values that differ from those of the scene, by name.
        inputs: as in `gelenk.simulate`.
        confidence: probability of the confidence intervals.
        accuracy: as in `gelenk.sensitivity`.

    Returns:
        Fit: values, confidence intervals, and the parameters that the measurements do not determine.

    Raises:
        SceneError, AssemblyError, StepError, UsageError: an argument is invalid, or the simulation with the
            initial guess fails or is not differentiable.

    >>> true = gelenk.simulate(four_bar, stop=0.2, step=0.01, inputs={"drive.tau": 3.0})
    >>> found = gelenk.fit(
    ...     four_bar, {"A.phi": true["A.phi"]}, {"crank.m": 1.2}, step=0.01, inputs={"drive.tau": 3.0}
    ... )
    >>> round(found.values["crank.m"], 4)
    1.0
    """
    from scipy import optimize, stats

    problem = _Problem(scene, measured, unknowns, step, deviation, parameters, inputs, accuracy)
    if not 0 < confidence < 1:
        raise UsageError(f"confidence: found {confidence}, expected a number between 0 and 1")
    problem.at(problem.guess)  # what is wrong with the guess is an error, later values are only avoided
    found = optimize.least_squares(
        problem.residuals, problem.guess, problem.jacobian, bounds=(problem.low, problem.high),
        x_scale=problem.sizes, xtol=1e-10, ftol=FTOL, gtol=1e-12,
    )  # fmt: skip
    run = problem.at(found.x)
    J = problem.jacobian(found.x) * problem.sizes
    left = problem.residuals(found.x)
    surplus = len(left) - len(found.x)
    undetermined, covariance = _identified(J)
    covariance *= np.outer(problem.sizes, problem.sizes)
    noise = float(np.sqrt(left @ left / surplus)) if surplus > 0 else float("nan")
    known_noise = deviation is not None
    if not known_noise:
        covariance = covariance * noise**2
    quantile = (
        stats.norm.ppf((1 + confidence) / 2)
        if known_noise
        else stats.t.ppf((1 + confidence) / 2, max(surplus, 1))
    )
    names = problem.names
    lost = tuple(name for name, missing in zip(names, undetermined, strict=True) if missing)
    deviations = np.where(undetermined, np.inf, np.sqrt(np.diag(covariance)))
    low, high = found.x - quantile * deviations, found.x + quantile * deviations
    return Fit(
        dict(zip(names, found.x.tolist(), strict=True)),
        dict(zip(names, deviations.tolist(), strict=True)),
        covariance,
        dict(zip(names, zip(low.tolist(), high.tolist(), strict=True), strict=True)),
        confidence, lost,
        tuple(n for n, side in zip(names, found.active_mask, strict=True) if side),
        noise, problem.apart(run), run, problem.runs, str(found.message),
    )  # fmt: skip


def _identified(J: Array) -> tuple[NDArray[np.bool_], Array]:
    """Return which parameters are not determined, and the covariance of the others for unit noise.

    Args:
        J: derivatives of the residuals by the parameters, each relative to its size.
    """
    _, sigma, right = np.linalg.svd(J, full_matrices=True)
    full = np.zeros(J.shape[1])
    full[: len(sigma)] = sigma
    acts = full > RANK_TOLERANCE * full.max(initial=0.0)
    undetermined = np.abs(right[~acts]).max(axis=0, initial=0.0) > SMALLEST_PART
    scaled = right[acts] / full[acts][:, None]
    return undetermined, scaled.T @ scaled


class _Problem:
    """Residuals and their Jacobian as functions of the unknowns."""

    def __init__(
        self, scene: Source, measured: Mapping[str, ArrayLike], unknowns: Mapping[str, float | tuple[float,
        float, float]],
        step: float | None, deviation: Mapping[str, float] | float | None,
        parameters: Mapping[str, Value] | None, inputs: Inputs | None, accuracy: float,
    ) -> None:  # fmt: skip
        if not measured or not unknowns:
            raise UsageError("measured, unknowns: expected at least one output and one parameter")
        self.names = tuple(unknowns)
        table = np.array([_bounded(name, given) for name, given in unknowns.items()])
        self.guess, self.low, self.high = table.T
        self.sizes = np.where(self.guess != 0, np.abs(self.guess), 1.0)
        self._measured = {name: np.asarray(curve, np.float64) for name, curve in measured.items()}
        points = len(next(iter(self._measured.values())))
        for name, curve in self._measured.items():
            if curve.shape != (points,) or points < 2:
                raise UsageError(
                    f"{name}: found an array of shape {curve.shape}, expected ({max(points, 2)},), as many "
                    "values for each output"
                )
        loaded = load(scene)
        self._step = loaded.step if step is None else step
        self._stop = (points - 1) * self._step
        self._deviation = _deviations(deviation, self._measured)
        self._scene, self._parameters, self._inputs = loaded, dict(parameters or {}), inputs
        listed, self._renamed = with_listed(loaded, self.names)
        known = [*listed.parameters, *(s.name for s in Simulation(loaded.with_outputs(None)).inputs)]
        check_names([self._renamed.get(name, name) for name in self.names], known, "parameter or input")
        self._accuracy = accuracy
        self._last: tuple[bytes, DifferentiatedRun] | None = None
        self.runs = 0

    def at(self, x: Array) -> DifferentiatedRun:
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = (key, self._simulated(dict(zip(self.names, x.tolist(), strict=True))))
            self.runs += 1
        return self._last[1]

    def _simulated(self, values: dict[str, float]) -> DifferentiatedRun:
        settable = {n: v for n, v in values.items() if n in self._renamed or n in self._scene.parameters}
        constants = {n: v for n, v in values.items() if n not in settable}
        inputs: Inputs | None = self._inputs
        if constants:
            if not isinstance(inputs, Mapping | None):
                raise UsageError("inputs: expected a mapping of names, since some of them are unknown")
            twice = [name for name in constants if name in (inputs or {})]
            if twice:
                raise UsageError(f"{twice[0]}: given twice, in unknowns and in inputs")
            inputs = {**(inputs or {}), **constants}
        return sensitivity(
            self._scene, self.names, outputs=list(self._measured),
            parameters={**self._parameters, **settable},
            inputs=inputs, stop=self._stop, step=self._step, accuracy=self._accuracy,
        )  # fmt: skip

    def apart(self, run: DifferentiatedRun) -> dict[str, Array]:
        return {name: run[name] - curve for name, curve in self._measured.items()}

    def residuals(self, x: Array) -> Array:
        try:
            run = self.at(x)
        except (SceneError, AssemblyError, StepError, UsageError):
            return np.full(self._count(), 1e6)  # the search shortens its step
        parts = [d / self._deviation[name] for name, d in self.apart(run).items()]
        flat = np.concatenate(parts)
        return flat[~np.isnan(flat)]

    def jacobian(self, x: Array) -> Array:
        run = self.at(x)
        columns = [[*run.parameters, *run.inputs].index(name) for name in self.names]
        whole = run.jacobian[:, :, columns]
        rows = []
        for name, curve in self._measured.items():
            part = whole[:, run.outputs.index(name)] / self._deviation[name]
            rows.append(part[~np.isnan(curve)])
        return np.concatenate(rows)

    def _count(self) -> int:
        return int(sum(np.count_nonzero(~np.isnan(curve)) for curve in self._measured.values()))


def _bounded(name: str, given: float | Sequence[float]) -> tuple[float, float, float]:
    numbers = np.atleast_1d(np.asarray(given, np.float64))
    if numbers.shape == (1,):
        return float(numbers[0]), -np.inf, np.inf
    if numbers.shape != (3,) or not numbers[1] < numbers[2] or not numbers[1] <= numbers[0] <= numbers[2]:
        raise UsageError(
            f"{name}: found {given}, expected a guess, or (guess, low, high) with low <= guess <= high"
        )
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _deviations(given: Mapping[str, float] | float | None, measured: Mapping[str, Array]) -> dict[str, float]:
    found = {}
    for name in measured:
        value = given.get(name) if isinstance(given, Mapping) else 1.0 if given is None else given
        if value is None or not value > 0:
            raise UsageError(f"deviation: found {value} for {name}, expected more than 0")
        found[name] = float(value)
    return found
