"""What finer lumps would change, how many are enough, and what is nothing because a part is one lump."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine

from network import Machine, Refused, Scenario, choose_lumps, estimate_lumping, simulate, superpose
from network.analysis.sweep.finer_lumps import bars_of, cut_bars, moving_mean
from network.analysis.sweep.lumping_error import cut_finely
from network.analysis.sweep.usual_program import usual_program
from network.cli import main

ROOT = Path(__file__).parents[1]
GANTRY, WARM = ROOT / "machines" / "gantry_spindle.yaml", ROOT / "scenarios" / "warm_up_and_stop.yaml"
HEAT = ROOT / "scenarios" / "bearing_warms.yaml"
POOR = """
machine: A bar that is cooled at its far end, better than its file says
reference: 20 degC
nodes:
  bar: {material: aluminium, length: 400 mm, area: 100 cm^2}
  air: {temperature: 20 degC}
links: {skin: {kind: convection, between: [bar@0.9..1, air], conductance: 0.3 W/K ± 200 %}}
sources: {heater: {kind: heat_source, into: {bar@0..0.1: 1}, power: 50 W}}
tcp: {z: {grows: {kind: stretching, of: bar, direction: 1}}}
sensors: {T: {measures: bar@0.05, noise: 0.05 K}, dz: {measures: tcp.z, noise: 0.3 um}}
"""
CHILLED, SHIFT = ROOT / "machines" / "chilled_spindle.yaml", ROOT / "scenarios" / "shift_at_one_speed.yaml"


def two_bars(**changes: Any) -> Machine:
    """A long bar heated at its far end, which grows along z, beside a short one heated evenly, along y."""
    bar = {"material": "steel", "length": "800 mm", "area": "20 cm^2"}
    nodes = {"long": bar, "short": bar | {"length": "20 mm", "area": "200 cm^2"}, "air": {"temperature": "20 degC"}}
    return machine(
        nodes,
        links={"skin": {"kind": "convection", "between": ["long@0.9..1", "air"], "conductance": "20 W/K"},
               "film": {"kind": "convection", "between": ["short", "air"], "conductance": "2 W/K"}},
        sources={"heater": {"kind": "heat_source", "into": {"long@0..0.1": 0.6, "short": 0.4}, "power": "50 W"}},
        tcp={"z": {"grows": {"kind": "stretching", "of": "long@0..0.5", "direction": 1}},
             "y": {"swells": {"kind": "stretching", "of": "short", "direction": 1}}},
        **changes,
    )  # fmt: skip


HOURS = Scenario.of("two hours", "2 h", output="20 s")


# -- the error ------------------------------------------------------------------------------------------------------
def test_what_finer_lumps_change_is_what_they_change() -> None:
    """Against a mesh of 128: the estimate finds the error of one lump to a few percent."""
    coarse, fine = two_bars(), cut_bars(two_bars(), {"long": 128})
    found = estimate_lumping(coarse, HOURS)
    assert found is not None
    runs = [simulate(m, HOURS).tcp["z"] for m in (coarse, fine)]
    off = runs[1] - runs[0]
    truth = float(off[int(np.argmax(np.abs(off)))])
    told = {change.name: change for change in found.changes}
    assert told["z"].largest == pytest.approx(truth, rel=0.03)
    assert told["y"].share < 0.001 and not found.is_within
    assert found.summary()["channels"]["z"]["max"] == pytest.approx(truth * 1e6, rel=0.03)


def test_bars_that_need_lumps_are_named() -> None:
    found = estimate_lumping(two_bars(), HOURS)
    assert found is not None and found.choice is not None
    assert found.choice.lumps["long"] > 1 == found.choice.lumps["short"]
    assert "Within 2 % of every range: long " in str(found) and "the others are fine" in str(found)


def test_masses_have_no_lumps_to_speak_of() -> None:
    masses = machine({"a": {"heat_capacity": "1 kJ/K"}, "air": {"temperature": "20 degC"}},
                     links={"l": {"kind": "convection", "between": ["a", "air"], "conductance": "1 W/K"}})  # fmt: skip
    assert cut_finely(masses) is None and estimate_lumping(masses, HOURS) is None
    with pytest.raises(Refused, match="has no bar to cut"):
        choose_lumps(masses, HOURS)


# -- the choice -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("share", [0.05, 0.02, 0.005])
def test_chosen_lumps_keep_the_tolerance_on_a_mesh_that_they_have_not_seen(share: float) -> None:
    choice = choose_lumps(two_bars(), HOURS, share=share)
    chosen, fine = simulate(choice.machine, HOURS), simulate(cut_bars(two_bars(), {"long": 200, "short": 50}), HOURS)
    for axis in ("y", "z"):
        assert np.abs(chosen.tcp[axis] - fine.tcp[axis]).max() < 1.5 * share * np.ptp(fine.tcp[axis])
    assert choice.is_within and choice.is_settled
    halved = {name: max(count // 2, 1) for name, count in choice.lumps.items()}
    coarser = simulate(cut_bars(two_bars(), halved), HOURS)
    assert np.abs(coarser.tcp["z"] - fine.tcp["z"]).max() > share * np.ptp(fine.tcp["z"])  # no lump too many


def test_fewer_lumps_than_a_fine_level_and_as_good() -> None:
    gantry, warm = Machine.load(GANTRY), Scenario.load(WARM)
    choice = choose_lumps(gantry, warm)
    assert choice.machine.lumps < Machine.load(GANTRY, level="fine").lumps
    assert choice.lumps["table"] == 4, "what bends stays as it is written"
    assert [choice.machine.nodes[name].lumps for name in choice.lumps] == list(choice.lumps.values())
    error = estimate_lumping(choice.machine, warm)
    assert error is not None and error.is_within


def test_bars_that_are_to_stay_do() -> None:
    choice = choose_lumps(two_bars(), HOURS, keep=["long"])
    assert choice.lumps == {"long": 1, "short": 1}


def test_swings_of_a_relay_are_averaged() -> None:
    """Two runs out of step by a little are not told apart by what each swing is off."""
    t = np.arange(4000.0)
    late = np.sign(np.sin(t / 40)) - np.sign(np.sin((t - 3) / 40))
    assert np.abs(moving_mean(late, 251)).max() < 0.05 * np.abs(late).max()
    choice = choose_lumps(Machine.load(CHILLED), Scenario.load(SHIFT))
    assert choice.is_settled and choice.is_within


def test_a_schedule_is_made_where_none_is_given() -> None:
    chilled = Machine.load(CHILLED)
    program = usual_program(chilled)
    assert set(program.schedule.signals) == set(chilled.inputs) and 4 <= program.duration / 3600 <= 24
    assert simulate(chilled, program).switches


# -- commands -------------------------------------------------------------------------------------------------------
def run(*words: object, capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    try:
        main([str(word) for word in words])
    except SystemExit as left:
        assert left.code in (0, 2)
    out = capsys.readouterr()
    return out.out, out.err


def test_simulate_tells_what_lumps_cost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = run("simulate", GANTRY, WARM, "-o", tmp_path, "--no-plots", capsys=capsys)
    assert "Lumps: with 16 in every bar, z would be up to 13.7 µm higher (20 % of its range)" in out and not err
    told = json.loads((tmp_path / "summary.json").read_text())["lumping"]
    assert told["channels"]["z"]["max"] == pytest.approx(13.7, rel=0.01) and not told["within"]
    assert set(told["needed"]) == set(bars_of(Machine.load(GANTRY)))


@pytest.mark.parametrize(
    "words",
    [
        ("iso230", GANTRY, "spindle_constant", "--top", "speed=8000 rpm"),
        ("warmup", GANTRY, WARM, "--tolerance", "9 um", "--speeds", "8000 rpm", "--longest", "20 min"),
        ("export", GANTRY, WARM, "--as", "c", "--states", "2"),
        ("export", GANTRY, WARM, "--as", "table"),
    ],
)
def test_every_command_that_tells_micrometres_tells_what_lumps_cost(
    words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, _ = run(*words, "-o", tmp_path, capsys=capsys)
    assert "Lumps: with 16 in every bar, z would be up to 1" in out.replace("up to 7.", "up to 1")
    assert "`--lumps auto` chooses" in out
    told = json.loads(run(*words, "-o", tmp_path, "--json", capsys=capsys)[0])["lumping"]
    assert told["channels"]["z"]["max"] > 5 and not told["within"]
    if words[0] == "iso230":
        assert "Lumps: with 16 in every bar" in (tmp_path / "report.html").read_text()
        assert "`--lumps auto`" not in run(*words, "-o", tmp_path, "--lumps", "auto", capsys=capsys)[0]


def test_the_page_of_a_run_tells_what_lumps_cost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("simulate", GANTRY, WARM, "-o", tmp_path, "--no-plots", "--page", capsys=capsys)
    assert "Lumps: with 16 in every bar, z would be up to 13.7 µm higher" in (tmp_path / "report.html").read_text()


def test_lumps_are_chosen_again_with_the_numbers_that_are_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bar that is cooled at its end better than its file says is steeper, and asks for more lumps."""
    (tmp_path / "m.yaml").write_text(POOR, encoding="utf-8")
    made = ("simulate", tmp_path / "m.yaml", HEAT, "-o", tmp_path, "--no-plots", "--noise", "--lumps", "32")
    run(*made, "--set", "links.skin.conductance=20 W/K", capsys=capsys)
    words = ("calibrate", tmp_path / "m.yaml", tmp_path / "results.csv", "-o", tmp_path / "c", "--no-plots")
    out, err = run(*words, "--lumps", "auto", capsys=capsys)
    assert "With the numbers found: Lumps: " in err and "alibrate with it" not in out and "`--lumps auto`" not in out
    out, err = run(*words, "--lumps", "2", capsys=capsys)
    assert "Calibrate with it." in out and "With the numbers" not in err


def test_what_cancels_asks_for_no_lumps() -> None:
    """Two equal columns tilt nothing: what rounding leaves of that is no range to keep a share of, nor a movement."""
    bar = {"material": "steel", "length": "400 mm", "area": "20 cm^2"}
    twins = machine(
        {"left": bar, "right": bar, "air": {"temperature": "20 degC"}},
        links={f"{n} skin": {"kind": "convection", "between": [f"{n}@0.8..1", "air"], "conductance": "5 W/K"}
               for n in ("left", "right")},
        sources={"heater": {"kind": "heat_source", "into": {"left@0..0.2": 0.5, "right@0..0.2": 0.5}, "power": "60 W"}},
        tcp={"z": {"grows": {"kind": "stretching", "of": "left", "direction": 1}},
             "b": {"tilts": {"kind": "tilt", "between": ["left", "right"], "distance": "1 m", "direction": 1}}},
    )  # fmt: skip
    choice = choose_lumps(twins, HOURS)
    assert choice.is_settled and max(choice.lumps.values()) < 32
    run = simulate(cut_bars(twins, {"left": 7, "right": 7}), HOURS)
    assert np.ptp(run.tcp["b"]) < 1e-12
    told = str(superpose(run)) + str(run) + str(estimate_lumping(twins, HOURS))
    assert "Nothing turns the tool centre point about b." in told and "nothing\n" in told and "0.0000" not in told
    assert "b would not change" in told
    uneven = estimate_lumping(cut_bars(twins, {"right": 4}), HOURS)
    assert uneven is not None and "(it stands still then)" in str(uneven)


def test_a_tolerance_is_told_as_it_was_given() -> None:
    assert "within 10 % or" in str(choose_lumps(two_bars(), HOURS, share=0.1))
    assert "within 0.5 % or" in str(choose_lumps(two_bars(), HOURS, share=0.005))


def test_what_is_not_settled_says_what_was_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many bars leave no room for a finer run: what the last doubling that was tried changed decides, and is told."""
    monkeypatch.setattr("network.analysis.sweep.lump_choice.MOST", 40)
    assert choose_lumps(two_bars(), HOURS, share=0.05).is_settled
    choice = choose_lumps(two_bars(), HOURS, share=0.0005)
    assert choice.still is not None and not choice.is_settled
    told = str(choice)
    assert "the last doubling, to 16 in every bar, still changed" in told and "no finer ones are tried" in told


def test_auto_is_told_and_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = "simulate", GANTRY, WARM, "-o", tmp_path, "--no-plots", "--json", "--lumps"
    out, err = run(*words, "auto", "--lumps", "table=2", capsys=capsys)
    assert err.startswith("Lumps: shaft ") and "table 2 (" in err
    assert json.loads(out)["lumping"]["within"]


@pytest.mark.parametrize(
    ("wishes", "said"),
    [
        (["auto", "3"], "asks for `auto` and for one number in every bar"),
        (["auto", "auto:1 %"], "asks for `auto` twice"),
        (["auto:2 um"], "'2 um' is no tolerance; write `--lumps auto`, or a share"),
    ],
)
def test_wishes_that_cannot_be(wishes: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said in run("check", GANTRY, *(w for wish in wishes for w in ("--lumps", wish)), capsys=capsys)[1]


def test_numbers_that_are_unknown_do_not_keep_lumps_from_being_chosen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They count as in the middle of their range, and stay unknown."""
    words = "check", GANTRY, "--set", "links.flange.conductance=unknown 20..80 W/K", "--lumps", "auto", "--json"
    out, err = run(*words, capsys=capsys)
    assert "No schedule is given: along a warm-up and rest." in err
    told = json.loads(out)
    assert told["uncertain"]["links.flange.conductance"]["prior"] == "unknown" and told["nodes"]["housing"]["lumps"] > 1


def test_python_is_told_how() -> None:
    with pytest.raises(Refused, match=r"choose_lumps\(machine, scenario\)\.machine"):
        Machine.load(GANTRY, lumps=["auto"])


# -- what is nothing by structure -----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("lumps", "entry", "doubted"),
    [
        (1, {"kind": "bending", "of": "column", "length": "1 m"}, True),
        (2, {"kind": "bending", "of": "column", "length": "1 m"}, False),
        (2, {"kind": "bending", "of": "column@0..0.4", "length": "1 m"}, True),
        (1, {"kind": "bending", "of": "column", "length": "1 m", "method": "paper"}, False),
        (4, {"kind": "bending", "between": ["column@0.3", "column@0.4"], "distance": "30 mm", "length": "1 m"}, True),
        (4, {"kind": "bending", "between": ["column@0.9", "column@0.1"], "distance": "240 mm", "length": "1 m"}, False),
        (1, {"kind": "tilt", "between": ["column@0.1", "column@0.9"], "distance": "1 m", "length": "1 m", "arm": "1 m"},
         True),
    ],
)  # fmt: skip
def test_what_reads_one_lump_is_doubted(lumps: int, entry: dict[str, Any], doubted: bool) -> None:
    """And is nothing indeed, whatever the column's temperatures."""
    made = machine(
        {"column": {"material": "cast_iron", "length": "300 mm", "area": "0.2 m^2", "lumps": lumps},
         "air": {"temperature": "20 degC"}},
        links={"skin": {"kind": "convection", "between": ["column@0.9..1", "air"], "conductance": "20 W/K"}},
        sources={"sun": {"kind": "heat_source", "into": {"column@0..0.1": 1}, "power": "500 W"}},
        tcp={"y": {"bends": entry | {"direction": 1}}},
    )  # fmt: skip
    assert any("is 0 whatever happens" in str(warning) for warning in made.warnings) == doubted
    assert (np.abs(simulate(made, HOURS).tcp["y"]).max() < 1e-15) == doubted
