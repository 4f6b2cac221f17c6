# SPDX-License-Identifier: BSD-3-Clause
"""A scene as a nonlinear system of python-control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import UsageError
from gelenk.linear.model import SignalNames, with_dots
from gelenk.model.scene import Source, load
from gelenk.model.values import Value, check_names
from gelenk.simulation.inputs import is_motion
from gelenk.simulation.run import expanded
from gelenk.simulation.simulation import Simulation

if TYPE_CHECKING:
    import control

    from gelenk import _core

type Array = NDArray[np.float64]

# Between the positions from which the loops of a mechanism are closed [rad, m].
SPACING = 0.25
MOST_POSITIONS = 10_000


def control_system(
    scene: Source,
    *,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    parameters: Mapping[str, Value] | None = None,
) -> control.NonlinearIOSystem:
    """Return a scene as a nonlinear system of python-control, for its simulations, designs and block
    diagrams.

    The states are independent coordinates and velocities, as those of `gelenk.linearize`. Rates and outputs
    are functions of time, states and inputs alone: the same arguments give the same bits, and no evaluation
    affects another. Loops are closed on the branch of the start.

    Args:
        scene: anything `gelenk.load` accepts.
        inputs: names of the inputs of the system, in this order; by default all. The others are 0.
        outputs: names and patterns of its outputs; by default those of the scene.
        parameters: values that differ from those of the scene, by name.

    Returns:
        control.NonlinearIOSystem: the labels of its states, inputs and outputs have "_" for "." (drive_f),
        the attribute `names` has the names with dots; the attribute `x0` has the states at the start.

    Raises:
        SceneError, AssemblyError, UsageError: the scene, a name or a value is invalid; the scene has
        friction,
            limits or contacts, which differential equations alone do not describe, or a prescribed motion.
    """
    import control

    loaded = load(scene).with_parameters(dict(parameters or {}))
    known = [signal.name for signal in Simulation(loaded.with_outputs(None)).outputs]
    names = [s.name for s in Simulation(loaded).outputs] if outputs is None else with_dots(outputs, known)
    names = expanded(names, known)
    check_names(names, known, "output")
    equations = Equations(loaded.with_outputs(names) if names else loaded, inputs, names)
    signals = SignalNames(equations.states, equations.inputs, tuple(names))
    system = control.NonlinearIOSystem(
        lambda t, x, u, _: equations.rates(t, x, u), lambda t, x, u, _: equations.outputs(t, x, u),
        name=loaded.name or "scene", dt=0, **signals.labels(),
    )  # fmt: skip
    system.names, system.x0 = signals, equations.start
    return system


class Equations:
    """The equations of motion of a scene as functions without side effects."""

    def __init__(self, scene: Any, inputs: Sequence[str] | None, outputs: Sequence[str]) -> None:
        """Assemble a plant.

        Args:
            scene: the scene.
            inputs: names; None: all.
            outputs: names.

        Raises:
            SceneError, AssemblyError, UsageError: see `control_system`.
        """
        self._plant = plant = Simulation(scene)
        every = [signal.name for signal in plant.inputs]
        self.inputs = tuple(every if inputs is None else with_dots(inputs, every))
        check_names(list(self.inputs), every, "input")
        motions = [name for name in every if is_motion(name)]
        if motions:
            raise UsageError(
                f"{motions[0]}: it prescribes a motion, which needs the derivatives of an input; replace it "
                "by a force"
            )
        with scene.located():
            plant._core.assemble(0.0)
        obstacle = plant._core.modes()
        if obstacle:
            raise UsageError(
                f"the scene has {obstacle}, whose events differential equations alone do not contain; use "
                "gelenk.Simulation, or model them smoothly"
            )
        self._indices = [plant._input[name] for name in self.inputs]
        self._outputs = [plant._output[name] for name in outputs]
        self._states: list[int] = plant._core._states()
        #: Names of the states.
        self.states = tuple(plant._signals[i].name for i in self._states)
        #: Their values at the start.
        self.start = plant._core.read_outputs(self._states)
        self._home = plant._core.position()
        self._has_loops = plant.size.constraint_equations > 0
        self._positions: dict[tuple[int, ...], _core.Position] = {}
        coordinates = len(plant._core.independent_coordinates)
        self._coordinates = np.arange(len(self._states)) < coordinates
        self._last: tuple[float, bytes, bytes] | None = None

    def rates(self, time: float, x: ArrayLike, u: ArrayLike) -> Array:
        """Return the time derivatives of the states."""
        self._go(time, x, u)
        return np.array(self._plant._core.rates())

    def outputs(self, time: float, x: ArrayLike, u: ArrayLike) -> Array:
        """Return the outputs."""
        self._go(time, x, u)
        return self._plant._core.read_outputs(self._outputs)

    def _go(self, time: float, x: ArrayLike, u: ArrayLike) -> None:
        states = np.array(x, np.float64).reshape(-1)
        values = np.array(u, np.float64).reshape(-1)
        point = (float(time), states.tobytes(), values.tobytes())
        if self._last == point:
            return
        self._last = None
        core = self._plant._core
        for index, value in zip(self._indices, values.tolist(), strict=True):
            core.set_input(index, value)
        core.return_to(self._near(states) if self._has_loops else self._home)
        core.move_to(states.tolist(), float(time))
        self._last = point

    def _near(self, states: Array) -> _core.Position:
        """Return a position near the states, which depends on the states alone.

        It is a point of a lattice, reached on a straight way from the start.
        """
        apart = np.where(self._coordinates, states - self.start, 0.0)
        if not np.isfinite(apart).all():
            return self._home
        cell = tuple(np.rint(apart / SPACING).astype(np.int64).tolist())
        if cell not in self._positions:
            if len(self._positions) >= MOST_POSITIONS:
                self._positions.clear()
            core = self._plant._core
            core.return_to(self._home)
            at = self._home
            try:
                core.move_to((np.array(cell) * SPACING + self._start_at_rest()).tolist(), 0.0)
                at = core.position()
            except UsageError:
                pass  # beyond the range of the mechanism: from the start
            self._positions[cell] = at
        return self._positions[cell]

    def _start_at_rest(self) -> Array:
        return np.where(self._coordinates, self.start, 0.0)
