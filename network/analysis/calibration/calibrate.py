"""From a machine with uncertain numbers and recordings of it to the calibrated machine, and how far to believe it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.calibration.band_coverage import Coverage, measure_coverage
from network.analysis.calibration.estimated_constants import Numbers, compare_all_estimated
from network.analysis.calibration.identifiability_report import (
    describe_constants,
    describe_disagreements,
    describe_holdout,
    sentences,
    shift,
)
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import chi_of
from network.analysis.calibration.noise import Noise
from network.analysis.calibration.null import estimate_null
from network.analysis.calibration.one_machine import Disagreement, find_disagreements
from network.analysis.calibration.recording_admission import admit, check_apart, check_parameters
from network.analysis.calibration.robust_fit import Fit
from network.analysis.calibration.tcp_bands import Band, bands
from network.analysis.calibration.uncertainty import Uncertainty
from network.analysis.comparison.channel_residual import pool_residuals
from network.analysis.comparison.common_start import doubt_starts, share_starts
from network.analysis.comparison.compare import Comparison, compare
from network.analysis.sweep.lumping_error import LumpingError, estimate_on_recording
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, at_prior_centres, free_parameters
from network.machine.machine import Machine
from network.platform.printing import Tabled, summarise
from network.platform.stages import Stage, say
from network.platform.threads import on_one_thread
from network.recordings.call_arguments import as_several, expect_fit
from network.recordings.channel_match import overheard
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import runs_of, tell_excluded

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Tabled):
    """The outcome. machine: with value ± standard error for each number; original: as it was given; fit, known: the
    minimum and its uncertainty; before, after, before_holdout, after_holdout: residuals on the recordings calibrated on
    and on those held out (None without), the constants of each run estimated, of those held out from their beginning;
    `before` with unknown numbers at their priors' centres; stated, stated_holdout: after with constants as stated and
    starts by rule, as `simulate` runs it; bands: of the tool centre point, by recording; coverage: of
    its bands on the runs held out; disagreements: numbers that
    runs want differently; warnings: what was wrong with the input; sentences: what the result means; cut: what
    finer lumps would change of the calibrated machine."""

    machine: Machine
    original: Machine
    parameters: tuple[Parameter, ...]
    fit: Fit
    known: Uncertainty
    before: Comparison
    after: Comparison
    before_holdout: Comparison | None
    after_holdout: Comparison | None
    stated: Comparison
    stated_holdout: Comparison | None
    bands: tuple[tuple[Band, ...], ...]
    coverage: tuple[Coverage, ...]
    disagreements: tuple[Disagreement, ...]
    warnings: tuple[str, ...]
    sentences: tuple[str, ...]
    tried: int
    seed: int
    seconds: float
    cut: LumpingError | None = None

    @property
    def theta(self) -> Array:
        return self.fit.at.theta

    @property
    def std(self) -> Array:
        """1σ of θ: of the logarithm, or of the number itself."""
        return self.known.std

    @property
    def correlation(self) -> Array:
        return self.known.correlation

    @cached_property
    def shift(self) -> Array:
        """How far each number moved, in prior σ; NaN where the prior was flat."""
        return shift(self.parameters, self.theta)

    @property
    def noise(self) -> Noise:
        return self.fit.noise

    @property
    def data(self) -> tuple[Measured, ...]:
        return self.fit.at.problem.data

    def summary(self) -> dict[str, Any]:
        """calibration.json."""
        return summarise(self)

    def __repr__(self) -> str:
        return f"<calibration of {self.original.name}: rmse {self.after.rmse_in_noise:.3g} σ>"


@on_one_thread
def calibrate(
    machine: Machine, recordings: Recording | Iterable[Recording], holdout: Recording | Iterable[Recording] = (), *,
    start: Start | None = None, seed: int = 0, progress: Progress | None = None,
) -> Calibration:  # fmt: skip
    """The most probable values of the machine's uncertain numbers, given recordings and priors.

    holdout: recordings that are only predicted; start: overrides where runs begin (it stays uncertain); seed: of
    further beginnings; progress: told the share done. Raises Refused for input that cannot be used, Failed where every
    run breaks down.
    """
    began, tell = time.perf_counter(), progress or (lambda share: None)
    given = as_several(recordings), as_several(holdout)
    expect_fit(machine, given[0], start)
    train, held_out = share_starts(machine, runs_of(machine, given[0]), runs_of(machine, given[1]), start)
    parameters = free_parameters(machine)
    check_parameters(machine, parameters)
    check_apart(*given)
    check_apart(train, held_out)
    with np.errstate(over="ignore", invalid="ignore"):
        found = _calibrate(machine, parameters, train, held_out, start, seed, tell, began)
    return replace(found, warnings=(*overheard(machine, *given), *found.warnings, *tell_excluded(held_out)))


def _calibrate(
    machine: Machine, parameters: tuple[Parameter, ...], train: Sequence[Recording], held_out: Sequence[Recording],
    start: Start | None, seed: int, tell: Progress, began: float,
) -> Calibration:  # fmt: skip
    say(tell, "looking at the recordings")
    let_in = admit(machine, parameters, train, start)
    null = estimate_null(machine, parameters, let_in.data, start, seed, Stage(tell, 0.1, 0.9))
    left = f"{chi_of(null.fit.at):.3g} σ left"
    say(tell, f"{left}; how well each number is known")
    fit, known = null.fit, null.known
    say(tell, f"{left}; bands, and every recording beside it")
    result, off = null.machine, null.machine.calibrated.left if null.machine.calibrated else {}
    areas = tuple(
        bands(machine, parameters, fit.at.theta, known.theta_covariance, r, start, off) for r in (*train, *held_out)
    )
    before, before_holdout = _compare_runs(Numbers.of(at_prior_centres(machine, parameters), start), train, held_out)
    after, after_holdout = _compare_runs(replace(null.numbers(start), machine=result), train, held_out)
    stated = compare(result, train, start=start), compare(result, held_out, start=start) if held_out else None
    findings = [*describe_holdout(before_holdout, after_holdout, after), *sentences(null.found, fit, known)]
    findings += describe_constants(after, stated[0])
    doubts = doubt_starts(machine, (*train, *held_out), start)
    apart = find_disagreements(null)
    findings += describe_disagreements(apart)
    return Calibration(
        result, machine, parameters, fit, known, before, after, before_holdout, after_holdout, *stated,
        areas, measure_coverage(result, after_holdout), apart, (*doubts, *let_in.warnings), tuple(findings),
        null.found.tried, seed, time.perf_counter() - began,
        estimate_on_recording(result, stated[0].recordings, start=start, asks=False),
    )  # fmt: skip


def _compare_runs(
    of: Numbers, train: Sequence[Recording], held_out: Sequence[Recording]
) -> tuple[Comparison, Comparison | None]:
    after = compare_all_estimated(of, train)
    assert after is not None
    return after, compare_all_estimated(of, held_out, held_out=True)


def pool_channels(comparison: Comparison) -> Mapping[str, dict[str, Any]]:
    """Residuals of each channel over all recordings."""
    out = {}
    for name in dict.fromkeys(n for r in comparison.recordings for n in r.channels):
        several = [r.channels[name] for r in comparison.recordings if name in r.channels]
        summaries = [c.summary() for c in several if c.n]
        n = sum(t["n"] for t in summaries)
        if n:
            rmse = float(np.sqrt(sum(t["rmse"] ** 2 * t["n"] for t in summaries) / n))
            largest = max(t["max"] for t in summaries)
            out[name] = {
                "rmse": rmse,
                "unit": summaries[0]["unit"],
                "rmse_in_noise": pool_residuals(several),
                "max": largest,
                "n": n,
            }
    return out
