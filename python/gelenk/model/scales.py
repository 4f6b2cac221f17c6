# SPDX-License-Identifier: BSD-3-Clause
"""Units of a mechanism's own size, in which tolerances apply: equally for micrometers and kilometers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Exponents of mass, length and time in unit symbols.
_SYMBOLS = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "rad": (0, 0, 0), "1": (0, 0, 0),
    "N": (1, 1, -2), "J": (1, 2, -2), "W": (1, 2, -3), "Hz": (0, 0, -1),
}  # fmt: skip
_FACTOR = re.compile(r"(kg|rad|Hz|[mNJWs1])(\d*)")


@dataclass(frozen=True)
class Scales:
    """The own units of a mechanism: powers of two, so that conversions cause no rounding errors.

    Attributes:
        length: a length of about the mechanism's size [m]; 1 for ordinary or unknown sizes.
        mass: a mass of about those of its bodies [kg]; 1 for ordinary or unknown masses.
        time: a time of about that of its motion [s]; 1 for ordinary or unknown times.
    """

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def size(self, unit: str) -> float:
        """Return the SI value of 1 own unit.

        Args:
            unit: the unit in SI, as FMI spells it; unknown units are dimensionless.
        """
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
        """Return the SI values of 1 own unit for several units, shape (units,)."""
        return np.array([self.size(unit) for unit in units], np.float64)
