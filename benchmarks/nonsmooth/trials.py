# SPDX-License-Identifier: BSD-3-Clause
"""Trials of the failure map: scenes at the thresholds of friction and limits, with exact solutions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from benchmarks.nonsmooth import exact, problems
from benchmarks.nonsmooth.exact import Law, course, springy
from benchmarks.nonsmooth.problems import GRAVITY, Scene, at, exactly, joint
from benchmarks.nonsmooth.trial import Trial, coordinate, grid, wheel


@dataclass(frozen=True)
class Case:
    """A wheel under torques until each of the times."""

    row: str
    column: str
    law: Law
    x: float
    v: float
    times: Sequence[float]
    torques: Sequence[float]
    rate: float = (
        1.0  # 1/s, by which an error of the position multiplies that of the speed: acceleration / speed
    )

    def trial(self, family: str) -> Trial:
        """Return the trial, with the exact solution."""
        law = self.law
        found, events = course(law, self.x, self.v, self.times, self.torques)
        fields: dict[str, object] = {}
        if law.static > 0:
            fields["friction"] = {"coulomb": law.coulomb, "static": law.static}
        bounds = {"lower": law.lower, "upper": law.upper}
        limit = {name: x for name, x in bounds.items() if math.isfinite(x)}
        if limit:
            fields["limit"] = limit | {"restitution": law.restitution}
        scene = wheel(self.x, self.v, law.inertia, **fields)
        scale = max(1.0, self.rate, *(max(abs(x), abs(v)) for x, v in found), abs(self.v))
        return Trial(
            family, self.row, self.column, scene, self.times, coordinate(found), events, self.torques,
            "drive.tau", scale,
        )  # fmt: skip


STATICS = (1.0, 1.001, 1.2, 2.0, 10.0)
RATIOS = (0.5, 0.999999, 1.0, 1 + 1e-9, 1.000001, 2.0)


def breaking_away() -> Iterator[Trial]:
    """A wheel at rest under a constant torque near its static limit."""
    for unit in (1.0, 1e-6, 1e6):
        for static in STATICS:
            for ratio in RATIOS:
                law = Law(0.5 * unit, unit, static * unit)
                size = "" if unit == 1 else f", {unit:g} N m"
                case = Case(f"static/coulomb {static:g}{size}", f"{ratio:.10g}", law, 0.3, 0.0, grid(1.0), [])
                yield replace(case, torques=[ratio * law.static] * 20).trial("torque / static limit, at rest")


def coming_to_rest() -> Iterator[Trial]:
    """A wheel in motion under a constant torque."""
    for static in (1.0, 2.0):
        for torque in (-1.0, 0.0, 0.5, 1.0, 1 + 1e-9, -1 - 1e-9, 1.5, -1.5, -3.0):
            for speed in (1e-4, 1e-2, 1.0, 100.0):
                law = Law(0.5, 1.0, static)
                stop = speed / 0.5
                row = f"static/coulomb {static:g}, torque {torque:.10g} coulomb"
                case = Case(row, f"{speed:g} rad/s", law, 0.3, speed, grid(stop), [torque] * 20)
                yield case.trial("torque and initial speed")


def with_stribeck() -> Iterator[Trial]:
    """A wheel that slows down, or accelerates from rest, through its Stribeck speed."""
    for static in (1.2, 2.0, 10.0):
        for torque in (0.0, 0.5, 1.5):  # above 1: of the static limit
            for stribeck in (1e-4, 1e-2, 1.0, 100.0):
                law = Law(0.5, 1.0, static)
                load, v, times = torque, 1.0, grid(2.0)
                if torque > 1:
                    load, v = torque * static, 0.0
                found, events = exact.with_stribeck(law, stribeck, v, times, load)
                friction = {"coulomb": 1.0, "static": static, "stribeck": stribeck}
                row = f"static/coulomb {static:g}, from {v:g} rad/s, {load:g} N m"
                scale = max(1.0, *(max(abs(x), w) for x, w in found))
                yield Trial("Stribeck speed", row, f"{stribeck:g} rad/s",
                            wheel(0.0, v, friction=friction), times, coordinate(found), events, [load] * 20,
                            "drive.tau", scale)  # fmt: skip


def alternating() -> Iterator[Trial]:
    """Torques that change their sign at every communication step."""
    for static in (1.0, 2.0):
        for torque in (0.5, 1.0, 1.000001, 1.5, 2.000001, 4.0):
            for step in (1e-4, 1e-2, 1.0):
                times = [step * (k + 1) for k in range(40)]
                torques = [torque * (-1) ** k for k in range(40)]
                row = f"static/coulomb {static:g}, torque +-{torque:.10g}"
                yield Case(row, f"{step:g} s", Law(0.5, 1.0, static), 0.3, 0.0, times, torques).trial(
                    "alternating torque, period"
                )


def bouncing() -> Iterator[Trial]:
    """A wheel that a torque pushes towards its limit from a distance."""
    for restitution in (0.0, 0.5, 0.9, 0.99, 1.0):
        for distance in (1e-6, 1e-3, 1.0, 1e3):
            law = Law(0.5, lower=0.2, restitution=restitution)
            fall = math.sqrt(2 * distance * 0.5)  # torque -1 N m
            stop = 11.7 * fall if restitution < 0.95 else 20.4 * fall
            case = Case(f"restitution {restitution:g}", f"{distance:g} rad", law, 0.2 + distance, 0.0,
                        grid(stop, 23), [-1.0] * 23, rate=fall / distance)  # fmt: skip
            yield case.trial("fall to a limit from")


STARTS = {
    "at it, at rest": (0.0, 0.0), "at it, inwards": (0.0, 1.0), "at it, outwards": (0.0, -1.0),
    "1e-12 off, at rest": (1e-12, 0.0), "1e-9 off, at rest": (1e-9, 0.0), "1e-9 off, outwards": (1e-9, -1.0),
    "0.1 off, outwards": (0.1, -1.0),
}  # fmt: skip


def starting_at_limits() -> Iterator[Trial]:
    for side in (-1, 1):
        for words, (distance, inwards) in STARTS.items():
            for restitution in (0.0, 0.5) if 0 < distance < 1e-3 else (0.0, 0.5, 1.0):
                for torque in (0.0, 1e-9, 1.0, 1e3, -1e-9, -1.0):  # towards the limit
                    law = Law(0.5, lower=0.2, upper=3.2, restitution=restitution)
                    x = 0.2 + distance if side < 0 else 3.2 - distance
                    v = -side * inwards
                    stop = 0.88 if torque <= 1 else 0.0297
                    row = f"{'lower' if side < 0 else 'upper'}, {words}, e = {restitution:g}"
                    case = Case(row, f"push {torque:g} N m", law, x, v, grid(stop), [side * torque] * 20,
                                rate=2 * abs(torque))  # fmt: skip
                    trial = case.trial("start at a limit")
                    yield (
                        replace(trial, events=math.nan) if distance == 1e-12 else trial
                    )  # closer than rounding


def between_limits() -> Iterator[Trial]:
    for width in (1e-3, 0.1, 1.0):
        for restitution in (0.0, 0.5, 0.9, 1.0):
            for friction in (0.0, 1e-3, 0.1):
                law = Law(0.5, friction, friction, 0.0, width, restitution)
                times = grid(6.3 * width)
                case = Case(f"{width:g} rad apart, e = {restitution:g}", f"friction {friction:g} N m", law,
                            width / 3, 1.0, times, [0.0] * 20)  # fmt: skip
                yield case.trial("two limits")


def pressed_with_friction() -> Iterator[Trial]:
    """A wheel with friction at its limit: pressed, released, pulled away, pressed again."""
    for restitution in (0.0, 0.5, 1.0):
        for static in (1.0, 1.5):
            for pull in (0.5, 1.0, 1.2, 1.5, 1.500001, 3.0):
                law = Law(0.5, 1.0, static, lower=0.2, restitution=restitution)
                torques = [-3.0, -0.5, 0.0, 0.5, pull, -3.0, -3.0, -3.0, 0.0, 0.0, -0.5, pull]
                case = Case(f"e = {restitution:g}, static {static:g}", f"pull {pull:.10g}", law, 0.2, 0.0,
                            grid(6.0, 12), torques)  # fmt: skip
                yield case.trial("limit and friction")


def oscillating() -> Iterator[Trial]:
    """A spring-mass with friction loses an equal part of its amplitude in each half oscillation."""
    for static in (1.0, 1.5, 3.0):
        for count in (0.5, 1.0, 1 + 1e-9, 1.5, 3.0, 5.0, 10.3, 100.7):
            if (static, count) == (3.0, 5.0):
                continue  # stops by itself at its limit: within tolerance it sticks or slips
            law, stiffness = Law(0.5, 1.0, static), 50.0
            x = count / stiffness
            times = grid(min(60, count + 1) * math.pi / 10, 37)
            found, events = springy(law, stiffness, x, times)
            friction = {"coulomb": 1.0, "static": static}
            scene = wheel(x, 0.0, friction=friction, stiffness=stiffness)
            yield Trial("spring released at, over its friction", f"static/coulomb {static:g}",
                        f"{count:.10g}", scene, times, coordinate(found), events)  # fmt: skip


def on_belts() -> Iterator[Trial]:
    """The block on a belt; with equal static and sliding friction it only grazes the speed of the belt."""
    for static in STATICS:
        for speed in (2e-4, 2e-3, 2e-2, 0.2, 2.0):
            scene = problems.belt_scene(speed, static * problems.SLIDING)
            period = sum(problems.belt_phases(speed, static * problems.SLIDING))
            times = grid(3.3 * period, 17)
            found, events = problems.belt_solution(tuple(times), speed, static * problems.SLIDING)
            count = math.nan if static == 1 else events
            yield Trial("block on a belt at", f"static/coulomb {static:g}", f"{speed:g} m/s", scene, times,
                        {"where.r[1]": found}, count, bound=max(1.0, abs(found[-1])))  # fmt: skip


def stacks() -> Iterator[Trial]:
    """Wheels on one axis, each with friction on the one before it, brake together to a halt."""
    for count in (2, 5, 20, 50):
        for ratio in (0.0, 0.5, 1.0):  # torque / friction of the first
            inertia, friction = 0.1, 1.0
            names = [f"w{k}" for k in range(count)]
            bodies = {name: {"mass": 1.0, "inertia": [0, 0, inertia]} for name in names}
            joints: Scene = {}
            for k, name in enumerate(names):
                start = exactly(phi=0.0, w=0.0 if k else 2.0)
                parent = at(names[k - 1]) if k else at("ground")
                joints[f"J{k}"] = joint("revolute", parent, name, [0, 0, 1], start=start,
                                        friction={"coulomb": friction})  # fmt: skip
            scene = {"gelenk": 1, "name": "stack", "bodies": bodies, "joints": joints,
                     "motors": {"drive": {"joint": "J0"}}}  # fmt: skip
            law = Law(count * inertia, friction, friction)
            times = grid(1.5 * 2 * count * inertia)
            torques = [ratio * friction] * 20
            found, events = course(law, 0.0, 2.0, times, torques)
            signals = dict(coordinate(found, "J0.phi", "J0.w"))
            signals |= {f"J{k}.w": [0.0] * 20 for k in range(1, count)}
            yield Trial("stack of wheels, torque / friction", f"{count} wheels", f"{ratio:g}", scene, times,
                        signals, events, torques, "drive.tau", bound=2.0)  # fmt: skip


def parallelogram(x: float, v: float, cranks: int, friction: float) -> Scene:
    """Return equal cranks with a coupler in the horizontal plane; their joints share the friction."""
    hinges: Scene = {}
    bodies: Scene = {"coupler": problems.bar(1.0, 2.0)}
    share = {"coulomb": friction / (2 * cranks)}
    for k in range(cranks):
        bodies[f"crank{k}"] = problems.bar(0.5, 0.4)
        place = 2.0 * k / (cranks - 1)
        start = exactly(phi=x, w=v) if k == 0 else {"phi": x, "w": v}
        hinges[f"A{k}"] = joint(
            "revolute", at("ground", place), f"crank{k}", [0, 0, 1], start=start, friction=share
        )
        back = {"phi": -x, "w": -v}
        hinges[f"B{k}"] = joint(
            "revolute", at(f"crank{k}", 0.4), "coupler", [0, 0, 1], start=back, friction=share
        )
        hinges[f"B{k}"]["child"] = at("coupler", place)
    motor = {"drive": {"joint": "A0"}}
    return {"gelenk": 1, "name": "parallelogram", "bodies": bodies, "joints": hinges, "motors": motor}


def parallelograms() -> Iterator[Trial]:
    """Parallelograms, also with the links in line, whose cranks turn like one wheel."""
    for cranks in (2, 3):
        inertia = 1.0 * 0.4**2 + cranks * 0.5 * 0.4**2 / 3
        law = Law(inertia, 1.0, 1.0)
        for words, x in (("in line", 0.0), ("1e-9 off", 1e-9), ("1e-3 off", 1e-3), ("at 1 rad", 1.0)):
            for v in (0.0, 1.0, 5.0):
                for torque in (0.0, 0.5, 1.0, 1.000001, 2.0):
                    times, torques = grid(1.0), [torque] * 20
                    found, _ = course(law, x, v, times, torques)
                    yield Trial("parallelogram, torque / friction", f"{cranks} cranks, {words}, {v:g} rad/s",
                                f"{torque:.10g}", parallelogram(x, v, cranks, 1.0), times,
                                coordinate(found, "A0.phi", "A0.w"), math.nan, torques, "drive.tau",
                                bound=max(1.0, abs(found[-1][0]), v))  # fmt: skip


def blocked_four_bars() -> Iterator[Trial]:
    """The four-bar at rest in its dead centers and elsewhere, under loads below its friction."""
    still = {"A.w": [0.0] * 5, "D.w": [0.0] * 5}
    inside = math.acos((2.0**2 + 2.25**2 - 1.5**2) / (2 * 2.0 * 2.25))  # crank and coupler in line
    folded = math.acos((2.0**2 + 1.25**2 - 1.5**2) / (2 * 2.0 * 1.25)) - math.pi
    for words, phi in (("stretched", inside), ("folded", folded), ("at 1 rad", 1.0)):
        for scale in (1.0, 1e3):
            scene = problems.four_bar_scene()
            scene["joints"]["A"]["start"] = exactly(phi=phi, w=0.0)
            scene["gravity"] = [0, 0, 0]
            scene["motors"] = {"drive": {"joint": "A"}}
            for name in "ABCD":
                scene["joints"][name]["friction"] = {"coulomb": 0.3 * scale}
            for torque in (0.0, 0.1, 0.29):
                yield Trial("four-bar at rest, torque / friction", f"{words}, friction {0.3 * scale:g} N m",
                            f"{torque / 0.3:.2g}", scene, grid(1.0, 5), still, 0, [torque * scale] * 5,
                            "drive.tau")  # fmt: skip


def falling() -> Iterator[Trial]:
    """A body on a vertical guide with friction, on its limit or in the air."""
    weight = 0.7 * GRAVITY
    for ratio in (0.0, 0.5, 0.999999, 1.0, 1.000001, 2.0):  # friction / weight
        for restitution in (0.0, 0.5, 1.0):
            law = Law(0.7, ratio * weight, ratio * weight, lower=0.0, restitution=restitution)
            times = grid(2.0)
            found, events = course(law, 0.5, 0.0, times, [-weight] * 20)
            friction = {"friction": {"coulomb": ratio * weight}} if ratio else {}
            limit = {"lower": 0.0, "restitution": restitution}
            guide = joint(
                "prismatic", at("ground"), "ball", [0, 0, 1], start=exactly(s=0.5, v=0.0), limit=limit
            )
            scene = {"gelenk": 1, "name": "ball", "gravity": [0, 0, -GRAVITY],
                     "bodies": {"ball": {"mass": 0.7}}, "joints": {"J": guide | friction}}  # fmt: skip
            signals = coordinate(found, "J.s", "J.v")
            yield Trial("guided fall, friction / weight", f"e = {restitution:g}", f"{ratio:.7g}", scene,
                        times, signals, events)  # fmt: skip


Family = Callable[[], Iterator[Trial]]
FAMILIES: tuple[Family, ...] = (
    breaking_away, coming_to_rest, with_stribeck, alternating, bouncing, starting_at_limits, between_limits,
    pressed_with_friction, oscillating, on_belts, stacks, parallelograms, blocked_four_bars, falling,
)  # fmt: skip


def trials() -> list[Trial]:
    return [trial for family in FAMILIES for trial in family()]
