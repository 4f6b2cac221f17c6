# SPDX-License-Identifier: BSD-3-Clause
"""Right and wrong calls of FMI 3.0, asked of the crank-rocker of plants.py or the one with a circuit."""

from __future__ import annotations

import ctypes
import math
import re
from ctypes import c_bool, c_double, c_size_t, c_uint, c_void_p
from pathlib import Path

import fmpy

from fmu.host import DISCARD, ERROR, OK
from fmu.host3 import Fmu3, Slave3, expect

HEADER = Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h"
FUNCTIONS = re.findall(r"^FMI3_Export fmi3\w+\s+(fmi3\w+);", HEADER.read_text(), re.MULTILINE)
UNUSED_TYPES = ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "UInt64", "String", "Binary")
SIZE = 1e-2  # s, of a step


def torque(slave: Slave3, value: float) -> None:
    assert slave.set({"drive.tau": value}) == OK, slave.said


def life(slave: Slave3) -> list[list[float]]:
    torque(slave, 2.5)
    rows = slave.run(5)
    torque(slave, 0.5)
    return rows + slave.run(5, first=5)


def refused_instance(slave: Slave3, *words: str) -> None:
    assert slave.instance is None
    expect(slave, ERROR, ERROR, "fmi3InstantiateCoSimulation: ", *words)


def fmi3_instantiation_refuses_what_does_not_fit(fmu: Fmu3) -> None:
    wrong = "00000000-0000-0000-0000-000000000000"
    refused_instance(
        Slave3(fmu, token=wrong), "instantiation token", wrong, fmu.description.instantiationToken
    )
    refused_instance(Slave3(fmu, token=None), "instantiation token: found a null pointer")
    refused_instance(Slave3(fmu, name=""), "instance name: found none")
    refused_instance(Slave3(fmu, resources=None), "resource path: found a null pointer")
    refused_instance(Slave3(fmu, resources="/no/such/place/"), "/no/such/place/scene.json", "No such file")
    refused_instance(Slave3(fmu, event_mode=True), "eventModeUsed: found true", "hasEventMode")
    refused_instance(Slave3(fmu, intermediate=2), "requiredIntermediateVariables: found 2")


def fmi3_scheduled_execution_is_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu)
    token, resources = fmu.description.instantiationToken, str(fmu.folder / "resources")
    arguments = [b"plant", token.encode(), resources.encode(), c_bool(False), c_bool(False), None, s._logger]
    assert fmu.library.fmi3InstantiateScheduledExecution(*arguments, None, None, None) is None
    expect(s, ERROR, ERROR, "fmi3InstantiateScheduledExecution: this FMU has no clocks")


def fmi3_calls_out_of_order_are_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu)
    before = "called before fmi3EnterInitializationMode"
    expect(s, s.step(0.0, 0.1).status, ERROR, f"fmi3DoStep: {before}", "expected")
    expect(
        s, s.leave(), ERROR, "fmi3ExitInitializationMode: called before", "expected in initialization mode"
    )
    expect(s, s.call("fmi3Terminate"), ERROR, "fmi3Terminate: called before")
    value = c_double()
    status = s.call("fmi3GetFloat64", s.references(["A.phi"]), c_size_t(1), ctypes.byref(value), c_size_t(1))
    expect(s, status, ERROR, "A.phi can be read only after fmi3EnterInitializationMode")
    assert s.enter() == OK
    expect(s, s.enter(), ERROR, "fmi3EnterInitializationMode: called in initialization mode")
    expect(s, s.step(0.0, 0.1).status, ERROR, "fmi3DoStep: called in initialization mode")
    assert s.leave() == OK
    expect(s, s.leave(), ERROR, "called after initialization")
    expect(s, s.set({"crank.m": 1.5}), ERROR, "crank.m is a fixed parameter", "fmi3ExitInitializationMode")
    expect(s, s.set({"A.phi": 1.5}), ERROR, "A.phi is computed by the plant and cannot be set")
    expect(s, s.set({"time": 1.5}), ERROR, "time is computed by the plant and cannot be set")
    assert s.step(0.0, 0.1).status == OK
    assert s.call("fmi3Terminate") == OK
    expect(s, s.call("fmi3Terminate"), ERROR, "called after fmi3Terminate")
    expect(s, s.step(0.1, 0.1).status, ERROR, "called after fmi3Terminate")
    assert math.isfinite(s.get(["A.phi"])[0])  # the last values can still be read
    s.free()


def fmi3_configuration_mode_changes_nothing(fmu: Fmu3) -> None:
    expected = life(Slave3(fmu).start())
    s = Slave3(fmu)
    expect(s, s.call("fmi3ExitConfigurationMode"), ERROR, "expected in configuration mode")
    assert s.call("fmi3EnterConfigurationMode") == OK
    expect(s, s.enter(), ERROR, "fmi3EnterInitializationMode: called in configuration mode")
    expect(s, s.set({"crank.m": 1.0}), ERROR, "fmi3SetFloat64: called in configuration mode")
    state = c_void_p()
    status = s.call("fmi3GetFMUState", ctypes.byref(state))
    expect(s, status, ERROR, "fmi3GetFMUState: called in configuration mode")
    assert s.call("fmi3ExitConfigurationMode") == OK
    assert life(s.start()) == expected
    expect(s, s.call("fmi3EnterConfigurationMode"), ERROR, "called after initialization")


def fmi3_experiments_that_cannot_be_are_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu)
    expect(s, s.enter(start=math.nan), ERROR, "start time: found NaN")
    expect(s, s.enter(start=1.0, stop=0.5), ERROR, "stop time: found 0.5 s, expected at least the start time")
    expect(s, s.enter(tolerance=-1.0), ERROR, "tolerance: found -1")
    assert s.enter(start=3.0, stop=4.0, tolerance=1e-8) == OK
    assert s.leave() == OK
    step = s.step(3.0, 0.1)
    assert (step.status, step.event, step.terminate, step.early) == (OK, False, False, False)
    assert abs(step.time - 3.1) < 1e-15
    expect(s, s.step(3.1, 1.0).status, ERROR, "beyond the stop time 4 s of fmi3EnterInitializationMode")


def fmi3_steps_that_no_clock_makes_are_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu).start()
    for size in (0.0, -0.1, math.nan, math.inf):
        expect(s, s.step(0.0, size).status, ERROR, "communication step: found", "expected a positive, finite")
    expect(s, s.step(math.nan, 0.1).status, ERROR, "communication point: found NaN")
    assert s.step(0.0, 0.1).status == OK
    expect(s, s.step(0.0, 0.1).status, ERROR, "the plant is at t = 0.1 s", "cannot go back")
    expect(s, s.step(0.3, 0.1).status, ERROR, "contiguous")
    places = [ctypes.byref(c_bool()) for _ in range(3)] + [ctypes.byref(c_double())]
    names = ("eventHandlingNeeded", "terminateSimulation", "earlyReturn", "lastSuccessfulTime")
    for missing, name in enumerate(names):
        some = [None if i == missing else place for i, place in enumerate(places)]
        status = s.call("fmi3DoStep", c_double(0.1), c_double(0.1), c_bool(True), *some)
        expect(s, status, ERROR, f"fmi3DoStep: {name}: found a null pointer, expected a place")
    assert s.step(0.1, 0.1).status == OK  # none of them was made


def fmi3_wrong_references_types_sizes_and_pointers_are_refused(fmu: Fmu3) -> None:
    s = Slave3(fmu).start()
    value, unknown, one = (c_double * 2)(), (c_uint * 1)(4000000000), c_size_t(1)
    phi = s.references(["A.phi"])
    for verb in ("Get", "Set"):
        function = f"fmi3{verb}Float64"
        expect(s, s.call(function, unknown, one, value, one), ERROR, "value reference: found 4000000000")
        expect(s, s.call(function, None, one, value, one), ERROR, "value references: found a null pointer")
        expect(s, s.call(function, phi, one, None, one), ERROR, "values: found a null pointer")
        expect(
            s, s.call(function, phi, one, value, c_size_t(2)), ERROR, "found an array of 2, expected one of 1"
        )
        assert s.call(function, None, c_size_t(0), None, c_size_t(0)) == OK
        for kind in ("Int32", "Int64", "Boolean"):
            expect(s, s.call(f"fmi3{verb}{kind}", phi, one, value, one), ERROR, "A.phi is of type Float64")
        for kind in UNUSED_TYPES[:-1]:
            expect(
                s, s.call(f"fmi3{verb}{kind}", phi, one, value, one), ERROR, f"no variables of type {kind}"
            )
        expect(s, s.call(f"fmi3{verb}Binary", phi, one, None, value, one), ERROR, "of type Binary")
        expect(s, s.call(f"fmi3{verb}Clock", phi, one, value), ERROR, "no variables of type Clock")
    for name, kind in (
        ("A.fixed", "Boolean"),
        ("solver.max_evaluations", "Int32"),
        ("solver.start", "Enumeration"),
    ):
        status = s.call("fmi3GetFloat64", s.references([name]), one, value, one)
        expect(s, status, ERROR, f"{name} is of type {kind}")


def fmi3_impossible_values_are_named(fmu: Fmu3) -> None:
    s = Slave3(fmu)
    expect(s, s.set({"drive.tau": math.nan}), ERROR, "drive.tau: found NaN, expected a finite number")
    before = s.get(["crank.m"])
    status = s.set({"crank.m": 2.0, "coupler.com[1]": math.inf})
    expect(s, status, ERROR, "coupler.com[1]: found", "expected a finite number")
    assert s.get(["crank.m"]) == before  # a call sets all values or none
    expect(s, s.set({"crank.m": -1.0}), ERROR, "crank.m: found -1, expected at least 0 kg")
    for number in (0, 99, 2**62):
        status = s.set({"solver.integrator": number}, "Int64")
        expect(s, status, ERROR, "solver.integrator: found", "(ida)")
    expect(s, s.set({"solver.max_evaluations": 0}, "Int32"), ERROR, "solver.max_evaluations: found 0")
    seven, one = (ctypes.c_ubyte * 1)(7), c_size_t(1)
    status = s.call("fmi3SetBoolean", s.references(["A.fixed"]), one, seven, one)
    expect(s, status, ERROR, "A.fixed: found 7, expected false (0) or true (1)")
    assert s.set({"A.fixed": True}, "Boolean") == OK
    assert s.get(["A.fixed"], "Boolean") == [True]


def fmi3_failed_steps_say_where_the_plant_is(fmu: Fmu3) -> None:
    s = Slave3(fmu).start()
    s.run(2)
    before = s.outputs()
    torque(s, 1e300)
    step = s.step(2 * SIZE, SIZE)
    expect(s, step.status, DISCARD, "fmi3DoStep: ", "state is unchanged")
    assert (step.event, step.terminate, step.early, step.time) == (False, True, False, 2 * SIZE)
    torque(s, 0.0)
    assert s.outputs() == before
    s.run(2, first=2)


def fmi3_a_budget_of_evaluations_ends_steps_early(fmu: Fmu3) -> None:
    """Early return if the importer allows it, otherwise a discarded step; both continue to the same end."""
    ends = []
    for allowed in (False, True):
        s = Slave3(fmu, early_return=allowed)
        assert s.set({"solver.max_evaluations": 40}, "Int32") == OK
        s.start()
        torque(s, 2.0)
        time, count = 0.0, 0
        while time < 1.0:
            step = s.step(time, 1.0 - time)
            assert step.time > time
            assert (step.event, step.terminate) == (False, False)
            if step.time < 1.0:
                assert step.early == allowed
                if allowed:
                    assert step.status == OK
                    assert s.log[-1][:2] == (1, "logStatusWarning")
                else:
                    assert step.status == DISCARD
                    assert s.log[-1][:2] == (DISCARD, "logStatusDiscard")
                assert "fmi3DoStep: t = " in s.said
            time, count = step.time, count + 1
        assert count > 2
        ends.append(s.outputs())
        s.free()
    assert ends[0] == ends[1]


def fmi3_states_are_restored_to_the_bit(fmu: Fmu3) -> None:
    """In the same instance, in another one after serialization, and beyond a discarded step."""
    s = Slave3(fmu).start()
    torque(s, 1.3)
    s.run(5)
    state = c_void_p()
    assert s.call("fmi3GetFMUState", ctypes.byref(state)) == OK
    expected = s.run(8, first=5)
    torque(s, -4.0)
    s.run(3, first=13)
    torque(s, 1e300)
    assert s.step(16 * SIZE, SIZE).status == DISCARD
    assert s.call("fmi3SetFMUState", state) == OK
    assert s.run(8, first=5) == expected
    size = c_size_t()
    assert s.call("fmi3SerializedFMUStateSize", state, ctypes.byref(size)) == OK
    content = (ctypes.c_ubyte * size.value)()
    assert s.call("fmi3SerializeFMUState", state, content, size) == OK
    other, found = Slave3(fmu), c_void_p()
    assert other.call("fmi3DeserializeFMUState", content, size, ctypes.byref(found)) == OK
    assert other.call("fmi3SetFMUState", found) == OK
    assert other.run(8, first=5) == expected
    s.log.clear()
    status = s.call("fmi3SerializeFMUState", state, content, c_size_t(8))
    expect(s, status, ERROR, "size: found 8", "returned by fmi3SerializedFMUStateSize")
    content[20] ^= 1
    status = other.call("fmi3DeserializeFMUState", content, size, ctypes.byref(found))
    expect(other, status, ERROR, "fmi3DeserializeFMUState: ")
    content[0] ^= 1
    status = other.call("fmi3DeserializeFMUState", content, size, ctypes.byref(found))
    expect(other, status, ERROR, "bytes written by fmi3SerializeFMUState")
    expect(s, s.call("fmi3SetFMUState", found), ERROR, "FMU state: found an unknown one")
    expect(s, s.call("fmi3SetFMUState", None), ERROR, "FMU state: found a null pointer")
    assert s.call("fmi3FreeFMUState", ctypes.byref(state)) == OK
    assert not state.value
    other.free()
    s.free()


def fmi3_reset_gives_a_fresh_instance(fmu: Fmu3) -> None:
    expected = life(Slave3(fmu).start())
    s = Slave3(fmu)
    assert s.set({"crank.m": 4.0, "drive.tau": -3.0}) == OK
    s.start().run(7)
    assert s.call("fmi3Reset") == OK
    assert life(s.start()) == expected


def fmi3_logging_follows_the_categories(fmu: Fmu3) -> None:
    """Texts are no formats in FMI 3.0: % is not doubled."""
    s = Slave3(fmu, name="50% of % the plant", logging_on=True).start()
    assert [category for _, category, _ in s.log] == ["logEvents"] * len(s.log)
    assert "50% of % the plant is now in initialization mode" in [text for _, _, text in s.log]
    s.log.clear()
    only = (ctypes.c_char_p * 1)(b"logStatusDiscard")
    assert s.call("fmi3SetDebugLogging", c_bool(True), c_size_t(1), only) == OK
    assert s.step(0.0, -1.0).status == ERROR
    assert s.log == []
    assert s.call("fmi3SetDebugLogging", c_bool(True), c_size_t(0), None) == OK
    unknown = (ctypes.c_char_p * 1)(b"100%")
    status = s.call("fmi3SetDebugLogging", c_bool(True), c_size_t(1), unknown)
    expect(s, status, ERROR, "category: found '100%', expected one of logAll, logEvents")


def fmi3_features_that_do_not_exist_say_so(fmu: Fmu3) -> None:
    s = Slave3(fmu).start()
    nothing = [c_void_p(None)] * 6
    expect(s, s.call("fmi3EnterStepMode"), ERROR, "fmi3EnterStepMode: ", "no event mode")
    expect(s, s.call("fmi3EvaluateDiscreteStates"), ERROR, "providesEvaluateDiscreteStates")
    for function in ("GetNumberOfVariableDependencies", "GetVariableDependencies"):
        expect(s, s.call(f"fmi3{function}", *nothing), ERROR, "modelDescription.xml")
    for function in ("EnterEventMode", "UpdateDiscreteStates", "SetTime", "GetNumberOfEventIndicators"):
        status = s.call(f"fmi3{function}", *nothing)
        expect(
            s, status, ERROR, f"fmi3{function}: is a function for model exchange; this instance is for co-"
        )
    s.run(2)


def fmi3_every_function_survives_null(fmu: Fmu3) -> None:
    """All arguments null or zero, without an instance and with one in each mode."""
    assert len(FUNCTIONS) == 75
    functions = [
        name
        for name in FUNCTIONS
        if not name.startswith(("fmi3Instantiate", "fmi3GetVersion", "fmi3FreeInstance", "fmi3Reset"))
        and not name.startswith(("fmi3Enter", "fmi3Exit", "fmi3Terminate"))
    ]
    nothing = [c_void_p(None)] * 9

    def all_functions(s: Slave3) -> None:
        for function in functions:
            s.log.clear()
            status = s.call(function, *nothing)
            assert status in (OK, DISCARD, ERROR), function
            assert len(s.log) == (1 if status != OK and s.instance else 0), (function, s.log)
            logs = s.call("fmi3SetDebugLogging", c_bool(True), c_size_t(0), None)
            assert logs == (OK if s.instance else ERROR)
        s.log.clear()

    s = Slave3(fmu, token="wrong")
    all_functions(s)
    for function in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset"):
        assert s.call(f"fmi3{function}", *nothing) == ERROR
    s.free()
    s = Slave3(fmu)
    all_functions(s)
    assert s.enter() == OK
    all_functions(s)
    assert s.leave() == OK
    all_functions(s)
    s.run(2)
    assert s.call("fmi3Terminate") == OK
    all_functions(s)
    s.free()


def fmi3_interleaved_instances_are_as_alone(fmu: Fmu3) -> None:
    expected = life(Slave3(fmu).start())
    first, second = Slave3(fmu).start(), Slave3(fmu).start()
    torque(second, -1.0)
    second.run(4)
    assert life(first) == expected
    first.free()
    second.run(1, first=4)
    second.free()
