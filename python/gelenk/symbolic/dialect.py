# SPDX-License-Identifier: BSD-3-Clause
"""How a language writes operations. Each is a subclass of `Dialect` in a file of its own."""

from __future__ import annotations

from typing import ClassVar

# Strength of binding: an operand that binds less is put into parentheses.
CHOICE, SUM, PRODUCT, SIGN, POWER, ATOM = range(6)

type Written = tuple[str, int]  # a text and the strength of its outermost operation


class Dialect:
    """Writes each operation as text."""

    functions: ClassVar[dict[str, str]] = {}  # where they differ from the names in the graph
    prefix: ClassVar[str] = ""  # of functions: "np."

    def number(self, value: float) -> Written:
        """Write a constant, so that it is read back bit by bit."""
        text = repr(value).removesuffix(".0")
        return text, SIGN if value < 0 else ATOM

    def within(self, part: Written, least: int) -> str:
        """Write an operand of an operation that binds it with this strength."""
        text, strength = part
        return text if strength >= least else self.parentheses(text)

    def parentheses(self, text: str) -> str:
        """Put a text into parentheses."""
        return f"({text})"

    def add(self, a: Written, b: Written) -> Written:
        """Write a + b; a constant comes last, with its sign."""
        if a[1] in (ATOM, SIGN) and a[0].lstrip("-")[0].isdigit():
            a, b = b, a
        if b[0].startswith("-") and b[1] > SUM:
            return f"{self.within(a, SUM)} - {self.within((b[0][1:], b[1]), PRODUCT)}", SUM
        return f"{self.within(a, SUM)} + {self.within(b, SUM)}", SUM

    def subtract(self, a: Written, b: Written) -> Written:
        """Write a - b."""
        return f"{self.within(a, SUM)} - {self.within(b, PRODUCT)}", SUM

    def multiply(self, a: Written, b: Written) -> Written:
        """Write a times b; a constant comes first."""
        if b[0].lstrip("-")[0].isdigit() and b[1] in (ATOM, SIGN):
            a, b = b, a
        return f"{self.within(a, PRODUCT)}*{self.within(b, POWER)}", PRODUCT

    def divide(self, a: Written, b: Written) -> Written:
        """Write a / b."""
        return f"{self.within(a, PRODUCT)}/{self.within(b, POWER)}", PRODUCT

    def negate(self, a: Written) -> Written:
        """Write -a."""
        return f"-{self.within(a, PRODUCT)}", SIGN

    def power(self, a: Written, b: Written) -> Written:
        """Write a to the power of b."""
        return f"{self.within(a, ATOM)}**{self.within(b, POWER)}", POWER

    def call(self, name: str, *arguments: Written) -> Written:
        """Write the value of a function."""
        name = self.functions.get(name, f"{self.prefix}{name}")
        return f"{name}({', '.join(text for text, _ in arguments)})", ATOM

    def choose(self, g: Written, a: Written, b: Written) -> Written:
        """Write: a where g > 0, else b."""
        raise NotImplementedError

    def operation(self, name: str, index: int, of: list[Written]) -> Written:
        """Write an operation on operands that are written."""
        if name == "integer_power":
            return self.power(of[0], self.number(index))
        if name in ("add", "subtract", "multiply", "divide", "negate", "power", "choose"):
            written: Written = getattr(self, name)(*of)
            return written
        return self.call(name, *of)
