# SPDX-License-Identifier: BSD-3-Clause
"""Equations as the printers read them: arguments with names, and quantities as terms of a graph."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from gelenk import _core
from gelenk.symbolic.graph import Graph, Output
from gelenk.symbolic.names import function_names, identifier


@dataclass(frozen=True)
class Argument:
    """A number on which the equations depend.

    Attributes:
        name: name in the texts, "phi_A".
        signal: name in the scene, "A.phi".
        unit: its unit.
        text: its meaning.
        start: its value at the start.
    """

    name: str
    signal: str
    unit: str
    text: str
    start: float


@dataclass(frozen=True)
class Quantity:
    """A scalar, a column or a matrix of terms.

    Attributes:
        name: "M".
        text: its meaning.
        shape: () of a scalar, (n,) or (n, m).
        terms: its terms, row by row.
        arguments: on which it depends: some of the letters q, v, u.
    """

    name: str
    text: str
    shape: tuple[int, ...]
    terms: tuple[int, ...]
    arguments: str

    def entry_name(self, k: int) -> str:
        """Return the name of an entry, counted from 1: "M21", "M10_2", "h3"."""
        if not self.shape:
            return self.name
        if len(self.shape) == 1:
            return f"{self.name}{k + 1}"
        row, column = k // self.shape[1] + 1, k % self.shape[1] + 1
        return f"{self.name}{row}{'_' if max(self.shape) > 9 else ''}{column}"

    @property
    def is_symmetric(self) -> bool:
        """Whether it is the mass matrix, of which the lower triangle is written."""
        return self.name == "M"

    def outputs(self, graph: Graph) -> Iterator[Output]:
        """Return the entries that are not 0; of those that are equal by symmetry the lower one."""
        for k, term in enumerate(self.terms):
            if graph.is_zero(term):
                continue
            if not self.is_symmetric:
                yield Output(self.entry_name(k), term, (k,))
                continue
            row, column = divmod(k, self.shape[1])
            if column <= row:
                mirrored = column * self.shape[1] + row
                yield Output(self.entry_name(k), term, (k,) if row == column else (mirrored, k))


@dataclass(frozen=True)
class System:
    """The equations of a scene."""

    name: str
    graph: Graph
    q: tuple[Argument, ...]
    v: tuple[Argument, ...]
    u: tuple[Argument, ...]
    rows: tuple[str, ...]
    notes: tuple[str, ...]
    quantities: Mapping[str, Quantity]
    states: int
    traced: _core.TracedScene

    @property
    def names(self) -> list[str]:
        """The names of all arguments."""
        return [argument.name for argument in (*self.q, *self.v, *self.u)]

    @property
    def identifier(self) -> str:
        """The name of the scene as one of C and Python, in small letters."""
        return identifier(re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", self.name).lower())

    def lists(self, letters: str) -> list[tuple[str, tuple[Argument, ...]]]:
        """Return the lists of arguments with these letters."""
        return [(letter, getattr(self, letter)) for letter in letters]

    def used(self, terms: Iterator[int] | list[int]) -> set[str]:
        """Return the names of the arguments on which terms depend."""
        names = self.names
        return {names[index] for index in self.graph.variables(terms)}

    @cached_property
    def function_names(self) -> dict[int, str]:
        """Names of sines and cosines: cos_A if phi_A is the only angle of A."""
        owners = Counter(argument.signal.rpartition(".")[0] for argument in self.q)
        angles = [""] * len(self.names)
        for k, argument in enumerate(self.q):
            owner = argument.signal.rpartition(".")[0]
            if argument.unit == "rad" and owners[owner] == 1:
                angles[k] = identifier(owner)
        terms = [term for quantity in self.quantities.values() for term in quantity.terms]
        return function_names(self.graph, self.graph.live(terms), self.names, angles)

    def head(self) -> list[str]:
        """Return the lines at the beginning of a text."""
        lines = [
            f"Equations of motion of {self.name}, in SI units:",
            "  M(q) vdot + h(q, v, u) + J(q)^T lambda = 0,  J(q) vdot = gamma(q, v, u),  Phi(q, u) = 0",
        ]
        for letter, arguments in self.lists("qvu"):
            shown = ", ".join(f"{of.signal} [{of.unit or '1'}]" for of in arguments)
            lines.append(f"  {letter}: {shown or 'none'}")
        if self.rows:
            lines.append(f"  constraint equations of: {', '.join(self.rows)}")
        # Names of scenes and units may be any text.
        return [re.sub(r"[\r\n\t]", " ", line) for line in (*lines, *self.notes)]
