# SPDX-License-Identifier: BSD-3-Clause
"""The gelenk command: what it prints, what it writes, how it fails."""

from __future__ import annotations

import csv
import json
import os
import pty
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import programs
import pytest

import gelenk
from gelenk.simulation import progress


def call(*args: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return programs.gelenk(*args, cwd=cwd)


def told(*args: str | Path, cwd: Path | None = None) -> str:
    """What a call that has to succeed prints."""
    done = call(*args, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


def faults(*args: str | Path, cwd: Path | None = None) -> list[str]:
    """What a call that has to fail says: whole lines, exit code 1, nothing on stdout, no traceback."""
    done = call(*args, cwd=cwd)
    assert done.returncode == 1, done.stdout + done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    return done.stderr.splitlines()


def test_version_is_the_packages() -> None:
    assert told("--version") == f"gelenk {gelenk.__version__}\n"


def test_export_then_simulate_the_fmu(four_bar_file: Path, tmp_path: Path) -> None:
    out = told("export", four_bar_file, "-o", "x.fmu", cwd=tmp_path)
    assert re.fullmatch(r"x\.fmu: \d\.\d\d MB, FourBar\n", out)
    out = told(
        "simulate", "x.fmu", "--stop", "0.1", "--output", "r.csv", "--set", "drive.tau=3", cwd=tmp_path
    )
    assert out == "r.csv: 101 rows, 12 outputs, to 0.1 s\n"
    with (tmp_path / "r.csv").open() as file:
        rows = list(csv.reader(file))
    expected = gelenk.simulate(four_bar_file, stop=0.1, inputs={"drive.tau": 3})
    assert rows[0] == ["time", *expected.names]
    assert [tuple(map(float, row)) for row in rows[1:]] == expected.table.tolist()


def test_export_names_the_fmu_after_the_scene(four_bar_file: Path, tmp_path: Path) -> None:
    told("export", four_bar_file, cwd=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["FourBar.fmu"]


def test_every_option_of_simulate_reaches_the_run(four_bar_file: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("time,drive.tau\n0,3\n0.1,4\n")
    out = told(
        "simulate", four_bar_file, "--stop", "0.1", "--step", "0.005", "--tolerance", "1e-8",
        "--integrator", "ida", "--input", tmp_path / "in.csv", "--set", "A.phi_start=1.2",
        "--set", "gravity[3]=-1.62", "--output", "-",
    )  # fmt: skip
    expected = gelenk.simulate(
        four_bar_file, stop=0.1, step=0.005, tolerance=1e-8, integrator="ida",
        inputs={"drive.tau": ([0, 0.1], [3, 4])}, parameters={"A.phi_start": 1.2, "gravity[3]": -1.62},
    )  # fmt: skip
    assert out == expected.csv()


def test_without_output_the_span_of_every_output_is_told(four_bar_file: Path) -> None:
    lines = told("simulate", four_bar_file, "--stop", "0.1").splitlines()
    assert lines[0] == "0 to 0.1 s, 101 rows; --output FILE.csv writes them"
    assert lines[1].split() == ["start", "min", "max", "end"]
    assert [line.split()[0] for line in lines[2:5]] == ["A.phi", "A.w", "A.a"]
    assert [line.split()[-1] for line in lines[2:5]] == ["rad", "rad/s", "rad/s2"]
    assert lines[2].split()[1] == "1.5708"


def test_check_says_what_a_scene_is(four_bar_file: Path) -> None:
    lines = told("check", four_bar_file).splitlines()
    assert lines[0] == "<Scene FourBar: 3 bodies, 4 joints, 1 motor>"
    assert (
        lines[1]
        == "1 degree of freedom: 3 velocities, 2 constraint equations of rank 2, 3 moving bodies, planar"
    )
    assert lines[2] == "inputs: drive.tau"
    assert lines[3].startswith("loops closed at A.phi = 1.5708 rad")


def test_inspect_tells_sizes_reasons_and_costs(four_bar_file: Path) -> None:
    lines = told("inspect", four_bar_file).splitlines()
    assert lines[0] == "FourBar"
    assert lines[1].split() == ["as", "described", "as", "computed"]
    table = {line.split()[0]: line.split()[1:] for line in lines[2:10]}
    assert table["bodies"] == ["3", "->", "3"]
    assert table["coordinates"] == ["3", "->", "3"]
    assert table["constraint"] == ["equations", "5", "->", "2", "planar,", "redundant_rows"]
    assert table["degrees"] == ["of", "freedom", "1", "->", "1", "counted:", "-2,", "see", "mobility"]
    assert table["algebra"] == ["spatial", "->", "planar", "planar"]
    assert table["islands"] == ["1", "->", "1"]
    before, unit, _, after, same_unit = table["evaluation"]
    assert unit == same_unit == "us"
    assert float(before) > float(after) > 0
    text = " ".join(" ".join(lines).split())
    for name in gelenk.model.inspection.REDUCTIONS:
        assert re.search(rf" {name} [0-9.]+ us ", text), name
    assert "C: sliding along y, C: turning about x and C: turning about z" in text
    assert "statically indeterminate: f[2], t[1], t[3] of A, B, C and D" in text
    assert (
        "mobility 1 degree of freedom, while counting (6 for each body minus its constraints) gives -2;"
        in text
    )
    assert max(map(len, lines)) <= 110


def test_inspect_tells_programs_the_same(four_bar_file: Path) -> None:
    report = json.loads(told("inspect", four_bar_file, "--json"))
    sizes = {"bodies", "coordinates", "velocities", "constraint_equations", "degrees_of_freedom", "algebra"}
    sizes |= {"islands", "evaluation", "speeds", "rows", "freedoms"}  # the last three for one release
    assert set(report) == {
        "name", "described", "reduced", "reductions", "redundant_constraints", "undetermined_reactions",
        "moved_frames", "mobility", "left_out", "redundant_rows",
    }  # fmt: skip
    assert set(report["described"]) == set(report["reduced"]) == sizes
    assert [report[key]["constraint_equations"] for key in ("described", "reduced")] == [5, 2]
    assert report["described"]["evaluation"] > report["reduced"]["evaluation"] > 0  # s
    assert list(report["reductions"]) == list(gelenk.model.inspection.REDUCTIONS)
    for entry in report["reductions"].values():
        assert set(entry) == {"on", "changed", "notes", "evaluation_without"}
        assert entry["on"] is True
    assert [name for name, entry in report["reductions"].items() if entry["changed"]] == [
        "planar", "redundant_rows", "outputs",
    ]  # fmt: skip
    assert [row["joint"] for row in report["redundant_constraints"]] == ["C", "C", "C"]
    assert len(report["undetermined_reactions"]) == 12
    mobility = report["mobility"]
    assert (mobility["degrees_of_freedom"], mobility["counted"], mobility["at_start"]) == (1, -2, 1)
    assert len(mobility["causes"]) == 1


def test_inspect_without_a_reduction(four_bar_file: Path) -> None:
    report = json.loads(told("inspect", four_bar_file, "--without", "planar", "--json"))
    assert report["reductions"]["planar"]["on"] is False
    assert (report["reduced"]["algebra"], report["reduced"]["constraint_equations"]) == ("spatial", 2)
    text = told("inspect", four_bar_file, "--without", "planar", "--without", "redundant-rows")
    assert text.count("switched off") == 2
    assert re.search(r"constraint equations +5  ->  5\n", text)
    report = json.loads(told("inspect", four_bar_file, "--without", "all", "--json"))
    assert not any(entry["on"] for entry in report["reductions"].values())


def test_simulate_without_a_reduction(four_bar_file: Path) -> None:
    options = ("--stop", "0.05", "--set", "drive.tau=3", "--output", "-")
    out = told("simulate", four_bar_file, "--without", "planar", *options)
    expected = gelenk.simulate(four_bar_file, stop=0.05, inputs={"drive.tau": 3}, without=["planar"])
    assert out == expected.csv()
    assert out != told("simulate", four_bar_file, *options)  # other roundings: it was computed in space


def test_export_without_a_reduction(four_bar_file: Path, tmp_path: Path) -> None:
    told("export", four_bar_file, "--without", "planar", "--without", "outputs", "-o", "x.fmu", cwd=tmp_path)
    with zipfile.ZipFile(tmp_path / "x.fmu") as archive:
        carried = json.loads(archive.read("resources/scene.json"))
        page = archive.read("documentation/index.html").decode()
    assert "<li>planar: switched off in the scene</li>" in page
    assert "redundant_rows: 3 constraint equations are redundant at every position" in page
    assert carried["solver"]["reductions"] == {"planar": False, "outputs": False}
    out = told("simulate", "x.fmu", "--stop", "0.05", "--output", "-", cwd=tmp_path)
    assert out == gelenk.simulate(four_bar_file, stop=0.05, without=["planar", "outputs"]).csv()


def test_import_writes_a_scene_and_tells_what_it_left_out(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/></inertial></link>'
        '<joint name="j" type="prismatic"><parent link="a"/><child link="b"/></joint></robot>'
    )
    done = call("import", "r.urdf", "-o", "r.yaml", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout == "r.yaml: <Scene r: 2 bodies, 2 joints, 1 motor>\n"
    assert done.stderr == "links without mass: a\n"
    assert "prismatic" in (tmp_path / "r.yaml").read_text()
    told("import", "r.urdf", "-o", "f.json", "--floating", cwd=tmp_path)
    assert gelenk.load(tmp_path / "f.json").to_dict()["joints"]["base"]["type"] == "free"


def test_import_repairs_inertias_where_asked_to(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>'
        '<inertia ixx="3" iyy="1" izz="1"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    )
    assert "--repair-inertia" in faults("import", "r.urdf", "-o", "r.yaml", cwd=tmp_path)[-1]
    done = call("import", "r.urdf", "-o", "r.yaml", "--repair-inertia", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr.splitlines()[-1] == (
        "link b: no rigid body has its principal moments 1, 1, 3 kg m2; replaced by the nearest possible "
        "ones, 1.5, 1.5, 3: the second moments change by 23 %"
    )


@pytest.mark.parametrize("command", [["export"], ["check"], ["inspect"], ["simulate"]])
def test_scene_that_is_wrong_is_told_line_by_line(command: list[str], tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "gelenk: 1\nbodies: {a: {mass: -1, com: [0, 0]}}\njoints:\n  A: {type: weld}\n"
    )
    lines = faults(*command, "s.yaml", cwd=tmp_path)
    assert lines[:2] == [
        "s.yaml:2: bodies.a.mass: found -1 kg, expected 0 kg or more",
        "s.yaml:2: bodies.a.com: found a list of 2, expected a list of 3 numbers in m",
    ]
    assert all(re.match(r"s\.yaml:[24]: ", line) for line in lines)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["check", "none.yaml"], "none.yaml: no such file or directory"),
        (["check", "folder"], "folder: is a directory"),
        (["simulate", "none.fmu"], "none.fmu: no such file or directory"),
        (["check", "s.txt"], "s.txt: found the ending .txt, expected .yaml, .yml or .json"),
        (["simulate", "SCENE", "--input", "none.csv"], "none.csv: no such file or directory"),
        (["simulate", "SCENE", "--input", "s.txt"],
         "s.txt: drive.ta: no such input; did you mean drive.tau?"),
        (["simulate", "SCENE", "--set", "A.phi"], "--set A.phi: expected NAME=VALUE"),
        (["simulate", "SCENE", "--set", "gravity[3]="], "--set gravity[3]=: expected NAME=VALUE"),
        (["simulate", "SCENE", "--set", "drive.tau=x"], "drive.tau: found 'x', expected a number"),
        (["simulate", "SCENE", "--set", "a=1", "--set", "a=2"], "--set a=2: a is set twice"),
        (["simulate", "SCENE", "--set", "gravit[3]=1"],
         "gravit[3]: no such parameter or input; did you mean gravity[3] or gravity[2] or gravity[1]?"),
        (["simulate", "SCENE", "--stop", "-1"], "stop: found -1.0 s, expected 0 or more"),
        (["simulate", "SCENE", "--output", "none/r.csv", "--stop", "0"],
         "none/r.csv: no such file or directory"),
        (["inspect", "none.yaml"], "none.yaml: no such file or directory"),
        (["inspect", "SCENE", "--without", "plana"], "plana: no such reduction; did you mean planar?"),
        (["simulate", "SCENE", "--without", "planer"], "planer: no such reduction; did you mean planar?"),
        (["export", "SCENE", "--without", "x"],
         "x: no such reduction; there are weld, static, cut_choice, planar, redundant_rows, islands, "
         "outputs, massless, kinematic, all"),
        (["simulate", "x.fmu", "--without", "planar"],
         "without: reductions of an FMU cannot be changed after its export"),
        (["export", "SCENE", "-o", "x.zip"], "x.zip: found the ending .zip, expected .fmu"),
    ],
)  # fmt: skip
def test_slips_are_told_in_one_line(
    args: list[str], message: str, four_bar_file: Path, tmp_path: Path
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "s.txt").write_text("time,drive.ta\n0,1\n")
    assert faults(*(str(four_bar_file) if a == "SCENE" else a for a in args), cwd=tmp_path) == [message]


def test_failed_run_writes_the_rows_until_then(four_bar_file: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("time,drive.tau\n0,3\n0.0049,3\n0.0049,1e100\n")
    done = call("simulate", four_bar_file, "--input", "in.csv", "-o", "r.csv", cwd=tmp_path)
    assert done.returncode == 1
    assert "The state is unchanged at t = 0.005 s" in done.stderr
    assert len((tmp_path / "r.csv").read_text().splitlines()) == 7  # names, 0 to 0.005 s


@pytest.fixture
def terminal() -> Iterator[tuple[int, IO[str]]]:
    """Both ends of a terminal: what a user would see, and what a program writes to."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w") as stream:
        yield ours, stream
    os.close(ours)


def seen(end: int) -> str:
    """What has been written to the terminal."""
    os.set_blocking(end, False)
    try:
        return os.read(end, 1 << 16).decode()
    except (BlockingIOError, OSError):
        return ""


def test_long_run_shows_its_progress_on_a_terminal(
    terminal: tuple[int, IO[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "QUIET", 0.0)
    monkeypatch.setattr(progress, "PERIOD", 0.0)
    end, stream = terminal
    with progress.terminal_bar(stream) as reached:
        assert reached is not None
        reached(1.0, 4.0)
        assert re.search(r"25%.*1 of 4 s", seen(end))


def test_short_run_shows_no_progress(four_bar_file: Path, terminal: tuple[int, IO[str]]) -> None:
    end, stream = terminal
    done = subprocess.run(
        [sys.executable, "-m", "gelenk", "simulate", four_bar_file, "--stop", "0.1"],
        stdout=subprocess.DEVNULL, stderr=stream, timeout=60, check=True,
    )  # fmt: skip
    assert done.returncode == 0
    assert seen(end) == ""


def test_no_progress_is_shown_where_no_one_looks(tmp_path: Path) -> None:
    with (tmp_path / "log").open("w") as stream, progress.terminal_bar(stream) as reached:
        assert reached is None


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("../../evil", "___.._evil.fmu"),
        ("/etc/evil", "_etc_evil.fmu"),
        ("CON", "CON_.fmu"),
        ("nul.tar", "nul_.tar.fmu"),
        ("Com1", "Com1_.fmu"),
        ("LPT² .x", "LPT²_ .x.fmu"),
        ('a<b>c:d"e\\f|g?h*i', "a_b_c_d_e_f_g_h_i.fmu"),
        ("ends. .", "ends___.fmu"),
        ("-o", "_o.fmu"),
        ("..", "__.fmu"),
        ("ä" * 100, None),
        ("Getriebe 3, neu", None),
        ("console", None),
        ("COM10", None),
    ],
)
def test_export_keeps_to_the_folder_and_to_names_that_every_system_takes(
    name: str, file: str | None, four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    here = tmp_path / "a" / "b"
    here.mkdir(parents=True)
    (here / "scene.json").write_text(json.dumps({**four_bar.to_dict(), "name": name}))
    done = call("export", "scene.json", cwd=here)
    assert done.returncode == 0, done.stderr
    expected = file or f"{name}.fmu"
    assert {path.name for path in tmp_path.rglob("*.*")} == {"scene.json", expected}
    told_why = (
        f"name: {name!r} is not a valid file name on all systems; written to {expected}, "
        "use --output for another name\n"
    )
    assert done.stderr == (told_why if file else "")
    with zipfile.ZipFile(here / expected) as archive:
        stems = [part.split(".")[0].upper() for member in archive.namelist() for part in member.split("/")]
    assert not {"CON", "NUL", "COM1", "LPT2"} & {*stems}
    gelenk.simulate(here / expected, stop=0.01)


def test_a_device_of_windows_as_output_is_told(four_bar_file: Path, tmp_path: Path) -> None:
    done = call("export", four_bar_file, "-o", "aux.fmu", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr == "aux.fmu: 'aux' is the name of a device on Windows, where this file cannot exist\n"
