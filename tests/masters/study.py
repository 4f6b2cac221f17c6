# SPDX-License-Identifier: BSD-3-Clause
"""Runs masters that are there and writes the table of docs/fmu.md: `python -m masters.study [NAME...]`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from .jobs import SCENES, jobs
from .masters import HERE, MASTERS, outcome

PAGE = HERE.parents[1] / "docs" / "fmu.md"
BEGIN, END = "<!-- table: made by tests/masters/study.py -->\n", "<!-- end of table -->"


def main() -> None:
    """Of masters that are missing here, or not asked for, the line stays as it is."""
    asked_for = sys.argv[1:] or [master.name for master in MASTERS]
    page = PAGE.read_text(encoding="utf-8")
    begin = page.index(BEGIN) + len(BEGIN)
    end = page.index(END, begin)
    old = {line.split("|")[1].strip(): line for line in page[begin:end].splitlines() if line.startswith("|")}
    lines = ["| Master | version | FMUs | runs | bitwise identical | warnings |", "|---|---|---|---|---|---|"]
    for master in MASTERS:
        if master.missing or master.name not in asked_for:
            print(f"{master.name}: {master.missing or 'not asked for'}")
            lines += [old[master.name]] if master.name in old else []
            continue
        with tempfile.TemporaryDirectory() as name:
            asked = jobs(Path(name))
            found = outcome(master, asked, Path(name))
        print(*found.different, *found.warnings, sep="\n")
        same = len(asked) - len(found.different)
        lines.append(
            f"| {master.name} | {master.version} | {len(SCENES)} | {len(asked)} | {same} "
            f"| {len(found.warnings) or 'none'} |"
        )
        print(lines[-1], flush=True)
    PAGE.write_text(page[:begin] + "\n".join(lines) + "\n" + page[end:], encoding="utf-8")


if __name__ == "__main__":
    main()
