"""`lptn` without one stage of the diagnosis: `python -m bench.ablated STAGE diagnose …`, for `lptn prove --ablate`.

Nothing in the package knows of it: functions of network.analysis.diagnosis are replaced by name before the command is
called, wherever they were imported to.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any

Stand = Callable[[Callable[..., Any]], Callable[..., Any]]
"""From a function to what stands in for it."""


def as_it_was(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda case, hypothesis: case


def all_of_it(original: Callable[..., Any]) -> Callable[..., Any]:
    """All that was found, as if it explained everything."""
    return lambda before, current, gains, jobs: (current, gains, 1.0)


def on_seen_runs(original: Callable[..., Any]) -> Callable[..., Any]:
    """The held-out recordings do not count."""
    return lambda h, fits: original(h, replace(fits, holdout_before=None, holdout_after=None))


def none_found(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *_, **__: []


def nothing(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *_, **__: None


def never(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *_, **__: False


def no_gain(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *_, **__: 0.0


def as_given(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda ranked, jobs: [*ranked]


def worth_all(original: Callable[..., Any]) -> Callable[..., Any]:
    """Findings add as much as can be beside heat of any course, and leave nothing of it."""
    return lambda *_, **__: (float("inf"), 1.0)


def always(original: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *_, **__: True


STAGES: Mapping[str, Mapping[str, Stand]] = {
    "file-noise": {"hypotheses.case_noise.estimate_noise": as_it_was},
    "as-written": {"lumps.lump_refinement.choose_lumps": nothing},
    "seen-runs": {
        "steps.backward_elimination._keep_what_predicts": all_of_it,
        "findings.invariants.list_refutations": on_seen_runs,
    },
    "no-latent": {
        "steps.backward_elimination.is_imitation": never,
        "latent_heat.latent_rest.rank_beside_rest": as_given,
        "steps.backward_elimination._weigh_rest": worth_all,
        "steps.unseen_runs._add_rest": no_gain,
        "intermittent.find_onset_fault._beats_unknown": always,
        "latent_heat.locate.explain_unknown_at_most": no_gain,
    },
    "no-crossed": {"screening.crossed_splits.halve": nothing},
    "no-switching": {
        "switching.relay_search.search_relays": none_found,
        "switching.followed_search.search_traced_relays": none_found,
    },
    "no-intermittent": {"intermittent.find_fault.find_reading_fault": nothing},
}
"""What each does without: noise told from residuals, finer lumps, checks on runs left out or held out, what unknown
heat decides, tests on the half that did not choose, the search for relays, faults that come and go. Functions by module
and name."""


def switch_off(stage: str) -> None:
    """Raises AttributeError where a function is no longer there: then nothing would have been switched off."""
    everywhere = [*modules()]
    for path, stand in STAGES[stage].items():
        home, _, name = path.rpartition(".")
        original = getattr(importlib.import_module(f"network.analysis.diagnosis.{home}"), name)
        substitute = stand(original)
        for module in everywhere:
            for word in [word for word, value in vars(module).items() if value is original]:
                setattr(module, word, substitute)


def modules() -> Iterator[ModuleType]:
    """All of the diagnosis, imported."""
    package = importlib.import_module("network.analysis.diagnosis")
    for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        yield importlib.import_module(found.name)


if __name__ == "__main__":
    switch_off(sys.argv[1])
    from network.cli import main

    main(sys.argv[2:])
