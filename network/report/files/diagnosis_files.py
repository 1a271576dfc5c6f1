"""What `lptn diagnose` leaves in a folder: all of it or nothing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.analysis.diagnosis.experiments.experiment import experiment_file
from network.machine.file_layers import is_made_of
from network.platform.folders import folder
from network.platform.publication import Kind, publication
from network.platform.refusal import Spot, refuse
from network.platform.yaml.document import dump
from network.report.files.diagnosis_patch import FILE, patch_text
from network.report.files.diagnosis_pictures import Picture, pictures_of
from network.report.files.page import Shown, page
from network.report.files.result_files import as_json
from network.report.words.effect_words import effect_summary

if TYPE_CHECKING:
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.machine.machine import Machine

ORDER = (".html", ".yaml", ".json", ".yml", ".png")
PICTURES = ("network.png", "candidates.png", "gains.png", "heat.png", "fit-*.png", "holdout-fit-*.png",
            "experiment-*.yml", "changes.png")  # fmt: skip
DIAGNOSIS = Kind("diagnosis.json", (*PICTURES, "report.html"))


def check_target(machine: Machine, where: Path) -> Path:
    """The folder, before anything is computed. Raises Refused where it could not be written to in the end, and where
    the result would replace a file that it extends."""
    if where.exists():
        folder(where)
    if is_made_of(machine.file, where / FILE):
        wrong = f"holds {FILE}, and that is a file the machine is made of"
        raise refuse(Spot(str(where)), wrong, "give another -o")
    return where


def write_diagnosis(d: Diagnosis, where: Path, pictures: bool = True) -> list[Path]:
    """report.html, machine.diagnosed.yaml, diagnosis.json and pictures, all of them or none."""
    with publication(where, DIAGNOSIS) as draft:
        _fill(d, draft, where, pictures)
        made = sorted(draft.iterdir(), key=lambda path: (ORDER.index(path.suffix), path.name))
    return [where / path.name for path in made]


def _fill(d: Diagnosis, draft: Path, where: Path, pictures: bool) -> None:
    """Makes every file; `where` is where they are going to stand."""
    drawn = [_draw(picture, draft) for picture in pictures_of(d)] if pictures else []
    patch = patch_text(d, where)
    runs = {experiment_file(k): dump(e.scenario) for k, e in enumerate(d.advice, 1) if e.scenario}
    texts = {
        FILE: patch,
        "diagnosis.json": as_json(summarise_diagnosis(d)),
        "report.html": page(d, drawn, patch, where),
    } | runs
    for name, content in texts.items():
        (draft / name).write_text(content, encoding="utf-8", newline="\n")


def summarise_diagnosis(d: Diagnosis) -> dict[str, Any]:
    """With what every finding does to the tool centre point."""
    told = d.summary()
    return told | {"findings": [f | {"effect": effect_summary(d, i)} for i, f in enumerate(told["findings"])]}


def _draw(picture: Picture, draft: Path) -> Shown:
    from network.report.figures.canvas import save

    path = save(picture.draw(), draft / picture.name)
    return Shown(picture.name, picture.place, picture.caption, path.read_bytes())
