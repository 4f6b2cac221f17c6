# SPDX-License-Identifier: BSD-3-Clause
"""Many runs of a scene or an FMU with different parameters."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.model.scene import Scene
from gelenk.simulation.inputs import Inputs
from gelenk.sweeps.dataset import MAX_MEMORY, dataset, gathered, lazy_trajectories
from gelenk.sweeps.design import designed
from gelenk.sweeps.driver import Driver, Progress, Range, Workers, progress_of
from gelenk.sweeps.outputs import Outputs
from gelenk.sweeps.plan import Chunk, Plan
from gelenk.sweeps.planning import Request, identity
from gelenk.sweeps.store import Store
from gelenk.sweeps.workers import (
    PROCESS_SECONDS,
    THREAD_SECONDS,
    Values,
    dask_cluster,
    processes,
    processors,
    restarted,
    threads,
)

if TYPE_CHECKING:
    import xarray as xr


def sweep(
    plant: Scene | str | PathLike[str] | Mapping[str, Any],
    parameters: Mapping[str, Any],
    *,
    outputs: Outputs | None = None,
    inputs: Inputs | None = None,
    design: str = "grid",
    samples: int | None = None,
    seed: int = 0,
    stop: float | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    integrator: str | None = None,
    formulation: str | None = None,
    without: Sequence[str] = (),
    cluster: Any = None,
    workers: int | None = None,
    isolate: bool = False,
    store: str | PathLike[str] | None = None,
    max_time: float | None = None,
    max_run_time: float | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Simulate a scene or an FMU many times with different parameters.

    A run is what `gelenk.simulate` computes, to the bit, independent of the number and the order of workers.
    A run that fails does not end the sweep: what it lacks is NaN, and `error` says why.

    Args:
        plant: a .fmu file, or anything `gelenk.load` accepts.
        parameters: values by name: parameters, inputs that are constant in a run, and numbers of a scene by
            their path ("coupler.com[1]"). A single value applies to all runs, a list makes them differ. With
            the designs "latin", "sobol", "random" and "saltelli", a distribution: "uniform(low, high)",
            "normal(mean, deviation)", "loguniform", "lognormal", "truncnormal", "triangular", or one of
            scipy.stats.
        outputs: what is kept of each run. A list: trajectories of these outputs (names and patterns). A
            mapping: for each of them "trajectory", "last", "max", "min", "mean", "rms", "first>NUMBER",
            "first<NUMBER" (the time at which it is first beyond it), a function of (time, values), or a list
            of these; for the name "events" the reductions "count" and "first:PATTERN" of a scene's events;
            for a new name a pair of a function of (time, values, ...) and a list of outputs. None: the
            trajectories of all outputs.
        inputs: as in `gelenk.simulate`, the same for all runs.
        design: "grid" (all combinations), "list" (the first values, the second values, ...), "latin"
            (Latin hypercube), "sobol", "random", "saltelli" (for `gelenk.sobol`).
        samples: number of runs of "latin", "sobol" (a power of 2) and "random"; of base points of
            "saltelli" (a power of 2), which has as many runs for each of two more than there are
            parameters.
        seed: of their random numbers.
        stop: end of each run [s]; by default that of the scene or FMU.
        step: communication step [s].
        tolerance: relative tolerance of the integrator.
        integrator: see `gelenk.simulate`.
        formulation: see `gelenk.simulate`.
        without: reductions to switch off; scenes only.
        cluster: None: threads of this process; "local": processes of this machine; the address of a Dask
            scheduler, or a `distributed.Client`.
        workers: number of threads or processes; by default one for each processor.
        isolate: whether runs are made in processes of their own, so that a run that crashes ends only
            itself.
        store: folder in which outcomes are kept while they are computed; the same call continues there after
            an interruption.
        max_time: time after which the sweep ends [s]; `error` says which runs were not made.
        max_run_time: time that a run may take [s]; longer ones fail.
        progress: called with the number of completed runs and of all runs. True: a progress bar, in
            notebooks a widget.

    Returns:
        xarray.Dataset: variables "OUTPUT" (trajectories) and "OUTPUT.REDUCTION" with their units, `error` and
        `warning` (text, empty if there is none). A grid has a dimension for each parameter, other designs
        have the dimension `run`, trajectories also `time`. The attributes give the version, the scene, the
        design. With a store, trajectories of more than 1 GB are read when they are needed.

    Raises:
        SceneError, UsageError: the scene, a name or a value is invalid, or a package is not installed.
        OSError: a file cannot be read, or the store cannot be written.

    >>> found = gelenk.sweep(four_bar, {"crank.m": [0.9, 1.0, 1.1]}, outputs={"A.w": "max"}, stop=0.2)
    >>> found["A.w.max"].dims
    ('crank.m',)
    """
    extra("xarray", "results of sweeps are Datasets of xarray")
    runs = designed(parameters, design, samples, seed)
    request = Request(
        inputs, stop, step, tolerance,
        {"integrator": integrator, "formulation": formulation}, tuple(without), outputs, max_run_time or 0.0,
    )  # fmt: skip
    for name, limit in (("max_time", max_time), ("max_run_time", max_run_time)):
        if limit is not None and not limit > 0:
            raise UsageError(f"{name}: found {limit}, expected more than 0 s")
    if workers is not None and workers < 1:
        raise UsageError(f"workers: found {workers}, expected at least 1")
    plan, values, units, attributes = request.planned(plant, runs)
    kept = None if store is None else Store(Path(store), identity(plan, values, attributes), runs.runs)
    deadline = None if max_time is None else time.monotonic() + max_time
    todo = [(0, runs.runs)] if kept is None else kept.missing
    chunks = []
    with progress_of(progress) as reached:
        for chunk in _computed(
            plan, values, todo, Place(cluster, workers, isolate, kept is not None), deadline
        ):
            if kept is None:
                chunks.append(chunk)
            else:
                kept.add(chunk)
            todo = _without(todo, (chunk.first, chunk.last))
            if reached is not None:
                reached(runs.runs - sum(b - a for a, b in todo), runs.runs)
    late = f"the run was not made within the time of the sweep, {max_time:g} s" if max_time else ""
    size = 8 * runs.runs * len(plan.times) * sum(v.is_trajectory for v in plan.variables)
    lazily = kept is not None and size > MAX_MEMORY
    names = [v.name for v in plan.variables if not (lazily and v.is_trajectory)]
    whole = gathered(
        plan, runs.runs, chunks if kept is None else kept.chunks(names), late, lazily=lazily
    )  # fmt: skip
    lazy = lazy_trajectories(plan, runs.runs, kept.parts()) if lazily and kept is not None else {}
    return dataset(plan, runs, whole.values | lazy, whole.errors, whole.warnings, units, attributes)


@dataclass(frozen=True)
class Place:
    """Where runs are made: see `sweep`."""

    cluster: Any
    workers: int | None
    isolate: bool
    stored: bool

    def opened(self, plan: Plan, values: Values) -> AbstractContextManager[Workers]:
        """Return the context of the workers."""
        if self.cluster is not None:
            return dask_cluster(plan, values, self.cluster, self.workers)
        count = self.workers or processors()
        if self.isolate:
            return processes(plan, values, count)
        return threads(plan, values, count, PROCESS_SECONDS if self.stored else THREAD_SECONDS)


def _computed(
    plan: Plan, values: Values, todo: list[Range], place: Place, deadline: float | None
) -> Iterator[Chunk]:
    """Yield the chunks of all runs that are to be made; nothing is started if there are none.

    A scheduler that is lost is waited for, and what it had not returned is made again.
    """

    def failed(run: int, why: str) -> Chunk:
        return plan.empty(run, 1, why)

    while todo:
        try:
            with place.opened(plan, values) as workers:
                for chunk in Driver(workers, todo, plan.bytes_per_run, deadline, failed).chunks():
                    todo = _without(todo, (chunk.first, chunk.last))
                    yield chunk
        except ConnectionError:
            address = restarted(place.cluster)
            if address is None:
                raise
            place = replace(place, cluster=address)
        else:
            return


def _without(ranges: list[Range], taken: Range) -> list[Range]:
    """Return ranges without one that is part of one of them."""
    out = []
    for first, last in ranges:
        if first <= taken[0] and taken[1] <= last:
            out += [(a, b) for a, b in ((first, taken[0]), (taken[1], last)) if a < b]
        else:
            out.append((first, last))
    return out
