# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates with friction that reverse at a dead center, at which their speeds say nothing of the motion.

To stop a speed of 1e-12 there, at a lever of 1e-12, would stop the mechanism.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, four_bar, frame, joint, scene

import gelenk

INTEGRATORS = ("erk", "dirk", "cvode", "ida", "moreau-jean")
TOLERANCES = [float(f"{10**-x:.5g}") for x in np.linspace(6, 9.5, 150)]

# A body on a planar joint, which a one-way clutch holds in one direction, and a rod on a universal joint.
ROD: Scene = json.loads((Path(__file__).parent / "rod_at_a_dead_center.json").read_text())
DRIVES: dict[str, Any] = {
    "d_s_x.f": lambda t: 0.3550950030210563 * math.sin(4 * t + 0.6939622423185381),
    "d_s_y.f": lambda t: 1.9341070192456866 * math.sin(4 * t + 3.369012162430277),
    "d_phi.tau": lambda t: 1.4604393040122348 * math.sin(4 * t + 5.443530757540757),
}


def speed_of_the_rod(integrator: str, tolerance: float, **solver: float) -> float:
    """Return J.w [rad/s] after both coordinates of the universal joint have reversed together."""
    source = {**ROD, "solver": {"integrator": integrator, **solver}}
    result = gelenk.simulate(source, stop=0.22, step=0.002, tolerance=tolerance, inputs=DRIVES)
    assert not result.warnings
    return float(result["J.w"][-1])


def test_a_rod_passes_its_dead_center_at_every_tolerance() -> None:
    """Where the located speeds of both coordinates are by chance on the wrong side of zero, too."""
    exact = speed_of_the_rod("dirk", 1e-10)
    found = np.array([speed_of_the_rod("erk", tolerance) for tolerance in TOLERANCES])
    assert exact == pytest.approx(-7.416, abs=1e-3)
    assert np.abs(found - exact).max() < 1e-4  # rad/s, at a tolerance of 1e-6


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-7, 8.7691e-8, 1e-9])
def test_a_rod_passes_its_dead_center_with_every_integrator(integrator: str, tolerance: float) -> None:
    step = {"step": 1e-5} if integrator == "moreau-jean" else {}
    assert speed_of_the_rod(integrator, tolerance, **step) == pytest.approx(-7.416, abs=2e-3)


CRANK, RODS, COULOMB = 0.1, (0.3, 0.27), (0.05, 0.1)  # m, m, N
PHI, W = 0.7, -7.0  # rad, rad/s
PUSH = 200.0  # N


def boxer(tilt: float, is_held: bool, w: float = W, phi: float = PHI) -> Scene:
    """Two opposed sliders with friction, which reverse at the same dead centers of one crank.

    The crank turns on a carriage that a one-way clutch holds, or that rests on the ground.
    """
    along = [math.cos(tilt), math.sin(tilt), 0.0]
    fixed = {"fixed": True}
    held: dict[str, Any] = {"one_way": {"free": "negative"}} if is_held else {"friction": {"coulomb": 1e4}}
    joints = {
        "Y": joint("prismatic", frame("ground"), frame("carriage"), axis=along,
                   start={"s": 0.0, "v": 0.0, **fixed}, **held),
        "A": joint("revolute", frame("carriage"), frame("crank"), axis=[0, 0, 1],
                   start={"phi": phi + tilt, "w": w, **fixed}),
    }  # fmt: skip
    bodies = {"carriage": body(1.0), "crank": body(0.5, inertia=(0, 0, 0.05))}
    for k, (side, length, coulomb) in enumerate(zip((1, -1), RODS, COULOMB, strict=True)):
        bodies |= {f"rod{k}": body(0.2, (length / 2, 0, 0), (0, 0.01, 0.01)), f"slider{k}": body(0.3)}
        leans = side * math.asin(CRANK * math.sin(phi) / length)
        turned = (0 if side > 0 else math.pi) - leans - phi
        at = CRANK * math.cos(phi) + side * length * math.cos(leans)
        joints |= {
            f"B{k}": joint("revolute", frame("crank", (CRANK, 0, 0)), frame(f"rod{k}"), axis=[0, 0, 1],
                           start={"phi": turned}),
            f"S{k}": joint("prismatic", frame("ground"), frame(f"slider{k}"), axis=along,
                           friction={"coulomb": coulomb}, start={"s": at}),
            f"C{k}": joint("revolute", frame(f"rod{k}", (length, 0, 0)), frame(f"slider{k}"), axis=[0, 0, 1]),
        }  # fmt: skip
    source = scene(bodies, joints, motors={"push": {"joint": "Y"}})
    return {**source, "sensors": {"e": {"type": "energy"}}}


def travels(phi: float) -> list[float]:
    """Return how far both sliders have gone [m], from PHI to a crank angle [rad]."""
    ends = np.arange(math.floor(phi / math.pi), math.ceil(PHI / math.pi) + 1) * math.pi
    angles = np.array([phi, *ends[(ends > phi) & (ends < PHI)], PHI])
    out = []
    for side, length in zip((1, -1), RODS, strict=True):
        across = CRANK * np.sin(angles)
        s = CRANK * np.cos(angles) + side * np.sqrt(length**2 - across**2)
        out.append(float(np.abs(np.diff(s)).sum()))
    return out


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("is_held", [True, False])
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_sliders_lose_the_work_of_friction_alone(tilt: float, is_held: bool, integrator: str) -> None:
    """Closed form, without gravity: the kinetic energy that is left, past three dead centers."""
    solver: dict[str, Any] = {"integrator": integrator}
    if integrator == "moreau-jean":
        solver["step"] = 1e-4
    source = {**boxer(tilt, is_held), "solver": solver}
    for tolerance in TOLERANCES[::30]:
        result = gelenk.simulate(
            source, stop=1.2, step=0.05, tolerance=tolerance, inputs={"push.f": lambda _: PUSH}
        )
        energy = result["e.kinetic"]
        phi = float(result["A.phi"][-1]) - tilt
        assert phi < -2 * math.pi
        lost = sum(c * way for c, way in zip(COULOMB, travels(phi), strict=True))
        accuracy = 1e-4 if integrator == "moreau-jean" else 1e-4 * (tolerance / 1e-6) ** 0.5  # J
        assert energy[0] - energy[-1] == pytest.approx(lost, abs=accuracy)


@pytest.mark.parametrize("is_held", [True, False])
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1e-4, 2e-3])
def test_what_rests_beside_a_dead_center_rests_exactly(angle: float, is_held: bool) -> None:
    """Friction with a small lever, or none, holds what has no load."""
    source = boxer(0.0, is_held, 0.0, angle)
    result = gelenk.simulate(source, stop=1.0, step=0.1)
    for name in ("A.w", "S0.v", "S1.v"):
        assert np.all(result[name] == 0)
    assert np.ptp(result["A.phi"]) == 0


@pytest.mark.parametrize("w", [1e-3, 1.0])
def test_what_moves_through_a_dead_center_keeps_its_motion(w: float) -> None:
    """From the dead center: friction of what has no lever does not stop it there."""
    source = boxer(0.0, is_held=True, w=w, phi=0.0)
    result = gelenk.simulate(source, stop=1e-3, step=1e-4, tolerance=1e-10, inputs={"push.f": lambda _: PUSH})
    assert result["A.w"][1] == pytest.approx(w, rel=1e-3)


def rocking(w: float, coulomb: float, **solver: Any) -> Scene:
    """A four-bar with friction in its rocker, and a ball that touches the ground without a force."""
    source = four_bar()
    del source["joints"]["A"]["damping"]
    source["joints"]["A"]["start"]["w"] = w
    source["joints"]["D"]["friction"] = {"coulomb": coulomb}
    start = {"s": 0.1, "v": 0.0, "fixed": True}
    return {
        **source,
        "gravity": [0, 0, 0],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "bodies": {
            **source["bodies"],
            "puck": {"mass": 1.0, "shapes": {"tread": {"sphere": 0.1, "surface": "ball"}}},
        },
        "joints": {
            **source["joints"],
            "Z": joint("prismatic", frame("ground"), frame("puck"), axis=[0, 0, 1], start=start),
        },
        "contacts": {"rest": {"between": ["ball", "floor"]}},
        "sensors": {"e": {"type": "energy"}},
        "solver": solver,
    }


def reversed_at(reach: float) -> float:
    """D.phi [rad] where crank and coupler are in line, with this distance [m] between their ends."""
    ground, rocker = 2.0, 1.5
    return math.pi - math.acos((ground**2 + rocker**2 - reach**2) / (2 * ground * rocker))


@pytest.mark.parametrize("integrator", ["erk", "dirk", "cvode", "ida"])
@pytest.mark.parametrize("islands", [True, False])
@pytest.mark.parametrize(("w", "coulomb"), [(2.0, 1e-4), (10.0, 1e-4), (10.0, 0.1), (50.0, 1.0)])
def test_a_contact_elsewhere_does_not_hold_what_reverses(
    w: float, coulomb: float, islands: bool, integrator: str
) -> None:
    """Closed form: the work of friction on the way of the rocker, past eight reversals.

    There, friction changes the acceleration by less than the tolerance of a decision on all that touches and
    sticks in one island: the joint was taken for at rest, although it is accelerated, and the linkage
    stopped.
    """
    source = rocking(w, coulomb, integrator=integrator, reductions={"islands": islands})
    result = gelenk.simulate(source, stop=45 / w, step=0.02 / w, tolerance=1e-9)
    phi, speed = result["D.phi"], result["D.w"]
    reversals = np.flatnonzero(speed[1:] * speed[:-1] < 0)
    assert len(reversals) >= 8
    ends = sorted(map(reversed_at, (1.75 - 0.5, 1.75 + 0.5)))
    turns = [ends[1] if speed[k] > 0 else ends[0] for k in reversals]
    way = np.abs(np.diff([phi[0], *turns, phi[-1]])).sum()
    energy = result["e.kinetic"]
    # J: a multiple of the tolerance, of all that moves
    assert energy[0] - energy[-1] == pytest.approx(coulomb * way, abs=1e-6 * energy[0])
