# SPDX-License-Identifier: BSD-3-Clause
"""What a master must not do to an FMU: each scenario ends in a status, one sentence, and a living process."""

from __future__ import annotations

import ctypes
import math
from ctypes import c_double, c_int, c_size_t, c_uint
from typing import Any

from fmu.host import ERROR, LAST_SUCCESSFUL_TIME, OK, Fmu, Slave, expect


def refused_instance(slave: Slave, *words: str) -> None:
    assert slave.component is None
    expect(slave, ERROR, ERROR, "fmi2Instantiate: ", *words)


def instantiation_refuses_what_does_not_fit(fmu: Fmu) -> None:
    wrong = "00000000-0000-0000-0000-000000000000"
    refused_instance(Slave(fmu, guid=wrong), "GUID", wrong, fmu.description.guid)
    refused_instance(Slave(fmu, guid=None), "GUID: found a null pointer")
    refused_instance(Slave(fmu, name=""), "instance name: found none")
    refused_instance(Slave(fmu, name=None), "instance name: found none")
    refused_instance(
        Slave(fmu, kind=7), "type: found 7, expected fmi2ModelExchange (0) or fmi2CoSimulation (1)"
    )
    refused_instance(Slave(fmu, resources=None), "resource location: found a null pointer")
    refused_instance(Slave(fmu, resources="http://example.org/x"), "expected a path or a file: URI")
    refused_instance(Slave(fmu, resources="file://server/x"), "expected a file on this machine")
    refused_instance(Slave(fmu, resources="file:///tmp/100%"), "two hexadecimal digits", "100%")
    refused_instance(Slave(fmu, resources="/no/such/place"), "/no/such/place/scene.json", "No such file")


def damaged_scene_is_named(fmu: Fmu) -> None:
    scene = fmu.folder / "resources" / "scene.json"
    text = scene.read_text()
    scene.write_text(text[: len(text) // 2])
    refused_instance(Slave(fmu), str(scene))
    scene.write_text(text.replace('"crank"', '"krank"'))
    refused_instance(Slave(fmu))
    scene.write_text(text + " ")
    refused_instance(Slave(fmu), "GUID", "not from the same export")


def null_instances_are_refused(fmu: Fmu) -> None:
    nothing = Slave(fmu, guid="wrong")
    for function in (
        "fmi2EnterInitializationMode",
        "fmi2ExitInitializationMode",
        "fmi2Terminate",
        "fmi2Reset",
        "fmi2CancelStep",
    ):
        assert nothing.call(function) == ERROR
    assert nothing.setup() == ERROR
    assert nothing.step(0.0, 0.1) == ERROR
    assert nothing.set_real(drive__tau=1.0) == ERROR
    nothing.free()


def calls_out_of_order_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu)
    expect(s, s.step(0.0, 0.1), ERROR, "fmi2DoStep: called before fmi2EnterInitializationMode", "expected")
    expect(
        s, s.leave(), ERROR, "fmi2ExitInitializationMode: called before", "expected in initialization mode"
    )
    expect(s, s.call("fmi2Terminate"), ERROR, "fmi2Terminate: called before")
    value = c_double()
    status = s.call("fmi2GetReal", s.references(["A.phi"]), c_size_t(1), ctypes.byref(value))
    expect(s, status, ERROR, "A.phi can be read only after fmi2EnterInitializationMode")
    assert s.setup() == OK
    assert s.enter() == OK
    expect(s, s.enter(), ERROR, "fmi2EnterInitializationMode: called in initialization mode")
    expect(s, s.setup(), ERROR, "fmi2SetupExperiment: called in initialization mode")
    expect(s, s.step(0.0, 0.1), ERROR, "fmi2DoStep: called in initialization mode")
    assert s.leave() == OK
    expect(s, s.leave(), ERROR, "called after initialization")
    assert s.step(0.0, 0.1) == OK
    assert s.call("fmi2Terminate") == OK
    expect(s, s.call("fmi2Terminate"), ERROR, "called after fmi2Terminate")
    expect(s, s.step(0.1, 0.1), ERROR, "called after fmi2Terminate")
    assert math.isfinite(s.get("A.phi"))  # the last values can still be read
    s.free()


def a_set_call_counts_as_a_whole(fmu: Fmu) -> None:
    s = Slave(fmu)
    before = s.get("crank.m")
    status = s.set({"crank.m": 2.0, "coupler.com[1]": math.nan})
    expect(s, status, ERROR, "coupler.com[1]: found NaN, expected a finite number")
    assert s.get("crank.m") == before


def impossible_parameters_are_named(fmu: Fmu) -> None:
    s = Slave(fmu)
    expect(s, s.set({"crank.m": -1.0}), ERROR, "crank.m: found -1, expected at least 0 kg")
    expect(s, s.set({"solver.tolerance": 0.0}), ERROR, "solver.tolerance: found 0, expected between")
    integer = ("fmi2SetInteger", c_int)
    expect(s, s.set({"solver.integrator": 99}, *integer), ERROR, "solver.integrator: found 99", "(ida)")
    for count in (0, -1):
        status = s.set({"solver.max_evaluations": count}, *integer)
        expect(
            s, status, ERROR, f"solver.max_evaluations: found {count}, expected a whole number from 1 to 2147"
        )
    expect(s, s.set({"solver.max_evaluations": 9.0}), ERROR, "solver.max_evaluations is of type Integer")
    boolean = ("fmi2SetBoolean", c_int)
    expect(s, s.set({"A.fixed": 7}, *boolean), ERROR, "A.fixed: found 7, expected false (0) or true (1)")
    s.start()
    expect(
        s,
        s.set({"crank.m": 1.5}),
        ERROR,
        "crank.m is a fixed parameter",
        "only before fmi2ExitInitializationMode",
    )
    expect(s, s.set({"A.phi": 1.5}), ERROR, "A.phi is computed by the plant and cannot be set")


def wrong_references_types_and_pointers_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    value, unknown = (c_double * 1)(), (c_uint * 1)(4000000000)
    expect(s, s.call("fmi2GetReal", unknown, c_size_t(1), value), ERROR, "value reference: found 4000000000")
    expect(s, s.call("fmi2SetReal", unknown, c_size_t(1), value), ERROR, "value reference: found 4000000000")
    phi = s.references(["A.phi"])
    integers = (c_int * 1)()
    expect(s, s.call("fmi2GetInteger", phi, c_size_t(1), integers), ERROR, "A.phi is of type Real")
    expect(s, s.call("fmi2GetBoolean", phi, c_size_t(1), integers), ERROR, "A.phi is of type Real")
    expect(s, s.call("fmi2GetString", phi, c_size_t(1), value), ERROR, "no variables of type String")
    expect(s, s.call("fmi2SetInteger", phi, c_size_t(1), integers), ERROR, "A.phi is of type Real")
    expect(s, s.call("fmi2SetBoolean", phi, c_size_t(1), integers), ERROR, "A.phi is of type Real")
    expect(s, s.call("fmi2SetString", phi, c_size_t(1), value), ERROR, "no variables of type String")
    expect(
        s, s.call("fmi2SetReal", None, c_size_t(1), value), ERROR, "value references: found a null pointer"
    )
    expect(s, s.call("fmi2SetReal", phi, c_size_t(1), None), ERROR, "values: found a null pointer")
    fixed = s.references(["A.fixed"])
    expect(s, s.call("fmi2GetReal", fixed, c_size_t(1), value), ERROR, "A.fixed is of type Boolean")
    expect(
        s, s.call("fmi2GetReal", None, c_size_t(1), value), ERROR, "value references: found a null pointer"
    )
    expect(s, s.call("fmi2GetReal", phi, c_size_t(1), None), ERROR, "values: found a null pointer")
    assert s.call("fmi2GetReal", None, c_size_t(0), None) == OK
    status = s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), None)
    expect(s, status, ERROR, "value: found a null pointer")


def steps_that_no_clock_makes_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu)
    assert s.setup(stop=1.0) == OK
    assert s.enter() == OK
    assert s.leave() == OK
    for size in (0.0, -0.1, math.nan, math.inf):
        expect(s, s.step(0.0, size), ERROR, "communication step: found", "expected a positive, finite number")
    expect(s, s.step(math.nan, 0.1), ERROR, "communication point: found NaN")
    assert s.step(0.0, 0.1) == OK
    expect(s, s.step(0.0, 0.1), ERROR, "t = 0 s", "the plant is at t = 0.1 s", "cannot go back")
    expect(s, s.step(0.3, 0.1), ERROR, "t = 0.3 s", "contiguous")
    expect(s, s.step(0.1, 1e-20), ERROR, "too small to change t = 0.1 s")
    expect(s, s.step(0.1, 1.0), ERROR, "beyond the stop time 1 s")
    assert s.step(0.1, 0.9) == OK


def experiments_that_cannot_be_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu)
    expect(s, s.setup(start=math.nan), ERROR, "start time: found NaN")
    expect(
        s, s.setup(start=1.0, stop=0.5), ERROR, "stop time: found 0.5 s, expected at least the start time 1 s"
    )
    expect(s, s.setup(tolerance=-1.0), ERROR, "tolerance: found -1")
    assert s.setup(start=3.0, tolerance=1e-8) == OK
    assert s.enter() == OK
    assert s.leave() == OK
    assert s.step(3.0, 0.1) == OK
    time = c_double()
    assert s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(time)) == OK
    assert abs(time.value - 3.1) < 1e-15


def impossible_input_derivatives_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    function, one, tau = "fmi2SetRealInputDerivatives", c_size_t(1), s.references(["drive.tau"])

    def refused(words: str, references: Any, order: int | None, value: float | None) -> None:
        orders = None if order is None else (c_int * 1)(order)
        values = None if value is None else (c_double * 1)(value)
        expect(s, s.call(function, references, one, orders, values), ERROR, f"{function}: {words}")

    refused("value references: found a null pointer, expected an array of 1", None, 1, 1.0)
    refused("orders: found a null pointer, expected an array of 1", tau, None, 1.0)
    refused("values: found a null pointer, expected an array of 1", tau, 1, None)
    refused("value reference: found 4000000000", (c_uint * 1)(4000000000), 1, 1.0)
    refused(
        "A.phi: found a variable that is not an input, expected an input", s.references(["A.phi"]), 1, 1.0
    )
    refused("crank.m: found a variable that is not an input", s.references(["crank.m"]), 1, 1.0)
    refused("A.fixed is of type Boolean", s.references(["A.fixed"]), 1, 1.0)
    for order in (0, 6, -1):
        refused(
            f"drive.tau: found a derivative of order {order}, expected one of order 1 to 5", tau, order, 1.0
        )
    for bad in (math.nan, math.inf, -math.inf):
        refused("drive.tau: found ", tau, 1, bad)
    both = (c_double * 2)(3.0, math.nan)  # a call counts as a whole
    status = s.call(function, s.references(["drive.tau"] * 2), c_size_t(2), (c_int * 2)(1, 2), both)
    expect(s, status, ERROR, "drive.tau: found NaN for the derivative of order 2, expected a finite number")
    assert s.call(function, None, c_size_t(0), None, None) == OK
    s.run(1)
    assert s.get("drive.tau") == 0.0
    assert s.call("fmi2Terminate") == OK
    expect(s, s.call(function, tau, one, (c_int * 1)(1), (c_double * 1)(1.0)), ERROR, "after fmi2Terminate")


def functions_not_offered_say_so(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    real, one = (c_double * 1)(), c_size_t(1)
    calls: dict[str, tuple[tuple[Any, ...], ...]] = {
        "is a function for model exchange; this instance is for co-simulation": (
            ("fmi2EnterEventMode",),
            ("fmi2EnterContinuousTimeMode",),
            ("fmi2SetTime", c_double(0)),
            ("fmi2GetDerivatives", real, one),
            ("fmi2GetContinuousStates", real, one),
            ("fmi2SetContinuousStates", real, one),
            ("fmi2GetEventIndicators", real, one),
            ("fmi2GetNominalsOfContinuousStates", real, one),
            ("fmi2NewDiscreteStates", None),
            ("fmi2CompletedIntegratorStep", c_int(0), None, None),
        ),
        "no step is running": (("fmi2CancelStep",),),
    }
    for words, functions in calls.items():
        for function, *arguments in functions:
            expect(s, s.call(function, *arguments), ERROR, f"{function}: ", words)
    s.run(2)  # none of it did harm
