# SPDX-License-Identifier: BSD-3-Clause
"""A run together with the derivatives of its steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import UsageError
from gelenk.model.values import unknown

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class DifferentiatedRun:
    """A run, linearized step by step: what `gelenk.sensitivity` returns.

    With the independent states x, parameters p and inputs u, dx[k + 1] = F[k] dx[k] + G[k] du[k] + P[k] dp
    and dy[k] = C[k] dx[k] + D[k] du[k - 1] + Q[k] dp.

    Attributes:
        time: times of the outputs [s], shape (points,).
        outputs: names.
        inputs: names of the inputs by which derivatives are known.
        parameters: names of the parameters by which derivatives are known.
        values: of the outputs, shape (points, outputs).
        units: by name.
        F: shape (steps, states, states).
        G: shape (steps, states, inputs).
        P: shape (steps, states, parameters).
        C: shape (points, outputs, states).
        D: shape (points, outputs, inputs).
        Q: shape (points, outputs, parameters).
        start: derivatives of the states at the start by the parameters, shape (states, parameters).
    """

    time: Array
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Array
    units: Mapping[str, str]
    F: Array
    G: Array
    P: Array
    C: Array
    D: Array
    Q: Array
    start: Array

    def __getitem__(self, output: str) -> Array:
        """Return the values of an output, shape (points,). Raises UsageError for an unknown name."""
        return self.values[:, _index(output, "output", self.outputs)]

    def derivative(self, output: str, by: str) -> Array:
        """Return the derivatives of an output by a parameter or by an input that is changed in the whole run.

        Args:
            output: its name.
            by: name of a parameter or input.

        Returns:
            NDArray: shape (points,), in the unit of the output per unit of the parameter or input.

        Raises:
            UsageError: a name is unknown.
        """
        k = _index(output, "output", self.outputs)
        return self.jacobian[:, k, _index(by, "parameter or input", [*self.parameters, *self.inputs])]

    @property
    def jacobian(self) -> Array:
        """Derivatives of all outputs by all parameters and, changed in the whole run, all inputs.

        Shape (points, outputs, parameters + inputs).
        """
        parameters = np.eye(len(self.parameters), len(self.parameters) + len(self.inputs))
        inputs = np.eye(len(self.inputs), parameters.shape[1], len(self.parameters))
        return _forward(self, parameters, np.broadcast_to(inputs, (len(self.F), *inputs.shape)))


def jvp(
    run: DifferentiatedRun,
    parameters: Mapping[str, float] | None = None,
    inputs: Mapping[str, ArrayLike] | None = None,
) -> dict[str, Array]:
    """Return the change of the outputs in a direction: the Jacobian of a run times a vector.

    Args:
        run: what `gelenk.sensitivity` returns.
        parameters: changes by name.
        inputs: changes by name: a number, or one for each step.

    Returns:
        dict[str, NDArray]: for each output, shape (points,).

    Raises:
        UsageError: a name is unknown, or the shape of a change is wrong.

    >>> run = gelenk.sensitivity(four_bar, ["crank.m", "drive.tau"], outputs=["A.w"], stop=0.1)
    >>> gelenk.jvp(run, {"crank.m": 0.01}, {"drive.tau": 0.5})["A.w"].shape
    (101,)
    """
    dp = np.zeros((len(run.parameters), 1))
    for name, change in (parameters or {}).items():
        dp[_index(name, "parameter", run.parameters)] = change
    du = np.zeros((len(run.F), len(run.inputs), 1))
    for name, signal in (inputs or {}).items():
        table = np.asarray(signal, np.float64)
        if table.shape not in ((), (len(run.F),)):
            raise UsageError(
                f"{name}: found an array of shape {table.shape}, expected a number or one for each of "
                f"{len(run.F)} steps"
            )
        du[:, _index(name, "input", run.inputs), 0] = table
    found = _forward(run, dp, du)[:, :, 0]
    return {name: found[:, k] for k, name in enumerate(run.outputs)}


def vjp(
    run: DifferentiatedRun, outputs: Mapping[str, ArrayLike]
) -> tuple[dict[str, float], dict[str, Array]]:
    """Return the gradient of a sum over the outputs: a vector times the Jacobian of a run.

    Its cost does not depend on the number of inputs and steps.

    Args:
        run: what `gelenk.sensitivity` returns.
        outputs: for each output, the derivatives of a scalar by its values, shape (points,).

    Returns:
        tuple[dict[str, float], dict[str, NDArray]]: the derivatives of that scalar by the parameters, and by
        each input in each step, shape (steps,).

    Raises:
        UsageError: a name is unknown, or a shape is wrong.
    """
    weights = np.zeros_like(run.values)
    for name, signal in outputs.items():
        table = np.asarray(signal, np.float64)
        if table.shape != run.time.shape:
            raise UsageError(f"{name}: found an array of shape {table.shape}, expected {run.time.shape}")
        weights[:, _index(name, "output", run.outputs)] += table
    by_parameter = np.einsum("ky,kyp->p", weights, run.Q)
    by_input = np.zeros((len(run.F), len(run.inputs)))
    adjoint = run.C[-1].T @ weights[-1]
    for k in reversed(range(len(run.F))):
        by_parameter += run.P[k].T @ adjoint
        by_input[k] += run.G[k].T @ adjoint + run.D[k + 1].T @ weights[k + 1]
        adjoint = run.F[k].T @ adjoint + run.C[k].T @ weights[k]
    if len(run.F):
        by_input[0] += run.D[0].T @ weights[0]
    by_parameter += run.start.T @ adjoint
    return (
        dict(zip(run.parameters, by_parameter.tolist(), strict=True)),
        {name: by_input[:, k] for k, name in enumerate(run.inputs)},
    )


def _forward(run: DifferentiatedRun, dp: Array, du: Array) -> Array:
    """Return the changes of the outputs, shape (points, outputs, directions).

    Args:
        run: the run.
        dp: shape (parameters, directions).
        du: shape (steps, inputs, directions).
    """
    dx = run.start @ dp
    found = run.Q @ dp
    found[0] += run.C[0] @ dx + (run.D[0] @ du[0] if len(du) else 0.0)
    for k in range(len(run.F)):
        dx = run.F[k] @ dx + run.G[k] @ du[k] + run.P[k] @ dp
        found[k + 1] += run.C[k + 1] @ dx + run.D[k + 1] @ du[k]
    return found


def _index(name: str, what: str, known: Sequence[str]) -> int:
    if name not in known:
        raise UsageError(unknown(name, what, known))
    return known.index(name)
