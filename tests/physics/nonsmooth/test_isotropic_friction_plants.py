# SPDX-License-Identifier: BSD-3-Clause
"""Joints with isotropic friction: saved states, FMUs, linear models, equilibria, files, errors."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import warned

import gelenk
from gelenk.io import export

from .test_isotropic_friction import FORCE, INERTIA, MASS, MOMENT, Source, ball, puck, run, wrench

pytestmark = [warned.GUESSES, warned.TIGHT, warned.STILL, warned.GYRATION, warned.MOVING]

BALL_OUTPUTS = ["J.Q[1]", "J.Q[4]", "J.w[1]", "J.w[2]", "J.w[3]", "J.friction.tau[2]", "J.friction.mode"]
PUCK_OUTPUTS = [
    "P.s_x",
    "P.s_y",
    "P.v_x",
    "P.v_y",
    "P.friction.translation.f[1]",
    "P.friction.translation.mode",
]


def stopping_ball() -> Source:
    return ball({"coulomb": MOMENT, "static": 1.3 * MOMENT}, w=[0.4, -0.9, 0.3], inertia=[0.2, 0.4, 0.35])


def stopping_puck() -> Source:
    source = puck({"translation": {"coulomb": FORCE, "static": 1.2 * FORCE}}, v=[0.9, -0.4], w=0.5)
    source["joints"]["P"]["stiffness"] = [20, 35, 0]
    source["joints"]["P"]["start"]["s_x"] = 0.3
    return source


@pytest.mark.parametrize("integrator", ["erk", "dirk", "cvode", "ida", "auto", "moreau-jean"])
@pytest.mark.parametrize("of_ball", [True, False])
def test_restored_to_the_bit(integrator: str, of_ball: bool) -> None:
    source, names = (stopping_ball(), BALL_OUTPUTS) if of_ball else (stopping_puck(), PUCK_OUTPUTS)
    source["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-8)
    states, values = [], []
    for k in range(100):
        states.append(plant.save())
        plant.step_to(0.02 * (k + 1))
        values.append(plant.values(names))
    assert values[2][-1] == 1
    assert values[-1][-1] == 0
    for k in (90, 3, 40, 99, 0):
        plant.restore(states[k])
        plant.step_to(0.02 * (k + 1))
        assert np.array_equal(plant.values(names), values[k])


@pytest.mark.parametrize("of_ball", [True, False])
def test_as_an_fmu(tmp_path: Path, of_ball: bool) -> None:
    source, names = (stopping_ball(), BALL_OUTPUTS) if of_ball else (stopping_puck(), PUCK_OUTPUTS)
    law = "J.friction" if of_ball else "P.friction.translation"
    source["parameters"] = [f"{law}.coulomb", f"{law}.static"]
    path = tmp_path / "friction.fmu"
    gelenk.export_fmu(gelenk.load(source), path)
    size = MOMENT if of_ball else FORCE
    changed = {f"{law}.coulomb": 0.6 * size, f"{law}.static": 0.7 * size}
    found = gelenk.simulate(path, stop=1.0, step=0.01, tolerance=1e-8, parameters=changed)
    of = {"coulomb": 0.6 * size, "static": 0.7 * size}
    if of_ball:
        source["joints"]["J"]["friction"] = of
    else:
        source["joints"]["P"]["friction"] = {"translation": of}
    expected = gelenk.simulate(source, stop=1.0, step=0.01, tolerance=1e-8)
    for name in names:
        assert np.array_equal(found[name], expected[name])


@pytest.mark.parametrize("integrator", ["auto", "ida"])
def test_tuned_during_a_run(integrator: str) -> None:
    """Less friction during the run: the ball loses what it holds, and turns."""
    torque = [0.0, 0.6 * MOMENT, 0.0]
    source = ball({"coulomb": MOMENT}, forces={"F": wrench("ball", torque=torque)})
    source["solver"] = {"integrator": integrator}
    source["parameters"] = ["J.friction.coulomb"]
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-9)
    plant.step_to(0.5)
    assert plant.values(["J.w[2]"]) == [0]
    tuned = gelenk.load(source).with_parameters({"J.friction.coulomb": 0.25 * MOMENT})
    plant._core.tune(tuned._core)
    plant.step_to(1.5)
    assert plant.values(["J.w[2]"])[0] == pytest.approx(0.35 * MOMENT / INERTIA, rel=1e-9)


def test_linear_models() -> None:
    """At rest, friction holds the joint, or acts as `friction` says; in motion it turns with the velocity."""
    assert gelenk.linearize(ball({"coulomb": MOMENT})).nstates == 0
    assert gelenk.linearize(ball({"coulomb": MOMENT}), friction="off").nstates == 6
    source = puck({"translation": {"coulomb": FORCE}})
    assert gelenk.linearize(source).nstates == 2
    assert gelenk.linearize(source, friction="off").nstates == 6
    source = puck({"translation": {"coulomb": FORCE}}, v=[0.8, 0.0])
    model = gelenk.linearize(source)
    names = [str(name) for name in model.state_labels]
    x, y = names.index("P_v_x"), names.index("P_v_y")
    A = np.asarray(model.A)
    assert A[y, y] == pytest.approx(-FORCE / MASS / 0.8, rel=1e-9)
    assert abs(A[x, x]) < 1e-9
    source = ball({"coulomb": MOMENT}, w=[0.0, 0.5, 0.0])
    model = gelenk.linearize(source)
    eigenvalues = np.sort(np.linalg.eigvals(model.A).real)
    assert eigenvalues[:2] == pytest.approx([-MOMENT / INERTIA / 0.5] * 2, rel=1e-6)


@pytest.mark.parametrize("part", [1 - 1e-9, 1 + 1e-6])
def test_equilibria(part: float) -> None:
    """A body beside the joint is held where its weight needs no more than the static moment."""
    arm = MOMENT / (MASS * 9.81)
    source = ball({"coulomb": 0.8 * MOMENT, "static": MOMENT})
    source["gravity"] = [0, 0, -9.81]
    source["bodies"]["ball"]["com"] = [0.6 * part * arm, -0.8 * part * arm, 0.0]
    if part > 1:
        with pytest.raises(
            gelenk.EquilibriumError, match=r"joints\.J\.friction would need a friction of .* N m"
        ):
            gelenk.equilibrium(source, friction="present")
        return
    found = gelenk.equilibrium(source, friction="present")
    (point,) = found.contact_points
    assert point.contact == "J.friction"
    assert point.bodies == ("ground", "ball")
    assert point.friction == pytest.approx(part * MOMENT, rel=1e-12)
    assert point.limit == pytest.approx(MOMENT, rel=1e-12)
    assert str(point).endswith("N m")
    still = run(source, stop=1.0)
    assert np.all(still["J.w[1]"] == 0)


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        ({"coulomb": 0.2, "static": 0.1}, r"joints\.J\.friction\.static: found 0\.1 N m, expected at least"),
        ({"static": 0.1}, r"joints\.J\.friction\.coulomb: found nothing"),
        ({"coulomb": 0, "static": 0.1}, r"joints\.J\.friction\.coulomb: found 0 N m, expected more than 0"),
        ({"coulomb": -1}, r"joints\.J\.friction\.coulomb: found -1"),
        ({}, r"joints\.J\.friction\.coulomb: found nothing"),
        ({"coulomb": 0.1, "bearing": 1}, r"joints\.J\.friction\.bearing: found an unknown field"),
    ],
)
def test_errors_of_ball_joints(friction: Source, message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(ball(friction))


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        ({}, r"joints\.P\.friction: found nothing, expected a mapping with coordinates .* translation"),
        ({"coulomb": 1}, r"joints\.P\.friction: found 'coulomb', expected .*: s_x, s_y, phi, translation"),
        ({"translation": {"coulomb": 1, "static": 0.5}}, r"friction\.translation\.static: found 0\.5 N"),
        (
            {"translation": {"coulomb": 1}, "s_y": {"coulomb": 1}},
            r"joints\.P\.friction\.s_y: found friction along this coordinate beside friction\.translation",
        ),
        ({"rotation": {"coulomb": 1}}, r"joints\.P\.friction\.rotation: found an unknown field"),
    ],
)
def test_errors_of_planar_joints(friction: Source, message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(puck(friction))


def test_the_only_coordinate_has_no_name() -> None:
    source = {
        "gelenk": 1,
        "bodies": {"b": {"mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}},
        "joints": {
            "A": {"type": "revolute", "parent": "ground", "child": "b", "friction": {"phi": {"coulomb": 1}}}
        },
    }
    message = r"joints\.A\.friction: found 'phi', expected .*: a revolute joint has one coordinate"
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(source)


def test_what_does_not_know_it_says_so() -> None:
    with pytest.raises(gelenk.SceneError, match=r"J\.friction: found friction along several velocities"):
        gelenk.equations(ball({"coulomb": MOMENT}))
    with pytest.raises(gelenk.GelenkError, match=r"friction"):
        gelenk.batch(puck({"translation": {"coulomb": FORCE}}), 4)


def test_file_and_schema(tmp_path: Path) -> None:
    schema = json.loads(export.schema())
    for source in (
        ball({"coulomb": 0.25, "static": 0.5}),
        puck({"translation": {"coulomb": 0.25, "static": 0.5}, "phi": {"coulomb": 0.125}}),
    ):
        jsonschema.validate(source, schema)
        (name,) = source["joints"]
        gelenk.load(source).save(tmp_path / "scene.yaml")
        again = gelenk.load(tmp_path / "scene.yaml").to_dict()["joints"][name]["friction"]
        friction = source["joints"][name]["friction"]
        for key, value in friction.items():
            found = again[key]
            assert found == value or (key == "phi" and found["coulomb"] == value["coulomb"])
        wrong = json.loads(json.dumps(source))
        wrong["joints"][name]["friction"] = {"rotation": {"coulomb": 1}}
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema)


@pytest.mark.parametrize("integrator", ["erk", "moreau-jean"])
def test_reactions_and_powers_show_it(integrator: str) -> None:
    """What a joint transmits is its constraint forces and its friction."""
    source = ball({"coulomb": MOMENT}, w=[0.0, 0.0, 0.9], sensors={"R": {"type": "reaction", "joint": "J"}})
    source["sensors"]["W"] = {"type": "power", "joint": "J"}
    found = run(source, integrator, stop=0.5, **({"step": 0.01} if integrator == "moreau-jean" else {}))
    assert found["R.t[3]"][1:] == pytest.approx(np.full(len(found.time) - 1, -MOMENT), rel=1e-9)
    mean = found["J.w[3]"]
    assert found["W.total"][1:] == pytest.approx(-MOMENT * mean[1:], rel=1e-9)
    disc = puck(
        {"translation": {"coulomb": FORCE}}, v=[0.8, 0.6], sensors={"R": {"type": "reaction", "joint": "P"}}
    )
    found = run(disc, integrator, stop=0.3, **({"step": 0.01} if integrator == "moreau-jean" else {}))
    assert found["R.f[1]"][1:] == pytest.approx(np.full(len(found.time) - 1, -0.8 * FORCE), rel=1e-9)


def test_expressions_do_not_name_it() -> None:
    for name in ("J.friction.tau[1]", "R.t[1]"):
        source = ball({"coulomb": MOMENT}, sensors={"R": {"type": "reaction", "joint": "J"}})
        source["states"] = {"work": {"rate": name}}
        with pytest.raises(gelenk.SceneError, match=re.escape(name)):
            gelenk.simulate(source, stop=0.1, step=0.1)


@pytest.mark.parametrize("integrator", ["auto", "dirk", "ida", "moreau-jean"])
def test_none_and_set_in_motion(integrator: str) -> None:
    """Without friction a ball turns freely; friction that is set while it turns slows it down."""
    source = ball({"coulomb": 0}, w=[0.3, 0.0, 0.4])
    source["solver"] = {"integrator": integrator}
    source["parameters"] = ["J.friction.coulomb"]
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-9)
    plant.step_to(0.5)
    assert plant.values(["J.w[1]", "J.w[3]"]) == pytest.approx([0.3, 0.4], abs=1e-12)
    tuned = gelenk.load(source).with_parameters({"J.friction.coulomb": MOMENT})
    plant._core.tune(tuned._core)
    for k in range(10):
        plant.step_to(0.5 + 0.05 * (k + 1))
    speed = 0.5 - MOMENT / INERTIA * 0.5
    assert plant.values(["J.w[1]", "J.w[3]"]) == pytest.approx([0.6 * speed, 0.8 * speed], abs=1e-8)


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "ida", "moreau-jean"])
def test_set_to_none_in_motion(integrator: str) -> None:
    """A ball that friction slows down turns on at its speed; friction that is set again stops it."""
    source = ball({"coulomb": MOMENT}, w=[0.6, 0.0, 0.8])
    source["solver"] = {"integrator": integrator, "step": 1e-3}
    source["parameters"] = ["J.friction.coulomb"]
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-9)
    stop = INERTIA / MOMENT  # s: of the ball from 1 rad/s
    plant.step_to(0.25 * stop)
    none = gelenk.load(source).with_parameters({"J.friction.coulomb": 0.0})
    plant._core.tune(none._core)
    plant.step_to(0.5 * stop)
    assert plant.values(["J.w[1]", "J.w[3]"]) == pytest.approx([0.45, 0.6], abs=1e-8)
    plant._core.tune(gelenk.load(source)._core)
    plant.step_to(stop)
    assert plant.values(["J.w[1]", "J.w[3]"]) == pytest.approx([0.15, 0.2], abs=1e-8)
    plant.step_to(1.3 * stop)
    assert plant.values(["J.w[1]", "J.w[3]"]) == pytest.approx([0, 0], abs=1e-12)


LAWS = {"J.friction": {"friction": {"coulomb": MOMENT}}, "J.limit": {"limit": {"swing": 1.0}}}


def with_law(law: str) -> Source:
    source = ball({"coulomb": MOMENT}, w=[0.4, -0.9, 0.3])
    del source["joints"]["J"]["friction"]
    source["joints"]["J"] |= LAWS[law]
    return source


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("integrator", ["auto", "erk", None])
def test_another_formulation_is_refused_with_the_name_of_the_law(law: str, integrator: str | None) -> None:
    source = with_law(law)
    source["solver"] = {"formulation": "baumgarte"} | ({"integrator": integrator} if integrator else {})
    with pytest.raises(gelenk.SceneError) as refused:
        gelenk.Simulation(source)
    assert f"found 'baumgarte' with joints.{law}, expected the formulation projection" in str(refused.value)
    source["solver"]["integrator"] = "moreau-jean"
    with pytest.raises(gelenk.SceneError, match="found 'baumgarte' with the integrator moreau-jean"):
        gelenk.Simulation(source)


@pytest.mark.parametrize("law", LAWS)
def test_differential_equations_are_refused_with_the_name_of_the_law(law: str) -> None:
    with pytest.raises(gelenk.UsageError) as refused:
        gelenk.control_system(with_law(law))
    assert f"the scene has joints.{law}, whose events" in str(refused.value)
    assert "contact" not in str(refused.value)


def test_derivatives_through_a_stop_are_refused_with_the_name_of_the_law() -> None:
    source = puck({"translation": {"coulomb": FORCE}}, v=[0.5, 0.2])
    source["solver"] = {"integrator": "erk"}
    before = gelenk.sensitivity(source, ["puck.mass"], stop=0.2, outputs=["P.s_x"], step=0.05)
    assert len(before.time) == 5
    with pytest.raises(gelenk.UsageError) as refused:
        gelenk.sensitivity(source, ["puck.mass"], stop=1.0, outputs=["P.s_x"], step=0.05)
    assert "P sticks in its translation" in str(refused.value)
    assert "the modes of joints.P.friction.translation cannot be taken over; end the run before" in str(
        refused.value
    )
