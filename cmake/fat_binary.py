# SPDX-License-Identifier: BSD-3-Clause
"""Combine libraries of macOS for several processors into one file, as Apple's `lipo -create` does."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

FAT_MAGIC = 0xCAFEBABE  # of the header, which is big-endian: magic number, number of parts
MACHO_64_MAGIC = 0xFEEDFACF
ALIGNMENT = 14  # log2; pages of ARM have 16 kB


def fat_binary(libraries: Sequence[Path]) -> bytes:
    """Return the universal ("fat") binary of Mach-O libraries. Raises ValueError if one is of another format.

    Each part is described by five big-endian words (`fat_arch` in <mach-o/fat.h>): processor, its variant,
    offset, size, alignment. The first two are copied from the library's own header, which is little-endian.
    """
    header = struct.pack(">II", FAT_MAGIC, len(libraries))
    content = bytearray(len(header) + 20 * len(libraries))
    for library in libraries:
        part = library.read_bytes()
        magic, processor, variant = struct.unpack_from("<III", part)
        if magic != MACHO_64_MAGIC:
            raise ValueError(
                f"{library}: found {magic:#x}, expected a 64-bit Mach-O file, {MACHO_64_MAGIC:#x}"
            )
        content.extend(bytes(-len(content) % (1 << ALIGNMENT)))
        header += struct.pack(">IIIII", processor, variant, len(content), len(part), ALIGNMENT)
        content.extend(part)
    content[: len(header)] = header
    return bytes(content)
