# SPDX-License-Identifier: BSD-3-Clause
"""Measure the cone solvers for docs/cone-solvers.md: part of `make nonsmooth`.

Pictures are written to docs/pictures/, all figures as CSV to out/nonsmooth/. `--quick` solves twelve problems
and writes to out/nonsmooth/ only, as a test.
"""

from __future__ import annotations

import sys

from benchmarks.page_parts import NonsmoothStudy, quick_parser

from gelenk.chart import cones, draw_cones
from gelenk.chart.cone_problems import COUNT
from gelenk.chart.progress import status_line
from gelenk.chart.recorded_cones import recorded_scenes

MAKER = "benchmarks/cones.py"


def main() -> None:
    study = NonsmoothStudy("cone-solvers.md", quick_parser(__doc__).parse_args().quick)
    numbers = range(12 if study.quick else COUNT)
    scenes = recorded_scenes()[::2] if study.quick else recorded_scenes()
    parts = {}
    for name, exact in (("cones", False), ("cones-coulomb", True)):
        with status_line(sys.stderr) as progress:
            runs = cones.study(None, numbers, exact, scenes, progress)
        cones.write(runs, study.numbers / f"{name}.csv")
        picture = study.pictures / f"{name}.png"
        draw_cones.draw(runs, picture, exact)
        law = "Coulomb's law" if exact else "convex problems"
        parts[name] = (
            f"![{law}: work and failures against residual](pictures/{picture.name})\n\n" + cones.table(runs)
        )
        print(f"{picture.name}: {len(runs)} runs", flush=True)
    study.put(MAKER, parts)


if __name__ == "__main__":
    main()
