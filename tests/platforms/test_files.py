# SPDX-License-Identifier: BSD-3-Clause
"""The libraries for other machines as files: what they export, what they need, how they are protected."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import pytest

from gelenk.io import export

from .machines import NO_RUNTIMES

lief = pytest.importorskip("lief", reason="lief is not installed: pip install --group runtimes")
pytestmark = pytest.mark.platforms
HEADERS = Path(fmpy.__file__).parent / "c-code"
FUNCTIONS = {
    name
    for version in (2, 3)
    for name in re.findall(
        rf"^\s*FMI{version}_Export fmi{version}\w+\s+(fmi{version}\w+);",
        (HEADERS / f"fmi{version}Functions.h").read_text(),
        re.MULTILINE,
    )
}
LINKERS = {"_mh_dylib_header", "__dso_handle"}  # the place of the library itself


def content(platform: str) -> list[int]:
    if export.missing_platforms(platform):
        pytest.skip(f"{platform}: {NO_RUNTIMES}")
    return list(gzip.decompress(export.runtime_library(platform).read_bytes()))


def library(platform: str) -> Any:
    return lief.parse(content(platform))


@pytest.fixture(scope="module", params=["x86-64", "ARM"])
def mac(request: pytest.FixtureRequest) -> Iterator[Any]:
    """The part of the library for macOS for each processor; lief releases it with the whole."""
    both = lief.MachO.parse(content("darwin64"))
    assert both.size == 2
    wanted = {"x86-64": lief.MachO.Header.CPU_TYPE.X86_64, "ARM": lief.MachO.Header.CPU_TYPE.ARM64}
    (found,) = (part for part in both if part.header.cpu_type == wanted[request.param])
    yield found  # noqa: PT022


def test_macos_sees_only_the_functions_of_fmi_and_gives_only_its_system_library(mac: Any) -> None:
    exported = {symbol.name.removeprefix("_") for symbol in mac.exported_symbols}
    assert exported - LINKERS == FUNCTIONS
    needed = [library.name for library in mac.libraries]
    assert [name for name in needed if not name.endswith("gelenk_fmu.dylib")] == [
        "/usr/lib/libSystem.B.dylib"
    ]
    assert mac.header.file_type == lief.MachO.Header.FILE_TYPE.DYLIB


def test_macos_11_suffices_and_arm_finds_a_signature(mac: Any) -> None:
    """64-bit ARM loads no library without at least an ad hoc signature."""
    assert mac.build_version.minos == [11, 0, 0]
    if mac.header.cpu_type == lief.MachO.Header.CPU_TYPE.ARM64:
        assert mac.has_code_signature


def test_windows_sees_only_the_functions_of_fmi_and_gives_only_its_own() -> None:
    """The C library of Windows 10 (api-ms-win-crt-*) and the kernel."""
    dll = library("win64")
    assert {entry.name for entry in dll.get_export().entries} == FUNCTIONS
    needed = {part.name.lower() for part in dll.imports}
    assert all(
        re.fullmatch(r"kernel32\.dll|ntdll\.dll|api-ms-win-crt-\w+-l1-1-0\.dll", name) for name in needed
    ), needed


def test_windows_places_the_library_at_random_and_runs_no_data() -> None:
    dll = library("win64")
    kinds = lief.PE.OptionalHeader.DLL_CHARACTERISTICS
    flags = set(dll.optional_header.dll_characteristics_lists)
    assert {kinds.DYNAMIC_BASE, kinds.HIGH_ENTROPY_VA, kinds.NX_COMPAT} <= flags
    assert dll.has_relocations  # without them, it would stay where it is
    written_and_run = lief.PE.Section.CHARACTERISTICS.MEM_WRITE, lief.PE.Section.CHARACTERISTICS.MEM_EXECUTE
    for section in dll.sections:
        assert not all(section.has_characteristic(kind) for kind in written_and_run), section.name


def test_arm_needs_only_the_c_library_of_2012() -> None:
    so = library("aarch64-linux")
    assert {symbol.name for symbol in so.exported_symbols} == FUNCTIONS
    assert so.header.machine_type == lief.ELF.ARCH.AARCH64
    assert set(so.libraries) <= {
        "libc.so.6",
        "libm.so.6",
        "libpthread.so.0",
        "libdl.so.2",
        "ld-linux-aarch64.so.1",
    }
    versions = [
        tuple(int(n) for n in version.name.removeprefix("GLIBC_").split("."))
        for needed in so.symbols_version_requirement
        for version in needed.get_auxiliary_symbols()
    ]
    assert versions
    assert max(versions) == (2, 17)  # the first for this processor


def test_arm_has_read_only_addresses_and_runs_no_data() -> None:
    so = library("aarch64-linux")
    kinds = {segment.type: segment for segment in so.segments}
    assert lief.ELF.Segment.TYPE.GNU_RELRO in kinds
    assert not int(kinds[lief.ELF.Segment.TYPE.GNU_STACK].flags) & int(lief.ELF.Segment.FLAGS.X)
    assert so[lief.ELF.DynamicEntry.TAG.FLAGS].has(lief.ELF.DynamicEntryFlags.FLAG.BIND_NOW)


# First instructions of functions that may be called indirectly: bti c, or paciasp, which signs the return
# address, too.
LANDING_PADS = {bytes.fromhex("5f2403d5"), bytes.fromhex("3f2303d5")}


def test_arm_signs_return_addresses_and_has_landing_pads() -> None:
    so = library("aarch64-linux")
    starts = {s.name: bytes(so.get_content_from_virtual_address(s.value, 4)) for s in so.exported_symbols}
    assert {name for name, first in starts.items() if first not in LANDING_PADS} == set()
    text = bytes(so.get_section(".text").content)
    assert text.count(bytes.fromhex("3f2303d5")) > 1000  # most functions call others


def test_macos_runs_no_data(mac: Any) -> None:
    """No segment may be written and run; 64-bit programs have no executable stack there."""
    for segment in mac.segments:
        assert segment.init_protection & 6 != 6, segment.name  # VM_PROT_WRITE 2, VM_PROT_EXECUTE 4


def test_an_fmu_for_all_machines_is_small(tmp_path: Path, four_bar: Any) -> None:
    import gelenk

    if export.missing_platforms("all"):
        pytest.skip(NO_RUNTIMES)
    fmu = gelenk.export_fmu(four_bar, tmp_path / "x.fmu", "all")
    assert fmu.stat().st_size < 12e6
