# SPDX-License-Identifier: BSD-3-Clause
"""The folders are the architecture: includes and imports point one way, and each library has one room."""

import ast
import re
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# What a room may include of ours: itself and these.
BELOW: dict[str, set[str]] = {"util": set(), "math": set(), "linear": set(), "decomposition": set()}
BELOW |= {"expression": {"util", "math"}, "event": {"math", "util"}, "complementarity": {"linear", "util"}}
BELOW["field"] = BELOW["recording"] = BELOW["lanes"] = {"expression", *BELOW["expression"]}
BELOW["shape"] = BELOW["joint"] = {"field", "math", *BELOW["field"]}
BELOW |= {"collision": {"shape", *BELOW["shape"]}, "element": {"joint", *BELOW["joint"]}}
BELOW["scene"] = {"element", "shape", *BELOW["element"], *BELOW["shape"]}
BELOW["check"] = {"scene", "decomposition", *BELOW["scene"]}
BELOW["scene_file"] = {"check", *BELOW["check"]}
BELOW["scene_schema"] = {"scene_file", *BELOW["scene_file"]}
BELOW["mechanism"] = {"scene", *BELOW["scene"]}
BELOW["kinematics"] = {"mechanism", "linear", *BELOW["mechanism"]}
BELOW["derivatives"] = {"kinematics", *BELOW["kinematics"]}
BELOW["dynamics"] = {"derivatives", *BELOW["derivatives"]}
BELOW["machine_code"] = {"lanes", *BELOW["lanes"]}
BELOW["recorded"] = {"recording", "machine_code", "lanes"} | BELOW["dynamics"]
BELOW["contact_geometry"] = {"dynamics", "collision", *BELOW["dynamics"], *BELOW["collision"]}
BELOW["nonsmooth"] = {"dynamics", "complementarity", "decomposition", *BELOW["dynamics"]}
BELOW["time_stepping"] = {"contact_geometry", "nonsmooth", *BELOW["contact_geometry"], *BELOW["nonsmooth"]}
BELOW["event_driven"] = {"event", *BELOW["time_stepping"]}
BELOW["formulation"] = {"event_driven", "time_stepping", "recorded", *BELOW["recorded"]}
BELOW["formulation"] |= BELOW["event_driven"]
BELOW["integrator"] = {"formulation", *BELOW["formulation"]}
BELOW["outputs"] = {"dynamics", *BELOW["dynamics"]}
BELOW["assembly"] = {"decomposition", *BELOW["outputs"]}
BELOW["analysis"] = {"assembly", "event_driven", "outputs", *BELOW["assembly"], *BELOW["event_driven"]}
BELOW["preparation"] = {"analysis", "formulation", *BELOW["analysis"], *BELOW["formulation"]}
BELOW["simulation"] = {"integrator", "outputs", "preparation", *BELOW["integrator"], *BELOW["preparation"]}
BELOW["runs"] = BELOW["inspection"] = {"simulation", *BELOW["simulation"]}
BELOW["modelDescription"] = {"scene_file", "simulation", *BELOW["scene_file"], *BELOW["simulation"]}
BELOW["fmu/runtime"] = {"modelDescription", *BELOW["modelDescription"]}
BELOW["fmu/export"] = {"modelDescription", "scene_schema", "inspection", *BELOW["modelDescription"]}
BELOW["fmu"] = BELOW["fmu/page"] = {"fmu/runtime", *BELOW["fmu/runtime"]}
BELOW["fmu/fmi2"] = BELOW["fmu/fmi3"] = {"fmu", *BELOW["fmu"]}
BELOW["equations"] = {"simulation", *BELOW["simulation"]}
BELOW["batch"] = {"equations", "scene_file", *BELOW["equations"], *BELOW["scene_file"]}
BELOW["bindings"] = {"fmu/runtime", "fmu/export", "runs", "batch"} | BELOW["fmu/export"] | BELOW["batch"]

FOLDERS = {room: ROOT / "src" / room for room in BELOW} | {
    **{room: ROOT / room for room in BELOW if room.startswith(("fmu", "model"))},
    "bindings": ROOT / "python" / "bindings",
}

# Headers of other people's libraries, and the only room that may know each.
OWNERS = {
    "integrator": re.compile(r"(ida|idas|cvode|cvodes|arkode|kinsol|nvector|sun[a-z]*|sundials)/"),
    "fmu/fmi2": re.compile(r"fmi2\w*\.h"),
    "fmu/fmi3": re.compile(r"fmi3\w*\.h"),
    "scene_file": re.compile(r"(nlohmann|yaml-cpp)/"),
    "bindings": re.compile(r"(nanobind/|Python\.h)"),
}

LICENSE = "SPDX-License-Identifier: BSD-3-Clause"
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def code_files(*suffixes: str) -> Iterator[tuple[str, Path]]:
    """Every source file of every room, as (room, path)."""
    rooms = {folder: room for room, folder in FOLDERS.items()}
    for room, folder in FOLDERS.items():
        for path in sorted(folder.rglob("*")):
            nearest = next(parent for parent in path.parents if parent in rooms)
            if path.suffix in suffixes and rooms[nearest] == room:
                yield room, path


def room_of(name: str) -> str:
    """The room of an included file: its longest prefix that is a room."""
    if name.startswith("python/"):
        return "bindings"
    first, _, rest = name.partition("/")
    inner = f"{first}/{rest.partition('/')[0]}"
    return inner if inner in BELOW else first


def wrong_includes(room: str, text: str) -> list[str]:
    """The includes in `text`, a file of `room`, that this room must not have."""
    wrong = []
    for _, name in INCLUDE.findall(text):
        target = room_of(name)
        if target in BELOW and target != room and target not in BELOW[room]:
            wrong.append(name)
        wrong += [name for owner, headers in OWNERS.items() if owner != room and headers.match(name)]
    return wrong


@pytest.mark.parametrize(
    ("room", "line"),
    [
        ("math", '#include "joint/kind.h"'),
        ("scene", '#include "mechanism/mechanism.h"'),
        ("formulation", '#include "integrator/integrator.h"'),
        ("analysis", '#include "formulation/formulation.h"'),
        ("integrator", '#include "assembly/assembly.h"'),
        ("simulation", '#include "modelDescription/catalog.h"'),
        ("modelDescription", '#include "fmu/instance.h"'),
        ("modelDescription", '#include "fmu/runtime/plant.h"'),
        ("fmu/runtime", '#include "fmu/export/pack.h"'),
        ("simulation", "#include <idas/idas.h>"),
        ("dynamics", "#include <sundials/sundials_types.h>"),
        ("modelDescription", "#include <fmi2Functions.h>"),
        ("fmu", '#include "fmu/fmi3/adapter.h"'),
        ("modelDescription", "# include <nlohmann/json.hpp>"),
    ],
)
def test_the_check_sees_an_arrow_that_points_back(room: str, line: str) -> None:
    assert len(wrong_includes(room, f"#pragma once\n{line}\n")) == 1


def test_includes_point_one_way() -> None:
    files = list(code_files(".h", ".cpp"))
    assert len(files) > 20  # the folders were found
    wrong = [
        f"{path.relative_to(ROOT)} includes {name}"
        for room, path in files
        for name in wrong_includes(room, path.read_text(encoding="utf-8"))
    ]
    assert wrong == []


PACKAGE = ROOT / "python" / "gelenk"

# What a package of Python, or a module beside the packages, may import of ours: itself, other modules beside
# them, and these packages. Modules that are not listed may import none.
IMPORTS: dict[str, set[str]] = {"model": set()}
IMPORTS["viewer"] = IMPORTS["symbolic"] = IMPORTS["batches"] = {"model"}
IMPORTS["simulation"] = {"model", "viewer"}
for package in ("sweeps", "gradients", "io", "linear"):
    IMPORTS[package] = {"simulation", *IMPORTS["simulation"]}
IMPORTS["learning"] = {"batches", *IMPORTS["io"]}
IMPORTS["modal"] = {"linear", *IMPORTS["linear"]}
IMPORTS["equilibria"] = {"linear", *IMPORTS["linear"]}
IMPORTS["chart"] = {"io", "modal", "equilibria", *IMPORTS["modal"]}
IMPORTS["cli"] = {"chart", "sweeps", "symbolic", "viewer", *IMPORTS["chart"]}
IMPORTS |= {"demo": set(), "__main__": {"cli"}}
USERS = {"chart", "cli", "demo"}  # these use the whole as everybody does: `import gelenk`


def imported(text: str, *, later: bool = True) -> set[str]:
    """Modules that Python code imports, but for types alone.

    later: also those that functions import when they are called.
    """
    found: set[str] = set()
    waiting: list[ast.AST] = [ast.parse(text)]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
        elif later or not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            waiting += ast.iter_child_nodes(node)
    return found


def wrong_imports(package: str, text: str) -> list[str]:
    """The imports in `text`, a file of `package`, that this package must not have."""
    allowed = {package, *IMPORTS.get(package, set())}
    wrong = []
    for name in sorted(imported(text)):
        room = name.removeprefix("gelenk.").split(".")[0] if name.startswith("gelenk.") else ""
        if (name == "gelenk" and package not in USERS) or (room in IMPORTS and room not in allowed):
            wrong.append(name)
    return wrong


def python_files() -> list[tuple[str, Path]]:
    """Every file of the package gelenk, with the package of its own that it lives in, or its name."""
    files = sorted(PACKAGE.rglob("*.py"))
    return [
        (path.stem if path.parent == PACKAGE else path.relative_to(PACKAGE).parts[0], path) for path in files
    ]


@pytest.mark.parametrize(
    ("package", "line"),
    [
        ("model", "from gelenk.simulation.run import simulate"),
        ("model", "import gelenk"),
        ("simulation", "def late():\n    from gelenk.linear import linear_model"),
        ("linear", "from gelenk import modal"),
        ("equilibria", "import gelenk.modal.eigenvalues"),
        ("io", "if SOME:\n    from gelenk.cli import told"),
        ("errors", "from gelenk.model.values import unknown"),
    ],
)
def test_the_check_sees_an_import_that_points_back(package: str, line: str) -> None:
    assert len(wrong_imports(package, line)) == 1


def test_imports_for_types_alone_point_where_they_like() -> None:
    line = "if TYPE_CHECKING:\n    from gelenk.simulation.result import Result\n"
    assert wrong_imports("errors", line) == []


def test_imports_of_python_point_one_way() -> None:
    files = python_files()
    folders = {package for package, path in files if path.parent != PACKAGE}
    assert folders == {package for package in IMPORTS if (PACKAGE / package).is_dir()}
    assert {package for package, path in files if path.name == "__init__.py"} == {"__init__", *folders}
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for package, path in files
        for name in wrong_imports(package, path.read_text(encoding="utf-8"))
    ]
    assert wrong == []


def test_no_module_of_python_imports_itself_by_way_of_others() -> None:
    modules = {}
    for _, path in python_files():
        name = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        modules[name.removesuffix(".__init__")] = path.read_text(encoding="utf-8")
    graph = {
        module: {
            other
            for name in imported(text, later=False)
            for other in (name, name.rpartition(".")[0])
            if other in modules and other != module and not module.startswith(f"{other}.")
        }
        for module, text in modules.items()
    }
    assert sum(map(len, graph.values())) > len(graph)  # there is something to be found
    assert len([*TopologicalSorter(graph).static_order()]) == len(graph)  # raises CycleError


def joint_words() -> tuple[str, str]:
    """Alternatives of a regular expression: the names of the joint kinds, and of the structs behind them."""
    kinds, structs = set(), set()
    for path in (ROOT / "src" / "joint").glob("*.h"):
        text = path.read_text(encoding="utf-8")
        named = re.findall(r'std::string_view kind = "(\w+)"', text)
        if named:
            kinds.update(named)
            structs.update(re.findall(r"^struct (\w+)", text, re.MULTILINE))
    return "|".join(sorted(kinds)), "|".join(sorted(structs))


def joint_switches(text: str) -> list[str]:
    """The places in `text` that decide something by the kind of a joint."""
    kinds, structs = joint_words()
    name = rf"""["'](?:{kinds})["']"""
    patterns = [
        rf"(?:==|!=|\bcase)\s*{name}",
        rf"{name}(?:sv)?\s*(?:==|!=)",
        rf"\bin\s*[(\[{{][^)\]}}\n]*{name}",  # Python: kind in ("revolute", ...)
        r"\bswitch\s*\([^)\n]*\b(?:joint\w*\.|joint_?)(?:kind|type)\b",
        rf"\b(?:holds_alternative|get_if|get)<\s*(?:gelenk::)?(?:{structs})\s*>",
        rf"\bis_same(?:_v)?<[^;\n]*\b(?:{structs})\b",
    ]
    return [found.group(0) for pattern in patterns for found in re.finditer(pattern, text)]


@pytest.mark.parametrize(
    "line",
    [
        'if (joint.type == "revolute") turn();',
        'if ("prismatic"sv != kind) return;',
        'if joint.kind in ("planar", "free"):',
        "    case 'spherical':",
        "switch (joint.kind) {",
        "if (std::holds_alternative<Weld>(joint)) continue;",
        "if constexpr (std::is_same_v<J, Universal>) {",
    ],
)
def test_the_check_sees_a_switch_on_the_kind_of_joint(line: str) -> None:
    assert joint_switches(line)


def test_no_switch_on_the_kind_of_joint_outside_its_room() -> None:
    """The registry is asked instead: what a joint is stands in its own file."""
    files = [path for room, path in code_files(".h", ".cpp") if room != "joint"]
    # URDF's own words, "revolute" and "prismatic" among them, are the importer's business.
    files += [p for p in sorted((ROOT / "python" / "gelenk").rglob("*.py")) if "urdf" not in p.stem]
    found = [
        f"{path.relative_to(ROOT)}: {place}"
        for path in files
        for place in joint_switches(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def element_words() -> tuple[str, str]:
    """Likewise of the kinds of elements."""
    text = "".join(p.read_text(encoding="utf-8") for p in sorted((ROOT / "src" / "element").rglob("*.h")))
    kinds = re.findall(r'std::string_view kind = "(\w+)"', text)
    lists = re.findall(r"struct (?:Any\w+|JointForces)\s*:\s*std::(?:variant|tuple)<([^{;]+)>\s*\{", text)
    structs = re.findall(r"\b(?!std\b|optional\b)\w+", " ".join(lists))
    return "|".join(sorted(set(kinds))), "|".join(sorted(set(structs)))


def element_switches(text: str) -> list[str]:
    """The places in `text` that decide something by the kind of an element.

    Names of kinds are words of other matters, too ("frame", "energy"): these count where they are compared
    with a type or a kind, and those that are no plain words, as "knife_edge", wherever they are compared.
    """
    kinds, structs = element_words()
    name = rf"""["'](?:{kinds})["']"""
    own = "|".join(kind for kind in kinds.split("|") if "_" in kind)
    own_name = rf"""["'](?:{own})["']"""
    # joint.type, row["type"], row.get("type"), kind_of(c.is).kind
    typed = r"""\b(?:kind|type|summary)\b["']?(?:\]|\)|\(\))*"""
    patterns = [
        rf"{typed}\s*(?:==|!=)\s*{name}",
        rf"{name}(?:sv|s)?\s*(?:==|!=)\s*[\w.\->()\[\]\"']*\b(?:kind|type)\b",
        rf"{typed}\s+(?:not\s+)?in\s*[(\[{{][^)\]}}\n]*{name}",
        rf"(?:==|!=|\bcase)\s*{own_name}",
        rf"{own_name}(?:sv|s)?\s*(?:==|!=)",
        rf"\bin\s*[(\[{{][^)\]}}\n]*{own_name}",
        rf"\b(?:holds_alternative|get_if|get)<\s*(?:(?:gelenk::|std::optional<)\s*)?(?:{structs})\s*>",
        rf"\bis_same(?:_v)?<[^;\n]*\b(?:{structs})\b\s*>",
        rf"\b(?:{structs})::kind\b",
    ]
    return [found.group(0) for pattern in patterns for found in re.finditer(pattern, text)]


@pytest.mark.parametrize(
    "line",
    [
        'if (kind_of(force.is).kind == "spring_damper") pull();',
        'if (name == "knife_edge") cut();',
        'if ("reaction"sv != sensor.type) return;',
        'if row["type"] == "rolling":',
        'if row.get("type") == "frame":',
        'wheels = [row for row in rows if row["type"] in ("rolling", "gear")]',
        'if row["type"] not in ("energy",):',
        "    case 'spring_damper':",
        "if (std::holds_alternative<Rolling>(cut.joint)) continue;",
        "const auto* motion = std::get_if<gelenk::Motion>(&constraint.is);",
        "const auto& stop = std::get<std::optional<Stop>>(joint.along[0]);",
        "if constexpr (std::is_same_v<E, JointSpring>) {",
        "if (kind.kind == Wrench::kind) {",
    ],
)
def test_the_check_sees_a_switch_on_the_kind_of_element(line: str) -> None:
    assert element_switches(line)


@pytest.mark.parametrize(
    "line",
    [
        'fields[name] = reference("frame");',
        "return f\"{who} hold this {'motion' if motion else 'pose'}: {rest}\"",
        'names.take(always, "energy", {"kinetic", "potential", "total"});',
        'data["sensors"] = {name: {"type": "frame", "body": name} for name in heavy}',
        'if (key == "position") return;',
        'if prefix == "energy" and name != "frame":',
        "std::vector<Motion> V;",
        "const typename A::Motion& V = std::get<0>(motions);",
        "const Rod& rod = std::get<Rod>(cut.joint);",
    ],
)
def test_words_that_are_also_names_of_elements_are_no_switch(line: str) -> None:
    assert element_switches(line) == []


def test_no_switch_on_the_kind_of_element_outside_its_room() -> None:
    """An element's own header says what it does, and the registry what it has."""
    files = [path for room, path in code_files(".h", ".cpp") if room not in ("joint", "element")]
    files += [p for p in sorted((ROOT / "python" / "gelenk").rglob("*.py")) if "urdf" not in p.stem]
    found = [
        f"{path.relative_to(ROOT)}: {place}"
        for path in files
        for place in element_switches(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def own_files() -> Iterator[Path]:
    """Every file of code that people write."""
    yield from (path for _, path in code_files(".h", ".cpp"))
    for folder in ("python", "tests", "benchmarks", "cmake"):
        yield from sorted((ROOT / folder).rglob("*.py"))
    yield from sorted((ROOT / "cmake").glob("*.cmake"))


def test_every_file_names_its_licence() -> None:
    silent = [
        str(path.relative_to(ROOT))
        for path in own_files()
        if path.stat().st_size > 0 and LICENSE not in path.read_text(encoding="utf-8")[:200]
    ]
    assert silent == []
