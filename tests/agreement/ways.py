# SPDX-License-Identifier: BSD-3-Clause
"""Ways to run a trial that must all give the same motion."""

from __future__ import annotations

import contextlib
import time
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mechanisms import matrix, rotation
from numpy.typing import NDArray

import gelenk

from .elements import COORDINATES, STEP, SceneData, Trial

Array = NDArray[np.float64]
BELOW = 1000.0  # m; the distance of a floor that nothing reaches


@dataclass
class Run:
    """What a run has given.

    Args:
        values: positions and velocities, shape (points + 1, number of names); fewer rows if refused.
        refusal: why it ended early, or empty.
        said: warnings of a singular start, and events after which the motion is uncertain.
        seconds: CPU time.
        outputs: forces and modes by name, at each point, if asked for.
        stepped: whether time steps, not located events, have led to each point.
    """

    values: Array
    refusal: str = ""
    said: list[str] = field(default_factory=list)
    seconds: float = 0.0
    outputs: list[dict[str, float]] = field(default_factory=list)
    stepped: list[bool] = field(default_factory=list)


def motion_names(scene: SceneData) -> list[str]:
    """Coordinates and velocities of all joints, except quaternions."""
    out = []
    for name, joint in scene["joints"].items():
        if joint["type"] in COORDINATES:
            out += [f"{name}.{x}" for x in COORDINATES[joint["type"]]]
        elif joint["type"] == "free":
            out += [f"{name}.{x}[{i}]" for x in "rvw" for i in (1, 2, 3)]
    return out


def with_solver(trial: Trial, **solver: Any) -> Trial:
    out = trial.copy()
    out.scene["solver"] = {**out.scene.get("solver", {}), **solver}
    return out


def without_reductions(trial: Trial) -> Trial:
    return with_solver(trial, reductions={"all": False})


def with_floor(trial: Trial) -> Trial:
    """A ball on the first body, and a floor far below that it never reaches."""
    out = trial.copy()
    for fields in out.scene["bodies"].values():
        if fields["mass"] == 0:
            continue
        fields["shapes"] = fields.get("shapes", {}) | {"never": {"sphere": 0.01, "surface": "never"}}
        break
    ground = out.scene.setdefault("ground", {"shapes": {}})["shapes"]
    ground["far"] = {"plane": [0, 0, 1], "position": [0, 0, -BELOW], "surface": "far"}
    out.scene["contacts"] = {
        **out.scene.get("contacts", {}),
        "far": {"between": ["never", "far"], "friction": 0.3},
    }
    return out


def turned(trial: Trial, R: Array) -> Trial:
    """Everything on the ground and gravity turned by R."""
    out = trial.copy()
    out.scene["gravity"] = (R @ np.array(out.scene["gravity"])).tolist()
    for joint in out.scene["joints"].values():
        parent = joint["parent"] if isinstance(joint["parent"], dict) else {"body": joint["parent"]}
        if parent["body"] != "ground":
            continue
        position = R @ np.array(parent.get("position", [0, 0, 0]), float)
        joint["parent"] = {"body": "ground", "position": position.tolist(), "rotation": matrix(R)}
    for shape in out.scene.get("ground", {}).get("shapes", {}).values():
        shape["plane"] = (R @ np.array(shape["plane"], float)).tolist()
    return out


def perturbed(trial: Trial, size: float) -> Trial:
    """Given start values changed by about this much, but for coordinates at bounds and speeds of zero."""
    out = trial.copy()
    rng = np.random.default_rng(7)
    for joint in out.scene["joints"].values():
        start = joint.get("start", {})
        for name, value in start.items():
            if name in ("phi", "s", "w", "v") and isinstance(value, float) and value != 0:
                start[name] = value * (1 + size * float(rng.choice((-1, 1))))
            elif name in ("v", "w", "r") and isinstance(value, list):
                start[name] = [x * (1 + size * float(rng.choice((-1, 1)))) for x in value]
    gravity = np.array(out.scene["gravity"]) * (1 + size)
    out.scene["gravity"] = gravity.tolist()
    return out


# In a communication step that is to be refused: a hundred times what ordinary ones take.
FEW_EVALUATIONS = 20_000


def start(trial: Trial, begin: float = 0.0) -> gelenk.Simulation:
    plant = gelenk.Simulation(trial.scene)
    put(plant, trial, 0.0)
    plant.initialize(begin, trial.tolerance)
    return plant


def put(plant: gelenk.Simulation, trial: Trial, t: float) -> None:
    """Set all inputs that have a knot at t [s]; others go on."""
    for name, course in trial.inputs.items():
        if not any(abs(knot - t) < 1e-9 for knot in course.knots):
            values = course.at(t)
            if len(values) == 1:
                continue
        else:
            values = course.at(t)
        plant.set_input(name, values[0])
        for order, value in enumerate(values[1:], 1):
            plant.set_input_derivative(name, order, value)


Between = Callable[[int, gelenk.Simulation], gelenk.Simulation]


def run(
    trial: Trial,
    *,
    begin: float = 0.0,
    between: Between | None = None,
    outputs: Iterable[str] = (),
    seconds: float = 20.0,
) -> Run:
    """Run the trial.

    Args:
        trial: scene and inputs.
        begin: time at which it starts [s]; its inputs are shifted likewise.
        between: called before each communication step with its number; returns the plant that goes on.
        outputs: further names to read.
        seconds: CPU time after which the run is given up, as if it were refused.
    """
    names = motion_names(trial.scene)
    outputs = list(outputs)
    begun = time.process_time()
    rows: list[Array] = []
    out = Run(np.zeros((0, len(names))))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            plant = start(trial, begin)
            rows.append(plant.values(names))
            for k in range(trial.points):
                if between is not None:
                    plant = between(k, plant)
                put(plant, trial, k * STEP)
                plant.step_to(begin + (k + 1) * STEP)
                rows.append(plant.values(names))
                out.stepped.append(in_steps(plant, out.stepped[-1] if out.stepped else False))
                out.said += [
                    text
                    for _, text in plant.events
                    if any(words in text for words in ("more than one", "singular", "are uncertain"))
                ]
                if outputs:
                    out.outputs.append(dict(zip(outputs, plant.values(outputs).tolist(), strict=True)))
                if time.process_time() - begun > seconds:
                    out.refusal = f"took more than {seconds} s"
                    break
        except gelenk.GelenkError as error:
            out.refusal = f"{type(error).__name__}: {error}"
        out.said += [str(w.message) for w in caught if issubclass(w.category, gelenk.StartWarning)]
    out.values = np.array(rows).reshape(len(rows), len(names))
    out.seconds = time.process_time() - begun
    return out


def in_steps(plant: gelenk.Simulation, before: bool) -> bool:
    """Whether a plant makes time steps, by the events of its last communication step."""
    changes = [text for _, text in plant.events if "from here on" in text]
    return changes[-1].startswith("time steps") if changes else before


def saving(_k: int, plant: gelenk.Simulation) -> gelenk.Simulation:
    plant.save()
    return plant


def restoring(trial: Trial, seed: int) -> Between:
    """Before some steps a state is saved, a step made that is refused or goes elsewhere, and the state
    restored, here or in another instance.
    """
    rng = np.random.default_rng(seed)

    def between(_k: int, plant: gelenk.Simulation) -> gelenk.Simulation:
        saved = plant.save()
        if rng.random() < 0.5:
            return plant
        here = plant.time
        for name in trial.inputs:
            if "friction" not in name:
                plant.set_input(name, float(rng.choice((1e20, 10.0))) if "_ref" not in name else 0.1)
        with contextlib.suppress(gelenk.GelenkError):
            plant.step_to(here + STEP)
        if rng.random() < 0.5:
            plant = start(trial, 0.0)
        plant.restore(saved)
        return plant

    return between


def directions(seed: int) -> Array:
    """A rotation, often by a round angle."""
    rng = np.random.default_rng(seed)
    if rng.random() < 0.5:
        axis = [[1, 0, 0], [0, 1, 0], [0, 0, 1]][int(rng.integers(3))]
        return rotation(axis, float(rng.choice((np.pi / 2, np.pi, -np.pi / 2))))
    return rotation(rng.normal(size=3), float(rng.uniform(0, np.pi)))


def without_static_excess(trial: Trial) -> Trial:
    """Static friction is sliding friction: whether a joint slides then follows from its forces alone.

    Otherwise it may stick or slide under a force between the two, and a jump of the velocity of its motion,
    however small, ends static friction.
    """
    out = trial.copy()
    for joint in out.scene["joints"].values():
        joint.get("friction", {}).pop("static", None)
    return out


def run_values_only(trial: Trial, parts: int) -> Array:
    """Values at the points of the trial if positions are set without derivatives, `parts` times a step."""
    names = motion_names(trial.scene)
    plant = gelenk.Simulation(trial.scene)
    put_values(plant, trial, 0.0)
    plant.initialize(0.0, trial.tolerance)
    rows = [plant.values(names)]
    for k in range(trial.points):
        for part in range(parts):
            put_values(plant, trial, (k + part / parts) * STEP)
            plant.step_to((k + (part + 1) / parts) * STEP)
        rows.append(plant.values(names))
    return np.array(rows)


def put_values(plant: gelenk.Simulation, trial: Trial, t: float) -> None:
    """Set all inputs at t [s], motions without their derivatives."""
    for name, course in trial.inputs.items():
        value, *derivatives = course.at(t)
        plant.set_input(name, value)
        for order, derivative in enumerate([] if "_ref" in name else derivatives, 1):
            plant.set_input_derivative(name, order, derivative)
