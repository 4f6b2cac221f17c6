# SPDX-License-Identifier: BSD-3-Clause
"""The equations that are handed out are those that simulations solve, in all shipped scenes."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import gelenk
from gelenk.errors import SceneError

from .states import by_kernels, closed_states, closeness, random_states

ROOT = Path(__file__).resolve().parents[2]
SCENES = {path.stem: path for path in sorted(ROOT.glob("scenes/*.yaml"))}
SCENES |= {path.parent.name: path for path in sorted(ROOT.glob("docs/gallery/*/scene.yaml"))}

# Scenes that cannot be written as expressions, and what their messages name.
REFUSED: dict[str, tuple[str, ...]] = {
    "bucket": ("scraping: found contacts between shapes",),
    "cam": ("contact: found contacts between shapes",),
    "car": ("tire_fl: found a law with branches", "tire_rr: found a law with branches"),
    "gear_shift": ("clutch1.phi: found friction of a joint that closes a loop",),
    "gripper": ("found contacts between shapes",),
    "ratchet": ("catch: found contacts between shapes",),
    "worm_hoist": ("motor.phi: found friction that depends on the forces",),
}
WRITTEN = [name for name in SCENES if name not in REFUSED]


@pytest.mark.parametrize("name", WRITTEN)
def test_matrices_and_energies_are_those_of_the_kernels(name: str) -> None:
    """At 100 states anywhere, relative to the largest of them; round-off of some thousand operations."""
    equations = gelenk.equations(SCENES[name])
    functions = equations.to_numpy()
    states = random_states(equations, 100)
    expected = [by_kernels(equations, state) for state in states]
    for quantity in equations._system.quantities.values():
        if quantity.name == "rates" and not quantity.terms:
            continue
        compute = getattr(functions, quantity.name)
        found = [compute(*(state["qvu".index(of)] for of in quantity.arguments)) for state in states]
        error = closeness(found, [getattr(values, quantity.name) for values in expected])
        assert error < 1e-12, f"{quantity.name}: {error:.1e}"


@pytest.mark.parametrize("name", WRITTEN)
def test_accelerations_are_those_of_the_kernels(name: str) -> None:
    """At states on the constraints, also by CasADi; 1e-10 where they are near a singular position, 1e-12 in
    the middle: another elimination than the core's, of matrices with condition numbers of some 1e4.
    """
    equations = gelenk.equations(SCENES[name])
    functions = equations.to_numpy()
    of_languages = [functions]
    if find_spec("casadi"):
        of_languages.append(equations.to_casadi())
    states = closed_states(equations, functions, 30)
    assert len(states) >= 10
    for of in of_languages:
        errors = [
            closeness(of.accelerations(*state)[0], by_kernels(equations, state).vdot) for state in states
        ]
        assert max(errors) < 1e-10
        assert np.median(errors) < 1e-12


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_written_is_refused_by_name(name: str) -> None:
    with pytest.raises(SceneError) as refusal:
        gelenk.equations(SCENES[name])
    for word in REFUSED[name]:
        assert word in str(refusal.value)
