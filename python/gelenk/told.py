# SPDX-License-Identifier: BSD-3-Clause
"""What a user can cause, as lines on stderr and exit code 1."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable

import typer

from gelenk.errors import GelenkError


def told[**P](command: Callable[P, None]) -> Callable[P, None]:
    """The command, with errors that a user can cause turned into lines."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except GelenkError as e:
            lines = e.lines
        except BrokenPipeError:  # the reader of our output has gone: nothing to tell
            sys.stderr.close()
            raise typer.Exit(1) from None
        except OSError as e:
            lines = (f"{e.filename}: {(e.strerror or str(e)).lower()}" if e.filename else str(e),)
        except KeyboardInterrupt:
            lines = ("interrupted",)
        else:
            return
        for line in lines:
            print(line, file=sys.stderr)
        raise typer.Exit(1)

    return run
