# SPDX-License-Identifier: BSD-3-Clause
"""FMU states: what is saved is everything that decides how a run goes on."""

from __future__ import annotations

import ctypes
import math
import re
import struct
from ctypes import c_char, c_double, c_int, c_size_t, c_void_p
from itertools import product

from fmu.host import DISCARD, ERROR, OK, Fmu, Slave, expect


def get_state(s: Slave, over: c_void_p | None = None) -> c_void_p:
    state = over if over is not None else c_void_p()
    assert s.call("fmi2GetFMUstate", ctypes.byref(state)) == OK, s.said
    return state


def set_state(s: Slave, state: c_void_p) -> None:
    assert s.call("fmi2SetFMUstate", state) == OK, s.said


def serialized(s: Slave, state: c_void_p) -> bytes:
    size = c_size_t()
    assert s.call("fmi2SerializedFMUstateSize", state, ctypes.byref(size)) == OK, s.said
    room = (c_char * size.value)()
    assert s.call("fmi2SerializeFMUstate", state, room, size) == OK, s.said
    return room.raw


def deserialize(s: Slave, content: bytes, state: c_void_p) -> int:
    return s.call(
        "fmi2DeSerializeFMUstate",
        ctypes.create_string_buffer(content, len(content)),
        c_size_t(len(content)),
        ctypes.byref(state),
    )


def everything(s: Slave) -> list[float]:
    """All reals: counts of steps and evaluations, too."""
    names = [v.name for v in s.fmu.description.modelVariables if v.type == "Real"]
    values = (c_double * len(names))()
    assert s.call("fmi2GetReal", s.references(names), c_size_t(len(names)), values) == OK, s.said
    return list(values)


def drive(s: Slave, first: int, steps: int, size: float = 2e-2) -> list[list[float]]:
    """Under another torque now and then, held in between."""
    rows = []
    for k in range(first, first + steps):
        if k % 3 == 0:
            assert s.set_real(drive__tau=3 * math.sin(0.7 * k)) == OK
        assert s.step(k * size, size) == OK, s.said
        rows.append(everything(s))
    return rows


def choice(of: Fmu, name: str) -> dict[str, int]:
    """The words of a choice with their numbers, as its description tells them: ": 1 auto, 2 erk"."""
    (variable,) = (v for v in of.description.modelVariables if v.name == name)
    found = {word: int(n) for n, word in re.findall(r"(?<=[:,] )(\d+) ([\w-]+)", variable.description)}
    assert [*found.values()] == [*range(1, int(variable.max) + 1)]
    return found


def with_methods(of: Fmu, formulation: int, integrator: int) -> Slave | None:
    """A slave at t = 0; none where the two do not go together."""
    s = Slave(of)
    methods: dict[str, float] = {"solver.formulation": formulation, "solver.integrator": integrator}
    assert s.set(methods, "fmi2SetInteger", c_int) == OK, s.said
    assert s.setup() == OK
    assert s.enter() == OK
    if s.leave() != OK:
        assert "expected" in s.said
        return None
    return s


def a_run_goes_on_from_a_state_to_the_bit(fmu: Fmu) -> None:
    """With every formulation and integrator: in the same instance, and from bytes in another one."""
    ran = set()
    for (formulation, f), (integrator, i) in product(
        choice(fmu, "solver.formulation").items(), choice(fmu, "solver.integrator").items()
    ):
        s = with_methods(fmu, f, i)
        if s is None:
            continue
        ran.add((formulation, integrator))
        drive(s, 0, 10)
        state = get_state(s)
        there = everything(s)
        expected = drive(s, 10, 10)
        set_state(s, state)
        assert everything(s) == there, (formulation, integrator)
        assert drive(s, 10, 10) == expected, (formulation, integrator)
        fresh = Slave(fmu)  # not even initialized
        copy = c_void_p()
        assert deserialize(fresh, serialized(s, state), copy) == OK, fresh.said
        set_state(fresh, copy)
        assert everything(fresh) == there, (formulation, integrator)
        assert drive(fresh, 10, 10) == expected, (formulation, integrator)
        s.free()
        fresh.free()
    assert {name for name, _ in ran} == set(choice(fmu, "solver.formulation"))
    assert {name for _, name in ran} == set(choice(fmu, "solver.integrator"))


def saving_changes_no_bit_of_a_run(fmu: Fmu) -> None:
    """With every integrator. Counts apart: the derivative at a saved state is computed again."""
    methods = choice(fmu, "solver.integrator")
    for name in methods:
        runs = []
        for saving in (False, True):
            s = with_methods(fmu, choice(fmu, "solver.formulation")["projection"], methods[name])
            assert s is not None
            rows = []
            for k in range(0, 60, 3):
                drive(s, k, 3)
                rows.append(s.outputs())
                if saving:
                    get_state(s)
            runs.append(rows)
            s.free()
        assert runs[0] == runs[1], name


def a_state_brings_settings_and_time_along(fmu: Fmu) -> None:
    s = Slave(fmu)
    assert s.set({"crank.m": 1.7, "A.phi_start": 1.1, "solver.tolerance": 1e-8, "gravity[3]": -3.7}) == OK
    assert s.set({"A.fixed": 1}, "fmi2SetBoolean", c_int) == OK
    assert s.setup(start=2.0, stop=9.0) == OK
    assert s.enter() == OK
    assert s.leave() == OK
    assert s.step(2.0, 0.25) == OK
    assert s.set({"A.damping": 0.9, "gravity[3]": -1.6}) == OK  # tuned
    assert s.step(2.25, 0.25) == OK
    state = get_state(s)
    content = serialized(s, state)
    there = everything(s)

    def go_on(slave: Slave) -> list[float]:
        assert slave.step(2.5, 0.25) == OK, slave.said
        return everything(slave)

    expected = go_on(s)
    for other in (Slave(fmu), Slave(fmu).start()):
        copy = c_void_p()
        assert deserialize(other, content, copy) == OK, other.said
        set_state(other, copy)
        assert everything(other) == there
        assert other.get("A.fixed", "fmi2GetBoolean", c_int) == 1
        assert go_on(other) == expected
        expect(other, other.step(2.75, 20.0), ERROR, "beyond the stop time 9 s")
    assert s.set({"A.damping": 0.1}) == OK
    set_state(s, state)
    assert everything(s) == there
    assert go_on(s) == expected


def what_is_tuned_is_not_forgotten_on_the_way(fmu: Fmu) -> None:
    """A damper made stronger within a run: a state saved later knows that it was weaker before."""
    formulations, integrators = (choice(fmu, f"solver.{of}") for of in ("formulation", "integrator"))
    s = with_methods(fmu, formulations["projection"], integrators["cvode"])
    assert s is not None
    rows, state = [], None
    for k in range(60):
        if k == 20:
            assert s.set({"A.damping": 0.9}) == OK, s.said
        if k == 40:
            state = get_state(s)
        assert s.step(k * 1e-2, 1e-2) == OK, s.said
        rows.append(s.outputs())
    assert state is not None
    set_state(s, state)
    for k in range(40, 60):
        assert s.step(k * 1e-2, 1e-2) == OK, s.said
        assert s.outputs() == rows[k], k


def states_of_all_modes(fmu: Fmu) -> None:
    usual = Slave(fmu).start().run(3)
    s = Slave(fmu)
    s.set_real(drive__tau=0.0)
    fresh = get_state(s)
    assert s.setup() == OK
    assert s.enter() == OK
    initial = get_state(s)
    assert s.leave() == OK
    ready = get_state(s)
    s.run(2)
    s.set_real(drive__tau=1e300)
    assert s.step(0.02, 0.01) == DISCARD
    s.log.clear()
    assert s.call("fmi2Terminate") == OK
    ended = get_state(s)
    set_state(s, ready)
    assert s.run(3) == usual
    set_state(s, initial)
    assert s.set({"A.phi_start": 1.2}) == OK
    assert s.leave() == OK
    assert s.run(3) != usual
    set_state(s, fresh)
    assert s.start().run(3) == usual
    set_state(s, ended)
    s.log.clear()
    expect(s, s.step(0.02, 0.01), ERROR, "called after fmi2Terminate")


def a_state_is_written_over_and_used_often(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    state = get_state(s)
    where = state.value
    s.run(4)
    get_state(s, over=state)
    assert state.value == where
    later = s.outputs()
    for _ in range(3):
        s.run(2, first=4)
        set_state(s, state)
        assert s.outputs() == later


def states_that_are_none_are_refused(fmu: Fmu) -> None:
    s, other = Slave(fmu).start(), Slave(fmu).start()
    s.run(2)
    before = s.outputs()
    foreign = get_state(other)
    freed = get_state(s)
    assert s.call("fmi2FreeFMUstate", ctypes.byref(c_void_p(freed.value))) == OK
    for state, found in (
        (c_void_p(), "a null pointer"),
        (foreign, "an unknown one"),
        (freed, "an unknown one"),
    ):
        for function in ("fmi2SetFMUstate", "fmi2SerializedFMUstateSize"):
            expect(s, s.call(function, state, None), ERROR, f"{function}: FMU state: found {found}")
        if state.value is not None:
            expect(s, s.call("fmi2FreeFMUstate", ctypes.byref(state)), ERROR, f"found {found}")
    expect(s, s.call("fmi2GetFMUstate", None), ERROR, "found a null pointer, expected a place for the result")
    assert s.call("fmi2FreeFMUstate", None) == OK
    assert s.call("fmi2FreeFMUstate", ctypes.byref(c_void_p())) == OK
    own = get_state(s)
    expect(s, s.call("fmi2SerializedFMUstateSize", own, None), ERROR, "size: found a null pointer")
    room, size = (c_char * 8)(), c_size_t(8)
    expect(s, s.call("fmi2SerializeFMUstate", own, room, size), ERROR, "size: found 8, expected ")
    expect(s, s.call("fmi2SerializeFMUstate", own, None, size), ERROR, "bytes: found a null pointer")
    assert s.outputs() == before


def a_pointer_that_is_not_initialized_gets_a_new_state(fmu: Fmu) -> None:
    """As some masters give it; a state of another instance is not written over."""
    s, other = Slave(fmu).start(), Slave(fmu).start()
    other.run(1)
    foreign = get_state(other)
    there = serialized(other, foreign)
    s.run(3)
    here = s.outputs()
    number = c_double(1)
    for given in (foreign.value, 1, 0xDEADBEEF, ctypes.addressof(number)):
        state = c_void_p(given)
        assert s.call("fmi2GetFMUstate", ctypes.byref(state)) == OK, s.said
        assert state.value != given
        s.run(2, first=3)
        set_state(s, state)
        assert s.outputs() == here
    assert serialized(other, foreign) == there


def checksum(content: bytes) -> int:
    """FNV-1a, 64 bit."""
    number = 0xCBF29CE484222325
    for byte in content:
        number = (number ^ byte) * 0x100000001B3 % 2**64
    return number


def damaged_bytes_are_refused(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.run(3)
    good = serialized(s, get_state(s))
    before = everything(s)
    guid = good[16:52]
    damaged = {
        b"": "found 0 bytes",
        good[:20]: "found 20 bytes",
        good[:-8]: "bytes, expected the number returned by fmi2SerializedFMUstateSize",
        good + bytes(8): "bytes, expected the number returned by fmi2SerializedFMUstateSize",
        b"x" + good[1:]: "not a saved state",
        good[:8] + b"\x07" + good[9:]: "layout 7, expected layout 1",
        good.replace(guid, bytes(reversed(guid))): "a state of another FMU",
    }
    for k in range(64, len(good), 41):
        damaged[good[:k] + bytes([good[k] ^ 1]) + good[k + 1 :]] = "a state with a wrong checksum"
    for content, words in damaged.items():
        state = c_void_p()
        status = deserialize(s, content, state)
        expect(s, status, ERROR, "fmi2DeSerializeFMUstate: found ", words, "expected ")
        assert state.value is None
    for arguments in ((None, c_size_t(3), ctypes.byref(c_void_p())), (good, c_size_t(len(good)), None)):
        expect(s, s.call("fmi2DeSerializeFMUstate", *arguments), ERROR, "found a null pointer, expected ")
    assert everything(s) == before


def forged_bytes_do_no_harm(fmu: Fmu) -> None:
    """Each word in turn replaced, under a right checksum: taken or refused, the plant goes on."""
    s = Slave(fmu).start()
    s.run(3)
    own = get_state(s)
    good = serialized(s, own)
    expected = s.run(2, first=3)
    forgeries = (struct.pack("<q", -1), struct.pack("<q", 2**40), struct.pack("<d", math.nan), bytes(8))
    refused = 0
    for k in range(64, len(good) - 8, 8):
        for word in forgeries:
            content = good[:k] + word + good[k + 8 : -8]
            state = c_void_p()
            assert deserialize(s, content + struct.pack("<Q", checksum(content)), state) == OK, s.said
            status = s.call("fmi2SetFMUstate", state)
            assert status in (OK, ERROR)
            refused += status == ERROR
            if status == ERROR:
                assert s.said.startswith("fmi2SetFMUstate: "), s.said
            s.step(3e-2, 1e-2)
            assert s.call("fmi2FreeFMUstate", ctypes.byref(state)) == OK
            set_state(s, own)
    assert refused > 20
    assert s.run(2, first=3) == expected
