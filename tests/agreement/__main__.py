# SPDX-License-Identifier: BSD-3-Clause
"""Run many trials, in the folder tests: `python -m agreement [count] [first]`.

Prints a line of JSON for each finding, with the number of its trial, and a summary. A trial that takes too
long or crashes is reported, too. `python -m agreement --minimize SEED` makes one as small as possible.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from concurrent.futures import TimeoutError as LateError

from pebble import ProcessExpired, ProcessPool

from .compare import Comparison, Finding, as_line, found_in
from .drawn import drawn
from .minimize import minimized

SECONDS_EACH = 300


def study(count: int, first: int, jobs: int) -> int:
    """Print what is found; return the number of trials with findings other than a refusal."""
    kinds: Counter[str] = Counter()
    wrong = 0
    with ProcessPool(jobs, max_tasks=200) as pool:
        results = pool.map(found_in, range(first, first + count), timeout=SECONDS_EACH).result()
        for seed in range(first, first + count):
            try:
                found = next(results)
            except LateError:
                found = [Finding(seed, "slow", f"more than {SECONDS_EACH} s")]
            except ProcessExpired as error:
                found = [Finding(seed, "crash", str(error))]
            except Exception as error:
                found = [Finding(seed, "error", f"{type(error).__name__}: {error}")]
            for finding in found:
                print(as_line(finding), flush=True)
                kinds[finding.way] += 1
            wrong += any(f.way not in ("refused", "not started") for f in found)
    print(f"{count} trials, {wrong} with findings: {dict(kinds)}")
    return wrong


def show(seed: int) -> None:
    trial = drawn(seed)
    for finding in Comparison(trial, seed).findings():
        small, kept = minimized(trial, finding)
        print(as_line(kept))
        courses = {name: [course.knots, course.values] for name, course in small.inputs.items()}
        print(json.dumps({"scene": small.scene, "points": small.points, "inputs": courses}))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=3000)
    parser.add_argument("first", type=int, nargs="?", default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--minimize", type=int, metavar="SEED")
    given = parser.parse_args()
    if given.minimize is not None:
        show(given.minimize)
        return 0
    return int(study(given.count, given.first, given.jobs) > 0)


if __name__ == "__main__":
    sys.exit(main())
