# SPDX-License-Identifier: BSD-3-Clause
"""Loops over cases in one test miss none."""

import inspect

import pytest
from looped import looped


def test_all_cases_are_run_and_those_that_fail_are_named() -> None:
    seen = []

    @looped("seed", range(4))
    @looped(("a", "b"), [(1, 2), (3, 4)])
    def check(seed: int, a: int, b: int) -> None:
        seen.append((seed, a, b))
        assert seed != 2 or a == 1, "wrong"

    with pytest.raises(
        AssertionError, match=r"1 of 4 cases failed:\n\{'seed': 2\}: .*\n\{'a': 3, 'b': 4\}: .*wrong"
    ):
        check()
    assert seen == [(seed, *pair) for seed in range(4) for pair in ((1, 2), (3, 4))]


def test_what_is_not_raised_fails() -> None:
    @looped("seed", [1])
    def check(seed: int) -> None:
        with pytest.raises(ValueError, match="none"):
            assert seed

    with pytest.raises(AssertionError, match="DID NOT RAISE"):
        check()


def test_fixtures_remain_arguments() -> None:
    @looped("seed", [1])
    def check(seed: int, tmp_path: object) -> None:
        assert (seed, tmp_path) == (1, 2)

    assert list(inspect.signature(check).parameters) == ["tmp_path"]
    check(tmp_path=2)
