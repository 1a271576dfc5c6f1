"""The command `lptn warmup`."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import click

from network.cli.options import AskedMachine, json_flag, machine_options, results_go_to, tell_result
from network.report.progress import share_bar


@click.command()
@machine_options
@click.argument("scenario", type=click.Path())
@click.option("--tolerance", required=True, metavar="LENGTH", help="what may move over SCENARIO, like '2 um'")
@click.option("--speeds", metavar="A,B,… rpm", help="to choose from; default 50, 75, 100 % of SCENARIO's largest")
@click.option("--input", "driven", metavar="NAME", help="what warms up; default the speed")
@click.option("--longest", default="4 h", show_default=True, metavar="TIME", help="that is tried")
@click.option("-o", "--output", type=click.Path(), metavar="DIR", help="warmup.json and a picture of the trade")
@json_flag
def warmup(
    machine: AskedMachine, scenario: str, tolerance: str, speeds: str | None, driven: str | None, longest: str,
    output: str | None, as_json: bool,
) -> None:  # fmt: skip
    """The shortest warm-up of a MACHINE after which its tool centre point moves less than a tolerance over SCENARIO."""
    with share_bar(f"warming up {machine.name}") as bar:
        results_go_to(output)
        from network.recordings.scenario import Scenario

        read = cache(lambda: [Scenario.load(scenario)])
        loaded = machine.read(read)
        from network.analysis.sweep.warm_up import find_warm_up
        from network.recordings.yaml_values import read_time

        (work,) = read()
        found = find_warm_up(
            loaded, work, tolerance, speeds=speeds, longest=read_time("--longest", longest), driven=driven,
            progress=lambda share: bar.now("trying warm-ups", share),
        )  # fmt: skip
        written = []
        if output is not None:
            from network.platform.files import write_text
            from network.platform.publication import publication
            from network.report.figures.canvas import save
            from network.report.figures.warm_up_figure import warm_up_figure
            from network.report.files.result_files import as_json as json_text

            with publication(output) as draft:
                write_text(draft / "warmup.json", json_text(found.summary()))
                made = [draft / "warmup.json", save(warm_up_figure(found), draft / "warmup.png")]
            written = [Path(output) / path.name for path in made]
    tell_result(found, found.summary, written, as_json, loaded.warnings)
