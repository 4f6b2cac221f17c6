# SPDX-License-Identifier: BSD-3-Clause
"""Equations as C99 source: no allocation, nothing but the mathematical library."""

from __future__ import annotations

from collections.abc import Sequence

from gelenk.symbolic.c_solver import SOLVE_CONSTRAINED, SOLVE_TREE, accelerations, step
from gelenk.symbolic.graph import Output
from gelenk.symbolic.languages import C
from gelenk.symbolic.system import Quantity, System
from gelenk.symbolic.writer import Writer

WIDTH = 110  # columns of lines that can be broken
FEW_ZEROS = 3  # more are written by a loop


def text(system: System) -> str:
    """Return the source file."""
    name, rows = system.identifier, len(system.rows)
    of = system.quantities
    counts = {"nq": len(system.q), "nv": len(system.v), "nu": len(system.u), "rows": rows}
    sizes = f"enum {{ {', '.join(f'{name}_{key} = {count}' for key, count in counts.items())} }};"
    head = (line.replace("*/", "* /").replace("/*", "/ *") for line in system.head())
    parts = ["/*\n" + "".join(f" * {line}".rstrip() + "\n" for line in head) + " */"]
    parts.append(f"#include <math.h>\n\n{sizes}")
    equations = [of[name] for name in (("M", "h", "J", "gamma") if rows else ("M", "h"))]
    parts.append(function(system, "equations", "qvu", equations, "The matrices, row by row."))
    if rows:
        parts.append(function(system, "constraints", "qu", [of["Phi"]], "Constraint residuals."))
        parts.append(function(system, "rates", "qvu", [of["rate"]], "Their rates; 0 in motion."))
    parts.append(function(system, "qdot", "qv", [of["qdot"]], "Rates of the coordinates."))
    parts.append(function(system, "energy", "qv", [of["kinetic"], of["potential"]], "Energies [J]."))
    if system.states:
        parts.append(function(system, "state_rates", "qvu", [of["rates"]], "Rates of the element states."))
    parts.append((SOLVE_CONSTRAINED if rows else SOLVE_TREE).replace("NAME", name))
    parts.append(accelerations(rows > 0).replace("NAME", name))
    # What else changes with time is the caller's: states, and prescribed motions.
    if not system.states and not any(
        argument.signal == "t" or is_target(argument.signal) for argument in system.u
    ):
        parts.append(step(rows > 0).replace("NAME", name))
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def is_target(signal: str) -> bool:
    """Whether an argument is the value, speed or acceleration of a prescribed motion."""
    return signal.endswith((".value", ".speed", ".acceleration"))


def function(system: System, name: str, letters: str, quantities: Sequence[Quantity], comment: str) -> str:
    """Return a function that writes quantities into arrays."""
    terms = [term for quantity in quantities for term in quantity.terms]
    used = system.used(terms)
    parameters = [f"const double {letter}[]" for letter in letters]
    parameters += [
        f"double {'*' if not of.shape else ''}{of.name}{'[]' if of.shape else ''}" for of in quantities
    ]
    lines = [f"/* {comment} */", f"void {system.identifier}_{name}({', '.join(parameters)}) {{"]
    for letter, arguments in system.lists(letters):
        named = [f"{of.name} = {letter}[{k}]" for k, of in enumerate(arguments) if of.name in used]
        lines += broken("  const double ", named) if named else [f"  (void){letter};"]
    outputs = [output for quantity in quantities for output in quantity.outputs(system.graph)]
    owners = [quantity for quantity in quantities for _ in quantity.outputs(system.graph)]
    assignments, expressions = Writer(system.graph, C(), system.names, system.function_names).write(outputs)
    lines += [f"  const double {left} = {right};" for left, right in assignments]
    for quantity in quantities:
        lines += zeros(system, quantity)
    for quantity, output, expression in zip(owners, outputs, expressions, strict=True):
        lines.append(f"  {''.join(f'{place} = ' for place in places(quantity, output))}{expression};")
    return "\n".join([*lines, "}"])


def places(quantity: Quantity, output: Output) -> list[str]:
    """Return where an output is stored."""
    if not quantity.shape:
        return [f"*{quantity.name}"]
    return [f"{quantity.name}[{k}]" for k in output.places]


def zeros(system: System, quantity: Quantity) -> list[str]:
    """Return the lines that write the entries that are 0."""
    found = [k for k, term in enumerate(quantity.terms) if system.graph.is_zero(term)]
    if not found:
        return []
    if not quantity.shape:
        return [f"  *{quantity.name} = 0;"]
    if len(found) > FEW_ZEROS:
        return [f"  for (int k = 0; k < {len(quantity.terms)}; ++k) {quantity.name}[k] = 0;"]
    return [f"  {' = '.join(f'{quantity.name}[{k}]' for k in found)} = 0;"]


def broken(start: str, items: Sequence[str]) -> list[str]:
    """Return declarations of items, as many in a line as it holds."""
    lines: list[str] = []
    for item in items:
        if lines and len(lines[-1]) + len(item) + 3 <= WIDTH:
            lines[-1] += f", {item}"
        else:
            lines.append(f"{start}{item}")
    return [f"{line};" for line in lines]
