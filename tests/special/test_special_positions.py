# SPDX-License-Identifier: BSD-3-Clause
"""At special positions all reductions, cuts and file orders give the same results,
which agree with closed forms.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import scene_files
import warned
from mechanisms import placed, rotation
from samples import thorough_beyond
from scipy.integrate import solve_ivp

import gelenk
from gelenk.linear import LinearModel, linear_model

from .compare import Comparison
from .drawn import Case, drawn
from .finished import finished
from .listed import families, started, starts
from .named import Linkage, crank_slider, four_bar_linkage, scotch_yoke, turning_block
from .study import FOUND

UP, LEFT = math.pi / 2, math.pi
SLIDER_CRANK = crank_slider(0.1, 0.4)
SHIPPED_FOUR_BAR = (0.5, 1.75, 1.5, 2.0)

# Positions where the rate of a joint that may be cut vanishes, or nearly vanishes, and positions nearby.
NAMED: dict[str, tuple[Linkage, float]] = {
    "slider-crank, crank across the slide": (SLIDER_CRANK, UP),
    "slider-crank, crank across, below": (SLIDER_CRANK, -UP),
    "slider-crank, crank across, below, a turn on": (SLIDER_CRANK, 3 * UP),
    "slider-crank, stretched": (SLIDER_CRANK, 0.0),
    "slider-crank, folded": (SLIDER_CRANK, LEFT),
    "slider-crank, beside": (SLIDER_CRANK, 1.5),
    "slider-crank with an offset": (crank_slider(0.1, 0.4, 0.05), UP),
    "slider-crank, offset, crank across": (crank_slider(0.25, 0.5, 0.25), UP),
    "four-bar, crank in line with the ground": (four_bar_linkage(SHIPPED_FOUR_BAR), 0.0),
    "four-bar, crank in line, folded back": (four_bar_linkage(SHIPPED_FOUR_BAR), LEFT),
    "four-bar, other branch": (four_bar_linkage(SHIPPED_FOUR_BAR, -1), 0.0),
    "four-bar, other branch, folded back": (four_bar_linkage(SHIPPED_FOUR_BAR, -1), LEFT),
    "four-bar, beside": (four_bar_linkage(SHIPPED_FOUR_BAR), 0.05),
    "crank-rocker of round sizes": (four_bar_linkage((0.5, 1.5, 1.5, 2.0)), 0.0),
    "drag link": (four_bar_linkage((1.5, 1.75, 2.0, 0.5)), LEFT),
    "kite": (four_bar_linkage((1.0, 2.0, 2.0, 1.0), -1), UP),
    "no bar goes round": (four_bar_linkage((1.0, 1.2, 1.1, 1.5)), 0.0),
    "Scotch yoke, crank up": (scotch_yoke(0.3), UP),
    "Scotch yoke, crank down": (scotch_yoke(0.3), -UP),
    "Scotch yoke, crank along the slide": (scotch_yoke(0.3), 0.0),
    "Scotch yoke, crank back": (scotch_yoke(0.3), LEFT),
    "turning block, crank towards it": (turning_block(0.5, 1.5), 0.0),
    "turning block, crank away from it": (turning_block(0.5, 1.5), LEFT),
}
SAMPLE = [file for file in scene_files.good() if file.stem in ("four_bar", "slider_crank", "double_pendulum")]
TILTED = rotation([0.3, -0.7, 0.5], 1.3)
SPEEDS = (0.0, 2.0)  # rad/s
# Central differences of sixth order, h = 1e-3: h^6 times seventh derivatives up to 1e6, round-off divided by
# h.
DIFFERENCES = 1e-9


def assert_matches_geometry(found: LinearModel, truth: Linkage, phi: float, w: float) -> None:
    """Compare x0, rates, A, B and C with the linkage's geometry."""
    assert found.states == ("A.phi", "A.w")
    expected = truth.outputs(phi, w)
    size = 1 + max(abs(x) for x in expected.values())
    at = dict(zip(found.outputs, found.y0, strict=True))
    for name, value in expected.items():
        assert at[name] == pytest.approx(value, abs=1e-11 * size), name
    derivatives = truth.derivatives(phi, w)
    size = 1 + max(np.abs(row).max() for row in derivatives.values())
    for name, row in derivatives.items():
        found_row = found.C[found.outputs.index(name)]
        assert found_row == pytest.approx(row, abs=DIFFERENCES * size), name
    assert found.A[0] == pytest.approx([0, 1], abs=0)
    assert found.A[1] == pytest.approx(derivatives["A.a"], abs=DIFFERENCES * size)
    assert found.B[:, 0] == pytest.approx([0, 1 / truth.inertia(phi)], rel=1e-11)


@pytest.mark.parametrize("w", SPEEDS)
@pytest.mark.parametrize("name", NAMED)
def test_linear_model_matches_the_geometry(name: str, w: float) -> None:
    linkage, phi = NAMED[name]
    assert_matches_geometry(linear_model(linkage.source(phi, w)), linkage, phi, w)


@pytest.mark.parametrize("name", NAMED)
def test_linear_model_matches_the_geometry_in_an_oblique_plane(name: str) -> None:
    linkage, phi = NAMED[name]
    assert_matches_geometry(
        linear_model(placed(linkage.source(phi, 2.0), TILTED, (0.3, -0.2, 0.7))), linkage, phi, 2.0
    )


@pytest.mark.parametrize("name", NAMED)
def test_run_from_special_position_matches_the_geometry(name: str) -> None:
    linkage, phi = NAMED[name]
    plant = gelenk.Simulation(linkage.source(phi, 1.5))
    plant.initialize(0.0, 1e-10)
    plant.step_to(0.2)
    exact = _motion(linkage, phi, 1.5, 0.2)
    # 1e4 times the tolerance; a joint classified as a weld ends the run in its first step.
    assert plant.output("A.phi") == pytest.approx(exact[0], abs=1e-6)
    assert plant.output("A.w") == pytest.approx(exact[1], abs=1e-6)


def _motion(linkage: Linkage, phi: float, w: float, stop: float) -> tuple[float, float]:
    found = solve_ivp(
        lambda _t, y: [y[1], linkage.acceleration(y[0], y[1])], (0, stop), [phi, w], method="DOP853",
        rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    assert found.success
    return float(found.y[0, -1]), float(found.y[1, -1])


@pytest.mark.parametrize(
    ("linkage", "angles"),
    [
        (SLIDER_CRANK, (UP, -UP)),
        (four_bar_linkage(SHIPPED_FOUR_BAR), (0.0, LEFT)),
        (scotch_yoke(0.3), (UP, -UP)),
    ],
    ids=["slider-crank", "four-bar", "Scotch yoke"],
)
def test_fmu_started_at_a_special_position_matches_the_geometry(
    linkage: Linkage, angles: tuple[float, ...], tmp_path: Path
) -> None:
    """Exported at another position, with its start parameter set: the linear model, and a run."""
    fmu = gelenk.export_fmu(gelenk.load(linkage.source(0.7, 0.0)), tmp_path / "Linkage.fmu")
    for phi in angles:
        assert_matches_geometry(linear_model(fmu, at={"A.phi": phi, "A.w": 2.0}), linkage, phi, 2.0)
        run = gelenk.simulate(
            fmu, stop=0.2, step=0.05, tolerance=1e-10, parameters={"A.phi_start": phi, "A.w_start": 2.0}
        )
        exact = _motion(linkage, phi, 2.0, 0.2)
        assert run["A.phi"][-1] == pytest.approx(exact[0], abs=1e-6)
        assert run["A.w"][-1] == pytest.approx(exact[1], abs=1e-6)


# --- all ways of computing compared with each other; `make special` compares more of them ---


def findings(case: Case, seed: int) -> list[str]:
    verdicts = list(Comparison(case, seed).verdicts())
    assert any(v.kind in ("agree", "refused") for v in verdicts), "nothing was compared"
    return [f"{case.name} | {v.check}: {v.kind}: {v.words}" for v in verdicts if v.kind in FOUND]


@pytest.mark.parametrize("path", thorough_beyond(scene_files.good(), SAMPLE), ids=lambda path: path.stem)
def test_shipped_scenes_agree_at_special_positions(path: Path) -> None:
    """Every third of their starts: at other angles, as given, at rest, without gravity, tilted."""
    found = []
    for i, case in enumerate(list(starts(path.stem, gelenk.load(path).to_dict()))[::3]):
        found += findings(case, i)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("path", thorough_beyond(scene_files.good(), SAMPLE), ids=lambda path: path.stem)
def test_fmus_of_shipped_scenes_agree_at_special_positions(path: Path) -> None:
    """Exported at one angle, started at the others."""
    found = []
    for name, verdicts in finished(path.stem, gelenk.load(path).to_dict()):
        found += [f"{name} | {v.check}: {v.kind}: {v.words}" for v in verdicts if v.kind in FOUND]
    assert not found, "\n".join(found)


@warned.GUESSES
@pytest.mark.parametrize("angle", [0.0, LEFT])
def test_two_cranks_in_line_are_not_singular(angle: float) -> None:
    """No motion of the cranks rotates the tool joint here: two degrees of freedom,
    and no singular configuration.
    """
    source = gelenk.load(scene_files.SCENES / "five_bar.yaml").to_dict()
    case = Case("five_bar", started(source, {"left": angle, "right": angle}))
    assert not findings(case, 0)
    assert len(linear_model(case.source).states) == 4


# Bars fully extended between the ground and a crank that is on the branch of its own loop.
@pytest.mark.study
@pytest.mark.parametrize(
    ("family", "name"), [("speed: nfourbar_2", "j_V0 at -90°"), ("windows 3", "A0 at -90°")]
)
def test_bars_rigid_to_second_order_do_not_move(family: str, name: str) -> None:
    """The bars are immobile in every order of the file, or the start gives a warning. Where round-off had
    closed the loops beside the singular position, the start was on no branch, with accelerations of 1e8 1/s2.
    """
    found = []
    for i, case in enumerate(starts(family, dict(families())[family])):
        if name in case.name:
            found += findings(case, i)
    assert not found, "\n".join(found)


# Cut joints that are instantaneously at rest: these caused wrong accelerations, linear models and runs. 1169:
# a start that round-off closes beside a singular position, without a warning. 1126, 1705: the comparison was
# wrong.
REGRESSIONS = (102, 115, 205, 248, 263, 292, 1126, 1169, 1705, 1766, 2056)


@pytest.mark.parametrize("seed", REGRESSIONS)
def test_regressions_of_random_mechanisms(seed: int) -> None:
    found = findings(drawn(seed), seed)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("first", thorough_beyond(range(0, 100, 10), [50]))
def test_random_mechanisms_agree_at_special_positions(first: int) -> None:
    found = []
    for seed in range(first, first + 10):
        found += findings(drawn(seed), seed)
    assert not found, "\n".join(found)
