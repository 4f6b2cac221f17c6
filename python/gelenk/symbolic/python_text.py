# SPDX-License-Identifier: BSD-3-Clause
"""What texts in Python share."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gelenk.symbolic.dialect import Dialect
from gelenk.symbolic.system import Quantity, System
from gelenk.symbolic.writer import Writer

type Array = Callable[[tuple[int, ...], Sequence[str]], str]  # of a shape, with these entries


def comment(system: System) -> list[str]:
    """Return the head of a text."""
    return [f"# {line}".rstrip() for line in system.head()]


def unpacking(system: System, letters: str, used: set[str], of: str) -> list[str]:
    """Return the lines that name arguments. of: "np.asarray({}, float)", the list with its letter."""
    return [
        f"{', '.join(argument.name for argument in arguments)}{',' if len(arguments) == 1 else ''}"
        f" = {of.format(letter)}"
        for letter, arguments in system.lists(letters)
        if used & {argument.name for argument in arguments}
    ]


def body(system: System, quantities: Sequence[Quantity], dialect: Dialect, array: Array) -> list[str]:
    """Return the lines that compute quantities, each under its name."""
    outputs = [output for quantity in quantities for output in quantity.outputs(system.graph)]
    writer = Writer(system.graph, dialect, system.names, system.function_names)
    lines, expressions = writer.write(outputs)
    out = [f"{name} = {text}" for name, text in lines]
    entries: dict[str, str] = {}
    for output, text in zip(outputs, expressions, strict=True):
        if len(output.places) > 1 and not text.isidentifier():  # an entry that is there twice
            out.append(f"{output.name} = {text}")
            text = output.name
        entries[output.name] = text
    for quantity in quantities:
        texts = []
        for k in range(len(quantity.terms)):
            row, column = divmod(k, quantity.shape[1]) if len(quantity.shape) == 2 else (0, 0)
            lower = column * quantity.shape[1] + row if quantity.is_symmetric and column > row else k
            texts.append(entries.get(quantity.entry_name(lower), "0"))
        out.append(f"{quantity.name} = {array(quantity.shape, texts)}")
    return out


def nested(shape: tuple[int, ...], texts: Sequence[str]) -> str:
    """Return entries as lists within lists."""
    if not shape:
        return texts[0]
    if len(shape) == 1:
        return f"[{', '.join(texts)}]"
    columns = shape[1]
    return (
        f"[{', '.join(nested((columns,), texts[k * columns : (k + 1) * columns]) for k in range(shape[0]))}]"
    )


def function(name: str, arguments: Sequence[str], text: str, lines: Sequence[str], result: str) -> str:
    """Return the text of a function."""
    inner = "".join(f"    {line}\n" for line in lines)
    return f'def {name}({", ".join(arguments)}):\n    """Return {text}."""\n{inner}    return {result}\n'


def quantity_functions(
    system: System, dialect: Dialect, array: Array, of: str, before: str = ""
) -> list[str]:
    """Return a function for each quantity, and `equations` with M, h, J and gamma. before: a decorator."""
    out = []
    for quantity in system.quantities.values():
        if quantity.name == "rates" and not system.states:
            continue
        used = system.used(list(quantity.terms))
        lines = [
            *unpacking(system, quantity.arguments, used, of),
            *body(system, [quantity], dialect, array),
        ]
        # A function and its result have the same name.
        text = lines.pop().partition(" = ")[2]
        out.append(before + function(quantity.name, list(quantity.arguments), quantity.text, lines, text))
    all_four = [system.quantities[name] for name in ("M", "h", "J", "gamma")]
    terms = [term for quantity in all_four for term in quantity.terms]
    lines = [*unpacking(system, "qvu", system.used(terms), of), *body(system, all_four, dialect, array)]
    out.append(before + function("equations", list("qvu"), "M, h, J and gamma", lines, "M, h, J, gamma"))
    return out
