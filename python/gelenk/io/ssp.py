# SPDX-License-Identifier: BSD-3-Clause
"""Export of scenes as SSP archives: the FMU of the mechanism, its parameters, and the place of a controller.

System Structure and Parameterization 1.0 (https://ssp-standard.org): a zip archive of FMUs, of the
connections between them (`SystemStructure.ssd`) and of sets of parameters (`.ssv`).
"""

from __future__ import annotations

import logging
import tempfile
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from xml.etree import ElementTree as ET

from gelenk.errors import ExportError
from gelenk.file_writing import replacing
from gelenk.io.export import export_fmu
from gelenk.model.scene import Source, load
from gelenk.simulation.fmu_file import DESCRIPTION, text_in

log = logging.getLogger(__name__)

VERSION = "1.0"
SSD, SSC, SSV = (
    f"http://ssp-standard.org/SSP1/{name}"
    for name in ("SystemStructureDescription", "SystemStructureCommon", "SystemStructureParameterValues")
)
# Elements of the system, and files of the archive: with names that need no encoding in a URI.
PLANT, CONTROLLER = "plant", "controller"
FMU, PARAMETERS = f"resources/{PLANT}.fmu", f"resources/{PLANT}.ssv"
# Of the drawing: width of elements and of the gaps between them, distance of connectors.
WIDTH, PITCH = 60, 4
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)  # of zip archives; equal scenes give equal files


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU, with the texts of its description."""

    name: str
    causality: str
    type: str  # Real, Integer, Boolean or String
    unit: str | None
    start: str | None
    description: str


# From an element to another, of their connectors with the name of a variable; None: the system itself.
Connection = tuple[str | None, Variable, str | None]


def export_ssp(
    scene: Source,
    out: str | PathLike[str],
    platforms: str | Sequence[str] | None = None,
    outputs: Iterable[str] | None = None,
    *,
    view: bool = True,
) -> Path:
    """Write an SSP archive (version 1.0) with the FMU of a scene; no incomplete file remains after an error.

    `SystemStructure.ssd` is a system with the element `plant`, an FMU of FMI 2.0 for co-simulation, whose
    inputs and outputs are those of the system; its parameters are in a file of their own. If the scene has
    inputs, `Controlled.ssd` is a variant in which both are connected to the element `controller`: an empty
    system, to be replaced by a controller with the same connectors.

    Args:
        scene: anything `gelenk.load` accepts.
        out: the .ssp file; an existing file is replaced.
        platforms: platforms of the FMU, as in `gelenk.export_fmu`.
        outputs: names and patterns of the requested outputs; by default the scene's own.
        view: whether the documentation of the FMU shows the mechanism in three dimensions.

    Returns:
        Path: the file written.

    Raises:
        SceneError: the scene is invalid.
        UsageError: an output is unknown.
        AssemblyError: the loops cannot be closed with the start values.
        ExportError: the file cannot be written, or a platform is unknown or missing.
        OSError: the scene cannot be read.

    >>> gelenk.export_ssp(four_bar, "FourBar.ssp").name
    'FourBar.ssp'
    """
    target = Path(out)
    if target.suffix.lower() != ".ssp":
        raise ExportError(f"{target}: found the ending {target.suffix or 'none'}, expected .ssp")
    loaded = load(scene)
    with tempfile.TemporaryDirectory(prefix="gelenk-") as folder:
        fmu = export_fmu(loaded, Path(folder) / f"{PLANT}.fmu", platforms, outputs, view=view)
        described = ET.fromstring(text_in(fmu, DESCRIPTION))
        contents = {"SystemStructure.ssd": _text(system_structure(loaded.name, described))}
        if described.find("ModelVariables/ScalarVariable[@causality='input']") is not None:
            contents["Controlled.ssd"] = _text(system_structure(loaded.name, described, controller=True))
        contents |= {PARAMETERS: _text(parameter_values(described)), FMU: fmu.read_bytes()}
    try:
        with replacing(target) as draft, zipfile.ZipFile(draft, "w") as archive:
            for name, content in contents.items():
                packed = zipfile.ZIP_STORED if name == FMU else zipfile.ZIP_DEFLATED  # an FMU is compressed
                archive.writestr(zipfile.ZipInfo(name, _FIRST_DAY), content, packed)
    except OSError as e:
        raise ExportError(f"{target}: the archive could not be written: {e.strerror}") from None
    log.info("%s: %.2f MB", target, target.stat().st_size / 1e6)
    return target


def system_structure(name: str, described: ET.Element, controller: bool = False) -> ET.Element:
    """Return the root of a .ssd file: the plant, connected to the outside or to the place of a controller.

    Args:
        name: name of the scene.
        described: root of the FMU's modelDescription.xml.
        controller: whether the inputs are written by a controller, which is an empty system with the right
            connectors. Otherwise they are inputs of the whole system.
    """
    known = variables(described)
    inputs = [v for v in known if v.causality == "input"]
    outputs = [v for v in known if v.causality == "output"]
    height = PITCH * max(len(inputs), len(outputs), 1)

    root = _root(SSD, "SystemStructureDescription", name, described)
    system = _sub(root, "System", name=name)
    if not controller:
        _add_connectors(system, inputs, outputs)
    elements = _sub(system, "Elements")
    if controller:
        empty = _sub(elements, "System", name=CONTROLLER, description="empty: to be replaced by a controller")
        _add_connectors(empty, outputs, inputs, (WIDTH, height))
    plant = _sub(elements, "Component", name=PLANT, source=FMU, implementation="CoSimulation")
    _add_connectors(plant, inputs, outputs, (3 * WIDTH if controller else WIDTH, height))
    _sub(_sub(plant, "ParameterBindings"), "ParameterBinding", source=PARAMETERS)
    # With a controller, both ends are elements: many importers know no others.
    outside = CONTROLLER if controller else None
    connections: list[Connection] = [(outside, v, PLANT) for v in inputs]
    connections += [(PLANT, v, outside) for v in outputs]
    _add_connections(system, connections)
    width = WIDTH * (5 if controller else 3)
    _sub(system, "SystemGeometry", x1="0", y1="0", x2=str(width), y2=str(height + 2 * PITCH))
    _add_units(root, described, {v.unit for v in inputs + outputs})
    experiment = described.find("DefaultExperiment")
    if experiment is not None:
        times = {
            key: value for key in ("startTime", "stopTime") if (value := experiment.get(key)) is not None
        }
        _sub(root, "DefaultExperiment", **times)
    return root


def parameter_values(described: ET.Element) -> ET.Element:
    """Return the root of the .ssv file: all parameters with the values and units of the FMU.

    Args:
        described: root of the FMU's modelDescription.xml.
    """
    root = _root(SSV, "ParameterSet", PLANT, described)
    to = _sub(root, "Parameters")
    parameters = [v for v in variables(described) if v.causality == "parameter" and v.start is not None]
    for v in parameters:
        parameter = _sub(to, "Parameter", name=v.name, description=v.description)
        _sub(parameter, v.type, value=v.start or "", **({"unit": v.unit} if v.unit else {}))
    _add_units(root, described, {v.unit for v in parameters})
    return root


def variables(described: ET.Element) -> list[Variable]:
    """Return the variables of an FMU of FMI 2.0, from the root of its modelDescription.xml."""
    found = []
    for element in described.iterfind("ModelVariables/ScalarVariable"):
        kind = element[0]
        found.append(
            Variable(
                element.get("name", ""),
                element.get("causality", "local"),
                kind.tag,
                kind.get("unit"),
                kind.get("start"),
                element.get("description", ""),
            )
        )
    return found


def _root(space: str, tag: str, name: str, described: ET.Element) -> ET.Element:
    tool = described.get("generationTool", "Gelenk")
    return ET.Element(f"{{{space}}}{tag}", version=VERSION, name=name, generationTool=tool)


def _sub(parent: ET.Element, tag: str, space: str | None = None, **attributes: str) -> ET.Element:
    """Append a new element, by default of the same namespace as its parent."""
    return ET.SubElement(parent, f"{{{space or parent.tag[1:].partition('}')[0]}}}{tag}", attributes)


def _add_connectors(
    to: ET.Element,
    inputs: list[Variable],
    outputs: list[Variable],
    drawn: tuple[int, int] | None = None,
) -> None:
    """Append connectors, inputs on the left; drawn: left end and height of the element's box."""
    group = _sub(to, "Connectors")
    for kind, x, ports in (("input", "0", inputs), ("output", "1", outputs)):
        for k, v in enumerate(ports):
            connector = _sub(group, "Connector", name=v.name, kind=kind, description=v.description)
            _sub(connector, v.type, SSC, **({"unit": v.unit} if v.unit else {}))
            _sub(connector, "ConnectorGeometry", x=x, y=f"{(k + 0.5) / len(ports):.6g}")
    if len(group) == 0:
        to.remove(group)
    if drawn:
        left, height = drawn
        _sub(to, "ElementGeometry", x1=str(left), y1=str(PITCH), x2=str(left + WIDTH), y2=str(PITCH + height))


def _add_connections(to: ET.Element, connections: list[Connection]) -> None:
    """Append connections of connectors with the name of a variable."""
    if not connections:
        return
    group = _sub(to, "Connections")
    for start, v, end in connections:
        connection = _sub(group, "Connection", startConnector=v.name, endConnector=v.name)
        for key, element in (("startElement", start), ("endElement", end)):
            if element is not None:
                connection.set(key, element)


def _add_units(root: ET.Element, described: ET.Element, used: set[str | None]) -> None:
    """Append the units that are used, defined by those of SI as in the FMU."""
    units = [u for u in described.iterfind("UnitDefinitions/Unit") if u.get("name") in used]
    if not units:
        return
    group = _sub(root, "Units")
    for unit in units:
        base = unit.find("BaseUnit")
        to = _sub(group, "Unit", SSC, name=unit.get("name", ""))
        _sub(to, "BaseUnit", **(base.attrib if base is not None else {}))


def _text(root: ET.Element) -> bytes:
    """Return the XML text of an element, with the prefixes of the standard."""
    for prefix, space in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV)):
        ET.register_namespace(prefix, space)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"
