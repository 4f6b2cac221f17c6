# SPDX-License-Identifier: BSD-3-Clause
"""Names that mean something in C, Python or the texts themselves, and all functions of expressions."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gelenk

from .states import by_kernels, closeness, random_states
from .test_c_text import COMPILER, Compiled
from .test_left_out import lever

# Keywords, macros of math.h, entries of matrices, and names that the texts give to terms.
NAMES = [
    "int",
    "def",
    "lambda",
    "NAN",
    "HUGE_VAL",
    "M",
    "M11",
    "h1",
    "Phi1",
    "a1",
    "r",
    "u",
    "q",
    "np",
    "sp",
    "ca",
    "cos_A",
    "sin_A",
    "t1",
    "t2",
    "vdot",
    "lambda1",
    "float",
]

FUNCTIONS: dict[str, Callable[[float], float]] = {
    "log10(9 + phi)": lambda x: math.log10(9 + x),
    "cbrt(phi - 1)": lambda x: math.cbrt(x - 1),
    "erf(phi)": math.erf,
    "asinh(phi) + atanh(phi/9)": lambda x: math.asinh(x) + math.atanh(x / 9),
    "acosh(3 + phi)": lambda x: math.acosh(3 + x),
    "(9 + phi)^2.5*(9 + phi)^(-3)": lambda x: (9 + x) ** -0.5,
    "1/if(phi > 0, 2, 3)": lambda x: 1 / (2 if x > 0 else 3),
    "if(phi > 0, 99999, -88888)*if(phi > 0.2, 99999, 77777)": lambda x: (
        (99999 if x > 0 else -88888) * (99999 if x > 0.2 else 77777)
    ),
    "phi - (1 - (phi - 5))/(2 - phi/(phi + 7))": lambda x: x - (6 - x) / (2 - x / (x + 7)),
}


def check(equations: gelenk.Equations, folder: Path) -> None:
    """C, NumPy, SymPy and CasADi have the numbers of the kernels."""
    numpy = equations.to_numpy()
    compiled = Compiled(equations, folder) if COMPILER else None
    pytest.importorskip("casadi")
    casadi = equations.to_casadi()
    sp = pytest.importorskip("sympy")
    found = equations.to_sympy()
    symbols = [*found.q, *found.v, *found.u]
    assert len(set(symbols)) == len(symbols)
    lambdified = sp.lambdify(symbols, found.h, modules=["scipy", "numpy"])
    for q, v, u in random_states(equations, 4):
        expected = by_kernels(equations, (q, v, u)).h
        assert closeness(numpy.h(q, v, u), expected) < 1e-13
        assert closeness(np.array(casadi.h(q, v, u)), expected) < 1e-13
        assert closeness(lambdified(*q, *v, *u), expected) < 1e-13
        if compiled:
            M, h = np.zeros(1), np.zeros(1)
            compiled.call("equations", q, v, u, M, h)
            assert closeness(h, expected) < 1e-13


@pytest.mark.parametrize("name", NAMES)
def test_any_name_can_be_written(name: str, tmp_path: Path) -> None:
    law = {"effort": f"{name}*cos(phi)*cos(phi) + sin(w*{name})*sin(w*{name}) + (phi + {name} + w)^2*{name}"}
    equations = gelenk.equations(lever(inputs={name: {}}, law=law))
    assert [of.signal for of in equations.u] == [name]
    check(equations, tmp_path)


@pytest.mark.parametrize("text", FUNCTIONS)
def test_functions_have_their_values(text: str, tmp_path: Path) -> None:
    """Two whole numbers divide as such in C; the cube root of SymPy is complex, and CasADi has none."""
    equations = gelenk.equations(lever(law={"effort": text}))
    numpy = equations.to_numpy()
    for phi in (-0.3, 0.1, 0.7):
        torque = numpy.h([phi], [0.0], [])
        weight = -2.0 * 9.81 * 0.3 * math.cos(phi)
        assert torque[0] - weight == pytest.approx(-FUNCTIONS[text](phi), rel=1e-12)
    check(equations, tmp_path)


@pytest.mark.parametrize("name", ["*/ int x; /*", "ψ", "back\\", "double", "100% {x", "1st"])
def test_any_scene_name_can_be_written(name: str, tmp_path: Path) -> None:
    check(gelenk.equations({**lever(), "name": name}), tmp_path)
