# SPDX-License-Identifier: BSD-3-Clause
"""Places in the sources that can be mutated.

- A threshold is a named constant with a number: it becomes a thousand times larger or smaller; a count, or a
  number from 0.05 to 20, twice or half as large.
- A guard is a condition after which a function returns, raises or goes on to the next case: it never holds.
- A fall-back is what handles an exception: it is not there.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[2]
NATIVE = ("src", "modelDescription", "fmu", "python/bindings")
NUMBER = r"-?\d+(?:\.\d*)?(?:e-?\d+)?"
CONSTANT = re.compile(rf"^(?:inline |static )*constexpr (double|int|long) (\w+) = ({NUMBER});", re.MULTILINE)
GUARD = re.compile(
    r"^ +(?:\} else )?if \((?!constexpr)(.*)\) (return|continue|break|throw)\b.*;", re.MULTILINE
)
HANDLER = re.compile(r"^ *\} catch \([^)]*\) \{$", re.MULTILINE)


@dataclass(frozen=True)
class Mutant:
    """A file of the sources with one place changed."""

    path: Path
    line: int
    kind: str  # threshold, guard, fall-back
    before: str
    after: str
    text: str  # of the whole file

    def __str__(self) -> str:
        place = f"{self.path.relative_to(ROOT)}:{self.line}"
        return f"{place}: {self.kind}: {self.before.strip()} -> {self.after.strip()}"


def scaled(number: str, larger: bool) -> str:
    """Another value of a threshold."""
    value = float(number)
    if re.fullmatch(r"-?\d+", number):
        return str(int(value) * 2 if larger or abs(value) < 2 else int(value) // 2)
    factor = 2.0 if 0.05 <= abs(value) <= 20 else 1000.0
    return f"{value * factor if larger else value / factor:.12g}"


def changed(path: Path, text: str, start: int, end: int, new: str, kind: str) -> Mutant:
    mutated = text[:start] + new + text[end:]
    line = text.count("\n", 0, start) + 1
    lines, others = text.splitlines(), mutated.splitlines()
    return Mutant(path, line, kind, lines[line - 1], others[line - 1], mutated)


def of_native(path: Path, text: str, larger: bool) -> Iterator[Mutant]:
    for found in CONSTANT.finditer(text):
        if float(found[3]) != 0:
            yield changed(path, text, *found.span(3), scaled(found[3], larger), "threshold")
    for found in GUARD.finditer(text):
        if found[1].count("(") == found[1].count(")") and ";" not in found[1]:
            yield changed(path, text, *found.span(1), f"false && ({found[1]})", "guard")
    for found in HANDLER.finditer(text):
        yield changed(path, text, found.end(), found.end(), " throw;", "fall-back")


def of_python(path: Path, text: str, larger: bool) -> Iterator[Mutant]:
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def at(line: int, column: int) -> int:
        """Of a place in the syntax tree, whose columns count bytes."""
        begin = text[starts[line - 1] : starts[line]].encode()[:column]
        return starts[line - 1] + len(begin.decode())

    def span(node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return at(node.lineno, node.col_offset), at(node.end_lineno, node.end_col_offset)

    tree = ast.parse(text)
    for node in tree.body:
        value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        if isinstance(value, ast.Constant) and type(value.value) in (int, float) and value.value:
            start, end = span(value)
            number = text[start:end].replace("_", "")
            if re.fullmatch(NUMBER, number):  # others are no thresholds: 0x...
                yield changed(path, text, start, end, scaled(number, larger), "threshold")
    for each in ast.walk(tree):
        if isinstance(each, ast.If) and not each.orelse:
            if isinstance(each.body[-1], ast.Return | ast.Raise | ast.Continue) and not is_for_types(each):
                yield changed(path, text, *span(each.test), "False", "guard")
        elif isinstance(each, ast.ExceptHandler):
            first = each.body[0]
            begin = at(first.lineno, first.col_offset)
            yield changed(path, text, begin, begin, "raise; ", "fall-back")


def is_for_types(node: ast.If) -> bool:
    return "TYPE_CHECKING" in ast.unparse(node.test) or "sys.platform" in ast.unparse(node.test)


def native_files() -> list[Path]:
    return sorted(p for room in NATIVE for end in ("cpp", "h") for p in (ROOT / room).rglob(f"*.{end}"))


def python_files() -> list[Path]:
    return sorted((ROOT / "python" / "gelenk").rglob("*.py"))


def found_in(files: list[Path], of: Callable[[Path, str, bool], Iterator[Mutant]], r: Random) -> list[Mutant]:
    """All mutants of files."""
    return [m for path in files for m in of(path, path.read_text(encoding="utf-8"), r.random() < 0.5)]


def drawn(count: int, seed: int) -> list[Mutant]:
    """As many mutants: half in C++, half in Python; of each half, a third of each kind, if there are."""
    r = Random(seed)
    native, python = found_in(native_files(), of_native, r), found_in(python_files(), of_python, r)
    out = []
    for found, share in ((native, count - count // 2), (python, count // 2)):
        for i, kind in enumerate(("threshold", "guard", "fall-back")):
            of_kind = [mutant for mutant in found if mutant.kind == kind]
            out += r.sample(of_kind, min(len(of_kind), (share + i) // 3))
    return out
