# SPDX-License-Identifier: BSD-3-Clause
"""Directional and adjoint derivatives of FMI 3.0: one matrix, from both sides."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from numpy.typing import NDArray

import gelenk

from .derivatives import directional
from .host import Fmu, Slave
from .host3 import Fmu3, Slave3
from .test_fmi3 import PLANTS, SHIPPED, source_of

FORWARD, ADJOINT = "fmi3GetDirectionalDerivative", "fmi3GetAdjointDerivative"
SIZE = 1e-3  # s, of a step


@pytest.fixture(scope="module", params=[*(p for p in PLANTS if p != "touching"), *SHIPPED])
def fmus(
    request: pytest.FixtureRequest, root: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Fmu, Fmu3]:
    folder = tmp_path_factory.mktemp(request.param)
    source = source_of(request.param, root)
    for fmi in (2, 3):
        fmu = gelenk.export_fmu(source, folder / f"{fmi}.fmu", view=False, fmi=fmi)
        fmpy.extract(str(fmu), str(folder / f"fmi{fmi}"))
    return Fmu(folder / "fmi2"), Fmu3(folder / "fmi3")


def unknowns_and_knowns(fmu: Fmu3) -> tuple[list[str], list[str]]:
    derivatives = [u.variable for u in fmu.description.derivatives]
    inputs = [name for name, v in fmu.variables.items() if v.causality == "input"]
    return [*fmu.outputs, *(v.name for v in derivatives)], [
        *inputs,
        *(v.derivative.name for v in derivatives),
    ]


def jacobian(slave: Slave3, unknowns: list[str], knowns: list[str]) -> NDArray[np.float64]:
    columns = [slave.sensitivity(FORWARD, unknowns, [name], [1.0], len(unknowns)) for name in knowns]
    return np.asarray(columns, dtype=np.float64).T


def product(
    slave: Slave3, function: str, seed: NDArray[np.float64], names: tuple[list[str], list[str]]
) -> NDArray[np.float64]:
    count = len(names[0] if function == FORWARD else names[1])
    return np.asarray(slave.sensitivity(function, *names, seed.tolist(), count), dtype=np.float64)


def test_both_derivatives_are_of_one_matrix(fmus: tuple[Fmu, Fmu3]) -> None:
    """<v, J w> = <J^T v, w> to rounding of the sums: 1e-12 of the sum of the magnitudes."""
    fmu = fmus[1]
    unknowns, knowns = unknowns_and_knowns(fmu)
    slave = Slave3(fmu).start()
    slave.run(20, SIZE)
    matrix = jacobian(slave, unknowns, knowns)
    rng = np.random.default_rng(1)
    for _ in range(3):
        v, w = rng.normal(size=len(unknowns)), rng.normal(size=len(knowns))
        forward = product(slave, FORWARD, w, (unknowns, knowns))
        adjoint = product(slave, ADJOINT, v, (unknowns, knowns))
        magnitude = np.abs(v) @ np.abs(matrix) @ np.abs(w)
        assert abs(v @ forward - adjoint @ w) <= 1e-12 * magnitude
        np.testing.assert_allclose(
            adjoint, v @ matrix, rtol=0, atol=1e-12 * np.abs(v) @ np.abs(matrix).max(axis=1)
        )
    slave.free()


def test_directional_derivatives_are_bitwise_those_of_fmi_2(fmus: tuple[Fmu, Fmu3]) -> None:
    unknowns, knowns = unknowns_and_knowns(fmus[1])
    seeds = {name: 0.3 + 0.1 * i for i, name in enumerate(knowns)}
    old, new = Slave(fmus[0]).start(), Slave3(fmus[1]).start()
    assert old.run(5, SIZE) == new.run(5, SIZE)
    found = new.sensitivity(FORWARD, unknowns, knowns, list(seeds.values()), len(unknowns))
    assert found == directional(old, unknowns, seeds)
    old.free()
    new.free()


def test_an_adjoint_is_a_row_of_the_matrix_and_leaves_the_run_alone(fmus: tuple[Fmu, Fmu3]) -> None:
    fmu = fmus[1]
    unknowns, knowns = unknowns_and_knowns(fmu)
    undisturbed = Slave3(fmu).start()
    expected = undisturbed.run(10, SIZE)
    slave = Slave3(fmu).start()
    rows = slave.run(5, SIZE)
    matrix = jacobian(slave, unknowns, knowns)
    scale = np.abs(matrix).max()
    for i in (0, len(unknowns) // 2, len(unknowns) - 1):
        row = slave.sensitivity(ADJOINT, [unknowns[i]], knowns, [1.0], len(knowns))
        np.testing.assert_allclose(row, matrix[i], rtol=1e-11, atol=1e-12 * scale)
    assert rows + slave.run(5, SIZE, first=5) == expected
    undisturbed.free()
    slave.free()
