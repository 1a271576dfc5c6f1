"""The commands `lptn diagnose` and `lptn prove`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import click

from network.cli.options import (
    AskedMachine,
    FileName,
    Whole,
    json_flag,
    machine_options,
    output_folder,
    print_json,
    read_start,
    recordings_of,
    results_go_to,
    start_option,
    tell_result,
    warn_of_extrapolation,
)
from network.platform.stopping import time_to_tell
from network.report.progress import share_bar

LAST = 60.0
"""s in which a diagnosis that is stopped writes the best so far."""

jobs_option = click.option(
    "--jobs", type=Whole(1), default=os.cpu_count() or 1, show_default=True, metavar="N", help="processes"
)


def take_time(ctx: click.Context, param: click.Parameter, value: str) -> float:
    """A time above zero, `5 min`, in seconds. Raises Refused."""
    from network.recordings.yaml_values import read_time

    return read_time(f"--{param.name}", value)


class TwoSets(click.Command):
    """Takes `MACHINE NEW… --reference OLD…` as it stands: all names behind --reference, up to the next option, are of
    then where those of now stand before it."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        return super().parse_args(ctx, spread_references(args))


def spread_references(words: Sequence[str]) -> list[str]:
    """--reference before each of its names."""
    first = next((i for i, word in enumerate(words) if word.startswith("-")), len(words))
    if first < 2 or "--reference" not in words:
        return [*words]
    out, is_behind = list[str](), False
    for word in words:
        if word.startswith("-"):
            is_behind = word == "--reference"
            out += [] if is_behind else [word]
        else:
            out += ["--reference", word] if is_behind else [word]
    return [*out, "--reference"] if words[-1] == "--reference" else out


@click.command(cls=TwoSets)
@machine_options
@click.argument("recordings", nargs=-1, required=True, type=FileName())
@click.option("--holdout", multiple=True, type=FileName(), metavar="RECORDING", help="only predicted, never fitted")
@click.option("--reference", multiple=True, type=FileName(), metavar="OLD", help="of then: what has changed since")
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
    machine: AskedMachine, recordings: Sequence[str], holdout: Sequence[str], reference: Sequence[str], output: str,
    jobs: int, seed: int, start: str | None, budget: float, no_plots: bool, as_json: bool,
) -> None:  # fmt: skip
    """Where a MACHINE and RECORDINGS differ, which physics was left out, and whether adding it holds.

    With --reference: which numbers and sensors have changed since the recordings of then.
    """
    if reference and holdout:
        raise click.UsageError("--reference and --holdout do not go together; leave --holdout out")
    if reference:
        _compare_sets(machine, recordings, reference, output, seed, start, no_plots, as_json)
        return
    with share_bar(f"diagnosing {machine.name}") as bar:
        from network.analysis.diagnosis.diagnose import diagnose as run
        from network.recordings.channel_match import overheard
        from network.report.files.diagnosis_files import check_target, summarise_diagnosis, write_diagnosis

        results_go_to(output)
        read = recordings_of(recordings)
        loaded = machine.read(read, start)
        where = check_target(loaded, Path(output))
        begins, runs, held_out = read_start(start), read(), recordings_of(holdout)()
        with time_to_tell(LAST):
            result = run(loaded, runs, held_out, start=begins, seed=seed, jobs=jobs, progress=bar, seconds=budget)
            bar.now("drawing what was found", 1.0)
            written = write_diagnosis(result, where, pictures=not no_plots)
        text = "" if as_json else str(result)
    doubts = [*overheard(loaded, runs, held_out), *warn_of_extrapolation(loaded, [*runs, *held_out])]
    tell_result(text, lambda: summarise_diagnosis(result), written, as_json, [*loaded.warnings, *doubts])
    if result.ended == "stopped":
        raise KeyboardInterrupt


def _compare_sets(
    machine: AskedMachine, new: Sequence[str], old: Sequence[str], output: str, seed: int, start: str | None,
    no_plots: bool, as_json: bool,
) -> None:  # fmt: skip
    """Then and now."""
    with share_bar(f"comparing {machine.name} then and now") as bar:
        from network.analysis.change.changes import find_changes
        from network.report.files.change_files import write_changes
        from network.report.files.diagnosis_files import check_target

        results_go_to(output)
        both = recordings_of([*new, *old])
        loaded = machine.read(both, start)
        where, begins = check_target(loaded, Path(output)), read_start(start)
        now, then = both()[: len(new)], both()[len(new) :]
        found = find_changes(loaded, now, then, start=begins, seed=seed, progress=bar)
        written = write_changes(found, where, pictures=not no_plots)
        text = "" if as_json else str(found)
    doubts = [*found.warnings, *warn_of_extrapolation(loaded, both())]
    tell_result(text, found.summary, written, as_json, [*loaded.warnings, *doubts])


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
