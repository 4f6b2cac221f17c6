# SPDX-License-Identifier: BSD-3-Clause
"""The different ways in which a mechanism can be put together."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.defaults import STARTS
from gelenk.model.scene import Scene, Source, from_dict, load
from gelenk.model.values import Value, start_parameter


@dataclass(frozen=True)
class Branch:
    """One way to put a part of a mechanism together.

    Attributes:
        values: of all joint coordinates of the part, by name ("A.phi"), in SI units.
        distance: root of the sum of weight * change ** 2, which assembly makes small, over all guesses;
            coordinates without one count a ten-thousandth of their squares.
        freedoms: that the fixed values leave. With some, this is a place of least distance among its
            neighbours; without, a place that stands by itself.
        flat: there are neighbours at the same distance, of which this is one.
        hits: searches that ended here.
        chosen: the scene's own start values lead here.
        part: number of the part. Any branch of one part goes with any of another.
    """

    values: Mapping[str, float]
    distance: float
    degrees_of_freedom: int
    flat: bool
    hits: int
    chosen: bool
    part: int

    @property
    def start(self) -> dict[str, dict[str, Any]]:
        """Start coordinates as a scene's joints have them: {"A": {"phi": 0.3}}."""
        out: dict[str, dict[str, Any]] = {}
        for name, value in self.values.items():
            joint, _, quantity = name.partition(".")
            base, bracket, _ = quantity.partition("[")
            if bracket:
                out.setdefault(joint, {}).setdefault(base, []).append(value)
            else:
                out.setdefault(joint, {})[base] = value
        return out

    @property
    def parameters(self) -> dict[str, Value]:
        """The same as parameters of the scene and its FMU: {"A.phi_start": 0.3}."""
        return {start_parameter(name): value for name, value in self.values.items()}

    def put_into(self, scene: Source) -> Scene:
        """The scene with these coordinates as its start values: it is assembled here.

        What was fixed stays so; the rest are guesses. Speeds stay as they are.
        """
        changed = load(scene)
        data = copy.deepcopy(changed.to_dict())
        for joint, values in self.start.items():
            start = data["joints"][joint].setdefault("start", {})
            if start.get("fixed") is True:  # of what was given
                start["fixed"] = [key for key in start if key not in ("fixed", "weight")]
            start.update(values)
        return changed._with_core(from_dict(data, changed.file)._core)


@dataclass(frozen=True)
class Assemblies:
    """The branches that were found; iterates over them.

    Attributes:
        name: of the mechanism.
        branches: part by part, the nearest to the wishes first.
        starts: searches made, by part.
        closed: those of them that closed the loops.
        settled: searches ended because they found nothing new any more, not because there were enough.
        units: of the coordinates.
    """

    name: str
    branches: tuple[Branch, ...]
    starts: tuple[int, ...]
    closed: tuple[int, ...]
    settled: tuple[bool, ...]
    units: Mapping[str, str]

    def __iter__(self) -> Iterator[Branch]:
        return iter(self.branches)

    def __len__(self) -> int:
        return len(self.branches)

    def __getitem__(self, index: int) -> Branch:
        return self.branches[index]

    def to_dict(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        parts = [
            {
                "starts": self.starts[part],
                "closed": self.closed[part],
                "settled": self.settled[part],
                "branches": [_plain(branch) for branch in self.branches if branch.part == part],
            }
            for part in range(len(self.starts))
        ]
        return {"name": self.name, "parts": parts, "units": dict(self.units)}

    def __str__(self) -> str:
        return "\n".join(_lines(self))


def assemblies(
    source: Source,
    *,
    parameters: Mapping[str, Value] | None = None,
    bodies: Iterable[str] = (),
    starts: int = STARTS,
    seed: int = 1,
) -> Assemblies:
    """Lists the ways in which a scene can be put together with its fixed start values.

    Loops are closed from many random positions, the same ones in every call; positions that were found
    before (angles within a turn) count once. Where the fixed values leave freedoms, the places of least
    distance from the guesses are listed. Searching ends when it has found nothing new for long: it is
    likely, not certain, that none is missing. `hits` tell how often each was met.

    Args:
        source: anything `gelenk.load` takes.
        parameters: set before, by name.
        bodies: branches in which these stand alike count as one, of which the nearest is listed; none: all
            coordinates count. (Each leg of a Stewart platform can be turned by half a turn about itself.)
        starts: at most so many searches for each part.
        seed: of the random positions.

    Raises:
        AssemblyError: the scene's own start values lead to no assembly.
        UsageError: starts or seed below zero, a body that does not exist.

    >>> [round(branch.values["D.phi"], 4) for branch in gelenk.assemblies(four_bar)]
    [1.9152, 3.8781]
    """
    if starts < 0 or seed < 0:
        raise UsageError(f"assemblies: found starts = {starts} and seed = {seed}, expected 0 or more")
    scene = load(source).with_parameters(parameters or {})
    found = _core.list_assemblies(scene._core, list(bodies), starts, seed)
    branches = [
        Branch(
            values=dict(zip(names, one.values, strict=True)),
            distance=one.distance,
            degrees_of_freedom=one.degrees_of_freedom,
            flat=one.flat,
            hits=one.hits,
            chosen=one.chosen,
            part=number,
        )
        for number, (part, names, _) in enumerate(found)
        for one in part.assemblies
    ]
    return Assemblies(
        name=scene.name,
        branches=tuple(branches),
        starts=tuple(part.starts for part, _, _ in found),
        closed=tuple(part.closed for part, _, _ in found),
        settled=tuple(part.settled for part, _, _ in found),
        units={name: unit for _, names, units in found for name, unit in zip(names, units, strict=True)},
    )


def _plain(branch: Branch) -> dict[str, Any]:
    out = {key: getattr(branch, key) for key in ("distance", "degrees_of_freedom", "flat", "hits", "chosen")}
    return {**out, "values": dict(branch.values), "start": branch.start}


def _lines(found: Assemblies) -> Iterator[str]:
    if not found.starts:
        yield f"{found.name} has no loops: its start values are taken as they are"
    for part in range(len(found.starts)):
        listed = {n: branch for n, branch in enumerate(found.branches, 1) if branch.part == part}
        yield _search_line(found, part, len(listed))
        most = max((branch.degrees_of_freedom for branch in listed.values()), default=0)
        if most:
            yield (
                f"  fixed values leave {most} freedom{'' if most == 1 else 's'}: "
                "listed are places of least distance from the guesses"
            )
        for number, branch in listed.items():
            yield from _branch_lines(number, branch, found.units)


def _search_line(found: Assemblies, part: int, count: int) -> str:
    what = f"{count} branch{'' if count == 1 else 'es'}"
    end = "no new ones turned up any more" if found.settled[part] else "there may be more"
    where = f", part {part + 1}" if len(found.starts) > 1 else ""
    searches = f"after {found.starts[part]} searches of which {found.closed[part]} closed the loops"
    return f"{found.name}{where}: {what}, {searches}; {end}"


def _branch_lines(number: int, branch: Branch, units: Mapping[str, str]) -> Iterator[str]:
    notes = [f"distance {branch.distance:.6g}", f"found {branch.hits} times"]
    if branch.flat:
        notes.append("one of many at this distance")
    if branch.chosen:
        notes.append("taken by the start values as they are")
    yield ""
    yield f"  {number}: {'; '.join(notes)}"
    width = max(map(len, branch.values), default=0)
    for name, value in branch.values.items():
        unit = units[name]
        yield f"    {name:{width}}  {value + 0.0:12.6g}{'' if unit == '1' else '  ' + unit}"
