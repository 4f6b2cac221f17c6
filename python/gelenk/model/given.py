# SPDX-License-Identifier: BSD-3-Clause
"""What a scene was made of: where it is written, this is kept but for what has changed."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Any

from gelenk import _core
from gelenk.errors import SceneError
from gelenk.model import yaml12, yaml_edits


class Given:
    """The data of a scene as they were given, without defaults, and their text."""

    def __init__(self, core: _core.Scene, data: dict[str, Any], text: str | None = None) -> None:
        """core: what became of it; text: of the data, where they were read from YAML."""
        self._core = core
        self._data = data
        self._text = text

    def written(self, core: _core.Scene, language: str) -> str:
        """The text of a file, in YAML or JSON, of the scene or of what has become of it.

        All of it is written anew, with defaults, where a change is none of single fields.
        """
        data = self._data_of(core)
        if language == "yaml" and self._text is not None and data is not None:
            text = self._text if data is self._data else yaml_edits.changed(self._text, self._data, data)
            if text is not None:
                return text
        if data is None:
            data = json.loads(_core.write_scene_json(core))
        return yaml12.dump(data) if language == "yaml" else json.dumps(data, indent=2) + "\n"

    def _data_of(self, core: _core.Scene) -> dict[str, Any] | None:
        """As those given, with changes; None where no changes of single fields make them."""
        if core is self._core:
            return self._data
        before, after = (_core.write_scene_json(scene) for scene in (self._core, core))
        for beside in (False, True):
            found = _changed(self._data, json.loads(before), json.loads(after), beside)
            with suppress(SceneError):
                if _core.write_scene_json(_core.read_scene_json(json.dumps(found), "")) == after:
                    assert isinstance(found, dict)
                    return found
        return None


def _changed(given: Any, before: Any, after: Any, beside: bool) -> Any:
    """The value given, with what differs between the scene as it was and as it is.

    Both have all defaults; what is left out of the value and did not change stays out. beside: with what
    stands beside a change, too, where it was given in other words (`fixed: [w]`, of a start with w alone).
    """
    if repr(before) == repr(after):
        return given
    values = (given, before, after)
    if all(isinstance(value, dict) for value in values):
        return _changed_mapping(given, before, after, beside)
    if all(isinstance(value, list) for value in values) and len(before) == len(after):
        n = len(given)  # products of inertia may be left out
        if repr(before[n:]) == repr(after[n:]):
            return [_changed(*items, beside) for items in zip(given, before, after, strict=False)]
    return after


def _changed_mapping(
    given: dict[str, Any], before: dict[str, Any], after: dict[str, Any], beside: bool
) -> dict[str, Any]:
    out = {key: value for key, value in given.items() if key in after or key not in before}
    changes = {key: value for key, value in after.items() if repr(before.get(key)) != repr(value)}
    for key, value in changes.items():
        left_out: dict[str, Any] | None = {} if isinstance(value, dict) else None
        out[key] = _changed(given.get(key, left_out), before.get(key, left_out), value, beside)
    if beside and not all(isinstance(value, dict) for value in changes.values()):
        told = {key: after[key] for key in out if not isinstance(after.get(key, {}), dict)}
        out |= {key: value for key, value in told.items() if out[key] != value}
    return out
