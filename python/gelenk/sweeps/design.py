# SPDX-License-Identifier: BSD-3-Clause
"""Designs of experiments: the values that parameters have in each run of a sweep."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.model.values import Value

DESIGNS = ("grid", "list", "latin", "sobol", "random", "saltelli")
MAX_RUNS = 100_000_000
_CALL = re.compile(r"\s*(\w+)\s*\(([^()]*)\)\s*")
# Samples in (0, 1): distributions without bounds have no quantiles at 0 and 1.
_INSIDE = 2.0**-53

# Distributions by name: what their numbers mean, and the arguments of scipy.stats' distribution of this name.
_NAMED: dict[str, tuple[tuple[str, ...], str, Any]] = {
    "uniform": (("low", "high"), "uniform", lambda a, b: {"loc": a, "scale": b - a}),
    "loguniform": (("low", "high"), "loguniform", lambda a, b: {"a": a, "b": b}),
    "normal": (("mean", "deviation"), "norm", lambda m, s: {"loc": m, "scale": s}),
    "lognormal": (("median", "deviation of the logarithm"), "lognorm", lambda m, s: {"s": s, "scale": m}),
    "truncnormal": (
        ("mean", "deviation", "low", "high"),
        "truncnorm",
        lambda m, s, a, b: {"a": (a - m) / s, "b": (b - m) / s, "loc": m, "scale": s},
    ),
    "triangular": (
        ("low", "mode", "high"),
        "triang",
        lambda a, c, b: {"c": (c - a) / (b - a), "loc": a, "scale": b - a},
    ),
}


@dataclass(frozen=True)
class Design:
    """The runs of a sweep.

    Attributes:
        columns: of each parameter that differs between runs its values, shape (runs,).
        constants: values of the other parameters.
        axes: of a grid, the values along each dimension; None for other designs.
        attributes: how the design was made: its kind, the number of samples, the seed.
    """

    columns: dict[str, NDArray[Any]]
    constants: dict[str, Value]
    axes: dict[str, NDArray[Any]] | None
    attributes: dict[str, str | int]

    @property
    def runs(self) -> int:
        """The number of runs."""
        return next((len(column) for column in self.columns.values()), 1)


def designed(parameters: Mapping[str, Any], kind: str, samples: int | None, seed: int) -> Design:
    """Return the runs of a design.

    Args:
        parameters: see `gelenk.sweep`.
        kind: one of `DESIGNS`.
        samples: number of runs of "latin", "sobol" and "random", of base points of "saltelli".
        seed: of their random numbers.

    Raises:
        UsageError: the design cannot be made.
    """
    if kind not in DESIGNS:
        raise UsageError(f"design: found {kind!r}, expected one of {', '.join(DESIGNS)}")
    found = {name: _varied(name, value) for name, value in dict(parameters.items()).items()}
    constants = {name: _plain(parameters[name]) for name, value in found.items() if value is None}
    varied = {name: value for name, value in found.items() if value is not None}
    if kind in ("grid", "list"):
        if samples is not None:
            raise UsageError(f"samples: found {samples} with the design {kind}, expected none")
        wrong = [name for name, value in varied.items() if not isinstance(value, np.ndarray)]
        if wrong:
            raise UsageError(
                f"{wrong[0]}: found a distribution with the design {kind}, expected a list of values; "
                "distributions are sampled by latin, sobol, random and saltelli"
            )
        return _listed(varied, constants, kind)
    return _sampled(varied, constants, kind, samples, seed)


def _varied(name: str, value: Any) -> Any:
    """Return an array of values or a distribution; None for a single value."""
    if isinstance(value, str):
        call = _CALL.fullmatch(value)
        return None if call is None else _distribution(name, call[1], call[2])
    if hasattr(value, "ppf"):
        return value
    array = np.asarray(value)
    if array.ndim == 0:
        return None
    if array.ndim != 1 or not len(array):
        raise UsageError(f"{name}: found an array of shape {array.shape}, expected a list of values")
    return array


def _plain(value: Any) -> Value:
    plain: Value = value.item() if isinstance(value, np.generic | np.ndarray) else value
    return plain


def _distribution(name: str, kind: str, text: str) -> Any:
    if kind not in _NAMED:
        raise UsageError(f"{name}: found the distribution {kind!r}, expected one of {', '.join(_NAMED)}")
    words, scipy_name, arguments = _NAMED[kind]
    expected = f"expected {kind}({', '.join(words)})"
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != len(words) or not all(map(math.isfinite, numbers)):
        raise UsageError(f"{name}: found {kind}({text}), {expected}")
    from scipy import stats

    try:
        with np.errstate(all="ignore"):
            found = getattr(stats, scipy_name)(**arguments(*numbers))
            quantile = float(found.ppf(0.5))
    except (ValueError, ZeroDivisionError):
        quantile = math.nan
    if not math.isfinite(quantile):
        raise UsageError(f"{name}: found {kind}({text}), {expected} in increasing order, deviations positive")
    return found


def _listed(varied: dict[str, Any], constants: dict[str, Value], kind: str) -> Design:
    if kind == "list":
        lengths = {name: len(value) for name, value in varied.items()}
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{n} of {name}" for name, n in lengths.items())
            raise UsageError(f"design list: found {found}; expected as many values of each parameter")
        return Design(varied, constants, None, {"design": kind})
    runs = math.prod(len(axis) for axis in varied.values())
    _check_count(runs)
    for name, axis in varied.items():
        if len(np.unique(axis)) < len(axis):
            raise UsageError(f"{name}: found a value twice, expected each value of a grid once")
    meshes = np.meshgrid(*varied.values(), indexing="ij") if varied else []
    columns = {name: mesh.reshape(-1) for name, mesh in zip(varied, meshes, strict=True)}
    return Design(columns, constants, varied, {"design": kind})


def _check_count(runs: int) -> None:
    if runs > MAX_RUNS:
        raise UsageError(f"the design has {runs} runs, expected at most {MAX_RUNS}")


def _sampled(
    varied: dict[str, Any], constants: dict[str, Value], kind: str, samples: int | None, seed: int
) -> Design:
    listed = [name for name, value in varied.items() if isinstance(value, np.ndarray)]
    if listed:
        raise UsageError(
            f"{listed[0]}: found a list of values with the design {kind}, expected a distribution, such as "
            "'normal(1, 0.01)', or one value"
        )
    if samples is None or samples < 1:
        raise UsageError(f"samples: found {samples}, expected the number of runs of the design {kind}")
    _check_count(samples * (len(varied) + 2) if kind == "saltelli" else samples)
    if not varied:
        raise UsageError(f"parameters: found no distribution, expected one for the design {kind}")
    if kind in ("sobol", "saltelli") and samples & (samples - 1):
        near = 1 << samples.bit_length()
        raise UsageError(
            f"samples: found {samples}, expected a power of 2 for the design {kind}: {near // 2} or {near}"
        )
    points = np.clip(_unit_cube(kind, len(varied), samples, seed), _INSIDE, 1 - _INSIDE)
    columns = {
        name: np.asarray(law.ppf(points[:, i]), np.float64) for i, (name, law) in enumerate(varied.items())
    }
    return Design(columns, constants, None, {"design": kind, "samples": samples, "seed": seed})


def _unit_cube(kind: str, dimensions: int, samples: int, seed: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    if kind == "random":
        return np.random.default_rng(seed).random((samples, dimensions))
    if kind == "saltelli":
        extra("SALib", "Sobol indices are computed by SALib")
        problem = {"num_vars": dimensions, "names": [*map(str, range(dimensions))]}
        problem["bounds"] = [[0, 1]] * dimensions
        sample = import_module("SALib.sample.sobol").sample
        unit: NDArray[np.float64] = sample(problem, samples, calc_second_order=False, seed=seed)
        return unit
    make = qmc.LatinHypercube if kind == "latin" else qmc.Sobol
    points: NDArray[np.float64] = make(dimensions, rng=np.random.default_rng(seed)).random(samples)
    return points
