# SPDX-License-Identifier: BSD-3-Clause
"""The linear model of a mechanism about a point of its motion."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from gelenk.derivatives import Array, Derivatives, Minimal, chosen_states
from gelenk.errors import GelenkError, OperatingPointWarning, UsageError
from gelenk.inputs import Inputs, Signal, functions_and_constants, is_motion, set_inputs
from gelenk.linear import LinearModel
from gelenk.plant import Plant
from gelenk.run import configure, expanded, grid, open_plant
from gelenk.scene import Scene, Value, number, unknown
from gelenk.state_basis import completed, felt, transformed

if TYPE_CHECKING:
    import control

type Names = Sequence[str]


def linearize(
    source: Scene | str | PathLike[str] | Mapping[str, Any],
    *,
    at: float | Mapping[str, Value] | None = None,
    input_values: Inputs | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
    parameters: Mapping[str, Value] | None = None,
    tolerance: float | None = None,
) -> control.StateSpace:
    """The linear model of a scene, or of an FMU by its directional derivatives alone, for python-control.

    Exact, without difference quotients; by as many states as the mechanism has. See `linear_model`, whose
    numbers these are, for the point itself (x0, u0, y0), and docs/linearization.md.

    Args:
        source: a .fmu file, or whatever `gelenk.load` takes.
        at: the point: None, the start values; a time [s], where the motion from the start values under
            `input_values` gets to; or values by name, on top of the start values: a joint's state
            ("hinge.phi", attained exactly), a parameter ("hinge.phi_start", "pole.m"), an input.
        input_values: see `gelenk.inputs.functions`; inputs that are not named are 0.
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
    model = linear_model(
        source, at=at, input_values=input_values, inputs=inputs, outputs=outputs, states=states,
        parameters=parameters, tolerance=tolerance,
    )  # fmt: skip
    if model.unrest:
        warnings.warn(model.unrest, OperatingPointWarning, stacklevel=2)
    return model.to_control()


def linear_model(
    source: Scene | str | PathLike[str] | Mapping[str, Any],
    *,
    at: float | Mapping[str, Value] | None = None,
    input_values: Inputs | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    states: Names | None = None,
    parameters: Mapping[str, Value] | None = None,
    tolerance: float | None = None,
) -> LinearModel:
    """The same as `linearize`, as matrices with the point they belong to; warns of nothing."""
    plant = open_plant(source, (), whole=outputs is not None)
    try:
        settings, exact, signals = point_given(plant, at, parameters, input_values)
        configure(plant, settings, tolerance, {})
        plant.start(tolerance, {name: signal(0.0) for name, signal in signals.items()})
        time = time_given(at)
        go_on(plant, time, signals)
        found = plant.derivatives(states or ())
    finally:
        plant.close()
    _check_attained(found, exact)
    return _assembled(plant.name, time, found, inputs, outputs, states)


def point_given(
    plant: Plant,
    at: float | Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    input_values: Inputs | None,
) -> tuple[dict[str, Value], dict[str, float], dict[str, Signal]]:
    """Parameters to set before the start, states that have to be so afterwards, inputs by time."""
    settings, exact = _settings(plant, at if isinstance(at, Mapping) else {}, parameters or {})
    twice = "twice, as an input and as part of the point"
    return (
        settings,
        exact,
        functions_and_constants(input_values, settings, [*plant.inputs, *plant.idle], twice),
    )


def start_parameter(name: str) -> str:
    """Of a joint's coordinate or speed: A.phi_start, F.r_start[1]."""
    return name.replace("[", "_start[", 1) if "[" in name else f"{name}_start"


def time_given(at: float | Mapping[str, Value] | None) -> float:
    """Of the point [s]. Raises UsageError."""
    if at is None or isinstance(at, Mapping):
        return 0.0
    time = number("at", at, "real")
    if time < 0:
        raise UsageError(f"at: found {time:g} s, expected 0 or more")
    return time


def _settings(
    plant: Plant, at: Mapping[str, Value], parameters: Mapping[str, Value]
) -> tuple[dict[str, Value], dict[str, float]]:
    """What to set before the start, and what of it has to be so afterwards."""
    known = [*plant.parameters, *plant.inputs, *plant.idle]
    settings = dict(parameters)
    exact = {}
    faults = []
    for name, value in at.items():
        start = start_parameter(name)
        place = start if name not in known and start in known else name
        if place not in known:
            faults.append(unknown(name, "state, parameter or input", [*plant.outputs, *known]))
        elif place in settings:
            faults.append(f"{name}: given twice, as a parameter and as part of the point")
        else:
            settings[place] = value
            if place != name:
                exact[name] = number(name, value, "real")
    if faults:
        raise UsageError("\n".join(faults))
    return settings, exact


def go_on(plant: Plant, time: float, signals: Mapping[str, Any]) -> None:
    """Runs as `gelenk.simulate` does, and leaves the inputs at what they are at the end."""
    if time == 0:
        return
    times = grid(time, plant.step).tolist()
    for start, end in itertools.pairwise(times):
        set_inputs(plant, signals, start, end)
        plant.advance(start, end)
    for name, signal in signals.items():
        if not is_motion(name):  # these are where the run has followed them to
            plant.set_input(name, signal(time))


def _check_attained(found: Derivatives, exact: Mapping[str, float]) -> None:
    faults = [
        f"{name}: the loops are closed at {found.values[name]:.9g} instead of {value:.9g}, "
        f"which was a guess: {name.rpartition('.')[0]}.fixed is not set"
        for name, value in exact.items()
        if not math.isclose(found.values[name], value, rel_tol=1e-9, abs_tol=1e-9 * found.size(name))
    ]
    if faults:
        raise UsageError("\n".join(faults))


def _assembled(
    name: str,
    time: float,
    found: Derivatives,
    inputs: Names | None,
    outputs: Names | None,
    states: Names | None,
) -> LinearModel:
    chosen_inputs = _selected(inputs, found.inputs, "input")
    named = None if outputs is None else expanded(outputs, found.outputs)
    chosen_outputs = _selected(named, found.outputs, "output")
    minimal = Minimal(found.in_own_units())
    x = chosen_states(minimal, states)
    check_whole(minimal)
    whole = completed(minimal, x)
    by_x, C = transformed(minimal, whole, time)
    rates = [minimal.rate(state) for state in x]
    by_u = np.array([row for _, row, _ in rates]).reshape(len(x), len(found.inputs))
    if len(x) < len(whole):
        if outputs is None:
            chosen_outputs = _determined(C, found.readings, chosen_outputs, len(x))
        _check_closed(by_x, C[[found.readings.index(n) for n in chosen_outputs]], whole, x, chosen_outputs)
        by_x, C = by_x[: len(x), : len(x)], C[:, : len(x)]
    u = [found.inputs.index(n) for n in chosen_inputs]
    y = [found.readings.index(n) for n in chosen_outputs]
    signals = (*chosen_inputs, *chosen_outputs)
    units = {n: found.units.get(n, "1") for n in signals} | {n: minimal.unit(n) for n in x}
    sizes = [found.scales.sizes([units[n] for n in names]) for names in (x, chosen_inputs, chosen_outputs)]
    x_size, u_size, y_size = sizes
    rate_size = x_size / found.scales.time
    return LinearModel(
        name, time, tuple(x), chosen_inputs, chosen_outputs,
        by_x * rate_size[:, None] / x_size, by_u[:, u] * rate_size[:, None] / u_size,
        C[y] * y_size[:, None] / x_size, found.D[np.ix_(y, u)],
        np.array([minimal.value(n) for n in x]) * x_size,
        np.array([found.values[n] for n in chosen_inputs]),
        np.array([found.values[n] for n in chosen_outputs]),
        np.array([rate for _, _, rate in rates]) * rate_size, units, found.scales,
    )  # fmt: skip


def _determined(C: Array, readings: Names, outputs: Names, kept: int) -> tuple[str, ...]:
    """Those outputs that do not change with states behind the first `kept`."""
    rows = {name: C[[readings.index(name)]] for name in outputs}
    return tuple(n for n in outputs if not felt(rows[n], (n,), kept, [""] * C.shape[1]))


def _check_closed(A: Array, C: Array, states: Names, kept: Names, outputs: Names) -> None:
    n = len(kept)
    faults = felt(A[:n], [f"der({name})" for name in kept], n, states) + felt(C, outputs, n, states)
    if faults:
        raise UsageError("\n".join(f"states: {fault}, which is not among them" for fault in faults))


def check_whole(minimal: Minimal) -> None:
    """All that moves has to move by the states."""
    found = minimal.of
    names, joints = ", ".join(minimal.names), ", ".join(minimal.part_free)
    sentence = (
        f"a joint with a quaternion turns in part freely{f' ({joints})' if joints else ''} and can give no "
        f"states; the others, {names}, do not tell all of the motion"
    )
    if found.order is not None:
        if len(minimal.names) != found.order:
            raise GelenkError(
                f"{sentence}: they are {len(minimal.names)} of {found.order}. A loop that is cut at this "
                "joint needs no states of it: list it behind the loop's other joints, or leave the "
                "reduction cut_choice on"
            )
        return
    # Other FMUs do not tell how many it takes. But what is read moves as the states let it: dy/dt = C dx/dt.
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    for i, name in enumerate(found.readings):
        speed = found.rates.get(name)
        if speed is None:
            continue
        terms = minimal.C[i] * rates
        scale = 1 + np.abs(terms).sum() + abs(found.values[speed])
        if abs(terms.sum() - found.values[speed]) > 1e-4 * scale:  # loops held by a penalty may gape a little
            raise GelenkError(f"{sentence}: {name} moves otherwise")


def _selected(wanted: Names | None, known: Names, what: str) -> tuple[str, ...]:
    if wanted is None:
        return tuple(known)
    if isinstance(wanted, str):
        wanted = [wanted]
    faults = [unknown(name, what, known) for name in wanted if name not in known]
    faults += [f"{name}: asked for twice" for name in dict.fromkeys(wanted) if list(wanted).count(name) > 1]
    if faults:
        raise UsageError("\n".join(faults))
    return tuple(wanted)
