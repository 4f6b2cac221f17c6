# SPDX-License-Identifier: BSD-3-Clause
"""What model exchange refuses, and where it ends; driven loops, whose position depends on the time."""

from __future__ import annotations

import math
from pathlib import Path

import fmpy
import numpy as np
import pytest
from mechanisms import four_bar, four_bar_angles

import gelenk

from .derivatives import directional
from .host import DISCARD, ERROR, MODEL_EXCHANGE, OK, Fmu, Slave, expect
from .importer import Importer
from .plants import cranked, gyroscope, two_cylinders, with_circuit

TOLERANCE = 1e-9
LINKS = (0.5, 1.75, 1.5, 2.0)  # crank, coupler, rocker, ground [m]


def extracted(source: object, folder: Path) -> Fmu:
    found = gelenk.export_fmu(source, folder / "x.fmu")  # type: ignore[arg-type]
    return Fmu(fmpy.extract(str(found), str(folder / "extracted")))


def test_inputs_that_prescribe_motions_are_for_co_simulation(tmp_path: Path) -> None:
    fmu = extracted(cranked(), tmp_path)
    assert fmu.description.modelExchange is None
    refused = Slave(fmu, kind=MODEL_EXCHANGE)
    assert refused.component is None
    expect(
        refused, ERROR, ERROR, "type: found model exchange, expected co-simulation: crank.w_ref prescribes"
    )
    with pytest.raises(gelenk.UsageError, match=r"expected FMI 2\.0 or 3\.0 model exchange"):
        gelenk.simulate(tmp_path / "x.fmu", kind="me")


def test_contacts_of_time_steps_are_for_co_simulation(tmp_path: Path) -> None:
    fmu = extracted(two_cylinders(), tmp_path)
    assert fmu.description.modelExchange is None
    refused = Slave(fmu, kind=MODEL_EXCHANGE)
    expect(
        refused,
        ERROR,
        ERROR,
        "contacts are solved in time steps, not at located events: contacts.c is between",
    )


def test_a_kind_that_is_none_and_scenes_are_refused() -> None:
    with pytest.raises(gelenk.UsageError, match=r"kind: found 'xy', expected 'cs'"):
        gelenk.simulate(four_bar(), kind="xy")
    with pytest.raises(gelenk.UsageError, match=r"kind: found 'me' with a scene, expected a \.fmu file"):
        gelenk.simulate(four_bar(), kind="me")


def test_states_beyond_the_reach_of_the_links_are_discarded(root: Path, tmp_path: Path) -> None:
    """The elbows of the five-bar are 0.3 m + 0.5 m cos(a) apart, its upper links at a and 180 deg - a; the
    lower links reach 0.7 m.
    """
    s = Importer(extracted(root / "scenes" / "five_bar.yaml", tmp_path)).start()
    x = s.states()
    reach = math.acos(0.8)

    def go_to(a: float) -> tuple[int, list[float]]:
        s.go_to(0.0, [math.pi - a, 0.0, a, 0.0])
        return s.read_states("fmi2GetDerivatives", 4)

    status, rates = go_to(reach + 1e-3)
    assert status == OK, s.said
    assert all(map(math.isfinite, rates))
    status, _ = go_to(reach - 1e-3)
    expect(
        s,
        status,
        DISCARD,
        "t = 0 s: the states do not determine the position: joint ",
        "whose coordinate is a state",
    )
    s.go_to(0.0, x)
    assert all(map(math.isfinite, s.rates()))
    s.free()


@pytest.mark.parametrize("plant", [with_circuit, gyroscope], ids=lambda plant: plant.__name__)
def test_directional_derivatives_are_those_of_the_rates(plant: object, tmp_path: Path) -> None:
    """Of states set by the importer, by differences of fourth order, h = 1e-3: 1e-9 of the largest."""
    fmu = extracted(plant(), tmp_path)  # type: ignore[operator]
    s = Importer(fmu).start()
    names = [u.variable.derivative.name for u in fmu.description.derivatives]
    x = np.array(s.states())
    x += 0.01 * np.arange(1, len(x) + 1) / len(x)
    for k, name in enumerate(names):
        h = 1e-3 * np.eye(len(x))[k]
        s.go_to(0.0, x.tolist())
        exact = np.array(directional(s, [f"der({n})" for n in names], {name: 1.0}))
        found = np.zeros(len(x))
        for step, weight in ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12)):
            s.go_to(0.0, (x + step * h).tolist())
            found += weight * np.array(s.rates()) / 1e-3
        norm = [i for i, n in enumerate(names) if ".Q[" in n]
        if k in norm:
            continue  # their norm changes
        np.testing.assert_allclose(
            exact, found, rtol=0, atol=1e-7 * max(1.0, np.abs(found).max()), err_msg=name
        )
    s.free()


def test_driven_loops_follow_the_time_over_many_turns(tmp_path: Path) -> None:
    """A crank with 10 rad/s and no state: angles of all joints in long steps, of 3 rad each, count turns."""
    source = four_bar(1.1)
    source["constraints"] = {"turn": {"type": "motion", "joint": "A", "polynomial": [1.1, 10.0]}}
    source["joints"]["A"]["start"] = {"phi": 1.1}
    del source["motors"]
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    run = gelenk.simulate(fmu, stop=3.0, step=0.3, kind="me")
    for t, crank, rocker in zip(run.time, run["A.phi"], run["D.phi"], strict=True):
        assert crank == pytest.approx(1.1 + 10 * t, abs=1e-12 * (1 + 10 * t))
        _, psi = four_bar_angles(1.1 + 10 * t, LINKS)
        _, start = four_bar_angles(1.1, LINKS)
        assert rocker - run["D.phi"][0] == pytest.approx(psi - start, abs=1e-12)


def test_quaternions_are_normalized_at_an_event(tmp_path: Path) -> None:
    s = Importer(extracted(gyroscope(), tmp_path)).start()
    names = [u.variable.derivative.name for u in s.fmu.description.derivatives]
    Q = [k for k, name in enumerate(names) if name.startswith("S.Q[")]
    x = s.states()
    rates = s.rates()
    longer = [1.001 * value if k in Q else value for k, value in enumerate(x)]
    s.go_to(0.0, longer)
    np.testing.assert_allclose(s.rates(), rates, rtol=0, atol=1e-12 * np.abs(rates).max())
    assert s.completed()
    s.enter_event_mode()
    assert s.event().states_changed
    norm = math.hypot(*(s.states()[k] for k in Q))
    assert norm == pytest.approx(1, abs=1e-15)
    s.free()


def test_a_scene_of_the_gallery_with_contacts(root: Path, tmp_path: Path) -> None:
    """A cam lets its follower go and catches it: impacts, sliding and flight."""
    fmu = gelenk.export_fmu(root / "docs/gallery/cam/scene.yaml", tmp_path / "x.fmu")
    inside, outside = (
        gelenk.simulate(
            fmu, stop=1.0, step=0.01, tolerance=TOLERANCE, outputs=["guide.s", "guide.v"], kind=kind
        )
        for kind in ("cs", "me")
    )
    np.testing.assert_allclose(outside["guide.s"], inside["guide.s"], rtol=0, atol=100 * TOLERANCE)
    np.testing.assert_allclose(
        outside["guide.v"], inside["guide.v"], rtol=0, atol=1000 * TOLERANCE
    )  # 1.6 m/s


@pytest.mark.parametrize("step", [0.01, 0.05, 0.1])
def test_a_time_event_a_rounding_from_a_communication_point(step: float, tmp_path: Path) -> None:
    """The sum of steps of 0.01 s to 0.7 s is one rounding below the point of the table at 0.7 s."""
    table = {"time": [0, 0.7, 2], "value": [0, 1, 0.5], "interpolation": "pchip"}
    arm = {"mass": 1, "com": [0.1, 0, 0], "inertia": [0.1] * 3}
    source = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"a": arm, "b": arm},
        "joints": {
            "A": {"type": "revolute", "axis": [0, -1, 0], "parent": "ground", "child": "a"},
            "B": {
                "type": "revolute",
                "axis": [0, -1, 0],
                "parent": "a",
                "child": "b",
                "start": {"phi": 0.2, "w": 0, "fixed": True},
            },
        },
        "constraints": {"m": {"type": "motion", "joint": "A", "table": table}},
    }
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    found, expected = (
        gelenk.simulate(fmu, stop=1.8, step=step, kind=kind, tolerance=1e-9) for kind in ("me", "cs")
    )
    assert np.abs(found["B.phi"] - expected["B.phi"]).max() < 1e-7


def test_states_many_turns_away_are_said_to_be_far(root: Path, tmp_path: Path) -> None:
    """The crank can turn fully: no limit of its motion is near."""
    s = Importer(extracted(root / "scenes" / "four_bar.yaml", tmp_path)).start()
    phi, w = s.states()
    s.go_to(0.0, [phi + 20 * math.pi, w])
    assert s.read_states("fmi2GetDerivatives", 2)[0] == OK
    s.go_to(0.0, [phi + 40 * math.pi, w])
    status, _ = s.read_states("fmi2GetDerivatives", 2)
    expect(s, status, DISCARD, "too far from those at the end of the last step (more than 100 rad)")
    s.free()
