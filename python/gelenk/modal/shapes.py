# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of modes by coordinates and by bodies, from a linear model's outputs."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from gelenk.linear.linearization import model_at
from gelenk.linear.model import COORDINATES, STANDS, LinearModel
from gelenk.linear.operating_point import OperatingPoint
from gelenk.modal.mode import BodyMotion, Complex, Mode
from gelenk.modal.spectrum import Cluster, spectrum
from gelenk.model.rotation import small_turn
from gelenk.model.scene import Scene, load
from gelenk.model.values import elements

Array = NDArray[np.float64]

SPEEDS_COUNT = 1e-6  # in the choice of shapes of repeated modes: only where coordinates leave one open
NOTHING = 1e-9  # a coordinate that moves by this part of the states does not move
WATCH = "watch_"  # before a body's name: the sensor on it


@dataclass(frozen=True)
class Rows:
    """What moves by how much with the states: coordinates, speeds, and frames of bodies.

    Attributes:
        names: of the coordinates.
        by_states: shape (names, states).
        frames: name -> slopes of its translation and of its rotation in the world, both of shape (3, states).
        units: of the coordinates.
    """

    names: tuple[str, ...]
    by_states: Array
    frames: Mapping[str, tuple[Array, Array]]
    units: Mapping[str, str]


def watched(scene: Scene, point: OperatingPoint, states: Sequence[str]) -> LinearModel | None:
    """The scene's linear model, with a frame sensor on each body that has mass; None where there is no body.

    Sensors change no motion. A rod without mass is no body there: it is told by the joints at its ends.
    """
    data = copy.deepcopy(scene.to_dict())
    heavy = [name for name, body in data["bodies"].items() if body["mass"] > 0]
    if not heavy:
        return None
    prefix = free_prefix(data)
    data["sensors"] = {f"{prefix}{name}": {"type": "frame", "body": name} for name in heavy}
    model = model_at(replace(point, source=load(data)), states=states)
    return _renamed(model, prefix)


def free_prefix(data: Mapping[str, Any]) -> str:
    """One that no name of a scene begins with."""
    prefix = WATCH
    sections = [section for section in data.values() if isinstance(section, Mapping)]
    while any(str(name).startswith(prefix) for section in sections for name in section):
        prefix += "_"
    return prefix


def _renamed(model: LinearModel, prefix: str) -> LinearModel:
    """Without the prefix: its frames are bodies."""
    kept = [i for i, name in enumerate(model.outputs) if name.startswith(prefix)]
    outputs = tuple(model.outputs[i].removeprefix(prefix) for i in kept)
    return LinearModel(
        model.name, model.time, model.states, model.inputs, outputs, model.A, model.B, model.C[kept],
        model.D[kept], model.x0, model.u0, model.y0[kept], model.rates,
        {name: unit for name, unit in model.units.items() if not name.startswith(prefix)},
    )  # fmt: skip


def rows_of(model: LinearModel, bodies: LinearModel | None) -> Rows:
    """Coordinates are states, and outputs of joints, in rad or m; all states, if there are none."""
    unit = np.eye(len(model.states))
    names = {name: row for name, row in zip(model.states, unit, strict=True) if _is_place(model, name)}
    for name, row in _outputs_of_joints(model):
        names.setdefault(name, row)
    if not names:
        names = dict(zip(model.states, unit, strict=True))
    of = model if bodies is None else bodies
    return Rows(
        tuple(names), np.array([*names.values()]).reshape(len(names), len(model.states)),
        {name: _frame(of, name) for name in _frame_names(of.outputs)},
        {name: model.units.get(name, "rad" if ".theta[" in name else "1") for name in names},
    )  # fmt: skip


def _is_place(model: LinearModel, name: str) -> bool:
    return model.units.get(name) in COORDINATES


def _outputs_of_joints(model: LinearModel) -> Iterator[tuple[str, Array]]:
    """Coordinates among the outputs, J.theta[1..3] in the place of quaternions, and their slopes."""
    at = {name: i for i, name in enumerate(model.outputs)}
    for name in model.outputs:
        owner, _, rest = name.rpartition(".")
        if rest.startswith("r[") and f"{owner}.a[1]" not in at:
            continue  # where a sensor's frame or a contact is: no joint
        if _is_place(model, name):
            yield name, model.C[at[name]]
        elif rest == "Q[1]" and f"{owner}.z[1]" in at and {*elements(f"{owner}.Q", 4)} <= {*at}:
            Q = [at[n] for n in elements(f"{owner}.Q", 4)]
            turn = small_turn(model.y0[Q], model.C[Q], in_world=False)
            yield from zip(elements(f"{owner}.theta", 3), turn, strict=True)


def _frame_names(outputs: Sequence[str]) -> list[str]:
    """Frame sensors: position and quaternion, as a free joint has, but no accelerations."""
    known = {*outputs}
    owners = dict.fromkeys(name.removesuffix(".r[1]") for name in outputs if name.endswith(".r[1]"))
    return [
        name for name in owners
        if f"{name}.z[1]" not in known and {*elements(f"{name}.r", 3), *elements(f"{name}.Q", 4)} <= known
    ]  # fmt: skip


def _frame(model: LinearModel, name: str) -> tuple[Array, Array]:
    at = {output: i for i, output in enumerate(model.outputs)}
    r, Q = ([at[n] for n in elements(f"{name}.{key}", count)] for key, count in (("r", 3), ("Q", 4)))
    return model.C[r], small_turn(model.y0[Q], model.C[Q], in_world=True)


def shaped(model: LinearModel, rows: Rows, rounding: float) -> tuple[Mode, ...]:
    """The modes of A, slow ones first."""
    clusters = spectrum(model.A, rounding)
    clusters.sort(key=lambda c: (float(f"{abs(c.value):.9e}"), -c.value.real))
    coasts = _coasts(model, rounding)
    found: list[Mode] = []
    for cluster in clusters:
        vectors = _told_apart(cluster, rows)
        for k in range(len(cluster.lengths)):
            found.append(_mode(len(found) + 1, cluster, k, vectors[:, k], coasts, model, rows))
    return tuple(found)


def _coasts(model: LinearModel, rounding: float) -> bool:
    """Whether Jordan chains of 0 are but coordinates that run on and that no speed feels: a disc's place.

    Without them, and what only they feel, 0 has a shape for each time it is there.
    """
    unfelt = np.array([model.units.get(name) in COORDINATES for name in model.states], bool)
    size = np.abs(model.A)
    entries = size > STANDS + rounding * size.max(axis=1, keepdims=True, initial=0.0)
    while (felt := unfelt & entries[~unfelt].any(axis=0)).any():
        unfelt &= ~felt
    rest = spectrum(model.A[np.ix_(~unfelt, ~unfelt)], rounding)
    return bool(unfelt.any()) and all(max(c.lengths) == 1 for c in rest if c.value == 0)


def _told_apart(cluster: Cluster, rows: Rows) -> Complex:
    """Of equal modes any mixture is one. Taken are those in which one coordinate moves that others leave.

    Leads of longer chains may be mixed into those of shorter ones, not the other way round.
    """
    V = cluster.vectors.copy()
    W = np.vstack([rows.by_states, SPEEDS_COUNT * np.eye(len(V))])
    done: list[int] = []
    while len(done) < V.shape[1]:
        first = len(done)
        longer, equal = V[:, :first], slice(first, first + cluster.lengths.count(cluster.lengths[first]))
        if first:
            V[:, equal] -= longer @ np.linalg.solve(W[done] @ longer, W[done] @ V[:, equal])
        seen = W @ V[:, equal]
        order = qr(seen.conj().T, pivoting=True, mode="r")[1]
        pivots = sorted(map(int, order[: seen.shape[1]]))
        V[:, equal] = np.linalg.solve(seen[pivots].T, V[:, equal].T).T
        done += pivots
    return V


def _mode(
    number: int, cluster: Cluster, chain: int, v: Complex, coasts: bool, model: LinearModel, rows: Rows
) -> Mode:
    names, shape = rows.names, rows.by_states @ v
    if np.abs(shape).max(initial=0.0) <= NOTHING * np.abs(v).max():  # a speed that is kept
        names, shape = model.states, v
    size_of = np.abs(shape)
    v = v / shape[int(np.flatnonzero(size_of >= (1 - 1e-9) * size_of.max())[0])]
    if cluster.value.imag == 0:
        v = v.real.astype(np.complex128)
    shape = rows.by_states @ v if names is rows.names else v
    by_name, by_state = (
        dict(zip(keys, map(complex, x), strict=True)) for keys, x in ((names, shape), (model.states, v))
    )
    bodies = {name: BodyMotion(r @ v, turn @ v) for name, (r, turn) in rows.frames.items()}
    return Mode(
        number,
        cluster.value,
        cluster.error,
        cluster.size,
        cluster.lengths[chain],
        coasts and cluster.value == 0,
        by_name,
        by_state,
        bodies,
    )
