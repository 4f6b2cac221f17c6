# SPDX-License-Identifier: BSD-3-Clause
"""What FMUs of FMI 2.0 and 3.0 say about themselves, as fmpy reads it."""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any

import fmpy

from gelenk.errors import UsageError
from gelenk.simulation.fmu_file import DESCRIPTION, text_in

_KINDS = {"coSimulation": "co-simulation", "modelExchange": "model exchange"}


# Types of FMI 2.0 by those of FMI 3.0.
_TYPES = {"Float64": "Real"} | dict.fromkeys(
    ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"), "Integer"
)


def description_of(path: Path, part: str) -> Any:
    """Return what fmpy reads of an FMU of FMI 2.0 or 3.0.

    Args:
        path: the FMU.
        part: "coSimulation" or "modelExchange".

    Raises:
        UsageError: it cannot be read, is for something else, or has variables that are arrays.
        OSError: it cannot be opened.
    """
    text = text_in(path, DESCRIPTION)
    if b"<!ENTITY" in text or b"\0" in text:
        raise UsageError(f"{path}: its modelDescription.xml is not plain UTF-8 text without entities")
    # As the only file of an archive: fmpy reads FMUs.
    only = io.BytesIO()
    with zipfile.ZipFile(only, "w") as archive:
        archive.writestr(DESCRIPTION, text)
    try:
        found = fmpy.read_model_description(only, validate=False)
    except Exception as e:  # exceptions of the XML parser and of fmpy
        raise UsageError(
            f"{path}: its modelDescription.xml cannot be read: {' '.join(str(e).split())}"
        ) from None
    kinds = [name for key, name in _KINDS.items() if getattr(found, key) is not None]
    if found.fmiVersion[:2] not in ("2.", "3.") or getattr(found, part) is None:
        raise UsageError(
            f"{path}: found an FMU of FMI {found.fmiVersion} for {' and '.join(kinds)}, expected FMI 2.0 or "
            f"3.0 {_KINDS[part]}"
        )
    if is_fmi3(found):
        _refuse_arrays(path, found)
    return found


def type_of(variable: Any) -> str:
    """Return the type of a variable in the words of FMI 2.0: "Real", "Integer", ..."""
    return _TYPES.get(variable.type, str(variable.type))


def is_fmi3(description: Any) -> bool:
    """Return whether an FMU is of FMI 3."""
    return str(description.fmiVersion).startswith("3.")


def integer_types(description: Any) -> dict[int, str]:
    """Return the types of whole numbers and choices of FMI 3.0, by value reference."""
    return {
        v.valueReference: "Int64" if v.type == "Enumeration" else v.type
        for v in description.modelVariables
        if v.type == "Enumeration" or _TYPES.get(v.type) == "Integer"
    }


def _refuse_arrays(path: Path, description: Any) -> None:
    arrays = [v.name for v in description.modelVariables if v.dimensions]
    if arrays:
        raise UsageError(
            f"{path}: found the array {arrays[0]}, expected scalar variables; fmpy.simulate_fmu runs it"
        )


def experiment_of(path: Path, experiment: Any) -> tuple[float, float]:
    """Return the stop time and the step size of an FMU [s]."""
    given = [getattr(experiment, name, None) for name in ("stopTime", "stepSize")]
    try:
        stop, step = (float(value or default) for value, default in zip(given, (1.0, 1e-3), strict=True))
    except ValueError:
        stop = step = math.nan
    if not (math.isfinite(stop) and math.isfinite(step) and step > 0):
        raise UsageError(
            f"{path}: found the stop time {given[0]} and the step size {given[1]}, expected numbers"
        )
    return stop, step


def annotations_of(path: Path, folder: str) -> ET.Element | None:
    """Return Gelenk's vendor annotations in modelDescription.xml, which fmpy does not read."""
    root = _parsed(path, folder)
    of_fmi2 = root.find("VendorAnnotations/Tool[@name='Gelenk']")
    return of_fmi2 if of_fmi2 is not None else root.find("Annotations/Annotation[@type='Gelenk']")


def provides_derivatives(path: Path, folder: str, part: str) -> bool:
    """Return whether an FMU that is unpacked into a folder provides directional derivatives."""
    kind = _parsed(path, folder).find(part[0].upper() + part[1:])
    names = "providesDirectionalDerivative", "providesDirectionalDerivatives"  # FMI 2.0, FMI 3.0
    return kind is not None and any(kind.get(name) in ("true", "1") for name in names)


def _parsed(path: Path, folder: str) -> ET.ElementTree[ET.Element]:
    try:
        return ET.parse(Path(folder, DESCRIPTION))
    except (ET.ParseError, ValueError, LookupError) as e:
        raise UsageError(f"{path}: its modelDescription.xml cannot be read: {e}") from None


def unit_of(variable: Any) -> str:
    """Return the unit of a variable; "1" if it has none."""
    declared = getattr(variable.declaredType, "unit", None)
    return str(variable.unit or declared or "1")
