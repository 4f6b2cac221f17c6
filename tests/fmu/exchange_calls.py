# SPDX-License-Identifier: BSD-3-Clause
"""What importers do to an FMU for model exchange, right and wrong."""

from __future__ import annotations

import math
import random
from ctypes import c_double, c_int, c_size_t, c_void_p

from fmu.host import DISCARD, ERROR, OK, Fmu, Slave, expect
from fmu.importer import EventInfo, Importer
from fmu.states import deserialize, get_state, serialized, set_state


def functions_for_co_simulation_say_so(fmu: Fmu) -> None:
    s = Importer(fmu).start()
    before = s.rates()
    one, real = c_size_t(1), (c_double * 1)()
    status = (c_int * 1)()
    expect(s, s.step(0.0, 0.1), ERROR, "fmi2DoStep: is a function for co-simulation", "for model exchange")
    tau = s.references(["drive.tau"])
    for function, *arguments in (
        ("fmi2CancelStep",),
        ("fmi2GetBooleanStatus", c_int(3), status),
        ("fmi2SetRealInputDerivatives", tau, one, (c_int * 1)(1), real),
        ("fmi2GetRealOutputDerivatives", s.references(["A.w"]), one, (c_int * 1)(1), real),
    ):
        expect(s, s.call(function, *arguments), ERROR, f"{function}: is a function for co-simulation")
    assert s.rates() == before
    s.free()


def exchange_out_of_order_is_refused(fmu: Fmu) -> None:
    s = Importer(fmu)
    expect(s, s.set_time(0.0), ERROR, "fmi2SetTime: called before fmi2EnterInitializationMode", "event mode")
    assert s.setup() == s.enter() == s.leave() == OK
    expect(s, s.call("fmi2EnterEventMode"), ERROR, "called in event mode, expected in continuous-time mode")
    status = s.call("fmi2EnterContinuousTimeMode")
    expect(s, status, ERROR, "fmi2EnterContinuousTimeMode: called before fmi2NewDiscreteStates")
    s.event()
    s.go_on()
    info = EventInfo()
    expect(s, s.new_discrete_states(info), ERROR, "called in continuous-time mode, expected in event mode")
    expect(s, s.set({"crank.m": 2.0}), ERROR, "crank.m is a fixed parameter")
    expect(s, s.set({"A.damping": 0.3}), ERROR, "A.damping is a tunable parameter", "only in event mode")
    s.enter_event_mode()
    assert s.set({"A.damping": 0.3}) == OK, s.said
    assert s.call("fmi2Terminate") == OK
    assert all(map(math.isfinite, s.rates()))  # the last values can still be read
    expect(s, s.set_time(1.0), ERROR, "called after fmi2Terminate")
    s.free()


def wrong_arrays_are_refused(fmu: Fmu) -> None:
    s = Importer(fmu).start()
    x, rates = s.states(), s.rates()
    expect(s, s.set_states([*x, 0.0]), ERROR, "states: found 3 numbers, expected 2")
    expect(s, s.set_states([math.nan, x[1]]), ERROR, "A.phi: found NaN, expected a finite number")
    expect(s, s.set_states([x[0] + 1, math.inf]), ERROR, "A.w: found Infinity")
    expect(s, s.set_time(math.nan), ERROR, "time: found NaN")
    for function in ("fmi2GetDerivatives", "fmi2GetContinuousStates", "fmi2GetNominalsOfContinuousStates"):
        expect(s, s.read_states(function, 1)[0], ERROR, f"{function}: ", "found 1 numbers, expected 2")
        expect(s, s.call(function, None, c_size_t(2)), ERROR, "found a null pointer, expected an array of 2")
    expect(s, s.read_states("fmi2GetEventIndicators", 1)[0], ERROR, "found 1 numbers, expected 0")
    expect(s, s.call("fmi2CompletedIntegratorStep", c_int(1), None, None), ERROR, "found a null pointer")
    s.enter_event_mode()
    expect(s, s.new_discrete_states(None), ERROR, "event information: found a null pointer")
    s.event()
    s.go_on()
    assert s.states() == x  # a call that is refused sets nothing
    assert s.rates() == rates
    s.free()


def states_in_any_order_give_the_same_bits(fmu: Fmu) -> None:
    """Near each other and far apart, with outputs read in between or not."""
    s = Importer(fmu).start()
    start = s.states()
    draw = random.Random(3)
    offsets = [10.0 ** draw.uniform(-9, 0) for _ in range(40)]
    points = [[start[0] + d, start[1] + draw.uniform(-2, 2), *start[2:]] for d in offsets]
    seen: dict[int, tuple[list[float], list[float]]] = {}
    for k in [draw.randrange(len(points)) for _ in range(200)]:
        s.go_to(0.0, points[k])
        found = s.rates(), s.outputs()
        assert seen.setdefault(k, found) == found
        if draw.random() < 0.3:
            s.go_to(0.0, points[draw.randrange(len(points))])
    assert len(seen) == len(points)
    s.free()


def _walk(s: Importer, seed: int) -> list[list[float]]:
    """Some steps of Euler's method, completed or not, with another torque now and then."""
    draw = random.Random(seed)
    rows = []
    t = 0.0
    for k in range(30):
        x, rate = s.states(), s.rates()
        h = draw.uniform(1e-4, 5e-3)
        t += h
        s.go_to(t, [a + h * b for a, b in zip(x, rate, strict=True)])
        if k % 3 == 0:
            assert s.set_real(drive__tau=draw.uniform(-3, 3)) == OK
        if k % 2 == 0 and s.completed():
            s.enter_event_mode()
            s.event()
            s.go_on()
        rows.append([*s.states(), *s.rates(), *s.indicators(), *s.outputs()])
    return rows


def a_restored_exchange_continues_with_the_same_bits(fmu: Fmu) -> None:
    s = Importer(fmu).start()
    _walk(s, 1)
    saved = get_state(s)
    content = serialized(s, saved)
    first = _walk(s, 2)
    set_state(s, saved)
    assert _walk(s, 2) == first
    other = Importer(fmu)
    state = c_void_p()
    assert deserialize(other, content, state) == OK, other.said
    set_state(other, state)
    assert _walk(other, 2) == first
    s.free()
    other.free()


def states_of_the_other_kind_are_refused(fmu: Fmu) -> None:
    outside, inside = Importer(fmu).start(), Slave(fmu).start()
    for giver, taker, words in (
        (outside, inside, "found a state of an instance for model exchange, expected one for co-simulation"),
        (inside, outside, "found a state of an instance for co-simulation, expected one for model exchange"),
    ):
        state = c_void_p()
        assert deserialize(taker, serialized(giver, get_state(giver)), state) == OK
        expect(taker, taker.call("fmi2SetFMUstate", state), ERROR, words)
        assert all(map(math.isfinite, taker.outputs()))
    inside.run(2)
    outside.rates()
    inside.free()
    outside.free()


def states_far_from_all_others_are_discarded(fmu: Fmu) -> None:
    """The instance continues at states that make sense."""
    s = Importer(fmu).start()
    x, rates = s.states(), s.rates()
    for far in (1e6, 1e300):
        assert s.set_states([far, *x[1:]]) == OK
        expect(s, s.read_states("fmi2GetDerivatives", len(x))[0], DISCARD, "fmi2GetDerivatives: t = 0 s: ")
    s.go_to(0.0, x)
    assert s.rates() == rates
    s.free()
