# SPDX-License-Identifier: BSD-3-Clause
"""Expressions: values and derivatives against Python's parser and forty digits, kinks, and mistakes in words.

Values are compared relative to the largest term that occurs in the expression, since a difference of large
terms has no more digits.
"""

from __future__ import annotations

import ast
import math
import random
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import mpmath
import pytest

NAMES = ("s", "v", "arm.phi")
INSIDE = {  # of functions of one argument: what keeps the argument in their domain, and bounded
    "sin": "{}",
    "cos": "{}",
    "atan": "{}",
    "tanh": "{}",
    "asinh": "{}",
    "erf": "{}",
    "abs": "{}",
    "exp": "sin({})",
    "cosh": "sin({})",
    "sinh": "sin({})",
    "tan": "sin({})",
    "asin": "sin({})/2",
    "acos": "sin({})/2",
    "atanh": "sin({})/2",
    "acosh": "2 + sin({})",
    "log": "2 + cos({})",
    "log10": "2 + cos({})",
    "sqrt": "1 + {}^2",
    "cbrt": "2 + sin({})",
}
EXACT = {  # the functions with many digits; `if` is no name in Python
    **{name: getattr(mpmath, name) for name in INSIDE if name not in ("abs",)},
    "abs": abs,
    "atan2": mpmath.atan2,
    "hypot": mpmath.hypot,
    "pow": mpmath.power,
    "min": min,
    "max": max,
    "choose": lambda condition, a, b: a if condition else b,
}


def random_text(rng: random.Random, depth: int) -> str:
    if depth == 0:
        number = rng.choice(["1", "2", "0.3", "7.5", "1e-1", ".25"])
        return rng.choice(NAMES) if rng.random() < 0.7 else number
    a, b = random_text(rng, depth - 1), random_text(rng, depth - 1)
    name = rng.choice(sorted(INSIDE))
    return rng.choice([
        f"{a} + {b}", f"{a} - {b}", f"({a})*({b})", f"({a} - {b})*{a}", f"-({a})", f"-{a}",
        f"({a})/(1 + ({b})^2)", f"-({a})^2", f"({a})^3 - {b}", f"(1 + ({a})^2)^-2",
        f"{name}({INSIDE[name].format(f'({a})')})",
        f"pow(1 + ({a})^2, sin({b}))", f"atan2({a}, 2 + ({b})^2)", f"hypot({a}, 1)", f"min({a}, {b})",
        f"max({a}, {b}, s)", f"if(s < 0.3 and not v >= 1 or arm.phi > 1, {a}, {b})",
    ])  # fmt: skip


class Exact:
    """A text as Python reads it, with forty digits."""

    def __init__(self, text: str) -> None:
        tree = ast.parse(text.replace("^", "**").replace("if(", "choose("), mode="eval")
        parts = [node for node in ast.walk(tree.body) if isinstance(node, ast.expr)]
        numbers = (ast.BinOp, ast.UnaryOp, ast.Call)
        self._parts = [
            compile(ast.Expression(node), "", "eval")
            for node in parts
            if isinstance(node, numbers) and not isinstance(getattr(node, "op", None), ast.Not)
        ]
        self._whole = compile(tree, "", "eval")

    def value(self, x: list[Any], code: Any = None) -> Any:
        s, v, phi = x
        names = {"s": s, "v": v, "arm": SimpleNamespace(phi=phi)}
        return mpmath.mpf(eval(code or self._whole, EXACT | names))  # the text of this test

    def along(self, x: list[Any], direction: list[float], order: int, code: Any = None) -> Any:
        """A derivative in a direction, by differences of numbers with a hundred digits."""
        with mpmath.workdps(100):
            return mpmath.diff(
                lambda h: self.value([a + h * d for a, d in zip(x, direction, strict=True)], code), 0, order
            )

    def largest(self, x: list[Any], direction: list[float], order: int) -> float:
        """The largest magnitude of the derivatives of its parts, at least 1."""
        return max([1.0, *(float(abs(self.along(x, direction, order, code))) for code in self._parts)])


@pytest.mark.parametrize("block", range(10))
def test_values_and_derivatives_agree_with_forty_digits(units: ModuleType, block: int) -> None:
    """Fifty expressions in each block, at points where no kink is nearer than 1e-3."""
    rng = random.Random(block)
    for _ in range(50):
        text = random_text(rng, rng.choice([1, 2, 3]))
        expression, truth = units.Expression(text, list(NAMES)), Exact(text)
        x = [rng.uniform(-2, 2) for _ in NAMES]
        while any(abs(g) < 1e-3 for g in expression.arguments(x)):
            x = [rng.uniform(-2, 2) for _ in NAMES]
        direction = [rng.uniform(-1, 1) for _ in NAMES]
        exact = [mpmath.mpf(number) for number in x]
        sizes = [truth.largest(exact, direction, order) for order in range(3)]
        assert abs(expression.value(x) - truth.value(exact)) <= 1e-14 * sizes[0], text
        first = truth.along(exact, direction, 1)
        found = [
            sum(d * g for d, g in zip(direction, gradient, strict=True))
            for gradient in (expression.gradient(x), [expression.derivative([k], x) for k in range(3)])
        ]
        bound = 1e-14 * sizes[0] * sizes[1]
        assert all(abs(one - first) <= bound for one in found), text
        coefficients = expression.series(x, direction, [0.0] * 3)
        assert abs(coefficients[1] - first) <= bound, text
        second = truth.along(exact, direction, 2)
        bound = 1e-14 * (sizes[0] * sizes[2] + sizes[1] ** 2) * sizes[0]
        assert abs(2 * coefficients[2] - second) <= bound, text
        symbolic = sum(
            direction[j] * direction[k] * expression.derivative([j, k], x) for j in range(3) for k in range(3)
        )
        assert abs(symbolic - second) <= 10 * bound, text


@pytest.fixture
def s(units: ModuleType) -> Callable[[str], Any]:
    return lambda text: units.Expression(text, ["s", "v", "t", "k"])


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("-s^2", -9.0),
        ("8/4/2", 1.0),
        ("1 - 2 - 3", -4.0),
        ("2*-3", -6.0),
        ("+s", 3.0),
        ("1e3 + .5 + 2.", 1002.5),
        ("pi", math.pi),
        ("min(s, 2, 7) + max(1, s, 2)", 5.0),
        ("clip(s, 0, 2) + clip(-s, 0, 2) + clip(1, 0, 2)", 3.0),
        ("sign(s) + sign(-s) + sign(s - 3)", 0.0),
        ("smoothstep(s, 2, 4)", 0.5),
        ("smoothstep(s, 4, 5) + smoothstep(s, 1, 2)", 1.0),
        ("hypot(s, 4)", 5.0),
        ("log10(1000)", 3.0),
        ("if(s >= 3, 1, 2)", 1.0),
        ("if(s > 3, 1, 2)", 2.0),
        ("if(s <= 3, 1, 2)", 1.0),
        ("if(s < 3, 1, 2)", 2.0),
        ("if(s > 0 and (s < 1 or not s < 3), 1, 2)", 1.0),
        ("if(s > 5 or s > 4, 1, if(s > 2, 7, 8))", 7.0),
        ("0*s", 0.0),
        ("s^0", 1.0),
        ("(-8)^3", -512.0),
        ("pow(4, 0.5)", 2.0),
    ],
)
def test_what_an_expression_means(s: Callable[[str], Any], text: str, value: float) -> None:
    assert s(text).value([3.0, 0.0, 0.0, 0.0]) == value


def test_equal_parts_are_computed_once(s: Callable[[str], Any]) -> None:
    """sin(s*v) occurs three times, once with its factors exchanged; constants are folded."""
    assert s("sin(s*v) + sin(s*v)*sin(v*s)").operations() == 4
    assert s("2*pi*3/4").operations() == 0
    assert not s("0*s + v").depends_on(0)
    assert s("0*s + v").depends_on(1)


@pytest.mark.parametrize("exponent", [1.5, 2.5, 3.25])
def test_powers_at_zero(s: Callable[[str], Any], exponent: float) -> None:
    """x^y at x = 0, y > 1: all first derivatives are 0, and with x = t + t^2 the second is 0 where y > 2."""
    for text in (f"s^{exponent}", f"pow(s, v + {exponent})"):
        expression = s(text)
        assert expression.value([0.0, 0.0, 0.0, 0.0]) == 0
        assert expression.gradient([0.0, 0.0, 0.0, 0.0]) == [0, 0, 0, 0]
        assert expression.series([0.0] * 4, [0.0] * 4, [2.0, 0.0, 0.0, 0.0]) == [0, 0, 0]
        if exponent > 2:
            assert expression.series([0.0] * 4, [1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]) == [0, 0, 0]


def test_kinks_are_known_and_can_be_held(s: Callable[[str], Any]) -> None:
    """|s| + min(v, 2): two kinks. A branch held beyond its kink is smooth."""
    expression = s("abs(s) + min(v, 2)")
    assert expression.has_choices()
    assert not s("s*v").has_choices()
    x = [-0.5, 1.5, 0.0, 0.0]
    arguments = expression.arguments(x)
    assert sorted(arguments) == [-0.5, 0.5]
    sides = [argument > 0 for argument in arguments]
    assert expression.held(x, sides) == expression.value(x) == 2.0
    beyond = [0.25, 3.0, 0.0, 0.0]
    assert expression.value(beyond) == 2.25
    assert expression.held(beyond, sides) == 2.75


def test_a_law_reuses_the_places_of_what_is_no_longer_needed(s: Callable[[str], Any]) -> None:
    """A sum of 2000 terms needs a few places; a thousand constants at once do not fit, and that is said."""
    text = "+".join(["s*v"] * 2 + [f"sin(s)^{k % 7 + 2}" for k in range(2000)])
    assert s(text[:9000].rsplit("+", 1)[0]).value([1.0, 1.0, 0.0, 0.0]) > 0
    with pytest.raises(Exception, match="more than 512 intermediate values"):
        s("+".join(f"s^{1.5 + k / 7}" for k in range(700))[:9900].rsplit("+", 1)[0])


MISTAKES = {
    "2s": "2*s",
    "2 s": "2*s",
    "s v": "s*v",
    "(s)(v)": "'*'",
    "s(v)": "s*(...)",
    "3(s + 1)": "'*'",
    "s**2": "x^2",
    "1,5*s": "1.5",
    "90\u00b0": "90*pi/180",
    "90 deg": "90*pi/180",
    "5 mm": "SI units",
    "sin s": "sin(x)",
    "sin + 1": "sin(x)",
    "ln(s)": "log(x)",
    "arcsin(s)": "asin(x)",
    "math.sin(s)": "sin(x)",
    "np.abs(s)": "abs(x)",
    "fabs(s)": "abs(x)",
    "|s|": "abs(x)",
    "s > 0 ? 1 : 2": "if(condition, a, b)",
    "1 if s > 0 else 2": "if(condition, a, b)",
    "if(s > 0, 1)": "expected 3",
    "if(s, 1, 2)": "expected a comparison",
    "s > 0": "expected a number",
    "1 + (s > 0)": "expected a number",
    "0 < s < 1": "a < b and b < c",
    "if(s == 0, 1, 2)": "hardly ever equal",
    "if(s > 0 && v > 0, 1, 2)": "'and'",
    "f = k*s": "no '='",
    "(s + 1": "without ')'",
    "s + 1)": "without '('",
    "s +": "found the end",
    "": "found nothing",
    "  ": "found nothing",
    "K*s": "did you mean 'k'?",
    "min(s)": "expected 2 or more",
    "atan2(s)": "atan2(y, x)",
    "sinn(s)": "did you mean sin(x)?",
    "e^s": "exp(1)",
    "s\u00b2": "x^2",
    "s \u2212 1": "write the minus sign as -",
    "2\u00b7s": "write *",
    "5 %": "0.05",
    "mod(s, 2)": "jump again and again",
    "x'": "speed w",
    "1.2.3": "two decimal points",
    "1e999": "too large for 64 bits",
    "s $ 2": "found '$'",
    "tip.r[": "tip.r[1]",
    "s; v": "one formula",
    "max(s, , v)": "found ','",
    "()": "found ')'",
    "*s": "found '*'",
    "s^": "found the end",
    "(" * 300 + "s" + ")" * 300: "more than 200",
    "1" * 20_000: "at most 10000",
}


@pytest.mark.parametrize("text", MISTAKES, ids=lambda text: text[:20] or "empty")
def test_mistakes_are_answered_in_words(s: Callable[[str], Any], text: str) -> None:
    with pytest.raises(ValueError, match=r"^column ") as raised:
        s(text)
    assert MISTAKES[text] in str(raised.value)
    assert "^" in str(raised.value).splitlines()[-1]


def test_the_caret_is_below_the_mistake(s: Callable[[str], Any]) -> None:
    """Columns count characters, not bytes, of the line with the mistake."""
    with pytest.raises(ValueError, match=r"^column") as raised:
        s("2*k +\n  s*force*v")
    assert str(raised.value).splitlines()[0].startswith("column 5: found 'force'")
    assert str(raised.value).splitlines()[1:] == ["    s*force*v", "      ^^^^^"]
    with pytest.raises(ValueError, match=r"^column") as raised:
        s("(\u00e4)")
    assert str(raised.value).splitlines()[1:] == ["  (\u00e4)", "   ^"]


WORDS = [
    "s", "v", "1", "2.5", "(", ")", "+", "-", "*", "/", "^", ",", "<", ">=", "and", "or", "not", "if(",
    "min(", "sin(", "clip(", " ", "\u00e9", "pi", "atan2(", "e3", ".", "[1]", "pow(", "smoothstep(",
]  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_any_text_is_an_expression_or_a_mistake(s: Callable[[str], Any], seed: int) -> None:
    """Ten thousand texts of words in any order, and as many of any characters: no crash, no other error."""
    rng = random.Random(seed)
    read, mistakes = 0, []
    for k in range(5000):
        words = WORDS if k % 2 == 0 else [chr(rng.randrange(1, 0x2FF)) for _ in range(8)]
        text = "".join(rng.choice(words) for _ in range(rng.randrange(1, 12)))
        try:
            expression = s(text)
        except ValueError as error:
            mistakes.append(str(error))
        else:
            read += 1
            expression.value([0.3, -0.4, 0.5, 0.6])
            expression.derivative([0, 1], [0.3, -0.4, 0.5, 0.6])
    assert all(mistake.startswith("column ") for mistake in mistakes)
    assert read > 20
