"""Why a draft is as it is, in sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from network.analysis.comparison.amounts import amount
from network.analysis.drafting.channel_roles import Wishes
from network.analysis.drafting.displacement_paths import Path
from network.analysis.drafting.draft_entries import Names, behind
from network.analysis.drafting.heat_scale import Sizes
from network.analysis.drafting.identification import Identified
from network.analysis.drafting.lag_bench import ALWAYS, OTHER
from network.analysis.drafting.part_models import PartModel
from network.platform.quantities.number_format import format_amount, write_minus
from network.platform.quantities.text_table import digits, span
from network.platform.wording import join_names

ALIKE = 0.98
"""Correlation of two inputs above which less than 4 % of what one does is its own."""


def tell_surroundings(found: Identified, wishes: Wishes) -> Iterator[str]:
    roles = found.roles
    if roles.ambient:
        why = "as you say" if wishes.ambient else "by its name"
        why = "because no input drives it, and most others follow it" if roles.is_by_behaviour else why
        yield f"{roles.ambient} is the temperature of the surroundings, {why}."
    else:
        level = format_amount(found.level, "degC")
        yield (
            f"No temperature of the surroundings is known: they are constant at {level} ± {found.spread:.2g} K, where "
            "the readings begin. --ambient NAME takes a column, `inputs: {ambient: …}` in a mapping one for each run."
        )


def tell_inputs(found: Identified) -> Iterator[str]:
    roles = found.roles
    if roles.inputs:
        units = "their units" if len(roles.inputs) > 1 else "its unit"
        yield f"{join_names(list(roles.inputs))} may make heat, by {units}."
    if roles.leader:
        yield (
            f"No input is recorded that makes heat, and other temperatures follow {roles.leader}: it is held at what "
            f"is recorded of it. --sensor {roles.leader} keeps it a sensor; what warms is then given heat that is "
            "always on."
        )
    elif roles.held:
        yield f"{join_names(list(roles.held))} {'are' if len(roles.held) > 1 else 'is'} held at what is recorded."
    elif not roles.inputs:
        yield "No input is recorded that makes heat: what warms is given heat that is always on."
    yield from _tell_alike(found)
    idle = [n for n in roles.inputs if not any(n in m.fit.weights for m in found.models)]
    if idle:
        yield f"No part is seen to follow {join_names(idle)}."


def _tell_alike(found: Identified) -> Iterator[str]:
    names = [*found.roles.inputs, *found.roles.held]
    rows = [np.concatenate([c.values[n] for c in found.courses]) for n in names]
    moving = [k for k, row in enumerate(rows) if np.ptp(row) > 0]
    for j, k in ((j, k) for j in moving for k in moving if j < k):
        r = float(np.corrcoef(rows[j], rows[k])[0, 1])
        if abs(r) > ALIKE:
            yield (
                f"Not told apart: {names[j]} and {names[k]} go together in these recordings (r = {r:.2f}), so what is "
                "given to one may be the other's. A run in which only one of them changes would tell."
            )


def tell_part(found: Identified, k: int, names: Names) -> Iterator[str]:
    """What a part is, and what it follows."""
    model, own = found.models[k], names.parts[k]
    sensors = list(model.group.sensors)
    if len(sensors) > 1:
        apart = amount(model.group.apart, "K", 2)
        yield f"{join_names(sensors)} move alike ({apart} apart, rms): one part, {own}."
    follows = [*_tell_heats(found, model), *_tell_links(model, names)]
    yield from _tell_behind(model, own)
    lasts = f"63 % in {span(model.fit.tau)}"
    whom = join_names(follows) or "its surroundings, as far as is seen"
    yield f"{own} follows {whom}; {lasts}; {amount(model.fit.rms, 'K', 2)} is left."


def _tell_behind(model: PartModel, own: str) -> Iterator[str]:
    lags = model.fit.lags
    if lags and lags.is_late:
        yield f"{own} begins to move late: its sensors lag by {span(lags.short)}, or what heats it does."
    elif lags:
        short, long = span(lags.short), span(lags.long)
        yield f"{own} has two time constants, {short} and {long}: {behind(own)} stands for what has no sensor."


def _tell_heats(found: Identified, model: PartModel) -> Iterator[str]:
    for name, gain in model.fit.weights.items():
        if name == ALWAYS:
            yield f"heat that is always on ({amount(gain, 'K', 2)} in the end)"
        elif name in found.largest:
            largest = found.largest[name]
            rise = gain * largest ** (2 if found.goes_squared(name) else 1)
            at = format_amount(largest, found.units[name])
            yield f"{name} ({'−' if rise < 0 else ''}{amount(rise, 'K', 2)} at {at})"


def _tell_links(model: PartModel, names: Names) -> Iterator[str]:
    for name, share in model.fit.weights.items():
        if name == OTHER and model.parent is not None:
            worth = f"clear by {digits(math.sqrt(2 * max(model.gain, 0.0)), 2)} σ"
            yield f"{names.parts[model.parent]} ({100 * share:.0f} % of what it exchanges, {worth})"
        elif name in names.held:
            yield f"{names.held[name]} ({100 * share:.0f} % of what it exchanges)"


def tell_scale(sizes: Sequence[Sizes]) -> Iterator[str]:
    known = [k for k, size in enumerate(sizes) if size.is_known]
    if len(known) == len(sizes):
        yield "Heat capacities and conductances are those at which the recorded power becomes heat in what it warms."
    else:
        others = "the other parts'" if known else "all"
        yield (
            f"No power in W tells {others} heat: heat capacities, conductances and powers may be off by one factor "
            "together; only their ratios, and time constants, are seen. A usual heat was assumed."
        )


def tell_noise(found: Identified) -> str:
    own = sorted(found.noise.values())
    told = amount(own[0], "K", 2) if len(own) == 1 else f"{amount(own[0], 'K', 2)} to {amount(own[-1], 'K', 2)}"
    return (
        "The noise told is what is left, as no fit should be truer than its parts can be; that of the readings is "
        f"{told}: write it once the structure holds, and before `lptn diagnose`."
    )


def tell_path(path: Path, names: Names) -> str:
    if not path.slopes:
        return f"{path.channel} follows no part ({amount(path.moved, 'um', 2)} rms): it is left out."
    parts = [f"{names.node(k)} ({write_minus(f'{1e6 * slope:+.2g}')} µm/K)" for k, slope in path.slopes.items()]
    gate = f", and is frozen while {path.gate} is zero" if path.gate else ""
    left = f"{amount(path.left, 'um', 2)} of {amount(path.moved, 'um', 2)} rms is left"
    return f"{path.channel} follows {join_names(parts)}{gate}; {left}."


def tell_unused(found: Identified) -> Iterator[str]:
    for name, why in found.roles.unused.items():
        yield f"{name} is not used: {why}."
