# SPDX-License-Identifier: BSD-3-Clause
"""Random drives: shafts with clutches and one-way clutches on them, coupled by a gear with losses.

As a program, `python -m models.random_drives [first] [count]` compares many of them with the search through
all modes of models/drive_trains.py.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Array, Scene, body, frame, joint, scene

import gelenk

from .drive_elements import Friction, LossyGear, OneWay
from .drive_trains import DriveTrain

SEGMENT, SEGMENTS = 0.1, 10
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Drive:
    source: Scene
    train: DriveTrain
    start: Array  # speeds of the inertias
    knots: Array  # torques by segment end and inertia
    outputs: list[list[str]]  # the speeds of which the speed of each inertia is the sum


def turning(parent: str, child: str, w: float, **fields: Any) -> dict[str, Any]:
    start = {"phi": 0.0, "w": w, "fixed": True}
    return joint("revolute", frame(parent), frame(child), start=start, **fields)


def random_drive(seed: int) -> Drive:
    """Return one with one or two shafts; many numbers are round, and many speeds equal."""
    rng = np.random.default_rng(seed)
    speeds: list[float] = []
    elements: list[Friction | OneWay | LossyGear] = []
    outputs: list[list[str]] = []
    bodies: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    sections: dict[str, Any] = {}
    inertias: list[float] = []

    def add(name: str, w: float) -> int:
        inertias.append(float(rng.choice([0.5, 1.0, 2.0, rng.uniform(0.2, 3)])))
        bodies[name] = body(1, inertia=(0, 0, inertias[-1]))
        speeds.append(w)
        return len(inertias) - 1

    geared = rng.random() < 0.6
    ratio = float(rng.choice([1.0, 2.0, -3.0, rng.uniform(0.5, 4)]))
    w0 = float(rng.choice([0.0, 0.0, 1.0, rng.uniform(-3, 3)]))
    rows: list[tuple[int, int]] = []
    bearing = float(rng.choice([0.0, 0.5, 1.0]))  # of the first shaft

    def constant(value: float) -> Callable[[Array], float]:
        return lambda _u: value

    for shaft in range(2 if geared else 1):
        w = w0 if shaft == 0 else w0 / ratio
        name = f"shaft{shaft}"
        mine = add(name, w)
        # The losses of the gear are friction of the first shaft, the only one that may stick on its own.
        friction = {"friction": {"coulomb": bearing}} if shaft == 0 else {}
        joints[name] = turning("ground", name, w, **friction)
        outputs.append([f"{name}.w"])
        if shaft == 0 and not geared:
            row = np.zeros(4)
            row[mine] = 1
            elements.append(Friction(row, constant(bearing), constant(bearing)))
        if shaft == 1:
            driving, driven = (float(x) for x in rng.choice([1.0, 0.9, 0.6, 0.4], 2))
            elements.append(LossyGear(0, mine, ratio, driving, driven, bearing))
            mesh = {"type": "gear", "joint": "shaft0", "with": name, "ratio": ratio}
            sections["constraints"] = {"mesh": {**mesh, "efficiency": driving, "backdriving": driven}}
        if rng.random() < 0.75:
            slip = float(rng.choice([0.0, 0.0, 1.0, rng.uniform(0, 2)]))
            wheel = add(f"wheel{shaft}", w + slip)
            rows.append((mine, wheel))
            sliding = float(rng.choice([0.0, 1.0, rng.uniform(0.1, 3)]))
            static = sliding * float(rng.choice([1.0, 1.0, 1.3]))
            fields: dict[str, Any] = {"friction": {"coulomb": sliding, "static": static}}
            one_way = rng.random() < 0.5
            if one_way:
                fields["one_way"] = {"free": "positive"}
            joints[f"wheel{shaft}"] = turning(name, f"wheel{shaft}", slip, **fields)
            outputs.append([f"{name}.w", f"wheel{shaft}.w"])
            row = np.zeros(4)
            row[[mine, wheel]] = -1, 1
            kind = OneWay if one_way else Friction
            elements.append(kind(row, constant(sliding), constant(static)))
    n = len(inertias)
    cut: list[Friction | OneWay | LossyGear] = []
    for e in elements:
        if isinstance(e, LossyGear):
            cut.append(e)
        else:
            cut.append((Friction if isinstance(e, Friction) else OneWay)(e.row[:n], e.sliding, e.static))
    sections["motors"] = {f"torque{k}": {"joint": name} for k, name in enumerate(joints)}
    knots = rng.choice([0.0, 1.0, -2.0, 4.0], (SEGMENTS + 1, n)) + rng.choice(
        [0.0, 1.0], (1, n)
    ) * rng.uniform(-3, 3, (SEGMENTS + 1, n))
    # Motors act between the bodies of their joint.
    share = np.eye(n)
    for inner, wheel in rows:
        share[inner, wheel] = -1
    train = DriveTrain(np.array(inertias), lambda u, _phi, _w: share @ u, cut)
    source = scene(bodies, joints, gravity=[0, 0, 0], **sections)
    return Drive(source, train, np.array(speeds), knots, outputs)


def difference(drive: Drive, integrator: str = "erk") -> float:
    """Return the largest difference of speeds relative to the largest speed, or 1."""
    expected = np.array([
        y[len(drive.start) :]
        for y in drive.train.run(
            lambda t: drive.knots[min(SEGMENTS, round(t / SEGMENT))], SEGMENT, SEGMENTS, drive.start
        )
    ])  # fmt: skip
    plant = gelenk.Simulation(gelenk.load({**drive.source, "solver": {"integrator": integrator}}))
    plant.initialize(0.0, TOLERANCE)
    found = []
    for k in range(SEGMENTS):
        for i, signal in enumerate(plant.inputs):
            plant.set_input(str(signal.name), float(drive.knots[k, i]))
            slope = (drive.knots[k + 1, i] - drive.knots[k, i]) / SEGMENT
            plant.set_input_derivative(str(signal.name), 1, float(slope))
        plant.step_to((k + 1) * SEGMENT)
        found.append([sum(plant.output(name) for name in names) for names in drive.outputs])
    return float(np.abs(np.array(found) - expected).max() / max(1.0, np.abs(expected).max()))


def main() -> None:
    first, count = (int(x) for x in [*sys.argv[1:], "0", "100"][:2])
    outcomes: Counter[str] = Counter()
    for seed in range(first, first + count):
        try:
            error = difference(random_drive(seed))
        except AssertionError:
            outcomes["no reference"] += 1  # no modes within its rounding
            continue
        except gelenk.StepError as e:
            outcomes[f"refused: {e.args[0][:80]}"] += 1
            continue
        outcomes["right" if error <= 1000 * TOLERANCE else "wrong"] += 1
        if error > 1000 * TOLERANCE:
            print(f"seed {seed}: {error:.2g}")
    print(dict(outcomes))


if __name__ == "__main__":
    main()
