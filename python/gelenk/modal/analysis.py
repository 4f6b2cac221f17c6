# SPDX-License-Identifier: BSD-3-Clause
"""Modes of a mechanism about a point of its motion."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gelenk.errors import OperatingPointWarning, UsageError
from gelenk.linear.linearization import model_at
from gelenk.linear.model import LinearModel
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.modal.mode import Mode, verdict
from gelenk.modal.posing import Posed, posed
from gelenk.modal.shapes import Rows, rows_of, shaped, watched
from gelenk.modal.spectrum import ROUNDING
from gelenk.modal.table import table
from gelenk.model.scene import Scene, load
from gelenk.model.values import Value
from gelenk.simulation.inputs import Inputs

if TYPE_CHECKING:
    import control


SCENE = "resources/scene.json"  # in an FMU of Gelenk


@dataclass(frozen=True)
class Modes:
    """All modes of a mechanism near a point, slow ones first.

    Attributes:
        name: of the mechanism.
        time: of the point [s].
        modes: one for each real eigenvalue, for each pair, and for each Jordan chain of repeated ones.
        stability: "stable": all decay; "marginal": none grows, some stay, drift or swing on for ever, and
            what the linear model leaves out decides; "unstable": some grow.
        decided_by: the mode that makes it so; None where nothing moves.
        why: the same as a sentence.
        units: of shapes and states.
    """

    name: str
    time: float
    modes: tuple[Mode, ...]
    stability: Literal["stable", "marginal", "unstable"]
    decided_by: Mode | None
    why: str
    units: Mapping[str, str]
    _posed: Posed | None = field(default=None, repr=False, compare=False)

    def animate(self, mode: int, file: str | PathLike[str], amplitude: float | None = None) -> Path:
        """Draws a mode's shape, swinging about the point: one period, again and again.

        A shape that only decays or grows swings, too, so that it can be seen; no amplitude dies away.

        Args:
            mode: its number.
            file: .gif, .html, or .mp4, which takes ffmpeg.
            amplitude: of the coordinate that moves most [rad, m]; by default as much as is seen well.

        Returns:
            Path: the file.

        Raises:
            UsageError: no such mode, no scene to draw, no matplotlib, another kind of file; or loops that do
                not close at this amplitude.
            OSError: the file cannot be written.
        """
        from gelenk.modal.animation import animate

        if not 1 <= mode <= len(self.modes):
            raise UsageError(f"mode: found {mode}, expected a number from 1 to {len(self.modes)}")
        if self._posed is None:
            raise UsageError("found a linear model alone, expected modes of a scene or of an FMU of Gelenk")
        return animate(self._posed, self.modes[mode - 1], Path(file), amplitude)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON: complex numbers as [real, imaginary]."""
        return {
            "name": self.name, "time": self.time, "stability": self.stability, "why": self.why,
            "decided_by": None if self.decided_by is None else self.decided_by.number,
            "modes": [mode.to_dict() for mode in self.modes], "units": dict(self.units),
        }  # fmt: skip

    def __str__(self) -> str:
        title = f"{self.name} at t = {self.time:g} s" if self.name else f"t = {self.time:g} s"
        return table(f"{title}: {self.stability}", self.why, self.modes)


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
    """Eigenvalues, frequencies, damping and shapes of a scene, an FMU or a linear model, and its stability.

    Repeated eigenvalues are found as such, with as many modes as they have shapes; where those are too few,
    with the lengths of their Jordan chains. See docs/modes.md.

    Args:
        source: a .fmu file, whatever `gelenk.load` takes, an operating point, in which the arguments of these
            names stand already, or a continuous linear model.
        at: the point, as for `gelenk.linearize`.
        input_values: inputs at the point.
        states: coordinates to be states. Eigenvalues depend on them only where the point is no equilibrium.
        parameters: values by FMU parameter name.
        tolerance: relative tolerance of the integrator, where `at` is a time.
        rounding: error of the matrix A that is reckoned with, relative to its norm: eigenvalues that it could
            make one are one.

    Warns:
        OperatingPointWarning: the point is no equilibrium; names each state that changes, and its rate.

    Raises:
        SceneError, UsageError, AssemblyError, StepError, OSError: as `gelenk.linearize`.

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
    model = model_at(point, states=states)
    if model.unrest_of_states:
        warnings.warn(model.unrest_of_states, OperatingPointWarning, stacklevel=2)
    bodies = None if by_fmu or scene is None else watched(scene, point, model.states)
    if scene is None:
        return found_in(model, rounding, bodies)
    # Of fewer states than all not every joint's place is told.
    everything = model if states is None else model_at(point)
    settings = {**(point.parameters or {}), **point.values}
    return found_in(model, rounding, bodies, posed(scene, settings, everything))


def _refuse(arguments: Mapping[str, Any]) -> None:
    given = ", ".join(name for name, value in arguments.items() if value is not None)
    if given:
        raise UsageError(f"{given}: of no use with a linear model, whose point is settled")


def _opened(source: Any) -> tuple[Scene | str, Scene | None, bool]:
    """What is to be linearised, the scene to draw, and whether it is an FMU's."""
    if not (isinstance(source, str | PathLike) and str(source).lower().endswith(".fmu")):
        scene = load(source).wanted_part()
        return scene, scene, False
    try:
        with zipfile.ZipFile(source) as archive:
            return str(source), load(archive.read(SCENE).decode()).wanted_part(), True
    except (zipfile.BadZipFile, KeyError):  # model_at says what is the matter; or no FMU of Gelenk
        return str(source), None, True


def _of_control(system: Any) -> LinearModel:
    if system.dt not in (0, None):
        raise UsageError(f"found a model in time steps of {system.dt} s, expected a continuous one")
    x, u, y = (tuple(map(str, getattr(system, f"{key}_labels"))) for key in ("state", "input", "output"))
    x0, u0, y0 = (np.zeros(len(names)) for names in (x, u, y))
    A, B, C, D = (np.asarray(getattr(system, key), np.float64) for key in "ABCD")
    return LinearModel(str(system.name), 0.0, x, u, y, A, B, C, D, x0, u0, y0, 0 * x0, {})


def found_in(
    model: LinearModel, rounding: float, bodies: LinearModel | None = None, at: Posed | None = None
) -> Modes:
    """Modes of a linear model; bodies: the same with frame sensors on all bodies."""
    if not np.isfinite(model.A).all():
        raise UsageError("A: found a number that is not finite")
    rows: Rows = rows_of(model, bodies)
    found = shaped(model, rows, rounding)
    stability, by, why = verdict(found)
    units = {**rows.units} | {name: model.units.get(name, "1") for name in model.states}
    return Modes(model.name, model.time, found, stability, by, why, units, at)
