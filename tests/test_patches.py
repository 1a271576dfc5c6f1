"""Patches: `extends:`, levels, `--set`, `--lumps` and patches from Python lead to the machine that is meant."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest
from test_refusals import BENCH, edited

from network.analysis.diagnosis.candidates.candidates import candidates, kinds, lay_over
from network.machine.machine import Machine
from network.machine.size_checks import count_tables
from network.platform.refusal import Refused, Spot
from network.platform.yaml.document import Branch, dump, tree_of

SHIPPED = sorted((Path(__file__).parents[1] / "machines").glob("*.yaml"))


def files(folder: Path, **texts: str) -> Path:
    """Writes files and gives the path of the first."""
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return folder / f"{next(iter(texts))}.yaml"


def refused(path: Path, **options: object) -> str:
    with pytest.raises(Refused) as caught:
        Machine.load(path, **options)  # type: ignore[arg-type]
    return str(caught.value).replace(f"{path.parent}/", "")


# -- extends --------------------------------------------------------------------------------------------------------
def test_an_entry_replaces_the_whole_entry_and_null_removes_it(tmp_path: Path) -> None:
    skin = "  skin: {kind: radiation, between: [housing, ambient], emissivity_area: 0.2 m^2}\n"
    top = f"extends: base.yaml\nreference: 25 degC\nlinks:\n{skin}sensors: {{dz: null}}\n"
    machine = Machine.load(files(tmp_path, top=top, base=BENCH))
    assert machine.links["skin"].kind == "radiation" and list(machine.links) == ["bearing", "skin"]
    assert (machine.name, machine.reference, list(machine.sensors)) == ("test bench", 25.0, ["T_housing"])


def test_tcp_is_patched_by_axis_and_name(tmp_path: Path) -> None:
    y = "  y:\n    more: {kind: stretching, of: housing, direction: -1}\n"
    path = files(tmp_path, top=f"extends: base.yaml\ntcp:\n{y}  z: {{other: null}}\n", base=BENCH)
    assert refused(path) == "top.yaml:5: tcp.z.other is removed, and it is not there; known are: growth"
    machine = Machine.load(files(tmp_path, top=f"extends: base.yaml\ntcp:\n{y}", base=BENCH))
    assert {axis: list(entries) for axis, entries in machine.tcp.items()} == {"z": ["growth"], "y": ["more"]}


def test_chains_go_from_the_ground_up(tmp_path: Path) -> None:
    top = "extends: sub/middle.yaml\nmachine: top\n"
    middle = "extends: ../base.yaml\nreference: 21 degC\nmachine: middle\n"
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "middle.yaml").write_text(middle)
    machine = Machine.load(files(tmp_path, top=top, base=BENCH))
    assert (machine.name, machine.reference) == ("top", 21.0)
    assert machine.links["skin"].spot == Spot(str(tmp_path / "sub/../base.yaml"), 11)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (("extends: a.yaml\n",), "a.yaml:1: extends itself: a.yaml → a.yaml; take one `extends:` out"),
        (
            ("extends: b.yaml\n", "# two\nextends: a.yaml\n"),
            "b.yaml:2: extends itself: a.yaml → b.yaml → a.yaml; take one `extends:` out",
        ),
        (
            ("extends: b.yaml\n", "extends: c.yaml\n", "extends: b.yaml\n"),
            "c.yaml:1: extends itself: b.yaml → c.yaml → b.yaml; take one `extends:` out",
        ),
        (("extends: z.yaml\n",), "a.yaml:1: extends 'z.yaml', and there is no such file; give its path from HERE"),
        (("extends: .\n",), "a.yaml:1: extends '.', and there is no such file; give its path from HERE"),
        (("extends:\n",), "a.yaml:1: extends is not a file name; write `extends: other.yaml`"),
        (
            ("extends: b.yaml\nlinks: {skn: null}\n", BENCH),
            "a.yaml:2: links.skn is removed, and it is not there; did you mean 'skin'?",
        ),
        (
            ("extends: b.yaml\nmaterials:\n  iron: null\n", BENCH),
            "b.yaml:7: nodes.housing: there is no material 'iron' any more (a.yaml:3 takes it out); "
            "change or take out this entry too",
        ),
        (
            ("extends: b.yaml\nnodes:\n  shaft: null\n", BENCH),
            "b.yaml:10: links.bearing: there is no node 'shaft' any more (a.yaml:3 takes it out); "
            "change or take out this entry too\n"
            "b.yaml:13: sources.friction: there is no node 'shaft' any more (a.yaml:3 takes it out); "
            "change or take out this entry too",
        ),
        (
            ("extends: b.yaml\ntcp: {z: null}\n", BENCH),
            "b.yaml:19: sensors.dz: measures tcp.z, and nothing moves that axis; add an entry below tcp.z",
        ),
        (
            ("extends: b.yaml\nsensors: 5\n", BENCH.replace("500 N mm", "500")),
            "a.yaml:2: section 'sensors' is not a mapping; write `name: {…}` lines below it\n"
            "b.yaml:13: sources.friction: torque '500' has no unit; a unit like N m is needed, as in `500 N m`",
        ),
    ],
)
def test_refused_chains(texts: tuple[str, ...], message: str, tmp_path: Path) -> None:
    path = files(tmp_path, **dict(zip("abc", texts, strict=False)))
    assert refused(path) == message.replace("HERE", str(tmp_path))


# -- --set and --lumps ----------------------------------------------------------------------------------------------
def test_set_exchanges_adds_and_removes(tmp_path: Path) -> None:
    stone = "density: 2 kg/l, specific_heat: 1 kJ/(kg K), conductivity: 1 W/(m K), expansion: 5 um/(m K)"
    sets = [
        "links.skin.conductance=8 W/K ± 20 %",
        "links.bearing.between.0=ambient",
        "sources.friction.into={shaft: 1}",
        "sensors.T_housing.effects=[{kind: sensor_lag, lag: 5 s}]",
        "sensors.T_housing.effects.0.lag=1 min",
        "sensors.dz=null",
        "tcp.y.tall={kind: stretching, of: housing, direction: -1}",
        "reference=300 K",
        "nodes.housing.lumps=5",
        f"materials.stone={{{stone}}}",
    ]
    machine = Machine.load(files(tmp_path, bench=BENCH), sets=sets)
    skin = machine.links["skin"].numbers["conductance"]
    assert (skin.value, skin.prior, skin.spread) == (8.0, "log", 0.2)
    assert str(machine.links["bearing"].between[0]) == "ambient"
    assert machine.sensors["T_housing"].effects[0].lag == 60
    assert list(machine.tcp) == ["z", "y"] and list(machine.sensors) == ["T_housing"]
    assert machine.reference == pytest.approx(26.85)
    assert machine.nodes["housing"].lumps == 5
    assert machine.materials["stone"].density == pytest.approx(2000)


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("links.skin", "is not path=value; write it like links.skin.conductance=5 W/K"),
        ("=5", "is not path=value; write it like links.skin.conductance=5 W/K"),
        ("links.skin.conductance=", "is not path=value; write it like links.skin.conductance=5 W/K"),
        ("linkz.skin=5", "the machine has no 'linkz'; did you mean 'links'?"),
        ("links.skni.conductance=8 W/K", "links has no 'skni'; did you mean 'skin'?"),
        (
            "links.skin.conductance=8",
            "links.skin: conductance '8' has no unit; a unit like W/K is needed, as in `8 W/K`",
        ),
        (
            "links.bearing.conductanc=8 W/K",
            "links.bearing has an unknown key 'conductanc'; did you mean 'conductance'?",
        ),
        ("links.skn=null", "takes out links.skn, and it is not there; did you mean 'skin'?"),
        (
            "links.bearing.between.5=a",
            "links.bearing.between is a list of 2; write links.bearing.between.0 for the first",
        ),
        ("links.skin.conductance.x=5", "links.skin.conductance is a single value; write links.skin.conductance=value"),
        (
            "sources.friction.into.shaft=0.4",
            "sources.friction: into has shares that add up to 0.9; make them add up to 1",
        ),
        (
            "links.new={kind: conduction",
            "'{kind: conduction' is not YAML (a bracket is opened here and not closed properly); mind the brackets",
        ),
        ("links.new={a: &x [*x]}", "'{a: &x [*x]}' is not YAML ('*x' contains itself); mind the brackets"),
        (
            "nodes.new={heat_capacity: 5 kJ/K}",
            "nodes.new is isolated: no link and no source; link it, or take it out",
        ),
    ],
)
def test_refused_settings(assignment: str, message: str, tmp_path: Path) -> None:
    told = refused(files(tmp_path, bench=BENCH), sets=[assignment])
    assert told == f"--set {assignment}: {message}"


@pytest.mark.parametrize(("wish", "lumps"), [("4", 4), (7, 7), ("housing=3", 3)])
def test_lumps_of_every_bar_or_of_one(wish: str | int, lumps: int, tmp_path: Path) -> None:
    machine = Machine.load(files(tmp_path, bench=BENCH), lumps=[wish])
    assert (machine.nodes["housing"].lumps, machine.nodes["shaft"].lumps) == (lumps, 1)


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ("shaft=3", "'shaft' is not a bar; known are: housing"),
        ("hosing=3", "'hosing' is not a bar; did you mean 'housing'?"),
        ("2.5", "'2.5' is not a number of lumps; write N or node=N, N a whole number from 1"),
        ("0", "'0' is not a number of lumps; write N or node=N, N a whole number from 1"),
        ("99999", "nodes.housing: lumps is '99999'; give a whole number from 1 to 2000"),
    ],
)
def test_refused_lumps(wish: str, message: str, tmp_path: Path) -> None:
    assert refused(files(tmp_path, bench=BENCH), lumps=[wish]) == f"--lumps {wish}: {message}"


# -- levels ---------------------------------------------------------------------------------------------------------
LEVELS = """\
closed_form: {spindle: housing}
levels:
  fine: {lumps: {housing: 9}, links: {skin: {kind: convection, between: [housing, ambient], conductance: 9 W/K}}}
  three: {lumps: 3}
  one: {merge: {unit: [shaft, housing]}}
  few: {merge: {unit: [shaft]}}
  held: {merge: {unit: [shaft, ambient]}}
  list: {merge: [shaft, housing]}
  taken: {merge: {ambient: [shaft, housing]}}
  twice: {merge: {unit: [shaft, housing], other: [shaft, housing]}}
  mass: {lumps: {shaft: 3}}
  typo: {links: {skan: null}}
"""


def test_a_level_is_a_patch_with_lumps(tmp_path: Path) -> None:
    path = files(tmp_path, bench=BENCH + LEVELS)
    assert Machine.load(path, level="fine").nodes["housing"].lumps == 9
    assert Machine.load(path, level="fine").links["skin"].numbers["conductance"].value == 9
    assert Machine.load(path, level="three").nodes["housing"].lumps == 3
    assert Machine.load(path, level="three", lumps=[4], sets=["nodes.housing.lumps=5"]).nodes["housing"].lumps == 5


def test_merged_parts_keep_their_heat_their_growth_and_what_is_uncertain(tmp_path: Path) -> None:
    text = BENCH.replace("lumps: 2", "lumps: 2, extra_heat_capacity: 1 kJ/K ± 20 %").replace("10 kJ/K", "10 kJ/K ± 5 %")
    path = files(tmp_path, bench=text + LEVELS)
    full, one = Machine.load(path), Machine.load(path, level="one")
    assert list(one.nodes) == ["ambient", "unit"] and list(one.links) == ["skin"]
    assert one.nodes["unit"].capacity == pytest.approx(sum(full.nodes[name].capacity for name in ("shaft", "housing")))
    spread = one.uncertain["nodes.unit.heat_capacity"].spread * one.nodes["unit"].capacity
    assert spread == pytest.approx((500**2 + 200**2) ** 0.5)
    assert one.nodes["unit"].rotates and one.closed_form == {"spindle": "unit"}
    assert str(one.sources["friction"].into[0][0]) == "unit" and one.sources["friction"].into[0][1] == 1
    assert str(one.sensors["T_housing"].measures) == "unit"
    growth = one.tcp["z"]["growth"].to_plain()
    assert (growth["of"], growth["length"], growth["expansion"]) == ("unit", "0.5 m", "1.1e-05 1/K")


def test_streams_pass_a_merged_part_once(tmp_path: Path) -> None:
    stream = "  stream: {kind: advection, through: [ambient, shaft, housing, ambient], capacity_flow: 9 W/K}\nsources:"
    one = Machine.load(files(tmp_path, bench=edited("sources:", stream) + LEVELS), level="one")
    assert [str(place) for place in one.links["stream"].through] == ["ambient", "unit", "ambient"]


@pytest.mark.parametrize(
    ("level", "message"),
    [
        ("few", "25: merge.unit is not a list of different nodes; write `merge: {new name: [node, node]}`"),
        ("held", "26: merge.unit: 'ambient' is no part of the machine; known are: shaft, housing"),
        ("list", "27: merge is not a mapping; write `merge: {new name: [node, node]}`"),
        ("taken", "28: merge.ambient: there is another node 'ambient'; give the merged part a name of its own"),
        ("twice", "29: merge.other: 'shaft' is no part of the machine; known are: unit"),
        ("mass", "30: 'shaft' is not a bar; known are: housing"),
        ("typo", "31: links.skan is removed, and it is not there; did you mean 'skin'?"),
    ],
)
def test_refused_levels(level: str, message: str, tmp_path: Path) -> None:
    assert refused(files(tmp_path, bench=BENCH + LEVELS), level=level) == f"bench.yaml:{message}"


def test_an_unknown_level_is_answered_with_the_likely_one(tmp_path: Path) -> None:
    told = refused(files(tmp_path, bench=BENCH + LEVELS), level="fin")
    assert told == "bench.yaml: there is no level 'fin'; did you mean 'fine'?"


# -- from Python, and back to a file --------------------------------------------------------------------------------
def test_patched_from_python_leaves_the_machine_as_it_was(tmp_path: Path) -> None:
    machine = Machine.load(files(tmp_path, bench=BENCH))
    skin = {"kind": "convection", "between": ["housing", "ambient"], "conductance": "7.25 W/K"}
    patched = machine.patched({"links": {"skin": skin, "bearing": None}, "nodes": {"housing": {**bar(), "lumps": 3}}})
    assert (list(patched.links), list(machine.links)) == (["skin"], ["bearing", "skin"])
    assert patched.links["skin"].numbers["conductance"].value == 7.25 and patched.nodes["housing"].lumps == 3
    with pytest.raises(Refused) as caught:
        machine.patched({"links": {"skin": {**skin, "between": ["housing"]}}}, "finding")
    assert str(caught.value) == "finding: links.skin: between has 1 places; give 2 places, as in [a, b]"


def bar() -> dict[str, object]:
    return {"material": "iron", "length": "500 mm", "area": "200 cm^2"}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_machine_written_and_read_again_is_the_same(path: Path, tmp_path: Path) -> None:
    machine = Machine.load(path)
    again = Machine.load(files(tmp_path, again=dump(machine.to_plain())))
    tree = tree_of(machine.to_plain(), Spot("again"))
    assert isinstance(tree, Branch)
    for other in (again, Machine.read(tree, "again")):
        assert dict(other.entries()) == dict(machine.entries())
        assert (other.name, other.reference, other.uncertain) == (machine.name, machine.reference, machine.uncertain)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_an_entry_written_and_read_again_is_the_same(path: Path) -> None:
    machine = Machine.load(path)
    sections: dict[str, dict[str, object]] = {}
    for where, entry in machine.entries():
        if not (where.axis or where.inner):
            sections.setdefault(entry.section, {})[entry.name] = entry.to_plain()
    again = machine.patched(sections)
    assert dict(again.entries()) == dict(machine.entries())


# -- one entry more -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_machine_with_an_entry_more_is_the_one_that_is_read_as_a_whole(path: Path) -> None:
    machine = Machine.load(path)
    patches = [patch for kind in kinds() for patch in islice(kind.proposes(machine), 2)]
    for patch in patches:
        try:
            patched = machine.patched(patch)
        except Refused as refused:
            assert str(refused)
            continue
        whole = Machine.read(patched.tree, machine.file)
        assert [*patched.by_path] == [*whole.by_path] and patched.by_path == whole.by_path
        assert (patched.inputs, patched.warnings) == (whole.inputs, whole.warnings)


def test_an_entry_more_counts_beside_those_that_are_there(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine.load(next(path for path in SHIPPED if path.stem == "vertical_mill"))
    ends = sorted((n for n, node in machine.nodes.items() if node.is_part), key=lambda n: -machine.nodes[n].lumps)[:2]
    body = {"kind": "conduction", "between": ends, "conductance": "5 W/K"}
    pairs, more = count_tables(machine).pairs, machine.nodes[ends[0]].lumps * machine.nodes[ends[1]].lumps
    monkeypatch.setattr("network.machine.size_checks.MOST_PAIRS", pairs + more)
    assert count_tables(machine.patched({"links": {"more": body}})).pairs == pairs + more
    monkeypatch.setattr("network.machine.size_checks.MOST_PAIRS", pairs + more - 1)
    with pytest.raises(Refused, match="pairs of lumps"):
        machine.patched({"links": {"more": body}})


def test_what_an_entry_more_leaves_wrong_is_refused_as_in_the_whole_file(tmp_path: Path) -> None:
    machine = Machine.load(files(tmp_path, bench=BENCH))
    same = {"kind": "conduction", "between": ["housing", "housing"], "conductance": "5 W/K"}
    nowhere = {"kind": "conduction", "between": ["housing", "attic"], "conductance": "5 W/K"}
    for body, wrong in ((same, "joins housing with itself"), (nowhere, "there is no node 'attic'")):
        with pytest.raises(Refused, match=wrong):
            machine.patched({"links": {"more": body}})


def test_two_findings_with_one_number_cannot_be_laid_one_over_the_other(tmp_path: Path) -> None:
    machine = Machine.load(files(tmp_path, bench=BENCH))
    faults = [c for c in candidates(machine, machine.inputs) if c.kind.kind == "sensor_fault"]
    assert faults and lay_over(machine, faults[:1]) is not None
    assert lay_over(machine, [faults[0], faults[0]]) is None
