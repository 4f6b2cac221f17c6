# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives asked through FMI 3.0, rightly and wrongly, of the crank-rocker of plants.py."""

from __future__ import annotations

import math
from ctypes import c_double, c_int32, c_size_t

from fmu.fmi3_calls import torque
from fmu.host import ERROR, OK
from fmu.host3 import Fmu3, Slave3, expect


def fmi3_output_derivatives_are_the_rates(fmu: Fmu3) -> None:
    """The first of an angle is its velocity, the second its acceleration, to rounding."""
    s = Slave3(fmu).start()
    torque(s, 1.7)
    s.run(3)
    names, two = ["A.phi", "A.phi"], c_size_t(2)
    orders, out = (c_int32 * 2)(1, 2), (c_double * 2)()
    assert s.call("fmi3GetOutputDerivatives", s.references(names), two, orders, out, two) == OK, s.said
    w, a = s.get(["A.w", "A.a"])
    assert abs(out[0] - w) < 1e-12 * (1 + abs(w))
    assert abs(out[1] - a) < 1e-12 * (1 + abs(a))
    for wrong in (0, 3):
        orders[1] = wrong
        status = s.call("fmi3GetOutputDerivatives", s.references(names), two, orders, out, two)
        expect(s, status, ERROR, f"order: found {wrong} for A.phi, expected 1 to 2")
    status = s.call("fmi3GetOutputDerivatives", s.references(names), two, orders, out, c_size_t(1))
    expect(s, status, ERROR, "values: found an array of 1, expected one of 2")
    status = s.call("fmi3GetOutputDerivatives", s.references(names), two, None, out, two)
    expect(s, status, ERROR, "orders: found a null pointer, expected an array of 2")


def fmi3_sensitivities_of_wrong_sizes_are_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu).start()
    unknowns, knowns = s.references(["A.a", "C.a"]), s.references(["drive.tau"])
    seed, out, one, two = (c_double * 2)(1.0, 1.0), (c_double * 2)(), c_size_t(1), c_size_t(2)
    forward, adjoint = "fmi3GetDirectionalDerivative", "fmi3GetAdjointDerivative"
    wrong = s.call(forward, unknowns, two, knowns, one, seed, two, out, two)
    expect(s, wrong, ERROR, "seed: found an array of 2, expected one of 1")
    wrong = s.call(forward, unknowns, two, knowns, one, seed, one, out, one)
    expect(s, wrong, ERROR, "sensitivity: found an array of 1, expected one of 2")
    wrong = s.call(adjoint, unknowns, two, knowns, one, seed, one, out, one)
    expect(s, wrong, ERROR, "seed: found an array of 1, expected one of 2")
    wrong = s.call(adjoint, unknowns, two, knowns, one, seed, two, out, two)
    expect(s, wrong, ERROR, "sensitivity: found an array of 2, expected one of 1")
    wrong = s.call(adjoint, unknowns, two, knowns, one, None, two, out, one)
    expect(s, wrong, ERROR, "seed: found a null pointer, expected an array of 2")
    seed[1] = math.nan
    wrong = s.call(adjoint, unknowns, two, knowns, one, seed, two, out, one)
    expect(s, wrong, ERROR, "seed of C.a: found NaN, expected a finite number")
    wrong = s.call(adjoint, knowns, one, knowns, one, seed, one, out, one)
    expect(s, wrong, ERROR, "unknown: found drive.tau, expected an output")
    wrong = s.call(adjoint, unknowns, one, unknowns, one, seed, one, out, one)
    expect(s, wrong, ERROR, "known: found A.a, expected an input or a state")
