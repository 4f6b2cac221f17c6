# SPDX-License-Identifier: BSD-3-Clause
"""Equations as formulas of LaTeX."""

from __future__ import annotations

from gelenk.symbolic.graph import Output
from gelenk.symbolic.languages import LaTeX
from gelenk.symbolic.system import Argument, Quantity, System
from gelenk.symbolic.writer import Writer

SYMBOLS = {"phi": r"\varphi", "w": r"\omega", "tau": r"\tau", "gamma": r"\gamma", "Phi": r"\Phi"}
SCALARS = {"kinetic": "T", "potential": "V", "rate": "r", "qdot": r"\dot q", "rates": r"\dot x"}


def symbol(argument: Argument) -> str:
    """Return the symbol of an argument: that of its quantity, with its owner as a subscript."""
    owner, _, quantity = argument.signal.rpartition(".")
    letter, _, number = quantity.replace("]", "").partition("[")
    text = SYMBOLS.get(letter, letter if len(letter) == 1 else rf"\mathrm{{{escaped(letter)}}}")
    subscript = ",".join(part for part in (escaped(owner), number) if part)
    return f"{text}_{{\\mathrm{{{subscript}}}}}" if subscript else text


def escaped(name: str) -> str:
    """Return a name with the characters that LaTeX reads otherwise."""
    return name.replace("_", r"\_").replace("#", r"\#").replace("%", r"\%").replace("&", r"\&")


def entry(quantity: Quantity, k: int) -> str:
    """Return the symbol of an entry: M_{21}."""
    text = SCALARS.get(quantity.name, SYMBOLS.get(quantity.name, quantity.name))
    if not quantity.shape:
        return text
    if len(quantity.shape) == 1:
        return f"{text}_{{{k + 1}}}"
    row, column = divmod(k, quantity.shape[1])
    return f"{text}_{{{row + 1}{',' if max(quantity.shape) > 9 else ''}{column + 1}}}"


def text(system: System) -> str:
    """Return the equations, preceded by the terms that they share; entries that are 0 are left out."""
    arguments = [*system.q, *system.v, *system.u]
    outputs: list[Output] = []
    for quantity in system.quantities.values():
        if quantity.name == "rates" and not system.states:
            continue
        outputs += [
            Output(entry(quantity, output.places[-1]), output.term, output.places)
            for output in quantity.outputs(system.graph)
        ]
    writer = Writer(
        system.graph,
        LaTeX(),
        [symbol(argument) for argument in arguments],
        {},
        "t_{{{}}}",
        system.function_names,
    )
    lines, expressions = writer.write(outputs)
    rows = [f"{name} &= {right}" for name, right in lines]
    rows += [
        f"{output.name} &= {right}"
        for output, right in zip(outputs, expressions, strict=True)
        if output.name != right
    ]
    head = "".join(f"% {line}".rstrip() + "\n" for line in system.head())
    general = r"M(q)\,\dot v + h(q, v, u) + J(q)^{\mathsf T} \lambda &= 0"
    if system.rows:
        general += "\\\\\nJ(q)\\,\\dot v &= \\gamma(q, v, u), \\qquad \\Phi(q, u) = 0"
    return f"{head}\\begin{{align}}\n{general}\\\\\n" + "\\\\\n".join(rows) + "\n\\end{align}\n"
