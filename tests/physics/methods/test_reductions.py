# SPDX-License-Identifier: BSD-3-Clause
"""Reductions change no answer and cost nothing: every scene with each of them switched off."""

from __future__ import annotations

import functools
import itertools
import math
import time
from collections.abc import Callable

import numpy as np
import pytest
import scene_files
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, reaction, rod, scene, with_sensors
from models import reducible, rods
from models.running import assert_close

import gelenk
from gelenk.model.inspection import REDUCTIONS, evaluation_cost
from physics.loops.test_bricard import bricard
from physics.loops.test_parallelograms import four_bar_chain

# What reductions find something to do in, and the time [s] to run it.
BUILT: dict[str, tuple[Callable[[], Scene], float]] = {
    "tilted_four_bar": (reducible.tilted_four_bar, 2.0),
    "ball_four_bar": (reducible.ball_four_bar, 2.0),
    "triple_crank": (lambda: reducible.triple_crank(False, rate=1.0), 0.2),  # short of its change points,
    "triple_crank_turned": (lambda: reducible.triple_crank(True, rate=1.0), 0.2),  # where errors grow
    "four_bar_chain": (lambda: four_bar_chain(3, 0.2, 1.0), 0.3),  # likewise
    "bricard": (bricard, 2.0),
    "door": (reducible.door, 2.0),
    "guided": (reducible.guided, 1.0),
    "welded_chain": (reducible.welded_chain, 2.0),
    "triangle": (reducible.triangle, 1.0),
    "tripod": (lambda: reducible.tripod("universal"), 1.0),
    "spinning_tripod": (lambda: reducible.tripod("spherical"), 1.0),
    "two_mechanisms": (reducible.two_mechanisms, 1.0),
    "platform_on_balls": (reducible.platform_on_balls, 1.0),
    "massless_coupler": (rods.planar_four_bar, 2.0),
    "massless_rod": (rods.spatial_four_bar, 1.0),
}
READY = {path.stem: path for path in scene_files.good()}
OFF = [*REDUCTIONS, "all"]


def loaded(name: str) -> tuple[gelenk.Scene, float]:
    """A scene, and the time [s] to run it."""
    if name in READY:
        ready = gelenk.load(READY[name])
        return ready, ready.stop
    make, stop = BUILT[name]
    return gelenk.load(make()), stop


def answers(name: str, without: str | None) -> dict[str, Array]:
    """All outputs at 41 times, all inputs following 0.01 sin(6 t) N, N m in steps; the five-bar turns round
    and over its dead points under more.
    """
    source, stop = loaded(name)
    plant = gelenk.Simulation(source.without([without] if without else []))
    plant.initialize(0.0, 1e-11)
    rows = [plant.values()]
    times = np.linspace(0, stop, 41)
    for start, end in itertools.pairwise(times):
        for signal in plant.inputs:
            plant.set_input(signal.name, 0.01 * math.sin(6 * start))
        plant.step_to(float(end))
        rows.append(plant.values())
    columns = np.array(rows).T
    return {signal.name: column for signal, column in zip(plant.outputs, columns, strict=True)}


@functools.cache
def answers_with_all(name: str) -> dict[str, Array]:
    return answers(name, None)


@pytest.mark.parametrize("off", OFF)
@pytest.mark.parametrize("name", [*READY, *BUILT])
def test_answers_are_the_same_without(name: str, off: str) -> None:
    """Issue 3: within 1e-9 at rtol 1e-11, of each output's largest value, or of 1 of its unit where that is
    less.
    """
    expected = answers_with_all(name)
    found = answers(name, off)
    assert found.keys() == expected.keys()
    for output, value in expected.items():
        scale = max(1.0, float(np.abs(value).max()))
        assert_close(output, found[output], value, 1e-9 * scale, "one motion")


def test_only_reactions_told_to_be_undetermined_change() -> None:
    """A four-bar in space, loaded across its plane, all reactions read: with the repeated row left out and
    with the least multipliers, the rest is the same; and those told to be open do differ.
    """
    source = with_sensors(reducible.ball_four_bar(), **{f"R{j}": reaction(j) for j in "ABCD"})
    source["gravity"] = [2.0, -GRAVITY, 3.0]
    open_ones = {f"R{name}" for name in gelenk.inspect(source).undetermined_reactions}
    across = {f"R{j}.{c}" for j in "ABD" for c in ("f[3]", "t[1]", "t[2]")}
    assert open_ones == across | {
        f"RC.f[{i}]" for i in (1, 2, 3)
    }  # C's frame lies askew, and a ball holds no torque
    values = []
    for off in ([], ["redundant_rows"]):
        plant = gelenk.Simulation(gelenk.load(reducible.without(source, *off)))
        plant.initialize(0.0, 1e-11)
        plant.step_to(1.0)
        values.append({s.name: plant.output(s.name) for s in plant.outputs})
    for name, value in values[0].items():
        if name not in open_ones:
            assert_close(name, values[1][name], value, 1e-9 * max(1, abs(value)), "one motion")
    assert all(abs(values[0][name] - values[1][name]) > 1e-3 for name in open_ones)  # N, N m


# --- cost ---

# The least times of one and the same model in several simulations lie up to 10 % apart: the smallest scenes
# take 60 ns, and where their data come to lie counts.
NOISE = 1.15


def ratio_to(limit: float, source: gelenk.Scene, off: str) -> float:
    """The least cost of an evaluation without a reduction over that with all: measured in turns until it
    reaches the limit, for 20 s at most, as what else the machine does only ever makes a measurement longer.
    """
    least, least_without, ratio = math.inf, math.inf, 0.0
    end = time.monotonic() + 20
    while time.monotonic() < end:
        least = min(least, cost(source, []))
        least_without = min(least_without, cost(source, [off]))
        ratio = least_without / least
        if ratio >= limit:
            break
    return ratio


def cost(source: gelenk.Scene, off: list[str]) -> float:
    seconds = evaluation_cost(source, off).seconds
    assert seconds is not None
    return seconds


@pytest.mark.clock
@pytest.mark.parametrize("off", OFF)
@pytest.mark.parametrize("name", READY)
def test_no_reduction_makes_an_evaluation_slower(name: str, off: str) -> None:
    assert ratio_to(1 / NOISE, gelenk.load(READY[name]), off) >= 1 / NOISE


@pytest.mark.clock
def test_four_bar_is_evaluated_two_and_a_half_times_faster() -> None:
    """With all reductions against none. Issue 3 asked for three times, and got them against 1.2 us, until
    loops in space were sped up more than those in a plane: 0.9 us without, 0.34 with.
    tests/costs counts its instructions.
    """
    assert ratio_to(2.5, gelenk.load(READY["four_bar"]), "all") >= 2.5


# --- size ---


def chain(kind: str, count: int = 1000) -> Scene:
    """Rods in a row; all but the first joint are of that kind."""
    joints = {
        f"J{i}": joint(
            kind if i else "revolute",
            frame(f"rod{i - 1}", (1, 0, 0)) if i else frame("ground"),
            frame(f"rod{i}"),
        )
        for i in range(count)
    }
    return scene({f"rod{i}": rod(1, 1) for i in range(count)}, joints, gravity=[0, -GRAVITY, 0])


def flock(count: int = 1000) -> Scene:
    """Bodies that fly."""
    return scene(
        {f"bird{i}": body(1, inertia=(1, 1, 1)) for i in range(count)},
        {f"flight{i}": joint("free", frame("ground"), frame(f"bird{i}")) for i in range(count)},
    )


THOUSAND: dict[str, tuple[Callable[[], Scene], int]] = {  # and the islands they make
    "chain": (lambda: chain("revolute"), 1),
    "welded": (lambda: chain("weld"), 1),
    "loops": (lambda: four_bar_chain(500, 0.3, 1.0), 1),
    "flock": (flock, 1000),
    "pendulums": (lambda: reducible.in_line(1000, np.arange(1000.0)), 1000),
}


@pytest.mark.parametrize("name", THOUSAND)
def test_a_thousand_bodies_are_reduced_to_their_islands(name: str) -> None:
    make, islands = THOUSAND[name]
    assert gelenk.Simulation(gelenk.load(make())).size.islands == islands


@pytest.mark.clock
@pytest.mark.parametrize("name", THOUSAND)
def test_a_thousand_bodies_are_compiled_in_a_second(name: str) -> None:
    """Issue 3. CPU time; the least of three."""
    source = gelenk.load(THOUSAND[name][0]())
    spent = []
    for _ in range(3):
        begin = time.process_time()
        gelenk.Simulation(source)
        spent.append(time.process_time() - begin)
    assert min(spent) < 1.0  # s
