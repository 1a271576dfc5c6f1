"""What `lptn calibrate` leaves in a folder: all of it or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.calibrated_patch import FILE, patch_text
from network.catalogue.declaration.entry_path import displacement
from network.platform.publication import Kind, publication
from network.platform.wording import join_names
from network.report.files.result_files import as_json
from network.report.words.recording_names import stems_of, title_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.calibration.tcp_bands import Band
    from network.analysis.comparison.compare import Comparison
    from network.machine.machine import Machine

PICTURES = tuple(f"{side}{what}-*.png" for side in ("", "holdout-") for what in ("fit", "residual"))
ORDER = (".yaml", ".json", ".html", ".png")
CALIBRATION = Kind("calibration.json", (*PICTURES, "shifts.png", "band-*.png", "report.html"))


def write_calibration(c: Calibration, where: Path, pictures: bool = True, page: bool = False) -> list[Path]:
    """machine.calibrated.yaml, calibration.json, pictures and, where asked for, the page, all of them or none."""
    with publication(where, CALIBRATION) as draft:
        (draft / FILE).write_text(patch_text(c.machine, where, remark(c)), encoding="utf-8", newline="\n")
        (draft / "calibration.json").write_text(as_json(c.summary()), encoding="utf-8", newline="\n")
        for name, figure in figures(c) if pictures else ():
            from network.report.figures.canvas import save

            save(figure(), draft / name)
        if page:
            from network.report.pages.result_pages import page_of_calibration, write_page

            write_page(page_of_calibration(c), draft)
        made = sorted(draft.iterdir(), key=lambda path: (ORDER.index(path.suffix), path.name))
    return [where / path.name for path in made]


def remark(c: Calibration) -> str:
    names = join_names([Path(r.recording.file).name for r in c.after.recordings])
    return f"calibrated by lptn on {names}: value ± standard error"


def figures(c: Calibration) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Name → what makes it: fits and residuals of every recording, shifts, bands; the held-out ones last."""
    from network.report.figures.fit_figure import fit_figure
    from network.report.figures.residual_figure import residual_figure

    sides: list[tuple[str, Comparison, Comparison]] = [("", c.before, c.after)]
    if c.before_holdout is not None and c.after_holdout is not None:
        sides.append(("holdout-", c.before_holdout, c.after_holdout))
    for prefix, before, after in sides:
        for stem, b, a in zip(stems_of(after), before.recordings, after.recordings, strict=True):
            side = "held out" if prefix else "calibrated on"
            title = f"{c.original.name}: {title_of(a.recording)}, {side}"
            yield f"{prefix}fit-{stem}.png", partial(fit_figure, b, a, title, large=bool(prefix))
            yield f"{prefix}residual-{stem}.png", partial(residual_figure, b, a, side)
    if any(np.isfinite(c.shift)):
        yield "shifts.png", partial(_shifts, c)
    for band in c.bands[-1]:
        yield f"band-{band.axis}.png", partial(_band, c, band)


def _shifts(c: Calibration) -> Figure:
    """Of all numbers whose prior was not flat."""
    from network.report.figures.calibration_figure import shift_figure

    own = [j for j in range(len(c.parameters)) if np.isfinite(c.shift[j])]
    std = [np.nan if j in c.known.at_bound else c.std[j] / c.parameters[j].spread for j in own]
    return shift_figure([c.parameters[j].path for j in own], c.shift[own], np.array(std))


def _band(c: Calibration, band: Band) -> Figure:
    """Of one axis over the last recording, with the probe that measures it, the run's constants taken out."""
    from network.report.figures.calibration_figure import band_figure

    last = (c.after_holdout or c.after).recordings[-1]
    t, file = last.recording.t, last.recording.file
    centre, std = (np.interp(t, band.t, v) for v in (band.centre, band.total))
    name = next((n for n in last.channels if _reads(c.machine, n, band.axis)), None)
    measured = None if name is None else centre + last.channels[name].residual
    inside = next((k.inside for k in c.coverage if (k.file, k.channel) == (file, name)), None)
    noise = c.machine.sensors[name].sigma if name is not None else 0.0
    on = f"{title_of(last.recording)}, {'held out' if c.after_holdout else 'calibrated on'}"
    return band_figure(t, centre, std, measured, band.unit, displacement(band.axis), inside, noise, on)


def _reads(machine: Machine, name: str, axis: str) -> bool:
    """Whether a channel reads an axis as it is, but for where its zero lies: not changed by effects."""
    sensor = machine.sensors[name]
    return sensor.axis == axis and not sensor.effects
