# SPDX-License-Identifier: BSD-3-Clause
"""Completion of names in the shell: signals and parameters of the scene, FMU or run on the line, choices.

It never fails: a line that is being typed may name no file yet, or a scene that has errors.
"""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import typer

SUBJECTS = ("plant", "scene", "run")  # arguments of commands that name a scene, an FMU or a run
FRICTION = ("present", "locked", "sliding", "off")
SWITCHES = ("true", "false")

type Completer = Callable[[typer.Context, str], list[str]]


def _completer(candidates: Callable[[typer.Context, str], Iterable[str]]) -> Completer:
    """Return a completer of typer: the candidates that begin with what has been typed.

    Args:
        candidates: of the command line and what has been typed of a word; it may raise.
    """

    def complete(ctx: typer.Context, incomplete: str) -> list[str]:
        logging.disable()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                return [name for name in candidates(ctx, incomplete) if name.startswith(incomplete)]
        except Exception:  # the command itself reports what is wrong with a file
            return []
        finally:
            logging.disable(logging.NOTSET)

    return complete


def _subject(ctx: typer.Context) -> Path:
    # Where a line ends with an option that needs a value, the parser leaves the arguments in `args`.
    given = [ctx.params[name] for name in SUBJECTS if ctx.params.get(name)]
    return Path([*given, *ctx.args][0])


def _scene(ctx: typer.Context) -> Any:
    """Return the scene that the line names, or the one in the FMU that it names."""
    import gelenk

    path = _subject(ctx)
    if path.suffix.lower() != ".fmu":
        return gelenk.load(path)
    from gelenk.simulation.fmu_file import SCENE, text_in

    return gelenk.load(json.loads(text_in(path, SCENE)))


def _inputs(ctx: typer.Context) -> list[str]:
    inputs: list[str] = _scene(ctx).inputs_beyond(())
    return inputs


def _signals(ctx: typer.Context) -> list[str]:
    import gelenk
    from gelenk.simulation.csv_file import csv_rows
    from gelenk.simulation.files import ENDINGS

    path = _subject(ctx)
    if path.suffix.lower() == ".csv":  # may be large: the first line is enough
        return next(csv_rows(path))[1][1:]
    if path.suffix.lower() in ENDINGS:
        return list(gelenk.Result.read(path).names)
    return [signal.name for signal in gelenk.Simulation(_scene(ctx)).outputs]


def _settings(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return NAME= of parameters and inputs; once a name is complete, NAME=VALUE of choices and switches."""
    from gelenk import _core

    scene = _scene(ctx)
    name, equals, _ = incomplete.partition("=")
    if not equals:
        return [f"{known}=" for known in (*scene.parameters, *scene.inputs_beyond(()))]
    parameter = next(p for p in _core.list_parameters(scene._core) if p.name == name)
    values = SWITCHES if parameter.type == "boolean" else parameter.items
    return [f"{name}={value}" for value in values]


def _solver_choices(key: str) -> list[str]:
    from gelenk import _core

    solver = json.loads(_core.scene_schema())["properties"]["solver"]
    return list(solver["properties"][key]["enum"])


def _reductions() -> list[str]:
    from gelenk import _core

    return [*_core.reduction_names(), "all"]


def _platforms(incomplete: str) -> list[str]:
    """Return lists of platforms, separated by commas, with one more than have been typed."""
    from gelenk.io.export import ALL, LIBRARIES

    *before, _ = incomplete.split(",")
    return [",".join([*before, name]) for name in (*LIBRARIES, ALL) if name not in before]


def _fmi_versions() -> list[str]:
    from gelenk.io.export import FMI_VERSIONS

    return [str(version) for version in FMI_VERSIONS]


def _methods() -> list[str]:
    from gelenk.chart.methods import all_methods

    return [method.name for method in all_methods()]


settings = _completer(_settings)
inputs = _completer(lambda ctx, _: _inputs(ctx))
input_values = _completer(lambda ctx, _: [f"{name}=" for name in _inputs(ctx)])
signals = _completer(lambda ctx, _: _signals(ctx))
signal_values = _completer(lambda ctx, _: [f"{name}=" for name in _signals(ctx)])
bodies = _completer(lambda ctx, _: _scene(ctx).to_dict()["bodies"])
integrators = _completer(lambda *_: _solver_choices("integrator"))
formulations = _completer(lambda *_: _solver_choices("formulation"))
reductions = _completer(lambda *_: _reductions())
platforms = _completer(lambda _, incomplete: _platforms(incomplete))
fmi_versions = _completer(lambda *_: _fmi_versions())
frictions = _completer(lambda *_: FRICTION)
methods = _completer(lambda *_: _methods())
