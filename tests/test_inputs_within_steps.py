# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that are functions of time vary within the communication steps of `simulate`."""

from __future__ import annotations

import itertools
import math
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk
from gelenk.simulation.fmu_plant import FmuPlant
from gelenk.simulation.inputs import sampled, shifted

MASS, END, STEP = 2.0, 0.7, 0.1  # kg, s, s


def sled() -> Scene:
    x = joint("prismatic", frame("ground"), frame("sled"), axis=[1, 0, 0])
    return scene({"sled": body(MASS)}, {"x": x}, motors={"push": {"joint": "x"}})


def place(force: object, *, hold: bool = False) -> float:
    inputs = {"push.f": force}
    run = gelenk.simulate(sled(), stop=END, step=STEP, tolerance=1e-11, inputs=inputs, hold=hold)  # type: ignore[arg-type]
    return float(run["x.s"][-1])


def test_a_smooth_force_acts_as_it_is() -> None:
    """Its double integral; the quartic through five values errs by h^5 f^(5) / 4e4 at most, 1e-7 N here."""
    exact = (4.0 * END / 3.0 - 4.0 / 9.0 * math.sin(3.0 * END)) / MASS

    def force(t: float) -> float:
        return 4.0 * math.sin(3.0 * t)

    assert place(force) == pytest.approx(exact, abs=1e-8)
    values = [force(STEP * k) for k in range(7)]
    held = sum(f * (0.5 + 6 - k) for k, f in enumerate(values)) * STEP**2 / MASS
    assert place(force, hold=True) == pytest.approx(held, abs=1e-12)
    assert abs(held - exact) > 0.05


def step_at(jump: float) -> Callable[[float], float]:
    return lambda t: 5.0 if t >= jump else 1.0


@pytest.mark.parametrize("jump", [0.3, 0.1 * 3, 0.7])
def test_a_jump_at_a_communication_point_is_exact(jump: float) -> None:
    """The point is at 3 * 0.1 s, which is later than 0.3 s by rounding."""
    exact = (END**2 + 4.0 * (END - jump) ** 2) / 2 / MASS
    assert place(step_at(jump)) == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("jump", np.linspace(0.3001, 0.3999, 9))
def test_a_jump_within_a_step_is_held(jump: float) -> None:
    assert place(step_at(float(jump))) == place(step_at(float(jump)), hold=True)


def test_a_table_is_linear_within_steps() -> None:
    """Between points that are 0.1 s apart: the double integral of straight lines."""
    times = [STEP * k for k in range(8)]
    values = [0.0, 3.0, -1.0, 2.0, 2.0, 7.0, 1.0, -4.0]
    v = x = 0.0
    for f, g in itertools.pairwise(values):
        x += STEP * v + STEP**2 * (2.0 * f + g) / 6 / MASS
        v += STEP * (f + g) / 2 / MASS
    assert place((times, values)) == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize(("slope", "follows"), [(0.09, False), (0.10, True)])
def test_the_polynomial_is_used_where_it_is_near(slope: float, follows: bool) -> None:
    """A jump of 1 just before the end of a step, on a line: the polynomial errs by 0.273 of 1 + slope."""
    table = sampled({"f": lambda t: slope * t + (t > 0.99)}, np.array([0.0, 1.0])).table
    assert (table[0, 1:] != 0).any() == follows
    assert 0.2734375 / (1 + 0.09) > 0.25 > 0.2734375 / (1 + 0.10)


def test_functions_are_called_in_order_of_time_within_each_step() -> None:
    called: list[float] = []

    def force(t: float) -> float:
        called.append(t)
        return t

    sampled({"f": force}, np.array([0.0, 0.1, 0.3]))
    assert called == sorted(called)
    assert [t for t in called if t < 0.1] == called[:9]
    assert len(called) == 18


def test_bits_do_not_depend_on_the_number_of_steps_sampled_together() -> None:
    times = np.cumsum(np.random.default_rng(3).uniform(0.01, 0.2, 40))
    force = {"f": lambda t: math.sin(7 * t) + t**3}
    together = sampled(force, times).table
    singly = [sampled(force, times[k : k + 2]).table[0].tolist() for k in range(len(times) - 1)]
    assert together.tolist() == singly


def test_a_shifted_polynomial_is_the_same() -> None:
    value, derivatives = shifted(1.0, [2.0, 3.0, 4.0, 5.0], 0.5)
    p = np.polynomial.Polynomial([1.0, 2.0, 3.0 / 2, 4.0 / 6, 5.0 / 24])
    assert [value, *derivatives] == pytest.approx([p.deriv(k)(0.5) if k else p(0.5) for k in range(5)])


def test_what_cannot_be_held_is_refused() -> None:
    with pytest.raises(gelenk.UsageError, match=r"push.g: no such input; did you mean push.f\?"):
        gelenk.simulate(sled(), stop=0.1, hold=["push.g"])
    source = sled()
    source["constraints"] = {"pos": {"type": "motion", "joint": "x", "input": "position"}}
    with pytest.raises(gelenk.UsageError, match=r"hold: found pos.s_ref, a prescribed motion"):
        gelenk.simulate(source, stop=0.1, hold=["pos.s_ref"])
    gelenk.simulate(source, stop=0.1, inputs={"pos.s_ref": lambda t: t}, hold=True)


def test_fmus_that_do_not_interpolate_hold_their_inputs(tmp_path: Path) -> None:
    """An FMU of which modelDescription.xml says so: as with `hold` in one that does."""
    own = gelenk.export_fmu(sled(), tmp_path / "own.fmu")
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(own) as source, zipfile.ZipFile(other, "w") as copy:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                content, count = re.subn(rb'canInterpolateInputs="true"', b"", content)
                assert count == 1
            copy.writestr(name, content)
    plant = FmuPlant(other)
    try:
        assert plant.held == {"push.f"}
    finally:
        plant.close()
    inputs = {"push.f": lambda t: 4.0 * math.sin(3.0 * t)}
    held = gelenk.simulate(own, stop=END, step=STEP, inputs=inputs, hold=True)
    assert gelenk.simulate(other, stop=END, step=STEP, inputs=inputs)["x.s"].tolist() == held["x.s"].tolist()
