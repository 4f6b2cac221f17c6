# SPDX-License-Identifier: BSD-3-Clause
"""Events of model exchange: what jumps, against closed forms and co-simulation."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from scipy.optimize import brentq

import gelenk

from .host import Fmu
from .importer import Importer

pytestmark = warned.GUESSES

TOLERANCE = 1e-9
BOUND = 100 * TOLERANCE


def slide(mass: float = 1.0, gravity: float = 0.0, start: dict[str, Any] | None = None, **keys: Any) -> Scene:
    """A body on a vertical guide J, with a motor `drive`."""
    sections = {name: keys.pop(name) for name in ("tables", "inputs", "states", "contacts") if name in keys}
    begin = {"s": 0.0, "v": 0.0, "fixed": True} | (start or {})
    return scene(
        {"block": body(mass)},
        {"J": joint("prismatic", frame("ground"), frame("block"), start=begin, **keys)},
        motors={"drive": {"joint": "J"}},
        gravity=[0, 0, -gravity],
        **sections,
    )


def both(source: Scene, folder: Path, **options: Any) -> tuple[gelenk.Result, gelenk.Result]:
    """A run of CVODE outside the FMU, and one of co-simulation."""
    fmu = gelenk.export_fmu(source, folder / "x.fmu")
    outside, inside = (
        gelenk.simulate(fmu, tolerance=TOLERANCE, kind=kind, **options) for kind in ("me", "cs")
    )
    for name in inside.names:
        bound = BOUND * max(1.0, np.abs(inside[name]).max())
        np.testing.assert_allclose(outside[name], inside[name], rtol=0, atol=bound, err_msg=name)
    return outside, inside


def extracted(source: Scene, folder: Path) -> Fmu:
    found = gelenk.export_fmu(source, folder / "y.fmu")
    return Fmu(fmpy.extract(str(found), str(folder / "extracted")))


def bounces(restitution: float, height: float, time: float) -> tuple[float, float]:
    """Closed form: height above the floor and speed of a bouncing ball."""
    v = math.sqrt(2 * GRAVITY * height)
    t = time - v / GRAVITY
    if t < 0:
        return height - GRAVITY * time**2 / 2, -GRAVITY * time
    while True:
        v *= restitution
        if t < 2 * v / GRAVITY:
            return v * t - GRAVITY * t**2 / 2, v - GRAVITY * t
        t -= 2 * v / GRAVITY


def test_a_body_bounces_at_its_limit(tmp_path: Path) -> None:
    """Five impacts: an error of an event time of dt would displace the body by 2 v dt."""
    source = slide(0.7, GRAVITY, {"s": 1.1}, limit={"lower": 0.1, "restitution": 0.8})
    run, _ = both(source, tmp_path, stop=2.0, step=0.013)
    exact = np.array([bounces(0.8, 1.0, t) for t in run.time])
    np.testing.assert_allclose(run["J.s"], 0.1 + exact[:, 0], rtol=0, atol=BOUND)
    np.testing.assert_allclose(run["J.v"], exact[:, 1], rtol=0, atol=BOUND * 5)  # m/s: v = 4.4


def test_a_body_comes_to_rest_at_its_limit(tmp_path: Path) -> None:
    """Infinitely many impacts until 1.3546 s; afterwards it is at rest, exactly, with a rate of zero."""
    source = slide(0.7, GRAVITY, {"s": 1.1}, limit={"lower": 0.1, "restitution": 0.5})
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    run = gelenk.simulate(fmu, tolerance=TOLERANCE, kind="me", stop=2.0, step=0.1)
    assert run["J.v"][-1] == 0
    assert run["J.a"][-1] == 0
    assert run["J.s"][-1] == run["J.s"][-3] == pytest.approx(0.1, abs=1e-10)


def test_dry_friction_lets_go_and_stops(tmp_path: Path) -> None:
    """A force 4 sin(2 pi t) N on 1 kg against 3 N of friction moves it from where they are equal until its
    momentum is used up; then friction holds it until the force is -3 N, at 0.635 s.
    """
    w = 2 * math.pi
    first = math.asin(3 / 4) / w

    def speed(t: float) -> float:
        return 4 / w * (math.cos(w * first) - math.cos(w * t)) - 3 * (t - first)

    def distance(t: float) -> float:
        change = (math.sin(w * t) - math.sin(w * first)) / w
        return 4 / w * (math.cos(w * first) * (t - first) - change) - 3 / 2 * (t - first) ** 2

    stop = brentq(speed, 0.3, 0.5, xtol=1e-15)
    run, _ = both(
        slide(friction={"coulomb": 3.0}), tmp_path, stop=0.6, step=1e-3,
        inputs={"drive.f": lambda t: 4 * math.sin(w * t)},
    )  # fmt: skip
    exact = [distance(min(max(t, first), stop)) for t in run.time]
    np.testing.assert_allclose(run["J.s"], exact, rtol=0, atol=BOUND)
    assert (run["J.v"][run.time < first] == 0).all()
    assert (run["J.v"][run.time > stop] == 0).all()
    assert run["J.s"][-1] == pytest.approx(distance(stop), abs=BOUND)


def test_an_input_that_jumps_ends_rest(tmp_path: Path) -> None:
    """3 N against 2 N of friction from 0.2 s on: v = t - 0.2 s."""
    run, _ = both(
        slide(friction={"coulomb": 2.0}), tmp_path, stop=0.5, step=0.01,
        inputs={"drive.f": lambda t: 3.0 if t >= 0.2 - 1e-12 else 1.0}, hold=True,
    )  # fmt: skip
    np.testing.assert_allclose(run["J.v"], np.maximum(0, run.time - 0.2), rtol=0, atol=BOUND)


def test_points_of_a_table_are_time_events(tmp_path: Path) -> None:
    """A force over time by straight lines, at whose points steps must end."""
    points = [0.0, 0.125, 0.3, 0.31, 0.7]
    values = [0.0, 10.0, -5.0, 40.0, 0.0]
    source = slide(
        law={"effort": "table(push, t)"},
        tables={"push": {"x": points, "values": values, "interpolation": "linear"}},
    )
    run, _ = both(source, tmp_path, stop=0.6, step=0.02)
    fine = np.unique(np.concatenate([points, run.time]))
    force = np.interp(fine, points, values)
    speed = np.concatenate([[0], np.cumsum(np.diff(fine) * (force[1:] + force[:-1]) / 2)])
    np.testing.assert_allclose(run["J.v"], np.interp(run.time, fine, speed), rtol=0, atol=BOUND)
    s = Importer(extracted(source, tmp_path))
    assert s.setup() == s.enter() == s.leave() == 0
    found = []
    for _ in points[1:]:
        info = s.event()
        assert info.next_event_time_defined
        found.append(info.next_event_time)
        s.go_on()
        s.set_time(info.next_event_time)
        s.enter_event_mode()
    assert found == points[1:]
    assert not s.event().next_event_time_defined
    s.free()


def test_a_kink_of_a_law_is_an_event(tmp_path: Path) -> None:
    """Against a spring of 400 N/m that begins at 0.1 m: a half oscillation of pi/20 s, then back."""
    source = slide(law={"effort": "-400*max(0, s - 0.1)"}, start={"v": 1.0})
    run, _ = both(source, tmp_path, stop=0.5, step=0.01)
    back = 0.1 + math.pi / 20

    def exact(t: float) -> float:
        if t < 0.1:
            return t
        return 0.1 + math.sin(20 * (t - 0.1)) / 20 if t < back else 0.1 - (t - back)

    np.testing.assert_allclose(run["J.s"], [exact(t) for t in run.time], rtol=0, atol=BOUND)
