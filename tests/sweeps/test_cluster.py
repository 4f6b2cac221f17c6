# SPDX-License-Identifier: BSD-3-Clause
"""Sweeps in other processes: the same results, also if workers die, runs crash or do not end."""

from __future__ import annotations

import gc
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gelenk
from gelenk.sweeps import driver, workers
from sweeps.test_runs import same

distributed = pytest.importorskip("distributed")


def made(four_bar: gelenk.Scene, **options: Any) -> xr.Dataset:
    given: dict[str, Any] = {
        "design": "sobol", "samples": 64, "seed": 1, "stop": 0.1,
        "outputs": {"A.phi": ["max", lambda t, x: float(x[-1] * t[-1]), "trajectory"]},
    }  # fmt: skip
    parameters = {"crank.m": "uniform(0.9, 1.1)", "A.damping": "uniform(-0.01, 0.1)"}
    return gelenk.sweep(four_bar, parameters, **given | options)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """A cluster of two processes."""
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driver, "GROWTH", 1)  # one run each


def test_a_cluster_gives_the_results_of_threads(four_bar: gelenk.Scene, client: Any) -> None:
    assert same(made(four_bar, cluster=client), made(four_bar))


def test_the_plan_is_sent_to_each_worker_once(
    four_bar: gelenk.Scene, client: Any, monkeypatch: pytest.MonkeyPatch, short_chunks: None
) -> None:
    del short_chunks
    sent: list[int] = []
    pickled = workers._pickled

    def counted(plan: Any) -> bytes:
        sent.append(1)
        return pickled(plan)

    monkeypatch.setattr(workers, "_pickled", counted)
    made(four_bar, cluster=client)
    assert sent == [1]


def test_a_killed_worker_loses_nothing(four_bar: gelenk.Scene, client: Any, short_chunks: None) -> None:
    del short_chunks
    expected = made(four_bar)
    process = next(iter(client.run(os.getpid).values()))
    killed: list[int] = []

    def kill(done: int, _: int) -> None:
        if done >= 8 and not killed:
            killed.append(process)
            os.kill(process, signal.SIGKILL)

    assert same(made(four_bar, cluster=client, progress=kill), expected)
    assert killed


@pytest.mark.thorough
def test_a_local_cluster_is_made_for_the_sweep(four_bar: gelenk.Scene) -> None:
    found = gelenk.sweep(
        four_bar, {"crank.m": [0.9, 1.0]}, outputs={"A.w": "last"}, stop=0.01, cluster="local", workers=1
    )
    assert same(found, gelenk.sweep(four_bar, {"crank.m": [0.9, 1.0]}, outputs={"A.w": "last"}, stop=0.01))


@pytest.mark.thorough
def test_a_local_cluster_is_reached_from_this_machine_only(four_bar: gelenk.Scene) -> None:
    """Whoever reaches a port of it can run code: all of them are on the loopback interface."""
    psutil = pytest.importorskip("psutil")

    def addresses() -> set[Any]:
        me = psutil.Process()
        all_of_them = [c for p in (me, *me.children(recursive=True)) for c in p.net_connections(kind="inet")]
        return {c.laddr for c in all_of_them if c.status == psutil.CONN_LISTEN}

    before, found = addresses(), set()
    gelenk.sweep(
        four_bar, {"crank.m": [0.9, 1.0]}, outputs={"A.w": "last"}, stop=0.01, cluster="local", workers=1,
        progress=lambda *_: found.update(addresses() - before),
    )  # fmt: skip
    assert {address.ip for address in found} == {"127.0.0.1"}


def crash_or_hang(_: Any, x: Any) -> float:
    """Of the initial angle: end the process, wait, or return it."""
    if x[0] > 1.6:
        os.kill(os.getpid(), signal.SIGSEGV)
    if x[0] < 1.5:
        time.sleep(1000)
    return float(x[0])


@pytest.mark.thorough
def test_a_run_that_crashes_or_hangs_ends_only_itself(
    four_bar: gelenk.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "GRACE", 1.0)
    start = np.full(12, 1.55)
    start[4], start[9] = 1.65, 1.45
    found = gelenk.sweep(
        four_bar, {"A.phi_start": start, "crank.m": np.linspace(0.9, 1.1, 12)}, design="list", stop=0.01,
        outputs={"A.phi": crash_or_hang}, isolate=True, workers=2, max_run_time=0.5,
    )  # fmt: skip
    errors = found["error"].values.tolist()
    assert errors[4] == "the process of the run ended by signal 11"
    assert errors[9] == "the run has taken longer than 0.5 s; its process was ended"
    assert [i for i, error in enumerate(errors) if error] == [4, 9]
    values = found["A.phi.crash_or_hang"].values
    assert np.flatnonzero(np.isnan(values)).tolist() == [4, 9]
    assert set(values[~np.isnan(values)]) == {1.55}


class Restarted:
    """A cluster of two processes, the scheduler of which can be killed and started again."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        self.processes: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        port = self.address.rpartition(":")[2]
        scheduler = ["scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard"]
        worker = ["worker", self.address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
        self.processes = [
            subprocess.Popen(
                [sys.executable, "-m", "dask", *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            for command in (scheduler, worker)
        ]

    def kill(self) -> None:
        """Kill the scheduler; without it, the worker ends."""
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def restarted() -> Iterator[Restarted]:
    cluster = Restarted()
    cluster.start()
    yield cluster
    cluster.kill()


@pytest.mark.thorough
def test_a_scheduler_that_is_killed_and_started_again_loses_nothing(
    four_bar: gelenk.Scene, restarted: Restarted, short_chunks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No store is needed: what was returned is kept, and the rest is made after the restart."""
    del short_chunks
    monkeypatch.setattr(workers, "CONNECT", 60.0)  # s: Python and Dask are loaded on a busy machine
    monkeypatch.setattr(workers, "RESTART", 60.0)
    progress: list[int] = []
    kills: list[int] = []

    def kill(done: int, _: int) -> None:
        progress.append(done)
        if done >= 8 and not kills:
            kills.append(done)
            restarted.kill()
            restarted.start()

    assert same(made(four_bar, cluster=restarted.address, progress=kill), made(four_bar))
    assert kills
    assert kills[0] < 64
    assert progress == sorted(set(progress))  # nothing was made twice
    assert progress[-1] == 64


@pytest.mark.thorough
def test_a_scheduler_that_is_lost_leaves_a_store_that_continues(
    four_bar: gelenk.Scene, tmp_path: Any, short_chunks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    del short_chunks
    monkeypatch.setattr(workers, "RESTART", 0.5)  # s: nobody starts it again
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0")
    lost = distributed.Client(cluster, timeout=2)

    def lose(done: int, _: int) -> None:
        if done == 5:
            thread = threading.Thread(target=cluster.close)
            thread.start()
            thread.join()

    with pytest.raises(ConnectionError, match="the connection to the scheduler was lost"):
        made(four_bar, cluster=lost, store=tmp_path, progress=lose)
    lost.close()
    stored = len(list(tmp_path.glob("runs-*.parquet")))
    assert 5 <= stored < 64
    assert same(made(four_bar, store=tmp_path), made(four_bar))


@pytest.mark.thorough
def test_a_sweep_that_takes_too_long_ends(four_bar: gelenk.Scene, client: Any) -> None:
    """Each run lasts for some 0.05 s, so that some of them are made within the time, and not all."""
    found = gelenk.sweep(
        four_bar, {"crank.m": np.linspace(0.9, 1.1, 1000), "solver.integrator": "rk4"}, stop=25.0,
        outputs={"A.phi": "last"}, max_time=2.0, cluster=client,
    )  # fmt: skip
    errors = found["error"].values.tolist()
    assert set(errors) == {"", "the run was not made within the time of the sweep, 2 s"}
    assert np.isnan(found["A.phi.last"].values).tolist() == [bool(error) for error in errors]


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # pipes and processes of dask-jobqueue
@pytest.mark.thorough
def test_jobs_of_a_batch_system_are_workers(four_bar: gelenk.Scene) -> None:
    """Through the scripts of dask-jobqueue, run by a shell instead of a batch system."""
    local = pytest.importorskip("dask_jobqueue.local")
    distributed = pytest.importorskip("distributed")
    options = {"cores": 1, "processes": 1, "memory": "1GB", "scheduler_options": {"dashboard_address": ":0"}}
    with local.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        cluster.scale(1)
        assert made(four_bar, cluster=client).equals(made(four_bar))
    gc.collect()  # what it leaves open warns here
