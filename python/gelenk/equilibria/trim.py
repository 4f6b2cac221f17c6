# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria, at rest or in steady motion, and the inputs that hold them (trim)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from gelenk.equilibria.newton import Search
from gelenk.equilibria.rest import Pose, Rest, pose_of
from gelenk.equilibria.steady import advancing, change, constant_speeds, pushed, steady_given
from gelenk.errors import EquilibriumError
from gelenk.linear.minimal import Minimal
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.model.values import Value, check_names, number
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.plant import Plant
from gelenk.simulation.run import open_plant

LATER = 1e-6  # of what is steady, what a step of the integrator may leave, in own units; found below 1e-9


@dataclass(frozen=True)
class Equilibrium:
    """A point where the mechanism stands still, or moves steadily.

    Attributes:
        name: of the mechanism.
        values: of all outputs there.
        inputs: of all inputs, those that were solved for among them.
        residual: the largest acceleration that remains, in SI units.
        iterations: steps of Newton's method that were taken, beside those of the plant's own search.
        at: the point for `gelenk.linearize(source, at=...)`: start values, parameters, inputs.
        units: of outputs and inputs.
        advancing: coordinates that go on in a steady motion, and their speeds; empty at rest.
    """

    name: str
    values: Mapping[str, float]
    inputs: Mapping[str, float]
    residual: float
    iterations: int
    at: Mapping[str, Value]
    units: Mapping[str, str]
    advancing: Mapping[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        out = {key: dict(getattr(self, key)) for key in ("values", "inputs", "at", "units", "advancing")}
        return {"name": self.name, "residual": self.residual, "iterations": self.iterations, **out}

    def __str__(self) -> str:
        steps = f"{self.iterations} step{'' if self.iterations == 1 else 's'}"
        going = ", ".join(self.advancing)
        what = f"moves steadily, {going} {'go' if ',' in going else 'goes'} on" if going else "stands still"
        lines = [f"{self.name} {what}, found in {steps}; accelerations up to {self.residual:.2g}"]
        for title, values in (("outputs", self.values), ("inputs", self.inputs)):
            if values:
                width = max(map(len, values))
                lines += ["", title]
            for name, value in values.items():
                unit = self.units.get(name, "1")
                lines.append(f"  {name:{width}}  {value + 0.0:12.6g}{'' if unit == '1' else '  ' + unit}")
        return "\n".join(lines)


def equilibrium(
    source: Mechanism | OperatingPoint,
    *,
    at: At = None,
    hold: Mapping[str, float] | None = None,
    steady: Mapping[str, float | None] | Sequence[str] | str | None = None,
    solve_for: Sequence[str] | str = (),
    input_values: Inputs | None = None,
    parameters: Mapping[str, Value] | None = None,
) -> Equilibrium:
    """Where a scene or an FMU stands still or moves steadily, or the inputs that hold it there.

    Newton's method with exact derivatives on the independent coordinates, from a first pose on, by the
    branch in which the loops are closed there. Whether what is found is stable is not asked. Where nothing
    is held, to be found or steady, it is where a run with `solver.start: equilibrium` begins.

    Args:
        source: a .fmu file, or whatever `gelenk.load` takes; or an operating point, in which the arguments of
            these names stand already.
        at: the first pose, as for `gelenk.linearize`; its speeds count where they are to be found.
        hold: coordinates of joints that keep these values exactly [rad, m].
        steady: speeds of joints that stay constant, with their values [rad/s, m/s], or None where these are
            to be found; their coordinates go on. Of all other speeds as many are 0 as can be. Without it, the
            mechanism stands still.
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
    point = OperatingPoint.given(source, at, input_values, parameters)
    plant = open_plant(point.source, ())
    try:
        check_names(solve_for, plant.inputs, "input")
        wanted = {name: number(name, value, "real") for name, value in (hold or {}).items()}
        settings = point.reach(plant).settings
        first, rest = _task(plant, settings, wanted, steady)
        rest.check_hold(first)
        values = {name: first.found.values[name] for name in first.found.inputs}
        if not solve_for:
            first = rest.settled(first, None if point.time else settings, values)
        search = Search(rest, first, values, solve_for)
        search.run()
        if not search.pose.stands or not search.kept():
            raise EquilibriumError(_sentence(search, solve_for))
        _check_steady(search.pose)
        if pushed(search.pose):
            _check_later(plant, search)
    finally:
        plant.close()
    return _result(plant.name, search)


def _task(
    plant: Plant,
    settings: Mapping[str, Value],
    hold: Mapping[str, float],
    steady: Mapping[str, float | None] | Sequence[str] | str | None,
) -> tuple[Pose, Rest]:
    found = plant.derivatives(())
    wanted = {name: value / found.size(name) for name, value in hold.items()}
    if steady is None:
        return pose_of(found), Rest(plant, found.size, settings, wanted)
    given = {
        name: None if value is None else value / found.size(name)
        for name, value in steady_given(steady).items()
    }
    conditions = constant_speeds(Minimal(found.in_own_units()), given)
    speeds = {name: given.get(name, 0.0) for name in conditions}
    kept = {name: value for name, value in speeds.items() if value is not None}
    return pose_of(found, conditions), Rest(plant, found.size, settings, wanted, kept, conditions)


def _check_later(plant: Plant, search: Search) -> None:
    """Now and a step later, by when a given motion has gone on."""
    _check_pushed(search.pose, "")
    search.rest.put(search.starts, search.inputs)
    plant.advance(0.0, plant.step)
    _check_pushed(pose_of(plant.derivatives(()), search.pose.conditions), f", {plant.step:g} s later")


def _check_pushed(pose: Pose, when: str) -> None:
    accelerations = {name: a for name, a in pushed(pose).items() if name not in pose.found.rates}
    largest, value, _ = pose.largest()
    for name, found in (accelerations | {largest: value}).items():
        if abs(found) > LATER:
            unit = pose.found.units.get(name, "1")
            value = pose.in_si(name, found)
            raise EquilibriumError(f"no steady motion: {name} = {value:.6g} {unit} by a given motion{when}")


def _check_steady(pose: Pose) -> None:
    name, found, bound = change(pose)
    if advancing(pose) and abs(found) > bound:
        rate = pose.in_si(name, found) / pose.found.scales.time
        raise EquilibriumError(
            f"steady for a moment only: {name} changes at {rate:.6g} {pose.found.units.get(name, '1')} per "
            f"second as {', '.join(advancing(pose))} go{'es' if len(advancing(pose)) == 1 else ''} on"
        )


def _result(name: str, search: Search) -> Equilibrium:
    found, rest = search.pose.found, search.rest
    inputs = rest.in_si(search.inputs)
    return Equilibrium(
        name, rest.in_si({n: found.values[n] for n in found.outputs}), inputs, search.pose.residual,
        search.steps, {**rest.settings(search.starts), **inputs},
        {n: found.units.get(n, "1") for n in (*found.outputs, *search.inputs)},
        advancing(search.pose),
    )  # fmt: skip


def _sentence(search: Search, solve_for: Sequence[str]) -> str:
    if not search.kept():
        return search.unreached
    name, own, unit = search.pose.largest()
    value = search.pose.in_si(name, own) if name else own
    rest = f"{name} = {value:.6g} {unit} is the largest acceleration that remains"
    motion = search.rest.conditions is not None
    what = "steady motion" if motion else "equilibrium"
    if not search.settled:
        return f"no {what} found in {search.steps} steps: {rest}"
    if search.rest.hold and (solve_for or not motion):
        who = f"{', '.join(solve_for)} cannot" if solve_for else "the given inputs do not"
        return f"{who} hold this {'motion' if motion else 'pose'}: {rest}"
    return f"no {what} near this {'point' if motion else 'pose'}: {rest}"
