# SPDX-License-Identifier: BSD-3-Clause
"""Pages that compute, in Chromium: no requests; sliders and the mouse; faults in words."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.errors import UsageError
from gelenk.viewer import computing
from gelenk.viewer.page import COMPUTING

from .browser import Browser
from .cores import WITHOUT

LARGEST = 2.8e6  # bytes
needs_core = pytest.mark.skipif(not computing.has_core(), reason=WITHOUT)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    out = Browser()
    yield out
    out.close()


def opened(browser: Browser, page: Path) -> None:
    """Open a page and wait for the first frame that it has computed."""
    browser.open(page)
    browser.wait("return gelenk.computation.started && gelenk.frames > 2")


def row(name: str) -> str:
    """JavaScript that gets what a row of the settings consists of."""
    return f"const row = gelenk.computation.settings.rows.get({name!r});"


def choose(browser: Browser, name: str, value: float) -> None:
    """Type a number into a row of the settings."""
    browser.run(f"{row(name)} row.number.value = '{value}'; row.number.dispatchEvent(new Event('change'));")
    browser.wait(f"{row(name)} return !row.waiting")


@needs_core
def test_a_page_computes_without_requests(four_bar: gelenk.Scene, tmp_path: Path, browser: Browser) -> None:
    page = gelenk.view(four_bar, stop=2.0, computes=True).save(tmp_path / "four_bar.html")
    assert page.stat().st_size < LARGEST
    assert COMPUTING in page.read_text(encoding="utf-8")
    opened(browser, page)
    assert browser.run("return gelenk.playing")
    browser.wait("return gelenk.time > 0.5")
    browser.press(" ")
    assert not browser.run("return gelenk.playing")
    plant = gelenk.Simulation(four_bar)
    plant.initialize()
    time = browser.run("return gelenk.time")
    for k in range(round(time / four_bar.step)):
        plant.step_to((k + 1) * four_bar.step)
    header, *rows = browser.run("return Gelenk.csvOf(gelenk.live.recording)").splitlines()
    assert header.startswith("time,A.phi,")
    assert len(rows) == browser.run("return gelenk.frames")
    last = [float(number) for number in rows[-1].split(",")]
    assert last[:2] == pytest.approx([time, plant.output("A.phi")], rel=1e-5)
    _, p = plant.pose("coupler")
    assert browser.run("return gelenk.pose('coupler').p") == pytest.approx(p, abs=1e-5)
    assert browser.errors() == []
    assert browser.requests() == []


@needs_core
def test_sliders_and_steps(four_bar: gelenk.Scene, tmp_path: Path, browser: Browser) -> None:
    opened(browser, gelenk.view(four_bar, stop=1.0, computes=True).save(tmp_path / "four_bar.html"))
    browser.run("gelenk.pause()")
    browser.press("r")
    browser.wait("return gelenk.time === 0 && gelenk.frames === 1")
    browser.press(".")
    browser.wait(f"return gelenk.time === {four_bar.step}")
    choose(browser, "drive.tau", 12.0)
    assert browser.run("return gelenk.time") == four_bar.step  # an input changes the run itself
    choose(browser, "crank.m", 2.0)
    browser.wait("return gelenk.time === 0 && gelenk.frames === 1")
    choose(browser, "crank.m", -2.0)
    fault = browser.run(f"{row('crank.m')} return row.fault.hidden ? '' : row.fault.textContent")
    assert fault.startswith("crank.m: found -2")
    choose(browser, "crank.m", 3.0)
    assert browser.run(f"{row('crank.m')} return row.fault.hidden")
    browser.press("m")
    browser.wait("return !document.getElementById('return').disabled")
    browser.press(".")
    browser.press(".")
    browser.wait("return gelenk.frames === 3")
    browser.press("b")
    browser.wait("return gelenk.frames === 1 && gelenk.time === 0")
    browser.run("for (const id of ['save-csv', 'save-scene']) document.getElementById(id).click()")
    browser.wait("return Boolean(gelenk.computation.sceneText)")
    assert browser.errors() == []


@needs_core
def test_the_mouse_pulls_a_body(four_bar: gelenk.Scene, tmp_path: Path, browser: Browser) -> None:
    """To the right, where it would not go by itself within this time; the camera does not turn."""
    page = gelenk.view(four_bar, stop=1.0, computes=True)
    opened(browser, page.save(tmp_path / "four_bar.html"))
    browser.run("gelenk.pause()")
    browser.press("r")
    browser.wait("return gelenk.frames === 1")
    before = browser.run("return gelenk.project('rocker')")
    browser.drag(before, (before[0] + 150, before[1]), hold=1.5)
    browser.wait("return gelenk.time > 0.5")
    after = browser.run("return gelenk.project('rocker')")
    assert after[0] > before[0] + 5
    browser.wait(f"return gelenk.time > {browser.run('return gelenk.time')} + 0.3")  # without the pointer
    assert browser.run("return document.getElementById('notice').hidden")
    assert browser.errors() == []


@needs_core
def test_what_fails_is_said(tmp_path: Path, browser: Browser) -> None:
    """A run whose budget is exhausted stops with the message; names are text, never script."""
    attack = "<img src=x onerror='document.title=1'></script><script>document.title='run'</script>"
    source = {
        "gelenk": 1, "name": attack, "gravity": [0, 0, -9.81],
        "bodies": {"bob": {"mass": 1.0, "com": [1, 0, 0]}},
        "joints": {"A": {"type": "revolute", "parent": "ground", "child": "bob", "axis": [0, 1, 0]}},
        "parameters": ["A.stiffness"], "experiment": {"stop": 0.1}, "solver": {"max_evaluations": 1000},
    }  # fmt: skip
    opened(browser, gelenk.view(source, computes=True).save(tmp_path / "pendulum.html"))
    browser.run("gelenk.pause()")
    choose(browser, "A.stiffness", 1e14)
    browser.run("gelenk.play()")
    browser.wait("return !gelenk.playing && !document.getElementById('notice').hidden")
    assert len(browser.run("return document.getElementById('notice').textContent")) > 20
    assert browser.run("return document.title") == attack
    assert browser.errors() == []


@needs_core
def test_the_command_makes_a_page_that_computes(
    four_bar_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a scene, unless a run is wanted; without the core, the page of a run."""

    def computes(*options: str) -> bool:
        out = tmp_path / "page.html"
        done = CliRunner().invoke(
            app, ["view", str(four_bar_file), "--stop", "0.1", *options, "-o", str(out)]
        )
        assert done.exit_code == 0, done.output
        return 'id="core"' in out.read_text(encoding="utf-8")

    assert computes("--set", "drive.tau=2", "--degrees")
    assert not computes("--replay")
    assert not computes("--reactions")
    assert not computes("--with-set", "drive.tau=1")
    monkeypatch.setattr(computing, "_CORE", Path("nowhere"))
    assert not computes()


def test_without_the_core_it_is_said(four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computing, "_CORE", Path("nowhere"))
    with pytest.raises(UsageError, match="no core for pages that compute: `make page-core`"):
        gelenk.view(four_bar, stop=0.1, computes=True)


@needs_core
def test_what_a_page_cannot_compute_is_refused(four_bar: gelenk.Scene) -> None:
    with pytest.raises(UsageError, match="inputs: found functions of time, expected constants"):
        gelenk.view(four_bar, stop=0.1, inputs={"drive.tau": lambda t: t}, computes=True)
    with pytest.raises(UsageError, match="reactions, tolerance: not in pages that compute"):
        gelenk.view(four_bar, stop=0.1, tolerance=1e-8, reactions=True, computes=True)
    with pytest.raises(UsageError, match="found a result or several runs, expected a scene"):
        gelenk.view([four_bar, four_bar], stop=0.1, computes=True)
