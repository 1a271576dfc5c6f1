"""The command `lptn export`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from network.cli.options import (
    AskedMachine,
    Whole,
    json_flag,
    machine_options,
    output_folder,
    results_go_to,
    sources_of,
    tell_result,
)
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.machine.machine import Machine
    from network.recordings.recording import Recording
    from network.recordings.scenario import Scenario

FORMS = ("c", "fmu", "table", "sinumerik", "heidenhain", "beckhoff")


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
    machine: AskedMachine, sources: Sequence[str], form: str, inputs: str | None, states: int | None, step: str,
    output: str, as_json: bool,
) -> None:  # fmt: skip
    """A MACHINE as a correction for a control, with the micrometres lost on every scenario or recording (SOURCES)."""
    with share_bar(f"exporting {machine.name}"):
        results_go_to(output)
        read = sources_of(sources)
        loaded = machine.read(read)
        from network.analysis.correction.channels_given import read_channels
        from network.platform.publication import publication
        from network.recordings.yaml_values import read_time

        channels, given = read_channels(loaded, inputs), read()
        with publication(output) as draft:
            if form in ("c", "fmu"):
                text, summary, made = _as_code(loaded, given, form, channels, states, read_time("--step", step), draft)
            else:
                text, summary, made = _as_formulas(loaded, given, channels, form, draft)
        written = [Path(output) / path.name for path in made]
    tell_result(text, lambda: summary, written, as_json, loaded.warnings)


def _as_code(
    machine: Machine, sources: Sequence[Scenario | Recording], form: str, channels: Sequence[str] | None,
    states: int | None, step: float, where: Path,
) -> tuple[str, dict[str, Any], list[Path]]:  # fmt: skip
    from network.analysis.correction.correction import make_correction
    from network.report.files.correction_files import write_correction

    result = make_correction(machine, sources, states=states, channels=channels, step=step)
    written, sentence, told = write_correction(result, form, where)
    return "\n".join(filter(None, [str(result), sentence])), result.summary() | told, written


def _as_formulas(
    machine: Machine, sources: Sequence[Scenario | Recording], channels: Sequence[str] | None, form: str, where: Path
) -> tuple[str, dict[str, Any], list[Path]]:
    from network.analysis.correction.temperature_formula import fit_formulas
    from network.report.files.formula_files import write_formulas

    result = fit_formulas(machine, sources, channels)
    return str(result), result.summary(), write_formulas(result, form, where)
