# SPDX-License-Identifier: BSD-3-Clause
"""Texts of random expressions have their values: parentheses, signs, shared terms."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from gelenk.symbolic.graph import Graph, Output
from gelenk.symbolic.languages import C, LaTeX, NumPy
from gelenk.symbolic.names import argument_names
from gelenk.symbolic.writer import Writer

NAMES = ["phi_A", "w_A", "tau"]
TWO: dict[str, Callable[[float, float], float]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
}
ONE: dict[str, Callable[[float], float]] = {"negate": lambda a: -a, "sin": math.sin, "atan": math.atan}


def random_graph(seed: int) -> tuple[Graph, list[float], list[float]]:
    """Nodes, the values of the arguments and of all nodes."""
    rng = np.random.default_rng(seed)
    arguments = [float(x) for x in rng.uniform(0.5, 2.0, size=3)]
    nodes: list[tuple[str, list[int], int, float]] = [("variable", [], k, 0.0) for k in range(3)]
    values = list(arguments)
    for constant in (-3.0, 0.5, 1e-5):
        nodes.append(("constant", [], 0, constant))
        values.append(constant)
    while len(nodes) < 40:
        a, b, g = (int(k) for k in rng.integers(0, len(nodes), size=3))
        kind = str(rng.choice([*TWO, *ONE, "choose", "integer_power"]))
        if kind == "choose":
            nodes.append((kind, [g, a, b], 0, 0.0))
            values.append(values[a] if values[g] > 0 else values[b])
        elif kind == "integer_power":
            nodes.append((kind, [a], 2, 0.0))
            values.append(values[a] ** 2)
        elif kind in TWO:
            if kind == "divide" and values[b] == 0:
                continue
            nodes.append((kind, [a, b], 0, 0.0))
            values.append(TWO[kind](values[a], values[b]))
        else:
            # The core joins signs: there is none before a negative number or another sign.
            if kind == "negate" and nodes[a][0] in ("negate", "constant", "multiply", "divide"):
                continue
            nodes.append((kind, [a], 0, 0.0))
            values.append(ONE[kind](values[a]))
        if not abs(values[-1]) < 1e6:
            nodes.pop()
            values.pop()
    return Graph(nodes), arguments, values


@pytest.mark.parametrize("seed", range(200))
def test_a_text_has_the_value_of_its_graph(seed: int) -> None:
    graph, arguments, values = random_graph(seed)
    terms = range(30, 40)
    outputs = [Output(f"y{k}", k) for k in terms]
    lines, expressions = Writer(graph, NumPy(), NAMES, {}).write(outputs)
    known: dict[str, object] = {"np": np, **dict(zip(NAMES, map(np.float64, arguments), strict=True))}
    for name, text in lines:
        known[name] = eval(text, known)
    for k, text in zip(terms, expressions, strict=True):
        assert eval(text, known) == pytest.approx(values[k], rel=1e-9, abs=1e-9 * max(map(abs, values)))


def test_what_is_shared_is_written_once() -> None:
    """sin(phi) + sin(phi)*w has one sine."""
    product = [("variable", [], 0, 0), ("variable", [], 1, 0), ("sin", [0], 0, 0), ("multiply", [2, 1], 0, 0)]
    graph = Graph([*product, ("add", [2, 3], 0, 0)])
    lines, expressions = Writer(graph, C(), NAMES, {2: "sin_A"}).write([Output("y", 4)])
    assert lines == [("sin_A", "sin(phi_A)")]
    assert expressions == ["sin_A + sin_A*w_A"]


def test_functions_of_latex_do_not_reach_beyond_their_argument() -> None:
    """In sin x y, y could be read as a part of the argument."""
    graph = Graph(
        [("variable", [], 0, 0), ("variable", [], 1, 0), ("sin", [0], 0, 0), ("multiply", [2, 1], 0, 0)]
    )
    _, (text,) = Writer(graph, LaTeX(), [r"\varphi", "w"], {}).write([Output("y", 3)])
    assert text == r"w \, \sin \varphi"


def test_names_are_those_of_signals_turned_around() -> None:
    signals = ["A.phi", "S.q[2]", "drive.tau", "t", "lambda", "a.b.w", "b_a.w"]
    names = argument_names(signals)
    assert names[:5] == ["phi_A", "q2_S", "tau_drive", "t", "lambda_"]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z]\w*", name) for name in names)
