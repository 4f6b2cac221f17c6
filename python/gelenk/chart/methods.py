# SPDX-License-Identifier: BSD-3-Clause
"""The methods that are compared: formulations combined with integrators, and `auto`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import gelenk
from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.values import unknown

FIXED_STEP = frozenset({"rk4", "euler", "generalized-alpha", "hht", "newmark", "moreau-jean"})
# Formulations that are differential-algebraic equations and their integrators; the others can use any.
OWN_INTEGRATORS = {
    "stabilized-index2": ("ida",),
    "index3": ("ida", "generalized-alpha"),
}
NATURAL = ("erk", "ida")  # integrators compared for formulations that can use any
DEFAULT = "projection"


@dataclass(frozen=True)
class Method:
    """A formulation and an integrator; `auto` leaves both to Gelenk."""

    formulation: str
    integrator: str

    @property
    def name(self) -> str:
        """The name on charts: `auto`, or `formulation+integrator`."""
        return "auto" if self.automatic else f"{self.formulation}+{self.integrator}"

    @property
    def automatic(self) -> bool:
        """Whether Gelenk chooses formulation and integrator."""
        return self.integrator == "auto"

    @property
    def fixed_step(self) -> bool:
        """Whether the integrator has fixed steps, without error control."""
        return self.integrator in FIXED_STEP

    def solver(self, step: float | None) -> dict[str, Any]:
        """Return the section `solver` of a scene.

        Args:
            step: Step size [s] of integrators with fixed steps; None for those with error control.
        """
        if self.automatic:
            return {}
        chosen: dict[str, Any] = {"formulation": self.formulation, "integrator": self.integrator}
        return chosen if step is None else {**chosen, "step": step}


AUTO = Method("auto", "auto")


@cache
def registered() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the core's formulations and integrators, in its order, without `auto`."""
    smallest = gelenk.load("gelenk: 1\nbodies: {b: {mass: 1}}\njoints: {j: {type: prismatic, parent: ground, "
                           "child: b}}\n")  # fmt: skip
    items = {p.name: p.items for p in _core.list_parameters(smallest._core)}
    return tuple(
        tuple(name for name in items[f"solver.{kind}"] if name != "auto")
        for kind in ("formulation", "integrator")
    )  # type: ignore[return-value]


def all_methods() -> list[Method]:
    """Return `auto`, projection with every integrator, and the other formulations with their usual ones."""
    formulations, integrators = registered()
    methods = [AUTO]
    methods += [Method(DEFAULT, integrator) for integrator in integrators]
    for formulation in formulations:
        if formulation == DEFAULT:
            continue
        own = OWN_INTEGRATORS.get(formulation, NATURAL)
        methods += [Method(formulation, name) for name in own if name in integrators]
    return methods


def chosen(names: Iterable[str] | None) -> list[Method]:
    """Return methods by name: `auto`, `formulation+integrator`, or one of the two with its usual partner.

    Args:
        names: Names of methods; None or empty: all methods.

    Raises:
        UsageError: there is no method with one of the names.
    """
    if not names:
        return all_methods()
    formulations, integrators = registered()
    found, faults = [], []
    for name in names:
        formulation, plus, integrator = name.partition("+")
        if name == "auto":
            found.append(AUTO)
        elif not plus and name in integrators:
            found.append(Method(DEFAULT, name))
        elif not plus and name in formulations:
            found.append(Method(name, OWN_INTEGRATORS.get(name, NATURAL)[0]))
        elif plus and formulation in formulations and integrator in integrators:
            found.append(Method(formulation, integrator))
        else:
            wrong, known = (
                (integrator, integrators) if plus and formulation in formulations
                else (formulation, formulations) if plus else (name, ("auto", *formulations, *integrators))
            )  # fmt: skip
            faults.append("--method " + unknown(wrong, "method", known))
    if faults:
        raise UsageError("\n".join(faults))
    return list(dict.fromkeys(found))
