# SPDX-License-Identifier: BSD-3-Clause
"""The loop that gives chunks of runs to workers, and takes what they have computed."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any

from gelenk.simulation.progress import reports
from gelenk.sweeps.plan import Chunk

type Range = tuple[int, int]  # the first run, and the one after the last
type Progress = Callable[[int, int], None]

MAX_CHUNK_BYTES = 32_000_000  # of recorded signals
LOST = "cluster: the connection to the scheduler was lost; with a store, the same call continues"
POLL = 0.2  # s between looks at the clock
GROWTH = 4  # of a chunk compared with the one before, until the cost of runs is known well


@dataclass
class Workers:
    """Where chunks are computed.

    Attributes:
        submit: starts the computation of the runs of a range.
        in_flight: number of chunks that are computed or waiting at the same time.
        chunk_seconds: time that a chunk should take [s].
        stop: ends the running computations early.
        died: the message if an exception of a future means that the process of the worker has died; None if
            it means something else.
    """

    submit: Callable[[int, int], Future[Chunk]]
    in_flight: int
    chunk_seconds: float
    stop: Callable[[], None]
    died: Callable[[BaseException], str | None] = lambda _: None


class Driver:
    """Computes ranges of runs by workers, in chunks whose size follows from their measured cost."""

    def __init__(
        self,
        workers: Workers,
        todo: Iterable[Range],
        bytes_per_run: int,
        deadline: float | None,
        failed: Callable[[int, str], Chunk],
    ) -> None:
        """Prepare the computation.

        Args:
            workers: where chunks are computed.
            todo: the ranges of runs to compute.
            bytes_per_run: memory that a worker needs for a run.
            deadline: time of `time.monotonic` at which to stop; None: never.
            failed: returns the outcome of a run whose worker has died, given its number and why.
        """
        self._workers = workers
        self._todo = deque(todo)
        self._largest = max(1, MAX_CHUNK_BYTES // bytes_per_run)
        self._size = 1
        self._deadline = deadline
        self._failed = failed
        self._futures: dict[Future[Chunk], Range] = {}

    def chunks(self) -> Iterator[Chunk]:
        """Yield chunks as they are completed, in any order; all of them unless the deadline is reached."""
        try:
            while self._todo or self._futures:
                if self._deadline is not None and time.monotonic() >= self._deadline:
                    break
                while self._todo and len(self._futures) < self._workers.in_flight:
                    self._submit()
                done, _ = wait(self._futures, timeout=POLL, return_when=FIRST_COMPLETED)
                yield from self._taken(done)
        finally:
            self._workers.stop()
            for future in self._futures:
                future.cancel()
        # What was computed until the deadline is kept.
        done, _ = wait(self._futures, timeout=5.0)
        yield from self._taken(future for future in done if not future.cancelled())

    def _submit(self) -> None:
        first, last = self._todo.popleft()
        left = last - first + sum(b - a for a, b in self._todo)
        fair = -(-left // self._workers.in_flight)  # at the end, all workers have something to do
        end = min(last, first + max(1, min(self._size, self._largest, fair)))
        if end < last:
            self._todo.appendleft((end, last))
        self._futures[self._workers.submit(first, end)] = (first, end)

    def _taken(self, done: Iterable[Future[Chunk]]) -> Iterator[Chunk]:
        for future in list(done):
            first, last = self._futures.pop(future)
            if future.cancelled():
                raise ConnectionError(LOST)
            error = future.exception()
            if error is None:
                chunk = future.result()
                self._measure(chunk)
                yield chunk
                continue
            why = self._workers.died(error)
            if why is None:
                raise error
            if last - first == 1:
                yield self._failed(first, why)
            else:  # one by one, so that only the run that does it fails
                self._todo.extendleft((i, i + 1) for i in reversed(range(first, last)))

    def _measure(self, chunk: Chunk) -> None:
        runs = chunk.last - chunk.first
        if runs:
            wanted = int(self._workers.chunk_seconds / max(chunk.seconds / runs, 1e-7))
            self._size = max(1, min(wanted, GROWTH * max(self._size, runs)))


def progress_of(wanted: Progress | bool | None) -> AbstractContextManager[Progress | None]:
    """Return the context of a function to be called with the number of completed runs and of all runs.

    Args:
        wanted: this function itself, or None. True: one that draws a bar, in notebooks as a widget.

    Raises:
        UsageError: tqdm is not installed, on entry.
    """
    return reports(wanted, _bar)


@contextmanager
def _bar(make: Callable[..., Any]) -> Iterator[Progress]:
    bar: Any = make(unit="run", leave=False, delay=0.5)

    def reached(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    try:
        yield reached
    finally:
        bar.close()
