# SPDX-License-Identifier: BSD-3-Clause
"""Samples of the parameters of long tests."""

from collections.abc import Container, Iterable
from typing import Any

import pytest


def thorough_beyond(values: Iterable[Any], sample: Container[Any]) -> list[Any]:
    """Return parameters of a test of which those outside the sample are left to `make thorough`."""
    return [value if value in sample else pytest.param(value, marks=pytest.mark.thorough) for value in values]


def sampled(values: Iterable[Any], sample: Container[Any]) -> list[Any]:
    """Return parameters of a test of which those outside the sample are studies (see pyproject.toml)."""
    return [value if value in sample else pytest.param(value, marks=pytest.mark.study) for value in values]
