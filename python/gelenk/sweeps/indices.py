# SPDX-License-Identifier: BSD-3-Clause
"""Sobol indices: which parameters the variance of a result is due to."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.sweeps.dataset import RUN

if TYPE_CHECKING:
    import xarray as xr

INDICES = ("first", "first_conf", "total", "total_conf")
_OF_SALIB = ("S1", "S1_conf", "ST", "ST_conf")
# SALib takes a seed of 0 for none.
_SEED = 1


def sobol(study: xr.Dataset, *, confidence: float = 0.95, resamples: int = 100) -> xr.Dataset:
    """Return the Sobol indices of the results of a sweep with the design "saltelli".

    The index of first order of a parameter is the part of the variance that it causes alone, the total index
    the part that would vanish if it had a fixed value. Computed by SALib (Saltelli et al., Computer Physics
    Communications 181 (2010) 259).

    Args:
        study: what `gelenk.sweep` returns with the design "saltelli".
        confidence: level of the confidence intervals.
        resamples: number of bootstrap samples of which these are found.

    Returns:
        xarray.Dataset: the variables of the study, with the dimensions `index` ("first", "total", and half
        the widths of their confidence intervals, "first_conf" and "total_conf"), `parameter` and, of
        trajectories, `time`. NaN for results that do not vary.

    Raises:
        UsageError: the study has another design, a run has failed, or SALib is not installed.

    >>> study = gelenk.sweep(
    ...     four_bar,
    ...     {"crank.m": "uniform(0.9, 1.1)", "A.damping": "uniform(0, 0.2)"},
    ...     design="saltelli",
    ...     samples=16,
    ...     outputs={"A.w": "max"},
    ...     stop=0.1,
    ... )
    >>> gelenk.sobol(study)["A.w.max"].sizes
    Frozen({'index': 4, 'parameter': 2})
    """
    xarray = extra("xarray", "results of sweeps are Datasets of xarray")
    extra("SALib", "Sobol indices are computed by SALib")
    if study.attrs.get("design") != "saltelli":
        raise UsageError(
            f"design: found {study.attrs.get('design')!r}, expected a sweep with the design 'saltelli'"
        )
    if not 0 < confidence < 1:
        raise UsageError(f"confidence: found {confidence}, expected a number between 0 and 1")
    errors = [text for text in study["error"].values.tolist() if text]
    if errors:
        raise UsageError(
            f"{len(errors)} of {study.sizes[RUN]} runs have failed, and Sobol indices need all of them; the "
            f"first failure: {errors[0]}"
        )
    parameters = [str(name) for name, values in study.coords.items() if values.dims == (RUN,) and name != RUN]
    found: dict[str, Any] = {}
    for name, values in study.data_vars.items():
        if name in ("error", "warning"):
            continue
        others = values.dims[1:]
        table = np.asarray(values.values, np.float64).reshape(len(values), -1)
        indices = np.stack([_indices(y, parameters, confidence, resamples) for y in table.T], axis=-1)
        shape = (len(INDICES), len(parameters), *(study.sizes[dim] for dim in others))
        found[str(name)] = (("index", "parameter", *others), indices.reshape(shape))
    coordinates = {"index": list(INDICES), "parameter": parameters}
    coordinates |= {str(name): values for name, values in study.coords.items() if RUN not in values.dims}
    result: xr.Dataset = xarray.Dataset(found, coordinates, {**study.attrs, "confidence": confidence})
    return result


def _indices(
    y: NDArray[np.float64], parameters: Sequence[str], confidence: float, resamples: int
) -> NDArray[np.float64]:
    """Return the indices of one result, shape (indices, parameters)."""
    if not np.ptp(y) > 0:  # also for a NaN, such as an event that has not happened
        return np.full((len(INDICES), len(parameters)), np.nan)
    problem = {"num_vars": len(parameters), "names": list(parameters), "bounds": [[0, 1]] * len(parameters)}
    indices = import_module("SALib.analyze.sobol").analyze(
        problem, y, calc_second_order=False, num_resamples=resamples, conf_level=confidence, seed=_SEED
    )
    return np.array([indices[name] for name in _OF_SALIB])
