# SPDX-License-Identifier: BSD-3-Clause
"""Modes of a mechanism about an operating point."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gelenk.errors import OperatingPointWarning, UsageError
from gelenk.linear.linearization import model_at
from gelenk.linear.model import LinearModel, SignalNames
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.modal.body_poses import PoseEvaluator, pose_evaluator
from gelenk.modal.eigenvalues import ROUNDING
from gelenk.modal.mode import Mode, stability_of
from gelenk.modal.shapes import CoordinateRows, coordinate_rows, modes_of, with_body_sensors
from gelenk.modal.table import table
from gelenk.model.scene import Scene, load
from gelenk.model.values import Value
from gelenk.simulation.fmu_file import SCENE, text_in
from gelenk.simulation.inputs import Inputs

if TYPE_CHECKING:
    import control

    from gelenk.viewer.pages import View


@dataclass(frozen=True)
class Modes:
    """All modes of a mechanism about an operating point, slowest first.

    Attributes:
        name: name of the mechanism.
        time: time of the operating point [s].
        modes: one mode for each real eigenvalue, each complex pair, and each Jordan chain of repeated ones.
        stability: "stable": all modes are damped. "marginal": none is unstable, but some are undamped,
            drifting or rigid-body modes, so that the terms neglected by the linear model decide. "unstable":
            some grow.
        decided_by: the mode that determines the stability; None if the mechanism cannot move.
        why: the reason, as a sentence.
        units: units of shape components and states, by name.
    """

    name: str
    time: float
    modes: tuple[Mode, ...]
    stability: Literal["stable", "marginal", "unstable"]
    decided_by: Mode | None
    why: str
    units: Mapping[str, str]
    _evaluator: PoseEvaluator | None = field(default=None, repr=False, compare=False)

    def animate(self, mode: int, file: str | PathLike[str], amplitude: float | None = None) -> Path:
        """Write an animation of a mode shape: one period of oscillation about the operating point, repeated.

        Non-oscillatory modes are also drawn as oscillations; the amplitude neither decays nor grows.

        Args:
            mode: number of the mode, from 1.
            file: file to write: .gif, .html, or .mp4, which requires ffmpeg.
            amplitude: amplitude of the coordinate with the largest motion [rad, m]; by default one that is
                clearly visible.

        Returns:
            Path: the file.

        Raises:
            UsageError: the mode does not exist, there is no scene to draw, Pillow is not installed, the file
                type is not supported, or the loops cannot be closed at this amplitude.
            OSError: the file cannot be written.
        """
        from gelenk.modal.animation import animate

        if not 1 <= mode <= len(self.modes):
            raise UsageError(f"mode: found {mode}, expected a number from 1 to {len(self.modes)}")
        return animate(self._drawn(), self.modes[mode - 1], Path(file), amplitude)

    def view(self, amplitude: float | None = None) -> View:
        """Return a page on which the mechanism moves in a mode that is chosen there, with its amplitude.

        Args:
            amplitude: amplitude of the coordinate with the largest motion [rad, m]; by default one that is
                clearly visible.

        Raises:
            UsageError: there is no scene to draw, no mode has a shape, or the loops cannot be closed at this
                amplitude.
        """
        from gelenk.modal.animation import view_of_modes

        if amplitude is not None and not (np.isfinite(amplitude) and amplitude > 0):
            raise UsageError(f"amplitude: found {amplitude}, expected more than 0")
        return view_of_modes(self._drawn(), self.modes, amplitude)

    def _drawn(self) -> PoseEvaluator:
        if self._evaluator is None:
            raise UsageError(
                "found modes of a linear model, expected modes of a scene or of an FMU exported by Gelenk"
            )
        return self._evaluator

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: complex numbers as [real, imaginary]; old keys as in `Mode.to_dict`."""
        return {
            "name": self.name, "time": self.time, "stability": self.stability, "why": self.why,
            "decided_by": None if self.decided_by is None else self.decided_by.number,
            "modes": [mode.to_dict() for mode in self.modes], "units": dict(self.units),
        }  # fmt: skip

    def __str__(self) -> str:
        title = f"{self.name} at t = {self.time:g} s" if self.name else f"t = {self.time:g} s"
        return table(f"{title}: {self.stability}", self.why, self.modes)

    def __repr__(self) -> str:
        count = f"{len(self.modes)} mode{'' if len(self.modes) == 1 else 's'}"
        return f"<Modes of {self.name} at t = {self.time:g} s: {count}, {self.stability}>"

    def _repr_html_(self) -> str:
        from gelenk.modal.modes_html import modes_html

        title = f"{self.name} at t = {self.time:g} s" if self.name else f"t = {self.time:g} s"
        return modes_html(title, self.stability, self.why, self.modes)


def modes(
    source: Mechanism | OperatingPoint | LinearModel | control.StateSpace,
    *,
    at: At = None,
    input_values: Inputs | None = None,
    states: Sequence[str] | None = None,
    parameters: Mapping[str, Value] | None = None,
    tolerance: float | None = None,
    rounding: float = ROUNDING,
) -> Modes:
    """Compute the modes of a scene, an FMU or a linear model, and its stability.

    Repeated eigenvalues are recognized, with one mode for each of their Jordan chains. See docs/modes.md.

    Args:
        source: a .fmu file, anything `gelenk.load` accepts, a continuous linear model, or an operating point,
            which already contains the arguments `at`, `input_values`, `parameters` and `tolerance`.
        at: the operating point, as for `gelenk.linearize`.
        input_values: inputs at the operating point.
        states: names of coordinates that are states. Eigenvalues depend on the choice only if the point is
            not an equilibrium.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, if `at` is a time.
        rounding: assumed error of the matrix A relative to its norm, from 0 to less than 1. Eigenvalues that
            a perturbation of this size could make coincide are considered equal.

    Returns:
        Modes: the modes, slowest first, and the stability.

    Warns:
        OperatingPointWarning: the point is not an equilibrium; the warning gives the rates of the states.

    Raises:
        SceneError, UsageError, AssemblyError, StepError, OSError: as for `gelenk.linearize`.

    >>> found = gelenk.modes("scenes/cart_pole.yaml", at={"hinge.phi": 0})
    >>> found.stability, found.decided_by.names
    ('unstable', ['hinge.phi'])
    """
    if not 0 <= rounding < 1:
        raise UsageError(f"rounding: found {rounding}, expected a number from 0 to less than 1")
    if isinstance(source, LinearModel) or hasattr(source, "state_labels"):
        _refuse({"at": at, "input_values": input_values, "states": states, "parameters": parameters,
                 "tolerance": tolerance})  # fmt: skip
        return found_in(source if isinstance(source, LinearModel) else _of_control(source), rounding)
    point = OperatingPoint.given(source, at, input_values, parameters, tolerance)
    plant, scene, by_fmu = _opened(point.source)
    point = replace(point, source=plant)
    model = model_at(point, states=states, with_idle=True)
    if model.residual_state_rates:
        warnings.warn(model.residual_state_rates, OperatingPointWarning, stacklevel=2)
    bodies = None if by_fmu or scene is None else with_body_sensors(scene, point, model.states)
    if scene is None:
        return found_in(model, rounding, bodies)
    # A model with fewer states does not determine all joint coordinates.
    complete = model if states is None else model_at(point, with_idle=True)
    settings = {**(point.parameters or {}), **point.values}
    return found_in(model, rounding, bodies, pose_evaluator(scene, settings, complete))


def _refuse(arguments: Mapping[str, Any]) -> None:
    given = ", ".join(name for name, value in arguments.items() if value is not None)
    if given:
        raise UsageError(f"{given}: not allowed with a linear model, which has its operating point already")


def _opened(source: Any) -> tuple[Scene | str, Scene | None, bool]:
    """Return what to linearize, the scene to draw (None if unknown), and whether `source` is an FMU."""
    if not (isinstance(source, str | PathLike) and str(source).lower().endswith(".fmu")):
        scene = load(source).wanted_part()
        return scene, scene, False
    try:
        return str(source), load(text_in(source, SCENE).decode()).wanted_part(), True
    except (UsageError, KeyError, ValueError):  # not exported by Gelenk, or damaged, which model_at reports
        return str(source), None, True


def _of_control(system: Any) -> LinearModel:
    if system.dt not in (0, None):
        raise UsageError(
            f"found a discrete-time model with steps of {system.dt} s, expected a continuous-time model"
        )
    labels = [list(map(str, getattr(system, f"{key}_labels"))) for key in ("state", "input", "output")]
    names = getattr(system, "names", None)
    if not isinstance(names, SignalNames) or [*names.labels().values()] != labels:
        names = SignalNames(*map(tuple, labels))  # of another origin, or changed since
    x, u, y = names.states, names.inputs, names.outputs
    x0, u0, y0 = (np.zeros(len(names)) for names in (x, u, y))
    A, B, C, D = (np.asarray(getattr(system, key), np.float64) for key in "ABCD")
    return LinearModel(str(system.name), 0.0, x, u, y, A, B, C, D, x0, u0, y0, 0 * x0, {})


def found_in(
    model: LinearModel, rounding: float, bodies: LinearModel | None = None, at: PoseEvaluator | None = None
) -> Modes:
    """Return the modes of a linear model.

    Args:
        model: the linear model.
        rounding: assumed error of A relative to its norm.
        bodies: the same model with the frames of all bodies as outputs; None if they are unknown.
        at: evaluator for animations; None if there is no scene.

    Raises:
        UsageError: A contains NaN or infinity.
    """
    if not np.isfinite(model.A).all():
        raise UsageError("A: found NaN or infinity, expected finite entries")
    rows: CoordinateRows = coordinate_rows(model, bodies)
    found = modes_of(model, rows, rounding)
    stability, by, why = stability_of(found)
    units = {**rows.units} | {name: model.units.get(name, "1") for name in model.states}
    return Modes(model.name, model.time, found, stability, by, why, units, at)
