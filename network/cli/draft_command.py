"""The command `lptn draft`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from network.cli.options import json_flag, print_json, recordings_of, results_go_to, warn
from network.platform.refusal import Spot, refuse
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.analysis.drafting.machine_draft import Draft


@click.command()
@click.argument("recordings", nargs=-1, required=True, type=click.Path())
@click.option("-o", "--output", type=click.Path(), metavar="FILE", help="the machine file; printed without")
@click.option(
    "--input", "inputs", multiple=True, metavar="NAME", help="a column that drives: heat, or a held temperature"
)
@click.option("--sensor", "sensors", multiple=True, metavar="NAME", help="a column that is measured on a part")
@click.option("--ambient", default="", metavar="NAME", help="the temperature of the surroundings")
@json_flag
def draft(
    recordings: Sequence[str], output: str | None, inputs: Sequence[str], sensors: Sequence[str], ambient: str,
    as_json: bool,
) -> None:  # fmt: skip
    """A first machine file from RECORDINGS alone: parts from sensors that move alike, sources from inputs, everything
    ±, and sentences that say why."""
    with share_bar("drafting a machine") as bar:
        if output is not None:
            _check_target(Path(output))
            results_go_to(Path(output).parent)
        from network.analysis.drafting.channel_roles import Wishes
        from network.analysis.drafting.machine_draft import draft as make

        given = recordings_of(recordings)()
        result = make(given, Wishes(tuple(inputs), tuple(sensors), ambient), progress=bar)
    _print(result, output, as_json)
    warn([*(remark for one in given for remark in one.remarks), *result.warnings])


def _check_target(path: Path) -> None:
    """A file that was worked on is never replaced, one that was drafted is."""
    from network.analysis.drafting.machine_draft import DRAFTED

    if path.suffix.lower() not in (".yaml", ".yml"):
        raise refuse(Spot(str(path)), "is no machine file", "end it in .yaml")
    if path.is_file() and not path.read_bytes().startswith(DRAFTED.encode()):
        raise refuse(Spot(str(path)), "is there and was not drafted", "give another -o")


def _print(result: Draft, output: str | None, as_json: bool) -> None:
    from network.platform.files import write_text
    from network.platform.folders import folder

    if output is not None:
        folder(Path(output).parent)
        write_text(Path(output), result.text)
    if as_json:
        print_json(result.summary() | {"machine": output})
    else:
        click.echo(str(result) if output is not None else result.text, nl=output is not None)
    if output is not None:
        click.echo(f"\nWritten: {output}", err=as_json)
