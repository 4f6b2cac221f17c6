# SPDX-License-Identifier: BSD-3-Clause
"""Whatever can be a parameter is set in the finished FMU, and acts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from ctypes import c_int
from pathlib import Path
from typing import Any

import fmpy
import pytest
import scene_files
from mechanisms import Scene

import gelenk

from .all_parameters import observed, offering_all
from .host import DISCARD, ERROR, OK, Fmu, Slave, expect
from .plants import crank_rocker, gyroscope
from .states import choice

STEPS = 3
STEP = 2.0**-6  # s

Values = dict[str, float]


def set_all(slave: Slave, values: Values) -> None:
    for name, value in values.items():
        kind = next(v.type for v in slave.fmu.description.modelVariables if v.name == name)
        setter = {"Real": "fmi2SetReal", "Boolean": "fmi2SetBoolean"}.get(kind, "fmi2SetInteger")
        if kind == "Real":
            assert slave.set({name: value}) == OK, slave.said
        else:
            assert slave.set({name: int(value)}, setter, c_int) == OK, slave.said


def run(fmu: Fmu, values: Values) -> list[list[float]] | None:
    """Outputs at the start and after each step; None where that is refused."""
    slave = Slave(fmu)
    try:
        set_all(slave, values)
        assert slave.setup() == OK, slave.said
        assert slave.enter() == OK, slave.said
        set_all(slave, {v.name: 1.3 for v in fmu.description.modelVariables if v.causality == "input"})
        if slave.leave() != OK:
            return None
        rows = [slave.outputs()]
        size = 10 * step_of(fmu)
        for k in range(STEPS):
            status = slave.step(k * size, size)
            if status == DISCARD and "solver.max_evaluations" in slave.said:
                return [*rows, slave.outputs()]
            if status != OK:
                return None
            rows.append(slave.outputs())
        return rows
    finally:
        slave.free()


def step_of(fmu: Fmu) -> float:
    return float(fmu.description.defaultExperiment.stepSize)


class Situations:
    """An FMU and ways to start it in which parameters act that do not in the scene as it is."""

    def __init__(self, source: dict[str, Any], folder: Path) -> None:
        out = gelenk.export_fmu(source, folder / "x.fmu")
        fmpy.extract(str(out), str(folder / "extracted"))
        self.fmu = Fmu(folder / "extracted")
        self.parameters = {
            v.name: v for v in self.fmu.description.modelVariables if v.causality == "parameter"
        }
        self._runs: dict[str, list[list[float]] | None] = {}

    def choice(self, name: str, word: str) -> Values:
        return {name: choice(self.fmu, name)[word]}

    def all(self, pattern: str, value: float) -> Values:
        return {name: value for name in self.parameters if re.search(pattern, name)}

    def situations(self) -> Iterator[tuple[str, Values]]:
        yield "as it is", {}
        yield "guesses only", self.all(r"\.fixed$", 0)
        yield "springs everywhere", self.all(r"\.stiffness", 7.0) | self.all(r"\.rotor_inertia$", 0.01)
        yield "at its stops", self.all(r"\.stop\.lower$", 1.0) | self.all(r"\.stop\.upper$", 2.0)
        for method in ("rk4", "generalized-alpha"):
            yield method, {**self.choice("solver.integrator", method), "solver.step": step_of(self.fmu)}
        yield "baumgarte", self.choice("solver.formulation", "baumgarte")
        yield "short of evaluations", {"solver.max_evaluations": 40, "solver.tolerance": 1e-12}
        yield "few corrections", {**self.choice("solver.integrator", "euler"), "solver.corrections": 3}
        round_ones = self.all(r"\.inertia\[[123]\]|\.m$", 1.0) | self.all(r"\.inertia\[[456]\]", 0.0)
        yield "round bodies", round_ones
        yield "turned", self.all(r"\.Q_start\[1\]", 0.1) | self.all(r"\.fixed$", 0)
        yield "swinging", self.all(r"\.(w|v|w_a|w_b)_start", 0.4) | self.all(r"\.fixed$", 0)

    def acts(self, name: str) -> bool:
        """Whether a change of the parameter changes some output, in any situation."""
        for situation, values in self.situations():
            if situation not in self._runs:
                self._runs[situation] = run(self.fmu, values)
            before = values.get(name, float_start(self.parameters[name]))
            changed = run(self.fmu, values | {name: perturbed(self.parameters[name], before)})
            if None not in (changed, self._runs[situation]) and changed != self._runs[situation]:
                return True
        return False


def float_start(parameter: Any) -> float:
    if parameter.type == "Boolean":
        return float(parameter.start == "true")
    return float(parameter.start)


def perturbed(parameter: Any, value: float) -> float:
    if parameter.type == "Boolean":
        return 1 - value
    if parameter.type == "Integer" and ": 1 " in parameter.description:  # a choice
        return value + 1 if value < int(parameter.max) else value - 1
    if parameter.type == "Integer":
        return value // 3
    larger = 1.013 * value + 0.011
    return larger if parameter.max is None or larger <= float(parameter.max) else 0.9 * value


def normal(source: dict[str, Any]) -> int | None:
    """0, 1, 2: everything moves in the plane across x, y, z."""
    joints = source["joints"].values()
    if any(joint["type"] not in ("revolute", "prismatic") for joint in joints):
        return None
    axes = {tuple(abs(x) for x in joint["axis"]) for joint in joints if joint["type"] == "revolute"}
    return axes.pop().index(1) if len(axes) == 1 else None


def cannot_act(source: dict[str, Any], name: str) -> bool:
    """What physics leaves without effect, in these scenes.

    In a tree guesses are kept as exactly as what is fixed, and there is nothing to formulate (another
    formulation acts nevertheless: it has no program, from which the kernels differ by rounding). In a
    plane only inertia about the normal matters, deviations from it included, and none of bodies that slide;
    what moves a joint of a loop off the plane tears the loop, so is refused. Their numbers are exact, which
    `assembly.tolerance` leaves as they are (tests/physics/assembly/test_rounded_mechanisms.py has others).
    """
    if name == "assembly.tolerance":
        return True
    tree = len(source["joints"]) == len(source["bodies"]) and not source.get("constraints")
    if tree and re.search(r"\.fixed$|^solver\.(baumgarte_|corrections)", name):
        return True
    # Between a planar joint and one along its normal a body turns about that alone.
    level = {"BalancingRobot": "heading|axle", "Bicycle": "place|level"}.get(source["name"])
    if level and re.fullmatch(rf"({level})\.inertia\[[124]\]", name):
        return True
    n = normal(source)
    if n is None:
        return False
    if found := re.fullmatch(r"(\w+)\.inertia\[(\d)\]", name):
        ends = (("parent", "child"), ("child", "parent"))
        slides = any(
            joint["type"] == "prismatic" and joint[a]["body"] == found[1] and joint[b]["body"] == "ground"
            for joint in source["joints"].values()
            for a, b in ends
        )
        return slides or "xyz"[n] not in ("xx", "yy", "zz", "xy", "xz", "yz")[int(found[2]) - 1]
    return not tree and name.endswith(f".position[{n + 1}]")


# Held where they are by wheels: what acts on these joints shows by rounding, or not at all.
HELD = {"balancing_robot": ("lift", "roll"), "bicycle": ("height", "pitch")}


LONG = ("andrews", "stewart", "five_bar")
SHORT = ("double_pendulum", "heavy_top", "free_body", "pendulum", "cart_pole")


def tier(name: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.study] if name in LONG else [] if name in SHORT else [pytest.mark.thorough]


@pytest.mark.parametrize(
    "file",
    [pytest.param(file, marks=tier(file.stem)) for file in scene_files.good()],
    ids=lambda file: file.stem,
)
def test_each_parameter_of_each_scene_acts(file: Path, tmp_path: Path) -> None:
    source = offering_all(gelenk.load(file).to_dict())
    (tmp_path / "plain").mkdir()
    plain = Situations(source, tmp_path / "plain")
    silent = [name for name in plain.parameters if not plain.acts(name)]
    if silent:  # nobody looks where they act
        (tmp_path / "observed").mkdir()
        seen = Situations(observed(source), tmp_path / "observed")
        silent = [name for name in silent if not seen.acts(name)]
    held = HELD.get(file.stem, ())
    expected = [name for name in plain.parameters if cannot_act(source, name)]
    assert sorted(n for n in silent if n.split(".")[0] not in held) == sorted(expected)


# A value for each kind of tunable parameter, other than where the scenes have it.
TUNED = {
    r"^gravity\[\d\]$": 3.0,
    r"\.damping": 0.7,
    r"\.stiffness": 9.0,
    r"\.spring_reference": 0.4,
    r"\.length$": 0.31,
    r"\.force\[\d\]$": 1.7,
    r"\.torque\[\d\]$": -0.6,
}


def tuned(name: str) -> float:
    (value,) = (value for pattern, value in TUNED.items() if re.search(pattern, name))
    return value


def loaded_crank_rocker() -> Scene:
    """With springs, dampers and stops on a joint of the tree and on one that closes the loop, in a plane."""
    out = crank_rocker()
    for name in "AD":
        out["joints"][name] |= {"stiffness": 2.0, "damping": 0.2}
    out["joints"]["A"]["stop"] = {"lower": -1.0, "upper": 1.2, "stiffness": 30.0, "damping": 0.4}
    out["forces"] = {"weight": {"type": "wrench", "body": "rocker", "force": [0.0, -2.0, 0.0]}}
    return offering_all(out)


def loaded_gyroscope() -> Scene:
    """In space, with quaternions, a spring between points, and a load along a body's axes."""
    out = gyroscope()
    out["gravity"] = [0.0, 0.0, -9.81]
    out["forces"]["load"] = {"type": "wrench", "body": "top", "frame": "body", "torque": [0.1, 0.0, 0.2]}
    return offering_all(out)


def start_where(slave: Slave, other: Slave) -> None:
    """Sets the start values of `slave` to where `other` stands."""
    for name in slave.fmu.reference:
        if "_start" in name and "der(" not in name:
            assert slave.set({name: other.get(name.replace("_start", ""))}) == OK, slave.said


@pytest.mark.parametrize("integrator", ["erk", "ida"])
@pytest.mark.parametrize("plant", [loaded_crank_rocker, loaded_gyroscope])
def test_a_tuned_plant_goes_on_as_one_made_so(
    plant: Callable[[], Scene], integrator: str, tmp_path: Path
) -> None:
    """Both runs at a tolerance of 1e-10, the loop closed anew at the start: they differ by less than 1e-6."""
    source = plant()
    source["solver"] = {"integrator": integrator}
    source["experiment"] = {"tolerance": 1e-10}
    situations = Situations(source, tmp_path)
    tunable = [name for name, v in situations.parameters.items() if v.variability == "tunable"]
    assert {re.sub(r"^\w+\.|\[\d\]", "", name) for name in tunable} >= {
        "gravity",
        "damping",
        "stiffness",
        "force",
    }
    for name in tunable:
        running = Slave(situations.fmu).start()
        running.run(4, STEP)
        before = running.outputs()
        value = tuned(name)
        assert running.set({name: value}) == OK, running.said
        assert running.get(name) == value
        fresh = Slave(situations.fmu)
        start_where(fresh, running)
        assert fresh.set({name: value}) == OK, fresh.said
        fresh.start()
        # Outputs and energies follow at once.
        assert running.get("energy.potential") == pytest.approx(
            fresh.get("energy.potential"), rel=1e-9, abs=1e-9
        )
        assert running.outputs() == pytest.approx(fresh.outputs(), rel=1e-6, abs=1e-6)
        rows, expected = running.run(4, STEP, first=4), fresh.run(4, STEP)
        for row, wanted in zip(rows, expected, strict=True):
            assert row == pytest.approx(wanted, rel=1e-6, abs=1e-6), name
        assert running.outputs() != before
        running.free()
        fresh.free()


def test_tuning_is_refused_as_a_whole_and_by_name(tmp_path: Path) -> None:
    situations = Situations(loaded_crank_rocker(), tmp_path)
    slave = Slave(situations.fmu).start()
    slave.run(2)
    before = slave.outputs()
    expect(
        slave,
        slave.set({"gravity[2]": -1.0, "D.damping": -2.0}),
        ERROR,
        "D.damping: found -2, expected at least 0",
    )
    expect(slave, slave.set({"gravity[2]": -1.0, "crank.m": 2.0}), ERROR, "crank.m is a fixed parameter")
    assert slave.get("gravity[2]") == -9.81
    assert slave.outputs() == before
    assert slave.call("fmi2Terminate") == OK
    expect(slave, slave.set({"gravity[2]": -1.0}), ERROR, "called after fmi2Terminate")


def test_a_rod_whose_damping_may_be_tuned_stays_a_body(tmp_path: Path) -> None:
    """A rod without mass is a distance only where nothing can act on its joints."""
    source = crank_rocker()
    source["bodies"]["coupler"] = {"mass": 0, "com": [0, 0, 0], "inertia": [0, 0, 0]}
    source["sensors"] = {}
    source["parameters"] = []
    assert gelenk.inspect(source).reduced.constraint_equations == 1
    source["parameters"] = ["B.damping"]
    assert gelenk.inspect(source).reduced.constraint_equations == 2
    situations = Situations(source, tmp_path)
    runs = []
    for damping in (0.0, 5.0):
        slave = Slave(situations.fmu).start()
        assert slave.set({"B.damping": damping}) == OK, slave.said
        runs.append(slave.run(5, STEP))
        slave.free()
    assert runs[0] != runs[1]


@pytest.mark.parametrize("file", scene_files.good(), ids=lambda file: file.stem)
def test_all_are_all_that_can_be_listed(file: Path, tmp_path: Path) -> None:
    source = gelenk.load(file).to_dict()
    names = []
    for number, scene in enumerate((source | {"parameters": "all"}, offering_all(source))):
        fmu = gelenk.export_fmu(scene, tmp_path / f"{number}.fmu")
        names.append([v.name for v in fmpy.read_model_description(str(fmu)).modelVariables])
    assert names[0] == names[1]
