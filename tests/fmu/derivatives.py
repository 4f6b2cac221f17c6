# SPDX-License-Identifier: BSD-3-Clause
"""Directional derivatives and time derivatives of outputs, asked of the crank-rocker of plants.py.

Its states are A.phi and A.w; the accelerations are affine in the torque.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from ctypes import c_double, c_int, c_size_t, c_uint

from fmu.host import DISCARD, ERROR, OK, Fmu, Slave, expect
from fmu.runs import push

SIZE = 1e-2  # s, of a step
DIRECTIONAL, IN_TIME = "fmi2GetDirectionalDerivative", "fmi2GetRealOutputDerivatives"


def outputs_of(fmu: Fmu) -> list[str]:
    return [v.name for v in fmu.description.modelVariables if v.causality == "output"]


def directional(s: Slave, unknowns: Sequence[str], seeds: Mapping[str, float]) -> list[float]:
    out = (c_double * len(unknowns))()
    status = s.call(
        DIRECTIONAL,
        s.references(unknowns),
        c_size_t(len(unknowns)),
        s.references(list(seeds)),
        c_size_t(len(seeds)),
        (c_double * len(seeds))(*seeds.values()),
        out,
    )
    assert status == OK, s.said
    return list(out)


def in_time(s: Slave, names: Sequence[str], order: int) -> list[float]:
    out = (c_double * len(names))()
    orders = (c_int * len(names))(*[order] * len(names))
    assert s.call(IN_TIME, s.references(names), c_size_t(len(names)), orders, out) == OK, s.said
    return list(out)


def assert_close(found: Sequence[float], expected: Sequence[float], bound: float) -> None:
    """Within `bound` of 1 and the number expected."""
    for x, y in zip(found, expected, strict=True):
        assert abs(x - y) < bound * (1 + abs(y)), (found, expected)


def slopes_by_the_torque_are_those_of_an_affine_plant(fmu: Fmu) -> None:
    """In every mode that allows it. A finite change tells them to rounding: 1e-12."""
    names = outputs_of(fmu)
    s = Slave(fmu)

    def check() -> None:
        found = directional(s, names, {"drive.tau": 0.7})
        s.set_real(drive__tau=2.0)
        before = s.outputs()
        s.set_real(drive__tau=2.7)
        assert_close(found, [b - a for a, b in zip(before, s.outputs(), strict=True)], 1e-12)
        s.set_real(drive__tau=2.0)

    assert s.setup() == OK
    assert s.enter() == OK
    check()
    assert s.leave() == OK
    check()
    s.run(5)
    check()
    s.set_real(drive__tau=1e300)
    assert s.step(5 * SIZE, SIZE) == DISCARD
    check()
    s.run(5, SIZE, first=5)
    check()
    before = directional(s, names, {"drive.tau": 1.0})
    assert s.call("fmi2Terminate") == OK
    assert directional(s, names, {"drive.tau": 1.0}) == before


def slopes_by_the_states_are_those_of_instances_set_beside(fmu: Fmu) -> None:
    """Instances assembled at moved start values, A exactly there; central differences of fourth order."""
    names = outputs_of(fmu)
    s = Slave(fmu).start()
    s.set_real(drive__tau=1.5)
    h = 1e-3  # its fourth power times the fifth derivative is 1e-11; rounding is 1e-15 / h
    for first in range(0, 60, 20):
        values = dict(zip(names, s.outputs(), strict=True))

        def moved(state: str, by: float, start: Mapping[str, float] = values) -> list[float]:
            other = Slave(fmu)
            at = dict(start)
            at[state] += by
            states = [f"{j}.{x}" for j in "ABCD" for x in ("phi", "w")]
            states += [name for name in names if f"{name}.rate" in names]  # of elements
            assert other.set({f"{name}_start": at[name] for name in states}) == OK, other.said
            other.set_real(drive__tau=1.5)
            out = other.start().outputs()
            other.free()
            return out

        for state in ("A.phi", "A.w"):
            around = [moved(state, k * h) for k in (-2, -1, 1, 2)]
            expected = [(a - 8 * b + 8 * c - d) / (12 * h) for a, b, c, d in zip(*around, strict=True)]
            assert_close(directional(s, names, {state: 1.0}), expected, 1e-8)
        s.run(20, SIZE, first=first)


def directions_add_up(fmu: Fmu) -> None:
    names = outputs_of(fmu)
    s = Slave(fmu).start()
    s.run(10)
    seeds = {"A.phi": 0.3, "A.w": -1.7, "drive.tau": 11.0}
    parts = [directional(s, names, {known: value}) for known, value in seeds.items()]
    assert_close(directional(s, names, seeds), [sum(terms) for terms in zip(*parts, strict=True)], 1e-12)
    assert directional(s, ["A.phi"], {"A.phi": 0.3}) == [0.3]
    assert directional(s, ["A.w"], {"A.phi": 0.3}) == [0.0]
    assert directional(s, ["B.a", "A.a"], seeds) == [
        directional(s, names, seeds)[names.index(x)] for x in ("B.a", "A.a")
    ]
    assert directional(s, names, {}) == [0.0] * len(names)
    assert directional(s, [], {}) == []


def speeds_and_accelerations_are_time_derivatives(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.set_real(drive__tau=2.0)
    for first in range(0, 30, 10):
        for joint in "ABCD":
            speed, acceleration = s.get(f"{joint}.w"), s.get(f"{joint}.a")
            assert_close(in_time(s, [f"{joint}.phi"], 1), [speed], 1e-12)
            assert_close(in_time(s, [f"{joint}.phi"], 2), [acceleration], 1e-12)
            assert_close(in_time(s, [f"{joint}.w"], 1), [acceleration], 1e-12)
        s.run(10, SIZE, first=first)


def time_derivatives_are_those_of_a_tight_run(fmu: Fmu) -> None:
    """Central differences of eighth order over steps of 2 ms, at 1e-13: error 1e-13 / h^2 at the most."""
    compare_with_a_tight_run(fmu, ())


def time_derivatives_follow_the_inputs(fmu: Fmu) -> None:
    """A torque that rises as a cubic, its derivatives set anew at each step."""
    compare_with_a_tight_run(fmu, (30.0, -200.0, 5e3))


def compare_with_a_tight_run(plant: Fmu, torque: Sequence[float]) -> None:
    """torque: its derivatives of order 1, 2, ... at t = 0."""
    names = outputs_of(plant)
    h = 2e-3
    s = Slave(plant)
    assert s.setup(tolerance=1e-13) == OK
    assert s.enter() == OK
    s.set_real(drive__tau=2.0)
    assert s.leave() == OK

    def run(steps: range) -> list[list[float]]:
        rows = []
        for k in steps:
            if torque:
                assert push(s, *at_time(torque, k * h)) == OK
            rows += s.run(1, h, first=k)
        return rows

    run(range(100))
    rows = run(range(100, 105))  # the last one's time is in the middle of all nine
    if torque:
        assert push(s, *at_time(torque, 105 * h)) == OK
    found = [in_time(s, names, order) for order in (1, 2)]
    around = list(zip(*rows, *run(range(105, 109)), strict=True))
    first = (1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280)
    second = (-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560)
    for order, weights in enumerate((first, second), 1):
        expected = [sum(w * x for w, x in zip(weights, c, strict=True)) / h**order for c in around]
        assert_close(found[order - 1], expected, 1e-7)


def at_time(derivatives: Sequence[float], t: float) -> list[float]:
    """Of a polynomial, from those at t = 0."""
    n = len(derivatives)
    return [sum(derivatives[j] * t ** (j - i) / math.factorial(j - i) for j in range(i, n)) for i in range(n)]


def asking_changes_no_bit(fmu: Fmu) -> None:
    names = outputs_of(fmu)
    usual, asked = Slave(fmu), Slave(fmu)
    for s in (usual, asked):
        assert s.setup() == OK
        assert s.enter() == OK
        s.set_real(drive__tau=2.0)
    directional(asked, names, {"A.phi": 1.0})
    for s in (usual, asked):
        assert s.leave() == OK
    for k in range(40):
        assert asked.step(k * SIZE, SIZE) == usual.step(k * SIZE, SIZE) == OK
        directional(asked, names, {"A.phi": 1.0, "drive.tau": -1.0})
        in_time(asked, names, 2)
        if k % 3 == 0:
            assert asked.outputs() == usual.outputs()
            for x in ("solver.steps", "solver.evaluations"):
                assert asked.get(x) == usual.get(x)
        if k == 20:
            for s in (usual, asked):
                s.set_real(drive__tau=-3.0)


def wrong_directions_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu)
    real, one, order = (c_double * 1)(1.0), c_size_t(1), (c_int * 1)(1)
    tau, phi = s.references(["drive.tau"]), s.references(["A.phi"])

    def ask(unknown: object = phi, known: object = tau, seed: object = real, out: object = real) -> int:
        return s.call(DIRECTIONAL, unknown, one, known, one, seed, out)

    expect(s, ask(), ERROR, DIRECTIONAL, "called before fmi2EnterInitializationMode")
    s.start()
    expected = "expected an output or the derivative of a state"
    for name in ("drive.tau", "gravity[1]", "A.fixed", "constraints.position"):
        expect(s, ask(unknown=s.references([name])), ERROR, f"unknown: found {name}, {expected}")
    for name in ("B.phi", "A.a", "hinge.f[1]", "crank.m", "solver.steps"):
        expect(
            s, ask(known=s.references([name])), ERROR, f"known: found {name}, expected an input or a state"
        )
    expect(s, ask(unknown=(c_uint * 1)(999999)), ERROR, "value reference: found 999999, expected less than")
    expect(s, ask(known=(c_uint * 1)(4294967295)), ERROR, "value reference: found 4294967295")
    expect(s, ask(unknown=None), ERROR, "unknowns: found a null pointer, expected an array of 1")
    expect(s, ask(known=None), ERROR, "knowns: found a null pointer")
    expect(s, ask(seed=None), ERROR, "dvKnown: found a null pointer")
    expect(s, ask(out=None), ERROR, "dvUnknown: found a null pointer")
    for bad in (math.nan, math.inf):
        expect(
            s, ask(seed=(c_double * 1)(bad)), ERROR, "dvKnown of drive.tau: found", "expected a finite number"
        )

    def in_time_of(name: str, which: int) -> int:
        return s.call(IN_TIME, s.references([name]), one, (c_int * 1)(which), real)

    for bad_order in (-1, 0, 3):
        expect(
            s, in_time_of("A.phi", bad_order), ERROR, f"order: found {bad_order} for A.phi, expected 1 to 2"
        )
    for name in ("drive.tau", "crank.m", "A.fixed", "energy.total"):
        expect(s, in_time_of(name, 1), ERROR, f"{name} is not an output")
    expect(s, s.call(IN_TIME, None, one, order, real), ERROR, "value references: found a null pointer")
    expect(s, s.call(IN_TIME, phi, one, None, real), ERROR, "orders: found a null pointer")
    expect(s, s.call(IN_TIME, phi, one, order, None), ERROR, "values: found a null pointer")
    s.run(3)  # none of it did harm
    assert ask() == OK


def output_derivatives_are_there_from_initialization_mode_on(fmu: Fmu) -> None:
    """Maestro asks for them there. They are those of the start, and asking changes no bit of the run."""
    names = outputs_of(fmu)
    asked, plain = Slave(fmu), Slave(fmu)
    for s in (asked, plain):
        assert s.setup() == OK
        arguments = (s.references(["A.phi"]), c_size_t(1), (c_int * 1)(1), ctypes.byref(c_double()))
        expect(s, s.call(IN_TIME, *arguments), ERROR, "expected in initialization mode")
        assert s.enter() == OK
    assert asked.set_real(drive__tau=1.7) == plain.set_real(drive__tau=1.7) == OK
    early = [in_time(asked, names, order) for order in (1, 2)]
    assert asked.leave() == plain.leave() == OK
    assert early == [in_time(asked, names, order) for order in (1, 2)]
    assert asked.run(5) == plain.run(5)
