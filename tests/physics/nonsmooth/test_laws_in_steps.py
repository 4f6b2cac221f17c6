# SPDX-License-Identifier: BSD-3-Clause
"""Every law of a joint coordinate in both schemes: located events, and time steps of shrinking size.

They are independent schemes for one law, so that steps converge to events, in the motion and in what outputs
show of the law, at first order at least.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

from .test_joint_friction import four_bar_with_friction

GRID = 0.027  # s: no impact of these scenes is near one of its multiples
STEPS = (1e-3, 2.5e-4)  # s


@dataclass
class Case:
    source: Scene
    stop: float
    inputs: dict[str, Callable[[float], float]]
    # Of the coarse steps: part of the largest value of an output up to which one may err.
    error: float = 0.02


def block(motor: Callable[[float], float], v: float = 0.0, s: float = 0.0, **laws: Any) -> Case:
    """A block on a guide, pushed by a motor."""
    guide = joint(
        "prismatic",
        frame("ground"),
        frame("block"),
        axis=[1, 0, 0],
        start={"s": s, "v": v, "fixed": True},
        **laws,
    )
    source = scene({"block": body(1.3)}, {"J": guide})
    source["motors"] = {"push": {"joint": "J"}}
    return Case(source, 1.0, {"push.f": motor})


def pulses(t: float) -> float:
    """Held by static friction, broken away, let go, pushed back."""
    return (0.6, 0.6, 1.4, 0.3, -1.5)[min(4, int(t / 0.22))]


def stribeck(exponent: int) -> Case:
    law = {"coulomb": 0.4, "static": 1.0, "stribeck": 0.3, "exponent": exponent}
    return block(pulses, v=0.21, friction=law)


def braked() -> Case:
    case = block(lambda _: 1.1, v=0.35, friction={"coulomb": 3.0, "input": "engagement"})
    case.inputs["J.friction.engagement"] = lambda t: (0.5, 0.1, 1.0, 0.0)[min(3, int(t / 0.26))]
    return case


def chain(
    law: str, restitutions: tuple[float, ...], speeds: tuple[float, ...], bounds: tuple[float, ...]
) -> Case:
    """Blocks in line, each with an upper limit against the one before; no forces."""
    names = [f"b{i}" for i in range(len(bounds))]
    joints = {}
    for i, name in enumerate(names):
        limit = {"upper": bounds[i], "restitution": restitutions[i], "law": law}
        parent = frame(names[i - 1]) if i > 0 else frame("ground")
        joints[f"J{i}"] = joint(
            "prismatic",
            parent,
            frame(name),
            axis=[1, 0, 0],
            limit=limit,
            start={"s": 0.0, "v": speeds[i], "fixed": True},
        )
    source = scene({name: body(1.0 + 0.7 * i) for i, name in enumerate(names)}, joints)
    return Case(source, 0.3, {})


def turned_disc(**laws: Any) -> Case:
    hub = joint(
        "revolute",
        frame("ground"),
        frame("disc"),
        axis=[0, 0, 1],
        start={"phi": 0.0, "w": 0.8, "fixed": True},
        **laws,
    )
    source = scene({"disc": body(1.0, [0.2, 0.2, 0.3])}, {"J": hub})
    source["motors"] = {"turn": {"joint": "J"}}
    return Case(source, 1.0, {"turn.tau": lambda t: (-0.9, 0.5, -0.3)[min(2, int(t / 0.37))]})


def clutch() -> Case:
    """Two discs on one shaft: the joint between them is a clutch."""
    start = {"fixed": True, "phi": 0.0}
    source = scene(
        {"a": body(1.0, [0.2, 0.2, 0.3]), "b": body(1.0, [0.2, 0.2, 0.5])},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 0, 1], start={**start, "w": 5.0}),
            "B": joint(
                "revolute",
                frame("a"),
                frame("b"),
                axis=[0, 0, 1],
                start={**start, "w": -4.0},
                friction={"coulomb": 4.0, "static": 6.0, "input": "engagement"},
            ),
        },
    )
    source["motors"] = {"drive": {"joint": "A"}}
    engaged = [0.0, 0.5, 1.0, 0.25]
    return Case(
        source,
        1.2,
        {
            "B.friction.engagement": lambda t: engaged[min(3, int(t / 0.28))],
            "drive.tau": lambda t: 2.0 if t < 0.7 else 9.0,
        },
    )


CASES: dict[str, Callable[[], Case]] = {
    "friction": lambda: block(pulses, v=0.21, friction={"coulomb": 0.5}),
    "static friction": lambda: block(pulses, v=0.21, friction={"coulomb": 0.5, "static": 1.1}),
    "more than static friction turns back": lambda: block(
        lambda _: -1.3, v=0.77, friction={"coulomb": 0.5, "static": 1.1}
    ),
    "Stribeck's curve": lambda: stribeck(2),
    "Stribeck's curve, exponent 1": lambda: stribeck(1),
    "brake": braked,
    "clutch": clutch,
    "friction in a loop": lambda: Case(four_bar_with_friction(), 0.5, {}),
    "limit": lambda: block(lambda _: 0.7, v=0.3, limit={"upper": 0.11, "lower": -0.2}),
    "limit with restitution": lambda: block(
        lambda t: -0.4 if t < 0.6 else 0.5, v=0.9, limit={"upper": 0.11, "lower": -0.17, "restitution": 0.7}
    ),
    "limit with friction": lambda: block(
        lambda t: 1.9 if t < 0.5 else -1.6,
        v=0.9,
        limit={"upper": 0.127, "restitution": 0.5},
        friction={"coulomb": 0.5, "static": 0.8, "stribeck": 0.1},
    ),
    "one-way clutch": lambda: turned_disc(one_way={"free": "positive"}),
    "one-way clutch and friction": lambda: turned_disc(
        one_way={"free": "positive"}, friction={"coulomb": 0.2, "static": 0.4}
    ),
}


def stopped(v: float, **law: float) -> Case:
    """A force between sliding and static friction stops the block for good, a larger one turns it back."""
    return block(lambda t: -0.8 if t < 0.8 else -1.3, v=v, friction={"coulomb": 0.5, "static": 1.1, **law})


# The block stops at any place within a step: it loses 1 mm/s in one.
for _v in (0.31, 0.3102, 0.3104, 0.3106, 0.3108):
    CASES[f"static friction stops at {_v}"] = partial(stopped, _v)
    CASES[f"Stribeck's curve stops at {_v}"] = partial(stopped, _v, stribeck=1e-5)


def struck_together(law: str) -> dict[str, Callable[[], Case]]:
    """Limits that are struck at the same instant, at any place within a step."""
    out: dict[str, Callable[[], Case]] = {
        "limits struck together, of unlike speeds": partial(
            chain, law, (0.3, 0.8), (0.8, 0.4), (0.1003, 0.05015)
        ),
        "three limits struck together": partial(
            chain, law, (0.5, 0.0, 0.9), (1.0, 0.5, 0.25), (0.1, 0.05, 0.025)
        ),
        "a limit that rests is struck": partial(chain, law, (0.8, 0.5), (0.0, 1.0), (0.0, 0.1003)),
    }
    for bound in (0.1, 0.10003, 0.10006, 0.1001):
        out[f"two limits struck together at {bound}"] = partial(
            chain, law, (1.0, 0.0), (1.0, 1.0), (bound, bound)
        )
    return out


for _law in ("newton", "poisson"):
    CASES |= {f"{name}, {_law}": case for name, case in struck_together(_law).items()}


def shown(source: Scene) -> list[str]:
    """Positions and speeds of the joints, and the outputs of their laws."""
    names = [signal.name for signal in gelenk.Simulation(gelenk.load(source)).outputs]
    wanted = (".s", ".v", ".phi", ".w", ".f", ".tau", ".mode")
    joints = source["joints"]
    return [name for name in names if name.split(".")[0] in joints and name.endswith(wanted)]


def run(case: Case, integrator: str, step: float) -> dict[str, np.ndarray]:
    source = {**case.source, "solver": {"integrator": integrator, "step": step}}
    plant = gelenk.Simulation(gelenk.load(source))
    for name, value in case.inputs.items():
        plant.set_input(name, value(0.0))
    plant.initialize(tolerance=1e-10)
    names = shown(source)
    rows = []
    for k in range(round(case.stop / GRID)):
        for name, value in case.inputs.items():
            plant.set_input(name, value(k * GRID + 1e-9))
        plant.step_to((k + 1) * GRID)
        rows.append([plant.output(name) for name in names])
    return dict(zip(names, np.array(rows).T, strict=True))


def errors(case: Case) -> dict[str, list[float]]:
    """By output, its largest error in steps of each size, relative to its largest value."""
    exact = run(case, "auto", STEPS[0])
    found: dict[str, list[float]] = {name: [] for name in exact}
    for step in STEPS:
        for name, values in run(case, "moreau-jean", step).items():
            size = max(1e-3, float(np.abs(exact[name]).max()))
            found[name].append(float(np.abs(values - exact[name]).max()) / size)
    return found


@pytest.mark.parametrize("name", CASES)
def test_steps_converge_to_located_events(name: str) -> None:
    """At first order: a quarter of the step, a quarter of the error."""
    case = CASES[name]()
    for output, found in errors(case).items():
        for step, error in zip(STEPS, found, strict=True):
            assert error <= case.error * step / STEPS[0], (output, found)


def test_every_law_of_joints_is_compared() -> None:
    """All groups of the laws that keep a coordinate at rest, or within bounds."""
    compared = {key for case in CASES.values() for J in case().source["joints"].values() for key in J}
    laws = {"friction", "limit", "one_way"}
    assert laws <= compared


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("bound", [1e-5, 1e-4, 4e-4])
def test_no_bound_is_passed_where_an_impact_drives_a_joint_to_it(bound: float, restitution: float) -> None:
    """A block stops; a load, at rest on it until then, meets its limit in the same step."""
    case = chain("newton", (0.0, restitution), (1.0, 0.0), (0.0503, bound))
    plant = gelenk.Simulation({**case.source, "solver": {"integrator": "moreau-jean", "step": 1e-3}})
    plant.initialize()
    reached = False
    for k in range(60):
        plant.step_to((k + 1) * 1e-3)
        # m: what counts as contact.
        assert plant.output("J1.s") <= bound + 1e-9
        assert plant.output("J0.s") <= 0.0503 + 1e-9
        reached = reached or plant.output("J1.s") >= bound - 1e-9
    assert reached
    if restitution > 0:
        # The load leaves its limit with half its speed, relative to the block, which remains at its own.
        assert plant.output("J1.v") + plant.output("J0.v") == pytest.approx(-0.5, abs=2e-3)
