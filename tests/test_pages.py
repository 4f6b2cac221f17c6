# SPDX-License-Identifier: BSD-3-Clause
"""Commands, programs and scenes of all pages run as printed, where there is only what the page says."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path

import programs
import pytest
from pages import ROOT, WITH_CODE, blocks, commands, create_files, printed, shown

import gelenk

NO_BROWSER = {"BROWSER": "true", "MPLBACKEND": "Agg"}  # the program `true` is what opens pages
# What a live view waits for: somebody who reads its frames until they end.
READER = "import sys, urllib.request\nurllib.request.urlopen(sys.argv[1] + 'frames').read()\n"

# Commands that take minutes.
LONG = {"docs/stability.md", "docs/work-precision.md"}
WITH_COMMANDS = [page for page in WITH_CODE if commands(ROOT / page)]
GALLERY = [page for page in WITH_CODE if page.startswith("docs/gallery/")]

# The Python of these pages is run by tests that also compare its numbers with those of the page.
ELSEWHERE = {
    "README.md": "test_readme.py",
    "docs/assembly.md": "test_readme.py",
    "docs/gradients.md": "gradients/test_page.py",
    "docs/howto-bearings.md": "test_howtos.py",
    "docs/linearization.md": "test_readme.py",
    "docs/modes.md": "test_readme.py",
    "docs/sweeps.md": "sweeps/test_page.py",
    "docs/tutorial-gripper.md": "test_tutorials.py",
    "docs/tutorial-lqr.md": "test_tutorials.py",
    "docs/tutorial-stiction.md": "test_tutorials.py",
    "docs/tutorial-vehicle.md": "test_tutorials.py",
    "docs/tutorial-wheels.md": "test_tutorials.py",
}
LIVE = "docs/viewer.md"
WITH_PYTHON = [page for page in WITH_CODE if blocks(ROOT / page, "python")]


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=pytest.mark.study) if page in LONG else page for page in WITH_COMMANDS]
)
def test_commands_of_a_page_print_what_it_shows(page: str, empty_folder: Path) -> None:
    """A command after which nothing is shown only has to succeed."""
    create_files(ROOT / page, empty_folder)
    for command, expected in commands(ROOT / page):
        program, first = command.split()[:2]
        if program == "gelenk":
            code, text = printed(command, empty_folder, **NO_BROWSER)
            assert shown(expected).fullmatch(text) if expected else code == 0, f"{command} printed:\n{text}"
        elif program == "make":
            assert re.search(rf"^{first}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        elif program == "python":
            assert importlib.util.find_spec(command.split()[2]) is not None, command
        else:
            assert command == "source .venv/bin/activate", command


@pytest.mark.parametrize("page", [page for page in WITH_PYTHON if page not in ELSEWHERE])
def test_python_of_a_page_runs_as_a_script(page: str, empty_folder: Path) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    create_files(ROOT / page, empty_folder)
    code = "\n".join(blocks(ROOT / page, "python"))
    if page == LIVE:
        assert "range(5000)" in code  # steps of 1 ms, held to the clock
        code = code.replace("range(5000)", "range(200)")
    Path("page.py").write_text(code, encoding="utf-8")
    Path("reader.py").write_text(READER, encoding="utf-8")
    done = programs.run("page.py", env=NO_BROWSER | {"BROWSER": f"{sys.executable} reader.py %s &"})
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", ELSEWHERE)
def test_python_of_the_other_pages_is_run_by_other_tests(page: str) -> None:
    assert page in WITH_PYTHON
    assert Path(page).name in (ROOT / "tests" / ELSEWHERE[page]).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "page",
    [page if "four_bar" in page else pytest.param(page, marks=pytest.mark.study) for page in GALLERY],
)
def test_command_of_the_gallery_shows_its_mechanism(page: str, empty_folder: Path) -> None:
    create_files(ROOT / page, empty_folder)
    (command,) = blocks(ROOT / page, "sh")
    code, text = printed(command.replace("\\\n", " "), empty_folder, **NO_BROWSER)
    assert code == 0, text


def test_scene_at_the_beginning_of_the_readme_is_one_screen_and_moves() -> None:
    (scene,) = blocks(ROOT / "README.md", "yaml")
    assert len(scene.splitlines()) <= 15
    above = (ROOT / "README.md").read_text(encoding="utf-8").partition(scene)[0]
    assert len(above.splitlines()) <= 20
    assert all(len(line) <= 120 for line in scene.splitlines())
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    start = plant.output("A.phi")
    plant.step_to(0.5)
    assert start == 1.5  # rad: kept exactly
    assert abs(plant.output("A.phi") - start) > 0.1  # rad


def test_the_readme_begins_with_the_purpose_and_two_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    title, purpose, block = text.split("\n\n")[:3]
    assert title == "# Gelenk"
    assert purpose.startswith("Gelenk ")
    assert re.findall(r"^make (\w+)", block, re.MULTILINE) == ["demo", "test"]
