"""The command `lptn follow`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from network.cli.options import AskedMachine, machine_options, results_go_to, warn

if TYPE_CHECKING:
    from network.analysis.correction.filter_model import FilterModel
    from network.analysis.correction.follower import Follower, Told
    from network.catalogue.declaration.declare import Array

EVERY = 100
"""Lines after which the state is saved; it is at the end, too."""


@click.command()
@machine_options
@click.option("--state", type=click.Path(), metavar="FILE", help="where the state is kept, to go on after a restart")
@click.option("--picture", type=click.Path(), metavar="FILE", help="what was told, drawn when the lines end")
@click.option("--inputs", metavar="A,B,…", help="the inputs and sensors that the lines hold; default all")
@click.option("--step", default="10 s", show_default=True, metavar="TIME", help="of the filter")
def follow(machine: AskedMachine, state: str | None, picture: str | None, inputs: str | None, step: str) -> None:
    """Runs beside a MACHINE: lines of a recording on standard input, with its header first; out go the movement of the
    tool centre point, half its band of 95 %, and a warning where readings leave what the model expects."""
    loaded = machine.read()
    from network.analysis.correction.channels_given import read_channels
    from network.analysis.correction.correction import make_correction
    from network.analysis.correction.follower import Follower
    from network.recordings.yaml_values import read_time

    made = make_correction(loaded, [], channels=read_channels(loaded, inputs), step=read_time("--step", step))
    warn([*map(str, loaded.warnings), *made.notes])
    follower = Follower(made.filter)
    for path in (state, picture):
        if path is not None:
            results_go_to(Path(path).parent)
    if state is not None:
        _restore(follower, Path(state))
    told: list[Told] | None = [] if picture is not None else None
    try:
        _follow(follower, sys.stdin, Path(state) if state is not None else None, told)
    finally:
        if state is not None and follower.inputs:
            _save(follower, Path(state))
        if picture is not None and told:
            from network.report.figures.canvas import save
            from network.report.figures.follow_figure import follow_figure

            save(follow_figure(made.filter, told), picture)


def _follow(follower: Follower, lines: Iterable[str], state: Path | None, kept: list[Told] | None) -> None:
    """Line by line, as they come; what was told is kept where it is to be drawn."""
    f = follower.filter
    head = [f"{axis} [{text}],{axis} band [{text}]" for axis, text in zip(f.axes, f.axis_units, strict=True)]
    click.echo(",".join(["time [s]", *head, "warning"]))
    for count, (t, inputs, read) in enumerate(_read_lines(f, lines), 1):
        told = follower.take(t, inputs, read)
        click.echo(_line(told))
        if kept is not None:
            kept.append(told)
        if state is not None and count % EVERY == 0:
            _save(follower, state)


def _line(told: Told) -> str:
    numbers = [f"{value:.6g}" for pair in zip(told.moved, told.band, strict=True) for value in pair]
    return ",".join([f"{told.t:.10g}", *numbers, f'"{"; ".join(told.warnings)}"' if told.warnings else ""])


def _read_lines(f: FilterModel, lines: Iterable[str]) -> Iterator[tuple[float, dict[str, float], Array]]:
    """Time, inputs and readings of every line; a line that cannot be read is told and left out."""
    import numpy as np

    source = iter(lines)
    scales = _read_header(f, next(source, ""))
    for number, line in enumerate(source, 2):
        cells = line.rstrip("\r\n").split(",")
        if not line.strip():
            continue
        if len(cells) != scales.width:
            warn([f"line {number} has {len(cells)} fields, the header has {scales.width}; it is left out"])
            continue
        values = {name: scales.value(name, cells) for name in ("time", *f.inputs, *f.sensors)}
        if values["time"] != values["time"]:
            warn([f"line {number} has no time; it is left out"])
            continue
        yield values["time"], {n: values[n] for n in f.inputs}, np.array([values[n] for n in f.sensors])


class _Columns:
    """Where each channel stands, and what makes its unit the filter's."""

    def __init__(self, width: int, places: Mapping[str, tuple[int, float, float]]) -> None:
        self.width, self.places = width, places

    def value(self, name: str, cells: Sequence[str]) -> float:
        """NaN where a channel is not in the header, or its cell is no number."""
        if name not in self.places:
            return float("nan")
        column, scale, offset = self.places[name]
        try:
            return float(cells[column]) * scale + offset
        except ValueError:
            return float("nan")


def _read_header(f: FilterModel, line: str) -> _Columns:
    """Raises Refused for inputs that are not there, and for units of another kind."""
    from network.platform.quantities.units import BadNumber, unit
    from network.platform.refusal import Complaints, Spot, likely

    complaints, places = Complaints(), dict[str, tuple[int, float, float]]()
    labels = [label.strip().strip('"') for label in line.rstrip("\r\n").split(",")]
    wanted = {"time": "s", **f.inputs, **dict.fromkeys(f.sensors, "degC")}
    for column, label in enumerate(labels):
        name, _, text = (part.strip(" ]") for part in label.partition("["))
        if name not in wanted:
            continue
        try:
            given, ours = unit(text or "1"), unit(wanted[name])
        except BadNumber as bad:
            complaints.refuse(Spot("standard input", 1), f"{label}: {bad.wrong}", bad.right)
            continue
        if given.dimension != ours.dimension:
            right = f"write `{name} [{wanted[name]}]`"
            complaints.refuse(Spot("standard input", 1), f"'{label}' is in another kind of unit", right)
            continue
        places[name] = column, given.scale / ours.scale, (given.offset - ours.offset) / ours.scale
    for name in ("time", *f.inputs):
        if name not in {label.partition("[")[0].strip() for label in labels}:
            right = f"begin with a header like `time [s],speed [rpm]` ({likely(name, labels)})"
            complaints.refuse(Spot("standard input", 1), f"has no column '{name}'", right)
    complaints.raise_if_any()
    return _Columns(len(labels), places)


def _restore(follower: Follower, path: Path) -> None:
    """Goes on from the file, if it is there. Raises Refused for one that is no state of this filter."""
    from network.platform.quantities.units import BadNumber
    from network.platform.refusal import Spot, refuse

    if not path.is_file():
        return
    try:
        follower.restore(json.loads(path.read_text(encoding="utf-8")))
    except BadNumber as bad:
        raise refuse(Spot(str(path)), bad.wrong, bad.right) from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise refuse(Spot(str(path)), "is no saved state", "give another --state, or remove the file") from None


def _save(follower: Follower, path: Path) -> None:
    from network.platform.files import write_text
    from network.report.files.result_files import as_json

    write_text(path, as_json(follower.to_plain()))
