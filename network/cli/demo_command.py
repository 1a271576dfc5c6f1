"""The command `lptn demo`."""

from __future__ import annotations

from collections.abc import Iterator

import click

from network.cli.options import output_folder, results_go_to
from network.report.progress import share_bar


@click.command()
@output_folder("out/demo")
def demo(output: str) -> None:
    """The main job on machines that come with lptn: simulate a schedule, see the tool centre point move, find out how
    simple the machine may be, compare it with recordings, and find and add the physics that it lacks."""
    lines = _tell_lines(output)
    while True:
        with share_bar("working on the demonstration"):
            line = next(lines, None)
        if line is None:
            return
        click.echo(line)


def _tell_lines(output: str) -> Iterator[str]:
    """Nothing is loaded before the first line is asked for."""
    from network.cli.demo_story import tell_demo

    results_go_to(output)
    yield from tell_demo(output)
