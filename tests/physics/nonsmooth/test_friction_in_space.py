# SPDX-License-Identifier: BSD-3-Clause
"""Loops in space with friction or limits in all joints: a body is split where the loop has to be opened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene
from models import rounded
from models.running import assert_close
from samples import thorough_beyond

import gelenk

from .test_joint_friction import (
    FOUR_BAR_PHI,
    FOUR_BAR_REVERSALS,
    FOUR_BAR_TIMES,
    FOUR_BAR_W,
    four_bar_with_friction,
    plant,
    read,
)

# Loops that move in space only because of their dimensions, and some that move in a plane or on a sphere.
LOOPS = ("bennett", "goldberg", "line_symmetric_bricard", "spherical_four_bar", "sarrus", "slider_crank")


def in_space(source: Scene) -> gelenk.Simulation:
    """The plane is not made use of."""
    simulation = gelenk.Simulation(gelenk.load(source).without(["planar"]))
    simulation.initialize(0.0, 1e-8)
    return simulation


def test_the_published_four_bar_in_space() -> None:
    """With friction in all joints and six constraint equations at the body that is split."""
    simulation = in_space(four_bar_with_friction())
    found = []
    for t in FOUR_BAR_TIMES:
        simulation.step_to(t)
        found.append((read(simulation, "A.phi"), read(simulation, "A.w")))
    phi, w = np.array(found).T
    assert_close("A.phi", phi, FOUR_BAR_PHI, 300e-8, "as in the plane")
    assert_close("A.w", w, FOUR_BAR_W, 2000e-8, "as in the plane")
    assert simulation.diagnostic("solver.events") == FOUR_BAR_REVERSALS


def test_reactions_and_poses_of_the_four_bar_in_space() -> None:
    """As in the plane, where another joint is cut; reactions of joints on both halves of the split body."""
    source = four_bar_with_friction()
    source["sensors"] = {
        f"tip_{name}": {"type": "frame", "body": name, "position": [0.3, 0.1, 0.2]}
        for name in ("crank", "coupler", "rocker")
    } | {"E": {"type": "energy"}}
    plane = plant(source)
    source["sensors"] |= {f"R{name}": {"type": "reaction", "joint": name} for name in "ABCD"}
    space = plant(source)
    for simulation in (plane, space):
        simulation.step_to(0.35)
    names = [signal.name for signal in plane.outputs]
    assert_close(
        "outputs", space.values(names), plane.values(names), 3e-6, "100 tolerances, of forces to 200 N"
    )
    # Newton's law for each moving body, with the accelerations of its center of mass by differences.
    for name in "ABCD":  # their axes are -y of F
        assert_close(f"{name}: force along its axis", read(space, f"R{name}.f[2]"), 0.0, 1e-9, "rounding")
        friction = read(space, f"{name}.friction.tau")
        assert_close(
            f"{name}: torque about its axis", -read(space, f"R{name}.t[2]"), friction, 1e-9, "rounding"
        )


@pytest.mark.parametrize("name", thorough_beyond(LOOPS, {*LOOPS} - {"bennett", "goldberg"}))
def test_power_of_friction_in_spatial_loops(name: str) -> None:
    """The rate of the energy is the power of friction, and the loop comes to rest, exactly."""
    placed = rounded.MECHANISMS[name]() if name in rounded.MECHANISMS else getattr(rounded, name)()
    fields: dict[str, Any] = {joint: {"friction": {"coulomb": 0.6}} for joint, *_ in placed}
    first = placed[0][0]
    fields[first]["start"] = {"phi": 0.0, "w": 3.0, "fixed": True}
    source = rounded.scene(placed, fields=fields)
    source["gravity"] = [0, 0, 0]
    simulation = plant(source, tolerance=1e-11)
    kinds = {joint: ("v", "f") if kind == "prismatic" else ("w", "tau") for joint, kind, *_ in placed}
    h, energy, power = 2e-4, {}, 0.0
    for k in (-1, 0, 1):
        simulation.step_to(0.02 + k * h)
        energy[k] = simulation.diagnostic("energy.total")
        if k == 0:
            power = sum(
                read(simulation, f"{j}.friction.{tau}") * read(simulation, f"{j}.{w}")
                for j, (w, tau) in kinds.items()
            )
    assert power < -1
    # Central difference: h^2 / 6 times the third derivative, 1e5 J/s^3 at most here.
    assert_close("power", (energy[1] - energy[-1]) / (2 * h), power, 1e-3, "h^2 / 6 times 1e5")
    simulation.step_to(20.0)
    assert all(read(simulation, f"{j}.{w}") == 0 for j, (w, _) in kinds.items())
    assert simulation.diagnostic("constraints.position") < 1e-10


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_limits_in_all_joints_of_a_spatial_loop(restitution: float) -> None:
    """Thrown back and forth between limits; without losses the energy stays."""
    placed = rounded.bennett()
    limit = {"lower": -0.2, "upper": 0.2, "restitution": restitution}
    fields: dict[str, Any] = {joint: {"limit": limit} for joint, *_ in placed}
    fields[placed[0][0]]["start"] = {"phi": 0.0, "w": 2.0, "fixed": True}
    source = rounded.scene(placed, fields=fields)
    source["gravity"] = [0, 0, 0]
    simulation = plant(source, tolerance=1e-10)
    energy = [simulation.diagnostic("energy.kinetic")]
    instants = set()  # opposite joints turn by the same angle, so that their limits are struck together
    for k in range(20):
        simulation.step_to(0.05 * (k + 1))
        energy.append(simulation.diagnostic("energy.kinetic"))
        instants |= {round(time, 6) for time, text in simulation.events if "meets" in text}
        assert max(abs(read(simulation, f"{joint}.phi")) for joint, *_ in placed) <= 0.2 + 1e-9
    assert instants
    if restitution == 1.0:
        assert_close("energy", energy, energy[0], 1e-7 * energy[0], "1000 tolerances over some ten impacts")
    else:
        # Newton's law for one degree of freedom.
        left = energy[0] * restitution ** (2 * len(instants))
        assert_close("energy", energy[-1], left, 1e-7 * energy[0], "the same")


def test_planar_loop_with_friction_in_all_joints_becomes_an_fmu(tmp_path: Path) -> None:
    source = four_bar_with_friction()
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "FourBar.fmu")
    result = gelenk.simulate(fmu, stop=0.5, step=0.05, tolerance=1e-8)
    assert_close("A.phi", result["A.phi"][-1], FOUR_BAR_PHI[0], 300e-8, "as for the scene")
    assert "loops are cut at" in str(gelenk.inspect(gelenk.load(source)))


def test_motor_with_inertia_in_a_loop_in_space_with_friction_elsewhere() -> None:
    """Its joint stays in the tree; as in the plane, where no body is split."""
    source = four_bar_with_friction()
    del source["joints"]["C"]["friction"]
    source["motors"] = {"drive": {"joint": "C", "rotor_inertia": 0.01}}
    plane = plant(source)
    space = in_space(source)
    for simulation in (plane, space):
        simulation.step_to(0.35)
    for name in ("A.phi", "C.w", "B.friction.tau"):
        assert_close(name, read(space, name), read(plane, name), 3e-6, "100 tolerances, of some N m")
