# SPDX-License-Identifier: BSD-3-Clause
"""The motion of a four-bar compared with its equation of motion in one independent coordinate.

Crank 0.5 m, coupler 1.75 m, rocker 1.5 m, ground 2 m, uniform rods of 2 kg/m, 3 N m on the crank, crank
damping 0.1 N m s/rad, 5 s. The reference equation (models/one_dof.py) is integrated by SciPy's DOP853 at
1e-12.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, four_bar, frame_sensor, with_sensors
from models.one_dof import OneDofMechanism
from models.planar_loops import FourBar, uniform
from models.running import INTEGRATORS, Recording, assert_close, run

pytestmark = warned.TIGHT

TIMES = np.linspace(0, 5, 501)
START = 1.1  # rad, a pose without symmetry
LINKS = FourBar(uniform(2, 0.5), uniform(2, 1.75), uniform(2, 1.5), 2.0)
# A mechanism that oscillates under gravity like a pendulum, and one that makes full turns without gravity.
GRAVITIES = {"hanging": (0.0, -GRAVITY, 0.0), "turning": (0.0, 0.0, 0.0)}


@functools.cache
def truth_of(name: str) -> dict[str, np.ndarray]:
    motion = OneDofMechanism(LINKS.geometry(), GRAVITIES[name], lambda _t, _phi, w: 3 - 0.1 * w)
    phi, w = motion.motion(START, 0, TIMES)
    states = LINKS.joint_states(phi, w)
    states["energy"] = np.array([motion.energy(x, v) for x, v in zip(phi, w, strict=True)])
    return states


@pytest.fixture(scope="module", params=[(g, i) for g in GRAVITIES for i in INTEGRATORS], ids="-".join)
def case(request: pytest.FixtureRequest) -> tuple[Recording, dict[str, np.ndarray]]:
    name, integrator = request.param
    scene = with_sensors(
        four_bar(START, gravity=GRAVITIES[name]),
        on_coupler=frame_sensor("coupler", (1.75, 0, 0)),
        on_rocker=frame_sensor("rocker", (1.5, 0, 0)),
        E={"type": "energy"},
    )
    found = run(scene, TIMES, tolerance=1e-10, integrator=integrator, inputs={"drive.tau": 3.0})
    return found, truth_of(name)


def test_reference_satisfies_energy_balance() -> None:
    """Checks the reference: the work of motor and damper equals the increase in
    energy, dE/dt = (3 - 0.1 w) w.
    """
    for name, gravity in GRAVITIES.items():
        truth = truth_of(name)
        w = truth["A.w"]
        power = 3 * w - 0.1 * w**2
        # Simpson's rule on 501 points of a smooth curve: error h^4 w'''' dt, about 1e-5 J of 300 J
        work = sum((TIMES[2] / 6) * (power[i] + 4 * power[i + 1] + power[i + 2]) for i in range(0, 500, 2))
        gain = truth["energy"][-1] - truth["energy"][0]
        assert_close(f"energy {gravity}", gain, work, 1e-4 * max(1.0, abs(work)), "Simpson's rule")


def test_joint_angles_match_one_coordinate_solution(case) -> None:
    """To 1e-7 rad at tolerance 1e-10. The reference is accurate to 1e-9; a wrong bias term gives 1e-1."""
    found, truth = case
    for joint in "ABCD":
        assert_close(f"{joint}.phi", found[f"{joint}.phi"], truth[f"{joint}.phi"], 1e-7, "1000 x rtol, 5 s")


def test_joint_speeds_match_one_coordinate_solution(case) -> None:
    """Joint speeds reach 40 rad/s where the angle error is 1e-7:
    accelerations of about 100 rad/s2 allow 1e-5.
    """
    found, truth = case
    for joint in "ABCD":
        assert_close(f"{joint}.w", found[f"{joint}.w"], truth[f"{joint}.w"], 1e-6, "10 x angles")


def test_reported_closure_errors_are_small(case) -> None:
    """The reported closure error is below 1e-10 m and its rate below 1e-9 m/s, at every output."""
    found, _ = case
    assert_close("constraints.position", found["constraints.position"], 0, 1e-10, "projection")
    assert_close("constraints.velocity", found["constraints.velocity"], 0, 1e-9, "projection")


def test_loop_is_closed_in_world_coordinates(case) -> None:
    """In world coordinates, the ends of coupler and rocker coincide at every output."""
    found, _ = case
    gap = found.vector("on_coupler.r") - found.vector("on_rocker.r")
    rate = found.vector("on_coupler.v") - found.vector("on_rocker.v")
    assert_close("gap", np.linalg.norm(gap, axis=1), 0, 1e-10, "projection, m")
    assert_close("rate of the gap", np.linalg.norm(rate, axis=1), 0, 1e-9, "projection, m/s")


def test_energy_matches_reference(case) -> None:
    """T + V of the sensor and of the reference, which have the same zero height; 500 J to 1e-5 J."""
    found, truth = case
    assert_close("energy", found["E.total"], truth["energy"], 1e-5, "100 J/rad x 1e-7 rad")


def test_accelerations_are_derivatives_of_the_speeds() -> None:
    """A.a is the central difference of A.w over 1 ms: h^2 w'''/6 < 1e-4 for w''' below 600 rad/s4."""
    times = np.arange(0, 0.3, 1e-3)
    found = run(four_bar(START), times, inputs={"drive.tau": 3.0})
    for joint in "ABCD":
        quotient = (found[f"{joint}.w"][2:] - found[f"{joint}.w"][:-2]) / 2e-3
        assert_close(f"{joint}.a", found[f"{joint}.a"][1:-1], quotient, 1e-3, "h^2 w'''/6")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_error_follows_the_tolerance(integrator: str) -> None:
    """The error is proportional to the tolerance:
    from 1e-6 to 1e-9 it decreases by at least a factor of 30.
    """
    times = TIMES[::50]
    truth = truth_of("hanging")["A.phi"][::50]
    errors = []
    for tolerance in (1e-6, 1e-9):
        found = run(
            four_bar(START), times, tolerance=tolerance, integrator=integrator, inputs={"drive.tau": 3.0}
        )
        errors.append(float(np.abs(found["A.phi"] - truth).max()))
    assert errors[1] < errors[0] / 30, f"errors {errors} rad"


def test_rk4_is_of_fourth_order() -> None:
    """error(h) / error(h/2) = 2^4 within 10 % over 0.5 s of smooth motion."""
    times = np.array([0, 0.5])
    motion = OneDofMechanism(LINKS.geometry(), GRAVITIES["hanging"], lambda _t, _phi, w: 3 - 0.1 * w)
    truth = motion.motion(START, 0, times, rtol=1e-13)[0][-1]
    errors = []
    for h in (1 / 64, 1 / 128):
        found = run(four_bar(START), times, integrator="rk4", step=h, inputs={"drive.tau": 3.0})
        errors.append(abs(found["A.phi"][-1] - truth))
    assert math.isclose(errors[0] / errors[1], 16, rel_tol=0.1), f"errors {errors} rad"
