# SPDX-License-Identifier: BSD-3-Clause
"""Units of a mechanism's own size: what is small is so in these, in a micrometre as in a kilometre."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Exponents of mass, length and time in the symbols of units.
_SYMBOLS = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "rad": (0, 0, 0), "1": (0, 0, 0),
    "N": (1, 1, -2), "J": (1, 2, -2), "W": (1, 2, -3), "Hz": (0, 0, -1),
}  # fmt: skip
_FACTOR = re.compile(r"(kg|rad|Hz|[mNJWs1])(\d*)")


@dataclass(frozen=True)
class Scales:
    """A length [m], a mass [kg] and a time [s] near those of a mechanism, powers of two: changing to these
    units and back rounds nothing. 1 where the mechanism's are usual, or not known.
    """

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def size(self, unit: str) -> float:
        """The SI value of 1 in these units. unit: as FMI spells it; what is no such unit is a number."""
        out = 1.0
        for sign, part in zip((1, -1), unit.partition("/")[::2], strict=True):
            for symbol in part.replace("/", ".").split(".") if part else ():
                found = _FACTOR.fullmatch(symbol)
                if found is None:
                    return 1.0
                mass, length, time = _SYMBOLS[found[1]]
                base = self.mass**mass * self.length**length * self.time**time
                out *= base ** (sign * int(found[2] or 1))
        return out

    def sizes(self, units: Sequence[str]) -> Array:
        """The same of several."""
        return np.array([self.size(unit) for unit in units], np.float64)
