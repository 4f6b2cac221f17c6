# SPDX-License-Identifier: BSD-3-Clause
"""What Gelenk makes of a scene: the model before and after its reductions, and what an evaluation costs."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from gelenk import _core
from gelenk.errors import GelenkError, StartWarning
from gelenk.model.scene import Scene, Source, load

#: The reductions by name, in the order in which they are reported.
REDUCTIONS: tuple[str, ...] = tuple(_core.reduction_names)


@dataclass(frozen=True)
class Cost:
    """CPU time of one evaluation of the equations of motion at the start [s], or why there is none."""

    seconds: float | None
    refusal: str = ""

    @property
    def text(self) -> str:
        """As people read it."""
        return f"{self.seconds * 1e6:.3g} us" if self.seconds is not None else self.refusal


@dataclass(frozen=True)
class Inspection:
    """What `gelenk inspect` tells.

    Attributes:
        name: of the mechanism.
        described: sizes of the scene taken literally, without any reduction.
        reduced: sizes of what is computed.
        reductions: by name: whether it is on, and what it did, in sentences.
        redundant_rows: rows that repeat others at every position: joint, and the motion it forbids in
            the joint's frame.
        undetermined_reactions: components of reactions that rigid bodies leave open ("A.f[3]").
        counted_freedoms: by Gruebler's count: 6 for each body, less what is constrained.
        momentary_freedoms: at the start; more than `freedoms` where it is singular.
        moved_frames: joint frames that were moved so that loops with rounded numbers close
            (`assembly.tolerance`): joint, body, by how much turned [rad] and shifted [m].
        mobility: why the freedoms are not as counted, in sentences.
        left_out: what no wanted output depends on, in a sentence; empty: nothing.
        cost: of an evaluation as asked for.
        cost_literal: of an evaluation with no reduction.
        cost_without: of an evaluation without the reduction of that name.
    """

    name: str
    described: _core.ModelSize
    reduced: _core.ModelSize
    reductions: dict[str, _core.ReductionReport]
    redundant_rows: tuple[tuple[str, str], ...]
    undetermined_reactions: tuple[str, ...]
    counted_degrees_of_freedom: int
    initial_degrees_of_freedom: int
    moved_frames: tuple[tuple[str, str, float, float], ...]
    mobility: tuple[str, ...]
    left_out: str
    cost: Cost
    cost_literal: Cost
    cost_without: dict[str, Cost]

    @property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom."""
        return self.reduced.degrees_of_freedom

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON. Times in seconds; null where that model cannot be simulated."""
        return {
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
            "redundant_rows": [{"joint": joint, "forbids": motion} for joint, motion in self.redundant_rows],
            "undetermined_reactions": list(self.undetermined_reactions),
            "moved_frames": [
                {"joint": joint, "body": body, "turn": turn, "shift": shift}
                for joint, body, turn, shift in self.moved_frames
            ],
            "mobility": {
                "freedoms": self.degrees_of_freedom,
                "counted": self.counted_degrees_of_freedom,
                "at_start": self.initial_degrees_of_freedom,
                "causes": list(self.mobility),
            },
        }

    def __str__(self) -> str:
        return "\n".join(_lines(self))


def inspect(scene: Source, without: Iterable[str] = (), outputs: Iterable[str] | None = None) -> Inspection:
    """Reduces a scene, closes its loops, and tells what was done and what it gains.

    Args:
        scene: anything `gelenk.load` takes.
        without: names of reductions to leave out, or "all".
        outputs: names and patterns of the outputs that are wanted; by default the scene's own.

    Raises:
        SceneError, AssemblyError: no model can be made of the scene.
        UsageError: a name that is no reduction, an entry of `outputs` that names no output.

    >>> report = gelenk.inspect(four_bar)
    >>> report.described.constraint_equations, report.reduced.constraint_equations, report.freedoms
    (5, 2, 1)
    """
    asked = load(scene).without(without)
    if outputs is not None:
        asked = asked.with_outputs(outputs)
    plant = _started(asked)
    found = plant.inspect(asked._core)
    reductions = {report.name: report for report in found.reductions}
    return Inspection(
        name=asked.name,
        described=found.described,
        reduced=found.reduced,
        reductions=reductions,
        redundant_rows=tuple((row.joint, row.motion) for row in found.redundant_rows),
        undetermined_reactions=tuple(found.undetermined_reactions),
        counted_degrees_of_freedom=found.counted_degrees_of_freedom,
        initial_degrees_of_freedom=found.initial_degrees_of_freedom,
        moved_frames=tuple((m.joint, m.body, m.turn, m.shift) for m in found.moved_frames),
        mobility=tuple(found.mobility),
        left_out=found.left_out,
        cost=Cost(plant.evaluation_cost()),
        cost_literal=evaluation_cost(asked, ["all"]),
        cost_without={name: evaluation_cost(asked, [name]) for name in REDUCTIONS},
    )


def evaluation_cost(scene: Source, without: Iterable[str] = ()) -> Cost:
    """What an evaluation costs when some reductions are left out; the refusal if there is no such model."""
    try:
        return Cost(_started(load(scene).without(without)).evaluation_cost())
    except GelenkError as e:
        return Cost(None, e.lines[0])


def _started(scene: Scene) -> _core.Simulation:
    """What is computed of a scene, with its loops closed."""
    with scene.located():
        plant = _core.Simulation(scene.pruned()._core)
        plant.initialize(0.0, 0.0)
    for sentence in plant.start_warnings():
        warnings.warn(sentence, StartWarning, stacklevel=2, skip_file_prefixes=(__file__,))
    return plant


# Which reductions can change a quantity.
_CAUSES = {
    "bodies": ("weld", "static", "massless"),
    "coordinates": ("weld", "static", "cut_choice", "massless"),
    "speeds": ("weld", "static", "cut_choice", "massless"),
    "rows": ("weld", "static", "cut_choice", "planar", "redundant_rows", "massless"),
    "algebra": ("planar",),
    "islands": ("islands",),
}


def _sizes(size: _core.ModelSize, degrees_of_freedom: int, cost: Cost) -> dict[str, Any]:
    return {
        "bodies": size.bodies,
        "coordinates": size.coordinates,
        "speeds": size.velocities,
        "rows": size.constraint_equations,
        "freedoms": degrees_of_freedom,
        "algebra": _algebra(size),
        "islands": size.islands,
        "evaluation": cost.seconds,
    }


def _algebra(size: _core.ModelSize) -> str:
    if size.planar_islands in (0, size.islands):
        return "planar" if size.planar_islands else "spatial"
    return f"{size.planar_islands} of {size.islands} planar"


def _lines(report: Inspection) -> Iterable[str]:
    yield report.name
    yield f"  {'':14}{'as described':>14}      as computed"
    before, after = report.to_dict()["described"], report.to_dict()["reduced"]
    for key, value in before.items():
        if key == "evaluation":
            literal = report.cost_literal
            value, result = literal.text if literal.seconds is not None else "refused", report.cost.text
        else:
            result = str(after[key])
        line = f"  {key:14}{value:>14}  ->  {result:13} {_reason(report, key)}"
        yield line.rstrip()
    yield ""
    yield f"  {'reduction':15} {'without it':>12}   what it did"
    for name, reduction in report.reductions.items():
        told = list(reduction.notes) if reduction.on else ["switched off", *reduction.notes]
        yield from _entry(name, report.cost_without[name].text, told or ["nothing to do"])
    yield ""
    yield from _paragraph("  mobility  ", "; ".join([_counted(report), *report.mobility]))
    if report.moved_frames:
        yield ""
        yield "  frames moved so that the loops close    turned [rad]   shifted [m]"
    for joint, body, turn, shift in report.moved_frames:
        yield f"    {f'{joint} in {body}':37} {turn:12.2e}  {shift:12.2e}"


def _entry(name: str, cost: str, notes: list[str]) -> Iterable[str]:
    head = f"  {name:15} {cost:>12}   "
    if len(cost) > 12:  # a refusal
        head, notes = f"  {name:15} {'-':>12}   ", [*notes, f"without it: {cost}"]
    for note in notes:
        yield from _paragraph(head, note)
        head = " " * len(head)


def _paragraph(head: str, text: str) -> Iterable[str]:
    return textwrap.wrap(text, 110, initial_indent=head, subsequent_indent=" " * len(head))


def _reason(report: Inspection, key: str) -> str:
    """The reductions behind a change; where several would each do, all that did something."""
    if key == "freedoms" and report.counted_degrees_of_freedom != report.degrees_of_freedom:
        return f"counted: {report.counted_degrees_of_freedom}, see mobility"
    if key not in _CAUSES or report.to_dict()["described"][key] == report.to_dict()["reduced"][key]:
        return ""
    return ", ".join(name for name in _CAUSES[key] if report.reductions[name].changed)


def _counted(report: Inspection) -> str:
    degrees_of_freedom = "1 freedom" if report.degrees_of_freedom == 1 else f"{report.degrees_of_freedom} freedoms"
    rule = "6 for each body, less what is constrained"
    if report.counted_degrees_of_freedom == report.degrees_of_freedom == report.initial_degrees_of_freedom:
        return f"{degrees_of_freedom}, as counted ({rule})"
    text = f"{degrees_of_freedom}, where counting ({rule}) gives {report.counted_degrees_of_freedom}"
    if report.initial_degrees_of_freedom != report.degrees_of_freedom:
        text += f"; {report.initial_degrees_of_freedom} for a moment at the start"
    return text
