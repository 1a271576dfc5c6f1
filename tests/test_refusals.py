"""Bad machine files: what the user reads, word for word, with the line it happened in."""

from __future__ import annotations

import random
import time
import tracemalloc
from itertools import pairwise
from pathlib import Path

import pytest

from network.catalogue.declaration.discovery import kinds
from network.machine.machine import Machine
from network.platform.refusal import Refused, likely
from network.recordings.recording import Recording

CASES = Path(__file__).parents[2] / "shared" / "cases"

BENCH = """\
machine: test bench
reference: 20 degC
materials:
  iron: {density: 7200 kg/m^3, specific_heat: 500 J/(kg K), conductivity: 48 W/(m K), expansion: 1.1e-5 1/K}
nodes:
  shaft: {heat_capacity: 10 kJ/K, rotates: true}
  housing: {material: iron, length: 500 mm, area: 200 cm^2, lumps: 2}
  ambient: {temperature: ambient}
links:
  bearing: {kind: conduction, between: [shaft, housing@0.1..0.3], conductance: 20 W/K ± 30 %}
  skin: {kind: convection, between: [housing, ambient], conductance: 5 W/K}
sources:
  friction: {kind: bearing_friction, into: {shaft: 0.5, housing@0.1..0.3: 0.5}, torque: 500 N mm}
tcp:
  z:
    growth: {kind: stretching, of: housing, direction: 1}
sensors:
  T_housing: {measures: housing@0.5, noise: 0.05 K}
  dz: {measures: tcp.z, noise: 0.2 um}
"""
SWITCH = "watches: tank, set: 20 degC, hysteresis: 1 K, power: 9 W"
COOLER = f"  cooler: {{kind: thermostat_cooling, into: {{shaft: 1}}, {SWITCH}}}\n"
FAN = "  fan: {kind: heat_source, into: {shaft: 1}, power: 5 W, with"
SKIN = "  skin: {kind: convection, between: [housing, ambient], conductance: 5 W/K}"
FRICTION = "into: {shaft: 0.5, housing@0.1..0.3: 0.5}"
GROWTH = "    growth: {kind: stretching, of: housing, direction: 1}"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "bench.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refused(path: Path) -> str:
    """What the user reads of a file, without the folder; empty where it is accepted."""
    try:
        Machine.load(path)
    except Refused as refused:
        return str(refused).replace(f"{path.parent}/", "")
    return ""


def edited(*edits: str) -> str:
    """The bench with texts exchanged: old, new, old, new, …"""
    text = BENCH
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        assert old in text
        text = text.replace(old, new, 1)
    return text


def test_the_bench_itself_is_right(tmp_path: Path) -> None:
    assert Machine.load(written(tmp_path, BENCH)).warnings == ()


G = "links.bearing: conductance"
NODE = "a bar has material, length and area, a mass has heat_capacity"
FORMS = "give exactly one of: conductance | coefficient + area | geometry + length + area"
PLACE = "write node, node@0.3 or node@0.2..0.8"
LUMPS = "give a whole number from 1 to 2000"
AXES = "the axes are x, y, z, a, b, c"
CHANGE = "change or take out this entry too"
LINKS = ", ".join(kinds("links"))
LISTED = "known are: machine, reference, extends, closed_form, nodes, links, sources, sensors, materials, levels, tcp"
LISTED += ", calibrated"


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        # units and numbers
        (("5 W/K}", "5}"), "11: links.skin: conductance '5' has no unit; a unit like W/K is needed, as in `5 W/K`"),
        (("5 W/K}", "5 W}"), "11: links.skin: conductance '5 W' is in W; a unit like W/K is needed"),
        (
            ("5 W/K}", "5 W/Kelv}"),
            "11: links.skin: conductance '5 W/Kelv' has an unknown unit 'Kelv'; did you mean 'kelvin'?",
        ),
        (("5 W/K}", "5 W/m^2 K}"), "11: links.skin: conductance '5 W/m^2 K' is in W/m^2 K; a unit like W/K is needed"),
        (
            ("5 W/K}", "5 W/(K}"),
            "11: links.skin: conductance '5 W/(K' has an unreadable unit 'W/(K'; "
            "a unit like W/K is needed",
        ),
        (
            ("500 N mm", "500"),
            "13: sources.friction: torque '500' has no unit; a unit like N m is needed, as in `500 N m`",
        ),
        (("20 W/K ± 30 %", "10:30"), f"10: {G} '10:30' is not a number; write it with its unit, like `5 W/K`"),
        (("20 W/K ± 30 %", "017 W/K"), f"10: {G} '017 W/K' starts with a zero; write `17 W/K`"),
        (("20 W/K ± 30 %", "1e3"), f"10: {G} '1e3' has no unit; a unit like W/K is needed, as in `1e3 W/K`"),
        (("20 W/K ± 30 %", "on"), f"10: {G} 'on' is not a number; write it with its unit, like `5 W/K`"),
        (
            ("20 W/K ± 30 %", "'20,5 W/K'"),
            f"10: {G} '20,5 W/K' has a comma in it; write the decimals with a point, like `0.5`",
        ),
        (("20 W/K ± 30 %", "1e999 W/K"), f"10: {G} '1e999 W/K' is not finite; write a finite number"),
        (("20 W/K ± 30 %", ""), f"10: {G} is empty; give a number, in W/K"),
        (("20 W/K ± 30 %", "[20 W/K]"), f"10: {G} is not a single value; give a number, in W/K"),
        (
            ("10 kJ/K", "-10 kJ/K"),
            "6: nodes.shaft: heat_capacity '-10 kJ/K' is not above zero; give a heat_capacity above zero, in J/K",
        ),
        (
            ("10 kJ/K", "0 kJ/K"),
            "6: nodes.shaft: heat_capacity '0 kJ/K' is not above zero; give a heat_capacity above zero, in J/K",
        ),
        (
            ("10 kJ/K", "nan kJ/K"),
            "6: nodes.shaft: heat_capacity 'nan kJ/K' is not a number; write it with its unit, like `5 J/K`",
        ),
        (
            ("10 kJ/K", ".inf"),
            "6: nodes.shaft: heat_capacity '.inf' is not a number; write it with its unit, like `5 J/K`",
        ),
        (
            ("5 W/K}", "-5 W/K}"),
            "11: links.skin: conductance '-5 W/K' is below what is possible; conductance goes from 0 W/K to 1e+06 W/K",
        ),
        (
            ("20 W/K ± 30 %", "20 W/K ± 0 %"),
            f"10: {G} '20 W/K ± 0 %' has a spread that is not above zero; drop the ± for a known number",
        ),
        (
            ("20 W/K ± 30 %", "20 W/K ± -3 %"),
            f"10: {G} '20 W/K ± -3 %' has a spread that is not above zero; drop the ± for a known number",
        ),
        (
            ("20 W/K ± 30 %", "20 W/K ± 3 % ± 1 %"),
            f"10: {G} '20 W/K ± 3 % ± 1 %' has more than one ±; write `value W/K ± spread`",
        ),
        (
            ("20 W/K ± 30 %", "20 W/K ± 3"),
            f"10: {G} '20 W/K ± 3' has a spread without unit; write `± 3 %` or `± 3 W/K`",
        ),
        (("20 W/K ± 30 %", "20 W/K ±"), f"10: {G} '20 W/K ±' has nothing behind the ±; write the spread, as in ± 30 %"),
        (
            ("20 W/K ± 30 %", "0 W/K ± 3 %"),
            f"10: {G} '0 W/K ± 3 %' has a spread that is a share of zero; write it with its unit, or drop the ±",
        ),
        (
            ("temperature: ambient", "temperature: 21 degC ± 5 %"),
            "8: nodes.ambient: temperature '21 degC ± 5 %' has a spread that is a share of a temperature; "
            "write it in K, as in ± 2 K",
        ),
        (
            ("20 W/K ± 30 %", "unknown 50..1 W/K"),
            f"10: {G} 'unknown 50..1 W/K' has its bounds the wrong way round; write the lower one first",
        ),
        (
            ("20 W/K ± 30 %", "unknown 1..50"),
            f"10: {G} 'unknown 1..50' has no unit; a unit like W/K is needed, as in `unknown 1..50 W/K`",
        ),
        (
            ("20 W/K ± 30 %", "unknown -1..50 W/K"),
            f"10: {G} 'unknown -1..50 W/K' is below what is possible; conductance goes from 0 W/K to 1e+06 W/K",
        ),
        (
            ("20 W/K ± 30 %", "unknown much"),
            f"10: {G} 'unknown much' is not a range; write `unknown 1..50 W/K`, or `unknown` alone",
        ),
        (
            ("20 W/K ± 30 %", "20,5 W/K"),
            "10: links.bearing has an unknown key '5 W/K'; write decimals with a point, like 0.5\n"
            f"bench.yaml:10: {G} '20' has no unit; a unit like W/K is needed, as in `20 W/K`",
        ),
        # keys, kinds and sections
        (("torque:", "torqe:"), "13: sources.friction has an unknown key 'torqe'; did you mean 'torque'?"),
        (
            (", conductance: 20 W/K ± 30 %", ""),
            "10: links.bearing has nothing to compute with; "
            "give exactly one of: conductance | conductivity + area + length",
        ),
        (("convection", "convecton"), "11: links.skin has an unknown kind 'convecton'; did you mean 'convection'?"),
        (
            ("kind: bearing_friction", "kind: bearing_frictoin"),
            "13: sources.friction has an unknown kind 'bearing_frictoin'; did you mean 'bearing_friction'?",
        ),
        (
            ("kind: conduction", "kind: bearing_friction"),
            "10: links.bearing has an unknown kind 'bearing_friction'; that kind belongs to sources",
        ),
        (("stretching", "stretchin"), "16: tcp.z.growth has an unknown kind 'stretchin'; did you mean 'stretching'?"),
        (
            ("0.05 K", "0.05 K, effects: [{kind: sensor_lg}]"),
            "18: sensors.T_housing.effects.0 has an unknown kind 'sensor_lg'; did you mean 'sensor_lag'?",
        ),
        (
            ("kind: convection, ", ""),
            "11: links.skin has no kind; "
            f"give one of: {LINKS}",
        ),
        (("sources:", "sorces:"), "12: unknown section 'sorces'; did you mean 'sources'?"),
        (("machine: test bench\n", "machine: test bench\nxyz: 1\n"), f"2: unknown section 'xyz'; {LISTED}"),
        (("  skin:", "  bearing:"), "11: 'bearing' is given twice (first in line 10); keep one of them"),
        (
            ("rotates: true", "rotates: true, rotates: false"),
            "6: 'rotates' is given twice (first in line 6); keep one of them",
        ),
        (("machine: test bench\n", ""), "1: 'machine' is missing; begin with `machine: a name`"),
        (
            ("reference: 20 degC\n", ""),
            "1: 'reference' is missing; give the temperature of zero displacement, as in `reference: 22 degC`",
        ),
        (
            ("reference: 20 degC", "reference: 20"),
            "2: reference '20' has no unit; a unit like degC is needed, as in `20 degC`",
        ),
        (
            ("reference: 20 degC", "reference: 2000 degC"),
            "2: reference '2000 degC' is out of range; it lies between -100 and 300 degC",
        ),
        (
            ("reference: 20 degC", "reference:"),
            "2: reference is empty; give the temperature of zero displacement, as in `reference: 22 degC`",
        ),
        ((SKIN, "  skin:"), "11: links.skin is empty; write `{kind: …, …}`"),
        (("{temperature: ambient}", ""), "8: nodes.ambient is empty; write `{}` for one without anything"),
        (("rotates: true", "rotates: yes"), "6: nodes.shaft: rotates is 'yes'; write true or false"),
        # names that lead nowhere
        (
            ("[housing, ambient]", "[hosing, ambient]"),
            "11: links.skin: there is no node 'hosing'; did you mean 'housing'?",
        ),
        (("{shaft: 0.5", "{shift: 0.5"), "13: sources.friction: there is no node 'shift'; did you mean 'shaft'?"),
        (
            ("measures: housing@0.5", "measures: houses"),
            "18: sensors.T_housing: there is no node 'houses'; did you mean 'housing'?",
        ),
        (("of: housing", "of: hausing"), "16: tcp.z.growth: there is no node 'hausing'; did you mean 'housing'?"),
        (
            (
                "  friction:",
                f"{COOLER}  friction:",
            ),
            "13: sources.cooler: there is no node 'tank'; known are: shaft, housing, ambient",
        ),
        (("material: iron", "material: irn"), "7: nodes.housing: there is no material 'irn'; did you mean 'iron'?"),
        (
            ("tcp:", "closed_form: {spindle: shift}\ntcp:"),
            "14: closed_form.spindle names no node; did you mean 'shaft'?",
        ),
        # places and shares
        (
            ("housing@0.5", "housing@1.5"),
            "18: sensors.T_housing: measures 'housing@1.5' lies outside the part; fractions go from 0 to 1",
        ),
        (
            ("[shaft, housing@0.1..0.3]", "[shaft, housing@0.3..0.1]"),
            "10: links.bearing: between 'housing@0.3..0.1' runs backwards; "
            "write the smaller fraction first, as in node@0.2..0.8",
        ),
        (
            ("housing@0.5", "housing@middle"),
            f"18: sensors.T_housing: measures 'housing@middle' is not a place; {PLACE}",
        ),
        (("housing@0.5", "housing@nan"), f"18: sensors.T_housing: measures 'housing@nan' is not a place; {PLACE}"),
        (
            ("{shaft: 0.5", "{shaft: 0.4"),
            "13: sources.friction: into has shares that add up to 0.9; make them add up to 1",
        ),
        (
            ("{shaft: 0.5", "{shaft: -0.5"),
            "13: sources.friction: into shaft: '-0.5' is not a share; shares go from 0 to 1, without ±",
        ),
        (
            ("{shaft: 0.5", "{shaft: 0.5 W"),
            "13: sources.friction: into shaft: '0.5 W' has a unit; a bare number is needed",
        ),
        (
            ("[housing, ambient]", "[housing, housing]"),
            "11: links.skin: joins housing with itself; name two different places",
        ),
        (("[housing, ambient]", "[housing]"), "11: links.skin: between has 1 places; give 2 places, as in [a, b]"),
        (("[housing, ambient]", "housing"), "11: links.skin: between is not a list; give 2 places, as in [a, b]"),
        # nodes
        (("lumps: 2", "lumps: 2.5"), f"7: nodes.housing: lumps is '2.5'; {LUMPS}"),
        (("lumps: 2", "lumps: 0"), f"7: nodes.housing: lumps is '0'; {LUMPS}"),
        (("lumps: 2", "lumps: 017"), f"7: nodes.housing: lumps is '017'; {LUMPS}"),
        (("lumps: 2", "lumps: 1e9"), f"7: nodes.housing: lumps is '1e9'; {LUMPS}"),
        (("lumps: 2", "lumps: 1000000000"), f"7: nodes.housing: lumps is '1000000000'; {LUMPS}"),
        (("lumps: 2", "lumps: ²"), f"7: nodes.housing: lumps is '²'; {LUMPS}"),
        (
            ("10 kJ/K", "10 kJ/K, lumps: 3"),
            "6: nodes.shaft: has lumps but is no bar; lumps need material, length and area",
        ),
        ((", area: 200 cm^2", ""), f"7: nodes.housing: has material and length but lacks area; {NODE}"),
        (
            ("material: iron, length: 500 mm, area: 200 cm^2, lumps: 2", "length: 500 mm"),
            f"7: nodes.housing: has length but lacks material and area; {NODE}",
        ),
        (
            ("lumps: 2", "heat_capacity: 5 kJ/K"),
            "7: nodes.housing: has heat_capacity beside a bar's size; use extra_heat_capacity, or drop the area",
        ),
        (
            ("temperature: ambient", "temperature: ambient, heat_capacity: 5 kJ/K"),
            "8: nodes.ambient: is held and has heat_capacity too; drop `temperature`, or the rest",
        ),
        (
            ("temperature: ambient", "temperature: 21"),
            "8: nodes.ambient: temperature '21' has no unit; a unit like degC is needed, as in `21 degC`",
        ),
        (
            ("temperature: ambient", "temperature: 10:30"),
            "8: nodes.ambient: temperature '10:30' is not a number; write it with its unit, like `5 degC`",
        ),
        (
            ("links:", "  spare: {heat_capacity: 1 kJ/K}\nlinks:"),
            "9: nodes.spare is isolated: no link and no source; link it, or take it out",
        ),
        (
            ("heat_capacity: 10 kJ/K", "melts: {at: 28 degC, over: 2 K, latent_heat: 5 kJ}"),
            "6: nodes.shaft: melts but has no heat capacity; give heat_capacity",
        ),
        (
            ("10 kJ/K", "10 kJ/K, melts: {at: 28, over: 2 K, latent_heat: 5 kJ}"),
            "6: nodes.shaft.melts: at '28' has no unit; a unit like degC is needed, as in `28 degC`",
        ),
        (
            ("  shaft: {heat", "  sh@ft: {heat"),
            "6: nodes: the name 'sh@ft' has @ in it; "
            "rename it\n"
            "bench.yaml:10: links.bearing: there is no node 'shaft'; "
            "did you mean 'sh@ft'?\n"
            "bench.yaml:13: sources.friction: there is no node 'shaft'; "
            "did you mean 'sh@ft'?",
        ),
        # forms and inputs
        (
            ("5 W/K}", "5 W/K, coefficient: 5 W/(m^2 K), area: 1 m^2}"),
            f"11: links.skin has 'conductance' and 'coefficient' and 'area'; {FORMS}",
        ),
        ((", conductance: 5 W/K", ""), f"11: links.skin has nothing to compute with; {FORMS}"),
        (("conductance: 5 W/K", "coefficient: 5 W/(m^2 K)"), f"11: links.skin has 'coefficient'; {FORMS}"),
        (
            (FRICTION, "into: {ambient: 1}"),
            "13: sources.friction: heats ambient, whose temperature is held; "
            "heat a part, or give that node a heat capacity",
        ),
        (
            ("  friction:", f"{FAN}: flow}}\n  friction:"),
            "13: sources.fan: follows 'flow' but lacks 'at'; give the value of flow that makes `power`",
        ),
        (
            (
                "  friction:",
                f"{FAN}: speed, at: 5 m/min}}\n  friction:",
            ),
            "14: sources.friction reads the input 'speed' in rpm, sources.fan in m/min; one input has one kind of unit",
        ),
        (
            (
                "  friction:",
                f"{FAN}: ambient, at: 5 m/min}}\n  friction:",
            ),
            "13: sources.fan reads the input 'ambient' in m/min, nodes.ambient in degC; one input has one kind of unit",
        ),
        # displacement and sensors
        (("direction: 1", "direction: 2"), "16: tcp.z.growth: direction is '2'; give 1 or -1"),
        (("  z:\n", "  w:\n"), f"15: tcp has no axis 'w'; {AXES}"),
        (
            ("tcp.z,", "tcp.y,"),
            "19: sensors.dz: measures tcp.y, and nothing moves that axis; add an entry below tcp.y, or measure tcp.z",
        ),
        (("tcp.z,", "tcp.up,"), f"19: sensors.dz: there is no axis 'up'; {AXES}"),
        (
            (
                GROWTH,
                "    growth: {kind: centrifugal_growth, displacement: 9 um, reference_speed: 9000 rpm, direction: 1}",
                "  z:",
                "  a:",
                "tcp.z",
                "tcp.a",
                "0.2 um",
                "0.2 urad",
            ),
            "16: tcp.a.growth: centrifugal_growth does not act on a; it acts on x, y, z",
        ),
        (
            ("of: housing", "of: shaft"),
            "16: tcp.z.growth: shaft names no material; "
            "give `expansion`, as in 1.1e-5 1/K\n"
            "bench.yaml:16: tcp.z.growth: the length of shaft is not known; "
            "give `length`",
        ),
        (
            ("noise: 0.05 K", "noise: 0.05 um"),
            "18: sensors.T_housing: noise '0.05 um' is not the noise of a temperature; give it in K, as in 0.05 K",
        ),
        (
            ("noise: 0.2 um", "noise: 0.2"),
            "19: sensors.dz: noise '0.2' is not the noise of a displacement; give it in um, as in 0.05 um",
        ),
        (
            (", noise: 0.05 K", ""),
            "18: sensors.T_housing lacks 'noise'; give it: 1σ of one sample, like 0.05 K or 0.25 um",
        ),
        (
            ("noise: 0.05 K", "noise: 0 K"),
            "18: sensors.T_housing: noise '0 K' is not above zero; give 1σ of one sample, like 0.05 K or 0.25 um",
        ),
        (
            ("noise: 0.05 K", "noise: 0.05 K ± 5 %"),
            "18: sensors.T_housing: noise '0.05 K ± 5 %' has a spread; give the number without ±",
        ),
        (
            ("noise: 0.05 K", "noise: 0.05 K, zero: start"),
            "18: sensors.T_housing: a temperature is not zeroed at the start; drop `zero`, it is for displacements",
        ),
        (("T_housing:", "ambient:"), "18: sensors.ambient has the name of an input; rename the sensor"),
        (("T_housing:", "time:"), "18: sensors.time has the name of the time column; rename the sensor"),
        # levels and what YAML itself does not allow
        (
            ("tcp:", "levels: {coarse: {lumbs: 2}}\ntcp:"),
            "14: levels.coarse has an unknown key 'lumbs'; did you mean 'lumps'?",
        ),
        (("  skin:", "\tskin:"), "11: this line is indented with a tab; indent with spaces"),
        (
            ("  skin:", "   skin:"),
            "11: this line does not fit what stands above it; mind the indentation and the quotes",
        ),
        (("5 W/K}", "5 W/K"), "11: a bracket is opened here and not closed properly; close it, with commas inside"),
        (
            ("test bench", "test: bench"),
            "1: a colon stands where none can be; mind the indentation, and quote such texts",
        ),
        (("test bench", "'test bench"), "1: a quote is opened here and not closed; close it"),
        (
            ("test bench", "!!python/object/apply:os.system ['touch never']"),
            "1: a value has the YAML tag '!!python/object/apply:os.system'; write plain values, tags are not read",
        ),
        (
            ("shaft: {heat", "!!python/name:os.system : {heat"),
            "6: a value has the YAML tag '!!python/name:os.system'; write plain values, tags are not read",
        ),
        (("[housing, ambient]", "&x [housing, *x]"), "11: '*x' contains itself; take the alias out of what `&x` marks"),
        (("[housing, ambient]", "*places"), "11: '*places' stands for nothing; mark it with `&places` above"),
        (
            ("  skin:", "  <<: {a: 1}\n  skin:"),
            "11: '<<' merges another mapping; "
            "write its entries out, or use `extends:`\n"
            "bench.yaml:11: links.<< has no kind; "
            f"give one of: {LINKS}",
        ),
        (("tcp:", "---\ntcp:"), "14: a second document begins; keep one document in a file, without `---` between"),
    ],
)  # fmt: skip
def test_one_fault(edits: tuple[str, ...], message: str, tmp_path: Path) -> None:
    assert refused(written(tmp_path, edited(*edits))) == f"bench.yaml:{message}"


def test_all_faults_of_a_file_are_told_by_line(tmp_path: Path) -> None:
    edits = ("5 W/K}", "5}", "material: iron", "material: irn", "of: housing", "of: hausing", "0.2 um", "1 K")
    twice = ("  friction:", "  friction: {kind: seal_frictoin}\n  friction:", "machine: test", "machne: test")
    assert refused(written(tmp_path, edited(*edits, *twice))).splitlines() == [
        "bench.yaml:1: unknown section 'machne'; did you mean 'machine'?",
        "bench.yaml:7: nodes.housing: there is no material 'irn'; did you mean 'iron'?",
        "bench.yaml:11: links.skin: conductance '5' has no unit; a unit like W/K is needed, as in `5 W/K`",
        "bench.yaml:13: sources.friction has an unknown kind 'seal_frictoin'; did you mean 'seal_friction'?",
        "bench.yaml:14: 'friction' is given twice (first in line 13); keep one of them",
        "bench.yaml:17: tcp.z.growth: there is no node 'hausing'; did you mean 'housing'?",
        "bench.yaml:20: sensors.dz: noise '1 K' is not the noise of a displacement; give it in um, as in 0.05 um",
    ]


def test_entries_over_several_lines_are_told_by_the_line_at_fault(tmp_path: Path) -> None:
    between = "    between:\n      - housing\n      - hall@2\n"
    block = f"  skin:\n    kind: convection\n{between}    conductance:\n      5 W\n"
    assert refused(written(tmp_path, edited(SKIN + "\n", block))).splitlines() == [
        "bench.yaml:15: links.skin: between 'hall@2' lies outside the part; fractions go from 0 to 1",
        "bench.yaml:16: links.skin: conductance '5 W' is in W; a unit like W/K is needed",
    ]
    shares = "into:\n      shaft: 0.5\n      housing@3: 0.5\n    torque: 5 N m\n    kind: bearing_friction\n"
    friction = "  friction: {kind: bearing_friction, " + FRICTION + ", torque: 500 N mm}\n"
    assert refused(written(tmp_path, edited(friction, f"  friction:\n    {shares}"))).splitlines() == [
        "bench.yaml:16: sources.friction: into housing@3: 'housing@3' lies outside the part; fractions go from 0 to 1"
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", ": is empty; give a machine file"),
        (" \n\n", ": is empty; give a machine file"),
        ("# only\n# words\n", ":1: holds nothing but comments; give a machine file"),
        ("- a\n- b\n", ":1: is not a mapping; a machine file is made of `key: value` lines"),
        ("hello", ":1: is not a mapping; a machine file is made of `key: value` lines"),
        (BENCH.encode("utf-16"), ": is not UTF-8 text (byte 0xff in line 1); save it as UTF-8"),
        ("machine: x".encode("utf-16-le"), ":1: has a character that no text has (0x00); save it as UTF-8 text"),
        (BENCH.encode("latin-1"), ": is not UTF-8 text (byte 0xb1 in line 10); save it as UTF-8"),
        (b"machine: \x1b[31m\n", ":1: has a character that no text has (0x1b); save it as UTF-8 text"),
        ("a: " + "[" * 100_000, ":1: a value is nested too deeply; at most 40 levels"),
        ("\n".join(" " * i + "a:" for i in range(500)), ":40: a value is nested too deeply; at most 40 levels"),
        ("x" * 4_000_001, ": has 4.0 MB; a machine file has at most 4 MB"),
    ],
    ids=range(12),
)
def test_what_is_no_machine_file(content: str | bytes, message: str, tmp_path: Path) -> None:
    start = time.process_time()
    assert refused(written(tmp_path, content)) == f"bench.yaml{message}"
    assert time.process_time() - start < 1  # of the processor: what is hostile takes minutes


def test_no_file_there(tmp_path: Path) -> None:
    assert refused(tmp_path / "none.yaml") == "none.yaml: there is no such file; give the path of a machine file"
    (tmp_path / "folder.yaml").mkdir()
    assert refused(tmp_path / "folder.yaml") == "folder.yaml: is not a file; give the path of a machine file"
    assert "cannot be read (file name too long)" in refused(tmp_path / ("long" * 100))


def test_a_large_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    with path.open("wb") as file:
        file.truncate(50_000_000_000)
    assert refused(path) == "bench.yaml: has 50000.0 MB; a machine file has at most 4 MB"


def test_aliases_that_would_blow_up_stay_small(tmp_path: Path) -> None:
    lines = ["a: &a [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    lines += [f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]" for old, new in pairwise("abcdefghij")]
    path = written(tmp_path, "\n".join(lines))
    tracemalloc.start()
    message, (_, peak) = refused(path), tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert message == "bench.yaml:6: this expands to more than 200000 values; write without nested aliases"
    assert peak < 1_000_000


def test_tags_run_nothing(tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    tag = f"!!python/object/apply:os.system ['touch {trace}']"
    assert "tags are not read" in refused(written(tmp_path, edited("test bench", tag)))
    assert not trace.exists()


def test_words_that_yaml_likes_to_change_are_names_like_others(tmp_path: Path) -> None:
    names = ("on", "10:30", "017", "1e3", "no", "~", "null", "2020-01-01")
    text = edited(*(t for name in names for t in ("links:", f"  {name}: {{heat_capacity: 1 kJ/K}}\nlinks:")))
    links = "".join(f"  l{i}: {{kind: conduction, between: [{name}, shaft], conductance: 1 W/K}}\n"
                    for i, name in enumerate(names) if name not in ("~", "null"))  # fmt: skip
    quoted = "  q1: {kind: conduction, between: ['~', 'null'], conductance: 1 W/K}\n"
    machine = Machine.load(written(tmp_path, text.replace("links:\n", f"links:\n{links}{quoted}")))
    assert set(names) < set(machine.nodes)
    assert machine.links["l2"].between[0].node == "017"


@pytest.mark.parametrize(
    ("edits", "warnings"),
    [
        (("500 N mm", "520 N m"), ["13: sources.friction: makes 163 kW at 3000 rpm; was N mm meant instead of N m?"]),
        (
            ("conductance: 5 W/K", "geometry: vertical_plate, length: 90 m, area: 1 m^2"),
            ["11: links.skin: gives Ra = 7.1e+14 at 10 K excess, outside the correlation; "
             "the correlation for vertical_plate holds for Ra 1e-01 to 1e+12"],
        ),
        (
            (SKIN + "\n", ""),
            ["6: nodes.shaft: no path from shaft, housing to a held node; it never settles; link it to ambient",
             "8: nodes.ambient is held and no link reaches it; link it, or take it out"],
        ),
        (
            ("links:", "  cellar: {temperature: 5 degC}\nlinks:"),
            ["9: nodes.cellar is held and no link reaches it; link it, or take it out"],
        ),
        (
            ("links:", "  hall: {temperature: 5 degC}\nlinks:\n"
             "  door: {kind: conduction, between: [hall, ambient], conductance: 1 W/K}"),
            ["11: links.door: joins only nodes whose temperature is held; "
             "it changes nothing; link a part, or take it out"],
        ),
        (("1.1e-5", "1.1e-3"), ["4: materials.iron: expands by 0.0011 per kelvin; metals have 1e-6 to 3e-5 1/K"]),
    ],
    ids=("kilowatts", "correlation", "never settles", "unlinked", "held only", "expansion"),
)  # fmt: skip
def test_warnings(edits: tuple[str, ...], warnings: list[str], tmp_path: Path) -> None:
    machine = Machine.load(written(tmp_path, edited(*edits)))
    told = [str(warning).replace(f"{tmp_path}/bench.yaml:", "") for warning in machine.warnings]
    assert told == warnings


WORDS = (
    *("±", "unknown", "null", "{", "}", "[", "]", ":", "@", "..", ",", "0", "-1", "1e9", "K", "kind", "- ", "\n", "\t"),
    *("  ", "'", '"', "&a", "*a", "!", "#", "|", ">", "°", "²", "٣", "nan", "\x00", "\ud7ff", "node", "%"),
)


def mutated(text: str, chance: random.Random) -> str:
    """The text with a few characters, words or lines taken out, doubled, exchanged or put elsewhere."""
    for _ in range(chance.randint(1, 4)):
        at, end = sorted(chance.choices(range(len(text) + 1), k=2))
        end = min(end, at + chance.randint(0, 30))
        lines = text.split("\n")
        line = chance.randrange(len(lines))
        match chance.randrange(5):
            case 0:
                text = text[:at] + text[end:]
            case 1:
                text = text[:at] + chance.choice(WORDS) + text[end if chance.random() < 0.5 else at :]
            case 2:
                text = "\n".join(lines[:line] + lines[line + 1 :])
            case 3:
                text = "\n".join([*lines[:line], chance.choice(lines), *lines[line:]])
            case 4:
                words = text.split(" ")
                words[chance.randrange(len(words))] = chance.choice(words)
                text = " ".join(words)
    return text


def test_mutated_cases_are_refused_or_read(tmp_path: Path) -> None:
    """Whatever happens to a file, its reader gets a machine or sentences, never a traceback."""
    files = sorted(CASES.glob("*/machine.yaml"))
    if not files:
        pytest.skip(f"the cases are not there: {CASES}")
    texts, chance = [file.read_text() for file in files], random.Random(7)
    outcomes = {True: 0, False: 0}
    for _ in range(300):
        message = refused(written(tmp_path, mutated(chance.choice(texts), chance).encode("utf-8", "replace")))
        outcomes[bool(message)] += 1
        assert all(line.startswith("bench.yaml") and "; " in line for line in message.splitlines())
    assert min(outcomes.values()) > 10


def test_a_beginning_names_the_one_word_that_goes_on_so() -> None:
    words = ("bending", "bearing_friction", "convection", "conduction")
    assert likely("bearing", words) == "did you mean 'bearing_friction'?"
    assert likely("bendin", words) == "did you mean 'bending'?"
    assert likely("con", words).startswith("known are") and likely("b", words).startswith("known are")


def test_a_folder_of_results_is_no_recording_but_holds_one(tmp_path: Path) -> None:
    (tmp_path / "june").mkdir()
    with pytest.raises(Refused, match=r"is not a file; give the path of a recording$"):
        Recording.load(tmp_path / "june")
    (tmp_path / "june" / "results.csv").write_text("time [s],T [degC]\n0,20\n")
    with pytest.raises(Refused, match=r"is not a file; .* \(did you mean .*june.results\.csv\?\)$"):
        Recording.load(tmp_path / "june")
