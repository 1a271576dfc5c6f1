"""Sweeps over drawn numbers: what is drawn, what the scatter tells, runs side by side, after a stop, over a cluster."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine

from network import Machine, Refused, Scenario
from network.analysis.sweep import batched_runs
from network.analysis.sweep.batched_runs import batch_of, run_sample
from network.analysis.sweep.first_order import first_order_shares
from network.analysis.sweep.level_runs import Job
from network.analysis.sweep.sample import Sample, sample
from network.analysis.sweep.sample_runs import SampleJob, run_one
from network.analysis.sweep.sampling import choose_drawn, latin_hypercube
from network.cli import main

ROOT = Path(__file__).parent.parent
GANTRY, WARM_UP = ROOT / "machines/gantry_spindle.yaml", ROOT / "scenarios/warm_up_and_stop.yaml"
HOUR = Scenario.of("an hour", "1 h", {"air": "20 degC"}, output="30 s")


def block(**links: Any) -> Machine:
    """A block that settles within the hour: its rise is power over conductance, and moves z."""
    return machine(
        {"block": {"heat_capacity": "1 kJ/K ± 10 %"}, "air": {"temperature": "20 degC"}},
        links={"skin": {"kind": "convection", "between": ["block", "air"], "conductance": "5 W/K ± 20 %"}, **links},
        sources={"heater": {"kind": "heat_source", "into": {"block": 1}, "power": "50 W ± 10 %"}},
        tcp={"z": {"grows": {"kind": "stretching", "of": "block", "direction": 1, "length": "100 mm",
                             "expansion": "1e-5 1/K"}}},
    )  # fmt: skip


def test_a_latin_hypercube_draws_once_from_every_piece() -> None:
    drawn = latin_hypercube(64, 3, seed=1)
    assert (np.sort((drawn * 64).astype(int), axis=0) == np.arange(64)[:, None]).all()
    assert np.abs(np.corrcoef(drawn.T) - np.eye(3)).max() < 0.4
    assert not (drawn == latin_hypercube(64, 3, seed=2)).all()


def test_numbers_are_drawn_from_their_priors_and_from_ranges() -> None:
    paths = [d.path for d in choose_drawn(block(), ())]
    assert sorted(paths) == ["links.skin.conductance", "nodes.block.heat_capacity", "sources.heater.power"]
    result = sample(block(), HOUR, 2000, seed=3)
    skin = np.log(result.numbers[:, result_index(result, "links.skin.conductance")])
    assert (skin.mean(), skin.std()) == (pytest.approx(np.log(5), abs=1e-3), pytest.approx(0.2, rel=5e-3))
    ranged = sample(block(), HOUR, 500, vary=["links.skin.conductance=3..9 W/K"])
    assert ranged.numbers.shape == (500, 1)
    assert (ranged.numbers.min(), ranged.numbers.max()) == (pytest.approx(3, abs=0.02), pytest.approx(9, abs=0.02))


def result_index(result: Sample, path: str) -> int:
    return [d.path for d in result.drawn].index(path)


def test_the_scatter_is_that_of_the_settled_block() -> None:
    """Settled, z = α L P/G: logarithms add, so its variance is 0.2² + 0.1², of which 80 % is the conductance's."""
    result = sample(block(), HOUR, 4000)
    final = result.shown["z", "final"]
    assert np.log(final).std() == pytest.approx(np.hypot(0.2, 0.1), rel=0.02)
    assert np.median(final) == pytest.approx(1e-5 * 0.1 * 10 * 1e6, rel=0.01)
    found = result.scatter["z", "final"]
    assert (found.low, found.high) == (pytest.approx(10 * np.exp(-1.96 * 0.2236), rel=0.03),
                                       pytest.approx(10 * np.exp(1.96 * 0.2236), rel=0.03))  # fmt: skip
    assert result.shares["z", "final"] == pytest.approx(
        {"links.skin.conductance": 0.8, "sources.heater.power": 0.2, "nodes.block.heat_capacity": 0.0}, abs=0.03
    )


def test_shares_of_a_sum_are_those_of_its_variances_and_of_a_product_of_centred_numbers_none() -> None:
    x = np.random.default_rng(0).standard_normal((5000, 3))
    assert first_order_shares(x, x @ [3.0, 1.0, 0.0]) == pytest.approx([0.9, 0.1, 0.0], abs=0.02)
    assert first_order_shares(x, x[:, 0] * x[:, 1]) == pytest.approx([0.0, 0.0, 0.0], abs=0.05)


def shared_job(of: Machine, scenario: Scenario) -> SampleJob:
    return SampleJob(Job(of, scenario), choose_drawn(of, ()))


@pytest.mark.parametrize("of", [lambda: block(), lambda: Machine.load(GANTRY)], ids=["block", "gantry"])
def test_runs_side_by_side_are_those_one_by_one(of: Callable[[], Machine]) -> None:
    scenario = HOUR if of().name == "test" else Scenario.load(WARM_UP)
    shared = shared_job(of(), scenario)
    assert batch_of(shared) is not None
    points = np.stack([d.at(latin_hypercube(5, 1, i)[:, 0]) for i, d in enumerate(shared.drawn)], axis=1)
    one_by_one = np.stack([run_one(shared, point) for point in points])
    assert run_sample(shared, points) == pytest.approx(one_by_one, rel=1e-9, abs=1e-14)


def test_what_cannot_run_side_by_side_runs_one_by_one() -> None:
    radiates = {"kind": "radiation", "between": ["block", "air"], "emissivity_area": "0.02 m^2"}
    shared = shared_job(block(glow=radiates), HOUR)
    assert batch_of(shared) is None
    assert sample(block(glow=radiates), HOUR, 3).values.shape == (3, 3)


def test_a_batch_that_is_wrong_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batched_runs.Batch, "_capacities",
                        lambda self, v: np.full((len(v), len(self.network.free)), 1001.0))  # fmt: skip
    assert batch_of(shared_job(block(), HOUR)) is None


def test_a_stopped_sweep_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, kept = sample(block(), HOUR, 600), tmp_path / "kept"
    sample(block(), HOUR, 600, resume=kept)
    lines = kept.read_text().split("\n")
    kept.write_text("\n".join([*lines[:400], lines[400][:7]]))
    done: list[int] = []

    def count(shared: SampleJob, values: np.ndarray) -> np.ndarray:
        done.append(len(values))
        return run_sample(shared, values)

    monkeypatch.setattr("network.analysis.sweep.sample.run_sample", count)
    again = sample(block(), HOUR, 600, resume=kept)
    assert sum(done) == 600 - 399 and again.values == pytest.approx(whole.values, rel=1e-12)
    sample(block(), HOUR, 600, resume=kept)
    assert sum(done) == 600 - 399
    with pytest.raises(Refused, match="belongs to another sweep; give another file"):
        sample(block(), HOUR, 600, seed=1, resume=kept)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--sample", "5", "--vary", "links.skin.conductance=3,5 W/K"], "is no range to draw from"),
        (["--sample", "5", "--vary", "links.housing skin.conductance=9..3 W/K"], "end first, from 0 W/K to 1e+06 W/K"),
        (["--sample", "5", "--vary", "sources.motor loss.reference_speed=9..3 rpm"], "from 0 rpm to 3e+05 rpm"),
        (["--sample", "5", "--vary", "links.housing skin.conductance=3..9 mm"], "give it in a unit like W/K"),
        (["--sample", "5", "--vary", "links.nothing.conductance=3..9 W/K"], "there is no number"),
        (["--sample", "5", "--levels", "1,2"], "--levels: compares levels, and --sample draws"),
        (["--resume", "x"], "--resume: keeps the runs of a grid, and levels are few; add --vary"),
        (["--sample", "2000000"], "give 2 to 1000000"),
    ],
)
def test_refusals_of_a_sample(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["sweep", str(GANTRY), str(WARM_UP), *arguments])
    assert left.value.code == 2 and told in capsys.readouterr().err


def test_the_command_writes_columns_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["sweep", str(GANTRY), str(WARM_UP), "--sample", "250", "-o", str(tmp_path)])
    told, summary = capsys.readouterr().out, json.loads((tmp_path / "sweep.json").read_text())
    assert "250 runs with 18 numbers drawn (seed 0)" in told and "The final value along z scatters by" in told
    lines = (tmp_path / "sweep.csv").read_text().split("\n")
    assert len(lines) == 252 and lines[0].endswith("z final [um],y max [um],y min [um],y final [um]")
    assert summary["runs"] == 250 and set(summary["tcp"]["z"]["final"]) == {
        "mean", "std", "low95", "high95", "unit", "shares"}  # fmt: skip


def test_columns_as_parquet(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    main(["sweep", str(GANTRY), str(WARM_UP), "--sample", "20", "--parquet", "-o", str(tmp_path / "sweep")])
    assert parquet.read_table(tmp_path / "sweep/sweep.parquet").num_rows == 20
    main(["simulate", str(GANTRY), str(WARM_UP), "--no-plots", "--parquet", "-o", str(tmp_path / "run")])
    table = parquet.read_table(tmp_path / "run/results.parquet")
    assert table.column_names[0] == "time [s]" and "T_housing [degC]" in table.column_names


# -- a cluster ------------------------------------------------------------------------------------------------------
@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    environment = os.environ | {"PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}", "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen([sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]],
                               env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def test_a_cluster_of_two_workers_one_of_them_killed(tmp_path: Path) -> None:
    """A scheduler and two workers on the loopback; one is killed in the midst, and nothing is lost."""
    distributed = pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    worker = ("dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard", "--no-nanny",
              "--local-directory", str(tmp_path), "--host", "127.0.0.1")  # fmt: skip
    with (
        started("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *worker[1:3]),
        started(*worker),
        started(*worker) as doomed,
    ):
        wait_for(file.exists)
        address = json.loads(file.read_text())["address"]
        with distributed.Client(address, timeout="30 s") as client:
            client.wait_for_workers(2, timeout=60)
            killed: list[float] = []

            def kill_one(share: float) -> None:
                if not killed:
                    doomed.send_signal(signal.SIGKILL)
                    killed.append(share)

            over = sample(block(), HOUR, 6000, cluster=address, progress=kill_one)
            wait_for(lambda: len(client.scheduler_info()["workers"]) == 1)
    assert killed and killed[0] < 0.5
    assert over.values == pytest.approx(sample(block(), HOUR, 6000, jobs=1).values, rel=1e-12)


def wait_for(there: Callable[[], bool], seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while not there():
        assert time.monotonic() < until
        time.sleep(0.1)
