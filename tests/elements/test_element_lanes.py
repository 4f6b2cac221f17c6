# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of elements of all kinds, each another one in a lane of a batch, are those of simulations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene

import gelenk
from gelenk.errors import SceneError

from .scenes import Given
from .test_element_numbers import every_place, parameters_of

pytestmark = pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")

STEP, STEPS = 1e-3, 20  # s

# What lanes cannot do, and a part of what is said of it.
REFUSED = {
    "bushing": "found a law with branches",
    "tire": "found a law with branches",
    "limit": "its limit is left out",
    "stop": "its stop is left out",
    "one_way": "its one_way is left out",
    "lock": "lock",
    "friction": "friction acts as in sliding",
    "motion": "found a prescribed motion",
}


def alone(scene: gelenk.Scene, inputs: dict[str, float]) -> dict[str, float]:
    result = gelenk.simulate(
        scene.with_parameters({"solver.step": STEP}),
        stop=STEPS * STEP,
        step=STEP,
        integrator="rk4",
        formulation="projection",
        inputs=inputs,
    )
    return {name: float(np.asarray(result[name])[-1]) for name in result}


@warned.GUESSES
@every_place
def test_each_number_may_differ_from_lane_to_lane(
    variants: list[Scene], at: tuple[str, ...], given: Given
) -> None:
    """By 3 %, in a lane of its own; and in the last lane none differs. Errors are those of rounding."""
    for source in variants:
        scene, parameters = parameters_of(source, at, given)
        values = {p.name: p.value(scene._core) for p in parameters}
        lanes = len(values) + 1
        table: dict[str, Any] = {name: np.full(lanes, value) for name, value in values.items()}
        for lane, name in enumerate(values):
            table[name][lane] *= 1.03
        try:
            batch = gelenk.batch(scene, lanes, table, step=STEP)
        except SceneError as refusal:
            assert REFUSED[given.kind["name"]] in str(refusal)  # noqa: PT017
            continue
        inputs = {name: 0.3 + 0.2 * i for i, name in enumerate(batch.inputs)}
        for name, value in inputs.items():
            batch.inputs[name] = value
        batch.step(STEPS)
        assert not batch.errors
        for lane, changed in enumerate([*values, None]):
            other = scene.with_parameters({changed: 1.03 * values[changed]} if changed else {})
            expected = alone(other, inputs)
            found = np.array([row[lane] for row in batch.states.values()])
            truth = np.array([expected[name] for name in batch.states])
            assert np.abs(found - truth).max() < 1e-12 * max(1.0, np.abs(truth).max()), changed
