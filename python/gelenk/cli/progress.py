# SPDX-License-Identifier: BSD-3-Clause
"""A progress bar for long runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any

from gelenk.errors import UsageError
from gelenk.extras import extra

QUIET = 1.0  # s; shorter runs show no bar
PERIOD = 0.1  # s between drawings


@contextmanager
def progress_bar(stream: IO[str]) -> Iterator[Callable[[float, float], None] | None]:
    """A function to be called with the time reached and the end [s]; None where no one would see it."""
    if not stream.isatty():
        yield None
        return
    begun = last = time.monotonic()
    bar: Any = None
    told = False

    def reached(t: float, stop: float) -> None:
        nonlocal bar, last, told
        now = time.monotonic()
        if told or now - last < PERIOD or now - begun < QUIET:
            return
        last = now
        if bar is None:
            try:
                tqdm = extra("tqdm", "progress is shown by tqdm").tqdm
            except UsageError as e:  # nothing that a run would have to end for
                told = True
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
