"""The command `lptn iso230`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import click

from network.cli.options import (
    AskedMachine,
    check_page,
    json_flag,
    machine_options,
    page_flag,
    read_start,
    results_go_to,
    sources_of,
    start_option,
    tell_result,
)
from network.platform.package_data import find_shipped
from network.platform.refusal import Spot, likely, refuse
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.recordings.recording import Recording
    from network.recordings.scenario import Scenario

PROGRAMS = ("etve", "spindle_constant", "spindle_spectrum", "linear_axis", "rotary_axis")


@click.command()
@machine_options
@click.argument("program", type=click.Path())
@click.option("--top", "tops", multiple=True, metavar="INPUT=VALUE", help="scale an input of PROGRAM, 'speed=9000 rpm'")
@click.option("--input", "names", multiple=True, metavar="THEIRS=OURS", help="what PROGRAM moves, 'feed=feed_x'")
@click.option("--tool-length", metavar="LENGTH", help="also the drift at a tool that is longer by this, like '150 mm'")
@click.option("--stable", metavar="SHARE", help="an hour that moves less than this share of the first is stable; 15 %")
@click.option("-o", "--output", type=click.Path(), metavar="DIR", help="report.html, iso230.json and a picture")
@page_flag
@start_option
@json_flag
def iso230(
    machine: AskedMachine, program: str, tops: Sequence[str], names: Sequence[str], tool_length: str | None,
    output: str | None, page: bool, start: str | None, stable: str | None, as_json: bool,
) -> None:  # fmt: skip
    """A thermal test of ISO 230-3 on a MACHINE: simulated along PROGRAM (a scenario, or one of the programs shipped:
    etve, spindle_constant, spindle_spectrum, linear_axis, rotary_axis), or from a recording."""
    check_page(page, output)  # which stands in the folder anyway
    with share_bar(f"testing {machine.name}") as bar:
        results_go_to(output)
        read = _fitted(program, tops, names)
        loaded = machine.read(read, start)
        from network.analysis.acceptance.thermal_test import evaluate_thermal_test

        length, share, (source,) = _read_length(tool_length), _read_share(stable), read()
        test = evaluate_thermal_test(loaded, source, tool_length=length, start=read_start(start), stable_share=share)
        written = []
        if output is not None:
            bar.now("drawing the test", 1.0)
            from network.platform.publication import publication
            from network.report.files.thermal_test_files import TEST, write_thermal_test

            with publication(output, TEST) as draft:
                written = [Path(output) / path.name for path in write_thermal_test(test, draft)]
    tell_result(test, test.summary, written, as_json, loaded.warnings)


def _fitted(program: str, tops: Sequence[str], names: Sequence[str]) -> Callable[[], list[Scenario | Recording]]:
    """What reads the program, with its inputs scaled and under the machine's names."""
    read = sources_of([_find_program(program)])

    @cache
    def fit() -> list[Scenario | Recording]:
        from network.recordings.scaled_inputs import rename_inputs, scale_inputs

        return [rename_inputs(scale_inputs(source, tops), names) for source in read()]

    return fit


def _find_program(program: str) -> Path:
    """A file, or a program that is shipped by its short name."""
    if Path(program).exists():
        return Path(program)
    if program in PROGRAMS:
        return find_shipped("scenarios", f"iso230_{program}.yaml")
    if not Path(program).suffix:
        raise refuse(Spot(program), "is no file, and no program that comes with lptn", likely(program, PROGRAMS))
    return Path(program)


def _read_share(text: str | None) -> float:
    from network.analysis.acceptance.drift_measures import SETTLED
    from network.platform.quantities.units import BadNumber, in_unit
    from network.platform.refusal import Spot, refuse

    if text is None:
        return SETTLED
    right = "a share above 0 and below 100 %, like '15 %' or '10 %'"
    try:
        share = in_unit(text, "1")
    except BadNumber as bad:
        raise refuse(Spot("--stable"), bad.wrong, right) from None
    if not 0 < share < 1:
        raise refuse(Spot("--stable"), f"'{text}' is no share of a drift", right)
    return share


def _read_length(text: str | None) -> float | None:
    from network.platform.quantities.units import BadNumber, in_unit

    if text is None:
        return None
    try:
        return in_unit(text, "mm")
    except BadNumber as bad:
        raise refuse(Spot("--tool-length"), bad.wrong, bad.right) from None
