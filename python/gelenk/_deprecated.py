# SPDX-License-Identifier: BSD-3-Clause
"""Public names that have been replaced: the old ones work for one release, with a warning."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any


class DeprecatedAlias:
    """An attribute under its old name; reading it warns with the new name.

    It is defined in the class: `hertz = DeprecatedAlias("frequency_hz")`. Read from the class, it is this
    object.
    """

    def __init__(self, name: str) -> None:
        """Make an alias of the attribute `name` of the same class."""
        self._name = name

    def __set_name__(self, owner: type, old_name: str) -> None:
        self._warning = (
            f"{owner.__name__}.{old_name} is deprecated and will be removed in the next release; "
            f"use {owner.__name__}.{self._name}"
        )

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        if instance is None:
            return self
        warnings.warn(self._warning, DeprecationWarning, stacklevel=2)
        return getattr(instance, self._name)


#: Old keys of JSON objects, and the new ones.
OLD_KEYS = {
    "error": "error_bound",
    "frequency": "natural_frequency",
    "hertz": "frequency_hz",
    "damping": "damping_ratio",
    "length": "chain_length",
    "coasts": "grows_in_position_only",
    "speeds": "velocities",
    "rows": "constraint_equations",
    "freedoms": "degrees_of_freedom",
    "redundant_rows": "redundant_constraints",
    "flat": "is_not_isolated",
    "chosen": "is_default",
}


def with_old_keys(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a JSON object in which values are also found under their old keys, for one release."""
    return {**data, **{old: data[new] for old, new in OLD_KEYS.items() if new in data}}
