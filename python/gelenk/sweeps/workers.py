# SPDX-License-Identifier: BSD-3-Clause
"""Where the runs of a sweep are made: threads, processes of their own, a Dask cluster."""

from __future__ import annotations

import contextlib
import os
import pickle
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.sweeps.driver import LOST, Workers
from gelenk.sweeps.plan import Chunk, Plan

type Values = tuple[NDArray[Any], NDArray[np.float64]]  # of parameters and of inputs, a row for each run

THREAD_SECONDS = 0.1  # s that a chunk should take in a thread; it costs some microseconds
PROCESS_SECONDS = (
    1.0  # s in another process, and with a store; a chunk costs milliseconds, and is a file there
)
RETRIES = 3  # of a chunk whose worker has died, before its runs are repeated one by one
LOOPBACK = "127.0.0.1"  # only processes of this machine reach a local cluster, whose scheduler runs any code
CONNECT = 10.0  # s to wait for an answer of the scheduler
RESTART = 30.0  # s to wait for a scheduler that was lost and may be started again
GRACE = 5.0  # s beyond its longest time after which a run that does not return is ended with its process


def processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def threads(plan: Plan, values: Values, count: int, chunk_seconds: float) -> Iterator[Workers]:
    """Yield threads of this process.

    Args:
        plan: the plan of the sweep.
        values: of all runs.
        count: number of threads.
        chunk_seconds: time that a chunk should take [s].
    """
    parameters, inputs = values
    runner = plan.runner
    with ThreadPoolExecutor(count, thread_name_prefix="gelenk-sweep") as pool:

        def submit(first: int, last: int) -> Future[Chunk]:
            return pool.submit(plan.run, first, parameters[first:last], inputs[first:last])

        try:
            yield Workers(submit, count, chunk_seconds, runner.stop)
        finally:
            runner.stop()
            pool.shutdown(cancel_futures=True)
            plan.close()


_plan: Plan | None = None  # of a process that makes runs for another one


def _take_plan(pickled: bytes) -> None:
    global _plan
    _plan = pickle.loads(pickled)


def _run_here(first: int, parameters: NDArray[Any], inputs: NDArray[np.float64]) -> Chunk:
    assert _plan is not None
    return _plan.run(first, parameters, inputs)


@contextmanager
def processes(plan: Plan, values: Values, count: int) -> Iterator[Workers]:
    """Yield processes, in which a run that crashes ends only itself.

    Args:
        plan: the plan of the sweep, which is sent to each process once.
        values: of all runs.
        count: number of processes.

    Raises:
        UsageError: pebble or cloudpickle is not installed.
    """
    pebble = extra("pebble", "processes that may crash are supervised with pebble")
    import multiprocessing

    parameters, inputs = values
    pool = pebble.ProcessPool(
        max_workers=count,
        initializer=_take_plan,
        initargs=[_pickled(plan)],
        context=multiprocessing.get_context("spawn"),
    )

    def submit(first: int, last: int) -> Future[Chunk]:
        longest = (last - first) * plan.max_run_time + GRACE if plan.max_run_time else None
        arguments = (first, parameters[first:last], inputs[first:last])
        future: Future[Chunk] = pool.schedule(_run_here, args=arguments, timeout=longest)
        return future

    def died(error: BaseException) -> str | None:
        if isinstance(error, TimeoutError):
            return f"the run has taken longer than {plan.max_run_time:g} s; its process was ended"
        code = getattr(error, "exitcode", None)
        if isinstance(error, pebble.ProcessExpired):
            how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
            return f"the process of the run ended {how}"
        return None

    try:
        yield Workers(submit, 2 * count, PROCESS_SECONDS, pool.stop, died)
    finally:
        pool.stop()
        pool.join()


def _pickled(plan: Plan) -> bytes:
    cloudpickle = extra("cloudpickle", "functions are sent to other processes by cloudpickle")
    try:
        pickled: bytes = cloudpickle.dumps(plan)
    except (TypeError, pickle.PicklingError) as e:
        raise UsageError(f"outputs: a function cannot be sent to other processes: {e}") from None
    return pickled


@contextmanager
def dask_cluster(plan: Plan, values: Values, cluster: Any, count: int | None) -> Iterator[Workers]:
    """Yield the workers of a Dask cluster.

    Args:
        plan: the plan of the sweep, which is sent to each worker once.
        values: of all runs.
        cluster: "local", the address of a scheduler, or a Client.
        count: number of workers of a local cluster; None: one for each processor.

    Raises:
        UsageError: Dask is not installed, or the scheduler cannot be reached.
    """
    distributed = extra("distributed", "clusters are those of Dask")
    parameters, inputs = values
    with contextlib.ExitStack() as stack:
        client = cluster
        if isinstance(cluster, str):
            client = stack.enter_context(_client(distributed, stack, cluster, count))
        # A task, not data: if the worker that has it dies, another one computes it again.
        shared = client.submit(pickle.loads, _pickled(plan), pure=False, retries=RETRIES)
        executor = client.get_executor(pure=False, retries=RETRIES)

        def submit(first: int, last: int) -> Future[Chunk]:
            arguments = (first, parameters[first:last], inputs[first:last])
            try:
                future: Future[Chunk] = executor.submit(Plan.run, shared, *arguments)
            except Exception:
                if client.status != "running":
                    raise ConnectionError(LOST) from None
                raise
            return future

        def died(error: BaseException) -> str | None:
            if isinstance(error, distributed.KilledWorker):
                return "the worker died while it made the run, and so did those that repeated it"
            if isinstance(error, distributed.CancelledError):
                raise ConnectionError(LOST)
            return None

        def stop() -> None:
            if client.status == "running":
                executor.shutdown(wait=False)

        slots = max(1, sum(client.nthreads().values()))
        try:
            yield Workers(submit, 2 * slots, PROCESS_SECONDS, stop, died)
        finally:
            stop()


def restarted(cluster: Any) -> str | None:
    """Wait for a scheduler that was lost; return its address when it answers again, None if it does not.

    Args:
        cluster: see `dask_cluster`.
    """
    if cluster == "local":
        return None
    distributed = extra("distributed", "clusters are those of Dask")
    address = cluster if isinstance(cluster, str) else getattr(cluster.scheduler, "address", None)
    deadline = time.monotonic() + RESTART
    while address is not None and (left := deadline - time.monotonic()) > 0:
        try:
            distributed.Client(address, timeout=min(left, CONNECT), set_as_default=False).close()
        except (OSError, ValueError):
            time.sleep(min(left, 0.2))
        else:
            return str(address)
    return None


def _client(distributed: Any, stack: contextlib.ExitStack, cluster: str, count: int | None) -> Any:
    if cluster == "local":
        local = distributed.LocalCluster(
            n_workers=count or processors(),
            threads_per_worker=1,
            processes=True,
            host=LOOPBACK,
            dashboard_address=f"{LOOPBACK}:0",
            worker_dashboard_address=f"{LOOPBACK}:0",  # older versions of distributed listen everywhere
        )
        return distributed.Client(stack.enter_context(local))
    try:
        return distributed.Client(cluster, timeout=CONNECT)
    except (OSError, ValueError) as e:
        raise UsageError(
            f"cluster: found {cluster!r}, where no scheduler answers ({e}); expected 'local' or an address "
            "such as tcp://host:8786"
        ) from None
