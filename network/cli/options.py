"""What the commands share: options, reading what they name, printing. Imports wait until they are needed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from network.platform.refusal import Complaints, Refused
from network.recordings.start_rule import ESTIMATED

if TYPE_CHECKING:
    from network.machine.machine import Machine
    from network.recordings.inputs import Start
    from network.recordings.recording import Recording
    from network.recordings.scenario import Scenario

Command = TypeVar("Command", bound=Callable[..., Any])


class Whole(click.IntRange):
    """A whole number from a least one on."""

    name = "whole number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        try:
            return int(super().convert(value, param, ctx))
        except click.BadParameter:
            self.fail(f"'{value}' is not one; give a whole number from {self.min}", param, ctx)


class FileName(click.Path):
    """A path; an empty one, of which Python makes the working folder, is none."""

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> str | bytes | os.PathLike[str]:
        if not os.fspath(value):
            self.fail("is empty; give the name of a file or a folder", param, ctx)
        return super().convert(value, param, ctx)


@dataclass(frozen=True)
class AskedMachine:
    """A machine file by its path, and how it is to be changed."""

    path: str
    level: str | None
    lumps: Sequence[str]
    sets: Sequence[str]

    @property
    def name(self) -> str:
        """Of the file."""
        return Path(self.path).name

    def read(self, along: Callable[[], Sequence[Scenario | Recording]] = tuple, start: str | None = None) -> Machine:
        """The machine, changed; along: what reads the scenarios and recordings by which `--lumps auto` chooses, with
        their start. A machine that is refused is told before they are."""
        from network.cli.lumps_option import cut_as_wished, split_wishes
        from network.machine.machine import Machine

        numbers, wish = split_wishes(self.lumps)
        machine = Machine.load(self.path, level=self.level, lumps=numbers, sets=self.sets)
        if wish is None:
            return machine
        begins = None if start == ESTIMATED else read_start(start)
        return cut_as_wished(machine, wish, numbers, along(), begins)


def machine_options(command: Callable[..., None]) -> Callable[..., None]:
    """Gives a command the argument MACHINE and its options; it takes them as one `machine: AskedMachine`."""

    @wraps(command)
    def told(machine: str, level: str | None, lumps: Sequence[str], sets: Sequence[str], **rest: Any) -> None:
        command(machine=AskedMachine(machine, level, lumps, sets), **rest)

    for option in (
        click.option("--set", "sets", multiple=True, metavar="PATH=VALUE", help="e.g. 'links.skin.conductance=5 W/K'"),
        click.option("--lumps", multiple=True, metavar="N|NODE=N|auto", help="of every bar, of one, or what it takes"),
        click.option("--level", metavar="NAME", help="a simplification level of the machine file"),
        click.argument("machine", type=FileName()),
    ):
        told = option(told)
    return told


json_flag = click.option("--json", "as_json", is_flag=True, help="print JSON instead of words")
start_option = click.option(
    "--start", metavar="TEMPERATURE", help="'22 degC', 'steady' or '{housing: 24 degC, others: 22 degC}'"
)
page_flag = click.option(
    "--page", is_flag=True, help="report.html besides: the result as one page, with charts to look into"
)
method_option = click.option(
    "--method", default="auto", show_default=True,
    help="auto, modal, krylov, switched, rosenbrock, expm, solve_ivp:LSODA|BDF|Radau|RK45",
)  # fmt: skip


def output_folder(default: str) -> Callable[[Command], Command]:
    return click.option(
        "-o", "--output", default=default, show_default=True, type=FileName(), metavar="DIR", help="where results go"
    )


def check_page(page: bool, output: str | None) -> None:
    """Raises Refused for a page that has no folder to stand in."""
    from network.platform.refusal import Spot, refuse

    if page and output is None:
        raise refuse(Spot("--page"), "has no folder to stand in", "name one with -o DIR")


def results_go_to(path: str | Path | None) -> None:
    """Raises Refused for a folder that cannot be had, before anything is read."""
    from network.platform.folders import check_folder

    if path is not None:
        check_folder(path)


def sources_of(paths: Sequence[str | Path]) -> Callable[[], list[Scenario | Recording]]:
    """What reads the scenarios and recordings, when they are first asked for."""

    @cache
    def read() -> list[Scenario | Recording]:
        from network.recordings.load_source import load_source

        return [load_source(path) for path in paths]

    return read


def recordings_of(paths: Sequence[str]) -> Callable[[], list[Recording]]:
    """What reads the recordings, when they are first asked for; all that are refused are told."""
    return cache(lambda: [*_read_recordings(paths)])


def read_fitting(machine: Machine, path: str) -> Scenario | Recording:
    """The scenario or recording, checked against what the machine reads and measures."""
    from network.analysis.comparison.compare import check_fit
    from network.recordings.load_source import load_source

    source = load_source(path)
    check_fit(machine, source)
    return source


def _read_recordings(paths: Sequence[str]) -> Iterator[Recording]:
    from network.recordings.load_source import load_recording

    complaints = Complaints()
    for path in paths:
        try:
            yield load_recording(path)
        except Refused as refused:
            complaints.absorb(refused)
    complaints.raise_if_any()


def warn_of_extrapolation(machine: Machine, recordings: Iterable[Recording]) -> Iterator[str]:
    """Of a calibrated machine: inputs of all recordings that leave the range it was calibrated in."""
    from network.recordings.extrapolation import list_extrapolated

    yield from list_extrapolated(machine, [recording.schedule(machine.inputs) for recording in recordings])


def read_start(text: str | None) -> Start | None:
    if text is None:
        return None
    from network.recordings.yaml_values import start_of

    return start_of(text)


def tell_result(
    words: object, summary: Callable[[], dict[str, Any]], written: Sequence[Path], as_json: bool,
    warnings: Iterable[object] = (),
) -> None:  # fmt: skip
    """How a command ends: the result in words (whose `str` is taken only then) or as JSON, the files that were written,
    and what is doubtful."""
    if as_json:
        print_json(summary())
    else:
        click.echo(str(words))
    if written:
        click.echo(f"\nWritten: {', '.join(map(str, written))}", err=as_json)
    warn(warnings)


def print_json(value: dict[str, Any]) -> None:
    from network.report.files.result_files import as_json

    click.echo(as_json(value), nl=False)


def warn(warnings: Iterable[object]) -> None:
    for warning in warnings:
        from network.platform.quantities.number_format import write_minus

        click.echo(write_minus(f"warning: {warning}"), err=True)
