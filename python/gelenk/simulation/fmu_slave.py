# SPDX-License-Identifier: BSD-3-Clause
"""Instances of FMUs, loaded by fmpy, with a logger of Gelenk."""

from __future__ import annotations

import platform
import sys
from contextlib import chdir
from ctypes import c_void_p
from pathlib import Path
from typing import Any

from fmpy import fmi2

from gelenk import _core
from gelenk.simulation.fmi3 import Model3, Slave3


def _library(folder: str, identifier: str) -> str | None:
    """Return the library where fmpy does not find it: on 64-bit ARM, fmpy looks for that of x86-64."""
    if sys.platform == "linux" and platform.machine() in ("aarch64", "arm64"):
        return str(Path(folder, "binaries", "aarch64-linux", f"{identifier}.so").absolute())
    return None


def instantiated(
    kind: type, folder: str, guid: str, identifier: str, log: _core.FmuLog, *, verbose: bool
) -> Any:
    """Load and instantiate an FMU.

    fmpy's own logger is not used: `instantiate_fmu(logger=...)` stores it in one pointer for the whole
    process, which dangles after the last FMU with a logger is closed, so that the next message of any FMU
    uses freed memory.

    Args:
        kind: fmpy's FMU2Slave or FMU2Model, or Slave3 or Model3.
        folder: folder with the extracted FMU.
        guid: identifier of the FMU.
        identifier: name of its library.
        log: receives the messages of the FMU; must live as long as the instance.
        verbose: whether the FMU logs all of its messages, or only errors and warnings.

    Returns:
        Any: an instance of `kind`.

    Raises:
        Exception: the library cannot be loaded or returns no instance.
    """
    # fmpy changes to the library's directory and remains there if the library cannot be loaded.
    is_fmi3 = issubclass(kind, (Slave3, Model3))
    with chdir(Path.cwd()):
        slave = kind(
            guid=guid,
            unzipDirectory=folder,
            modelIdentifier=identifier,
            **({"instanceName": identifier} if is_fmi3 else {"libraryPath": _library(folder, identifier)}),
        )
    try:
        if is_fmi3:
            slave.begin(log, verbose=verbose)
        else:
            _begin(slave, log, verbose=verbose)
    except BaseException:
        slave.freeLibrary()
        raise
    return slave


def _begin(slave: Any, log: _core.FmuLog, *, verbose: bool) -> None:
    """Create the instance of an FMU of FMI 2.0."""
    callbacks = fmi2.fmi2CallbackFunctions(
        logger=fmi2.fmi2CallbackLoggerTYPE(log.logger),
        allocateMemory=fmi2.defaultCallbacks.allocateMemory,
        freeMemory=fmi2.defaultCallbacks.freeMemory,
        componentEnvironment=c_void_p(log.environment),
    )
    slave.instantiate(callbacks=callbacks, loggingOn=verbose)  # keeps a reference to the callbacks
