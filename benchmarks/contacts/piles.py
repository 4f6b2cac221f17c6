# SPDX-License-Identifier: BSD-3-Clause
"""Measure piles of spheres: `python -m benchmarks.contacts.piles`.

Spheres fall into an open box of five half-spaces, with friction, from a loose lattice with random offsets.
Time is measured while they fall and after they have settled, and divided by the number of touching pairs,
which is counted from positions in the same way for all engines. The table is written to
docs/nonsmooth-measurements.md, with `--print` to the terminal only. A run that needs more than `--budget`
seconds of CPU time ends there.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import importlib.util
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.contacts.problems import GRAVITY, Array
from benchmarks.page_parts import put
from scipy.spatial import cKDTree

from gelenk.chart.tables import rows

ROOT = Path(__file__).resolve().parents[2]
COUNTS = (100, 300, 1000, 3000)
RADIUS, MASS, FRICTION = 0.05, 0.5, 0.4  # m, kg
STEP = 1e-3  # s; of EXUDYN a tenth
FALLING, SETTLED = (0.10, 0.15), (0.95, 1.0)  # s, from and to
TOUCHING = 1e-4  # m; spheres with a smaller gap touch

# Advances to a time and returns the positions of the spheres, shape (spheres, 3).
type Advance = Callable[[float], Array]


def lattice(count: int) -> tuple[Array, float]:
    """Return positions of spheres above the floor z = 0, and half the width of the box [m]."""
    side = round(count ** (1 / 3))
    pitch = 2.2 * RADIUS
    cells = np.array([(k % side, k // side % side, k // side**2) for k in range(count)], float)
    offsets = np.random.default_rng(1).uniform(-0.08, 0.08, (count, 3)) * RADIUS
    half = side * pitch / 2
    return (cells + 0.5) * pitch - [half, half, 0] + offsets, half


def walls(half: float) -> list[tuple[list[float], list[float]]]:
    """Return a point and the normal of each of the five half-spaces."""
    sides = [([s * half, 0.0, 0.0], [-s, 0.0, 0.0]) for s in (-1.0, 1.0)]
    sides += [([0.0, s * half, 0.0], [0.0, -s, 0.0]) for s in (-1.0, 1.0)]
    return [([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), *sides]


def gaps(positions: Array, half: float) -> Array:
    """Return the gaps of all pairs that touch [m]; negative: overlap."""
    tree = cKDTree(positions)
    pairs = tree.query_pairs(2 * RADIUS + TOUCHING, output_type="ndarray")
    between = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1) - 2 * RADIUS
    to_walls = np.concatenate([(positions - p) @ np.array(n) - RADIUS for p, n in walls(half)])
    return np.concatenate([between, to_walls[to_walls < TOUCHING]])


def gelenk_pile(count: int, **solver: float) -> Advance:
    import gelenk

    places, half = lattice(count)
    inertia = [0.4 * MASS * RADIUS**2] * 3
    shape = {"s": {"sphere": RADIUS, "surface": "stone"}}
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -GRAVITY],
        "bodies": {f"b{k}": {"mass": MASS, "inertia": inertia, "shapes": shape} for k in range(count)},
        "ground": {
            "shapes": {
                f"wall{k}": {"plane": n, "position": p, "surface": "stone"}
                for k, (p, n) in enumerate(walls(half))
            }
        },
        "joints": {
            f"j{k}": {"type": "free", "parent": "ground", "child": f"b{k}", "start": {"r": p, "fixed": True}}
            for k, p in enumerate(places.tolist())
        },
        "contacts": {"c": {"between": ["stone", "stone"], "friction": FRICTION}},
        "solver": {"integrator": "moreau-jean", "step": STEP, **solver},
    }
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    names = [f"j{k}.r[{i}]" for k in range(count) for i in (1, 2, 3)]

    def advance(t: float) -> Array:
        plant.step_to(t)
        return np.array(plant.values(names)).reshape(-1, 3)

    return advance


def mujoco_pile(count: int, option: str) -> Advance:
    mujoco: Any = importlib.import_module("mujoco")
    places, half = lattice(count)
    law = f'friction="{FRICTION} 0 0" condim="3"'
    planes = "".join(
        f'<geom type="plane" size="9 9 1" pos="{p[0]} {p[1]} {p[2]}" zaxis="{n[0]} {n[1]} {n[2]}" {law}/>'
        for p, n in walls(half)
    )
    spheres = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="sphere" size="{RADIUS}" mass="{MASS}" {law}/>'
        "</body>"
        for x, y, z in places.tolist()
    )
    text = (
        f'<mujoco><size memory="2G"/><option timestep="{STEP}" gravity="0 0 {-GRAVITY}" {option}/>'
        f"<worldbody>{planes}{spheres}</worldbody></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)

    def advance(t: float) -> Array:
        mujoco.mj_step(model, data, round((t - data.time) / STEP))
        return np.array(data.qpos).reshape(-1, 7)[:, :3]

    return advance


def exudyn_pile(count: int) -> Advance:
    """Spheres as point masses without rotation would have no friction: rigid bodies, explicit steps."""
    exu: Any = importlib.import_module("exudyn")
    items: Any = importlib.import_module("exudyn.itemInterface")
    utilities: Any = importlib.import_module("exudyn.utilities")
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())
    places, half = lattice(count)
    contact = system.AddGeneralContact()
    contact.SetFrictionPairings(np.array([[FRICTION]]))
    contact.SetFrictionProportionalZone(1e-3)
    cells = max(2, round(count ** (1 / 3)))
    contact.SetSearchTreeCellSize(numberOfCells=[cells] * 3)
    contact.SetSearchTreeBox(
        pMin=np.array([-half, -half, 0.0]) - 0.2, pMax=np.array([half, half, 3 * half]) + 0.2
    )
    rate = 1 / (20 * STEP / 10)
    stiffness, damping = 2 * MASS * rate**2, MASS * rate
    inertia = utilities.InertiaSphere(MASS, RADIUS)
    nodes = []
    for p in places.tolist():
        made = system.CreateRigidBody(
            inertia=inertia, referencePosition=p, gravity=[0, 0, -GRAVITY], returnDict=True,
            nodeType=exu.NodeType.RotationRotationVector,
        )  # fmt: skip
        nodes.append(made["nodeNumber"])
        mark = system.AddMarker(items.MarkerNodeRigid(nodeNumber=made["nodeNumber"]))
        contact.AddSphereWithMarker(
            mark, radius=RADIUS, contactStiffness=stiffness, contactDamping=damping, frictionMaterialIndex=0
        )
    still = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
    for p, n in walls(half):
        u = np.roll(np.abs(n), 1) * 9
        v = np.cross(n, u)
        corners = [list(np.array(p) + a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        contact.AddTrianglesRigidBodyBased(
            rigidBodyMarkerIndex=still, contactStiffness=stiffness, contactDamping=damping,
            frictionMaterialIndex=0, pointList=corners, triangleList=[[0, 1, 2], [0, 2, 3]],
        )  # fmt: skip
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.explicitIntegration.computeEndOfStepAccelerations = False
    # By default, steps multiply with the dense inverse of the mass matrix.
    settings.timeIntegration.explicitIntegration.computeMassMatrixInversePerBody = True
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    settings.displayStatistics = settings.displayComputationTime = False
    now = 0.0

    def advance(t: float) -> Array:
        nonlocal now
        settings.timeIntegration.startTime, settings.timeIntegration.endTime = now, t
        settings.timeIntegration.numberOfSteps = round((t - now) / (STEP / 10))
        system.SolveDynamic(
            settings, solverType=exu.DynamicSolverType.ExplicitMidpoint, showHints=False,
            showCausingItems=False, updateInitialValues=True,
        )  # fmt: skip
        now = t
        kind = exu.OutputVariableType.Position
        return np.array([system.GetNodeOutput(node, kind) for node in nodes])

    return advance


CONES = 'cone="elliptic" tolerance="1e-10" iterations="200"'
#: By series: the package and what makes a pile.
SERIES: dict[str, tuple[str, Callable[[int], Advance]]] = {
    "Gelenk": ("gelenk", gelenk_pile),
    "Gelenk, cone_tolerance 1e-3": ("gelenk", lambda count: gelenk_pile(count, cone_tolerance=1e-3)),
    "MuJoCo": ("mujoco", lambda count: mujoco_pile(count, "")),
    "MuJoCo, elliptic, Newton": ("mujoco", lambda count: mujoco_pile(count, f'{CONES} solver="Newton"')),
    "MuJoCo, elliptic, CG": ("mujoco", lambda count: mujoco_pile(count, f'{CONES} solver="CG"')),
    "EXUDYN, steps of 0.1 ms": ("exudyn", exudyn_pile),
}


def measured(name: str, count: int, budget: float) -> dict[str, Any]:
    """Return CPU times per ms simulated, contacts, and overlaps in both stages; NaN beyond the budget."""
    advance = SERIES[name][1](count)
    _, half = lattice(count)
    out: dict[str, Any] = {"series": name, "spheres": count}
    total = 0.0

    def timed(t: float) -> tuple[float, Array]:
        nonlocal total
        begin = time.process_time()
        positions = advance(t)
        spent = time.process_time() - begin
        total += spent
        return spent, positions

    reached = 0.0
    for stage, (begin, end) in {"falling": FALLING, "settled": SETTLED}.items():
        out |= {f"{stage} {key}": math.nan for key in ("ms", "contacts", "overlap")}
        while reached < begin - 1e-9 and total < budget:
            reached = min(begin, reached + 0.01)
            timed(reached)
        if total >= budget:
            continue
        spent, positions = timed(end)
        reached = end
        found = gaps(positions, half)
        out[f"{stage} ms"] = 1e3 * spent / ((end - begin) / STEP)
        out[f"{stage} contacts"] = len(found)
        out[f"{stage} overlap"] = max(0.0, -float(found.min())) if len(found) else 0.0
    return out


def table(found: Sequence[dict[str, Any]]) -> str:
    def shown(value: float, digits: str) -> str:
        return "" if math.isnan(value) else f"{value:{digits}}"

    lines = []
    for row in found:
        cells = [str(row["spheres"]), row["series"]]
        for stage in ("falling", "settled"):
            cost, contacts = row[f"{stage} ms"], row[f"{stage} contacts"]
            cells += [
                shown(contacts, ".0f"),
                shown(cost, ".3g"),
                shown(1e3 * cost / contacts if contacts else math.nan, ".3g"),
            ]
        lines.append([*cells, shown(1e3 * row["settled overlap"], ".1e")])
    return rows(
        ["spheres", "engine", "falling: contacts", "CPU per ms [ms]", "per contact [µs]", "settled: contacts",
         "CPU per ms [ms]", "per contact [µs]", "deepest overlap [mm]"], lines,
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--spheres", type=int, nargs="+", default=COUNTS)
    parser.add_argument("--ten-thousand", action="store_true", help="10 000 spheres, too")
    parser.add_argument("--only", nargs="+", choices=list(SERIES), default=list(SERIES))
    parser.add_argument("--budget", type=float, default=600.0, help="of a run [s]")
    parser.add_argument("--print", action="store_true", help="do not write to docs/nonsmooth-measurements.md")
    given = parser.parse_args()
    found = []
    for count in [*given.spheres, *([10_000] if given.ten_thousand else [])]:
        for name in given.only:
            if importlib.util.find_spec(SERIES[name][0]) is None:
                continue
            found.append(measured(name, count, given.budget))
            print(
                ", ".join(
                    f"{key} {x:.3g}" if isinstance(x, float) else f"{x}" for key, x in found[-1].items()
                ),
                flush=True,
            )
    (ROOT / "out" / "nonsmooth").mkdir(parents=True, exist_ok=True)
    with (ROOT / "out" / "nonsmooth" / "piles.csv").open("w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, list(found[0]))
        out.writeheader()
        out.writerows(found)
    if given.print:
        print(table(found))
    else:
        page = ROOT / "docs" / "nonsmooth-measurements.md"
        put(page, "benchmarks/contacts/piles.py", {"piles": table(found)})


if __name__ == "__main__":
    main()
