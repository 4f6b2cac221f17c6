# SPDX-License-Identifier: BSD-3-Clause
"""The packages of Python: imported when they are asked for, and found under their old names for a release."""

from __future__ import annotations

import ast
import json
import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import gelenk
from gelenk import _moved

HEAVY = {
    "numpy",
    "scipy",
    "control",
    "fmpy",
    "matplotlib",
    "yaml",
    "typer",
    "tqdm",
    "yourdfpy",
    "gelenk._core",
}
PACKAGES = (
    "chart",
    "cli",
    "equilibria",
    "gradients",
    "io",
    "learning",
    "linear",
    "modal",
    "model",
    "simulation",
    "sweeps",
)


def run(code: str) -> Any:
    """What a fresh interpreter prints, as JSON; the modules that start it are in `before`."""
    begin = "import json, sys; before = set(sys.modules)\n"
    done = subprocess.run(
        [sys.executable, "-c", begin + code], capture_output=True, text=True, timeout=60, check=True
    )
    return json.loads(done.stdout)


def test_importing_gelenk_imports_no_more_than_it_needs_to_find_names() -> None:
    found = set(run("import gelenk; print(json.dumps(sorted(set(sys.modules) - before)))"))
    assert found & HEAVY == set()
    ours = {name for name in found if name.partition(".")[0] == "gelenk"}
    assert ours == {"gelenk", "gelenk._lazy", "gelenk._moved"}


@pytest.mark.parametrize(
    ("use", "lacks"),
    [
        ("gelenk.UsageError", HEAVY),
        ("gelenk.__version__", HEAVY),
        ("gelenk.load", HEAVY - {"numpy", "yaml", "gelenk._core"}),
        (
            "gelenk.sweep",
            {"scipy", "control", "matplotlib", "typer", "tqdm", "fmpy", "xarray", "distributed"},
        ),
        ("gelenk.simulate", {"scipy", "control", "matplotlib", "typer", "tqdm", "fmpy"}),
        ("gelenk.linearize", {"control", "matplotlib", "typer", "tqdm", "fmpy"}),
    ],
)
def test_a_name_imports_what_it_is_made_of_and_no_more(use: str, lacks: set[str]) -> None:
    found = run(f"import gelenk; {use}; print(json.dumps(sorted(set(sys.modules) - before)))")
    assert lacks & {*found} == set()


def test_help_computes_nothing() -> None:
    code = (
        "import io, contextlib\nfrom gelenk.cli import main\nsys.argv = ['gelenk', '--help']\n"
        "with contextlib.redirect_stdout(io.StringIO()) as told:\n"
        "    try: main()\n    except SystemExit: pass\n"
        "print(json.dumps([told.getvalue(), sorted(set(sys.modules) - before)]))"
    )
    told, found = run(code)
    assert {"linearize", "chart", "simulate"} <= {*told.split()}
    assert {*found} & HEAVY == {"typer"}


def test_every_public_name_is_there_and_listed() -> None:
    listed = run("import gelenk; print(json.dumps(dir(gelenk)))")  # before anything was asked for
    assert {*gelenk.__all__, *PACKAGES, "errors"} <= {*listed}
    for name in gelenk.__all__:
        assert getattr(gelenk, name) is not None
    assert vars(gelenk)["simulate"] is gelenk.simulate  # looked up once
    with pytest.raises(AttributeError, match="module 'gelenk' has no attribute 'simulatte'"):
        _ = gelenk.simulatte  # type: ignore[attr-defined]
    assert not hasattr(gelenk, "__wrapped__")


@pytest.mark.parametrize("name", PACKAGES)
def test_public_names_of_a_package_are_those_that_it_lists(name: str) -> None:
    package = import_module(f"gelenk.{name}")
    for public in getattr(package, "__all__", []):
        assert getattr(package, public).__module__.startswith(f"gelenk.{name}.") or public == "app"
        assert public in dir(package)
        # The module of this name would take the place of the function once it is imported.
        assert not (Path(package.__path__[0]) / f"{public}.py").exists()


def test_types_of_the_compiled_module_are_complete() -> None:
    """They are generated: a binding that takes or returns any object, or any list, says too little."""
    stub = ast.parse((Path(gelenk.__file__).parent / "_core" / "__init__.pyi").read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(stub) if isinstance(node, ast.FunctionDef)]
    assert {"_linearize", "export_fmu"} <= {node.name for node in functions}
    types = [of for node in functions for of in (node.returns, *(a.annotation for a in node.args.args)) if of]
    types += [node.annotation for node in ast.walk(stub) if isinstance(node, ast.AnnAssign)]
    vague = {"object", "list", "dict", "tuple", "Any", "NDArray", "numpy.ndarray"}
    assert {ast.unparse(of) for of in types} & vague == set()


def test_no_package_hides_a_public_name() -> None:
    inside = {path.stem for path in Path(gelenk.__file__).parent.iterdir()}
    assert inside & {*gelenk.__all__} == set()


def test_a_module_that_fails_for_want_of_another_says_which(monkeypatch: pytest.MonkeyPatch) -> None:
    """The attribute is there: what is missing is told, not that the attribute is."""
    import_module("gelenk.io")
    monkeypatch.delitem(sys.modules, "gelenk.io")
    monkeypatch.delitem(vars(gelenk), "io")
    monkeypatch.setitem(sys.modules, "gelenk._lazy", None)
    with pytest.raises(ModuleNotFoundError, match=r"gelenk\._lazy"):
        _ = gelenk.io


@pytest.mark.parametrize(("old", "new"), _moved.MOVED.items())
def test_a_module_that_has_moved_is_found_with_a_warning(old: str, new: str) -> None:
    sys.modules.pop(f"gelenk.{old}", None)
    sentence = f"gelenk.{old} is deprecated and will be removed in the next release; use gelenk.{new}"
    with pytest.warns(DeprecationWarning, match="is deprecated") as caught:
        found = import_module(f"gelenk.{old}")
    assert [str(warning.message) for warning in caught] == [sentence]
    assert found is import_module(f"gelenk.{new}")
    assert found.__name__ == found.__spec__.name == f"gelenk.{new}"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "line",
    [
        "import gelenk.linearization as found",
        "from gelenk import linearization as found",
        "from gelenk.linearization import linear_model as found",
        "import gelenk\nfound = gelenk.linearization",
    ],
)
def test_whoever_uses_an_old_name_is_warned_in_his_own_line(line: str) -> None:
    """Python shows deprecations in scripts only where the script's own line is to blame."""
    code = f"{line}\nprint(json.dumps(found.__module__ if callable(found) else found.__name__))"
    done = subprocess.run(
        [sys.executable, "-c", f"import json\n{code}"], capture_output=True, text=True, timeout=60, check=True
    )
    assert json.loads(done.stdout) == "gelenk.linear.linearization"
    where, _, told = done.stderr.partition(": DeprecationWarning: ")
    assert where == f"<string>:{2 + line.count('\n')}"
    assert told.startswith(
        "gelenk.linearization is deprecated and will be removed in the next release; "
        "use gelenk.linear.linearization"
    )


def test_a_result_pickled_by_an_earlier_version_is_read(four_bar: gelenk.Scene) -> None:
    result = gelenk.simulate(four_bar, stop=0.01)
    old = pickle.dumps(result, 0).replace(b"cgelenk.simulation.result\n", b"cgelenk.result\n")
    assert old != pickle.dumps(result, 0)
    sys.modules.pop("gelenk.result", None)
    with pytest.warns(DeprecationWarning, match=r"gelenk\.result"):
        read = pickle.loads(old)
    assert (read["A.phi"] == result["A.phi"]).all()


def test_nothing_of_ours_uses_an_old_name() -> None:
    """All modules are imported, with warnings as errors."""
    code = (
        "import gelenk, pkgutil\nfrom importlib import import_module\n"
        "names = [m.name for m in pkgutil.walk_packages(gelenk.__path__, 'gelenk.')]\n"
        "for name in names:\n    if name != 'gelenk.__main__': import_module(name)\n"
        "print(json.dumps(names))"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error:gelenk:DeprecationWarning", "-c", f"import json\n{code}"],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert len(json.loads(done.stdout)) > len(_moved.MOVED)
