# SPDX-License-Identifier: BSD-3-Clause
"""Methods that charts compare: a formulation with an integrator, and `auto`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import gelenk
from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.values import unknown

FIXED_STEP = frozenset({"rk4", "euler", "generalized-alpha", "hht", "newmark"})
# Formulations that are no ordinary differential equations, and their partners on charts; others go with all.
OWN_INTEGRATORS = {
    "stabilized-index2": ("ida",),
    "index3": ("ida", "generalized-alpha"),
}
NATURAL = ("erk", "ida")  # what a formulation is charted with, where it goes with all
DEFAULT = "projection"


@dataclass(frozen=True)
class Method:
    """A formulation with an integrator; `auto` leaves both to Gelenk."""

    formulation: str
    integrator: str

    @property
    def name(self) -> str:
        """As on charts: `auto`, or `formulation+integrator`."""
        return "auto" if self.automatic else f"{self.formulation}+{self.integrator}"

    @property
    def automatic(self) -> bool:
        """Gelenk chooses."""
        return self.integrator == "auto"

    @property
    def fixed_step(self) -> bool:
        """Without error control: nothing can be asked of it but a step."""
        return self.integrator in FIXED_STEP

    def solver(self, step: float | None) -> dict[str, Any]:
        """The scene's section `solver`."""
        if self.automatic:
            return {}
        chosen: dict[str, Any] = {"formulation": self.formulation, "integrator": self.integrator}
        return chosen if step is None else {**chosen, "step": step}


AUTO = Method("auto", "auto")


@cache
def registered() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of (formulations, integrators) that the core has, in its order, without `auto`."""
    smallest = gelenk.load("gelenk: 1\nbodies: {b: {mass: 1}}\njoints: {j: {type: prismatic, parent: ground, "
                           "child: b}}\n")  # fmt: skip
    items = {p.name: p.items for p in _core.list_parameters(smallest._core)}
    return tuple(
        tuple(name for name in items[f"solver.{kind}"] if name != "auto")
        for kind in ("formulation", "integrator")
    )  # type: ignore[return-value]


def all_methods() -> list[Method]:
    """`auto`, projection with every integrator, every other formulation with those natural to it."""
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
    """Methods by name: `auto`, `formulation+integrator`, or one of both, the other as it is natural.

    Raises:
        UsageError: a name that stands for no method.
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
