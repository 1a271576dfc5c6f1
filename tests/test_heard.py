"""What a recording may not say, and what is told of channels that a fit does not hear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosed import saved
from fits import USUAL, recorded, speeds

from network import Machine
from network.analysis.comparison.compare import check_fit
from network.analysis.diagnosis.findings.holdout_admission import admit_runs
from network.cli import main
from network.platform.refusal import Refused
from network.recordings.channel_match import overheard
from network.recordings.columns import Column
from network.recordings.recording import Recording
from network.recordings.yaml_values import start_of


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return saved(tmp_path)


@pytest.fixture
def recording(machine: Machine) -> Recording:
    return recorded(machine, speeds(*USUAL, every=30.0), 0)


Change = Callable[[Column], Column]


def changed(recording: Recording, file: str, **changes: Change | None) -> Recording:
    """The recording under another name, with columns changed, renamed or (None) taken out."""
    columns = {}
    for name, column in recording.columns.items():
        change = changes.get(name, lambda same: same)
        if change is not None:
            new = change(column)
            columns[new.name] = new
    return replace(recording, file=file, columns=columns)


def empty(column: Column) -> Column:
    return replace(column, values=column.values * np.nan)


def told_as(unit: str, scale: float, offset: float) -> Change:
    """The same numbers with another unit in the header: values in °C become scale · value + offset."""
    return lambda column: replace(column, unit=unit, values=scale * column.values + offset)


def test_a_renamed_channel_is_told_with_the_sensor_that_lacks_it(machine: Machine, recording: Recording) -> None:
    renamed = changed(recording, "names.csv", T_body=lambda c: replace(c, name="Temp_body"))
    told = admit_runs(machine, [renamed], [], None).warnings
    assert told[:2] == (
        "names.csv: Temp_body is no sensor of this machine (did you mean T_body?)",
        "the sensor T_body is in no recording and was not used",
    )
    again = replace(renamed, file="again.csv")
    assert overheard(machine, [renamed], [again])[0].startswith("names.csv, again.csv: Temp_body is no sensor")
    other = replace(recording, t=recording.t + 1.0)
    assert overheard(machine, [renamed, other], []) == list(told[:1])
    assert overheard(machine, [recording], []) == []


def test_a_driver_is_no_misnamed_sensor(machine: Machine, recording: Recording) -> None:
    driven = changed(recording, "door.csv", T_body=lambda c: replace(c, name="door"))
    assert overheard(machine, [driven], []) == ["the sensor T_body is in no recording and was not used"]


def test_a_channel_empty_where_it_is_fitted_is_told(machine: Machine, recording: Recording) -> None:
    gone = changed(recording, "gone.csv", T_body=empty)
    assert overheard(machine, [gone], [recording]) == [
        "the sensor T_body is read only in what is held out and was not used"
    ]
    assert overheard(machine, [gone], []) == [
        "the sensor T_body is without any reading in the recordings and was not used"
    ]


def test_temperatures_that_no_machine_has_are_refused(machine: Machine, recording: Recording) -> None:
    kelvin = changed(recording, "kelvin.csv", T_body=told_as("K", 1.0, -273.15))
    with pytest.raises(Refused, match=r"kelvin\.csv:1: T_body reads [23]\d.* K = -2\d\d.* °C, .*; is it in degC\?"):
        check_fit(machine, kelvin)
    hot = changed(recording, "hot.csv", ambient=told_as("degC", 1.0, 600.0))
    with pytest.raises(Refused, match=r"ambient reads 62.* degC, which no part of a machine tool has; check"):
        check_fit(machine, hot)


def test_a_loose_contact_is_not_refused(machine: Machine, recording: Recording) -> None:
    half = np.arange(len(recording.t)) > len(recording.t) // 2
    loose = changed(recording, "l.csv", T_body=lambda c: replace(c, values=np.where(half, -127.0, c.values)))
    check_fit(machine, loose)


@pytest.mark.parametrize(("scale", "offset", "unit"), [(1.8, 32.0, "degF"), (1.0, 273.15, "K")])
def test_a_channel_in_another_unit_is_doubted(
    machine: Machine, recording: Recording, scale: float, offset: float, unit: str
) -> None:
    odd = changed(recording, "odd.csv", T_body=told_as("degC", scale, offset))
    [told] = overheard(machine, [odd], [])
    assert told.startswith("odd.csv: T_body starts ") and told.endswith(
        f" K above the other temperatures; is it in {unit}?"
    )


@pytest.mark.parametrize("text", ["500 degC", "21 K", "-90 degC"])
def test_a_start_that_no_machine_has_is_refused(text: str) -> None:
    with pytest.raises(Refused, match="is out of range; give a temperature from -80 to 400 degC"):
        start_of(text)


def test_the_terminal_hears_of_it(
    machine: Machine,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    recording: Recording,
) -> None:
    from network.recordings.csv_table import write_csv

    monkeypatch.chdir(tmp_path)
    columns = {n if n != "T_body" else "Temp_body": (c.unit, c.values) for n, c in recording.columns.items()}
    write_csv(Path("names.csv"), recording.t, columns)
    main(["compare", "blocks.yaml", "names.csv"])
    assert "warning: names.csv: Temp_body is no sensor" in capsys.readouterr().err
    main(["calibrate", "blocks.yaml", "names.csv", "--no-plots"])
    assert "warning: names.csv: Temp_body is no sensor" in capsys.readouterr().out


def test_a_machine_without_sensors_is_to_blame_itself(machine: Machine, recording: Recording) -> None:
    blind = machine.patched({"sensors": dict.fromkeys(machine.sensors)})
    with pytest.raises(Refused, match=r"blocks\.yaml: the machine has no sensors"):
        check_fit(blind, recording)
