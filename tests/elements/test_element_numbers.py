# SPDX-License-Identifier: BSD-3-Clause
"""Each number that an element of any kind can be given has an effect, before the start and tuned in a run."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene

import gelenk
from gelenk import _core

from . import laws, scenes
from .laws import KINDS, Array, Kind
from .scenes import JOINTS, Given, all_given

# Positions beyond bounds and unusual numbers are meant.
pytestmark = pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")

STEPS, STEP = 4, 0.02  # s

# A scene with the element in it, where the element's fields stand, and a name for the test.
type Example = tuple[Scene, tuple[str, ...], Given]


def places() -> Iterator[tuple[str, list[Scene], tuple[str, ...], Given]]:
    """Each kind with each of its ways: scenes that differ in where they start, and where its fields stand."""
    for force in all_given("forces"):
        yield str(force), [scenes.with_force(scenes.free_load(), force, "link")], ("forces", "E"), force
    for motor in all_given("motors"):
        (port,) = motor.kind["ports"]
        for joint in port["fits"]:
            source = scenes.one_joint(joint)
            along = {"coordinate": JOINTS[joint]["q"][0]} if JOINTS[joint]["nv"] > 1 else {}
            fields = {"type": motor.kind["name"], port["name"]: "J", **along, **motor.fields}
            source["motors"] = {"E": fields}
            yield f"{motor}-{joint}", [source], ("motors", "E"), motor
    for constraint in all_given("constraints"):
        optional = {any(p["optional"] for p in constraint.kind["ports"]), False}
        for there in sorted(optional):
            source = scenes.constrained(constraint, with_optional=there)
            yield f"{constraint}{'-all-ports' if there else ''}", [source], ("constraints", "E"), constraint
    for force in all_given("joints"):
        group = force.kind["group"]
        for joint in force.kind["fits"]:
            at = ("joints", "J", group) if group else ("joints", "J")
            if not group:
                fields = {name: for_each_speed(x, joint) for name, x in force.fields.items()}
            elif JOINTS[joint]["nv"] == 1 or force.kind["of_joint"]:
                fields = {group: force.fields}
            else:  # along one of its coordinates
                at = (*at, JOINTS[joint]["q"][0])
                fields = {group: {at[-1]: force.fields}}
            starts = [starting(joint, *state, copy.deepcopy(fields)) for state in states(force)]
            yield f"{force}-{joint}", starts, at, force


def states(force: Given) -> list[tuple[float, float]]:
    """Coordinates and speeds at the start: within and beyond bounds of a stop, before those of a limit."""
    if force.kind["name"] != "limit":
        return [(0.4, 0.7), (3.0, 0.7), (-3.0, 0.7)]
    return [(force.fields["lower"] + 1e-3, -0.7), (force.fields["upper"] - 1e-3, 0.7)]


def starting(joint: str, position: float, speed: float, fields: dict[str, Any]) -> Scene:
    source = scenes.one_joint(joint, position, **fields)
    start = source["joints"]["J"].get("start", {})
    start |= {name: speed for name in JOINTS[joint]["v"] if name in start}
    return source


def for_each_speed(value: float, joint: str) -> Any:
    """What a joint has along each of its coordinates; not all alike."""
    nv = JOINTS[joint]["nv"]
    return value if nv == 1 else [value * (1 + 0.1 * k) for k in range(nv)]


PLACES = list(places())
every_place = pytest.mark.parametrize(
    ("variants", "at", "given"), [p[1:] for p in PLACES], ids=[p[0] for p in PLACES]
)


def loaded(source: Scene, **fields: Any) -> gelenk.Scene:
    return gelenk.load({**scenes.with_sensors(source), **fields})


def values(plant: gelenk.Simulation) -> Array:
    energy = [plant.diagnostic(name) for name in plant.diagnostics if name.startswith("energy.")]
    return np.array([*plant.values(), *energy])


def going_on(plant: gelenk.Simulation) -> Array:
    """Outputs and energies now and at each of the next steps."""
    rows = [values(plant)]
    for _ in range(STEPS):
        plant.step_to(plant.time + STEP)
        rows.append(values(plant))
    return np.array(rows)


def started(scene: gelenk.Scene) -> gelenk.Simulation:
    plant = gelenk.Simulation(scene)
    plant.initialize(0.0, 1e-9)
    for i, signal in enumerate(plant.inputs):
        plant.set_input(signal.name, 0.3 + 0.2 * i)
    return plant


def differ(a: Array, b: Array) -> bool:
    """Well above what a tolerance of 1e-9 leaves; a change of a fourth in a number near 1 is seen by 1e-3."""
    return a.shape != b.shape or bool((np.abs(a - b) > 1e-5 * (1 + np.abs(b))).any())


def in_place(source: Scene, at: tuple[str, ...]) -> dict[str, Any]:
    entry: dict[str, Any] = source
    for key in at:
        entry = entry[key]
    return entry


def numbers_given(fields: list[Kind], entry: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str, Kind]]:
    """(mapping, key, field) of each field of the element that the scene gives, those of groups too."""
    for field in fields:
        if field["name"] not in entry:
            continue
        if field["type"] == "group":
            yield from numbers_given(field["fields"], entry[field["name"]])
        else:
            yield entry, field["name"], field


def others(value: Any, field: Kind) -> Iterator[Any]:
    """Other values of a field, each different in one number."""
    if field["type"] == "flag":
        yield not value
    elif field["type"] == "choice":
        yield from (word for word in field["words"] if word != value)
    elif isinstance(value, list):
        for i in range(len(value)):
            yield [changed(x, field) if k == i else x for k, x in enumerate(value)]
    else:
        yield changed(value, field)


def changed(x: Any, field: Kind) -> Any:
    """By a fourth; of times, which are in order, by less; exponents are 1 or 2."""
    if field["type"] in laws.FORMULAS:
        return f"1.25*({x}) + 0.01"  # a surface is the same for all factors
    return x * (2 if field["name"] == "exponent" else 1.01 if field["unit"] == "s" else 1.25)


# Laws of impact differ only where several limits are struck together (test_laws_of_impact.py), those of stops
# where contacts begin and end (test_modelica_drives.py). Whether a lock starts engaged is what its input
# starts with (test_locks_in_mechanisms.py).
ELSEWHERE = {("limit", "law"), ("stop", "law"), ("friction", "peak"), ("lock", "engaged")}


@warned.GUESSES
@every_place
def test_each_field_has_an_effect(variants: list[Scene], at: tuple[str, ...], given: Given) -> None:
    """Given otherwise in the scene, the motion or what is measured is another one."""
    before = [going_on(started(loaded(source))) for source in variants]
    silent = []
    for n, (_, key, field) in enumerate(numbers_given(given.kind["fields"], in_place(variants[0], at))):
        if (given.kind["name"], key) in ELSEWHERE:
            continue
        for other in others(in_place_value(variants[0], at, given, n), field):
            changed = copy.deepcopy(variants)
            for source in changed:
                entry, _, _ = list(numbers_given(given.kind["fields"], in_place(source, at)))[n]
                entry[key] = other
            after = (going_on(started(loaded(source))) for source in changed)
            if not any(differ(a, b) for a, b in zip(after, before, strict=True)):
                silent.append((key, other))
    assert silent == []


def in_place_value(source: Scene, at: tuple[str, ...], given: Given, n: int) -> Any:
    entry, key, _ = list(numbers_given(given.kind["fields"], in_place(source, at)))[n]
    return entry[key]


def test_each_direction_has_an_effect() -> None:
    """An axis given otherwise."""
    for name, (source, *_), at, given in PLACES:
        for field in (f for f in given.kind["fields"] if f["type"] == "direction"):
            changed = copy.deepcopy(source)
            in_place(changed, at)[field["name"]] = [0.2, 0.9, -0.1]
            assert differ(going_on(started(loaded(changed))), going_on(started(loaded(source)))), name


def paths_of(scene: gelenk.Scene, at: tuple[str, ...], given: Given) -> list[str]:
    """The element's paths among all that the scene can list."""
    head = ".".join(at[1:]) + "."
    names = {f["name"] for f in given.kind["fields"]}
    return [
        p
        for p, _ in _core.list_settables(scene._core)
        if p.startswith(head) and p[len(head) :].split(".")[0] in names
    ]


def parameters_of(source: Scene, at: tuple[str, ...], given: Given) -> tuple[gelenk.Scene, list[Any]]:
    """The scene that offers the element's numbers, and the parameters that these are."""
    plain = loaded(source)
    offering = loaded(source, parameters=paths_of(plain, at, given))
    known = {p.name for p in _core.list_parameters(plain._core)}
    return offering, [p for p in _core.list_parameters(offering._core) if p.name not in known]


@every_place
def test_each_number_can_be_a_parameter(variants: list[Scene], at: tuple[str, ...], given: Given) -> None:
    """As many as the fields that are given have numbers, one for each coordinate."""
    _, found = parameters_of(variants[0], at, given)
    expected = 0
    for entry, key, field in numbers_given(given.kind["fields"], in_place(variants[0], at)):
        if field["settable"] and field["type"] in ("number", "vector", "numbers"):
            expected += len(entry[key]) if isinstance(entry[key], list) else 1
    assert len(found) == expected


@warned.GUESSES
@every_place
def test_each_parameter_has_an_effect(variants: list[Scene], at: tuple[str, ...], given: Given) -> None:
    """Set before the start."""
    silent: set[str] = set()
    for source in variants:
        scene, parameters = parameters_of(source, at, given)
        before = going_on(started(scene))
        here = set()
        for parameter in parameters:
            changed = scene.with_parameters({parameter.name: 1.25 * parameter.value(scene._core)})
            if not differ(going_on(started(changed)), before):
                here.add(parameter.name)
        silent = here if source is variants[0] else silent & here
    assert silent == set()


@warned.GUESSES
@every_place
def test_each_tuned_number_has_the_effect_of_the_parameter(
    variants: list[Scene], at: tuple[str, ...], given: Given
) -> None:
    """Tuned right after the start, a plant goes on as one made so; restored, too, and to the bit."""
    silent: set[str] = set()
    for source in variants:
        scene, parameters = parameters_of(source, at, given)
        tunable = {name for f in given.kind["fields"] if f["tunable"] for name in [f["name"]]}
        assert {p.name.split(".")[len(at) - 1].split("[")[0] for p in parameters if p.tunable} >= {
            name for name in tunable if name in in_place(source, at)
        }
        before = going_on(started(scene))
        here = set()
        for parameter in (p for p in parameters if p.tunable):
            changed = scene.with_parameters({parameter.name: 1.25 * parameter.value(scene._core)})
            plant, other = started(scene), started(scene)
            for each in (plant, other):
                each._core.tune(changed._core)
            saved = plant.save()
            after = going_on(plant)
            fresh = going_on(started(changed))
            # both at a tolerance of 1e-9 over 0.1 s
            np.testing.assert_allclose(after, fresh, rtol=1e-6, atol=1e-6, err_msg=parameter.name)
            other.restore(saved)
            assert (going_on(other) == after).all()
            if not differ(after, before):
                here.add(parameter.name)
        silent = here if source is variants[0] else silent & here
    assert silent == set()


def test_every_section_has_kinds() -> None:
    """Else the tests above would hold of nothing."""
    assert all(KINDS[section] for section in ("motors", "forces", "constraints", "sensors", "joints"))
