# SPDX-License-Identifier: BSD-3-Clause
"""gelenk COMMAND --help prints all texts as they are written."""

from __future__ import annotations

import command_line
import programs
import pytest

COMMANDS = dict(command_line.commands())


def test_the_commands_are_found() -> None:
    assert {"check", "simulate", "modes", "chart stability"} <= {*COMMANDS}


def squeezed(text: str) -> str:
    """Without white space, as lines may be broken anywhere."""
    return "".join(text.split())


@pytest.mark.parametrize("name", COMMANDS)
def test_help_prints_the_texts_of_all_options(name: str) -> None:
    """Units such as "[s]" are not taken for markup."""
    done = programs.gelenk(*name.split(), "--help")
    assert done.returncode == 0, done.stderr
    texts = [option.help for option in COMMANDS[name].params if getattr(option, "help", None)]
    assert texts
    for text in [*texts, COMMANDS[name].help]:
        assert squeezed(text) in squeezed(done.stdout)


def test_some_texts_have_units_in_brackets() -> None:
    texts = [getattr(option, "help", "") or "" for option in COMMANDS["simulate"].params]
    assert sum("[s]" in text for text in texts) == 2
