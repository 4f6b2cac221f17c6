# SPDX-License-Identifier: BSD-3-Clause
"""A graph of expressions as the core has recorded it. It knows no mechanics."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Node:
    """An operation on earlier nodes.

    Attributes:
        operation: its name: "constant", "variable", "add", "sin", ...
        of: the operands, as places in the list of nodes.
        index: of a variable; or the exponent of an "integer_power".
        value: of a constant.
    """

    operation: str
    of: tuple[int, ...]
    index: int
    value: float


@dataclass(frozen=True)
class Output:
    """A result with a name.

    Attributes:
        name: as it is read: "M21".
        term: its node.
        places: where a text stores it: indices of an array.
    """

    name: str
    term: int
    places: tuple[int, ...] = ()


class Graph:
    """Nodes in an order in which each depends on earlier ones only."""

    def __init__(self, nodes: Iterable[tuple[str, Sequence[int], int, float]]) -> None:
        self.nodes = [Node(operation, tuple(of), index, value) for operation, of, index, value in nodes]

    def __getitem__(self, term: int) -> Node:
        return self.nodes[term]

    def is_zero(self, term: int) -> bool:
        """Whether a term is the constant 0."""
        return self[term].operation == "constant" and self[term].value == 0

    def live(self, terms: Iterable[int]) -> list[int]:
        """Return the nodes on which terms depend, and these, in ascending order."""
        found: set[int] = set()
        waiting = list(terms)
        while waiting:
            term = waiting.pop()
            if term not in found:
                found.add(term)
                waiting += self[term].of
        return sorted(found)

    def variables(self, terms: Iterable[int]) -> list[int]:
        """Return the indices of the variables on which terms depend."""
        return sorted(self[k].index for k in self.live(terms) if self[k].operation == "variable")
