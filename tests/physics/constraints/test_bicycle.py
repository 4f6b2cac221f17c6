# SPDX-License-Identifier: BSD-3-Clause
"""The benchmark bicycle: published eigenvalues, accelerations of the nonlinear equations, and runs.

Eigenvalues, critical speeds: Meijaard, Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007) 1955-1982.
Accelerations, steady turn: Basu-Mandal, Chatterjee & Papadopoulos, Proc. R. Soc. A 463 (2007) 1983-2003,
tables 1 and 2. Runs: the problem "uncontrolled bicycle" of the IFToMM benchmarks (Sanjurjo & Gonzalez).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import control
import fmpy
import numpy as np
import pytest
from mechanisms import Array
from models.running import Recording, assert_close, run
from models.whipple import FRONT_RADIUS, REAR_RADIUS, bicycle, linear_theory
from scipy.linalg import expm

import gelenk
from gelenk.linear import LinearModel

AT_REST = [-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393]  # 1/s
WEAVE_CAPSIZE_CASTERING = {  # by speed [m/s]: complex pair, two real ones [1/s]
    1: (3.5269617099007 + 0.8077402751993j, -3.13423125066578, -7.11008014637442),
    2: (2.68234517512745 + 1.68066296590675j, -3.07158645641514, -8.67387984831735),
    3: (1.70675605663975 + 2.31582447384325j, -2.63366137253667, -10.3510146724592),
    4: (0.41325331521125 + 3.07910818603206j, -1.42944427361326, -12.1586142657645),
    5: (-0.77534188219585 + 4.46486771378823j, -0.32286642900409, -14.0783896927982),
    6: (-1.52644486584142 + 5.87673060598709j, -0.0040669007697, -16.0853712309803),
    7: (-2.13875644258362 + 7.19525913329805j, 0.10268170574766, -18.15788466125262),
    8: (-2.69348683581097 + 8.46037971396931j, 0.14327879765713, -20.27940894394569),
    9: (-3.21675402252485 + 9.69377351531791j, 0.15790184030917, -22.43788559040858),
    10: (-3.72016840437287 + 10.90681139476287j, 0.16105338653172, -24.62459635017404),
}
PUBLISHED: dict[int, Sequence[complex]] = {0: AT_REST} | {
    v: [weave, weave.conjugate(), *real] for v, (weave, *real) in WEAVE_CAPSIZE_CASTERING.items()
}
DOUBLE_ROOT, WEAVE, CAPSIZE = 0.68428307889246, 4.29238253634111, 6.02426201538837  # m/s
LEAN_AND_STEER = ["lean.phi", "steer.phi", "lean.w", "steer.w"]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU of a bicycle at rest; the forward speed is a start value."""
    return gelenk.export_fmu(bicycle(), tmp_path_factory.mktemp("bicycle") / "Bicycle.fmu")


def riding(v: float) -> dict[str, float]:
    return {"hub.w": v / REAR_RADIUS}


def apart(A: Array, expected: Sequence[complex]) -> float:
    """The largest distance of a published eigenvalue to the closest computed one, each used once."""
    found = list(np.linalg.eigvals(A))
    out = 0.0
    for value in expected:
        nearest = min(range(len(found)), key=lambda i: abs(found[i] - value))
        out = max(out, abs(found.pop(nearest) - value))
    return out


def lean_and_steer(model: LinearModel) -> Array:
    """The block of A for lean and steer, which depend on no other state, as in the benchmark's equations."""
    k = [model.states.index(name) for name in LEAN_AND_STEER]
    assert_close("other columns", np.delete(model.A[k], k, axis=1), 0, 1e-11, "round-off of 10^3 1/s^2")
    return model.A[np.ix_(k, k)]


@pytest.mark.parametrize("v", PUBLISHED)
def test_eigenvalues_of_the_scene(v: int) -> None:
    """Ten states: seven coordinates, since each wheel constrains one, and three velocities."""
    model = gelenk.linear.linear_model(bicycle(v))
    assert (len([s for s in model.states if ".w" in s]), len(model.states)) == (3, 10)
    assert apart(lean_and_steer(model), PUBLISHED[v]) < 1e-11  # 14 published digits
    assert (
        apart(model.A, [*PUBLISHED[v], *[0.0] * 6]) < 1e-6
    )  # a zero may be a block of two: root of round-off, of entries up to 10^3


@pytest.mark.parametrize("v", PUBLISHED)
def test_eigenvalues_of_the_fmu_alone(v: int, fmu: Path) -> None:
    model = gelenk.linear.linear_model(fmu, at=riding(v))
    assert len(model.states) == 10
    assert apart(lean_and_steer(model), PUBLISHED[v]) < 1e-11  # 14 published digits
    assert_close("scene", model.A, gelenk.linear.linear_model(bicycle(v)).A, 1e-10, "round-off of 10^3")


@pytest.mark.parametrize("v", [0.5, 3.3, 7.7])
def test_linear_model_matches_the_matrices_of_the_benchmark(v: float) -> None:
    """Lean to the right is positive in both; here y is to the left, and z up: steer to the left."""
    signs = np.array([1, -1, 1, -1])
    expected = linear_theory(v) * np.outer(signs, signs)
    model = gelenk.linear.linear_model(bicycle(v))
    assert_close("A", lean_and_steer(model), expected, 1e-10, "matrices of 14 digits up to 80, inverted")


def test_critical_speeds() -> None:
    """Weave begins as a double root and becomes stable; then capsize becomes unstable."""
    at = {v: lean_and_steer(gelenk.linear.linear_model(bicycle(v))) for v in (DOUBLE_ROOT, WEAVE, CAPSIZE)}
    pair = sorted(np.linalg.eigvals(at[DOUBLE_ROOT]), key=lambda s: s.real)[2:]
    assert_close("mean", np.mean(pair).real, 3.7829040512932, 1e-12, "14 digits")
    assert abs(pair[0] - pair[1]) < 1e-5  # rounding of the speed, 1e-14, and of A, under a root
    weave = max(np.linalg.eigvals(at[WEAVE]), key=lambda s: s.imag)
    assert abs(weave - 3.43503384866144j) < 1e-12
    assert abs(np.linalg.eigvals(at[CAPSIZE])).min() < 1e-12


def test_normal_forces_at_rest_and_at_constant_speed() -> None:
    """Computed from the same data by statics; riding straight ahead does not change them."""
    for v in (0.0, 6.0):
        found = run(bicycle(v), [0.0])
        assert_close("rear", found["rear_tyre.f_n"], 612.836470588236, 1e-11, "15 digits")
        assert_close("front", found["front_tyre.f_n"], 309.303529411765, 1e-11, "15 digits")
        for name in ("rear_tyre.f_lat", "rear_tyre.f_long", "front_tyre.f_lat", "front_tyre.f_long"):
            assert_close(name, found[name], 0, 1e-10, "round-off of 600 N")


# Basu-Mandal et al., table 1: the heading is -x; lean is measured from the ground, pi/2 if upright; the pitch
# is pi if level.
Q = {"lean": 0.9501292851472, "pitch": 3.1257073014894, "steer": 0.2311385135743}
SPEEDS = {
    "base.v_x": 2.8069345714545,
    "base.v_y": 0.1480982396001,
    "height.v": 0.1058778746261,
    "base.w": 0.7830033527065,
    "lean.w": -0.6068425835418,
    "pitch.w": -0.0119185528069,
    "steer.w": 0.4859824687093,
    "hub.w": 8.912989661489,
    "front_hub.w": 8.0133620584155,
}
ACCELERATIONS = {
    "base.a_x": 0.5041626315047,
    "base.a_y": 0.3449706619454,
    "height.a": -1.460452833298,
    "base.wd": 0.8353281706379,
    "lean.a": 7.8555281128244,
    "pitch.a": 0.1205543897884,
    "steer.a": -4.6198904039403,
    "hub.a": 1.8472554144217,
    "front_hub.a": 2.454807290455,
}


def posed(lean: float, steer: float, lean_speed: float, steer_speed: float, wheel: float) -> Recording:
    """The bicycle with these coordinates and velocities at the start; assembly computes the others."""
    starts: dict[str, dict[str, Any]] = {
        "lean": {"phi": lean, "w": lean_speed, "fixed": True},
        "steer": {"phi": steer, "w": steer_speed, "fixed": True},
        "hub": {"w": wheel, "fixed": ["w"]},
    }
    return run(bicycle(0.0, starts), [0.0])


def test_accelerations_of_the_nonlinear_equations() -> None:
    """From lean, steer and the rear wheel, pitch and six velocities follow and have the published values."""
    found = posed(np.pi / 2 - Q["lean"], Q["steer"], *(SPEEDS[n] for n in ("lean.w", "steer.w", "hub.w")))
    assert_close("pitch", found["pitch.phi"], Q["pitch"] - np.pi, 2e-13, "13 decimals")
    assert_close("height", found["height.s"], 0.2440472102925, 1e-13, "13 decimals")
    for name, value in SPEEDS.items():
        assert_close(name, found[name], value, 1e-12, "13 decimals, and those of the pose")
    for name, value in ACCELERATIONS.items():
        assert_close(
            name, found[name], value, 2e-11, "13 decimals of speeds up to 9 rad/s, squared, and of the pose"
        )


def test_steady_turn() -> None:
    """Table 2: velocities are constant; the rear hub moves on a circle of the published radius."""
    found = posed(np.pi / 2 - 1.9178291654, 0.4049333918, 0.0, 0.0, 10.3899258905)
    speed = np.hypot(found["base.v_x"], found["base.v_y"])
    assert_close("radius", speed / found["base.w"], 2.2588798195, 1e-9, "10 decimals of the angles")
    assert_close(
        "toward the center", found["base.a_y"], speed * found["base.w"], 3e-9, "10 decimals, 13 1/s2"
    )
    for name in ("lean.a", "steer.a", "pitch.a", "hub.a", "front_hub.a", "base.wd", "height.a", "base.a_x"):
        assert_close(name, found[name], 0, 2e-9, "10 decimals of angles, times some 10 1/s2")


@pytest.mark.parametrize(("v", "roll"), [(4.0, 0.05), (4.6, 0.5), (8.0, 0.05)])
def test_maneuvers_conserve_energy(v: float, roll: float) -> None:
    """20 s after an initial roll rate [rad/s]. The benchmark requires 1e-3 percent."""
    found = run(bicycle(v, {"lean": {"phi": 0.0, "w": roll, "fixed": True}}), np.linspace(0, 20, 201))
    energy = found["energy.total"]
    assert np.ptp(energy) / energy[0] < 1e-10  # the tolerance of the run
    for wheel in ("rear", "front"):
        assert_close(f"{wheel} contact", found[f"{wheel}_tyre.r[3]"], 0, 1e-11, "projected")
    assert found["constraints.velocity"].max() < 1e-11  # slip [m/s]
    assert abs(found["lean.phi"]).max() > 0.05  # rad: a motion that is not small


def test_energy_of_the_weave_goes_into_forward_speed() -> None:
    """At 4.6 m/s the weave decays; its energy then is in straight riding, (94 + sum of J/r^2) v^2 / 2."""
    v, roll = 4.6, 0.5
    found = run(bicycle(v, {"lean": {"phi": 0.0, "w": roll, "fixed": True}}), np.linspace(0, 60, 61))
    mass = 94 + 0.12 / REAR_RADIUS**2 + 0.28 / FRONT_RADIUS**2
    about_the_ground_line = 80.81722  # kg m2, the benchmark's M[0, 0]
    final = np.sqrt(v**2 + about_the_ground_line * roll**2 / mass)
    assert_close(
        "speed", found["hub.w"][-1] * REAR_RADIUS, final, 1e-9, "energy to 1e-11; the rest of the weave"
    )
    assert final - v > 0.02


@pytest.mark.parametrize("v", [4.0, 4.6, 8.0])
def test_small_motions_follow_the_linear_theory(v: float) -> None:
    """2 s of weave and capsize after a roll rate of 1e-4 rad/s, against the benchmark's matrices."""
    small = 1e-4
    starts = {"lean": {"phi": 0.0, "w": small, "fixed": True}}
    found = run(bicycle(v, starts), np.linspace(0, 2, 21), tolerance=1e-12)
    expected = np.array([expm(linear_theory(v) * t) @ [0, 0, small, 0] for t in found.time]) / small
    ours = np.array([found[name] for name in LEAN_AND_STEER]).T * [1, -1, 1, -1] / small
    assert_close("motion", ours, expected, 1e-6, "terms of second order and the run's 1e-12, of 1e-4")


def test_steady_turn_is_found_from_its_lean() -> None:
    """Steer and speed of the rear wheel that hold the lean have the published digits."""
    turning = {
        "lean": {"phi": -0.3, "w": 0.0, "fixed": True},
        "steer": {"phi": 0.4, "w": 0.0, "fixed": True},
    }
    found = gelenk.equilibrium(
        bicycle(3.0, turning), steady={"hub.w": None}, hold={"lean.phi": np.pi / 2 - 1.9178291654}
    )
    assert_close("steer", found.values["steer.phi"], 0.4049333918, 2e-10, "10 decimals, of the lean, too")
    assert_close(
        "rear wheel", found.values["hub.w"], 10.3899258905, 5e-9, "10 decimals of the lean, times 20 1/s"
    )
    radius = found.values["base.v_x"] / found.values["base.w"]  # the heading is x at that moment
    assert_close("radius", radius, 2.2588798195, 2e-9, "10 decimals of the lean")


def test_shipped_scene_is_the_benchmark() -> None:
    ready = gelenk.load(Path(__file__).parents[3] / "scenes" / "bicycle.yaml")
    assert ready.to_dict()["joints"].keys() == bicycle()["joints"].keys()
    model = gelenk.linear.linear_model(ready, at={"lean.w": 0.0})
    assert apart(lean_and_steer(model), PUBLISHED[5]) < 1e-11  # 14 published digits


def test_lqr_at_the_handlebar_stabilizes_the_slow_bicycle(tmp_path: Path) -> None:
    """At 3 m/s it is unstable. An LQR of lean and steer stabilizes the nonlinear FMU after a roll rate."""
    ready = Path(__file__).parents[3] / "scenes" / "bicycle.yaml"
    fmu = gelenk.export_fmu(ready, tmp_path / "Bicycle.fmu")
    speed, step = 3.0 / REAR_RADIUS, 0.005
    plant = gelenk.linearize(
        fmu, at={"hub.w": speed, "lean.w": 0.0}, inputs=["handlebar.tau"], states=LEAN_AND_STEER
    )
    assert plant.poles().real.max() > 1.7
    sampled = plant.sample(step)
    K, _, _ = control.dlqr(sampled, np.diag([1.0, 1.0, 0.1, 0.1]), [[0.01]])
    reference = {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}

    def hold(_time: float, recorder: Any) -> bool:
        x = recorder.fmu.getReal([reference[name] for name in LEAN_AND_STEER])
        recorder.fmu.setReal([reference["handlebar.tau"]], [float(-K[0] @ x)])
        return True

    found = fmpy.simulate_fmu(
        str(fmu), stop_time=6.0, output_interval=step, output=LEAN_AND_STEER, step_finished=hold,
        start_values={"hub.w_start": speed, "lean.w_start": 0.2},
    )  # fmt: skip
    x = np.array([found[name] for name in LEAN_AND_STEER]).T
    assert abs(x[-1]).max() < 1e-6  # 0.4 exp(-2.86 * 6), and the oscillation
    # The slowest mode only: the ratio of its modal coordinate between steps.
    values, shapes = np.linalg.eig(sampled.A - sampled.B @ K)
    slowest = np.argmax(abs(values))
    late = (found["time"] > 1.5) & (found["time"] < 3.5)
    own = (x @ np.linalg.inv(shapes)[slowest])[late]
    seen = np.log(np.vdot(own[:-1], own[1:]) / np.vdot(own[:-1], own[:-1])) / step
    # The mode is determined from successive points of a decay.
    assert abs(seen - np.log(values[slowest]) / step) < 0.05 * abs(seen)
