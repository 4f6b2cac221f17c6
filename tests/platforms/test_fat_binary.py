# SPDX-License-Identifier: BSD-3-Clause
"""Libraries of macOS for two processors in one file, as another reader of the format sees it."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

lief = pytest.importorskip("lief", reason="lief is not installed: pip install --group runtimes")
pytestmark = [
    pytest.mark.platforms,
    pytest.mark.skipif(
        importlib.util.find_spec("ziglang") is None,
        reason="ziglang is not installed: pip install --group runtimes",
    ),
]


@pytest.fixture
def fat_binary(root: Path, monkeypatch: pytest.MonkeyPatch) -> object:
    monkeypatch.syspath_prepend(root / "cmake")
    from fat_binary import fat_binary

    return fat_binary


def test_both_parts_are_found_unchanged_at_pages_of_their_own(fat_binary: object, tmp_path: Path) -> None:
    assert callable(fat_binary)
    (tmp_path / "a.c").write_text("int answer(void) { return 42; }\n")
    parts = []
    for processor in ("x86_64", "aarch64"):
        parts.append(tmp_path / f"{processor}.dylib")
        subprocess.run(
            [sys.executable, "-m", "ziglang", "cc", "-target", f"{processor}-macos.11.0", "-shared",
             str(tmp_path / "a.c"), "-o", str(parts[-1])], check=True,
        )  # fmt: skip
    content = fat_binary(parts)
    both = lief.MachO.parse(list(content))
    kinds = lief.MachO.Header.CPU_TYPE
    assert [part.header.cpu_type for part in both] == [kinds.X86_64, kinds.ARM64]
    for part, file in zip(both, parts, strict=True):
        assert part.fat_offset % 2**14 == 0
        assert content[part.fat_offset :].startswith(file.read_bytes())
        assert "_answer" in {symbol.name for symbol in part.exported_symbols}


def test_what_is_not_of_macos_is_refused(fat_binary: object, tmp_path: Path) -> None:
    assert callable(fat_binary)
    file = tmp_path / "x.so"
    file.write_bytes(b"\x7fELF" + bytes(60))
    with pytest.raises(
        ValueError, match=r"x\.so: found 0x464c457f, expected a 64-bit Mach-O file, 0xfeedfacf"
    ):
        fat_binary([file])
