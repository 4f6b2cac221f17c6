# SPDX-License-Identifier: BSD-3-Clause
"""The source of a scene, which is preserved when the scene is saved, except for changes."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from gelenk import _core
from gelenk.errors import SceneError
from gelenk.model import yaml12, yaml_edits
from gelenk.model.named_files import NamedFiles


class Given:
    """The data of a scene as given, without defaults, and their text."""

    def __init__(
        self,
        core: _core.Scene,
        data: dict[str, Any],
        text: str | None = None,
        files: NamedFiles | None = None,
    ) -> None:
        """Store the source of a scene.

        Args:
            core: the scene.
            data: the data from which it was read.
            text: text of the data, if it is YAML.
            files: the files to which it refers.
        """
        self._core = core
        self._data = data
        self._text = text
        self._files = files or NamedFiles("")

    def written(self, core: _core.Scene, language: str, folder: Path) -> str:
        """Return the text of a file for the scene or a changed copy of it.

        The source is preserved except for changed fields. If a change cannot be expressed by single fields,
        everything is written, including defaults.

        Args:
            core: the scene to write.
            language: "yaml" or "json".
            folder: of the file; names of mesh files are valid in the folder of the source only.
        """
        data = self._data_of(core)
        if data is not None and folder.resolve() != self._files.folder.resolve():
            data = self._with_files(data)
        if language == "yaml" and self._text is not None and data is not None:
            text = self._text if data is self._data else yaml_edits.changed(self._text, self._data, data)
            if text is not None:
                return text
        if data is None:
            data = json.loads(_core.write_scene_json(core))
        return yaml12.dump(data) if language == "yaml" else json.dumps(data, indent=2) + "\n"

    def _with_files(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return data with points and triangles in the place of names of files; itself without names."""
        text = json.dumps(data)
        resolved = self._files.resolved(text)[0]
        return data if resolved is text else json.loads(resolved)

    def _data_of(self, core: _core.Scene) -> dict[str, Any] | None:
        """Return the given data with changed fields; None if changes of single fields are not sufficient."""
        if core is self._core:
            return self._data
        before, after = (_core.write_scene_json(scene) for scene in (self._core, core))
        for siblings in (False, True):
            found = _changed(self._data, json.loads(before), json.loads(after), siblings)
            with suppress(SceneError):
                whole = self._files.resolved(json.dumps(found))[0]
                if _core.write_scene_json(_core.read_scene_json(whole, "")) == after:
                    assert isinstance(found, dict)
                    return found
        return None


def _changed(given: Any, before: Any, after: Any, siblings: bool) -> Any:
    """Return a given value with the differences between two normalized versions of the scene.

    Args:
        given: the value as given, which may omit defaults; they remain omitted if they did not change.
        before: its normalized version before the change.
        after: its normalized version after the change.
        siblings: whether to write also the siblings of a changed field that were given in another form
            (`fixed: [w]` for a start with only w).
    """
    if repr(before) == repr(after):
        return given
    values = (given, before, after)
    if all(isinstance(value, dict) for value in values):
        return _changed_mapping(given, before, after, siblings)
    if all(isinstance(value, list) for value in values) and len(before) == len(after):
        n = len(given)  # products of inertia may be omitted
        if repr(before[n:]) == repr(after[n:]):
            return [_changed(*items, siblings) for items in zip(given, before, after, strict=False)]
    return after


def _changed_mapping(
    given: dict[str, Any], before: dict[str, Any], after: dict[str, Any], siblings: bool
) -> dict[str, Any]:
    out = {key: value for key, value in given.items() if key in after or key not in before}
    changes = {key: value for key, value in after.items() if repr(before.get(key)) != repr(value)}
    for key, value in changes.items():
        omitted: dict[str, Any] | None = {} if isinstance(value, dict) else None
        out[key] = _changed(given.get(key, omitted), before.get(key, omitted), value, siblings)
    if siblings and not all(isinstance(value, dict) for value in changes.values()):
        given_siblings = {key: after[key] for key in out if not isinstance(after.get(key, {}), dict)}
        out |= {key: value for key, value in given_siblings.items() if out[key] != value}
    return out
