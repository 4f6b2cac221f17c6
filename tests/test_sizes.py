# SPDX-License-Identifier: BSD-3-Clause
"""Files and classes stay small enough to be held in the head."""

import re
from collections import defaultdict
from collections.abc import Iterator

from test_layout import ROOT, code_files, own_files

MAX_LINES = 400
MOST_PUBLIC = 24
MOST_PROTECTED = 12

# Classes that are longer over all their files, and how long they may be.
LONG = {
    ("time_stepping", "TimeStepper"): 810,
    ("derivatives", "RecursiveJacobians"): 630,
}

CLASS = re.compile(r"\bclass\s+(?:\[\[\w+\]\]\s*)?(\w+)(?:\s+final)?(?:\s*:(?!:)[^;{}()=]*)?\s*\{")
ACCESS = re.compile(r"\s*(public|protected|private)\s*:$")
NO_MEMBER = re.compile(r"(template <[^;]*> )?(using|friend|enum|struct|class|static constexpr)\b")


def without_comments(text: str) -> str:
    text = re.sub(r'"(?:[^"\\\n]|\\.)*"', '""', text)
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)
    return re.sub(r"^\s*#[^\n]*", "", text, flags=re.MULTILINE)


def statements(body: str) -> Iterator[str]:
    """The declarations and access specifiers of a class body, what is in braces left out."""
    depth = 0
    current = ""
    for i, c in enumerate(body):
        if c == "}":
            depth -= 1
            rest = body[i + 1 :].lstrip()
            if depth == 0 and "(" in current and not rest.startswith((";", ",", "{")):
                yield current.strip()
                current = ""
        elif c == "{":
            depth += 1
        elif depth == 0 and c == ";":
            yield current.strip()
            current = ""
        elif depth == 0:
            current += c
            if ACCESS.match(current):
                yield current.strip()
                current = ""


def members(name: str, body: str) -> dict[str, list[str]]:
    """Functions and data by access; constructors, assignments, types and constants left out."""
    access = "private"
    found: dict[str, list[str]] = {"public": [], "protected": [], "private": []}
    for statement in statements(body):
        if specifier := ACCESS.match(statement):
            access = specifier[1]
            continue
        text = " ".join(statement.split())
        is_constructor = re.search(rf"(^|[\s~]){name} ?\(", text)
        if text and not is_constructor and "operator=" not in text and not NO_MEMBER.match(text):
            found[access].append(text)
    return found


def classes(text: str) -> Iterator[tuple[str, dict[str, list[str]]]]:
    code = without_comments(text)
    for match in CLASS.finditer(code):
        if code[: match.start()].rstrip().endswith("enum"):
            continue
        depth, end = 1, match.end()
        while depth > 0:
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        yield match[1], members(match[1], code[match.end() : end - 1])


def test_the_count_sees_members() -> None:
    text = """
    enum class Kind { one };
    class A final : public B {
     public:
      A(int x) : x_{x} {}
      A& operator=(const A&) = delete;
      int f() const { return g({1, 2}); }  // a member
      virtual void h(int a = 1) = 0;
      using T = int;
     protected:
      std::vector<int> data_{1, 2};
     private:
      int x_ = 0, y_;
    };
    """
    [(name, found)] = classes(text)
    assert name == "A"
    assert {access: len(of) for access, of in found.items()} == {"public": 2, "protected": 1, "private": 1}


def test_classes_are_narrow() -> None:
    seen = 0
    wide = []
    for _, path in code_files(".h"):
        for name, found in classes(path.read_text(encoding="utf-8")):
            seen += 1
            if len(found["public"]) > MOST_PUBLIC or len(found["protected"]) > MOST_PROTECTED:
                wide.append(
                    f"{path.relative_to(ROOT)}: {name} has {len(found['public'])} public and "
                    f"{len(found['protected'])} protected members"
                )
    assert seen > 50
    assert wide == []


def test_files_are_short() -> None:
    lengths = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in own_files()
    }
    assert {name: lines for name, lines in lengths.items() if lines > MAX_LINES} == {}


# The code is formatted: what begins in the first column ends there.
BODY = re.compile(r"(?:class|struct) (?:\[\[\w+\]\] )?(\w+)(?: final)?(?: :[^;]*)?\{")
MEMBER = re.compile(r"[^\s/#}].*?(?<![\w:])(\w+)(?:<[^<>]*>)?::~?(?:operator\S+|\w+)\((?!.*;$)")


def lines_of_classes(text: str) -> dict[str, int]:
    """Lines of the bodies of classes, and of their members that are defined outside these."""
    count: dict[str, int] = defaultdict(int)
    name = None
    for line in text.splitlines():
        begins = name is None
        if begins and (match := BODY.match(line) or MEMBER.match(line)):
            name = match[1]
        if name is not None:
            count[name] += 1
            if line.startswith("}") or (begins and line.endswith("}")):
                name = None
    return count


def test_the_count_of_lines_sees_members_outside_a_class() -> None:
    text = """class A final : public B {
  int f() const;
};
template <class T>
int A::f() const {
  return g();
}
bool A::g() { return true; }
int h() {
  return 0;
}
"""
    assert lines_of_classes(text) == {"A": 3 + 3 + 1}


def test_classes_are_short_over_all_their_files() -> None:
    count: dict[tuple[str, str], int] = defaultdict(int)
    for room, path in code_files(".h", ".cpp"):
        for name, lines in lines_of_classes(path.read_text(encoding="utf-8")).items():
            count[room, name] += lines
    long = {key: lines for key, lines in count.items() if lines > MAX_LINES}
    assert long.keys() == LONG.keys()
    assert {key: lines for key, lines in long.items() if lines > LONG[key]} == {}
