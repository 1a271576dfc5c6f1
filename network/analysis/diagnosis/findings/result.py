"""What a diagnosis says: verdict, findings with their rivals, where it differs, and what the fit gained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from network.analysis.calibration.one_machine import Disagreement
from network.analysis.comparison.compare import Comparison
from network.analysis.diagnosis.experiments.experiment import Experiment, experiment_file
from network.analysis.diagnosis.findings.finding import Finding, Rival
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.screening.screened_gain import ScreenedGain
from network.analysis.diagnosis.settings import SETTINGS
from network.machine.machine import Machine
from network.platform.printing import Brief, Tabled
from network.platform.wording import name_of
from network.recordings.hygiene.set_aside import summarise_excluded


@dataclass(frozen=True)
class Unsearched:
    """Kinds that were not looked for, by which strategy, and why."""

    strategy: str
    kinds: tuple[str, ...]
    why: str

    @property
    def sentence(self) -> str:
        names = ", ".join(name_of(kind) for kind in self.kinds)
        return f"Not looked for{f' ({names})' if names else ''}: {self.why}."

    def summary(self) -> dict[str, Any]:
        return {"strategy": self.strategy, "kinds": list(self.kinds), "why": self.why}


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
    disagreements: numbers that the runs want differently, None where there was no time to look;
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
    disagreements: tuple[Disagreement, ...] | None = ()
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
            "one_machine": self._summarise_agreement(),
            "runs": self.fits.list_runs({n: s.unit for n, s in self.machine.sensors.items()}),
            "left": {"rmse_in_noise": self.fits.left, "share_explained": self.explained},
            "budget_reached": self.ended == "budget", "stopped": self.ended == "stopped", "refuted": list(self.refuted),
            "settings": SETTINGS.summary(), "not_searched": [u.summary() for u in self.unsearched],
            "gains": [g.summary() for g in self.screened],
        }  # fmt: skip

    def _summarise_agreement(self) -> dict[str, Any]:
        agree = None if self.disagreements is None else not self.disagreements
        return {"agree": agree, "numbers": [d.summary() for d in self.disagreements or ()]}
