# SPDX-License-Identifier: BSD-3-Clause
"""What a user can cause, as lines on stderr and exit code 1."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from gelenk.errors import GelenkError, SceneWarning, StartWarning

TOLD = (SceneWarning, StartWarning)


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Warnings of a scene and its start are lines on stderr, each told once."""
    with warnings.catch_warnings():
        for category in TOLD:
            warnings.simplefilter("once", category)
        show = warnings.showwarning

        def line(message: Warning | str, category: type[Warning], *rest: Any, **named: Any) -> None:
            if issubclass(category, TOLD):
                print(message, file=sys.stderr)
            else:
                show(message, category, *rest, **named)

        warnings.showwarning = line
        yield


def told[**P](command: Callable[P, None]) -> Callable[P, None]:
    """The command, with errors that a user can cause turned into lines."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with _plain_warnings():
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
