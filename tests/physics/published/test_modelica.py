# SPDX-License-Identifier: BSD-3-Clause
"""Examples of the Modelica Standard Library compared with one-coordinate
solutions and the published curves.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import Scene, box
from models import modelica
from models.modelica import G_N
from models.one_dof import Jet, OneDofMechanism
from models.planar_loops import FourBar, Link
from models.running import INTEGRATORS, Recording, assert_close, run
from models.spatial_loops import ModelicaFourbar1
from scipy.integrate import solve_ivp

pytestmark = warned.TIGHT

# Bounds against Dymola's curves are the accuracy of those curves: their distance from independent
# integrations at 1e-12 (below, and as collected with the curves), rounded up. The last row of each curve at 5
# s (3 s) is given here so that the test can run without the files.
LAST_ROWS = {
    "Elementary.Pendulum": (5.0, {"rev.phi": (-1.67963464, 1e-5), "rev.w": (-2.31814703, 5e-5)}),
    "Elementary.DoublePendulum": (
        3.0,
        {
            "revolute1.phi": (-2.31792856, 5e-5),
            "revolute2.phi": (-1.73649167, 5e-5),
            "revolute1.w": (4.09411020, 4e-4),
            "revolute2.w": (-0.0503767046, 4e-4),
        },
    ),
    "Loops.PlanarFourbar": (5.0, {"revolute1.phi": (-0.93978340, 1e-3), "revolute1.w": (6.99349011, 5e-3)}),
    "Loops.Fourbar1": (5.0, {"j1.phi": (40.3282362, 1.5e-3), "j1.w": (11.7394219, 4e-3)}),
}
SCENES = {
    "Elementary.Pendulum": modelica.pendulum,
    "Elementary.DoublePendulum": modelica.double_pendulum,
    "Loops.PlanarFourbar": modelica.planar_four_bar,
    "Loops.Fourbar1": modelica.fourbar1,
}


@pytest.mark.parametrize("name", SCENES)
def test_final_values_match_the_published_curve(name: str) -> None:
    """Compares the last row of Dymola's curve, within its accuracy."""
    stop, expected = LAST_ROWS[name]
    found = run(SCENES[name](), [0.0, stop], tolerance=1e-10)
    for signal, (value, bound) in expected.items():
        assert_close(signal, found[signal][-1], value, bound, "Dymola at 1e-6")


@pytest.mark.parametrize("name", SCENES)
def test_motion_matches_the_published_curve(name: str) -> None:
    """The whole curve if the files are available, otherwise selected rows: bounds as for the last row,
    doubled for speeds, whose maxima occur where the angles change fastest.
    """
    curve = modelica.published(name)
    found = run(SCENES[name](), curve["time"], tolerance=1e-10)
    for signal, (_, bound) in LAST_ROWS[name][1].items():
        assert_close(signal, found[signal], curve[signal], 2 * bound, "Dymola at 1e-6")


def link(end: tuple[float, float]) -> Link:
    part = box((*end, 0), 0.05, 0.05)
    length = float(np.hypot(*end))
    return Link(length, part["mass"], length / 2, 0.0, part["inertia"][2])


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_planar_four_bar_matches_one_coordinate_solution(integrator: str) -> None:
    """Within 1e-7 rad; the ground link is inclined, the crank makes full turns."""
    times = np.linspace(0, 5, 101)
    lean = float(np.arctan2(1, -0.15))
    bars = FourBar(link((0.4, 0)), link((0.1, 1.1)), link((0.65, 0.1)), float(np.hypot(0.15, 1)), branch=-1)
    down = [-G_N * np.sin(lean), -G_N * np.cos(lean), 0.0]
    motion = OneDofMechanism(bars.geometry(), down, lambda _t, _phi, w: -0.1 * w)
    phi, w = motion.motion(-lean, 0, times)
    found = run(modelica.planar_four_bar(), times, tolerance=1e-10, integrator=integrator)
    assert_close("revolute1.phi", found["revolute1.phi"], phi + lean, 1e-7, "1000 rtol")
    assert_close("revolute1.w", found["revolute1.w"], w, 1e-6, "ten times as much")


def test_pendulum_matches_its_equation_of_motion() -> None:
    """(J + m c^2) phi'' = -m g c cos phi - d phi', by SciPy at 1e-12."""
    times = np.linspace(0, 5, 51)

    def rates(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], (-G_N * 0.5 * np.cos(y[0]) - 0.1 * y[1]) / 0.251]

    truth = solve_ivp(rates, (0, 5), [0, 0], method="DOP853", rtol=1e-12, atol=1e-12, t_eval=times).y
    found = run(modelica.pendulum(), times, tolerance=1e-11)
    assert_close("rev.phi", found["rev.phi"], truth[0], 2e-9, "200 rtol")
    assert_close("rev.w", found["rev.w"], truth[1], 1e-8, "omega0 times as much")


FOURBAR1_TIMES = np.linspace(0, 2, 41)


@pytest.fixture(scope="module")
def fourbar1_reference() -> dict[str, np.ndarray]:
    """From the geometry alone: crank angle and speed, slider, and the two angles of the universal joint."""
    model = ModelicaFourbar1()
    phi, w = OneDofMechanism(model.geometry, (0, -G_N, 0)).motion(0, 5.235987755982989, FOURBAR1_TIMES)
    cross = [model.rod(Jet(x)) for x in phi]
    slider = [model.slider(Jet(x, 1.0)) for x in phi]
    return {
        "j1.phi": phi,
        "j1.w": w,
        "j2.s": np.array([s.x for s in slider]),
        "j2.v": np.array([s.d for s in slider]) * w,
        "alpha": np.array([a.x for a, _ in cross]),
        "beta": np.array([b.x for _, b in cross]),
    }


@pytest.fixture(
    scope="module",
    params=[(c, i) for c in (False, True) for i in INTEGRATORS],
    ids=["joints-ida", "joints-erk", "chain-ida", "chain-erk"],
)
def fourbar1(request: pytest.FixtureRequest) -> tuple[Scene, Recording]:
    chain, integrator = request.param
    source = modelica.fourbar1(chain)
    return source, run(source, FOURBAR1_TIMES, tolerance=1e-11, integrator=integrator)


def test_fourbar1_matches_one_coordinate_solution(fourbar1, fourbar1_reference) -> None:
    """Four turns of the crank in 2 s; with compound joints and with chains of
    revolute joints as in Modelica.
    """
    source, found = fourbar1
    for name in ("j1.phi", "j2.s"):
        assert_close(name, found[name], fourbar1_reference[name], 1e-7, "10^4 rtol, 15 rad")
    for name in ("j1.w", "j2.v"):
        assert_close(name, found[name], fourbar1_reference[name], 1e-6, "ten times as much")
    angles = ("rev.phi", "rev1.phi") if "rev" in source["joints"] else ("cross.phi_a", "cross.phi_b")
    for name, key in zip(angles, ("alpha", "beta"), strict=True):
        assert_close(name, found[name], fourbar1_reference[key], 1e-7, "10^4 rtol")


def test_fourbar1_remains_closed(fourbar1) -> None:
    """At every output."""
    _, found = fourbar1
    assert_close("constraints.position", found["constraints.position"], 0, 1e-10, "closure")
    assert_close("constraints.velocity", found["constraints.velocity"], 0, 1e-9, "closure")


def test_angles_of_two_revolute_joints_equal_those_of_the_universal_joint() -> None:
    """Also speeds and accelerations: a universal joint is two revolute joints with nothing in between."""
    joints = run(modelica.fourbar1(), FOURBAR1_TIMES, tolerance=1e-11)
    chain = run(modelica.fourbar1(chain=True), FOURBAR1_TIMES, tolerance=1e-11)
    for suffix, level in (("phi", "phi"), ("w", "w"), ("a", "a")):
        bound = 1e-4 if level == "a" else 1e-6
        for hinge, letter in (("rev", "a"), ("rev1", "b")):
            assert_close(
                f"{hinge}.{level}",
                chain[f"{hinge}.{level}"],
                joints[f"cross.{suffix}_{letter}"],
                bound,
                "two runs at 1e-11; accelerations reach 500 rad/s2",
            )
