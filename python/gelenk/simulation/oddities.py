# SPDX-License-Identifier: BSD-3-Clause
"""What is valid in a run but probably not intended: tables that end early, a plant that never moves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import uniform_gravity
from gelenk.simulation.inputs import Constant, InputFunction, Table
from gelenk.simulation.plant import Plant
from gelenk.simulation.result import Result

type Array = NDArray[np.float64]

# A repeated time is a jump. If more than this fraction of them is repeated, they have probably been rounded.
MAX_REPEATED = 0.1


def doubts_of_tables(signals: Mapping[str, InputFunction], stop: float) -> Iterator[str]:
    """Yield a sentence for each doubtful table of inputs; one for inputs with the same times.

    Args:
        signals: functions of time by input.
        stop: end of the run [s].
    """
    tables: dict[bytes, list[str]] = {}
    for name, signal in signals.items():
        if isinstance(signal, Table):
            tables.setdefault(signal.times.tobytes(), []).append(name)
    for names in tables.values():
        of = [signals[name] for name in names]
        first = of[0]
        assert isinstance(first, Table)
        yield from _doubts(
            ", ".join(names), first.times, [x.values for x in of if isinstance(x, Table)], stop
        )


def _doubts(names: str, times: Array, columns: list[Array], stop: float) -> Iterator[str]:
    last = float(times[-1])
    if len(times) > 1 and last < stop * (1 - 1e-9):
        yield (
            f"{names}: the table ends at {last:g} s, before the end of the run at {stop:g} s; "
            "its last values are held from there on"
        )
    same = np.diff(times) == 0
    if not same.any():
        return
    k = int(np.flatnonzero(same)[0])
    constant = np.all([x[1:] == x[:-1] for x in columns], axis=0)
    thrice = np.flatnonzero(same[1:] & same[:-1])
    if len(thrice):
        k = int(thrice[0])
        yield f"{names}: found the time {times[k]:g} s three times, expected it once, or twice for a jump"
    elif same.sum() > MAX_REPEATED * len(times):
        yield (
            f"{names}: found {same.sum()} of {len(times)} times twice, {times[k]:g} s first; values jump "
            "where a time is repeated: have the times been rounded?"
        )
    elif (same & constant).any():
        k = int(np.flatnonzero(same & constant)[0])
        yield f"{names}: found the time {times[k]:g} s twice with equal values, expected it once"


def nothing_moves(plant: Plant, result: Result, signals: Mapping[str, InputFunction]) -> str:
    """Return a sentence if all outputs of a run are constant to the bit; empty if something moves.

    Args:
        plant: what was run.
        result: with all outputs of the plant.
        signals: functions of time by input.
    """
    # One column after the other: the first one that moves, usually the first of all, ends the search.
    columns = (result[name] for name in result.names)
    if len(result) < 2 or not result.names or any((column != column[0]).any() for column in columns):
        return ""
    if any(not isinstance(signal, Constant) or signal.value != 0 for signal in signals.values()):
        return ""
    scene = plant.scene
    if scene is None or scene.has_friction_or_limits:
        return ""
    # What contacts hold is at rest exactly.
    if any(name.endswith(".mode") and result[name][0] != 0 for name in result.names):
        return ""
    data = scene.to_dict()
    if isinstance(data.get("gravity"), dict):
        return "nothing moves: the field of gravity accelerates no joint at the start"
    gravity = uniform_gravity(data)
    names = ", ".join(plant.inputs)
    inputs = f", and all inputs are 0 ({names})" if names else ""
    if not any(gravity):
        return f"nothing moves: there is no gravity (such as gravity: [0, 0, -9.81]){inputs}"
    shown = ", ".join(f"{x:g}" for x in gravity)
    return (
        f"nothing moves: gravity [{shown}] m/s2 accelerates no joint at the start: no joint moves in its "
        f"direction, or the start is an equilibrium{inputs}"
    )
