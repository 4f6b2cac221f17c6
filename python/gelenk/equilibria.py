# SPDX-License-Identifier: BSD-3-Clause
"""Static equilibria, and the inputs that hold a pose (trim)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

from gelenk.errors import EquilibriumError, UsageError
from gelenk.inputs import Inputs
from gelenk.linear import STANDS
from gelenk.linearization import go_on, point_given, time_given
from gelenk.newton import Search
from gelenk.rest import Pose, Rest, pose_of
from gelenk.run import configure, open_plant
from gelenk.scene import Scene, Value, number, unknown


@dataclass(frozen=True)
class Equilibrium:
    """A point where the mechanism stands still.

    Attributes:
        name: of the mechanism.
        values: of all outputs there.
        inputs: of all inputs, those that were solved for among them.
        residual: the largest acceleration that remains, in SI units.
        iterations: steps that were taken.
        at: the point for `gelenk.linearize(source, at=...)`: start values, parameters, inputs.
        units: of outputs and inputs.
    """

    name: str
    values: Mapping[str, float]
    inputs: Mapping[str, float]
    residual: float
    iterations: int
    at: Mapping[str, Value]
    units: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        out = {key: dict(getattr(self, key)) for key in ("values", "inputs", "at", "units")}
        return {"name": self.name, "residual": self.residual, "iterations": self.iterations, **out}

    def __str__(self) -> str:
        steps = f"{self.iterations} step{'' if self.iterations == 1 else 's'}"
        lines = [f"{self.name} stands still, found in {steps}; accelerations up to {self.residual:.2g}"]
        for title, values in (("outputs", self.values), ("inputs", self.inputs)):
            if values:
                width = max(map(len, values))
                lines += ["", title]
            for name, value in values.items():
                unit = self.units.get(name, "1")
                lines.append(f"  {name:{width}}  {value + 0.0:12.6g}{'' if unit == '1' else '  ' + unit}")
        return "\n".join(lines)


def equilibrium(
    source: Scene | str | PathLike[str] | Mapping[str, Any],
    *,
    at: float | Mapping[str, Value] | None = None,
    hold: Mapping[str, float] | None = None,
    solve_for: Sequence[str] | str = (),
    input_values: Inputs | None = None,
    parameters: Mapping[str, Value] | None = None,
) -> Equilibrium:
    """A pose in which a scene or an FMU stands still, or the inputs that hold it in one.

    Newton's method with exact derivatives on the independent coordinates, from a first pose on, by the
    branch in which the loops are closed there. Whether what is found is stable is not asked.

    Args:
        source: a .fmu file, or whatever `gelenk.load` takes.
        at: the first pose, as for `gelenk.linearize`; its speeds do not count.
        hold: coordinates of joints that keep these values exactly [rad, m].
        solve_for: inputs to be found; where several sets do it, the one of the least sum of squares.
        input_values: the other inputs, and first guesses; those that are not named are 0.
        parameters: values by FMU parameter name.

    Returns:
        Equilibrium: its `at` is the point for `gelenk.linearize`.

    Raises:
        EquilibriumError: there is none near by, or these inputs cannot hold the pose.
        SceneError, UsageError: the scene, a name or a value is wrong, or the position is singular.
        AssemblyError: the loops cannot be closed with these values.
        StepError: the motion does not get to `at`.
        OSError: a file cannot be read.

    >>> found = gelenk.equilibrium("scenes/pendulum.yaml", at={"pin.phi": 1.0})
    >>> found.residual < 1e-8
    True
    """
    solve_for = [solve_for] if isinstance(solve_for, str) else solve_for
    plant = open_plant(source, ())
    try:
        settings, _, signals = point_given(plant, at, parameters, input_values)
        _check_inputs(solve_for, plant.inputs)
        wanted = {name: number(name, value, "real") for name, value in (hold or {}).items()}
        configure(plant, dict(settings), None, {})
        plant.start(None, {name: signal(0.0) for name, signal in signals.items()})
        go_on(plant, time_given(at), signals)
        first = pose_of(plant.derivatives(()))
        rest = Rest(plant, settings, wanted)
        rest.check_hold(first)
        search = Search(
            rest, first, {name: first.found.values[name] for name in first.found.inputs}, solve_for
        )
        search.run()
    finally:
        plant.close()
    if _residual(search.pose) > STANDS or not search.kept():
        raise EquilibriumError(_sentence(search, solve_for))
    return _result(plant.name, search)


def _result(name: str, search: Search) -> Equilibrium:
    found = search.pose.found
    return Equilibrium(
        name, {n: found.values[n] for n in found.outputs}, search.inputs, _residual(search.pose),
        search.steps, {**search.rest.settings(search.starts), **search.inputs},
        {n: found.units.get(n, "1") for n in (*found.outputs, *search.inputs)},
    )  # fmt: skip


def _check_inputs(wanted: Sequence[str], known: Sequence[str]) -> None:
    faults = [unknown(name, "input", known) for name in wanted if name not in known]
    faults += [f"{name}: asked for twice" for name in dict.fromkeys(wanted) if list(wanted).count(name) > 1]
    if faults:
        raise UsageError("\n".join(faults))


def _residual(pose: Pose) -> float:
    return abs(pose.largest()[1])


def _sentence(search: Search, solve_for: Sequence[str]) -> str:
    if not search.kept():
        return search.unreached
    name, value, unit = search.pose.largest()
    rest = f"{name} = {value:.6g} {unit} is the largest acceleration that remains"
    if not search.settled:
        return f"no equilibrium found in {search.steps} steps: {rest}"
    if search.rest.hold:
        who = f"{', '.join(solve_for)} cannot" if solve_for else "the given inputs do not"
        return f"{who} hold this pose: {rest}"
    return f"no equilibrium near this pose: {rest}"
