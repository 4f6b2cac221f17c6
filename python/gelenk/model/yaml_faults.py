# SPDX-License-Identifier: BSD-3-Clause
"""Syntax errors in YAML files, explained in terms of the file instead of the parser."""

from __future__ import annotations

import re
from collections.abc import Callable

import yaml

MAX_SHOWN = 50  # characters of a line in a message


def explained(error: yaml.YAMLError, text: str, file: str) -> str:
    """Return the message for a syntax error: `file:line:column: found ..., expected ...; what to do`.

    Args:
        error: error of the YAML parser.
        text: text of the file.
        file: file name for the message, which has no place if the parser gives none.
    """
    if isinstance(error, yaml.reader.ReaderError) and isinstance(error.character, int):
        index = error.position if error.position < len(text) else text.find(chr(error.character))
        return _at(file, *_place(text, index), f"found the character U+{error.character:04X}, expected text")
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if not isinstance(error, yaml.MarkedYAMLError) or mark is None:
        return f"{file}: {' '.join(str(error).split())}"
    lines = text.splitlines() or [""]
    problem = error.problem or ""
    if place := _odd_space(_Lines(lines, mark)):
        line, column, character = place
        what = f"found the space U+{ord(character):04X}, expected an ordinary space; type it again"
        return _at(file, line, column, what)
    if "block scalar" in (error.context or ""):
        return _at(file, *_block_text(error, _Lines(lines, mark)))
    for pattern, explain in _EXPLANATIONS:
        if pattern in problem:
            line, column, what = explain(error, _Lines(lines, mark))
            return _at(file, line, column, what)
    what = ", ".join(part for part in (error.context, problem) if part)
    return _at(file, mark.line, mark.column, what)


class _Lines:
    """The lines of a text and a place in it, the mark of an error."""

    def __init__(self, lines: list[str], mark: yaml.Mark) -> None:
        self.lines = lines
        self.line = mark.line
        self.column = mark.column

    def here(self) -> str:
        """Return the line of the mark."""
        return self.lines[self.line] if self.line < len(self.lines) else ""

    def above(self, line: int) -> int:
        """Return the last line before a line that contains more than a comment."""
        for k in range(line - 1, -1, -1):
            if self.lines[k].split("#")[0].strip():
                return k
        return line

    def word(self) -> str:
        """Return the word at the mark, for a message."""
        found = re.match(r"[^\s,:\[\]{}]+|\S", self.here()[self.column :])
        return quoted(found[0]) if found else "the end of the file" if self.ends() else "the end of the line"

    def ends(self) -> bool:
        """Whether nothing follows the mark in the text."""
        return not any(line.strip() for line in [self.here()[self.column :], *self.lines[self.line + 1 :]])


# Spaces and invisible characters that YAML takes for letters; texts copied from web pages contain them.
_ODD_SPACE = re.compile("[\u00a0\u1680\u2000-\u200b\u202f\u205f\u3000\ufeff]")


def _odd_space(at: _Lines) -> tuple[int, int, str] | None:
    """Return the first such space outside comments in the line of an error or the one before: its place."""
    for line in (at.above(at.line), at.line):
        found = _ODD_SPACE.search(at.lines[line].split("#")[0]) if line < len(at.lines) else None
        if found:
            return line, found.start(), found[0]
    return None


def quoted(line: str) -> str:
    """Return a line in quotes for a message: without control characters, and abbreviated."""
    shown = "".join(c if c.isprintable() else " " for c in line.strip())
    return f"'{shown if len(shown) <= MAX_SHOWN else shown[:MAX_SHOWN] + '...'}'"


type _Explanation = tuple[int, int, str]  # line and column from 0, message


def _second_colon(_: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    """Explain a `: ` inside a value: a second one in a line, or a value continued from the line above."""
    before = at.here()[: at.column]
    if re.search(r":\s", before):
        return at.line, at.column, (
            f"found a second ': ' in {quoted(at.here())}, expected one `name: value` per line; "
            "begin a new line, or put text in quotes"
        )  # fmt: skip
    above = at.above(at.line)
    if above != at.line and not re.search(r":(\s|$)", at.lines[above]):
        return _without_colon(at, above)
    here, there = _indent(at.here()), _indent(at.lines[above])
    return at.line, here, (
        f"found {quoted(at.here())} indented by {here}, expected {there} as the line above; "
        "indent entries of one block equally"
    )  # fmt: skip


def _without_colon(at: _Lines, line: int) -> _Explanation:
    text = at.lines[line].split("#")[0]
    squeezed = re.match(r"\s*(\w+):(\S.*)", text)
    hint = (
        f"write '{squeezed[1]}: {squeezed[2].strip()}'"
        if squeezed
        else "separate name and value by a colon and a space"
    )
    if re.match(r"\s*-\S", text):
        hint = "write a space after the '-' of a list"
    return line, _indent(text), f"found {quoted(text)}, expected `name: value`; {hint}"


def _no_colon(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    mark = error.context_mark
    return _without_colon(at, at.line if mark is None else mark.line)


def _not_closed(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    """Explain a missing comma or closing bracket in `[...]` or `{...}`."""
    close = "]" if "expected ',' or ']'" in (error.problem or "") else "}"
    opened_at = error.context_mark
    opening = "[" if close == "]" else "{"
    opened = f"the '{opening}' of line {opened_at.line + 1}" if opened_at else f"the '{opening}' before"
    chunk = re.split(r"[,\[\]{}]", at.here()[: at.column])[-1]
    what = f"found {at.word()}" + (f" after {quoted(chunk)}" if chunk.strip() else "")
    hint = "a comma or a bracket is missing"
    if at.here()[at.column : at.column + 1] in ("]", "}"):
        hint = "close each bracket by a matching one"
    if ";" in chunk:
        hint = "separate entries by commas, not semicolons"
    elif "=" in chunk:
        hint = "write `name: value`, not `name=value`"
    return at.line, at.column, f"{what}, expected ',' or '{close}' of {opened}; {hint}"


def _block_end(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    """Explain a line that does not fit the block above."""
    found = re.search(r"found '(.*)'", error.problem or "")
    token = found[1] if found else ""
    opened_at = (error.context_mark.line if error.context_mark else at.line) + 1
    if token in ("]", "}"):
        opening = "[" if token == "]" else "{"
        what = f"found '{token}', which closes nothing, expected it once for each '{opening}'; leave it out"
    elif token == "-":
        what = (
            f"found {quoted(at.here())} among names, expected `name: value` as in line {opened_at}; "
            "write `NAME: {...}` in place of `- {...}`"
        )
    elif token == "?":
        what = (
            f"found {quoted(at.here())} in a list, expected `- ...` as in line {opened_at}; "
            "write all entries as `NAME: {...}`"
        )
    elif token == "<block mapping start>" and _indent(at.here()) == at.column:
        above = _indent(at.lines[at.above(at.line)])
        what = (
            f"found {quoted(at.here())} indented by {at.column}, expected {above} as the line above; "
            "indent entries of one block equally"
        )
    else:
        what = f"found {at.word()}, expected a new line; write one `name: value` per line"
    return at.line, at.column, what


def _quote(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    mark = error.context_mark
    line, column = (at.line, at.column) if mark is None else (mark.line, mark.column)
    text = at.lines[line][column:]
    what = f"found the text {text.strip()} without its second {text[:1]}, expected one; close the quotes"
    return line, column, what


def _start(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    text = at.here()[at.column :]
    if text.startswith("\t") or "\\t" in (error.problem or ""):
        return at.line, at.column, "found a tab, expected spaces; YAML is indented by spaces only"
    return (
        at.line,
        at.column,
        f"found {quoted(text)}, expected a value; put text that begins like this in quotes",
    )


def _alias(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    text = quoted(at.here()[at.column if error.context_mark is None else error.context_mark.column :])
    what = f"found {text}, expected a value; & and * name anchors of YAML, put text in quotes"
    return at.line, at.column if error.context_mark is None else error.context_mark.column, what


def _no_value(_: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    found = f"found {at.word()} in {quoted(at.here())}"
    return at.line, at.column, f"{found}, expected a value; remove the sign, or add the missing value"


def _block_text(error: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    mark = error.context_mark
    line, column = (at.line, at.column) if mark is None else (mark.line, mark.column)
    what = (
        f"found {quoted(at.lines[line][column:])}, expected a value; put text that begins like this in quotes"
    )
    return line, column, what


def _after_the_end(_: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    return at.line, at.column, f"found {quoted(at.here())} after the end of the scene, expected nothing more"


def _document(_: yaml.MarkedYAMLError, at: _Lines) -> _Explanation:
    return (
        at.line,
        at.column,
        "found a second document after '---', expected one scene; use a file for each scene",
    )


_EXPLANATIONS: tuple[tuple[str, Callable[[yaml.MarkedYAMLError, _Lines], _Explanation]], ...] = (
    ("mapping values are not allowed here", _second_colon),
    ("could not find expected ':'", _no_colon),
    ("expected ',' or ", _not_closed),
    ("expected <block end>", _block_end),
    ("found unexpected end of stream", _quote),
    ("that cannot start any token", _start),
    ("found undefined alias", _alias),
    ("expected alphabetic or numeric character", _alias),
    ("but found another document", _document),
    ("expected the node content", _no_value),
    ("expected '<document start>'", _after_the_end),
)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _place(text: str, index: int) -> tuple[int, int]:
    before = text[: max(index, 0)]
    return before.count("\n"), len(before) - before.rfind("\n") - 1


def _at(file: str, line: int, column: int, what: str) -> str:
    return f"{file}:{line + 1}:{column + 1}: {what}"


def without_quotes(line: str) -> str:
    """Return a message about plain data, in which a text has no quotes that could be left out."""
    advised = line.removesuffix("; leave out the quotes")
    if advised == line:
        return line
    from_pyyaml = re.search(r"found '[-+]?\d+[eE][-+]?\d+'", line)
    hint = "; PyYAML reads 1e-4 as a text and 1.0e-4 as a number: read the file with gelenk.load"
    return f"{advised}, not a text{hint if from_pyyaml else ''}"
