# SPDX-License-Identifier: BSD-3-Clause
"""FMUs exported at one position and started at another, compared with unreduced scenes that start there."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from mechanisms import Scene

import gelenk
from gelenk.linear import LinearModel, linear_model

from .compare import ROUNDING, Comparison, Verdict
from .drawn import Case
from .listed import choices, started
from .plants import STEPS, STOP, TOLERANCE, Start, attempt, without

# As in `Comparison` for linear models: round-off through some divisions by pivots, twice.
LINEAR = 1e3 * ROUNDING


def finished(name: str, source: Scene) -> Iterator[tuple[str, list[Verdict]]]:
    """Name and verdicts of each start; the FMU's start parameters are set to it."""
    options = choices(source)
    if not options:
        return
    with tempfile.TemporaryDirectory() as folder:
        for at_first in options:
            first = started(source, at_first)
            fmu = attempt(partial(gelenk.export_fmu, first, Path(folder) / "Plant.fmu"))
            if isinstance(fmu, str):
                continue  # the loops cannot be closed there
            for angles in (a for a in options if a is not at_first):
                words = ", ".join(f"{joint} at {x:.3g}" for joint, x in angles.items())
                yield f"{name}, FMU: {words}", list(_compared(fmu, started(first, angles), angles))
            return


def _compared(fmu: Path, source: Scene, angles: Mapping[str, float]) -> Iterator[Verdict]:
    rules = Comparison(Case("", source))
    literal = Start(without(rules.pinned, all=False))
    settings = {f"{joint}.phi_start": x for joint, x in angles.items()}
    found = attempt(lambda: linear_model(fmu, parameters=settings))
    if isinstance(found, str) and not isinstance(rules.base.plant, str):
        yield rules.refused("FMU: linear", found)
    expected = None if isinstance(found, str) else literal.linear(found.states)
    if not isinstance(found, str) and not isinstance(expected, LinearModel):
        yield rules.refused("FMU: linear", str(expected))
    if not isinstance(found, str) and isinstance(expected, LinearModel):
        yield _compare_linear_models(rules, found, expected)
    run = attempt(lambda: _run(fmu, settings))
    there = literal.run
    if isinstance(run, str) or isinstance(there, str):
        if isinstance(run, str) != isinstance(there, str):
            yield rules.refused("FMU: run", run if isinstance(run, str) else f"scene: {there}")
        return
    faults = rules.deviations(there, run)
    kind = "sensitive" if faults and rules.sensitive else None
    yield Verdict("FMU: run", kind, faults[0][1]) if kind else rules.judged("FMU: run", faults)


def _run(fmu: Path, settings: Mapping[str, float]) -> dict[str, float]:
    with warnings.catch_warnings(action="ignore", category=gelenk.StartWarning):
        run = gelenk.simulate(
            fmu, stop=STOP, step=STOP / STEPS, tolerance=TOLERANCE, parameters=dict(settings)
        )
    return {name: float(run[name][-1]) for name in run.names}


def _compare_linear_models(rules: Comparison, found: LinearModel, expected: LinearModel) -> Verdict:
    if set(found.outputs) != set(expected.outputs):
        return rules.verdict("FMU: linear", "other outputs are determined by the states")
    faults = []
    for part in "ABCD":
        mine, there = getattr(found, part), getattr(expected, part)
        bound = LINEAR * rules.share * (1 + float(np.abs(there).max(initial=0)))
        if mine.shape != there.shape or not (np.abs(mine - there) <= bound).all():
            faults.append((1.0, f"{part}: {mine.tolist()} / {there.tolist()}"[:200]))
    return rules.judged("FMU: linear", faults)
