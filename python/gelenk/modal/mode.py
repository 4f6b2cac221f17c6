# SPDX-License-Identifier: BSD-3-Clause
"""Modes of vibration, and the stability that follows from them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gelenk._deprecated import DeprecatedAlias, with_old_keys

Complex = NDArray[np.complex128]

MAX_LISTED = 3  # coordinates or modes in a sentence


@dataclass(frozen=True)
class BodyMotion:
    """The motion of a body in a mode, in the world frame, at the same amplitude as the mode shape.

    Attributes:
        translation: of the origin of the body's frame [m], shape (3,).
        rotation: small rotation [rad], shape (3,).
    """

    translation: Complex
    rotation: Complex


@dataclass(frozen=True)
class Mode:
    """A mode of vibration: a motion proportional to Re(shape exp(eigenvalue t)).

    A complex pair of eigenvalues is one mode.

    Attributes:
        number: number in tables and messages, from 1.
        eigenvalue: eigenvalue [1/s]; of a complex pair the one with positive imaginary part.
        error_bound: bound of the eigenvalue's error due to rounding [1/s].
        multiplicity: algebraic multiplicity of the eigenvalue; modes with the same eigenvalue share it.
        chain_length: length of the Jordan chain. If it is 2 or more, there are also motions that grow as
            t^(chain_length - 1) exp(eigenvalue t).
        grows_in_position_only: whether, for an eigenvalue 0, only coordinates grow on which no velocity
            depends.
        shape: mode shape by coordinate, its largest component is 1; by velocity if no coordinate moves.
        states: eigenvector by state.
        bodies: the same motion by body, for an FMU by frame sensor; empty if unknown.
    """

    number: int
    eigenvalue: complex
    error_bound: float
    multiplicity: int
    chain_length: int
    grows_in_position_only: bool
    shape: Mapping[str, complex]
    states: Mapping[str, complex]
    bodies: Mapping[str, BodyMotion]

    hertz = DeprecatedAlias("frequency_hz")
    frequency = DeprecatedAlias("natural_frequency")
    damping = DeprecatedAlias("damping_ratio")
    swings = DeprecatedAlias("is_oscillatory")
    length = DeprecatedAlias("chain_length")
    coasts = DeprecatedAlias("grows_in_position_only")
    error = DeprecatedAlias("error_bound")

    @property
    def natural_frequency(self) -> float:
        """Undamped natural frequency, the magnitude of the eigenvalue [rad/s]."""
        return abs(self.eigenvalue)

    @property
    def frequency_hz(self) -> float:
        """Undamped natural frequency [Hz]."""
        return self.natural_frequency / (2 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio, from -1 to 1; NaN if the eigenvalue is 0."""
        return 0.0 - self.eigenvalue.real / self.natural_frequency if self.natural_frequency else math.nan

    @property
    def time_constant(self) -> float:
        """Time in which the mode decays or grows by a factor of e [s]; infinite if it does neither."""
        return 1 / abs(self.eigenvalue.real) if self.eigenvalue.real else math.inf

    @property
    def is_oscillatory(self) -> bool:
        """Whether the mode is a complex pair of eigenvalues."""
        return self.eigenvalue.imag > 0

    @property
    def kind(self) -> Literal["damped", "undamped", "rigid-body", "drifting", "unstable"]:
        """The behavior of the mode after a disturbance.

        "damped": decays. "undamped": oscillates with constant amplitude. "rigid-body": remains displaced
        (semisimple eigenvalue 0). "drifting": moves at constant velocity, or only coordinates grow on which
        no velocity depends. "unstable": grows.
        """
        real = self.eigenvalue.real
        if real:
            return "damped" if real < 0 else "unstable"
        if self.is_oscillatory:
            return "undamped" if self.chain_length == 1 else "unstable"
        if self.chain_length == 1:
            return "rigid-body"
        return "drifting" if self.chain_length == 2 or self.grows_in_position_only else "unstable"

    @property
    def names(self) -> list[str]:
        """Names of the coordinates with the largest amplitudes: at most three, at least half the largest."""
        largest = max(map(abs, self.shape.values()), default=0.0)
        moving = sorted(self.shape, key=lambda name: -round(abs(self.shape[name]) / (largest or 1.0), 9))
        return [name for name in moving if abs(self.shape[name]) >= 0.5 * largest][:MAX_LISTED]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: complex numbers as [real, imaginary], None for NaN and infinity.

        For one release, values are also found under the old keys in `gelenk._deprecated.OLD_KEYS`.
        """
        numbers = {
            key: value if math.isfinite(value) else None
            for key in ("error_bound", "natural_frequency", "frequency_hz", "damping_ratio", "time_constant")
            for value in [getattr(self, key)]
        }
        data = {
            "number": self.number, "eigenvalue": _parts(self.eigenvalue), "kind": self.kind, **numbers,
            "multiplicity": self.multiplicity, "chain_length": self.chain_length,
            "grows_in_position_only": self.grows_in_position_only,
            "shape": {name: _parts(x) for name, x in self.shape.items()},
            "states": {name: _parts(x) for name, x in self.states.items()},
            "bodies": {
                name: {key: [_parts(x) for x in getattr(motion, key)] for key in ("translation", "rotation")}
                for name, motion in self.bodies.items()
            },
        }  # fmt: skip
        return with_old_keys(data)


def stability_of(modes: Sequence[Mode]) -> tuple[Literal["stable", "marginal", "unstable"], Mode | None, str]:
    """Return the stability that follows from all modes, the mode that determines it, and the reason.

    A drifting mode is marginal: velocities do not grow, and nothing depends on the coordinates that do.
    """
    growing = [mode for mode in modes if mode.kind == "unstable"]
    if growing:
        worst = max(growing, key=lambda mode: (mode.eigenvalue.real, mode.chain_length))
        return "unstable", worst, f"mode {worst.number} {_growth(worst)}"
    persistent = [mode for mode in modes if mode.kind != "damped"]
    if persistent:
        first = max(persistent, key=lambda mode: (mode.kind == "drifting", mode.kind == "undamped"))
        others = [mode for mode in persistent if mode is not first]
        reasons = "; ".join(
            f"mode {mode.number} {_persistence(mode)}" for mode in [first, *others][:MAX_LISTED]
        )
        left = len(persistent) - MAX_LISTED
        more = f"; and {left} more that are not damped" if left > 0 else ""
        return "marginal", first, f"no mode is unstable, but {reasons}{more}"
    if not modes:
        return "stable", None, "the mechanism cannot move"
    slowest = min(modes, key=lambda mode: -mode.eigenvalue.real)
    return (
        "stable",
        slowest,
        f"all modes are damped; mode {slowest.number}, the slowest, has a time constant of "
        f"{slowest.time_constant:.4g} s ({_coordinates(slowest)})",
    )


def _growth(mode: Mode) -> str:
    coordinates = _coordinates(mode)
    if mode.eigenvalue.real:
        how = f"oscillates at {mode.eigenvalue.imag:.4g} rad/s and grows" if mode.is_oscillatory else "grows"
        return f"{how} by a factor of e in {mode.time_constant:.4g} s ({coordinates})"
    power = mode.chain_length - 1
    law = "t" if power == 1 else f"t^{power}"
    frequency = f", oscillating at {mode.eigenvalue.imag:.4g} rad/s" if mode.is_oscillatory else ""
    multiplicity = f"{mode.chain_length} equal eigenvalues share one mode shape"
    return f"grows as {law}{frequency} ({coordinates}): {multiplicity}"


def _persistence(mode: Mode) -> str:
    coordinates, plural = _coordinates(mode), len(mode.names) != 1
    if mode.kind == "drifting":
        how = "at constant velocity" if mode.chain_length == 2 else f"as t^{mode.chain_length - 1}"
        return f"drifts: {coordinates} {'continue' if plural else 'continues'} {how} after a push"
    if mode.kind == "undamped":
        return f"is undamped at {mode.natural_frequency:.4g} rad/s ({coordinates})"
    return f"is a rigid-body mode: {coordinates} {'remain' if plural else 'remains'} displaced"


def _coordinates(mode: Mode) -> str:
    return ", ".join(mode.names)


def _parts(x: complex) -> list[float]:
    return [float(x.real), float(x.imag)]
