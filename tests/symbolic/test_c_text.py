# SPDX-License-Identifier: BSD-3-Clause
"""The C source compiles without a warning as C99, and gives the numbers of the kernels."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gelenk
from gelenk import Equations

from .states import Numbers, State, by_kernels, closed_states, closeness
from .test_traced_scenes import SCENES

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler")

NAMES = ["pendulum", "double_pendulum", "four_bar", "slider_crank", "five_bar", "jansen_leg", "heavy_top",
         "free_body", "stewart", "andrews", "bennett", "delta_robot"]  # fmt: skip


class Compiled:
    """The functions of a C text, called with arrays of NumPy."""

    def __init__(self, equations: Equations, folder: Path) -> None:
        self._prefix = equations._system.identifier
        source, library = folder / "equations.c", folder / "equations.so"
        source.write_text(equations.to_c())
        warnings = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
        built = subprocess.run(
            [str(COMPILER), *warnings, "-O1", "-shared", "-fPIC", source, "-o", library, "-lm"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert built.returncode == 0, built.stderr
        self._library = ctypes.CDLL(str(library))

    def call(self, name: str, *arguments: Numbers | float) -> int:
        function = getattr(self._library, f"{self._prefix}_{name}")
        return int(
            function(
                *(
                    ctypes.c_double(of) if isinstance(of, float) else of.ctypes.data_as(ctypes.c_void_p)
                    for of in arguments
                )
            )
        )


@pytest.mark.parametrize("name", NAMES)
def test_compiled_equations_are_those_of_the_kernels(name: str, tmp_path: Path) -> None:
    equations = gelenk.equations(SCENES[name])
    functions = equations.to_numpy()
    compiled = Compiled(equations, tmp_path)
    nv, rows = len(equations.v), len(equations.rows)
    for q, v, u in closed_states(equations, functions, 20):
        M, h, J, gamma = np.ones(nv * nv), np.ones(nv), np.ones(rows * nv), np.ones(rows)
        compiled.call("equations", q, v, u, M, h, *([J, gamma] if rows else []))
        for found, expected in zip((M, h, J, gamma), functions.equations(q, v, u), strict=True):
            assert closeness(found, expected) < 1e-13
        vdot, multipliers = np.zeros(nv), np.zeros(rows)
        assert compiled.call("accelerations", q, v, u, vdot, *([multipliers] if rows else [])) == 1
        assert closeness(vdot, by_kernels(equations, (q, v, u)).vdot) < 1e-11
        residual = functions.M(q) @ vdot + functions.h(q, v, u) + functions.J(q).T @ multipliers
        assert np.abs(residual).max() < 1e-12 * max(1, np.abs(functions.h(q, v, u)).max())


def run(compiled: Compiled, state: State, steps: int, dt: float) -> tuple[Numbers, Numbers]:
    q, v, u = (of.copy() for of in state)
    for _ in range(steps):
        assert compiled.call("step", q, v, u, dt) == 1
    return q, v


def test_steps_have_order_four_and_keep_the_loop_closed(tmp_path: Path) -> None:
    """Halving the step divides the error by 16; a scheme of another order, or a projection that disturbs
    it, gives another ratio.
    """
    equations = gelenk.equations(SCENES["four_bar"])
    functions = equations.to_numpy()
    compiled = Compiled(equations, tmp_path)
    state = closed_states(equations, functions, 1)[0]
    exact, _ = run(compiled, state, 6400, 0.2 / 6400)
    errors = []
    for steps in (50, 100):
        q, v = run(compiled, state, steps, 0.2 / steps)
        errors.append(np.abs(q - exact).max())
        assert np.abs(functions.Phi(q, state[2])).max() < 1e-14
        assert np.abs(functions.J(q) @ v).max() < 1e-12
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.15)


def test_a_pendulum_swings_as_in_the_closed_form(tmp_path: Path) -> None:
    """The energy of 2000 steps is kept to the error of the method, and the simulation of the scene agrees."""
    equations = gelenk.equations(SCENES["double_pendulum"])
    functions = equations.to_numpy()
    compiled = Compiled(equations, tmp_path)
    of_q, of_v, of_u = (
        np.array([of.start for of in arguments], np.float64)
        for arguments in (equations.q, equations.v, equations.u)
    )
    start = (of_q, of_v, of_u)
    q, v = run(compiled, start, 2000, 5e-4)
    before = functions.kinetic(start[0], start[1]) + functions.potential(start[0])
    after = functions.kinetic(q, v) + functions.potential(q)
    assert after == pytest.approx(before, abs=1e-8 * abs(before))
    scene = gelenk.load(SCENES["double_pendulum"])
    simulated = gelenk.simulate(scene, stop=1.0, step=0.1, tolerance=1e-11)
    for of, found in zip(equations.q, q, strict=True):
        assert found == pytest.approx(simulated[of.signal][-1], abs=1e-7)


def test_accelerations_of_a_four_bar_are_short() -> None:
    """The matrices of a planar loop of three moving links, sums of a few products, in lines one can read."""
    text = gelenk.equations(SCENES["four_bar"]).to_c()
    body = text[text.index("void four_bar_equations") :]
    lines = body[: body.index("\n}\n")].splitlines()
    assert len(lines) <= 65
    assert max(map(len, lines)) <= 160
    for name in ("cos_A", "phi_A", "w_A", "tau_drive"):
        assert name in body


def test_the_source_allocates_nothing_and_includes_the_mathematical_library_alone() -> None:
    text = gelenk.equations(SCENES["stewart"]).to_c()
    assert [line for line in text.splitlines() if line.startswith("#")] == ["#include <math.h>"]
    assert "alloc" not in text
