# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.modes as users meet it: what may be given, what is printed, pictures, the command."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from PIL import Image
from test_cli import call, faults, told

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import linear_model

UPRIGHT = {"hinge.phi": 0.0}


@pytest.fixture
def cart_pole(root: Path) -> Path:
    return root / "scenes" / "cart_pole.yaml"


def values(found: gelenk.Modes) -> list[complex]:
    return [mode.eigenvalue for mode in found.modes]


def test_scene_fmu_and_linear_models_have_the_same_modes(cart_pole: Path, tmp_path: Path) -> None:
    found = gelenk.modes(cart_pole, at=UPRIGHT)
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    model = linear_model(cart_pole, at=UPRIGHT)
    by_fmu, by_model = gelenk.modes(fmu, at=UPRIGHT), gelenk.modes(model)
    by_control = gelenk.modes(model.to_control())
    for other in (by_fmu, by_model, by_control):
        assert values(other) == pytest.approx(values(found), rel=1e-12, abs=1e-12)
        assert other.stability == "unstable"
        assert other.why.split(" (")[0] == "mode 3 grows by a factor of e in 0.1908 s"
    assert sorted(x.real for x in values(found)) == pytest.approx(sorted(model.to_control().poles().real))
    assert by_fmu.modes[2].shape == pytest.approx(found.modes[2].shape, rel=1e-12, abs=1e-12)
    assert by_fmu.modes[0].bodies == {}  # it has no frame sensors
    assert list(by_control.modes[0].shape) == ["track.s", "hinge.phi", "track.v", "hinge.w"]


def test_frame_sensors_of_an_fmu_are_told(tmp_path: Path) -> None:
    source = mechanisms.shipped("cart_pole")
    source["sensors"] = {"tip": {"type": "frame", "body": "pole", "position": [0, 0, 0.6]}}
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    mode = gelenk.modes(fmu, at=UPRIGHT).modes[2]
    s, phi = mode.shape["track.s"], mode.shape["hinge.phi"]
    assert {*mode.shape} == {"track.s", "hinge.phi"}  # the sensor's position is no joint's
    assert mode.bodies["tip"].translation == pytest.approx(np.array([s + 0.6 * phi, 0, 0]), abs=1e-12)
    assert mode.bodies["tip"].rotation == pytest.approx(np.array([0, phi, 0]), abs=1e-12)


def test_a_wheel_in_the_state_space_of_python_control() -> None:
    """No units there: all states are told."""
    system = control.ss([[0, 1], [-4, -0.4]], [[0], [1]], [[1, 0]], 0, states=["angle", "rate"])
    (mode,) = gelenk.modes(system).modes
    wn, zeta, _ = control.damp(system, doprint=False)
    assert (mode.natural_frequency, mode.damping_ratio) == pytest.approx((wn[0], zeta[0]), rel=1e-14)
    assert mode.shape["angle"] == pytest.approx(1 / mode.eigenvalue)
    assert mode.shape["rate"] == 1


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"at": {"hinge.fi": 0}}, r"hinge\.fi: no such state, parameter or input"),
        ({"at": -1.0}, r"at: found -1 s, expected 0 or more"),
        ({"rounding": 1.5}, r"rounding: found 1\.5, expected a number from 0 to less than 1"),
        ({"states": ["track.s"]}, r"states: found 1, expected 2 coordinates"),
        ({"parameters": {"pole.n": 1}}, r"pole\.n: no such parameter or input"),
    ],
)
def test_wrong_calls_are_told(arguments: dict[str, Any], sentence: str, cart_pole: Path) -> None:
    with pytest.raises(gelenk.UsageError, match=sentence):
        gelenk.modes(cart_pole, **arguments)


def test_linear_models_are_at_their_point_and_in_continuous_time() -> None:
    system = control.ss([[-1.0]], [[1.0]], [[1.0]], 0)
    with pytest.raises(gelenk.UsageError, match="at, parameters: not allowed with a linear model"):
        gelenk.modes(system, at=0.3, parameters={})
    sentence = r"a discrete-time model with steps of 0\.1 s, expected a continuous-time model"
    with pytest.raises(gelenk.UsageError, match=sentence):
        gelenk.modes(control.c2d(system, 0.1))
    with pytest.raises(gelenk.UsageError, match="modes of a linear model, expected modes of a scene"):
        gelenk.modes(system).animate(1, "x.gif")


def test_no_equilibrium_is_warned_of(cart_pole: Path) -> None:
    with pytest.warns(gelenk.OperatingPointWarning, match=r"hinge\.w changes at 1\.40035 rad/s2") as caught:
        gelenk.modes(cart_pole)
    assert caught[0].filename == __file__


def test_nothing_that_moves_has_no_modes() -> None:
    source = scene({"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))})
    found = gelenk.modes(source)
    assert (found.modes, found.stability, found.decided_by) == ((), "stable", None)
    assert str(found) == "Mechanism at t = 0 s: stable\n\nthe mechanism cannot move"


@pytest.mark.parametrize(("masses", "rest"), [(3, ""), (4, "; and 1 more that are not damped")])
def test_three_modes_that_persist_are_named_and_others_counted(masses: int, rest: str) -> None:
    """Masses on springs of 1, 2, ... N/m."""
    bodies = {f"m{i}": body(1.0) for i in range(1, masses + 1)}
    joints = {
        f"J{i}": joint("prismatic", frame("ground"), frame(f"m{i}")) | {"stiffness": i}
        for i in range(1, masses + 1)
    }
    found = gelenk.modes(scene(bodies, joints))
    named = [f"mode {i} is undamped at {math.sqrt(i):.4g} rad/s (J{i}.s)" for i in (1, 2, 3)]
    assert found.why == f"no mode is unstable, but {'; '.join(named)}{rest}"


def test_json_holds_all_of_it(cart_pole: Path) -> None:
    found = gelenk.modes(cart_pole, at=UPRIGHT)
    data = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert (data["stability"], data["decided_by"], data["why"]) == ("unstable", 3, found.why)
    first, _, third, _ = data["modes"]
    assert (first["damping_ratio"], first["time_constant"], first["kind"]) == (None, None, "rigid-body")
    assert complex(*third["eigenvalue"]) == found.modes[2].eigenvalue
    assert complex(*third["bodies"]["pole"]["rotation"][1]) == third["shape"]["hinge.phi"][0] == 1
    assert data["units"]["hinge.phi"] == "rad"


def test_what_is_printed_can_be_read(root: Path) -> None:
    stewart = gelenk.load(root / "scenes" / "stewart.yaml").to_dict()
    for stiffness, verdict, tables in ((5e3, "stable", 1), (0, "unstable", 2)):  # six shapes abreast
        for k in range(1, 7):
            stewart["joints"][f"leg{k}"]["stiffness"] = stiffness
        with pytest.warns(gelenk.OperatingPointWarning):
            lines = str(gelenk.modes(stewart)).splitlines()
        assert lines[0] == f"Stewart at t = 0 s: {verdict}"
        assert max(map(len, lines)) <= 130
        assert sum(line.startswith("shapes") for line in lines) == tables
    damped = scene(
        {"m": body(1.0)},
        {"J": joint("prismatic", frame("ground"), frame("m"), axis=[1, 0, 0], stiffness=9.0, damping=0.6)},
    )
    line = str(gelenk.modes(damped)).splitlines()[5].split()
    assert line == ["1", "-0.3", "+-", "2.98496i", "3", "0.477465", "0.1", "3.3333", "damped"]


# --- pictures ---


def test_a_shape_is_drawn_with_its_loop_closed(four_bar_file: Path, tmp_path: Path) -> None:
    held = gelenk.equilibrium(four_bar_file, at={"A.phi": -1.0})
    found = gelenk.modes(four_bar_file, at=held.at)
    out = found.animate(1, tmp_path / "x.gif")
    with Image.open(out) as film:
        assert film.n_frames == 40  # type: ignore[attr-defined]
        film.seek(0)
        first = np.array(film.convert("L"), float)
        film.seek(20)  # half a period on
        assert np.abs(np.array(film.convert("L"), float) - first).max() > 100  # it has moved
    posed = found._evaluator
    assert posed is not None
    still = posed.poses({})
    moved = posed.poses({n: 0.2 * x.real for n, x in found.modes[0].shape.items()})
    for name in ("crank", "coupler", "rocker"):
        turn = still[name][0].T @ moved[name][0]  # about y
        # To first order the mode's; the loop is closed, so second order of 0.2 rad is there, too.
        expected = 0.2 * found.modes[0].bodies[name].rotation[1].real
        assert math.atan2(turn[0, 2], turn[0, 0]) == pytest.approx(expected, abs=0.04)
    end, pin = (
        R @ [length, 0, 0] + p for length, (R, p) in ((1.75, moved["coupler"]), (1.5, moved["rocker"]))
    )
    assert end == pytest.approx(pin, abs=1e-9)  # m, as assembly allows


def test_fmus_are_drawn_by_the_scene_they_carry(cart_pole: Path, tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(cart_pole, tmp_path / "x.fmu")
    out = gelenk.modes(fmu, at=UPRIGHT).animate(3, tmp_path / "x.html", amplitude=0.1)
    assert "<script" in out.read_text()


def test_pictures_that_cannot_be_are_told(
    cart_pole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = gelenk.modes(cart_pole, at=UPRIGHT)
    for arguments, sentence in (
        ((5, "x.gif"), "mode: found 5, expected a number from 1 to 4"),
        ((0, "x.gif"), "mode: found 0, expected"),
        ((1, "x.png"), r"x\.png: found \.png, expected \.gif, \.html or \.mp4"),
        ((1, "x.gif", -1.0), "amplitude: found -1.0, expected more than 0"),
    ):
        with pytest.raises(gelenk.UsageError, match=sentence):
            found.animate(*arguments)
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(gelenk.UsageError, match=r"pip install 'gelenk\[view\]'"):
        found.animate(1, tmp_path / "x.gif")


@pytest.mark.filterwarnings("ignore::gelenk.OperatingPointWarning")
def test_loops_that_do_not_close_are_told(tmp_path: Path) -> None:
    found = gelenk.modes(mechanisms.shipped("slider_crank"))
    with pytest.raises(gelenk.UsageError, match=r"amplitude: 1e\+06 is too large: loop .* cannot be closed"):
        found.animate(1, tmp_path / "x.gif", 1e6)


# --- the command ---


def test_command_prints_the_modes(cart_pole: Path) -> None:
    assert told("modes", cart_pole, "--at", "hinge.phi=0") == f"{gelenk.modes(cart_pole, at=UPRIGHT)}\n"


def test_command_for_programs_tells_what_is_no_equilibrium_apart(cart_pole: Path) -> None:
    done = call("modes", cart_pole, "--json", "--set", "hinge.phi_start=0.2", "--states", "hinge.phi,track.s")
    assert done.returncode == 0
    assert done.stderr.startswith("t = 0 s is not an equilibrium: hinge.w changes at")
    with pytest.warns(gelenk.OperatingPointWarning):
        found = gelenk.modes(cart_pole, at={"hinge.phi": 0.2}, states=["hinge.phi", "track.s"])
    assert json.loads(done.stdout) == found.to_dict()


def test_command_draws(cart_pole: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.gif"
    told("modes", cart_pole, "--at", "hinge.phi=0", "--animate", "3", "-o", out)
    assert out.read_bytes()[:3] == b"GIF"
    assert faults("modes", cart_pole, "--animate", "3") == [
        "--animate and --output: found one of them, expected both or none"
    ]
