# SPDX-License-Identifier: BSD-3-Clause
"""Linearization of a mechanism about an operating point."""

from __future__ import annotations

import itertools
import logging
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gelenk.errors import OperatingPointWarning, UsageError
from gelenk.linear.minimal_realization import (
    DEPENDENCY_TOLERANCE,
    Array,
    MinimalRealization,
    check_complete,
    chosen_states,
)
from gelenk.linear.model import LinearModel, with_dots
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.linear.state_basis import completed, dependencies, transformed
from gelenk.model.values import Value, check_names
from gelenk.simulation.derivatives import Derivatives
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.run import expanded, open_plant

if TYPE_CHECKING:
    import control

type Names = Sequence[str]

log = logging.getLogger(__name__)

TREATMENTS = ("present", "locked", "sliding", "off")  # of friction, see linearize()


def linearize(
    source: Mechanism | OperatingPoint,
    *,
    at: At = None,
    input_values: Inputs | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
    parameters: Mapping[str, Value] | None = None,
    tolerance: float | None = None,
    friction: str = "present",
) -> control.StateSpace:
    """Linearize a scene or an FMU about an operating point, for python-control.

    The model is exact to rounding and has a minimal number of states; FMUs are linearized by their
    directional derivatives. `gelenk.linear.linear_model` also returns the operating point (x0, u0, y0). See
    docs/linearization.md.

    Args:
        source: a .fmu file, anything `gelenk.load` accepts, or an operating point, which already contains the
            arguments `at`, `input_values`, `parameters` and `tolerance`.
        at: the operating point. None: the start values. A time [s]: the state that the motion from the start
            values under `input_values` reaches. Values by name: the start values with these replaced: a state
            of a joint ("hinge.phi", attained exactly), a parameter ("hinge.phi_start", "pole.m") or an input.
        input_values: see `gelenk.simulation.inputs.functions`; inputs that are not named are 0.
        inputs: names of the model's inputs, in this order; by default all. The others remain constant.
        outputs: names or patterns of the model's outputs, in this order; by default all that are
            differentiable.
        states: names of coordinates, or of coordinates and velocities, in this order; by default those chosen
            by the plant. Rotation coordinates of a spherical or free joint are `J.theta[1..3]`. States may be
            omitted if none of the named states and outputs depends on them. By default, idle rotations are
            omitted: those of a rod between two ball joints about its axis, if nothing depends on them.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, if `at` is a time.
        friction: what joints and contacts with dry friction do. "present": what they do at the operating
            point; what is at rest, sticks, or is in contact with a limit, is locked and not among the states.
            "locked": none moves. "sliding": all move, those at rest against a constant friction. "off": there
            is no friction. Closed contacts remain closed.

    Returns:
        control.StateSpace: the labels of its states, inputs and outputs have "_" for "." (drive_f); its
        attribute `names` has the names with dots, which are those in the FMU, as `names.states`,
        `names.inputs` and `names.outputs`. Arguments may be names or labels.

    Warns:
        OperatingPointWarning: the point is not an equilibrium; the warning gives the rates of the states. Or
            idle rotations are left out, see `states`.

    Raises:
        SceneError, UsageError: the scene, a name or a value is invalid, or the configuration is singular.
        AssemblyError: the loops cannot be closed with these values.
        StepError: the motion cannot be computed up to `at`.
        OSError: a file cannot be read.

    >>> model = gelenk.linearize("scenes/cart_pole.yaml", at={"hinge.phi": 0}, outputs=["hinge.phi"])
    >>> model.state_labels, model.input_labels, model.output_labels
    (['track_s', 'hinge_phi', 'track_v', 'hinge_w'], ['drive_f'], ['hinge_phi'])
    >>> model.names.states
    ('track.s', 'hinge.phi', 'track.v', 'hinge.w')
    """
    point = OperatingPoint.given(source, at, input_values, parameters, tolerance)
    model = model_at(point, inputs, outputs, states, friction)
    for remark in (model.residual_rates, model.idle_rotations if states is None else ""):
        if remark:
            warnings.warn(remark, OperatingPointWarning, stacklevel=2)
    return model.to_control()


def linear_model(
    source: Mechanism | OperatingPoint,
    *,
    at: At = None,
    input_values: Inputs | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
    parameters: Mapping[str, Value] | None = None,
    tolerance: float | None = None,
    friction: str = "present",
) -> LinearModel:
    """Return the linear model as matrices with its operating point, without a warning.

    The arguments are those of `linearize`; `LinearModel.residual_rates` states whether the point is an
    equilibrium.

    Raises:
        SceneError, UsageError, AssemblyError, StepError, OSError: as for `linearize`.

    >>> model = gelenk.linear.linear_model("scenes/cart_pole.yaml", at={"hinge.phi": 0})
    >>> model.A.shape, model.residual_rates
    ((4, 4), '')
    """
    point = OperatingPoint.given(source, at, input_values, parameters, tolerance)
    return model_at(point, inputs, outputs, states, friction)


def model_at(
    point: OperatingPoint,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
    friction: str = "present",
    *,
    with_idle: bool = False,
) -> LinearModel:
    """Return the linear model about an operating point.

    Args:
        point: the operating point.
        inputs: names of the inputs; None: all.
        outputs: names or patterns of the outputs; None: all that have derivatives.
        states: names of the states; None: those chosen by the plant.
        friction: see `linearize`.
        with_idle: whether the plant's choice of states includes rotations on which nothing depends.

    Raises:
        SceneError, UsageError, AssemblyError, StepError, OSError: as for `linearize`.
    """
    if friction not in TREATMENTS:
        raise UsageError(f"friction: found {friction!r}, expected one of {', '.join(TREATMENTS)}")
    plant = open_plant(point.source, (), whole=outputs is not None)
    try:
        reached = point.reach(plant)
        if states is not None:
            rotations = [theta for quaternion in plant.quaternions for theta in quaternion.theta]
            states = with_dots(states, [*plant.readings, *rotations])
        found = plant.derivatives(states or (), friction)
    finally:
        plant.close()
    reached.check(found)
    model = _assembled(plant.name, point.time, found, inputs, outputs, states, with_idle)
    model = replace(model, friction=friction)
    sizes = len(model.states), len(model.inputs), len(model.outputs)
    log.info("%s: linearized at t = %g s, %d states, %d inputs, %d outputs", model.name, model.time, *sizes)
    return model


def _assembled(
    name: str,
    time: float,
    found: Derivatives,
    inputs: Names | None,
    outputs: Names | None,
    states: Names | None,
    with_idle: bool,
) -> LinearModel:
    u = _selected(inputs, found.inputs, "input")
    y = _selected(outputs, found.outputs, "output")
    undetermined = found.undetermined_outputs()
    if unclear := [found.rates[x] for x in found.states if found.rates.get(x) in undetermined]:
        raise UsageError(
            f"{', '.join(unclear)}: found no derivatives at the operating point, where a force given by an "
            "expression is not smooth; expected another operating point"
        )
    if outputs is None:
        y = tuple(name for name in y if name not in undetermined)
    elif asked := [name for name in y if name in undetermined]:
        raise UsageError(
            f"outputs: {', '.join(asked)}: found no derivatives, since friction and limits hold the joints "
            "of a loop redundantly; expected other outputs"
        )
    found = found.without(undetermined)
    minimal = MinimalRealization(found.in_own_units())
    check_complete(minimal)
    if minimal.locked.isdisjoint(states or ()):
        minimal.leave_locked()
    spins = [] if with_idle else minimal.idle_rotations
    if outputs is not None and states is None:
        spins = _without_effect(minimal, spins, _indices(y, found.readings))
    idle = tuple(name for spin in spins for name in spin)
    x = chosen_states(minimal, states, idle)
    complete = completed(minimal, x)
    by_x, C = transformed(minimal, complete, time)
    if len(x) < len(complete):
        if outputs is None:
            y = _independent_of_others(C, found.readings, y, len(x))
        _check_independent_of_others(by_x, C[_indices(y, found.readings)], complete, x, y)
        by_x, C = by_x[: len(x), : len(x)], C[:, : len(x)]
    rates = [minimal.rate(state) for state in x]
    by_u = np.array([row for _, row, _ in rates]).reshape(len(x), len(found.inputs))
    columns, rows = _indices(u, found.inputs), _indices(y, found.readings)
    units = {n: found.units.get(n, "1") for n in (*u, *y)} | {n: minimal.unit(n) for n in x}
    values = minimal.of.values
    return _in_si(LinearModel(
        name, time, tuple(x), u, y, by_x, by_u[:, columns], C[rows], minimal.D[np.ix_(rows, columns)],
        np.array([minimal.value(n) for n in x]), np.array([values[n] for n in u]),
        np.array([values[n] for n in y]), np.array([rate for _, _, rate in rates]), units, found.scales,
        left_out=tuple(name for name in idle if name not in x),
    ))  # fmt: skip


def _without_effect(minimal: MinimalRealization, spins: list[Names], rows: Sequence[int]) -> list[Names]:
    """Return those of the idle rotations on which none of the rows of C depends."""
    by_spin = [minimal.C[np.ix_(rows, _indices(spin, minimal.names))] for spin in spins]
    small = [np.abs(by_states).max(initial=0.0) <= DEPENDENCY_TOLERANCE for by_states in by_spin]
    return list(itertools.compress(spins, small))


def _in_si(model: LinearModel) -> LinearModel:
    """Convert a model from the mechanism's own units to SI units."""
    x, u, y = (
        model.scales.sizes([model.units[name] for name in names])
        for names in (model.states, model.inputs, model.outputs)
    )
    rate = x / model.scales.time
    return replace(
        model, x0=model.x0 * x, u0=model.u0 * u, y0=model.y0 * y, rates=model.rates * rate,
        A=model.A * rate[:, None] / x, B=model.B * rate[:, None] / u,
        C=model.C * y[:, None] / x, D=model.D * y[:, None] / u,
    )  # fmt: skip


def _indices(names: Names, among: Names) -> list[int]:
    place = {name: i for i, name in enumerate(among)}
    return [place[name] for name in names]


def _independent_of_others(C: Array, readings: Names, outputs: Names, kept: int) -> tuple[str, ...]:
    """Return the outputs that do not depend on states after the first `kept`."""
    rows = {name: C[[readings.index(name)]] for name in outputs}
    return tuple(n for n in outputs if not dependencies(rows[n], (n,), kept, [""] * C.shape[1]))


def _check_independent_of_others(A: Array, C: Array, states: Names, kept: Names, outputs: Names) -> None:
    """Raise UsageError if rates of the kept states, or outputs, depend on other states."""
    n = len(kept)
    faults = dependencies(A[:n], [f"der({name})" for name in kept], n, states)
    faults += dependencies(C, outputs, n, states)
    if faults:
        raise UsageError("\n".join(f"states: {fault}, which is not among them" for fault in faults))


def _selected(wanted: Names | None, known: Names, what: str) -> tuple[str, ...]:
    if wanted is None:
        return tuple(known)
    if isinstance(wanted, Mapping):
        values = "; values of inputs are `input_values`" if what == "input" else ""
        raise UsageError(f"{what}s: found values by name, expected names{values}")
    wanted = with_dots([wanted] if isinstance(wanted, str) else wanted, known)
    if what == "output":
        wanted = expanded(wanted, known)
    check_names(wanted, known, what)
    return tuple(wanted)
