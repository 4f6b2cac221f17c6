# SPDX-License-Identifier: BSD-3-Clause
"""The work-precision diagram of a study: CPU time and evaluations against error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gelenk.chart.measure import Run
from gelenk.chart.methods import AUTO, Method
from gelenk.chart.outcome import Outcome
from gelenk.chart.style import look, save
from gelenk.chart.work_precision import Study
from gelenk.extras import pyplot

LIMIT = 3.0  # the gray area ends at this multiple of the reference's error
LOST = 10.0  # larger errors are drawn at this value: no correct digit
WRONG = "wrong:\nerror > 100 × tolerance,\nor > 0.01 with fixed steps"
ROW = 0.16  # inches, height of a method in the band of runs that did not finish


def draw(study: Study, path: Path) -> None:
    """Write the diagram as PNG.

    Raises:
        UsageError: matplotlib is not installed.
        OSError: the file cannot be written.
    """
    plt = pyplot()
    methods = list(dict.fromkeys(Method(run.formulation, run.integrator) for run in study.runs))
    unfinished = [m for m in methods if any(not run.finished for run in _of(study.runs, m))]
    band = ROW * max(1, len(unfinished)) + 0.1
    height = 5.6 + band
    figure, axes = plt.subplots(
        2, 2, figsize=(12.5, height), sharex=True, layout="constrained",
        gridspec_kw={"height_ratios": [band, height - band]},
    )  # fmt: skip
    for column, (field, label) in enumerate((("cpu", "CPU time [ms]"), ("evaluations", "evaluations"))):
        _lines(axes[1][column], study, methods, field, label)
        _band(axes[0][column], study.runs, unfinished, named=column == 0)
    axes[0][0].set_title(
        "not finished: refused ×, failed ▲ (at the requested tolerance)", fontsize=8, loc="left"
    )
    _legend(figure, axes[1][0], methods)
    figure.suptitle(
        f"{study.case.name}: work–precision diagram, {study.case.stop:g} s\n\n",
        fontsize=13,
        fontweight="bold",
    )
    figure.text(0.01, 0.955, _subtitle(study), fontsize=8, color="#444444", va="top")
    save(figure, path, 85)
    plt.close(figure)


def _of(runs: Sequence[Run], method: Method) -> list[Run]:
    return [
        run for run in runs if (run.formulation, run.integrator) == (method.formulation, method.integrator)
    ]


def _subtitle(study: Study) -> str:
    about = f"{study.case.about}\n" if study.case.about else ""
    return f"{about}Reference: {study.reference.words}."


def _place(error: float, digits: float) -> float:
    return min(LOST, max(error, digits))


def _lines(axis: Any, study: Study, methods: Sequence[Method], field: str, label: str) -> None:
    digits = study.reference.digits
    factor = 1e3 if field == "cpu" else 1.0
    for method in methods:
        runs = [run for run in _of(study.runs, method) if run.finished]
        x = [_place(run.error, digits) for run in runs]
        y = [factor * getattr(run, field) for run in runs]
        style = look(method)
        axis.plot(x, y, **{**style, "marker": ""})
        for outcome, face in ((Outcome.GOOD, style["color"]), (Outcome.WRONG, "white")):
            chosen = [k for k, run in enumerate(runs) if run.outcome == outcome]
            axis.plot(
                [x[k] for k in chosen], [y[k] for k in chosen],
                **{**style, "linestyle": "", "markerfacecolor": face},
            )  # fmt: skip
    axis.set_xscale("log")
    axis.set_yscale("log")
    low = min(0.5 * digits, 5e-13)
    axis.set_xlim(20.0, low)  # accuracy increases to the right
    axis.axvspan(low, LIMIT * digits, color="#dddddd", zorder=0)
    axis.text(LIMIT * digits, 0.99, " accuracy limit of the reference", rotation=90, fontsize=7,
              va="top", ha="left", color="#666666", transform=axis.get_xaxis_transform())  # fmt: skip
    own = " and states of elements" if study.case.scene.get("states") else ""
    axis.set_xlabel(f"largest error of joint positions{',' if own else ' and'} speeds{own}")
    axis.set_ylabel(label)
    axis.grid(which="major", alpha=0.35)


def _band(axis: Any, runs: Sequence[Run], methods: Sequence[Method], named: bool) -> None:
    axis.set_facecolor("#f6f1ea")
    axis.set_ylim(-0.7, max(1, len(methods)) - 0.3)
    axis.invert_yaxis()
    axis.set_yticks(range(len(methods)), [m.name for m in methods] if named else [""] * len(methods))
    axis.tick_params(axis="y", labelsize=7, length=0)
    axis.tick_params(axis="x", which="both", length=0)
    for row, method in enumerate(methods):
        for run in _of(runs, method):
            if run.finished:
                continue
            marker = "x" if run.outcome == Outcome.REFUSED else "^"
            place = LOST if math.isnan(run.tolerance) else run.tolerance
            axis.plot([place], [row], marker=marker, color=look(method)["color"], markersize=5)
    if not methods:
        axis.text(0.5, 0.5, "all runs finished", transform=axis.transAxes, ha="center",
                  va="center", fontsize=8, color="#666666")  # fmt: skip


def _legend(figure: Any, axis: Any, methods: Sequence[Method]) -> None:
    handles = [axis.plot([], [], label=m.name, **look(m))[0] for m in [AUTO, *methods] if m in methods]
    handles = list({handle.get_label(): handle for handle in handles}.values())
    gray = {"color": "#444444", "linestyle": "", "marker": "o", "markersize": 5}
    handles.append(axis.plot([], [], label="good", **gray)[0])
    handles.append(axis.plot([], [], label=WRONG, markerfacecolor="white", **gray)[0])
    figure.legend(handles=handles, loc="outside right center", fontsize=8, handlelength=3.2)
