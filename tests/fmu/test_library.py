# SPDX-License-Identifier: BSD-3-Clause
"""The binary: what it shows to the outside and what it needs from there."""

from __future__ import annotations

import platform
import re
import shutil
import subprocess
import sys
from ctypes import CDLL
from pathlib import Path

import fmpy
import pytest

import gelenk

from .plants import crank_rocker, gyroscope

HEADERS = Path(fmpy.__file__).parent / "c-code"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    found = gelenk.export_fmu(crank_rocker(), folder / "x.fmu")
    fmpy.extract(str(found), str(folder / "extracted"))
    return next((folder / "extracted" / "binaries" / "linux64").glob("*.so"))


def tool(name: str, *arguments: str) -> str:
    program = shutil.which(name)
    if program is None:
        pytest.skip(f"{name} (binutils) is not installed")
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def test_exactly_the_functions_of_fmi_are_exported(library: Path) -> None:
    listing = tool("nm", "-D", "--defined-only", str(library))
    found = {line.split()[-1].split("@")[0] for line in listing.splitlines()}
    declared = r"^\s*FMI{0}_Export fmi{0}\w+\s+(fmi{0}\w+);"
    wanted = set()
    for version, count in ((2, 44), (3, 75)):
        header = (HEADERS / f"fmi{version}Functions.h").read_text()
        functions = set(re.findall(declared.format(version), header, re.MULTILINE))
        assert len(functions) == count
        wanted |= functions
    assert found == wanted
    for name in wanted:
        assert hasattr(CDLL(str(library)), name)


def test_only_the_c_library_is_needed(library: Path) -> None:
    needed = set(re.findall(r"\(NEEDED\).*\[(.*?)\]", tool("readelf", "-d", str(library))))
    assert needed <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2"}


def test_the_c_library_may_be_as_old_as_the_documentation_says(library: Path, root: Path) -> None:
    said = re.search(r"glibc (\d+)\.(\d+) or newer", (root / "docs" / "fmu.md").read_text())
    assert said
    needs = re.findall(r"Name: GLIBC_(\S+)", tool("readelf", "-V", str(library)))
    assert len(needs) > 2
    versions = [tuple(map(int, version.split("."))) for version in needs]
    assert max(versions)[:2] <= (int(said[1]), int(said[2])), needs


@pytest.mark.parametrize("which", ["FMU", "Python module"])
def test_nothing_that_is_written_can_be_run_or_leads_anywhere(library: Path, which: str) -> None:
    """Full RELRO: addresses of functions are resolved when it is loaded, and read-only from then on."""
    if which == "Python module":
        library = Path(gelenk._core.__file__)
    segments = tool("readelf", "-lW", str(library))
    flags = dict(re.findall(r"^\s+(GNU_\w+|LOAD)\s(?:\s*0x\w+){5}\s+([RWE ]{3})\s", segments, re.MULTILINE))
    assert "GNU_RELRO" in flags
    assert flags["GNU_STACK"].split() == ["RW"]
    assert not re.search(r"LOAD\s(?:\s*0x\w+){5}\s+RWE", segments)
    dynamic = tool("readelf", "-d", str(library))
    assert "BIND_NOW" in dynamic
    assert "TEXTREL" not in dynamic


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the instructions are those of x86-64")
def test_calls_and_returns_may_be_enforced(library: Path) -> None:
    """Control-flow enforcement: a shadow stack for returns, landing pads (endbr64) for indirect calls."""
    assert re.search(r"x86 feature:.*\bSHSTK\b", tool("readelf", "-nW", str(library)))
    for name in ("fmi2Instantiate", "fmi2DoStep", "fmi2GetReal", "fmi2FreeInstance", "fmi3DoStep"):
        listing = tool("objdump", "-d", "--no-show-raw-insn", f"--disassemble={name}", str(library))
        first = re.search(rf"<{name}.*>:\n\s*[0-9a-f]+:\s+(\w+)", listing)
        assert first, name
        assert first[1] == "endbr64", name


def test_what_reads_bytes_of_others_is_checked_as_it_runs(library: Path) -> None:
    """Stack protector and _FORTIFY_SOURCE, as far as sources use what these look at."""
    wanted = tool("nm", "-D", "--undefined-only", str(library))
    assert "__stack_chk_fail" in wanted
    assert re.search(r"__\w+_chk\b", wanted)


def test_the_library_does_not_grow_by_accident(library: Path) -> None:
    """It has 7.52 MB. Of these programs for scenes take 0.5 MB, linear models in contact 0.12."""
    assert library.stat().st_size < 7.9e6


RUN_BOTH = """
import sys
from fmu.host import Fmu, Slave
first, second = Fmu(sys.argv[1]), Fmu(sys.argv[2])
def run(fmu, name, value):
    s = Slave(fmu).start()
    s.set({name: value})
    return s
a = run(first, "drive.tau", 2.0)
alone_a = a.run(10)
b = run(second, "push.f[1]", 0.5)
alone_b = b.run(10)
a, b = run(first, "drive.tau", 2.0), run(second, "push.f[1]", 0.5)
both_a, both_b = [], []
for k in range(10):
    both_a += a.run(1, first=k)
    both_b += b.run(1, first=k)
assert both_a == alone_a
assert both_b == alone_b
wrong = Slave(first, guid=second.description.guid)
assert wrong.component is None
a.free()
b.run(1, first=10)
print("done")
"""


def test_two_different_fmus_in_one_process_do_not_touch_each_other(tmp_path: Path) -> None:
    folders = []
    for plant in (crank_rocker, gyroscope):
        found = gelenk.export_fmu(plant(), tmp_path / f"{plant.__name__}.fmu")
        folders.append(fmpy.extract(str(found), str(tmp_path / plant.__name__)))
    tests = Path(__file__).resolve().parent.parent
    run = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(tests)!r})\n{RUN_BOTH}", *folders],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == "done\n"
