"""What a calibration means, in sentences: what is known, what is not, what is tied together, what looks wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from network.analysis.calibration.measured_means import OFFSET_LIMIT
from network.analysis.calibration.multistart import ADEQUATE, Found, rms
from network.analysis.calibration.one_machine import Disagreement
from network.analysis.calibration.robust_fit import Fit
from network.analysis.calibration.uncertainty import CLOSELY, Uncertainty
from network.analysis.comparison.amounts import amount
from network.analysis.comparison.compare import Comparison
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, centres
from network.platform.quantities.text_table import digits, span
from network.platform.quantities.units import show, unit
from network.platform.wording import join_names

FAR_MOVED = 2.0
WELL = 0.05
"""Standard error of the logarithm up to which a number is called well determined."""
WORSE, AGAIN = 1.02, 1.5
"""Held-out residuals over those before, and over those calibrated on, that are told."""
CONSTANTS, ABSORBED = 0.9, 0.1
"""Share of the residual that estimated constants have to leave at most, and of its square that inputs and offsets have
to take away, to be told."""
MOST_PAIRS, MOST_NAMED, MOST_APART = 6, 8, 3


def shift(parameters: Sequence[Parameter], theta: Array) -> Array:
    """How far each number moved, in prior σ; NaN where the prior was flat."""
    spread = [np.nan if p.is_unknown else p.spread for p in parameters]
    return np.asarray((theta - centres(parameters)) / spread)


def list_names(names: Sequence[str]) -> str:
    return join_names([*names[:MOST_NAMED], *([f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED else [])])


def relative(p: Parameter, theta: float, spread: float) -> str:
    """1σ as it is written behind a value: '3.1 %' or '0.2 K'."""
    if p.is_log:
        return f"{digits(100 * spread, 3)} %"
    return (
        show(spread, "K" if p.field.unit == "degC" else p.field.unit, 3) if p.field.unit != "1" else digits(spread, 3)
    )


def describe_holdout(before: Comparison | None, after: Comparison | None, train: Comparison) -> list[str]:
    """Whether what was learned carries over to recordings that were held out."""
    if before is None or after is None:
        return []
    was, now = before.rmse_in_noise, after.rmse_in_noise
    if now > WORSE * was:
        return [f"What was learned does not carry over: held out, the machine was {digits(was, 3)} σ off before and is "
                f"{digits(now, 3)} σ off now; numbers were moved to absorb missing physics"]  # fmt: skip
    if now > ADEQUATE and now > AGAIN * train.rmse_in_noise:
        there = f"({digits(now, 3)} σ) than where it was calibrated ({digits(train.rmse_in_noise, 3)} σ)"
        return [
            f"Held out, the machine is further off {there}: something moves there that these recordings do not show"
        ]
    return []


def describe_constants(after: Comparison, stated: Comparison) -> Iterator[str]:
    """Where it matters that the constants of a run are others than stated, and how much they take upon themselves."""
    if after.rmse_in_noise < CONSTANTS * stated.rmse_in_noise:
        now, then = digits(after.rmse_in_noise, 3), digits(stated.rmse_in_noise, 3)
        yield (
            f"With the starts, inputs and offsets of each run as the fit finds them (in calibration.json) {now} σ are "
            f"left, with those stated {then} σ"
        )
    for r in after.recordings:
        found = r.constants
        if found and found.absorbed > ABSORBED:
            names = join_names([*found.inputs, *(["offsets of sensors"] if found.offsets else [])])
            share = digits(100 * found.absorbed, 2)
            yield f"{r.recording.file}: {names} take {share} % of what else were left upon themselves"


def describe_disagreements(apart: Sequence[Disagreement]) -> Iterator[str]:
    """Whether the recordings are of one machine in one state."""
    for d in apart[:MOST_APART]:
        p = d.parameter
        wants = [f"{p.format_value(x)} ± {relative(p, x, d.std[file])} by {file}" for file, x in d.theta.items()]
        yield f"The recordings want different numbers, is it one machine? {p.path} is {list_names(wants)}"
    if len(apart) > MOST_APART:
        yield f"So are {list_names([d.parameter.path for d in apart[MOST_APART:]])} wanted differently"


def sentences(found: Found, fit: Fit, known: Uncertainty) -> list[str]:
    """All that is to be said of a fit, the gravest first."""
    return [*_misfit(fit), *_bounds(known), *_describe_moves(known), *_prior_only(known), *_describe_ties(known),
            *_well(known), *_rivals(found), *_noise(fit)]  # fmt: skip


def _misfit(fit: Fit) -> Iterator[str]:
    left = rms(fit.at.left)
    if left > ADEQUATE:
        yield (
            f"The calibrated machine leaves {digits(left, 3)} times what noise would leave in means over minutes: some "
            "physics is missing from it, or a noise is declared too low; every ± is widened by that factor"
        )


def _bounds(known: Uncertainty) -> Iterator[str]:
    parameters, theta = known.at.problem.parameters, known.at.theta
    for j in known.at_bound:
        p = parameters[j]
        from_ = (
            ""
            if p.is_unknown
            else f", {digits(abs(theta[j] - p.centre) / p.spread, 2)} times its ± from {p.format_value(p.centre)}"
        )
        yield f"{p.path} is at its bound, {p.format_value(theta[j])}{from_}: its uncertainty there means nothing"


def _describe_moves(known: Uncertainty) -> Iterator[str]:
    parameters, theta = known.at.problem.parameters, known.at.theta
    moved = shift(parameters, theta)
    far = [
        j for j in np.argsort(-np.abs(np.nan_to_num(moved))) if abs(moved[j]) > FAR_MOVED and j not in known.at_bound
    ]
    if far:
        told = list_names([f"{parameters[j].path} ({moved[j]:+.1f} σ)" for j in far])
        yield f"Further than twice their ± moved {told}: the classic sign of something missing from the machine"


def _prior_only(known: Uncertainty) -> Iterator[str]:
    parameters = known.at.problem.parameters
    nothing = [parameters[j].path for j in known.prior_only if j not in known.at_bound]
    if nothing:
        yield f"Nothing in these recordings tells {list_names(nothing)}: what stands there is the prior only"


def _describe_ties(known: Uncertainty) -> Iterator[str]:
    parameters = known.at.problem.parameters
    pairs = [pair for pair in known.pairs(CLOSELY) if not {pair[0], pair[1]} & {*known.at_bound}]
    for i, j, r in pairs[:MOST_PAIRS]:
        what = tie(parameters[i], parameters[j], known.at.theta[[i, j]], known.std[[i, j]], r)
        yield f"{parameters[i].path} and {parameters[j].path} are known only as {what} (correlation {r:+.3f})"


def tie(a: Parameter, b: Parameter, theta: Array, std: Array, r: float) -> str:
    """Which combination of two closely correlated numbers the readings tell: of two in one unit the sum or difference
    if they trade one for one, else the product or ratio."""
    size, relative = np.array([p.value(x) for p, x in zip((a, b), theta, strict=True)]), np.array(std, float)
    for k, p in enumerate((a, b)):
        relative[k] /= 1.0 if p.is_log else max(abs(size[k]), 1e-300)
    same_unit = unit(a.field.unit).dimension == unit(b.field.unit).dimension
    absolute = relative * np.abs(size)
    if same_unit and abs(np.log(absolute[0] / absolute[1])) < abs(np.log(relative[0] / relative[1])):
        return "a difference" if r > 0 else "a sum"
    return "a ratio" if r * size[0] * size[1] > 0 else "a product"


def _well(known: Uncertainty) -> Iterator[str]:
    parameters = known.at.problem.parameters
    out = {*known.prior_only, *known.at_bound}
    well = sum(1 for j, p in enumerate(parameters) if p.is_log and known.std[j] <= WELL and j not in out)
    if well:
        yield f"{well} of {len(parameters)} numbers {'is' if well == 1 else 'are'} known to 5 % or better"


def _rivals(found: Found) -> Iterator[str]:
    best = found.at
    for rival in found.rivals[:1]:
        parameters = best.problem.parameters
        far = np.abs(rival.theta - best.theta) / [p.spread for p in parameters]
        j = int(np.argmax(far))
        p = parameters[j]
        here, there = p.format_value(best.theta[j]), p.format_value(rival.theta[j])
        yield (
            f"Another set of numbers fits alike, {p.path} {there} instead of {here}: "
            "a recording that moves the machine otherwise would tell them apart"
        )


def _noise(fit: Fit) -> Iterator[str]:
    units = {n: s.unit for n, s in fit.at.problem.model.machine.sensors.items()}
    if fit.offsets:
        told = [_offset(n.name, x, units[n.name]) for n, x in zip(fit.at.problem.offsets, fit.at.eta, strict=False)
                if abs(x) > n.spread]  # fmt: skip
        if told:
            yield f"Sensors read off by a constant: {list_names(told)}"
    elif fit.refused:
        yield (
            f"Constant errors of sensors take no part in the fit: one would be more than {OFFSET_LIMIT:g} times what "
            "its kind is off by, so something else is missing"
        )
    coloured = [f"{n} ({amount(s, units[n])} over {span(tau)})" for n, (s, tau) in fit.noise.coloured.items()]
    if coloured:
        yield f"Residuals last longer than white noise would, and every ± allows for it: {list_names(coloured)}"
    if fit.weighted:
        of = f"{fit.weighted} of the {len(fit.at.left)} means that the readings of all channels were put together to"
        yield f"{of} lie far off, and count less in the fit"


def _offset(name: str, value: float, unit_text: str) -> str:
    return f"{name} {'+' if value > 0 else '−'}{amount(value, unit_text)}"
