# SPDX-License-Identifier: BSD-3-Clause
"""The compiled modules of the wheels for macOS, which cannot be run here: what they export and need."""

from __future__ import annotations

import gzip
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

lief = pytest.importorskip("lief", reason="lief is not installed: pip install --group runtimes")
pytestmark = pytest.mark.platforms
FLAT_LOOKUP = -2  # BIND_SPECIAL_DYLIB_FLAT_LOOKUP in <mach-o/loader.h>
BUILT = Path(__file__).resolve().parents[2] / "build" / "wheels"


@pytest.fixture(scope="module", params=["x86_64", "arm64"])
def wheel(request: pytest.FixtureRequest) -> Path:
    found = sorted(BUILT.glob(f"gelenk-*macosx_11_0_{request.param}.whl"))
    if not found:
        pytest.skip("build/wheels has no wheel for macOS: `make wheels` builds it after `make runtimes`")
    return found[-1]


@pytest.fixture(scope="module")
def module(wheel: Path) -> Iterator[Any]:
    with zipfile.ZipFile(wheel) as archive:
        whole = lief.MachO.parse(list(archive.read("gelenk/_core.abi3.so")))
    (part,) = whole
    yield part  # noqa: PT022  lief releases it with the whole


def test_the_module_is_for_the_processor_and_system_of_the_file_name(wheel: Path, module: Any) -> None:
    """64-bit ARM loads no module without at least an ad hoc signature."""
    processors = {"x86_64": lief.MachO.Header.CPU_TYPE.X86_64, "arm64": lief.MachO.Header.CPU_TYPE.ARM64}
    (processor,) = (name for name in processors if wheel.stem.endswith(name))
    assert module.header.cpu_type == processors[processor]
    assert module.build_version.minos == [11, 0, 0]
    assert module.has_code_signature or processor != "arm64"


def test_the_module_is_found_by_python_and_needs_only_python_and_the_system(module: Any) -> None:
    exported = {symbol.name for symbol in module.exported_symbols}
    assert "_PyInit__core" in exported
    needed = [library.name for library in module.libraries if "_core" not in library.name]
    assert needed == ["/usr/lib/libSystem.B.dylib"]
    # Python's are looked up in the whole process; its stable ABI has no other beginnings.
    from_process = {
        binding.symbol.name
        for binding in module.bindings
        if binding.has_symbol and binding.library_ordinal == FLAT_LOOKUP
    }
    assert from_process
    assert {name for name in from_process if not name.startswith(("_Py", "__Py"))} == set()


def test_the_wheel_has_the_runtime_for_both_processors(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        library = gzip.decompress(archive.read("gelenk/runtime/darwin64/gelenk_fmu.dylib.gz"))
        tags = archive.read(next(name for name in names if name.endswith("dist-info/WHEEL"))).decode()
    assert lief.MachO.parse(list(library)).size == 2
    assert [name for name in names if name.startswith("gelenk/runtime/") and name.endswith(".gz")] == [
        "gelenk/runtime/darwin64/gelenk_fmu.dylib.gz"
    ]
    assert f"Tag: cp312-abi3-{wheel.stem.split('-')[-1]}\n" in tags
