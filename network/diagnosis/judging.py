"""From what a search found to what is said: verdict, confidence, rivals, the machine with its findings, the gain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from network.calibration.beginnings import begun
from network.calibration.fitting import chi_of
from network.calibration.parameters import Parameter
from network.calibration.patching import calibrated
from network.comparison import Comparison, RecordingResidual
from network.diagnosis.advise import experiments
from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Hypothesis, rejudged
from network.diagnosis.coarse import lumping_of
from network.diagnosis.isolability import isolability
from network.diagnosis.ranking import ALIKE, confidence, distinct, shares
from network.diagnosis.together import spread
from network.diagnosis.verdict import UNKNOWN, Diagnosis, Finding, Fits, Quantity, Rival, UnknownHeat, sentence
from network.machine import Machine
from network.proposals import bodies
from network.recording import Recording
from network.units import show
from network.yamlfile import plain

if TYPE_CHECKING:
    from network.diagnosis.diagnosing import Search

UNEXPLAINED = 1.5
"""Misfit χ that no finding may leave and be called an explanation."""
SHARE = 0.75
"""Of the excess χ² − 1 that findings must take away to be told beside what stays unknown: with less they stand in for
it."""
WORSE = 1.05
"""Misfit of the machine with what was found, simulated, over that without, from which it is not believed."""
SHIFT = 2.0
"""Prior σ from which a number counts as wrong."""
REPLACED = 0.5
"""Confidence in a finding that took the place of another only beside later ones."""
FAULTY = 0.98
"""Confidence in a fault whose jumps are of one share, there and back."""
STRAY = 2.0
"""Standard deviations at which unknown heat counts."""


def diagnosis_of(
    search: Search, holdout: Sequence[Recording], warnings: Sequence[str], seed: int, jobs: int
) -> Diagnosis:
    """The diagnosis that a search amounts to."""
    search = _upheld(search)
    before = numbers_in(search.plain)
    after, fits = _simulated(search, before, holdout, jobs)
    is_refuted = bool(search.best.found) and _is_worse(fits)
    if is_refuted:
        search = _as_it_was(search)
        after, fits = _simulated(search, before, holdout, jobs)
    finer_gain = search.null.evidence - search.written.evidence
    is_finer = _is_finer(search)
    coarse = lumping_of(search.written, search.best.root, finer_gain, search.threshold) if is_finer else None
    findings, verdict = _weighed(search, [*_faults(search), *_findings(search, after)], coarse, is_refuted)
    known = isolability(search.screened.scores, search.screened.proposed)
    notes = (*warnings, *_notes(search), *([known.sentence] if known.sentence else ()))
    return Diagnosis(
        search.case.machine, before, after, verdict, tuple(findings), _channels(fits), search.located[:8], fits,
        tuple(_rivals(search.steps[0], search.befores[0]) if search.steps else ()), notes,
        tuple(experiments(search, known.unseen)), _shifts(search.best), seed,
    )  # fmt: skip


def _simulated(search: Search, before: Machine, holdout: Sequence[Recording], jobs: int) -> tuple[Machine, Fits]:
    """The machine with what was found and its numbers, and how it tells the recordings, simulated."""
    best = search.best
    after = numbers_in(best) if search.fault or best.found or _is_finer(search) else before
    return after, _fits(search, before, after, holdout, jobs)


def _is_finer(search: Search) -> bool:
    return search.best.root.to_plain() != search.written.machine.to_plain()


def _is_worse(fits: Fits) -> bool:
    """Whether the machine with what was found, simulated, tells recordings worse than without: the fit has leaned on
    constant errors of sensors then, or on where a run began."""
    pairs = ((fits.train_before, fits.train_after), (fits.holdout_before, fits.holdout_after))
    return any(b and a and a.rmse_in_noise > WORSE * b.rmse_in_noise for b, a in pairs)


def _as_it_was(search: Search) -> Search:
    """The search without its findings."""
    return replace(search, best=rejudged(search.best.case, search.null))


def _upheld(search: Search) -> Search:
    """The search without findings where these leave much and took away too little to be believed."""
    best = search.best
    if not best.found or best.chi <= UNEXPLAINED:
        return search
    before = _as_it_was(search)
    left = (best.chi**2 - 1) / max(before.best.chi**2 - 1, 1e-9)
    return before if left > 1 - SHARE else search


def numbers_in(h: Hypothesis) -> Machine:
    """The machine of a hypothesis with its numbers ± their standard errors."""
    std = np.sqrt(np.diag(h.fit.covariance))[: len(h.fit.theta)] * max(1.0, h.chi)
    return calibrated(h.machine, h.fit.problem.parameters, h.fit.theta, std)


def _faults(search: Search) -> Iterator[Finding]:
    """What was wrong with a channel for some of the time."""
    if (e := search.fault) is not None:
        c, first = e.candidate, e.candidate.own[0]
        share = {first.path.rpartition(".")[2]: Quantity(e.loose.share, e.loose.std, first.field.unit)}
        windows = next(w for w in e.loose.windows if w)
        yield Finding(
            c.kind.kind, c.section, (), c.channels, FAULTY, share, sentence(e.told), {}, e.gain,
            search.threshold, windows,
        )  # fmt: skip


def _findings(search: Search, after: Machine) -> Iterator[Finding]:
    for i, c in enumerate(search.best.found):
        k = min(i, len(search.steps) - 1)
        ranked = search.steps[k]
        told = list(_rivals(ranked, search.befores[k], c.key))
        is_first = ranked[0].found[-1].key == c.key
        sure = confidence(ranked, search.best.chi) if is_first else REPLACED
        gain = search.gains[i] if i < len(search.gains) else 0.0
        yield Finding(
            c.kind.kind, c.section, c.places, c.channels, sure, _quantities(search.best, c),
            _sentence(search.best, c, after), _patch(c, after), gain, search.threshold, windows_of(search.located),
            tuple(r for r in told if r.confidence < 0.3 or r.gain < search.best.evidence)[:5],
            tuple(_alike(ranked, c)),
        )  # fmt: skip


def _rivals(ranked: Sequence[Hypothesis], null: Hypothesis, but: tuple[str, ...] = ()) -> Iterator[Rival]:
    apart = distinct(ranked)
    for h, p in zip(apart, shares(apart), strict=True):
        c = h.found[-1]
        if c.key != but and h.evidence > null.evidence - ALIKE:
            gain, why_not = h.evidence - null.evidence, _why_not(h, ranked[0])
            yield Rival(c.kind.kind, c.places, c.channels, float(p), h.chi, gain, why_not)


def _why_not(h: Hypothesis, best: Hypothesis) -> str:
    worse = best.evidence - h.evidence
    if worse <= ALIKE:
        return f"cannot be told apart from it: {worse:.1f} nats"
    moved = float(np.abs(h.shift).max(initial=0.0))
    strained = f", with a number of the file {moved:.0f} prior σ off" if moved > 3 else ""
    return f"leaves {h.chi:.2f} instead of {best.chi:.2f} noise units{strained}"


def _alike(ranked: Sequence[Hypothesis], c: Candidate) -> Iterator[Rival]:
    """Other explanations within ALIKE nats of the best."""
    for r in _rivals(ranked, ranked[0], c.key):
        if -r.gain <= ALIKE:
            yield r


def _quantities(h: Hypothesis, c: Candidate) -> dict[str, Quantity]:
    std = np.sqrt(np.diag(h.fit.covariance)) * max(1.0, h.chi)
    index = {p.path: i for i, p in enumerate(h.fit.problem.parameters)}
    return {p.path.rpartition(".")[2]: _quantity(p, float(h.fit.theta[index[p.path]]), float(std[index[p.path]]))
            for p in c.own if p.path in index}  # fmt: skip


def _quantity(p: Parameter, theta: float, spread: float) -> Quantity:
    return Quantity(p.value(theta), p.std(theta, spread), p.field.unit)


def _sentence(h: Hypothesis, c: Candidate, after: Machine) -> str:
    """What is missing and how large it is, with its uncertainty."""
    index = {p.path: i for i, p in enumerate(h.fit.problem.parameters)}
    first = c.own[0]
    spread = float(np.sqrt(np.diag(h.fit.covariance))[index[first.path]]) * max(1.0, h.chi)
    unit = "K" if first.field.unit == "degC" else first.field.unit
    std = show(first.std(float(h.fit.theta[index[first.path]]), spread), unit, 2)
    return f"{sentence(c.kind.told(after, c.patch))} ({first.path.rpartition('.')[2].replace('_', ' ')} ± {std})."


def _patch(c: Candidate, after: Machine) -> dict[str, Any]:
    """The entries of a finding as they stand in the machine with its numbers."""
    patch: dict[str, Any] = {}
    for path, _ in bodies(c.patch):
        if ".effects." in path:
            continue
        section, _, name = path.partition(".")
        if section == "tcp":
            axis, _, name = name.partition(".")
            patch.setdefault(section, {}).setdefault(axis, {})[name] = plain(after.tree)[section][axis][name]
        else:
            patch.setdefault(section, {})[name] = plain(after.tree)[section][name]
    return patch


def _weighed(
    search: Search, findings: list[Finding], coarse: Finding | None, is_refuted: bool
) -> tuple[list[Finding], str]:
    """Findings and verdict, after what stays unexplained."""
    best = search.best
    if (is_refuted or best.chi > UNEXPLAINED) and search.located:
        return [*findings, *([coarse] if coarse else []), _unknown(search)], "unexplained"
    if findings:
        only_sensors = all(f.channels for f in findings)
        return [*findings, *([coarse] if coarse else [])], "sensor_fault" if only_sensors else "missing_physics"
    if coarse:
        return [coarse], "too_coarse"
    wrong = any(abs(x) > SHIFT for x in _shifts(best).values()) or _was_off(search)
    return [], "parameters_only" if wrong else "adequate"


def _was_off(search: Search) -> bool:
    """Whether the numbers of the file, as they stand, leave more than noise."""
    from network.diagnosis.confirm import nominal

    return chi_of(nominal(search.null.fit)) > UNEXPLAINED


def _unknown(search: Search) -> Finding:
    """What no kind explains: its place, its shape and its size."""
    from network.diagnosis.locate import locate

    left = locate(search.best.fit, search.best.machine) if search.best.found else search.located
    top = left[0]
    places = tuple(top.name.split(" to ")) if top.kind == "link" else (top.name,)
    unit = "W" if top.kind != "channel" else "of its unit"
    std = float(np.sqrt(np.mean(np.concatenate(top.std) ** 2)))
    size = Quantity(top.rms, std, "W" if top.kind != "channel" else "1")
    what = f"an unknown heat of {top.rms:.3g} {unit} (rms)" if top.kind != "channel" else "an unknown offset"
    said = f"{sentence(what)} at {' and '.join(places)} that no kind of the catalogue explains."
    is_channel = top.kind == "channel"
    return Finding(
        UNKNOWN, "sensors" if is_channel else "sources", () if is_channel else places, places if is_channel else (),
        top.probability, {"heat": size}, said, {}, top.gain, search.threshold, windows_of(left),
    )  # fmt: skip


def windows_of(located: Sequence[UnknownHeat]) -> tuple[tuple[float, float], ...]:
    """When the most probable unknown heat of the first recording differs from none."""
    if not located:
        return ()
    t, away = located[0].t[0], np.abs(located[0].heat[0]) > STRAY * located[0].std[0]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], away, [False]]).astype(int)))
    return tuple((float(t[a]), float(t[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1)


def _fits(search: Search, before: Machine, after: Machine, holdout: Sequence[Recording], jobs: int) -> Fits:
    best = search.plain if after is before else search.best
    held = _set_right(search, after, holdout)
    sets = [(search.plain, before, search.given.recordings), (best, after, search.case.recordings),
            (search.plain, before, holdout), (best, after, held)]  # fmt: skip
    told = iter(spread(_compared, [(h, m, r) for h, m, runs in sets for r in runs], jobs, None))
    train, fitted, *rest = (Comparison(m, tuple(next(told) for _ in runs)) for _, m, runs in sets)
    return Fits(train, fitted, *(rest if holdout else (None, None)))


def _set_right(search: Search, after: Machine, holdout: Sequence[Recording]) -> Sequence[Recording]:
    """Held-out recordings without the fault that was found in the others."""
    fault = search.fault
    if fault is None:
        return holdout
    raw = [_compared((search.best, after, r)) for r in holdout]
    return [fault.found_in(r.recording, r.channels[fault.channel]) if fault.channel in r.channels else r.recording
            for r in raw]  # fmt: skip


def _compared(of: tuple[Hypothesis, Machine, Recording]) -> RecordingResidual:
    """Residuals of a run of a machine with the numbers of a hypothesis, temperatures at the start estimated."""
    h, machine, run = of
    return begun(machine, h.machine, h.fit.problem.parameters, h.fit.theta, run, h.case.start, max(1.0, h.chi))


def _channels(fits: Fits) -> Mapping[str, float]:
    """Channels by how far they were off before, the worst first."""
    told: dict[str, float] = fits.summary()["train"]["before"]["channels"]
    return dict(sorted(told.items(), key=lambda pair: -pair[1]))


def _shifts(h: Hypothesis) -> dict[str, float]:
    """How far the numbers of the file moved, in prior σ, the farthest first."""
    own = {p.path for p in h.own}
    names = [p.path for p in h.fit.problem.parameters if p.path not in own]
    return dict(sorted(zip(names, h.shift.tolist(), strict=True), key=lambda pair: -abs(pair[1])))


def _notes(search: Search) -> Iterator[str]:
    """What the recordings are worth, as sentences."""
    for data in search.best.fit.problem.data:
        for name, channel in data.channels.items():
            if channel.apart.any():
                count = int(channel.apart.sum())
                yield f"{data.recording.name}: {count} readings of {name} lie apart and were set aside."
    tinted = [n for n, (s, _) in search.best.case.noise.coloured.items() if s]
    if tinted:
        yield f"The noise of {', '.join(tinted)} is coloured; evidence counts it as such."
