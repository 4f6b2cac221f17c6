# SPDX-License-Identifier: BSD-3-Clause
"""From the arguments of a sweep to its plan and the values of all runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.file_reading import read_bytes
from gelenk.model.scene import Scene, load
from gelenk.model.settable import with_listed
from gelenk.model.values import Value, number, unknown
from gelenk.simulation.fmu_file import MAX_SIZE
from gelenk.simulation.inputs import Inputs, functions_and_constants, sampled
from gelenk.simulation.plant import Plant
from gelenk.simulation.run import MAX_NUMBERS, configure, grid, open_plant
from gelenk.simulation.simulation import Simulation
from gelenk.sweeps.design import Design
from gelenk.sweeps.outputs import Outputs, recorded_names, selected
from gelenk.sweeps.plan import Plan
from gelenk.sweeps.store import described, fingerprint
from gelenk.sweeps.workers import Values


def identity(plan: Plan, values: Values, attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what distinguishes this sweep from others, as plain data."""
    parameters, inputs = values
    plant = plan.plant
    content = plant if isinstance(plant, bytes) else _core.write_scene_json(plant._core).encode()
    columns = parameters.tobytes() if parameters.dtype != object else repr(parameters.tolist()).encode()
    tables = [plan.times.tobytes(), plan.sampled.table.tobytes()]
    names = repr((plan.parameters, plan.inputs, plan.sampled.held, plan.sampled.motions, plan.signals))
    return {
        **{k: v for k, v in attributes.items() if k != "title"},
        "runs_sha256": fingerprint(columns, inputs.tobytes(), names.encode()),
        "sampling_sha256": fingerprint(content, repr(sorted(plan.settings.items())).encode(), *tables),
        "variables": described(plan.variables),
    }


@dataclass(frozen=True)
class Request:
    """The arguments of `sweep` that determine its runs."""

    inputs: Inputs | None
    stop: float | None
    step: float | None
    tolerance: float | None
    choices: dict[str, str | None]
    without: tuple[str, ...]
    outputs: Outputs | None
    max_run_time: float

    def planned(
        self, plant: Scene | str | PathLike[str] | Mapping[str, Any], runs: Design
    ) -> tuple[Plan, Values, dict[str, str], dict[str, Any]]:
        """Return the plan, the values of all runs, the units of what varies, and the provenance.

        Args:
            plant: a scene or an FMU.
            runs: the design.

        Raises:
            SceneError, UsageError, OSError: see `gelenk.sweep`.
        """
        is_fmu = isinstance(plant, str | PathLike) and str(plant).lower().endswith(".fmu")
        renamed: dict[str, str] = {}
        outputs, names = self.outputs, recorded_names(self.outputs)
        if not is_fmu:
            scene, renamed = with_listed(load(plant), [*runs.columns, *runs.constants])
            plant = scene
            if names is None and scene.outputs:
                outputs = names = list(scene.outputs)
            if self._acts_beyond(scene, names, [renamed.get(name, name) for name in runs.columns]):
                plant, names = scene.with_outputs(None), None
        opened = open_plant(plant, self.without, names)
        try:
            settings = {renamed.get(name, name): value for name, value in runs.constants.items()}
            known = [*opened.inputs, *opened.idle]
            signals = functions_and_constants(
                self.inputs, settings, known, "twice, as input and as parameter"
            )
            self._configure(opened, settings, [*signals], runs)
            times = self._times(opened)
            signal_names, variables = selected(outputs, opened.outputs, opened.units, has_events=not is_fmu)
            if len(times) * (1 + len(signal_names)) > MAX_NUMBERS:
                raise UsageError(
                    f"{len(times)} times of {len(signal_names)} outputs are too many for one run; "
                    "choose a longer step"
                )
            opened.select(signal_names)
            columns = {renamed.get(name, name): column for name, column in runs.columns.items()}
            parameters, inputs, values, units = _columns(opened, columns, has_table=not is_fmu)
            active = {name: signal for name, signal in signals.items() if name not in opened.idle}
            several = times if len(times) > 1 else np.array([0.0, opened.step])
            plan = Plan(
                read_bytes(str(plant), MAX_SIZE) if is_fmu else _kept(opened, settings),
                settings if is_fmu else {},
                parameters, inputs, times, sampled(active, several, opened.held), tuple(signal_names),
                tuple(variables), self.max_run_time,
            )  # fmt: skip
            listed = {given: units.get(renamed.get(given, given), "") for given in runs.columns}
            others = {n: v for n, v in settings.items() if n not in renamed.values()}
            return plan, values, listed, self._provenance(opened, plan, runs, {**others, **runs.constants})
        finally:
            opened.close()

    def _configure(
        self, opened: Plant, settings: dict[str, Value], signals: Sequence[str], runs: Design
    ) -> None:
        """Set the parameters that all runs have in common."""
        twice = [name for name in runs.columns if name in signals]
        if twice:
            raise UsageError(f"{twice[0]}: given twice, as input and as parameter")
        if self.tolerance is not None:
            if "solver.tolerance" in settings or "solver.tolerance" in runs.columns:
                raise UsageError("solver.tolerance: given twice, as tolerance and as parameter")
            settings["solver.tolerance"] = self.tolerance
        for name in ("integrator", "formulation"):
            if f"solver.{name}" in runs.columns and self.choices[name] is not None:
                raise UsageError(f"solver.{name}: given twice, as {name} and as parameter")
        configure(opened, settings, self.tolerance, self.choices)

    def _times(self, opened: Plant) -> NDArray[np.float64]:
        stop = opened.stop if self.stop is None else self.stop
        return grid(stop, opened.step if self.step is None else self.step)

    def _acts_beyond(self, scene: Scene, names: Sequence[str] | None, varied: Sequence[str]) -> bool:
        """Whether something that varies acts only on parts that no requested output depends on.

        All parts are then computed, so that a wrong value of such a parameter is an error of its run.
        """
        if not names or any(_core.faults_of_outputs(scene._core, list(names))):
            return False
        part = scene.with_outputs(names).pruned()
        known = {*part.parameters, *_core.input_names(part._core)}
        whole = {*scene.parameters, *_core.input_names(scene._core)}
        return any(name in whole and name not in known for name in varied)

    def _provenance(
        self, opened: Plant, plan: Plan, runs: Design, constants: Mapping[str, Value]
    ) -> dict[str, Any]:
        from importlib.metadata import version

        plant = plan.plant
        content = plant if isinstance(plant, bytes) else _core.write_scene_json(plant._core).encode()
        texts = {name: str(x) if isinstance(x, bool) else x for name, x in constants.items()}
        return {
            "title": f"sweep of {opened.name}",
            "gelenk_version": version("gelenk"),
            "plant": opened.name,
            "plant_sha256": fingerprint(content),
            "inputs_sha256": fingerprint(repr(plan.sampled.held).encode(), plan.sampled.table.tobytes()),
            "stop": float(plan.times[-1]),
            "step": opened.step if self.step is None else float(self.step),
            **runs.attributes,
            **{f"constant:{name}": value for name, value in texts.items()},
        }


def _kept(opened: Plant, settings: Mapping[str, Value]) -> Scene:
    scene = opened.scene
    assert scene is not None
    return scene.with_parameters({n: v for n, v in settings.items() if n in scene.parameters})


def _columns(
    opened: Plant, columns: Mapping[str, NDArray[Any]], *, has_table: bool
) -> tuple[tuple[str, ...], tuple[str, ...], Values, dict[str, str]]:
    """Return the names of varied parameters and inputs, their values and units.

    Args:
        opened: the plant.
        columns: values by name.
        has_table: whether the plant is a scene, whose table says which types its parameters have.

    Raises:
        UsageError: a name is unknown, or a value has the wrong type.
    """
    known = [*opened.parameters, *opened.inputs, *opened.idle]
    faults = [unknown(name, "parameter or input", known) for name in columns if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    runs = len(next(iter(columns.values()))) if columns else 1
    parameters = tuple(name for name in columns if name in opened.parameters)
    inputs = tuple(name for name in columns if name in opened.inputs)
    units = dict(opened.units)
    first: NDArray[Any] = np.empty((runs, len(parameters)), np.float64 if has_table else object)
    scene = opened.scene if has_table else None
    if scene is None:
        for i, name in enumerate(parameters):
            first[:, i] = columns[name].tolist()
    else:
        table = {p.name: p for p in _core.list_parameters(scene._core)}
        units |= {name: p.unit for name, p in table.items()}
        units |= {s.name: s.unit for s in Simulation(scene).inputs}
        for i, name in enumerate(parameters):
            first[:, i] = _numbers(name, columns[name], table[name].type, table[name].items)
    second = np.empty((runs, len(inputs)))
    for i, name in enumerate(inputs):
        second[:, i] = _numbers(name, columns[name], "real", ())
    return parameters, inputs, (first, second), units


def _numbers(name: str, column: NDArray[Any], kind: str, items: Sequence[str]) -> NDArray[np.float64]:
    different, places = np.unique(column, return_inverse=True)
    converted = np.array([number(name, value, kind, items) for value in different.tolist()], np.float64)
    return converted[places]
