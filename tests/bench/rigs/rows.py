"""One row of the table: a split or a concealment, with what simulation of the files that were written gives."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bench.rigs.answers import Score, named, score
from bench.rigs.baselines import baselines
from bench.rigs.figures import Figures, Size, figures
from bench.rigs.recovered import Recovered, recovered
from bench.rigs.running import Answered, fingerprint

STAGES = ("as written", "calibrated", "diagnosed")
HERE = Path(__file__).parent
MADE_OF = [HERE / f"{name}.py" for name in ("figures", "baselines", "recovered", "rows", "splits")]


@dataclass(frozen=True)
class Measured:
    """train, holdout: figures by stage; baselines: by name, on the held-out runs."""

    train: Mapping[str, Figures] = field(default_factory=dict)
    holdout: Mapping[str, Figures] = field(default_factory=dict)
    baselines: Mapping[str, Figures] = field(default_factory=dict)
    recovered: Recovered | None = None


@dataclass(frozen=True)
class Row:
    """name, title; hides, right: of a concealment; told: how the diagnosis ended; seconds: of it; named: findings, in
    their order, with their confidences."""

    name: str
    title: str
    hides: str
    right: str
    told: str
    seconds: float
    verdict: str
    named: tuple[str, ...]
    score: Score | None
    measured: Measured


def row(answered: Answered) -> Row:
    case, diagnosis, measured = answered.case, answered.diagnosis, kept(answered)
    answer, correlation = case.answer, measured.recovered.correlation if measured.recovered else None
    return Row(
        case.name, case.split.title, case.concealed.hides if case.concealed else "", answer.words if answer else "",
        answered.diagnosed.told, answered.diagnosed.seconds, diagnosis["verdict"] if diagnosis else "",
        tuple(named(found) for found in diagnosis["findings"]) if diagnosis else (),
        score(diagnosis, answer, correlation) if answer else None, measured,
    )  # fmt: skip


def kept(answered: Answered) -> Measured:
    """What was simulated before of the same files, or what is simulated now."""
    folder = answered.folder
    made = [path for path in (*MADE_OF, *files(folder).values()) if path.is_file()]
    mark, file = fingerprint(made), folder / "measured.json"
    if file.is_file() and (old := json.loads(file.read_text()))["mark"] == mark:
        return _measured(old["measured"])
    found = measure(answered)
    file.write_text(json.dumps({"mark": mark, "measured": asdict(found)}, indent=1))
    return found


def files(folder: Path) -> dict[str, Path]:
    """The machine file of each stage."""
    names = ("machine.yaml", "calibrate/machine.calibrated.yaml", "diagnose/machine.diagnosed.yaml")
    return dict(zip(STAGES, (folder / name for name in names), strict=True))


def measure(answered: Answered) -> Measured:
    folder, case = answered.folder, answered.case
    there = {stage: path for stage, path in files(folder).items() if path.is_file()}
    train, holdout = ([folder / name for name in names] for names in (case.train, case.holdout))
    counts = case.split.counts
    without = baselines(there["as written"], train, holdout, counts) if case.concealed is None else {}
    return Measured(_staged(there, train, counts), _staged(there, holdout, counts), without, _recovered(answered))


def _staged(there: Mapping[str, Path], runs: Sequence[Path], counts: Mapping[str, str]) -> dict[str, Figures]:
    found = {stage: figures(path, runs, counts) for stage, path in there.items()}
    return {stage: told for stage, told in found.items() if told is not None}


def _recovered(answered: Answered) -> Recovered | None:
    case, folder = answered.case, answered.folder
    if case.concealed is None or case.concealed.heat is None or answered.diagnosis is None:
        return None
    whole = folder / "whole"
    type(case)(case.split).write(whole)
    truth, given = ([where / name for name in case.train] for where in (whole, folder))
    written = files(folder)
    return recovered(whole / "machine.yaml", case.concealed.heat(case.tree), written["diagnosed"],
                     written["as written"], truth, given)  # fmt: skip


def _measured(plain: Mapping[str, Any]) -> Measured:
    sets = {key: {name: _figures(f) for name, f in plain[key].items()} for key in ("train", "holdout", "baselines")}
    return Measured(**sets, recovered=Recovered(**plain["recovered"]) if plain["recovered"] else None)


def _figures(plain: Mapping[str, Any]) -> Figures:
    return Figures(plain["noise"], {name: Size(**size) for name, size in plain["channels"].items()})
