# SPDX-License-Identifier: BSD-3-Clause
"""In time steps, too, what would turn back comes to rest before, and is held by static friction."""

from __future__ import annotations

import numpy as np
import pytest
from models.touching import inertia_of_box, on_plane

import gelenk

MASS, SIZE, GRAVITY = 1.3, (0.2, 0.2, 0.02), 10.0  # kg, m, m/s2
SLIDING, STATIC = 0.5, 1.1  # N
STEP = 1e-3  # s


@pytest.mark.parametrize("force", [0.8, 1.3])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, -0.8)])
@pytest.mark.parametrize("v0", [0.31, 0.3102, 0.3104, 0.3106, 0.3108])
def test_a_box_is_held_or_turns_back(v0: float, direction: tuple[float, float], force: float) -> None:
    """A force between sliding and static friction stops it, anywhere within a step; a larger one turns it."""
    along = np.array([*direction, 0.0])
    scene = on_plane(
        {"box": list(SIZE)},
        MASS,
        inertia_of_box(MASS, SIZE),
        {"r": [0, 0, SIZE[2] / 2], "v": (v0 * along).tolist()},
        {"friction": SLIDING / (MASS * GRAVITY), "static": STATIC / (MASS * GRAVITY)},
        step=STEP,
    )
    scene["gravity"] = [0, 0, -GRAVITY]
    scene["forces"] = {"push": {"type": "wrench", "body": "body", "force": (-force * along).tolist()}}
    run = gelenk.simulate(scene, stop=0.6, step=0.05)
    r = np.array([run[f"J.r[{i}]"] for i in (1, 2, 3)]).T @ along
    stopped = v0 * MASS / (force + SLIDING)  # s
    back = max(force - SLIDING, 0.0) / MASS if force > STATIC else 0.0
    exact = v0 * stopped / 2 - back * np.maximum(run.time - stopped, 0) ** 2 / 2
    after = run.time > stopped
    # Of order 1, where it stops: an error of the speed of up to a step, for 0.4 s.
    np.testing.assert_allclose(r[after], exact[after], rtol=0, atol=STEP * (v0 + 0.4 * force / MASS))
    if back == 0:
        np.testing.assert_allclose(r[after], r[-1], rtol=0, atol=1e-9)
