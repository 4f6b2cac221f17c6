# SPDX-License-Identifier: BSD-3-Clause
"""Processes that work off jobs within limits of time: a run that hangs or crashes ends its own only."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

PATIENCE = 60.0  # s for a process to come up, on a busy machine


@dataclass(frozen=True)
class Failure:
    """A job without a result, and why."""

    reason: str


class _Worker:
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
            raise OSError("a process for the runs did not start; a script needs `if __name__ == '__main__':`")

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
    told: Callable[[int, Any], None] | None = None,
) -> list[Any]:
    """Results of function(*arguments) in the order of the calls; a Failure for each that did not end well.

    Args:
        calls: (function, arguments, limit [s]); functions and arguments that can be pickled.
        jobs: processes at a time.
        told: called with the index and the result of each as it ends.
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
                if told is not None:
                    told(worker.job, result)
                if alive:
                    idle.append(worker)
                else:
                    worker.end()
    finally:
        for worker in busy + idle:
            worker.end()
    return results


def _answer(worker: _Worker) -> tuple[Any, bool]:
    """(result or None, whether the process can go on)."""
    if worker.pipe.poll():
        try:
            return worker.pipe.recv(), True
        except (EOFError, OSError):
            worker.process.join()
            return Failure(f"the process ended with {_end(worker.process.exitcode)}"), False
    if time.monotonic() >= worker.deadline:
        return Failure(f"no end within {worker.limit:g} s"), False
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
        except Exception as e:  # whatever it is, it is told as a failure and the next job goes on
            result = Failure(f"{type(e).__name__}: {e}")
        pipe.send(result)
