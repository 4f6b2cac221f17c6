# SPDX-License-Identifier: BSD-3-Clause
"""Mode shapes by coordinate and by body, from the outputs of a linear model."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from gelenk.linear.linearization import model_at
from gelenk.linear.model import COORDINATE_UNITS, EQUILIBRIUM_RATE_TOLERANCE, LinearModel
from gelenk.linear.operating_point import OperatingPoint
from gelenk.modal.eigenvalues import Cluster, spectrum
from gelenk.modal.mode import BodyMotion, Complex, Mode
from gelenk.model.rotation import small_rotation
from gelenk.model.scene import Scene, load
from gelenk.model.values import elements

Array = NDArray[np.float64]

# Weight of states against coordinates in the choice of a basis for repeated modes: they decide only if
# coordinates leave the choice open.
STATE_WEIGHT = 1e-6
IMMOBILE_AMPLITUDE = 1e-9  # relative to the largest component of the eigenvector; below it nothing moves
BODY_SENSOR_PREFIX = "watch_"  # name of a body's sensor: the prefix and the body's name


@dataclass(frozen=True)
class CoordinateRows:
    """Derivatives of coordinates and body frames with respect to the states.

    Attributes:
        names: names of the coordinates.
        by_states: derivatives of the coordinates, shape (names, states).
        frames: derivatives of translation [m] and rotation [rad] of each frame in the world, both of shape
            (3, states), by name.
        units: units of the coordinates.
    """

    names: tuple[str, ...]
    by_states: Array
    frames: Mapping[str, tuple[Array, Array]]
    units: Mapping[str, str]


def with_body_sensors(scene: Scene, point: OperatingPoint, states: Sequence[str]) -> LinearModel | None:
    """Return the linear model of a scene with a frame sensor on each body that has mass.

    Sensors do not influence the motion. Massless rods are omitted: the joints at their ends determine their
    motion.

    Args:
        scene: the scene.
        point: the operating point.
        states: names of the states.

    Returns:
        LinearModel | None: its outputs are named after the bodies; None if no body has mass.
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
    """Return a prefix with which no name in a scene begins."""
    prefix = BODY_SENSOR_PREFIX
    sections = [section for section in data.values() if isinstance(section, Mapping)]
    while any(str(name).startswith(prefix) for section in sections for name in section):
        prefix += "_"
    return prefix


def _renamed(model: LinearModel, prefix: str) -> LinearModel:
    """Return the model with only the outputs that have the prefix, which is removed from their names."""
    kept = [i for i, name in enumerate(model.outputs) if name.startswith(prefix)]
    outputs = tuple(model.outputs[i].removeprefix(prefix) for i in kept)
    return LinearModel(
        model.name, model.time, model.states, model.inputs, outputs, model.A, model.B, model.C[kept],
        model.D[kept], model.x0, model.u0, model.y0[kept], model.rates,
        {name: unit for name, unit in model.units.items() if not name.startswith(prefix)},
    )  # fmt: skip


def coordinate_rows(model: LinearModel, bodies: LinearModel | None) -> CoordinateRows:
    """Return the derivatives of all coordinates and frames with respect to the states.

    Coordinates are states and outputs of joints in rad or m; if there are none, all states are used.

    Args:
        model: the linear model.
        bodies: the model with body frames as outputs; None if they are unknown.
    """
    unit = np.eye(len(model.states))
    names = {name: row for name, row in zip(model.states, unit, strict=True) if _is_place(model, name)}
    for name, row in _outputs_of_joints(model):
        names.setdefault(name, row)
    if not names:
        names = dict(zip(model.states, unit, strict=True))
    of = model if bodies is None else bodies
    return CoordinateRows(
        tuple(names), np.array([*names.values()]).reshape(len(names), len(model.states)),
        {name: _frame(of, name) for name in _frame_names(of.outputs)},
        {name: model.units.get(name, "rad" if ".theta[" in name else "1") for name in names},
    )  # fmt: skip


def _is_place(model: LinearModel, name: str) -> bool:
    return model.units.get(name) in COORDINATE_UNITS


def _outputs_of_joints(model: LinearModel) -> Iterator[tuple[str, Array]]:
    """Yield the coordinates among the outputs and their derivatives; J.theta[1..3] replaces a quaternion."""
    at = {name: i for i, name in enumerate(model.outputs)}
    for name in model.outputs:
        owner, _, rest = name.rpartition(".")
        if rest.startswith("r[") and f"{owner}.a[1]" not in at:
            continue  # a frame sensor or a contact point, not a joint
        if _is_place(model, name):
            yield name, model.C[at[name]]
        elif rest == "Q[1]" and f"{owner}.z[1]" in at and {*elements(f"{owner}.Q", 4)} <= {*at}:
            Q = [at[n] for n in elements(f"{owner}.Q", 4)]
            turn = small_rotation(model.y0[Q], model.C[Q], in_world=False)
            yield from zip(elements(f"{owner}.theta", 3), turn, strict=True)


def _frame_names(outputs: Sequence[str]) -> list[str]:
    """Return the names of frame sensors: they have r and Q like a free joint, but no accelerations."""
    known = {*outputs}
    owners = dict.fromkeys(name.removesuffix(".r[1]") for name in outputs if name.endswith(".r[1]"))
    return [
        name for name in owners
        if f"{name}.z[1]" not in known and {*elements(f"{name}.r", 3), *elements(f"{name}.Q", 4)} <= known
    ]  # fmt: skip


def _frame(model: LinearModel, name: str) -> tuple[Array, Array]:
    at = {output: i for i, output in enumerate(model.outputs)}
    r, Q = ([at[n] for n in elements(f"{name}.{key}", count)] for key, count in (("r", 3), ("Q", 4)))
    return model.C[r], small_rotation(model.y0[Q], model.C[Q], in_world=True)


def modes_of(model: LinearModel, rows: CoordinateRows, rounding: float) -> tuple[Mode, ...]:
    """Return the modes of the matrix A, slowest first.

    Args:
        model: the linear model.
        rows: coordinates and frames for the mode shapes.
        rounding: assumed error of A relative to its norm.
    """
    clusters = spectrum(model.A, rounding)
    clusters.sort(key=lambda c: (float(f"{abs(c.value):.9e}"), -c.value.real))
    position_only = _grows_in_position_only(model, rounding)
    found: list[Mode] = []
    for cluster in clusters:
        vectors = _canonical_basis(cluster, rows)
        for k in range(len(cluster.chain_lengths)):
            found.append(_mode(len(found) + 1, cluster, k, vectors[:, k], position_only, model, rows))
    return tuple(found)


def _grows_in_position_only(model: LinearModel, rounding: float) -> bool:
    """Whether the Jordan chains of the eigenvalue 0 only move coordinates on which no velocity depends.

    An example is the position of a rolling disk. Without such coordinates the eigenvalue 0 is semisimple.
    """
    ignorable = np.array([model.units.get(name) in COORDINATE_UNITS for name in model.states], bool)
    size = np.abs(model.A)
    entries = size > EQUILIBRIUM_RATE_TOLERANCE + rounding * size.max(axis=1, keepdims=True, initial=0.0)
    while (used := ignorable & entries[~ignorable].any(axis=0)).any():
        ignorable &= ~used
    rest = spectrum(model.A[np.ix_(~ignorable, ~ignorable)], rounding)
    return bool(ignorable.any()) and all(max(c.chain_lengths) == 1 for c in rest if c.value == 0)


def _canonical_basis(cluster: Cluster, rows: CoordinateRows) -> Complex:
    """Return a basis of the modes of a cluster in which each mode has a coordinate that is zero in the
    others.

    Any linear combination of modes with equal eigenvalues is a mode; eigenvectors of longer Jordan chains may
    be added to those of shorter ones, but not vice versa.
    """
    V = cluster.vectors.copy()
    W = np.vstack([rows.by_states, STATE_WEIGHT * np.eye(len(V))])
    done: list[int] = []
    while len(done) < V.shape[1]:
        first = len(done)
        longer, equal = (
            V[:, :first],
            slice(first, first + cluster.chain_lengths.count(cluster.chain_lengths[first])),
        )
        if first:
            V[:, equal] -= longer @ np.linalg.solve(W[done] @ longer, W[done] @ V[:, equal])
        seen = W @ V[:, equal]
        order = qr(seen.conj().T, pivoting=True, mode="r")[1]
        pivots = sorted(map(int, order[: seen.shape[1]]))
        V[:, equal] = np.linalg.solve(seen[pivots].T, V[:, equal].T).T
        done += pivots
    return V


def _mode(
    number: int,
    cluster: Cluster,
    chain: int,
    v: Complex,
    position_only: bool,
    model: LinearModel,
    rows: CoordinateRows,
) -> Mode:
    names, shape = rows.names, rows.by_states @ v
    if np.abs(shape).max(initial=0.0) <= IMMOBILE_AMPLITUDE * np.abs(v).max():  # a conserved velocity
        names, shape = model.states, v
    amplitude = np.abs(shape)
    v = v / shape[int(np.flatnonzero(amplitude >= (1 - 1e-9) * amplitude.max())[0])]
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
        cluster.error_bound,
        cluster.size,
        cluster.chain_lengths[chain],
        position_only and cluster.value == 0,
        by_name,
        by_state,
        bodies,
    )
