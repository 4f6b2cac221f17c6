# SPDX-License-Identifier: BSD-3-Clause
"""Views of mechanisms in motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from gelenk.errors import UsageError
from gelenk.model.scene import Scene, Source
from gelenk.simulation.computing import computing_view
from gelenk.simulation.recording import record, scene_of
from gelenk.simulation.replay import replayed
from gelenk.simulation.result import Result
from gelenk.viewer.pages import View, view_of

type Viewed = Scene | str | PathLike[str] | Mapping[str, Any] | Result


def view(
    plant: Viewed | Sequence[Viewed],
    *,
    reactions: bool = False,
    degrees: bool = False,
    computes: bool = False,
    **run: Any,
) -> View:
    """Simulate a scene, or the scene of an FMU, and return a page on which it moves.

    The page is one HTML file that needs no network: a 3-D view with time slider, plots of the outputs, and
    the events of the run. Bodies are drawn as links between their joints.

    Args:
        plant: a .fmu file, anything `gelenk.load` accepts, or a result of `gelenk.simulate`. Two of them are
            laid over each other: see `View.overlay`.
        reactions: whether forces and torques of all joints are shown as arrows; those of forces, motors,
            contacts and what acts along joints, and of joints with a sensor of them, always are.
        degrees: whether angles and their derivatives are in degrees in the plots of the page.
        computes: whether the page simulates the scene itself, with sliders for inputs and parameters, and a
            pointer that pulls bodies, instead of showing a run. It then contains the core as WebAssembly,
            which `make page-core` builds.
        run: arguments of `gelenk.simulate`: stop, step, inputs, parameters, ...; stop=0 shows the start.

    Returns:
        View: a page; `save` writes it, `show` opens it in the browser.

    Raises:
        SceneError, AssemblyError, UsageError, OSError: see `gelenk.simulate`.
        StepError: a step failed; its `view` shows the motion up to this step.

    >>> page = gelenk.view(four_bar, stop=0.5)
    >>> page.html[:15]
    '<!DOCTYPE html>'
    """
    if degrees:
        return view(plant, reactions=reactions, computes=computes, **run).in_degrees()
    if computes:
        if isinstance(plant, Result) or (isinstance(plant, Sequence) and not isinstance(plant, str)):
            raise UsageError("computes: found a result or several runs, expected a scene or an FMU")
        return computing_view(scene_of(plant), reactions=reactions, **run)
    if isinstance(plant, Sequence) and not isinstance(plant, str):
        if len(plant) != 2:
            raise UsageError(f"view: found {len(plant)} runs, expected one or two")
        first, second = (view(one, reactions=reactions, **run) for one in plant)
        return first.overlay(second)
    if isinstance(plant, Result):
        return plant.view(reactions=reactions)
    return view_of(record(scene_of(plant), reactions=reactions, **run))


def view_of_result(result: Result, scene: Source) -> View:
    """Return the page of a result by its joint coordinates: see `Result.view`."""
    return view_of(replayed(scene_of(scene), result))
