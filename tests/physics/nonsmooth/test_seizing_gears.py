# SPDX-License-Identifier: BSD-3-Clause
"""A self-locking gear seizes where it would have to slow down its load: no deceleration agrees with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

RATIO, EFFICIENCY = 2.0, 0.4  # 1
WORM, COULOMB = 0.063, 0.5  # kg m2, N m
# Friction per force that the mesh exerts on the worm. With a load of this moment of inertia friction takes
# as much as the inertia of the worm: I0 = (losses - 1) I1 / ratio^2.
LOSSES = 1 / EFFICIENCY - 1
SEIZING = WORM * RATIO**2 / (LOSSES - 1)  # kg m2: 0.504
W = 2.0  # rad/s


def worm(load: float, w: float = W) -> Scene:
    """Two shafts with a gear; the first one has a motor."""

    def shaft(name: str, **laws: object) -> dict[str, object]:
        start = {"phi": 0.0, "w": w, "fixed": True} if name == "worm" else {"phi": 0.0}
        return joint(
            "revolute",
            frame("ground"),
            frame("a" if name == "worm" else "b"),
            axis=[1, 0, 0],
            start=start,
            **laws,
        )

    return scene(
        {"a": body(1.0, inertia=(WORM,) * 3), "b": body(1.0, inertia=(load,) * 3)},
        {"worm": shaft("worm", friction={"coulomb": COULOMB}), "wheel": shaft("wheel")},
        constraints={
            "mesh": {
                "type": "gear", "joint": "worm", "with": "wheel", "ratio": RATIO, "efficiency": EFFICIENCY,
            }
        },
        motors={"drive": {"joint": "worm"}, "brake": {"joint": "wheel"}},
    )  # fmt: skip


@pytest.mark.parametrize("w", [W, -W])
@pytest.mark.parametrize("integrator", ["auto", "cvode", "ida", "dirk"])
def test_a_gear_seizes_where_no_motion_agrees_with_its_friction(integrator: str, w: float) -> None:
    """Both shafts stop at once, and rest, held by friction."""
    plant = gelenk.Simulation({**worm(1.1 * SEIZING, w), "solver": {"integrator": integrator}})
    plant.initialize()
    plant.step_to(0.01)
    assert plant.events == [(0.0, "worm.phi sticks")]
    assert plant.output("worm.w") == pytest.approx(0, abs=1e-12)
    assert plant.output("wheel.w") == pytest.approx(0, abs=1e-12)
    assert plant.output("worm.phi") == pytest.approx(0, abs=1e-12)
    assert plant.output("worm.friction.mode") == 0


def test_below_that_load_it_decelerates() -> None:
    """(I0 - (losses - 1) I1 / ratio^2) a0 = -coulomb: the more, the nearer the load is to that of seizing."""
    for part in (0.0, 0.5, 0.9):
        load = max(part * SEIZING, 1e-9)
        plant = gelenk.Simulation(worm(load))
        plant.initialize()
        exact = -COULOMB / (WORM - (LOSSES - 1) * load / RATIO**2)
        assert plant.output("worm.a") == pytest.approx(exact, rel=1e-9)
        plant.step_to(0.01)
        assert plant.output("worm.w") == pytest.approx(max(0.0, W + 0.01 * exact), abs=1e-9)


def test_it_seizes_where_the_motor_ceases_to_drive_the_load() -> None:
    """Where the load would begin to drive: at tau = 3 - 20 t = coulomb, where a0 = 0."""
    plant = gelenk.Simulation(worm(1.1 * SEIZING, 0.0))
    plant.set_input("drive.tau", 3.0)
    plant.set_input_derivative("drive.tau", 1, -20.0)
    plant.initialize(tolerance=1e-9)
    plant.step_to(0.15)
    (time, text), *more = plant.events[1:] if "slips" in plant.events[0][1] else plant.events
    assert more == []
    assert text == "worm.phi sticks"
    assert time == pytest.approx((3.0 - COULOMB) / 20, abs=1e-9)
    assert plant.output("worm.w") == pytest.approx(0, abs=1e-12)
    # Until then: (I0 + (1 + losses) I1 / ratio^2) a0 = tau - coulomb.
    inertia = WORM + (1 + LOSSES) * 1.1 * SEIZING / RATIO**2
    exact = (2.5 * time**2 / 2 - 20 * time**3 / 6) / inertia
    assert plant.output("worm.phi") == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("w", [W, -W])
@pytest.mark.parametrize("integrator", ["auto", "erk", "rk4", "cvode", "ida", "dirk", "moreau-jean"])
def test_without_a_load_it_coasts(integrator: str, w: float) -> None:
    """Nothing is transmitted at a constant speed, and so there is no friction of the mesh."""
    of = worm(1.1 * SEIZING, w)
    of["joints"]["worm"]["friction"] = {"coulomb": 0.0}
    of["solver"] = {"integrator": integrator, "step": 1e-3}
    plant = gelenk.Simulation(of)
    plant.initialize()
    plant.step_to(0.5)
    assert plant.events == []
    assert plant.output("worm.w") == pytest.approx(w, abs=1e-12)
    assert plant.output("worm.phi") == pytest.approx(0.5 * w, abs=1e-12)


@pytest.mark.parametrize("slope", [1.0, -1.0])
@pytest.mark.parametrize("w", [W, -W])
@pytest.mark.parametrize("integrator", ["auto", "erk", "rk4", "cvode", "ida", "dirk", "moreau-jean"])
def test_a_load_that_rises_from_zero_has_the_sign_that_it_takes(
    integrator: str, w: float, slope: float
) -> None:
    """A motor whose torque rises from zero drives the gear on, or makes it seize and turns it back."""
    step, time = 1e-4, 0.1
    of = worm(1.1 * SEIZING, w)
    of["joints"]["worm"]["friction"] = {"coulomb": 0.0}
    of["solver"] = {"integrator": integrator, "step": step}
    plant = gelenk.Simulation(of)
    plant.initialize(tolerance=1e-9)
    plant.step_to(0.1)
    plant.set_input_derivative("drive.tau", 1, slope)
    plant.step_to(0.1 + time)
    inertia = WORM + (1 + LOSSES) * 1.1 * SEIZING / RATIO**2
    change = slope * time**2 / 2 / inertia
    # Time steps take the torque in the middle of a step, and stop at the end of one.
    most = time / inertia * step if integrator == "moreau-jean" else 1e-7
    assert plant.output("worm.w") == pytest.approx(change + (w if w * slope > 0 else 0), abs=most)


def test_a_gear_that_has_seized_is_driven_on() -> None:
    """A motor that overcomes its friction sets it in motion again."""
    plant = gelenk.Simulation(worm(1.1 * SEIZING))
    plant.initialize()
    plant.step_to(0.01)
    plant.set_input("drive.tau", 3.0)
    plant.step_to(0.02)
    inertia = WORM + (1 + LOSSES) * 1.1 * SEIZING / RATIO**2
    assert plant.output("worm.w") == pytest.approx(0.01 * (3.0 - COULOMB) / inertia, rel=1e-6)


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean"])
def test_the_impulse_of_a_stop_is_no_load(integrator: str) -> None:
    """A rotor on the wheel reaches its stop without restitution; friction of the gear exerts no impulse."""
    inner, rotor, speed = 0.09, 0.2, 3.0  # kg m2, kg m2, rad/s
    of = worm(inner, 0.0)
    of["bodies"]["rotor"] = body(1.0, inertia=(rotor,) * 3)
    of["joints"]["stopped"] = joint(
        "revolute", frame("b"), frame("rotor"), axis=[1, 0, 0],
        start={"phi": 0.0, "w": speed, "fixed": True}, limit={"upper": 0.1, "restitution": 0.0},
    )  # fmt: skip
    of["joints"]["worm"]["friction"] = {"coulomb": 0.0}
    of["solver"] = {"integrator": integrator, "step": 1e-5}
    plant = gelenk.Simulation(of)
    plant.initialize()
    plant.step_to(0.034)
    # What both have together; the worm turns RATIO times as fast.
    after = rotor * speed / (WORM * RATIO**2 + inner + rotor)
    assert plant.output("wheel.w") == pytest.approx(after, abs=1e-2 * after)
    assert plant.output("stopped.w") == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "dirk", "moreau-jean"])
@pytest.mark.parametrize("holds", ["friction", "limit"])
@pytest.mark.parametrize(("torque", "drive"), [(30.0, 1.0), (-30.0, 6.0)])
def test_a_worm_at_rest_bears_the_load_of_what_sets_out(
    torque: float, drive: float, holds: str, integrator: str
) -> None:
    """A spring drives a rotor on the wheel from its stop, or against friction: its torque is the load that
    holds the worm, although there would be none if the rotor remained at rest.
    """
    rotor, coulomb = 0.2, 0.3  # kg m2, N m
    of = worm(0.8, 0.0)
    of["bodies"]["rotor"] = body(1.0, inertia=(rotor,) * 3)
    bound = "lower" if torque > 0 else "upper"
    law = {"limit": {bound: 0.0}} if holds == "limit" else {"friction": {"coulomb": coulomb}}
    of["joints"]["free"] = joint(
        "revolute", frame("b"), frame("rotor"), axis=[1, 0, 0],
        start={"phi": 0.0, "w": 0.0, "fixed": True}, **law,
    )  # fmt: skip
    of["motors"]["spring"] = {"joint": "free"}
    of["solver"] = {"integrator": integrator, "step": 1e-3}
    plant = gelenk.Simulation(of)
    plant.set_input("spring.tau", torque)
    plant.set_input("drive.tau", drive)
    plant.initialize()
    plant.step_to(0.02)
    assert plant.output("worm.w") == pytest.approx(0, abs=1e-12)
    assert plant.output("wheel.w") == pytest.approx(0, abs=1e-12)
    assert plant.output("worm.friction.mode") == 0
    driving = torque - (math.copysign(coulomb, torque) if holds == "friction" else 0)
    assert plant.output("free.w") == pytest.approx(driving / rotor * 0.02, rel=1e-6)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida", "moreau-jean"])
def test_it_seizes_together_with_a_limit_that_is_met(integrator: str, friction: float, side: int) -> None:
    """No motion was found after the impact: the rotor left its bound and met it again without end.

    A rotor of 0.2 kg m2 on the wheel meets its bound at 1 rad/s, and turns all. A motor turns it back with
    1 N m, and the wheel on; this load brakes the wheel of 0.4 kg m2 with 1 N m / (SEIZING - 0.4 kg m2) =
    9.6 rad/s2, but the rotor with 5 rad/s2, so that it remains at the bound, where no force holds it. Wheel
    and rotor together are more than SEIZING: worm, wheel and rotor stop at once, and the rotor goes back.
    """
    rotor, distance, back = 0.2, 1e-3, 1.0
    of = worm(0.4, 0.0)
    of["joints"]["worm"]["friction"] = {"coulomb": 0.0}
    of["bodies"]["c"] = body(1.0, inertia=(rotor,) * 3)
    bounds = {"upper": distance, "lower": -1.0} if side > 0 else {"upper": 1.0, "lower": -distance}
    of["joints"]["rotor"] = joint(
        "revolute", frame("b"), frame("c"), axis=[1, 0, 0],
        friction={"coulomb": friction}, limit=bounds | {"restitution": 0.0},
        start={"phi": 0.0, "w": side * 1.0, "fixed": True},
    )  # fmt: skip
    of["motors"]["back"] = {"joint": "rotor"}
    step = 1e-5
    of["solver"] = {"integrator": integrator, "step": step, "max_evaluations": 100_000}
    plant = gelenk.Simulation(of)
    plant.set_input("back.tau", -side * back)
    plant.initialize(tolerance=1e-9)
    deceleration = (back + friction) / rotor
    meets = distance * (1 + distance * deceleration / 2)  # s, to the second order
    plant.step_to(0.02)
    assert plant.output("worm.w") == pytest.approx(0, abs=1e-12)
    # rad/s: an error of the time of the impact; time steps notice it at the end of one, and stop in the next
    most = 2.1 * step * back / rotor if integrator == "moreau-jean" else 1e-6 * deceleration
    assert plant.output("rotor.w") == pytest.approx(
        -side * (back - friction) / rotor * (0.02 - meets), abs=most
    )


# Of 1 kg m2 and less, driven on both sides, in motion or at rest: many seize, or could rest as well as move.
DRIVES = 150


@pytest.mark.parametrize("w", [-2.0, 0.0, 5.0])
def test_steps_find_the_motion_that_events_find(w: float) -> None:
    """Where friction depends so much on its load that several motions agree, both schemes take the same."""
    rng = np.random.default_rng(7)
    seized = 0
    for k in range(DRIVES):
        I0, I1 = 10 ** rng.uniform(-2, 0, 2)
        mesh = {
            "type": "gear", "joint": "worm", "with": "wheel",
            "ratio": float(rng.choice([-2.0, 0.5, 1.0, 3.0])), "efficiency": float(rng.uniform(0.15, 0.95)),
        }  # fmt: skip
        if rng.random() < 0.4:
            mesh["backdriving"] = float(rng.uniform(-2, 0.9))
        of = worm(I1, w)
        of["bodies"]["a"]["inertia"] = [I0, I0, I0]
        of["constraints"]["mesh"] = mesh
        drive, brake = (float(tau) for tau in rng.uniform(-10, 10, 2))
        after = {}
        for integrator in ("auto", "moreau-jean"):
            plant = gelenk.Simulation(of | {"solver": {"integrator": integrator, "step": 1e-4}})
            plant.set_input("drive.tau", drive)
            plant.set_input("brake.tau", brake)
            plant.initialize()
            plant.step_to(0.002)
            after[integrator] = plant.output("worm.w")
        exact = after["auto"]
        seized += w != 0 and exact * w <= 0
        # What stops within a step moves on at its end.
        most = 1e-4 * abs(drive) / I0 + 1e-9 if w != 0 and exact * w <= 0 else 1e-9 * (1 + abs(exact - w))
        assert after["moreau-jean"] == pytest.approx(exact, abs=most), (
            f"{k}: {I0}, {I1}, {mesh}, {drive}, {brake}"
        )
    assert w == 0 or seized > DRIVES / 20
