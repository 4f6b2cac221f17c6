# SPDX-License-Identifier: BSD-3-Clause
"""Modes, compared with closed forms: frequencies, damping ratios, shapes, kinds and stability."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from models import linear_plants as plants
from models.derivative_cases import CASES
from models.one_dof import Jet

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import linear_model
from gelenk.modal.analysis import found_in
from physics.analysis.test_linear_models import BARS, TOP_WEIGHT

CLOSE = 1e-11  # relative: 100 rounding errors of a matrix whose entries sum a few terms; measured 1e-13


def test_damped_oscillator() -> None:
    """Natural frequency sqrt(k / m), damping ratio d / 2 sqrt(k m), time constant 2 m / d."""
    m, d, k = 2.0, 3.0, 50.0
    (mode,) = gelenk.modes(oscillator(m, d, k)).modes
    assert mode.natural_frequency == pytest.approx(math.sqrt(k / m), rel=CLOSE)
    assert mode.frequency_hz == pytest.approx(math.sqrt(k / m) / (2 * math.pi), rel=CLOSE)
    assert mode.damping_ratio == pytest.approx(d / (2 * math.sqrt(k * m)), rel=CLOSE)
    assert mode.time_constant == pytest.approx(2 * m / d, rel=CLOSE)
    assert (mode.kind, mode.is_oscillatory, mode.multiplicity, mode.chain_length) == ("damped", True, 1, 1)
    assert mode.shape == {"J.s": 1}
    assert mode.states["J.v"] == pytest.approx(mode.eigenvalue)


def oscillator(m: float, d: float, k: float) -> Scene:
    return scene(
        {"mass": body(m)},
        {"J": joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], damping=d, stiffness=k)},
    )


@pytest.mark.parametrize(
    ("d", "k", "stability", "kinds"),
    [
        (20.0, 50.0, "stable", [("damped", 1)]),  # critical: a double eigenvalue -5 with one shape
        (30.0, 50.0, "stable", [("damped", 1), ("damped", 1)]),
        (0.0, 50.0, "marginal", [("undamped", 1)]),
        (3.0, 0.0, "marginal", [("rigid-body", 1), ("damped", 1)]),
        (0.0, 0.0, "marginal", [("drifting", 2)]),
    ],
)
def test_kinds_of_modes_and_stability_of_one_mass(d: float, k: float, stability: str, kinds: Any) -> None:
    found = gelenk.modes(oscillator(2.0, d, k))
    assert found.stability == stability
    assert [mode.kind for mode in found.modes] == [kind for kind, _ in kinds]
    lengths = [2] if (d, k) == (20.0, 50.0) else [length for _, length in kinds]
    assert [mode.chain_length for mode in found.modes] == lengths


def test_upright_top_at_rest_is_unstable() -> None:
    found = gelenk.modes(plants.top(0.0))
    assert found.stability == "unstable"
    growth = math.sqrt(TOP_WEIGHT / plants.ACROSS)
    grows = [mode for mode in found.modes if mode.kind == "unstable"]
    assert [mode.eigenvalue for mode in grows] == pytest.approx([growth] * 2, rel=CLOSE)
    assert [mode.multiplicity for mode in grows] == [2, 2]
    assert [mode.names for mode in grows] == [["S.theta[1]"], ["S.theta[2]"]]  # distinct shapes
    assert found.decided_by in grows


def two_pendulums(k: float, height: float, lengths: tuple[float, float] = (0.5, 0.5)) -> Scene:
    """Point masses of 1.3 kg, coupled by a spring between points at `height` [m] below their pivots."""
    about_y = {"axis": [0, 1, 0]}
    return scene(
        {f"p{i}": body(1.3, (0, 0, -lengths[i])) for i in (0, 1)},
        {f"J{i}": joint("revolute", frame("ground", (0.4 * i, 0, 0)), frame(f"p{i}"), **about_y)
         for i in (0, 1)},
        gravity=[0, 0, -GRAVITY],
        forces={"s": {"type": "spring_damper", "from": frame("p0", (0, 0, -height)),
                      "to": frame("p1", (0, 0, -height)), "stiffness": k, "length": 0.4}},
    )  # fmt: skip


def test_two_pendulums_coupled_by_a_spring() -> None:
    """sqrt(g / l) in phase, sqrt(g / l + 2 k a^2 / m l^2) in antiphase."""
    k, a, length = 3.0, 0.2, 0.5
    found = gelenk.modes(two_pendulums(k, a))
    assert found.stability == "marginal"
    together, apart = found.modes
    assert together.natural_frequency == pytest.approx(math.sqrt(GRAVITY / length), rel=CLOSE)
    assert apart.natural_frequency == pytest.approx(
        math.sqrt(GRAVITY / length + 2 * k * a**2 / (1.3 * length**2)), rel=CLOSE
    )
    for mode, sign in ((together, 1), (apart, -1)):
        assert mode.shape["J0.phi"] == pytest.approx(sign * mode.shape["J1.phi"], rel=CLOSE)
        # The bodies rotate about y; their frames are at the pivots and do not translate.
        assert mode.bodies["p1"].rotation == pytest.approx(np.array([0, mode.shape["J1.phi"], 0]), abs=CLOSE)
        assert mode.bodies["p1"].translation == pytest.approx(np.zeros(3), abs=CLOSE)


def test_double_eigenvalues_with_two_shapes_are_marginally_stable() -> None:
    """Two equal pendulums oscillate independently: the modes are undamped, and none grows as t."""
    found = gelenk.modes(two_pendulums(0.0, 0.2))
    assert found.stability == "marginal"
    assert [(m.multiplicity, m.chain_length, m.kind) for m in found.modes] == [(2, 1, "undamped")] * 2
    assert [m.names for m in found.modes] == [["J0.phi"], ["J1.phi"]]
    assert [m.shape["J1.phi"] for m in found.modes] == pytest.approx([0, 1], abs=CLOSE)


def test_spherical_pendulum() -> None:
    """Two equal oscillations, and a rotation about the vertical that drifts."""
    drift, *swings = gelenk.modes(plants.top(0.0, upright=False)).modes
    assert (drift.kind, drift.names, drift.chain_length) == ("drifting", ["S.theta[3]"], 2)
    frequency = math.sqrt(TOP_WEIGHT / plants.ACROSS)
    assert [m.natural_frequency for m in swings] == pytest.approx([frequency] * 2, rel=CLOSE)
    assert [(m.kind, m.multiplicity, m.chain_length) for m in swings] == [("undamped", 2, 1)] * 2


@pytest.mark.parametrize("n", [1, 5, 24])
def test_chain_of_equal_masses_and_springs(n: int) -> None:
    """Between two walls: frequencies 2 sqrt(k / m) sin(j pi / 2 (n + 1)), shapes sin(i j pi / (n + 1))."""
    m, k, d = 0.7, 130.0, 0.1
    ends = [frame("ground"), *(frame(f"m{i}") for i in range(n)), frame("ground", (d * (n + 1), 0, 0))]
    source = scene(
        {f"m{i}": body(m) for i in range(n)},
        {f"J{i}": joint("prismatic", frame("ground"), frame(f"m{i}"), axis=[1, 0, 0],
                        start={"s": d * (i + 1), "fixed": True}) for i in range(n)},
        forces={f"s{i}": {"type": "spring_damper", "from": ends[i], "to": ends[i + 1], "stiffness": k,
                          "length": d} for i in range(n + 1)},
    )  # fmt: skip
    found = gelenk.modes(source)
    assert found.stability == "marginal"
    for j, mode in enumerate(found.modes, 1):
        arc = j * math.pi / (n + 1)
        assert mode.natural_frequency == pytest.approx(2 * math.sqrt(k / m) * math.sin(arc / 2), rel=CLOSE)
        shape = np.array([mode.shape[f"J{i}.s"] for i in range(n)])
        expected = np.sin(arc * np.arange(1, n + 1))
        first = int(np.abs(shape - 1).argmin())  # the largest component, one of two equal ones
        # Neighboring frequencies differ by 1/n^2; rounding errors of shapes are divided by that.
        assert shape == pytest.approx(expected / expected[first], abs=1e-9)
    assert len(found.modes) == n


def test_free_body_at_rest_has_six_drifting_modes() -> None:
    """Twelve eigenvalues zero with six shapes."""
    at = {f"flight.w[{i}]": 0.0 for i in (1, 2, 3)}
    found = gelenk.modes(mechanisms.shipped("free_body"), at=at)
    assert found.stability == "marginal"
    assert [(m.kind, m.chain_length, m.multiplicity) for m in found.modes] == [("drifting", 2, 12)] * 6
    wanted = [f"flight.{key}[{i}]" for key in ("r", "theta") for i in (1, 2, 3)]
    assert [m.names for m in found.modes] == [[name] for name in wanted]
    assert "drifts: flight.r[1] continues at constant velocity after a push" in found.why
    for i, mode in enumerate(found.modes):
        motion = mode.bodies["body"]
        assert np.concatenate([motion.translation, motion.rotation]) == pytest.approx(np.eye(6)[i], abs=CLOSE)


# --- gyroscopes ---


def critical_spin() -> float:
    return 2 * math.sqrt(TOP_WEIGHT * plants.ACROSS) / plants.ALONG


@pytest.mark.parametrize("share", [1.0001, 1.3, 4.0])
def test_sleeping_top_precesses_and_nutates(share: float) -> None:
    """At (I3 w -+ sqrt(I3^2 w^2 - 4 I1 m g l)) / 2 I1 in space, less w in body axes (Klein & Sommerfeld)."""
    w = share * critical_spin()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.OperatingPointWarning)  # the angle about the axis increases
        found = gelenk.modes(plants.top(w))
    spin = plants.ALONG * w
    root = math.sqrt(spin**2 - 4 * plants.ACROSS * TOP_WEIGHT)
    expected = sorted(abs(w - (spin + sign * root) / (2 * plants.ACROSS)) for sign in (-1, 1))
    swings = [m for m in found.modes if m.is_oscillatory]
    # The two move by sqrt of an error where they meet: 1e-14 / (share - 1).
    assert [m.natural_frequency for m in swings] == pytest.approx(expected, rel=CLOSE)
    assert found.stability == "marginal"
    assert [m.kind for m in found.modes] == ["drifting", "undamped", "undamped"]


def test_top_at_the_critical_spin_is_unstable() -> None:
    """Both frequencies are equal, with one shape: the oscillation grows as t."""
    w = critical_spin()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.OperatingPointWarning)
        found = gelenk.modes(plants.top(w))
        below = gelenk.modes(plants.top(0.9999 * w))
    worst = found.decided_by
    assert worst is not None
    assert (found.stability, worst.chain_length, worst.kind) == ("unstable", 2, "unstable")
    assert worst.eigenvalue == pytest.approx(1j * abs(w - plants.ALONG * w / (2 * plants.ACROSS)), rel=1e-9)
    assert "grows as t, oscillating at" in found.why
    assert below.stability == "unstable"
    assert below.decided_by is not None
    assert below.decided_by.eigenvalue.real > 0
    assert "grows by a factor of e in" in below.why


# --- circulatory forces ---

ZIEGLER = 3.5 - math.sqrt(2)  # critical P l / k (Ziegler 1952): masses 2 m and m, both springs k


def ziegler(load: float) -> Scene:
    """Ziegler's double pendulum: massless rods of 1 m, springs of 1 N m/rad, a follower force at the end."""
    about_z = {"axis": [0, 0, 1], "stiffness": 1.0}
    return scene(
        {"first": body(2.0, (1, 0, 0)), "second": body(1.0, (1, 0, 0))},
        {"A": joint("revolute", frame("ground"), frame("first"), **about_z),
         "B": joint("revolute", frame("first", (1, 0, 0)), frame("second"), **about_z)},
        forces={"P": {"type": "wrench", "body": "second", "position": [1, 0, 0], "force": [-load, 0, 0],
                      "frame": "body"}},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("share", "stability", "lengths"),
    [(0.9999, "marginal", [1, 1]), (1.0, "unstable", [2]), (1.0001, "unstable", [1, 1])],
)
def test_ziegler_pendulum_flutters_at_and_above_the_critical_load(
    share: float, stability: str, lengths: list[int]
) -> None:
    found = gelenk.modes(ziegler(share * ZIEGLER))
    assert found.stability == stability
    assert [mode.chain_length for mode in found.modes] == lengths
    if share == 1:  # det(M w^4) = det K: 2 w^4 = 1
        assert found.modes[0].eigenvalue == pytest.approx(1j * 0.5**0.25, rel=1e-8)
        assert found.why.startswith("mode 1 grows as t, oscillating at 0.8409 rad/s")


def test_ball_on_a_free_beam_is_unstable() -> None:
    """With x'' = c a, a'' = 0: four eigenvalues zero, one shape. It is no drift: it grows faster than t."""
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1
    A[2, 1] = 7.0
    model = linear_model(two_pendulums(0.0, 0.2))
    found = found_in(gelenk.LinearModel(**{**vars(model), "A": A}), 1e-12)
    assert found.stability == "unstable"
    assert [(m.kind, m.chain_length) for m in found.modes] == [("unstable", 4)]
    assert found.why == "mode 1 grows as t^3 (J0.phi): 4 equal eigenvalues share one mode shape"


# --- loops ---


def test_mode_shapes_of_dependent_joints_and_bodies_satisfy_the_loop() -> None:
    """Four-bar: derivatives of its angles by triangle geometry; the coupler's end moves with the crank's."""
    source = four_bar(1.1)
    source["joints"]["D"] |= {"stiffness": 900.0, "spring_reference": BARS.angles(Jet(1.1, 1.0))[1].x}
    held = gelenk.equilibrium(source)
    (mode,) = gelenk.modes(source, at=held.at).modes
    phi = held.values["A.phi"]
    theta, psi = BARS.angles(Jet(phi, 1.0))
    derivatives = {"A.phi": 1.0, "B.phi": theta.d - 1, "C.phi": psi.d - theta.d, "D.phi": psi.d}
    a = mode.shape["A.phi"]
    assert {n: x / a for n, x in mode.shape.items()} == pytest.approx(derivatives, rel=1e-10)
    assert mode.bodies["coupler"].rotation / a == pytest.approx(np.array([0, 0, theta.d]), rel=1e-10)
    tip = 0.5 * np.array([-math.sin(phi), math.cos(phi), 0])
    assert mode.bodies["coupler"].translation / a == pytest.approx(tip, abs=1e-10)
    assert mode.kind == "damped"  # its crank is damped


@warned.PRESSED
@pytest.mark.parametrize("name", list(CASES))
@pytest.mark.filterwarnings("ignore::gelenk.OperatingPointWarning")
def test_every_mode_solves_the_eigenvalue_problem(name: str, tmp_path: Path) -> None:
    """Modes account for all states, with the lengths of their chains; those of the FMU are the same."""
    case = CASES[name]
    source = case.make()
    found = gelenk.modes(source, input_values=case.inputs)
    model = linear_model(source, input_values=case.inputs)
    size = np.linalg.norm(model.A)
    assert sum(m.chain_length * (2 if m.is_oscillatory else 1) for m in found.modes) == len(model.states)
    for mode in found.modes:
        v = np.array([mode.states[state] for state in model.states])
        # Means of clusters lie between their members, up to the root of 1e-12 away.
        bound = 1e-10 if mode.multiplicity == mode.chain_length == 1 else 1e-5
        assert np.abs(model.A @ v - mode.eigenvalue * v).max() < bound * size * np.abs(v).max(), mode.number
        assert {*mode.bodies} == {n for n, b in gelenk.load(source).to_dict()["bodies"].items() if b["mass"]}
    by_fmu = gelenk.modes(gelenk.export_fmu(source, tmp_path / "x.fmu"), input_values=case.inputs)
    assert by_fmu.stability == found.stability
    assert [m.kind for m in by_fmu.modes] == [m.kind for m in found.modes]
    assert list(by_fmu.modes[0].shape) == list(found.modes[0].shape)


def test_massless_rods_are_not_among_the_moving_bodies() -> None:
    """The analysis puts no sensors on them, which would make them bodies."""
    source = four_bar(1.1)
    source["bodies"]["coupler"] = {"mass": 0.0}
    source["joints"]["D"] |= {"stiffness": 50.0}
    held = gelenk.equilibrium(source)
    found = gelenk.modes(source, at=held.at)
    assert {*found.modes[0].bodies} == {"crank", "rocker"}
    assert "B.phi" in found.modes[0].shape
