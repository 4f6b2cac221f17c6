# SPDX-License-Identifier: BSD-3-Clause
"""What a long study is at, on one line of a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO


@contextmanager
def status_line(stream: IO[str]) -> Iterator[Callable[[str, float], None]]:
    """A function to be called with what is done and its share in [0, 1]; silent where no one would see it."""
    shown = stream.isatty()

    def tell(words: str, share: float) -> None:
        if shown:
            print(f"\r\033[K{words} {100 * share:.0f} %", end="", file=stream, flush=True)

    try:
        yield tell
    finally:
        if shown:
            print("\r\033[K", end="", file=stream, flush=True)
