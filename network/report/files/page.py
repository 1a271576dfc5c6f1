"""A diagnosis as one page: report.html, with everything in it."""

from __future__ import annotations

import base64
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.analysis.diagnosis.experiments.experiment import experiment_file
from network.platform.quantities.text_table import format_shift, span
from network.platform.wording import join_names, name_of
from network.recordings.start_rule import ESTIMATED
from network.report.files.diagnosis_patch import FILE
from network.report.pages.chart_page import chart_style, show_charts, write_policy, write_script
from network.report.pages.run_charts import chart_fits
from network.report.words.diagnosis_words import advice_words, fit_rows, is_unchanged, where_lines
from network.report.words.effect_words import effect_words
from network.report.words.finding_words import (
    alike_words,
    bench_words,
    evidence_words,
    percent,
    rival_name,
    set_words,
    sizes,
    sure_words,
    windows_words,
)
from network.report.words.moved_words import describe_moved, list_moved
from network.report.words.recording_names import name_recording
from network.report.words.tie_words import title_words
from network.report.words.verdict_words import next_words, verdict_words

if TYPE_CHECKING:
    from markupsafe import Markup

    from network.analysis.diagnosis.findings.finding import Finding, Rival
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.report.pages.chart import Chart

TEMPLATE = "diagnosis.html.j2"
TALL = 0.8
"""Height over width of a picture, from which half a page is too little for it."""


FITS = "Every recording to look into: measured grey, simulated before orange, after blue."


@dataclass(frozen=True)
class Shown:
    """A picture of the page. place: the section it stands in (found, where, fits); png: the file's bytes."""

    name: str
    place: str
    caption: str
    png: bytes


def page(d: Diagnosis, pictures: Sequence[Shown], patch: str, where: Path) -> str:
    """The page of a diagnosis whose files stand in the folder `where`."""
    from jinja2 import Environment, PackageLoader

    loader = PackageLoader("network.report")
    rooms = Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    told = _verdict(d) | _tables(d) | {"patch": patch, "patch_name": FILE, "commands": commands(d, where)}
    told |= {"charts": show_charts(charts_of_fits(d), FITS), "chart_style": chart_style(), "policy": write_policy()}
    told |= {"script": write_script()}
    return rooms.get_template(TEMPLATE).render(told, pictures=pictures, shown=embed, signed=format_shift)


def charts_of_fits(d: Diagnosis) -> list[Chart]:
    """Of every recording, the held-out ones first."""
    fits = d.fits
    sides = (("held out", fits.holdout_before, fits.holdout_after), ("fitted", fits.train_before, fits.train_after))
    return [*chart_fits(sides, lambda residual: name_recording(d, residual))]


def embed(picture: Shown) -> Markup:
    """The picture inside the page: no file beside it is needed."""
    from markupsafe import Markup

    data = base64.b64encode(picture.png).decode("ascii")
    image = Markup('<img src="data:image/png;base64,{}" alt="{}">').format(data, picture.caption)
    tall = Markup(' class="tall"') if is_tall(picture.png) else ""
    shape = Markup('<figure{}><div class="scroll">{}</div><figcaption>{}</figcaption></figure>\n')
    return shape.format(tall, image, picture.caption)


def is_tall(png: bytes) -> bool:
    """Whether a picture needs a page of its own to be read in print."""
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    return height > TALL * width


def _verdict(d: Diagnosis) -> dict[str, Any]:
    return {
        "machine": d.machine.name, "verdict": name_of(d.verdict), "meaning": verdict_words(d), "next": next_words(d),
        "basis": basis(d), "findings": [_finding(d, f) for f in d.findings], "where": where_lines(d),
        "bench": bench_words(d),
    }  # fmt: skip


def _tables(d: Diagnosis) -> dict[str, Any]:
    header, rows = fit_rows(d)
    return {
        "unchanged": is_unchanged(d), "fit_header": header, "fit_rows": rows,
        "numbers": list_moved(d), "moved": list(describe_moved(d)),
        "notes": d.notes,
        "advice": [(advice_words(e), experiment_file(k) if e.scenario else "") for k, e in enumerate(d.advice, 1)],
    }  # fmt: skip


def basis(d: Diagnosis) -> str:
    """On what it rests: which recordings, which seed, how long it took."""
    fitted = join_names([name_recording(d, r) for r in d.fits.train_after.recordings])
    told = f"Fitted on {fitted}"
    if d.fits.holdout_after is not None:
        told += f"; judged on {join_names([name_recording(d, r) for r in d.fits.holdout_after.recordings])}"
    return f"{told}. Machine file {Path(d.machine.file).name}, seed {d.seed}, {span(d.seconds)}."


def _finding(d: Diagnosis, finding: Finding) -> Mapping[str, Any]:
    return {
        "title": title_words(d, finding), "effect": effect_words(d, finding),
        "sentence": finding.whole_sentence, "sure": sure_words(finding), "sizes": sizes(finding),
        "evidence": " ".join(filter(None, [evidence_words(finding), windows_words(d, finding)])),
        "alike": alike_words(finding), "one_of": set_words(finding),
        "rivals": [_rival(finding, r) for r in finding.alternatives],
    }  # fmt: skip


def _rival(finding: Finding, rival: Rival) -> Mapping[str, str]:
    return {
        "name": rival_name(rival), "confidence": percent(finding.confidence_of(rival)), "why_not": rival.why_not,
    }  # fmt: skip


def commands(d: Diagnosis, where: Path) -> list[str]:
    """Command lines that use the patched machine."""
    machine = shlex.quote((where / FILE).as_posix())
    files = [shlex.quote(r.recording.file) for r in d.fits.train_after.recordings]
    runs = [shlex.quote((where / experiment_file(k)).as_posix()) for k, e in enumerate(d.advice, 1) if e.scenario]
    lines = [f"lptn compare {machine} {' '.join(files)} --start {ESTIMATED}", f"lptn simulate {machine} {files[0]}"]
    return lines + [f"lptn simulate {machine} {run}" for run in runs]
