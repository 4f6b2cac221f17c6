# SPDX-License-Identifier: BSD-3-Clause
"""What all commands share: reports as text or JSON, errors of users, log messages."""

from __future__ import annotations

import functools
import inspect
import json
import logging
import math
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any, NoReturn, get_type_hints

import typer

from gelenk.errors import FileWarning, GelenkError, SceneWarning, StartWarning

REPORTED_WARNINGS = (FileWarning, SceneWarning, StartWarning)
LEVELS = (logging.WARNING, logging.INFO, logging.DEBUG)  # by the number of -v

AsJson = Annotated[
    bool, typer.Option("--json", help="Print the result, or the error, as one JSON document with all digits.")
]
Verbose = Annotated[
    int,
    typer.Option(
        "--verbose",
        "-v",
        count=True,
        show_default=False,
        help="Log to stderr: what is done, and events; twice: diagnostics, too.",
    ),
]


@dataclass(frozen=True)
class Report:
    """The result of a command.

    Attributes:
        text: what is printed.
        data: what is printed with --json; NaN and infinity become null.
        failure: an error after which there is a partial result; None if there was none.
    """

    text: str
    data: Mapping[str, Any]
    failure: GelenkError | None = None


def command[**P](function: Callable[P, Report]) -> Callable[..., None]:
    """Turn a function into a command with the options --json and --verbose.

    Its report is printed to stdout. Errors that a user can cause become lines on stderr, with --json a
    document on stdout; the exit code is 1.

    Args:
        function: with parameters as typer reads them.
    """
    hints = get_type_hints(function, include_extras=True)
    own = [
        inspect.Parameter("verbose", inspect.Parameter.KEYWORD_ONLY, default=0, annotation=Verbose),
        inspect.Parameter("as_json", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=AsJson),
    ]
    given = [p.replace(annotation=hints[p.name]) for p in inspect.signature(function).parameters.values()]

    @functools.wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        as_json, verbose = bool(kwargs.pop("as_json")), int(str(kwargs.pop("verbose")))
        try:
            with plain_warnings(), log_messages(verbose):
                report = function(*args, **kwargs)
                _print(report, as_json)
        except GelenkError as e:
            fail(type(e).__name__, e.lines, as_json)
        except BrokenPipeError:  # the reader of our output has closed it
            sys.stderr.close()
            raise typer.Exit(1) from None
        except OSError as e:
            text = f"{e.filename}: {(e.strerror or str(e)).lower()}" if e.filename else str(e)
            fail(type(e).__name__, (text,), as_json)
        except KeyboardInterrupt:
            fail("KeyboardInterrupt", ("interrupted",), as_json)
        if report.failure is not None:
            raise typer.Exit(1)

    # typer reads the signature of what it is given.
    run.__signature__ = inspect.Signature([*given, *own])  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in (*given, *own)}
    del run.__wrapped__
    return run


def _print(report: Report, as_json: bool) -> None:
    failure = report.failure
    if as_json:
        error = error_data(type(failure).__name__, failure.lines) if failure is not None else {}
        print(document({**report.data, **error}))
    elif report.text:
        print(report.text.removesuffix("\n"))
    if failure is not None and not as_json:
        print(*failure.lines, sep="\n", file=sys.stderr)
    sys.stdout.flush()  # where the reader has closed the pipe, this fails here and not at exit


def fail(kind: str, lines: tuple[str, ...], as_json: bool, code: int = 1) -> NoReturn:
    """Report an error and end the command.

    Args:
        kind: class of the error.
        lines: the message, one line per fault.
        as_json: whether it is printed as JSON, on stdout, instead of lines on stderr.
        code: exit code.

    Raises:
        typer.Exit: always.
    """
    if as_json:
        print(document(error_data(kind, lines)))
    else:
        for line in lines:
            print(line, file=sys.stderr)
    raise typer.Exit(code) from None


def error_data(kind: str, lines: tuple[str, ...]) -> dict[str, Any]:
    """Return an error as plain data."""
    return {"error": {"type": kind, "messages": list(lines)}}


def document(data: Mapping[str, Any]) -> str:
    """Return plain data as JSON; NaN and infinity, which JSON does not have, become null."""
    return json.dumps(_finite(data), indent=2, allow_nan=False, ensure_ascii=False)


def _finite(x: Any) -> Any:
    if isinstance(x, Mapping):
        return {key: _finite(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [_finite(value) for value in x]
    return None if isinstance(x, float) and not math.isfinite(x) else x


@contextmanager
def log_messages(verbose: int) -> Iterator[None]:
    """Write the messages of Gelenk's loggers to stderr.

    Args:
        verbose: 0: warnings; 1: what is done, too; 2: everything.
    """
    logger = logging.getLogger("gelenk")
    handler = logging.StreamHandler()
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(LEVELS[min(verbose, 2)])
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Print warnings about files, a scene and its start as lines on stderr, each once."""
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
