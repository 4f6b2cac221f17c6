# SPDX-License-Identifier: BSD-3-Clause
"""Two runs on one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.viewer.interpolation import resampled

type Array = NDArray[np.float64]


def overlaid(first: Mapping[str, Any], second: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Return the data of a page on which a second run is seen through the first.

    The page shows both at the same times: those of the first run and, if the second is longer, its further
    ones. A run that has ended rests, and its plots end.

    Args:
        first: `gelenk.viewer.data.page_data` of a run.
        second: of another.
        names: of both runs; empty: those of the scenes.

    Raises:
        UsageError: one of them has two runs already, or there are not two names.
    """
    if "second" in first or "second" in second:
        raise UsageError("overlay: found a page of two runs, expected one run each")
    if len(names) not in (0, 2):
        raise UsageError(f"names: found {len(names)}, expected 2")
    own, other = names or (first["name"], second["name"])
    if own == other:
        own, other = f"{own} 1", f"{other} 2"
    time = np.concatenate([first["time"], second["time"][second["time"] > first["time"][-1]]])
    signals = {row["name"]: row for row in second["signals"]}
    return {
        **first,
        "name": own,
        "time": time,
        "poses": _poses(first, time),
        "signals": [
            {**row, "values": _values(row, first, time)}
            | ({"second": _values(signals[row["name"]], second, time)} if row["name"] in signals else {})
            for row in first["signals"]
        ],
        "events": [
            *({**event, "text": f"{own}: {event['text']}"} for event in first["events"]),
            *({**event, "text": f"{other}: {event['text']}"} for event in second["events"]),
        ],
        "arrows": [_resting(arrow, len(time)) for arrow in first["arrows"]],
        "second": {
            "name": other, "poses": _poses(second, time),
            **{key: second[key] for key in ("bodies", "ground", "springs", "colors")},
        },
    }  # fmt: skip


def _poses(data: Mapping[str, Any], time: Array) -> NDArray[np.float32]:
    if len(time) == len(data["time"]) and (time == data["time"]).all():
        same: NDArray[np.float32] = data["poses"]
        return same
    return resampled(np.asarray(data["time"]), np.asarray(data["poses"], float), time).astype(np.float32)


def _values(row: Mapping[str, Any], data: Mapping[str, Any], time: Array) -> NDArray[np.float32]:
    """Return a signal at other times; NaN after the run has ended."""
    out: NDArray[np.float32] = np.interp(time, data["time"], row["values"], right=np.nan).astype(np.float32)
    return out


def _resting(arrow: Mapping[str, Any], frames: int) -> dict[str, Any]:
    """Return an arrow that disappears when its run has ended."""
    vectors = arrow["vectors"]
    out = {**arrow, "vectors": np.vstack([vectors, np.zeros((frames - len(vectors), 3), np.int16)])}
    if arrow["points"] is not None:
        out["points"] = np.pad(arrow["points"], ((0, frames - len(vectors)), (0, 0)), mode="edge")
    return out
