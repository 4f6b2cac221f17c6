# SPDX-License-Identifier: BSD-3-Clause
"""Inspection of the model of a scene: its reductions, and the cost of an evaluation."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from gelenk import _core
from gelenk._deprecated import OLD_KEYS, DeprecatedAlias, with_old_keys
from gelenk.errors import GelenkError, StartWarning
from gelenk.model.scene import Scene, Source, load

#: The reductions by name, in the order in which they are reported.
REDUCTIONS: tuple[str, ...] = tuple(_core.reduction_names())


@dataclass(frozen=True)
class Cost:
    """The cost of one evaluation of the equations of motion at the start values.

    Attributes:
        seconds: CPU time [s]; None if the model cannot be simulated.
        refusal: in this case, the reason.
    """

    seconds: float | None
    refusal: str = ""

    @property
    def text(self) -> str:
        """The CPU time with its unit, or the reason for which there is none."""
        return f"{self.seconds * 1e6:.3g} us" if self.seconds is not None else self.refusal


@dataclass(frozen=True)
class Inspection:
    """The results of `gelenk.inspect`.

    Attributes:
        name: name of the mechanism.
        described: sizes of the model as described, without any reduction.
        reduced: sizes of the model that is computed.
        reductions: for each reduction, by name, whether it is on and its effects, as sentences.
        redundant_constraints: constraint equations that are redundant at every position: joint, and the
            motion that it prevents in the joint's frame.
        undetermined_reactions: components of reactions that rigid bodies do not determine ("A.f[3]").
        counted_degrees_of_freedom: degrees of freedom by Gruebler's count: 6 for each body minus constraints.
        initial_degrees_of_freedom: degrees of freedom at the start values; more than `degrees_of_freedom` in
            a singular configuration.
        moved_frames: joint frames that were moved so that loops with rounded dimensions close
            (`assembly.tolerance`): joint, body, rotation [rad] and displacement [m].
        mobility: reasons for which the degrees of freedom differ from the count, as sentences.
        left_out: what no requested output depends on, as a sentence; empty if there is nothing.
        cost: cost of an evaluation with the requested reductions.
        cost_literal: cost of an evaluation without any reduction.
        cost_without: cost of an evaluation without one reduction, by its name.
    """

    name: str
    described: _core.ModelSize
    reduced: _core.ModelSize
    reductions: dict[str, _core.ReductionReport]
    redundant_constraints: tuple[tuple[str, str], ...]
    undetermined_reactions: tuple[str, ...]
    counted_degrees_of_freedom: int
    initial_degrees_of_freedom: int
    moved_frames: tuple[tuple[str, str, float, float], ...]
    mobility: tuple[str, ...]
    left_out: str
    cost: Cost
    cost_literal: Cost
    cost_without: dict[str, Cost]

    freedoms = DeprecatedAlias("degrees_of_freedom")
    counted_freedoms = DeprecatedAlias("counted_degrees_of_freedom")
    momentary_freedoms = DeprecatedAlias("initial_degrees_of_freedom")
    redundant_rows = DeprecatedAlias("redundant_constraints")

    @property
    def degrees_of_freedom(self) -> int:
        """Number of velocities minus the rank of the constraint Jacobian at a regular position."""
        return self.reduced.degrees_of_freedom

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: times in seconds, null for a model that cannot be simulated.

        For one release, values are also found under the old keys in `gelenk._deprecated.OLD_KEYS`.
        """
        constraints = [{"joint": joint, "forbids": motion} for joint, motion in self.redundant_constraints]
        mobility = {
            "degrees_of_freedom": self.degrees_of_freedom,
            "counted": self.counted_degrees_of_freedom,
            "at_start": self.initial_degrees_of_freedom,
            "causes": list(self.mobility),
        }
        data = {
            "name": self.name,
            "described": _sizes(self.described, self.degrees_of_freedom, self.cost_literal),
            "reduced": _sizes(self.reduced, self.degrees_of_freedom, self.cost),
            "reductions": {
                name: {
                    "on": report.on,
                    "changed": report.changed,
                    "notes": list(report.notes),
                    "evaluation_without": self.cost_without[name].seconds,
                }
                for name, report in self.reductions.items()
            },
            "left_out": self.left_out,
            "redundant_constraints": constraints,
            "undetermined_reactions": list(self.undetermined_reactions),
            "moved_frames": [
                {"joint": joint, "body": body, "turn": turn, "shift": shift}
                for joint, body, turn, shift in self.moved_frames
            ],
            "mobility": with_old_keys(mobility),
        }
        return with_old_keys(data)

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def __repr__(self) -> str:
        return f"<Inspection of {self.name}: {_mobility(self)}>"

    def _repr_html_(self) -> str:
        from gelenk.model.inspection_html import inspection_html

        return inspection_html(self, _mobility(self))


def inspect(scene: Source, without: Iterable[str] = (), outputs: Iterable[str] | None = None) -> Inspection:
    """Reduce a scene, close its loops, and report the reductions and what they save.

    Args:
        scene: anything `gelenk.load` accepts.
        without: names of reductions to switch off, or "all".
        outputs: names and patterns of the requested outputs; by default the scene's own.

    Returns:
        Inspection: sizes, reductions, mobility and costs.

    Raises:
        SceneError, OSError: the scene is invalid, or cannot be read.
        AssemblyError: the loops cannot be closed.
        UsageError: a reduction or an output is unknown.

    >>> report = gelenk.inspect(four_bar)
    >>> report.described.constraint_equations, report.reduced.constraint_equations, report.degrees_of_freedom
    (5, 2, 1)
    """
    requested = load(scene).without(without)
    if outputs is not None:
        requested = requested.with_outputs(outputs)
    plant = _started(requested)
    found = plant.inspect(requested._core)
    reductions = {report.name: report for report in found.reductions}
    return Inspection(
        name=requested.name,
        described=found.described,
        reduced=found.reduced,
        reductions=reductions,
        redundant_constraints=tuple((row.joint, row.motion) for row in found.redundant_rows),
        undetermined_reactions=tuple(found.undetermined_reactions),
        counted_degrees_of_freedom=found.counted_degrees_of_freedom,
        initial_degrees_of_freedom=found.initial_degrees_of_freedom,
        moved_frames=tuple((m.joint, m.body, m.turn, m.shift) for m in found.moved_frames),
        mobility=tuple(found.mobility),
        left_out=found.left_out,
        cost=Cost(plant.evaluation_cost()),
        cost_literal=evaluation_cost(requested, ["all"]),
        cost_without={name: evaluation_cost(requested, [name]) for name in REDUCTIONS},
    )


def evaluation_cost(scene: Source, without: Iterable[str] = ()) -> Cost:
    """Return the cost of an evaluation if some reductions are switched off.

    Args:
        scene: anything `gelenk.load` accepts.
        without: names of reductions to switch off, or "all".

    Returns:
        Cost: CPU time by the general kernels, or the reason for which the model cannot be simulated.
    """
    try:
        return Cost(_started(load(scene).without(without)).evaluation_cost())
    except GelenkError as e:
        return Cost(None, e.lines[0])


def _started(scene: Scene) -> _core.Simulation:
    """Return the computed part of a scene, with closed loops.

    Its equations are evaluated by the kernels: programs leave out most of what reductions do.
    """
    scene = scene.with_parameters({"solver.equations": "general"})
    with scene.located():
        plant = _core.Simulation(scene.pruned()._core)
        plant.initialize(0.0, 0.0)
    for sentence in plant.start_warnings():
        warnings.warn(sentence, StartWarning, stacklevel=2, skip_file_prefixes=(__file__,))
    return plant


# The reductions that can change a size.
_CAUSES = {
    "bodies": ("weld", "static", "massless"),
    "coordinates": ("weld", "static", "cut_choice", "massless"),
    "velocities": ("weld", "static", "cut_choice", "massless"),
    "constraint_equations": ("weld", "static", "cut_choice", "planar", "redundant_rows", "massless"),
    "algebra": ("planar",),
    "islands": ("islands",),
}


def _sizes(size: _core.ModelSize, degrees_of_freedom: int, cost: Cost) -> dict[str, Any]:
    data = {
        "bodies": size.bodies,
        "coordinates": size.coordinates,
        "velocities": size.velocities,
        "constraint_equations": size.constraint_equations,
        "degrees_of_freedom": degrees_of_freedom,
        "algebra": _algebra(size),
        "islands": size.islands,
        "evaluation": cost.seconds,
    }
    return with_old_keys(data)


def _algebra(size: _core.ModelSize) -> str:
    if size.planar_islands in (0, size.islands):
        return "planar" if size.planar_islands else "spatial"
    return f"{size.planar_islands} of {size.islands} planar"


def _lines(report: Inspection) -> Iterable[str]:
    yield report.name
    yield f"  {'':20}{'as described':>14}      as computed"
    before, after = report.to_dict()["described"], report.to_dict()["reduced"]
    for key, value in before.items():
        if key in OLD_KEYS:
            continue
        if key == "evaluation":
            literal = report.cost_literal
            value, result = literal.text if literal.seconds is not None else "refused", report.cost.text
        else:
            result = str(after[key])
        line = f"  {key.replace('_', ' '):20}{value:>14}  ->  {result:13} {_reason(report, key)}"
        yield line.rstrip()
    yield ""
    yield f"  {'reduction':15} {'without it':>12}   effect"
    for name, reduction in report.reductions.items():
        notes = list(reduction.notes) if reduction.on else ["switched off", *reduction.notes]
        yield from _entry(name, report.cost_without[name].text, notes or ["nothing to do"])
    yield ""
    yield from _paragraph("  mobility  ", _mobility(report))
    if report.moved_frames:
        yield ""
        yield "  frames moved so that the loops close   rotation [rad]   shift [m]"
    for joint, body, turn, shift in report.moved_frames:
        yield f"    {f'{joint} in {body}':37} {turn:12.2e}  {shift:12.2e}"


def _entry(name: str, cost: str, notes: list[str]) -> Iterable[str]:
    head = f"  {name:15} {cost:>12}   "
    if len(cost) > 12:  # a reason instead of a time
        head, notes = f"  {name:15} {'-':>12}   ", [*notes, f"without it: {cost}"]
    for note in notes:
        yield from _paragraph(head, note)
        head = " " * len(head)


def _paragraph(head: str, text: str) -> Iterable[str]:
    return textwrap.wrap(text, 110, initial_indent=head, subsequent_indent=" " * len(head))


def _reason(report: Inspection, key: str) -> str:
    """Return the reductions that may have caused a change of a size: all that had an effect."""
    if key == "degrees_of_freedom" and report.counted_degrees_of_freedom != report.degrees_of_freedom:
        return f"counted: {report.counted_degrees_of_freedom}, see mobility"
    if key not in _CAUSES or report.to_dict()["described"][key] == report.to_dict()["reduced"][key]:
        return ""
    return ", ".join(name for name in _CAUSES[key] if report.reductions[name].changed)


def _mobility(report: Inspection) -> str:
    return "; ".join([_counted(report), *report.mobility])


def _counted(report: Inspection) -> str:
    number, counted = report.degrees_of_freedom, report.counted_degrees_of_freedom
    text = "1 degree of freedom" if number == 1 else f"{number} degrees of freedom"
    rule = "6 for each body minus its constraints"
    if counted == number == report.initial_degrees_of_freedom:
        return f"{text}, as counted ({rule})"
    text += f", while counting ({rule}) gives {counted}"
    if report.initial_degrees_of_freedom != number:
        text += f"; momentarily {report.initial_degrees_of_freedom} at the start"
    return text
