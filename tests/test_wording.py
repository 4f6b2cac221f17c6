# SPDX-License-Identifier: BSD-3-Clause
"""Code, messages and pages use the field's terms: docs/wording.toml lists what they avoid."""

import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "docs" / "wording.toml"
LOOKED_AT = ("src", "fmu", "modelDescription", "python", "docs", "scenes", "cmake", "*.md", "Makefile")
WORDING = tomllib.loads(LIST.read_text(encoding="utf-8"))

# The parts of an identifier are words: "slope_along", "bestSlope".
BETWEEN_WORDS = re.compile(r"(?<=[a-z])(?=[A-Z])")
MAX_ALLOWED = 20
# One expression, so that each text is read once.
PATTERNS = "|".join(f"(?P<_{k}>{entry['pattern']})" for k, entry in enumerate(WORDING["avoid"]))
AVOIDED = re.compile(rf"(?<![A-Za-z])(?:{PATTERNS})(?![A-Za-z])", re.IGNORECASE)


def avoided(text: str) -> Iterator[tuple[int, str, str]]:
    """The avoided words of a text: line, what was found there, what to write instead."""
    words = BETWEEN_WORDS.sub("_", text)
    for match in AVOIDED.finditer(words):
        assert match.lastgroup is not None
        instead = WORDING["avoid"][int(match.lastgroup[1:])]["write"]
        yield words.count("\n", 0, match.start()) + 1, match[0], instead


def files() -> list[Path]:
    command = ["git", "-C", str(ROOT), "ls-files", "--", *LOOKED_AT]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return [
        ROOT / name
        for name in listed
        if not name.endswith((".png", ".gif", LIST.name)) and (ROOT / name).is_file()
    ]


def test_texts_avoid_the_words_of_the_list() -> None:
    looked_at = files()
    assert len(looked_at) > 400
    allowed = {(entry["file"], entry["word"].lower()): 0 for entry in WORDING.get("allowed", [])}
    faults = []
    for path in looked_at:
        name = str(path.relative_to(ROOT))
        for line, found, instead in avoided(path.read_text(encoding="utf-8")):
            if (name, found.lower()) in allowed:
                allowed[name, found.lower()] += 1
            else:
                faults.append(f"{name}:{line}: found '{found}', write: {instead}")
    assert not faults, "\n".join(faults)
    assert [key for key, count in allowed.items() if count == 0] == []  # exceptions that are no longer needed
    assert sum(allowed.values()) < MAX_ALLOWED


def test_every_exception_has_a_reason() -> None:
    assert all(len(entry["reason"]) > 10 for entry in WORDING.get("allowed", []))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2 freedoms", ["freedoms"]),
        ("2 degrees of freedom", []),
        ("out.degrees_of_freedom", []),
        ("Jacobian slope_along(x)", ["slope"]),
        ("RecursiveSlopes", ["Slopes"]),
        ("The standard library tells nothing", ["tells"]),
        ("a Standing wave", ["Standing"]),
    ],
)
def test_the_list_sees_words_inside_identifiers(text: str, expected: list[str]) -> None:
    assert [found for _, found, _ in avoided(text)] == expected


def test_words_of_the_glossary_exist() -> None:
    """The second column quotes code and scene files: each word in it is found in one of them."""
    code = "\n".join(
        path.read_text(encoding="utf-8")
        for path in files()
        if path.suffix in (".h", ".cpp", ".py", ".yaml") or path.name == "scene-format.md"
    )
    rows = re.findall(
        r"^\| ([^|]+) \| ([^|]+) \|", (ROOT / "docs" / "glossary.md").read_text("utf-8"), re.MULTILINE
    )
    quoted = {word for _, cell in rows[1:] for word in re.findall(r"`([^`]+)`", cell)}
    assert len(quoted) > 60
    names = {word.rstrip("()").removesuffix(".*").rpartition(".")[2] or word for word in quoted}
    words = set(re.findall(r"\w+", code))
    missing = [name for name in sorted(names - words) if not re.search(rf"\b{re.escape(name)}\b", code)]
    assert missing == []
