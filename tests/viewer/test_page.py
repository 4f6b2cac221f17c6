# SPDX-License-Identifier: BSD-3-Clause
"""The page as a file: its size, its license, and text that is no markup."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import pytest
from mechanisms import body, frame, joint, scene
from physics.nonsmooth.test_dead_centers import slider_crank
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app


def chain(length: int) -> gelenk.Scene:
    names = ["ground", *(f"b{k}" for k in range(length))]
    bodies = {name: body(1.0, com=(0.5, 0, 0), inertia=(0.01, 0.1, 0.1)) for name in names[1:]}
    joints = {
        f"J{k}": joint("revolute", frame(a, (1.0 if k else 0.0, 0, 0)), frame(b), axis=[0, 1, 0])
        for k, (a, b) in enumerate(itertools.pairwise(names))
    }
    return gelenk.load(scene(bodies, joints, gravity=[0, 0, -9.81]))


def test_size_of_a_page() -> None:
    """20 bodies and 1000 frames: below 3 MB, of which three.js is 0.6."""
    page = gelenk.view(chain(20), stop=0.999, step=0.001)
    assert len(page.html.encode()) < 3e6


def test_pages_refer_to_nothing_and_name_licenses() -> None:
    html = gelenk.view(chain(1), stop=0.0).html
    head = html[: html.index('id="data"')]  # the rest is code, which tests in a browser watch
    assert re.findall(r"""(?:src|href)\s*=\s*['"](?!data:)|@import|url\(""", head) == []
    assert "Copyright (c) 2010-2022 three.js authors" in html
    assert "Permission is hereby granted, free of charge" in html


def test_names_are_text() -> None:
    source = chain(1).to_dict() | {"name": "a </script><b>bold</b> & co"}
    html = gelenk.view(gelenk.load(source), stop=0.0).html
    assert "<title>a &lt;/script&gt;&lt;b&gt;bold" in html
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.DOTALL)
    assert data
    assert json.loads(data[1])["name"] == source["name"]


def test_command(four_bar_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "page.html"
    found = CliRunner().invoke(app, ["view", str(four_bar_file), "--stop", "0.1", "-o", str(out)])
    assert found.exit_code == 0, found.output
    assert found.output.startswith(f"{out}: ")
    assert out.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    wrong = CliRunner().invoke(app, ["view", str(four_bar_file), "-o", str(tmp_path / "page.pdf")])
    assert wrong.exit_code == 1


def test_notebooks_show_the_page_in_a_frame(four_bar: gelenk.Scene) -> None:
    page = gelenk.view(four_bar, stop=0.0)
    assert page._repr_html_().startswith('<iframe srcdoc="&lt;!DOCTYPE html&gt;')
    assert repr(page).startswith("<View of FourBar, ")


def test_errors_of_the_run_are_those_of_simulate(four_bar: gelenk.Scene) -> None:
    with pytest.raises(gelenk.UsageError, match=r"no such parameter or input; did you mean drive\.tau"):
        gelenk.view(four_bar, parameters={"drive.ta": 3.0})


def test_a_run_that_fails_is_shown_up_to_its_end(tmp_path: Path) -> None:
    """A driven slider-crank meets a limit where nothing can stop it."""
    source = slider_crank(0.0, lower=1.4)
    source["joints"]["A"]["start"] = {"phi": 0.0}
    source["constraints"] = {"drive": {"type": "motion", "joint": "A", "polynomial": [0, 1.0]}}
    with pytest.raises(gelenk.StepError) as found:
        gelenk.view(gelenk.load(source), stop=1.0, step=0.01)
    assert found.value.view is not None
    assert "the run ended: t = 0.527" in found.value.view.html
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(source))
    out = tmp_path / "page.html"
    done = CliRunner().invoke(app, ["view", str(file), "--stop", "1", "-o", str(out)])
    assert done.exit_code == 1
    assert "where no force can stop it" in done.output
    assert out.exists()


@pytest.mark.parametrize(("length", "thickness"), [(5, 5.0), (40, 6.0)])
def test_pins_of_long_chains_do_not_cover_links(length: int, thickness: float) -> None:
    """Links of 1 m have a radius of 0.012 sizes of the mechanism, but of 6 links at most."""
    data = gelenk.view(chain(length), stop=0.0)._data
    (link,) = (tube for tube in data["bodies"][0]["tubes"] if not tube["role"])
    assert link["r"] == pytest.approx(0.012 * thickness, rel=0.15)  # the last body ends at its center of mass
