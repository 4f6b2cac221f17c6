# SPDX-License-Identifier: BSD-3-Clause
"""Scenes made of whatever kinds of elements the registry lists, with a sensor of every kind."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Scene, body, frame, joint, rotation, scene

from gelenk._core import elements
from gelenk._core import joints as joint_registry

from . import laws
from .laws import KINDS, Array, Kind

JOINTS = {kind["name"]: kind for kind in joint_registry.kinds()}
TILT = rotation([0.3, 1, -0.2], 0.7)
PIVOT = np.array([0.3, -0.2, 0.5])
LINK = 0.6  # m
BESIDE = 0.12  # m: so far along the axes the load moves beside the plane of the link
ANGLES = (0.5, 0.8)


def some_joint(kind: str, parent: dict[str, Any], child: dict[str, Any], **fields: Any) -> dict[str, Any]:
    """A joint of any kind, with axes and whatever numbers it requires."""
    axes = [[0.1, 0.2, 1.0], [1.0, 0.1, -0.3]][: JOINTS[kind]["axes"]]
    named: dict[str, Any] = {}
    if axes:
        named = {"axis": axes[0]} if len(axes) == 1 else {"axes": axes}
    rng = np.random.default_rng(23)
    for field in JOINTS[kind].get("fields", []):
        if field["required"]:
            named[field["name"]] = laws.drawn(field, rng)
    return joint(kind, parent, child, **named, **fields)


def with_sensors(source: Scene, *, on_joints: bool = True) -> Scene:
    """The same scene with each kind of sensor wherever it can be; reactions need space, out of any plane."""
    out = copy.deepcopy(source)
    sensors = out.setdefault("sensors", {})
    for kind in KINDS["sensors"]:
        name, ports = kind["name"], kind["ports"]
        if not ports:
            sensors[f"{name}_of_all"] = {"type": name}
        elif ports[0]["kind"] == "joint":
            if not on_joints:
                continue
            assert len(ports) == 1, "say here what a sensor of several joints is to be at"
            for j, fields in out["joints"].items():
                if fields["type"] in ports[0]["fits"]:
                    sensors[f"{name}_of_{j}"] = {"type": name, ports[0]["name"]: j}
        else:
            for b in out["bodies"]:
                at = [("ground", [0.2, 0.1, -0.4], None), (b, [0.1, -0.2, 0.3], None)]
                sensors[f"{name}_of_{b}"] = {"type": name, **at_frames(kind, at[-len(ports) :])}
    return out


def at_frames(kind: Kind, where: Sequence[tuple[str, Any, Array | None]]) -> dict[str, Any]:
    """The ports of an element that are frames: (body, position, rotation) each, as far as these count."""
    out: dict[str, Any] = {}
    ports = [port for port in kind["ports"] if port["kind"] != "joint"]
    for port, (on, position, R) in zip(ports, where, strict=False):
        entry = frame(on, position, R if port["kind"] == "frame" else None)
        if port["kind"] == "body":
            del entry["position"]
        out |= {port["name"]: entry} if port["name"] else entry
    return out


def given(fields: list[Kind], way: int, words: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """Values for a kind's fields as a scene file has them; of those with ways, of this one."""
    out: dict[str, Any] = {}
    for field in fields:
        if field["way"] not in (0, way):
            continue
        if field["type"] == "group":
            first = {f["name"]: f["words"][0] for f in field["fields"] if f["type"] == "choice"}
            out[field["name"]] = given(field["fields"], 0, first, rng)
        elif field["type"] in laws.FORMULAS:
            # Of any variables, but a surface must have some.
            text = "x + 0.5*y - 0.3*z - 0.1*x*z - 0.1" if field["name"] == "surface" else "0.9"
            out[field["name"]] = text if field["type"] == "formula" else [text] * 3
        elif field["name"] in words:
            out[field["name"]] = words[field["name"]]
        elif field["type"] not in ("flag", "choice", "direction"):
            out[field["name"]] = laws.drawn(field, rng)
    return out


def sound(section: str, kind: Kind, way: int, words: dict[str, Any]) -> dict[str, Any]:
    """Values that fit each other, as far as the element says so."""
    rng = np.random.default_rng(29)
    # Bearings and losses of gears have rules of their own (test_bearing_friction.py, test_drive_trains.py).
    described = [
        f
        for f in kind["fields"]
        if (section, f["type"]) != ("joints", "group") and f["name"] not in ("efficiency", "backdriving")
    ]
    for _ in range(100):
        fields = given(described, way, words, rng)
        texts = {f["name"] for f in described if f["type"] in laws.FORMULAS}
        numbers = {
            name: value
            for name, value in fields.items()
            if name in texts or not isinstance(value, str | bool)
        }
        checked: type[Any] | None = {"joints": elements.Along, "forces": elements.Force}.get(section)
        if checked is None or checked(kind["name"], numbers).is_sound:
            break
    return fields


@dataclass(frozen=True)
class Given:
    """A kind of element with fields as a scene file has them."""

    section: str
    kind: Kind
    fields: dict[str, Any]
    label: str

    def __str__(self) -> str:
        return "-".join(x for x in (self.section, str(self.kind["name"]), self.label) if x)


def all_given(section: str) -> Iterator[Given]:
    """Each kind with each of its ways and words and with its flags up and down.

    All but relations, which name joints of their scene (test_relations.py).
    """
    for kind in KINDS[section]:
        if kind["name"] == "relation":
            continue
        for of_way, of in laws.by_way(kind):
            fields = of["fields"]
            way = max(f["way"] for f in fields) if fields else 0
            for label, words in laws.words_and_flags(of):
                by_word = {
                    f["name"]: bool(words[f["name"]])
                    if f["type"] == "flag"
                    else f["words"][int(words[f["name"]])]
                    for f in fields
                    if f["name"] in words
                }
                labels = [of_way, label]
                numbers = sound(section, kind, way, by_word)
                yield Given(section, kind, numbers, "-".join(x for x in labels if x))


LOAD = body(0.9, (0.05, -0.1, 0.08), (0.06, 0.05, 0.07, -0.004, 0.003, 0.002))
ARM = body(1.2, (0.2, 0.05, -0.1), (0.03, 0.05, 0.04, 0.002, -0.003, 0.004))


def planar_arm() -> Scene:
    """Two links that turn about parallel axes, in a plane askew in the world."""
    R = rotation([1, -0.3, 0.4], 0.6)  # of the links' frames against the plane
    return scene(
        {"link": ARM, "load": LOAD},
        {
            "A": joint("revolute", frame("ground", PIVOT, TILT), frame("link", R=R.T), axis=[0, 0, 1],
                       start={"phi": ANGLES[0], "w": 0.9, "fixed": True}),
            "B": joint("revolute", frame("link", R.T @ [LINK, 0, BESIDE], R.T), frame("load", R=R.T),
                       axis=[0, 0, 1], start={"phi": ANGLES[1], "w": -1.3, "fixed": True}),
        },
        gravity=[0.5, -0.3, -GRAVITY],
    )  # fmt: skip


def on_gantry(source: Scene) -> Scene:
    """The arm with its load held by a gantry, too: two sliders and a hinge that forbid and weigh nothing."""
    out = copy.deepcopy(source)
    turn = TILT @ rotation([0, 0, 1], ANGLES[0])
    elbow = PIVOT + turn @ [LINK, 0, BESIDE]
    holder = frame("ground", elbow, turn @ rotation([0, 0, 1], ANGLES[1]))
    for name, axis in (("X", [1, 0, 0]), ("Y", [0, 1, 0])):
        out["bodies"][f"part_{name}"] = body(0.0)
        out["joints"][name] = joint("prismatic", holder, frame(f"part_{name}"), axis=axis)
        holder = frame(f"part_{name}")
    out["joints"]["C"] = joint("revolute", holder, out["joints"]["B"]["child"], axis=[0, 0, 1])
    return out


# Frames askew on the bodies, out of the plane.
R_FROM, R_TO = rotation([0.2, 0.7, -0.9], -0.8), rotation([1, -0.4, 0.5], 1.1)


def with_force(source: Scene, force: Given, first: str) -> Scene:
    """The force acts on `load`; one between two, from `first`."""
    at = (first, [0.4, 0.1, -0.15], R_FROM), ("load", [-0.1, 0.15, 0.05], R_TO)
    ports = at_frames(force.kind, list(at if len(force.kind["ports"]) == 2 else at[1:]))
    out = copy.deepcopy(source)
    out["forces"] = {"E": {"type": force.kind["name"], **ports, **force.fields}}
    return out


def free_load() -> Scene:
    """A load that moves freely beside an arm on a hinge, without symmetry."""
    start = {"r": [0.2, -0.3, 0.9], "Q": [0.1, -0.3, 0.3, 0.9], "v": [0.3, -0.2, 0.4], "w": [0.4, -0.5, 0.7]}
    return scene(
        {"link": ARM, "load": LOAD},
        {
            "A": joint("revolute", frame("ground", PIVOT, TILT), frame("link"), axis=[0, 0, 1],
                       start={"phi": 0.5, "w": 0.9}),
            "L": joint("free", frame("ground"), frame("load"), start=start),
        },
        gravity=[0.5, -0.3, -GRAVITY],
    )  # fmt: skip


def moving(kind: str, position: float, **fields: Any) -> dict[str, Any]:
    """A joint on the ground with a start: each coordinate there, each speed 0.7."""
    facts = JOINTS[kind]
    start: dict[str, Any] = {}
    if not facts["quaternion"]:
        start = dict.fromkeys(facts["q"], position) | dict.fromkeys(facts["v"], 0.7)
    return some_joint(
        kind, frame("ground", PIVOT, TILT), frame("load"), **fields, **({"start": start} if start else {})
    )


def one_joint(kind: str, position: float = 0.4, **fields: Any) -> Scene:
    """A load on one joint."""
    return scene({"load": LOAD}, {"J": moving(kind, position, **fields)}, gravity=[0.5, -0.3, -GRAVITY])


def constrained(constraint: Given, with_optional: bool) -> Scene:
    """A body on a joint of the first kind that fits for each of its joints; else a free load and an arm."""
    ports = [p for p in constraint.kind["ports"] if with_optional or not p["optional"]]
    names: dict[str, Any] = {"type": constraint.kind["name"]}
    if not any(p["kind"] == "joint" for p in ports):
        out = free_load()
        where = [("load", [0.02, 0.01, 0.03], R_TO), ("link", [0.1, 0.0, -0.9], rotation([1, 0, 0], 0.1))]
        names |= at_frames({**constraint.kind, "ports": ports}, where[: len(ports)])
    else:
        out = scene({}, {}, gravity=[0.5, -0.3, -GRAVITY])
        for i, port in enumerate(ports):
            kind = port["fits"][0]
            name = f"J{i}"
            out["bodies"][f"load_{i}"] = dict(LOAD)  # its own: scenes are changed in place
            out["joints"][name] = moving(kind, 0.4) | {"child": frame(f"load_{i}")}
            names[port["name"]] = name
            if port["has_coordinate"]:
                names["coordinate"] = JOINTS[kind]["q"][0]
    out["constraints"] = {"E": {**names, **constraint.fields}}
    return out
