"""Sealed pairs of then and now: made once and for all, with a change that is there, and judged by their keys."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bench.then_and_now import judge
from proof.pairs import list_pairs, make_pair_of, names
from proof.sealed import Broken, opened

from network import Machine, Recording

SEED = 5


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pair whose thermometer has changed, and one where nothing has."""
    folder = tmp_path_factory.mktemp("pairs")
    for name in ("changed-003", "same-001"):
        make_pair_of(folder, SEED, name)
    return folder


def test_changed_and_unchanged_come_in_turn() -> None:
    assert list_pairs(3, 2) == ["changed-001", "same-001", "changed-002", "same-002", "changed-003"]


def test_a_pair_is_a_machine_and_runs_of_it(made: Path) -> None:
    for pair in ("changed-003", "same-001"):
        machine = Machine.load(made / pair / "machine.yaml")
        runs = [Recording.load(made / pair / f"{name}.csv") for name in names()]
        assert len(runs) == 6 and all(set(machine.sensors) <= set(run.columns) for run in runs)


def test_every_third_change_is_of_a_thermometer(made: Path) -> None:
    key = opened(made, "changed-003")
    assert key["change"]["number"].startswith("sensors.") and 0.6 <= abs(key["change"]["size"]) <= 3
    assert opened(made, "same-001")["change"] is None


def test_a_key_that_was_changed_afterwards_is_not_opened(made: Path, tmp_path: Path) -> None:
    (tmp_path / "keys").mkdir()
    (tmp_path / "cases.json").write_text((made / "cases.json").read_text())
    key = json.loads((made / "keys" / "changed-003.json").read_text())
    key["change"]["size"] *= -1
    (tmp_path / "keys" / "changed-003.json").write_text(json.dumps(key))
    with pytest.raises(Broken):
        opened(tmp_path, "changed-003")


def test_the_thermometer_reads_otherwise_now(made: Path) -> None:
    """By as much as the key says, against another pair of the same seed without the change: its first readings, where
    all parts are at the reference to within 0.2 K, and offsets within 0.2 K."""
    change = opened(made, "changed-003")["change"]
    name = change["number"].removeprefix("sensors.")
    machine = Machine.load(made / "changed-003" / "machine.yaml")
    firsts = {run: Recording.load(made / "changed-003" / f"{run}.csv").columns[name].values[:30] for run in names()}
    now, then = (np.mean([firsts[run] for run in names() if run.startswith(side)]) for side in ("now", "then"))
    assert now - then == pytest.approx(change["size"], abs=0.4)
    assert then == pytest.approx(machine.reference, abs=0.6)


def told(*numbers: str, alike: tuple[str, ...] = ()) -> dict[str, object]:
    return {"changed": [{"number": number, "alike": list(alike)} for number in numbers]}


def test_answers_are_judged_by_the_first() -> None:
    change = {"number": "links.a.conductance", "size": 0.5, "visible": 2.0, "alike": ["links.b.conductance"]}
    key = {"change": change}
    assert judge(key, told("links.a.conductance", "links.c.conductance")) | {"named": True, "besides": 1} == judge(
        key, told("links.a.conductance", "links.c.conductance")
    )
    second = judge(key, told("links.b.conductance"))
    assert second["named"] and not second["strictly"]
    third = judge(key, told("links.c.conductance", alike=("links.a.conductance",)))
    assert not third["named"] and third["listed"]
    assert judge(key, told())["silent"] and not judge(key, told())["named"]
    assert judge({"change": None}, told("links.a.conductance"))["accused"]
    sensor = {"change": {"number": "sensors.T", "size": 1.0, "visible": 20.0, "alike": []}}
    assert judge(sensor, told("sensors.T.offset"))["strictly"]
