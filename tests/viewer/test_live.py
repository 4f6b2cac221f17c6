# SPDX-License-Identifier: BSD-3-Clause
"""Views of running simulations."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
import time
import urllib.error
import urllib.request
import webbrowser

import numpy as np
import pytest

import gelenk
from gelenk.simulation.live import live_view
from gelenk.viewer import live

from .browser import Browser


def started(scene: gelenk.Scene) -> gelenk.Simulation:
    plant = gelenk.Simulation(scene)
    plant.initialize()
    plant.set_input("drive.tau", 3.0)
    return plant


def test_a_page_shows_the_state_of_the_simulation(four_bar: gelenk.Scene) -> None:
    """The newest frame, until somebody looks at the past; after the end, all frames can be played."""
    plant = started(four_bar)
    browser = Browser()
    try:
        with live_view(plant, rate=50, browser=False) as view:
            browser.open_address(view.url)
            for k in range(60):
                plant.step_to(0.02 * (k + 1))
                view.update()
                time.sleep(0.01)
            browser.wait(f"return gelenk.frames > 10 && gelenk.time > {plant.time - 0.1}")
            browser.run("document.getElementById('slider').value = 3")
            browser.run("document.getElementById('slider').dispatchEvent(new Event('input'))")
            plant.step_to(2.0)
            time.sleep(0.05)
            view.update()
            browser.wait("return gelenk.live.recording.time[gelenk.frames - 1] === 2")
            assert browser.run("return gelenk.frame") == 3
            browser.run("document.getElementById('live').click()")
            assert browser.run("return gelenk.time") == 2.0
        browser.wait("return gelenk.live.ended")
        R, p = plant.pose("coupler")
        browser.run("gelenk.show(gelenk.frames - 1)")
        pose = browser.run("return gelenk.pose('coupler')")
        assert pose["p"] == pytest.approx(p, abs=1e-6)
        phi = browser.run(
            "const s = gelenk.live.recording.signals[0]; return [s.name, s.values[s.values.length - 1]]"
        )
        assert phi == ["A.phi", pytest.approx(plant.output("A.phi"), rel=1e-6)]
        assert R[1, 1] == pytest.approx(1)
        assert browser.errors() == []
    finally:
        browser.close()


def messages(url: str) -> str:
    with urllib.request.urlopen(url, timeout=10) as answer:
        text: str = answer.read().decode()
        return text


def test_frames_are_sent_at_the_rate_and_the_last_one_always(four_bar: gelenk.Scene) -> None:
    plant = started(four_bar)
    view = live_view(plant, rate=1.0, browser=False)
    for k in range(100):
        plant.step_to(0.001 * (k + 1))
        view.update()
    server = view._server
    assert server is not None
    assert server.count == 1  # within the first second
    view.close()
    assert server.count == 2
    assert server.frames[-1][0] == 0.1
    view.close()  # again
    view.update()
    assert server.count == 2
    with pytest.raises(urllib.error.URLError):
        messages(view.url)
    assert [thread for thread in threading.enumerate() if thread is server._thread] == []


def test_only_this_machine_is_answered(four_bar: gelenk.Scene) -> None:
    with live_view(started(four_bar), browser=False) as view:
        assert view.url.startswith("http://127.0.0.1:")
        assert "img-src data:; connect-src 'self'" in messages(view.url)
        for path, host, code in (("other", None, 404), ("", "evil.example", 403)):
            request = urllib.request.Request(view.url + path, headers={"Host": host} if host else {})
            with pytest.raises(urllib.error.HTTPError) as found:
                urllib.request.urlopen(request, timeout=10)
            assert found.value.code == code
            found.value.close()


def test_the_history_is_sent_to_pages_that_are_opened_later(
    four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The browser may need longer than the run."""
    received: list[str] = []

    def open_later(url: str) -> bool:
        def read() -> None:
            time.sleep(0.3)
            received.append(messages(url + "frames"))

        threading.Thread(target=read).start()
        return True

    monkeypatch.setattr(webbrowser, "open", open_later)
    plant = started(four_bar)
    with live_view(plant, rate=1e6) as view:
        for k in range(20):
            plant.step_to(0.001 * (k + 1))
            view.update()
    assert len(received) == 1
    assert received[0].startswith("data: {")
    assert received[0].endswith("event: end\ndata: {}\n\n")


def test_a_run_can_be_held_to_the_clock(four_bar: gelenk.Scene) -> None:
    plant = started(four_bar)
    begin = time.monotonic()
    with live_view(plant, speed=2.0, browser=False) as view:
        for k in range(10):
            plant.step_to(0.1 * (k + 1))
            view.update()
        assert time.monotonic() - begin >= 0.5


def test_old_frames_are_forgotten(four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live, "MAX_FRAMES", 3)
    server = live.LiveServer(live_view(started(four_bar), browser=False)._data)
    for k in range(10):
        server.add(0.1 * k, np.zeros(2, np.float32))
    count, message = server.batch(0)
    assert count == 10
    assert message.startswith("data: {")
    assert [t for t, _ in server.frames] == pytest.approx([0.7, 0.8, 0.9])
    server.close()


@pytest.mark.parametrize("choice", [{"rate": 0.0}, {"rate": float("inf")}, {"speed": -1.0}])
def test_wrong_choices(choice: dict[str, float], four_bar: gelenk.Scene) -> None:
    with pytest.raises(gelenk.UsageError, match=r"(rate|speed): found .*, expected more than 0"):
        live_view(started(four_bar), browser=False, **choice)


def test_connections_are_bounded(four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each has a thread; those in excess are closed, and those that send nothing after a while, too."""
    monkeypatch.setattr(live, "MAX_CONNECTIONS", 8)
    monkeypatch.setattr(live, "TIMEOUT", 60.0)  # on a busy machine, too, the 8 are still open
    before = threading.active_count()
    with live_view(started(four_bar), browser=False) as view:
        address = ("127.0.0.1", int(view.url.split(":")[2].strip("/")))
        with contextlib.ExitStack() as stack:
            waiting = {stack.enter_context(socket.create_connection(address)) for _ in range(100)}
            deadline = time.monotonic() + 10.0
            while len(waiting) > 8 and time.monotonic() < deadline:
                for closed in select.select(list(waiting), [], [], 1.0)[0]:
                    assert closed.recv(1) == b""
                    waiting.remove(closed)
            assert len(waiting) == 8
            assert threading.active_count() <= before + 1 + 8
        deadline = time.monotonic() + 10.0
        while True:
            try:
                assert "<html" in messages(view.url)
                break
            except (urllib.error.URLError, ConnectionError):  # the threads of the others are ending
                assert time.monotonic() < deadline
                time.sleep(0.01)


def test_a_connection_that_sends_nothing_is_closed(
    four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live, "TIMEOUT", 0.2)
    with live_view(started(four_bar), browser=False) as view:
        address = ("127.0.0.1", int(view.url.split(":")[2].strip("/")))
        with socket.create_connection(address, timeout=10.0) as silent:
            assert silent.recv(1) == b""
