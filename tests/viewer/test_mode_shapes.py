# SPDX-License-Identifier: BSD-3-Clause
"""Mode shapes on a page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import warned
from mechanisms import body, frame, joint, scene
from test_cli import call

import gelenk
from gelenk.modal import animation

from .browser import Browser

UPRIGHT = {"hinge.phi": 0.0}


@pytest.fixture
def cart_pole(root: Path) -> Path:
    return root / "scenes" / "cart_pole.yaml"


@pytest.mark.parametrize("shown", [True, False])
def test_command_shows_mode_shapes(shown: bool, cart_pole: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.html"
    more = ["--animate", "3"] if not shown else []
    done = call("modes", cart_pole, "--at", "hinge.phi=0", "--view", "-o", out, *more)
    assert (done.returncode == 0) == shown
    if shown:
        assert done.stdout == f"{gelenk.modes(cart_pole, at=UPRIGHT)}\n"
        assert "<!DOCTYPE html>" in out.read_text(encoding="utf-8")
    else:
        assert "--animate and --view: found both, expected one of them" in done.stderr


def test_modes_on_a_page(cart_pole: Path) -> None:
    """Mode 3: the pole by 0.3 rad at first, the cart by its share, at rest after a quarter of the period."""
    found = gelenk.modes(cart_pole, at=UPRIGHT)
    data = found.view(0.1)._data
    assert [row["number"] for row in data["modes"]] == [1, 2, 3, 4]
    falling = data["modes"][2]
    assert falling["text"].startswith("0.8341 Hz, damping ratio -1, grows in 0.191 s, mainly hinge.phi")
    assert falling["poses"].shape == (25, 2, 7)
    pole = falling["poses"][:, 1]
    tilt = 2 * np.arcsin(np.linalg.norm(pole[:, 3:6], axis=1))
    expected = 0.1 * np.abs(np.cos(2 * np.pi * np.arange(25) / 24))
    assert tilt == pytest.approx(expected, abs=1e-6)  # single precision
    cart = falling["poses"][:, 0, 0] - data["second"]["poses"][0, 0, 0]
    share = found.modes[2].shape["track.s"].real
    assert cart == pytest.approx(0.1 * share * np.cos(2 * np.pi * np.arange(25) / 24), abs=1e-6)
    assert np.ptp(data["second"]["poses"], axis=0).max() == 0


def swing(damping: float) -> gelenk.Modes:
    """A pendulum of 1 kg at 1 m, with 0.1 kg m2 about its center: J = 1.1 kg m2."""
    source = scene(
        {"bob": body(1.0, (0, 0, -1.0), (0.1, 0.1, 0.1))},
        {"J": joint("revolute", frame("ground"), frame("bob"), axis=[0, 1, 0], damping=damping)},
        gravity=[0, 0, -9.81],
    )
    return gelenk.modes(gelenk.load(source))


def test_a_mode_lasts_its_damped_period() -> None:
    """w^2 = m g l / J - (d / 2 J)^2; what does not oscillate is shown in 2 s."""
    expected = 2 * np.pi / np.sqrt(9.81 / 1.1 - (0.4 / 2.2) ** 2)
    assert swing(0.4).view()._data["modes"][0]["time"][-1] == pytest.approx(expected, rel=1e-9)
    assert swing(20.0).view()._data["modes"][0]["time"][-1] == 2.0


@warned.GUESSES
@pytest.mark.filterwarnings("ignore::gelenk.OperatingPointWarning")
def test_an_amplitude_at_which_loops_cannot_be_closed_is_reduced_unless_it_is_given(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = gelenk.modes(root / "scenes" / "slider_crank.yaml")
    with pytest.raises(gelenk.UsageError, match=r"amplitude: 1000 is too large: loop .* cannot be closed"):
        found.view(1000.0)
    monkeypatch.setattr(animation, "_visible_amplitude", lambda *_: 1000.0)
    assert np.isfinite(found.view()._data["poses"]).all()
    monkeypatch.setattr(animation, "_visible_amplitude", lambda *_: 1e6)
    with pytest.raises(gelenk.UsageError, match=r"amplitude: 1\.562e\+04 is too large"):  # 1e6 / 2^6
        found.view()
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(gelenk.UsageError, match=r"amplitude: found .*, expected more than 0"):
            found.view(wrong)


def test_modes_and_amplitudes_are_chosen_on_the_page(cart_pole: Path, tmp_path: Path) -> None:
    page = gelenk.modes(cart_pole, at=UPRIGHT).view(0.1)
    browser = Browser()
    try:
        browser.open(page.save(tmp_path / "x.html"))
        browser.run("gelenk.pause(); gelenk.show(0)")
        for amplitude in (100, 50, 150):
            browser.run(
                f"const slider = document.getElementById('amplitude'); slider.value = {amplitude};"
                "gelenk.chooseMode(2); slider.dispatchEvent(new Event('input'));"
            )
            q = browser.run("return gelenk.pose('pole').q")
            tilt = 2 * np.arcsin(np.linalg.norm(q[:3]))
            assert tilt == pytest.approx(0.1 * amplitude / 100, abs=1e-6)
        assert "mainly hinge.phi" in browser.run("return document.getElementById('mode-text').textContent")
        assert browser.errors() == []
    finally:
        browser.close()
