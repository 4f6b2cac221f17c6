# SPDX-License-Identifier: BSD-3-Clause
"""Simulation of a scene or an FMU over a time span."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import StartWarning, StepError, UsageError
from gelenk.model.scene import Scene, load
from gelenk.model.values import Value, check_names, is_number, unknown
from gelenk.simulation.inputs import Inputs, functions_and_constants, is_motion, polynomial, sampled
from gelenk.simulation.oddities import doubts_of_tables, nothing_moves
from gelenk.simulation.plant import Plant
from gelenk.simulation.progress import progress_bar
from gelenk.simulation.result import Result
from gelenk.simulation.scene_plant import ScenePlant

log = logging.getLogger(__name__)

SINGULAR_CROSSINGS = "solver.singular_positions"  # diagnostic: number of singular configurations crossed
BLOCK = 256  # steps between looks at what the user wants
MAX_NUMBERS = 500_000_000  # in a result, 4 GB
_DIAGNOSTICS = frozenset(_core.diagnostic_names())


def simulate(
    plant: Scene | str | PathLike[str] | Mapping[str, Any],
    *,
    stop: float | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    integrator: str | None = None,
    formulation: str | None = None,
    inputs: Inputs | None = None,
    parameters: Mapping[str, Value] | None = None,
    outputs: Sequence[str] | None = None,
    without: Sequence[str] = (),
    assembly_tolerance: float | None = None,
    hold: Sequence[str] | bool = False,
    progress: Callable[[float, float], None] | bool | None = None,
    kind: str = "cs",
) -> Result:
    """Simulate a scene or an FMU from t = 0.

    In every communication step an input that is a function of time follows the polynomial through five of
    its values. If the function deviates from it, because it jumps in the step, the input is held at its value
    at the start of the step, as are the inputs in `hold`. Functions are called nine times in each step. A row
    of the result contains the outputs at the end of a step, before the next input is set.

    Args:
        plant: a .fmu file, or anything `gelenk.load` accepts.
        stop: end of the simulation [s]; by default that of the scene or FMU.
        step: communication step [s]; the last one is shortened to end at `stop`.
        tolerance: relative tolerance of the integrator.
        integrator: "auto", "ida", "cvode", "cvode-adams", "dirk", "erk", "rk4", "euler",
            "generalized-alpha", "hht" or "newmark".
        formulation: "projection", or an alternative formulation of the constraints (docs/scene-format.md).
        inputs: see `gelenk.simulation.inputs.functions`; inputs that are not named are 0.
        parameters: values by parameter name, such as "A.phi_start", or by the path of what the scene lists
            under `parameters`, such as "crank.mass"; also constant inputs.
        outputs: names and patterns ("crank.*") of the outputs to record; by default those of the scene or
            FMU. Parts of a scene on which none of them depends are not computed.
        without: reductions to switch off, see `gelenk.inspect`; scenes only.
        assembly_tolerance: the parameter `assembly.tolerance`: the largest correction of joint frames (rad,
            and lengths of about the mechanism's size) that closes loops with rounded dimensions.
        hold: names of the inputs that are held over each step, as in a co-simulation without derivatives of
            inputs; True: all but motion inputs (`NAME.phi_ref`), which cannot be held.
        progress: called after every step with the time reached and `stop` [s]. True: a progress bar, in
            notebooks a widget, which requires tqdm.
        kind: "cs", or "me" for model exchange, of an FMU: CVODE outside the FMU advances its states, with
            `tolerance`; `integrator` and `formulation` then have no effect.

    Returns:
        Result: `time` and the outputs.

    Raises:
        SceneError, UsageError: the scene, a name or a value is invalid.
        AssemblyError: the loops cannot be closed with the start values.
        StepError: a step failed; its `result` contains the rows up to this step.
        OSError: a file cannot be read.

    Warns:
        StartWarning: the start is doubtful, a table of inputs ends before the run or repeats times, or
            nothing has moved, although no friction and no limit holds anything.

    >>> import math
    >>> result = gelenk.simulate(four_bar, stop=0.5, inputs={"drive.tau": lambda t: 3 + math.sin(10 * t)})
    >>> bool(result["A.phi"][-1] > result["A.phi"][0])
    True
    """
    opened = open_plant(plant, without, outputs, kind=kind)
    try:
        settings = opened.by_parameter(parameters or {})
        if assembly_tolerance is not None:
            settings["assembly.tolerance"] = assembly_tolerance
        known = [*opened.inputs, *opened.idle]
        signals = functions_and_constants(inputs, settings, known, "twice, as input and as parameter")
        held = opened.held | _held(hold, known)
        configure(opened, settings, tolerance, {"integrator": integrator, "formulation": formulation})
        times = grid(opened.stop if stop is None else stop, opened.step if step is None else step)
        names = _selected(opened, outputs)
        if len(times) * (1 + len(names)) > MAX_NUMBERS:
            raise UsageError(
                f"{len(times)} rows of {1 + len(names)} columns are too many; choose a longer step"
            )
        monitored = (
            [SINGULAR_CROSSINGS]
            if SINGULAR_CROSSINGS in opened.units and SINGULAR_CROSSINGS not in names
            else []
        )
        opened.select([*names, *monitored])
        tolerance = None if "solver.tolerance" in settings else tolerance
        first = float(times[1]) if len(times) > 1 else opened.step
        motions = {
            name: polynomial(signal, 0.0, first)[1] for name, signal in signals.items() if is_motion(name)
        }
        opened.start(tolerance, {name: signal(0.0) for name, signal in signals.items()}, motions)
        for sentence in doubts_of_tables(signals, float(times[-1])):
            warnings.warn(sentence, StartWarning, stacklevel=2)
        log.info("%s: 0 to %g s in %d steps, %d outputs", opened.name, times[-1], len(times) - 1, len(names))
        with progress_bar(progress) as reached:
            result = _run(opened, times, names, signals, held, reached)
        if outputs is None and (sentence := nothing_moves(opened, result, signals)):
            warnings.warn(sentence, StartWarning, stacklevel=2)
        if log.isEnabledFor(logging.DEBUG):
            _log_diagnostics(opened)
        result.run = (plant, {
            "stop": stop, "step": step, "tolerance": tolerance, "integrator": integrator,
            "formulation": formulation, "inputs": inputs, "parameters": parameters, "outputs": outputs,
            "without": without, "assembly_tolerance": assembly_tolerance, "hold": hold, "kind": kind,
        })  # fmt: skip
        return result
    finally:
        opened.close()


def grid(stop: float, step: float) -> NDArray[np.float64]:
    """Return the communication times k * step [s] from 0; the last one is `stop`.

    Times are multiples, not sums, so that rounding errors do not accumulate.

    Args:
        stop: end of the simulation [s].
        step: communication step [s].

    Returns:
        NDArray: shape (steps + 1,).

    Raises:
        UsageError: stop or step is out of range, or no number.
    """
    for name, value in (("stop", stop), ("step", step)):
        check_number(name, value, "s")
    if not (math.isfinite(stop) and stop >= 0):
        raise UsageError(f"stop: found {stop} s, expected 0 or more")
    if not (math.isfinite(step) and step > 0):
        raise UsageError(f"step: found {step} s, expected more than 0")
    ratio = stop / step
    if ratio > MAX_NUMBERS:
        raise UsageError(
            f"step: {stop:g} s in steps of {step:g} s are {ratio:.3g} steps; choose a longer step"
        )
    # 0.3 / 0.1 and 1.1 / 0.1 differ from integers by rounding, which must not cause a last step of 1e-16 s.
    whole = round(ratio)
    count = whole if abs(ratio - whole) <= 1e-12 * max(1.0, ratio) else math.ceil(ratio)
    times: NDArray[np.float64] = np.arange(count + 1, dtype=np.float64) * step
    times[-1] = stop
    return times


def check_number(name: str, value: object, unit: str = "") -> None:
    """Raise UsageError if a value is no number.

    Args:
        name: name of the value in the message.
        value: what was given.
        unit: unit of the number; empty if it has none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        expected = f"a number of {unit}" if unit else "a number"
        hint = "; leave out the quotes" if isinstance(value, str) and is_number(value) else ""
        raise UsageError(f"{name}: found {value!r}, expected {expected}{hint}")


def open_plant(
    plant: ScenePlant | Scene | str | PathLike[str] | Mapping[str, Any],
    without: Sequence[str],
    outputs: Sequence[str] | None = None,
    *,
    whole: bool = False,
    kind: str = "cs",
) -> Plant:
    """Open a scene or an FMU as a plant.

    Args:
        plant: as for `simulate`; one that is open already is returned as it is.
        without: reductions to switch off.
        outputs: names and patterns of the outputs; parts of a scene on which none of them depends are
            omitted. None: those that the scene lists.
        whole: whether to omit nothing.
        kind: "cs" or "me", as for `simulate`.

    Raises:
        SceneError, UsageError: the scene or FMU, or a name, is invalid.
        OSError: a file cannot be read.
    """
    if kind not in ("cs", "me"):
        raise UsageError(f"kind: found {kind!r}, expected 'cs' (co-simulation) or 'me' (model exchange)")
    if isinstance(plant, ScenePlant):
        return plant
    if isinstance(plant, str | PathLike) and str(plant).lower().endswith(".fmu"):
        if without:
            raise UsageError("without: reductions of an FMU cannot be changed after its export")
        if kind == "me":
            from gelenk.simulation.exchange_plant import ExchangedFmuPlant

            return ExchangedFmuPlant(Path(plant))
        from gelenk.simulation.fmu_plant import FmuPlant

        return FmuPlant(Path(plant))
    if kind == "me":
        raise UsageError("kind: found 'me' with a scene, expected a .fmu file; export the scene first")
    scene = load(plant).without(without)
    return ScenePlant(scene.with_outputs(None) if whole else _narrowed(scene, outputs))


def _narrowed(scene: Scene, outputs: Sequence[str] | None) -> Scene:
    if not outputs:
        return scene
    names = list(dict.fromkeys([outputs] if isinstance(outputs, str) else outputs))
    faults = _core.faults_of_outputs(scene._core, names)
    unknown_names = any(
        fault and not set("*?[") & set(name) for name, fault in zip(names, faults, strict=True)
    )
    if unknown_names or any(name in _DIAGNOSTICS for name in names):
        return scene.with_outputs(None)  # unknown names are reported later; diagnostics cover all parts
    return scene.with_outputs(names)


def configure(
    plant: Plant, settings: dict[str, Value], tolerance: float | None, choices: dict[str, str | None]
) -> None:
    """Set the parameters of a plant.

    Args:
        plant: the plant, not yet started.
        settings: values by parameter name; `choices` are added to it.
        tolerance: relative tolerance, which is only checked.
        choices: values of parameters `solver.NAME`; None: not given.

    Raises:
        UsageError: a name or value is invalid, or a parameter is given twice.
    """
    if tolerance is not None:
        check_number("tolerance", tolerance)
    if tolerance is not None and not 0 < tolerance < 1:
        raise UsageError(f"tolerance: found {tolerance}, expected a number between 0 and 1")
    for name, choice in choices.items():
        if choice is None:
            continue
        if f"solver.{name}" in settings:
            raise UsageError(f"solver.{name}: given twice, as {name} and as parameter")
        settings[f"solver.{name}"] = choice
    known = [*plant.parameters, *plant.inputs, *plant.idle]
    faults = [unknown(name, "parameter or input", known) for name in settings if name not in plant.parameters]
    if faults:
        raise UsageError("\n".join(faults))
    if settings:
        plant.set_parameters(settings)


def expanded(outputs: Sequence[str], known: Sequence[str]) -> list[str]:
    """Replace patterns by the names that match them, without those that other entries name.

    Args:
        outputs: names and patterns.
        known: names of all outputs.

    Returns:
        list[str]: names in the order of `outputs`; patterns without a match are kept.
    """
    entries = [outputs] if isinstance(outputs, str) else list(outputs)
    exact = set(known)
    taken = set(entries)
    names: list[str] = []
    for entry in entries:
        met = [] if entry in exact else [name for name in known if _core.meets(entry, name)]
        names += [name for name in met if name not in taken] if met else [entry]
        taken.update(met)
    return names


def _selected(plant: Plant, outputs: Sequence[str] | None) -> list[str]:
    names = list(plant.outputs) if outputs is None else expanded(outputs, [*plant.outputs])
    check_names(names, plant.units, "output")
    return names


def _held(hold: Sequence[str] | bool, known: Sequence[str]) -> frozenset[str]:
    """Return the names of the inputs to be held. Raises UsageError for an unknown name or a motion."""
    if isinstance(hold, bool):
        return frozenset(name for name in known if hold and not is_motion(name))
    names = [hold] if isinstance(hold, str) else list(hold)
    check_names(names, known, "input")
    motions = [name for name in names if is_motion(name)]
    if motions:
        raise UsageError(f"hold: found {motions[0]}, a prescribed motion, which cannot be held over a step")
    return frozenset(names)


def _run(
    plant: Plant,
    times: NDArray[np.float64],
    names: list[str],
    signals: dict[str, Callable[[float], float]],
    held: frozenset[str],
    progress: Callable[[float, float], None] | None,
) -> Result:
    monitored = [] if SINGULAR_CROSSINGS in names or SINGULAR_CROSSINGS not in plant.units else [1]
    rows = np.empty((len(times), 1 + len(names) + len(monitored)))
    rows[:, 0] = times
    rows[0, 1:] = plant.read()
    stop = float(times[-1])
    events: list[tuple[float, str]] = []
    k = 0
    while k + 1 < len(times):
        part = times[k : k + 1 + (BLOCK if progress is None else 1)]
        inputs = sampled(signals, part, held)
        steps, found, error = plant.record(part, inputs, rows[k + 1 : k + len(part), 1:])
        k += steps
        events += found
        for time, text in found:
            log.info("t = %.9g s: %s", time, text)
        if error is not None:
            if isinstance(error, StepError):
                error.result = _result(plant, names, rows[: k + 1], events)
            raise error
        if progress is not None:
            progress(float(times[k]), stop)
    return _result(plant, names, rows, events)


def _result(
    plant: Plant, names: list[str], rows: NDArray[np.float64], events: list[tuple[float, str]]
) -> Result:
    """Return the rows of a run as its result; a column after those of the names counts singular positions."""
    found = Result(names, rows[:, : 1 + len(names)], {name: plant.units[name] for name in names})
    found.assembly_report = plant.assembly_report
    found.events = tuple(events)
    found.warnings = tuple(plant.run_warnings)
    column = 1 + names.index(SINGULAR_CROSSINGS) if SINGULAR_CROSSINGS in names else 1 + len(names)
    if column < rows.shape[1]:
        counts = np.maximum.accumulate(np.maximum(rows[:, column], 0.0))
        found.singular_positions = tuple(rows[1:, 0][np.diff(counts) > 0].tolist())
    return found


def _log_diagnostics(plant: Plant) -> None:
    """Log the diagnostics after a run: counts of steps and evaluations, constraint errors, energies."""
    names = [name for name in plant.units if name in _DIAGNOSTICS]
    plant.select(names)
    for name, value in zip(names, plant.read().tolist(), strict=True):
        log.debug("%s = %.9g%s", name, value, "" if plant.units[name] == "1" else f" {plant.units[name]}")
