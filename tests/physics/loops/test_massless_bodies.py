# SPDX-License-Identifier: BSD-3-Clause
"""Bodies without mass, or with inertia about a single axis,
move as their constraints prescribe (closed-form solutions).
"""

from __future__ import annotations

import copy
import itertools
import math
import re
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, joint, scene
from models.driven import Array, run
from models.rods import spatial_four_bar
from models.running import assert_close, started

import gelenk

ABOUT_Z: dict[str, Any] = {"axis": [0, 0, 1]}
ALONG_X: dict[str, Any] = {"axis": [1, 0, 0]}
MASSLESS = body(0.0)
EXACT = 1e-12  # of accelerations in closed form: round-off of some tens of operations
FORMULATIONS = ("projection", "udwadia-kalaba", "baumgarte", "independent", "index3", "stabilized-index2")


def disc(mass: float, moment: float) -> dict[str, Any]:
    return body(mass, (0, 0, 0), (moment / 2, moment / 2, moment))


def hinge(
    on: str, what: str, position: tuple[float, float, float] = (0, 0, 0), **fields: Any
) -> dict[str, Any]:
    return joint("revolute", frame(on, position), frame(what), **ABOUT_Z, **fields)


def slide(on: str, what: str, **fields: Any) -> dict[str, Any]:
    return joint("prismatic", frame(on), frame(what), **ALONG_X, **fields)


def rack_and_wheel(pinion: dict[str, Any], radius: float = 0.03, ratio: float = -2.5) -> Scene:
    """A rack of 1.7 kg, its pinion, and a wheel of 0.02 kg m2 that meshes with the pinion."""
    return scene(
        {"rack": body(1.7, (0.1, 0, 0), (0.01, 0.02, 0.02)), "pinion": pinion, "wheel": disc(2.0, 0.02)},
        {
            "S": slide("ground", "rack", damping=0.8),
            "P": hinge("ground", "pinion", (0, radius, 0)),
            "W": hinge("ground", "wheel", (0.2, radius, 0), stiffness=6.0),
        },
        motors={"push": {"joint": "S"}, "drive": {"joint": "P"}, "turn": {"joint": "W"}},
        constraints={
            "teeth": {"type": "rack", "rack": "S", "pinion": "P", "radius": radius},
            "mesh": {"type": "gear", "joint": "W", "with": "P", "ratio": ratio},
        },
        sensors={"meter": {"type": "energy"}},
    )


@pytest.mark.parametrize("pinion", [MASSLESS, body(0.4)], ids=["nothing", "point mass"])
@pytest.mark.parametrize("radius", [0.03, 1e-4])
def test_massless_pinion_between_rack_and_wheel(pinion: dict[str, Any], radius: float) -> None:
    """The system has one degree of freedom p, the pinion angle: (m r^2 + n^2 I) p'' = r f + tau_P + n tau_W.

    The rack force accelerates the rack, the mesh transmits the remainder of the wheel torque, and the forces
    on the pinion balance.
    """
    n, m, moment = -2.5, 1.7, 0.02
    plant = started(rack_and_wheel(pinion, radius, n), push__f=3.0, drive__tau=0.2, turn__tau=-0.1)
    p = (radius * 3.0 + 0.2 + n * -0.1) / (m * radius**2 + n**2 * moment)
    assert_close("P.a", plant.output("P.a"), p, EXACT * abs(p), "closed form")
    assert_close("S.a", plant.output("S.a"), radius * p, EXACT, "closed form")
    assert_close("W.a", plant.output("W.a"), n * p, EXACT * abs(p), "closed form")
    teeth, mesh = plant.output("teeth.f"), plant.output("mesh.tau")
    assert_close("teeth", teeth, m * radius * p - 3.0, EXACT * 10, "force that accelerates the rack")
    assert_close("mesh", mesh, moment * n * p + 0.1, EXACT * 10, "torque that accelerates the wheel")
    assert_close("pinion", radius * teeth + n * mesh, 0.2, EXACT * 10, "no inertia: forces balance")


@warned.TIGHT
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_gear_train_with_massless_pinion_matches_oscillator(formulation: str) -> None:
    """(m r^2 + n^2 I) p'' + d r^2 p' + n^2 k p = 0, from rest at p = 0.4."""
    r, n = 0.03, -2.5
    source = rack_and_wheel(MASSLESS, r, n)
    source["joints"]["P"]["start"] = {"phi": 0.4, "fixed": True}
    source["solver"] = {"formulation": formulation, "integrator": "ida"}
    times = np.linspace(0, 2, 21)
    found = run(source, times, 1e-11)
    inertia = 1.7 * r**2 + n**2 * 0.02
    decay = 0.8 * r**2 / inertia / 2
    omega = math.sqrt(n**2 * 6.0 / inertia - decay**2)
    exact = 0.4 * np.exp(-decay * times) * (np.cos(omega * times) + decay / omega * np.sin(omega * times))
    # ida achieves about 100 times the tolerance; index 3 computes its multipliers by differences over the
    # step.
    assert_close("P.phi", found["P.phi"], exact, 1e-7 if formulation == "index3" else 1e-8, "closed form")
    drift = 1e-7 if formulation == "baumgarte" else 1e-9
    assert_close("rack", found["S.s"], r * found["P.phi"], drift, "the teeth")


@pytest.mark.parametrize("idlers", [1, 2, 5])
def test_massless_idler_gears_transmit_torque(idlers: int) -> None:
    """A gear train between two wheels; each idler gear meshes only with the next, and none has inertia."""
    wheels = ["a", *(f"i{k}" for k in range(idlers)), "b"]
    ratio = -1.5
    source = scene(
        {w: disc(1.0, {"a": 0.5, "b": 0.2}[w]) if w in "ab" else MASSLESS for w in wheels},
        {f"J{w}": hinge("ground", w, (0.3 * k, 0, 0)) for k, w in enumerate(wheels)},
        motors={"left": {"joint": "Ja"}, "right": {"joint": "Jb"}},
        constraints={
            f"m{k}": {"type": "gear", "joint": f"J{x}", "with": f"J{y}", "ratio": ratio}
            for k, (x, y) in enumerate(itertools.pairwise(wheels))
        },
    )
    plant = started(source, left__tau=0.7, right__tau=-0.3)
    n = ratio ** (idlers + 1)
    b = (-0.3 + n * 0.7) / (0.2 + n**2 * 0.5)
    assert_close("b", plant.output("Jb.a"), b, EXACT, "closed form")
    assert_close("a", plant.output("Ja.a"), n * b, EXACT, "closed form")
    plant.step_to(1.0)
    assert_close("phi", plant.output("Jb.phi"), b / 2, 1e-6, "the tolerance")
    assert_close("closed", plant.output("Ja.phi"), n * plant.output("Jb.phi"), 1e-12, "round-off")


def test_massless_slider_with_prescribed_motion_excites_a_spring() -> None:
    """Forced response: m x'' = -k (x - s - L), s = A sin(w t), from rest at x = L.

    x - L = A / (1 - r^2) (sin(w t) - r sin(w0 t)), r = w / w0. The drive force equals the spring force.
    """
    mass, k, length, A, frequency = 0.6, 50.0, 0.5, 0.04, 0.7
    source = scene(
        {"slider": MASSLESS, "load": body(mass, (0, 0, 0), (1e-3, 1e-3, 1e-3))},
        {"S": slide("ground", "slider"), "L": slide("ground", "load", start={"s": length, "fixed": True})},
        forces={
            "spring": {
                "type": "spring_damper", "from": frame("slider"), "to": frame("load"),
                "stiffness": k, "length": length,
            }
        },
        constraints={
            "shaker": {
                "type": "motion", "joint": "S", "coordinate": "s",
                "sine": {"amplitude": A, "frequency": frequency},
            }
        },
    )  # fmt: skip
    times = np.linspace(0, 3, 31)
    found = run(source, times, 1e-11)
    w, w0 = 2 * math.pi * frequency, math.sqrt(k / mass)
    exact = A / (1 - (w / w0) ** 2) * (np.sin(w * times) - w / w0 * np.sin(w0 * times))
    assert_close("load", found["L.s"], length + exact, 1e-9, "closed form; 100 times the tolerance")
    pull = -k * (found["L.s"] - found["S.s"] - length)
    assert_close("drive", found["shaker.f"], pull, 1e-12, "the force at the slider, of the same outputs")


def four_bar(crank: dict[str, Any]) -> Scene:
    """A crank-rocker in which all bodies except the crank are massless."""
    return scene(
        {"crank": crank, "coupler": MASSLESS, "rocker": MASSLESS},
        {
            "A": hinge("ground", "crank", start={"phi": 0.7, "fixed": True}),
            "B": hinge("crank", "coupler", (0.2, 0, 0)),
            "C": joint("revolute", frame("coupler", (0.5, 0, 0)), frame("rocker", (0.4, 0, 0)), **ABOUT_Z),
            "D": hinge("ground", "rocker", (0.55, 0, 0), start={"phi": 1.5}),
        },
        gravity=(0.0, -9.81, 0.0),
        motors={"drive": {"joint": "A"}},
        sensors={"meter": {"type": "energy"}},
    )


def test_massless_coupler_and_rocker_do_not_affect_the_crank() -> None:
    """Coupler and rocker are massless: the crank is a pendulum, and they follow it (Freudenstein 1955)."""
    crank = body(2.0, (0.15, 0, 0), (0.01, 0.03, 0.03))
    alone = scene({"crank": crank}, {"A": hinge("ground", "crank", start={"phi": 0.7, "fixed": True})},
                  gravity=(0.0, -9.81, 0.0))  # fmt: skip
    times = np.linspace(0, 3, 61)
    found = run(four_bar(crank), times, 1e-11)
    pendulum = run(alone, times, 1e-11)
    assert_close(
        "A.phi", found["A.phi"], pendulum["A.phi"], 1e-8, "both to 100 times the tolerance, 3 swings"
    )
    assert_close("A.a at the start", found["A.a"][0], pendulum["A.a"][0], EXACT * 100, "the same equation")
    psi = found["D.phi"]
    a, b, c, d = 0.2, 0.5, 0.4, 0.55
    freudenstein = (
        a**2 + c**2 + d**2 - b**2 - 2 * a * d * np.cos(found["A.phi"]) + 2 * c * d * np.cos(psi)
        - 2 * a * c * np.cos(found["A.phi"] - psi)
    )  # fmt: skip
    assert_close("closed", freudenstein, 0.0, 1e-13, "round-off of lengths below 1 m")
    assert np.ptp(found["meter.total"]) < 1e-8  # J, of 5: the tolerance


@pytest.mark.parametrize("reductions", [{}, {"all": False}], ids=["reduced", "literal"])
def test_massless_spatial_linkage_does_not_affect_the_crank(reductions: dict[str, bool]) -> None:
    """Rod and rocker are massless: the crank, which makes full turns, is a pendulum."""
    source = spatial_four_bar()
    source["bodies"]["rocker"] = MASSLESS
    alone = copy.deepcopy(source)
    alone["bodies"] = {"crank": source["bodies"]["crank"]}
    alone["joints"] = {"A": source["joints"]["A"]}
    source["solver"] = {"reductions": reductions}
    times = np.linspace(0, 1, 21)
    found, pendulum = run(source, times, 1e-10), run(alone, times, 1e-12)
    assert_close("A.phi", found["A.phi"], pendulum["A.phi"], 1e-8, "100 times the tolerance, a turn")
    assert_close("A.a at the start", found["A.a"][0], pendulum["A.a"][0], EXACT * 100, "the same equation")


@pytest.mark.parametrize("moments", [(0.0, 0.0, 0.3), (0.3, 0.3, 0.3), (0.15, 0.15, 0.3)])
def test_rotational_inertia_without_mass(moments: tuple[float, float, float]) -> None:
    """I phi'' = tau, exactly."""
    source = scene({"wheel": body(0.0, (0.2, 0, 0), moments)}, {"A": hinge("ground", "wheel")},
                   motors={"drive": {"joint": "A"}})  # fmt: skip
    assert started(source, drive__tau=0.6).output("A.a") == pytest.approx(2.0, rel=4 * 2.2e-16)


def in_plane(full: bool) -> Scene:
    def bar(mass: float, length: float) -> dict[str, Any]:
        moment = mass * length**2 / 12
        return body(mass, (length / 2, 0, 0), (0.0, moment if full else 0.0, moment))

    source = four_bar(bar(1.0, 0.2))
    source["bodies"] |= {"coupler": bar(2.0, 0.5), "rocker": bar(1.5, 0.4)}
    return source


def test_planar_motion_uses_only_the_moment_about_the_normal() -> None:
    """No other moment enters the equations of motion: the results are bitwise equal."""
    times = np.linspace(0, 1, 11)
    one, all_of_them = (run(in_plane(full), times, 1e-8) for full in (False, True))
    for name in one:
        assert np.array_equal(one[name], all_of_them[name]), name


def test_spatial_body_on_parallel_axes_needs_one_moment() -> None:
    """An arm on a prismatic and a revolute joint carries a pendulum perpendicular to it:
    only the arm's moment about z matters.
    """

    def source(moments: tuple[float, float, float]) -> Scene:
        across = joint(
            "revolute", frame("arm", (0.3, 0, 0)), frame("bob"), axis=[1, 0, 0], start={"phi": 0.5}
        )
        return scene(
            {"cart": body(1.0), "arm": body(1.2, (0.1, 0, 0), moments), "bob": body(0.5, (0, 0, -0.2))},
            {"S": slide("ground", "cart"), "A": hinge("cart", "arm", start={"w": 2.0}), "B": across},
            gravity=(0.0, 0.0, -9.81),
        )

    times = np.linspace(0, 1, 11)
    one, all_of_them = (run(source(m), times, 1e-9) for m in ((0, 0, 0.02), (0.01, 0.015, 0.02)))
    for name in one:
        assert_close(name, one[name], all_of_them[name], 1e-11, "round-off, amplified over a second")


@pytest.mark.parametrize("reductions", [{}, {"all": False}], ids=["reduced", "literal"])
def test_reductions_do_not_change_the_motion(reductions: dict[str, bool]) -> None:
    source = rack_and_wheel(MASSLESS)
    source["solver"] = {"reductions": reductions}
    plant = started(source, push__f=3.0)
    p = 0.03 * 3.0 / (1.7 * 0.03**2 + 2.5**2 * 0.02)
    assert_close("P.a", plant.output("P.a"), p, EXACT, "closed form")


def test_linear_model_of_gear_train_with_massless_pinion() -> None:
    """Transfer function from push to wheel angle: n r / (J s^2 + d r^2 s + n^2 k), J = m r^2 + n^2 I."""
    r, n = 0.03, -2.5
    inertia = 1.7 * r**2 + n**2 * 0.02
    model = gelenk.linearize(rack_and_wheel(MASSLESS, r, n), inputs=["push.f"], outputs=["W.phi"])
    s = 3.0j
    gain = model.C @ np.linalg.solve(s * np.eye(len(model.A)) - model.A, model.B) + model.D
    exact = n * r / (inertia * s**2 + 0.8 * r**2 * s + n**2 * 6.0)
    assert_close("gain", abs(gain[0, 0] - exact), 0.0, EXACT * 100, "closed form")


def test_restored_state_continues_bitwise_identically() -> None:
    plant = started(rack_and_wheel(MASSLESS), push__f=3.0)
    plant.step_to(0.3)
    saved = plant.save()
    ends: list[Array] = []
    for _ in range(2):
        plant.step_to(0.8)
        ends.append(plant.values())
        plant.restore(saved)
    assert np.array_equal(ends[0], ends[1])


def refused(source: Scene) -> str:
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.Simulation(gelenk.load(source)).initialize()
    return str(error.value)


def test_motion_without_inertia_is_refused_with_the_name_of_the_body() -> None:
    """Two meshed wheels without inertia; a pinion without inertia that meshes with
    nothing; one on a spring.
    """
    both = scene(
        {"a": MASSLESS, "b": MASSLESS, "c": disc(1.0, 0.1)},
        {f"J{x}": hinge("ground", x) for x in "abc"},
        constraints={"mesh": {"type": "gear", "joint": "Ja", "with": "Jb", "ratio": 2.0}},
    )
    assert re.search(r"bodies\.[ab]: moves without inertia", refused(both))
    loose = rack_and_wheel(MASSLESS)
    del loose["constraints"]["teeth"]
    loose["constraints"]["mesh"] = {"type": "rack", "rack": "S", "pinion": "W", "radius": 0.03}
    assert "bodies.pinion: moves without inertia" in refused(loose)
    sprung = scene({"arm": MASSLESS}, {"A": hinge("ground", "arm", stiffness=3.0)})
    assert "a spring is not sufficient" in refused(sprung)


def test_moment_about_one_axis_is_refused_if_the_motion_requires_more() -> None:
    ball = scene(
        {"top": body(1.0, (0, 0, 0.1), (0, 0, 0.2))}, {"A": joint("spherical", frame("ground"), frame("top"))}
    )
    assert refused(ball).endswith(
        "bodies.top.inertia: zz = 0.2 exceeds xx + yy = 0 kg m2; no rigid body has such moments, "
        "and no joint lets the body rotate about its z axis only"
    )
    tilted = copy.deepcopy(ball)
    tilted["joints"]["A"] = joint("revolute", frame("ground"), frame("top"), axis=[0, 0.01, 1])
    assert "no joint lets the body rotate about its z axis only" in refused(tilted)
