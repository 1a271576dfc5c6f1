"""The command `lptn compare`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from network.cli.options import (
    AskedMachine,
    FileName,
    check_page,
    machine_options,
    method_option,
    page_flag,
    read_start,
    recordings_of,
    results_go_to,
    start_option,
    tell_result,
    warn_of_extrapolation,
)
from network.platform.refusal import Spot, refuse
from network.recordings.start_rule import ESTIMATED
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.analysis.comparison.compare import Comparison
    from network.analysis.sweep.lumping_error import LumpingError
    from network.machine.machine import Machine
    from network.recordings.inputs import Start
    from network.recordings.recording import Recording
    from network.report.progress import Bar


@click.command()
@machine_options
@click.argument("recordings", nargs=-1, required=True, type=FileName())
@click.option("--json", "json_file", type=FileName(), metavar="FILE", help="residuals as JSON, '-' to print them")
@click.option("-o", "--output", type=FileName(), metavar="DIR", help="pictures of measured over simulated")
@page_flag
@method_option
@start_option
@click.option("--held-out", is_flag=True, help="estimate each start from its beginning, not scored, as calibrate does")
@click.option("--no-plots", is_flag=True, help="no pictures")
def compare(
    machine: AskedMachine, recordings: Sequence[str], json_file: str | None, output: str | None, page: bool,
    method: str, start: str | None, held_out: bool, no_plots: bool,
) -> None:  # fmt: skip
    """Residuals of a MACHINE on RECORDINGS, per channel, in units of noise; --start estimated finds the temperatures at
    the start of each from it, --held-out from its beginning alone, as calibrate and diagnose tell runs held out."""
    check_page(page, output)
    with share_bar(f"comparing {machine.name}") as bar:
        results_go_to(output)
        if json_file not in (None, "-"):
            results_go_to(Path(str(json_file)).parent)
        read = recordings_of(recordings)
        loaded = machine.read(read, start)
        from network.analysis.comparison.common_start import doubt_starts
        from network.analysis.sweep.lumping_error import estimate_on_recording
        from network.recordings.channel_match import overheard

        given = read()
        result, stated = _lay_beside(loaded, given, start, held_out, method, bar)
        bar.now("testing residuals", 1.0)
        text, summary = _tell(loaded, result, json_file != "-")
        lumping = estimate_on_recording(loaded, result.recordings, start=stated, method=method)
        if lumping is not None:
            text, summary = f"{text}\n{lumping}", summary | {"lumping": lumping.summary()}
        written = _write(result, lumping, summary, None if no_plots else output, json_file, page)
    doubts = [*overheard(loaded, given, ()), *doubt_starts(loaded, given, stated),
              *warn_of_extrapolation(loaded, given)]  # fmt: skip
    tell_result(text, lambda: summary, written, json_file == "-", [*loaded.warnings, *doubts, *result.warnings])


def _lay_beside(
    machine: Machine, given: Sequence[Recording], start: str | None, held_out: bool, method: str, bar: Bar
) -> tuple[Comparison, Start | None]:
    """The comparison, and where its runs were told to begin."""
    if held_out and start not in (None, ESTIMATED):
        raise refuse(Spot("--start"), f"{start} beside --held-out, which finds it", "take one of them out")
    if held_out or start == ESTIMATED:
        from network.analysis.calibration.estimated_constants import compare_estimating

        return compare_estimating(machine, given, held_out), None
    from network.analysis.comparison.compare import compare as lay_beside

    stated = read_start(start)
    return lay_beside(machine, given, start=stated, method=method, progress=bar.over(given)), stated


def _tell(machine: Machine, result: Comparison, in_words: bool) -> tuple[str, dict[str, Any]]:
    """What is said and what goes into JSON; of a calibrated machine with the share of readings inside its bands."""
    from network.analysis.calibration.band_coverage import measure_coverage
    from network.report.words.band_words import tell_coverage

    coverage = measure_coverage(machine, result)
    text = "\n".join([str(result), *tell_coverage(coverage)]) if in_words else ""
    return text, result.summary() | {"coverage": [c.summary() for c in coverage]}


def _write(
    result: Comparison, lumping: LumpingError | None, summary: dict[str, Any], output: str | None,
    json_file: str | None, page: bool,
) -> list[Path]:  # fmt: skip
    """Pictures, page and residuals, at once where they go into one folder; pictures and page that were written."""
    from network.platform.files import write_text
    from network.platform.folders import folder
    from network.platform.publication import publication
    from network.report.files.pictures import draw_comparison
    from network.report.files.result_files import as_json

    left = None if json_file in (None, "-") else Path(str(json_file))
    written: list[Path] = []
    if output is not None:
        with publication(output) as draft:
            written = [Path(output) / path.name for path in draw_comparison(result, draft)]
            if page:
                from network.report.pages.result_pages import page_of_comparison, write_page

                written.append(Path(output) / write_page(page_of_comparison(result, lumping), draft).name)
            if left is not None and left.parent.resolve() == Path(output).resolve() and not left.is_symlink():
                write_text(draft / left.name, as_json(summary))
                left = None
    if left is not None:
        folder(left.parent)
        write_text(left, as_json(summary))
    return written
