# SPDX-License-Identifier: BSD-3-Clause
"""The process around an FMU: its floating-point mode, its locale, its files, and when it goes away."""

from __future__ import annotations

import ctypes
import locale
import math
import os
import shutil
import subprocess
from collections.abc import Callable
from ctypes import c_double, c_int, c_size_t, c_void_p

from fmu.host import DISCARD, ERROR, LAST_SUCCESSFUL_TIME, OK, TERMINATED, Fmu, Slave, expect

# <fenv.h> of glibc on x86-64
TRAPS = 0x01 | 0x04 | 0x08 | 0x10  # invalid, division by zero, overflow, underflow
UPWARD, TO_ZERO = 0x800, 0xC00
SIZE = 2.0**-7  # s: times are exact, however the host rounds


def life(plant: Fmu) -> list[list[float]]:
    """All kinds of calls, a refused step among them; the outputs."""
    s = Slave(plant)
    assert s.set({"crank.m": 1.1}) == OK
    s.start()
    s.set_real(drive__tau=2.5)
    rows = s.run(10, SIZE)
    s.set_real(drive__tau=1e300)
    expect(s, s.step(10 * SIZE, SIZE), DISCARD, "state is unchanged")
    s.set_real(drive__tau=0.5)
    rows += s.run(10, SIZE, first=10)
    assert s.call("fmi2Terminate") == OK
    assert s.call("fmi2Reset") == OK
    rows += s.start().run(3, SIZE)
    s.free()
    return rows


def floating_point_modes_of_the_host_stay_outside(fmu: Fmu) -> None:
    libm = ctypes.CDLL("libm.so.6")
    expected = life(fmu)
    assert libm.feenableexcept(c_int(TRAPS)) >= 0
    trapped = life(fmu)
    assert libm.fegetexcept() == TRAPS  # as the host left it
    libm.fedisableexcept(c_int(TRAPS))
    assert trapped == expected  # to the bit
    for mode in (UPWARD, TO_ZERO):
        assert libm.fesetround(c_int(mode)) == 0
        rounded = life(fmu)
        assert libm.fegetround() == mode
        libm.fesetround(c_int(0))
        assert rounded == expected


def decimal_commas_are_no_concern(fmu: Fmu) -> None:
    expected = life(fmu)
    name, folder = "de_DE.UTF-8", fmu.folder.parent / "locales"
    if (program := shutil.which("localedef")) is None:
        raise UnavailableError("localedef, to make a locale with decimal commas, is not installed")
    folder.mkdir()
    made = subprocess.run([program, "-i", "de_DE", "-f", "UTF-8", str(folder / name)], capture_output=True)
    if not (folder / name).is_dir():
        raise UnavailableError(f"localedef: {made.stderr.decode()}")
    os.environ["LOCPATH"] = str(folder)
    locale.setlocale(locale.LC_ALL, name)
    libc = ctypes.CDLL(None)
    text = ctypes.create_string_buffer(20)
    libc.snprintf(text, c_size_t(20), b"%.1f", c_double(0.5))
    assert text.value == b"0,5"  # the host does speak so
    assert life(fmu) == expected
    s = Slave(fmu).start()
    assert s.step(0.0, 0.5) == OK
    expect(s, s.step(0.0, 0.5), ERROR, "is at t = 0.5 s")


class UnavailableError(Exception):
    """Something on this machine without which a scenario cannot be played."""


def instances_can_be_freed_at_any_moment(fmu: Fmu) -> None:
    def torn(s: Slave) -> None:
        for joint in "ABCD":
            assert s.set({f"{joint}.phi_start": 1.0}) == OK
            assert s.set({f"{joint}.fixed": 1}, "fmi2SetBoolean", c_int) == OK
        assert s.leave() == ERROR

    def discarded(s: Slave) -> None:
        s.set_real(drive__tau=1e300)
        assert s.step(0.01, 0.01) == DISCARD

    steps: list[Callable[[Slave], object]] = [
        lambda s: s.set_real(drive__tau=1.0),
        lambda s: s.setup(),
        lambda s: s.enter(),
        lambda s: s.get("A.a"),
        torn,
        lambda s: s.call("fmi2Reset"),
        lambda s: s.start(),
        lambda s: s.run(1),
        discarded,
        lambda s: s.call("fmi2Terminate"),
        lambda s: s.call("fmi2Reset"),
    ]
    for moment in range(len(steps) + 1):
        s = Slave(fmu)
        for step in steps[:moment]:
            step(s)
        s.free()
    fmu.library.fmi2FreeInstance(None)
    Slave(fmu).start().run(3)


def scenes_of_all_sorts_of_damage_are_refused(fmu: Fmu) -> None:
    scene = fmu.folder / "resources" / "scene.json"
    text = scene.read_bytes()
    damaged = [text[:n] for n in range(0, len(text), 41)]
    damaged += [
        text[:n] + bytes([byte]) + text[n + 1 :] for n in range(0, len(text), 97) for byte in b"\0{9-\xff"
    ]
    damaged += [b"[" * 10**6, b'{"a":' * 10**5, b'{"gelenk":' + b"9" * 10**6 + b"}", bytes(range(256)) * 100]
    for content in damaged:
        if content == text:
            continue
        scene.write_bytes(content)
        s = Slave(fmu)
        assert s.component is None
        expect(s, ERROR, ERROR, "fmi2Instantiate: ")
        assert len(s.said) < 20000
    scene.unlink()
    scene.mkdir()
    s = Slave(fmu)
    assert s.component is None
    expect(s, ERROR, ERROR, str(scene), "could not be read")
    scene.rmdir()
    scene.write_bytes(text)
    if os.geteuid() != 0:  # whom nothing is unreadable to
        scene.chmod(0)
        s = Slave(fmu)
        assert s.component is None
        expect(s, ERROR, ERROR, str(scene), "Permission denied")
        scene.chmod(0o644)
    Slave(fmu).start().run(1)


def drive_letters_are_told_from_schemes(fmu: Fmu) -> None:
    """On Linux a drive letter is a folder's name: of one beside us."""
    os.chdir(fmu.folder.parent)
    shutil.copytree(fmu.folder / "resources", "C:/the fmu/resources")
    for location in (
        "file:///C:/the%20fmu/resources",
        "file:////C:/the%20fmu/resources",
        "file://C:/the%20fmu/resources/",
        "file:/C:/the%20fmu/resources",
        "file:///C%3A/the%20fmu/resources",
        "C:/the fmu/resources",
    ):
        s = Slave(fmu, resources=location)
        assert s.component, (location, s.log)
        s.free()


def what_is_not_known_of_steps_is_discarded_with_a_sentence(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.run(1)
    value = (c_double * 1)()
    for function in ("fmi2GetStatus", "fmi2GetIntegerStatus", "fmi2GetStringStatus"):
        for kind in range(4):
            expect(s, s.call(function, c_int(kind), value), DISCARD, f"{function}: no step is running")
            expect(s, s.call(function, c_int(kind), None), DISCARD, f"{function}: no step is running")
    expect(s, s.call("fmi2GetRealStatus", c_int(TERMINATED), value), DISCARD, "fmi2LastSuccessfulTime")
    status = s.call("fmi2GetBooleanStatus", c_int(LAST_SUCCESSFUL_TIME), value)
    expect(s, status, DISCARD, "fmi2Terminated")
    expect(s, s.call("fmi2GetRealStatus", c_int(99), value), DISCARD, "fmi2GetRealStatus: ")
    s.run(1, first=1)


def gigantic_steps_come_back(fmu: Fmu) -> None:
    """Made where the plant rests before long, given up where it gets nowhere. Either way before the step's
    budget of evaluations is spent.
    """
    for size in (1e2, 1e4, 1e9, 1e15, 1e100, 1e300):
        s = Slave(fmu).start()
        s.set_real(drive__tau=0.5)
        s.run(2, SIZE)
        before = s.outputs()
        budget = s.get("solver.max_evaluations", "fmi2GetInteger", c_int)
        evaluations = s.get("solver.evaluations")
        status = s.step(2 * SIZE, size)
        assert s.get("solver.evaluations") - evaluations < budget * max(1.0, size / min(1.0, 1000 * SIZE))
        if status == OK:
            assert size < 1e5
            assert all(map(math.isfinite, s.outputs()))
            continue
        expect(
            s,
            status,
            DISCARD,
            "fmi2DoStep: t = ",
            f"state is unchanged at t = {2 * SIZE:.6g} s; the simulation can continue",
        )
        last = c_double()
        assert s.call("fmi2GetRealStatus", c_int(LAST_SUCCESSFUL_TIME), ctypes.byref(last)) == OK
        assert last.value == 2 * SIZE
        assert s.outputs() == before
        s.run(2, SIZE, first=2)
        s.free()


def every_function_survives_null(fmu: Fmu) -> None:
    """All arguments null or zero, without an instance and with one in each mode."""
    functions = [
        *(
            f"fmi2{verb}{kind}"
            for verb in ("Get", "Set")
            for kind in ("Real", "Integer", "Boolean", "String")
        ),
        *(f"fmi2Get{kind}Status" for kind in ("", "Real", "Integer", "Boolean", "String")),
        *(f"fmi2{verb}FMUstate" for verb in ("Get", "Set", "Free", "Serialize", "DeSerialize")),
        "fmi2SerializedFMUstateSize",
        "fmi2GetDirectionalDerivative",
        "fmi2SetRealInputDerivatives",
        "fmi2GetRealOutputDerivatives",
        "fmi2SetDebugLogging",
        "fmi2CancelStep",
    ]
    nothing = [c_void_p(None)] * 7

    def all_functions(s: Slave) -> None:
        for function in functions:
            s.log.clear()
            status = s.call(function, *nothing)
            assert status in (OK, DISCARD, ERROR), function
            assert len(s.log) == (1 if status != OK and s.component else 0), (function, s.log)
            assert s.call("fmi2SetDebugLogging", c_int(1), c_size_t(0), None) == (
                OK if s.component else ERROR
            )
        s.log.clear()

    all_functions(Slave(fmu, guid="wrong"))
    s = Slave(fmu)
    for step in (s.setup, s.enter, s.leave, lambda: s.step(0.0, 0.1), lambda: s.call("fmi2Terminate")):
        all_functions(s)
        assert step() == OK, s.said
    all_functions(s)
    s.free()


def loggers_hear_of_their_own_environment(fmu: Fmu) -> None:
    """Two instances, one name: each message reaches the logger of the instance that speaks."""
    first, second = Slave(fmu, name="twin"), Slave(fmu, name="twin")
    assert first.step(0.0, 0.1) == ERROR
    assert len(first.log) == 1
    assert second.log == []
