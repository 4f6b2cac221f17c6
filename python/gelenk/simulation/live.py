# SPDX-License-Identifier: BSD-3-Clause
"""Views of simulations that are running."""

from __future__ import annotations

import time
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.simulation.recording import Recording, poses_of
from gelenk.simulation.result import Result
from gelenk.simulation.simulation import Simulation
from gelenk.viewer.data import page_data
from gelenk.viewer.live import LiveServer

type Array = NDArray[np.float64]

MAX_SIGNALS = 30
RATE = 30.0  # frames per second
FIRST_PAGE = 10.0  # s; how long the browser may take to open a page of a run that is already over


class LiveView:
    """A page in the browser that shows a simulation while it is running; close it, or use it in a `with`."""

    def __init__(self, simulation: Simulation, rate: float, speed: float | None, *, browser: bool) -> None:
        """Start to serve the page; see `live_view`."""
        self._simulation = simulation
        positions = sorted(simulation.outputs, key=lambda signal: signal.unit not in ("rad", "m"))
        self._signals = [signal.name for signal in positions[:MAX_SIGNALS]]
        self._period = 1 / rate
        self._speed = speed
        self._browser = browser
        self._next = -np.inf
        self._origin = (time.monotonic(), simulation.time)
        start = Result(
            self._signals,
            np.array([[simulation.time, *simulation.values(self._signals)]]),
            {signal.name: signal.unit for signal in simulation.outputs},
        )
        recording = Recording(
            simulation.scene.to_dict(), start.time, poses_of(simulation)[None], start, np.arange(1)
        )
        data = self._data = page_data(recording)
        # The page plots signals in its own order.
        self._signals = [row["name"] for row in data["signals"]]
        self._server: LiveServer | None = LiveServer(data)
        #: Address of the page, on this machine.
        self.url = self._server.url
        self.update()
        if browser:
            import webbrowser

            webbrowser.open(self.url)

    def update(self) -> None:
        """Show the present state, unless the last frame is too recent; call it after every step.

        With a `speed`, it waits until the simulation is not ahead of the clock.
        """
        now = time.monotonic()
        if self._speed is not None:
            due = self._origin[0] + (self._simulation.time - self._origin[1]) / self._speed
            if due > now:
                time.sleep(due - now)
                now = time.monotonic()
            else:  # time that was lost is not made up for
                self._origin = (now, self._simulation.time)
        if now >= self._next:
            self._next = now + self._period
            self._send()

    def close(self) -> None:
        """Show the present state and stop to serve; pages keep what they have received.

        If the browser was opened, this waits until it has loaded the page, at most 10 s.
        """
        if self._server is None:
            return
        self._send()
        self._server.close(FIRST_PAGE if self._browser else 0.0)
        self._server = None

    def _send(self) -> None:
        if self._server is not None:
            numbers = np.concatenate(
                [poses_of(self._simulation).ravel(), self._simulation.values(self._signals)]
            )
            self._server.add(self._simulation.time, numbers.astype(np.float32))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" width="100%" height="520" style="border:0"></iframe>'

    def __repr__(self) -> str:
        return f"<LiveView of {self._simulation.scene.name or 'a scene'} at {self.url}>"


def live_view(
    simulation: Simulation, *, rate: float = RATE, speed: float | None = None, browser: bool = True
) -> LiveView:
    """Show a simulation in the browser while a controller steps it.

    The page is served on this machine only, at 127.0.0.1. It keeps what it has received, so that the run can
    be played again.

    Args:
        simulation: an initialized simulation.
        rate: frames per second, at most; `update` returns at once in between.
        speed: of the simulation relative to the clock, which `update` waits for; None: it never waits.
        browser: whether to open the page in the browser; `url` is its address.

    Returns:
        LiveView: to be updated after every step, and closed.

    Raises:
        UsageError: the simulation is not initialized, or `rate` or `speed` is not positive.
        OSError: no port is free.

    >>> plant = gelenk.Simulation(four_bar)
    >>> plant.initialize()
    >>> with gelenk.live_view(plant, browser=False) as view:
    ...     for k in range(100):
    ...         plant.step_to((k + 1) * 1e-3)
    ...         view.update()
    """
    for name, value in (("rate", rate), ("speed", speed)):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise UsageError(f"{name}: found {value}, expected more than 0")
    return LiveView(simulation, rate, speed, browser=browser)
