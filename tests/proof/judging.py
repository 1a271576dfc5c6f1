"""One case judged: what diagnosis.json says, laid beside the opened key, the first finding by its own kind alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from proof.course import correlation
from proof.findings import UNKNOWN, Concealed, Finding, concealed_in, met
from proof.judgement import Judgement

INNOCENT = ("adequate", "parameters_only", "too_coarse")
"""Verdicts that accuse nobody."""
LUMPING = "lumping"
"""A finding that adds cells, not physics: never an accusation, never an answer."""
MOST = 6
"""Findings of a case that are looked at."""
CLASSES = ("effect", "sensor", "two", "outside", "innocent")
SENSORS = ("sensor_", "clock_shift")


def judge(
    case: str, key: Mapping[str, Any], told: Mapping[str, Any] | None, run: Mapping[str, Any] | None = None
) -> Judgement:  # fmt: skip
    """Lays a diagnosis beside the key; None is a diagnosis that did not come. run: seconds and how it ended, measured
    outside, and `simulated`, the held-out misfit of the machine that was written."""
    known = {**about(case, key), **(run or {})}
    if told is None:
        return Judgement(**known)
    findings = [Finding.read(each) for each in told.get("findings") or ()]
    physics = [finding for finding in findings if finding.kind != LUMPING][:MOST]
    known["answer"] = " + ".join(finding.kind for finding in physics) or told["verdict"]
    known["confidence"] = physics[0].confidence if physics else None
    known["course"] = correlation(key.get("course"), told)
    known |= {"verdict": told["verdict"], "silent": not physics and told["verdict"] in INNOCENT}
    known |= {"seconds": told.get("seconds")} if known.get("seconds") is None else {}
    return Judgement(**known, **held_out(told), **judged(known["group"], concealed_in(key), told, physics))


def about(case: str, key: Mapping[str, Any]) -> dict[str, Any]:
    """What the key says of a case, whether it was answered or not."""
    expected = " + ".join(kinds[0] for kinds in key["kinds"])
    visible = float(key["in_noise"]["after_calibration"])
    return {"case": case, "layout": key["layout"], "truth": key.get("truth", ""), "group": group_of(key),
            "what": key.get("what") or key["class"], "expected": expected, "visible": visible}  # fmt: skip


def group_of(key: Mapping[str, Any]) -> str:
    """The scored class; told from the kinds where the key's class is a finer one."""
    if key["class"] in CLASSES:
        return str(key["class"])
    kinds = [group[0] for group in key["kinds"]]
    if len(kinds) != 1:
        return "two" if kinds else "innocent"
    return "outside" if kinds[0] == UNKNOWN else "sensor" if kinds[0].startswith(SENSORS) else "effect"


def judged(
    group: str, effects: Sequence[Concealed], told: Mapping[str, Any], physics: Sequence[Finding]
) -> dict[str, Any]:  # fmt: skip
    """Names, places, sets and accusations, by what the key conceals: nothing, something outside, or effects."""
    if group == "innocent":
        return {"accused": bool(physics) or told["verdict"] not in INNOCENT, "stray": len(physics)}
    if group == "outside":
        return judged_outside(effects[0], told, physics)
    first, all_of = physics[:1], len(effects)
    looked = first if all_of == 1 else physics
    named, placed, both = (
        met(effects, looked, fits) == all_of for fits in (Concealed.is_named, Concealed.is_placed, Concealed.is_met)
    )
    there = met(effects, physics, Concealed.is_named)
    stray = len(physics) - there
    return {
        "first": met(effects, first, Concealed.is_named) == 1, "named": named, "placed": placed, "both": both,
        "covered": met(effects, physics, Concealed.is_covered) == all_of,
        "sizes": tuple(len(finding.members) for finding in physics if finding.kind != UNKNOWN),
        "unknown": called_unknown(told, physics), "stray": stray, "besides": stray - (bool(physics) and not there),
    }  # fmt: skip


def called_unknown(told: Mapping[str, Any], physics: Sequence[Finding]) -> bool:
    """What is said first is that something is there that has no name."""
    return physics[0].kind == UNKNOWN if physics else told["verdict"] not in INNOCENT


def judged_outside(effect: Concealed, told: Mapping[str, Any], physics: Sequence[Finding]) -> dict[str, Any]:
    """Right is `unknown`, or a near kind told as a part; without findings, what `located` names first has the place."""
    unknown = called_unknown(told, physics)
    suspects = (told.get("located") or {}).get("nodes") or ()
    likeliest = frozenset(node["name"].partition("@")[0] for node in suspects[:1])
    first = physics[0] if physics else Finding(UNKNOWN, likeliest, 0.0)
    named = unknown or (effect.is_neared(first) and first.is_part)
    placed = (unknown or bool(physics)) and effect.is_placed(first)
    stray = [f for f in physics if f.kind != UNKNOWN and not effect.is_neared(f)]
    return {
        "first": named, "named": named, "placed": placed, "both": named and placed, "unknown": unknown,
        "near_whole": any(effect.is_neared(f) and not f.is_part for f in physics), "stray": len(stray),
        "besides": len(stray) - (first in stray),
    }  # fmt: skip


def held_out(told: Mapping[str, Any]) -> dict[str, float | None]:
    """Residual of the held-out recording in units of noise, before and after, as the diagnosis claims them."""
    fit = (told.get("fit") or {}).get("holdout") or {}
    before, after = ((fit.get(when) or {}).get("rmse_in_noise") for when in ("before", "after"))
    return {"before": before, "claimed": after}
