# SPDX-License-Identifier: BSD-3-Clause
"""The page docs/modelica/README.md; `python tests/modelica_page.py` writes it anew from scenes and values."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent.parent / "docs" / "modelica"
PAGE = FOLDER / "README.md"

# Section: folders. Those of a library in its order of subjects.
SECTIONS = {
    "Mechanics.MultiBody": ("multibody_elementary", "multibody_loops", "multibody_systems"),
    "Mechanics.Rotational": ("rotational",),
    "Mechanics.Translational": ("translational",),
    "PlanarMechanics": ("planar", "planar_vehicles"),
}
# What no scene says, and why; by section.
MISSING = {
    "Mechanics.MultiBody": {
        "Elementary.InitSpringConstant": "a stiffness that is solved for at the start",
        "Elementary.ThreeSprings": "a point without mass between springs",
    },
    "Mechanics.Rotational": {},
    "Mechanics.Translational": {},
    "PlanarMechanics": {
        "InvertedCraneCrab": "a force at one joint that moves another one as prescribed",
    },
}
HEAD = "| model | scene | verified by | within |\n|---|---|---|---|\n"


def scenes(folder: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Return the scenes of a folder: name of the model in its section, file and values."""
    values = json.loads((FOLDER / folder / "values.json").read_text(encoding="utf-8"))
    found = []
    for name, of in values.items():
        model = str(of["model"]).removeprefix("Modelica.Mechanics.").removeprefix("PlanarMechanics.")
        for prefix in ("MultiBody.", "Rotational.", "Translational."):
            model = model.removeprefix(prefix)
        found.append((model.replace("Examples.", ""), f"{folder}/{name}.yaml", of))
    yield from sorted(found)


def first_comment(file: str) -> str:
    """Return what the first line of a scene says."""
    with (FOLDER / file).open(encoding="utf-8") as opened:
        return opened.readline().lstrip("# ").strip()


def page() -> str:
    """Return the text of the page."""
    counts: list[tuple[str, int, int]] = []
    tables = []
    for section, folders in SECTIONS.items():
        rows = [row for folder in folders for row in scenes(folder)]
        missing = {
            model: why for model, why in MISSING[section].items() if model not in {row[0] for row in rows}
        }
        counts.append((section, len(rows), len(rows) + len(missing)))
        text = f"## {section}\n\n{HEAD}"
        for model, file, of in rows:
            text += f"| {model} | [{first_comment(file)}]({file}) | {of['source']} | {of['bound']:.0e} |\n"
        for model, why in missing.items():
            text += f"| {model} | not: {why} | | |\n"
        tables.append(text)
    said, whole = sum(n for _, n, _ in counts), sum(of for _, _, of in counts)
    overview = "".join(f"| {section} | {of} | {n} |\n" for section, n, of in counts)
    return f"""# Coming from Modelica

The examples of the Modelica Standard Library 4.0.0 for mechanics and of PlanarMechanics, as scenes:
{said} of {whole} are here, complete with their loads, controllers, circuits and temperatures, so that no
co-simulation master has to add anything. Gelenk's tests run each of them at a tolerance of 1e-9 and compare
some of its signals with values that do not come from Gelenk.

| library | examples | as scenes |
|---|---|---|
{overview}
What in Modelica is a component is here

- a joint with fields: springs, dampers, friction, brakes and clutches, stops, one-way clutches
  ([joints](../scene-format.md#joints));
- an [expression](../scene-format.md#expressions): force laws, load torques and motions in time, fields,
  sources of all kinds; [tables](../scene-format.md#tables) for what is measured;
- [states](../scene-format.md#states-of-elements) by their rates: circuits, controllers, filters,
  temperatures, elements in series;
- a [constraint](../scene-format.md#constraints): gears with and without losses, racks, rolling wheels,
  points on surfaces;
- a [sensor](../scene-format.md#sensors);
- a [body with one moment of inertia](../scene-format.md#rotors): a rotor on a carrier that moves. Modelica's
  `Rotor1D` counts its moment about the axis to the carrier as well, which has to be given with it there; here
  it belongs to the rotor alone. In BevelGear1D, Modelica's carrier has been given without it, so that its
  kinetic energy is negative in some motions. The scene has the same numbers for carrier and rotors, each
  with an energy of its own, and therefore moves otherwise than Modelica's curves.

In the tables, *curve* is the result of Dymola 2020x that the Modelica Association publishes, *closed form*
and *conservation law* are formulas, and *independent integration* solves equations of motion that were
derived by hand, from event to event, at a tolerance of 1e-12. *Within* bounds the difference, relative to the
range of the signal; `values.json` beside the scenes has all values and says how they were found.

""" + "\n".join(tables)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
