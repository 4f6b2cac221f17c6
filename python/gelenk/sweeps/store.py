# SPDX-License-Identifier: BSD-3-Clause
"""Outcomes of a sweep in a folder: what has been computed is not computed again.

Each part is a Parquet file of successive runs. It appears by being renamed, complete, and its name contains
its checksum: an interruption at any time leaves only whole parts, and a damaged one is noticed.
"""

from __future__ import annotations

import hashlib
import io
import json
import logging
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.file_reading import check_file, read_bytes
from gelenk.file_writing import is_draft, write_bytes
from gelenk.sweeps.driver import Range
from gelenk.sweeps.outputs import Output
from gelenk.sweeps.plan import Chunk

log = logging.getLogger(__name__)

FORMAT = 1
DESCRIPTION = "sweep.json"
_PART = re.compile(r"runs-(\d+)-(\d+)-([0-9a-f]{16})\.parquet")
MOST_BYTES = 2_000_000_000  # of a part, which is read into memory
OLD = 3600.0  # s after which a file that is being written is considered left by a killed process


class Store:
    """A folder with the outcomes of one sweep."""

    def __init__(self, folder: Path, description: Mapping[str, Any], runs: int) -> None:
        """Open a folder, which is made if there is none.

        Args:
            folder: the folder.
            description: what identifies the sweep, as plain data.
            runs: number of runs.

        Raises:
            UsageError: the folder contains another sweep or other files, or pyarrow is not installed.
            OSError: the folder cannot be written.
        """
        extra("pyarrow", "stores are Parquet files, written with pyarrow")
        self._folder = folder
        self._runs = runs
        self._parts: dict[Range, Path] = {}
        folder.mkdir(parents=True, exist_ok=True)
        identity = {"format": FORMAT, "runs": runs, **description}
        file = folder / DESCRIPTION
        # Another process may open the same store now: files are listed before the description is looked for.
        others = [path for path in folder.iterdir() if not is_draft(path.name)]
        if file.exists():
            _compare(file, json.loads(json.dumps(identity)))
        else:
            if others:
                raise UsageError(
                    f"{folder}: found other files, expected an empty folder or a store of this sweep"
                )
            self._write(file, json.dumps(identity, indent=1).encode())
        self._find_parts()

    def _find_parts(self) -> None:
        covered = 0
        found = []
        for path in self._folder.iterdir():
            if is_draft(path.name):
                with suppress(OSError):  # renamed or removed by another process
                    if time.time() - path.stat().st_mtime > OLD:
                        path.unlink()
            elif name := _PART.fullmatch(path.name):
                found.append(((int(name[1]), int(name[2]) + 1), name[3], path))
        for (first, last), checksum, path in sorted(found):
            if _checksum(read_bytes(path, MOST_BYTES)) != checksum:
                log.warning("%s: damaged, its checksum is another one; its runs are made again", path)
                path.unlink(missing_ok=True)
            elif first >= covered:  # otherwise two processes have made the same runs
                self._parts[first, last] = path
                covered = last

    @property
    def missing(self) -> list[Range]:
        """The ranges of runs that have no part, in order."""
        found = []
        at = 0
        for first, last in [*sorted(self._parts), (self._runs, self._runs)]:
            if first > at:
                found.append((at, first))
            at = last
        return found

    def add(self, chunk: Chunk) -> None:
        """Write the outcome of successive runs.

        Raises:
            OSError: the disk is full, or the folder cannot be written; what was written before remains.
        """
        if chunk.last == chunk.first:
            return
        content = _parquet(chunk)
        name = f"runs-{chunk.first:09}-{chunk.last - 1:09}-{_checksum(content)}.parquet"
        self._write(self._folder / name, content)
        self._parts[chunk.first, chunk.last] = self._folder / name

    def chunks(self, columns: Sequence[str]) -> Iterator[Chunk]:
        """Yield the values of variables that are stored, in the order of the runs."""
        for (first, _), path in sorted(self._parts.items()):
            yield read_part(path, first, columns)

    def parts(self) -> list[tuple[Range, Path]]:
        """Return the ranges of runs that are stored, and their files, in order."""
        return sorted(self._parts.items())

    def _write(self, path: Path, content: bytes) -> None:
        try:
            write_bytes(path, content)
        except OSError as e:
            stored = sum(last - first for first, last in self._parts)
            raise OSError(
                e.errno,
                f"{e.strerror}; {stored} of {self._runs} runs are stored, and the same call makes the others",
                str(self._folder),
            ) from None


def read_part(path: Path, first: int, columns: Sequence[str]) -> Chunk:
    """Return the chunk in a file.

    Args:
        path: the file, named after its runs.
        first: number of its first run.
        columns: variables to read.

    Raises:
        UsageError: the content is not that of such a part.
        OSError: the file cannot be read.
    """
    name = _PART.fullmatch(path.name)
    assert name is not None
    runs = int(name[2]) + 1 - int(name[1])
    check_file(path)
    try:
        return _read_part(path, first, columns, runs)
    except Exception as e:  # exceptions of pyarrow for faulty files, MemoryError
        why = " ".join(str(e).split()) or type(e).__name__
        raise UsageError(
            f"{path}: not what a sweep has written ({why}); delete it, and its runs are made again"
        ) from None


def _read_part(path: Path, first: int, columns: Sequence[str], runs: int) -> Chunk:
    from pyarrow import parquet

    with parquet.ParquetFile(path) as file:
        found = file.metadata.num_rows
        if found != runs:
            raise ValueError(f"found {found} rows, expected {runs}")
        missing = [
            column for column in ("error", "warning", *columns) if column not in file.schema_arrow.names
        ]
        if missing:
            raise ValueError(f"found no column {missing[0]}")
        table = file.read(columns=["error", "warning", *columns])
    values = {}
    for name in columns:
        column = table[name].combine_chunks()
        points = column.type.list_size if hasattr(column, "flatten") else None
        flat = column if points is None else column.flatten()
        numbers = flat.to_numpy(zero_copy_only=False)
        if numbers.dtype != np.float64 or len(numbers) != runs * (1 if points is None else points):
            raise ValueError(f"{name}: found {column.type}, expected a number or a list for each run")
        values[name] = numbers if points is None else numbers.reshape(runs, points)
    errors, warnings = table["error"].to_pylist(), table["warning"].to_pylist()
    if not all(isinstance(text, str) for text in (*errors, *warnings)):
        raise ValueError("found errors or warnings that are no texts")
    return Chunk(first, values, errors, warnings)


def fingerprint(*contents: bytes) -> str:
    """Return a checksum of several contents."""
    total = hashlib.sha256()
    for content in contents:
        total.update(len(content).to_bytes(8, "little"))
        total.update(content)
    return total.hexdigest()


def described(variables: Sequence[Output]) -> list[str]:
    """Return a text for each variable that changes when the variable does."""
    import inspect

    texts = []
    for variable in variables:
        text = repr((variable.name, variable.unit, variable.signals, variable.pattern))
        function = variable.function
        if function is not None and not (getattr(function, "__module__", "") or "").startswith("gelenk."):
            try:
                text += inspect.getsource(function)
            except (TypeError, OSError):
                text += getattr(function, "__qualname__", "")
        texts.append(text)
    return texts


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _parquet(chunk: Chunk) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    columns: dict[str, Any] = {"run": pa.array(np.arange(chunk.first, chunk.last))}
    # Of floating-point numbers, the bytes of equal significance together: a third smaller, and ten times as
    # fast to write as with dictionaries.
    encodings = {}
    for name, values in chunk.values.items():
        flat = pa.array(np.ascontiguousarray(values).reshape(-1))
        columns[name] = flat if values.ndim == 1 else pa.FixedSizeListArray.from_arrays(flat, values.shape[1])
        encodings[name if values.ndim == 1 else f"{name}.list.element"] = "BYTE_STREAM_SPLIT"
    columns["error"] = pa.array(chunk.errors, pa.string())
    columns["warning"] = pa.array(chunk.warnings, pa.string())
    buffer = io.BytesIO()
    parquet.write_table(
        pa.table(columns), buffer, compression="zstd", use_dictionary=False, column_encoding=encodings
    )
    return buffer.getvalue()


def _compare(file: Path, identity: dict[str, Any]) -> None:
    """Check that a description is that of this sweep."""
    try:
        found = json.loads(read_bytes(file, MOST_BYTES))
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise UsageError(f"{file}: found no description of a sweep; expected an empty folder") from None
    names = [name for name in {**identity, **found} if found.get(name) != identity.get(name)]
    if names:
        details = "; ".join(
            f"{name}: found {_short(found.get(name))}, expected {_short(identity.get(name))}"
            for name in names[:3]
        )
        raise UsageError(f"{file.parent}: found a store of another sweep ({details}); use another folder")


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
