"""The commands `lptn diagnose` and `lptn prove`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import click

from network.cli.options import (
    FileName,
    Whole,
    json_flag,
    machine_options,
    output_folder,
    print_json,
    read_machine,
    read_recordings,
    read_start,
    results_go_to,
    start_option,
    take_time,
    warn,
    warn_of_extrapolation,
)
from network.platform.stopping import time_to_tell
from network.report.progress import share_bar

LAST = 60.0
"""s in which a diagnosis that is stopped writes the best so far."""

jobs_option = click.option(
    "--jobs", type=Whole(1), default=os.cpu_count() or 1, show_default=True, metavar="N", help="processes"
)


@click.command()
@machine_options
@click.argument("recordings", nargs=-1, required=True, type=FileName())
@click.option("--holdout", multiple=True, type=FileName(), metavar="RECORDING", help="only predicted, never fitted")
@output_folder("out")
@jobs_option
@click.option("--seed", type=Whole(0), default=0, show_default=True, help="of all that is drawn")
@start_option
@click.option(
    "--budget", callback=take_time, default="2 min", show_default=True, metavar="TIME",
    help="after it the best so far is told",
)  # fmt: skip
@click.option("--no-plots", is_flag=True, help="no pictures")
@json_flag
def diagnose(
    machine: str, recordings: Sequence[str], holdout: Sequence[str], output: str, jobs: int, seed: int,
    start: str | None, budget: float, no_plots: bool, level: str | None, lumps: Sequence[str], sets: Sequence[str],
    as_json: bool,
) -> None:  # fmt: skip
    """Where a MACHINE and RECORDINGS differ, which physics was left out, and whether adding it holds."""
    with share_bar(f"diagnosing {Path(machine).name}") as bar:
        from network.analysis.diagnosis.diagnose import diagnose as run
        from network.recordings.channel_match import overheard
        from network.report.files.diagnosis_files import check_target, write_diagnosis

        results_go_to(output)
        loaded = read_machine(machine, level, lumps, sets)
        where = check_target(loaded, Path(output))
        begins, runs, held_out = read_start(start), [*read_recordings(recordings)], [*read_recordings(holdout)]
        with time_to_tell(LAST):
            result = run(loaded, runs, held_out, start=begins, seed=seed, jobs=jobs, progress=bar, seconds=budget)
            bar.now("drawing what was found", 1.0)
            written = write_diagnosis(result, where, pictures=not no_plots)
        text = "" if as_json else str(result)
    if as_json:
        print_json(result.summary())
    else:
        click.echo(f"{text}\n\nWritten: {', '.join(map(str, written))}")
    warn([*loaded.warnings, *overheard(loaded, runs, held_out), *warn_of_extrapolation(loaded, [*runs, *held_out])])
    if result.ended == "stopped":
        raise KeyboardInterrupt


@click.command()
@click.option("--cases", type=Whole(1), metavar="N", help="how many; 40, or as many as the resumed proof has")
@click.option("--seed", type=Whole(0), metavar="N", help="of what is concealed; 0; from 1000 on it is a scored proof")
@jobs_option
@output_folder("out/proof")
@click.option("--resume", type=FileName(), metavar="DIR", help="go on in a folder, and keep what is there if stopped")
@click.option("--ablate", metavar="STAGE", help="without a stage of the diagnosis, to see what it is worth")
@click.option("--time-two-cores", "timed", type=Whole(0), default=0, metavar="N", help="N cases again by two processes")
@click.option("--json", "json_file", type=FileName(), metavar="FILE", help="the score as JSON, '-' to print it")
def prove(
    cases: int | None, seed: int | None, jobs: int, output: str, resume: str | None, ablate: str | None, timed: int,
    json_file: str | None,
) -> None:  # fmt: skip
    """Conceals effects in machines of a separate truth, diagnoses each blind, then opens the keys and scores."""
    with share_bar("proving") as bar:
        from network.cli.proof import prove as run
        from network.platform.files import write_text
        from network.platform.folders import folder
        from network.report.files.result_files import as_json

        def tell(done: int, of: int, sentence: str) -> None:
            click.echo(f"{done}/{of} {sentence}", err=True)
            bar(done / max(of, 1))

        where = Path(resume or output)
        score = run(cases, seed, jobs, where, tell, resume=resume is not None, ablate=ablate, timed=timed)
        text = str(score) if json_file != "-" else ""
    if json_file == "-":
        print_json(score.summary())
        return
    click.echo(text)
    if json_file is not None:
        folder(Path(json_file).parent)
        write_text(Path(json_file), as_json(score.summary()))
