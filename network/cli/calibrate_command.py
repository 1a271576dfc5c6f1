"""The command `lptn calibrate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from network.cli.options import (
    AskedMachine,
    FileName,
    Whole,
    json_flag,
    machine_options,
    page_flag,
    read_fitting,
    read_start,
    recordings_of,
    results_go_to,
    sources_of,
    start_option,
    tell_result,
)
from network.platform.refusal import Spot, refuse
from network.report.progress import Bar, share_bar

if TYPE_CHECKING:
    from network.analysis.calibration.calibrate import Calibration
    from network.analysis.calibration.experiment_plan import Foresight
    from network.machine.machine import Machine
    from network.recordings.recording import Recording

PLAN = "plan.json"
AGAIN = 2
"""Times that lumps are chosen anew with the numbers found."""


@click.command()
@machine_options
@click.argument("recordings", nargs=-1, type=FileName())
@click.option("--holdout", multiple=True, type=FileName(), metavar="RECORDING", help="only predicted, never fitted")
@click.option(
    "-o", "--output", type=FileName(), metavar="DIR", help="machine.calibrated.yaml, calibration.json, pictures [out]"
)
@click.option("--plan", type=FileName(), metavar="SCENARIO", help="no recording: what this schedule would determine")
@click.option("--seed", type=Whole(0), default=0, show_default=True, help="of further beginnings")
@start_option
@click.option("--no-plots", is_flag=True, help="no pictures")
@page_flag
@json_flag
def calibrate(
    machine: AskedMachine, recordings: Sequence[str], holdout: Sequence[str], output: str | None, plan: str | None,
    seed: int, start: str | None, no_plots: bool, page: bool, as_json: bool,
) -> None:  # fmt: skip
    """The uncertain numbers of a MACHINE (± or unknown) from RECORDINGS, with their uncertainty."""
    if plan is None and not recordings:
        raise refuse(Spot("lptn calibrate"), "no recording is given", "name at least one, or a schedule with --plan")
    with share_bar(f"calibrating {machine.name}") as bar:
        results_go_to(output if plan is not None else output or "out")
        read = recordings_of(recordings)
        loaded = machine.read(read if plan is None else sources_of([plan]), start)
        answer: Foresight | Calibration
        if plan is not None:
            _check_no_recordings(recordings, holdout)
            answer, written = _plan(loaded, plan, output, start)
        else:
            made = (not no_plots, page)
            answer, written = _calibrate(loaded, read, holdout, output or "out", seed, start, made, bar)
        text = "" if as_json else str(answer)
    unsaid = getattr(answer, "warnings", ()) if as_json else ()
    tell_result(text, answer.summary, written, as_json, [*unsaid, *loaded.warnings])


def _check_no_recordings(recordings: Sequence[str], holdout: Sequence[str]) -> None:
    if recordings or holdout:
        raise refuse(Spot("--plan"), "looks ahead of any recording, and one is given", "leave one of the two away")


def _plan(machine: Machine, scenario: str, output: str | None, start: str | None) -> tuple[Foresight, list[Path]]:
    from network.analysis.calibration.experiment_plan import foresee
    from network.platform.files import write_text
    from network.platform.publication import publication
    from network.report.files.result_files import as_json

    plan = foresee(machine, read_fitting(machine, scenario), start=read_start(start))
    if output is None:
        return plan, []
    with publication(output) as draft:
        write_text(draft / PLAN, as_json(plan.summary()))
    return plan, [Path(output) / PLAN]


def _calibrate(
    machine: Machine, read: Callable[[], list[Recording]], holdout: Sequence[str], output: str, seed: int,
    start: str | None, made: tuple[bool, bool], bar: Bar,
) -> tuple[Calibration, list[Path]]:  # fmt: skip
    """made: whether pictures and the page are wanted."""
    from network.analysis.calibration.calibrate import calibrate as run
    from network.analysis.calibration.calibrated_patch import check_target
    from network.cli.lumps_option import choose_again
    from network.report.files.calibration_files import write_calibration

    check_target(machine, Path(output))
    train, held_out = read(), recordings_of(holdout)()
    result = run(machine, train, held_out, start=read_start(start), seed=seed, progress=bar)
    for _ in range(AGAIN):
        finer = choose_again(machine, result, train, read_start(start))
        if finer is None:
            break
        result = run(finer, train, held_out, start=read_start(start), seed=seed, progress=bar)
    bar.now("drawing the calibration", 1.0)
    return result, write_calibration(result, Path(output), *made)
