# SPDX-License-Identifier: BSD-3-Clause
"""Progress of a long study on one line of a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO


@contextmanager
def status_line(stream: IO[str]) -> Iterator[Callable[[str, float], None]]:
    """Yield a function that shows the current activity and the completed fraction in [0, 1].

    It prints nothing if the stream is not a terminal.
    """
    shown = stream.isatty()

    def show(activity: str, fraction: float) -> None:
        if shown:
            print(f"\r\033[K{activity} {100 * fraction:.0f} %", end="", file=stream, flush=True)

    try:
        yield show
    finally:
        if shown:
            print("\r\033[K", end="", file=stream, flush=True)
