# SPDX-License-Identifier: BSD-3-Clause
"""What every component obeys: parameters, start values, saved scenes and states, linear models, FMUs."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import warned
from circuits import values
from mechanisms import body, frame, joint, scene

import gelenk

from .component_kinds import HAND, KINDS, by_hand, with_component


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_parameters(kind: str) -> None:
    """Set before a run, each has the effect that it has in the file."""
    numbers = {
        name: value
        for name, value in KINDS[kind].items()
        if isinstance(value, int | float) and not name.startswith("start")
    }
    paths = [f"M.{name}" for name in numbers]
    source = with_component(kind, parameters=paths)
    for name, value in numbers.items():
        changed = copy.deepcopy(source)
        changed["components"]["M"][name] = 1.1 * value
        expected = gelenk.simulate(changed, stop=0.4, tolerance=1e-9)
        found = gelenk.simulate(source, stop=0.4, tolerance=1e-9, parameters={f"M.{name}": 1.1 * value})
        assert found.names == expected.names
        for output in found.names:
            scale = np.abs(expected[output]).max() + 1e-9
            assert np.abs(found[output] - expected[output]).max() <= 1e-9 * scale, (name, output)


@pytest.mark.parametrize("kind", KINDS)
def test_start_values_are_those_of_the_file_and_parameters(kind: str) -> None:
    source = with_component(kind)
    plain = gelenk.simulate(source, stop=0.1, tolerance=1e-9)
    for state in HAND[kind][0]:
        name = state.rstrip("_")
        start = plain[f"M.{name}"][0] + 0.05 * max(1.0, abs(plain[f"M.{name}"][0]))
        changed = copy.deepcopy(source)
        changed["components"]["M"].setdefault("start", {})[name] = start
        in_file = gelenk.simulate(changed, stop=0.1, tolerance=1e-9)
        set_before = gelenk.simulate(source, stop=0.1, tolerance=1e-9, parameters={f"M.{name}_start": start})
        with_it = gelenk.simulate(
            gelenk.load(source).with_parameters({f"M.{name}_start": start}), stop=0.1, tolerance=1e-9
        )
        assert in_file[f"M.{name}"][0] == pytest.approx(start, rel=1e-15)
        for output in plain.names:
            assert np.array_equal(in_file[output], set_before[output]), (name, output)
            assert np.array_equal(in_file[output], with_it[output]), (name, output)


@pytest.mark.parametrize("kind", ["dc_motor", "position_servo", "series_elastic_drive", "hydraulic_chamber"])
def test_equilibrium_is_that_by_hand(kind: str) -> None:
    """On a spring, with a constant input: rates of states vanish there, too."""
    found, expected = with_component(kind), by_hand(kind)
    for source in (found, expected):
        source["joints"]["axle"] |= {"stiffness": 3.0, "start": {}}
        source["inputs"]["u"]["start"] = 0.1
    if kind == "position_servo":  # without the time
        found["components"]["M"]["target"] = "u"
        expected = json.loads(json.dumps(expected).replace("u*t", "u"))
    rest = gelenk.equilibrium(found)
    for state in HAND[kind][0]:
        assert abs(rest.values[f"M.{state}.rate"]) < 1e-6
    by_states = gelenk.equilibrium(expected)
    for name in HAND[kind][0]:
        assert rest.values[f"M.{name}"] == pytest.approx(by_states.values[name], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_saved_scene_is_the_same(kind: str) -> None:
    loaded = gelenk.load(with_component(kind))
    again = gelenk.load(loaded.to_dict())
    assert again.to_dict() == loaded.to_dict()
    a, b = (gelenk.simulate(one, stop=0.2) for one in (loaded, again))
    assert a.names == b.names
    assert all(np.array_equal(a[name], b[name]) for name in a.names)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("integrator", ["auto", "ida", "rk4"])
def test_saved_state_repeats_the_run(kind: str, integrator: str) -> None:
    source = with_component(kind, solver={"integrator": integrator})
    names = gelenk.simulate(source, stop=0.01).names
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-7)
    for k in range(10):
        simulation.step_to(0.02 * (k + 1))
    saved = simulation.save()
    runs = []
    for _ in range(2):
        simulation.set_input("u", -1.0)
        run = []
        for k in range(10, 20):
            simulation.step_to(0.02 * (k + 1))
            run.append([simulation.output(name) for name in names])
        runs.append(run)
        simulation.restore(saved)
    assert runs[0] == runs[1]


@warned.MOVING
@pytest.mark.parametrize("kind", KINDS)
def test_linear_model_is_that_by_hand(kind: str) -> None:
    found, expected = (gelenk.linearize(one) for one in (with_component(kind), by_hand(kind)))
    assert [n.removeprefix("M_") for n in found.state_labels] == [
        n.rstrip("_") for n in expected.state_labels
    ]
    np.testing.assert_allclose(found.A, expected.A, rtol=1e-12, atol=1e-9)
    columns = [model.input_labels.index("u") for model in (found, expected)]
    np.testing.assert_allclose(found.B[:, columns[0]], expected.B[:, columns[1]], rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_fmu_runs_as_the_scene(kind: str, tmp_path: Path) -> None:
    source = with_component(kind, experiment={"stop": 0.4, "step": 0.02, "tolerance": 1e-8})
    fmu = gelenk.export_fmu(source, tmp_path / "plant.fmu")
    names = [v.name for v in fmpy.read_model_description(str(fmu)).modelVariables]
    assert len(names) == len(set(names))
    expected = gelenk.simulate(source)
    recorded = fmpy.simulate_fmu(
        str(fmu), output=expected.names, stop_time=0.4, step_size=0.02, output_interval=0.02
    )
    for name in expected.names:
        scale = np.abs(expected[name]).max() + 1e-9
        assert abs(recorded[name][-1] - expected[name][-1]) <= 1e-6 * scale, name


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_is_the_same_as_by_hand_in_natural_units(size: float) -> None:
    """A chamber on a slide of any size, whose numbers the core converts."""

    def chamber(**more: Any) -> dict[str, Any]:
        effort = more.pop("effort", "0")
        about = joint(
            "prismatic",
            frame("ground"),
            frame("slide", (size, 0, 0)),
            axis=[1, 0, 0],
            start={"s": 0.1 * size},
            law={"effort": f"-{4e5 * size}*s + {effort}"},
        )
        return scene({"slide": body(size**3)}, {"axle": about}, gravity=[0, 0, 0], **more)

    area, volume = 0.01 * size**2, 0.01 * size**3
    times = [0.01 * size, 0.1 * size]
    component = {
        "type": "pneumatic_chamber",
        "joint": "axle",
        "flow": f"{1e-3 * size**3}",
        "area": area,
        "volume": volume,
        "start": {"pressure": 1.2e5},
        "ambient_pressure": 1e5,
    }
    rate = f"1.4*(287.05*293.15*{1e-3 * size**3} - p*{area}*axle.v)/({volume} + {area}*axle.s)"
    states = {"p": {"rate": rate, "start": 1.2e5, "nominal": 1e5, "unit": "Pa"}}
    found = values(chamber(components={"M": component}), ["axle.s", "axle.v", "M.pressure"], times, 1e-9)
    hand = chamber(states=states, effort=f"(p - 1e5)*{area}")
    expected = values(hand, ["axle.s", "axle.v", "p"], times, 1e-9)
    np.testing.assert_allclose(found, expected, rtol=1e-7)
