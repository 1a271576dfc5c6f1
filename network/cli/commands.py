"""The command `lptn`: parse, call, print. Exit 0 done, 1 failed in computing, 2 refused input."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from network import __version__
from network.cli.calibrate_command import calibrate
from network.cli.compare_command import compare
from network.cli.demo_command import demo
from network.cli.diagnose_command import diagnose, prove
from network.cli.draft_command import draft
from network.cli.export_command import export
from network.cli.follow_command import follow
from network.cli.iso230_command import iso230
from network.cli.new_command import new
from network.cli.options import (
    AskedMachine,
    FileName,
    Whole,
    json_flag,
    machine_options,
    method_option,
    output_folder,
    page_flag,
    print_json,
    read_fitting,
    read_start,
    results_go_to,
    sources_of,
    start_option,
    tell_result,
    warn,
)
from network.cli.sweep_command import sweep
from network.cli.warmup_command import warmup
from network.platform.package_data import is_shipped
from network.platform.refusal import Complaints, Failed, Refused
from network.platform.threads import begin_on_one_thread
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.analysis.calibration.tcp_bands import Band
    from network.analysis.sweep.lumping_error import LumpingError
    from network.engine.superposition.superposition import Superposition
    from network.engine.trajectory import Trajectory
    from network.machine.machine import Machine
    from network.recordings.recording import Recording
    from network.recordings.scenario import Scenario


class _PipeClosed(Exception):
    """Nobody reads on: what is told is told, as with `lptn demo | head`."""


class _Commands(click.Group):
    def invoke(self, ctx: click.Context) -> Any:
        """click itself would end with 1 where a pipe is closed."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise _PipeClosed from None


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="lptn")
def cli() -> None:
    """Lumped-parameter thermal networks for machine tools: simulate speed schedules, compare with recordings."""


cli.add_command(calibrate)
cli.add_command(compare)
cli.add_command(demo)
cli.add_command(diagnose)
cli.add_command(export)
cli.add_command(follow)
cli.add_command(iso230)
cli.add_command(draft)
cli.add_command(new)
cli.add_command(prove)
cli.add_command(sweep)
cli.add_command(warmup)


@cli.command()
@machine_options
@click.argument("sources", nargs=-1, type=FileName())
@json_flag
def check(machine: AskedMachine, sources: Sequence[str], as_json: bool) -> None:
    """What is in a MACHINE, what is uncertain, what is wrong; with recordings or scenarios: whether they fit."""
    from network.machine.lumps import check_levels
    from network.report.words.check_summary import machine_summary, tell_source
    from network.report.words.describe import describe

    loaded = machine.read(sources_of(sources))
    words = [] if as_json else [describe(loaded)]
    complaints = Complaints()
    if machine.level is None:
        check_levels(loaded, complaints)
    for path in sources:
        try:
            words.append(tell_source(loaded, read_fitting(loaded, path)))
        except Refused as refused:
            complaints.absorb(refused)
    complaints.raise_if_any()
    if as_json:
        print_json(machine_summary(loaded))
    else:
        click.echo("\n\n".join(words))
    warn(map(str, loaded.warnings))


@cli.command()
@machine_options
@click.option("-o", "--output", required=True, type=FileName(), metavar="FILE", help="picture: .png, .svg or .pdf")
def draw(machine: AskedMachine, output: str) -> None:
    """The network of a MACHINE as a picture."""
    from network.platform.refusal import Spot, refuse

    path = Path(output)
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise refuse(Spot(output), "is no picture that can be drawn", "end it in .png, .svg or .pdf")
    with share_bar(f"drawing {machine.name}"):
        results_go_to(path.parent)
        loaded = machine.read()
        from network.platform.folders import folder
        from network.report.figures.canvas import save
        from network.report.figures.network_figure import network_figure

        folder(path.parent)
        save(network_figure(loaded), path)
    click.echo(f"{loaded.name}: network drawn in {path}")


@cli.command()
@machine_options
@click.argument("source", type=FileName())
@output_folder("out")
@method_option
@start_option
@click.option("--no-plots", is_flag=True, help="no pictures")
@click.option("--parquet", is_flag=True, help="results and parts as .parquet instead of .csv")
@click.option("--noise", is_flag=True, help="add every sensor's noise")
@click.option("--seed", type=Whole(0), default=0, show_default=True, help="of the noise")
@page_flag
@json_flag
def simulate(
    machine: AskedMachine, source: str, output: str, method: str, start: str | None, no_plots: bool, parquet: bool,
    noise: bool, seed: int, page: bool, as_json: bool,
) -> None:  # fmt: skip
    """Run a MACHINE through a scenario, or along the inputs of a recording (SOURCE)."""
    with share_bar(f"simulating {machine.name}") as bar:
        results_go_to(output)
        if parquet:
            from network.report.files.parquet_files import check_parquet

            check_parquet()
        read = sources_of([source])
        loaded, (driver,) = machine.read(read, start), read()
        from network.analysis.sweep.lumping_error import estimate_lumping
        from network.engine.simulation import simulate as run
        from network.engine.superposition.superpose import superpose
        from network.report.files.result_files import run_summary
        from network.report.words.band_words import summarise_bands, tell_bands

        result = run(
            loaded, driver, method=method, start=read_start(start), noise_seed=seed if noise else None,
            progress=bar.over([driver]),
        )  # fmt: skip
        shares, bands = superpose(result), _bands(loaded, driver, start)
        bar.now("cutting lumps more finely", 1.0)
        plain = None if noise else result
        lumping = estimate_lumping(loaded, driver, plain, start=read_start(start), method=method)
        bar.now("drawing the run", 1.0)
        written = _write(result, shares, bands, lumping, output, not no_plots, page, parquet)
        told = str(replace(result, warnings=()))  # which go to the other stream
        cut = [str(lumping), ""] if lumping is not None else []
        words = "\n".join([told, "", *cut, str(shares), *tell_bands(bands)])
    tell_result(
        words, lambda: run_summary(result, shares, lumping) | {"bands": summarise_bands(bands)}, written, as_json,
        result.warnings,
    )  # fmt: skip


def _write(
    result: Trajectory, shares: Superposition | None, bands: Sequence[Band], lumping: LumpingError | None, output: str,
    pictures: bool, page: bool, parquet: bool,
) -> list[Path]:  # fmt: skip
    from network.platform.publication import publication
    from network.report.files.result_files import RUN, write_bands, write_run

    with publication(output, RUN) as draft:
        made = write_run(result, draft, shares, lumping, parquet)
        made += write_bands(result, bands, draft)
        if pictures:
            from network.report.files.pictures import draw_run

            made += draw_run(result, draft, bands, shares)
        if page:
            from network.report.pages.result_pages import page_of_run, write_page

            made.append(write_page(page_of_run(result, shares, bands, lumping), draft))
    return [Path(output) / path.name for path in made]


def _bands(machine: Machine, driver: Scenario | Recording, start: str | None) -> tuple[Band, ...]:
    """Of a calibrated machine; any other has none and need not wait for what makes them."""
    if machine.validity is None:
        return ()
    from network.analysis.calibration.tcp_bands import bands_of

    return bands_of(machine, driver, read_start(start))


@cli.command()
@click.argument("kind", required=False)
def catalogue(kind: str | None) -> None:
    """The physics that can be written down: all kinds, one KIND with its equation and parameters, or `materials`."""
    from network.report.words.catalogue_page import catalogue_page

    click.echo(catalogue_page(kind))


@cli.command()
def schema() -> None:
    """JSON Schema of the machine file."""
    from network.machine.schema import schema as machine_schema

    print_json(machine_schema())


@cli.command()
@json_flag
def paper(as_json: bool) -> None:
    """The tables of the heat-quantity paper, with ours beside them."""
    from network.engine.paper.tables import paper_json, tell_paper

    if as_json:
        print_json(paper_json())
    else:
        click.echo("\n".join(tell_paper()))


def run(arguments: Sequence[str] | None = None) -> None:
    """Every refusal a sentence on stderr, never a traceback for bad input. Raises KeyboardInterrupt where stopped."""
    begin_on_one_thread()
    if not sys.warnoptions:  # what a computation warns of is told in a sentence, or is nothing to the user
        warnings.simplefilter("ignore", RuntimeWarning)
    try:
        cli.main(args=None if arguments is None else list(arguments), prog_name="lptn", standalone_mode=False)
    except Refused as refused:
        click.echo(str(refused), err=True)
        for file in sorted({refusal.spot.file for refusal in refused.refusals}):
            if is_shipped(file, sys.argv[1:] if arguments is None else arguments):
                click.echo(f"lptn: {file} came with lptn; copy it into your folder, change and name the copy", err=True)
        sys.exit(2)
    except Failed as failed:
        click.echo(f"lptn: {failed}", err=True)
        sys.exit(1)
    except click.exceptions.Exit as leave:
        sys.exit(leave.exit_code)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except _PipeClosed:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        click.echo(f"lptn: {error.filename or 'standard output'}: {error.strerror}", err=True)
        sys.exit(1)
    except click.Abort:
        raise KeyboardInterrupt from None
