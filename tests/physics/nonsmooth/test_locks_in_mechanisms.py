# SPDX-License-Identifier: BSD-3-Clause
"""Locks of joints in mechanisms: on a slope, on a crane, in loops, beside contacts, friction and limits."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from models.locks import LOCK, started
from models.running import assert_close

import gelenk

SLOPE = 0.3  # rad
ALONG = GRAVITY * math.sin(SLOPE)  # m/s2
ALL = ("erk", "dirk", "cvode", "ida", "cvode-adams")


def slope(**fields: Any) -> Scene:
    """A mass of 3 kg on a guide that falls off."""
    axis = [math.cos(SLOPE), 0, -math.sin(SLOPE)]
    return scene(
        {"mass": body(3)},
        {"A": joint("prismatic", frame("ground"), frame("mass"), axis=axis, **fields)},
        gravity=[0, 0, -GRAVITY],
    )


@pytest.mark.parametrize("lock", [{"engaged": True}, {"input": "engagement", "engaged": True}])
def test_a_latch_bears_the_weight_from_the_start(lock: dict[str, Any]) -> None:
    """Engaged at rest there is no impact; an input of a lock that starts engaged starts at 1."""
    plant = started(slope(lock=lock))
    assert plant.output("A.lock.f") == pytest.approx(-3 * ALONG, rel=1e-14)
    plant.step_to(1.0)
    assert plant.output("A.s") == 0
    assert plant.output("A.lock.f") == pytest.approx(-3 * ALONG, rel=1e-14)
    assert plant.diagnostics["solver.events"] == 0
    assert plant.diagnostics["solver.impacts"] == 0
    if "input" not in lock:
        return
    plant.set_input("A.lock.engagement", 0.0)
    assert plant.output("A.a") == pytest.approx(ALONG, rel=1e-13)  # of the step that begins
    plant.step_to(1.5)
    assert_close("s", plant.output("A.s"), ALONG / 8, 1e-9, "10 times the tolerance")


@pytest.mark.parametrize("integrator", ALL)
def test_an_input_that_rises_engages_it_within_a_step(integrator: str) -> None:
    """At 0.5 s; a pulse that rises above one half and falls again is found, too."""
    plant = started(slope(lock=LOCK), integrator, 1e-8)
    plant.set_input_derivative("A.lock.engagement", 1, 1.0)
    plant.step_to(2.0)
    assert_close("s", plant.output("A.s"), ALONG / 8, 1e-7, "10 times the tolerance")
    assert plant.output("A.v") == 0
    pulse = started(slope(lock=LOCK), integrator, 1e-8)
    pulse.set_input_derivative("A.lock.engagement", 1, 2.0)
    pulse.set_input_derivative("A.lock.engagement", 2, -3.9)
    pulse.step_to(2.0)
    from_, to = ((2 + side * math.sqrt(4 - 3.9)) / 3.9 for side in (-1, 1))
    travel = ALONG * (from_**2 + (2 - to) ** 2) / 2
    assert_close("s", pulse.output("A.s"), travel, 1e-7, "10 times the tolerance")
    assert pulse.diagnostics["solver.events"] == 2


def test_twice_at_the_same_instant_and_in_each_step() -> None:
    """The last value counts; each engagement stops the mass, each release lets it start from rest."""
    plant = started(slope(lock=LOCK), "erk")
    travel = 0.0
    for k in range(20):
        plant.step_to(0.1 * k)
        plant.set_input("A.lock.engagement", 1.0 - k % 2)
        plant.set_input("A.lock.engagement", float(k % 2))
        travel += (1 - k % 2) * ALONG * 0.1**2 / 2
    plant.step_to(2.0)
    assert_close("s", plant.output("A.s"), travel, 1e-9, "10 times the tolerance")
    assert plant.diagnostics["solver.impacts"] == 10


def test_a_start_in_motion_begins_with_the_impact() -> None:
    plant = started(slope(lock={"engaged": True}, start={"v": 1.0}))
    assert plant.output("A.v") == 1
    plant.step_to(0.1)
    assert plant.output("A.v") == plant.output("A.s") == 0
    assert plant.diagnostics["solver.impacts"] == 1


def test_a_load_leaves_a_swinging_crane() -> None:
    """The load flies on along a parabola, the arm swings on as without it."""
    arm = joint("revolute", frame("ground"), frame("arm"), axis=[0, 1, 0], start={"phi": 0.4, "w": 1.1})
    hook = joint(
        "free", frame("arm", (0.2, 0, -2.0)), frame("load", (0, 0, 0.3)), lock={**LOCK, "engaged": True}
    )
    crane = scene(
        {"arm": body(5, (0, 0, -0.8), (1, 2, 1)), "load": body(2, inertia=(0.1, 0.2, 0.3))},
        {"A": arm, "hook": hook},
        gravity=[0, 0, -GRAVITY],
        sensors={"load": {"type": "frame", "body": "load"}},
    )
    plant = started(crane, "erk", 1e-11)
    plant.step_to(0.6)
    r, v = (np.array([plant.output(f"load.{k}[{i}]") for i in (1, 2, 3)]) for k in "rv")
    phi, w = plant.output("A.phi"), plant.output("A.w")
    plant.set_input("hook.lock.engagement", 0.0)
    plant.step_to(1.0)
    t = 0.4
    fall = np.array([0, 0, -GRAVITY * t**2 / 2])
    found = [plant.output(f"load.r[{i}]") for i in (1, 2, 3)]
    assert_close("load", found, r + v * t + fall, 1e-9, "100 times the tolerance")
    alone = scene({"arm": crane["bodies"]["arm"]}, {"A": arm | {"start": {"phi": phi, "w": w}}},
                  gravity=[0, 0, -GRAVITY])  # fmt: skip
    reference = started(alone, "erk", 1e-11)
    reference.step_to(t)
    assert_close("arm", plant.output("A.phi"), reference.output("A.phi"), 1e-9, "100 times the tolerance")
    assert plant.diagnostics["solver.impacts"] == 0


@pytest.mark.parametrize("without", [[], ["planar"], ["planar", "cut_choice"]])
@pytest.mark.parametrize("locked", "ABCD")
def test_a_four_bar_is_rigid_with_one_joint_locked(locked: str, without: list[str]) -> None:
    """Whichever joint it is, in the tree or where the loop is cut; released, it swings from rest."""
    source = copy.deepcopy(four_bar())
    source["joints"][locked]["lock"] = LOCK
    plant = gelenk.Simulation(gelenk.load(source).without(without))
    plant.initialize(0.0, 1e-10)
    plant.step_to(0.4)
    pose = [plant.output(f"{name}.phi") for name in "ABCD"]
    plant.set_input(f"{locked}.lock.engagement", 1.0)
    plant.step_to(0.9)
    assert_close("w", [plant.output(f"{name}.w") for name in "ABCD"], 0, 1e-11, "closing the loop")
    assert_close("phi", [plant.output(f"{name}.phi") for name in "ABCD"], pose, 1e-11, "closing the loop")
    assert plant.output(f"{locked}.w") == 0
    assert plant.diagnostics["constraints.position"] < 1e-12
    plant.set_input(f"{locked}.lock.engagement", 0.0)
    plant.step_to(1.2)
    assert_close("released", plant.output("A.phi"), -0.3747003776849, 1e-9, "with any other joint locked")


def sled(friction: float, mass: Scene) -> Scene:
    """A box of 4 kg that slides on the ground, with a mass of 1.5 kg on it; its y axis is vertical."""
    upright = frame("ground", R=np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float))
    box = body(4, inertia=(0.1, 0.1, 0.1)) | {"shapes": {"b": {"box": [0.6, 0.4, 0.2], "surface": "wood"}}}
    return {
        **scene(
            {"sled": box, "mass": body(1.5, inertia=(0.01, 0.01, 0.01))},
            {
                "S": joint("planar", upright, frame("sled"), start={"s_x": 0, "s_y": 0.2, "v_x": 0.5}),
                "T": joint(parent=frame("sled", (0, 0, 0.1)), lock=LOCK, **mass),
            },
            gravity=[0, 0, -GRAVITY],
        ),
        "ground": {"shapes": {"f": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"c": {"between": ["wood", "floor"], "friction": friction}},
    }


SLIDER: Scene = {"kind": "prismatic", "child": frame("mass"), "axis": [1, 0, 0], "start": {"v": 2.0}}
SWING: Scene = {
    "kind": "revolute",
    "child": frame("mass", (0, -0.5, 0)),
    "axis": [0, 0, 1],
    "start": {"phi": 1.0, "w": -5.0},
}


@pytest.mark.parametrize("integrator", ["erk", "cvode", "moreau-jean"])
def test_on_a_sled_without_friction_the_momentum_remains(integrator: str) -> None:
    solver = {"step": 1e-3} if integrator == "moreau-jean" else {}
    plant = started(sled(0.0, SLIDER), integrator, 1e-9, **solver)
    plant.step_to(0.1)
    plant.set_input("T.lock.engagement", 1.0)
    plant.step_to(0.2)
    common = 0.5 + 1.5 * 2.0 / 5.5
    assert_close("v", plant.output("S.v_x"), common, 1e-12, "rounding")
    assert_close("v", plant.output("T.v"), 0, 1e-12, "rounding")
    assert_close("height", plant.output("S.s_y"), 0.2, 1e-14, "rounding")


def test_closed_contacts_take_part_in_the_impact() -> None:
    """A pendulum on a sled is locked in its swing: normal impulses, and their friction, on four corners.
    Steps with impulses come to the same end, of first order.
    """
    ends = []
    for integrator, h in (("erk", 0.0), ("moreau-jean", 1e-3), ("moreau-jean", 1e-4)):
        plant = started(sled(0.4, SWING), integrator, 1e-9, **({"step": h} if h else {}))
        plant.step_to(0.1)
        plant.set_input("T.lock.engagement", 1.0)
        plant.step_to(0.3)
        assert_close("w", plant.output("T.w"), 0, 1e-12, "rounding")
        ends.append([plant.output(name) for name in ("S.s_x", "S.s_y", "S.phi", "T.phi")])
    first, coarse, fine = (np.array(end) for end in ends)
    assert np.abs(coarse - first).max() < 5e-3
    assert np.abs(fine - first).max() < 5e-4


@pytest.mark.parametrize(
    "beside",
    [
        {"friction": {"coulomb": 4.0}},
        {"friction": {"coulomb": 20.0}},
        {"limit": {"lower": -5, "upper": 0.3, "restitution": 0.5}},
        {"one_way": {"free": "positive"}},
        {
            "friction": {"coulomb": 2.0},
            "limit": {"lower": -5, "upper": 0.3, "restitution": 0.5},
            "one_way": {"free": "positive"},
        },
    ],
)
def test_it_holds_alone_and_the_others_decide_when_it_is_released(beside: dict[str, Any]) -> None:
    """Until then, friction, limit and one-way clutch have no force."""
    ends = []
    for integrator in ("erk", "cvode"):
        plant = started(slope(lock=LOCK, start={"v": 0.1}, **beside), integrator, 1e-9)
        plant.step_to(0.2)
        plant.set_input("A.lock.engagement", 1.0)
        plant.step_to(0.3)
        assert plant.output("A.lock.f") == pytest.approx(-3 * ALONG, rel=1e-12)
        assert all(plant.output(f"A.{law}.f") == 0 for law in beside)
        plant.set_input("A.lock.engagement", 0.0)
        plant.step_to(1.0)
        assert plant.output("A.lock.f") == 0
        ends.append(plant.output("A.s"))
    assert_close("both", ends[0], ends[1], 1e-7, "100 times the tolerance")
    if beside == {"friction": {"coulomb": 20.0}}:
        assert plant.output("A.friction.f") == pytest.approx(-3 * ALONG, rel=1e-12)
    if beside == {"friction": {"coulomb": 4.0}}:
        assert_close("v", plant.output("A.v"), (ALONG - 4 / 3) * 0.7, 1e-7, "100 times the tolerance")


def test_friction_that_sticks_elsewhere_exerts_no_impulse() -> None:
    """The shoulder rests by friction when the elbow is locked: the impact moves it as if it had none."""
    ends = []
    for friction in ({"friction": {"coulomb": 30.0}}, {}):
        plant = started(two_links(friction, {"lock": LOCK}, w=1.0), "erk", 1e-11)
        if friction:
            assert plant.output("A.friction.mode") == 0
        plant.set_input("B.lock.engagement", 1.0)
        plant.step_to(1e-9)
        ends.append(plant.output("A.w"))
    assert ends[0] != 0
    assert_close("w", ends[0], ends[1], 1e-6, "1 ns of friction and weight")


def two_links(shoulder: dict[str, Any], elbow: dict[str, Any], w: float = 0.0) -> Scene:
    return scene(
        {"a": body(1.2, (0.3, 0, 0), (0.1, 0.1, 0.2)), "b": body(0.7, (0.2, 0, 0), (0.1, 0.1, 0.15))},
        {
            "A": joint(
                "revolute", frame("ground"), frame("a"), **{"start": {"phi": -0.7, "w": 0.0}, **shoulder}
            ),
            "B": joint("revolute", frame("a", (0.6, 0, 0)), frame("b"), start={"phi": 0.4, "w": w}, **elbow),
        },
        gravity=[0, -GRAVITY, 0],
    )


@pytest.mark.parametrize("reversed_", [False, True])
@pytest.mark.parametrize("kind", ["spherical", "universal", "cylindrical", "planar", "screw", "free"])
def test_joints_of_all_types(kind: str, reversed_: bool) -> None:
    """All velocities are zero, and the energy of the rest is constant."""
    fields: dict[str, Any] = {"pitch": 0.1} if kind == "screw" else {}
    source = two_links({}, {})
    ends = frame("a", (0.6, 0, 0)), frame("b", (0.1, 0, 0.05))
    source["joints"]["B"] = joint(kind, *(ends[::-1] if reversed_ else ends), lock=LOCK, **fields)
    source["joints"]["A"]["start"]["w"] = 0.4
    plant = started(source, "erk", 1e-11)
    plant.step_to(0.3)
    plant.set_input("B.lock.engagement", 1.0)
    plant.step_to(0.31)
    energy = plant.diagnostics["energy.total"]
    plant.step_to(0.8)
    speeds = [
        plant.output(s.name) for s in plant.outputs if s.name.startswith("B.") and s.unit in ("m/s", "rad/s")
    ]
    assert speeds == [0.0] * len(speeds)
    assert_close("energy", plant.diagnostics["energy.total"], energy, 1e-9, "100 times the tolerance")
    assert plant.diagnostics["solver.events"] == 1


def moved_by_a_loop() -> Scene:
    source = copy.deepcopy(four_bar())
    source["joints"]["A"]["start"] = {"phi": 1.1}
    source["joints"]["C"]["lock"] = LOCK
    source["constraints"] = {"M": {"type": "motion", "joint": "A", "polynomial": [1.1, 0.5]}}
    return source


def test_what_prescribed_motions_move_cannot_be_locked() -> None:
    """The step is refused by the name of the joint; released, the run goes on."""
    plant = started(moved_by_a_loop())
    plant.step_to(0.1)
    plant.set_input("C.lock.engagement", 1.0)
    with pytest.raises(
        gelenk.StepError, match="C is locked, where no force can stop it: closed loops or prescribed"
    ):
        plant.step_to(0.2)
    plant.set_input("C.lock.engagement", 0.0)
    plant.step_to(0.2)
    assert_close("A", plant.output("A.phi"), 1.2, 1e-9, "the motion")


def test_a_prescribed_motion_that_jumps_moves_no_locked_joint() -> None:
    """The elbow keeps its angle if the shoulder jumps; if the shoulder is locked, the step is refused."""
    jumps = {"constraints": {"M": {"type": "motion", "joint": "A", "input": "position"}}}
    plant = started({**two_links({"start": {"phi": 0.0}}, {"lock": LOCK}), **jumps})
    plant.set_input("B.lock.engagement", 1.0)
    plant.step_to(0.1)
    plant.set_input("M.phi_ref", 0.3)
    plant.step_to(0.2)
    assert_close("A", plant.output("A.phi"), 0.3, 1e-12, "the motion")
    assert plant.output("B.phi") == 0.4
    assert plant.output("B.w") == 0
    source = two_links({"start": {"phi": 0.0}, "lock": LOCK}, {})
    both = started({**source, **jumps})
    both.set_input("A.lock.engagement", 1.0)
    both.step_to(0.1)
    both.set_input("M.phi_ref", 0.3)
    with pytest.raises(gelenk.StepError, match="A is locked, where no force can stop it"):
        both.step_to(0.2)


def carried(engaged: bool) -> Scene:
    """A mass on a guide, on a carriage whose position an input gives."""
    joints = {
        "carriage": joint("prismatic", frame("ground"), frame("base"), axis=[1, 0, 0]),
        "guide": joint(
            "prismatic", frame("base"), frame("mass"), axis=[1, 0, 0], lock={**LOCK, "engaged": engaged}
        ),
    }
    motion = {"constraints": {"M": {"type": "motion", "joint": "carriage", "input": "position"}}}
    return {**scene({"base": body(1), "mass": body(2)}, joints), **motion}


@pytest.mark.parametrize("engages", [True, False])
@pytest.mark.parametrize("jump", [1e-12, 1e-8, 0.3])
def test_a_lock_switches_where_a_motion_jumps(jump: float, engages: bool) -> None:
    """It engages in the position after the jump, in which the mass has not moved, or carries it."""
    plant = started(carried(not engages))
    plant.set_input_derivative("M.s_ref", 1, 0.0)  # otherwise derivatives are estimated
    plant.step_to(0.1)
    plant.set_input("M.s_ref", jump)
    plant.set_input("guide.lock.engagement", 1.0 if engages else 0.0)
    plant.step_to(0.2)
    assert plant.output("guide.lock.mode") == (1 if engages else 0)
    if engages:
        assert plant.output("guide.s") == pytest.approx(-jump, abs=2e-12)  # less is no jump
        assert plant.output("guide.v") == 0
    else:
        assert plant.output("carriage.s") == pytest.approx(jump, abs=2e-12)
