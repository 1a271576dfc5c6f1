"""The correction as a Functional Mock-up Unit: a zip that FMI 2.0 co-simulation runs, for MATLAB, Modelica tools, fmpy.

modelDescription.xml says which values there are; sources/ holds the C file and the functions of the interface around
it; binaries/<platform>/ the library built of them, where this machine has a C compiler.
Source: Functional Mock-up Interface for Model Exchange and Co-Simulation, version 2.0.4 (Modelica Association, 2022).
"""

from __future__ import annotations

import hashlib
import platform
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree as ET

from network.analysis.correction.correction import Correction
from network.analysis.correction.filter_model import FilterModel
from network.platform.quantities.units import unit
from network.report.files.c_compiler import compile_c
from network.report.files.correction_c import write_c

IDENTIFIER = "correction"
NOT_READ = -273.15
"""°C that stand for a sensor that is not read: XML and many importers know no NaN."""
LIBRARY = ("-shared", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-DFMI2_OVERRIDE_FUNCTION_PREFIX")
PLATFORMS = {("linux", "x86_64"): ("linux64", ".so"), ("darwin", "x86_64"): ("darwin64", ".dylib")}
"""Folder and ending of a library, as version 2.0 names them, by system and processor."""
WRITTEN = (1980, 1, 1, 0, 0, 0)
"""Time that files in the zip carry, so that the same correction makes the same bytes."""
BASES = {
    "degC": {"K": "1", "offset": "273.15"}, "um": {"m": "1", "factor": "1e-6"},
    "urad": {"rad": "1", "factor": "1e-6"},
}  # fmt: skip


@dataclass(frozen=True)
class Value:
    """A value of the unit: its name, its unit, what it is, whether it is an input, where it begins."""

    name: str
    unit: str
    meaning: str
    start: float | None


def write_fmu(correction: Correction, path: Path) -> str | None:
    """Writes the zip; the name of the platform that it holds a library for, None where it holds sources alone."""
    code = {f"{IDENTIFIER}.c": write_c(correction), "fmu.c": _write_interface(correction)}
    with TemporaryDirectory() as folder:
        for name, text in code.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        built = _build(Path(folder))
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as zipped:
            _put(zipped, "modelDescription.xml", _describe(correction))
            for name, text in code.items():
                _put(zipped, f"sources/{name}", text.encode())
            if built is not None:
                _put(zipped, f"binaries/{built[0]}/{IDENTIFIER}{built[1].suffix}", built[1].read_bytes())
    return built[0] if built else None


def _put(zipped: zipfile.ZipFile, name: str, content: bytes) -> None:
    zipped.writestr(zipfile.ZipInfo(name, WRITTEN), content, zipfile.ZIP_DEFLATED)


def _build(folder: Path) -> tuple[str, Path] | None:
    """Platform and library, where the standard has a name for this one and a compiler is there."""
    place = PLATFORMS.get((sys.platform, platform.machine()))
    if place is None:
        return None
    library = folder / f"{IDENTIFIER}{place[1]}"
    return (place[0], library) if compile_c(folder / "fmu.c", library, LIBRARY) else None


def list_values(f: FilterModel) -> list[Value]:
    """All values in the order of their references: inputs, sensors, movements, temperatures at the sensors."""
    return [*_list_inputs(f), *_list_outputs(f)]


def _list_inputs(f: FilterModel) -> Iterator[Value]:
    for name, text in f.inputs.items():
        yield Value(name, text, "drives the machine", f.reference if text == "degC" else 0.0)
    for name in f.sensors:
        yield Value(f"read.{name}", "degC", f"reading of {name}; {NOT_READ} or less is no reading", NOT_READ)


def _list_outputs(f: FilterModel) -> Iterator[Value]:
    for axis, text in zip(f.axes, f.axis_units, strict=True):
        yield Value(f"tcp.{axis}", text, "movement of the tool centre point, tool minus workpiece", None)
    for name in f.sensors:
        yield Value(name, "degC", f"temperature at {name} as the model has it", None)


def _write_interface(correction: Correction) -> str:
    from jinja2 import Environment, PackageLoader

    f = correction.filter
    rooms = Environment(loader=PackageLoader("network.report"), autoescape=False, keep_trailing_newline=True)
    starts = [repr(float(value.start)) for value in _list_inputs(f) if value.start is not None]
    return rooms.get_template("fmu.c.j2").render(
        identifier=IDENTIFIER, guid=identify(correction), step=repr(float(f.step)), initial=", ".join([*starts, "0.0"]),
        inputs=len(f.inputs), sensors=len(f.sensors), axes=len(f.axes),
        let_pass="    lptn_let_pass(driven, &model->data.machine);\n" if len(f.films) else "",
    )  # fmt: skip


def identify(correction: Correction) -> str:
    """Changes with any number of the C file."""
    return "{" + hashlib.sha256(write_c(correction).encode()).hexdigest()[:32] + "}"


def _describe(correction: Correction) -> bytes:
    """modelDescription.xml."""
    f, values = correction.filter, list_values(correction.filter)
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": f.machine, "guid": identify(correction),
        "description": f"Thermal correction: {f.own} of {correction.full} states, corrected by its sensors",
        "generationTool": "lptn", "variableNamingConvention": "flat", "numberOfEventIndicators": "0",
    })  # fmt: skip
    run = ET.SubElement(root, "CoSimulation", {
        "modelIdentifier": IDENTIFIER, "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
    })  # fmt: skip
    ET.SubElement(ET.SubElement(run, "SourceFiles"), "File", name="fmu.c")
    _describe_units(root, values)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(float(f.step)))
    variables = ET.SubElement(root, "ModelVariables")
    for reference, value in enumerate(values):
        _describe_value(variables, reference, value)
    _describe_outputs(root, [i for i, value in enumerate(values, 1) if value.start is None])
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="UTF-8", xml_declaration=True))


def _describe_units(root: ET.Element, values: list[Value]) -> None:
    """The units that occur; those whose dimension the standard cannot say by their name alone."""
    names = dict.fromkeys(value.unit for value in values if value.unit != "1")
    units = ET.SubElement(root, "UnitDefinitions") if names else root
    for name in names:
        element = ET.SubElement(units, "Unit", name=name)
        base = {"rad": "1", "s": "-1", "factor": repr(unit(name).scale)} if name == "rpm" else BASES.get(name)
        if base is not None:
            ET.SubElement(element, "BaseUnit", base)


def _describe_value(variables: ET.Element, reference: int, value: Value) -> None:
    of = {"name": value.name, "valueReference": str(reference), "description": value.meaning}
    kind = {"causality": "output"} if value.start is None else {"causality": "input"}
    variable = ET.SubElement(variables, "ScalarVariable", of | kind | {"variability": "continuous"})
    told = {} if value.unit == "1" else {"unit": value.unit}
    ET.SubElement(variable, "Real", told | ({} if value.start is None else {"start": repr(float(value.start))}))


def _describe_outputs(root: ET.Element, outputs: list[int]) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    for section in ("Outputs", "InitialUnknowns") if outputs else ():
        element = ET.SubElement(structure, section)
        for index in outputs:
            ET.SubElement(element, "Unknown", index=str(index))
