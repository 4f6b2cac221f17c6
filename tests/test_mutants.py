# SPDX-License-Identifier: BSD-3-Clause
"""The places that `make mutants` changes are found."""

from pathlib import Path

import pytest
from mutants.places import ROOT, drawn, of_native, of_python


def test_thresholds_guards_and_fall_backs_of_cpp_are_found() -> None:
    text = """constexpr double tolerance = 1e-9;  // m
inline constexpr int most = 5;
constexpr double zero = 0;
void f() {
  if (x < tolerance && g(x)) return;
  if (x) {
  } catch (const E& e) {
  }
}
"""
    found = [(m.kind, m.line, m.after.strip()) for m in of_native(ROOT / "src/x.cpp", text, larger=True)]
    assert found == [
        ("threshold", 1, "constexpr double tolerance = 1e-06;  // m"),
        ("threshold", 2, "inline constexpr int most = 10;"),
        ("guard", 5, "if (false && (x < tolerance && g(x))) return;"),
        ("fall-back", 7, "} catch (const E& e) { throw;"),
    ]


def test_thresholds_guards_and_fall_backs_of_python_are_found() -> None:
    text = """LIMIT = 1e-8  # 1 µm
if TYPE_CHECKING:
    raise
def f(x):
    if x < LIMIT:
        return 1
    try:
        g()
    except ValueError:
        return 2
"""
    found = [(m.kind, m.line, m.after.strip()) for m in of_python(ROOT / "x.py", text, larger=False)]
    assert found == [
        ("threshold", 1, "LIMIT = 1e-11  # 1 µm"),
        ("guard", 5, "if False:"),
        ("fall-back", 10, "raise; return 2"),
    ]


@pytest.mark.thorough
def test_the_same_seed_draws_the_same_mutants_of_all_kinds() -> None:
    mutants = drawn(40, 3)
    assert [str(m) for m in mutants] == [str(m) for m in drawn(40, 3)]
    assert [str(m) for m in mutants] != [str(m) for m in drawn(40, 4)]
    assert len(mutants) == 40
    suffixes = {Path(m.path).suffix for m in mutants}
    assert ".py" in suffixes
    assert ".cpp" in suffixes
    assert {m.kind for m in mutants} == {"threshold", "guard", "fall-back"}
    assert all(m.text != m.path.read_text(encoding="utf-8") for m in mutants)
