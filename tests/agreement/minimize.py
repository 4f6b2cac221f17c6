# SPDX-License-Identifier: BSD-3-Clause
"""Makes a trial that shows a fault smaller, as long as it shows the same fault."""

from __future__ import annotations

import copy
from collections.abc import Iterator

from .compare import Comparison, Finding
from .elements import Course, Trial

SETTINGS = ("lock", "friction", "limit", "one_way", "stop", "stiffness", "spring_reference", "damping")
DETAILS = ("static", "stribeck", "exponent", "input", "restitution", "lower", "upper", "rolling")


def smaller(trial: Trial) -> Iterator[Trial]:
    """Trials that lack one thing, the largest things first."""
    scene = trial.scene
    if trial.points > 1:
        for points in (trial.points // 2, trial.points - 1):
            out = trial.copy()
            out.points = max(1, points)
            yield out
    bodies = list(scene["bodies"])
    for letter in "abc":
        yield without(trial, {body for body in bodies if body.startswith(letter)})
    for body in reversed(bodies):
        yield without(trial, {body})
    for section in ("forces", "motors", "contacts", "constraints"):
        for name in scene.get(section, {}):
            out = trial.copy()
            del out.scene[section][name]
            yield completed(out)
    for name, joint in scene["joints"].items():
        for key in SETTINGS:
            if key in joint:
                out = trial.copy()
                del out.scene["joints"][name][key]
                yield completed(out)
                for detail in DETAILS:
                    if isinstance(joint[key], dict) and detail in joint[key]:
                        out = trial.copy()
                        del out.scene["joints"][name][key][detail]
                        yield completed(out)
    for name, course in trial.inputs.items():
        if len(course.knots) > 1 and len(course.values[0]) < 6:
            out = trial.copy()
            out.inputs[name] = Course(course.knots[:-1], course.values[:-1])
            yield out


def without(trial: Trial, bodies: set[str]) -> Trial:
    """Without these bodies, their joints, and all that refers to either."""
    gone = bodies | {f"{letter}{body}" for letter in "JM" for body in bodies}
    out = trial.copy()
    for section in ("bodies", "joints", "motors", "constraints", "contacts", "forces"):
        kept = {}
        for name, entry in out.scene.get(section, {}).items():
            ends = [entry.get(end) for end in ("from", "to", "child", "parent", "joint", "with")]
            names = {name} | {end["body"] if isinstance(end, dict) else end for end in ends if end}
            if not names & gone:
                kept[name] = entry
        if section in out.scene:
            out.scene[section] = kept
    return completed(out)


def completed(trial: Trial) -> Trial:
    """Without sections and inputs that have become empty."""
    scene = trial.scene
    surfaces = {
        shape["surface"] for body in scene["bodies"].values() for shape in body.get("shapes", {}).values()
    }
    if "contacts" in scene:
        scene["contacts"] = {n: c for n, c in scene["contacts"].items() if c["between"][0] in surfaces}
    for section in ("motors", "constraints", "contacts", "forces"):
        if section in scene and not scene[section]:
            del scene[section]
    if "contacts" not in scene:
        scene.pop("ground", None)
        for body in scene["bodies"].values():
            body.pop("shapes", None)
    known = {
        name
        for name in trial.inputs
        if name.partition(".")[0] in {**scene.get("motors", {}), **scene.get("constraints", {})}
        or any(
            f".{law}." in name and "input" in scene["joints"].get(name.partition(".")[0], {}).get(law, {})
            for law in ("friction", "lock")
        )
    }
    trial.inputs = {name: course for name, course in trial.inputs.items() if name in known}
    return trial


def minimized(trial: Trial, finding: Finding, most: int = 300) -> tuple[Trial, Finding]:
    """Return a smaller trial with a finding of the same way, after at most this many attempts."""
    ways = [finding.way.removesuffix(" refused").replace("laws in steps", "steps")]
    ways = [way for way in ways if way not in ("refused", "slow", "laws", "not started")]
    best, kept = copy.deepcopy(trial), finding
    tried = 0
    found_one = True
    while found_one and tried < most:
        found_one = False
        for candidate in smaller(best):
            tried += 1
            if tried >= most:
                break
            if not candidate.scene["bodies"]:
                continue
            same = [f for f in Comparison(candidate, finding.seed).findings(ways) if f.way == finding.way]
            if same:
                best, kept, found_one = candidate, same[0], True
                break
    return best, kept
