"""What `lptn diagnose … --reference …` leaves: machine.diagnosed.yaml with the numbers of now, diagnosis.json, and a
picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from network.machine.file_layers import patch_from
from network.platform.publication import publication
from network.platform.wording import comment
from network.platform.yaml.document import dump
from network.report.files.diagnosis_files import DIAGNOSIS
from network.report.files.diagnosis_patch import FILE
from network.report.files.result_files import as_json
from network.report.words.change_words import explain, tell_nothing

if TYPE_CHECKING:
    from network.analysis.change.changes import Changes


def write_changes(found: Changes, where: Path, pictures: bool = True) -> list[Path]:
    """All of it or nothing. Raises Refused where a file cannot be written."""
    with publication(where, DIAGNOSIS) as draft:
        (draft / FILE).write_text(_patch_text(found, where), encoding="utf-8", newline="\n")
        (draft / "diagnosis.json").write_text(as_json(found.summary()), encoding="utf-8", newline="\n")
        if pictures:
            from network.report.figures.canvas import save
            from network.report.figures.change_figure import change_figure

            save(change_figure(found), draft / "changes.png")
        made = sorted(path.name for path in draft.iterdir())
    return [where / name for name in made]


def _patch_text(found: Changes, where: Path) -> str:
    """The machine as it is now; its text is what changed."""
    told = [explain(found, change) for change in found.found] or [tell_nothing(found)]
    head = "".join(f"{line}\n" for text in told for line in comment(text))
    over = patch_from(found.machine.file, found.after.tree, where)
    return head + dump(found.after.to_plain() if over is None else {"extends": over[0], **over[1]})
