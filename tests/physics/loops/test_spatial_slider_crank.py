# SPDX-License-Identifier: BSD-3-Clause
"""The spatial rigid slider-crank of the IFToMM benchmark library (after Haug)
compared with published and computed values.

Crank 0.08 m about x at (0, 0.1, 0.12), rod 0.3 m with a spherical joint at the crank and a universal joint at
the slider (first axis x in the slider, second normal to x and the rod, in the rod), slider along x. The crank
rate is initially 6 rad/s, gravity is along -z. Submissions differ in the rod's inertia; here 0.0004 about its
axis, 0.004 across.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, frame_sensor, joint, matrix, scene
from models.one_dof import Jet, OneDofMechanism
from models.running import INTEGRATORS, Recording, assert_close, run
from models.spatial_loops import SliderCrank
from scipy.spatial.transform import Rotation

pytestmark = warned.TIGHT

# Published by Gonzalez (nine digits); an independent integration of this model agrees to 4e-5 m.
PUBLISHED = {
    0.1: 0.226785384,
    0.2: 0.263034975,
    0.3: 0.28194126,
    0.5: 0.184952803,
    0.6: 0.205149298,
    0.8: 0.272248997,
    1.0: 0.211754668,
}
TIMES = np.array(sorted({0.0, *np.round(np.arange(0, 1.001, 0.05), 3)}))


def slider_crank() -> Scene:
    """Body frames: crank at its revolute joint, rod at the slider (x along the rod), slider at its center."""
    n = np.array([-0.2, 0.1, 0.2]) / 0.3
    b = np.cross([1, 0, 0], n) / np.linalg.norm(np.cross([1, 0, 0], n))
    R_rod = np.column_stack([n, b, np.cross(n, b)])
    return scene(
        {
            "crank": body(0.12, (0, 0, 0.04), (1e-4, 1e-4, 1e-5)),
            "rod": body(0.5, (0.15, 0, 0), (0.0004, 0.004, 0.004)),
            "slider": body(2.0, (0, 0, 0), (1e-4, 1e-4, 1e-4)),
        },
        {
            "A": joint(
                "revolute",
                frame("ground", (0, 0.1, 0.12)),
                frame("crank"),
                axis=[1, 0, 0],
                start={"phi": 0.0, "w": 6.0, "fixed": True},
            ),
            "S": joint(
                "spherical",
                frame("crank", (0, 0, 0.08)),
                {**frame("rod", (0.3, 0, 0)), "rotation": matrix(R_rod.T)},
            ),
            "U": joint(
                "universal",
                frame("slider"),
                {**frame("rod"), "rotation": matrix(R_rod.T)},
                axes=[[1, 0, 0], b.tolist()],
            ),
            "P": joint("prismatic", frame("ground"), frame("slider"), axis=[1, 0, 0], start={"s": 0.2}),
        },
        gravity=[0, 0, -GRAVITY],
        sensors={"rod": frame_sensor("rod", (0.15, 0, 0)), "E": {"type": "energy"}},
    )


@pytest.fixture(scope="module", params=INTEGRATORS)
def crank(request: pytest.FixtureRequest) -> Recording:
    return run(slider_crank(), TIMES, tolerance=1e-11, integrator=request.param)


def test_slider_path_matches_published_values(crank: Recording) -> None:
    """The first second, before the slow dead centers amplify the differences
    between submissions: to 5e-5 m.
    """
    for t, x in PUBLISHED.items():
        row = int(np.argmin(abs(TIMES - t)))
        assert_close(f"P.s({t})", crank["P.s"][row], x, 5e-5, "spread of the submissions")


def test_slider_and_crank_match_one_coordinate_solution(crank: Recording) -> None:
    """The motion is a function of the crank angle (spatial_loops.SliderCrank),
    integrated by SciPy at 1e-12.
    """
    model = SliderCrank()
    phi, w = OneDofMechanism(model.geometry, (0, 0, -GRAVITY)).motion(0, 6, TIMES)
    slider = [model.slider(Jet(x, 1.0)) for x in phi]
    assert_close("A.phi", crank["A.phi"], phi, 1e-7, "10^4 rtol: slow dead centers amplify")
    assert_close("A.w", crank["A.w"], w, 1e-6, "ten times as much")
    assert_close("P.s", crank["P.s"], [s.x for s in slider], 1e-8, "crank 0.08 m x angles")
    assert_close("P.v", crank["P.v"], np.array([s.d for s in slider]) * w, 1e-7, "ten times as much")


def test_initial_velocities_match_published_values(crank: Recording) -> None:
    """Printed with the benchmark: rod center (0.12, -0.24, 0) m/s, rod (1.92, -0.96,
    0.48) rad/s, slider 0.24 m/s.
    """
    assert_close("rod v", crank.vector("rod.v")[0], (0.12, -0.24, 0), 1e-12, "assembly, round-off")
    w_world = Rotation.from_quat(crank.vector("rod.Q")[0]).as_matrix() @ crank.vector("rod.w")[0]
    assert_close("rod w", w_world, (1.92, -0.96, 0.48), 1e-12, "assembly, round-off")
    assert_close("P.v", crank["P.v"][0], 0.24, 1e-12, "assembly, round-off")


def test_loop_remains_closed_and_energy_is_conserved(crank: Recording) -> None:
    """There is no friction and no drive: 3 J conserved to 1e-9."""
    total = crank["E.total"]
    assert_close("energy", total, total[0], 1e-9, "100 rtol")
    assert_close("constraints.position", crank["constraints.position"], 0, 1e-10, "closure")
    assert_close("constraints.velocity", crank["constraints.velocity"], 0, 1e-9, "closure")
