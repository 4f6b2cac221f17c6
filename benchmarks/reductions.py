# SPDX-License-Identifier: BSD-3-Clause
"""Measures the gain of each reduction and writes the tables of docs/reductions.md: `make reductions`."""

from __future__ import annotations

import math
import platform
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gelenk
from gelenk.chart.mechanisms import at, bricard, four_bar_chain, hinge, rod
from gelenk.model.inspection import REDUCTIONS, Inspection, evaluation_cost

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reductions.md"
BEGIN = "<!-- tables: made by benchmarks/reductions.py -->\n"
END = "<!-- end of tables -->"
ROUNDS = 7  # each the smallest of 20 measurements of 1 ms; the memory layout differs between rounds

Scene = dict[str, Any]


# --- scenes for reductions that the example scenes do not use ---


def welded_chain(n: int) -> Scene:
    """Return a pendulum of n welded pieces."""
    joints = {"pin": hinge("ground", "piece0", start={"phi": 0.3})}
    for i in range(1, n):
        joints[f"seam{i}"] = {"type": "weld", "parent": at(f"piece{i - 1}", 0.1), "child": f"piece{i}"}
    bodies = {f"piece{i}": rod(0.1, 0.1) for i in range(n)}
    return {"gelenk": 1, "gravity": [0, -9.81, 0], "bodies": bodies, "joints": joints}


def side_by_side() -> Scene:
    """Return the planar four-bar and the spatial heavy top in one scene."""
    first, second = (
        gelenk.load(ROOT / "scenes" / f"{name}.yaml").to_dict() for name in ("four_bar", "heavy_top")
    )
    for section in ("bodies", "joints"):
        first[section] |= second[section]
    return first


def on_a_truss() -> Scene:
    """Return a pendulum at the top of a truss of two rods."""
    phi = math.acos(0.6)
    joints = {
        "left": hinge("ground", "rod1", start={"phi": phi}),
        "right": hinge(at("ground", 1.2), "rod2", start={"phi": math.pi - phi}),
        "top": hinge(at("rod1", 1), at("rod2", 1), start={"phi": math.pi - 2 * phi}),
        "pin": hinge(at("rod1", 1), "bob", start={"phi": 0.4}),
    }
    bodies = {"rod1": rod(1), "rod2": rod(1), "bob": rod(0.5)}
    return {"gelenk": 1, "gravity": [0, -9.81, 0], "bodies": bodies, "joints": joints}


def ball_first() -> Scene:
    """Return a spatial slider-crank whose ball joint is listed before its universal joint."""
    n = [-2 / 3, 1 / 3, 2 / 3]  # along the rod, away from the slider
    b = [0.0, -2 / math.sqrt(5), 1 / math.sqrt(5)]  # normal to the rod and the slide
    c = [n[1] * b[2] - n[2] * b[1], n[2] * b[0] - n[0] * b[2], n[0] * b[1] - n[1] * b[0]]
    along = {"rotation": {"matrix": [n, b, c]}}
    joints = {
        "ball": {"type": "spherical", "parent": at("crank", 0, 0, 0.08),
                 "child": {**at("rod", 0.3), **along}},
        "main": hinge(at("ground", 0, 0.1, 0.12), "crank", axis=[1, 0, 0], start={"w": 6, "fixed": True}),
        "slide": {"type": "prismatic", "parent": "ground", "child": "slider", "axis": [1, 0, 0],
                  "start": {"s": 0.2}},
        "cross": {"type": "universal", "parent": "slider", "child": {**at("rod", 0), **along},
                  "axes": [[1, 0, 0], b]},
    }  # fmt: skip
    bodies = {
        "crank": {"mass": 0.12, "com": [0, 0, 0.04], "inertia": [1e-4, 1e-4, 1e-5]},
        "rod": {"mass": 0.5, "com": [0.15, 0, 0], "inertia": [4e-4, 4e-3, 4e-3]},
        "slider": {"mass": 2, "inertia": [1e-4, 1e-4, 1e-4]},
    }
    return {"gelenk": 1, "gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints}


def coupled_by_a_rod() -> Scene:
    """Return a crank about z and a rocker about x, connected by a massless rod."""
    bodies = {
        "crank": {"mass": 1, "com": [0.1, 0, 0], "inertia": [0.001, 0.01, 0.01]},
        "rod": {"mass": 0},
        "rocker": {"mass": 2, "com": [0, 0.2, 0], "inertia": [0.02, 0.001, 0.02]},
    }
    joints = {
        "A": hinge("ground", "crank", start={"phi": 0.3, "w": 2, "fixed": True}),
        "U": {
            "type": "universal",
            "axes": [[0, 1, 0], [0, 0, 1]],
            "parent": at("crank", 0.2, 0, 0.1),
            "child": "rod",
        },
        "S": {"type": "spherical", "parent": at("rod", 0.8), "child": at("rocker", 0, 0.4)},
        "B": hinge(at("ground", 0.9), "rocker", axis=[1, 0, 0], start={"phi": 0.2}),
    }
    return {"gelenk": 1, "gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints}


BUILT: dict[str, Callable[[], Scene]] = {
    "chain of five parallelograms": lambda: four_bar_chain(5, upright=math.pi / 2 - 1.2, rate=0.0),
    "Bricard's linkage of six hinges": bricard,
    "spatial slider-crank, ball joint listed first": ball_first,
    "pendulum of 50 welded pieces": lambda: welded_chain(50),
    "pendulum on a truss": on_a_truss,
    "four_bar and heavy_top in one scene": side_by_side,
    "crank and rocker coupled by a massless rod": coupled_by_a_rod,
}


# --- the tables ---


def scenes() -> Iterator[tuple[str, gelenk.Scene]]:
    for path in sorted((ROOT / "scenes").glob("*.yaml")):
        yield f"`{path.name}`", gelenk.load(path)
    for name, make in BUILT.items():
        yield name, gelenk.load(make())


def least_cost(scene: gelenk.Scene, *without: str) -> float | None:
    """Return the smallest time of one evaluation [s], or None if the scene cannot be computed."""
    costs = [evaluation_cost(scene, without).seconds for _ in range(ROUNDS)]
    return None if costs[0] is None else min(c for c in costs if c is not None)


def change(before: object, after: object) -> str:
    return str(after) if before == after else f"{before} → {after}"


def sizes(name: str, report: Inspection) -> str:
    data = report.to_dict()
    keys = ("bodies", "coordinates", "constraint_equations", "algebra", "islands")
    cells = [change(data["described"][key], data["reduced"][key]) for key in keys]
    counted = data["mobility"]["counted"]
    degrees_of_freedom = (
        str(report.degrees_of_freedom)
        if counted == report.degrees_of_freedom
        else f"{report.degrees_of_freedom} (counted {counted})"
    )
    return "| " + " | ".join([name, *cells, degrees_of_freedom]) + " |"


def costs(name: str, scene: gelenk.Scene, report: Inspection) -> str:
    here = least_cost(scene)
    assert here is not None
    cells = [name, f"{here * 1e6:.2f}"]
    for off in (*REDUCTIONS, "all"):
        if off != "all" and not report.reductions[off].changed:
            cells.append("")
            continue
        other = least_cost(scene, off)
        cells.append("not computable" if other is None else f"{other / here:.2f}" if here > 0 else "")
    return "| " + " | ".join(cells) + " |"


def tables() -> str:
    size_rows, cost_rows = [], []
    for name, scene in scenes():
        report = gelenk.inspect(scene)
        size_rows.append(sizes(name, report))
        cost_rows.append(costs(name, scene, report))
    columns = [f"`{name}`" for name in REDUCTIONS]
    lines = [
        "| scene | bodies | coordinates | constraint equations | algebra | islands | DOF |",
        "|---|---|---|---|---|---|---|",
        *size_rows,
        "",
        "CPU time of one evaluation of the equations of motion [µs], and the factor by which it changes",
        "without one reduction and without all of them. Empty: the reduction has nothing to do there. "
        f"Minimum of {ROUNDS * 20} measurements",
        f"on one core of {machine()}; ratios are accurate to about 5 %.",
        "",
        "| scene | µs | without " + " | ".join([*columns, "all"]) + " |",
        "|---" * (3 + len(columns)) + "|",
        *cost_rows,
    ]
    return "\n".join(lines) + "\n"


def machine() -> str:
    return (
        f"{'an' if platform.machine()[0] in 'aeiox' else 'a'} {platform.machine().replace('_', '-')} machine"
    )


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    PAGE.write_text(before + BEGIN + tables() + END + rest.split(END)[1], encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)}: the tables are new")
