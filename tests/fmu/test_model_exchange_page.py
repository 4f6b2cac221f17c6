# SPDX-License-Identifier: BSD-3-Clause
"""The programs of docs/fmu.md for importers of model exchange."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk


def program(root: Path, heading: str) -> str:
    section = (root / "docs" / "fmu.md").read_text(encoding="utf-8").split(f"### {heading}\n")[1]
    found = re.search(r"```python\n(.*?)```", section, re.DOTALL)
    assert found
    return found[1]


def run(root: Path, heading: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    (folder / "scenes").symlink_to(root / "scenes")
    monkeypatch.chdir(folder)
    names: dict[str, Any] = {}
    exec(compile(program(root, heading), heading, "exec"), names)
    return names


def test_scipy_agrees_with_co_simulation(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both at 1e-10, of which co-simulation keeps 100 times."""
    names = run(root, "SciPy", tmp_path, monkeypatch)
    inside = gelenk.simulate(root / "scenes" / "four_bar.yaml", stop=1.0, tolerance=1e-10)
    found = names["run"].y[:, -1]
    assert found[0] == pytest.approx(inside["A.phi"][-1], abs=1e-8)
    assert found[1] == pytest.approx(inside["A.w"][-1], abs=1e-7)


def test_casadi_brings_a_pendulum_to_rest(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The force found, as straight lines, in co-simulation. The trapezoidal rule leaves an error that falls
    with the square of its step: 0.079 rad at 25 ms.
    """
    pytest.importorskip("casadi", reason="casadi is not installed")
    names = run(root, "CasADi", tmp_path, monkeypatch)
    times = np.linspace(0, 1.5, 121)
    result = gelenk.simulate(
        root / "scenes" / "cart_pole.yaml",
        stop=1.5,
        step=1.5 / 120,
        tolerance=1e-9,
        parameters={"hinge.phi_start": 0.3},
        inputs={"drive.f": lambda t: float(np.interp(t, times, names["force"]))},
    )
    assert abs(result["hinge.phi"][-1]) < 1.1 * 0.079 / 4
    assert abs(result["track.s"][-1]) < 0.079 / 4
    assert np.abs(result["hinge.phi"]).max() == 0.3  # without the force it would fall


def test_casadi_differentiates_through_loops(root: Path, tmp_path: Path) -> None:
    """Jacobians of the five-bar's states and inputs, against those of the linear model."""
    ca = pytest.importorskip("casadi", reason="casadi is not installed")
    import fmpy

    source = root / "scenes" / "five_bar.yaml"
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    dae = ca.DaeBuilder("five_bar", str(fmpy.extract(str(fmu), str(tmp_path / "extracted"))))
    f = dae.create("f", ["x", "u"], ["ode"])
    jacobians = f.factory("J", ["x", "u"], ["jac:ode:x", "jac:ode:u"])
    sim = gelenk.Simulation(source)
    sim.initialize()
    A, B = jacobians([sim.output(name) for name in dae.x()], [0.0] * len(dae.u()))
    model = gelenk.linearize(source)
    order = [model.state_labels.index(name.replace(".", "_")) for name in dae.x()]
    inputs = [model.input_labels.index(name.replace(".", "_")) for name in dae.u()]
    scale = np.abs(model.B).max()
    np.testing.assert_allclose(np.array(A), model.A[np.ix_(order, order)], rtol=0, atol=1e-11 * scale)
    np.testing.assert_allclose(np.array(B), model.B[np.ix_(order, inputs)], rtol=0, atol=1e-11 * scale)
