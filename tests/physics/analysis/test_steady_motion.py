# SPDX-License-Identifier: BSD-3-Clause
"""Steady motions, in which velocities remain constant, and linear models about them, against closed forms."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models import linear_plants as plants

import gelenk
from gelenk.chart.mechanisms import governor
from gelenk.linear import linear_model

CLOSE = 1e-11  # Newton's method has converged; rounding of sums of a few terms


def steady(source: Scene, tmp_path: Path | None = None, **arguments: Any) -> gelenk.Equilibrium:
    """The steady motion of the scene; its FMU must have the same, and a run must continue it for 0.5 s."""
    found = gelenk.equilibrium(source, **arguments)
    assert found.residual < 1e-8
    if tmp_path is not None:
        by_fmu = gelenk.equilibrium(gelenk.export_fmu(source, tmp_path / "x.fmu"), **arguments)
        assert [*by_fmu.values.values()] == pytest.approx([*found.values.values()], rel=1e-9, abs=1e-9)
        assert list(by_fmu.advancing) == list(found.advancing)
    with warnings.catch_warnings():
        warnings.simplefilter("error", gelenk.OperatingPointWarning)
        gelenk.modes(source, at=found.at)
    run = gelenk.simulate(source, stop=0.5, tolerance=1e-10, inputs=found.inputs, parameters=start(found))
    for name, value in found.values.items():
        rate = found.advancing.get(name, 0.0) if "Q" not in name else None
        if rate is not None and name in run.names:
            # 1e-10 per step, over half a second in which unstable modes grow.
            assert run[name][-1] == pytest.approx(value + 0.5 * rate, rel=1e-5, abs=1e-6), name
    return found


def start(found: gelenk.Equilibrium) -> dict[str, Any]:
    return {name: value for name, value in found.at.items() if name not in found.inputs}


# --- a conical pendulum on a hinge, equivalent to a bead on a rotating hoop ---

MASS, LENGTH, SHAFT = 1.3, 0.7, 0.2  # kg, m, kg m2


def conical(damping: float = 0.0) -> Scene:
    """A point mass on a hinge that rotates with a vertical shaft."""
    return scene(
        {"shaft": body(0.1, (0, 0, 0), (0.1, 0.1, SHAFT)), "bob": body(MASS, (0, 0, -LENGTH))},
        {"S": joint("revolute", frame("ground"), frame("shaft"), axis=[0, 0, 1], damping=damping),
         "H": joint("revolute", frame("shaft"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.6})},
        gravity=[0, 0, -GRAVITY], motors={"drive": {"joint": "S"}}, name="Conical",
    )  # fmt: skip


@pytest.mark.parametrize(("spin", "first"), [(3.9, 0.6), (5.0, 0.6), (-20.0, 1.2)])
def test_conical_pendulum(spin: float, first: float, tmp_path: Path) -> None:
    """cos(tilt) = g / l w^2; small oscillations about it conserve the angular momentum of the shaft."""
    source = conical()
    found = steady(source, tmp_path, steady={"S.w": spin}, at={"H.phi": first})
    tilt = found.values["H.phi"]
    assert math.cos(tilt) == pytest.approx(GRAVITY / (LENGTH * spin**2), rel=CLOSE)
    assert found.values["S.w"] == spin
    assert found.advancing == {"S.phi": spin}
    assert str(found).startswith("Conical: steady motion, S.phi advances; found in")
    # I(tilt) w constant: dw = -w 2 m l^2 s c / I dtilt; of F = m l^2 s c w^2 - m g l s the slope.
    s, c, m = math.sin(tilt), math.cos(tilt), MASS * LENGTH**2
    slower = -2 * m * s * c * spin / (SHAFT + m * s**2)
    slope = m * (c**2 - s**2) * spin**2 + 2 * m * s * c * spin * slower - MASS * GRAVITY * LENGTH * c
    drift, swing = gelenk.modes(source, at=found.at).modes
    assert swing.natural_frequency == pytest.approx(math.sqrt(-slope / m), rel=1e-10)
    assert (drift.kind, drift.names) == ("drifting", ["S.phi"])


@pytest.mark.parametrize("excess", [1e-6, -1e-6, -0.3])
@pytest.mark.parametrize("treatment", [None, "off"])
def test_conical_pendulum_at_a_limit(excess: float, treatment: str | None) -> None:
    """It swings out freely up to the tilt of equilibrium, and rests against a limit below it."""
    spin = 5.0
    free = math.acos(GRAVITY / (LENGTH * spin**2))
    source = conical()
    source["joints"]["H"]["limit"] = {"upper": free + excess}
    found = gelenk.equilibrium(source, steady={"S.w": spin}, friction=treatment)
    assert found.values["H.phi"] == pytest.approx(min(free, free + excess), abs=1e-11)
    assert found.residual < 1e-9
    run = gelenk.simulate(source, stop=0.5, tolerance=1e-10, parameters=start(found))
    assert run["H.phi"][-1] == pytest.approx(found.values["H.phi"], abs=1e-8)


@pytest.mark.parametrize(("friction", "moves"), [(3.0, False), (1e-3, True)])
def test_friction_of_a_joint_at_rest_in_steady_motion(friction: float, moves: bool) -> None:
    """At a tilt of 0.9 the hinge needs 0.6 N m at this speed; the shaft slips, and its motor carries it."""
    source = conical()
    source["joints"]["H"] |= {"start": {"phi": 0.9}, "friction": {"coulomb": friction}}
    source["joints"]["S"]["friction"] = {"coulomb": 0.7}
    arguments: dict[str, Any] = {"steady": {"S.w": 5.0}, "solve_for": "drive.tau"}
    if moves:  # to the tilt where friction just suffices, at which no derivatives exist
        with pytest.raises(gelenk.UsageError, match=r"joints\.H\.friction is between two modes"):
            gelenk.equilibrium(source, **arguments)
        return
    found = gelenk.equilibrium(source, **arguments)
    assert found.values["H.phi"] == 0.9
    assert found.inputs["drive.tau"] == pytest.approx(0.7, rel=CLOSE)
    run = gelenk.simulate(source, stop=0.5, inputs=found.inputs, parameters=start(found))
    assert [run[name][-1] for name in ("H.phi", "S.w")] == pytest.approx([0.9, 5.0], rel=1e-9)


def test_below_the_critical_spin_the_pendulum_hangs_down() -> None:
    """Below sqrt(g / l) only tilt 0 is steady."""
    found = steady(conical(), steady={"S.w": 3.0})
    assert found.values["H.phi"] == pytest.approx(0, abs=1e-9)


def test_the_spin_that_holds_a_tilt_is_found(tmp_path: Path) -> None:
    """Of the two solutions, w and -w, the one closer to the initial guess is found."""
    for sign in (1, -1):
        found = steady(conical(), tmp_path, steady=["S.w"], hold={"H.phi": 0.8}, at={"S.w": 3.0 * sign})
        spin = sign * math.sqrt(GRAVITY / (LENGTH * math.cos(0.8)))
        assert found.values["S.w"] == pytest.approx(spin, rel=CLOSE)
        assert found.values["H.phi"] == 0.8


def test_motor_torque_balances_the_damping_of_the_shaft(tmp_path: Path) -> None:
    found = steady(conical(0.3), tmp_path, steady={"S.w": 5.0}, solve_for=["drive.tau"])
    assert found.inputs["drive.tau"] == pytest.approx(0.3 * 5.0, rel=CLOSE)
    assert math.cos(found.values["H.phi"]) == pytest.approx(GRAVITY / (LENGTH * 25), rel=CLOSE)


def test_body_on_a_spherical_joint_rotates_about_the_vertical() -> None:
    """Velocities in body axes are steady if (I1 - I3) w^2 cos(tilt) = m g l; others are rejected."""
    tilt = 0.7
    weight = plants.TOP_MASS * GRAVITY * plants.TOP_REACH
    spin = math.sqrt(weight / ((plants.ACROSS - plants.ALONG) * math.cos(tilt)))
    w = spin * np.array([0.0, math.sin(tilt), math.cos(tilt)])
    source = plants.top(0.0, upright=False)
    names = [f"S.w[{i}]" for i in (1, 2, 3)]
    source["joints"]["S"]["start"]["Q"] = [0.3, 0, 0, math.sqrt(0.91)]
    found = steady(source, steady=dict(zip(names, map(float, w), strict=True)))
    x, y, z, s = (found.values[f"S.Q[{i}]"] for i in (1, 2, 3, 4))
    up = np.array([2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)])  # in body axes
    assert up == pytest.approx(w / spin, abs=1e-10)
    assert {*found.advancing} == {"S.theta[2]", "S.theta[3]"}
    said = refusal(source, steady=dict(zip(names, map(float, 1.1 * w), strict=True)))
    assert said.startswith("the motion does not remain steady: ")


# --- a heavy top in gimbals ---


def gimballed_top() -> Scene:
    """Rings of negligible inertia: precession about the vertical, nutation, spin about the top's axis."""
    across = plants.ACROSS - plants.TOP_MASS * plants.TOP_REACH**2
    nearly_massless = body(1e-30, (0, 0, 0), (1e-30,) * 3)  # kg, kg m2
    return scene(
        {"outer": nearly_massless, "inner": nearly_massless,
         "top": body(plants.TOP_MASS, (0, 0, plants.TOP_REACH), (across, across, plants.ALONG))},
        {"precession": joint("revolute", frame("ground"), frame("outer"), axis=[0, 0, 1]),
         "nutation": joint("revolute", frame("outer"), frame("inner"), axis=[1, 0, 0], start={"phi": 0.5}),
         "spin": joint("revolute", frame("inner"), frame("top"), axis=[0, 0, 1])},
        gravity=[0, 0, -GRAVITY],
    )  # fmt: skip


@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("tilt", [0.4, 1.9])
def test_heavy_top_has_a_slow_and_a_fast_precession(tilt: float, fast: bool) -> None:
    """(I1 - I3) cos(tilt) p^2 - I3 s p + m g l = 0, s the speed of the spin joint (Goldstein 1980, 5-76)."""
    s = 250.0
    weight = plants.TOP_MASS * GRAVITY * plants.TOP_REACH
    a, b = (plants.ACROSS - plants.ALONG) * math.cos(tilt), -plants.ALONG * s
    roots = sorted(np.roots([a, b, weight]).real, key=abs)
    found = steady(
        gimballed_top(), steady={"spin.w": s, "precession.w": None}, hold={"nutation.phi": tilt},
        at={"precession.w": float(roots[fast]) * 0.8},
    )  # fmt: skip
    assert found.values["precession.w"] == pytest.approx(roots[fast], rel=CLOSE)
    assert {*found.advancing} == {"precession.phi", "spin.phi"}


def test_a_sleeping_top_is_steady() -> None:
    found = gelenk.equilibrium(plants.top(0.0), steady={"S.w[3]": 200.0})
    assert [found.values[f"S.w[{i}]"] for i in (1, 2, 3)] == [0, 0, 200]
    assert gelenk.modes(plants.top(0.0), at=found.at).stability == "marginal"


# --- governors ---


def test_stiff_governor_at_speed(tmp_path: Path) -> None:
    """Balance of the forces on arm and collar, from the scene's numbers; both arms have the same angle."""
    spin = 6.0
    found = steady(governor(), tmp_path, steady={"S.w": spin})
    assert found.values["L.phi"] == pytest.approx(found.values["R.phi"], rel=1e-9)
    s, phi = found.values["P.s"], found.values["L.phi"]
    arm = np.array([math.cos(phi), -math.sin(phi)])  # outward, up: phi points down from the horizontal
    middle, collar = np.array([0.05, 1.0]) + 0.5 * arm, np.array([0.05, s])
    length = float(np.linalg.norm(middle - collar))
    pull = 8e5 * (length - 0.5) * (collar - middle) / length
    # Collar: two springs carry 3 kg. 8e5 N/m times the rounding of 1 m: 1e-9 N.
    assert -2 * pull[1] == pytest.approx(3 * GRAVITY, rel=1e-7)
    # Moments of weight and centrifugal force about the pivot of the arm, a ball and a uniform rod; `thin` is
    # the difference of the rod's transverse and axial moments of inertia.
    m_ball, m_rod = 5.0, 0.3
    r_out = lambda share: 0.05 + share * math.cos(phi)  # noqa: E731
    weight = (m_ball + 0.5 * m_rod) * GRAVITY * math.cos(phi)
    thin = m_rod * (1 + 1e-4) / 12 - m_rod * 1e-4 / 6
    out = m_ball * r_out(1) * math.sin(phi) + m_rod * r_out(0.5) * 0.5 * math.sin(phi)
    out += thin * math.cos(phi) * math.sin(phi)
    spring = 0.5 * (arm[0] * pull[1] - arm[1] * pull[0])
    assert spring - weight + spin**2 * out == pytest.approx(0, abs=1e-6)


def porter(arm: float, ball: float, collar: float) -> Scene:
    """Two loops: balls on arms from the shaft's axis, massless links of the same length to the collar."""
    tilt = 0.7
    bodies: dict[str, Any] = {"shaft": body(0.5, (0, 0, 0), (0.1, 0.1, 0.1)), "collar": body(collar)}
    joints: dict[str, Any] = {
        "S": joint("revolute", frame("ground"), frame("shaft"), axis=[0, 0, 1]),
        "P": joint("prismatic", frame("shaft"), frame("collar"), axis=[0, 0, 1],
                   start={"s": -2 * arm * math.cos(tilt)}),
    }  # fmt: skip
    about_y = {"axis": [0, 1, 0]}
    for name, side in (("left", 1), ("right", -1)):
        bodies[name] = body(ball, (0, 0, -arm), (1e-3,) * 3)  # isotropic: no effect
        bodies[f"{name}_link"] = body(0.0)
        joints[f"{name}_top"] = joint(
            "revolute", frame("shaft"), frame(name), **about_y, start={"phi": -side * tilt}
        )
        joints[f"{name}_knee"] = joint(
            "revolute", frame(name, (0, 0, -arm)), frame(f"{name}_link"), **about_y,
            start={"phi": 2 * side * tilt},
        )  # fmt: skip
        joints[f"{name}_foot"] = joint(
            "revolute", frame(f"{name}_link", (0, 0, -arm)), frame("collar"), **about_y,
            start={"phi": -side * tilt},
        )  # fmt: skip
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY])


@pytest.mark.parametrize("spin", [8.0, 12.0])
def test_height_of_porters_governor(spin: float, tmp_path: Path) -> None:
    """The height is (m + M) / m g / w^2 for balls of mass m and a collar of mass M; with closed loops."""
    arm, ball, collar = 0.4, 1.5, 2.0
    found = steady(porter(arm, ball, collar), tmp_path, steady={"S.w": spin})
    height = (ball + collar) / ball * GRAVITY / spin**2
    assert found.values["P.s"] == pytest.approx(-2 * height, rel=1e-9)
    assert found.values["S.w"] == pytest.approx(spin, rel=1e-12)
    assert gelenk.modes(porter(arm, ball, collar), at=found.at).stability == "marginal"


# --- prescribed motions ---


def driven(motion: dict[str, Any], lean: float = 0.0) -> Scene:
    """The shaft follows a prescribed motion; gravity is inclined by `lean`."""
    source = conical()
    del source["motors"]
    source["gravity"] = [GRAVITY * math.sin(lean), 0, -GRAVITY * math.cos(lean)]
    source["constraints"] = {"turn": {"type": "motion", "joint": "S", **motion}}
    return source


@pytest.mark.parametrize("motion", [{"polynomial": [0.0, 5.0]}, {"speed": 5.0}])
@pytest.mark.parametrize("speeds", [None, {"S.w": 5.0}, ["S.w"]])
def test_pendulum_on_a_shaft_with_a_prescribed_motion(motion: Any, speeds: Any, tmp_path: Path) -> None:
    """The stiffness of its oscillations is m l^2 sin^2 w^2, since the shaft does not slow down."""
    found = gelenk.equilibrium(driven(motion), steady=speeds)
    by_fmu = gelenk.equilibrium(gelenk.export_fmu(driven(motion), tmp_path / "x.fmu"), steady=speeds)
    tilt = math.acos(GRAVITY / (LENGTH * 25))
    for each in (found, by_fmu):
        assert each.values["H.phi"] == pytest.approx(tilt, rel=CLOSE)
        assert each.advancing == {"S.phi": 5.0}
    swing = gelenk.modes(driven(motion), at=found.at).modes[-1]
    assert swing.natural_frequency == pytest.approx(5 * math.sin(tilt), rel=1e-10)


def test_a_given_motion_decides_its_speed() -> None:
    with pytest.raises(gelenk.UsageError, match=r"steady: found S\.w = 4, but a constraint makes it 5$"):
        gelenk.equilibrium(driven({"polynomial": [0.0, 5.0]}), steady={"S.w": 4.0})


@pytest.mark.parametrize(
    ("motion", "lean", "sentence"),
    [
        ({"polynomial": [0.3, 5.0]}, 0.1, r"H\.a = -?0\.00\d* rad/s2, 0\.001 s later"),
        ({"polynomial": [0.0, 0.0, 5.0]}, 0.0, r"S\.a = 10 rad/s2$"),
        (
            {"sine": {"amplitude": 0.5, "frequency": 2.0}},
            0.0,
            r"S\.a = -.*, 0\.001 s later",
        ),
    ],
)
def test_prescribed_motions_without_a_steady_motion_are_rejected(
    motion: Any, lean: float, sentence: str
) -> None:
    """In gravity that leans, ever faster, to and fro: there is a pose without acceleration, for a moment."""
    assert re.fullmatch(
        f"no steady motion: a prescribed motion causes {sentence}", refusal(driven(motion, lean))
    )


# --- motions that are not steady ---


def refusal(source: Scene, **arguments: Any) -> str:
    with pytest.raises(gelenk.EquilibriumError) as error:
        gelenk.equilibrium(source, **arguments)
    return str(error.value)


def test_motion_that_does_not_remain_steady_is_rejected() -> None:
    """A pendulum at its lowest point has no acceleration, but its rate of change is -g / l cos(0) w."""
    said = refusal(conical(), steady={"H.w": 3.0})
    assert (
        said
        == "the motion does not remain steady: H.a changes at -42.0429 rad/s2 per second as H.phi advances"
    )


def test_damped_shaft_without_a_motor_is_rejected() -> None:
    """The message states the residual deceleration, -c w / I at some tilt."""
    said = refusal(conical(0.3), steady={"S.w": 5.0})
    assert said.startswith("no steady motion")
    assert "S.a = -" in said


def test_tilt_above_the_horizontal_is_rejected() -> None:
    said = refusal(conical(), steady={"S.w": 5.0}, hold={"H.phi": 1.7}, solve_for="drive.tau")
    assert said.startswith("drive.tau cannot hold this motion; the largest residual acceleration is H.a = ")


def test_invalid_velocities_are_rejected() -> None:
    for speeds, sentence in (
        ({"S.v": 3.0}, r"S\.v: no such velocity; did you mean S\.w"),
        ({"S.phi": 3.0}, r"S\.phi: no such velocity; there are S\.w, H\.w"),
        ({"S.w": math.nan}, r"S\.w: found nan, expected a finite number"),
    ):
        with pytest.raises(gelenk.UsageError, match=sentence):
            gelenk.equilibrium(conical(), steady=speeds)
    with pytest.raises(gelenk.UsageError, match=r"left_top\.w, P\.v are not independent; 1 of them"):
        gelenk.equilibrium(porter(0.4, 1.5, 2.0), steady={"left_top.w": 0.0, "P.v": 0.0})


def test_linear_model_about_a_steady_motion_has_all_states() -> None:
    found = gelenk.equilibrium(conical(), steady={"S.w": 5.0})
    assert linear_model(conical(), at=found.at).rates.tolist() == pytest.approx([5, 0, 0, 0], abs=1e-8)
