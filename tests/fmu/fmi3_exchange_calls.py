# SPDX-License-Identifier: BSD-3-Clause
"""What importers of FMI 3.0 do to an FMU for model exchange, right and wrong."""

from __future__ import annotations

import ctypes
import math
from ctypes import c_bool, c_double, c_int32, c_size_t, c_void_p

from fmu.fmi3_calls import FUNCTIONS
from fmu.host import DISCARD, ERROR, OK
from fmu.host3 import Fmu3, Slave3, expect
from fmu.importer3 import Importer3


def fmi3_functions_for_co_simulation_say_so(fmu: Fmu3) -> None:
    s = Importer3(fmu).start()
    before = s.rates()
    status = s.step(0.0, 0.1).status
    expect(s, status, ERROR, "fmi3DoStep: is a function for co-simulation", "for model exchange")
    one, real = c_size_t(1), (c_double * 1)()
    status = s.call("fmi3GetOutputDerivatives", s.references(["A.w"]), one, (c_int32 * 1)(1), real, one)
    expect(s, status, ERROR, "fmi3GetOutputDerivatives: is a function for co-simulation")
    expect(s, s.call("fmi3EnterStepMode"), ERROR, "fmi3EnterStepMode: ")
    assert s.rates() == before
    s.free()


def fmi3_exchange_out_of_order_is_refused(fmu: Fmu3) -> None:
    s = Importer3(fmu)
    assert (s.count("ContinuousStates"), s.count("EventIndicators")) == (2, 0)
    expect(s, s.set_time(0.0), ERROR, "fmi3SetTime: called before fmi3EnterInitializationMode", "event mode")
    assert s.enter() == s.leave() == OK
    expect(s, s.call("fmi3EnterEventMode"), ERROR, "called in event mode, expected in continuous-time mode")
    status = s.call("fmi3EnterContinuousTimeMode")
    expect(s, status, ERROR, "fmi3EnterContinuousTimeMode: called before fmi3UpdateDiscreteStates")
    s.event()
    s.go_on()
    expect(s, s.update()[0], ERROR, "called in continuous-time mode, expected in event mode")
    expect(s, s.set({"crank.m": 2.0}), ERROR, "crank.m is a fixed parameter")
    expect(s, s.set({"A.damping": 0.3}), ERROR, "A.damping is a tunable parameter", "only in event mode")
    s.enter_event_mode()
    assert s.set({"A.damping": 0.3}) == OK, s.said
    assert s.call("fmi3Terminate") == OK
    assert all(map(math.isfinite, s.rates()))  # the last values can still be read
    expect(s, s.set_time(1.0), ERROR, "called after fmi3Terminate")
    s.free()


def fmi3_wrong_arrays_are_refused(fmu: Fmu3) -> None:
    s = Importer3(fmu).start()
    x, rates = s.states(), s.rates()
    expect(s, s.set_states([*x, 0.0]), ERROR, "states: found 3 numbers, expected 2")
    expect(s, s.set_states([math.nan, x[1]]), ERROR, "A.phi: found NaN, expected a finite number")
    expect(s, s.set_time(math.nan), ERROR, "time: found NaN")
    for name in ("ContinuousStateDerivatives", "ContinuousStates", "NominalsOfContinuousStates"):
        expect(s, s.read(f"fmi3Get{name}", 1)[0], ERROR, f"fmi3Get{name}: ", "found 1 numbers, expected 2")
        status = s.call(f"fmi3Get{name}", None, c_size_t(2))
        expect(s, status, ERROR, "found a null pointer, expected an array of 2")
    expect(s, s.read("fmi3GetEventIndicators", 1)[0], ERROR, "found 1 numbers, expected 0")
    for name in ("ContinuousStates", "EventIndicators"):
        expect(s, s.call(f"fmi3GetNumberOf{name}", None), ERROR, "number: found a null pointer")
    expect(s, s.call("fmi3CompletedIntegratorStep", c_bool(True), None, None), ERROR, "found a null pointer")
    s.enter_event_mode()
    for place in range(6):
        expect(s, s.update(missing=place)[0], ERROR, "fmi3UpdateDiscreteStates: ", "found a null pointer")
    s.event()
    s.go_on()
    assert s.states() == x  # a call that is refused sets nothing
    assert s.rates() == rates
    s.free()


def fmi3_saved_states_of_model_exchange_are_restored_to_the_bit(fmu: Fmu3) -> None:
    def walk(s: Importer3) -> list[list[float]]:
        rows = []
        for k in range(12):
            h = 1e-3 * (1 + k % 3)
            s.go_to(0.1 * k, [a + h * b for a, b in zip(s.states(), s.rates(), strict=True)])
            assert s.set({"drive.tau": 0.3 * k}) == OK
            if k % 2 == 0 and s.completed():
                s.enter_event_mode()
                s.event()
                s.go_on()
            rows.append([*s.states(), *s.rates(), *s.outputs()])
        return rows

    s, state = Importer3(fmu).start(), c_void_p()
    walk(s)
    assert s.call("fmi3GetFMUState", ctypes.byref(state)) == OK
    first = walk(s)
    assert s.call("fmi3SetFMUState", state) == OK
    assert walk(s) == first
    size = c_size_t()
    assert s.call("fmi3SerializedFMUStateSize", state, ctypes.byref(size)) == OK
    content = (ctypes.c_ubyte * size.value)()
    assert s.call("fmi3SerializeFMUState", state, content, size) == OK
    inside, found = Slave3(fmu).start(), c_void_p()
    assert inside.call("fmi3DeserializeFMUState", content, size, ctypes.byref(found)) == OK
    status = inside.call("fmi3SetFMUState", found)
    expect(inside, status, ERROR, "a state of an instance for model exchange, expected one for co-simulation")
    inside.run(2)
    inside.free()
    s.free()


def fmi3_states_far_from_all_others_are_discarded(fmu: Fmu3) -> None:
    """The instance continues at states that make sense."""
    s = Importer3(fmu).start()
    x, rates = s.states(), s.rates()
    assert s.set_states([1e6, *x[1:]]) == OK
    name = "fmi3GetContinuousStateDerivatives"
    expect(s, s.read(name, len(x))[0], DISCARD, f"{name}: t = 0 s: ")
    s.go_to(0.0, x)
    assert s.rates() == rates
    s.free()


def fmi3_every_function_of_model_exchange_survives_null(fmu: Fmu3) -> None:
    left_out = (
        "fmi3Instantiate",
        "fmi3GetVersion",
        "fmi3FreeInstance",
        "fmi3Reset",
        "fmi3Terminate",
        "fmi3Exit",
    )
    functions = [name for name in FUNCTIONS if not name.startswith((*left_out, "fmi3Enter"))]
    s = Importer3(fmu)
    for change in (s.enter, s.leave, s.event, s.go_on, lambda: s.call("fmi3Terminate"), lambda: None):
        for function in functions:
            s.log.clear()
            status = s.call(function, *[c_void_p(None)] * 9)
            assert status in (OK, DISCARD, ERROR), function
            assert len(s.log) == (1 if status != OK else 0), (function, s.log)
            assert s.call("fmi3SetDebugLogging", c_bool(True), c_size_t(0), None) == OK
        change()
    s.free()
