# SPDX-License-Identifier: BSD-3-Clause
"""Python programs in processes of their own, without the half second that importing Gelenk takes.

Each is forked from a server that has imported what most of them need, a forkserver of `multiprocessing`.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
import runpy
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(
    ["numpy", "fmpy", "control", "pydantic", "PIL.Image", "gelenk.cli.commands", "gelenk.simulation.run",
     "gelenk.simulation.replay", "gelenk.linear.linearization", "gelenk.equilibria.trim",
     "gelenk.modal.analysis", "gelenk.io.export", "gelenk.viewer.drawing.files"]
)  # fmt: skip
# What an interpreter reads when it starts.
AT_START = ("PYTHON", "LC_", "LANG", "MALLOC", "LD_", "GLIBC")


def started(name: str) -> bool:
    """Whether a variable of the environment takes effect only when an interpreter starts."""
    return name.startswith(AT_START) and name != "PYTHONPATH"


def run(
    *arguments: object,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
    merged: bool = False,
    timeout: float = 120,
) -> subprocess.CompletedProcess[str]:
    """Run `python ARGUMENTS`, where these are `-m MODULE ...` or `FILE ...`.

    Args:
        arguments: as on the command line.
        cwd: the folder to run in; default: the current one.
        env: further variables of the environment.
        merged: stderr goes where stdout goes.
        timeout: s, after which the program is killed.

    Raises:
        subprocess.TimeoutExpired: the program took too long.
    """
    words, variables = [*map(str, arguments)], dict(env or {})
    if any(started(name) for name in variables):
        return subprocess.run(
            [sys.executable, *words], cwd=cwd, env=os.environ | variables, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT if merged else subprocess.PIPE, text=True,
            timeout=timeout, check=False,
        )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        out, err = Path(folder, "out"), Path(folder, "out" if merged else "err")
        given = (words, str(cwd or Path.cwd()), dict(os.environ) | variables, str(out), str(err))
        process = SERVER.Process(target=_run, args=given)
        process.start()
        process.join(timeout)
        if process.exitcode is None:
            process.kill()
            process.join()
            raise subprocess.TimeoutExpired(words, timeout)
        text, errors = out.read_text(encoding="utf-8"), "" if merged else err.read_text(encoding="utf-8")
        return subprocess.CompletedProcess(words, process.exitcode, text, errors)


def gelenk(
    *arguments: object,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
    merged: bool = False,
) -> subprocess.CompletedProcess[str]:
    """Run the command `gelenk ARGUMENTS`: see `run`."""
    return run("-m", "gelenk", *arguments, cwd=cwd, env=env, merged=merged, timeout=600)


def _run(words: list[str], cwd: str, environment: dict[str, str], out: str, err: str) -> None:
    """Be the program, in the forked process."""
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(cwd)
    for number, name in ((1, out), (2, err)):
        file = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        os.dup2(file, number)
        os.close(file)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", buffering=1, closefd=False)  # noqa: SIM115
    paths = [path for path in environment.get("PYTHONPATH", "").split(os.pathsep) if path]
    try:
        if words[0] == "-m":
            sys.path[:0] = [cwd, *paths]
            sys.argv = words[1:]
            runpy.run_module(words[1], run_name="__main__", alter_sys=True)
        else:
            sys.path[:0] = [str(Path(words[0]).resolve().parent), *paths]
            sys.argv = words
            runpy.run_path(words[0], run_name="__main__")
    except Exception:
        sys.excepthook(*sys.exc_info())
        sys.exit(1)
    finally:
        atexit._run_exitfuncs()
        sys.stdout.flush()
