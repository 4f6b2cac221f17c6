# SPDX-License-Identifier: BSD-3-Clause
"""All scenarios by name. Run one: python -m fmu.scenarios NAME FOLDER, in a process of its own, so that a
crash fails one test only. FOLDER holds the crank-rocker of plants.py, extracted.
"""

from __future__ import annotations

import sys
from pathlib import Path

from fmu import derivatives, exchange_calls, hosts, runs, states, wrong_calls
from fmu.host import Fmu

SCENARIOS = {
    name: function
    for module in (wrong_calls, runs, states, hosts, derivatives, exchange_calls)
    for name, function in vars(module).items()
    if getattr(function, "__module__", "") == module.__name__
    and getattr(function, "__annotations__", {}).get("fmu") == "Fmu"
}

if __name__ == "__main__":
    try:
        SCENARIOS[sys.argv[1]](Fmu(Path(sys.argv[2])))
        print("done")
    except hosts.UnavailableError as missing:
        print(f"skip: {missing}")
