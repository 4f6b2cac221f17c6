# SPDX-License-Identifier: BSD-3-Clause
"""The tables of docs/command-line.md, made from the commands; `python tests/command_line.py` writes them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from gelenk.cli import app

PAGE = Path(__file__).parent.parent / "docs" / "command-line.md"
BEGIN = "<!-- commands: made from the program by tests/command_line.py -->\n"
END = "<!-- end of commands -->\n"
COMMON = ("as_json", "verbose")  # options of every command, which the page describes once


def commands(group: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Names and objects of all commands, in the order of --help."""
    parent: Any = typer.main.get_command(app) if group is None else group
    for name, command in parent.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, (*path, name))
        else:
            yield " ".join((*path, name)), command


def reference() -> str:
    """A section for each command: what it does, its arguments and options."""
    return "\n".join(_section(name, command) for name, command in commands())


def _section(name: str, command: Any) -> str:
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option" and p.name not in COMMON]
    usage = " ".join(["gelenk", name, *(_argument(p) for p in arguments), "[OPTIONS]"])
    text = textwrap.fill(" ".join(command.help.split()), 140)
    lines = [f"### `gelenk {name}`", "", text, "", f"    {usage}", ""]
    if arguments or options:
        lines += ["| | |", "|---|---|"]
    lines += [f"| `{_escaped(p.metavar)}` | {_escaped(p.help)} |" for p in arguments]
    lines += [f"| `{_escaped(_spelled(p))}` | {_escaped(_described(p))} |" for p in options]
    return "\n".join([*lines, ""])


def _argument(parameter: Any) -> str:
    name = str(parameter.metavar)
    return name if parameter.required or name.startswith("[") else f"[{name}]"


def _spelled(option: Any) -> str:
    names = sorted(
        [*option.opts, *option.secondary_opts], key=lambda name: (name.startswith("--"), name.find("no-"))
    )
    value = "" if option.is_flag or option.count else f" {option.metavar or 'X'}"
    return ", ".join(names) + value


def _described(option: Any) -> str:
    default = option.default
    is_given = option.show_default and default not in (None, False, True, ()) and not callable(default)
    return f"{option.help}{f' Default: {default}.' if is_given else ''}"


def _escaped(text: str) -> str:
    return text.replace("|", r"\|")


def parts(page: str) -> tuple[str, str, str]:
    """What is before, in and after the sections of the page."""
    before, rest = page.split(BEGIN)
    inside, after = rest.split(END)
    return before, inside, after


if __name__ == "__main__":
    start, _, end = parts(PAGE.read_text(encoding="utf-8"))
    PAGE.write_text(f"{start}{BEGIN}{reference()}{END}{end}", encoding="utf-8")
