# SPDX-License-Identifier: BSD-3-Clause
"""The writer of gelenk-export keeps the contract of gelenk.file_writing: completely or not at all, links."""

from __future__ import annotations

import errno
import os
import resource
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from gelenk.file_writing import is_draft

LARGE = 40_000_000  # bytes; takes some 20 ms to write


@pytest.fixture(scope="session")
def module_folder(units: Any) -> str:
    return str(Path(units.__file__).parent)


def child(code: str, module_folder: str, *words: object, **options: Any) -> subprocess.Popen[bytes]:
    """A process in which `write` is the function that is tested, and `words` are its arguments."""
    start = (
        f"import sys; sys.path.insert(0, {module_folder!r}); from native_units import write_file as write\n"
    )
    return subprocess.Popen([sys.executable, "-c", start + code, *map(str, words)], **options)


def test_files_are_made_and_replaced(units: Any, tmp_path: Path) -> None:
    for content in (b"", b"first", bytes(1_000_000), b"last"):
        assert units.write_file(str(tmp_path / "x.fmu"), content) == 0
        assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("x.fmu", content)]


def test_links_lead_to_the_file_that_is_written(units: Any, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "second").symlink_to(Path("there", "missing.fmu"))
    (tmp_path / "first").symlink_to("second")
    for content in (b"made", b"replaced"):
        assert units.write_file(str(tmp_path / "first"), content) == 0
        assert (tmp_path / "first").is_symlink()
        assert (tmp_path / "second").is_symlink()
        assert (tmp_path / "there" / "missing.fmu").read_bytes() == content
    assert len(list((tmp_path / "there").iterdir())) == 1
    (tmp_path / "loop").symlink_to("loop")
    assert units.write_file(str(tmp_path / "loop"), b"") == errno.ELOOP


def test_permissions_are_kept(units: Any, tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        file = tmp_path / "x.fmu"
        units.write_file(str(file), b"")
        assert stat.S_IMODE(file.stat().st_mode) == 0o640
        for mode in (0o600, 0o664, 0o755):
            file.chmod(mode)
            units.write_file(str(file), b"")
            assert stat.S_IMODE(file.stat().st_mode) == mode
    finally:
        os.umask(before)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_must_not_be_written_is_not_replaced(units: Any, tmp_path: Path) -> None:
    file = tmp_path / "x.fmu"
    file.write_bytes(b"old")
    file.chmod(0o444)
    assert units.write_file(str(file), b"new") == errno.EACCES
    file.chmod(0o644)
    tmp_path.chmod(0o555)  # no file can be made beside it
    assert units.write_file(str(file), b"new") == 0
    assert file.read_bytes() == b"new"


def test_pipes_are_written_to(units: Any, tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    found: list[bytes] = []
    thread = threading.Thread(target=lambda: found.append(pipe.read_bytes()))
    thread.start()
    content = bytes(range(256)) * 4000  # more than a pipe holds
    assert units.write_file(str(pipe), content) == 0
    thread.join(30)
    assert found == [content]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_stdout_is_written_to_and_not_replaced(module_folder: str, tmp_path: Path) -> None:
    with (tmp_path / "out").open("wb") as out:
        inode = (tmp_path / "out").stat().st_ino
        assert child("write('/dev/stdout', b'content')", module_folder, stdout=out).wait() == 0
    assert (tmp_path / "out").read_bytes() == b"content"
    assert (tmp_path / "out").stat().st_ino == inode
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_errors_leave_nothing(units: Any, tmp_path: Path) -> None:
    assert units.write_file(str(tmp_path), b"") == errno.EISDIR
    assert units.write_file(str(tmp_path / "missing" / "x.fmu"), b"") == errno.ENOENT
    assert units.write_file(str(tmp_path / ("x" * 300)), b"") == errno.ENAMETOOLONG
    assert list(tmp_path.iterdir()) == []
    longest = "x" * 251 + ".fmu"
    assert units.write_file(str(tmp_path / longest), b"") == 0


def test_a_full_disk_leaves_the_old_file(module_folder: str, tmp_path: Path) -> None:
    file = tmp_path / "x.fmu"
    file.write_bytes(b"old")

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

    code = "sys.exit(write(sys.argv[1], bytes(100_000)))"
    writer = child(code, module_folder, file, preexec_fn=limit, stdin=subprocess.DEVNULL)
    assert writer.wait() == errno.EFBIG
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("x.fmu", b"old")]


def test_a_killed_process_leaves_the_old_file_or_the_new_one(module_folder: str, tmp_path: Path) -> None:
    """Its draft is hidden, and known as such."""
    file, new = tmp_path / "x.fmu", b"n" * LARGE
    code = "content = b'n' * int(sys.argv[2]); print(flush=True)\nwhile True: write(sys.argv[1], content)"
    outcomes = set()
    for k in range(12):
        file.write_bytes(b"old")
        with child(code, module_folder, file, LARGE, stdout=subprocess.PIPE) as writer:
            assert writer.stdout is not None
            writer.stdout.readline()
            time.sleep(0.004 * k)
            writer.kill()
        outcomes.add(file.read_bytes())
        for other in tmp_path.iterdir():
            if other != file:
                assert is_draft(other.name), other.name
                other.unlink()
    assert outcomes <= {b"old", new}


def test_two_processes_write_one_file(module_folder: str, tmp_path: Path) -> None:
    """Sixty times each: at any time, the file is that of one of them."""
    file = tmp_path / "x.fmu"
    file.write_bytes(b"1" * 300_000)
    code = "sys.exit(max(write(sys.argv[1], sys.argv[2].encode() * 300_000) for _ in range(60)))"
    writers = [child(code, module_folder, file, digit) for digit in "12"]
    while any(writer.poll() is None for writer in writers):
        content = file.read_bytes()
        assert content in (b"1" * 300_000, b"2" * 300_000)
    assert [writer.returncode for writer in writers] == [0, 0]
    assert [p.name for p in tmp_path.iterdir()] == ["x.fmu"]
