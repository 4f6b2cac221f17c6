# SPDX-License-Identifier: BSD-3-Clause
"""Hostile and malformed files of 14 kinds; as a program: what each of them causes.

python hostile_files.py KIND FOLDER
"""

from __future__ import annotations

import gzip
import io
import json
import os
import random
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gelenk

ROOT = Path(__file__).parent.parent
FOUR_BAR = ROOT / "scenes" / "four_bar.yaml"
MEGABYTE = 1_000_000

type Files = Iterator[tuple[str, Any]]
"""Names and contents: bytes, a size of zeros (int), or a function that makes the file."""


def pipe(path: Path) -> None:
    os.mkfifo(path)


def link(target: str) -> Callable[[Path], None]:
    return lambda path: path.symlink_to(target)


def anything(ending: str) -> Files:
    """What no reader expects, whatever it reads."""
    yield "empty", b""
    yield "zero", bytes(100)
    yield "noise", random.Random(1).randbytes(5000)
    yield "endless zeros", link("/dev/zero")
    yield "sparse", 3000 * MEGABYTE
    yield "folder", Path.mkdir
    yield "loop", link(f"loop{ending}")
    yield "nowhere", link("nowhere")
    yield "bom", b"\xef\xbb\xbf"
    yield "utf16", "gelenk: 1\nname: x\n".encode("utf-16")
    yield "not utf8", b"time,\xff\n1,2\n"
    yield "a zip", zipped({"a": b"b"})
    yield "gzip", gzip.compress(bytes(MEGABYTE))


def damaged(content: bytes) -> Files:
    """A valid file cut off, with bytes changed, and with something behind it."""
    chosen = random.Random(2)
    for k in range(4):
        yield f"cut {k}", content[: chosen.randrange(1, len(content))]
    for k in range(4):
        other = bytearray(content)
        for _ in range(1 + len(other) // 200):
            other[chosen.randrange(len(other))] = chosen.randrange(256)
        yield f"changed {k}", bytes(other)
    yield "doubled", content + content


def zipped(files: dict[str, bytes | int], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method, compresslevel=1) as archive:
        for name, content in files.items():
            with archive.open(name, "w", force_zip64=True) as file:
                for _ in range((content if isinstance(content, int) else 0) // MEGABYTE):
                    file.write(bytes(MEGABYTE))
                file.write(b"" if isinstance(content, int) else content)
    return out.getvalue()


def scenes(valid: bytes, wrap: Callable[[Any], bytes]) -> Files:
    yield from damaged(valid)
    scene = gelenk.load(FOUR_BAR).to_dict()
    yield "long name", wrap({**scene, "name": "x" * MEGABYTE})
    yield "list", wrap([scene])
    yield "numbers", wrap(dict.fromkeys(scene, 1e309))
    yield "infinite", wrap({**scene, "gravity": [0, 0, 1e400]})
    yield "many joints", wrap({**scene, "joints": {f"j{k}": scene["joints"]["A"] for k in range(500)}})
    for name in ("\0.stl", "/dev/zero", "../x.stl", "C:\\x.stl", "x" * 5000 + ".stl", "."):
        crank = {**scene["bodies"]["crank"], "shapes": {"s": {"mesh": name}}}
        yield f"mesh {name[:5]!r}", wrap({**scene, "bodies": {**scene["bodies"], "crank": crank}})


def yaml_scenes() -> Files:
    yield from scenes(FOUR_BAR.read_bytes(), lambda data: json.dumps(data).encode())
    yield "deep", b"[" * 100_000
    yield "deep blocks", b"- " * 100_000
    yield (
        "aliases",
        b"a: &a [x, x]\n"
        + b"".join(
            f"b{k}: &b{k} [{', '.join([f'*b{k - 1}' if k else '*a'] * 2)}]\n".encode() for k in range(100)
        ),
    )
    yield "itself", b"a: &a [*a]\n"
    yield "python", b"!!python/object/apply:os.system ['touch /tmp/was_run']\n"
    yield "anchors", b"".join(b"k%d: &a%d 1\n" % (k, k) for k in range(20_000))
    yield "one line", b"name: " + b"x" * (5 * MEGABYTE)


def json_scenes() -> Files:
    valid = json.dumps(gelenk.load(FOUR_BAR).to_dict()).encode()
    yield from scenes(valid, lambda data: json.dumps(data).encode())
    yield "deep", b"[" * 100_000
    yield "deep objects", b'{"a":' * 100_000
    yield "large number", b'{"gelenk": ' + b"1" * MEGABYTE + b"}"
    yield "surrogate", b'{"gelenk": 1, "name": "\\ud800"}'


CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
         (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip


def stl() -> Files:
    head, triangle = bytes(80), struct.pack("<12fH", *[0.0] * 12, 0)
    yield from damaged(head + struct.pack("<I", 12) + 12 * triangle)
    yield "count", head + struct.pack("<I", 2**32 - 1) + triangle
    yield "not finite", head + struct.pack("<I", 1) + struct.pack("<12fH", *[float("nan")] * 12, 0)
    yield "text", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 1 2\nendloop\nendfacet\nendsolid\n"
    yield "words", b"solid x\n" + b"vertex a b c\n" * 1000
    yield "many", head + struct.pack("<I", 250_000) + 250_000 * triangle


def obj() -> Files:
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE)
    faces = "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in FACES)
    yield from damaged((points + faces).encode())
    yield "indices", (points + "f 1 2 999999999\n").encode()
    yield "negative", (points + "f -1 -2 -99\n").encode()
    yield "material", b"mtllib /dev/zero\nusemtl x\n" + (points + faces).encode()
    yield "words", b"v a b c\nf x y z\n" * 100
    yield "polygon", (points + "f " + "1 2 3 " * 100_000 + "\n").encode()


def ply() -> Files:
    head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    face = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
    body = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE) + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    yield from damaged((head.format(8) + face.format(12) + body).encode())
    for count in ("4000000000", "-1", "x", "8e9", ""):
        yield f"count {count}", (head.format(count) + face.format(12) + body).encode()
        yield f"faces {count}", (head.format(8) + face.format(count) + body).encode()
    binary = head.replace("ascii", "binary_little_endian")
    yield "binary", (binary.format(10**12) + face.format(10**12)).encode() + bytes(100)
    yield "texture", (head.replace("\nel", "\ncomment TextureFile /dev/zero\nel").format(8) + body).encode()
    yield "no end", head.format(8).encode() + b"property float x\n" * 50_000


def off() -> Files:
    body = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE) + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    yield from damaged(f"OFF\n8 12 0\n{body}".encode())
    for counts in ("4000000000 12 0", "8 4000000000 0", "-8 12 0", "8", "x y z", ""):
        yield f"counts {counts}", f"OFF\n{counts}\n{body}".encode()
    yield "polygon", f"OFF\n8 1 0\n{body[:50]}99999999 1 2\n".encode()


def urdf() -> Files:
    link_text = '<link name="{}"><inertial><mass value="{}"/></inertial></link>'
    robot = f'<robot name="r">{link_text.format("a", 1)}{{}}</robot>'
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>{}</joint>'
    yield from damaged(robot.format(link_text.format("b", 1) + joint.format('<axis xyz="0 0 1"/>')).encode())
    yield "laughs", b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + b"".join(
        b'<!ENTITY %c "%s">' % (98 + k, b"&%c;" % (97 + k) * 10) for k in range(9)
    ) + b']><robot name="&j;"/>'  # fmt: skip
    yield "outside", b'<!DOCTYPE r [<!ENTITY a SYSTEM "/etc/passwd">]><robot name="r">&a;</robot>'
    yield "deep", b"<robot>" + b"<a>" * 100_000
    yield "encoding", b'<?xml version="1.0" encoding="utf-7"?><robot name="r"/>'
    yield "no encoding", b'<?xml version="1.0" encoding="x"?><robot name="r"/>'
    for value in ("nan", "inf", "-1", "1e999", "x", ""):
        yield f"mass {value}", robot.format(link_text.format("b", value) + joint.format("")).encode()
    for axis in ("0 0 0", "1", "nan 0 1", "a b c", "1 2 3 4", ""):
        text = joint.format(f'<axis xyz="{axis}"/><origin xyz="{axis}" rpy="{axis}"/>')
        yield f"axis {axis}", robot.format(link_text.format("b", 1) + text).encode()
    chain = "".join(link_text.format(f"l{k}", 1) for k in range(300))
    yield "cycle", robot.format(chain + joint.replace('"b"', '"a"').format("")).encode()
    yield (
        "limits",
        robot.format(
            link_text.format("b", 1) + joint.format('<limit lower="x" upper="nan" effort="" velocity=""/>')
        ).encode(),
    )


def fmus(folder: Path) -> Files:
    valid = gelenk.export_fmu(FOUR_BAR, folder / "valid.fmu", view=False).read_bytes()
    yield from damaged(valid)
    with zipfile.ZipFile(io.BytesIO(valid)) as archive:
        files: dict[str, bytes | int] = {name: archive.read(name) for name in archive.namelist()}
    (folder / "valid.fmu").unlink()
    text = files["modelDescription.xml"]
    assert isinstance(text, bytes)
    for name in ("/tmp/absolute", "../up", "a\\b", "C:/x", "a/../../b", "x" * 300, "resources", "a//b"):
        yield f"name {name[:10].replace('/', ' ')}", zipped({**files, name: b"x"})
    yield "bomb", zipped({**files, "resources/bomb": 800 * MEGABYTE})
    yield "large text", zipped({**files, "modelDescription.xml": 200 * MEGABYTE})
    yield "many", zipped({**files, **{f"resources/{k}": b"" for k in range(30_000)}}, zipfile.ZIP_STORED)
    yield "no description", zipped({name: c for name, c in files.items() if "Description" not in name})
    yield "no library", zipped({name: c for name, c in files.items() if "binaries" not in name})
    yield "no scene", zipped({name: c for name, c in files.items() if "scene" not in name})
    for name, scene in (("list", b"[1]"), ("empty", b""), ("deep", b"[" * 100_000), ("text", b'"a"')):
        yield f"scene {name}", zipped({**files, "resources/scene.json": scene})
    changes = (
        (b'fmiVersion="2.0"', b'fmiVersion="9"'), (b'stopTime="5"', b'stopTime="x"'),
        (b'valueReference="0"', b'valueReference="x"'), (b"<Real", b"<Unreal"), (b'guid="', b'guid="x'),
        (b"<CoSimulation", b"<ModelExchange"), (b"?>", b'?><!DOCTYPE r [<!ENTITY a "b">]>'),
        (b'stopTime="5"', b'stopTime="nan"'), (b'causality="output"', b'causality="x"'),
    )  # fmt: skip
    for k, (old, new) in enumerate(changes):
        content = text.replace(old, new)
        yield f"description {k}", zipped({**files, "modelDescription.xml": content})
    lzma = zipped({"modelDescription.xml": text}, zipfile.ZIP_LZMA)
    yield "lzma", lzma
    secret = bytearray(zipped({"modelDescription.xml": text}))
    secret[6] |= 1
    secret[secret.rindex(b"PK\1\2") + 8] |= 1
    yield "encrypted", bytes(secret)


def csv_tables(*, header: str) -> Files:
    lines = "".join(f"{0.1 * k!r},{k}\n" for k in range(50))
    yield from damaged(f"{header}\n{lines}".encode())
    yield "field", f"{header}\n0,{'1' * 200_000}\n".encode()
    yield "quote", f'{header}\n0,"{"1" * 500_000}'.encode()
    yield "long line", b"time," + b"x" * (30 * MEGABYTE)
    yield "columns", b"time" + b",x" * 500_000
    yield "names", b"time" + b"".join(b",x%d" % k for k in range(60_000)) + b"\n1,2\n"
    yield "zero byte", f"{header}\n0,1\0\n".encode()
    yield "words", (f"{header}\n" + "a,b\n" * 50_000).encode()
    yield "ragged", (f"{header}\n" + "1\n1,2,3\n" * 50_000).encode()
    yield "infinite", f"{header}\n0,1e999x\n".encode()


def tables(folder: Path, ending: str) -> Iterator[bytes]:
    import numpy as np

    result = gelenk.Result(["A", "B"], np.arange(30.0).reshape(10, 3), {"A": "m", "B": "m"})
    result.scene = gelenk.load(FOUR_BAR).to_dict()
    result.save(folder / f"valid{ending}")
    yield (folder / f"valid{ending}").read_bytes()
    (folder / f"valid{ending}").unlink()


def written(function: Callable[[Path], object]) -> Callable[[Path], None]:
    return lambda path: (function(path), None)[1]


def parquet_tables(folder: Path) -> Files:
    import pandas as pd
    import pyarrow as pa
    from pyarrow import parquet

    yield from damaged(*tables(folder, ".parquet"))

    def frame(data: dict[str, Any], index: str | None = "time", **attrs: Any) -> Callable[[Path], None]:
        table = pd.DataFrame(data)
        table = table if index is None else table.rename_axis(index)
        table.attrs |= attrs
        return written(table.to_parquet)

    yield "no time", frame({"A": [1.0]}, None)
    yield "texts", frame({"A": ["x"]})
    yield "no numbers", frame({"A": [[1.0], [2.0]]})
    yield "scene", frame({"A": [1.0]}, gelenk_scene="[1]")
    yield "scene text", frame({"A": [1.0]}, gelenk_scene="{")
    yield "units", frame({"A": [1.0]}, units=[1])
    # Equal numbers take no space.
    rows = pa.table({"time": pa.chunked_array([pa.array([0.0] * MEGABYTE)] * 100)})
    yield "bomb", written(lambda path: parquet.write_table(rows, path, compression="zstd"))


def netcdf_tables(folder: Path) -> Files:
    import h5py

    yield from damaged(*tables(folder, ".nc"))

    def made(fill: Callable[[Any], object]) -> Callable[[Path], None]:
        def write(path: Path) -> None:
            with h5py.File(path, "w") as file:
                fill(file)

        return write

    yield "no time", made(lambda file: file.create_dataset("A", data=[1.0]))
    yield "texts", made(lambda file: file.create_dataset("time", data=[b"x"]))
    yield (
        "huge",
        made(lambda file: [file.create_dataset(n, (10**11,), "f8", chunks=(1000,)) for n in ("time", "A")]),
    )
    yield "group", made(lambda file: file.create_group("time"))
    yield "outside", made(lambda file: file.__setitem__("time", h5py.ExternalLink("/dev/zero", "/x")))
    yield "itself", made(lambda file: file.__setitem__("time", h5py.SoftLink("/time")))


def mat_tables(folder: Path) -> Files:
    import numpy as np
    from scipy.io import savemat

    yield from damaged(*tables(folder, ".mat"))

    def made(**content: Any) -> Callable[[Path], None]:
        return written(lambda path: savemat(path, content, do_compression=True))

    x = np.zeros((3, 1))
    yield "empty names", made(time=x, values=x, names=np.array([], object), units=np.array([], object))
    yield "nothing", made()
    yield "only time", made(time=x)
    yield "names", made(time=x, values=x, names=1.0, units=2.0)
    yield "shapes", made(time=x, values=np.zeros((4, 2)), names="A", units="m")
    yield "texts", made(time="x", values="y", names="A", units="m")
    yield "bomb", made(time=np.zeros((30 * MEGABYTE, 1)), values=x, names="A", units="m")
    yield "version 4", struct.pack("<5i", 0, 10**6, 10**6, 0, 5) + b"time\0" + bytes(100)
    head = b"MATLAB 5.0".ljust(124) + struct.pack("<2H", 0x0100, 0x4D49)
    yield "size", head + struct.pack("<2I", 14, 2**31 - 1) + bytes(100)
    yield "zlib", head + struct.pack("<2I", 15, 300) + zlib.compress(bytes(100 * MEGABYTE))[:300]


def stores(folder: Path) -> Files:
    """Folders of sweeps: of each file what is in the place of the one that was written."""
    del folder
    yield "list", {"sweep.json": b"[1]"}
    yield "text", {"sweep.json": b'"a"'}
    yield "empty", {"sweep.json": b""}
    yield "deep", {"sweep.json": b"[" * 100_000}
    yield "pipe", {"sweep.json": pipe}
    yield "folder", {"sweep.json": Path.mkdir}
    yield "zeros", {"sweep.json": link("/dev/zero")}
    yield "parts are pipes", {"runs": pipe}
    yield "parts are endless", {"runs": link("/dev/zero")}
    yield "parts are noise", {"runs": random.Random(3).randbytes(1000)}
    for name in ("rows", "columns", "types", "lists", "texts", "nothing"):
        yield name, {"runs": name}


def crafted_part(part: Path, how: str) -> bytes:
    """A part with another content."""
    import pyarrow as pa
    from pyarrow import parquet

    table = parquet.read_table(part)
    changed = {
        "rows": lambda: table.slice(0, 1),
        "columns": lambda: table.select(["run", "error", "warning"]),
        "types": lambda: table.set_column(1, table.column_names[1], pa.array(["x"] * len(table))),
        "lists": lambda: table.set_column(1, table.column_names[1], pa.array([[1.0, 2.0]] * len(table))),
        "texts": lambda: table.set_column(
            table.column_names.index("error"), "error", pa.array([1.0] * len(table))
        ),
        "nothing": lambda: pa.table({}),
    }[how]()
    out = io.BytesIO()
    parquet.write_table(changed, out)
    return out.getvalue()
