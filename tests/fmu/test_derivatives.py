# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives asked through FMI: of quaternions, by the states declared, at singular positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int, c_size_t
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from mechanisms import Scene, four_bar
from models.reducible import two_mechanisms

import gelenk
from gelenk.chart import mechanisms

from .derivatives import DIRECTIONAL, IN_TIME, directional, in_time
from .host import DISCARD, OK, Fmu, Slave, expect
from .plants import crank_rocker, cranked, driven, gyroscope


def extracted(source: Scene, folder: Path) -> Fmu:
    fmu = gelenk.export_fmu(source, folder / "x.fmu")
    return Fmu(fmpy.extract(str(fmu), str(folder / "extracted")))


def derivatives_of(fmu: Fmu) -> dict[str, str]:
    """Derivative -> its state, as modelDescription.xml declares them."""
    return {u.variable.name: u.variable.derivative.name for u in fmu.description.derivatives}


def moved(fmu: Fmu, values: Mapping[str, float], names: Sequence[str]) -> list[float]:
    """Outputs and rates of an instance assembled at these start values."""
    s = Slave(fmu)
    assert (
        s.set({f"{n.replace('[', '_start[') if '[' in n else n + '_start'}": v for n, v in values.items()})
        == OK
    )
    s.start()
    out = [float(s.get(n)) for n in names]
    s.free()
    return out


def test_declared_derivatives_of_a_body_in_space_by_its_states(tmp_path: Path) -> None:
    """All of der(Q), w' and the outputs, against instances set beside, their quaternions normalized.

    Central differences of fourth order, h = 1e-3, at 11 rad/s: 1e-8 of the largest.
    """
    fmu = extracted(gyroscope(), tmp_path)
    declared = derivatives_of(fmu)
    states = sorted(set(declared.values()))
    names = [*declared, *(v.name for v in fmu.description.modelVariables if v.causality == "output")]
    s = Slave(fmu).start()
    s.run(20)
    here = {n: float(s.get(n)) for n in states}
    h = 1e-3
    for state in states:
        column = np.zeros(len(names))
        for k, weight in {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}.items():
            at = dict(here)
            at[state] += k * h
            for joint in "SF":
                Q = [f"{joint}.Q[{i}]" for i in (1, 2, 3, 4)]
                length = math.hypot(*(at[n] for n in Q))
                at |= {n: at[n] / length for n in Q}
            column += weight / h * np.array(moved(fmu, at, names))
        found = np.array(directional(s, names, {state: 1.0}))
        assert np.abs(found - column).max() < 1e-8 * (1 + np.abs(column).max()), state


def test_der_of_a_quaternion_is_its_first_time_derivative(tmp_path: Path) -> None:
    fmu = extracted(gyroscope(), tmp_path)
    s = Slave(fmu).start()
    s.run(20)
    for joint in "SF":
        names = [f"{joint}.Q[{i}]" for i in (1, 2, 3, 4)]
        rates = [float(s.get(f"der({n})")) for n in names]
        assert in_time(s, names, 1) == pytest.approx(rates, abs=1e-14)
        w, z = [f"{joint}.w[{i}]" for i in (1, 2, 3)], [f"{joint}.z[{i}]" for i in (1, 2, 3)]
        assert in_time(s, w, 1) == pytest.approx([float(s.get(n)) for n in z], abs=1e-13)
        assert in_time(s, w, 2) == pytest.approx(in_time(s, z, 1), rel=1e-13)


def test_states_stay_those_declared_whatever_parameters_say(tmp_path: Path) -> None:
    """The scene starts by the crank A, so A.phi is declared; an instance starts by the rocker D."""
    source = four_bar(torque=2.0)
    fmu = extracted(source, tmp_path)
    assert set(derivatives_of(fmu).values()) == {"A.phi", "A.w"}
    s = Slave(fmu)
    assert s.set({"A.fixed": 0, "D.fixed": 1}, "fmi2SetBoolean", c_int) == OK
    s.start()
    s.run(10)
    usual = Slave(fmu)
    assert usual.set({"A.phi_start": s.get("A.phi"), "A.w_start": s.get("A.w")}) == OK
    guesses = {f"{j}.phi_start": s.get(f"{j}.phi") for j in "BCD"}
    assert usual.set(guesses) == OK
    usual.start()
    names = [f"{j}.{x}" for j in "ABCD" for x in ("phi", "w", "a")]
    for state in ("A.phi", "A.w"):
        expected = directional(usual, names, {state: 1.0})
        assert directional(s, names, {state: 1.0}) == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_singular_position_is_discarded_with_a_sentence(tmp_path: Path) -> None:
    """The instance goes on: the flat parallelogram is left at once, and then there are derivatives."""
    fmu = extracted(mechanisms.parallelogram(0.0, 1.0), tmp_path)
    s = Slave(fmu).start()
    assert [(status, category) for status, category, _ in s.log] == [(1, "logStatusWarning")]
    assert "the start is a singular configuration of the loop through" in s.said
    s.log.clear()
    state = next(iter(derivatives_of(fmu).values()))
    one, real = c_size_t(1), (c_double * 1)(1.0)
    reference = s.references([state])
    words = "t = 0 s: a loop is in or close to a singular configuration"
    expect(s, s.call(DIRECTIONAL, reference, one, reference, one, real, real), DISCARD, words)
    expect(s, s.call(IN_TIME, reference, one, (c_int * 1)(1), real), DISCARD, words)
    s.run(3)
    assert directional(s, [state], {state: 1.0}) == [1.0]


@pytest.mark.parametrize("plant", [crank_rocker, gyroscope, two_mechanisms, driven, cranked])
def test_nothing_depends_on_what_is_not_declared(plant: Callable[[], Scene], tmp_path: Path) -> None:
    """Derivatives that do not vanish are among the dependencies that modelDescription.xml declares."""
    fmu = extracted(plant(), tmp_path)
    unknowns = [*fmu.description.outputs, *fmu.description.derivatives]
    names = [u.variable.name for u in unknowns]
    known = {v.name for v in fmu.description.modelVariables if v.causality == "input"}
    known |= set(derivatives_of(fmu).values())
    s = Slave(fmu).start()
    s.run(10)
    acting = 0
    for name in known:
        for unknown, slope in zip(unknowns, directional(s, names, {name: 1.0}), strict=True):
            if slope != 0:
                acting += 1
                assert name in {v.name for v in unknown.dependencies}, (unknown.variable.name, name, slope)
    assert acting > len(names)


def test_fmpy_asks_for_derivatives(tmp_path: Path) -> None:
    source = mechanisms.shipped("cart_pole")
    path = gelenk.export_fmu(source, tmp_path / "x.fmu")
    description = fmpy.read_model_description(str(path), validate=True)
    assert description.coSimulation.providesDirectionalDerivative
    assert description.coSimulation.maxOutputDerivativeOrder == 2
    reference = {v.name: v.valueReference for v in description.modelVariables}
    slave: Any = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(path), str(tmp_path / "extracted")),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    known = [reference[n] for n in ("track.s", "hinge.phi", "track.v", "hinge.w", "drive.f")]
    unknown = [reference[n] for n in ("track.a", "hinge.a")]
    found = np.array([slave.getDirectionalDerivative(unknown, [k], [1.0]) for k in known]).T
    plant = gelenk.Simulation(source)
    plant.initialize()
    A, B, *_ = plant._core._linearize()
    expected = np.hstack([A.reshape((4, 4)).T, B.reshape((1, 4)).T])[2:]
    assert np.array_equal(found, expected)
    slave.terminate()
    slave.freeInstance()
