# SPDX-License-Identifier: BSD-3-Clause
"""Measure the cone solvers for docs/contact.md: part of `make nonsmooth`.

Pictures are written to docs/pictures/, all figures as CSV to out/nonsmooth/. `--quick` solves twelve problems
and writes to out/nonsmooth/ only, as a test.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.page_parts import put

from gelenk.chart import cones, draw_cones
from gelenk.chart.cone_problems import COUNT
from gelenk.chart.progress import status_line

ROOT = Path(__file__).resolve().parent.parent
NUMBERS = ROOT / "out" / "nonsmooth"
MAKER = "benchmarks/cones.py"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    pictures = NUMBERS if given.quick else ROOT / "docs" / "pictures"
    NUMBERS.mkdir(parents=True, exist_ok=True)
    parts = {}
    for name, exact in (("cones", False), ("cones-coulomb", True)):
        with status_line(sys.stderr) as progress:
            runs = cones.study(None, range(12 if given.quick else COUNT), exact, progress)
        cones.write(runs, NUMBERS / f"{name}.csv")
        picture = pictures / f"{name}.png"
        draw_cones.draw(runs, picture, exact)
        law = "Coulomb's law" if exact else "convex problems"
        parts[name] = (
            f"![{law}: work and failures against residual](pictures/{picture.name})\n\n" + cones.table(runs)
        )
        print(f"{picture.relative_to(ROOT)}: {len(runs)} runs", flush=True)
    target = NUMBERS / "contact.md" if given.quick else ROOT / "docs" / "contact.md"
    put(target, MAKER, parts)
    print(f"{target.relative_to(ROOT)}: {len(parts)} parts updated")


if __name__ == "__main__":
    main()
