# SPDX-License-Identifier: BSD-3-Clause
"""Files to which a scene refers by name, of meshes and tables: what they contain replaces the names."""

from __future__ import annotations

import json
from collections.abc import Hashable
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from gelenk.model import meshes, tables
from gelenk.model.file_names import FileFaultError

_KINDS: tuple[Any, ...] = (meshes, tables)


class _Entries(dict[str, Any]):
    """A mapping that writes repeated keys, too: the reader of scenes reports them."""

    def __init__(self, pairs: list[tuple[str, Any]]) -> None:
        super().__init__(pairs)
        self._pairs = pairs

    def items(self) -> Any:
        """Return all pairs."""
        return super().items() if len(self) == len(self._pairs) else self._pairs


class NamedFiles:
    """The files of one scene, each of which is read once."""

    def __init__(self, file: str) -> None:
        """Store where they are.

        Args:
            file: the scene, to whose folder names of files are relative; empty: to the current folder.
        """
        self._file = file
        self._folder = Path(file).parent if file else Path()
        self._read: dict[Hashable, dict[str, Any]] = {}

    @property
    def folder(self) -> Path:
        """The folder to which names of files are relative."""
        return self._folder

    def resolved(self, text: str) -> tuple[str, list[str]]:
        """Replace the names of files by what they contain.

        Args:
            text: a scene in JSON.

        Returns:
            tuple: the scene without names of files, and faults, one line each.
        """
        if '"mesh"' not in text and '"tables"' not in text:
            return text, []
        try:
            data = json.loads(text, object_pairs_hook=_Entries)
        except (ValueError, RecursionError):
            return text, []  # the reader of scenes reports it
        faults = []
        found = False
        for kind in _KINDS if isinstance(data, dict) else ():
            for path, owner, key in kind.references(data):
                found = True
                try:
                    owner[key] = self._content(kind, owner[key])
                except FileFaultError as fault:
                    faults.append(f"{self._file or 'scene'}: {path}{fault}")
                    # The rest of the scene is checked, too.
                    owner[key] = kind.ANY
        return (json.dumps(data) if found else text), faults

    def _content(self, kind: Any, reference: Any) -> dict[str, Any]:
        name, how = kind.named(reference)
        key = (kind.__name__, name, how)
        if key not in self._read:
            self._read[key] = kind.load(self._path(name), name, how)
        # The rest of a reference stays: how a table is interpolated.
        others = reference if isinstance(reference, dict) else {}
        return {k: v for k, v in others.items() if k not in kind.OF_FILES} | self._read[key]

    def _path(self, name: str) -> Path:
        is_absolute = PurePosixPath(name).is_absolute() or PureWindowsPath(name).is_absolute()
        if is_absolute or ".." in PurePosixPath(name.replace("\\", "/")).parts:
            raise FileFaultError(
                f"'{name}'",
                "a file in the folder of the scene, or in a folder of it, so that both can be moved",
            )
        return self._folder / name
