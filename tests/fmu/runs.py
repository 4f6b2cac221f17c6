# SPDX-License-Identifier: BSD-3-Clause
"""What a master may do to an FMU, with what it has to give."""

from __future__ import annotations

import ctypes
import math
import os
import shutil
from ctypes import c_double, c_int, c_size_t, c_void_p

from fmu.host import DISCARD, ERROR, LAST_SUCCESSFUL_TIME, OK, TERMINATED, Fmu, Slave, expect
from fmu.states import deserialize, get_state, serialized, set_state


def instances_without_callbacks_work_in_silence(fmu: Fmu) -> None:
    for slave in (Slave(fmu, callbacks=False), Slave(fmu, logger=False)):
        assert slave.component
        assert slave.step(0.0, 0.1) == ERROR
        slave.start().run(3)
        slave.free()


def numbers_that_are_none_do_not_enter(fmu: Fmu) -> None:
    reference = Slave(fmu).start()
    reference.set_real(drive__tau=2.5)
    expected = reference.run(20)
    s = Slave(fmu).start()
    s.set_real(drive__tau=2.5)
    rows = s.run(10)
    for bad in (math.nan, math.inf, -math.inf):
        expect(
            s, s.set_real(drive__tau=bad), ERROR, "fmi2SetReal: drive.tau: found", "the value remains 2.5 N.m"
        )
        assert s.get("drive.tau") == 2.5
    rows += s.run(10, first=10)
    assert rows == expected  # to the bit


def a_refused_step_leaves_the_plant_where_it_was(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.run(5)
    before = s.outputs()
    s.set_real(drive__tau=1e300)
    expect(
        s, s.step(0.05, 0.01), DISCARD, "fmi2DoStep: t = ", "not finite", "state is unchanged at t = 0.05 s"
    )
    time, wish = c_double(), c_int()
    assert s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(time)) == OK
    assert s.call("fmi2GetBooleanStatus", c_int(TERMINATED), ctypes.byref(wish)) == OK
    assert wish.value == 1
    assert abs(time.value - 0.05) < 1e-15
    s.set_real(drive__tau=0.0)
    assert s.outputs() == before
    assert s.step(time.value, 0.01) == OK
    assert all(map(math.isfinite, s.outputs()))
    assert s.call("fmi2GetBooleanStatus", c_int(TERMINATED), ctypes.byref(wish)) == OK
    assert wish.value == 0


def push(s: Slave, *derivatives: float) -> int:
    """Sets the drive's torque's derivatives of order 1, 2, ..."""
    n = len(derivatives)
    orders, values = (c_int * n)(*range(1, n + 1)), (c_double * n)(*derivatives)
    return s.call("fmi2SetRealInputDerivatives", s.references(["drive.tau"] * n), c_size_t(n), orders, values)


def torques_follow_their_derivatives(fmu: Fmu) -> None:
    """One step of 0.1 s, and ten with the polynomial taken anew at each, within the tolerance of 1e-6."""
    whole, parts, held = (Slave(fmu).start() for _ in range(3))
    for s in (whole, held):
        s.set_real(drive__tau=1.0)
    assert push(whole, 40.0, -300.0) == OK
    assert whole.step(0.0, 0.1) == OK
    assert held.step(0.0, 0.1) == OK
    for k in range(10):
        t = 0.01 * k
        assert push(parts, 40.0 - 300.0 * t, -300.0) == OK  # before the value or after: it is all one
        parts.set_real(drive__tau=1.0 + 40.0 * t - 150.0 * t * t)
        assert parts.step(t, 0.01) == OK
    for s in (whole, parts):
        assert abs(s.get("drive.tau") - 3.5) < 1e-14
    difference = max(abs(a - b) for a, b in zip(whole.outputs(), parts.outputs(), strict=True))
    assert difference < 1e-4  # of accelerations, 100 times the tolerance
    assert abs(whole.get("A.phi") - held.get("A.phi")) > 1e-3
    assert whole.step(0.1, 0.1) == OK  # over which it is held
    assert abs(whole.get("drive.tau") - 3.5) < 1e-14


def torques_follow_derivatives_set_before_the_run(fmu: Fmu) -> None:
    """As fmi2SetReal: from instantiation on, kept when a parameter changes what is assembled."""
    ends = []
    for moment in range(3):
        s = Slave(fmu)
        for k, act in enumerate((s.setup, s.enter, s.leave)):
            if k == moment:
                assert push(s, 5.0, 60.0) == OK
            assert act() == OK
            if k == 1:
                s.get("A.a")  # assembles
                assert s.set({"crank.m": 1.3}) == OK
        assert s.step(0.0, 0.1) == OK
        assert abs(s.get("drive.tau") - 0.8) < 1e-15
        ends.append(s.outputs())
    assert ends[1:] == ends[:1] * 2


def status_of_step(s: Slave) -> tuple[float, bool]:
    """The last successful time [s], and whether the plant wishes to end."""
    time, wish = c_double(), c_int()
    assert s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(time)) == OK
    assert s.call("fmi2GetBooleanStatus", c_int(TERMINATED), ctypes.byref(wish)) == OK
    return time.value, bool(wish.value)


def steps_that_take_too_much_are_cut_short(fmu: Fmu) -> None:
    whole = Slave(fmu).start()
    assert whole.step(0.0, 0.8) == OK
    s = Slave(fmu)
    assert s.get("solver.max_evaluations", "fmi2GetInteger", c_int) == 1_000_000
    assert s.set({"solver.max_evaluations": 50}, "fmi2SetInteger", c_int) == OK
    s.start()
    count, t = 0, 0.0
    while (status := s.step(t, 0.8 - t)) != OK:
        words = (
            "fmi2DoStep: t = ",
            "the step to 0.8 s ended here",
            "50 evaluations",
            "can continue from the state at t = ",
        )
        expect(s, status, DISCARD, *words)
        reached, wish = status_of_step(s)
        assert t < reached < 0.8
        assert not wish
        assert all(map(math.isfinite, s.outputs()))
        assert s.get("constraints.position") < 1e-12
        expect(s, s.step(t, 0.8 - t), ERROR, "the plant is at t = ", "cannot go back")
        count, t = count + 1, reached
    assert count > 1, s.get("solver.evaluations")
    time, wish = status_of_step(s)
    assert abs(time - 0.8) < 1e-15
    assert not wish
    difference = max(abs(a - b) for a, b in zip(s.outputs(), whole.outputs(), strict=True))
    assert difference < 1e-9  # the same steps; t + (0.8 - t) may be another 0.8
    s.run(1, 0.01, first=80)


def shortened_steps_keep_the_torque_moving(fmu: Fmu) -> None:
    s = Slave(fmu)
    assert s.set({"solver.max_evaluations": 60}, "fmi2SetInteger", c_int) == OK
    s.start()
    assert push(s, 4.0, 10.0) == OK
    assert s.step(0.0, 0.5) == DISCARD
    t, _ = status_of_step(s)
    assert 0.0 < t < 0.5
    assert abs(s.get("drive.tau") - (4.0 * t + 5.0 * t * t)) < 1e-14
    while s.step(t, 0.5 - t) == DISCARD:
        t, _ = status_of_step(s)
    assert abs(s.get("drive.tau") - 3.25) < 1e-14


def start_values_that_cannot_be_assembled_can_be_mended(fmu: Fmu) -> None:
    s = Slave(fmu)
    assert s.setup() == OK
    assert s.enter() == OK
    # Fixed at angles that tear the loop apart.
    for joint, angle in {"A": 1.0, "B": 1.0, "C": 1.0, "D": 1.0}.items():
        assert s.set({f"{joint}.phi_start": angle}) == OK
        assert s.set({f"{joint}.fixed": 1}, "fmi2SetBoolean", c_int) == OK
    expect(s, s.leave(), ERROR, "fmi2ExitInitializationMode: ", "cannot be closed", "closure error")
    for joint in "BCD":
        assert s.set({f"{joint}.fixed": 0}, "fmi2SetBoolean", c_int) == OK
    assert s.leave() == OK, s.said
    assert abs(s.get("A.phi") - 1.0) < 1e-15
    s.run(2)


def parameters_act(fmu: Fmu) -> None:
    usual = Slave(fmu).start().run(5)
    for name, factor in {"crank.m": 1.1, "coupler.com[1]": 0.9, "A.damping": 3.0, "gravity[2]": 0.5}.items():
        s = Slave(fmu)
        value = s.get(name) * factor
        assert s.set({name: value}) == OK
        assert s.start().run(5) != usual
        assert s.get(name) == value


def setting_what_is_set_already_changes_nothing(fmu: Fmu) -> None:
    """Masters write all start values back; a guess must stay a guess."""
    usual = Slave(fmu).start().run(5)
    s = Slave(fmu)
    for v in fmu.description.modelVariables:
        if v.causality == "parameter":
            kind = {
                "Real": ("fmi2GetReal", "fmi2SetReal", c_double),
                "Boolean": ("fmi2GetBoolean", "fmi2SetBoolean", c_int),
            }
            getter, setter, ctype = kind.get(v.type, ("fmi2GetInteger", "fmi2SetInteger", c_int))
            assert s.set({v.name: s.get(v.name, getter, ctype)}, setter, ctype) == OK, s.said
    assert s.start().run(5) == usual


def of_two_wishes_for_the_scenes_tolerance_the_finer_counts(fmu: Fmu) -> None:
    """Some masters set all parameters to their start values and ask for 0.1, which they have from nowhere."""
    own = {"solver.tolerance": Slave(fmu).get("solver.tolerance")}

    def life(wish: float | None, before: dict[str, float], within: dict[str, float]) -> list[list[float]]:
        s = Slave(fmu)
        assert not before or s.set(before) == OK
        assert s.setup(tolerance=wish) == OK
        assert s.enter() == OK
        assert s.set_real(drive__tau=2.0) == OK
        s.outputs()  # assembled
        assert not within or s.set(within) == OK
        kept = get_state(s)
        other = Slave(fmu)
        copied = c_void_p()
        assert deserialize(other, serialized(s, kept), copied) == OK, other.said
        set_state(other, copied)
        assert s.leave() == other.leave() == OK
        rows = s.run(20)
        assert other.run(20) == rows
        return rows

    plain = life(None, {}, {})
    assert life(0.1, {}, {}) != plain  # a wish alone counts
    assert life(0.1, own, {}) == plain
    assert life(0.1, {}, own) == plain
    assert life(1e-9, own, {}) == life(1e-9, {}, {}) != plain
    assert life(0.1, {"solver.tolerance": 1e-9}, {}) == life(1e-9, {}, {})


def reset_gives_a_fresh_instance(fmu: Fmu) -> None:
    fresh = Slave(fmu).start()
    fresh.set_real(drive__tau=1.7)
    expected = fresh.run(15)
    s = Slave(fmu)
    s.set_real(crank__m=4.0, drive__tau=-3.0)
    s.start().run(7)
    assert s.call("fmi2Terminate") == OK
    assert s.call("fmi2Reset") == OK
    s.start()
    assert s.get("drive.tau") == 0.0
    s.set_real(drive__tau=1.7)
    assert s.run(15) == expected


def interleaved_instances_are_as_alone(fmu: Fmu) -> None:
    torques = [0.3 * k - 1.1 for k in range(6)]
    alone = []
    for torque in torques:
        s = Slave(fmu).start()
        s.set_real(drive__tau=torque)
        alone.append(s.run(12))
        s.free()
    slaves = [Slave(fmu).start() for _ in torques]
    for s, torque in zip(slaves, torques, strict=True):
        s.set_real(drive__tau=torque)
    rows: list[list[list[float]]] = [[] for _ in torques]
    for k in range(12):
        for s, found in zip(slaves, rows, strict=True):
            found += s.run(1, first=k)
    assert rows == alone


def clocks_that_round_differently_see_the_same_plant(fmu: Fmu) -> None:
    multiplied = Slave(fmu).start()
    summed = Slave(fmu).start()
    size, time, count = 1e-3, 0.0, 700
    for k in range(count):
        assert multiplied.step(k * size, (k + 1) * size - k * size) == OK, multiplied.said
        assert summed.step(time, size) == OK, summed.said
        time += size
    assert time != count * size  # the clocks do differ
    assert multiplied.outputs() == summed.outputs()


def resource_locations_of_all_kinds(fmu: Fmu) -> None:
    target = fmu.folder.parent / "a room with spaces, 100% Ünïcode"
    shutil.copytree(fmu.folder / "resources", target, dirs_exist_ok=True)
    plain = str(target)
    escaped = target.as_uri().removeprefix("file://")
    for location in (
        f"file:{escaped}",
        f"file://{escaped}",
        f"file:///{escaped}",
        f"file://localhost{escaped}",
        f"FILE://{escaped}",
        f"file://{escaped}/",
        plain,
        plain + "/",
        os.path.relpath(plain),
    ):
        s = Slave(fmu, resources=location)
        assert s.component, (location, s.log)
        s.free()


def logging_follows_the_categories(fmu: Fmu) -> None:
    s = Slave(fmu, name="50% of % the plant", logging_on=True).start()
    assert [category for _, category, _ in s.log] == ["logEvents"] * len(s.log)
    assert len(s.log) >= 3
    assert "50% of % the plant is now in initialization mode" in [text for _, _, text in s.log]
    s.log.clear()
    only = (ctypes.c_char_p * 1)(b"logStatusDiscard")
    assert s.call("fmi2SetDebugLogging", c_int(1), c_size_t(1), only) == OK
    assert s.step(0.0, -1.0) == ERROR
    assert s.log == []
    assert s.call("fmi2SetDebugLogging", c_int(1), c_size_t(0), None) == OK
    unknown = (ctypes.c_char_p * 1)(b"100%")
    status = s.call("fmi2SetDebugLogging", c_int(1), c_size_t(1), unknown)
    expect(s, status, ERROR, "category: found '100%', expected one of logAll, logEvents")
    expect(
        s,
        s.call("fmi2SetDebugLogging", c_int(1), c_size_t(2), None),
        ERROR,
        "categories: found a null pointer",
    )
