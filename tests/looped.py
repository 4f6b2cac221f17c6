# SPDX-License-Identifier: BSD-3-Clause
"""One test of many cases."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import pytest


def looped(
    names: str | tuple[str, ...], cases: Iterable[Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Like pytest.mark.parametrize, but all cases are one test, which names those that fail.

    A case that is skipped counts as one that fails.
    For cases of one kind, such as seeds: to collect and report a test costs as much as most of them.
    """
    keys = (names,) if isinstance(names, str) else names
    rows = [dict(zip(keys, (case,) if isinstance(names, str) else case, strict=True)) for case in cases]

    def decorated(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def run(**given: Any) -> None:
            failed = []
            for row in rows:
                try:
                    test(**given, **row)
                except (Exception, pytest.fail.Exception, pytest.skip.Exception) as error:
                    failed.append((row, error))
            if failed:
                lines = "\n".join(f"{row}: {type(error).__name__}: {error}" for row, error in failed[:20])
                message = f"{len(failed)} of {len(rows)} cases failed:\n{lines}"
                raise AssertionError(message) from failed[0][1]

        of = inspect.signature(test)
        left = [parameter for name, parameter in of.parameters.items() if name not in keys]
        run.__signature__ = of.replace(parameters=left)  # type: ignore[attr-defined]  # read by pytest
        return run

    return decorated
