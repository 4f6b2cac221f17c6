# SPDX-License-Identifier: BSD-3-Clause
"""All scenarios by name. Run one: python -m fmu.scenarios NAME FOLDER, in a process of its own, so that a
crash fails one test only. FOLDER holds the crank-rocker of plants.py, extracted.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from fmu import (
    derivatives,
    exchange_calls,
    fmi3_calls,
    fmi3_derivative_calls,
    fmi3_exchange_calls,
    hosts,
    runs,
    states,
    wrong_calls,
)
from fmu.host import Fmu
from fmu.host3 import Fmu3


def scenarios_in(modules: Sequence[ModuleType], kind: type) -> dict[str, Callable[[Any], None]]:
    """The functions of one argument, an FMU of this kind."""
    return {
        name: function
        for module in modules
        for name, function in vars(module).items()
        if getattr(function, "__module__", "") == module.__name__
        and getattr(function, "__annotations__", {}).get("fmu") == kind.__name__
    }


SCENARIOS = scenarios_in((wrong_calls, runs, states, hosts, derivatives, exchange_calls), Fmu)
SCENARIOS_OF_FMI_3 = scenarios_in((fmi3_calls, fmi3_derivative_calls), Fmu3)
EXCHANGE_OF_FMI_3 = scenarios_in((fmi3_exchange_calls,), Fmu3)

if __name__ == "__main__":
    name, folder = sys.argv[1], Path(sys.argv[2])
    try:
        if name in SCENARIOS:
            SCENARIOS[name](Fmu(folder))
        else:
            (SCENARIOS_OF_FMI_3 | EXCHANGE_OF_FMI_3)[name](Fmu3(folder))
        print("done")
    except hosts.UnavailableError as missing:
        print(f"skip: {missing}")
