# SPDX-License-Identifier: BSD-3-Clause
"""Charts: outcomes are distinguished, figures complete, pictures drawn."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.chart import mechanisms, published, reference, runs_csv, stability, work_precision
from gelenk.chart.case import Array, Case, Jumps, case_of
from gelenk.chart.measure import Course, Reference, Run, Task, compared, measured
from gelenk.chart.methods import AUTO, Method, all_methods, chosen, registered
from gelenk.chart.outcome import Outcome, judged
from gelenk.chart.quadrature import rotation
from gelenk.chart.scenes import LIGHT_CART_POLE, light_cart_pole_truth, stability_cases
from gelenk.chart.workers import Failure, work_off
from gelenk.cli import app

ERK = Method("projection", "erk")
STABLE = {case.name: case for case in stability_cases()}


@pytest.fixture(scope="module")
def four_bar_case(four_bar_file: Path) -> Case:
    return replace(case_of(four_bar_file), stop=1.0, step=0.1)


@pytest.fixture(scope="module")
def truth(four_bar_case: Case) -> dict[str, Reference | Failure]:
    return reference.references([four_bar_case], 1, 60.0, quick=True)


def test_outcomes_are_distinguished(four_bar_case: Case, truth: dict[str, Reference | Failure]) -> None:
    """Real runs: one is good, one has no two correct digits, one is refused, one times out."""
    refused = STABLE["contradictory-speeds"]
    endless = replace(four_bar_case, name="endless", stop=1e4, step=1e4)
    tasks = [
        Task(four_bar_case, ERK, 1e-6),
        Task(four_bar_case, Method("projection", "euler"), None, 0.05),
        Task(refused, ERK, 1e-6),
        Task(endless, Method("projection", "rk4"), None, 1e-6),  # 1e10 steps
    ]
    good, wrong, no, none = work_precision.run_all(tasks, truth, 1, 2.0)
    assert (good.outcome, good.reason) == (Outcome.GOOD, "")
    assert 0 < good.error < 1e-4
    assert (wrong.outcome, wrong.reason) == (Outcome.WRONG, "no two correct digits")
    assert wrong.error > 1e-2
    assert no.outcome == Outcome.REFUSED
    assert "the fixed start velocities of A, D contradict the loops" in no.reason
    assert no.reached == 0
    assert (none.outcome, none.reason) == (Outcome.FAILED, "timed out after 2 s")
    assert math.isnan(none.error)


def test_a_refusal_during_a_run_has_the_time_reached() -> None:
    """The augmented Lagrangian iteration does not converge with redundant constraints."""
    run = measured(Task(STABLE["bricard"], Method("augmented-lagrangian", "erk"), 1e-8), None)
    assert run.outcome == Outcome.REFUSED
    assert run.reason
    assert run.reached < 10


def crash() -> int:
    import os

    os.abort()


def double(x: int) -> int:
    return 2 * x


def test_a_crash_and_a_hang_end_their_own_run_only() -> None:
    calls: list[tuple[Any, tuple[float, ...], float]] = [
        (double, (1,), 60.0),
        (crash, (), 60.0),
        (time.sleep, (100.0,), 0.5),
        (double, (4,), 60.0),
    ]
    first, crashed, hung, last = work_off(calls, 2)
    assert (first, last) == (2, 8)
    assert crashed == Failure("the process ended with signal 6")
    assert hung == Failure("timed out after 0.5 s")


@pytest.mark.thorough
def test_runs_after_a_timeout_are_skipped_at_smaller_steps(
    four_bar_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = replace(four_bar_case, name="endless", stop=1e4, step=1e4)
    tasks = [Task(endless, Method("projection", "rk4"), None, step) for step in (1e-6, 1e-7, 1e-8)]
    tried: list[float | None] = []

    def noted(calls: Sequence[Any], jobs: int) -> list[Any]:
        tried.extend(arguments[0].step for _, arguments, _ in calls)
        return work_off(calls, jobs)

    monkeypatch.setattr(work_precision, "work_off", noted)
    # The limit [s] is reached before the evaluation budget is exhausted.
    runs = work_precision.run_all([*tasks, Task(four_bar_case, ERK, 1e-6)], {}, 1, 2.0)
    assert tried == [1e-6, None]
    assert [r.reason for r in runs] == ["timed out after 2 s"] * 3 + [""]
    assert [r.step for r in runs[:3]] == [1e-6, 1e-7, 1e-8]


@pytest.mark.parametrize(
    ("error", "tolerance", "digits", "expected"),
    [
        (0.9e-4, 1e-6, 1e-12, Outcome.GOOD),  # 100 times the tolerance
        (1.1e-4, 1e-6, 1e-12, Outcome.WRONG),
        (1e-9, 1e-12, 2e-9, Outcome.GOOD),  # below the accuracy of the reference
        (0.9e-2, None, 1e-12, Outcome.GOOD),  # fixed steps: two digits
        (1.1e-2, None, 1e-12, Outcome.WRONG),
    ],
)
def test_judgement(error: float, tolerance: float | None, digits: float, expected: Outcome) -> None:
    assert judged(error, tolerance, digits) == expected


def course(states: Array, total: Array | None = None) -> Course:
    kinetic = np.array([0.0, 2.0, 1.0])
    return Course(states, kinetic, np.zeros(3) if total is None else total, 1e-9, 1e-8, {})


def test_error_is_the_largest_relative_to_the_size_of_the_signal() -> None:
    """0.2 of a signal of up to 50 is 4e-3; 0.003 of a signal below 1 is 3e-3."""
    states = np.array([[0.5, 50.0], [0.2, -10.0]])
    found = Reference(states, np.array([1.0, 50.0]), np.array([0.0, 2.0, 1.0]), np.zeros(3), 1e-12, "")
    off = states + np.array([[0.003, 0.0], [0.0, 0.2]])
    run = compared(Run("s", "m", "f", "i", 1e-4, outcome=Outcome.GOOD), course(off), found)
    assert run.error == pytest.approx(4e-3)
    assert run.outcome == Outcome.GOOD
    lost = compared(Run("s", "m", "f", "i", 1e-4), course(off * math.nan), found)
    assert (lost.outcome, lost.reason) == (Outcome.FAILED, "the states are not finite")


def test_energy_is_compared_with_its_start_if_conserved_and_else_with_the_reference() -> None:
    states, kinetic = np.ones((2, 1)), np.array([0.0, 2.0, 1.0])
    kept = Reference(states, np.ones(1), kinetic, np.full(3, 5.0), 1e-12, "")
    lost = Reference(states, np.ones(1), kinetic, np.array([5.0, 4.0, 3.0]), 1e-12, "")
    total = np.array([7.0, 7.0, 7.5])  # the zero of the potential energy may differ
    run = Run("s", "m", "f", "i", 1e-4)
    assert compared(run, course(states, total), kept).energy_error == pytest.approx(0.25)
    assert compared(run, course(states, total), lost).energy_error == pytest.approx(2.25)


# --- references ---


def test_references_carry_the_digits_in_which_unrelated_methods_agree(
    truth: dict[str, Reference | Failure],
) -> None:
    found = truth["four_bar"]
    assert isinstance(found, Reference)
    assert 1e-14 <= found.digits < 1e-8  # tolerances 1e-13 and 1e-12 over 1 s
    assert found.words.startswith("projection+erk at 1e-13, checked by independent+")


def test_quadrature_finds_the_pendulum_s_rates_and_period() -> None:
    """A rod rotates uniformly without gravity; with gravity, energy relates rate and angle."""
    times = np.linspace(0.1, 20, 50)
    phi, w = rotation(np.ones_like, np.zeros_like, 0.3, -2.0, times)
    np.testing.assert_allclose(phi, 0.3 - 2 * times, rtol=0, atol=1e-12)  # rounding of 40 rad
    phi, w = rotation(np.ones_like, lambda x: 9.81 * np.cos(x), 0.0, 1.0, times)
    np.testing.assert_allclose(w**2 / 2 + 9.81 * np.cos(phi), 0.5 + 9.81, rtol=1e-12)
    ahead, _ = rotation(np.ones_like, lambda x: 9.81 * np.cos(x), 0.0, 1.0, times + 1e-4)
    np.testing.assert_allclose((ahead - phi) / 1e-4, w, rtol=1e-2)  # h / 2 times the acceleration
    with pytest.raises(ValueError, match="does not suffice"):
        rotation(np.ones_like, lambda x: 9.81 * np.sin(x), 0.0, 1.0, times)


def test_light_cart_pole_swings_as_published() -> None:
    """Published with 15 digits and an accuracy of 9e-12."""
    times = np.array(list(LIGHT_CART_POLE))
    found = light_cart_pole_truth(times)
    printed = np.array(list(LIGHT_CART_POLE.values()))
    np.testing.assert_allclose(found["track.s"], printed[:, 0], rtol=0, atol=5e-11)
    np.testing.assert_allclose(found["hinge.phi"], printed[:, 1], rtol=0, atol=5e-11)


@pytest.mark.parametrize("name", ["n-four-bar-2", "parallelogram", "equal-slider-crank"])
def test_closed_forms_satisfy_the_equations_of_motion_at_first(name: str) -> None:
    """Before the first singular configuration: an integration of the loops at 1e-12."""
    case = replace(STABLE[name], stop=0.1)
    found = reference.recorded(Task(case, Method("independent", "cvode-adams"), 1e-12))
    assert isinstance(found, reference.Recording)
    assert case.truth is not None
    columns = case.truth(case.grid[case.samples()])
    expected = np.array([columns[n] for n in found.names]).T
    np.testing.assert_allclose(found.course.states, expected, rtol=0, atol=1e-9)  # 1000 rtol


# --- methods ---


def test_methods_are_those_of_the_core() -> None:
    formulations, integrators = registered()
    methods = all_methods()
    assert methods[0] == AUTO
    assert {m.formulation for m in methods[1:]} == set(formulations)
    assert {m.integrator for m in methods[1:]} == set(integrators)


def test_steps_are_fixed_where_the_tolerance_changes_nothing() -> None:
    pendulum = Case("pendulum", "", mechanisms.shipped("pendulum"), 0.5, 0.1)
    for method in all_methods():
        if method.automatic or method.formulation != "projection":
            continue
        step = 0.01 if method.fixed_step else None
        counts = {measured(Task(pendulum, method, x, step), None).evaluations for x in (1e-4, 1e-10)}
        assert (len(counts) == 1) == method.fixed_step, method.name


def test_methods_are_chosen_by_name() -> None:
    assert chosen(["auto", "rk4", "baumgarte", "independent+ida"]) == [
        AUTO, Method("projection", "rk4"), Method("baumgarte", "erk"), Method("independent", "ida"),
    ]  # fmt: skip
    with pytest.raises(gelenk.UsageError, match=r"--method baumgart: no such method; did you mean baumgarte"):
        chosen(["baumgart"])
    with pytest.raises(gelenk.UsageError, match=r"--method edra: no such method"):
        chosen(["penalty+edra"])


# --- figures ---


def run(method: str, tolerance: float, cpu: float, error: float, **fields: float | str) -> Run:
    outcome = judged(error, None if math.isnan(tolerance) else tolerance, 1e-14)
    return Run("toy", method, "f", "i", tolerance, outcome=outcome, cpu=cpu, error=error, **fields)  # type: ignore[arg-type]


def test_regret_is_against_the_cheapest_that_is_good_at_the_same_tolerance() -> None:
    runs = [
        run("auto", 1e-6, 3.0, 1e-7),
        run("quick", 1e-6, 1.0, 2e-4),  # wrong: does not count
        run("best", 1e-6, 2.0, 1e-5),
        run("slow", 1e-6, 9.0, 1e-9),
        run("best", 1e-8, 0.1, 1e-8),  # another tolerance
        run("fixed", math.nan, 1.5, 0.9e-4, step=0.1),
        run("fixed", math.nan, 0.5, 2e-4, step=0.2),  # error of more than 100 times 1e-6
    ]
    (found,) = work_precision.regrets(runs, (1e-6, 1e-4))
    assert (found.best, found.ratio) == ("best", 1.5)
    assert (found.best_of_all, found.ratio_of_all) == ("fixed", 2.0)


def test_regret_without_other_methods() -> None:
    (found,) = work_precision.regrets([run("auto", 1e-6, 3.0, 1.0)], (1e-6,))
    assert found.outcome == Outcome.WRONG
    assert found.best == "none"
    assert math.isnan(found.ratio)


def test_observed_order() -> None:
    """Errors of 3 h^4, except one at rounding and one without correct digits."""
    steps = [0.8, 0.1, 0.05, 0.025, 1e-4]
    runs = [run("rk4", math.nan, 1.0, max(3 * h**4, 1e-14), step=h, digits=1e-14) for h in steps]
    assert work_precision.observed_order(runs) == pytest.approx(4)
    assert math.isnan(work_precision.observed_order(runs[:1]))


def test_orders_are_those_of_the_methods(four_bar_case: Case, truth: dict[str, Reference | Failure]) -> None:
    """rk4: 4, improved Euler: 1, within 10 % of 2^p: 0.14 of p."""
    for name, order, step in (("rk4", 4, 3.125e-3), ("euler", 1, 1e-3)):
        tasks = [Task(four_bar_case, Method("projection", name), None, step / n) for n in (1, 2)]
        assert work_precision.observed_order(work_precision.run_all(tasks, truth, 1, 60.0)) == pytest.approx(
            order, abs=0.14
        )


def test_csv_holds_every_figure(tmp_path: Path) -> None:
    runs = [run("a", 1e-6, 3.0, 1e-7, steps=12.0), run("b", math.nan, 1.0, 1.0, reason="x, y")]
    runs_csv.write(runs, tmp_path / "runs.csv")
    header = (tmp_path / "runs.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header == [
        "scene", "method", "formulation", "integrator", "tolerance", "step", "outcome", "cpu", "evaluations",
        "steps", "rejected", "jacobians", "error", "digits", "position_residual", "velocity_residual",
        "energy_error", "reached", "reason",
    ]  # fmt: skip
    back = runs_csv.read(tmp_path / "runs.csv")
    assert (back[0].method, back[0].cpu, back[0].steps, back[0].reason) == ("a", 3.0, 12.0, "")
    assert math.isnan(back[1].tolerance)
    assert back[1].reason == "x, y"


def test_inputs_jump_at_every_communication_step_reproducibly() -> None:
    torque = Jumps(3.0, 10.0)
    values = np.array([torque.at(k) for k in range(1000)])
    assert values.min() >= -7
    assert values.max() <= 13
    assert np.abs(np.diff(values)).min() > 1
    assert abs(values.mean() - 3) < 0.1


def test_published_tables_have_the_cheapest_run_that_is_accurate_enough() -> None:
    given = ((1e-3, 100, 1e-3), (1e-6, 300, 1e-5), (1e-7, 200, 1e-6))
    efforts = [published.Effort(*figures) for figures in given]
    found = published.cheapest(efforts, 1e-4)
    assert found is not None
    assert found.evaluations == 200
    assert published.cheapest(efforts, 1e-9) is None


# --- commands ---


def assert_drawn(path: Path) -> None:
    """A picture of sufficient size with more than one color."""
    from matplotlib import image

    pixels = image.imread(path)
    assert min(pixels.shape[:2]) > 300
    assert pixels[..., :3].std() > 0.05
    assert path.stat().st_size < 150_000


@pytest.mark.thorough
def test_work_precision_from_the_command_line(tmp_path: Path, four_bar_file: Path) -> None:
    result = CliRunner().invoke(
        app, ["chart", "work-precision", str(four_bar_file), "--quick", "--jobs", "2", "-o", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    runs = runs_csv.read(tmp_path / "work-precision-four_bar.csv")
    assert {r.method for r in runs} == {m.name for m in all_methods()}
    assert all(r.error < 1e-4 for r in runs if r.method == "auto")
    assert_drawn(tmp_path / "work-precision-four_bar.png")
    assert "tolerance 1e-06: auto good" in result.output


@pytest.mark.thorough
def test_stability_from_the_command_line(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["chart", "stability", "--quick", "--jobs", "2", "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    runs = runs_csv.read(tmp_path / "stability.csv")
    assert {r.scene for r in runs} >= {"n-four-bar-1", "andrews", "contradictory-speeds"}
    assert {r.outcome for r in runs if r.scene == "contradictory-speeds"} == {Outcome.REFUSED}
    drifting = next(r for r in runs if (r.scene, r.method) == ("n-four-bar-1", "udwadia-kalaba+erk"))
    assert drifting.outcome == Outcome.WRONG
    assert_drawn(tmp_path / "stability-1e-6.png")
    assert "| n-four-bar-1 |" in (tmp_path / "stability.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["work-precision", "missing.yaml"], "missing.yaml: no such file or directory"),
        (["work-precision", "four_bar", "--method", "erg"], "--method erg: no such method"),
        (["work-precision", "four_bar", "--tolerance", "2"], "--tolerance: found 2.0, expected a"),
        (["work-precision", "four_bar", "four_bar"], "four_bar: two scenes with this name"),
        (["stability", "bricart"], "bricart: no such scene of the map; did you mean bricard?"),
    ],
)
def test_usage_errors_are_reported_in_one_line(arguments: list[str], words: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["chart", *arguments, "-o", str(tmp_path)])
    assert result.exit_code == 1
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_without_matplotlib_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    result = CliRunner().invoke(app, ["chart", "stability", "-o", str(tmp_path / "none")])
    assert result.exit_code == 1
    assert result.stderr == "charts are drawn with matplotlib: pip install 'gelenk[charts]'\n"
    assert not (tmp_path / "none").exists()


def test_every_scene_of_the_map_has_a_description() -> None:
    """One sentence each; all readable scenes can be initialized except the one that must be refused."""
    for case in stability_cases():
        assert case.about.endswith((".", "?"))
        assert len(case.about) < 170
        if stability.unreadable(case):
            continue
        simulation = gelenk.Simulation(gelenk.load(case.scene))
        if case.expected == "refused":
            with pytest.raises(gelenk.AssemblyError):
                simulation.initialize()
        else:
            simulation.initialize()


def test_mechanisms_are_the_benchmark_s() -> None:
    """Masses of the IFToMM library: 5 links of 1 kg, 5 rods of 1 kg; shaft, collar and two loaded arms."""
    scenes = (mechanisms.four_bar_chain(2), mechanisms.bricard(), mechanisms.governor())
    masses = [sum(b["mass"] for b in scene["bodies"].values()) for scene in scenes]
    assert masses == pytest.approx([5, 5, 0.3 + 3 + 2 * 5.3])
