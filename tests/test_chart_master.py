# SPDX-License-Identifier: BSD-3-Clause
"""Costs per communication step, as a master sees them."""

from __future__ import annotations

from dataclasses import replace

import pytest

import gelenk
from gelenk.chart import master
from gelenk.chart.methods import chosen
from gelenk.chart.workers import Failure


def test_costs_are_reported_per_communication_step() -> None:
    case = replace(master.master_case(), stop=0.05)
    runs, found = master.master_runs(chosen(["auto", "rk4"]), (1e-6,), rounds=1, case=case)
    assert [r.method for r in runs] == ["auto", "projection+rk4"]
    assert runs[1].evaluations == 4 * 50
    assert found.digits < 1e-8
    table = master.master_table(runs, 50, (1e-6,))
    assert "| projection+rk4 | " in table
    assert "| 4.0 |" in table


def test_costs_without_a_reference_solution_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    case = master.master_case()
    failed = {case.name: Failure("no two methods agree")}
    monkeypatch.setattr(master, "references", lambda *_: failed)
    with pytest.raises(gelenk.UsageError, match=r"^no two methods agree$"):
        master.master_runs(chosen(["rk4"]), (1e-6,), rounds=1, case=case)
