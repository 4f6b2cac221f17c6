# SPDX-License-Identifier: BSD-3-Clause
"""Modes: what they are, in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

MOST_NAMED = 3  # coordinates or modes in a sentence


@dataclass(frozen=True)
class BodyMotion:
    """Of a body in a mode, along the world's axes, for the same amplitude as the mode's shape.

    Attributes:
        translation: of the origin of the body's frame [m], shape (3,).
        rotation: small turn [rad], shape (3,).
    """

    translation: Complex
    rotation: Complex


@dataclass(frozen=True)
class Mode:
    """Motion in proportion to Re(shape exp(eigenvalue t)); of a pair of eigenvalues there is one mode.

    Attributes:
        number: in tables and sentences, from 1.
        eigenvalue: [1/s], of a pair the one with the positive imaginary part.
        error: that the eigenvalue may have [1/s], by the rounding that is reckoned with.
        multiplicity: how many eigenvalues of the matrix this one stands for, other modes' included.
        length: of its Jordan chain: from 2 on there are motions t^(length - 1) exp(eigenvalue t), too.
        coasts: whether what grows beside the eigenvalue are coordinates alone that no speed depends on.
        shape: by coordinate, the largest 1; of modes without coordinates by speed.
        states: the eigenvector by state.
        bodies: the same motion by body, or by frame sensor of an FMU; empty where these are not known.
    """

    number: int
    eigenvalue: complex
    error: float
    multiplicity: int
    length: int
    coasts: bool
    shape: Mapping[str, complex]
    states: Mapping[str, complex]
    bodies: Mapping[str, BodyMotion]

    @property
    def frequency(self) -> float:
        """Undamped natural frequency, the eigenvalue's magnitude [rad/s]."""
        return abs(self.eigenvalue)

    @property
    def hertz(self) -> float:
        """Undamped natural frequency [Hz]."""
        return self.frequency / (2 * math.pi)

    @property
    def damping(self) -> float:
        """Damping ratio, from -1 to 1; not a number where the eigenvalue is 0."""
        return 0.0 - self.eigenvalue.real / self.frequency if self.frequency else math.nan

    @property
    def time_constant(self) -> float:
        """In which it decays, or grows, by e [s]; infinite where it does neither."""
        return 1 / abs(self.eigenvalue.real) if self.eigenvalue.real else math.inf

    @property
    def swings(self) -> bool:
        """Whether there is a pair of eigenvalues."""
        return self.eigenvalue.imag > 0

    @property
    def kind(self) -> Literal["decays", "swings on", "stays", "drifts", "grows"]:
        """What becomes of it: "drifts" is a steady speed, or coordinates alone that run on faster."""
        real = self.eigenvalue.real
        if real:
            return "decays" if real < 0 else "grows"
        if self.swings:
            return "swings on" if self.length == 1 else "grows"
        if self.length == 1:
            return "stays"
        return "drifts" if self.length == 2 or self.coasts else "grows"

    @property
    def names(self) -> list[str]:
        """Of what moves most."""
        most = max(map(abs, self.shape.values()), default=0.0)
        moving = sorted(self.shape, key=lambda name: -round(abs(self.shape[name]) / (most or 1.0), 9))
        return [name for name in moving if abs(self.shape[name]) >= 0.5 * most][:MOST_NAMED]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON: complex numbers as [real, imaginary], None for what is not finite."""
        numbers = {
            key: value if math.isfinite(value) else None
            for key in ("error", "frequency", "hertz", "damping", "time_constant")
            for value in [getattr(self, key)]
        }
        return {
            "number": self.number, "eigenvalue": _parts(self.eigenvalue), "kind": self.kind, **numbers,
            "multiplicity": self.multiplicity, "length": self.length, "coasts": self.coasts,
            "shape": {name: _parts(x) for name, x in self.shape.items()},
            "states": {name: _parts(x) for name, x in self.states.items()},
            "bodies": {
                name: {key: [_parts(x) for x in getattr(motion, key)] for key in ("translation", "rotation")}
                for name, motion in self.bodies.items()
            },
        }  # fmt: skip


def verdict(modes: Sequence[Mode]) -> tuple[Literal["stable", "marginal", "unstable"], Mode | None, str]:
    """Of all modes together: the word, the mode that decides, and why.

    What drifts is marginal: speeds do not grow, and nothing is felt of how far it has gone.
    """
    growing = [mode for mode in modes if mode.kind == "grows"]
    if growing:
        worst = max(growing, key=lambda mode: (mode.eigenvalue.real, mode.length))
        return "unstable", worst, f"mode {worst.number} {_growth(worst)}"
    staying = [mode for mode in modes if mode.kind != "decays"]
    if staying:
        first = max(staying, key=lambda mode: (mode.kind == "drifts", mode.kind == "swings on"))
        others = [mode for mode in staying if mode is not first]
        told = "; ".join(f"mode {mode.number} {_rest(mode)}" for mode in [first, *others][:MOST_NAMED])
        left = len(staying) - MOST_NAMED
        more = f"; and {left} more that do not decay" if left > 0 else ""
        return "marginal", first, f"nothing grows, but {told}{more}"
    if not modes:
        return "stable", None, "nothing moves"
    last = min(modes, key=lambda mode: -mode.eigenvalue.real)
    constant = f"{last.time_constant:.4g} s"
    return (
        "stable",
        last,
        f"all modes decay, mode {last.number} as the last, by e in {constant} ({_who(last)})",
    )


def _growth(mode: Mode) -> str:
    if mode.eigenvalue.real:
        swinging = f" and swings at {mode.eigenvalue.imag:.4g} rad/s" if mode.swings else ""
        return f"grows by e in {mode.time_constant:.4g} s{swinging} ({_who(mode)})"
    power = mode.length - 1
    speed = "t" if power == 1 else f"t^{power}"
    swinging = f", swinging at {mode.eigenvalue.imag:.4g} rad/s" if mode.swings else ""
    return f"grows as {speed}{swinging} ({_who(mode)}): {mode.length} equal eigenvalues share one shape"


def _rest(mode: Mode) -> str:
    if mode.kind == "drifts":
        how = "steadily" if mode.length == 2 else f"as t^{mode.length - 1}"
        return f"drifts: {_who(mode)} {'goes' if len(mode.names) == 1 else 'go'} on {how} once pushed"
    if mode.kind == "swings on":
        return f"swings on undamped at {mode.frequency:.4g} rad/s ({_who(mode)})"
    return f"stays: {_who(mode)} {'is' if len(mode.names) == 1 else 'are'} left wherever put"


def _who(mode: Mode) -> str:
    return ", ".join(mode.names)


def _parts(x: complex) -> list[float]:
    return [float(x.real), float(x.imag)]
