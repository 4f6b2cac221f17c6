# SPDX-License-Identifier: BSD-3-Clause
"""How the languages write operations."""

from __future__ import annotations

import re
from typing import ClassVar

from gelenk.symbolic.dialect import ATOM, CHOICE, POWER, PRODUCT, SIGN, SUM, Dialect, Written


class C(Dialect):
    """C99."""

    functions: ClassVar[dict[str, str]] = {}

    def number(self, value: float) -> Written:
        """Write a constant as a double."""
        text = repr(value)
        return text.removesuffix(".0") if "." in text and "e" not in text and abs(value) < 1e6 else text, (
            SIGN if value < 0 else ATOM
        )

    def power(self, a: Written, b: Written) -> Written:
        """Write a to the power of b; squares as products."""
        if b[0] == "2" and a[0].isidentifier():
            return f"{a[0]}*{a[0]}", PRODUCT
        return self.call("pow", a, b)

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b. Of two whole numbers it would be one: 1/(g > 0 ? 2 : 3) is 0."""
        first, second = (self.within((re.sub(r"^-?\d+$", r"\g<0>.0", of[0]), of[1]), SUM) for of in (a, b))
        return f"{self.within(g, SUM)} > 0 ? {first} : {second}", CHOICE


class NumPy(Dialect):
    """Python with NumPy."""

    prefix = "np."
    functions: ClassVar[dict[str, str]] = {
        "asin": "np.arcsin", "acos": "np.arccos", "atan": "np.arctan", "atan2": "np.arctan2",
        "asinh": "np.arcsinh", "acosh": "np.arccosh", "atanh": "np.arctanh", "erf": "math.erf",
    }  # fmt: skip

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b."""
        return f"({self.within(a, SUM)} if {self.within(g, SUM)} > 0 else {self.within(b, SUM)})", ATOM


class SymPy(Dialect):
    """Python with SymPy."""

    prefix = "sp."

    def call(self, name: str, *arguments: Written) -> Written:
        """Write the value of a function. The cube root of SymPy is complex where its argument is negative."""
        x = arguments[0][0]
        if name == "log10":
            return f"sp.log({x}, 10)", ATOM
        if name == "cbrt":
            return f"sp.sign({x})*sp.cbrt(sp.Abs({x}))", PRODUCT
        return super().call(name, *arguments)

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b."""
        return f"sp.Piecewise(({a[0]}, {self.within(g, SUM)} > 0), ({b[0]}, True))", ATOM


class CasADi(Dialect):
    """Python with CasADi."""

    prefix = "ca."

    def call(self, name: str, *arguments: Written) -> Written:
        """Write the value of a function. CasADi has no cube root."""
        x = arguments[0][0]
        if name == "cbrt":
            return f"ca.sign({x})*ca.fabs({x})**(1/3)", PRODUCT
        return super().call(name, *arguments)

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b."""
        return f"ca.if_else({self.within(g, SUM)} > 0, {a[0]}, {b[0]})", ATOM


class LaTeX(Dialect):
    """Formulas of LaTeX."""

    _function = re.compile(r"\\(sin|cos|tan|ln|exp|arc\w+|sinh|cosh|tanh) \S+$")
    functions: ClassVar[dict[str, str]] = {
        "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "log": r"\ln", "log10": r"\log_{10}",
        "asinh": r"\operatorname{arsinh}", "acosh": r"\operatorname{arcosh}",
        "atanh": r"\operatorname{artanh}", "erf": r"\operatorname{erf}",
        "atan2": r"\operatorname{atan2}",
    }  # fmt: skip

    def number(self, value: float) -> Written:
        """Write a constant with all digits; powers of ten as such."""
        mantissa, _, exponent = repr(value).removesuffix(".0").partition("e")
        text = f"{mantissa} \\cdot 10^{{{int(exponent)}}}" if exponent else mantissa
        return text, SIGN if value < 0 else PRODUCT if exponent else ATOM

    def parentheses(self, text: str) -> str:
        """Put a text into parentheses of its height."""
        return rf"\left({text}\right)"

    def multiply(self, a: Written, b: Written) -> Written:
        """Write a times b."""
        if b[0].lstrip("-")[0].isdigit() and b[1] in (ATOM, SIGN):
            a, b = b, a
        if self._function.search(a[0]) and not self._function.match(b[0]):
            # sin x a would be read as sin(x a).
            sign, a = ("-", (a[0][1:], a[1])) if a[0].startswith("-") else ("", a)
            return f"{sign}{self.multiply(b, a)[0]}", PRODUCT
        sign = r" \cdot " if b[0][0].isdigit() else r" \, "
        return f"{self.within(a, PRODUCT)}{sign}{self.within(b, PRODUCT)}", PRODUCT

    def divide(self, a: Written, b: Written) -> Written:
        """Write a fraction."""
        return rf"\frac{{{a[0]}}}{{{b[0]}}}", POWER

    def power(self, a: Written, b: Written) -> Written:
        """Write a to the power of b."""
        return f"{self.within(a, ATOM)}^{{{b[0]}}}", POWER

    def call(self, name: str, *arguments: Written) -> Written:
        """Write the value of a function."""
        if name == "sqrt":
            return rf"\sqrt{{{arguments[0][0]}}}", ATOM
        if name == "cbrt":
            return rf"\sqrt[3]{{{arguments[0][0]}}}", ATOM
        symbol = self.functions.get(name, f"\\{name}")
        if len(arguments) == 1 and arguments[0][1] == ATOM:
            return f"{symbol} {arguments[0][0]}", PRODUCT
        return rf"{symbol}\left({', '.join(text for text, _ in arguments)}\right)", POWER

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b."""
        return (
            rf"\begin{{cases}} {a[0]} & {g[0]} > 0 \\ {b[0]} & \text{{otherwise}} \end{{cases}}",
            CHOICE,
        )
