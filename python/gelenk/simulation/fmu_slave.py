# SPDX-License-Identifier: BSD-3-Clause
"""An instance of an FMU, loaded by fmpy, with a logger of Gelenk's."""

from __future__ import annotations

from contextlib import chdir
from ctypes import c_void_p
from pathlib import Path
from typing import Any

from fmpy import fmi2

from gelenk import _core


def instantiated(folder: str, description: Any, log: _core.FmuLog) -> Any:
    """The instance, as fmpy's FMU2Slave.

    In fmpy `instantiate_fmu(logger=...)` holds the logger of the whole process in one pointer. The last FMU
    with a logger leaves it there when it is closed, and the next message of any FMU in fmpy goes to freed
    memory. So fmpy's is not touched.

    Args:
        folder: where the FMU was extracted.
        description: fmpy's, of an FMU of FMI 2.0 for co-simulation.
        log: takes what the FMU logs; has to live as long as the instance.

    Raises:
        Exception: the library cannot be loaded or makes no instance.
    """
    # fmpy goes to the library's directory and, where the library cannot be loaded, stays there.
    with chdir(Path.cwd()):
        slave = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
    callbacks = fmi2.fmi2CallbackFunctions(
        logger=fmi2.fmi2CallbackLoggerTYPE(_core.fmu_logger),
        allocateMemory=fmi2.defaultCallbacks.allocateMemory,
        freeMemory=fmi2.defaultCallbacks.freeMemory,
        componentEnvironment=c_void_p(log.environment),
    )
    try:
        slave.instantiate(callbacks=callbacks)  # which keeps the callbacks
    except BaseException:
        slave.freeLibrary()
        raise
    return slave
