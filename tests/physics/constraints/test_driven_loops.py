# SPDX-License-Identifier: BSD-3-Clause
"""Loops with prescribed motions: a crank-driven four-bar, the car axis of the Test Set for IVP Solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, reaction, scene
from models.driven import Array, Law, polynomial, run, sine
from models.modelica import G_N, fourbar1
from models.one_dof import Jet, OneDofMechanism
from models.planar_loops import FourBar, uniform
from models.running import assert_close
from models.spatial_loops import ModelicaFourbar1

import gelenk

LENGTHS = (0.5, 1.75, 1.5, 2.0)
LINKS = FourBar(uniform(2, 0.5), uniform(2, 1.75), uniform(2, 1.5), 2.0)
MOTION = OneDofMechanism(LINKS.geometry(), (0.0, -GRAVITY, 0.0))
DAMPING, START = 0.1, 1.1
TIMES: Array = np.linspace(0, 2, 41)


def driven(name: str = "A", **motion: Any) -> Scene:
    out = four_bar(START, LENGTHS, damping=DAMPING)
    del out["motors"]
    out["joints"]["A"]["start"] = {"phi": START}
    out["constraints"] = {"drive": {"type": "motion", "joint": name, **motion}}
    out["sensors"] = {f"in_{j}": reaction(j) for j in "ABCD"} | {"meter": {"type": "energy"}}
    return out


def kinematics(phi: float, w: float, a: float) -> dict[str, float]:
    """Angles, velocities and accelerations of the joints, by triangle geometry and its derivatives."""
    theta, psi = LINKS.angles(Jet(phi, 1.0))
    relative = {"A": Jet(phi, 1.0), "B": theta - Jet(phi, 1.0), "C": psi - theta, "D": psi}
    out: dict[str, float] = {}
    for name, angle in relative.items():
        out |= {f"{name}.phi": angle.x, f"{name}.w": angle.d * w, f"{name}.a": angle.dd * w * w + angle.d * a}
    return out


def torque(phi: float, w: float, a: float) -> float:
    """The drive torque by virtual work: the residual of the equation of motion of phi."""
    inertia = sum(moving.reduced()[0] for moving in MOTION.geometry(Jet(phi, 1.0)))
    return inertia * (a - MOTION.acceleration(0, phi, w)) + DAMPING * w


def check(found: dict[str, Array], law: Law, bound: float) -> None:
    for i, t in enumerate(TIMES):
        phi, w, a = law(float(t))[:3]
        for name, value in kinematics(phi, w, a).items():
            turn = 2 * math.pi if name.endswith("phi") else 0.0
            seen = found[name][i]
            seen -= turn * round((seen - value) / turn) if turn else 0.0
            assert_close(f"{name} at {t}", seen, value, bound, "closed form; 1e-10 is asked for")
        assert_close(f"torque at {t}", found["drive.tau"][i], torque(phi, w, a), 1e-9, "of 100 N m")


@pytest.mark.parametrize("integrator", ["erk", "rk4"])
def test_crank_at_constant_speed_follows_the_closed_form(integrator: str) -> None:
    """No degree of freedom is left to integrate: steps of any method end at the closed form."""
    source = driven(speed=7.0)
    source["joints"]["A"]["start"] = {"phi": START, "fixed": ["phi"]}
    source["solver"] = {"integrator": integrator, **({"step": 0.01} if integrator == "rk4" else {})}
    check(run(source, TIMES, 1e-8), polynomial([START, 7.0]), 1e-10)


def test_crank_with_deceleration_and_oscillation_follows_the_closed_form() -> None:
    motion: dict[str, Any] = {"polynomial": [START, 5.0, -1.0], "sine": {"amplitude": 0.2, "frequency": 1.5}}

    def law(t: float) -> list[float]:
        parts = zip(polynomial([START, 5.0, -1.0])(t), sine(0.2, 1.5)(t), strict=True)
        return [a + b for a, b in parts]

    check(run(driven(**motion), TIMES, 1e-8), law, 1e-10)


def by_crank(name: str) -> Callable[[float], float]:
    return lambda phi: kinematics(phi, 0.0, 0.0)[f"{name}.phi"]


@pytest.mark.parametrize("name", ["B", "C", "D"])
def test_motion_can_be_prescribed_at_any_joint_of_the_loop(name: str) -> None:
    """The rocker's angle or a relative angle is prescribed: the mechanism moves as if the crank were driven.

    The torque differs, the power does not: tau w of that joint is tau w of the crank.
    """
    mean = by_crank(name)(START)
    rate = {"B": 0.6, "C": -0.4, "D": 0.5}[name]
    source = driven(name, polynomial=[mean, rate, -0.3 * rate])
    times = np.linspace(0, 0.5, 11)
    found = run(source, times, 1e-8)
    for i, t in enumerate(times):
        phi, w, a = (found[f"A.{q}"][i] for q in ("phi", "w", "a"))
        for key, value in kinematics(phi, w, a).items():
            assert_close(f"{key} at {t}", found[key][i], value, 1e-10, "closed form")
        given = polynomial([mean, rate, -0.3 * rate])(float(t))[:3]
        assert_close("motion", [found[f"{name}.{q}"][i] for q in ("phi", "w", "a")], given, 1e-10, "given")
        power = found["drive.tau"][i] * given[1]
        assert_close(f"power at {t}", power, torque(phi, w, a) * w, 1e-9, "of 20 W")


def test_reactions_balance_weight_and_inertia() -> None:
    """The ground's forces on the linkage add up to sum m (r'' - g), with the paths of the centers of mass."""
    source = driven(speed=7.0)
    source["joints"]["A"]["start"] = {"phi": START, "fixed": ["phi"]}
    found = run(source, TIMES, 1e-8)
    for i, t in enumerate(TIMES):
        needed = np.zeros(2)
        for moving in LINKS.geometry()(Jet(START + 7.0 * float(t), 1.0)):
            needed += moving.mass * np.array([c.dd * 49.0 for c in moving.com[:2]])
            needed[1] += moving.mass * GRAVITY
        seen = [found[f"in_A.f[{k}]"][i] + found[f"in_D.f[{k}]"][i] for k in (1, 2)]
        assert_close(f"forces at {t}", seen, needed, 1e-9, "of 100 N")
        # The sensor measures all torques between the bodies about the axis: drive and damper.
        assert_close(
            "torque", found["in_A.t[3]"][i], found["drive.tau"][i] - DAMPING * 7.0, 1e-10, "of 50 N m"
        )


# The car axis (Test Set for IVP Solvers, release 2.4): a massless bar of length 1 between two point masses
# eps^2 M / 2 on springs; the base has a hinge at its left end, and its right end rises by r sin(omega t).
POINT, LENGTH, UNSTRETCHED, RISE, OMEGA = 0.01**2 * 10 / 2, 1.0, 0.5, 0.1, 10.0
AT_3 = [
    0.04934557842754028, 0.49698946023017115, 1.0417425248854215, 0.37391102726536124,
    -0.07705836840409723, 0.007446866587237785, 0.017556815753723223, 0.7703410437792519,
]  # fmt: skip
ALONG_BASE, ALONG_BAR = -0.004736886590848933, -0.0011046803312573436  # multipliers


def car_axis() -> Scene:
    """The car axis; its base is a bar, hinged at the left, whose right end is moved by a cross slide."""
    about_z: dict[str, Any] = {"axis": [0, 0, 1]}

    def spring(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
        return {"type": "spring_damper", "from": below, "to": above, "stiffness": 1.0, "length": UNSTRETCHED}

    return scene(
        {
            "lift": body(0.1),
            "base": body(0.1, (0.5, 0, 0), (0.01, 0.01, 0.01)),
            "left": body(POINT),
            "right": body(POINT, (LENGTH, 0, 0)),
            "block": body(0.1, (0, 0, 0), (0.01, 0.01, 0.01)),
        },
        {
            "rise": joint("prismatic", frame("ground", (LENGTH, 0, 0)), frame("lift"), axis=[0, 1, 0]),
            "cross": joint("prismatic", frame("lift"), frame("block"), axis=[1, 0, 0]),
            "hinge": joint("revolute", frame("ground"), frame("base"), **about_z),
            "end": joint("revolute", frame("base", (LENGTH, 0, 0)), frame("block"), **about_z),
            "strut": joint(
                "prismatic",
                frame("base"),
                frame("left"),
                axis=[0, 1, 0],
                start={"s": 0.5, "v": 0.0, "fixed": True},
            ),
            "bar": joint(
                "revolute",
                frame("left"),
                frame("right"),
                **about_z,
                start={"phi": 0.0, "w": -1.0, "fixed": True},  # at rest, on a base that rotates at 1 rad/s
            ),
        },
        name="CarAxis",
        gravity=[0, -1.0, 0],
        forces={
            "left_spring": spring(frame("ground"), frame("left")),
            "right_spring": spring(frame("block"), frame("right", (LENGTH, 0, 0))),
        },
        constraints={
            "road": {
                "type": "motion",
                "joint": "rise",
                "sine": {"amplitude": RISE, "frequency": OMEGA / (2 * math.pi)},
            }
        },
        sensors={
            "l": {"type": "frame", **frame("left")},
            "r": {"type": "frame", **frame("right", (LENGTH, 0, 0))},
            "at_strut": reaction("strut"),
            "at_bar": reaction("bar"),
        },
    )


def test_car_axis_ends_at_the_published_reference() -> None:
    found = run(car_axis(), [0.0, 3.0], 1e-12)
    names = [f"{s}.{q}[{i}]" for q in "rv" for s in "lr" for i in (1, 2)]
    assert [found[name][0] for name in names] == pytest.approx([0, 0.5, 1, 0.5, -0.5, 0, -0.5, 0], abs=1e-12)
    end = [found[name][-1] for name in names]
    assert_close("car axis", end, AT_3, 1e-11, "of 3 s at the tolerance of 1e-12: twice what is seen")
    # On the left point: lambda1 (xb, yb) from the base; on the right: -2 lambda2 (left - right) from the bar.
    assert_close("strut", found["at_strut.f[1]"][-1], ALONG_BASE * LENGTH, 1e-9, "as above")
    force = math.hypot(found["at_bar.f[1]"][-1], found["at_bar.f[2]"][-1])
    assert_close("bar", force, 2 * abs(ALONG_BAR) * LENGTH, 1e-9, "as above")


# A spatial loop with revolute, prismatic, spherical and universal joints, Modelica's Fourbar1. For each
# coordinate: its function of the crank angle, the names of its velocity and its acceleration.
FOURBAR1 = ModelicaFourbar1()
IN_SPACE: dict[str, tuple[Callable[[Jet], Jet], str, str]] = {
    "j1.phi": (lambda phi: phi, "w", "a"),
    "j2.s": (FOURBAR1.slider, "v", "a"),
    "cross.phi_a": (lambda phi: FOURBAR1.rod(phi)[0], "w_a", "a_a"),
    "cross.phi_b": (lambda phi: FOURBAR1.rod(phi)[1], "w_b", "a_b"),
}


@pytest.mark.parametrize("driven_at", list(IN_SPACE))
def test_spatial_loop_driven_at_each_of_its_coordinates(driven_at: str) -> None:
    """All coordinates follow the crank; the power of the drive equals that of a torque at the crank."""
    source = fourbar1()
    name, _, coordinate = driven_at.partition(".")
    law, speed, _ = IN_SPACE[driven_at]
    begin = law(Jet(0.3, 1.0))
    given = polynomial([begin.x, 1.5 * begin.d, 0.4 * begin.d])
    source["joints"]["j1"]["start"] = {"phi": 0.3}
    source["constraints"] = {
        "drive": {
            "type": "motion",
            "joint": name,
            "coordinate": coordinate,
            "polynomial": [begin.x, 1.5 * begin.d, 0.4 * begin.d],
        }
    }
    times = np.linspace(0, 0.35, 8)  # the cross reaches a dead center at 0.38 s
    found = run(source, times, 1e-8)
    motion = OneDofMechanism(FOURBAR1.geometry, (0.0, -G_N, 0.0))
    for i, t in enumerate(times):
        phi, w, a = (found[f"j1.{q}"][i] for q in ("phi", "w", "a"))
        for key, (angle, rate, change) in IN_SPACE.items():
            x, joint_name = angle(Jet(phi, 1.0)), key.partition(".")[0]
            expected = (x.x, x.d * w, x.dd * w * w + x.d * a)
            seen = (found[key][i], found[f"{joint_name}.{rate}"][i], found[f"{joint_name}.{change}"][i])
            assert_close(f"{key} at {t}", seen, expected, 1e-10, "closed form")
        assert_close("motion", found[driven_at][i], given(float(t))[0], 1e-12, "given")
        inertia = sum(moving.reduced()[0] for moving in FOURBAR1.geometry(Jet(phi, 1.0)))
        at_crank = inertia * (a - motion.acceleration(0, phi, w))
        force = found["drive.f" if coordinate == "s" else "drive.tau"][i]
        power = force * found[f"{name}.{speed}"][i]
        assert_close(f"power at {t}", power, at_crank * w, 1e-8, "of 200 W")


@pytest.mark.parametrize("integrator", ["auto", "cvode", "rk4"])
def test_motion_beyond_a_dead_center_is_rejected_there(integrator: str) -> None:
    """The cross rotates to 0.423 rad and back during a crank revolution: it cannot rotate further."""
    source = fourbar1()
    source["joints"]["j1"]["start"] = {"phi": 0.3}
    begin = IN_SPACE["cross.phi_a"][0](Jet(0.3, 1.0)).x
    motion = {"type": "motion", "joint": "cross", "coordinate": "phi_a", "polynomial": [begin, 0.6]}
    source["constraints"] = {"drive": motion}
    source["solver"] = {"integrator": integrator, "step": 1e-3}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    most = max(IN_SPACE["cross.phi_a"][0](Jet(x, 1.0)).x for x in np.linspace(1.3, 1.6, 301))
    dead = (most - begin) / 0.6
    plant.step_to(dead - 0.01)
    before = plant.values().tolist()
    with pytest.raises(gelenk.StepError):
        plant.step_to(dead + 0.01)
    assert plant.values().tolist() == before
