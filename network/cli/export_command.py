"""The command `lptn export`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from network.cli.options import (
    Whole,
    json_flag,
    machine_options,
    output_folder,
    print_json,
    read_machine,
    results_go_to,
    warn,
)
from network.report.progress import share_bar

FORMS = ("c",)


@click.command()
@machine_options
@click.argument("sources", nargs=-1, type=click.Path())
@click.option("--as", "form", type=click.Choice(FORMS), required=True, help="what the control takes")
@click.option("--inputs", metavar="A,B,…", help="the inputs and sensors that the control has; default all")
@click.option("--states", type=Whole(1), metavar="N", help="default as many as lose less than the displacement's noise")
@click.option("--step", default="10 s", show_default=True, metavar="TIME", help="between two steps of the control")
@output_folder("out")
@json_flag
def export(
    machine: str, sources: Sequence[str], form: str, inputs: str | None, states: int | None, step: str, output: str,
    level: str | None, lumps: Sequence[str], sets: Sequence[str], as_json: bool,
) -> None:  # fmt: skip
    """A MACHINE as a correction for a control, with the micrometres lost on every scenario or recording (SOURCES)."""
    with share_bar(f"exporting {Path(machine).name}") as bar:
        results_go_to(output)
        loaded = read_machine(machine, level, lumps, sets)
        from network.analysis.correction.channels_given import read_channels, read_step
        from network.analysis.correction.correction import make_correction
        from network.recordings.load_source import load_source
        from network.report.files.correction_files import write_correction
        from network.report.files.result_files import folder
        from network.report.files.step_timing import time_step

        channels = read_channels(loaded, inputs)
        given = [load_source(path) for path in sources]
        result = make_correction(loaded, given, states=states, channels=channels, step=read_step(step))
        bar.now("writing the correction", 1.0)
        written = write_correction(result, folder(output))
        seconds = time_step(written[0])
    if as_json:
        print_json(result.summary() | {"step_seconds": seconds})
    else:
        click.echo(str(result))
        if seconds is not None:
            click.echo(f"A step takes {1e6 * seconds:.2g} µs here.")
        click.echo(f"\nWritten: {', '.join(map(str, written))}")
    warn(map(str, loaded.warnings))
