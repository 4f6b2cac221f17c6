# SPDX-License-Identifier: BSD-3-Clause
"""What FMUs log while Gelenk and fmpy run them in one process."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from ctypes import CFUNCTYPE, c_char_p, c_int, c_void_p
from pathlib import Path

import pytest
from mechanisms import Scene, body, frame, joint, scene
from samples import thorough_beyond

import gelenk
from gelenk import _core


def hanging() -> Scene:
    """A damped pendulum [0.3 m, 1 kg] that hangs at 0 rad."""
    return scene(
        {"rod": body(1.0, (0.3, 0, 0), (0.01, 0.02, 0.02))},
        {"A": joint("revolute", frame("ground"), frame("rod"), axis=[0, 1, 0], damping=0.2)},
        motors={"drive": {"joint": "A"}},
    )


BOTH = """
import gc, sys
import fmpy, gelenk
fmu, order = sys.argv[1], sys.argv[2]

def ours():
    gelenk.equilibrium(fmu)
    assert gelenk.linearize(fmu).nstates == 2
    gelenk.simulate(fmu, stop=0.02)

def fmpys():  # the FMU tells each change of its mode
    fmpy.simulate_fmu(fmu, stop_time=0.02, debug_logging=True)

for _ in range(3):
    for run in (ours, fmpys) if order == "ours first" else (fmpys, ours):
        run()
        gc.collect()
        rubbish = [bytes(100 + k) for k in range(2000)]  # where the freed callbacks were
    fmpys()
print("done")
"""


@pytest.mark.parametrize("order", thorough_beyond(["ours first", "fmpy first"], ["fmpy first"]))
def test_fmpy_runs_what_logs_after_gelenk_has_closed_its_plants(order: str, tmp_path: Path) -> None:
    """In fmpy one pointer leads to the logger of a whole process: it must not be left with one of ours."""
    fmu = gelenk.export_fmu(hanging(), tmp_path / "x.fmu")
    run = subprocess.run(
        [sys.executable, "-c", BOTH, str(fmu), order],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert run.returncode == 0, (run.returncode, run.stderr)
    assert run.stdout.endswith("done\n")
    assert run.stdout.count("initialization mode") >= 6


def test_the_logger_writes_out_what_comes_with_a_message() -> None:
    """Messages of other tools' FMUs are formats with arguments; Gelenk's double their percent signs."""
    log = _core.FmuLog()
    logger = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_int, c_char_p)(log.logger)
    logger(log.environment, b"x", 1, b"all", b"%d of %s", 7, b"nine")
    logger(log.environment, b"x", 3, b"all", b"100 %% of \xff", 0, b"")
    logger(log.environment, b"x", 2, b"all", b"%s", 0, b"a" * 5000)
    logger(None, b"x", 1, b"all", b"nobody listens", 0, b"")
    logger(log.environment, b"x", 1, b"all", None, 0, b"")
    assert log.take()[:2] == [(1, b"7 of nine"), (3, b"100 % of \xff")]
    assert log.take() == []


def test_two_plants_hear_their_own_fmu_only(tmp_path: Path) -> None:
    """Of two that are open at a time, the one that fails is told what is the matter with it."""
    from gelenk.simulation.fmu_plant import FmuPlant

    first, second = (FmuPlant(gelenk.export_fmu(hanging(), tmp_path / f"{name}.fmu")) for name in "ab")
    try:
        with pytest.raises(gelenk.UsageError, match=r"solver\.tolerance: found 2, expected between"):
            first.set_parameters({"solver.tolerance": 2.0})
        second.set_parameters({"solver.tolerance": 1e-7})
    finally:
        first.close()
        second.close()


def test_a_library_that_cannot_be_loaded_leaves_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = gelenk.export_fmu(hanging(), tmp_path / "whole.fmu")
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(whole) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            target.writestr(name, b"no library" if name.endswith(".so") else source.read(name))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(gelenk.UsageError, match="Failed to load shared library"):
        gelenk.simulate(broken, stop=0.1)
    assert Path.cwd() == tmp_path
