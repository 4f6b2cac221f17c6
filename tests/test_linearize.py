# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.linearize as users meet it: points, names, warnings, errors, the command."""

from __future__ import annotations

import json
import math
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
import warned
from mechanisms import body, four_bar, frame, frame_sensor, joint, reaction, scene, with_sensors
from models.derivative_cases import assert_relative
from test_cli import call, faults, told

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import linear_model
from gelenk.linear.minimal_realization import MinimalRealization
from gelenk.simulation.scene_plant import ScenePlant


@pytest.fixture
def cart_pole(root: Path) -> Path:
    return root / "scenes" / "cart_pole.yaml"


UPRIGHT = {"hinge.phi": 0.0}


def test_what_comes_back_is_a_state_space_of_python_control(cart_pole: Path) -> None:
    found = gelenk.linearize(cart_pole, at=UPRIGHT)
    assert isinstance(found, control.StateSpace)
    assert found.name == "CartPole"
    assert found.dt == 0  # continuous
    assert found.state_labels == ["track_s", "hinge_phi", "track_v", "hinge_w"]
    assert found.input_labels == ["drive_f"]
    assert found.output_labels == ["track_s", "track_v", "track_a", "hinge_phi", "hinge_w", "hinge_a"]
    numbers = linear_model(cart_pole, at=UPRIGHT)
    for matrix in "ABCD":
        assert np.array_equal(getattr(found, matrix), getattr(numbers, matrix))


def test_selections_are_rows_and_columns_in_the_order_asked_for(root: Path) -> None:
    source = root / "scenes" / "slider_crank.yaml"
    everything = linear_model(source)
    inputs, outputs = ["gas.f[1]", "starter.tau"], ["bearing.f[3]", "cylinder.s"]
    found = linear_model(source, inputs=inputs, outputs=outputs)
    u = [everything.inputs.index(name) for name in inputs]
    y = [everything.outputs.index(name) for name in outputs]
    assert np.array_equal(found.A, everything.A)
    assert np.array_equal(found.B, everything.B[:, u])
    assert np.array_equal(found.C, everything.C[y])
    assert np.array_equal(found.D, everything.D[np.ix_(y, u)])
    assert np.array_equal(found.y0, everything.y0[y])
    assert found.D[0].all()  # reactions feel the inputs at once
    assert (found.inputs, found.outputs) == (tuple(inputs), tuple(outputs))


def test_states_in_another_order_are_the_same_model(root: Path) -> None:
    source = root / "scenes" / "five_bar.yaml"
    usual = linear_model(source, input_values={"motor_left.tau": 0.1})
    names = ["right.w", "left.phi", "left.w", "right.phi"]
    found = linear_model(source, input_values={"motor_left.tau": 0.1}, states=names)
    assert found.states == tuple(names)
    order = [usual.states.index(name) for name in names]
    # Solving with a permutation: rounding at the most.
    assert_relative("A", found.A, usual.A[np.ix_(order, order)], 1e-13)
    assert_relative("C", found.C, usual.C[:, order], 1e-13)
    assert_relative("rates", found.rates, usual.rates[order], 1e-13)


@pytest.mark.parametrize("at", [None, 0.3])
def test_any_coordinates_of_joints_can_be_states(at: float | None, tmp_path: Path) -> None:
    """Also those of the joint that closes the loop, and by the FMU alone."""
    source = four_bar(torque=None)
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    usual = linear_model(source, at=at, states=["A.phi"])
    for name in ("B.phi", "C.phi", "D.phi"):
        found = linear_model(source, at=at, states=[name])
        by_fmu = linear_model(fmu, at=at, states=[name])
        assert found.states == by_fmu.states == (name, name.replace("phi", "w"))
        assert_relative("A", by_fmu.A, found.A, 1e-12)  # sums in another order
        assert_relative("D", found.D, usual.D, 1e-12)
        # A step of the input is felt alike whatever the states are called.
        assert_relative("C B", found.C @ found.B, usual.C @ usual.B, 1e-11)


def test_a_time_is_where_a_run_gets_to(cart_pole: Path, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    inputs: Any = {"drive.f": lambda t: 3 * math.cos(5 * t)}
    run = gelenk.simulate(cart_pole, stop=0.42, inputs=inputs)
    for source in (cart_pole, fmu):
        found = linear_model(source, at=0.42, input_values=inputs)
        assert found.time == 0.42
        for name, value in zip(found.states, found.x0, strict=True):
            assert value == run[name][-1]
        assert found.u0.tolist() == [3 * math.cos(5 * 0.42)]


def test_a_point_may_name_states_parameters_and_inputs(cart_pole: Path, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    at = {"hinge.phi": 0.4, "hinge.w_start": -0.2, "track.v": 1.5, "pole.m": 0.3, "drive.f": 2.5}
    for source in (cart_pole, fmu):
        found = linear_model(source, at=at)
        assert found.x0.tolist() == [0, 0.4, 1.5, -0.2]
        assert found.u0.tolist() == [2.5]
        again = linear_model(
            source, at={"hinge.phi": 0.4, "track.v": 1.5}, parameters={"hinge.w_start": -0.2, "pole.m": 0.3},
            input_values={"drive.f": 2.5},
        )  # fmt: skip
        assert np.array_equal(again.A, found.A)
        lighter = linear_model(source, at=at | {"pole.m": 0.2})
        assert not np.array_equal(lighter.A, found.A)


def test_vectors_are_named_by_component() -> None:
    at = {"flight.r[2]": 0.5, "flight.w[1]": 0.0, "flight.w[2]": 0.0, "flight.w[3]": 0.0}
    found = linear_model(mechanisms.shipped("free_body"), at=at)
    assert found.x0[found.states.index("flight.r[2]")] == 0.5
    assert found.units["flight.theta[1]"] == "rad"


# --- warnings ---


def test_no_equilibrium_is_warned_of_by_name_and_rate(cart_pole: Path, tmp_path: Path) -> None:
    expected = (
        "t = 0 s is not an equilibrium: "
        r"track.v changes at -0.0699297 m/s2, hinge.w changes at 1.40035 rad/s2"
    )
    for source in (cart_pole, gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")):
        with pytest.warns(gelenk.OperatingPointWarning) as caught:
            gelenk.linearize(source)
        assert [str(w.message) for w in caught] == [expected]
        assert caught[0].filename == __file__  # it points at who asked


def test_an_equilibrium_is_not_warned_of(cart_pole: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gelenk.linearize(cart_pole, at=UPRIGHT)


def wheel(com: float, **sensors: Any) -> dict[str, Any]:
    """It spins at 3 rad/s about a level axis; its center of mass lies beside the axis [m]."""
    return scene(
        {"wheel": body(2.0, (com, 0, 0.3), (0.4, 0.5, 0.7))},
        {"J": joint("revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1], start={"w": 3.0})},
        gravity=[-9.81, 0, 0], sensors=sensors,
    )  # fmt: skip


def test_a_coordinate_that_does_not_stay_constant_is_named_where_it_counts() -> None:
    """A wheel's angle goes on at a steady speed. Weight may depend on it, or a sensor on its rim."""
    on_rim = wheel(0.0, rim=frame_sensor("wheel", (0.2, 0, 0)))
    for source, sentence in (
        (wheel(0.01), r"is not an equilibrium: J\.phi changes at 3 rad/s$"),
        (on_rim, r"is not an equilibrium: J\.phi changes at 3 rad/s$"),
    ):
        with pytest.warns(gelenk.OperatingPointWarning, match=sentence):
            gelenk.linearize(source)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gelenk.linearize(wheel(0.0))
        gelenk.linearize(on_rim, outputs=["J.w", "J.phi"])
        gelenk.modes(on_rim)


# --- errors ---


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"outputs": ["hinge.ph"]}, r"hinge\.ph: no such output; did you mean hinge\.phi"),
        ({"inputs": ["drive.f", "drive.g"]}, r"drive\.g: no such input; did you mean drive\.f\?"),
        ({"inputs": {"drive.f": 2.0}}, r"inputs: found values by name, expected names; values of inputs are"),
        ({"outputs": ["hinge.phi", "hinge.phi"]}, r"hinge\.phi: found twice, expected once"),
        ({"states": ["hinge.phi", "hinge.phi"]}, r"hinge\.phi: found twice, expected once"),
        ({"states": ["hinge.a", "track.s"]}, r"hinge\.a: no such state; did you mean"),
        (
            {"states": ["track.s"]},
            r"states: found 1, expected 2 coordinates, or these and their 2 velocities",
        ),
        ({"states": []}, r"states: found 0, expected 2 coordinates"),
        ({"at": {"hinge.fi": 0}}, r"hinge\.fi: no such state, parameter or input; did you mean"),
        ({"at": {"hinge.phi": math.nan}}, r"hinge\.phi: found nan, expected a finite number"),
        ({"at": -1.0}, r"at: found -1 s, expected 0 or more"),
        ({"at": math.inf}, r"at: found inf, expected a finite number"),
        ({"at": "soon"}, r"at: found 'soon', expected a number"),
        ({"at": {"drive.f": 1}, "input_values": {"drive.f": 1}}, r"drive\.f: given twice"),
        ({"at": UPRIGHT, "parameters": {"hinge.phi_start": 1}}, r"hinge\.phi: given twice"),
        ({"parameters": {"pole.n": 1}}, r"pole\.n: no such parameter or input"),
        ({"input_values": {"drive.tau": 1}}, r"drive\.tau: no such input"),
    ],
)  # fmt: skip
def test_wrong_calls_are_told(
    arguments: dict[str, Any], sentence: str, cart_pole: Path, tmp_path: Path
) -> None:
    for source in (cart_pole, gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")):
        with pytest.raises(gelenk.UsageError, match=sentence):
            gelenk.linearize(source, **arguments)


def test_a_quaternion_is_no_state(tmp_path: Path) -> None:
    source = mechanisms.shipped("heavy_top")
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        with pytest.raises(
            gelenk.UsageError, match=r"tip\.Q\[2\]: a quaternion .*; use tip\.theta\[1\.\.3\]$"
        ):
            linear_model(plant, states=["tip.Q[2]"])
        names = [f"tip.theta[{i}]" for i in (3, 1, 2)]
        assert linear_model(plant, states=names).states[3:] == ("tip.w[3]", "tip.w[1]", "tip.w[2]")


def test_a_guess_that_is_moved_is_no_point(four_bar_file: Path) -> None:
    with pytest.raises(gelenk.UsageError, match=r"D\.phi: assembly changed it from 1\.9 to 1\.915\d*, "):
        linear_model(four_bar_file, at={"D.phi": 1.9})
    at = {"D.phi": 1.9, "A.fixed": False, "D.fixed": True}
    found = linear_model(four_bar_file, at=at, states=["D.phi"])
    assert found.x0[0] == 1.9


def test_states_that_nothing_feels_may_be_left_out(cart_pole: Path, tmp_path: Path) -> None:
    """The cart's place: neither accelerations nor the other outputs change with it."""
    names = ["hinge.phi", "track.v", "hinge.w"]
    for source in (cart_pole, gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")):
        whole = linear_model(source, at=UPRIGHT)
        found = linear_model(source, at=UPRIGHT, states=names)
        kept = [whole.states.index(name) for name in names]
        outputs = [i for i, name in enumerate(whole.outputs) if name != "track.s"]
        assert found.outputs == tuple(whole.outputs[i] for i in outputs)
        # Rounding of the solve by the states' meaning, a permutation here.
        assert pytest.approx(whole.A[np.ix_(kept, kept)], rel=1e-13) == found.A
        assert pytest.approx(whole.B[kept], rel=1e-13) == found.B
        assert pytest.approx(whole.C[np.ix_(outputs, kept)], rel=1e-13, abs=1e-13) == found.C
        with pytest.raises(gelenk.UsageError, match=r"track\.s depends on track\.s, which is not among"):
            linear_model(source, at=UPRIGHT, states=names, outputs=["track.s"])
        with pytest.raises(gelenk.UsageError, match=r"der\(track\.s\) depends on track\.v, which is not"):
            linear_model(source, at=UPRIGHT, states=["track.s", "hinge.phi", "hinge.w"])


@warned.SINGULAR
def test_singular_positions_are_told(tmp_path: Path) -> None:
    source = mechanisms.parallelogram(0.0, 1.0)
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        with pytest.raises(
            gelenk.UsageError, match=r"t = 0 s: a loop is in or close to a singular configuration"
        ):
            gelenk.linearize(plant)


def test_a_dead_centre_is_told_for_the_states_it_is_one_for(tmp_path: Path) -> None:
    """Crank and coupler in one line: by the crank there is a linear model, by the rocker none."""
    reach, rocker, ground = 0.5 + 1.75, 1.5, 2.0
    source = four_bar(math.acos((ground**2 + reach**2 - rocker**2) / (2 * ground * reach)))
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        assert linear_model(plant).states == ("A.phi", "A.w")
        with pytest.raises(gelenk.UsageError, match=r"the states D\.phi, D\.w do not determine the others"):
            linear_model(plant, states=["D.phi"])


def test_states_asked_for_lead_over_the_dead_centre_of_those_of_the_plant() -> None:
    """As a motion by the rocker gets to it: its angle does not tell the crank's there."""
    reach, rocker, ground = 0.5 + 1.75, 1.5, 2.0
    source = four_bar(math.acos((ground**2 + reach**2 - rocker**2) / (2 * ground * reach)))
    plant = ScenePlant(gelenk.load(source))
    plant.start(None, {})
    core = plant._simulation._core
    core._take_states([plant.outputs.index("D.phi")], [plant.outputs.index("D.w")])
    with pytest.raises(gelenk.UsageError, match=r"the states D\.phi do not determine"):
        plant.derivatives([])
    found = MinimalRealization(plant.derivatives(["A.phi"]))
    assert found.names == ("A.phi", "A.w")
    assert np.array_equal(found.rate("A.w")[0], linear_model(source).A[1])


def rod_between_balls() -> dict[str, Any]:
    """Its spin about its own line is a rotation of one of its ball joints."""
    start = {"fixed": True}
    return scene(
        {"crank": body(1.0, (0.1, 0, 0), (0.01, 0.02, 0.02)),
         "rod": body(0.4, (0.5, 0.02, 0), (0.001, 0.02, 0.02)),
         "slider": body(1.0, (0, 0, 0), (0.01, 0.01, 0.01))},
        {"A": joint("revolute", frame("ground"), frame("crank"), axis=[0, 0, 1],
                    start={"phi": 0.4, "w": 1.0, **start}),
         "S": joint("spherical", frame("crank", (0.3, 0, 0)), frame("rod"), start={"w": [2.0, 0, 0]}),
         "T": joint("spherical", frame("rod", (1.0, 0, 0)), frame("slider")),
         "P": joint("prismatic", frame("ground"), frame("slider"), axis=[1, 0, 0], start={"s": 1.2})},
        gravity=[0, 0, -9.81],
    )  # fmt: skip


def test_a_spin_that_matters_is_among_the_states(tmp_path: Path) -> None:
    """The center of mass is beside the line between the balls; test_idle_rotations.py has idle spins."""
    source = rod_between_balls()
    models = [linear_model(plant) for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu"))]
    for model in models:
        assert model.states == ("A.phi", "S.theta[1]", "A.w", "S.w[1]")
        assert model.left_out == ()
    assert np.allclose(models[0].A, models[1].A, rtol=1e-9, atol=1e-9)


def test_an_fmu_without_derivatives_is_told(cart_pole: Path, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == "modelDescription.xml":
                wanted = b'providesDirectionalDerivative="true"'
                assert wanted in text
                text = text.replace(wanted, b'providesDirectionalDerivative="false"')
            new.writestr(name, text)
    with pytest.raises(gelenk.UsageError, match=r"other\.fmu: this FMU provides no directional derivatives"):
        linear_model(other)


def test_python_control_is_asked_for_in_words(cart_pole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(
        gelenk.UsageError, match="linear models require python-control, which cannot be imported: "
    ):
        gelenk.linearize(cart_pole, at=UPRIGHT)
    assert linear_model(cart_pole, at=UPRIGHT).A.shape == (4, 4)  # numbers need none


def test_names_that_differ_by_a_dot_are_told() -> None:
    source = with_sensors(mechanisms.shipped("cart_pole"), **{"hinge_phi": frame_sensor("pole")})
    assert gelenk.linearize(source, at=UPRIGHT).noutputs > 6  # sensors of such names are fine
    model = linear_model(source, at=UPRIGHT, outputs=["hinge.phi"])
    twice = gelenk.LinearModel(**{**vars(model), "outputs": ("a.b_c", "a_b.c")})
    with pytest.raises(
        gelenk.UsageError, match=r"outputs: python-control allows no dots in names, and a\.b_c, a_b\.c are"
    ):
        twice.to_control()


@pytest.mark.parametrize("sensors", [{}, {"R": reaction("W")}])
def test_nothing_that_moves_makes_an_empty_model(sensors: dict[str, Any], tmp_path: Path) -> None:
    source = scene({"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))}, sensors=sensors)
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        found = gelenk.linearize(plant)
        assert (found.nstates, found.ninputs) == (0, 0)


# --- the command ---


def test_command_prints_the_model(cart_pole: Path) -> None:
    lines = told("linearize", cart_pole, "--at", "hinge.phi=0", "--outputs", "hinge.phi,track.s").splitlines()
    assert lines[0] == "CartPole at t = 0 s: 4 states, 1 input, 2 outputs"
    assert lines[3].split() == ["track.s", "0", "m"]
    model = linear_model(cart_pole, at=UPRIGHT)
    (head,) = (k for k, line in enumerate(lines) if line.startswith("A "))
    assert lines[head].split() == ["A", *model.states]
    for line, name, row in zip(lines[head + 1 :], model.states, model.A, strict=False):
        first, *cells = line.split()
        assert first == f"der({name})"
        assert [float(x) for x in cells] == pytest.approx(row, rel=1e-5)
    assert lines[-2:] == ["hinge.phi             0", "track.s               0"]


def test_command_tells_programs_all_digits(cart_pole: Path, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    (tmp_path / "in.csv").write_text("time,drive.f\n0,2\n1,3\n")
    for arguments, inputs in (
        (("--input", "drive.f=2"), {"drive.f": 2.0}),
        (("--input", tmp_path / "in.csv"), {"drive.f": ([0, 1], [2, 3])}),
    ):
        for source in (cart_pole, fmu):
            done = call("linearize", source, "--at", "0.2", *arguments, "--set", "pole.m=0.3",
                        "--inputs", "drive.f", "--states", "hinge.phi,track.s", "--json")  # fmt: skip
            assert done.returncode == 0
            model = linear_model(
                source,
                at=0.2,
                input_values=inputs,
                parameters={"pole.m": 0.3},
                states=["hinge.phi", "track.s"],
            )
            assert json.loads(done.stdout) == model.to_dict()
            assert done.stderr == model.residual_rates + "\n"
            assert model.residual_rates.startswith("t = 0.2 s is not an equilibrium")


def test_command_tells_what_is_wrong(cart_pole: Path) -> None:
    assert faults("linearize", cart_pole, "--at", "soon") == ["--at: found 'soon', expected a number"]
    assert faults("linearize", cart_pole, "--at", "1", "--at", "2") == ["--at 1: expected NAME=VALUE"]
    assert faults("linearize", cart_pole, "--input", "drive.g=1") == [
        "drive.g: no such input; did you mean drive.f?"
    ]
    assert faults("linearize", cart_pole, "--input", "drive.f=x") == ["drive.f: found 'x', expected a number"]
