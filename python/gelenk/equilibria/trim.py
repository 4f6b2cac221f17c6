# SPDX-License-Identifier: BSD-3-Clause
"""The search for equilibria, at rest or in steady motion, and for inputs that hold them (trim)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

from gelenk.equilibria.holding import Holding, RestingScene
from gelenk.equilibria.newton import Search
from gelenk.equilibria.pose import LinearizedPose, PosedPlant, linearized_pose
from gelenk.equilibria.steady import (
    acceleration_drift,
    advancing,
    constant_speeds,
    driven_rates,
    steady_given,
)
from gelenk.errors import AssemblyError, EquilibriumError, UsageError
from gelenk.linear.minimal_realization import MinimalRealization
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.model.scene import Scene
from gelenk.model.values import Value, check_names, number
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.plant import Plant
from gelenk.simulation.run import open_plant
from gelenk.simulation.scene_plant import ScenePlant

# Largest driven velocity or acceleration after a communication step, in own units; rounding leaves less than
# 1e-9.
STEADY_TOLERANCE = 1e-6
TREATMENTS = ("off", "present")  # of friction, see equilibrium()


@dataclass(frozen=True)
class Equilibrium:
    """A static equilibrium or a steady motion.

    Attributes:
        name: name of the mechanism.
        values: values of all outputs, by name.
        inputs: values of all inputs, including those that were solved for.
        residual: the largest residual acceleration, in SI units.
        iterations: number of Newton steps, without those of the plant's own search.
        at: the operating point for `gelenk.linearize(source, at=...)`: start values, parameters and inputs.
        units: units of outputs and inputs.
        advancing: coordinates that advance in a steady motion, with their velocities; empty at rest.
        held: by coordinate, what keeps it at rest: contact with a hard limit and, with `friction="present"`,
            dry friction. Several joints of a loop may hold redundantly; then no distribution of their
            friction has a smaller largest fraction of a limit than this one.
    """

    name: str
    values: Mapping[str, float]
    inputs: Mapping[str, float]
    residual: float
    iterations: int
    at: Mapping[str, Value]
    units: Mapping[str, str]
    advancing: Mapping[str, float] = field(default_factory=dict)
    held: Mapping[str, Holding] = field(default_factory=dict)

    @property
    def margin(self) -> float:
        """The smallest unused part of static friction: 1 if none is used, 0 just before break-away."""
        return min((holding.margin for holding in self.held.values()), default=1.0)

    @property
    def load_factor(self) -> float:
        """The factor by which all loads can be multiplied before a joint slips; infinite without friction."""
        return 1 / (1 - self.margin) if self.margin < 1 else math.inf

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        out: dict[str, Any] = {
            key: dict(getattr(self, key)) for key in ("values", "inputs", "at", "units", "advancing")
        }
        if self.held:
            held = {name: asdict(holding) | {"margin": holding.margin} for name, holding in self.held.items()}
            out |= {"held": held, "margin": self.margin}
        return {"name": self.name, "residual": self.residual, "iterations": self.iterations, **out}

    def __str__(self) -> str:
        steps = f"{self.iterations} step{'' if self.iterations == 1 else 's'}"
        coordinates = ", ".join(self.advancing)
        verb = "advance" if len(self.advancing) > 1 else "advances"
        what = f"steady motion, {coordinates} {verb}" if coordinates else "equilibrium at rest"
        lines = [f"{self.name}: {what}; found in {steps}, largest residual acceleration {self.residual:.2g}"]
        for title, values in (("outputs", self.values), ("inputs", self.inputs)):
            if values:
                width = max(map(len, values))
                lines += ["", title]
            for name, value in values.items():
                unit = self.units.get(name, "1")
                lines.append(f"  {name:{width}}  {value + 0.0:12.6g}{'' if unit == '1' else '  ' + unit}")
        if self.held:
            width = max(map(len, self.held))
            lines += ["", "held", *(f"  {name:{width}}  {holding}" for name, holding in self.held.items())]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from gelenk.equilibria.trim_html import trim_html

        return trim_html(self)


def equilibrium(
    source: Mechanism | OperatingPoint,
    *,
    at: At = None,
    hold: Mapping[str, float] | None = None,
    steady: Mapping[str, float | None] | Sequence[str] | str | None = None,
    solve_for: Sequence[str] | str = (),
    input_values: Inputs | None = None,
    parameters: Mapping[str, Value] | None = None,
    friction: str | None = None,
) -> Equilibrium:
    """Find an equilibrium or a steady motion of a scene or an FMU, or the inputs that hold it (trim).

    Newton's method with exact Jacobians is applied to the independent coordinates, starting at an initial
    pose and remaining on its assembly branch. The equilibrium may be unstable. Without `hold`, `solve_for`
    and `steady`, it is the one at which a simulation with `solver.start: equilibrium` begins. It is within
    the hard limits of joints: what meets a limit rests against it.

    With `friction="present"` nothing is searched: the initial pose is returned, with what holds it and the
    margin until a joint slips, if dry friction and contact with limits can hold it.

    Args:
        source: a .fmu file, anything `gelenk.load` accepts, or an operating point, which already contains the
            arguments `at`, `input_values` and `parameters`.
        at: the initial pose, as for `gelenk.linearize`; its velocities are the initial guesses of `steady`.
        hold: coordinates of joints that keep these values exactly [rad, m].
        steady: velocities of joints that remain constant, with their values [rad/s, m/s], or None to
            determine them; their coordinates advance. As many other velocities as possible are 0. By default,
            the mechanism is at rest.
        solve_for: inputs to determine; if there are several solutions, the one with the least sum of squares.
        input_values: the other inputs, and initial guesses of those in `solve_for`; 0 by default.
        parameters: values by FMU parameter name.
        friction: what dry friction does. "off": nothing, which is the default for equilibria at rest.
            "present": it holds what it can; the default for steady motions, in which moving joints slip.

    Returns:
        Equilibrium: its `at` is an operating point for `gelenk.linearize`.

    Raises:
        EquilibriumError: there is no equilibrium nearby or none within the limits, the inputs cannot hold the
            pose, or friction cannot.
        SceneError, UsageError: the scene, a name or a value is invalid, or the configuration is singular.
        AssemblyError: the loops cannot be closed with these values.
        StepError: the motion cannot be computed up to `at`.
        OSError: a file cannot be read.

    >>> found = gelenk.equilibrium("scenes/pendulum.yaml", at={"pin.phi": 1.0})
    >>> found.residual < 1e-8
    True
    """
    solve_for = [solve_for] if isinstance(solve_for, str) else solve_for
    if friction not in (None, *TREATMENTS):
        raise UsageError(f"friction: found {friction!r}, expected one of {', '.join(TREATMENTS)}")
    point = OperatingPoint.given(source, at, input_values, parameters)
    plant = open_plant(point.source, ())
    try:
        check_names(solve_for, plant.inputs, "input")
        wanted = {name: number(name, value, "real") for name, value in (hold or {}).items()}
        scene = plant.scene
        if scene is not None and scene.to_dict().get("contacts"):
            raise UsageError(
                "found a scene with contacts, expected one without: they are not part of equilibria yet"
            )
        if steady is None and friction == "present":
            if scene is None:
                raise UsageError("friction: found 'present' with an FMU of another tool, expected 'off'")
            return _held_pose(point, scene, wanted, solve_for)
        if scene is not None and scene.has_friction_or_limits:
            if steady is None:
                return _within_limits(point, scene, wanted, solve_for)
            if friction == "off":
                plant.close()
                plant = ScenePlant(scene.without_friction_and_limits())
        settings = point.reach(plant).settings
        first, posed = _initial_pose(plant, settings, wanted, steady)
        posed.check_hold(first)
        values = {name: first.found.values[name] for name in first.found.inputs}
        if not solve_for:
            first = posed.native_equilibrium(first, None if point.time else settings, values)
        search = _searched(plant, Search(posed, first, values, solve_for), solve_for)
    finally:
        plant.close()
    return _result(plant.name, search)


def _searched(plant: Plant, search: Search, solve_for: Sequence[str]) -> Search:
    search.run()
    if not search.pose.is_equilibrium or not search.holds():
        raise EquilibriumError(_failure(search, solve_for))
    _check_steady(search.pose)
    if driven_rates(search.pose):
        _check_prescribed_motions(plant, search)
    return search


def _held_pose(
    point: OperatingPoint, scene: Scene, hold: Mapping[str, float], solve_for: Sequence[str]
) -> Equilibrium:
    """Return the initial pose, with held coordinates, if friction and contact keep it at rest."""
    if solve_for:
        raise UsageError(
            f"solve_for: found {', '.join(solve_for)} with friction='present', under which a range of inputs "
            "holds a pose; expected given inputs"
        )
    resting = RestingScene(scene, point)
    starts, steps = resting.starts(), 0
    if hold:
        search = _smooth_search(resting, hold, ())
        search.approach()
        starts, steps = search.plant.settings(search.starts), search.steps
    holding = resting.put(starts, resting.inputs)
    resting.check_held(holding)
    return _rest_result(resting, holding, steps)


def _within_limits(
    point: OperatingPoint, scene: Scene, hold: Mapping[str, float], solve_for: Sequence[str]
) -> Equilibrium:
    """Return an equilibrium without dry friction, within the hard limits."""
    resting = RestingScene(scene, point)
    starts = resting.starts()
    if hold or solve_for:
        search = _smooth_search(resting, hold, solve_for)
        search.approach()
        starts = search.plant.settings(search.starts)
    if not solve_for:
        # The scene's own search has limits, but holds nothing: it may have remained where it should.
        with suppress(AssemblyError):
            found = _rest_result(resting, _contacts(resting.put(starts, resting.inputs, "equilibrium")), 0)
            if all(math.isclose(found.values[name], hold[name], rel_tol=1e-12) for name in hold):
                return found
        if not hold:
            resting.put(starts, resting.inputs)
            search = _smooth_search(resting, hold, solve_for)
    _searched(search.plant.plant, search, solve_for)
    end = search.plant.settings(search.starts), search.plant.in_si(search.inputs)
    return _rest_result(resting, _contacts(resting.put(*end)), search.steps)


def _smooth_search(resting: RestingScene, hold: Mapping[str, float], solve_for: Sequence[str]) -> Search:
    smooth = resting.smooth_plant()
    known = set(smooth.parameters)
    settings = {name: value for name, value in resting.settings.items() if name in known}
    first, posed = _initial_pose(smooth, settings, hold, None)
    posed.check_hold(first)
    return Search(posed, first, {n: first.found.values[n] for n in first.found.inputs}, solve_for)


def _contacts(holding: Mapping[str, Holding]) -> dict[str, Holding]:
    return {name: of for name, of in holding.items() if of.bound}


def _rest_result(resting: RestingScene, holding: Mapping[str, Holding], steps: int) -> Equilibrium:
    plant = resting.plant
    values, inputs = plant.values, plant.input_values
    _, acceleration = resting.largest_acceleration()
    return Equilibrium(
        plant.name, {name: values[name] for name in plant.outputs}, inputs, abs(acceleration), steps,
        {**resting.settings, **resting.starts(), **inputs},
        {name: plant.unit(name) for name in (*plant.outputs, *inputs)},
        held=holding,
    )  # fmt: skip


def _initial_pose(
    plant: Plant,
    settings: Mapping[str, Value],
    hold: Mapping[str, float],
    steady: Mapping[str, float | None] | Sequence[str] | str | None,
) -> tuple[LinearizedPose, PosedPlant]:
    found = plant.derivatives(())
    wanted = {name: value / found.size(name) for name, value in hold.items()}
    if steady is None:
        return linearized_pose(found), PosedPlant(plant, found.size, settings, wanted)
    given = {
        name: None if value is None else value / found.size(name)
        for name, value in steady_given(steady).items()
    }
    conditions = constant_speeds(MinimalRealization(found.in_own_units()), given)
    speeds = {name: given.get(name, 0.0) for name in conditions}
    kept = {name: value for name, value in speeds.items() if value is not None}
    return linearized_pose(found, conditions), PosedPlant(
        plant, found.size, settings, wanted, kept, conditions
    )


def _check_prescribed_motions(plant: Plant, search: Search) -> None:
    """Check that prescribed motions cause no accelerations, now and one communication step later."""
    _check_driven_rates(search.pose, "")
    search.plant.put(search.starts, search.inputs)
    plant.advance(0.0, plant.step)
    _check_driven_rates(
        linearized_pose(plant.derivatives(()), search.pose.conditions), f", {plant.step:g} s later"
    )


def _check_driven_rates(pose: LinearizedPose, when: str) -> None:
    accelerations = {name: a for name, a in driven_rates(pose).items() if name not in pose.found.rates}
    largest, value, _ = pose.largest()
    for name, found in (accelerations | {largest: value}).items():
        if abs(found) > STEADY_TOLERANCE:
            unit = pose.found.units.get(name, "1")
            value = pose.in_si(name, found)
            raise EquilibriumError(
                f"no steady motion: a prescribed motion causes {name} = {value:.6g} {unit}{when}"
            )


def _check_steady(pose: LinearizedPose) -> None:
    name, found, bound = acceleration_drift(pose)
    if advancing(pose) and abs(found) > bound:
        rate = pose.in_si(name, found) / pose.found.scales.time
        coordinates = list(advancing(pose))
        raise EquilibriumError(
            f"the motion does not remain steady: {name} changes at {rate:.6g} "
            f"{pose.found.units.get(name, '1')} per second as {', '.join(coordinates)} "
            f"advance{'s' if len(coordinates) == 1 else ''}"
        )


def _result(name: str, search: Search) -> Equilibrium:
    found, posed = search.pose.found, search.plant
    inputs = posed.in_si(search.inputs)
    return Equilibrium(
        name, posed.in_si({n: found.values[n] for n in found.outputs}), inputs, search.pose.residual,
        search.steps, {**posed.settings(search.starts), **inputs},
        {n: found.units.get(n, "1") for n in (*found.outputs, *search.inputs)},
        advancing(search.pose),
    )  # fmt: skip


def _failure(search: Search, solve_for: Sequence[str]) -> str:
    if not search.holds():
        return search.unreachable
    name, own, unit = search.pose.largest()
    value = search.pose.in_si(name, own) if name else own
    residual = f"the largest residual acceleration is {name} = {value:.6g} {unit}"
    motion = search.plant.conditions is not None
    what = "steady motion" if motion else "equilibrium"
    if not search.converged:
        return f"no {what} found in {search.steps} steps; {residual}"
    if search.plant.hold and (solve_for or not motion):
        who = f"{', '.join(solve_for)} cannot" if solve_for else "the given inputs do not"
        return f"{who} hold this {'motion' if motion else 'pose'}; {residual}"
    return f"no {what} near this {'point' if motion else 'pose'}; {residual}"
