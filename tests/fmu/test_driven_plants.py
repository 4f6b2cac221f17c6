# SPDX-License-Identifier: BSD-3-Clause
"""FMUs whose inputs are motions: how they are described, started, driven, saved and begun anew."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from ctypes import c_double, c_int, c_size_t
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from mechanisms import Scene

import gelenk

from .derivatives import in_time
from .host import DISCARD, LAST_SUCCESSFUL_TIME, OK, Fmu, Slave
from .plants import cranked, driven
from .states import choice, deserialize, everything, get_state, serialized, set_state

SIZE = 0.01  # s
START = 0.7  # rad


def crank(t: float) -> list[float]:
    """A position and its derivatives up to order 5."""
    return [
        START * (k == 0)
        + 0.5 * 3.0**k * math.sin(3.0 * t + k * math.pi / 2)
        + 2.0 * (t if k == 0 else k == 1)
        for k in range(6)
    ]


LAWS: dict[Callable[[], Scene], tuple[str, Callable[[float], Sequence[float]]]] = {
    driven: ("crank.phi_ref", crank),
    cranked: ("crank.w_ref", lambda t: crank(t)[1:]),
}
PLANTS = pytest.mark.parametrize("plant", [driven, cranked])


def extracted(source: Scene, folder: Path) -> Fmu:
    folder.mkdir(exist_ok=True)
    fmu = gelenk.export_fmu(source, folder / "x.fmu")
    return Fmu(fmpy.extract(str(fmu), str(folder / "extracted")))


def give(s: Slave, name: str, law: Sequence[float]) -> None:
    value, *derivatives = law
    assert s.set({name: value}) == OK, s.said
    n = len(derivatives)
    status = s.call(
        "fmi2SetRealInputDerivatives",
        s.references([name] * n),
        c_size_t(n),
        (c_int * n)(*range(1, n + 1)),
        (c_double * n)(*derivatives),
    )
    assert status == OK, s.said


def begin(s: Slave, name: str, law: Sequence[float], tolerance: float | None = None) -> Slave:
    """The start is at what the input says while the slave initializes."""
    assert s.setup(tolerance=tolerance) == OK
    assert s.enter() == OK
    give(s, name, law)
    assert s.leave() == OK, s.said
    return s


def go_on(s: Slave, plant: Callable[[], Scene], first: int, steps: int) -> list[list[float]]:
    name, law = LAWS[plant]
    rows = []
    for k in range(first, first + steps):
        give(s, name, law(k * SIZE))
        assert s.step(k * SIZE, SIZE) == OK, s.said
        rows.append(everything(s))
    return rows


def test_inputs_and_forces_are_named_with_units_and_sentences(tmp_path: Path) -> None:
    told = {
        v.name: (v.causality, v.unit, v.description)
        for f in (driven, cranked)
        for v in extracted(f(), tmp_path / f.__name__).description.modelVariables
    }
    assert told["crank.phi_ref"] == ("input", "rad", "crank: prescribed value of A.phi")
    assert told["crank.w_ref"][:2] == ("input", "rad/s")
    assert told["crank.tau"] == ("output", "N.m", "crank: torque that enforces the motion of A.phi")
    assert told["shake.f"] == ("output", "N", "shake: force that enforces the motion of shakes.s")
    assert told["mesh.tau"] == ("output", "N.m", "mesh: torque of the gear on joint turns")
    assert told["teeth.f"] == ("output", "N", "teeth: force of the pinion on joint runs")


@PLANTS
def test_the_start_follows_the_input_set_before_it(plant: Callable[[], Scene], tmp_path: Path) -> None:
    name, law = LAWS[plant]
    s = begin(Slave(extracted(plant(), tmp_path)), name, law(0.0))
    expected = crank(0.0)[:3]
    assert [s.get(f"A.{q}") for q in ("phi", "w", "a")] == pytest.approx(expected, abs=1e-12)


@PLANTS
def test_crank_follows_its_input_and_all_else_as_the_scene_does(
    plant: Callable[[], Scene], tmp_path: Path
) -> None:
    """Taylor polynomials of order 5 over 10 ms err by (3 / 100)^6 / 6! 0.5 rad: below 1e-12."""
    name, law = LAWS[plant]
    s = begin(Slave(extracted(plant(), tmp_path)), name, law(0.0))
    names = [v.name for v in s.fmu.description.modelVariables if v.causality == "output"]
    here = gelenk.Simulation(gelenk.load(plant()))
    for order, value in enumerate(law(0.0)):
        if order:
            here.set_input_derivative(name, order, value)
        else:
            here.set_input(name, value)
    here.initialize()
    for k in range(100):
        value, *derivatives = law(k * SIZE)
        here.set_input(name, value)
        for order, d in enumerate(derivatives, 1):
            here.set_input_derivative(name, order, d)
        here.step_to((k + 1) * SIZE)
        go_on(s, plant, k, 1)
        assert [s.get(n) for n in names] == here.values(names).tolist()
        angle, speed = crank((k + 1) * SIZE)[:2]
        assert s.get("A.w") == pytest.approx(speed, abs=1e-9)
        assert s.get("A.phi") == pytest.approx(angle, abs=1e-9)


@PLANTS
def test_runs_go_on_from_saved_states_to_the_bit(plant: Callable[[], Scene], tmp_path: Path) -> None:
    """With every formulation and integrator that goes with the plant, in this instance and in another."""
    fmu = extracted(plant(), tmp_path)
    name, law = LAWS[plant]
    ran = set()
    for (formulation, f), (integrator, i) in product(
        choice(fmu, "solver.formulation").items(), choice(fmu, "solver.integrator").items()
    ):
        s = Slave(fmu)
        methods: dict[str, float] = {"solver.formulation": f, "solver.integrator": i}
        assert s.set(methods, "fmi2SetInteger", c_int) == OK, s.said
        assert s.setup() == OK
        assert s.enter() == OK
        give(s, name, law(0.0))
        if s.leave() != OK:
            assert "expected" in s.said
            continue
        ran.add((formulation, integrator))
        go_on(s, plant, 0, 5)
        state = get_state(s)
        expected = go_on(s, plant, 5, 5)
        set_state(s, state)
        assert go_on(s, plant, 5, 5) == expected, (formulation, integrator)
        other = Slave(fmu)
        copy = ctypes.c_void_p()
        assert deserialize(other, serialized(s, state), copy) == OK, other.said
        set_state(other, copy)
        assert go_on(other, plant, 5, 5) == expected, (formulation, integrator)
        s.free()
        other.free()
    told = {f for f, _ in ran}
    assert told == set(choice(fmu, "solver.formulation")) - ({"independent"} if plant is cranked else set())


@PLANTS
def test_a_reset_plant_runs_again_to_the_bit(plant: Callable[[], Scene], tmp_path: Path) -> None:
    name, law = LAWS[plant]
    s = begin(Slave(extracted(plant(), tmp_path)), name, law(0.0))
    first = go_on(s, plant, 0, 20)
    assert s.call("fmi2Reset") == OK
    begin(s, name, law(0.0))
    assert go_on(s, plant, 0, 20) == first


@PLANTS
def test_a_step_cut_short_goes_on_along_the_motion(plant: Callable[[], Scene], tmp_path: Path) -> None:
    name, law = LAWS[plant]
    s = Slave(extracted(plant(), tmp_path))
    assert s.set({"solver.max_evaluations": 40}, "fmi2SetInteger", c_int) == OK, s.said
    begin(s, name, law(0.0), 1e-8)
    give(s, name, law(0.0))
    t, cuts = 0.0, 0
    while t < 0.5:
        status = s.step(t, 0.5 - t)
        assert status in (OK, DISCARD), s.said
        reached = c_double()
        if status == DISCARD:
            assert s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(reached)) == OK
            assert t < reached.value < 0.5
            cuts += 1
        t = reached.value if status == DISCARD else 0.5
        polynomial = sum(c * t**k / math.factorial(k) for k, c in enumerate(law(0.0)))
        follows = "A.phi" if plant is driven else "A.w"
        assert s.get(follows) == pytest.approx(polynomial, abs=1e-9), t
    assert cuts > 2


@PLANTS
def test_time_derivatives_of_outputs_follow_the_motion(plant: Callable[[], Scene], tmp_path: Path) -> None:
    """As the input is to go on: of accelerations two more derivatives of the position than they are."""
    name, law = LAWS[plant]
    s = begin(Slave(extracted(plant(), tmp_path)), name, law(0.0))
    go_on(s, plant, 0, 10)
    give(s, name, law(10 * SIZE))
    for order in (1, 2):
        at = crank(10 * SIZE)
        # Of an input two derivatives are asked for: of a position the jerk is not among them.
        known = [at[order], at[1 + order] if 1 + order <= 2 + (plant is cranked) else 0.0]
        assert in_time(s, ["A.phi", "A.w"], order) == pytest.approx(known, abs=1e-8), order


def test_parts_that_are_driven_apart_do_not_feel_each_other(tmp_path: Path) -> None:
    """Its own steps, its own motion: the part that shakes does the same whatever the crank does."""
    assert gelenk.Simulation(gelenk.load(driven())).size.islands == 2
    rows = []
    for moving in (False, True):
        s = Slave(extracted(driven(), tmp_path / str(moving)))
        begin(s, "crank.phi_ref", crank(0.0) if moving else [START])
        names = ["swings.phi", "turns.w", "runs.s", "shake.f", "mesh.tau", "teeth.f", "axle.f[1]"]
        found = []
        for k in range(20):
            if moving:
                give(s, "crank.phi_ref", crank(k * SIZE))
            assert s.step(k * SIZE, SIZE) == OK
            found.append([s.get(n) for n in names])
        rows.append(found)
    assert rows[0] == rows[1]


def test_speeds_by_fmpy_have_accelerations(tmp_path: Path) -> None:
    """Values alone are given: the parabola through three of them errs by h^3 times the third derivative at
    its end. In the first two steps speeds are held, which lacks h^2/2 times the acceleration in each.
    """
    found = gelenk.export_fmu(cranked(), tmp_path / "x.fmu")
    times = SIZE * np.arange(51)
    given = [crank(float(t))[1] for t in times]
    table = np.array(list(zip(times, given, strict=True)), dtype=[("time", float), ("crank.w_ref", float)])
    run: Any = fmpy.simulate_fmu(
        str(found), stop_time=0.5, output_interval=SIZE, input=table, output=["A.w", "A.phi", "bobs.phi"]
    )
    third = 0.5 * 3.0**4
    assert run["A.w"][3:] == pytest.approx(given[3:], abs=SIZE**3 * third)
    assert run["A.w"][1:3] == pytest.approx(given[:2], abs=1e-9)
    turned = np.array([crank(float(t))[0] for t in times]) - crank(0.0)[0]
    held = SIZE**2 * 0.5 * 3.0**2 * math.sin(3.0 * 2 * SIZE)
    left = 0.5 * 0.375 * SIZE**3 * third + held  # each parabola is integrated with an error of 3/8 h^4 w'''
    assert run["A.phi"] - run["A.phi"][0] == pytest.approx(turned, abs=left)
