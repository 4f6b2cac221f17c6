# SPDX-License-Identifier: BSD-3-Clause
"""Files are written completely or not at all: killed processes, full disks, two at once, links, pipes."""

from __future__ import annotations

import json
import os
import pickle
import signal
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import programs
import pytest
from file_writers import KINDS, contents, new_and_old
from samples import thorough_beyond

import gelenk
from gelenk.file_writing import LONGEST_ENDING, is_draft, replacing, write_bytes, write_text, writing

STUDY_KILLS = 200  # of each kind, at random times
FULL_DISKS, STUDY_FULL_DISKS = 2, 50
TWO, STUDY_TWO = 5, 60  # repetitions of two writers


def run(job: str, kind: str, count: int, folder: Path) -> dict[str, int]:
    """The outcomes of `file_writers`, which are counted in a process of its own."""
    program = Path(__file__).with_name("file_writers.py")
    done = programs.run(program, job, kind, count, folder, timeout=1800)
    assert done.returncode == 0, done.stderr
    counts: dict[str, int] = json.loads(done.stdout)
    return counts


# A film takes a second each time, and is written as pictures are.
@pytest.mark.parametrize("kind", thorough_beyond(KINDS, {*KINDS} - {"gif"}))
def test_a_process_that_is_killed_at_any_moment_leaves_the_old_file_or_the_new_one(
    kind: str, tmp_path: Path
) -> None:
    counts = run("moments", kind, 1, tmp_path)
    assert counts.pop("ended with 0") == 1
    assert counts.pop(f"killed by {int(signal.SIGXFSZ)}, old") == 1
    assert set(counts) == {"old", "new"}
    assert counts["old"] >= 3  # before the new file is made, brought to the disk, and renamed


@pytest.mark.parametrize("kind", thorough_beyond(KINDS, {*KINDS} - {"gif"}))
def test_a_full_disk_leaves_the_old_file_and_nothing_else(kind: str, tmp_path: Path) -> None:
    """RLIMIT_FSIZE ends a file before its first or its last byte: each time an error, and no crash."""
    assert run("full", kind, FULL_DISKS, tmp_path) == {"old": FULL_DISKS}


def test_a_full_disk_does_not_end_the_process(tmp_path: Path) -> None:
    """As HDF5 does at its end if a file that it has opened could not be written."""
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    path, old, _ = new_and_old("nc", tmp_path)
    before = path.read_bytes()
    code = f"""
import pickle, resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
result = pickle.loads({pickle.dumps(old)!r})
for limit in (0, 5000, {len(before)} // 2, {len(before)} - 1):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        result.save({str(path)!r})
    except OSError as e:
        sys.stderr.write(f"{{e.filename}}: {{e.strerror}}\\n")
sys.exit(3)
"""
    done = subprocess.run([sys.executable, "-"], input=code, capture_output=True, text=True, check=False)
    assert done.returncode == 3, done.stderr
    assert done.stderr.splitlines() == [f"{path}: File too large"] * 4
    assert path.read_bytes() == before


@pytest.mark.study
@pytest.mark.parametrize("kind", KINDS)
def test_two_hundred_kills_and_fifty_full_disks(kind: str, tmp_path: Path) -> None:
    counts = run("kills", kind, STUDY_KILLS, tmp_path)
    assert set(counts) == {"old", "new"}
    (tmp_path / "full").mkdir()
    assert run("full", kind, STUDY_FULL_DISKS, tmp_path / "full") == {"old": STUDY_FULL_DISKS}


def assert_two_writers_agree(kind: str, repetitions: int, folder: Path) -> int:
    """Return how often the file was read while two processes wrote it, always one of both."""
    counts = run("two", kind, repetitions, folder)
    found = counts.pop("whole")
    assert counts == {"ended with 0": 2, f"files {[f'file.{kind}']}": 1}
    return found


@pytest.mark.parametrize("kind", thorough_beyond(["csv", "fmu", "png"], ["csv"]))
def test_two_processes_that_write_one_file_are_no_error(kind: str, tmp_path: Path) -> None:
    assert assert_two_writers_agree(kind, TWO, tmp_path) > 1


@pytest.mark.study
@pytest.mark.parametrize("kind", KINDS)
def test_two_processes_write_one_file_sixty_times_each(kind: str, tmp_path: Path) -> None:
    assert assert_two_writers_agree(kind, STUDY_TWO, tmp_path) > STUDY_TWO


@pytest.mark.parametrize("kind", ["csv", "fmu", "yaml"])
def test_two_at_once_are_no_error(kind: str, tmp_path: Path) -> None:
    path, old, new = new_and_old(kind, tmp_path)
    expected = contents(kind, path, old), contents(kind, path, new)
    errors: list[Exception] = []

    def write(what: object) -> None:
        try:
            for _ in range(10):
                KINDS[kind](what, path)
        except Exception as e:
            errors.append(e)

    writers = [threading.Thread(target=write, args=(what,)) for what in (old, new)]
    for writer in writers:
        writer.start()
    while any(writer.is_alive() for writer in writers):
        assert path.read_bytes() in expected
    assert errors == []
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_links_lead_to_the_file_that_is_written(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / "link.csv"
    link.symlink_to(Path("there", "missing.csv"))
    for text in ("first", "second"):
        write_text(link, text)
        assert link.is_symlink()
        assert (tmp_path / "there" / "missing.csv").read_text() == text
    assert len(list((tmp_path / "there").iterdir())) == 1
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OSError, match="loop"):
        write_text(tmp_path / "loop", "")


def test_permissions_are_kept(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "new", "")
        assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640
        for mode in (0o600, 0o664, 0o755):
            (tmp_path / "new").chmod(mode)
            write_text(tmp_path / "new", "")
            assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == mode
    finally:
        os.umask(before)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_must_not_be_written_is_not_replaced(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("old")
    file.chmod(0o444)
    with pytest.raises(PermissionError):
        write_text(file, "new")
    file.chmod(0o644)
    tmp_path.chmod(0o555)  # no file can be made beside it
    write_text(file, "new")
    assert file.read_text() == "new"


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[tuple[Path, list[bytes]]]:
    """A pipe, and what comes out of it."""
    pipe = tmp_path / "pipe.nc"
    os.mkfifo(pipe)
    found: list[bytes] = []
    thread = threading.Thread(target=lambda: found.append(pipe.read_bytes()), daemon=True)
    thread.start()
    yield pipe, found
    thread.join(10)


def test_pipes_are_written_to(reader: tuple[Path, list[bytes]], tmp_path: Path) -> None:
    """Also in formats that are not written from the beginning to the end."""
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    pipe, found = reader
    _, old, _ = new_and_old("nc", tmp_path)
    old.save(pipe)
    while not found:
        pass
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    (tmp_path / "again.nc").write_bytes(found[0])
    assert gelenk.Result.read(tmp_path / "again.nc").names == old.names


def test_stdout_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    code = """
from gelenk.file_writing import write_text
print("a", flush=True)
write_text("/dev/stdout", "b\\n")
"""
    piped = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert piped.stdout == "a\nb\n"
    with (tmp_path / "out").open("w") as out:
        inode = (tmp_path / "out").stat().st_ino
        subprocess.run([sys.executable, "-c", code], stdout=out, check=True)
    assert (tmp_path / "out").stat().st_ino == inode
    assert list(tmp_path.iterdir()) == [tmp_path / "out"]


def test_errors_name_the_file_of_the_user(tmp_path: Path) -> None:
    for path, error in (
        (tmp_path / "missing" / "x.csv", FileNotFoundError),
        (tmp_path, IsADirectoryError),
        (tmp_path / ("x" * 300), OSError),
    ):
        with pytest.raises(error) as caught:
            write_text(path, "")
        assert caught.value.filename == str(path)
    with pytest.raises(gelenk.UsageError, match="found a zero byte in the name of a file"):
        write_text("a\0b", "")
    with pytest.raises(FileNotFoundError) as other, writing(tmp_path / "x"):
        (tmp_path / "another").read_bytes()
    assert other.value.filename == str(tmp_path / "another")
    assert list(tmp_path.iterdir()) == []


def test_names_of_new_files(tmp_path: Path) -> None:
    """Any name that a file may have; the format is found by the ending, and drafts by their name."""
    long = ("ä" * 127, "." + "x" * 254, f"{'x' * 200}.parquet", "a.b" + "c" * 200)
    for name in ("a", "a.csv", ".hidden", *long):
        with replacing(tmp_path / name) as draft:
            assert is_draft(draft.name)
            assert draft.suffix[:LONGEST_ENDING] in (Path(name).suffix[:LONGEST_ENDING], ".part")
        assert [p.name for p in tmp_path.iterdir()] == [name]
        assert not is_draft(name)
        (tmp_path / name).unlink()


def test_an_exception_leaves_the_old_file(tmp_path: Path) -> None:
    write_bytes(tmp_path / "x", b"old")
    with pytest.raises(ZeroDivisionError), writing(tmp_path / "x") as file:
        file.write(bytes([1 // 0]))
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("x", b"old")]


def test_a_page_is_shown_whatever_the_scene_is_called(
    four_bar: gelenk.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names of scenes are free: they are no paths."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    for name in ("a/b", str(tmp_path / "elsewhere"), "../x", "x" * 200, "a\\b", "con", "ä ü"):
        scene = gelenk.load({**four_bar.to_dict(), "name": name})
        page = gelenk.view(scene, stop=0.0).show()
        assert page.parent == tmp_path / "temporary"
        assert page.as_uri() == opened[-1]
    assert [p.name for p in tmp_path.iterdir()] == ["temporary"]
