# SPDX-License-Identifier: BSD-3-Clause
"""Compares all listed scenes and 2000 random ones at special positions: `make special`.

python -m special.study                       all; findings are written to build/special.txt
python -m special.study --random 100 --from 300
python -m special.study --only "random 87"    one of them again, or all whose names contain this
"""

from __future__ import annotations

import argparse
import collections
import itertools
import multiprocessing
import time
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from .compare import Verdict, compared
from .drawn import Case, drawn
from .finished import finished
from .listed import families, starts

FOUND = ("DISAGREE", "REFUSED", "CRASH", "SLOW", "SINGULAR", "ALARM")
KINDS = ("agree", "refused", "warned", "sensitive", "skipped", *FOUND, "ELSEWHERE")
MEANING = """
agree     within the tolerance
refused   with a message: singular position, values that no position has, or a documented limitation
warned    beyond the tolerance, but the start gave a warning
sensitive a run at another tolerance ends elsewhere, too
skipped   nothing to compare
DISAGREE  beyond the tolerance
REFUSED   by one way of computing alone, or at a position where nothing is singular
CRASH     without a message
SLOW      more than 60 s of CPU time
ELSEWHERE loops are closed farther from the guesses in another order of the file: no error, for inspection
SINGULAR  beyond the tolerance, at a position where derivatives or accelerations may not exist, and no warning
ALARM     a warning, although nothing is singular
"""
REPORT = Path("build") / "special.txt"


def cases(count: int, first: int) -> Iterator[tuple[str, int]]:
    """Names of families, numbers of random mechanisms."""
    yield from ((name, -1) for name, _ in families())
    yield from ((f"random {seed}", seed) for seed in range(first, first + count))


def judged(task: tuple[str, int]) -> list[tuple[str, str, list[Verdict]]]:
    """Family, name and verdicts of each start."""
    name, seed = task
    if seed >= 0:
        case = drawn(seed)
        return [(case.name.split()[0], f"random {seed}: {case.name}", of(case, seed))]
    source = dict(families())[name]
    by_scene = [(name, case.name, of(case, i)) for i, case in enumerate(starts(name, source))]
    return by_scene + [(name, *found) for found in finished(name, source)]


def of(case: Case, seed: int) -> list[Verdict]:
    """The verdicts of a case; an exception of the comparison itself is one, too."""
    try:
        return compared(case, seed)
    except Exception as e:
        return [Verdict("comparison", "CRASH", f"{type(e).__name__}: {e}")]


def table(counts: dict[str, collections.Counter[str]]) -> str:
    width = max(map(len, counts), default=0)
    rows = [[f"{counts[name][kind] or '':>10}" for kind in KINDS] for name in counts]
    head = f"{'':{width}} " + "".join(f"{kind:>10}" for kind in KINDS)
    sums = [f"{sum(c[kind] for c in counts.values()):>10}" for kind in KINDS]
    lines = [f"{name:{width}} " + "".join(row) for name, row in zip(counts, rows, strict=True)]
    return "\n".join([head, *lines, f"{'all':{width}} " + "".join(sums)])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--random", type=int, default=2000, help="how many random mechanisms")
    parser.add_argument("--from", type=int, default=0, dest="first", help="the number of the first of them")
    parser.add_argument("--only", default="", help="those whose names contain this")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    tasks = list(cases(options.random, options.first))
    if options.only:
        tasks = [t for t in tasks if t[0] in options.only or options.only in t[0]]
    counts: dict[str, collections.Counter[str]] = {}
    findings = 0
    began = time.monotonic()
    REPORT.parent.mkdir(exist_ok=True)
    with multiprocessing.Pool(options.jobs) as pool, REPORT.open("w", encoding="utf-8") as report:
        done = tqdm(pool.imap_unordered(judged, tasks), total=len(tasks), mininterval=10)
        for family, name, verdicts in itertools.chain.from_iterable(done):
            counts.setdefault(family, collections.Counter()).update(v.kind for v in verdicts)
            found = [
                f"{name} | {v.check}: {v.kind}: {v.words}"
                for v in verdicts
                if v.kind in (*FOUND, "ELSEWHERE")
            ]
            report.writelines(f"{line}\n" for line in found)
            report.flush()
            findings += len(found)
    print(table(dict(sorted(counts.items()))))
    print(MEANING)
    print(f"{time.monotonic() - began:.0f} s; {findings} findings in {REPORT}")


if __name__ == "__main__":
    main()
