"""`lptn sweep`: levels of simplification, varied numbers, or numbers drawn from what is not known of them."""

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
    method_option,
    read_start,
    results_go_to,
    sources_of,
    start_option,
    tell_result,
)
from network.platform.refusal import Complaints, Spot
from network.report.progress import share_bar

if TYPE_CHECKING:
    from network.analysis.sweep.sample import Sample
    from network.analysis.sweep.sweep import Sweep


@click.command()
@machine_options
@click.argument("source", type=FileName())
@click.option("--levels", metavar="A,B,…", help="paper, numbers of lumps, names of levels; default the usual ones")
@click.option(
    "--vary", multiple=True, metavar="PATH=VALUES", help="'links.skin.conductance=3..9 W/K:20' or '…=3,5,9 W/K'"
)
@click.option("--sample", "count", type=Whole(2), metavar="N", help="N runs, numbers drawn from their ± (or --vary)")
@click.option("--seed", type=Whole(0), default=0, show_default=True, help="of --sample")
@click.option(
    "--resume", type=FileName(), metavar="FILE", help="of --sample, --vary: keeps what is done, goes on from it"
)
@click.option("--parquet", is_flag=True, help="of --sample: sweep.parquet instead of sweep.csv")
@click.option("--tolerance", metavar="LENGTH", help="look for the coarsest level that stays within, like '1 um'")
@click.option("--jobs", type=Whole(1), default=1, show_default=True, metavar="N", help="processes")
@click.option("--cluster", metavar="ADDRESS", help="a dask scheduler, instead of processes")
@click.option("-o", "--output", type=FileName(), metavar="DIR", help="sweep.csv, sweep.json and a picture")
@method_option
@start_option
@json_flag
def sweep(
    machine: AskedMachine, source: str, levels: str | None, vary: Sequence[str], count: int | None, seed: int,
    resume: str | None, parquet: bool, tolerance: str | None, jobs: int, cluster: str | None, output: str | None,
    method: str, start: str | None, as_json: bool,
) -> None:  # fmt: skip
    """How far a MACHINE may be simplified along SOURCE, how its tool centre point answers to varied numbers, or how
    sure it is with numbers drawn from their ±."""
    _check(count, levels, tolerance, parquet)
    with share_bar(f"sweeping {machine.name}") as bar:
        results_go_to(output)
        read = sources_of([source])
        loaded = machine.read(read, start)
        (driver,), begin = read(), read_start(start)
        result: Sweep | Sample
        if count is not None:
            from network.analysis.sweep.sample import sample

            result = sample(
                loaded, driver, count, vary=vary, seed=seed, start=begin, method=method, jobs=jobs, cluster=cluster,
                resume=resume, progress=bar,
            )  # fmt: skip
        else:
            from network.analysis.sweep.sweep import sweep as run

            result = run(
                loaded, driver, levels=levels.split(",") if levels else (), vary=vary, tolerance=tolerance,
                start=begin, method=method, jobs=jobs, cluster=cluster, resume=resume, progress=bar,
            )  # fmt: skip
        written = _write(result, output, parquet, lambda: bar.now("drawing the sweep", 1.0))
    tell_result(result, result.summary, written, as_json, loaded.warnings)


def _check(count: int | None, levels: str | None, tolerance: str | None, parquet: bool) -> None:
    complaints = Complaints()
    if count is None:
        if parquet:
            complaints.refuse(Spot("--parquet"), "is for numbers that are drawn", "add --sample N")
    elif levels or tolerance:
        option = "--levels" if levels else "--tolerance"
        complaints.refuse(Spot(option), "compares levels, and --sample draws numbers at one", "leave one of them out")
    complaints.raise_if_any()
    if parquet:
        from network.report.files.parquet_files import check_parquet

        check_parquet()


def _write(result: Sweep | Sample, output: str | None, parquet: bool, say: Callable[[], None]) -> list[Path]:
    from network.analysis.sweep.sweep import Sweep
    from network.report.files.sweep_files import write_sample, write_sweep

    if output is None:
        return []
    if not isinstance(result, Sweep):
        return write_sample(result, output, parquet)
    say()
    return write_sweep(result, output)
