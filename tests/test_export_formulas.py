"""Two numbers an axis: found again where they are true, judged on the full model, written as controls take them."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from build import machine

from network import Machine, Refused, Scenario, simulate
from network.analysis.correction.temperature_formula import fit_formulas
from network.cli import main

ROOT = Path(__file__).parents[1]
GANTRY = ROOT / "machines" / "gantry_spindle.yaml"
RUNS = [ROOT / "scenarios" / f"{name}.yaml" for name in ("warm_up_and_stop", "day_of_work")]


def plate() -> Machine:
    """One part, one sensor, and a screw that stretches by it: the formula is the machine."""
    grows = {"kind": "stretching", "of": "a", "length": "400 mm", "expansion": "1e-5 1/K", "direction": -1}
    screw = {"kind": "stretching", "of": "a", "fixed": "0 mm", "at": "100 mm + position", "length": "1 m",
             "expansion": "1e-5 1/K", "direction": 1}  # fmt: skip
    skin = {"kind": "convection", "between": ["a", "air"], "conductance": "2 W/K"}
    heat = {"kind": "heat_source", "into": {"a": 1}, "power": "50 W"}
    return machine(
        {"a": {"heat_capacity": "5 kJ/K"}, "air": {"temperature": "air"}}, links={"skin": skin}, sources={"heat": heat},
        tcp={"z": {"grows": grows}, "x": {"screw": screw}}, sensors={"T": {"measures": "a", "noise": "0.1 K"}},
    )  # fmt: skip


def travel() -> Scenario:
    steps = [{"for": "10 min", "at": f"{x} mm"} for x in (0, 300, 100, 500, 0, 500)]
    return Scenario.of("travel", "1 h", {"air": "20 degC", "position": steps}, output="20 s")


def test_numbers_that_are_true_are_found_again() -> None:
    """δz = −4 µm/K; δx = 10 µm/(m K) times 100 mm + position, so 3.5 µm/K at the middle of the travel."""
    z, x = fit_formulas(plate(), [travel()]).formulas
    assert z.by_sensor == pytest.approx([-4e-6], rel=1e-6) and z.position == ""
    assert (x.position, x.middle) == ("position", 0.25) and x.by_sensor == pytest.approx([3.5e-6], rel=1e-6)
    assert x.slope_by_sensor == pytest.approx([1e-5], rel=1e-6)
    assert max(*z.lost, *x.lost) < 1e-11 < 1e-6 < min(*z.uncorrected, *x.uncorrected)


def test_what_is_left_is_what_the_formula_misses_on_the_full_model() -> None:
    table = fit_formulas(Machine.load(GANTRY), [Scenario.load(path) for path in RUNS])
    run = simulate(Machine.load(GANTRY), Scenario.load(RUNS[0]))
    for f in table.formulas:
        told = f.offset + f.by_sensor[0] * (run.sensors[f.sensors[0]] - f.reference)
        assert f.lost[0] == pytest.approx(np.abs(run.tcp[f.axis] - told).max())
        assert f.lost[0] < 0.5 * f.uncorrected[0]


def test_more_sensors_leave_less() -> None:
    sources = [Scenario.load(path) for path in RUNS]
    one, all_ = (fit_formulas(Machine.load(GANTRY), sources, channels) for channels in
                 (["T_headstock"], ["T_nose", "T_headstock", "T_beam"]))  # fmt: skip
    for few, many in zip(one.formulas, all_.formulas, strict=True):
        assert max(many.lost) < max(few.lost)


@pytest.mark.parametrize("form", ["table", "sinumerik", "heidenhain", "beckhoff"])
def test_every_form_holds_the_same_numbers(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Read back from its own units at 30 °C: the movement of export.json."""
    main(["export", str(GANTRY), *map(str, RUNS), "--as", form, "-o", str(tmp_path)])
    assert "µm" in capsys.readouterr().out
    told = json.loads((tmp_path / "export.json").read_text())["axes"]
    path = next(p for p in tmp_path.iterdir() if p.name != "export.json")
    text = path.read_text(encoding="utf-8")
    for axis, numbers in told.items():
        expected = numbers["offset"] + numbers["per_K"][0] * (30 - 21.6)
        assert evaluate(form, text, axis) == pytest.approx(expected, rel=1e-4)


def evaluate(form: str, text: str, axis: str) -> float:
    """Movement [µm] with every temperature at 30 °C."""
    if form == "table":
        rows = {row["term"]: float(row["value"]) for row in csv.DictReader(text.splitlines()) if row["axis"] == axis}
        return rows["offset"] + rows["per kelvin over the reference"] * (30 - rows["reference"])
    line = next(line for line in text.splitlines() if re.search(rf"(VALUE\[{axis.upper()}\]|^{axis.upper()} TEMPCOMP|"
                                                                rf"^{axis.upper()}_offset_0)", line))  # fmt: skip
    right = re.split(r" :?= ", line, maxsplit=1)[1].split(";")[0].replace("REAL_TO_DINT", "")
    value = float(eval(re.sub(r"\$R\d+|W\d+|T\d+", "30", right)))
    return value * (0.1 if form == "beckhoff" else 1e3)


def test_sensors_have_one_place_for_all_axes(tmp_path: Path) -> None:
    main(["export", str(GANTRY), str(RUNS[0]), "--as", "heidenhain", "-o", str(tmp_path)])
    text = (tmp_path / "correction.txt").read_text(encoding="utf-8")
    places = set(re.findall(r"^; (W\d+): (\S+)", text, re.MULTILINE))
    assert len(places) == len({word for word, _ in places}) == len({sensor for _, sensor in places})


def test_a_formula_needs_runs_and_sensors() -> None:
    with pytest.raises(Refused, match="has no run to fit two numbers an axis on; give a scenario or a recording"):
        fit_formulas(plate(), [])
    with pytest.raises(Refused, match="leaves the control no temperature; give one of T in --inputs"):
        fit_formulas(plate(), [travel()], ["air"])
