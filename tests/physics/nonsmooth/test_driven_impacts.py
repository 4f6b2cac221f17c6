# SPDX-License-Identifier: BSD-3-Clause
"""A discontinuity in a prescribed velocity changes all other velocities as in an impact."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from models.driven import Array
from models.hybrid import Chain
from models.running import assert_close

import gelenk
from physics.constraints.test_given_motions import TOLERANCE, rest

pytestmark = warned.TIGHT


def impact(chain: Chain, q: Array, change: float) -> Array:
    """Return the changes of the velocities when the driven one is changed by an impulse along it."""
    M, _ = chain.terms(q, np.zeros(chain.n))
    along = np.linalg.solve(M, np.eye(chain.n)[chain.driven])
    out: Array = along * change / along[chain.driven]
    return out


# Without index3 and ida: the error of its velocities is the tolerance divided by the step, here 1 ns.
METHODS = [
    ("projection", "erk"),
    ("projection", "rk4"),
    ("projection", "cvode"),
    ("baumgarte", "erk"),
    ("udwadia-kalaba", "erk"),
    ("penalty", "cvode"),
    ("augmented-lagrangian", "erk"),
    ("independent", "erk"),
    ("index3", "generalized-alpha"),
    ("stabilized-index2", "ida"),
]
CASES = [
    (given, *methods)
    for given in ("position", "speed")
    for methods in METHODS
    if (given, methods[0]) != ("speed", "independent")  # refused: test_driven_methods.py
]
JOINTS = [("revolute", "phi"), ("planar", "s_y"), ("universal", "phi_a")]


@pytest.mark.parametrize(("kind", "coordinate"), JOINTS)
@pytest.mark.parametrize(("given", "formulation", "integrator"), CASES)
def test_jump_of_a_prescribed_velocity_is_an_impact(
    kind: str, coordinate: str, given: str, formulation: str, integrator: str
) -> None:
    chain = Chain(kind, coordinate)
    solver = {
        "formulation": formulation,
        "integrator": integrator,
        "step": 0.02 if integrator == "rk4" else 1e-3,
    }
    plant = gelenk.Simulation(gelenk.load(chain.scene({"input": given}, rest(chain), solver=solver)))
    name = plant.inputs[0].name

    def give(position: float, speed: float) -> None:
        plant.set_input(name, position if given == "position" else speed)
        if given == "position":
            plant.set_input_derivative(name, 1, speed)

    give(0.0, 0.7)
    plant.initialize(0.0, TOLERANCE)
    plant.step_to(0.5)
    q, before = plant.values(chain.names), plant.values(chain.speeds)
    # A penalty holds it approximately; Baumgarte stabilization leaves some round-off.
    left = {"penalty": 1e-7, "baumgarte": 1e-11}.get(formulation, 1e-12)
    assert before[chain.driven] == pytest.approx(0.7, abs=left)
    give(float(q[chain.driven]), -0.6)
    plant.step_to(0.5 + 1e-9)
    jumps = plant.values(chain.speeds) - before
    # Over 1 ns accelerations of up to 50 change velocities by 5e-8.
    assert_close("speeds", jumps, impact(chain, q, -1.3), 1e-7, "see above")
    assert_close("coordinates", plant.values(chain.names), q, 1e-8, "over 1 ns")
