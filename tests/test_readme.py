# SPDX-License-Identifier: BSD-3-Clause
"""What README, docs and docstrings say is so: their commands and examples are run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import json
import pkgutil
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import control
import element_tables
import joint_table
import pytest
from pages import blocks, executed

import gelenk
from gelenk import _core

MODULES = [m.name for m in pkgutil.walk_packages(gelenk.__path__, "gelenk.") if m.name != "gelenk.__main__"]


@pytest.mark.usefixtures("empty_folder")
def test_python_of_the_readme_runs(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    executed(root / "README.md")
    angle, gap, torque = map(float, capsys.readouterr().out.split())
    assert abs(angle - 1.5) > 0.1  # rad: it moved
    assert gap < 1e-10  # m: the projection's own bound
    assert torque == pytest.approx(12.9, abs=0.05)  # N m, as the page says
    assert Path("run.csv").read_text().startswith("time,A.phi,D.phi,constraints.position\n")


@pytest.mark.usefixtures("folder")
def test_controller_of_the_linearization_page_holds_the_pole(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names: dict[str, object] = {}
    block = blocks(root / "docs" / "linearization.md", "python")[0]
    exec(compile(block, "linearization.md", "exec"), names)
    labels, growth, most, rest = capsys.readouterr().out.splitlines()
    assert labels == "('track.s', 'hinge.phi', 'track.v', 'hinge.w')"
    assert float(growth) == pytest.approx(5.24, abs=0.005)  # as the page says
    assert float(most) == pytest.approx(20, abs=1e-3)  # degrees: it falls for the first step, of 1 ms
    # The slowest pole is at -1.007 1/s: exp(-6) of the first 0.35 rad, of which the cart's way is the most.
    assert float(rest) < 0.35 * 2.5e-3
    assert isinstance(names["plant"], control.StateSpace)
    block = blocks(root / "docs" / "linearization.md", "python")[1]
    exec(compile(block, "linearization.md", "exec"), names)
    shown = [line.rpartition("  # ")[2] for line in block.splitlines() if line.startswith("print")]
    assert capsys.readouterr().out.splitlines() == shown
    assert isinstance(names["angle"], control.StateSpace)


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("error::gelenk.OperatingPointWarning")
def test_trim_of_the_linearization_page_is_a_point_to_linearize_about(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names: dict[str, Any] = {"gelenk": gelenk}
    block = blocks(root / "docs" / "linearization.md", "python")[2]
    exec(compile(block, "linearization.md", "exec"), names)
    assert capsys.readouterr().out.endswith("}\n4\n")
    assert set(names["held"].inputs) == {"motor_left.tau", "motor_right.tau"}
    assert all(abs(torque) > 0.01 for torque in names["held"].inputs.values())  # N m: they carry


@pytest.mark.filterwarnings("error::gelenk.OperatingPointWarning")
def test_friction_of_the_linearization_page(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    block = blocks(root / "docs" / "linearization.md", "python")[3]
    exec(compile(block, "linearization.md", "exec"), {"gelenk": gelenk})
    for line, printed in zip(
        [line for line in block.splitlines() if line.startswith("print")],
        capsys.readouterr().out.splitlines(),
        strict=True,
    ):
        shown = line.rpartition("  # ")[2].split(":")[0]
        for expected, found in zip(shown.split(), printed.split(), strict=True):
            word = expected.rstrip(",")
            if word.replace(".", "").isdigit():
                assert float(found.rstrip(",")) == pytest.approx(float(word), rel=1e-3)  # as many digits
            else:
                assert found == expected


def test_steady_motion_of_the_linearization_page(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {"gelenk": gelenk}
    block = blocks(root / "docs" / "linearization.md", "python")[5]
    exec(compile(block, "linearization.md", "exec"), names)
    first, advancing, spin = capsys.readouterr().out.splitlines()
    tilt, torque = map(float, first.split())
    assert tilt == pytest.approx(0.976, abs=5e-4)  # as the page says
    assert torque == pytest.approx(1.5, rel=1e-9)
    assert advancing == "{'shaft_bearing.phi': 5.0}"
    assert float(spin) == pytest.approx(4.48, abs=0.005)
    assert len(names["plant"].poles()) == 4


def test_contacts_of_the_linearization_page(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, expected in ((4, [1 / 3, 4, 18.0]), (6, [6, 3.946, 10])):
        block = blocks(root / "docs" / "linearization.md", "python")[number]
        exec(compile(block, "linearization.md", "exec"), {"gelenk": gelenk})
        found = [float(word) for word in capsys.readouterr().out.split()]
        assert found == pytest.approx(expected, abs=5e-4)  # as the page says


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("error::gelenk.OperatingPointWarning")
def test_python_of_the_modes_page_runs(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    names: dict[str, Any] = {}
    (block,) = blocks(root / "docs" / "modes.md", "python")
    exec(compile(block, "modes.md", "exec"), names)
    out = capsys.readouterr().out
    assert out.startswith("FourBar at t = 0 s: stable\n")
    assert names["swing"].kind == "damped"
    assert Path("swing.gif").stat().st_size > 10_000


@pytest.mark.usefixtures("folder")
def test_python_of_the_assembly_page_takes_the_other_branch(root: Path) -> None:
    names: dict[str, Any] = {}
    (block,) = blocks(root / "docs" / "assembly.md", "python")
    exec(compile(block, "assembly.md", "exec"), names)
    plant = gelenk.Simulation(names["scene"])
    plant.initialize()
    assert plant.output("C.phi") == pytest.approx(-1.36701, abs=5e-6)  # as the page says


def test_cmake_of_the_readme_is_what_the_user_test_builds(root: Path) -> None:
    tested = (root / "tests" / "cmake_user" / "CMakeLists.txt").read_text().splitlines()
    for line in blocks(root / "README.md", "cmake")[0].splitlines():
        assert line in tested


def test_targets_of_make_are_there(root: Path) -> None:
    makefile = (root / "Makefile").read_text()
    for target in re.findall(r"^make (\w+)", blocks(root / "README.md", "sh")[0], re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)


PAGES = (
    "scene-format", "reductions", "methods", "linearization", "modes", "assembly", "tutorial-lqr",
    "tutorial-wheels", "tutorial-stiction", "tutorial-gripper", "command-line", "viewer",
    "internals/architecture", "internals/notation", "gallery/README", "sweeps", "gradients",
    "nonsmooth-laws", "located-events", "time-stepping", "cone-solvers", "nonsmooth-measurements",
)  # fmt: skip


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", *(f"docs/{page}.md" for page in PAGES)])
def test_links_lead_somewhere(page: str, root: Path) -> None:
    for link in re.findall(r"\]\(([^)#:]+)\)", (root / page).read_text(encoding="utf-8")):
        assert (root / page).parent.joinpath(link).exists(), link


def test_page_of_the_reductions_has_all_of_them_and_every_scene(root: Path) -> None:
    text = (root / "docs" / "reductions.md").read_text(encoding="utf-8")
    described = re.findall(r"^\| `(\w+)` \| [A-Z]", text, re.MULTILINE)
    assert described == list(gelenk.model.inspection.REDUCTIONS)
    for scene in (root / "scenes").glob("*.yaml"):
        assert text.count(f"| `{scene.name}` |") == 2, "run make reductions"
    (solver,) = blocks(root / "docs" / "reductions.md", "yaml")
    gelenk.load((root / "scenes" / "pendulum.yaml").read_text(encoding="utf-8") + solver)


def test_page_of_the_methods_has_all_of_them(root: Path) -> None:
    text = (root / "docs" / "methods.md").read_text(encoding="utf-8")
    solver = json.loads(_core.scene_schema())["properties"]["solver"]["properties"]
    for name in solver["formulation"]["enum"]:
        assert f"\n## {name}\n" in text
        assert f"[{name}](#{name})" in text
    for name in solver["integrator"]["enum"]:
        assert name == "auto" or f"\n**{name}**" in text or f"`{name}`" in text, name


def test_joint_table_of_the_format_page_is_the_registrys(root: Path) -> None:
    _, inside, _ = joint_table.section((root / "docs" / "scene-format.md").read_text(encoding="utf-8"))
    assert inside == joint_table.table(), "run python tests/joint_table.py"


@pytest.mark.parametrize("section", element_tables.SECTIONS)
def test_element_tables_of_the_format_page_are_the_registrys(root: Path, section: str) -> None:
    page = (root / "docs" / "scene-format.md").read_text(encoding="utf-8")
    _, inside, _ = element_tables.parts(page, section)
    assert inside == element_tables.table(section), "run python tests/element_tables.py"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ["gelenk", *MODULES])
def test_docstring_examples_run(name: str, four_bar: gelenk.Scene) -> None:
    if name == "gelenk.io.urdf":
        pytest.importorskip("yourdfpy", reason="yourdfpy (the extra urdf) is not installed")
    module = importlib.import_module(name)
    result = doctest.testmod(module, extraglobs={"gelenk": gelenk, "four_bar": four_bar})
    assert result.failed == 0


def public_functions() -> dict[str, Callable[..., Any]]:
    """Functions and methods of what `from gelenk import *` gives."""
    found: dict[str, Callable[..., Any]] = {}
    for name in gelenk.__all__:
        thing = getattr(gelenk, name)
        if inspect.isfunction(thing):
            found[name] = thing
        elif inspect.isclass(thing) and not issubclass(thing, Exception):
            methods = inspect.getmembers(thing, inspect.isfunction)
            found |= {f"{name}.{n}": f for n, f in methods if not n.startswith("_")}
    return found


SPEAK_FOR_THEMSELVES = {"self", "name", "path", "value"}


@pytest.mark.parametrize("name", public_functions())
def test_every_public_argument_is_documented(name: str) -> None:
    function = public_functions()[name]
    doc = inspect.getdoc(function) or ""
    arguments = set(inspect.signature(function).parameters) - SPEAK_FOR_THEMSELVES
    assert doc
    assert [n for n in arguments if not re.search(rf"\b{n}\b", doc)] == []


def test_demo_writes_table_plot_and_fmu(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    from gelenk import demo

    demo.main(tmp_path / "out")
    told = capsys.readouterr().out
    gap = float(re.search(r"Largest closure error of the loop: (\S+) m;", told).group(1))  # type: ignore[union-attr]
    assert gap < 1e-10  # m: the projection's own bound
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"FourBar.fmu", "four_bar.csv", "four_bar.png"}
    assert (tmp_path / "out" / "four_bar.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "out" / "four_bar.csv").read_text().splitlines()) == 5002
    for file in (tmp_path / "out").iterdir():
        assert str(file) in told
