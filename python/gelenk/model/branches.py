# SPDX-License-Identifier: BSD-3-Clause
"""The branches in which a mechanism can be assembled."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from gelenk import _core
from gelenk._deprecated import DeprecatedAlias, with_old_keys
from gelenk.errors import UsageError
from gelenk.model.defaults import STARTS
from gelenk.model.scene import Scene, Source, from_dict, load
from gelenk.model.values import Value, start_parameter


@dataclass(frozen=True)
class Branch:
    """One of the positions in which an island of a mechanism can be assembled.

    Attributes:
        values: all joint coordinates of the island, by name ("A.phi"), in SI units.
        distance: distance from the initial guesses, which assembly minimizes: the square root of the sum of
            weight * change ** 2. Squares of coordinates without a guess count a ten-thousandth.
        degrees_of_freedom: degrees of freedom that the fixed values leave. If there are any, the branch is a
            local minimum of the distance; otherwise, its position is isolated.
        is_not_isolated: whether neighboring positions have the same distance, of which this is one.
        hits: number of searches that ended here.
        is_default: whether the scene's own start values lead to this branch.
        island: number of the island, from 0. Branches of different islands can be combined freely.
    """

    values: Mapping[str, float]
    distance: float
    degrees_of_freedom: int
    is_not_isolated: bool
    hits: int
    is_default: bool
    island: int

    freedoms = DeprecatedAlias("degrees_of_freedom")
    flat = DeprecatedAlias("is_not_isolated")
    chosen = DeprecatedAlias("is_default")
    part = DeprecatedAlias("island")
    put_into = DeprecatedAlias("apply_to")

    @property
    def start(self) -> dict[str, dict[str, Any]]:
        """Start coordinates as in the joints of a scene: {"A": {"phi": 0.3}}."""
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
        """Start coordinates as parameters of the scene and its FMU: {"A.phi_start": 0.3}."""
        return {start_parameter(name): value for name, value in self.values.items()}

    def apply_to(self, scene: Source) -> Scene:
        """Return a copy of a scene with these coordinates as start values, so that it is assembled in this
        branch.

        Fixed values remain fixed, all others are initial guesses. Start velocities are unchanged.

        Args:
            scene: the scene of the branch; anything `gelenk.load` accepts.

        Raises:
            SceneError, OSError: the scene is invalid, or cannot be read.
        """
        changed = load(scene)
        data = copy.deepcopy(changed.to_dict())
        for joint, values in self.start.items():
            start = data["joints"][joint].setdefault("start", {})
            if start.get("fixed") is True:  # the values that were given
                start["fixed"] = [key for key in start if key not in ("fixed", "weight")]
            start.update(values)
        return changed._with_core(from_dict(data, changed.file)._core)


@dataclass(frozen=True)
class Assemblies:
    """The assembly branches of a mechanism; a sequence of `Branch`.

    Attributes:
        name: name of the mechanism.
        branches: branches by island, each with the nearest to the initial guesses first.
        starts: number of searches in each island.
        closed: number of searches that closed the loops, in each island.
        settled: whether the search in each island ended because it found no new branches, not at the limit.
        units: units of the coordinates.
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
        """Return plain data for JSON.

        For one release, values are also found under the old keys in `gelenk._deprecated.OLD_KEYS`, and
        `islands` under `parts`.
        """
        islands = [
            {
                "starts": self.starts[island],
                "closed": self.closed[island],
                "settled": self.settled[island],
                "branches": [_plain(branch) for branch in self.branches if branch.island == island],
            }
            for island in range(len(self.starts))
        ]
        return {"name": self.name, "islands": islands, "units": dict(self.units), "parts": islands}

    def __str__(self) -> str:
        return "\n".join(_lines(self))

    def _repr_html_(self) -> str:
        from gelenk.model.branches_html import assemblies_html

        counts = [sum(branch.island == k for branch in self.branches) for k in range(len(self.starts))]
        return assemblies_html(self, [_search_line(self, k, count) for k, count in enumerate(counts)])


def assemblies(
    source: Source,
    *,
    parameters: Mapping[str, Value] | None = None,
    bodies: Iterable[str] = (),
    starts: int = STARTS,
    seed: int = 1,
) -> Assemblies:
    """List the branches in which a scene can be assembled with its fixed start values.

    Loops are closed from many random positions, the same ones in every call. Positions that differ by full
    turns are equal. If the fixed values leave degrees of freedom, local minima of the distance from the
    initial guesses are listed. The search ends when it has found no new branch for a long time; that none is
    missing is likely but not certain. `hits` states how often each branch was found.

    Args:
        source: anything `gelenk.load` accepts.
        parameters: values of parameters, by name.
        bodies: names of bodies; branches in which these have equal poses count as one, of which the nearest
            is listed. By default, all coordinates distinguish branches. (Each leg of a Stewart platform can
            be rotated by half a turn about itself.)
        starts: maximum number of searches in each island.
        seed: seed of the random positions.

    Returns:
        Assemblies: the branches.

    Raises:
        SceneError, OSError: the scene is invalid, or cannot be read.
        AssemblyError: the loops cannot be closed from the scene's own start values.
        UsageError: `starts` or `seed` is negative, or a body or parameter is unknown.

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
            is_not_isolated=one.flat,
            hits=one.hits,
            is_default=one.chosen,
            island=number,
        )
        for number, (island, names, _) in enumerate(found)
        for one in island.assemblies
    ]
    return Assemblies(
        name=scene.name,
        branches=tuple(branches),
        starts=tuple(island.starts for island, _, _ in found),
        closed=tuple(island.closed for island, _, _ in found),
        settled=tuple(island.settled for island, _, _ in found),
        units={name: unit for _, names, units in found for name, unit in zip(names, units, strict=True)},
    )


def _plain(branch: Branch) -> dict[str, Any]:
    keys = ("distance", "degrees_of_freedom", "is_not_isolated", "hits", "is_default")
    data = {key: getattr(branch, key) for key in keys}
    data |= {"values": dict(branch.values), "start": branch.start}
    return with_old_keys(data)


def _lines(found: Assemblies) -> Iterator[str]:
    if not found.starts:
        yield f"{found.name} has no closed loops: its start values are used as they are"
    for island in range(len(found.starts)):
        listed = {n: branch for n, branch in enumerate(found.branches, 1) if branch.island == island}
        yield _search_line(found, island, len(listed))
        dof = max((branch.degrees_of_freedom for branch in listed.values()), default=0)
        if dof:
            count = "1 degree of freedom" if dof == 1 else f"{dof} degrees of freedom"
            yield (
                f"  the fixed values leave {count}: "
                "local minima of the distance from the initial guesses are listed"
            )
        for number, branch in listed.items():
            yield from _branch_lines(number, branch, found.units)


def _search_line(found: Assemblies, island: int, count: int) -> str:
    what = f"{count} branch{'' if count == 1 else 'es'}"
    end = "probably all" if found.settled[island] else "there may be more"
    where = f", island {island + 1}" if len(found.starts) > 1 else ""
    searches = f"in {found.starts[island]} searches, {found.closed[island]} of which closed the loops"
    return f"{found.name}{where}: {what} found {searches}; {end}"


def _branch_lines(number: int, branch: Branch, units: Mapping[str, str]) -> Iterator[str]:
    notes = [f"distance {branch.distance:.6g}", f"found {branch.hits} times"]
    if branch.is_not_isolated:
        notes.append("one of many at this distance")
    if branch.is_default:
        notes.append("assembled from the start values")
    yield ""
    yield f"  {number}: {'; '.join(notes)}"
    width = max(map(len, branch.values), default=0)
    for name, value in branch.values.items():
        unit = units[name]
        yield f"    {name:{width}}  {value + 0.0:12.6g}{'' if unit == '1' else '  ' + unit}"
