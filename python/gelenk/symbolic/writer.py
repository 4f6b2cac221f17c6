# SPDX-License-Identifier: BSD-3-Clause
"""Terms of a graph as assignments: what is used more than once gets a line and a name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from itertools import count

from gelenk.errors import UsageError
from gelenk.symbolic.dialect import ATOM, Dialect, Written
from gelenk.symbolic.graph import Graph, Output

LONGEST = 14  # operations that are written into one line; more become lines of their own


class Writer:
    """Writes outputs in a language.

    Args:
        graph: the graph.
        dialect: how the language writes operations.
        names: of the arguments, by index.
        given: names of nodes that have one.
        temporary: names of others, with {} for their number.
        written_out: nodes that never get a line of their own.
    """

    def __init__(
        self,
        graph: Graph,
        dialect: Dialect,
        names: Sequence[str],
        given: Mapping[int, str],
        temporary: str = "t{}",
        written_out: Collection[int] = (),
    ) -> None:
        self._graph = graph
        self._dialect = dialect
        self._names = names
        self._given = dict(given)
        self._temporary = temporary
        self._written_out = written_out

    def write(self, outputs: Sequence[Output]) -> tuple[list[tuple[str, str]], list[str]]:
        """Return the assignments, as (name, expression) in their order, and the expression of each output.

        Outputs that others use, or that are used twice, have an assignment with their name.
        """
        graph = self._graph
        live = graph.live(output.term for output in outputs)
        uses = Counter(of for term in live for of in graph[term].of)
        uses.update(output.term for output in outputs)
        named = {term: name for term, name in self._given.items() if term in uses}
        for output in outputs:
            if uses[output.term] > 1 and not self._is_short(output.term):
                named.setdefault(output.term, output.name)
        taken = {*self._names, *named.values()}
        free = (name for k in count(1) if (name := self._temporary.format(k)) not in taken)
        lines: list[tuple[str, str]] = []
        written: dict[int, Written] = {}
        sizes: dict[int, int] = {}
        for term in live:
            node = graph[term]
            text = self._written(term, written)
            size = 1 + sum(sizes[of] for of in node.of)
            is_leaf = node.operation in ("constant", "variable")
            is_long = (
                size > LONGEST
                and term not in self._written_out
                and not any(output.term == term for output in outputs)
            )
            if not is_leaf and (term in named or (uses[term] > 1 and not self._is_short(term)) or is_long):
                name = named[term] if term in named else next(free)
                lines.append((name, text[0]))
                text, size = (name, ATOM), 0
            written[term] = text
            sizes[term] = 0 if is_leaf else size
        return lines, [written[output.term][0] for output in outputs]

    # A sign alone is no line of its own.
    def _is_short(self, term: int) -> bool:
        if term in self._written_out:
            return True
        node = self._graph[term]
        if node.operation == "negate":
            return self._graph[node.of[0]].operation in ("variable", "constant")
        return node.operation in ("variable", "constant")

    def _written(self, term: int, written: Mapping[int, Written]) -> Written:
        node = self._graph[term]
        if node.operation == "constant":
            return self._dialect.number(node.value)
        if node.operation == "variable":
            return self._names[node.index], ATOM
        if node.operation == "lookup":
            raise UsageError("tables: found one in the equations; expected formulas without tables")
        return self._dialect.operation(node.operation, node.index, [written[of] for of in node.of])
