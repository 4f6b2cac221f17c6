# SPDX-License-Identifier: BSD-3-Clause
"""All files of a folder are compiled together, so that they share the names that are local to each.

A second declaration is an error of the compiler. But two functions of one name are overloads, and one in an
inner namespace hides the other: a call then means another function than where the file is compiled alone.
"""

import re
from collections import defaultdict
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import pytest
from test_layout import BELOW

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = [*(ROOT / "src").iterdir(), ROOT / "modelDescription", ROOT / "python" / "bindings"]
FOLDERS += [ROOT / "fmu", *(ROOT / "fmu" / name for name in ("fmi2", "fmi3", "runtime", "export"))]

# A line that begins a declaration in an unnamed namespace; the code is formatted, so these are not indented.
DECLARATIONS = [
    re.compile(r"(?:struct|class|enum class|union) (\w+)"),
    re.compile(r"using (\w+) ="),
    re.compile(
        r"(?:static |inline )*(?:constexpr|const|thread_local)\b[^=({]*?\b(\w+)(?:\[\w*\])*\s*(?:=|\{)"
    ),
    re.compile(r"(?!using|return|typedef)[\w:<>,&*\s\[\]]*?[\w>&*\]]\s+[&*]?(\w+)\("),
]


def local_names(text: str) -> set[str]:
    """Names declared in unnamed namespaces of a file."""
    found = set()
    for part in re.findall(r"^namespace \{$(.*?)^\}  // namespace$", text, re.MULTILINE | re.DOTALL):
        for line in re.findall(r"^[^\s#/{}].*", part, re.MULTILINE):
            matches = (declaration.match(line) for declaration in DECLARATIONS)
            found |= {match[1] for match in matches if match}
    return found


def compiled_together(folder: Path) -> list[Path]:
    """Those of a folder of src and of the folders in it, but those that depend on kinds of forces."""
    files = folder.rglob("*.cpp") if folder.parent.name == "src" else folder.glob("*.cpp")
    return sorted(path for path in files if not path.name.endswith("_by_kind.cpp"))


def shared(texts: Iterable[str]) -> set[str]:
    """Names that several files declare for themselves."""
    count: dict[str, int] = defaultdict(int)
    for text in texts:
        for name in local_names(text):
            count[name] += 1
    return {name for name, files in count.items() if files > 1}


@pytest.mark.parametrize(
    "line",
    [
        "int index(double x) {",
        "[[noreturn]] void index(std::string_view what) {",
        "std::map<int, std::vector<double>> index(const Scene& scene,",
        "class index {",
        "using index = int;",
        "constexpr int index = 3;",
        "constexpr std::array<double, 2> index{1, 2};",
        "const char* index(int i) { return nullptr; }",
    ],
)
def test_the_check_sees_a_name_that_two_files_declare(line: str) -> None:
    texts = [
        f"namespace gelenk {{\nnamespace {{\n\n{line}\n\n}}  // namespace\n",
        "namespace {\nint index();\n}  // namespace\n",
    ]
    assert shared(texts) == {"index"}


def test_names_that_are_local_to_a_file_are_unique_in_its_folder() -> None:
    found = {}
    for folder in FOLDERS:
        names = shared(path.read_text(encoding="utf-8") for path in compiled_together(folder))
        if names:
            found[str(folder.relative_to(ROOT))] = names
    assert found == {}


def test_each_folder_is_compiled_in_one_way() -> None:
    """Hot, warm or cold; a folder that is in no list would be missing in the library."""
    text = (ROOT / "cmake" / "GelenkTargets.cmake").read_text(encoding="utf-8")
    lists = [
        set(words.split())
        for words in re.findall(r"^set\(GELENK_(?:HOT|WARM|COLD)\s([^)]*)\)", text, re.MULTILINE)
    ]
    assert len(lists) == 3
    assert all(not a & b for a, b in [*pairwise(lists), (lists[0], lists[2])])
    folders = [*FOLDERS, *(ROOT / "src").glob("*/*/")]
    compiled = {str(folder.relative_to(ROOT)) for folder in folders if any(folder.glob("*.cpp"))}
    python = {"python/bindings", "src/equations", "src/batch"}  # in no FMU
    assert set.union(*lists) == compiled - {"fmu", "fmu/fmi2", "fmu/fmi3", *python}


def test_the_page_on_the_architecture_has_all_modules_and_what_they_include() -> None:
    """Its table names what a module is built on; what that includes may be included, too."""
    text = (ROOT / "docs" / "internals" / "architecture.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w/]+)` \| [^|]+ \| (–|`[^|]+`) \|$", text, re.MULTILINE)
    on = {name: set(re.findall(r"`([\w/]+)`", names)) for name, names in rows}

    def below(name: str) -> set[str]:
        return on[name].union(*(below(other) for other in on[name]))

    assert {name.replace("python/", ""): below(name) for name in on} == BELOW


def test_what_depends_on_the_kinds_of_forces_is_compiled_apart() -> None:
    """So that a new kind recompiles little: each of these files is read by few."""
    readers: dict[str, set[str]] = defaultdict(set)
    for folder in FOLDERS:
        for path in folder.rglob("*.*"):
            if path.suffix in {".h", ".cpp"}:
                name = str(path.relative_to(ROOT)).removeprefix("src/")
                for included in re.findall(r'^#include "([^"]+)"', path.read_text("utf-8"), re.MULTILINE):
                    readers[included].add(name)

    def read_by(header: str) -> set[str]:
        return readers[header].union(*(read_by(name) for name in readers[header] if name.endswith(".h")))

    units = {name for name in read_by("element/forces/registry.h") if name.endswith(".cpp")}
    assert len(units) > 4
    assert {name for name in units if not name.endswith("_by_kind.cpp")} == {
        "element/registry.cpp",
        "outputs/outputs.cpp",
        "outputs/outputs_dual.cpp",
        "outputs/wrenches.cpp",
    }
