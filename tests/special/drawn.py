# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms at special positions, each determined by a seed."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Array, Scene, placed, rotation

from .bodies import Bodies, Poses
from .planar import PLANAR
from .sketch import COORDINATES, Sketch
from .spatial import SPATIAL

SPEEDS = {"phi": "w", "s": "v", "phi_a": "w_a", "phi_b": "w_b", "s_x": "v_x", "s_y": "v_y"}


@dataclass(frozen=True)
class Case:
    """A mechanism and its start.

    exact: all coordinates are given, and close the loops. reachable: there is such a position.
    """

    name: str
    source: Scene
    exact: bool = False
    reachable: bool = False


def drawn(seed: int) -> Case:
    """Return the same case for the same seed."""
    rng = np.random.default_rng([15, seed])
    while True:
        planar = rng.random() < 0.65
        families = PLANAR if planar else SPATIAL
        family = families[rng.integers(len(families))]
        natural = bool(rng.random() < 0.6)
        sketch = family(rng, natural)
        if sketch is None:
            continue
        source = sketch.scene(name=f"{family.__name__}{seed}".replace("_", ""))
        made = _started(source, rng)
        if made is None:
            continue
        source, style = made
        _load(source, sketch, rng, planar)
        if rng.random() < (0.3 if planar else 0.1):
            source = placed(source, rotation(rng.normal(size=3), rng.uniform(0, 3)), rng.uniform(-1, 1, 3))
        words = f"{family.__name__} {seed}, {'along links' if natural else 'along the world'}, {style}"
        return Case(words, source, style in ("exact", "guesses"), True)


def values_of(source: Scene) -> dict[str, float]:
    """Coordinates by name, from start values; missing ones are zero."""
    out = {}
    for name, entry in source["joints"].items():
        start = entry.get("start", {})
        for q in COORDINATES.get(entry["type"], ()):
            if not q.startswith("Q"):
                out[f"{name}.{q}"] = float(start.get(q, 0.0))
        if entry["type"] == "spherical":
            out |= {f"{name}.Q[{i}]": x for i, x in enumerate(start.get("Q", [0, 0, 0, 1]), 1)}
    return out


def _started(source: Scene, rng: np.random.Generator) -> tuple[Scene, str] | None:
    """The scene with fixed drivers and velocities compatible with the loops. None:
    nothing moves, or too much for a test.
    """
    model = Bodies(source)
    x = model.poses(values_of(source))
    degrees_of_freedom = model.degrees_of_freedom(x)
    if not 0 < degrees_of_freedom <= 6:
        return None
    names, H = model.rates(x)
    N = model.null_space(x)
    speeds = np.zeros(len(names))
    if rng.random() < 0.5:
        V = N @ rng.normal(size=N.shape[1])
        speeds = H @ V
        speeds *= rng.choice([0.3, 1.0, 5.0]) / max(1e-9, float(np.abs(speeds).max()))
        speeds[np.abs(speeds) < 1e-14] = 0.0
    drivers = _drivers(model, x, degrees_of_freedom, names, H @ N)
    style = str(rng.choice(["exact", "guesses", "one left out", "rounded"], p=[0.45, 0.1, 0.2, 0.25]))
    _set_start_values(source, dict(zip(names, speeds.tolist(), strict=True)), drivers, style, rng)
    return source, style


def _drivers(model: Bodies, x: Poses, degrees_of_freedom: int, names: list[str], rates: Array) -> list[str]:
    """Select as many velocities as degrees of freedom, in file order, that determine the motion well."""
    del model, x
    chosen: list[str] = []
    basis = np.zeros((0, rates.shape[1]))
    size = float(np.linalg.norm(rates, axis=1).max(initial=1e-300))
    for name, row in zip(names, rates, strict=True):
        if len(chosen) == degrees_of_freedom or "[" in name:
            continue
        rest = row - basis.T @ (basis @ row)
        if np.linalg.norm(rest) > 0.2 * size * (1 if not chosen else 0.3):
            chosen.append(name)
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
    return chosen


def _set_start_values(
    source: Scene, speeds: dict[str, float], drivers: list[str], style: str, rng: np.random.Generator
) -> None:
    moving = any(speeds.values())
    others = [n for n in source["joints"] if not any(d.startswith(f"{n}.") for d in drivers)]
    left_out = str(rng.choice(others)) if others else ""
    for name, entry in source["joints"].items():
        start = entry.get("start")
        if start is None:
            continue
        fixed = []
        for q in list(start):
            if q == "Q":
                if moving:
                    start["w"] = [speeds[f"{name}.w[{i}]"] for i in (1, 2, 3)]
                continue
            w = SPEEDS[q]
            is_driver = f"{name}.{w}" in drivers
            if moving:
                start[w] = speeds[f"{name}.{w}"]
            if is_driver and style != "guesses":
                fixed += [q, w] if moving else [q]
            elif style == "rounded":
                start[q] = round(start[q], 2)
                start.pop(w, None)
        if fixed:
            start["fixed"] = fixed
        elif style == "one left out" and name == left_out:
            del entry["start"]


def _load(source: Scene, sketch: Sketch, rng: np.random.Generator, planar: bool) -> None:
    """Add gravity, motors, dampers, springs."""
    style = rng.random()
    if style < 0.5:
        source["gravity"] = [0.0, -GRAVITY, 0.0] if planar else [0.0, 0.0, -GRAVITY]
    elif style < 0.6:
        source["gravity"] = [3.0, -5.0, 0.0 if planar else 2.0]
    single = [n for n, j in source["joints"].items() if j["type"] in ("revolute", "prismatic")]
    light = {n for n, b in source["bodies"].items() if b["mass"] == 0}
    single = [n for n in single if not {source["joints"][n][s]["body"] for s in ("parent", "child")} & light]
    if single:
        motor: dict[str, Any] = {"joint": str(rng.choice(single))}
        if rng.random() < 0.2:
            motor |= {"gear_ratio": 10, "rotor_inertia": 1e-3}
        source["motors"] = {"push": motor}
    for name in single:
        chance = rng.random()
        if chance < 0.15:
            source["joints"][name]["damping"] = 0.5
        elif chance < 0.3:
            source["joints"][name] |= {"stiffness": 20.0, "spring_reference": 0.3}
    if rng.random() < 0.15:
        body = str(rng.choice([n for n in source["bodies"] if n not in light]))
        R, p = sketch.poses[body]
        anchor = p + np.array([0.7, -0.9, 0.0 if planar else 0.4])
        source["forces"] = {
            "spring": {
                "type": "spring_damper",
                "from": {"body": "ground", "position": anchor.tolist()},
                "to": {"body": body, "position": [0.0, 0.0, 0.0]},
                "stiffness": 50.0,
                "damping": 2.0,
                "length": 0.3,
            }
        }
        del R


def at_rest(source: Scene) -> Scene:
    out = copy.deepcopy(source)
    for entry in out["joints"].values():
        start = entry.get("start", {})
        for key in [k for k in start if k in ("v", "w") or k.startswith(("v_", "w_"))]:
            del start[key]
            if isinstance(start.get("fixed"), list):
                start["fixed"] = [f for f in start["fixed"] if f != key]
        if start.get("fixed") == []:
            del start["fixed"]
        if entry["type"] == "free" and "v" in start:
            del start["v"]
    return out
