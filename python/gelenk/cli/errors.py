# SPDX-License-Identifier: BSD-3-Clause
"""Errors that a user can cause: lines on stderr and exit code 1."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from gelenk.errors import GelenkError, SceneWarning, StartWarning

REPORTED_WARNINGS = (SceneWarning, StartWarning)


@contextmanager
def _plain_warnings() -> Iterator[None]:
    """Print warnings about a scene and its start as lines on stderr, each once."""
    with warnings.catch_warnings():
        for category in REPORTED_WARNINGS:
            warnings.simplefilter("once", category)
        show = warnings.showwarning

        def line(message: Warning | str, category: type[Warning], *rest: Any, **named: Any) -> None:
            if issubclass(category, REPORTED_WARNINGS):
                print(message, file=sys.stderr)
            else:
                show(message, category, *rest, **named)

        warnings.showwarning = line
        yield


def report_user_errors[**P](command: Callable[P, None]) -> Callable[P, None]:
    """Decorate a command: errors that a user can cause become lines on stderr and exit code 1."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with _plain_warnings():
                command(*args, **kwargs)
        except GelenkError as e:
            lines = e.lines
        except BrokenPipeError:  # the reader of our output has closed it
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
