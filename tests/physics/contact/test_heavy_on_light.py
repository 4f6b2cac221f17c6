# SPDX-License-Identifier: BSD-3-Clause
"""A heavy body on a light one on the floor: right, or refused by name, whatever the ratio of their masses.

Per force between them, their relative acceleration is 1 / m + 1 / M. Numbers of 16 digits keep 1 / M with a
relative error of M / m x 1e-16: from some ratio on, nothing says how heavy it is.
"""

from typing import Any

import pytest
from samples import thorough_beyond

import gelenk

G = 9.81  # m/s2
EDGE = 0.1  # m, of cubes; the diameter of balls
SHAPES = [("ball", "cube"), ("cube", "cube"), ("cube", "ball")]


def stacked(ratio: float, heavy: str, light: str, integrator: str, drop: float = 0.0) -> dict[str, Any]:
    """A body of sqrt(ratio) kg on one of 1 / sqrt(ratio) kg, and the floor; gaps [m] between them."""
    masses = {"heavy": ratio**0.5, "light": ratio**-0.5}
    shapes: dict[str, dict[str, Any]] = {"ball": {"sphere": EDGE / 2}, "cube": {"box": [EDGE] * 3}}
    kinds = {"heavy": heavy, "light": light}
    moments = {"ball": EDGE**2 / 10, "cube": EDGE**2 / 6}
    heights = {"heavy": 1.5 * EDGE + 2 * drop, "light": EDGE / 2 + drop}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            name: {
                "mass": masses[name],
                "inertia": [masses[name] * moments[kinds[name]]] * 3,
                "shapes": {"s": {**shapes[kinds[name]], "surface": name}},
            }
            for name in masses
        },
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "joints": {
            f"j_{name}": {
                "type": "free",
                "parent": "ground",
                "child": name,
                "start": {"r": [0, 0, heights[name]], "fixed": True},
            }
            for name in masses
        },
        "contacts": {
            "above": {"between": ["heavy", "light"], "friction": 0.5},
            "below": {"between": ["light", "floor"], "friction": 0.5},
        },
        "experiment": {"step": 0.01, "tolerance": 1e-8},
        "solver": {"integrator": integrator},
    }


def after(scene: dict[str, Any], seconds: float) -> gelenk.Simulation:
    simulation = gelenk.Simulation(scene)
    simulation.initialize(0.0, scene["experiment"]["tolerance"])
    for k in range(round(seconds / 0.01)):
        simulation.step_to((k + 1) * 0.01)
    return simulation


@pytest.mark.parametrize("integrator", ["auto", "erk", "moreau-jean"])
@pytest.mark.parametrize(("heavy", "light"), SHAPES)
@pytest.mark.parametrize("ratio", thorough_beyond([1.0, 1e4, 1e6], [1.0, 1e4]))
def test_dropped_it_comes_to_rest(ratio: float, heavy: str, light: str, integrator: str) -> None:
    """The light one lands, the heavy one strikes it, and the forces at rest are the weights."""
    simulation = after(stacked(ratio, heavy, light, integrator, drop=0.05), 0.4)
    # Gaps of what has been closed in steps are rounding; a located one is closed to 1e-10 m.
    assert simulation.output("j_heavy.r[3]") == pytest.approx(1.5 * EDGE, abs=1e-9)
    assert simulation.output("j_light.r[3]") == pytest.approx(EDGE / 2, abs=1e-9)
    weight = ratio**0.5 * G
    rel = 1e-9 if integrator == "moreau-jean" else 1e-15 * ratio + 1e-9
    assert simulation.output("above.f[3]") == pytest.approx(weight, rel=rel)
    assert simulation.output("below.f[3]") == pytest.approx(weight * (1 + 1 / ratio), rel=rel)


@pytest.mark.parametrize("integrator", ["auto", "erk", "moreau-jean"])
@pytest.mark.parametrize(("heavy", "light"), SHAPES)
@pytest.mark.parametrize("drop", thorough_beyond([0.0, 0.05], [0.05]))
@pytest.mark.parametrize("ratio", thorough_beyond([1e12, 1e16], [1e16]))
def test_what_numbers_do_not_resolve_is_refused(
    ratio: float, drop: float, heavy: str, light: str, integrator: str
) -> None:
    """And not, as before, a heavy body that falls through the light one and the floor."""
    with pytest.raises(gelenk.StepError, match=r"contacts\.(above|below)|(heavy|light) touches"):
        after(stacked(ratio, heavy, light, integrator, drop), 0.4)


@pytest.mark.parametrize(("ratio", "is_hard"), [(1e2, False), (1e6, True)])
def test_a_budget_of_evaluations_bounds_what_impulses_of_time_steps_take(ratio: float, is_hard: bool) -> None:
    """Two evaluations per step, and the iterations beyond the usual ones: they could take minutes."""
    scene = stacked(ratio, "cube", "cube", "moreau-jean", 1e-3)
    scene["solver"] |= {"step": 1e-3, "max_evaluations": 1000}
    plant = gelenk.Simulation(scene)
    plant.initialize()
    if is_hard:
        with pytest.raises(
            gelenk.StepBudgetError, match=r"after 1000 evaluations \(solver.max_evaluations\)"
        ):
            plant.step_to(0.05)
        assert 0 < plant.time < 0.05
    else:
        plant.step_to(0.05)
        assert plant.diagnostics["solver.evaluations"] < 3 * 50
