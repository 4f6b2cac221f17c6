# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs through events, compared with closed forms and with central differences of runs."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned

import gelenk
from gradients.test_sensitivity import apart, central

type Motion = Callable[..., tuple[complex, complex]]


def slider(**joint: Any) -> dict[str, Any]:
    """A mass of 2 kg on a vertical track."""
    return {
        "gelenk": 1, "gravity": [0, 0, -9.81], "bodies": {"mass": {"mass": 2.0}},
        "joints": {
            "track": {"type": "prismatic", "axis": [0, 0, 1], "parent": "ground", "child": "mass"} | joint
        },
        "motors": {"drive": {"joint": "track"}},
        "solver": {"integrator": "rk4"}, "experiment": {"stop": 1.0, "step": 0.01},
    }  # fmt: skip


def derivatives_of(
    motion: Motion, time: float, values: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """The derivatives of position and velocity at a time by all arguments, by a complex step: exact."""
    found = {}
    for name in values:
        changed: dict[str, complex] = dict(values)
        changed[name] += 1e-30j
        s, v = motion(time, **changed)
        found[name] = (s.imag / 1e-30, v.imag / 1e-30)
    return found


def agree(run: gelenk.DifferentiatedRun, motion: Motion, names: dict[str, str], values: dict[str, float],
          relative: float, outputs: tuple[str, str] = ("track.s", "track.v")) -> None:  # fmt: skip
    """Compare values and derivatives at all times with a closed form.

    relative: to the largest value of each.
    """
    times = run.time.tolist()
    exact = [motion(t, **values) for t in times]
    for i, output in enumerate(outputs):
        expected = np.array([pair[i].real for pair in exact])
        assert run[output] == pytest.approx(expected, abs=relative * np.abs(expected).max())
        for argument, name in names.items():
            expected = np.array([derivatives_of(motion, t, values)[argument][i] for t in times])
            found = run.derivative(output, name)
            assert found == pytest.approx(expected, abs=relative * np.abs(expected).max()), (output, name)


def bounce(
    time: float, h: complex, v: complex, g: complex, e: complex, floor: complex
) -> tuple[complex, complex]:
    """A ball that is thrown up from a height and bounces."""
    at: complex = 0
    s = h
    while True:
        flight = (v + cmath.sqrt(v * v + 2 * g * (s - floor))) / g
        if (at + flight).real > time:
            t = time - at
            return s + v * t - g * t * t / 2, v - g * t
        at, s, v = at + flight, floor, e * (g * flight - v)


def test_a_bouncing_ball_has_the_derivatives_of_its_closed_form() -> None:
    start = {"s": 0.8, "v": 0.5, "fixed": True}
    scene = slider(start=start, limit={"lower": -0.1, "restitution": 0.8})
    names = {
        "h": "track.s_start", "v": "track.v_start", "e": "track.limit.restitution",
        "floor": "track.limit.lower",
    }  # fmt: skip
    run = gelenk.sensitivity(
        scene,
        [*names.values(), "gravity[3]", "mass.mass"],
        outputs=["track.s", "track.v"],
        stop=2.5,
        step=0.01,
    )
    values = {"h": 0.8, "v": 0.5, "g": 9.81, "e": 0.8, "floor": -0.1}
    assert np.count_nonzero(np.diff(np.sign(run["track.v"])) > 0) == 4  # impacts
    # rk4 is exact here. Each impact multiplies the errors of the times of earlier ones.
    agree(run, bounce, names, values, 1e-8)
    assert run.derivative("track.v", "mass.mass") == pytest.approx(0 * run.time, abs=1e-8)
    by_g = [derivatives_of(bounce, float(t), values)["g"][0] for t in run.time]
    assert run.derivative("track.s", "gravity[3]") == pytest.approx(
        -np.array(by_g), abs=1e-8 * max(map(abs, by_g))
    )


def rebound(
    time: float, k: complex, m: complex, x: complex, e: complex, wall: complex
) -> tuple[complex, complex]:
    """A mass on a spring that is released at rest at x < wall and meets a wall beyond its equilibrium."""
    w = cmath.sqrt(k / m)
    at: complex = 0
    s, v = x, 0j
    while True:
        amplitude, phase = cmath.sqrt(s * s + (v / w) ** 2), cmath.atan(-v / (w * s))
        if s.real < 0:
            phase += cmath.pi
        reach = -cmath.acos(wall / amplitude)  # amplitude cos(w t + phase), rising
        while ((reach - phase) / w).real < 1e-9:
            reach += 2 * cmath.pi
        flight = (reach - phase) / w
        if (at + flight).real > time:
            t = w * (time - at) + phase
            return amplitude * cmath.cos(t), -amplitude * w * cmath.sin(t)
        at, s, v = at + flight, wall, e * amplitude * w * cmath.sin(reach)


def test_an_oscillator_that_strikes_a_limit_has_the_derivatives_of_its_closed_form() -> None:
    scene = slider(
        stiffness=200.0, start={"s": -0.2, "v": 0, "fixed": True}, limit={"upper": 0.05, "restitution": 0.7}
    ) | {"gravity": [0, 0, 0]}
    names = {
        "k": "track.stiffness", "m": "mass.mass", "x": "track.s_start", "e": "track.limit.restitution",
        "wall": "track.limit.upper",
    }  # fmt: skip
    scene["solver"] = {"integrator": "rk4", "step": 5e-4}
    run = gelenk.sensitivity(scene, [*names.values()], outputs=["track.s", "track.v"], stop=1.2, step=0.01)
    values = {"k": 200.0, "m": 2.0, "x": -0.2, "e": 0.7, "wall": 0.05}
    assert np.count_nonzero(np.diff(np.sign(run["track.v"])) < 0) >= 3
    # (w h)^4 / 120 of rk4 with w = 10 rad/s and h = 0.5 ms are 5e-12; 1e-8 for the formulas at the impacts.
    agree(run, rebound, names, values, 1e-8)


def brake(time: float, v: complex, f: complex, m: complex, g: complex) -> tuple[complex, complex]:
    """A block that slides up an incline until friction holds it."""
    a = f / m + g
    t = min(complex(time), v / a, key=lambda x: x.real)
    return v * t - a * t * t / 2, v - a * t


def test_a_block_that_stops_on_an_incline_has_the_derivatives_of_its_closed_form() -> None:
    scene = slider(start={"s": 0, "v": 0.7, "fixed": True}, friction={"coulomb": 5.0})
    scene |= {"gravity": [0, 0, -1.3]}  # along the incline
    names = {"v": "track.v_start", "f": "track.friction.coulomb", "m": "mass.mass"}
    run = gelenk.sensitivity(
        scene, [*names.values(), "gravity[3]", "drive.f"], outputs=["track.s", "track.v"], stop=0.4, step=0.01
    )
    values = {"v": 0.7, "f": 5.0, "m": 2.0, "g": 1.3}
    assert run["track.v"][-1] == 0
    agree(run, brake, names, values, 1e-9)
    assert run.derivative("track.v", "drive.f")[-1] == 0
    # The stopping distance v^2 / (2 a), where a force F adds -F/m to a.
    a = 5.0 / 2 + 1.3
    assert run.derivative("track.s", "drive.f")[-1] == pytest.approx(0.7**2 / (2 * a * a) / 2, rel=1e-9)


def stick_slip(
    time: float, k: complex, m: complex, fs: complex, fc: complex, v: complex
) -> tuple[complex, complex]:
    """A mass with friction that a spring pulls whose other end moves at the speed v."""
    w = cmath.sqrt(k / m)
    at: complex = 0  # start of a slip
    s: complex = 0
    extension: complex = 0  # when it sticks, since `at`
    while True:
        away = at + (fs / k - extension) / v
        if away.real > time:
            return s, 0j
        a = (fs - fc) * w / k
        slip = (2 * cmath.pi - 2 * cmath.atan(a / v)) / w

        def stretched(t: complex, a: complex = a) -> tuple[complex, complex]:
            y = fc / k + a / w * cmath.cos(w * t) + v / w * cmath.sin(w * t)
            return y, -a * cmath.sin(w * t) + v * cmath.cos(w * t)

        if (away + slip).real > time:
            y, rate = stretched(time - away)
            return s + fs / k + v * (time - away) - y, v - rate
        y = stretched(slip)[0]
        s, at, extension = s + fs / k + v * slip - y, away + slip, y


PULLED: dict[str, Any] = {
    "gelenk": 1, "gravity": [0, 0, 0],
    "bodies": {"cart": {"mass": 1.0}, "mass": {"mass": 2.0}},
    "joints": {
        "belt": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "cart",
                 "start": {"s": 0, "v": 0.5}},
        "track": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "mass",
                  "start": {"s": 0, "v": 0, "fixed": True}, "friction": {"coulomb": 6.0, "static": 9.0}},
    },
    "constraints": {"pull": {"type": "motion", "joint": "belt", "polynomial": [0, 0.5]}},
    "forces": {"spring": {"type": "spring_damper", "from": {"body": "cart", "position": [1, 0, 0]},
                          "to": "mass",
                          "stiffness": 400.0, "length": 1.0}},
    "solver": {"integrator": "rk4", "step": 5e-4}, "experiment": {"stop": 2.0, "step": 0.01},
}  # fmt: skip


def test_stick_and_slip_have_the_derivatives_of_their_closed_form() -> None:
    names = {
        "k": "spring.stiffness", "m": "mass.mass", "fs": "track.friction.static",
        "fc": "track.friction.coulomb",
        "v": "pull.polynomial[2]",
    }  # fmt: skip
    run = gelenk.sensitivity(PULLED, [*names.values()], outputs=["track.s", "track.v"], stop=1.6, step=0.01)
    modes = np.diff((run["track.v"] > 0).astype(int))
    assert np.count_nonzero(modes > 0) >= 2  # it slips twice,
    assert np.count_nonzero(modes < 0) >= 2  # and sticks again
    agree(run, stick_slip, names, {"k": 400.0, "m": 2.0, "fs": 9.0, "fc": 6.0, "v": 0.5}, 1e-7)


OPTIONS: dict[str, Any] = {"stop": 1.0, "step": 0.02, "inputs": {"drive.tau": 6.0}}


@warned.GUESSES
@pytest.mark.parametrize(
    ("joint", "fields", "by"),
    [
        ("D", {"limit": {"upper": 2.2, "restitution": 0.6}}, ["D.limit.upper", "D.limit.restitution"]),
        pytest.param(
            "A", {"limit": {"upper": 4.5, "restitution": 0.3}}, ["A.limit.upper"],
            marks=pytest.mark.thorough,
        ),
        pytest.param(
            "A", {"friction": {"coulomb": 3.0, "static": 5.0}, "start": {"phi": 2.2, "w": -2, "fixed": True}},
            ["A.friction.coulomb", "A.w_start"], marks=pytest.mark.thorough,
        ),
        pytest.param(
            "C", {"stop": {"upper": 1.6, "stiffness": 500.0, "damping": 2.0}},
            ["C.stop.stiffness", "C.stop.damping"], marks=pytest.mark.thorough,
        ),
    ],
)  # fmt: skip
def test_events_in_loops_agree_with_central_differences(
    root: Path, joint: str, fields: dict[str, Any], by: list[str]
) -> None:
    data = gelenk.load(root / "scenes" / "four_bar.yaml").to_dict()
    data["joints"][joint] |= fields
    data["solver"] = {"integrator": "rk4", "step": 2.5e-4}
    scene = gelenk.load(data)
    outputs = ["A.phi", "A.w", "D.phi", "C.w"]
    found = gelenk.simulate(scene, outputs=outputs, **OPTIONS)
    assert found.events
    by = [*by, "crank.mass", "B.parent.position[1]", "drive.tau"]
    run = gelenk.sensitivity(scene, by, outputs=outputs, **OPTIONS)
    for name in by:
        # As for the smooth four-bar; differences of order 4 with relative steps of 2e-4.
        expected = central(scene, name, 1e-4, outputs, **OPTIONS)
        assert apart(run, name, expected, outputs) < 1e-7, name


def test_products_with_vectors_pass_through_events() -> None:
    scene = slider(start={"s": 0.3, "v": 0.5, "fixed": True}, limit={"lower": 0.0, "restitution": 0.8})
    run = gelenk.sensitivity(
        scene, ["track.v_start", "drive.f"], outputs=["track.s"], inputs={"drive.f": 1.0}, stop=1.0, step=0.01
    )
    last = np.zeros(len(run.time))
    last[-1] = 1.0
    by_parameter, by_input = gelenk.vjp(run, {"track.s": last})
    assert by_parameter["track.v_start"] == pytest.approx(
        run.derivative("track.s", "track.v_start")[-1], rel=1e-9
    )
    assert by_input["drive.f"].sum() == pytest.approx(run.derivative("track.s", "drive.f")[-1], rel=1e-9)


def test_an_input_that_lets_go_has_the_derivatives_of_its_closed_form() -> None:
    """A force F presses the mass against its limit from 0.3162 s on, and is -3 N from 0.6 s on."""

    def force(t: float) -> float:
        return 2.0 if t < 0.595 else -3.0

    scene = slider(start={"s": 0.0, "v": 0, "fixed": True}, limit={"upper": 0.05, "restitution": 0.0})
    scene["gravity"] = [0, 0, 0]
    run = gelenk.sensitivity(
        scene, ["track.limit.upper", "mass.mass", "drive.f"], outputs=["track.s"], inputs={"drive.f": force}
    )
    t, m = run.time, 2.0
    after = np.maximum(t - 0.6, 0.0)
    assert run["track.s"][60] == pytest.approx(0.05, abs=1e-12)
    before = t < 0.3
    for name, free, released in (
        ("track.limit.upper", 0 * t, 1 + 0 * t),
        ("mass.mass", -2.0 * t**2 / (2 * m * m), 3.0 * after**2 / (2 * m * m)),
        ("drive.f", t**2 / (2 * m), after**2 / (2 * m)),
    ):
        found = run.derivative("track.s", name)
        assert found[before] == pytest.approx(free[before], abs=1e-9)
        assert found[t > 0.33] == pytest.approx(released[t > 0.33], abs=1e-9)  # rk4 is exact here


def test_contact_with_a_stop_by_its_bound_is_refused() -> None:
    scene = slider(start={"s": 0.0, "v": 1.0, "fixed": True}, stop={"upper": 0.1, "stiffness": 100.0})
    scene["gravity"] = [0, 0, 0]
    with pytest.raises(
        gelenk.UsageError, match=r"track.stop.upper: at t = 0\.\d* s the equations .* abruptly"
    ):
        gelenk.sensitivity(scene, ["track.stop.upper"], outputs=["track.s"], step=0.013)


def test_an_impact_that_grazes_is_refused() -> None:
    """The oscillator reaches 0.2 m; the limit is 1 nm within, which it meets at 0.2 mm/s."""
    scene = slider(
        stiffness=200.0,
        start={"s": -0.2, "v": 0, "fixed": True},
        limit={"upper": 0.2 - 1e-9, "restitution": 0.5},
    ) | {"gravity": [0, 0, 0], "solver": {"integrator": "rk4", "step": 1e-4}}
    with pytest.raises(
        gelenk.UsageError, match=r"t = 0\.31414\d* s: track.s meets its upper limit; .* it grazes"
    ):
        gelenk.sensitivity(scene, ["mass.mass"], outputs=["track.s"], stop=0.5)


def test_impacts_at_the_same_instant_are_refused() -> None:
    """The order in which neighboring runs have them decides on what follows."""
    scene = slider(start={"s": 0.3, "v": 0.5, "fixed": True}, limit={"lower": 0.0, "restitution": 0.8})
    scene["bodies"]["other"] = {"mass": 1.0}
    scene["joints"]["guide"] = scene["joints"]["track"] | {"child": "other"}
    with pytest.raises(
        gelenk.UsageError, match=r"neighboring runs have other events; .* coincides with another one"
    ):
        gelenk.sensitivity(scene, ["track.s_start"], outputs=["*.s"])


def test_an_event_at_a_communication_point_is_refused() -> None:
    scene = slider(start={"s": 0.0, "v": 0.6, "fixed": True}, limit={"upper": 0.3, "restitution": 0.8})
    scene["gravity"] = [0, 0, 0]
    with pytest.raises(gelenk.UsageError, match=r"t = 0\.5 s: .*track"):
        gelenk.sensitivity(scene, ["mass.mass"], outputs=["track.s"])
