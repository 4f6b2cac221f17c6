# SPDX-License-Identifier: BSD-3-Clause
"""Random scenes of bodies that are thrown on a floor and each other, for contacts at located events.

Shapes of all kinds that events are located for, alone or linked by joints with dry friction and limits, some
in loops. Run as a program, simulates many of them: `python -m models.thrown 3000`.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from dataclasses import dataclass, field
from multiprocessing import Pool
from time import process_time
from typing import Any

import numpy as np

import gelenk

SceneData = dict[str, Any]
Generator = np.random.Generator

STEPS, STEP = 12, 0.05  # s
EDGED = 100_000
TOLERANCE = 1e-6
# Of energy that rises between communication points, relative to all that is exchanged: errors of the method
# at this tolerance; a wrong impulse or mode adds parts of one.
ENERGY = 1e-4
DEPTH = 1e-8  # m; what is apart never penetrates further
EVENTS = 500  # of a communication step, beyond which it is refused
# What a run may be refused for, by words of the messages.
REFUSALS = {
    "events": "more than .* events",
    "no advance": "steps advanced the time by only",
    "no forces": "no contact forces were found",
    "flat end": "with a flat end, whose contacts are not located",
    "no stop": "where no force can stop it",
    "budget": "evaluations",
    "loops": "loops|dead center",
    "step size": "step size|did not converge|too small",
}


def _one_of(rng: Generator, *values: Any) -> Any:
    return values[int(rng.integers(len(values)))]


def _direction(rng: Generator) -> list[float]:
    out = rng.normal(size=3)
    return [float(x) for x in out / np.linalg.norm(out)]


def _shape(rng: Generator, edged: bool) -> SceneData:
    a, b, c = (float(x) for x in rng.uniform(0.08, 0.3, 3))
    if edged and rng.random() < 0.2:
        return {"cylinder": {"radius": a / 2, "length": c}, "surface": "drum"}
    kind = int(rng.integers(1, 4) if edged else rng.integers(5))
    if kind <= 1:
        return {"sphere": a / 2, "surface": "ball"}
    if kind == 2:
        return {"box": [a, b, c], "surface": "solid"}
    if kind == 3:
        return {"capsule": {"radius": a / 3, "length": c}, "surface": "solid"}
    return {"hull": (a * rng.normal(size=(int(rng.integers(4, 10)), 3)) / 2).tolist(), "surface": "rock"}


def _law(rng: Generator) -> SceneData:
    law: SceneData = {"friction": _one_of(rng, 0.0, 0.3, 0.6, 1.0)}
    if rng.random() < 0.2:
        law["static"] = 1.3 * law["friction"] + 0.1
    if rng.random() < 0.2:
        law["rolling"] = 1e-3
    if rng.random() < 0.2:
        law["spinning"] = 1e-3
    law["restitution"] = _one_of(rng, 0.0, 0.0, 0.3, 0.6, 0.9)
    return law


def _free(rng: Generator, child: str, place: np.ndarray) -> SceneData:
    quaternion = rng.normal(size=4)
    start = {
        "r": place.tolist(),
        "Q": (quaternion / np.linalg.norm(quaternion)).tolist(),
        "v": rng.normal(size=3).tolist(),
        "w": (3 * rng.normal(size=3)).tolist(),
        "fixed": True,
    }
    return {"type": "free", "parent": "ground", "child": child, "start": start}


def _linked(rng: Generator, parent: str, child: str, at: np.ndarray) -> SceneData:
    kind = _one_of(rng, "revolute", "revolute", "prismatic", "spherical")
    out: SceneData = {"type": kind, "parent": parent, "child": child, "at": {"position": at.tolist()}}
    if kind == "spherical":
        return out
    out["axis"] = _direction(rng)
    speed = "w" if kind == "revolute" else "v"
    out["start"] = {speed: float(rng.normal())}
    if rng.random() < 0.6:
        out["friction"] = {"coulomb": _one_of(rng, 0.02, 0.2, 1.0, 10.0)}
        if rng.random() < 0.3:
            out["friction"]["static"] = 1.2 * out["friction"]["coulomb"]
    if rng.random() < 0.5:
        out["limit"] = {
            "lower": _one_of(rng, 0.0, -0.1, -1.0),
            "upper": _one_of(rng, 0.05, 0.5),
            "restitution": _one_of(rng, 0.0, 0.5, 1.0),
        }
    return out


def thrown(seed: int) -> SceneData:
    """Return the scene of this number; the same one each time.

    From EDGED on they have boxes and capsules that touch each other, and cylinders.
    """
    rng = np.random.default_rng([417, seed])
    edged = seed >= EDGED
    count = int(rng.integers(1, 5))
    linked = rng.random() < 0.5
    bodies: SceneData = {}
    joints: SceneData = {}
    places = [np.array([0.35 * i, 0, 0]) + rng.normal(size=3) * 0.05 + [0, 0, 0.5] for i in range(count)]
    for i in range(count):
        mass = float(10 ** rng.uniform(-1, 1))
        moments = mass * 0.02 * rng.uniform(0.3, 1, 3)
        moments = np.array([moments[0] + moments[1], moments[1] + moments[2], moments[2] + moments[0]])
        bodies[f"b{i}"] = {"mass": mass, "inertia": moments.tolist(), "shapes": {"s": _shape(rng, edged)}}
        if not linked or rng.random() < 0.3:
            joints[f"j{i}"] = _free(rng, f"b{i}", places[i])
            continue
        bodies[f"b{i}"]["pose"] = {"position": places[i].tolist()}
        parent = f"b{i - 1}" if i and "pose" in bodies[f"b{i - 1}"] else "ground"
        before = places[i - 1] if parent != "ground" else places[i] + [0, 0, 0.3]
        joints[f"j{i}"] = _linked(rng, parent, f"b{i}", (before + places[i]) / 2)
    last = f"b{count - 1}"
    if count > 2 and "pose" in bodies[last] and rng.random() < 0.6:
        joints["closing"] = {
            "type": "spherical",
            "parent": "ground",
            "child": last,
            "at": {"position": (places[-1] + [0.15, 0.05, 0.1]).tolist()},
        }
    ground = {"floor": {"plane": [0, 0, 1], "surface": "stone"}}
    if rng.random() < 0.3:
        ground["wall"] = {"plane": [-1, 0, 0.2], "position": [1.2, 0, 0], "surface": "stone"}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": bodies,
        "ground": {"shapes": ground},
        "joints": joints,
        "contacts": _contacts(rng, bodies, joints, edged),
        "solver": {
            "integrator": _one_of(rng, "erk", "erk", "cvode", "ida", "dirk"),
            "max_events": EVENTS,
            "max_evaluations": 300_000,
        },
    }


def _contacts(rng: Generator, bodies: SceneData, joints: SceneData, edged: bool) -> SceneData:
    """Laws between all surfaces that can touch."""
    touching = {("ball", "ball"), ("ball", "solid")} | ({("solid", "solid")} if edged else set())
    surfaces = [body["shapes"]["s"]["surface"] for body in bodies.values()]
    joined = {(joint["parent"], joint["child"]) for joint in joints.values() if joint["type"] != "free"}
    pairs = {tuple(sorted((surface, "stone"))) for surface in surfaces}
    names = list(bodies)
    for i, first in enumerate(names):
        for other in names[i + 1 :]:
            pair = tuple(sorted((surfaces[i], surfaces[names.index(other)])))
            if pair in touching and (first, other) not in joined:
                pairs.add(pair)
    # Bodies whose joints are on the ground touch it, too.
    adjacent = [{"adjacent": True} if "stone" in pair else {} for pair in sorted(pairs)]
    return {
        f"c{k}": {"between": list(pair)} | _law(rng) | adjacent[k] for k, pair in enumerate(sorted(pairs))
    }


@dataclass
class Course:
    """What has become of a scene.

    Args:
        seed: number of the scene.
        refused: the kind of refusal (a key of REFUSALS; rigid: loops leave no motion), or empty.
        faults: what must not be.
        seconds: CPU time.
        events: number of events.
    """

    seed: int
    refused: str = ""
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0
    events: int = 0


def refusal_of(message: str) -> str:
    return next((kind for kind, words in REFUSALS.items() if re.search(words, message)), "")


def run(seed: int) -> Course:
    """Simulate the scene of this number."""
    out = Course(seed)
    start = process_time()
    try:
        simulation = gelenk.Simulation(thrown(seed))
        simulation.initialize(tolerance=TOLERANCE)
    except gelenk.SceneError as error:
        out.refused = "rigid" if "found no shape with the surface" in str(error) else ""
        out.faults += [] if out.refused else [f"not started: {error}"]
        return out
    energies = []
    kinetic = 0.0
    gaps = [name for name in (signal.name for signal in simulation.outputs) if name.endswith(".gap")]
    apart: set[str] = set()
    for k in range(STEPS + 1):
        try:
            if k:
                simulation.step_to(k * STEP)
        except gelenk.StepError as error:
            out.refused = refusal_of(str(error))
            if not out.refused:
                out.faults.append(f"refused: {error}")
            break
        found = simulation.diagnostics
        if not (np.isfinite(simulation.values()).all() and np.isfinite(list(found.values())).all()):
            out.faults.append("not finite")
        for name in gaps:
            gap = simulation.output(name)
            if gap < -DEPTH and name in apart:
                out.faults.append(f"{name} is {gap:.2e} m at {k * STEP:.2f} s")
            (apart.discard if gap < -DEPTH else apart.add)(name)
        energies.append(found["energy.kinetic"] + found["energy.potential"])
        kinetic = max(kinetic, found["energy.kinetic"])
    gain = float(np.diff(energies).max(initial=0))
    if gain > ENERGY * max(kinetic, 1e-3):
        at = int(np.diff(energies).argmax())
        out.faults.append(f"energy rises by {gain:.2e} J of {kinetic:.2e} J after {at * STEP:.2f} s")
    out.events = int(simulation.diagnostics["solver.events"])
    out.seconds = process_time() - start
    return out


def main(count: int, first: int = 0, jobs: int = 2) -> int:
    """Simulate scenes from `first` on, print what is wrong, and return the number of scenes with faults."""
    with Pool(jobs, maxtasksperchild=50) as pool:
        courses = []
        for course in pool.imap(run, range(first, first + count)):
            courses.append(course)
            if course.faults or course.refused:
                print(course.seed, course.refused, *course.faults, f"{course.seconds:.1f} s", flush=True)
    wrong = sum(bool(course.faults) for course in courses)
    refused = Counter(course.refused for course in courses if course.refused)
    print(
        f"{count} scenes, {sum(c.events for c in courses)} events, {wrong} with faults, "
        f"refused: {dict(refused)}"
    )
    print(f"{sum(c.seconds for c in courses):.0f} s of CPU, at most {max(c.seconds for c in courses):.1f} s")
    return wrong


if __name__ == "__main__":
    sys.exit(main(*(int(argument) for argument in sys.argv[1:] or ["3000"])) > 0)
