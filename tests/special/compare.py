# SPDX-License-Identifier: BSD-3-Clause
"""Compares results that must not depend on the way a mechanism is computed, and reports every difference."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mechanisms import Array, Scene, reordered

from gelenk.linear import LinearModel

from . import plants
from .bodies import Poses, UnknownError
from .drawn import Case, at_rest, values_of
from .moving_bodies import MovingBodies
from .plants import STOP, TOLERANCE, Start, beside, guess_error, same_sign, start_of, whole_vectors, without

ROUNDING = 1e-9  # closures to 1e-14 of the size, after some divisions by pivots
SOLVER = 1e-6  # 1e4 times the tolerance of 1e-10: accumulated error of steps where a motion amplifies errors
QUOTIENT = 1e-5  # closures of 1e-14 over steps of 1e-4 twice, and the curvature that two steps do not resolve
NEAREST = (
    1e-3  # values not given have a weight of a ten-thousandth in the squares, or none where a loop is cut
)
ALARM = 1e-3  # a warning is justified if the smallest pivot is a ten-thousandth of its value elsewhere
TIGHTER = 0.1
STEP, SLOW = 2e-4, 60  # rad, m; s of CPU time: three times what the slowest comparison takes here
# Refusals at positions that need not be singular.
DOCUMENTED = ("not all rotations of a joint with a quaternion are free", "moves without inertia")


@dataclass(frozen=True)
class Verdict:
    """One comparison; study.py explains its kinds."""

    check: str
    kind: str
    words: str = ""


class Comparison:
    """All comparisons of one start."""

    def __init__(self, case: Case, seed: int = 0) -> None:
        self.case = case
        self.seed = seed
        self.base = Start(case.source)
        # The rotation of a massless rod between ball joints about itself is arbitrary and depends on the
        # order of the file.
        light = {n for n, b in case.source["bodies"].items() if b["mass"] == 0}
        self.open = self.beside(light)

    # --- the independent model's view of the position ---

    @cached_property
    def model(self) -> MovingBodies | str:
        try:
            return MovingBodies(self.case.source)
        except UnknownError as e:
            return str(e)

    @cached_property
    def poses(self) -> Poses | None:
        """Poses of the bodies; None if unknown."""
        if isinstance(self.model, str):
            return None
        start = self.base if not isinstance(self.base.plant, str) else Start(at_rest(self.case.source))
        values = values_of(self.case.source) if isinstance(start.plant, str) else start.values
        try:
            x = self.model.poses(values)
        except KeyError:
            return None
        return x if np.abs(self.model.closure_errors(x)).max(initial=0) < 1e-8 else self.model.closed(x)

    @cached_property
    def rank(self) -> tuple[int, float] | None:
        """Rank of the joint constraints here, and the smallest nonzero singular value."""
        return None if isinstance(self.model, str) or self.poses is None else self.model.rank(self.poses)

    @cached_property
    def has_zero_length_spring(self) -> bool:
        """Whether a spring has zero length, so that its direction is undefined."""
        if isinstance(self.model, str) or isinstance(self.base.plant, str):
            return False
        return self.model.has_zero_length_spring(self.model.poses(self.base.values))

    @cached_property
    def singular(self) -> bool:
        if self.rank is None or isinstance(self.model, str) or self.poses is None:
            return self.has_zero_length_spring
        return self.has_zero_length_spring or self.model.singular(self.poses)

    @property
    def share(self) -> float:
        """Factor by which the smallest pivot may amplify round-off."""
        return 1.0 if self.rank is None else 1 / self.rank[1]

    def verdict(self, check: str, words: str, other: Start | None = None) -> Verdict:
        if not self.singular:
            return Verdict(check, "DISAGREE", words)
        warned = self.base.warned or (other is not None and other.warned)  # at least the incorrect one
        return Verdict(check, "warned" if warned else "SINGULAR", words)

    def refused(self, check: str, words: str) -> Verdict:
        if plants.CRASH in words:
            return Verdict(check, "CRASH", words)
        if any(known in words for known in DOCUMENTED):
            return Verdict(check, "refused", words)
        return Verdict(check, "refused" if self.singular else "REFUSED", words)

    # --- the comparisons ---

    def verdicts(self) -> Iterator[Verdict]:
        began = time.process_time()
        plant = self.base.plant
        yield from self.compared_starts()
        if not isinstance(plant, str):
            warned = self.base.warned_of_singularity
            if warned and self.rank is not None and not self.singular and self.rank[1] > ALARM:
                yield Verdict("warning", "ALARM", warned)
            yield from self.assemblies()
            yield from self.independent_model()
            yield from self.linear_models()
            yield from self.runs()
        spent = time.process_time() - began
        if spent > SLOW:
            yield Verdict("time", "SLOW", f"{spent:.1f} s")

    @cached_property
    def pinned(self) -> Scene:
        """The scene with all coordinates and velocities found by the first start, which must not change."""
        if isinstance(self.base.plant, str):
            return self.case.source
        out = copy.deepcopy(self.case.source)
        for joint, entry in out["joints"].items():
            found = start_of(self.base, joint)
            fixed = entry.get("start", {}).get("fixed")
            entry["start"] = found | ({"fixed": fixed} if fixed else {})
        return out

    @cached_property
    def others(self) -> list[Start]:
        source = self.pinned
        every = dict.fromkeys(("all",), False)
        light = any(b["mass"] == 0 for b in source["bodies"].values())
        if light:
            every = {"all": False, "massless": True}
        other = reordered(source, 100 + self.seed)
        return [
            Start(without(source, **every), "all off"),
            Start(other, "reordered"),
            Start(without(other, cut_choice=False), "cut by another order"),
            Start(without(reordered(source, 200 + self.seed), **every), "all off, another order"),
        ]

    def compared_starts(self) -> Iterator[Verdict]:
        plant = self.base.plant
        if isinstance(plant, str) and not self.case.reachable:
            words = [other.plant for other in self.others if isinstance(other.plant, str)]
            kind = "refused" if len(words) == len(self.others) else "REFUSED"
            yield Verdict("start", kind, plant)
            return
        for other in self.others:
            check = f"start: {other.label}"
            there = other.plant
            if isinstance(plant, str) or isinstance(there, str):
                refusals = [x for x in (plant, there) if isinstance(x, str)]
                both = "both: " if len(refusals) == 2 else ("base: " if isinstance(plant, str) else "other: ")
                yield self.refused(check, both + refusals[0])
                continue
            if not self.base.values or not other.values:
                yield self.refused(check, "values cannot be read")
                continue
            yield self.values_agree(check, other)

    def values_agree(self, check: str, other: Start) -> Verdict:
        mine, levels = self.base.values, self.base.levels
        size = dict.fromkeys((-1, 0, 1, 2), 1.0)
        for name, value in mine.items():
            level = levels[name] if levels[name] in size else -1
            size[level] = max(size[level], abs(value))
        faults = []
        for name, value in mine.items():
            if self.is_open(name):
                continue
            level = levels[name] if levels[name] in size else -1
            found = other.values[name]
            gap = abs(found - value)
            if ".Q[" in name:
                gap = min(gap, abs(found + value))
            bound = ROUNDING * size[level] * self.share ** max(level, 0)
            if not gap <= bound:
                faults.append((gap / bound, f"{name}: {value:.10g} / {found:.10g}"))
        return self.judged(check, faults, other)

    def judged(self, check: str, faults: list[tuple[float, str]], other: Start | None = None) -> Verdict:
        if not faults:
            return Verdict(check, "agree")
        faults.sort(key=lambda fault: -fault[0])
        return self.verdict(
            check, "; ".join(words for _, words in faults[:4]) + f" ({len(faults)} differ)", other
        )

    def assemblies(self) -> Iterator[Verdict]:
        """Conflicting guesses: another order of the file finds a position equally close to them."""
        other = Start(reordered(self.case.source, 100 + self.seed), "reordered")
        if self.case.exact or isinstance(other.plant, str):
            return
        mine, there = guess_error(self.case.source, self.base), guess_error(self.case.source, other)
        if abs(mine - there) <= NEAREST * (mine + there) + NEAREST**2:
            yield Verdict("assembly", "agree")
        else:
            words = f"guesses deviate by {mine:.6g}, in another order of the file by {there:.6g}"
            yield Verdict("assembly", "ELSEWHERE", words)

    def independent_model(self) -> Iterator[Verdict]:
        if isinstance(self.model, str):
            return
        given, values = values_of(self.case.source), self.base.values
        if self.case.exact:
            faults = [
                (abs(values[n] - x) / 1e-10, f"{n}: given {x:.12g}, found {values[n]:.12g}")
                for n, x in given.items()
                if ".Q[" not in n and not abs(values[n] - x) <= 1e-10
            ]
            yield self.judged("start kept", faults)
        x = self.model.poses(values)
        gap = float(np.abs(self.model.closure_errors(x)).max(initial=0))
        if gap > 1e-9:
            yield Verdict("closed", "DISAGREE", f"the closure error is {gap:.3g}")
            return
        plant = self.base.plant
        if self.rank is None or self.has_zero_length_spring:
            return
        assert not isinstance(plant, str)
        degrees_of_freedom = self.model.size - self.rank[0]
        if not self.open and plant.size.degrees_of_freedom != degrees_of_freedom and not self.singular:
            yield self.verdict(
                "degrees of freedom", f"{plant.size.degrees_of_freedom} / {degrees_of_freedom}"
            )
        if self.rank[1] < 1e-3 and self.singular:
            return  # the independent model does not apply here
        V = self.model.twist(x, values)
        expected = self.model.accelerations(x, V, values)
        size = max([1.0, *(abs(a) for a in expected.values())])
        bound = 1e-7 * size * self.share
        faults = [
            (abs(values[n] - a) / bound, f"{n}: {values[n]:.8g} / {a:.8g}")
            for n, a in expected.items()
            if n in values and not self.is_open(n) and not abs(values[n] - a) <= bound
        ]
        if faults and self.singular and plant.size.degrees_of_freedom < degrees_of_freedom:
            # For loops that are rigid to second order it permits motions that their first-order equations
            # allow.
            yield Verdict("accelerations by all bodies", "skipped", "degrees of freedom of first order only")
            return
        yield self.judged("accelerations by all bodies", faults)

    def beside(self, bodies: set[str]) -> set[str]:
        """Joints at these bodies."""
        joints = self.case.source["joints"]
        return {n for n, j in joints.items() if {j["parent"]["body"], j["child"]["body"]} & bodies}

    def is_open(self, name: str) -> bool:
        return name.partition(".")[0] in self.open

    # --- linear models ---

    def linear_models(self) -> Iterator[Verdict]:
        model = self.base.linear()
        if isinstance(model, str):
            yield self.refused("linear", f"base: {model}")
            return
        for other in self.others:
            check = f"linear: {other.label}"
            if isinstance(other.plant, str):
                continue
            there = other.linear(model.states)
            if isinstance(there, str):
                by_its_own = other.linear()  # a refusal that concerns its states, not these
                yield self.refused(check, f"other: {by_its_own if isinstance(by_its_own, str) else there}")
                continue
            if set(there.outputs) != set(model.outputs):
                yield self.verdict(
                    check, f"{len(model.states)} states do not determine all outputs there", other
                )
                continue
            faults = []
            for part in "ABCD":
                mine, found = getattr(model, part), getattr(there, part)
                faults += self.mismatch(part, mine, found, model, 1e3 * ROUNDING * self.share, there.outputs)
            yield self.judged(check, faults, other)
        yield self.finite_differences(model)

    def mismatch(
        self, part: str, mine: Array, found: Array, model: LinearModel, share: float, outputs: Sequence[str]
    ) -> list[tuple[float, str]]:
        rows = list(model.states) if part in "AB" else list(model.outputs)
        columns = list(model.states) if part in "AC" else list(model.inputs)
        if part in "CD":
            found = found[[list(outputs).index(name) for name in rows]]
        if part in "BD":
            found = found[:, [columns.index(n) for n in columns]]
        out = []
        size = 1 + np.abs(mine).max(initial=0)
        for i, j in zip(*np.nonzero(~(np.abs(mine - found) <= share * size)), strict=True):
            if self.is_open(rows[i]):
                continue
            words = f"{part}[{rows[i]}, {columns[j]}]: {mine[i, j]:.8g} / {found[i, j]:.8g}"
            out.append((float(abs(mine[i, j] - found[i, j]) / (share * size)), words))
        return out

    def finite_differences(self, model: LinearModel) -> Verdict:
        """C by central differences of plants that start at neighboring positions."""
        check = "linear: finite differences"
        if not whole_vectors(model.states):
            return Verdict(check, "skipped", "part of a vector among the states")
        derivatives = {state: model.C[:, k] for k, state in enumerate(model.states)}
        if list(model.outputs) != list(self.base.values):
            return Verdict(check, "skipped", "other outputs")
        faults, rough = [], 0
        for k, state in enumerate(model.states):
            found: list[Array] = []
            for h in (STEP, 2 * STEP):
                sides = []
                for sign in (1, -1):
                    side = Start(beside(self.base, model.states, {state: sign * h}, derivatives))
                    if isinstance(side.plant, str):
                        return self.refused(check, f"at {state} {sign * h:+g}: {side.plant}")
                    if not side.values:
                        return self.refused(check, f"at {state} {sign * h:+g}: values cannot be read")
                    sides.append(np.array(list(same_sign(side.values, self.base.values).values())))
                found.append((sides[0] - sides[1]) / (2 * h))
            best = (4 * found[0] - found[1]) / 3
            doubt = np.abs(found[0] - found[1])
            mine = model.C[:, k]
            size = 1 + np.abs(mine).max() + float(np.abs(list(self.base.values.values())).max())
            bound = 0.5 * doubt + QUOTIENT * size * min(self.share, 1e3)
            rough += int((doubt > 0.05 * size).any())
            for i in np.nonzero(~(np.abs(best - mine) <= bound))[0]:
                gap = float(abs(best[i] - mine[i]) / bound[i])
                if self.is_open(model.outputs[i]):
                    continue
                faults.append((gap, f"C[{model.outputs[i]}, {state}]: {mine[i]:.8g} / {best[i]:.8g}"))
        if rough and not faults:
            return Verdict(check, "agree", f"{rough} columns are rough")
        return self.judged(check, faults)

    # --- runs ---

    def runs(self) -> Iterator[Verdict]:
        mine = self.base.run
        if isinstance(mine, str):
            yield self.refused("run", f"base: {mine}")
        for other in (self.others[0], self.others[2]):
            check = f"run: {other.label}"
            if isinstance(other.plant, str):
                continue
            there = other.run
            if isinstance(mine, str) or isinstance(there, str):
                if isinstance(mine, str) and isinstance(there, str):
                    continue
                yield self.refused(
                    check, f"other: {there}" if isinstance(there, str) else "only the base is refused"
                )
                continue
            faults = self.deviations(mine, there)
            yield (
                Verdict(check, "sensitive", faults[0][1])
                if faults and self.sensitive
                else self.judged(check, faults, other)
            )

    @cached_property
    def sensitive(self) -> bool:
        """Whether a run at another tolerance also ends elsewhere: the motion amplifies errors."""
        mine, there = self.base.run, Start(self.case.source, tolerance=TIGHTER * TOLERANCE).run
        return not isinstance(mine, str) and not isinstance(there, str) and bool(self.deviations(mine, there))

    def deviations(self, mine: Mapping[str, float], there: Mapping[str, float]) -> list[tuple[float, str]]:
        size = max([1.0, *(abs(x) for x in mine.values())])
        bound = SOLVER * size * min(self.share, 1e3)
        out = []
        for name, value in mine.items():
            if self.is_open(name):
                continue
            gap = abs(there[name] - value)
            if ".Q[" in name:
                gap = min(gap, abs(there[name] + value))
            if not gap <= bound:
                out.append((gap / bound, f"{name} at {STOP} s: {value:.8g} / {there[name]:.8g}"))
        return out


def compared(case: Case, seed: int = 0) -> list[Verdict]:
    return list(Comparison(case, seed).verdicts())
