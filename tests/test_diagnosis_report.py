"""What a diagnosis leaves: words, files, page and pictures, from diagnoses made by hand."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from diagnosed import diagnosed, finding, rival, saved, unknown_heat
from matplotlib.figure import Figure

from network import Machine, Scenario, compare, simulate
from network.analysis.comparison.compare import Comparison
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.experiments.experiment import Experiment
from network.analysis.diagnosis.experiments.programs import programs
from network.analysis.diagnosis.findings.finding import UNKNOWN, Quantity
from network.analysis.diagnosis.findings.findings import why_not
from network.analysis.diagnosis.findings.isolability import DETAILS
from network.analysis.diagnosis.findings.result import Diagnosis, Fits
from network.analysis.diagnosis.findings.unnamed_findings import size_of_unknown
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.screening.screened_gain import ScreenedGain
from network.platform.quantities.text_table import digits
from network.platform.refusal import Refused
from network.recordings.inputs import Start, hold
from network.report.figures.explanations_figure import candidates_figure
from network.report.figures.fit_figure import fit_figure
from network.report.figures.gains_figure import gains_figure
from network.report.figures.heat_figure import heat_figure, order_inputs
from network.report.figures.lit_figure import lit_figure, lit_paths, moves_of
from network.report.files.diagnosis_files import check_target, write_diagnosis
from network.report.files.diagnosis_patch import patch_text
from network.report.files.diagnosis_pictures import pictures_of
from network.report.files.page import basis, is_tall
from network.report.files.result_files import tidy
from network.report.words import moved_words
from network.report.words.diagnosis_words import fit_rows
from network.report.words.effect_words import effect_summary, movements
from network.report.words.finding_words import plus_minus, sure_word, sure_words
from network.report.words.heat_words import course
from network.report.words.moved_words import Moved, list_moved
from network.report.words.tie_words import title_words
from network.report.words.verdict_words import MEANING

ROOT = Path(__file__).parent.parent
DESIGN = {
    "findings": {"kind", "section", "places", "channels", "confidence", "parameters", "alternatives",
                 "indistinguishable", "sentence", "patch", "evidence"},
    "evidence": {"delta_log_evidence", "threshold", "windows"},
}  # fmt: skip


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return diagnosed(tmp_path_factory.mktemp("machine"))


@pytest.fixture(scope="module")
def folder(found: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("out")
    write_diagnosis(found, where)
    return where


def flat(text: str) -> str:
    return " ".join(text.split())


# -- words ----------------------------------------------------------------------------------------------------------
def test_the_words_tell_what_where_how_sure_and_against_what(found: Diagnosis) -> None:
    told = flat(str(found))
    assert "test lacks one effect that its recordings show at body." in told
    assert "conductance 6.10 ± 0.20 W/K" in told and "probable, 93 %" in told
    assert "It stands out by 29 σ; chance alone may reach 4.3 σ." in told and "nats" not in told
    assert "radiation (body, air), 5 %: fits 3.3 times worse" in told
    assert "links.skin.conductance from +2.5 to +0.0" in told
    assert "If one unknown" not in told and "more heat than" not in told
    assert "train1: 3 readings of T_body are outliers" in told
    assert "It would tell convection from radiation by 6.1 σ in 42 min." in told
    before, after = found.fits.train_before.rmse_in_noise, found.fits.train_after.rmse_in_noise
    assert f"falls from {before:.1f} to {after:.3f} noise units" in told
    assert "on holdout.csv, never used in a fit" in told


def unnamed(d: Diagnosis, *places: str) -> Diagnosis:
    """The same where what was found at those places has no name."""
    nameless = finding(kind=UNKNOWN, places=places or ("body",), patch={}, parameters={})
    return replace(d, verdict="unexplained", findings=(nameless,))


def test_unknown_heat_is_told_with_its_sign_its_time_and_its_bursts(found: Diagnosis) -> None:
    told = flat(str(unnamed(found)))
    assert "it would be heat in body (81 %), or heat from motor to body (12 %), or an offset of T_body (4.0 %)." in told
    right = "of train1.csv body gets on average 155 W less heat than the model gives it, in 4 bursts of about 310 W."
    assert f"Between 45 and 140 min {right}" in told


def test_a_course_that_never_leaves_its_uncertainty_is_none() -> None:
    t = np.linspace(0, 3600, 20)
    assert course(t, np.full(20, 5.0), np.full(20, 4.0)) is None
    steady = course(t, np.full(20, 50.0), np.full(20, 4.0))
    assert steady is not None and steady.bursts == 0 and steady.mean == pytest.approx(50)
    swings = course(t, 50 * np.sin(t / 300), np.full(20, 4.0))
    assert swings is not None and not swings.is_one_way


def test_it_is_told_when_the_map_of_unknown_heat_points_elsewhere(found: Diagnosis) -> None:
    assert "explains the recordings better" not in flat(str(unnamed(found)))
    assert "explains the recordings better" in flat(str(unnamed(found, "motor")))
    probe = unknown_heat(Location(channel="dz"), 0.9, 2, 2e-6)
    told = flat(str(replace(unnamed(found, "tcp.z", "motor"), located=(probe, *found.located))))
    assert "explains the recordings better" not in told and "dz reads on average 1.0 µm higher than the model" in told
    named = replace(found, findings=(finding(places=("tcp.z", "motor")),))
    assert "show at motor (movement along z)." in flat(str(named))


@pytest.mark.parametrize(("at", "size", "told"), [
    (Location(("motor", "body")), 92.0, "46 W more flow from motor to body than in the model"),
    (Location(channel="T_body"), 0.6, "T_body reads on average 0.30 K higher than the model"),
])  # fmt: skip
def test_unknown_heat_of_links_and_channels(found: Diagnosis, at: Location, size: float, told: str) -> None:
    heat = unknown_heat(at, 0.9, 2, size)
    assert told in flat(str(replace(unnamed(found), located=(heat,))))


@pytest.mark.parametrize(("at", "size", "told"), [
    (Location(("body",)), 92.0, ("heat", "W", 1.0)),
    (Location(channel="T_body"), 0.6, ("offset", "K", 1.0)),
    (Location(channel="dz"), 2e-6, ("offset", "um", 1e6)),
])  # fmt: skip
def test_the_size_of_what_is_unknown_is_in_the_unit_of_its_place(
    found: Diagnosis, at: Location, size: float, told: tuple[str, str, float]
) -> None:
    unknown = unknown_heat(at, 0.9, 2, size)
    name, quantity = size_of_unknown(found.machine, unknown)
    summary = quantity.summary()
    assert (name, summary["unit"]) == told[:2]
    assert summary["value"] == pytest.approx(unknown.rms * told[2])
    assert summary["std"] == pytest.approx(told[2] * size / 10)


def test_what_sits_in_a_channel_is_no_heat(found: Diagnosis) -> None:
    sensor = replace(finding(kind=UNKNOWN, patch={}, parameters={}), places=(), channels=("dz",))
    told = flat(str(replace(found, verdict="unexplained", findings=(sensor,))))
    assert "Check that sensor and what it is fixed to first" in told and "where heat or movement" not in told
    assert "where heat or movement is unaccounted for" in flat(str(unnamed(found)))


@pytest.mark.parametrize(("verdict", "findings", "words"), [
    ("adequate", (), "is what noise leaves. No physics is missing that these recordings would show."),
    ("parameters_only", (), "Only numbers of test were wrong."),
    ("too_coarse", ("lumping",), "test is cut too coarsely at body. With more lumps there"),
    ("missing_physics", ("convection", "windage"), "test lacks two effects that its recordings show at body"),
    ("sensor_fault", ("sensor_lag",), "The physics of test holds; T_body does not read true."),
    ("unexplained", (UNKNOWN,), "differ at body, and nothing in the catalogue explains it: after all that was tried"),
])  # fmt: skip
def test_every_verdict_says_plainly_what_it_means(
    found: Diagnosis, verdict: str, findings: tuple[str, ...], words: str
) -> None:
    several = tuple(
        finding(kind=kind, patch={}, parameters={}, places=() if "sensor" in kind else ("body",),
                channels=("T_body",) if "sensor" in kind else ())
        for kind in findings
    )  # fmt: skip
    told = flat(str(replace(found, verdict=verdict, findings=several)))
    assert words in told and ("If one unknown were" in told) == (verdict == "unexplained")
    assert verdict in MEANING


@pytest.mark.parametrize(("shift", "words"), [
    (2.5, "Only numbers of test were wrong."),
    (-3.5, "For that links.skin.conductance must lie more than 3 times its ± from the file: either the file is"),
])  # fmt: skip
def test_numbers_far_from_the_file_may_stand_for_what_is_missing(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch, shift: float, words: str
) -> None:
    moved = Moved("links.skin.conductance", "5 W/K", "5 W/K", "9 W/K", 0.0, shift)
    monkeypatch.setattr(moved_words, "list_moved", lambda d: [moved])
    told = flat(str(replace(found, verdict="parameters_only", findings=())))
    assert words in told and ("no physics is missing" in told) == (abs(shift) < 3)
    assert ("Measure these numbers before you use them" in told) == (abs(shift) > 3)


def test_a_held_out_run_that_is_not_explained_is_told_of_a_clean_verdict(found: Diagnosis) -> None:
    told = flat(str(replace(found, verdict="parameters_only", findings=())))
    assert "But it leaves" not in told and found.fits.holdout_before is not None
    off = replace(found.fits, holdout_after=found.fits.holdout_before)
    told = flat(str(replace(found, verdict="parameters_only", findings=(), fits=off)))
    assert f"But it leaves {found.fits.holdout_before.rmse_in_noise:#.3g} σ of" in told
    assert "never used in a fit: that run differs" in told


@pytest.mark.parametrize("holdout", [True, False])
def test_the_share_that_is_explained_says_on_what_it_was_tested(found: Diagnosis, holdout: bool) -> None:
    left, held = found.fits.train_before, found.fits.holdout_after if holdout else None
    fits = replace(found.fits, train_after=left, holdout_before=held, holdout_after=held)
    told = flat(str(replace(found, explained=0.62, fits=fits)))
    assert "a part of the truth, 62 % of what was unexplained on the fitted runs, each told by the others: " in told
    single = replace(fits, train_after=replace(left, recordings=left.recordings[:1]))
    told = flat(str(replace(found, explained=0.62, fits=single)))
    assert "62 % of what was unexplained in the end of the run, told from its beginning: " in told
    assert "unseen" not in told


def test_what_cannot_be_told_apart_is_told(found: Diagnosis) -> None:
    alike = finding(indistinguishable=(rival("radiation", "body", 0.4, 1.0, 410.0),))
    assert "These recordings cannot tell it from radiation (body)." in flat(str(replace(found, findings=(alike,))))


def test_what_is_as_likely_shares_the_headline(found: Diagnosis) -> None:
    place = rival("convection", "motor air", 0.4, 1.0, 410.0)
    tie = replace(found, findings=(finding(confidence=0.56, alternatives=(place,)),))
    assert "that its recordings show at body or motor." in flat(str(tie))
    kind = rival("radiation", "body air", 0.4, 1.0, 410.0)
    either = finding(confidence=0.5, alternatives=(), indistinguishable=(kind,))
    assert title_words(found, finding()) == "convection at body"
    assert title_words(tie, tie.findings[0]) == "convection at body or motor"
    assert title_words(found, either) == "convection or radiation at body"
    both = finding(confidence=0.5, alternatives=(), indistinguishable=(replace(kind, places=("motor", "air")),))
    assert title_words(found, both) == "convection at body or radiation at motor"


def test_what_it_does_to_the_tool_is_told_in_micrometres(found: Diagnosis) -> None:
    """Beside a simulation of the better machine with and without its entry."""
    residual = found.fits.train_after.recordings[0]
    there, gone = (simulate(m, residual.trajectory.schedule, start=Start(others=20.0))
                   for m in (found.after, found.after.patched({"links": {"wet side": None}})))  # fmt: skip
    assert there.T_start == pytest.approx(residual.trajectory.T_start)
    apart = there.shown("tcp.z") - gone.shown("tcp.z")
    most = apart[np.argmax(np.abs(apart))]
    assert movements(found, 0)["z"] == pytest.approx(most * 1e-6) and abs(most) > 1
    told = f"{'−' if most < 0 else '+'}{digits(abs(most), 2)} µm along z"
    assert f"It moves the tool centre point by up to {told} on train1.csv." in flat(str(found))
    assert effect_summary(found, 0)["z"] == {"value": pytest.approx(most), "unit": "um"}


def test_a_sensor_moves_nothing(found: Diagnosis) -> None:
    lag = finding(kind="sensor_lag", section="sensors", places=(), channels=("T_body",), patch={"sensors": {}})
    assert "moves the tool" not in str(replace(found, findings=(lag,)))


def test_a_search_that_was_cut_short_does_not_call_the_machine_complete(found: Diagnosis) -> None:
    cut = flat(str(replace(found, verdict="parameters_only", findings=(), ended="budget")))
    assert "nothing was found so far that it lacks" in cut and "The time was up" in cut
    assert "no physics is missing" not in cut and "Use the calibrated numbers" not in cut


def test_the_next_experiment_is_a_scenario_that_runs(found: Diagnosis, tmp_path: Path) -> None:
    runs = [r.recording for r in found.fits.train_after.recordings]
    made = programs([found.machine], runs)
    switching = next(p for p in made if p.text.startswith("Switch"))
    steps = Experiment(switching.text, ("convection", "radiation"), 6.1, switching.hours, switching.scenario())
    d = replace(found, advice=(steps,))
    write_diagnosis(d, tmp_path / "out", pictures=False)
    assert [p.name for p in (tmp_path / "out").glob("*.yaml")] == ["machine.diagnosed.yaml"]
    written = Scenario.load(tmp_path / "out" / "experiment-1.yml")
    assert written.duration == pytest.approx(3600 * switching.hours, rel=1e-4)
    t = np.arange(30.0, written.duration, 60.0)
    for name, signal in switching.signals.items():
        assert written.schedule.signals[name].at(t) == pytest.approx(signal.at(t), rel=1e-3, abs=1e-3)
    assert simulate(d.after, written).t[-1] == pytest.approx(written.duration)
    told = flat(str(d))
    assert "It is written as experiment-1.yml." in told and "min in turn" not in told and "in holds of" in told
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text())["advice"][0]["scenario"] == "experiment-1.yml"


def test_one_number_has_one_word_and_more_is_never_less_sure() -> None:
    words = list(dict.fromkeys(sure_word(p / 1000) for p in range(1001)))
    assert words == ["doubtful", "an even chance", "more likely than not", "probable", "nearly certain"]
    assert all(sure_word(p) == sure_word(float(f"{100 * p:.0f}") / 100) for p in np.linspace(0, 1, 777))
    assert "likely" not in sure_word(0.5)
    alike = finding(confidence=0.504, indistinguishable=(rival("foundation", "beam", 0.493, 1.0, 410.0),))
    assert sure_words(alike) == "50 %: as likely as foundation (beam)"
    behind = replace(alike, confidence=0.7, indistinguishable=(rival("foundation", "beam", 0.25, 1.0, 410.0),))
    assert sure_words(behind) == "70 %, beside 25 % for foundation (beam)"
    half = replace(alike, confidence=0.25, share=0.5, holds=0.5)
    assert sure_words(half) == "25 %: as likely as foundation (beam)"
    assert half.summary()["indistinguishable"][0]["confidence"] == pytest.approx(0.2465)
    assert [half.confidence_of(r) for r in half.alternatives] == pytest.approx([0.025, 0.005])
    assert replace(half, holds=None).confidence_of(half.alternatives[0]) == 0.05
    assert replace(half, share=0.1).confidence_of(half.alternatives[0]) == 0.05


@pytest.mark.parametrize(("chi", "shift", "told"), [
    (3.54, 8.2, "fits 3.7 times worse, and moves a number of the file by 8 times its ±"),
    (1.07, 0.0, "fits 13 % worse"), (0.953, 0.0, "fits nearly as well"),
])  # fmt: skip
def test_a_rival_is_told_relative_to_what_was_found(chi: float, shift: float, told: str) -> None:
    """Its misfit is another measure than the table's rmse."""
    other, best = (SimpleNamespace(chi=c, weighed=e, shift=np.array([shift])) for c, e in ((chi, 0.0), (0.95, 99.0)))
    assert why_not(other, best) == told  # type: ignore[arg-type]


def test_parts_that_need_more_lumps_are_told_together_and_all_of_them() -> None:
    nodes = {name: {"material": "steel", "lumps": n} for name, n in (("head", 10), ("beam", 10), ("rail", 20))}
    cut = finding(kind="lumping", parameters={}, patch={"nodes": nodes}, sentence="Head needs 10 lumps.")
    right = "Head and beam need 10 lumps each along their length; rail needs 20 lumps along its length."
    assert cut.whole_sentence == right == cut.summary()["sentence"]
    assert finding().whole_sentence == finding().sentence


def test_what_says_nothing_is_left_out(found: Diagnosis) -> None:
    always = finding(windows=((0.0, 4 * 3600.0),))
    still = unknown_heat(Location(("body",)), 0.9, 2, 0.0)
    told = flat(str(replace(found, findings=(always,), located=(still,))))
    assert "showed most" not in told
    twice = replace(found, findings=(finding(), finding(kind="windage", places=("motor",))))
    assert flat(str(twice)).count("It showed most") == 1
    vague = tuple(replace(u, at=Location(("motor",)), probability=0.1) for u in found.located)
    pointless = flat(str(replace(unnamed(found), located=vague)))
    assert "If one unknown" not in pointless and "motor gets" not in pointless
    long = replace(found, notes=(f"3 of 9 effects are too small to show here. {DETAILS} alike: tilt (3).",))
    assert "too small to show here." in flat(str(long)) and "alike: tilt" not in flat(str(long))


@pytest.mark.parametrize(("quantity", "told"), [
    (Quantity(790.0, 31.0, "W"), "790 ± 31 W"), (Quantity(0.79, 0.031, "1"), "0.790 ± 0.031"),
    (Quantity(21.4, 0.12, "degC"), "21.40 ± 0.12 °C"), (Quantity(0.7, 0.08, "K"), "0.700 ± 0.080 K"),
    (Quantity(5.2e4, 4e3, "kJ/K"), "52.0 ± 4.0 kJ/K"), (Quantity(3.0, 0.0, "1"), "3.000"),
    (Quantity(207908.0, 6855.0, "J/K"), "207.9 ± 6.9 kJ/K"), (Quantity(1e6, 1252999.0, "W/K"), "1.0 ± 1.3 MW/K"),
    (Quantity(8123.0, 1234.0, "W"), "8100 ± 1200 W"), (Quantity(-0.001, 0.31, "W"), "0.00 ± 0.31 W"),
    (Quantity(-4.1, 0.31, "W"), "−4.10 ± 0.31 W"),
])  # fmt: skip
def test_a_size_is_told_to_two_digits_of_its_error(quantity: Quantity, told: str) -> None:
    assert plus_minus(quantity) == told


def test_numbers_that_the_findings_replace_are_left_out_of_the_shifts(found: Diagnosis) -> None:
    assert next(m.path for m in list_moved(found)) == "links.skin.conductance"
    gone = replace(found, after=found.after.patched({"links": {"skin": None}}))
    assert "links.skin.conductance" not in [m.path for m in list_moved(gone)]


def test_recordings_of_one_file_name_are_told_with_their_folder(tmp_path: Path) -> None:
    d = diagnosed(tmp_path)
    fits, files = d.fits, iter(["one/results.csv", "three/log.csv", "two/results.csv"])

    def renamed(before: Comparison | None, after: Comparison | None) -> tuple[Comparison, Comparison]:
        assert before is not None and after is not None
        own = [next(files) for _ in after.recordings]
        sides = [[replace(r, recording=replace(r.recording, file=f)) for r, f in zip(side.recordings, own, strict=True)]
                 for side in (before, after)]  # fmt: skip
        return replace(before, recordings=tuple(sides[0])), replace(after, recordings=tuple(sides[1]))

    train, held = renamed(fits.train_before, fits.train_after), renamed(fits.holdout_before, fits.holdout_after)
    clashing = replace(d, fits=Fits(*train, *held))
    assert basis(clashing).startswith("Fitted on one/results.csv and log.csv; judged on two/results.csv.")
    told = flat(str(clashing))
    assert "on two/results.csv, never used" in told and "min of one/results.csv" in told
    assert "# Diagnosed by lptn on one/results.csv and log.csv" in patch_text(clashing, tmp_path)
    assert "one/results.csv" in words_of(heat_figure(clashing))
    assert any("two/results.csv" in picture.caption for picture in pictures_of(clashing))


# -- files ----------------------------------------------------------------------------------------------------------
def test_one_yaml_one_json_one_page_and_pictures(folder: Path) -> None:
    assert sorted(p.name for p in folder.iterdir()) == [
        "candidates.png", "diagnosis.json", "fit-train1.png", "fit-train2.png", "heat.png", "holdout-fit-holdout.png",
        "machine.diagnosed.yaml", "network.png", "report.html",
    ]  # fmt: skip


def test_the_json_has_the_keys_of_the_contract(folder: Path) -> None:
    told = json.loads((folder / "diagnosis.json").read_text())
    assert {"verdict", "findings", "located", "fit", "advice", "machine", "seconds"} <= set(told)
    assert DESIGN["findings"] <= set(told["findings"][0])
    assert DESIGN["evidence"] == set(told["findings"][0]["evidence"])
    assert told["findings"][0]["parameters"]["conductance"] == {"value": 6.1, "std": 0.2, "unit": "W/K"}
    assert set(told["findings"][0]["alternatives"][0]) >= {"kind", "places", "confidence"}
    assert set(told["located"]["nodes"][0]) == {"name", "probability", "heat_rms"}
    assert set(told["fit"]["holdout"]["before"]) >= {"rmse_in_noise", "channels"}
    assert set(told["advice"][0]) == {"experiment", "separates", "sigma", "hours"}
    assert told["machine"] == "machine.diagnosed.yaml"


def test_without_a_recording_held_out_it_is_null(tmp_path: Path) -> None:
    d = diagnosed(tmp_path, holdout=False)
    write_diagnosis(d, tmp_path / "out", pictures=False)
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text())["fit"]["holdout"] is None
    assert "held out" not in str(d) + (tmp_path / "out" / "report.html").read_text()


def test_the_patch_reads_back_and_reproduces_the_residual(tmp_path: Path) -> None:
    d = diagnosed(tmp_path)
    write_diagnosis(d, tmp_path / "out", pictures=False)
    text = (tmp_path / "out" / "machine.diagnosed.yaml").read_text()
    assert text.startswith("# Body loses heat to air over 6.1 W/K that is not in the file.\n")
    order = [text.index(word) for word in ("extends: ../blocks.yaml", "wet side", "# calibrated", "skin:")]
    assert order == sorted(order)
    machine = Machine.load(tmp_path / "out" / "machine.diagnosed.yaml")
    assert machine.to_plain() == d.after.to_plain()
    for residual in d.fits.train_after.recordings:
        again = compare(machine, residual.recording)
        assert again.rmse_in_noise == pytest.approx(residual.rmse_in_noise, rel=1e-9)


def test_a_patch_holds_axes_removals_and_what_options_changed(tmp_path: Path) -> None:
    saved(tmp_path)
    machine = Machine.load(tmp_path / "blocks.yaml", sets=["links.fins.conductance=5 W/K"])
    leans = {"kind": "stretching", "of": "motor", "length": "80 mm", "expansion": "1.1e-5 1/K", "direction": -1}
    grows = {**machine.to_plain()["tcp"]["z"]["grows"], "length": "310 mm ± 1 %"}
    patch = {"tcp": {"z": {"leans": leans}}, "links": {"flange": None}}
    after = machine.patched(patch).patched({"tcp": {"z": {"grows": grows}}})
    found = finding(kind="stretching", section="tcp", places=("tcp.z", "motor"), patch=patch)
    d = diagnosed(tmp_path, machine=machine, after=after, findings=(found,))
    write_diagnosis(d, tmp_path / "out", pictures=False)
    again = Machine.load(tmp_path / "out" / "machine.diagnosed.yaml")
    assert again.to_plain() == after.to_plain() and "flange" not in again.links
    text = (tmp_path / "out" / "machine.diagnosed.yaml").read_text()
    assert text.index("leans") < text.index("grows") and text.index("flange: null") < text.index("fins")


def test_whatever_the_catalogue_proposes_reads_back(found: Diagnosis, tmp_path: Path) -> None:
    machine = Machine.load(ROOT / "machines" / "chilled_spindle.yaml")
    first = {c.kind: c for c in candidates(machine, {*machine.inputs, "speed", "feed"})}
    assert len(first) > 15
    for c in first.values():
        several = replace(found, machine=machine, after=c.machine, findings=(finding(kind=c.kind.kind, patch=c.patch),))
        path = tmp_path / "machine.diagnosed.yaml"
        path.write_text(patch_text(several, tmp_path), encoding="utf-8")
        assert Machine.load(path).to_plain() == c.machine.to_plain(), c.name
        assert "extends:" in path.read_text(encoding="utf-8")


def test_a_machine_whose_file_is_gone_is_written_whole(tmp_path: Path) -> None:
    d = diagnosed(tmp_path)
    (tmp_path / "blocks.yaml").unlink()
    write_diagnosis(d, tmp_path / "out", pictures=False)
    again = Machine.load(tmp_path / "out" / "machine.diagnosed.yaml")
    assert again.to_plain() == d.after.to_plain()


def test_nothing_is_left_when_it_is_stopped(found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import network.report.figures.canvas as canvas

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(canvas, "save", stop)
    with pytest.raises(KeyboardInterrupt):
        write_diagnosis(found, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_what_the_machine_is_made_of_is_refused(tmp_path: Path) -> None:
    write_diagnosis(diagnosed(tmp_path), tmp_path / "out", pictures=False)
    machine = Machine.load(tmp_path / "out" / "machine.diagnosed.yaml")
    with pytest.raises(Refused, match="a file the machine is made of; give another -o"):
        check_target(machine, tmp_path / "out")
    assert check_target(machine, tmp_path / "other") == tmp_path / "other"
    with pytest.raises(Refused, match="cannot be a folder"):
        check_target(machine, tmp_path / "blocks.yaml")


def test_what_json_does_not_know_is_made_plain() -> None:
    odd: dict[str, Any] = {"a": np.float64("inf"), "b": [np.int64(3), np.bool_(True)], "c": np.array([1.0, np.nan])}
    assert tidy(odd) == {"a": None, "b": [3, True], "c": [1.0, None]}


# -- page -----------------------------------------------------------------------------------------------------------
class Links(HTMLParser):
    """Every address a page names, and tags that were not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_needs_nothing_beside_it(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    links = Links()
    links.feed(text)
    assert not links.open and len(links.addresses) == 6
    assert all(address.startswith("data:image/png;base64,") for address in links.addresses)
    assert not re.search("https?:", re.sub("base64,[A-Za-z0-9+/=]*", "", text)) and text.count("<script>") == 1
    for told in (
        "What was found",
        "stands out by 29 σ",
        "radiation (body",
        "Before and after",
        "lptn compare",
        "wet side",
    ):
        assert told in text


def test_names_are_text_on_the_page(tmp_path: Path) -> None:
    d = diagnosed(tmp_path, notes=("<b>bold</b> & more",), findings=())
    write_diagnosis(d, tmp_path / "out", pictures=False)
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "&lt;b&gt;bold&lt;/b&gt; &amp; more" in text and "What was found" not in text


# -- pictures -------------------------------------------------------------------------------------------------------
def words_of(figure: Figure) -> str:
    texts = [*figure.texts, *(t for axes in figure.axes for t in (*axes.texts, axes.xaxis.label, axes.yaxis.label))]
    return " | ".join(t.get_text() for t in texts)


def test_the_suspect_is_lit(found: Diagnosis) -> None:
    assert [str(path) for path in lit_paths(found)] == ["nodes.body", "links.wet side"]
    assert "lit in orange: body" in words_of(lit_figure(found))
    moves = replace(found, findings=(finding(places=("tcp.z", "motor"), patch={}),))
    assert "moves tcp.z" in words_of(lit_figure(moves))
    assert moves_of(moves) == {"motor": "↕ moves tcp.z"}
    assert "moves" not in " ".join(t.get_text() for t in lit_figure(moves).texts)
    reads = replace(found, findings=(finding(places=(), channels=("T_motor",), patch={}),))
    assert [str(path) for path in lit_paths(reads)] == ["nodes.motor"]


def test_unknown_heat_is_drawn_for_every_recording_with_its_inputs(found: Diagnosis) -> None:
    figure = heat_figure(unnamed(found))
    told = words_of(figure)
    assert len(figure.axes) == 2 * 4
    for word in ("train1.csv", "train2.csv", "heat into body", "offset of T_body", "speed [rpm]", "heat [W]", "[K]"):
        assert word in told
    assert "rms 140 W; if it all sits at one place, 81 % for this one" in told and "probability" not in told
    line = figure.axes[0].lines[-1]
    assert np.min(line.get_ydata()) == pytest.approx(-310.0)


def test_where_a_name_was_found_only_its_place_is_drawn(found: Diagnosis) -> None:
    told = words_of(heat_figure(found))
    assert "heat into body" in told and "offset of" not in told and "at one place" not in told
    assert "before it was added" in told


def test_what_the_finding_reads_is_drawn_below_it(found: Diagnosis) -> None:
    (run, *_) = found.fits.train_before.recordings
    step = hold("n", "W", np.array([0.0, 600.0]), np.array([0.0, 50.0]))
    signals = {**run.trajectory.schedule.signals, **{n: replace(step, name=n) for n in ("a", "b", "c", "cutting")}}
    inputs = {name: np.zeros(2) for name in signals}
    schedule = replace(run.trajectory.schedule, signals=signals)
    many = replace(run, trajectory=replace(run.trajectory, schedule=schedule, inputs=inputs))
    assert "cutting" not in order_inputs([], [many]) and order_inputs(["cutting"], [many])[0] == "cutting"


def test_rivals_are_ranked_and_the_found_one_stands_out(found: Diagnosis) -> None:
    figure = candidates_figure(found)
    gains = figure.axes[0]
    assert [patch.get_width() for patch in gains.patches] == pytest.approx(np.sqrt(2 * np.array([412.3, 300.0, 90.0])))
    assert [t.get_text() for t in figure.axes[1].texts] == ["1.00", "1.27", "3.33"]
    assert len({patch.get_facecolor() for patch in gains.patches}) == 2
    names = [t.get_text() for t in gains.get_yticklabels()]
    assert names == ["convection (body, air)", "radiation (body, air)", "windage (motor)"]
    again = replace(found, findings=(finding(gain=382.3),))
    told = [t.get_text() for t in candidates_figure(again).axes[0].texts]
    assert told == ["28", "24", "13"] and "by 28 σ" in str(again)
    many = replace(found, tried=tuple(rival("convection", f"n{i}", 0.1, 1 + i, 50.0 - i) for i in range(40)))
    assert "the best 16 of 40" in words_of(candidates_figure(many))


def test_the_map_of_gains_shows_kinds_at_places_the_best_first(found: Diagnosis) -> None:
    gains = (
        ScreenedGain("windage", ("motor",), (), 50.0), ScreenedGain("heat_source", ("motor",), (), 8.0),
        ScreenedGain("sensor_lag", (), ("T_motor",), 200.0),
    )  # fmt: skip
    (axes,) = gains_figure(replace(found, screened=gains)).axes
    assert [t.get_text() for t in axes.get_yticklabels()] == ["T_motor", "motor"]
    assert [t.get_text() for t in axes.get_xticklabels()] == ["sensor lag", "windage", "heat source"]
    assert [t.get_text() for t in axes.texts] == ["20", "10", "4"]
    many = tuple(ScreenedGain(f"kind{i}", (f"n{i}",), (), 50.0 - i) for i in range(30))
    told = words_of(gains_figure(replace(found, screened=many)))
    assert "the best 14 of 30 places" in told and "the best 14 of 30 kinds" in told


def test_heat_and_offsets_share_one_clock_and_are_called_what_they_are(found: Diagnosis) -> None:
    figure = heat_figure(unnamed(found))
    assert "unknown heat or offset of a channel" in words_of(figure)
    assert len({axes.get_xlabel() for axes in figure.axes} - {""}) == 1
    quick = finding(parameters={"period": Quantity(540.0, 2.0, "min")})
    told = words_of(heat_figure(replace(found, findings=(quick,), located=found.located[:1])))
    assert "unknown heat |" in told and "a value every 5 min, too coarse for a period of 9 min" in told


def test_a_machine_that_stays_as_it_is_is_drawn_and_told_once(found: Diagnosis) -> None:
    fits = replace(found.fits, train_before=found.fits.train_after, holdout_before=found.fits.holdout_after)
    same = replace(found, verdict="adequate", findings=(), fits=fits)
    assert fit_rows(same)[0] == ["rmse [σ]", "fitted", "held out"] and "before:" not in str(same)
    assert len(fit_rows(found)[0]) == 5
    (residual, *_) = fits.train_after.recordings
    once, twice = (fit_figure(b, residual, "fit") for b in (residual, found.fits.train_before.recordings[0]))
    assert len(once.axes[0].lines) < len(twice.axes[0].lines)
    assert "→" not in words_of(once) and "before orange" not in words_of(once) and "→" in words_of(twice)


def test_a_tall_picture_has_a_printed_page_of_its_own(folder: Path) -> None:
    assert not is_tall((folder / "candidates.png").read_bytes())
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert text.count('<figure class="tall">') == sum(is_tall(p.read_bytes()) for p in folder.glob("*.png"))
    assert "max-height: 118mm" in text and "break-inside: avoid" in text


def test_what_was_found_is_named_whole_in_the_network(found: Diagnosis) -> None:
    link, source = "conduction through the bracket of body", "heat_source while the spindle runs motor"
    flow = {"kind": "conduction", "between": ["motor", "body"], "conductance": "3 W/K"}
    patch = {"links": {link: flow}, "sources": {source: {"kind": "heat_source", "into": {"motor": 1}, "power": "9 W"}}}
    bare, lit = (replace(found, after=found.machine.patched(patch), findings=(finding(patch=p),)) for p in ({}, patch))
    assert link in words_of(lit_figure(lit)) and source in words_of(lit_figure(lit))
    assert link not in words_of(lit_figure(bare)) and source not in words_of(lit_figure(bare))
