# SPDX-License-Identifier: BSD-3-Clause
"""The search for equilibria, at rest or in steady motion, and for inputs that hold them (trim)."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from os import PathLike
from typing import Any

from gelenk.equilibria.holding import ContactPoint, Holding, PosedScene
from gelenk.equilibria.steady import (
    advancing,
    check_prescribed_motions,
    check_steady,
    constant_speeds,
    realization,
)
from gelenk.errors import EquilibriumError, SceneError, StartWarning, UsageError
from gelenk.linear.operating_point import At, Mechanism, OperatingPoint
from gelenk.model.scene import load
from gelenk.model.values import Value, check_names, number, start_parameter
from gelenk.simulation.fmu_file import SCENE, text_in
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.run import open_plant
from gelenk.simulation.scene_plant import ScenePlant

TREATMENTS = ("off", "present")  # of friction, see equilibrium()


@dataclass(frozen=True)
class Equilibrium:
    """A static equilibrium or a steady motion.

    Attributes:
        name: name of the mechanism.
        values: values of all outputs, by name.
        inputs: values of all inputs, including those that were solved for.
        residual: the largest residual acceleration, in SI units.
        iterations: number of steps of the search.
        at: the operating point for `gelenk.linearize(source, at=...)`: start values, parameters and inputs.
        units: units of outputs and inputs.
        advancing: coordinates that advance in a steady motion, with their velocities; empty at rest.
        held: by coordinate, what keeps it at rest: contact with a hard limit and, with `friction="present"`,
            dry friction. Several joints of a loop may hold redundantly; then no distribution of their
            friction has a smaller largest fraction of a limit than this one.
        contact_points: with `friction="present"`, all points at which shapes touch, with their forces; where
            these are redundant, those of least norm if they are within the laws.
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
    contact_points: Sequence[ContactPoint] = ()

    @property
    def margin(self) -> float:
        """The smallest unused part of static friction, of joints and contacts.

        1 if none is used, 0 just before something slips.
        """
        of_points = [point.margin for point in self.contact_points]
        return min((*(holding.margin for holding in self.held.values()), *of_points), default=1.0)

    @property
    def load_factor(self) -> float:
        """The factor by which all loads can be multiplied before a joint slips; infinite without friction.

        The friction of contacts grows with the loads.
        """
        margin = min((holding.margin for holding in self.held.values()), default=1.0)
        return 1 / (1 - margin) if margin < 1 else math.inf

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        out: dict[str, Any] = {
            key: dict(getattr(self, key)) for key in ("values", "inputs", "at", "units", "advancing")
        }
        if self.held:
            held = {name: asdict(holding) | {"margin": holding.margin} for name, holding in self.held.items()}
            out |= {"held": held}
        if self.contact_points:
            out["contact_points"] = [
                asdict(point) | {"margin": point.margin} for point in self.contact_points
            ]
        if self.held or self.contact_points:
            out["margin"] = self.margin
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
        if self.contact_points:
            width = max(len(point.contact) for point in self.contact_points)
            lines += ["", "contacts", *(f"  {p.contact:{width}}  {p}" for p in self.contact_points)]
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
    the hard limits of joints: what meets a limit rests against it, but a coordinate in `hold` is held by the
    inputs in `solve_for`, if there are any.

    With `friction="present"` nothing is searched: the initial pose is returned, with what holds it and the
    margin until something slips, if dry friction, contact with limits, and contacts of shapes can hold it.
    The search does not know the forces of contacts of shapes: what it finds is refused where one is closed.

    Args:
        source: an FMU that Gelenk has exported (.fmu), anything `gelenk.load` accepts, or an operating point,
            which already contains the arguments `at`, `input_values` and `parameters`.
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
    plant = _plant_of(point.source)
    check_names(solve_for, plant.inputs, "input")
    wanted = {name: number(name, value, "real") for name, value in (hold or {}).items()}
    if steady is not None and friction == "off":
        plant = ScenePlant(plant.scene.without_friction())
    elif steady is None and friction == "present" and solve_for:
        raise UsageError(
            f"solve_for: found {', '.join(solve_for)} with friction='present', under which a range of inputs "
            "holds a pose; expected given inputs"
        )
    posed = PosedScene(plant, point)
    posed.hold(wanted)
    if steady is None:
        return _at_rest(posed, wanted, solve_for, held_by_friction=friction == "present")
    speeds = constant_speeds(realization(plant, "off"), steady)  # which joints move is not known yet
    kept = wanted | {name: value for name, value in speeds.items() if value is not None}
    steps, _ = _search(posed, kept, solve_for, list(speeds))
    minimal = realization(plant)
    check_steady(minimal, list(speeds))
    posed.check_open()
    found = _result(posed, steps, advancing(minimal), [plant.rates[name] for name in speeds])
    check_prescribed_motions(plant, minimal, list(speeds))
    return found


def _plant_of(source: Mechanism) -> ScenePlant:
    """Return a scene, or that of an FMU, as a plant."""
    if isinstance(source, str | PathLike) and str(source).lower().endswith(".fmu"):
        try:
            text = text_in(source, SCENE).decode("utf-8", "replace")
        except KeyError:
            raise UsageError(
                f"{source}: found an FMU without a scene, expected one that Gelenk has exported"
            ) from None
        source = load(f"{text}\n")  # a line break marks it as text
    plant = open_plant(source, ())
    assert isinstance(plant, ScenePlant)
    return plant


def _at_rest(
    posed: PosedScene, hold: Mapping[str, float], solve_for: Sequence[str], held_by_friction: bool
) -> Equilibrium:
    """Return an equilibrium without dry friction, or the initial pose if friction and contact hold it."""
    plant = posed.plant
    if not held_by_friction:
        steps, is_driven = _search(posed, hold, solve_for, None)
        posed.check_open()
        holding = {name: of for name, of in posed.holding().items() if of.bound}
        if not is_driven:
            return _result(posed, steps, {}, None, holding)
        minimal = realization(plant)
        free = [name for name in minimal.names if minimal.is_velocity(name)]
        check_steady(minimal, free)
        found = _result(posed, steps, advancing(minimal), None, holding)
        check_prescribed_motions(plant, minimal, free)
        return found
    steps = 0
    if hold:
        steps, _ = _search(posed, hold, (), None, only_approach=True)
    else:
        posed.put(posed.starts(), posed.inputs)
    holding = posed.holding()
    points = posed.contact_points()
    posed.check_held(holding)
    return replace(_result(posed, steps, {}, None, holding), contact_points=points)


def _search(
    posed: PosedScene,
    hold: Mapping[str, float],
    solve_for: Sequence[str],
    speeds: Sequence[str] | None,
    *,
    only_approach: bool = False,
) -> tuple[int, bool]:
    """Bring a plant to an equilibrium or, if velocities are given that are constant, to a steady motion.

    Args:
        posed: the plant in the initial state.
        hold: coordinates and velocities to hold, and their values.
        solve_for: inputs to determine.
        speeds: the velocities that are constant; None: at rest.
        only_approach: whether the values to hold suffice.

    Returns:
        The number of steps, and whether prescribed motions may act.

    Raises:
        EquilibriumError, AssemblyError: see `equilibrium`.
    """
    is_steady = speeds is not None
    accelerations = [posed.plant.rates[name] for name in speeds or ()]
    ask = hold, solve_for, is_steady, accelerations, only_approach
    end, steps, is_driven, residual = posed.plant.trim(*ask)
    held = {start_parameter(name): value for name, value in hold.items()}
    if end == "unreachable":
        message = f"{', '.join(hold)}: the mechanism cannot be brought to "
        message += "this motion" if is_steady else "the pose to hold"
        try:
            with warnings.catch_warnings():  # of guesses, which are not the user's
                warnings.simplefilter("ignore", StartWarning)
                posed.put(posed.starts(is_steady) | held, posed.inputs)  # which may explain why
        except SceneError as e:
            raise EquilibriumError(f"{message}: {e}") from None
        raise EquilibriumError(message)
    if end != "found":
        name, value = posed.largest(residual)
        left = f"the largest residual acceleration is {name} = {value:.6g} {posed.plant.unit(name)}"
        if posed.has_contacts:
            left += (
                "; the search does not know the forces of contacts, friction='present' asks whether they "
                "hold a given pose"
            )
        what = "steady motion" if is_steady else "equilibrium"
        if end == "not_converged":
            raise EquilibriumError(f"no {what} found in {steps} steps; {left}")
        if hold and (solve_for or not is_steady):
            who = f"{', '.join(solve_for)} cannot" if solve_for else "the given inputs do not"
            raise EquilibriumError(f"{who} hold this {'motion' if is_steady else 'pose'}; {left}")
        raise EquilibriumError(f"no {what} near this {'point' if is_steady else 'pose'}; {left}")
    posed.inputs, starts = posed.plant.input_values, posed.starts(is_steady) | held
    posed.put(starts, posed.inputs)
    # Where assembly has rounded otherwise, or to the exact values held: once more from there.
    if posed.starts(is_steady) != starts and posed.plant.trim(*ask)[0] == "found":
        posed.inputs = posed.plant.input_values
        posed.put(posed.starts(is_steady) | held, posed.inputs)
    return steps, is_driven


def _result(
    posed: PosedScene,
    steps: int,
    moving: Mapping[str, float],
    conditions: Sequence[str] | None,
    holding: Mapping[str, Holding] | None = None,
) -> Equilibrium:
    """Return the present state; conditions: the accelerations that vanish in a steady motion."""
    plant = posed.plant
    values, inputs = plant.values, plant.input_values
    residual = posed.accelerations() if conditions is None else {name: values[name] for name in conditions}
    return Equilibrium(
        plant.name, {name: values[name] for name in plant.outputs}, inputs,
        max((abs(value) for value in residual.values()), default=0.0), steps,
        {**posed.settings, **posed.starts(conditions is not None), **inputs},
        {name: plant.unit(name) for name in (*plant.outputs, *inputs)}, moving, holding or {},
    )  # fmt: skip
