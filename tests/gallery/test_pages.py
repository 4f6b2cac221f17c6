# SPDX-License-Identifier: BSD-3-Clause
"""Pages of the gallery: what each of them has, and that its scene is in order."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest
import scene_files
import warned
from benchmarks.gallery import SHOTS, SIZE, index
from samples import thorough_beyond

import gelenk
from gallery.entries import GALLERY, NAMES, file, ran

pytestmark = warned.STILL

LARGEST = {"picture.png": 60_000, "moving.gif": 250_000}  # bytes
TOTAL = 8_000_000
MODULES = sorted(Path(__file__).parent.glob("test_*.py"))


def test_the_gallery_shows_all_scenes_and_lists_all_pages() -> None:
    assert list(scene_files.gallery()) == NAMES
    assert len(NAMES) >= 24
    assert sorted(name for shots in SHOTS.values() for name in shots) == NAMES
    assert (GALLERY / "README.md").read_text(encoding="utf-8") == index(), "run make gallery"
    assert f"shows {len(NAMES)} mechanisms" in (GALLERY.parents[1] / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_page_has_three_sentences_and_links_that_lead_somewhere(name: str) -> None:
    text = (GALLERY / name / "README.md").read_text(encoding="utf-8")
    title, rest = text.split("\n", 1)
    assert title.startswith("# ")
    sentences = re.findall(r"\.(?=\s+[A-Z]|\s*$)", rest.partition("![")[0])
    assert len(sentences) == 3
    links = re.findall(r"\]\(([^)#:]+)\)", text)
    assert {"moving.gif", "picture.png", "../README.md"} < {*links}
    for link in links:
        assert (GALLERY / name / link).exists(), link
    command = f"gelenk view {file(name).relative_to(GALLERY.parents[1])}"
    assert command in text
    for signal, value in next(shots[name] for shots in SHOTS.values() if name in shots).inputs.items():
        assert f"{signal}={value:g}" in text.partition(command)[2]  # the film is of the command


@pytest.mark.parametrize("name", NAMES)
def test_page_is_about_what_its_test_computes(name: str) -> None:
    """The test that the page names states a number of it (`assert_stated`)."""
    text = (GALLERY / name / "README.md").read_text(encoding="utf-8")
    (module,) = [path for path in MODULES if f"/{path.name})" in text]
    assert f'assert_stated("{name}"' in module.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_pictures_are_small_and_films_move(name: str) -> None:
    Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    for picture, largest in LARGEST.items():
        path = GALLERY / name / picture
        assert path.stat().st_size <= largest
        with Image.open(path) as found:
            assert found.size == SIZE
    with Image.open(GALLERY / name / "moving.gif") as film:
        assert film.n_frames >= 12
        first = film.convert("RGB").tobytes()
        film.seek(film.n_frames // 3)
        assert film.convert("RGB").tobytes() != first
        assert film.info["loop"] == 0  # repeats itself


def test_all_pictures_together_are_small() -> None:
    assert sum(path.stat().st_size for path in GALLERY.rglob("*") if path.is_file()) < TOTAL


@pytest.mark.parametrize("name", thorough_beyond(NAMES, {*NAMES} - {"delta_robot", "stewart"}))
def test_scene_has_a_comment_and_no_warnings_and_stays_closed(name: str) -> None:
    assert file(name).read_text(encoding="utf-8").startswith("# ")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        inspection = gelenk.inspect(gelenk.load(file(name)))
        plant = gelenk.Simulation(gelenk.load(file(name)))
        plant.initialize()
    assert inspection is not None
    end = ran(name).time[-1]
    for k in range(1, 11):
        plant.step_to(end * k / 10)
        assert plant.diagnostics["constraints.position"] < 1e-10  # m: the projection's own bound
        assert plant.diagnostics["constraints.velocity"] < 1e-9  # m/s
