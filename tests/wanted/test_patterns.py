# SPDX-License-Identifier: BSD-3-Clause
"""Output patterns have the syntax of shells; a set of characters at the end also matches an index."""

from __future__ import annotations

import fnmatch
import random

import pytest

import gelenk
from gelenk import _core


def test_patterns_match_like_fnmatch() -> None:
    """Compared with fnmatch.fnmatchcase, for patterns and names without an index at
    the end, where both agree.
    """
    draw = random.Random(7)
    pieces = ["*", "?", "[ab]", "[!a]", "[a-c]", "[!a-b]", "a", "b", "c", ".", "**", "[]a]", "[a"]
    met = 0
    for _ in range(20_000):
        pattern = "".join(draw.choices(pieces, k=draw.randint(1, 6)))
        name = "".join(draw.choices("abc.", k=draw.randint(0, 7)))
        expected = fnmatch.fnmatchcase(name, pattern)
        assert _core.meets(pattern, name) == expected, (pattern, name)
        met += expected
    assert 1000 < met < 19_000


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("tip.r[2]", {"tip.r[2]"}),
        ("tip.r[1-2]", {"tip.r[1]", "tip.r[2]"}),
        ("*.r[13]", {"tip.r[1]", "tip.r[3]"}),
        ("tip.r[*]", {"tip.r[1]", "tip.r[2]", "tip.r[3]"}),
        ("tip.r[?]", {"tip.r[1]", "tip.r[2]", "tip.r[3]"}),
        ("tip.r[!1]", {"tip.r[2]", "tip.r[3]"}),
        ("tip.r*", {"tip.r[1]", "tip.r[2]", "tip.r[3]"}),
        ("U.phi_[ab]", {"U.phi_a", "U.phi_b"}),
        ("*", {"tip.r[1]", "tip.r[2]", "tip.r[3]", "U.phi_a", "U.phi_b"}),
        ("tip.r", set()),
        ("tip.r[4]", set()),
        ("[!t]*", {"U.phi_a", "U.phi_b"}),
        ("", set()),
        ("[]", set()),
        ("[!]", set()),
    ],
)
def test_character_sets_at_the_end_match_indices(pattern: str, names: set[str]) -> None:
    known = {"tip.r[1]", "tip.r[2]", "tip.r[3]", "U.phi_a", "U.phi_b"}
    assert {name for name in known if _core.meets(pattern, name)} == names


def test_pattern_with_many_stars_is_matched_quickly() -> None:
    assert not _core.meets("*a" * 40 + "b", "a" * 200)


def test_requested_outputs_are_in_the_requested_order(four_bar: gelenk.Scene) -> None:
    result = gelenk.simulate(four_bar, stop=0.01, step=0.01, outputs=["D.*", "A.phi", "*.w"])
    assert result.names == ("D.phi", "D.w", "D.a", "A.phi", "A.w", "B.w", "C.w")
