# SPDX-License-Identifier: BSD-3-Clause
"""A linear model: matrices with names, and the point they belong to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.scales import Scales

if TYPE_CHECKING:
    import control

type Array = NDArray[np.float64]

COORDINATES = ("rad", "m")

STANDS = _core.equilibrium_rate_tolerance  # of a state in own units: above it the point is told to be no equilibrium
ROUNDED = _core.equilibrium_rounding_tolerance  # of the terms a rate is the sum of


@dataclass(frozen=True)
class LinearModel:
    """dx/dt = rates + A (x - x0) + B (u - u0), y = y0 + C (x - x0) + D (u - u0), near a point.

    Attributes:
        name: of the mechanism.
        time: of the point [s].
        states: names of x.
        inputs: names of u.
        outputs: names of y.
        A: shape (states, states).
        B: shape (states, inputs).
        C: shape (outputs, states).
        D: shape (outputs, inputs).
        x0: the states at the point; a rotation coordinate `J.theta[i]` is 0 there.
        u0: the inputs at the point.
        y0: the outputs at the point.
        rates: of the states at the point; all 0 at an equilibrium.
        units: of states, inputs and outputs, by name.
        scales: of the mechanism; what is small is so in these units.
    """

    name: str
    time: float
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Array
    B: Array
    C: Array
    D: Array
    x0: Array
    u0: Array
    y0: Array
    rates: Array
    units: Mapping[str, str]
    scales: Scales = field(default_factory=Scales)

    def to_control(self) -> control.StateSpace:
        """For python-control. Its inputs and outputs may have no dots in their names: they are `_` there.

        Raises:
            UsageError: python-control is not installed, or two names are one without their dots.
        """
        try:
            import control
        except ImportError as e:
            raise UsageError(f"python-control, which linear models are made for, is missing: {e}") from None
        inputs, outputs = _without_dots(self.inputs, "inputs"), _without_dots(self.outputs, "outputs")
        # python-control takes a matrix of shape (1, 0) for one of shape (0, 0): without inputs the model is
        # made with one that does nothing, which is then taken away.
        B, D = (M if inputs else np.zeros((len(M), 1)) for M in (self.B, self.D))
        out = control.StateSpace(
            self.A, B, self.C, D, name=self.name.replace(".", "_") or None, dt=0,
            states=list(self.states), inputs=inputs or 1, outputs=outputs, remove_useless_states=False,
        )  # fmt: skip
        if not inputs:
            out.B, out.D = self.B.copy(), self.D.copy()
            out.set_inputs(inputs)
        return out

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON: matrices row by row."""
        lists = {key: getattr(self, key).tolist() for key in ("A", "B", "C", "D", "x0", "u0", "y0", "rates")}
        names = {key: list(getattr(self, key)) for key in ("states", "inputs", "outputs")}
        units = {name: self.units[name] for key in names for name in names[key]}
        return {"name": self.name, "time": self.time, **names, "units": units, **lists}

    @property
    def unrest(self) -> str:
        """Why the point is no equilibrium, in words that name each state and its rate; empty if it is one.

        Coordinates that go on steadily count where a rate or another output changes by it.
        """
        return self._told(self._moving(self.C))

    @property
    def unrest_of_states(self) -> str:
        """The same without a look at outputs."""
        return self._told(self._moving(self.C[:0]))

    def _moving(self, C: Array) -> list[int]:
        """States that change, and not steadily or felt by others than the output of that name."""
        x, y = self._sizes(self.states), self._sizes(self.outputs)
        rates, A, C = self.rates / x * self.scales.time, self.A * x / x[:, None], C * x / y[: len(C), None]
        A *= self.scales.time
        speeds = np.array([self.units.get(name) not in COORDINATES for name in self.states], bool)
        bounds = standing(A, 1 + speeds * np.abs(self.x0 / x))
        moving = [int(i) for i in np.flatnonzero(np.abs(rates) > bounds)]
        own = {self.states[i] for i in moving}
        others = [k for k in range(len(C)) if self.outputs[k] not in own]
        felt = [M for M in (A, C[others]) if _felt(M @ rates, np.abs(M) @ np.abs(rates))]
        named = [i for i in moving if any(_felt(M[:, i], np.abs(M).max(axis=1)) for M in felt)]
        unsteady = [i for i in moving if _felt(A[i] @ rates, np.abs(A[i]) @ np.abs(rates))]
        return sorted({*named, *unsteady})

    def _sizes(self, names: Sequence[str]) -> Array:
        return self.scales.sizes([self.units.get(name, "1") for name in names])

    def _told(self, moving: Sequence[int]) -> str:
        if not moving:
            return ""
        told = ", ".join(
            f"{self.states[i]} changes at {self.rates[i]:.6g} {_per_second(self.units[self.states[i]])}"
            for i in moving[:6]
        ) + (f" and {len(moving) - 6} more" if len(moving) > 6 else "")
        return f"t = {self.time:g} s is no equilibrium in these states: {told}"

    def __str__(self) -> str:
        return _shown(self)


def standing(A: Array, sizes: Array) -> Array:
    """Up to which rates nothing moves. A: their slopes by states of these sizes; all in own units."""
    bounds: Array = STANDS + ROUNDED * (np.abs(A) @ sizes)
    return bounds


def _felt(found: Any, size: Any) -> bool:
    """Whether any of these is more than rounding of terms of this size."""
    return bool((np.abs(found) > STANDS + 1e-12 * size).any())


def _without_dots(names: Sequence[str], what: str) -> list[str]:
    out = [name.replace(".", "_") for name in names]
    same = [name for name, short in zip(names, out, strict=True) if out.count(short) > 1]
    if same:
        raise UsageError(
            f"{what}: python-control knows no dots, and without them {', '.join(same)} are one name"
        )
    return out


def _per_second(unit: str) -> str:
    return {"rad": "rad/s", "m": "m/s", "rad/s": "rad/s2", "m/s": "m/s2"}.get(unit, f"{unit} per second")


def _shown(model: LinearModel) -> str:
    """The point, then A, B, C and D with the names of their rows and columns."""
    point = f"{model.name} at t = {model.time:g} s: {_count(len(model.states), 'state')}, "
    point += f"{_count(len(model.inputs), 'input')}, {_count(len(model.outputs), 'output')}"
    groups = (("states", model.states, model.x0), ("inputs", model.inputs, model.u0))
    parts = [point, *(_values(model, title, names, values) for title, names, values in groups if names)]
    x, u, y = model.states, model.inputs, model.outputs
    derivatives = [f"der({name})" for name in x]
    for title, matrix, rows, columns in (
        ("A", model.A, derivatives, x),
        ("B", model.B, derivatives, u),
        ("C", model.C, y, x),
        ("D", model.D, y, u),
    ):
        parts.append(_matrix(title, matrix, rows, columns))
    return "\n\n".join(part for part in parts if part)


def _values(model: LinearModel, title: str, names: Sequence[str], values: Array) -> str:
    width = max(map(len, names))
    lines = []
    for name, value in zip(names, values, strict=True):
        unit = model.units[name]
        lines.append(f"  {name:{width}}  {value + 0.0:12.6g}{'' if unit in ('', '1') else '  ' + unit}")
    return "\n".join([f"{title} at the point", *lines])


def _matrix(title: str, matrix: NDArray[np.float64], rows: Sequence[str], columns: Sequence[str]) -> str:
    if not matrix.size:
        return ""
    first = max(len(title), *map(len, rows))
    widths = [max(12, len(name)) for name in columns]
    lines = [f"{title:{first}}  " + "  ".join(f"{n:>{w}}" for n, w in zip(columns, widths, strict=True))]
    for name, row in zip(rows, matrix, strict=True):
        cells = "  ".join(f"{value + 0.0:{w}.6g}" for value, w in zip(row, widths, strict=True))
        lines.append(f"{name:{first}}  {cells}")
    return "\n".join(lines)


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"
