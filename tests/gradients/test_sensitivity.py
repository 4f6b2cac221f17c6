# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs, compared with closed forms and with central differences of runs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.model.settable import with_listed

SLIDER: dict[str, Any] = {
    "gelenk": 1,
    "gravity": [0, 0, 0],
    "bodies": {"mass": {"mass": 2.0}},
    "joints": {
        "track": {
            "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "mass",
            "start": {"s": 0.1, "v": 0.3, "fixed": True},
        }
    },
    "motors": {"drive": {"joint": "track"}},
    "solver": {"integrator": "rk4"},
    "experiment": {"stop": 1.0, "step": 0.01},
}  # fmt: skip


def slider(**joint: Any) -> dict[str, Any]:
    """A mass on a track with these keys, which are parameters if they are numbers."""
    numbers = [f"track.{key}" for key, value in joint.items() if isinstance(value, float)]
    joints = {"track": SLIDER["joints"]["track"] | joint}
    return SLIDER | {"joints": joints, "parameters": [*numbers, "mass.mass"]}


def central(scene: gelenk.Scene, name: str, relative: float, outputs: list[str], **options: Any) -> Any:
    """The derivatives of a run by a parameter or input: central differences of order 4."""
    given = dict(options.pop("inputs", {}))
    listed, renamed = with_listed(scene, [name])
    parameter = renamed.get(name, name)
    value = given[name] if name in given else float(listed.parameters[parameter])
    h = relative * (abs(value) or 1.0)

    def run(x: float) -> Any:
        changed = listed if name in given else listed.with_parameters({parameter: x})
        inputs = given | ({name: x} if name in given else {})
        result = gelenk.simulate(changed, outputs=outputs, inputs=inputs, **options)
        return np.array([result[output] for output in outputs]).T

    near, far = (run(value + k * h) - run(value - k * h) for k in (1, 2))
    return (8 * near - far) / (12 * h)


def apart(run: Any, name: str, expected: Any, outputs: list[str]) -> float:
    """The largest difference of derivatives by a name from these, relative to the largest of each output."""
    found = np.array([run.derivative(output, name) for output in outputs]).T
    return float((np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max())


def test_an_oscillator_has_the_derivatives_of_its_closed_form() -> None:
    """With w = sqrt(k/m) x = x0 cos(w t) + v0/w sin(w t): dx/dk = dx/dw / (2 m w), dx/dm = -w/(2 m) dx/dw."""
    run = gelenk.sensitivity(
        slider(stiffness=50.0), ["track.stiffness", "mass.mass", "track.s_start", "track.v_start"],
        outputs=["track.s", "track.v"],
    )  # fmt: skip
    t, m, w, x0, v0 = run.time, 2.0, 5.0, 0.1, 0.3
    cos, sin = np.cos(w * t), np.sin(w * t)
    by_w = -x0 * t * sin + v0 * (t * cos / w - sin / w**2)
    expected = {
        "track.stiffness": by_w / (2 * m * w), "mass.mass": -by_w * w / (2 * m), "track.s_start": cos,
        "track.v_start": sin / w,
    }  # fmt: skip
    # rk4 in steps of 10 ms: (w h)^5 / 120 a step are 3e-7 of the amplitude in the phase; 2e-7 were measured.
    for name, exact in expected.items():
        assert run.derivative("track.s", name) == pytest.approx(exact, abs=1e-6 * np.abs(exact).max())
    assert run.derivative("track.v", "track.s_start") == pytest.approx(-w * sin, abs=1e-6 * w)


BARS = [
    "crank.mass", "coupler.com[1]", "rocker.com[1]", "B.parent.position[1]", "C.child.position[1]",
    "A.damping", "A.phi_start", "A.w_start", "gravity[3]", "drive.tau",
]  # fmt: skip


@pytest.mark.thorough
def test_through_loops_they_agree_with_central_differences(four_bar: gelenk.Scene) -> None:
    # Steps of 0.25 ms, so that rk4 is exact to 1e-10. Differences of order 4 with relative steps of 2e-4:
    # their error is below 1e-8 (from half of the step) except by the length of the crank, with 4e-8.
    fine = four_bar.with_parameters({"solver.integrator": "rk4", "solver.step": 2.5e-4})
    outputs = ["A.phi", "D.phi", "C.w", "A.a"]
    options: dict[str, Any] = {"stop": 0.8, "step": 0.02, "inputs": {"drive.tau": 6.0}}
    run = gelenk.sensitivity(fine, BARS, outputs=outputs, **options)
    for name in BARS:
        expected = central(fine, name, 2e-4, outputs, **options)
        assert apart(run, name, expected, outputs) < 1e-7, name


@pytest.mark.parametrize(
    ("name", "by", "outputs"),
    [
        ("slider_crank", ["crank.m"], ["*.s", "*.phi"]),
        ("double_pendulum", [], ["*.phi"]),
        ("heavy_top", [], ["*.w*"]),
        ("five_bar", [], ["*.phi"]),
    ],
)
def test_shipped_scenes_agree_with_central_differences(
    root: Path, name: str, by: list[str], outputs: list[str]
) -> None:
    scene = gelenk.load(root / "scenes" / f"{name}.yaml").with_parameters({"solver.tolerance": 1e-11})
    known = scene.parameters
    masses = [p for p in known if p.endswith(".m")][:2]
    starts = [
        p
        for p in known
        if p.endswith(("phi_start", "s_start", ".w_start")) and known[p.split(".")[0] + ".fixed"]
    ][:1]
    chosen = list(dict.fromkeys([p for p in by if p in known] + masses + starts + ["gravity[3]"]))
    options: dict[str, Any] = {"stop": 0.2, "step": 0.02}
    run = gelenk.sensitivity(scene, chosen, outputs=outputs, **options)
    for parameter in chosen:
        expected = central(scene, parameter, 1e-3, list(run.outputs), **options)
        found = np.array([run.derivative(output, parameter) for output in run.outputs]).T
        # The differences of runs at a tolerance of 1e-11 have errors of 1e-8 of the largest values / step.
        size = np.abs(expected).max() + 1e-3 * np.abs(run.values).max()
        assert np.abs(found - expected).max() < 1e-6 * size, parameter


def test_through_spatial_loops_they_agree_with_central_differences(root: Path) -> None:
    """A Stewart platform: six legs, five loops in space."""
    scene = gelenk.load(root / "scenes" / "stewart.yaml").with_parameters({"solver.tolerance": 1e-11})
    options: dict[str, Any] = {"stop": 0.06, "step": 0.02}
    by = ["gravity[3]", next(name for name in scene.parameters if name.endswith(".m"))]
    run = gelenk.sensitivity(scene, by, outputs=["*.s"], **options)
    for name in by:
        expected = central(scene, name, 1e-3, list(run.outputs), **options)
        found = np.array([run.derivative(output, name) for output in run.outputs]).T
        # Runs at a tolerance of 1e-11, absolute per meter; differences of them over 1e-3 of the parameter.
        value = abs(float(scene.parameters[name]))
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max() + 1e-7 / value, name


def test_sliding_friction_has_the_derivative_of_its_closed_form() -> None:
    """S = s0 + v0 t - f t^2 / (2 m) while it slides."""
    run = gelenk.sensitivity(
        slider(friction={"coulomb": 0.4}),
        ["track.friction.coulomb", "track.v_start"],
        outputs=["track.s"],
        stop=1.0,
    )
    assert run.derivative("track.s", "track.friction.coulomb") == pytest.approx(-(run.time**2) / 4, abs=1e-9)
    assert run.derivative("track.s", "track.v_start") == pytest.approx(run.time, abs=1e-9)


def test_where_friction_begins_to_hold_as_a_step_ends_the_run_is_refused() -> None:
    """It comes to rest at t = m v0 / f = 1.5 s, a communication point, where accelerations jump."""
    with pytest.raises(gelenk.UsageError, match=r"t = 1\.5 s: "):
        gelenk.sensitivity(slider(friction={"coulomb": 0.4}), ["mass.mass"], outputs=["track.s"], stop=2.0)


def test_a_value_at_the_end_of_its_range_is_differentiated_from_inside() -> None:
    """Damping d >= 0: s = s0 + v0 (1 - exp(-d t / m)) m / d, ds/dd = -v0 t^2 / (2 m) at d = 0."""
    run = gelenk.sensitivity(slider(damping=0.0), ["track.damping"], outputs=["track.s"])
    assert run.derivative("track.s", "track.damping") == pytest.approx(-0.3 * run.time**2 / 4, abs=1e-8)


def test_inputs_that_jump_are_followed() -> None:
    """A force that is held in each step of 0.1 s: v = v0 + sum of F h / m, s accordingly."""

    def force(t: float) -> float:
        return 2.0 * math.sin(20 * 0.1 * math.floor(10 * t + 1e-9))

    run = gelenk.sensitivity(
        slider(damping=0.0),
        ["drive.f", "mass.mass"],
        outputs=["track.s", "track.v"],
        inputs={"drive.f": force},
        step=0.1,
    )
    impulses = np.concatenate([[0], np.cumsum([0.1 * force(t) for t in run.time[:-1]])])
    assert run.derivative("track.v", "mass.mass") == pytest.approx(-impulses / 4, abs=1e-10)
    assert run.derivative("track.v", "drive.f") == pytest.approx(run.time / 2, abs=1e-10)


def test_products_with_vectors_agree_with_differences_and_with_each_other(four_bar: gelenk.Scene) -> None:
    scene = four_bar.with_parameters({"solver.integrator": "rk4"})
    steps, h = 30, 1e-4
    rng = np.random.default_rng(1)
    torque, change = 5 + rng.normal(size=steps), rng.normal(size=steps)

    def held(table: Any) -> Any:
        return lambda t: float(table[min(int(t / 0.02 + 1e-9), steps - 1)])

    options: dict[str, Any] = {"outputs": ["A.phi", "C.a"], "stop": 0.6, "step": 0.02}
    run = gelenk.sensitivity(scene, ["drive.tau", "crank.m"], inputs={"drive.tau": held(torque)}, **options)
    along = gelenk.jvp(run, {"crank.m": 0.2}, {"drive.tau": change})

    def moved(k: float) -> Any:
        other = scene.with_parameters({"crank.m": 1.0 + 0.2 * k})
        return gelenk.simulate(other, inputs={"drive.tau": held(torque + k * change)}, **options)

    ahead, behind = moved(h), moved(-h)
    for name in options["outputs"]:
        expected = (ahead[name] - behind[name]) / (2 * h)
        # At t = 0 the result has the values before the step; errors of the differences h^2 and rounding / h.
        assert along[name] == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())

    weights = {name: rng.normal(size=steps + 1) for name in options["outputs"]}
    by_parameter, by_input = gelenk.vjp(run, weights)
    sum_of_outputs = sum(float(weights[name] @ along[name]) for name in weights)
    sum_of_changes = 0.2 * by_parameter["crank.m"] + float(by_input["drive.tau"] @ change)
    assert sum_of_changes == pytest.approx(sum_of_outputs, rel=1e-12)


def test_a_prescribed_motion_leaves_no_states_and_derivatives_by_lengths(root: Path) -> None:
    """The rocker of a four-bar whose crank turns at 3 rad/s, from the two triangles between B and D."""
    motion = {"type": "motion", "joint": "A", "polynomial": [math.pi / 2, 3.0]}
    data = gelenk.load(root / "scenes" / "four_bar.yaml").to_dict()
    data |= {"motors": {}, "constraints": {"crank": motion}}
    data["joints"]["A"]["start"] = {"phi": math.pi / 2}
    run = gelenk.sensitivity(
        data, ["B.parent.position[1]", "C.child.position[1]"], outputs=["A.phi", "D.phi"], stop=1.0, step=0.05
    )
    assert run.F.shape == (20, 0, 0)

    def rocker(crank: float, length: float) -> Any:
        x, y = crank * np.cos(run["A.phi"]) - 2.0, crank * np.sin(run["A.phi"])  # from D to B
        diagonal = np.hypot(x, y)
        cosine = (length**2 + diagonal**2 - 1.75**2) / (2 * length * diagonal)
        return np.unwrap(np.arctan2(y, x)) - np.arccos(cosine)

    assert run["D.phi"] == pytest.approx(rocker(0.5, 1.5), abs=1e-9)

    small = 1e-6  # differences of the closed form, exact to 1e-10
    for name, ahead, behind in (
        ("B.parent.position[1]", rocker(0.5 + small, 1.5), rocker(0.5 - small, 1.5)),
        ("C.child.position[1]", rocker(0.5, 1.5 + small), rocker(0.5, 1.5 - small)),
    ):
        expected = (ahead - behind) / (2 * small)
        assert run.derivative("D.phi", name) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(
    ("by", "outputs", "sentence"),
    [
        (["nothing.m"], ["track.s"], "nothing.m: no such parameter or input"),
        (["mass.m"], ["track.x"], "track.x: no such output"),
        (["solver.integrator"], ["track.s"], "solver.integrator: found 'rk4', expected a real number"),
    ],
)
def test_wrong_calls_say_what_is_expected(by: list[str], outputs: list[str], sentence: str) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        gelenk.sensitivity(slider(damping=0.1), by, outputs=outputs)
    assert sentence in str(caught.value)


def test_wrong_directions_say_what_is_expected() -> None:
    run = gelenk.sensitivity(slider(damping=0.1), ["mass.m", "drive.f"], outputs=["track.s"], stop=0.1)
    with pytest.raises(gelenk.UsageError, match=r"drive.f: found an array of shape \(3,\)"):
        gelenk.jvp(run, inputs={"drive.f": [1, 2, 3]})
    with pytest.raises(gelenk.UsageError, match=r"track.s: found an array of shape \(3,\), expected \(11,\)"):
        gelenk.vjp(run, {"track.s": [1, 2, 3]})
    with pytest.raises(gelenk.UsageError, match=r"drive.f: no such parameter"):
        gelenk.jvp(run, {"drive.f": 1.0})
