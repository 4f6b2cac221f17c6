# SPDX-License-Identifier: BSD-3-Clause
"""Worker processes with time limits: a hang or a crash affects only its own job."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

PATIENCE = 60.0  # s, limit for the start of a process on a busy machine


@dataclass(frozen=True)
class Failure:
    """A job without a result and the reason."""

    reason: str


class _Worker:
    """A process that runs one call at a time, with a deadline."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, far = context.Pipe()
        self.process: SpawnProcess = context.Process(target=_serve, args=(far,), daemon=True)
        self.process.start()
        far.close()
        self.job = -1
        self.deadline = 0.0
        self.limit = 0.0
        try:
            ready = self.pipe.poll(PATIENCE) and self.pipe.recv() == "ready"
        except EOFError:
            ready = False
        if not ready:
            raise OSError("a worker process did not start; a script needs `if __name__ == '__main__':`")

    def give(self, job: int, call: tuple[Callable[..., Any], tuple[Any, ...]], limit: float) -> None:
        self.job, self.limit = job, limit
        self.deadline = time.monotonic() + limit
        self.pipe.send(call)

    def end(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


def work_off(
    calls: Iterable[tuple[Callable[..., Any], tuple[Any, ...], float]],
    jobs: int,
    done: Callable[[int, Any], None] | None = None,
) -> list[Any]:
    """Call functions in worker processes and return their results in the order of the calls.

    A call that raises an exception, crashes or exceeds its limit has a Failure as result.

    Args:
        calls: (function, arguments, wall-clock limit [s]); functions and arguments must be picklable.
        jobs: Number of concurrent processes.
        done: Called with index and result of each call when it finishes.

    Raises:
        OSError: a worker process did not start.
    """
    waiting = list(enumerate(calls))[::-1]
    results: list[Any] = [None] * len(waiting)
    busy: list[_Worker] = []
    idle: list[_Worker] = []
    try:
        while waiting or busy:
            while waiting and len(busy) < jobs:
                index, (function, arguments, limit) = waiting.pop()
                worker = idle.pop() if idle else _Worker()
                worker.give(index, (function, arguments), limit)
                busy.append(worker)
            wait([w.pipe for w in busy], timeout=min(w.deadline for w in busy) - time.monotonic())
            for worker in list(busy):
                result, alive = _answer(worker)
                if result is None:
                    continue
                busy.remove(worker)
                results[worker.job] = result
                if done is not None:
                    done(worker.job, result)
                if alive:
                    idle.append(worker)
                else:
                    worker.end()
    finally:
        for worker in busy + idle:
            worker.end()
    return results


def _answer(worker: _Worker) -> tuple[Any, bool]:
    """Return (result or None, whether the process can be reused)."""
    if worker.pipe.poll():
        try:
            return worker.pipe.recv(), True
        except (EOFError, OSError):
            worker.process.join()
            return Failure(f"the process ended with {_end(worker.process.exitcode)}"), False
    if time.monotonic() >= worker.deadline:
        return Failure(f"timed out after {worker.limit:g} s"), False
    return None, True


def _end(code: int | None) -> str:
    return f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"


def _serve(pipe: Connection) -> None:
    pipe.send("ready")
    while True:
        try:
            function, arguments = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        try:
            result = function(*arguments)
        except Exception as e:  # any error is returned as a failure; the worker continues
            result = Failure(f"{type(e).__name__}: {e}")
        pipe.send(result)
