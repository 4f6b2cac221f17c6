# SPDX-License-Identifier: BSD-3-Clause
"""What must be true of each mechanism with friction and limits, by its outputs and events.

`python -m properties.nonsmooth_laws 0 3000`, in tests, checks these mechanisms, one line of JSON for each.
"""

from __future__ import annotations

import faulthandler
import json
import sys
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gelenk

from .nonsmooth_mechanisms import COORDINATES, STEP, STEPS, Trial, drawn

Array = NDArray[np.float64]
SECONDS_EACH = 120  # of computation, far more than any takes
PENETRATION = 1e-8  # rad, m; a limit may be exceeded by rounding only
FASTEST = 100.0  # rad/s, m/s; faster motions diverge within a run, without any event, too
MOST_EVENTS = 4000  # a run of 0.8 s; series of impacts end after some 40 each
LISTED_EVENTS = 256  # in a step; later ones are only counted


class FaultError(Exception):
    """A mechanism does what it must not."""


@dataclass
class Joint:
    """A joint with one degree of freedom, and the names of its outputs."""

    name: str
    fields: dict[str, Any]
    q: str
    v: str
    motor: str  # its input, or nothing
    ratio: float

    @property
    def friction(self) -> dict[str, float]:
        given: dict[str, float] = self.fields.get("friction", {})
        return {"coulomb": 0.0} | given

    @property
    def static(self) -> float:
        return self.friction.get("static", self.friction["coulomb"])


@dataclass
class Run:
    """What was found in a run: for each step its values and events, and why it ended early."""

    rows: list[dict[str, float]] = field(default_factory=list)
    inputs: list[dict[str, float]] = field(default_factory=list)
    events: list[list[tuple[float, str]]] = field(default_factory=list)
    last: bytes = b""
    refusal: str = ""


def joints_of(trial: Trial) -> list[Joint]:
    out = []
    for name, fields in trial.scene["joints"].items():
        if fields["type"] not in COORDINATES:
            continue
        motor = trial.scene.get("motors", {}).get(f"M{name}")
        effort = "f" if fields["type"] == "prismatic" else "tau"
        q, v = (f"{name}.{x}" for x in COORDINATES[fields["type"]])
        ratio = motor["gear_ratio"] if motor else 0.0
        out.append(Joint(name, fields, q, v, f"M{name}.{effort}" if motor else "", ratio))
    return out


def is_tree(trial: Trial) -> bool:
    return len(trial.scene["joints"]) == len(trial.scene["bodies"])


def started(trial: Trial, integrator: str = "") -> gelenk.Simulation:
    source = trial.source
    if integrator:
        source["solver"]["integrator"] = integrator
    simulation = gelenk.Simulation(source)
    for name, value in trial.schedule[0].items():
        simulation.set_input(name, value)
    simulation.initialize(0.0, trial.tolerance)
    return simulation


def advance(simulation: gelenk.Simulation, trial: Trial, first: int, last: int, *, reads: bool) -> Run:
    """Make these steps. Outputs are read after each, also under other inputs, or not at all."""
    out = Run()
    names = [signal.name for signal in simulation.outputs]
    for k in range(first, last):
        inputs = trial.schedule[k // STEPS]
        for name, value in inputs.items():
            simulation.set_input(name, value)
        if reads and k == 0:
            out.rows.append(dict(zip(names, simulation.values().tolist(), strict=True)))
        try:
            simulation.step_to((k + 1) * STEP)
        except gelenk.StepError as error:
            out.refusal = f"{type(error).__name__}: {error}"
            break
        if not reads:
            continue
        out.rows.append(dict(zip(names, simulation.values().tolist(), strict=True)))
        out.inputs.append(inputs)
        out.events.append(list(simulation.events))
        if trial.integrator in ("erk", "rk4"):  # others restart when an input has been changed
            for name in inputs:
                simulation.set_input(name, 50.0)
            simulation.values()
    for name, value in trial.schedule[-1].items():
        simulation.set_input(name, value)
    out.last = simulation.values().tobytes()
    return out


def check(trial: Trial) -> dict[str, Any]:
    """Raise FaultError if something is wrong with it. Otherwise return what has happened."""
    steps = STEPS * len(trial.schedule)
    middle = steps // 2
    try:
        first = started(trial)
    except (gelenk.SceneError, gelenk.AssemblyError) as error:
        require_reason(str(error))
        return {"is": "refused", "why": str(error)}
    run = advance(first, trial, 0, middle, reads=True)
    saved = first.save()
    if not run.refusal:
        rest = advance(first, trial, middle, steps, reads=True)
        run = Run(
            run.rows + rest.rows, run.inputs + rest.inputs, run.events + rest.events, rest.last, rest.refusal
        )
    if run.refusal:
        require_reason(run.refusal)
    check_laws(trial, run)
    if len(run.inputs) >= middle:
        restored = started(trial)
        restored.restore(saved)
        require(advance(restored, trial, middle, steps, reads=False).last == run.last, "restored: other bits")
    check_unread(trial, run, middle, steps)
    events = sum(map(len, run.events))
    require(events <= MOST_EVENTS or is_fast(trial, run), f"events: {events}")
    agreement = check_other(trial, run)
    evaluations = first.diagnostic("solver.evaluations")
    return {
        "is": "stopped" if run.refusal else "ran",
        "why": run.refusal,
        "events": events,
        "evaluations": evaluations,
        **agreement,
    }


def is_fast(trial: Trial, run: Run) -> bool:
    return any(abs(row[joint.v]) > FASTEST for row in run.rows for joint in joints_of(trial))


def check_unread(trial: Trial, run: Run, middle: int, steps: int) -> None:
    """Without reading of outputs, but with the same save, everything is the same."""
    plant = started(trial)
    found = advance(plant, trial, 0, middle, reads=False)
    plant.save()
    if not found.refusal:
        found = advance(plant, trial, middle, steps, reads=False)
    require(
        found.refusal == run.refusal,
        f"reading: other end: {found.refusal or 'none'}; {run.refusal or 'none'}",
    )
    require(found.last == run.last, "reading: other bits")


def require(holds: bool, text: str) -> None:
    if not holds:
        raise FaultError(text)


def require_reason(text: str) -> None:
    require(
        len(text) > 30 and "nan" not in text.lower().split(),
        f"text: {text}",
    )
    require("StepBudgetError" not in text, f"cost: {text}")


def check_laws(trial: Trial, run: Run) -> None:
    joints = joints_of(trial)
    for k, row in enumerate(run.rows):
        require(all(np.isfinite(x) for x in row.values()), f"finite: step {k}")
        for joint in joints:
            check_limits(joint, row, k)
            check_reaction(trial, joint, row, run.inputs[max(k - 1, 0)] if run.inputs else {}, k)
    check_rest(trial, run)
    check_energy(trial, run)


def check_limits(joint: Joint, row: dict[str, float], k: int) -> None:
    q = row[joint.q]
    limit = joint.fields.get("limit", {})
    for side, bound in ((1, limit.get("upper")), (-1, limit.get("lower"))):
        if bound is not None:
            beyond = side * (q - bound)
            require(
                beyond <= PENETRATION * max(1, abs(bound)), f"limit: {joint.name} by {beyond:.3g} at step {k}"
            )


def check_rest(trial: Trial, run: Run) -> None:
    """From `sticks` until `slips`, a joint of a tree has no speed at all."""
    if not is_tree(trial):
        return
    for joint in joints_of(trial):
        sticks = False
        for k, events in enumerate(run.events):
            for _, text in events:
                if text.startswith(f"{joint.q} "):
                    sticks = text.endswith(" sticks") or (sticks and "leaves" in text)
            sticks = sticks and len(events) < LISTED_EVENTS
            v = run.rows[k + 1][joint.v]
            require(not sticks or v == 0, f"rest: {joint.name} at step {k} has {v:.3g}")


def check_reaction(
    trial: Trial, joint: Joint, row: dict[str, float], inputs: dict[str, float], k: int
) -> None:
    """What the joint exerts along its coordinate, less motor, spring and damper, is friction and contact:
    friction within its limit, and opposite to the motion.
    """
    if f"R{joint.name}.t[1]" not in row:
        return
    if joint.motor and trial.scene["motors"][f"M{joint.name}"]["rotor_inertia"] > 0:
        return
    q, v = row[joint.q], row[joint.v]
    axis = np.array(joint.fields["axis"], float)
    axis /= np.linalg.norm(axis)
    force, moment = (np.array([row[f"R{joint.name}.{x}[{i}]"] for i in (1, 2, 3)]) for x in "ft")
    kind = joint.fields["type"]
    along = axis @ (force if kind == "prismatic" else moment)
    if kind == "screw":
        along += joint.fields["pitch"] * axis @ force
    known = joint.ratio * inputs.get(joint.motor, 0.0) - joint.fields.get("damping", 0.0) * v
    known -= joint.fields.get("stiffness", 0.0) * (q - joint.fields.get("spring_reference", 0.0))
    stop = joint.fields.get("stop")
    if stop:
        for side, bound in ((1, stop.get("upper")), (-1, stop.get("lower"))):
            if bound is None:
                continue
            depth = side * (q - bound)
            if abs(depth) < 1e-9:
                return  # on either side of the jump of its damping
            if depth > 0:
                known -= side * max(0.0, stop["stiffness"] * depth + side * stop["damping"] * v)
    rest = along - known
    size = np.abs(force).max() + np.abs(moment).max() + abs(known)
    slack = 1e-6 * size + 1e-7 + 1e-6 * joint.static
    upper = lower = joint.static
    limit = joint.fields.get("limit", {})
    for name in limit:
        if name != "restitution" and abs(q - limit[name]) < 1e-7:
            if name == "upper":
                lower = np.inf
            else:
                upper = np.inf
    # In a loop, several joints at rest share what holds it, in a way that is not unique.
    holds = not is_tree(trial) or -lower - slack <= rest <= upper + slack
    require(holds, f"law: {joint.name} at step {k} exerts {rest:.6g}, limit {joint.static}")
    if abs(v) > 1e-6 and np.isfinite(lower + upper):
        f = joint.friction
        magnitude = f["coulomb"]
        if f.get("stribeck", 0) > 0:
            magnitude += (joint.static - magnitude) * np.exp(-((v / f["stribeck"]) ** 2))
        require(
            abs(rest + np.sign(v) * magnitude) <= slack,
            f"law: {joint.name} at step {k} with {v:.3g} exerts {rest:.6g}, friction {magnitude:.6g}",
        )


def check_energy(trial: Trial, run: Run) -> None:
    """Energy grows by the work of motors, less that of friction, at most."""
    joints = joints_of(trial)
    if trial.integrator == "rk4":
        return  # of fixed steps: no tolerance
    lossless = not trial.scene.get("forces", {}).get("F", {}).get("damping") and all(
        not joint.fields.get("damping")
        and not joint.fields.get("stop", {}).get("damping")
        and "stribeck" not in joint.friction
        for joint in joints
    )
    exchanged = 1.0
    for k, inputs in enumerate(run.inputs):
        before, after = run.rows[k], run.rows[k + 1]
        exchanged = max(exchanged, after["E.kinetic"], abs(after["E.potential"]))
        supplied = 0.0
        for joint in joints:
            travel = after[joint.q] - before[joint.q]
            supplied += joint.ratio * inputs.get(joint.motor, 0.0) * travel
            supplied -= joint.friction["coulomb"] * abs(travel)
            exchanged = max(exchanged, abs(joint.ratio * inputs.get(joint.motor, 0.0) * travel))
        surplus = after["E.total"] - before["E.total"] - supplied
        bound = 300 * trial.tolerance * exchanged
        require(surplus <= bound, f"energy: step {k} gains {surplus:.3g} J, bound {bound:.3g}")
        if lossless and not run.events[k]:
            require(surplus >= -bound, f"energy: step {k} loses {surplus:.3g} J, bound {bound:.3g}")


def check_other(trial: Trial, run: Run) -> dict[str, Any]:
    """Another integrator finds the same, until the fourth event: some are decided by rounding."""
    count = 0
    seen = 0
    while count < len(run.events) and seen + len(run.events[count]) <= 3:
        seen += len(run.events[count])
        count += 1
    speeds = [abs(row[joint.v]) for row in run.rows[: count + 1] for joint in joints_of(trial)]
    if count == 0 or trial.integrator == "rk4" or max(speeds) > FASTEST:
        return {}
    other = "ida" if trial.integrator in ("auto", "erk") else "erk"
    found = advance(started(trial, other), trial, 0, count, reads=True)
    if len(found.rows) <= count:
        return {"other": found.refusal}
    a, b = run.rows[count], found.rows[count]
    worst = 0.0
    for joint in joints_of(trial):
        for name in (joint.q, joint.v):
            worst = max(worst, abs(a[name] - b[name]) / (1 + abs(a[name])))
    multiple = worst / trial.tolerance  # below 1, but for few; impacts magnify errors
    require(multiple <= 1000, f"other: integrators differ by {multiple:.3g} times the tolerance")
    return {"difference": multiple}


def main(first: int, last: int) -> None:
    """Check these; a line is written before each, so that one that crashes is known."""
    warnings.simplefilter("ignore", UserWarning)
    for seed in range(first, last):
        print(json.dumps({"seed": seed}), flush=True)
        faulthandler.dump_traceback_later(SECONDS_EACH, exit=True)
        try:
            found = check(drawn(seed))
        except FaultError as fault:
            found = {"is": "fault", "why": str(fault)}
        except Exception as error:
            found = {"is": "fault", "why": f"{type(error).__name__}: {error}"}
        faulthandler.cancel_dump_traceback_later()
        print(json.dumps({"seed": seed, **found}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
