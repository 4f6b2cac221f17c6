# SPDX-License-Identifier: BSD-3-Clause
"""How Gelenk writes files: completely, or not at all.

The content is written to a new file in the folder of the target, flushed to the disk, and renamed. After a
full disk, a crash or the end of the process at any moment, the target is the old file or the new one. A
killed process may leave a hidden file, `.NAME-....part` with the ending of the target, which can be deleted.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedRandom, FileIO
from os import PathLike
from pathlib import Path
from typing import Any, override

from gelenk.file_reading import usable_name

# Characters of the target's name and ending in the name of the new file: names may have 255 bytes.
LONGEST_STEM, LONGEST_ENDING = 40, 10
PART = ".part"
_DRAFT = re.compile(r"\..*-[0-9a-f]{16}\.part(\..*)?")
# A folder in which no file can be made may contain one that can be written.
_NO_NEW_FILE = (errno.EACCES, errno.EPERM, errno.EROFS)
# Of a file on which another file system is mounted, as in containers.
_NOT_REPLACEABLE = (errno.EBUSY, errno.EXDEV)
_RETRIES = 10  # on Windows, a file cannot be replaced while another process is replacing it
_PAUSE = 0.01  # s between them


@contextmanager
def replacing(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield the path of a new file, which takes the place of a file when the block ends without an exception.

    Symbolic links are followed; an existing file keeps its permissions. What is no regular file (a pipe,
    /dev/stdout) is written to when the block ends. So is a file in a folder in which no file can be made, or
    that cannot be replaced: only such a file is incomplete if the process ends in the middle.

    Args:
        path: the file to be made or replaced.

    Raises:
        UsageError: the name contains a zero byte.
        OSError: the file cannot be written; it is as it was before.
    """
    target = usable_name(path)
    draft = None
    try:
        place = _place(target)
        draft = None if place is None else _new_file(place)
        if draft is None or place is None:
            with tempfile.TemporaryDirectory(prefix="gelenk-") as folder:
                draft = Path(folder, f"new{target.suffix}")
                yield draft
                _copy(draft, target)
            return
        try:
            yield draft
            _to_disk(draft)
            _rename(draft, place)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as e:
        # Errors about the new file, and of writing to open files, become errors about the target.
        name = None if e.filename is None else Path(os.fsdecode(e.filename))
        if e.errno is None or not (name in (None, draft) or is_draft(name.name)):
            raise
        raise OSError(e.errno, os.strerror(e.errno), str(target)) from None


@contextmanager
def writing(path: str | PathLike[str]) -> Iterator[BufferedRandom]:
    """Yield an open binary file whose content becomes that of a file: see `replacing`.

    It can be read and positioned, also if the target is a pipe.
    """
    with replacing(path) as draft:
        raw = _Raw(draft, "w+b")
        try:
            with BufferedRandom(raw) as file:
                yield file
        except Exception:
            if raw.error is None:
                raise
        # What failed because of it is of no interest.
        if raw.error is not None:
            raise raw.error


def write_bytes(path: str | PathLike[str], content: bytes) -> None:
    """Write a file: see `replacing`."""
    with writing(path) as file:
        file.write(content)


def write_text(path: str | PathLike[str], text: str) -> None:
    """Write a file in UTF-8, with line breaks as given: see `replacing`."""
    write_bytes(path, text.encode("utf-8"))


def is_draft(name: str) -> bool:
    """Return whether a name is that of a file which is being written, or which a killed process has left."""
    return _DRAFT.fullmatch(name) is not None


class _Raw(FileIO):
    """A file that keeps the first error and discards what is written after it.

    HDF5 crashes at the end of the process if a file could not be written.
    """

    error: OSError | None = None

    @override
    def write(self, content: Any) -> int:
        if self.error is None:
            try:
                return super().write(content) or 0
            except OSError as e:
                self.error = e
        count = memoryview(content).nbytes
        self.seek(count, os.SEEK_CUR)
        return count

    @override
    def truncate(self, size: int | None = None) -> int:
        if self.error is None:
            try:
                return super().truncate(size)
            except OSError as e:
                self.error = e
        return self.seek(0, os.SEEK_CUR) if size is None else size


def _place(target: Path) -> Path | None:
    """Return the regular file at the end of links, which need not exist; None: it is written to directly."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode) or _is_open_file(target):
        return None
    return Path(os.path.realpath(target))


def _is_open_file(target: Path) -> bool:
    """Return whether a path leads to an open file of a process, as /dev/stdout does, even a regular one."""
    step = target.absolute()
    for _ in range(40):  # the longest chain of links on Linux
        folder = step.parent.resolve()
        if Path("/proc") in folder.parents or folder in (Path("/dev"), Path("/dev/fd")):
            return True
        if not step.is_symlink():
            return False
        step = folder / step.readlink()
    return False


def _new_file(place: Path) -> Path | None:
    """Make an empty file with the permissions that the target has or will have; None: none is allowed."""
    old = None
    with suppress(FileNotFoundError):
        old = place.stat()
    if old is not None and not os.access(place, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    name = f".{place.stem[:LONGEST_STEM]}-{secrets.token_hex(8)}{PART}{place.suffix[:LONGEST_ENDING]}"
    draft = place.with_name(name)
    try:
        # Without other permissions than the umask allows; those of an existing file follow.
        os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as e:
        if old is not None and e.errno in _NO_NEW_FILE:
            return None
        raise
    if old is not None:
        if hasattr(os, "chown"):
            with suppress(OSError):  # of another user
                os.chown(draft, old.st_uid, old.st_gid)
        with suppress(OSError):  # a file system without permissions
            draft.chmod(stat.S_IMODE(old.st_mode))
    return draft


def _to_disk(draft: Path) -> None:
    with draft.open("r+b") as file:
        os.fsync(file.fileno())


def _rename(draft: Path, place: Path) -> None:
    for trial in range(_RETRIES):
        try:
            draft.replace(place)
            break
        except PermissionError:
            if os.name != "nt" or trial == _RETRIES - 1:
                raise
            time.sleep(_PAUSE)
        except OSError as e:
            if e.errno not in _NOT_REPLACEABLE:
                raise
            _copy(draft, place)
            return
    if hasattr(os, "O_DIRECTORY"):
        with suppress(OSError):  # some file systems cannot; the content is on the disk
            folder = os.open(place.parent, os.O_RDONLY | os.O_DIRECTORY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)


def _copy(draft: Path, target: Path) -> None:
    with draft.open("rb") as content, target.open("wb") as file:
        shutil.copyfileobj(content, file)
