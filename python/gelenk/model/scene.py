# SPDX-License-Identifier: BSD-3-Clause
"""Scenes: loading, changing and saving."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from gelenk import _core, _html
from gelenk.errors import AssemblyError, SceneError, SceneWarning, UsageError
from gelenk.file_reading import existing, read_start
from gelenk.file_writing import write_text
from gelenk.model import other_formats, yaml12
from gelenk.model.line_numbers import Places
from gelenk.model.named_files import NamedFiles
from gelenk.model.source_text import Given
from gelenk.model.values import Value, number, unknown
from gelenk.model.yaml_faults import without_quotes

LANGUAGES = {".yaml": "yaml", ".yml": "yaml", ".json": "json"}  # language of scene files by ending
MAX_BYTES = 50_000_000  # that are read; scenes may be smaller only
type Source = Scene | str | PathLike[str] | Mapping[str, Any]


class Scene:
    """A valid, immutable description of a mechanism, created by `gelenk.load`."""

    def __init__(
        self,
        core: _core.Scene,
        given: Given,
        report: Iterable[str] = (),
        places: Places | None = None,
    ) -> None:
        self._core = core
        self._given = given
        self._places = places
        self._pruned: Scene | None = None
        #: What an import did not convert, line by line; empty for scenes that were not imported.
        self.report = tuple(report)

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self._core.name

    @property
    def file(self) -> str:
        """File from which the scene was read; empty if there is none."""
        return self._core.file

    @property
    def stop(self) -> float:
        """Default end of a simulation [s]."""
        return self._core.stop

    @property
    def step(self) -> float:
        """Default communication step [s]."""
        return self._core.step

    @property
    def tolerance(self) -> float:
        """Default relative tolerance of the integrator."""
        return self._core.tolerance

    @property
    def parameters(self) -> dict[str, Value]:
        """Parameters that can be set before a simulation: names as in the FMU, with present values."""
        return {p.name: _shown(p, p.value(self._core)) for p in _core.list_parameters(self._core)}

    def with_parameters(self, settings: Mapping[str, Value]) -> Scene:
        """Return a copy with other parameter values.

        Args:
            settings: values by parameter name, or by the path in the file of what the scene lists under
                `parameters` ("crank.m" or "crank.mass"): numbers (SI units), booleans, or names of
                enumeration items.

        Raises:
            UsageError: a name is unknown or no parameter, or a value is not allowed.
            SceneError: the values contradict each other.

        Warns:
            SceneWarning: a value is suspicious.
        """
        table = {p.name: p for p in _core.list_parameters(self._core)}
        values = []
        for name, value in by_parameter(self, settings).items():
            if name not in table:
                raise UsageError(unknown(name, "parameter", table))
            values.append((name, number(name, value, table[name].type, table[name].items)))
        with self.located():
            changed = self._with_core(_core.with_parameters(self._core, values))
        before = _core.find_doubts(self._core)
        _warn([doubt for doubt in _core.find_doubts(changed._core) if doubt not in before])
        return changed

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names and patterns of the requested outputs; empty: all."""
        return tuple(self._core.outputs)

    def with_outputs(self, outputs: Iterable[str] | None) -> Scene:
        """Return a copy with other requested outputs.

        Parts on which none of them depends are omitted when the scene is simulated, linearized or exported.

        Args:
            outputs: names ("A.phi"), or patterns as in shells ("crank.*", "*.w", "tip.r[1-2]"); None: all.

        Raises:
            UsageError: the list is empty, or an entry matches no output.
        """
        names = [outputs] if isinstance(outputs, str) else list(outputs or [])
        if outputs is not None and not names:
            raise UsageError("outputs: found none, expected at least one name or pattern")
        faults = [f"outputs: {fault}" for fault in _core.faults_of_outputs(self._core, names) if fault]
        if faults:
            raise UsageError("\n".join(faults))
        return self._with_core(_core.with_outputs(self._core, names))

    def pruned(self) -> Scene:
        """Return the scene without the parts on which no requested output depends."""
        if not self.outputs or self._core.is_wanted_part:
            return self
        if self._pruned is None:
            self._pruned = self._with_core(_core.wanted_part(self._core))
        return self._pruned

    def inputs_beyond(self, known: Iterable[str]) -> list[str]:
        """Return the names of the scene's inputs that are not in a list.

        Args:
            known: the list.
        """
        names = set(known)
        return [name for name in _core.input_names(self._core) if name not in names]

    def wanted_part(self) -> Scene:
        """Return the parts on which the requested outputs depend, as a scene with all of their outputs."""
        if not self.outputs:
            return self
        return self._with_core(_core.with_outputs(_core.wanted_part(self._core), []))

    @property
    def has_friction_or_limits(self) -> bool:
        """Whether any joint has dry friction or a hard limit."""
        return _core.has_friction_or_limits(self._core)

    def without_friction(self) -> Scene:
        """Return a copy without dry friction."""
        return self._with_core(_core.without_friction(self._core))

    def without(self, reductions: Iterable[str]) -> Scene:
        """Return a copy in which reductions are switched off.

        Args:
            reductions: names of reductions, or "all".

        Raises:
            UsageError: a reduction is unknown.
        """
        names = [name.replace("-", "_") for name in reductions]
        known = [*_core.reduction_names(), "all"]
        faults = [unknown(name, "reduction", known) for name in names if name not in known]
        if faults:
            raise UsageError("\n".join(faults))
        if not names:
            return self
        if "all" in names:
            names = _core.reduction_names()
        data = self.to_dict()
        solver = data.setdefault("solver", {})
        solver["reductions"] = {**solver.get("reductions", {}), **dict.fromkeys(names, False)}
        return self._with_core(_read_plain(data, self.file)[0])

    def _with_core(self, core: _core.Scene) -> Scene:
        """Return a changed version of this scene that remembers its source."""
        return Scene(core, self._given, self.report, self._places)

    @contextmanager
    def located(self) -> Iterator[None]:
        """Add line numbers to errors about this scene."""
        try:
            yield
        except (SceneError, AssemblyError) as e:
            if self._places is None:
                raise
            lines = self._places.located(e.lines, whole=False)
            raise (
                SceneError(lines) if isinstance(e, SceneError) else AssemblyError("\n".join(lines))
            ) from None

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as plain data, with all defaults, and all frames relative to their bodies."""
        data = json.loads(_core.write_scene_json(self._core))
        assert isinstance(data, dict)
        return data

    def save(self, path: str | PathLike[str]) -> None:
        """Write the scene to a .yaml, .yml or .json file.

        Everything that has not been changed is written as it was given. Scenes that were read from YAML keep
        their comments and layout in YAML. Names of mesh files are kept in the folder of the scene; to other
        folders, their points and triangles are written.

        Raises:
            SceneError: the file name has another ending.
            OSError: the file cannot be written; it is as it was before.
        """
        target = Path(path)
        language = LANGUAGES.get(target.suffix.lower())
        if language is None:
            found = target.suffix or "none"
            raise SceneError(f"{target}: found the ending {found}, expected .yaml, .yml or .json")
        write_text(target, self._given.written(self._core, language, target.parent))

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self._counts()}>"

    def _counts(self) -> str:
        data = self.to_dict()
        return ", ".join(
            f"{len(data[key])} {key if len(data[key]) != 1 else key[:-1].replace('bodie', 'body')}"
            for key in ("bodies", "joints", "motors", "forces", "constraints", "sensors")
            if data.get(key)
        )

    def _repr_html_(self) -> str:
        try:
            drawing = _core.draw_svg(self._core)
        except (SceneError, AssemblyError) as e:  # for example, loops that cannot be closed
            picture = _html.joined(_html.paragraph(line) for line in e.lines)
        else:
            # Lines and letters are dark, and a notebook may be, too.
            picture = _html.Fragment(
                f'<div style="background:#fff;color:#000;display:inline-block">{drawing}</div>'
            )
        return _html.joined([_html.heading(self.name, self._counts()), picture])


def known_parameters(scene: Scene, settings: Mapping[str, Value]) -> dict[str, Value]:
    """Return the settings that are parameters of a scene, without inputs and others."""
    known = scene.parameters
    return {name: value for name, value in by_parameter(scene, settings).items() if name in known}


def by_parameter(scene: Scene, settings: Mapping[str, Value]) -> dict[str, Value]:
    """Return settings by the names of parameters, see `gelenk.model.settable.by_parameter`."""
    from gelenk.model import settable  # which needs this module

    return settable.by_parameter(scene, settings)


def load(source: Source) -> Scene:
    """Read and check a scene.

    Args:
        source: a .yaml, .yml or .json file; a mapping with the same keys; or the text of a scene (recognized
            by its line breaks or its opening brace).

    Returns:
        Scene: the scene; a scene is returned unchanged.

    Raises:
        SceneError: the scene is invalid; the message lists all faults, one per line.
        UsageError: the source is neither a scene nor the name of a file.
        OSError: the file cannot be read; MissingFileError: it does not exist.

    Warns:
        SceneWarning: a value is valid but suspicious, such as an angle in degrees.

    >>> pendulum = gelenk.load('''
    ... gelenk: 1
    ... name: Pendulum
    ... gravity: [0, 0, -9.81]
    ... bodies:
    ...   bob: {mass: 0.5, com: [0, 0, -0.8]}
    ... joints:
    ...   A: {type: revolute, axis: [0, 1, 0], parent: {body: ground}, child: {body: bob}}
    ... ''')
    >>> pendulum
    <Scene Pendulum: 1 body, 1 joint>
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, Mapping):
        return from_dict(source)
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith(("{", "<"))):
        other_formats.refuse_content(source.encode("utf-8", "replace"), "scene")
        return _read(source, "yaml", "")
    path = existing(source)
    _core.check_size(path.stat().st_size, str(path))
    language = LANGUAGES.get(path.suffix.lower())
    if language is None:
        other_formats.refuse_ending(path)
    content = read_start(path, MAX_BYTES, pipes=True)
    _core.check_size(len(content), str(path))
    other_formats.refuse_content(content, str(path))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        line = content.count(b"\n", 0, e.start) + 1
        raise SceneError(f"{path}:{line}: byte {e.start + 1} is not UTF-8 text") from None
    return _read(text, language, str(path))


def from_dict(data: Mapping[str, Any], file: str = "", report: Iterable[str] = ()) -> Scene:
    """Create a scene from plain data.

    Args:
        data: the scene; numpy numbers and arrays are accepted.
        file: file name for messages.
        report: what an import did not convert.

    Raises:
        SceneError: the scene is invalid.
    """
    files = NamedFiles(file)
    try:
        core, plain, doubts = _read_plain(data, file, files)
    except SceneError as e:
        raise SceneError(map(without_quotes, e.lines)) from None
    _warn(doubts)
    return Scene(core, Given(core, plain, files=files), report)


def _read_plain(
    data: Mapping[str, Any], file: str, files: NamedFiles | None = None
) -> tuple[_core.Scene, dict[str, Any], list[str]]:
    """Return the scene, the data without numpy types, and warnings about suspicious values."""
    try:
        text = json.dumps(data, default=_plain)
    except ValueError:
        raise SceneError(f"{file or 'scene'}: contains itself") from None
    except TypeError as e:
        raise SceneError(f"{file or 'scene'}: {e}") from None
    core, doubts = _read_core(text, file, files or NamedFiles(file))
    return core, json.loads(text), doubts


# More are not read by anyone, and a file that is no scene has one in each line.
_MOST_FAULTS = 100


def _read_core(text: str, file: str, files: NamedFiles) -> tuple[_core.Scene, list[str]]:
    """Return the scene of a JSON text, and warnings; all faults are raised, those of files first."""
    resolved, faults = files.resolved(text)
    try:
        core, doubts = _core.read_scene_and_doubts(resolved, file)
    except SceneError as e:
        faults = [*faults, *e.lines]
    if not faults:
        return core, doubts
    if (more := len(faults) - _MOST_FAULTS) > 0:
        faults[_MOST_FAULTS:] = [f"{file or 'scene'}: {more} more faults"]
    raise SceneError(faults)


def _read(text: str, language: str, file: str) -> Scene:
    places = Places(text, language, file)
    files = NamedFiles(file)
    plain = yaml12.to_json(text, file or "scene") if language == "yaml" else text
    try:
        core, doubts = _read_core(plain, file, files)
    except SceneError as e:
        raise SceneError(places.located(e.lines)) from None
    _warn(places.located(doubts))
    given = Given(core, json.loads(plain), text if language == "yaml" else None, files)
    return Scene(core, given, (), places)


def _warn(doubts: Iterable[str]) -> None:
    for doubt in doubts:
        warnings.warn(doubt, SceneWarning, stacklevel=4)


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"found a {type(value).__name__}, expected numbers, strings, lists and mappings")


def _shown(parameter: _core.Parameter, value: float) -> Value:
    if parameter.type == "boolean":
        return bool(value)
    if parameter.type == "integer":
        return round(value)
    return parameter.items[round(value) - 1] if parameter.type == "enumeration" else value
