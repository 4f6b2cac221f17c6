# SPDX-License-Identifier: BSD-3-Clause
"""Names and values of parameters, inputs and outputs, as given by users."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Collection, Iterable, Sequence

from gelenk.errors import UsageError

type Value = float | int | bool | str


def unknown(name: str, what: str, known: Iterable[str]) -> str:
    """Return the message for an unknown name, with similar names or, if there are few, all names.

    Args:
        name: the unknown name.
        what: what it should name: "output".
        known: the known names.
    """
    names = list(known)
    near = difflib.get_close_matches(name, names, n=3)
    if near:
        return f"{name}: no such {what}; did you mean {' or '.join(near)}?"
    if not names:
        return f"{name}: no such {what}; there are none"
    if len(names) <= 12:
        return f"{name}: no such {what}; there are {', '.join(names)}"
    return f"{name}: no such {what}; there are {', '.join(names[:10])} and {len(names) - 10} more"


def check_names(
    wanted: Sequence[str], known: Collection[str], what: str, missing: Callable[[str], str] | None = None
) -> None:
    """Check that all names of a list are known and occur only once.

    Args:
        wanted: the list.
        known: the known names.
        what: what they name, for messages: "output".
        missing: function that returns the message for an unknown name; None: `unknown`.

    Raises:
        UsageError: a name is unknown or repeated; the message has a line for each fault.
    """
    sentence = missing or (lambda name: unknown(name, what, known))
    faults = [sentence(name) for name in wanted if name not in known]
    faults += [
        f"{name}: found twice, expected once"
        for name in dict.fromkeys(wanted)
        if list(wanted).count(name) > 1
    ]
    if faults:
        raise UsageError("\n".join(faults))


def is_number(text: str) -> bool:
    """Return whether a text is a number, `inf` and `nan` included."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def number(name: str, value: Value, kind: str, items: Iterable[str] = ()) -> float:
    """Convert the value of a parameter to a number.

    Args:
        name: name of the parameter, for messages.
        value: the value given.
        kind: type of the parameter: "real", "integer", "boolean" or "enumeration".
        items: items of an enumeration, numbered from 1.

    Raises:
        UsageError: the value does not have this type, or is not finite.
    """
    if kind == "boolean":
        if value in (True, False):
            return float(value)
        if isinstance(value, str) and value.lower() in ("true", "false", "1", "0"):
            return float(value.lower() in ("true", "1"))
        raise UsageError(f"{name}: found {value!r}, expected true or false")
    names = list(items)
    if kind == "enumeration":
        if isinstance(value, str) and value in names:
            return float(names.index(value) + 1)
        if not isinstance(value, str) and value in range(1, len(names) + 1):
            return float(value)
        raise UsageError(f"{name}: found {value!r}, expected one of {', '.join(names)}")
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise UsageError(f"{name}: found {value!r}, expected a number") from None
    if not math.isfinite(result):
        raise UsageError(f"{name}: found {result}, expected a finite number")
    return result


def start_parameter(name: str) -> str:
    """Return the start parameter of a coordinate, a velocity or a state: A.phi_start, i_start."""
    return name.replace("[", "_start[", 1) if "[" in name else f"{name}_start"


def elements(name: str, count: int) -> list[str]:
    """Return the names of a vector's components: name[1], name[2], ..."""
    return [f"{name}[{i}]" for i in range(1, count + 1)]
