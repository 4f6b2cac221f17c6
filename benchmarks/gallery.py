# SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of docs/gallery with the viewer, and writes its list: `make gallery`."""

from __future__ import annotations

import argparse
import io
import re
from dataclasses import dataclass, field
from pathlib import Path

import gelenk

ROOT = Path(__file__).resolve().parent.parent
GALLERY = ROOT / "docs" / "gallery"
SIZE = (400, 300)  # pixels
PLOT, DPI = (320, 300), 80  # pixels, pixels per inch
COLORS = 96  # of still pictures
FIRST = "jansen_leg"  # on the first page
COLUMNS = 3


@dataclass(frozen=True)
class Shot:
    """How a mechanism is shown.

    Args:
        span: the times that the film shows [s].
        still: time of the still picture [s].
        speed: of the film, relative to real time.
        camera: as for `View.save`.
        frame_rate: of the film [1/s].
        trails: whether paths of points are shown.
        inputs: inputs of the run.
    """

    span: tuple[float, float]
    still: float = 0.0
    speed: float = 1.0
    camera: str | tuple[float, float] = "start"
    frame_rate: float = 12.0
    trails: bool = False
    inputs: dict[str, float] = field(default_factory=dict)


BRAKING = {f"hub_{corner}.friction.engagement": 1.0 for corner in ("fl", "fr", "rl", "rr")}
TILTING = {"drive1.f": 600.0, "drive2.f": 600.0, "drive4.f": -600.0, "drive5.f": -600.0}  # N

SHOTS: dict[str, dict[str, Shot]] = {
    "Linkages in the plane": {
        "jansen_leg": Shot((0, 2), 0.5, trails=True),
        "four_bar": Shot((0, 4), 0.4),
        "slider_crank": Shot((0, 3), 0.0),
        "five_bar": Shot((0, 2), 0.0, inputs={"motor_left.tau": -0.003, "motor_right.tau": -0.001}),
        "windscreen_wiper": Shot((0, 2), 0.4),
        "excavator": Shot((0, 8), 1.5, speed=2.0),
        "andrews": Shot((0, 0.03), 0.0, speed=0.006),
    },
    "Linkages in space": {
        "bennett": Shot((0, 4), 0.6, trails=True),
        "bricard": Shot((0, 5), 0.7),
        "delta_robot": Shot((0, 2), 0.0, trails=True),
        "stewart": Shot((0, 2), 0.0, inputs=TILTING),
        "double_wishbone": Shot((0, 2), 0.5, camera=(-130, 15)),
    },
    "Gears and wheels": {
        "gears": Shot((0, 3), 1.0),
        "planetary_gear": Shot((0, 3.5), 0.3, camera=(-80, 50)),
        "gear_shift": Shot((0, 3), 0.3, camera=(-60, 25), inputs={"clutch2.friction.engagement": 0.5}),
        "worm_hoist": Shot((0, 2), 0.3, camera=(-60, 15)),
        "backlash_drive": Shot((0, 2), 0.15, speed=0.5, camera=(-70, 50)),
        "differential": Shot((0, 7), 0.5, speed=1.5),
        "rolling_disc": Shot((0, 4.19), 0.6, trails=True),
        "mast_arm_disc": Shot((0, 6), 0.0, speed=1.5),
        "car": Shot((0, 2.2), 0.55, camera=(-28, 14), inputs=BRAKING),
        "bicycle": Shot((0, 2.5), 0.5, frame_rate=8.0),
        "balancing_robot": Shot((0, 1), 0.0, speed=0.4, inputs={"push.f[1]": 0.1}),
        "cart_pole": Shot((0, 5), 0.6, speed=1.25),
    },
    "Contacts": {
        "gripper": Shot((0, 1.4), 0.9, inputs={"grip1.tau": 0.8, "grip2.tau": 0.8}),
        "cam": Shot((0.7, 0.95), 0.72, speed=0.1),
        "ratchet": Shot((0, 0.3), 0.1, speed=0.1, inputs={"load.tau": -0.1}),
        "bucket": Shot((0, 8), 4.0, speed=2.0),
    },
    "Pendulums and tops": {
        "pendulum": Shot((0, 4), 0.0, trails=True),
        "double_pendulum": Shot((0, 4), 0.3, trails=True),
        "free_body": Shot((0, 24), 0.0, speed=6.0),
        "heavy_top": Shot((0, 2), 0.0, speed=0.5),
    },
}


def scene_file(name: str) -> Path:
    """Return the scene of a mechanism: its own, or one of the package."""
    own = GALLERY / name / "scene.yaml"
    return own if own.exists() else ROOT / "scenes" / f"{name}.yaml"


def draw(name: str, shot: Shot) -> None:
    """Write the picture and the film of a mechanism."""
    from PIL import Image

    view = gelenk.view(scene_file(name), stop=shot.span[1], inputs=shot.inputs)
    picture, film = GALLERY / name / "picture.png", GALLERY / name / "moving.gif"
    camera, trails = shot.camera, shot.trails
    view.save(picture, size=SIZE, camera=camera, trails=trails, span=(shot.still, shot.span[1]))
    Image.open(picture).convert("RGB").quantize(COLORS).save(picture, optimize=True)
    view.save(
        film, size=SIZE, camera=camera, trails=trails, span=shot.span, speed=shot.speed,
        frame_rate=shot.frame_rate,
    )  # fmt: skip


def draw_with_plot(name: str, shot: Shot, signals: list[str], path: Path) -> None:
    """Write the film of a mechanism beside the plot of some signals, on which a line marks the time."""
    from PIL import Image, ImageSequence

    result = gelenk.simulate(scene_file(name), stop=shot.span[1], inputs=shot.inputs)
    figure = result.plot(signals)
    figure.set_size_inches(PLOT[0] / DPI, PLOT[1] / DPI)
    marks = [axis.axvline(shot.span[0], color="#c2410c", lw=1.2) for axis in figure.axes]
    pictures = []
    with Image.open(GALLERY / name / "moving.gif") as film:
        for k, frame in enumerate(ImageSequence.Iterator(film)):
            time = shot.span[0] + k * shot.speed / shot.frame_rate
            for mark in marks:
                mark.set_xdata([time, time])
            buffer = io.BytesIO()
            figure.savefig(buffer, dpi=DPI)
            both = Image.new("RGB", (SIZE[0] + PLOT[0], SIZE[1]), "white")
            both.paste(frame.convert("RGB"), (0, 0))
            both.paste(Image.open(buffer).convert("RGB"), (SIZE[0], 0))
            pictures.append(both.quantize(32, dither=Image.Dither.NONE))
    pictures[0].save(
        path, save_all=True, append_images=pictures[1:], duration=round(1000 / shot.frame_rate), loop=0,
        optimize=True,
    )  # fmt: skip


def words(name: str) -> tuple[str, str]:
    """Return the title of a page and its first sentence."""
    text = (GALLERY / name / "README.md").read_text(encoding="utf-8")
    title, rest = text.removeprefix("# ").split("\n", 1)
    sentence = re.match(r".*?\.(?=\s)", " ".join(rest.split()))
    if sentence is None:
        raise ValueError(f"{name}: the page has no first sentence")
    return title, re.sub(r"\[([^]]+)\]\([^)]+\)", r"\1", sentence[0])  # without links


def index() -> str:
    """Return the list of all mechanisms, docs/gallery/README.md."""
    count = sum(map(len, SHOTS.values()))
    out = [
        "# Gallery\n",
        f"{count} mechanisms, each with its scene, a film and a number from outside: a closed form, a",
        "published figure or an independent computation, with which a test compares it. `gelenk view SCENE`",
        "shows each of them in motion.\n",
    ]
    for group, shots in SHOTS.items():
        out.append(f"## {group}\n")
        cells = []
        for name in shots:
            title, sentence = words(name)
            picture = f'<img src="{name}/picture.png" width="260" alt="{title}">'
            cells.append(f"[{picture}]({name}/README.md)<br>**[{title}]({name}/README.md)**<br>{sentence}")
        cells += [""] * (-len(cells) % COLUMNS)
        rows = [cells[i : i + COLUMNS] for i in range(0, len(cells), COLUMNS)]
        out.append("| | | |\n|---|---|---|")
        out += [f"| {' | '.join(row)} |" for row in rows]
        out.append("")
    return "\n".join(out)


def main() -> None:
    """Draw all mechanisms, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="mechanisms; default: all")
    names = parser.parse_args().names
    for shots in SHOTS.values():
        for name, shot in shots.items():
            if not names or name in names:
                draw(name, shot)
                sizes = [(GALLERY / name / file).stat().st_size for file in ("picture.png", "moving.gif")]
                print(f"{name}: {sizes[0] / 1e3:.0f} + {sizes[1] / 1e3:.0f} kB")
    if not names or FIRST in names:
        shot = next(shots[FIRST] for shots in SHOTS.values() if FIRST in shots)
        draw_with_plot(FIRST, shot, ["tip.r[3]", "drive.tau"], ROOT / "docs" / "pictures" / f"{FIRST}.gif")
    (GALLERY / "README.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main()
