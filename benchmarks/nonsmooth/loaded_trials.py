# SPDX-License-Identifier: BSD-3-Clause
"""Trials of the failure map with bearings, gears with losses, clutches, freewheels and play."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from benchmarks.nonsmooth import exact_bearings, exact_drives
from benchmarks.nonsmooth.exact import Law, course
from benchmarks.nonsmooth.exact_bearings import GRAVITY, Eccentric, SliderCrank
from benchmarks.nonsmooth.problems import Scene, at, bar, exactly, joint
from benchmarks.nonsmooth.trial import Trial, coordinate, grid, wheel

NEAR_ONE = (0.5, 0.999999, 1.0, 1.000001, 2.0)
COUPLINGS = (0.0, 0.01, 0.05, 0.1, 0.5, 0.9, 0.99, 0.999999, 1.000001, 1.5)


def bearing(coefficient: float, radius: float, **fields: float) -> Scene:
    return {"coulomb": 0.0, "bearing": {"coefficient": coefficient, "radius": radius, **fields}}


def turned_in_bearings() -> Iterator[Trial]:
    """A wheel whose weight rests on a bearing, from rest under a torque near its limit."""
    for unit in (1.0, 1e-6, 1e6):
        for static in (1.0, 1.001, 2.0, 10.0):  # over the coefficient in motion
            for ratio in NEAR_ONE:
                mass, radius = 0.5, 0.01
                weight = 100.0 * unit
                coefficient = 0.1
                limit = coefficient * radius * weight
                law = Law(0.5 * unit, limit, static * limit)
                torques = [ratio * law.static] * 20
                times = grid(1.0)
                found, events = course(law, 0.0, 0.0, times, torques)
                friction = bearing(coefficient, radius, static=static * coefficient)
                scene = wheel(0.0, 0.0, law.inertia, friction=friction)
                scene["bodies"]["wheel"]["mass"] = mass
                scene["forces"] = {"weight": {"type": "wrench", "body": "wheel", "force": [0, -weight, 0]}}
                row = f"static/sliding {static:g}" + ("" if unit == 1 else f", {weight:g} N")
                scale = max(1.0, *(max(abs(x), abs(v)) for x, v in found))
                yield Trial("wheel in a bearing, torque / limit", row, f"{ratio:.10g}", scene, times,
                            coordinate(found), events, torques, "drive.tau", scale)  # fmt: skip


ECCENTRIC: dict[str, dict[str, float]] = {
    "coasts from 5 rad/s": {"w": 5.0, "gravity": 0.0},
    "driven from rest": {"w": 0.0, "gravity": 0.0, "torque": 1.0},
    "driven at 5 rad/s": {"w": 5.0, "gravity": 0.0, "torque": 2.0},
    "braked at 5 rad/s": {"w": 5.0, "gravity": 0.0, "torque": -2.0},
    "swings from 1 rad": {"w": 0.0, "phi": 1.0},
    "swings over the top": {"w": 12.0},
}


def eccentric_wheels() -> Iterator[Trial]:
    """Friction of the bearing grows with the acceleration that it resists: none, or two of them from 1 on."""
    for words, of in ECCENTRIC.items():
        for coupling in COUPLINGS:
            mass, inertia, radius, coefficient = 2.0, 0.2, 0.05, 1.0
            arm = coupling * inertia / (coefficient * radius * mass)
            arm, strength = (0.1, 0.0) if coupling == 0 else (min(arm, 0.1), max(1.0, arm / 0.1))
            gravity = of.get("gravity", GRAVITY)
            machine = Eccentric(
                mass, arm, inertia, strength * coefficient * radius, gravity, of.get("torque", 0)
            )
            phi, w, times = of.get("phi", 0.0), of["w"], grid(1.5, 15)
            start = exactly(phi=phi, w=w)
            friction = bearing(strength * coefficient, radius)
            scene: Scene = {
                "gelenk": 1, "name": "eccentric", "gravity": [0, -gravity, 0],
                "bodies": {"wheel": {"mass": mass, "com": [0, -arm, 0],
                                     "inertia": [0, 0, inertia - mass * arm**2]}},
                "joints": {"J": joint("revolute", at("ground"), "wheel", [0, 0, 1], start=start,
                                      friction=friction)},
                "motors": {"drive": {"joint": "J"}},
            }  # fmt: skip
            torques = [machine.torque] * len(times)
            yield bearing_trial("eccentric wheel, friction x arm / inertia", words, f"{coupling:.7g}", scene,
                                machine, phi, w, times, torques, ("J.phi", "J.w"))  # fmt: skip


def bearing_trial(family: str, row: str, column: str, scene: Scene, machine: Eccentric | SliderCrank,
                  phi: float, w: float, times: list[float], torques: list[float],
                  names: tuple[str, str]) -> Trial:  # fmt: skip
    """Return a trial with its exact solution, or one that is to be refused."""
    try:
        found, events = exact_bearings.reversing(machine, phi, w, times)
    except exact_bearings.ParadoxError:
        return Trial(family, row, column, scene, times, {}, math.nan, torques, "drive.tau", refused=True)
    scale = max(1.0, *(max(abs(x), abs(v)) for x, v in found))
    return Trial(
        family, row, column, scene, times, coordinate(found, *names), events, torques, "drive.tau", scale
    )


def slider_cranks() -> Iterator[Trial]:
    """The guide of a slider-crank, up to coefficients at which it seizes."""
    for words, w, torque in (("coasts", 12.0, 0.0), ("driven", 12.0, 5.0), ("braked", 12.0, -4.0)):
        for coefficient in (0.0, 0.1, 0.3, 1.0, 2.0, 5.0, 8.0, 10.0):
            machine = SliderCrank((0.15, 0.56), (0.5, 0.8, 1.5), coefficient, torque=torque)
            phi, times = 0.6, grid(0.4, 8)
            tilt = math.asin(0.15 * math.sin(phi) / 0.56)
            about = [0.0, -1.0, 0.0]
            guide = joint(
                "prismatic", at("ground"), "slider", [1, 0, 0],
                start={"s": 0.15 * math.cos(phi) + 0.56 * math.cos(tilt)},
                friction={"coulomb": 0.0, "bearing": {"coefficient": coefficient}},
            )  # fmt: skip
            scene: Scene = {
                "gelenk": 1, "name": "slider_crank", "gravity": [0, 0, -GRAVITY],
                "bodies": {"crank": bar(0.5, 0.15), "rod": bar(0.8, 0.56), "slider": {"mass": 1.5}},
                "joints": {
                    "A": joint("revolute", at("ground"), "crank", about, start=exactly(phi=phi, w=w)),
                    "B": joint("revolute", at("crank", 0.15), "rod", about, start={"phi": -phi - tilt}),
                    "guide": guide,
                    "C": joint("revolute", at("slider"), "rod", about) | {"child": at("rod", 0.56)},
                },
                "motors": {"drive": {"joint": "A"}},
            }  # fmt: skip
            yield bearing_trial("slider-crank, friction of its guide", words, f"{coefficient:g}", scene,
                                machine, phi, w, times, [torque] * 8, ("A.phi", "A.w"))  # fmt: skip


def pushed_obliquely() -> Iterator[Trial]:
    """A carriage pushed into its guide at an angle: steeper than friction, no force moves it."""
    weight, mass, coefficient = 20.0, 2.0, 0.5
    for angle in (0.0, 30.0, 60.0, 63.4, 63.5, 80.0):
        slope = math.radians(angle)
        gain = math.cos(slope) - coefficient * math.sin(slope)
        forces = (
            {f"{r:.7g}": r * coefficient * weight / gain for r in NEAR_ONE}
            if gain > 0
            else {"100 kN": 1e5, "1 N": 1.0}
        )
        for words, force in forces.items():
            limit = coefficient * (weight + force * math.sin(slope))
            law, times = Law(mass, limit, limit), grid(1.0)
            along = force * math.cos(slope)
            found, events = course(law, 0.0, 0.0, times, [along] * 20)
            scene: Scene = {
                "gelenk": 1, "name": "carriage", "gravity": [0, 0, -weight / mass],
                "bodies": {"carriage": {"mass": mass}},
                "joints": {"J": joint("prismatic", at("ground"), "carriage", [1, 0, 0],
                                      start=exactly(s=0.0, v=0.0),
                                      friction={"coulomb": 0.0, "bearing": {"coefficient": coefficient}})},
                "forces": {"push": {"type": "wrench", "body": "carriage",
                                    "force": [along, 0, -force * math.sin(slope)]}},
            }  # fmt: skip
            scale = max(1.0, *(max(abs(x), abs(v)) for x, v in found))
            yield Trial("carriage pushed at an angle, force / limit", f"{angle:g} deg", words, scene, times,
                        coordinate(found, "J.s", "J.v"), events, bound=scale)  # fmt: skip


def gears() -> Iterator[Trial]:
    """A gear, and a rack, that raise a load, hold it, let it down, and are driven by it."""
    for efficiency, backdriving in (
        (1.0, 1.0),
        (0.9, 0.9),
        (0.5, 0.5),
        (0.6, 1 / 3),
        (0.4, -0.5),
        (0.4, 0.0),
    ):
        for rack in (False, True):
            ratio = 1 / 0.02 if rack else 4.0
            load = -10.0 * ratio / 4  # 2.5 N m on the first shaft without losses
            gear = exact_drives.Gear((0.1, 40.0 if rack else 1.5), ratio, efficiency, backdriving, load)
            raise_, lower = 2.5 / efficiency, 2.5 * backdriving
            for words, torque in {
                "raises": 1.5 * raise_, "just raises": (1 + 1e-6) * raise_, "at its limit": raise_,
                "just holds": (1 - 1e-6) * raise_, "holds": (raise_ + lower) / 2,
                "just lowers": lower - 2.5e-6, "lowers": lower - 1.0,
            }.items():  # fmt: skip
                if efficiency == 1 and words in ("at its limit", "just holds", "holds"):
                    continue
                times = grid(2.0)
                torques = [torque] * 8 + [lower - 1.0] * 6 + [1.5 * raise_] * 6
                found, events = exact_drives.gear_course(gear, 0.0, times, torques)
                scale = max(1.0, *(max(abs(x), abs(v)) for x, v in found))
                row = f"{'rack' if rack else 'gear'} {efficiency:g}, {backdriving:.3g}"
                yield Trial("gear that carries a load, torque", row, words, geared(gear, rack), times,
                            coordinate(found, "first.phi", "first.w"), events if efficiency < 1 else math.nan,
                            torques, "drive.tau", scale)  # fmt: skip


def geared(gear: exact_drives.Gear, rack: bool) -> Scene:
    mesh: Scene = {"efficiency": gear.efficiency, "backdriving": gear.backdriving}
    start = exactly(phi=0.0, w=0.0)
    first = joint("revolute", at("ground"), "first", [0, 0, 1], start=start, friction={"coulomb": 0.0})
    push: Scene = {"type": "wrench", "body": "second"}
    if rack:
        second = joint("prismatic", at("ground"), "second", [1, 0, 0], start=exactly(s=0.0, v=0.0))
        mesh |= {"type": "rack", "rack": "second", "pinion": "first", "radius": 1 / gear.ratio}
        body: Scene = {"mass": gear.inertias[1]}
        push["force"] = [gear.load, 0, 0]
    else:
        second = joint("revolute", at("ground"), "second", [0, 0, 1], start=start)
        mesh |= {"type": "gear", "joint": "first", "with": "second", "ratio": gear.ratio}
        body = {"mass": 1.0, "inertia": [0, 0, gear.inertias[1]]}
        push["torque"] = [0, 0, gear.load]
    return {
        "gelenk": 1, "name": "gear",
        "bodies": {"first": {"mass": 1.0, "inertia": [0, 0, gear.inertias[0]]}, "second": body},
        "joints": {"first": first, "second": second},
        "constraints": {"mesh": mesh}, "forces": {"load": push}, "motors": {"drive": {"joint": "first"}},
    }  # fmt: skip


def braked_gears() -> Iterator[Trial]:
    """A gear with losses and friction on its first shaft; a clutch connects the second to a braked wheel."""
    ratio, inertias = 4.0, (0.1, 1.5)
    for efficiency in (1.0, 0.8, 0.5):
        for bearing_, brake in ((1.0, 0.5), (1.0, 4.0), (1.0, 40.0), (0.0, 4.0)):
            limit = bearing_ + brake / (efficiency * ratio)
            law = Law(inertias[0] + inertias[1] / (efficiency * ratio**2), limit, limit)
            for share in (0.5, 0.99, 0.999999, 1.000001, 1.01, 1.1, 2.0):
                times, torques = grid(1.0), [share * limit] * 20
                found, _ = course(law, 0.0, 0.0, times, torques)
                gear = exact_drives.Gear((inertias[0], 1e-3), ratio, efficiency, efficiency, 0.0)
                scene = geared(gear, rack=False)
                del scene["forces"]
                scene["joints"]["first"]["friction"] = {"coulomb": bearing_}
                # The second wheel is part of what is braked.
                scene["bodies"]["wheel"] = {"mass": 1.0, "inertia": [0, 0, inertias[1] - 1e-3]}
                start, axis = exactly(phi=0.0, w=0.0), [0.0, 0.0, 1.0]
                scene["joints"] |= {
                    "wheel": joint("revolute", at("ground"), "wheel", axis, start=start,
                                   friction={"coulomb": brake}),
                    "clutch": joint("revolute", at("second"), "wheel", axis, friction={"coulomb": 100.0}),
                }  # fmt: skip
                scale = max(1.0, *(max(abs(x), abs(v)) for x, v in found))
                row = f"efficiency {efficiency:g}, friction {bearing_:g}, brake {brake:g} N m"
                signals = coordinate(found, "first.phi", "first.w")
                yield Trial("gear, clutch and brake, torque / limit", row, f"{share:.7g}", scene, times,
                            signals, math.nan, torques, "drive.tau", scale)  # fmt: skip


def two_wheels(inertias: tuple[float, float], w: tuple[float, float], **fields: object) -> Scene:
    """Return two wheels with a motor on the first."""
    one, two = ({"mass": 1.0, "inertia": [0, 0, J]} for J in inertias)
    slip = exactly(phi=0.0, w=w[1] - w[0])
    return {
        "gelenk": 1, "name": "two_wheels", "bodies": {"one": one, "two": two},
        "joints": {
            "shaft": joint("revolute", at("ground"), "one", [0, 0, 1], start=exactly(phi=0.0, w=w[0])),
            "clutch": joint("revolute", at("one"), "two", [0, 0, 1], start=slip, **fields),
        },
        "motors": {"drive": {"joint": "shaft"}},
    }  # fmt: skip


def engaging() -> Iterator[Trial]:
    """A clutch engaged and released in ramps, from slipping or locked at the start."""
    inertias, sliding = (0.5, 2.0), 10.0
    for static in (1.0, 1.3):
        for words, speeds in (("slips at 20 rad/s", (20.0, 0.0)), ("at rest", (0.0, 0.0))):
            for carried in (0.0, 0.5, 0.999999, 1.000001, 1.5):  # of the static limit, locked
                for ramp in (1e-6, 1e-3, 0.1, 1.0):
                    torque = carried * static * sliding * (inertias[0] + inertias[1]) / inertias[1]
                    of = exact_drives.Clutch(inertias, torque, sliding, static * sliding, speeds)
                    times, values, slopes, now = [], [], [], 0.0
                    for span, value, slope in (
                        (ramp, 0.0, 1 / ramp), (2.0, 1.0, 0.0), (ramp, 1.0, -1 / ramp), (0.3, 0.0, 0.0),
                        (ramp, 0.0, 0.5 / ramp), (3.0, 0.5, 0.0),
                    ):  # fmt: skip
                        now += span
                        times.append(now)
                        values.append(value)
                        slopes.append(slope)
                    found, events = of.course(times, values, slopes)
                    friction = {"coulomb": sliding, "static": static * sliding, "input": "engagement"}
                    scene = two_wheels(inertias, speeds, friction=friction)
                    del scene["motors"]
                    scene["forces"] = {"engine": {"type": "wrench", "body": "one", "torque": [0, 0, torque]}}
                    signals = {
                        "shaft.phi": [s[0] for s in found], "shaft.w": [s[2] for s in found],
                        "clutch.phi": [s[1] - s[0] for s in found], "clutch.w": [s[3] - s[2] for s in found],
                    }  # fmt: skip
                    scale = max(1.0, *(max(abs(x) for x in s) for s in found))
                    row = f"{words}, static {static:g}, carries {carried:.7g} of it"
                    yield Trial("clutch engaged within", row, f"{ramp:g} s", scene, times, signals, events,
                                values, "clutch.friction.engagement", scale, slopes)  # fmt: skip


def chattering() -> Iterator[Trial]:
    """Freewheels and play under torques that change their sign at every communication step."""
    for period in (1e-4, 1e-2, 1.0):
        times = [period * (k + 1) for k in range(40)]
        for load in (0.0, -0.5):
            torques = [3.0 if k % 2 == 0 else -2.0 for k in range(40)]
            inertias = (0.5, 1.0)
            speeds, events = exact_drives.freewheel_course(inertias, load, times, torques)
            scene = two_wheels(inertias, (0.0, 0.0), one_way={"free": "positive"})
            scene["forces"] = {"load": {"type": "wrench", "body": "two", "torque": [0, 0, load]}}
            signals = {"shaft.w": [a for a, _ in speeds], "clutch.w": [b - a for a, b in speeds]}
            scale = max(1.0, *(max(abs(a), abs(b)) for a, b in speeds))
            yield Trial("chatter, period", f"freewheel, load {load:g} N m", f"{period:g} s", scene, times,
                        signals, events, torques, "drive.tau", scale)  # fmt: skip
        for restitution in (0.0, 0.5):
            # The play is crossed in 0.6 of a period.
            width = 0.5 / 0.5 * (0.6 * period) ** 2
            law = Law(0.5, lower=-width / 2, upper=width / 2, restitution=restitution)
            torques = [(-1.0) ** k for k in range(40)]
            found, count = course(law, 0.0, 0.0, times, torques)
            count = count if restitution == 0 else math.nan  # series of impacts
            limit = {"lower": -width / 2, "upper": width / 2, "restitution": restitution}
            scene = wheel(0.0, 0.0, 0.5, limit=limit)
            scale = max(1.0, 2 / (2 * width) ** 0.5)  # acceleration / speed at the impact
            yield Trial("chatter, period", f"play, e = {restitution:g}", f"{period:g} s", scene, times,
                        coordinate(found), count, torques, "drive.tau", scale)  # fmt: skip


Family = Callable[[], Iterator[Trial]]
FAMILIES: tuple[Family, ...] = (
    turned_in_bearings, eccentric_wheels, slider_cranks, pushed_obliquely, gears, braked_gears, engaging,
    chattering,
)  # fmt: skip


def trials() -> list[Trial]:
    return [trial for family in FAMILIES for trial in family()]
