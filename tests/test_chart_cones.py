# SPDX-License-Identifier: BSD-3-Clause
"""Charts of the cone solvers: complete, drawn, failures distinguished."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gelenk.chart import cones
from gelenk.cli import app

pytest.importorskip("PIL.Image", reason="matplotlib (the extra charts) is not installed")


@pytest.mark.study
def test_cones_from_the_command_line(tmp_path: Path) -> None:
    """Twelve problems, and twelve recorded ones: what the default solver solves, also Coulomb's law."""
    for options, name in ([], "cones"), (["--coulomb"], "cones-coulomb"):
        arguments = ["chart", "cones", "--quick", *options, "-o", str(tmp_path)]
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 0, result.output
        assert 30_000 < (tmp_path / f"{name}.png").stat().st_size < 300_000
        rows = (tmp_path / f"{name}.csv").read_text(encoding="utf-8").splitlines()
        assert rows[0] == "problem,kind,solver,residual,products,seconds"
        # Coulomb's law in walls that are struck is not solved to rounding by any method.
        for level, kinds in (
            ("1e-10", {"dense", "chain", "redundant", "spheres", "loops"}),
            ("1e-05", {"boxes"}),
        ):
            reached = [row.split(",") for row in rows if f",hybrid,{level}," in row]
            assert len(reached) == 24
            assert all(0 < int(row[4]) < 500 for row in reached if row[1] in kinds)
        assert "| `gauss-seidel` |" in result.output


def test_runs_of_cone_solvers_end_at_the_known_solution() -> None:
    """The residual of the chart is that of the solution, and failures are distinguished from successes."""
    (run,) = cones.study(["p-spg-fb"], [1])
    products, seconds = run.work(1e-4)
    assert 1 < products < 3000
    assert 0 < seconds < 10
    assert run.work(1e-13) == (math.inf, math.inf)  # condition 12000: it stalls
    assert cones.solved([run], 1e-4) == 1
    assert cones.solved([run], 1e-13) == 0
    assert cones.median_work([run], 1e-13) == (math.inf, math.inf)


def test_an_unknown_solver_is_reported_in_one_line(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["chart", "cones", "newtom", "-o", str(tmp_path)])
    assert result.exit_code == 1
    assert result.stderr == "newtom: no such cone solver; did you mean newton?\n"
