# SPDX-License-Identifier: BSD-3-Clause
"""Linear models: matrices with names and an operating point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk._deprecated import DeprecatedAlias
from gelenk.errors import UsageError
from gelenk.model.scales import Scales

if TYPE_CHECKING:
    import control

type Array = NDArray[np.float64]

COORDINATE_UNITS = ("rad", "m")

# The largest rate of a state at an equilibrium, in the mechanism's own units; and relative to the magnitude
# of the terms of the rate, which cancel only to rounding.
EQUILIBRIUM_RATE_TOLERANCE = _core.equilibrium_rate_tolerance
EQUILIBRIUM_ROUNDING_TOLERANCE = _core.equilibrium_rounding_tolerance
CANCELLATION_TOLERANCE = 1e-12  # of a sum relative to its terms: rounding errors


@dataclass(frozen=True)
class SignalNames:
    """The names that the scene and the FMU have for the signals of a system of python-control, in its order.

    python-control allows no dots in names of inputs and outputs, so that all its labels have `_` for `.`.

    Attributes:
        states: names of the states: "hinge.phi", where `state_labels` has "hinge_phi".
        inputs: names of the inputs.
        outputs: names of the outputs.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def labels(self) -> dict[str, list[str]]:
        """Return the labels in python-control, as the arguments `states`, `inputs` and `outputs` of systems.

        Raises:
            UsageError: two names are equal without their dots.
        """
        return {key: without_dots(names, key) for key, names in vars(self).items()}


@dataclass(frozen=True)
class LinearModel:
    """A linear model dx/dt = rates + A (x - x0) + B (u - u0), y = y0 + C (x - x0) + D (u - u0), in SI units.

    Attributes:
        name: name of the mechanism.
        time: time of the operating point [s].
        states: names of the states x.
        inputs: names of the inputs u.
        outputs: names of the outputs y.
        A: derivatives of the rates with respect to the states, shape (states, states).
        B: derivatives of the rates with respect to the inputs, shape (states, inputs).
        C: derivatives of the outputs with respect to the states, shape (outputs, states).
        D: derivatives of the outputs with respect to the inputs, shape (outputs, inputs).
        x0: states at the operating point; a rotation coordinate `J.theta[i]` is 0 there.
        u0: inputs at the operating point.
        y0: outputs at the operating point.
        rates: rates of the states at the operating point; 0 at an equilibrium.
        units: units of states, inputs and outputs, by name.
        scales: the mechanism's own units, in which tolerances apply.
        friction: what joints with dry friction do: "present", "locked", "sliding" or "off".
        left_out: states of joints that spin idly, which are none of the model: nothing depends on them.
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
    friction: str = "present"
    left_out: tuple[str, ...] = ()

    unrest = DeprecatedAlias("residual_rates")
    unrest_of_states = DeprecatedAlias("residual_state_rates")

    @property
    def idle_rotations(self) -> str:
        """A sentence about the states that are left out; empty if there are none."""
        if not self.left_out:
            return ""
        return (
            f"left out: {', '.join(self.left_out)}, an idle rotation on which nothing depends; "
            "name states or outputs to include it"
        )

    def to_control(self) -> control.StateSpace:
        """Return the model as a `StateSpace` of python-control.

        Its labels of states, inputs and outputs have `_` for `.`, because python-control does not allow dots
        in those of inputs and outputs; its attribute `names` has the names with dots.

        Raises:
            UsageError: python-control is not installed, or two names are equal without their dots.
        """
        try:
            import control
        except ImportError as e:
            raise UsageError(f"linear models require python-control, which cannot be imported: {e}") from None
        names = SignalNames(self.states, self.inputs, self.outputs)
        labels = names.labels()
        # python-control treats a matrix of shape (1, 0) as one of shape (0, 0). A model without inputs is
        # therefore created with an input that has no effect, which is then removed.
        B, D = (M if self.inputs else np.zeros((len(M), 1)) for M in (self.B, self.D))
        out = control.StateSpace(
            self.A, B, self.C, D, name=self.name.replace(".", "_") or None, dt=0,
            states=labels["states"], inputs=labels["inputs"] or 1, outputs=labels["outputs"],
            remove_useless_states=False,
        )  # fmt: skip
        if not self.inputs:
            out.B, out.D = self.B.copy(), self.D.copy()
            out.set_inputs([])
        out.names = names
        # In notebooks: the operating point and the names of the scene, which python-control lacks.
        out._repr_html_ = self._repr_html_
        return out

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: matrices as lists of rows, in SI units."""
        lists = {key: getattr(self, key).tolist() for key in ("A", "B", "C", "D", "x0", "u0", "y0", "rates")}
        names = {key: list(getattr(self, key)) for key in ("states", "inputs", "outputs")}
        units = {name: self.units[name] for key in names for name in names[key]}
        return {
            "name": self.name,
            "time": self.time,
            "friction": self.friction,
            **names,
            "units": units,
            **lists,
        }

    @property
    def residual_rates(self) -> str:
        """A message with the rate of each state that is not in equilibrium; empty if all are.

        Coordinates that advance at a constant rate are only listed if a rate or another output depends on
        them.
        """
        return self._residual_report(self._nonequilibrium_states(self.C))

    @property
    def residual_state_rates(self) -> str:
        """The same as `residual_rates`, without regard to outputs."""
        return self._residual_report(self._nonequilibrium_states(self.C[:0]))

    def _nonequilibrium_states(self, C: Array) -> list[int]:
        """Return the indices of states that change, except those that change steadily without any effect."""
        x, y = self._sizes(self.states), self._sizes(self.outputs)
        rates, A, C = self.rates / x * self.scales.time, self.A * x / x[:, None], C * x / y[: len(C), None]
        A *= self.scales.time
        speeds = np.array([self.units.get(name) not in COORDINATE_UNITS for name in self.states], bool)
        bounds = equilibrium_rate_bounds(A, 1 + speeds * np.abs(self.x0 / x))
        moving = [int(i) for i in np.flatnonzero(np.abs(rates) > bounds)]
        own = {self.states[i] for i in moving}
        others = [k for k in range(len(C)) if self.outputs[k] not in own]
        changing = [M for M in (A, C[others]) if _exceeds_rounding(M @ rates, np.abs(M) @ np.abs(rates))]
        sizes = [np.abs(M).max(axis=1) for M in changing]
        named = [
            i
            for i in moving
            if any(_exceeds_rounding(M[:, i], size) for M, size in zip(changing, sizes, strict=True))
        ]
        unsteady = [i for i in moving if _exceeds_rounding(A[i] @ rates, np.abs(A[i]) @ np.abs(rates))]
        return sorted({*named, *unsteady})

    def _sizes(self, names: Sequence[str]) -> Array:
        return self.scales.sizes([self.units.get(name, "1") for name in names])

    def _residual_report(self, moving: Sequence[int]) -> str:
        if not moving:
            return ""
        listed = ", ".join(
            f"{self.states[i]} changes at {self.rates[i]:.6g} {_per_second(self.units[self.states[i]])}"
            for i in moving[:6]
        ) + (f" and {len(moving) - 6} more" if len(moving) > 6 else "")
        return f"t = {self.time:g} s is not an equilibrium: {listed}"

    def __str__(self) -> str:
        return _shown(self)

    def __repr__(self) -> str:
        sizes = ((self.states, "state"), (self.inputs, "input"), (self.outputs, "output"))
        listed = ", ".join(_count(len(names), what) for names, what in sizes)
        return f"<LinearModel {self.name} at t = {self.time:g} s: {listed}>"

    def _repr_html_(self) -> str:
        from gelenk.linear.model_html import model_html

        return model_html(self)


def equilibrium_rate_bounds(A: Array, sizes: Array) -> Array:
    """Return the rates up to which states are considered at rest, in the mechanism's own units.

    Args:
        A: derivatives of the rates with respect to the states, shape (rates, states).
        sizes: magnitudes of the states, shape (states,).
    """
    bounds: Array = EQUILIBRIUM_RATE_TOLERANCE + EQUILIBRIUM_ROUNDING_TOLERANCE * (np.abs(A) @ sizes)
    return bounds


def _exceeds_rounding(sums: Any, terms: Any) -> bool:
    """Whether any of these sums exceeds the rounding error of terms of this magnitude."""
    return bool((np.abs(sums) > EQUILIBRIUM_RATE_TOLERANCE + CANCELLATION_TOLERANCE * terms).any())


def with_dots(wanted: Sequence[str], known: Sequence[str]) -> list[str]:
    """Return names for which labels of python-control may be given: "hinge_phi" for "hinge.phi".

    Args:
        wanted: names and labels.
        known: all names; those that are no names, nor the label of exactly one, are returned as they are.
    """
    exact = set(known)
    by_label: dict[str, list[str]] = {}
    for name in known:
        by_label.setdefault(name.replace(".", "_"), []).append(name)

    def name_of(label: str) -> str:
        found = by_label.get(label, ())
        return label if label in exact or len(found) != 1 else found[0]

    return [name_of(label) for label in wanted]


def without_dots(names: Sequence[str], what: str) -> list[str]:
    """Return names as python-control allows them.

    Args:
        names: names of signals.
        what: what they are, for the message.

    Raises:
        UsageError: two of them are then equal.
    """
    out = [name.replace(".", "_") for name in names]
    same = [name for name, short in zip(names, out, strict=True) if out.count(short) > 1]
    if same:
        raise UsageError(
            f"{what}: python-control allows no dots in names, and {', '.join(same)} are equal without them"
        )
    return out


def _per_second(unit: str) -> str:
    otherwise = "1/s" if unit in ("", "1") else f"{unit} per second"
    return {"rad": "rad/s", "m": "m/s", "rad/s": "rad/s2", "m/s": "m/s2"}.get(unit, otherwise)


def _shown(model: LinearModel) -> str:
    """Return the operating point, then A, B, C and D with the names of their rows and columns."""
    point = f"{model.name} at t = {model.time:g} s: {_count(len(model.states), 'state')}, "
    point += f"{_count(len(model.inputs), 'input')}, {_count(len(model.outputs), 'output')}"
    groups = (("states", model.states, model.x0), ("inputs", model.inputs, model.u0))
    if model.left_out:
        point += f"\n{model.idle_rotations}"
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
    return "\n".join([f"{title} at the operating point", *lines])


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
