# SPDX-License-Identifier: BSD-3-Clause
"""A progress bar for long simulations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any

from gelenk.errors import UsageError
from gelenk.extras import extra

QUIET = 1.0  # s; shorter simulations show no bar
PERIOD = 0.1  # s between updates


@contextmanager
def progress_bar(stream: IO[str]) -> Iterator[Callable[[float, float], None] | None]:
    """Yield a function to be called with the time reached and the end [s]; None if there is no terminal.

    Args:
        stream: where to draw the bar.
    """
    if not stream.isatty():
        yield None
        return
    started = last = time.monotonic()
    bar: Any = None
    failed = False

    def reached(t: float, stop: float) -> None:
        nonlocal bar, last, failed
        now = time.monotonic()
        if failed or now - last < PERIOD or now - started < QUIET:
            return
        last = now
        if bar is None:
            try:
                tqdm = extra("tqdm", "progress is shown by tqdm").tqdm
            except UsageError as e:  # a missing progress bar must not end the simulation
                failed = True
                print(e, file=stream)
                return
            bar = tqdm(total=stop, initial=t, unit="s", file=stream, leave=False,
                       bar_format="{l_bar}{bar}| {n:.3g} of {total:g} s, {remaining} left")  # fmt: skip
        else:
            bar.n = t
            bar.refresh()

    try:
        yield reached
    finally:
        if bar is not None:
            bar.close()
