# SPDX-License-Identifier: BSD-3-Clause
"""Sobol indices of mechanisms whose indices are known in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

pytest.importorskip("SALib")

FORCE, MASS = (1.0, 3.0), (0.5, 2.0)  # N, kg: ranges of uniform distributions
SLIDER: dict[str, Any] = {
    "gelenk": 1, "gravity": [0, 0, 0], "bodies": {"mass": {"mass": 2.0}}, "parameters": ["mass.mass"],
    "joints": {"track": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "mass",
                         "start": {"s": 0, "v": 0, "fixed": True}}},
    "motors": {"drive": {"joint": "track"}},
    "solver": {"integrator": "rk4"},
}  # fmt: skip


def pushed(**options: Any) -> Any:
    """A mass that a constant force pushes: s = F t^2 / (2 m)."""
    given: dict[str, Any] = {
        "design": "saltelli", "samples": 1024, "seed": 3, "stop": 1.0, "step": 0.25,
        "outputs": {"track.s": "last"},
    }  # fmt: skip
    parameters = {"drive.f": "uniform({}, {})".format(*FORCE), "mass.mass": "uniform({}, {})".format(*MASS)}
    return gelenk.sweep(SLIDER, parameters, **given | options)


def compare(found: Any, first: Any, total: Any) -> None:
    """The returned half widths are 1.96 standard deviations: three of these are allowed."""
    for index, exact in (("first", first), ("total", total)):
        width = found.sel(index=f"{index}_conf").values
        assert width.max() < 0.15
        apart = np.abs(found.sel(index=index).values - exact)
        assert (apart <= 1.53 * width + 1e-12).all(), (index, apart, width)


@pytest.mark.thorough
def test_a_pushed_mass_has_the_indices_of_a_product() -> None:
    """Of a product of independent factors x and y: V = E[x^2] E[y^2] - E[x]^2 E[y]^2, of first order
    Var(x) E[y]^2 / V, total Var(x) E[y^2] / V.
    """
    (a, b), (c, d) = FORCE, MASS
    means = np.array([(a + b) / 2, np.log(d / c) / (d - c)])  # of F and of 1/m
    squares = np.array([(a * a + a * b + b * b) / 3, 1 / (c * d)])
    variance = squares.prod() - means.prod() ** 2
    own = squares - means**2
    found = gelenk.sobol(pushed())["track.s.last"]
    assert found.sel(index="first").parameter.values.tolist() == ["drive.f", "mass.mass"]
    compare(found, own * means[::-1] ** 2 / variance, own * squares[::-1] / variance)
    assert float(found.sel(index="first").sum()) < 1 < float(found.sel(index="total").sum())  # they interact


@pytest.mark.thorough
def test_three_links_have_the_indices_of_the_ishigami_function() -> None:
    """Of sin x + 7 sin^2 y + 0.1 z^4 sin x (Ishigami & Homma 1990) with angles in [-pi, pi]."""
    names = ("A", "B", "C")
    scene: dict[str, Any] = {
        "gelenk": 1, "gravity": [0, 0, 0],
        "bodies": {f"link_{n}": {"mass": 1, "inertia": [0.1, 0.1, 0.1]} for n in names},
        "joints": {n: {"type": "revolute", "axis": [0, 0, 1], "parent": "ground", "child": f"link_{n}",
                       "start": {"phi": 0, "w": 0, "fixed": True}} for n in names},
    }  # fmt: skip

    def ishigami(_: Any, x: Any, y: Any, z: Any) -> float:
        return float(np.sin(x[-1]) + 7 * np.sin(y[-1]) ** 2 + 0.1 * z[-1] ** 4 * np.sin(x[-1]))

    study = gelenk.sweep(
        scene, {f"{n}.phi_start": "uniform(-3.141592653589793, 3.141592653589793)" for n in names},
        design="saltelli", samples=1024, outputs={"value": (ishigami, [f"{n}.phi" for n in names])},
        stop=0.01, step=0.01,
    )  # fmt: skip
    found = gelenk.sobol(study)["value"]
    a, b = 7.0, 0.1
    x, y = 0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8
    both = b**2 * np.pi**8 * (1 / 18 - 1 / 50)
    total = x + y + both
    compare(found, np.array([x, y, 0]) / total, np.array([x + both, y, both]) / total)


def test_trajectories_have_indices_at_each_time() -> None:
    found = gelenk.sobol(pushed(outputs={"track.v": ["last", "trajectory"]}, samples=64))
    assert found["track.v"].dims == ("index", "parameter", "time")
    assert np.isnan(found["track.v"].isel(time=0)).all()  # it does not vary there
    last = found["track.v"].isel(time=-1).values
    assert last.tobytes() == found["track.v.last"].values.tobytes()
    assert found.time.values.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_an_interrupted_study_has_the_same_indices(tmp_path: Any) -> None:
    def interrupt(done: int, _: int) -> None:
        if done > 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pushed(samples=256, store=tmp_path, progress=interrupt)
    found = gelenk.sobol(pushed(samples=256, store=tmp_path))
    assert found.identical(gelenk.sobol(pushed(samples=256)))


def test_studies_without_indices_say_why() -> None:
    with pytest.raises(gelenk.UsageError, match="design: found 'latin', expected a sweep with the design"):
        gelenk.sobol(pushed(design="latin", samples=8))
    with pytest.raises(gelenk.UsageError, match="samples: found 100, expected a power of 2"):
        pushed(samples=100)
    with pytest.raises(gelenk.UsageError, match="confidence: found 2, expected a number between 0 and 1"):
        gelenk.sobol(pushed(samples=8), confidence=2)
    failing = gelenk.sweep(
        SLIDER, {"mass.mass": "uniform(-1, 1)"}, design="saltelli", samples=8, outputs={"track.s": "last"},
        stop=0.01,
    )  # fmt: skip
    with pytest.raises(
        gelenk.UsageError, match=r"of 24 runs have failed, and Sobol indices need all .* mass"
    ):
        gelenk.sobol(failing)
