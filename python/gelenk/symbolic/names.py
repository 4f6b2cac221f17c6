# SPDX-License-Identifier: BSD-3-Clause
"""Names that people read: `phi_A` for the signal A.phi, `cos_A` for its cosine."""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection, Sequence

from gelenk.symbolic.graph import Graph

# Words of C, and names that the texts use themselves.
C_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long
register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
"""
OWN_WORDS = """
q v u r dt M h J gamma Phi rate qdot rates vdot lambda_ kinetic potential np sp ca math pi e i k
sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log log10 sqrt cbrt erf pow fabs fmax
y0 y1 yn j0 j1 jn
"""
# Macros of math.h that are no functions.
C_MACROS = """
NAN INFINITY HUGE_VAL HUGE_VALF HUGE_VALL MATH_ERRNO MATH_ERREXCEPT FP_NAN FP_INFINITE FP_ZERO FP_SUBNORMAL
FP_NORMAL FP_FAST_FMA FP_FAST_FMAF FP_FAST_FMAL FP_ILOGB0 FP_ILOGBNAN math_errhandling
"""
TAKEN = {*C_WORDS.split(), *OWN_WORDS.split(), *C_MACROS.split()}
# Entries of matrices and columns: M21, M10_2, h3.
ENTRY = re.compile(r"(M|h|J|gamma|Phi|rate|rates|qdot|a|lambda)\d+(_\d+)?")


def argument_names(signals: Sequence[str]) -> list[str]:
    """Return a name of letters for each signal: "A.phi" -> "phi_A", "S.q[2]" -> "q2_S"."""
    out: list[str] = []
    for signal in signals:
        owner, _, quantity = signal.rpartition(".")
        name = f"{quantity}_{owner}" if owner else quantity
        out.append(unused(identifier(name), out))
    return out


def identifier(text: str) -> str:
    """Return a text as an identifier of C and Python."""
    name = re.sub(r"\W+", "_", re.sub(r"\[(\d+)\]", r"\1", text), flags=re.ASCII).strip("_") or "x"
    name = name if name[0].isalpha() else f"x{name}"
    is_taken = name in TAKEN or keyword.iskeyword(name) or ENTRY.fullmatch(name)
    return f"{name}_" if is_taken else name


def unused(name: str, taken: Collection[str]) -> str:
    """Return the name, with a number if it is taken."""
    found, k = name, 1
    while found in taken:
        k += 1
        found = f"{name}_{k}"
    return found


def function_names(
    graph: Graph, live: Sequence[int], names: Sequence[str], angles: Sequence[str]
) -> dict[int, str]:
    """Return names of the sines and cosines of arguments.

    Args:
        graph: the graph.
        live: the nodes of interest.
        names: those of the arguments.
        angles: of each argument its owner if it has no other argument of this kind: cos_A; or empty.
    """
    out: dict[int, str] = {}
    taken = set(names)
    for term in live:
        node = graph[term]
        if node.operation not in ("sin", "cos") or graph[node.of[0]].operation != "variable":
            continue
        index = graph[node.of[0]].index
        out[term] = unused(f"{node.operation}_{angles[index] or names[index]}", taken)
        taken.add(out[term])
    return out
