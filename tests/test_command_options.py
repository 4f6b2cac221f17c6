# SPDX-License-Identifier: BSD-3-Clause
"""What all commands have: --json, --verbose, completion; and the messages that the package logs."""

from __future__ import annotations

import json
import logging
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import command_line
import programs
import pytest
from mechanisms import body, frame, joint, scene
from physics.nonsmooth.test_dead_centers import slider_crank

import gelenk
from gelenk.cli import command
from gelenk.simulation import progress

COMMANDS = dict(command_line.commands())


def call(*args: str | Path, cwd: Path, **env: str) -> subprocess.CompletedProcess[str]:
    return programs.gelenk(*args, cwd=cwd, env=env)


@pytest.fixture
def here(four_bar: gelenk.Scene, tmp_path: Path) -> Path:
    """A folder with a scene, an FMU, a run and a robot."""
    four_bar.save(tmp_path / "s.yaml")
    gelenk.export_fmu(four_bar, tmp_path / "x.fmu")
    gelenk.simulate(four_bar, stop=0.01).save(tmp_path / "r.csv")
    link = '<link name="a"><inertial><mass value="1"/></inertial></link>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{link}</robot>')
    return tmp_path


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_common_options(name: str) -> None:
    options = {option for p in COMMANDS[name].params for option in p.opts}
    assert {"--json", "--verbose", "-v"} <= options


RESULTS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "export": (["s.yaml", "-o", "y.fmu"], {"file": "y.fmu", "platforms": ["linux64"], "notes": []}),
    "check": (["s.yaml"], {"degrees_of_freedom": 1, "rank": 2, "inputs": {"drive.tau": "N.m"}}),
    "inspect": (["s.yaml"], {"name": "FourBar"}),
    "equations": (["s.yaml", "-o", "s.c"], {"file": "s.c", "language": "c", "notes": []}),
    "assemblies": (["s.yaml"], {}),
    "import": (["r.urdf", "-o", "r.yaml"], {"file": "r.yaml", "name": "r"}),
    "simulate": (["x.fmu", "--stop", "0.01"], {"file": None, "rows": 11, "stop": 0.01, "events": []}),
    "sweep": (["s.yaml", "--vary", "crank.m=1,1.1", "--outputs", "A.w:max", "--stop", "0.01"],
              {"file": None, "runs": 2, "failed": 0}),
    "linearize": (["s.yaml"], {"name": "FourBar", "inputs": ["drive.tau"]}),
    "equilibrium": (["s.yaml"], {"name": "FourBar"}),
    "modes": (["s.yaml"], {"name": "FourBar"}),
    "plot": (["r.csv"], {"file": "r.png", "rows": 11, "stop": 0.01}),
    "view": (["s.yaml", "--stop", "0", "-o", "s.html"], {"file": "s.html"}),
}  # fmt: skip


def test_all_but_the_long_commands_are_tried() -> None:
    assert {*RESULTS} == {name for name in COMMANDS if not name.startswith("chart ")}


@pytest.mark.parametrize("name", RESULTS)
def test_results_are_one_document(name: str, here: Path) -> None:
    if name == "import":
        pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")
    arguments, expected = RESULTS[name]
    done = call(name, *arguments, "--json", cwd=here)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert {key: found[key] for key in expected} == expected
    if "bytes" in found:
        assert found["bytes"] == (here / found["file"]).stat().st_size


def test_the_document_of_a_run_has_its_extremes_and_on_request_its_signals(here: Path) -> None:
    run = gelenk.simulate(here / "s.yaml", stop=0.1, inputs={"drive.tau": 3.0})
    arguments = ("simulate", "s.yaml", "--stop", "0.1", "--set", "drive.tau=3", "--json")
    found = json.loads(call(*arguments, cwd=here).stdout)
    w = run["A.w"]
    assert found["outputs"]["A.w"] == {
        "unit": "rad/s", "start": w[0], "min": w.min(), "max": w.max(), "end": w[-1],
    }  # fmt: skip
    assert "signals" not in found
    signals = json.loads(call(*arguments, "--output", "-", cwd=here).stdout)["signals"]
    assert signals == {name: run[name].tolist() for name in ("time", *run.names)}


@pytest.mark.parametrize(
    ("arguments", "code", "kind", "message"),
    [
        (["check", "none.yaml"], 1, "MissingFileError", "none.yaml: no such file or directory"),
        (["check", "s.txt"], 1, "SceneError", "s.txt: found the ending .txt"),
        (["simulate", "s.yaml", "--stop", "-1"], 1, "UsageError", "stop: found -1.0 s, expected 0 or more"),
        (["simulate", "s.yaml", "--stip", "1"], 2, "UsageError", "--stip"),
        (["simulate"], 2, "UsageError", "SCENE|FMU"),
        (["chart", "stability", "none"], 1, "UsageError", "none: no such scene of the map"),
    ],
)
def test_errors_are_one_document_and_keep_their_exit_code(
    arguments: list[str], code: int, kind: str, message: str, here: Path
) -> None:
    (here / "s.txt").touch()
    done = call(*arguments, "--json", cwd=here)
    assert done.returncode == code == call(*arguments, cwd=here).returncode
    error = json.loads(done.stdout)["error"]
    assert error["type"] == kind
    assert message in error["messages"][0]
    assert done.stderr == ""


def test_all_faults_of_a_scene_are_in_the_document(here: Path) -> None:
    (here / "s.yaml").write_text("gelenk: 1\nbodies: {a: {mass: -1, com: [0, 0]}}\njoints: {}\n")
    messages = json.loads(call("check", "s.yaml", "--json", cwd=here).stdout)["error"]["messages"]
    fields = {message.partition(": found")[0] for message in messages}
    assert fields >= {"s.yaml:2: bodies.a.mass", "s.yaml:2: bodies.a.com"}


def test_a_run_that_fails_has_its_rows_and_its_error_in_one_document(tmp_path: Path) -> None:
    """A driven slider-crank meets a limit where nothing can stop it."""
    source = slider_crank(0.0, lower=1.4)
    source["joints"]["A"]["start"] = {"phi": 0.0}
    source["constraints"] = {"drive": {"type": "motion", "joint": "A", "polynomial": [0, 1.0]}}
    (tmp_path / "s.json").write_text(json.dumps(source))
    for arguments in (["simulate", "s.json", "--step", "0.01"], ["view", "s.json", "-o", "s.html"]):
        done = call(*arguments, "--stop", "1", "--json", cwd=tmp_path)
        assert done.returncode == 1
        found = json.loads(done.stdout)
        assert found["error"]["type"] == "StepError"
        assert "where no force can stop it" in found["error"]["messages"][0]
        assert done.stderr == ""
        assert found.get("rows") in (53, None)  # until 0.52 s
    assert (tmp_path / "s.html").exists()


def test_documents_have_no_numbers_that_json_lacks() -> None:
    data = {"a": [math.nan, 1.0, (math.inf, {"b": -math.inf})], "c": "NaN", "d": True}
    assert json.loads(command.document(data)) == {
        "a": [None, 1.0, [None, {"b": None}]],
        "c": "NaN",
        "d": True,
    }


def bouncing() -> gelenk.Scene:
    """A mass that falls onto a stop and rests there."""
    slide = joint("prismatic", frame("ground"), frame("mass"), axis=[0, 0, 1], limit={"lower": -0.1})
    return gelenk.load(scene({"mass": body(1.0)}, {"s": slide}, gravity=[0, 0, -9.81]))


def test_verbose_commands_report_events_on_stderr(tmp_path: Path) -> None:
    bouncing().save(tmp_path / "s.yaml")
    arguments = ("simulate", "s.yaml", "--stop", "0.5", "--step", "0.01", "-o", "r.csv")
    quiet, verbose, all_messages = (call(*arguments, *v, cwd=tmp_path) for v in ((), ("-v",), ("-vv",)))
    assert quiet.stdout == verbose.stdout == all_messages.stdout
    assert quiet.stderr == ""
    lines = verbose.stderr.splitlines()
    assert lines[0].endswith("0 to 0.5 s in 50 steps, 5 outputs")
    t = math.sqrt(2 * 0.1 / 9.81)
    assert any(line.startswith(f"t = {t:.4f}"[:9]) and "lower limit" in line for line in lines[1:])
    assert not any("solver.evaluations" in line for line in lines)
    assert all_messages.stderr.startswith(verbose.stderr)
    assert "solver.evaluations = " in all_messages.stderr


def test_events_of_an_fmu_are_logged_by_the_fmu(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """As often as the scene itself reports them."""
    fmu = gelenk.export_fmu(bouncing(), tmp_path / "x.fmu")
    with caplog.at_level(logging.INFO, "gelenk"):
        gelenk.simulate(fmu, stop=0.5)
    events = gelenk.simulate(bouncing(), stop=0.5).events
    messages = [r.getMessage() for r in caplog.records if "lower limit" in r.getMessage()]
    assert len(messages) == len(events) > 0


def test_messages_are_logged_and_never_printed(
    caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    with caplog.at_level(logging.DEBUG, "gelenk"):
        found = gelenk.simulate(bouncing(), stop=0.5)
    events = [r for r in caplog.records if r.getMessage().startswith("t = ")]
    assert len(events) == len(found.events) > 0
    assert {r.levelno for r in events} == {logging.INFO}
    counts = [r.getMessage() for r in caplog.records if r.levelno == logging.DEBUG]
    assert any(text.startswith("solver.evaluations = ") for text in counts)
    assert all(r.name.startswith("gelenk.") for r in caplog.records)
    gelenk.simulate(bouncing(), stop=0.5)
    assert capsys.readouterr() == ("", "")


def test_logging_changes_no_bits(caplog: pytest.LogCaptureFixture) -> None:
    plain = gelenk.simulate(bouncing(), stop=0.5).csv()
    with caplog.at_level(logging.DEBUG, "gelenk"):
        assert gelenk.simulate(bouncing(), stop=0.5).csv() == plain


def test_a_command_restores_the_logger() -> None:
    logger = logging.getLogger("gelenk")
    before = (logger.level, list(logger.handlers))
    with command.log_messages(2):
        assert logger.isEnabledFor(logging.DEBUG)
    assert (logger.level, list(logger.handlers)) == before


def test_progress_is_drawn_on_request(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], four_bar: gelenk.Scene
) -> None:
    pytest.importorskip("tqdm", reason="tqdm (the extra progress) is not installed")
    monkeypatch.setattr(progress, "QUIET", 0.0)
    monkeypatch.setattr(progress, "PERIOD", 0.0)
    gelenk.simulate(four_bar, stop=0.1, progress=True)
    assert "of 0.1 s" in capsys.readouterr().err
    gelenk.simulate(four_bar, stop=0.1, progress=False)
    assert capsys.readouterr().err == ""


def test_progress_without_tqdm_is_refused(monkeypatch: pytest.MonkeyPatch, four_bar: gelenk.Scene) -> None:
    monkeypatch.setitem(sys.modules, "tqdm", None)
    with pytest.raises(gelenk.UsageError, match=r"pip install 'gelenk\[progress\]'"):
        gelenk.simulate(four_bar, stop=0.1, progress=True)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("simu", ["simulate"]),
        ("simulate s.yaml --set A.ph", ["A.phi_start="]),
        ("simulate x.fmu --set dri", ["drive.tau="]),
        ("simulate s.yaml --set solver.integrator=e", ["solver.integrator=erk", "solver.integrator=euler"]),
        ("simulate s.yaml --set assembly.tol", ["assembly.tolerance="]),
        ("simulate --stop 1 s.yaml --outputs C.", ["C.phi", "C.w", "C.a"]),
        ("simulate s.yaml --integrator cv", ["cvode", "cvode-adams"]),
        ("simulate s.yaml --formulation index", ["index3"]),
        ("simulate s.yaml --without pl", ["planar"]),
        ("simulate none.yaml --set A.", []),
        ("simulate wrong.yaml --outputs A.", []),
        ("simulate s.yaml --set unknown=", []),
        ("simulate --set A.", []),
        ("export s.yaml --platforms linux64,w", ["linux64,win64"]),
        ("assemblies s.yaml --body c", ["crank", "coupler"]),
        ("linearize s.yaml --friction s", ["sliding"]),
        ("linearize s.yaml --at D.p", ["D.phi="]),
        ("equilibrium s.yaml --solve-for d", ["drive.tau"]),
        ("plot r.csv B", ["B.phi", "B.w", "B.a"]),
        ("plot x.fmu A.a", ["A.a"]),
        ("chart stability --method baumgarte+e", ["baumgarte+erk"]),
    ],
)
def test_completion_of_a_line(line: str, expected: list[str], here: Path) -> None:
    """As the script of bash asks for it; nothing is written to stderr, which a user would see in the line."""
    (here / "wrong.yaml").write_text("gelenk: 1\nbodies: 3\n")
    words = ["gelenk", *line.split()]
    done = call(cwd=here, COMP_WORDS=" ".join(words), COMP_CWORD=str(len(words) - 1),
                _GELENK_COMPLETE="complete_bash")  # fmt: skip
    assert done.stdout.split() == expected
    assert done.stderr == ""


def test_completion_can_be_installed(here: Path) -> None:
    found = call("--help", cwd=here).stdout
    assert "--install-completion" in found
    script = call(cwd=here, _GELENK_COMPLETE="source_bash").stdout
    assert "_GELENK_COMPLETE=complete_bash" in script


def test_the_page_of_the_command_line_lists_all_options() -> None:
    _, inside, _ = command_line.parts(command_line.PAGE.read_text(encoding="utf-8"))
    assert inside == command_line.reference(), "run python tests/command_line.py"
