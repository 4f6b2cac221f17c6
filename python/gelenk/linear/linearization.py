# SPDX-License-Identifier: BSD-3-Clause
"""The linear model of a mechanism about a point of its motion."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gelenk.errors import OperatingPointWarning, UsageError
from gelenk.linear.minimal import Array, Minimal, check_whole, chosen_states
from gelenk.linear.model import LinearModel
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.linear.state_basis import completed, felt, transformed
from gelenk.model.values import Value, check_names
from gelenk.simulation.derivatives import Derivatives
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.run import expanded, open_plant

if TYPE_CHECKING:
    import control

type Names = Sequence[str]


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
) -> control.StateSpace:
    """The linear model of a scene, or of an FMU by its directional derivatives alone, for python-control.

    Exact, without difference quotients; by as many states as the mechanism has. See
    `gelenk.linear.linear_model`, whose numbers these are, for the point itself (x0, u0, y0), and
    docs/linearization.md.

    Args:
        source: a .fmu file, or whatever `gelenk.load` takes; or an operating point, in which the arguments of
            these names stand already.
        at: the point: None, the start values; a time [s], where the motion from the start values under
            `input_values` gets to; or values by name, on top of the start values: a joint's state
            ("hinge.phi", attained exactly), a parameter ("hinge.phi_start", "pole.m"), an input.
        input_values: see `gelenk.simulation.inputs.functions`; inputs that are not named are 0.
        inputs: names to be inputs of the model, in this order; by default all. Others stay as they are.
        outputs: names to be outputs of the model, in this order; by default all.
        states: names of coordinates, or of coordinates and speeds, in this order; by default those of the
            plant. Of a spherical or free joint, `J.theta[1..3]`. Coordinates and speeds may be fewer than all
            where nothing named changes with those left out.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, where `at` is a time.

    Returns:
        control.StateSpace: states as named in Gelenk, inputs and outputs with "_" for "." (drive_f).

    Warns:
        OperatingPointWarning: the point is no equilibrium; names each state that changes, and its rate.

    Raises:
        SceneError, UsageError: the scene, a name or a value is wrong, or the position is singular.
        AssemblyError: the loops cannot be closed with these values.
        StepError: the motion does not get to `at`.
        OSError: a file cannot be read.

    >>> model = gelenk.linearize("scenes/cart_pole.yaml", at={"hinge.phi": 0}, outputs=["hinge.phi"])
    >>> model.state_labels, model.input_labels, model.output_labels
    (['track.s', 'hinge.phi', 'track.v', 'hinge.w'], ['drive_f'], ['hinge_phi'])
    """
    point = OperatingPoint.given(source, at, input_values, parameters, tolerance)
    model = model_at(point, inputs, outputs, states)
    if model.unrest:
        warnings.warn(model.unrest, OperatingPointWarning, stacklevel=2)
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
) -> LinearModel:
    """The same as `linearize`, as matrices with the point they belong to; warns of nothing."""
    point = OperatingPoint.given(source, at, input_values, parameters, tolerance)
    return model_at(point, inputs, outputs, states)


def model_at(
    point: OperatingPoint,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
) -> LinearModel:
    """The linear model about a point; names as of `linearize`, None for all."""
    plant = open_plant(point.source, (), whole=outputs is not None)
    try:
        reached = point.reach(plant)
        found = plant.derivatives(states or ())
    finally:
        plant.close()
    reached.check(found)
    return _assembled(plant.name, point.time, found, inputs, outputs, states)


def _assembled(
    name: str,
    time: float,
    found: Derivatives,
    inputs: Names | None,
    outputs: Names | None,
    states: Names | None,
) -> LinearModel:
    u = _selected(inputs, found.inputs, "input")
    y = _selected(None if outputs is None else expanded(outputs, found.outputs), found.outputs, "output")
    minimal = Minimal(found.in_own_units())
    x = chosen_states(minimal, states)
    check_whole(minimal)
    whole = completed(minimal, x)
    by_x, C = transformed(minimal, whole, time)
    if len(x) < len(whole):
        if outputs is None:
            y = _determined(C, found.readings, y, len(x))
        _check_closed(by_x, C[_places(y, found.readings)], whole, x, y)
        by_x, C = by_x[: len(x), : len(x)], C[:, : len(x)]
    rates = [minimal.rate(state) for state in x]
    by_u = np.array([row for _, row, _ in rates]).reshape(len(x), len(found.inputs))
    columns, rows = _places(u, found.inputs), _places(y, found.readings)
    units = {n: found.units.get(n, "1") for n in (*u, *y)} | {n: minimal.unit(n) for n in x}
    values = minimal.of.values
    return _in_si(LinearModel(
        name, time, tuple(x), u, y, by_x, by_u[:, columns], C[rows], minimal.D[np.ix_(rows, columns)],
        np.array([minimal.value(n) for n in x]), np.array([values[n] for n in u]),
        np.array([values[n] for n in y]), np.array([rate for _, _, rate in rates]), units, found.scales,
    ))  # fmt: skip


def _in_si(model: LinearModel) -> LinearModel:
    """The same, with its numbers in SI in the place of the mechanism's own units."""
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


def _places(names: Names, among: Names) -> list[int]:
    return [among.index(name) for name in names]


def _determined(C: Array, readings: Names, outputs: Names, kept: int) -> tuple[str, ...]:
    """Those outputs that do not change with states behind the first `kept`."""
    rows = {name: C[[readings.index(name)]] for name in outputs}
    return tuple(n for n in outputs if not felt(rows[n], (n,), kept, [""] * C.shape[1]))


def _check_closed(A: Array, C: Array, states: Names, kept: Names, outputs: Names) -> None:
    n = len(kept)
    faults = felt(A[:n], [f"der({name})" for name in kept], n, states) + felt(C, outputs, n, states)
    if faults:
        raise UsageError("\n".join(f"states: {fault}, which is not among them" for fault in faults))


def _selected(wanted: Names | None, known: Names, what: str) -> tuple[str, ...]:
    if wanted is None:
        return tuple(known)
    if isinstance(wanted, Mapping):
        values = "; values of inputs are `input_values`" if what == "input" else ""
        raise UsageError(f"{what}s: found values by name, expected names{values}")
    if isinstance(wanted, str):
        wanted = [wanted]
    check_names(wanted, known, what)
    return tuple(wanted)
