# SPDX-License-Identifier: BSD-3-Clause
"""Views whose pages compute."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.scene import Scene, by_parameter, known_parameters
from gelenk.simulation.recording import record
from gelenk.viewer.computing import computing, core_file
from gelenk.viewer.data import page_data
from gelenk.viewer.pages import View

OPTIONS = ("stop", "step", "inputs", "parameters", "outputs", "progress")


def has_constant_inputs(inputs: object) -> bool:
    """Whether inputs, as of `gelenk.simulate`, are none or constants, for which a page has sliders."""
    return inputs is None or (
        isinstance(inputs, Mapping) and all(isinstance(value, int | float) for value in inputs.values())
    )


def computing_view(scene: Scene, **run: Any) -> View:
    """Return a page that simulates a scene.

    Args:
        scene: the scene.
        run: arguments of `gelenk.simulate`, of which only OPTIONS are possible; inputs must be constant.

    Raises:
        UsageError: an argument is not possible, or this installation has no core for pages.
        SceneError, AssemblyError, StepError: see `gelenk.simulate`.
    """
    core_file()
    others = [name for name, value in run.items() if name not in OPTIONS and value]
    if others:
        raise UsageError(f"{', '.join(others)}: not in pages that compute, expected {', '.join(OPTIONS)}")
    inputs = run.get("inputs")
    if not has_constant_inputs(inputs):
        raise UsageError("inputs: found functions of time, expected constants in a page that computes")
    given = by_parameter(scene, run.get("parameters") or {})
    parameters = known_parameters(scene, given)
    constants = {name: value for name, value in given.items() if name not in parameters}
    recording = record(scene, **run)
    data = page_data(recording)
    step = run.get("step")
    text = _core.write_scene_json(scene.with_parameters(parameters)._core)
    settings = {name: float(value) for name, value in {**constants, **(inputs or {})}.items()}
    page = computing(data, recording, text, scene.step if step is None else step, settings)
    return View(page, data)
