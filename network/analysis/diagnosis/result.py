"""What a diagnosis says: verdict, findings with their rivals, where it differs, and what the fit gained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from network.analysis.calibration.one_machine import Disagreement
from network.analysis.comparison.compare import Comparison
from network.analysis.diagnosis.location import Location
from network.analysis.diagnosis.lump_sentences import cuts_only, lump_sentence
from network.analysis.diagnosis.screened_gain import ScreenedGain
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.patch import Patch
from network.machine.machine import Machine
from network.platform.printing import Brief, Tabled
from network.recordings.hygiene.set_aside import summarise_excluded

UNKNOWN = "unknown"
"""The kind of a finding that no kind of the catalogue explains."""
CLEAR = 3.0
"""σ from which a run counts as telling two explanations apart."""
FAINT = 1.0
"""σ below which a run tells nothing, and is not proposed."""


@dataclass(frozen=True)
class Quantity:
    """A number of a finding, SI; unit: as it is shown; std: 0 where it was not free."""

    value: float
    std: float
    unit: str

    def summary(self) -> dict[str, Any]:
        from network.platform.quantities.units import difference, unit

        of = unit(self.unit)
        shown = difference(of) if self.unit == "K" else of
        return {"value": shown.from_si(self.value), "std": self.std / difference(of).scale, "unit": self.unit}


@dataclass(frozen=True)
class Rival:
    """Another explanation that was fitted. chi: rms residual it leaves, in noise; gain: log evidence over nothing
    missing [nats]; why_not: what speaks against it, as a sentence."""

    kind: str
    places: tuple[str, ...]
    channels: tuple[str, ...]
    confidence: float
    chi: float
    gain: float
    why_not: str

    def summary(self) -> dict[str, Any]:
        return {"kind": self.kind, "places": list(self.places), "channels": list(self.channels),
                "confidence": self.confidence}  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """One piece of missing physics. gain: log evidence it adds [nats]; threshold: what chance reaches; windows: times
    [s] in which the residual differed most before; patch: what adds it to the machine, numbers as fitted."""

    kind: str
    section: str
    places: tuple[str, ...]
    channels: tuple[str, ...]
    confidence: float
    parameters: Mapping[str, Quantity]
    sentence: str
    patch: Patch
    gain: float
    threshold: float
    windows: tuple[tuple[float, float], ...] = ()
    alternatives: tuple[Rival, ...] = ()
    indistinguishable: tuple[Rival, ...] = ()
    doubts: tuple[str, ...] = ()
    course: UnknownHeat | None = None

    @property
    def part(self) -> str:
        """Whether it is all that was missing or a part of the truth."""
        return "part" if self.doubts or self.kind == UNKNOWN else "whole"

    @property
    def is_room(self) -> bool:
        """Whether it is surroundings that are not what is given for them, for which no number of a file can stand."""
        return self.course is not None and self.course.is_room

    @property
    def members(self) -> list[str]:
        """The explanations of which it is one, with SETTINGS.covered of the belief, the most likely first."""
        told, belief = [name_member(self.kind, self.places, self.channels)], self.confidence
        rest = sorted((*self.indistinguishable, *self.alternatives), key=lambda r: -r.confidence)
        for r in rest:
            name = name_member(r.kind, r.places, r.channels)
            if (belief < SETTINGS.covered or r in self.indistinguishable) and name not in told:
                told.append(name)
                belief += r.confidence
        return told

    @property
    def whole_sentence(self) -> str:
        """As it was found; where its patch does nothing but cut parts more finely, every part of the patch."""
        only_lumps = not self.parameters and cuts_only(self.patch)
        return lump_sentence(self.patch["nodes"]) if only_lumps else self.sentence

    def summary(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "section": self.section, "places": list(self.places), "channels": list(self.channels),
            "confidence": self.confidence, "parameters": {n: q.summary() for n, q in self.parameters.items()},
            "alternatives": [r.summary() for r in self.alternatives],
            "indistinguishable": [r.summary() for r in self.indistinguishable],
            "sentence": self.whole_sentence, "patch": self.patch.to_plain(),
            "evidence": {"delta_log_evidence": self.gain, "threshold": self.threshold,
                         "windows": [list(w) for w in self.windows]},
            "part": self.part, "doubts": list(self.doubts), "set": self.members,
            **({"course": self.course.list_courses()} if self.course else {}),
        }  # fmt: skip


def name_member(kind: str, places: Sequence[str], channels: Sequence[str]) -> str:
    """kind@place, or kind@place|place."""
    return f"{kind}@{'|'.join((*places, *channels))}"


@dataclass(frozen=True, eq=False, repr=False)
class UnknownHeat(Brief):
    """Heat that a place would need for simulation and recordings to agree, before anything was added; at a channel it
    is an offset in the channel's unit, SI; of surroundings K beside what is given. t, heat, std: for each recording
    [s, W]; files: of these."""

    at: Location
    probability: float
    rms: float
    gain: float
    t: tuple[Array, ...]
    heat: tuple[Array, ...]
    std: tuple[Array, ...]

    files: tuple[str, ...] = ()

    @property
    def is_offset(self) -> bool:
        return self.at.kind == "channel"

    @property
    def is_room(self) -> bool:
        return self.at.kind == "surroundings"

    @property
    def quantity(self) -> str:
        """What it is."""
        return {"channel": "offset", "surroundings": "temperature"}.get(self.at.kind, "heat")

    @property
    def unit(self) -> str:
        """Of a heat or a temperature; an offset has that of its channel."""
        return "K" if self.is_room else "W"

    def list_courses(self) -> list[dict[str, Any]]:
        """Over time in every recording: heat [W], a temperature [K] or an offset [SI], with its 1σ."""
        runs = zip(self.files, self.t, self.heat, self.std, strict=True)
        return [{"file": f, "t": t.tolist(), self.quantity: x.tolist(), "std": s.tolist()} for f, t, x, s in runs]

    def summary(self) -> dict[str, Any]:
        """A part or a link with its heat, or surroundings with their temperature."""
        rms = {"value": self.rms, "unit": self.unit}
        return {"name": str(self.at), "probability": self.probability, f"{self.quantity}_rms": rms,
                **({"course": self.list_courses()} if self.files else {})}  # fmt: skip


@dataclass(frozen=True)
class Unsearched:
    """Kinds that were not looked for, by which strategy, and why."""

    strategy: str
    kinds: tuple[str, ...]
    why: str

    @property
    def sentence(self) -> str:
        names = ", ".join(kind.replace("_", " ") for kind in self.kinds)
        return f"Not looked for{f' ({names})' if names else ''}: {self.why}."

    def summary(self) -> dict[str, Any]:
        return {"strategy": self.strategy, "kinds": list(self.kinds), "why": self.why}


@dataclass(frozen=True)
class Experiment:
    """A run that would tell rivals apart: by how many σ, in how many hours. Where σ is not CLEAR, it is the best that
    was tried. scenario: the run as a scenario file holds it; empty where it is none."""

    text: str
    separates: tuple[str, ...]
    sigma: float
    hours: float
    scenario: Mapping[str, Any] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        return {"experiment": self.text, "separates": list(self.separates), "sigma": self.sigma, "hours": self.hours}


def experiment_file(number: int) -> str:
    """What the scenario of a proposed run is called, counted from 1."""
    return f"experiment-{number}.yml"


@dataclass(frozen=True, eq=False, repr=False)
class Fits(Brief):
    """Comparisons of the calibrated machine as it was written (before) and with what was found (after)."""

    train_before: Comparison
    train_after: Comparison
    holdout_before: Comparison | None
    holdout_after: Comparison | None

    @property
    def left(self) -> dict[str, float | None]:
        """Misfit with what was found."""
        held = self.holdout_after
        return {"train": self.train_after.rmse_in_noise, "holdout": held.rmse_in_noise if held else None}

    def list_runs(self, units: Mapping[str, str]) -> list[dict[str, Any]]:
        """The constants of every run with what was found; units: of the channels."""
        runs = (*self.train_after.recordings, *(self.holdout_after.recordings if self.holdout_after else ()))
        return [{"file": r.recording.file, **r.constants.summary(units),
                 "excluded": summarise_excluded(r.recording.excluded or ())} for r in runs if r.constants]  # fmt: skip

    def summary(self) -> dict[str, Any]:
        held = self.holdout_before is not None and self.holdout_after is not None
        return {
            "train": {"before": _fit(self.train_before), "after": _fit(self.train_after)},
            "holdout": {"before": _fit(self.holdout_before), "after": _fit(self.holdout_after)} if held else None,
        }


def _fit(comparison: Comparison | None) -> dict[str, Any]:
    if comparison is None:
        return {}
    from network.analysis.comparison.channel_residual import pool_residuals

    names = dict.fromkeys(n for r in comparison.recordings for n in r.channels)
    by_name = {n: pool_residuals(r.channels[n] for r in comparison.recordings if n in r.channels) for n in names}
    return {"rmse_in_noise": comparison.rmse_in_noise, "channels": by_name}


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Tabled):
    """What was found out about a machine from its recordings.

    machine: as given; before: as given, calibrated; after: with the findings in it, calibrated; tried: every rival of
    the first finding that was fitted, best first; notes: sentences about the recordings and what cannot be told;
    explained: share of the misfit on fitted runs, each told by the others (of a single run on its end), that the
    findings take away; ended: `budget`, `stopped` or `broken` where the search did not come to its end; refuted: why
    what was found is not told; unsearched: what was not looked for; screened: the map of gains.
    """

    machine: Machine
    before: Machine
    after: Machine
    verdict: str
    findings: tuple[Finding, ...]
    channels: Mapping[str, float]
    located: tuple[UnknownHeat, ...]
    fits: Fits
    tried: tuple[Rival, ...]
    notes: tuple[str, ...]
    advice: tuple[Experiment, ...]
    shifts: Mapping[str, float]
    seed: int
    seconds: float = 0.0
    patch: Mapping[str, Any] = field(default_factory=dict)
    disagreements: tuple[Disagreement, ...] = ()
    explained: float = 0.0
    ended: str = ""
    refuted: tuple[str, ...] = ()
    unsearched: tuple[Unsearched, ...] = ()
    screened: tuple[ScreenedGain, ...] = ()

    def summary(self) -> dict[str, Any]:
        """diagnosis.json."""
        rooms = [u.summary() for u in self.located if u.is_room]
        nodes = [u.summary() for u in self.located if not (u.is_offset or u.is_room)]
        channels = [{"name": n, "rmse_in_noise": x} for n, x in self.channels.items()]
        return {
            "verdict": self.verdict, "findings": [f.summary() for f in self.findings],
            "located": {"channels": channels, "nodes": nodes, "surroundings": rooms}, "fit": self.fits.summary(),
            "advice": [e.summary() | ({"scenario": experiment_file(k)} if e.scenario else {})
                       for k, e in enumerate(self.advice, 1)], "machine": "machine.diagnosed.yaml",
            "seconds": self.seconds, "seed": self.seed, "notes": list(self.notes),
            "one_machine": {"agree": not self.disagreements, "numbers": [d.summary() for d in self.disagreements]},
            "runs": self.fits.list_runs({n: s.unit for n, s in self.machine.sensors.items()}),
            "left": {"rmse_in_noise": self.fits.left, "share_explained": self.explained},
            "budget_reached": self.ended == "budget", "stopped": self.ended == "stopped", "refuted": list(self.refuted),
            "settings": SETTINGS.summary(), "not_searched": [u.summary() for u in self.unsearched],
            "gains": [g.summary() for g in self.screened],
        }  # fmt: skip
