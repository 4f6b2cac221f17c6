# SPDX-License-Identifier: BSD-3-Clause
"""Every integrator gives the same motion with its own order,
errors that follow the tolerance, and solves stiff scenes.

Orders from the Taylor expansion of one step: the local error of rk4 is of order h^5, the global error h^4.
The improved Euler method q += h (v + h/2 vdot), v += h vdot has local errors of h^3 in q but of h^2/2
d(vdot)/dt in v; over a run the error of velocities is of order h, and so is that of q, their integral: order
1. Projection changes a state by at most its own error, so orders are preserved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from models.running import Recording, assert_close, run

from gelenk.chart.mechanisms import governor

pytestmark = warned.TIGHT

ADAPTIVE = ("ida", "cvode", "cvode-adams", "dirk", "erk")
FIXED = {"rk4": 4, "euler": 1}


def heavy_top() -> Scene:
    """The top of test_heavy_top.py with a fifth of the spin."""
    return scene(
        {"top": body(15, (0, 1, 0), (0.234375, 0.46875, 0.234375))},
        {"O": joint("spherical", frame("ground"), frame("top"), start={"w": [0, 30, -4.61538]})},
        gravity=[0, 0, -GRAVITY],
    )


def cart_pole() -> Scene:
    return scene(
        {"cart": body(1), "pole": body(0.2, (0, 0, 0.3), (0.006, 0.006, 0))},
        {
            "track": joint("prismatic", frame("ground"), frame("cart"), axis=[1, 0, 0], damping=0.1),
            "hinge": joint(
                "revolute",
                frame("cart"),
                frame("pole"),
                axis=[0, 1, 0],
                damping=0.002,
                start={"phi": 2.0, "w": 0.5, "fixed": True},
            ),
        },
        gravity=[0, 0, -GRAVITY],
        motors={"drive": {"joint": "track"}},
    )


# scene, inputs, seconds
MOTIONS: dict[str, tuple[Callable[[], Scene], Mapping[str, float], float]] = {
    "four bar": (four_bar, {"drive.tau": 3.0}, 2.0),
    "heavy top": (heavy_top, {}, 0.5),
    "cart-pole": (cart_pole, {"drive.f": 0.7}, 2.0),
}


def move(
    motion: str, integrator: str, tolerance: float = 1e-12, points: int = 11, step: float = 0
) -> Recording:
    source, inputs, end = MOTIONS[motion]
    times = np.linspace(0, end, points)
    return run(source(), times, tolerance=tolerance, integrator=integrator, inputs=inputs, step=step)


def states(motion: str, found: Recording) -> dict[str, np.ndarray]:
    """Positions and velocities; accelerations follow from them."""
    joints = found.joint_states(MOTIONS[motion][0]())
    return {name: value for name, value in joints.items() if name.split(".")[1][0] not in "az"}


def error(motion: str, found: Recording, truth: Recording) -> float:
    return max(float(np.abs(found[name] - value).max()) for name, value in states(motion, truth).items())


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("integrator", ADAPTIVE[:-1])
def test_all_integrators_give_the_same_motion(motion: str, integrator: str) -> None:
    truth = move(motion, "erk", 1e-13)
    found = move(motion, integrator, 1e-11)
    for name, expected in states(motion, truth).items():
        assert_close(f"{integrator}: {name}", found[name], expected, 5e-7, "5e4 rtol")
    assert found["constraints.position"].max() < 1e-12
    assert found["constraints.velocity"].max() < 1e-11


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_errors_follow_the_tolerance(motion: str, integrator: str) -> None:
    """With 1e-4 of the tolerance a proportional error would be 1e-4 as large; 1e-2 is required."""
    truth = move(motion, "erk", 1e-13)
    coarse, fine = (error(motion, move(motion, integrator, tol), truth) for tol in (1e-5, 1e-9))
    assert fine < 1e-2 * coarse, f"errors {coarse}, {fine}"
    assert fine < 1e-5, f"error {fine}"


@pytest.mark.parametrize("integrator", FIXED)
def test_order_of_fixed_steps(motion: str, integrator: str) -> None:
    """error(h) / error(h/2) = 2^p within 10 %, projection included."""
    order = FIXED[integrator]
    first = 4096 if order == 1 else 1024 if motion == "heavy top" else 256
    source, inputs, _ = MOTIONS[motion]
    name = {"four bar": "A.phi", "heavy top": "O.w[1]", "cart-pole": "hinge.phi"}[motion]
    times = np.array([0, 0.5])
    truth = run(source(), times, tolerance=1e-13, integrator="erk", inputs=inputs)[name][-1]
    errors = [
        abs(run(source(), times, integrator=integrator, inputs=inputs, step=1 / n)[name][-1] - truth)
        for n in (first, 2 * first)
    ]
    assert math.isclose(errors[0] / errors[1], 2**order, rel_tol=0.1), f"errors {errors}"


@pytest.mark.parametrize("integrator", ["rk4", "euler", *ADAPTIVE])
def test_runs_are_bitwise_reproducible(integrator: str) -> None:
    first, second = (move("four bar", integrator, 1e-6, step=1e-3) for _ in range(2))
    for name in first.joint_states(four_bar()):
        assert np.array_equal(first[name], second[name]), name


def test_constant_acceleration_is_exact_with_euler() -> None:
    """X = v0 t - g t^2/2 for any step size."""
    start = {"s": 0.0, "v": 3.0, "fixed": True}
    source = scene(
        {"b": body(2)},
        {"P": joint("prismatic", frame("ground"), frame("b"), axis=[0, 0, 1], start=start)},
        gravity=[0, 0, -GRAVITY],
    )
    times = np.linspace(0, 1, 5)
    found = run(source, times, integrator="euler", step=0.25)
    assert_close("P.s", found["P.s"], 3 * times - GRAVITY * times**2 / 2, 1e-14, "round-off")


@pytest.mark.parametrize("integrator", ["ida", "cvode", "dirk"])
def test_implicit_methods_solve_stiff_scene_with_long_steps(integrator: str) -> None:
    """The height of the collar after 10 s is 0.6196229171 m;
    erk needs 9000 steps for it, limited by stability.
    """
    times = [0.0, 10.0]
    explicit = run(governor(), times, tolerance=1e-4, integrator="erk")
    assert_close(
        "erk: P.s", explicit["P.s"][-1], 0.6196229171, 1e-8, "erk is limited by stability, not accuracy"
    )
    found = run(governor(), times, tolerance=1e-4, integrator=integrator)
    assert found["solver.steps"][-1] < explicit["solver.steps"][-1] / 4
    assert found["solver.evaluations"][-1] < explicit["solver.evaluations"][-1] / 10
    assert_close(f"{integrator}: P.s", found["P.s"][-1], 0.6196229171, 1e-2, "100 rtol")
