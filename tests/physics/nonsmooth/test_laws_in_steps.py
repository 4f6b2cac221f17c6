# SPDX-License-Identifier: BSD-3-Clause
"""Every law of a joint coordinate in both schemes: located events, and time steps of shrinking size.

They are independent schemes for one law, so that steps converge to events, in the motion, in forces and in
what outputs show of the law, at first order at least.
"""

from __future__ import annotations

import numpy as np
import pytest
from models import registered_laws
from models.both_schemes import assert_steps_converge, located
from models.joint_law_cases import CASES, braked, chain

import gelenk


@pytest.mark.parametrize("name", CASES)
def test_steps_converge_to_located_events(name: str) -> None:
    assert_steps_converge(CASES[name]())


def compared_settings() -> set[registered_laws.Setting]:
    return {
        setting
        for case in CASES.values()
        for J in case().source["joints"].values()
        for setting in registered_laws.settings(J, "joints")
    }


def test_every_field_of_the_laws_of_joints_is_compared() -> None:
    """All numbers and words of the registry; a force by an expression is smooth, as that of a spring."""
    assert registered_laws.wanted("joints") - compared_settings() == {(("law", "effort"), True)}


def test_every_input_of_the_laws_of_joints_varies() -> None:
    """Those that words of the registry ask for, which are all in some case, as well as those of motors."""
    for case in CASES.values():
        inputs = case().inputs
        assert {signal.name for signal in gelenk.Simulation(case().source).inputs} == set(inputs)
    engaged = braked().inputs["J.friction.engagement"]
    assert {engaged(t) for t in (0.0, 0.3, 0.6, 0.9)} == {0.0, 0.1, 0.5, 1.0}


# The values of mode by law: which way a coordinate slips, what it touches or keeps from moving, whether it is
# locked.
MODES = {"friction": {-1, 0, 1}, "limit": {-1, 0, 1}, "one_way": {-1, 0, 1}, "lock": {0, 1}}


def test_every_output_of_the_laws_of_joints_is_compared() -> None:
    """All modes occur, and every law exerts forces and torques."""
    modes: dict[str, set[float]] = {}
    efforts: dict[str, set[str]] = {}
    for case in CASES.values():
        for name, values in located(case()).values.items():
            parts = name.split(".")
            if len(parts) != 3 or parts[0] not in case().source["joints"]:
                continue
            _, law, output = parts
            if output == "mode":
                modes.setdefault(law, set()).update(values.tolist())
            elif np.abs(values).max() > 0.1:  # N, N m
                efforts.setdefault(law, set()).add(output)
    assert modes == MODES
    assert set(efforts) == set(MODES)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("bound", [1e-5, 1e-4, 4e-4])
def test_no_bound_is_passed_where_an_impact_drives_a_joint_to_it(bound: float, restitution: float) -> None:
    """A block stops; a load, at rest on it until then, meets its limit in the same step."""
    case = chain("newton", (0.0, restitution), (1.0, 0.0), (0.0503, bound))
    plant = gelenk.Simulation({**case.source, "solver": {"integrator": "moreau-jean", "step": 1e-3}})
    plant.initialize()
    reached = False
    for k in range(60):
        plant.step_to((k + 1) * 1e-3)
        # m: what counts as contact.
        assert plant.output("J1.s") <= bound + 1e-9
        assert plant.output("J0.s") <= 0.0503 + 1e-9
        reached = reached or plant.output("J1.s") >= bound - 1e-9
    assert reached
    if restitution > 0:
        # The load leaves its limit with half its speed, relative to the block, which remains at its own.
        assert plant.output("J1.v") + plant.output("J0.v") == pytest.approx(-0.5, abs=2e-3)
