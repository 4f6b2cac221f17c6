# SPDX-License-Identifier: BSD-3-Clause
"""Parameters from measured curves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.model.settable import with_listed

STEP, STOP = 0.04, 0.4
NOISE = {"A.phi": 1e-3, "D.phi": 1e-3}  # rad
TRUE = {"crank.m": 1.0, "coupler.m": 3.5, "A.damping": 0.1, "C.child.position[1]": 1.5, "A.w_start": 2.0}
TORQUE = {"drive.tau": lambda t: 20.0 * np.sin(9.0 * t)}


@pytest.fixture(scope="module")
def measured_bar(four_bar: gelenk.Scene) -> gelenk.Scene:
    return four_bar.with_parameters({"solver.integrator": "rk4", "A.w_start": 2.0})


@pytest.fixture(scope="module")
def curves(measured_bar: gelenk.Scene) -> dict[str, Any]:
    run = gelenk.simulate(measured_bar, stop=STOP, step=STEP, inputs=TORQUE, outputs=list(NOISE))
    return {name: run[name] for name in NOISE}


# The standard deviation of the share of one parameter is 0.22 / sqrt(trials), 1.5 % and 4.9 %; of all five,
# whose intervals are not independent, at most that and at least 0.7 % and 2.2 %.
@pytest.mark.study
@pytest.mark.parametrize(("trials", "share", "of_one"), [(200, 0.04, 0.06), (20, 0.12, 0.2)])
def test_five_parameters_of_a_four_bar_lie_in_their_confidence_intervals(
    measured_bar: gelenk.Scene, curves: dict[str, Any], trials: int, share: float, of_one: float
) -> None:
    """Of five 95 % intervals in each trial, 95 % contain the true value."""
    rng = np.random.default_rng(26)
    guess = {name: value * (1 + 0.005 * (-1) ** k) for k, (name, value) in enumerate(TRUE.items())}
    hits = dict.fromkeys(TRUE, 0)
    for _ in range(trials):
        noisy = {name: curve + NOISE[name] * rng.normal(size=len(curve)) for name, curve in curves.items()}
        found = gelenk.fit(measured_bar, noisy, guess, step=STEP, inputs=TORQUE, accuracy=1e-4)
        assert not found.unidentifiable
        for name, (low, high) in found.intervals.items():
            hits[name] += low <= TRUE[name] <= high
    assert sum(hits.values()) / (trials * len(TRUE)) == pytest.approx(0.95, abs=share), hits
    for name, count in hits.items():
        assert count / trials == pytest.approx(0.95, abs=of_one), name


@pytest.mark.thorough
def test_without_noise_the_parameters_are_found(measured_bar: gelenk.Scene, curves: dict[str, Any]) -> None:
    guess = {name: 1.1 * value for name, value in TRUE.items()}
    found = gelenk.fit(measured_bar, curves, guess, step=STEP, inputs=TORQUE, deviation=1e-3, accuracy=1e-9)
    for name, value in TRUE.items():
        assert found.values[name] == pytest.approx(value, rel=1e-5)
    assert "crank.m" in str(found)


def carts(**more: Any) -> dict[str, Any]:
    """A cart with a load that is welded to it: only the sum of the masses acts."""
    return {
        "gelenk": 1, "gravity": [0, 0, 0],
        "bodies": {"cart": {"mass": 2.0}, "load": {"mass": 1.0}},
        "joints": {
            "track": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "cart",
            "stiffness": 30.0}, "bolt": {"type": "weld", "parent": "cart", "child": "load"},
        },
        "motors": {"drive": {"joint": "track"}}, "parameters": ["cart.mass", "load.mass", "track.stiffness"],
        "experiment": {"stop": 1.0, "step": 0.05},
    } | more  # fmt: skip


def test_parameters_that_measurements_do_not_determine_are_named() -> None:
    run = gelenk.simulate(carts(), inputs={"drive.f": 5.0}, outputs=["track.s"])
    found = gelenk.fit(
        carts(), {"track.s": run["track.s"]}, {"cart.m": 2.2, "load.m": 0.9, "track.stiffness": 28.0},
        inputs={"drive.f": 5.0},
    )  # fmt: skip
    assert found.unidentifiable == ("cart.m", "load.m")
    assert found.values["cart.m"] + found.values["load.m"] == pytest.approx(3.0, rel=1e-6)
    assert found.values["track.stiffness"] == pytest.approx(30.0, rel=1e-6)
    assert found.deviations["cart.m"] == np.inf
    assert "not determined" in str(found)


def test_inputs_bounds_and_missing_values() -> None:
    run = gelenk.simulate(carts(), inputs={"drive.f": 5.0}, outputs=["track.s", "track.v"])
    curve = run["track.s"].copy()
    curve[3:7] = np.nan
    found = gelenk.fit(
        carts(), {"track.s": curve, "track.v": run["track.v"]}, {"drive.f": 3.0, "cart.m": (1.5, 1.0, 3.0)}
    )
    assert found.values == pytest.approx({"drive.f": 5.0, "cart.m": 2.0}, rel=1e-6)
    bounded = gelenk.fit(carts(), {"track.s": curve}, {"cart.m": (1.5, 1.0, 1.8)}, inputs={"drive.f": 5.0})
    assert bounded.at_bounds == ("cart.m",)
    assert bounded.values["cart.m"] == pytest.approx(1.8)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"unknowns": {}}, "expected at least one output and one parameter"),
        ({"unknowns": {"cart.x": 1.0}}, "cart.x: no such parameter or input"),
        ({"unknowns": {"cart.m": (1.0, 2.0, 3.0)}}, "cart.m: found (1.0, 2.0, 3.0), expected a guess"),
        ({"measured": {"track.s": [1.0]}}, "track.s: found an array of shape (1,)"),
        ({"deviation": 0.0}, "deviation: found 0.0 for track.s"),
        ({"confidence": 95}, "confidence: found 95"),
    ],
)
def test_wrong_calls_say_what_is_expected(options: Any, sentence: str) -> None:
    given = {"measured": {"track.s": np.zeros(5)}, "unknowns": {"cart.m": 1.0}} | options
    with pytest.raises(gelenk.UsageError) as caught:
        gelenk.fit(carts(), given.pop("measured"), given.pop("unknowns"), **given)
    assert sentence in str(caught.value)


def test_the_crank_that_brings_a_coupler_curve_nearest_to_a_given_one(four_bar: gelenk.Scene) -> None:
    """The curve of C, driven at a given speed, for a crank of 0.5 m; from 0.42 m the search returns to it."""
    data = four_bar.to_dict()
    data["motors"], data["parameters"] = {}, []
    data["constraints"] = {"crank": {"type": "motion", "joint": "A", "polynomial": [np.pi / 2, 6.0]}}
    data["joints"]["A"]["start"] = {"phi": np.pi / 2}
    options: dict[str, Any] = {"outputs": ["A.phi", "B.phi"], "stop": 1.0, "step": 0.05}
    length = "B.parent.position[1]"

    def curve(run: Any, crank: float) -> tuple[Any, Any]:
        at = run["A.phi"] + run["B.phi"]
        return (
            crank * np.cos(run["A.phi"]) + 1.75 * np.cos(at),
            crank * np.sin(run["A.phi"]) + 1.75 * np.sin(at),
        )

    wanted = gelenk.simulate(data, **options)
    target = wanted["B.phi"]

    def distance(run: Any) -> Any:
        apart = run["B.phi"] - target
        return float(apart @ apart), {"B.phi": 2 * apart}

    best = gelenk.optimize(data, {length: (0.42, 0.3, 0.6)}, distance, **options)
    assert best.success
    assert best.values[length] == pytest.approx(0.5, abs=1e-6)
    assert curve(best.run, best.values[length]) == pytest.approx(np.array(curve(wanted, 0.5)), abs=1e-5)
    assert with_listed(gelenk.load(data), [length])[1]


@pytest.mark.thorough
def test_designs_that_cannot_be_assembled_are_avoided(four_bar: gelenk.Scene) -> None:
    """The shorter the ground link's opposite, the better: until the loop cannot be closed."""

    def short(run: Any) -> Any:
        return -run["D.phi"][0], {"D.phi": np.eye(len(run.time))[0] * -1}

    best = gelenk.optimize(
        four_bar, {"C.parent.position[1]": (1.75, 0.2, 4.5)}, short, outputs=["D.phi"], stop=0.02, step=0.01
    )
    assert best.failed
    assert np.isfinite(best.objective)
