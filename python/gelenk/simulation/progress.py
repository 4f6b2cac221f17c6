# SPDX-License-Identifier: BSD-3-Clause
"""Progress bars of long simulations, in terminals and notebooks."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from typing import IO, Any

from gelenk.errors import UsageError
from gelenk.extras import extra

QUIET = 1.0  # s; shorter simulations show no bar
PERIOD = 0.1  # s between updates
FORMAT = "{l_bar}{bar}| {n:.3g} of {total:g} s, {remaining} left"

type Report = Callable[[float, float], None]


@contextmanager
def reports[R](
    wanted: R | bool | None, opened: Callable[[Any], AbstractContextManager[R]]
) -> Iterator[R | None]:
    """Yield a function to which progress is reported.

    Args:
        wanted: this function itself, or None. True: one that draws a bar, in notebooks as a widget.
        opened: the context of a bar, made with tqdm's class.

    Raises:
        UsageError: tqdm is not installed.
    """
    if not isinstance(wanted, bool):
        yield wanted
    elif not wanted:
        yield None
    else:
        extra("tqdm", "progress is shown by tqdm")
        with opened(import_module("tqdm.auto").tqdm) as reached:
            yield reached


def progress_bar(wanted: Report | bool | None) -> AbstractContextManager[Report | None]:
    """Return the context of a function to be called with the time reached and the end [s].

    Args:
        wanted: this function itself, or None. True: one that draws a bar, in notebooks as a widget.

    Raises:
        UsageError: tqdm is not installed, on entry.
    """
    return reports(wanted, _bar)


@contextmanager
def terminal_bar(stream: IO[str]) -> Iterator[Report | None]:
    """Yield a function that draws a bar in a terminal; None if the stream is none.

    Without tqdm, the bar is replaced by a line with the reason: it must not end the simulation.

    Args:
        stream: where to draw the bar.
    """
    if not stream.isatty():
        yield None
        return

    def opened(**options: Any) -> Any:
        try:
            tqdm = extra("tqdm", "progress is shown by tqdm").tqdm
        except UsageError as e:
            print(e, file=stream)
            return None
        return tqdm(file=stream, **options)

    with _bar(opened) as reached:
        yield reached


@contextmanager
def _bar(make: Callable[..., Any]) -> Iterator[Report]:
    """Yield a function that updates a bar, which is made when the simulation has lasted for a while."""
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
            bar = make(total=stop, initial=t, unit="s", leave=False, bar_format=FORMAT)
            failed = bar is None
        else:
            bar.n = t
            bar.refresh()

    try:
        yield reached
    finally:
        if bar is not None:
            bar.close()
