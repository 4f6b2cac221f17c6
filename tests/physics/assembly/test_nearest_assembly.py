# SPDX-License-Identifier: BSD-3-Clause
"""The start is the assembly nearest to the guesses of all joints, wherever the loops are cut.

The truth is a least-squares solution over all joint coordinates, with the loop's closure as a penalty, from
many random positions.
"""

from __future__ import annotations

import functools
import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import frame, joint, placed, reordered, rotation, scene
from numpy.typing import NDArray
from scipy.optimize import least_squares
from special.plants import without

import gelenk

pytestmark = warned.GUESSES

Array = NDArray[np.float64]


PENALTY = 1e6  # of closure errors: shifts the squared distance by 1e-11 or less
ROUGH = 1e4  # of their squares, in the search


@dataclass(frozen=True)
class Chain:
    """A chain of hinges (True) and slides from the ground to the ground, with one loop."""

    hinges: tuple[bool, ...]
    axes: Array  # shape (joints, 3), in the frame of the previous body
    steps: Array  # shape (joints, 3): where each joint sits on the previous body
    end: Array  # 4x4: pose of the last joint's frame on the ground

    @property
    def names(self) -> list[str]:
        return [f"j{i}" for i in range(len(self.hinges))]

    def poses(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Rotation and position of the end, and the twists of the joints there, for positions q (n, joints).

        The twists (angular, linear), shape (n, 6, joints), are written in the world.
        """
        n = len(q)
        R, p = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3))
        axes, origins = [], []
        for hinge, axis, step, x in zip(self.hinges, self.axes, self.steps, q.T, strict=True):
            p = p + R @ step
            axes.append(R @ axis)
            origins.append(p)
            if hinge:
                K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
                turn = np.eye(3) + np.sin(x)[:, None, None] * K + (1 - np.cos(x))[:, None, None] * K @ K
                R = R @ turn
            else:
                p = p + x[:, None] * axes[-1]
        twists = [
            np.hstack([w, np.cross(w, p - o)] if hinge else [0 * w, w])
            for hinge, w, o in zip(self.hinges, axes, origins, strict=True)
        ]
        return R, p, np.stack(twists, axis=2), np.array(origins)

    def errors(self, q: Array) -> tuple[Array, Array]:
        """Closure errors (n, 6) and their Jacobian (n, 6, joints); also 0 where the end is turned by pi."""
        R, p, twists, _ = self.poses(q)
        R_end, p_end = self.end[:3, :3], self.end[:3, 3]
        E = R_end.T @ R
        turn = np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        by_turn = np.trace(E, axis1=1, axis2=2)[:, None, None] * np.eye(3) - E
        J = np.concatenate([by_turn @ R_end.T @ twists[:, :3], R_end.T @ twists[:, 3:]], axis=1)
        return np.hstack([turn / 2, (p - p_end) @ R_end]), J * np.array([0.5] * 3 + [1] * 3)[:, None]

    def residuals(self, q: Array, guess: Array, penalty: float) -> Array:
        return np.concatenate([penalty * self.errors(q[None])[0][0], q - guess])

    def jacobian(self, q: Array, _: Array, penalty: float) -> Array:
        return np.vstack([penalty * self.errors(q[None])[1][0], np.eye(len(q))])

    def gap(self, q: Array) -> float:
        """Largest closure error of one position."""
        R, p, _, _ = self.poses(q[None])
        return float(max(abs(self.end[:3, :3] - R[0]).max(), abs(self.end[:3, 3] - p[0]).max()))

    def nearest(self, guess: Array, starts: int, seed: int) -> tuple[float, Array]:
        """The squared distance of the nearest closed position, and the position.

        Levenberg-Marquardt steps from all starts at once; the best ones are then solved by SciPy.
        """
        rng = np.random.default_rng(seed)
        spread = np.minimum(math.pi, 0.1 * np.arange(starts))[:, None]
        q = guess + spread * rng.uniform(-1, 1, (starts, len(guess)))
        damping = np.ones(starts)

        def costs(c: Array, q: Array) -> Array:
            return np.asarray(ROUGH * (c**2).sum(axis=1) + ((q - guess) ** 2).sum(axis=1))

        c, J = self.errors(q)
        for _ in range(100):
            A = ROUGH * J.transpose(0, 2, 1) @ J + (1 + damping)[:, None, None] * np.eye(len(guess))
            b = ROUGH * np.einsum("nij,ni->nj", J, c) + q - guess
            tried = q - np.linalg.solve(A, b[:, :, None])[:, :, 0]
            c_tried, J_tried = self.errors(tried)
            better = costs(c_tried, tried) < costs(c, q)
            q[better], c[better], J[better] = tried[better], c_tried[better], J_tried[better]
            damping = np.where(better, damping / 5, damping * 4)
        best = (math.inf, guess)
        R = self.poses(q)[0]
        turned_by_pi = np.einsum("ij,nij->n", self.end[:3, :3], R) < 1  # the trace of the error
        for k in np.argsort(np.where(turned_by_pi, math.inf, costs(c, q)))[:6]:
            x = q[k]
            for penalty in (PENALTY / 100, PENALTY):
                x = least_squares(self.residuals, x, self.jacobian, xtol=1e-14, args=(guess, penalty)).x
            if self.gap(x) < 1e-6:
                best = min(best, (float(((x - guess) ** 2).sum()), x), key=lambda pair: pair[0])
        return best

    def scene(self, start: dict[str, dict[str, Any]]) -> dict[str, Any]:
        """The chain as a scene; the last joint connects the last body with the ground at the end."""
        n = len(self.hinges)
        bodies = {f"b{i}": {"mass": 1.0 + i, "inertia": [0.1, 0.11, 0.12, 0, 0, 0]} for i in range(n - 1)}
        joints = {}
        for i in range(n):
            parent = frame("ground" if i == 0 else f"b{i - 1}", self.steps[i])
            last = frame("ground", self.end[:3, 3], self.end[:3, :3])
            kind = "revolute" if self.hinges[i] else "prismatic"
            child = last if i == n - 1 else frame(f"b{i}")
            entry = joint(kind, parent, child, axis=[float(x) for x in self.axes[i]])
            joints[f"j{i}"] = entry | ({"start": start[f"j{i}"]} if f"j{i}" in start else {})
        return scene(bodies, joints, name="Chain")


def chain(seed: int, spatial: bool) -> Chain:
    rng = np.random.default_rng(seed)
    n = 8 if spatial else 4 + seed % 4
    slide = int(rng.integers(n))
    hinges = tuple(i != slide or n == 4 for i in range(n))
    axes = rng.normal(size=(n, 3)) if spatial else np.tile([0.0, 0.0, 1.0], (n, 1))
    if not spatial and not hinges[slide]:
        axes[slide] = [*rng.normal(size=2), 0]
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    steps = rng.uniform(-0.6, 0.6, (n, 3)) * ([1, 1, 1] if spatial else [1, 1, 0])
    somewhere = rng.uniform(-1.5, 1.5, n)
    R, p, _, _ = Chain(hinges, axes, steps, np.eye(4)).poses(somewhere[None])
    end = np.eye(4)
    end[:3, :3], end[:3, 3] = R[0], p[0]
    return Chain(hinges, axes, steps, end)


def coordinate(of: Chain, name: str) -> str:
    return f"{name}.{'phi' if of.hinges[int(name[1:])] else 's'}"


def start_of(of: Chain, source: dict[str, Any]) -> tuple[Array, Array]:
    """Coordinates and velocities at the start, in the order of the chain."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)
        plant = gelenk.Simulation(source)
        plant.initialize()
    q = [plant.output(coordinate(of, name)) for name in of.names]
    v = [plant.output(f"{n}.{'w' if h else 'v'}") for n, h in zip(of.names, of.hinges, strict=True)]
    return np.array(q), np.array(v)


def variants(source: dict[str, Any]) -> dict[str, dict[str, Any]]:
    turn = rotation([1, 2, 3], 0.7)
    return {
        "as given": source,
        "other cut": without(source, cut_choice=False),
        "no reductions": without(source, all=False),
        "reordered": reordered(source, 3),
        "reordered, other cut": without(reordered(source, 5), cut_choice=False),
        "turned": placed(source, turn, [0.3, -0.2, 0.5]),
    }


@functools.cache
def truth(seed: int, spatial: bool, guessed: bool) -> tuple[float, Array, Array]:
    of = chain(seed, spatial)
    rng = np.random.default_rng(1000 + seed)
    guess = rng.uniform(-1, 1, len(of.hinges)) if guessed else np.zeros(len(of.hinges))
    return (*of.nearest(guess, 100, seed), guess)


CASES = [*((seed, False) for seed in range(1, 6)), *((seed, True) for seed in (1, 2, 4))]


@pytest.mark.parametrize("guessed", [False, True], ids=["zero", "guesses"])
@pytest.mark.parametrize(("seed", "spatial"), CASES)
def test_start_is_the_nearest_assembly_wherever_the_loop_is_cut(
    seed: int, spatial: bool, guessed: bool
) -> None:
    of = chain(seed, spatial)
    least, position, guess = truth(seed, spatial, guessed)
    start = {n: {"phi" if h else "s": float(x)} for n, h, x in zip(of.names, of.hinges, guess, strict=True)}
    for name, source in variants(of.scene(start if guessed else {})).items():
        q, _ = start_of(of, source)
        assert of.gap(q) < 1e-9, name
        assert ((q - guess) ** 2).sum() == pytest.approx(least, rel=1e-6), name
        assert q == pytest.approx(position, abs=1e-4), name  # flat where the penalty has bent it


@pytest.mark.parametrize(("seed", "spatial"), [(2, False), (6, False), (2, True)])
def test_fixed_coordinates_of_the_nearest_assembly_keep_it(seed: int, spatial: bool) -> None:
    of = chain(seed, spatial)
    _, position, _ = truth(seed, spatial, False)
    found, _ = start_of(of, of.scene({}))
    start = {"j1": {"phi" if of.hinges[1] else "s": float(found[1]), "fixed": True}}
    for name, source in variants(of.scene(start)).items():
        q, _ = start_of(of, source)
        assert q[1] == found[1], name
        assert q == pytest.approx(position, abs=1e-4), name


@pytest.mark.parametrize(("seed", "spatial"), [(3, False), (6, False), (7, False), (1, True)])
def test_start_velocities_are_the_nearest_wherever_the_loop_is_cut(seed: int, spatial: bool) -> None:
    """Guesses are projected orthogonally; one alone is attained, with the others as small as possible."""
    of = chain(seed, spatial)
    guess = np.random.default_rng(seed).uniform(-2, 2, len(of.hinges))
    start = {n: {"w" if h else "v": float(x)} for n, h, x in zip(of.names, of.hinges, guess, strict=True)}
    for given in (start, {"j0": start["j0"]}):
        for name, source in variants(of.scene(given)).items():
            q, v = start_of(of, source)
            _, sizes, rows = np.linalg.svd(of.errors(q[None])[1][0])
            free = rows[np.sum(sizes > 1e-6) :]
            expected = (
                free.T @ (free @ guess)
                if given is start
                else guess[0] * free.T @ free[:, 0] / np.sum(free[:, 0] ** 2)
            )
            assert v == pytest.approx(expected, abs=1e-7), name


def triangle(guess: float, order: int = 0) -> dict[str, Any]:
    """Two bars of 0.5 m between a hinge and a slide 0.4 m from it: the elbow is on either side."""
    bodies = {name: {"mass": 1, "inertia": [0.02, 0.02, 0.02, 0, 0, 0]} for name in ("a", "b", "c")}
    about_z = {"axis": [0, 0, 1]}
    joints = {
        "r1": joint("revolute", frame("ground"), frame("a"), **about_z),
        "r2": joint("revolute", frame("a", (0.5, 0, 0)), frame("b"), start={"phi": guess}, **about_z),
        "r3": joint("revolute", frame("b", (0.5, 0, 0)), frame("c"), **about_z),
        "p": joint("prismatic", frame("ground"), frame("c"), axis=[1, 0, 0], start={"s": 0.4, "fixed": True}),
    }  # fmt: skip
    out = scene(bodies, joints, name="Triangle")
    return reordered(out, order) if order else out


@pytest.mark.parametrize("order", range(6))
@pytest.mark.parametrize("cut_choice", [True, False])
def test_of_two_assemblies_equally_near_the_choice_is_that_of_the_documentation(
    order: int, cut_choice: bool
) -> None:
    """r1, the first joint by name that differs, has the larger angle, also if the guess is almost 0."""
    elbow = math.pi - math.acos(0.68)  # law of cosines
    for guess in (0.0, 1e-9, -1e-9):
        plant = gelenk.Simulation(without(triangle(guess, order), cut_choice=cut_choice))
        with pytest.warns(gelenk.StartWarning, match="equally close"):
            plant.initialize()
        assert plant.output("r1.phi") == pytest.approx(elbow / 2, abs=1e-9)
        assert plant.output("r2.phi") == pytest.approx(-elbow, abs=1e-9)
    for guess in (0.01, -0.01):
        with warnings.catch_warnings():
            warnings.filterwarnings("error", ".*equally close", gelenk.StartWarning)
            plant = gelenk.Simulation(without(triangle(guess, order), cut_choice=cut_choice))
            plant.initialize()
        assert plant.output("r2.phi") == pytest.approx(math.copysign(elbow, guess), abs=1e-9)


def test_loops_without_a_common_joint_are_assembled_one_by_one() -> None:
    """Eight chains in one island are found as one alone: their 48 velocities are not searched together."""
    of = chain(6, False)
    _, position, _ = truth(6, False, False)
    one = of.scene({})
    several = scene({}, {}, name="Several")
    for k in range(8):
        for name, entry in one["bodies"].items():
            several["bodies"][f"c{k}_{name}"] = entry
        for name, entry in one["joints"].items():
            placed_entry = dict(entry)
            for end in ("parent", "child"):
                where = entry[end]["body"]
                placed_entry[end] = entry[end] | {"body": where if where == "ground" else f"c{k}_{where}"}
            several["joints"][f"c{k}_{name}"] = placed_entry
    for source in (several, without(several, islands=False), without(several, all=False)):
        plant = gelenk.Simulation(source)
        plant.initialize()
        for k in range(8):
            q = [plant.output(f"c{k}_{coordinate(of, name)}") for name in of.names]
            assert q == pytest.approx(position, abs=1e-4)


@pytest.mark.parametrize("cut_choice", [True, False])
@pytest.mark.parametrize("order", range(3))
def test_screw_in_a_loop_keeps_its_turns(cut_choice: bool, order: int) -> None:
    """A nut 0.5 m along a slide has turned its screw of 0.01 m/rad by 50 rad."""
    bodies = {name: {"mass": 1, "inertia": [1, 1, 1, 0, 0, 0]} for name in ("spindle", "nut")}
    joints = {
        "turn": joint("revolute", frame("ground"), frame("spindle"), axis=[1, 0, 0]),
        "screw": joint("screw", frame("spindle"), frame("nut"), axis=[1, 0, 0], pitch=0.01),
        "slide": joint("prismatic", frame("ground"), frame("nut"), axis=[1, 0, 0],
                       start={"s": 0.5, "fixed": True}),
    }  # fmt: skip
    plant = gelenk.Simulation(without(reordered(scene(bodies, joints), order), cut_choice=cut_choice))
    plant.initialize()
    assert plant.output("slide.s") == 0.5
    assert plant.output("screw.phi") == pytest.approx(50, abs=1e-9)
    assert math.remainder(plant.output("turn.phi") + 50, 2 * math.pi) == pytest.approx(0, abs=1e-9)


def test_guessed_velocity_of_a_prescribed_motion_moves_nothing_else() -> None:
    """The slide has the speed of its motion; the pendulum on it keeps its own guess."""
    bodies = {name: {"mass": 1, "inertia": [1, 1, 1, 0, 0, 0]} for name in ("table", "bob")}
    joints = {
        "slide": joint("prismatic", frame("ground"), frame("table"), axis=[1, 0, 0], start={"v": 0.3}),
        "swing": joint("revolute", frame("table"), frame("bob"), axis=[0, 0, 1], start={"w": 0.7}),
    }
    sine = {"type": "motion", "joint": "slide", "sine": {"amplitude": 0.05, "frequency": 2.0}}
    plant = gelenk.Simulation(scene(bodies, joints, constraints={"shake": sine}))
    plant.initialize()
    assert plant.output("slide.v") == pytest.approx(0.05 * 2 * math.pi * 2.0, rel=1e-12)
    assert plant.output("swing.w") == pytest.approx(0.7, rel=1e-12)
