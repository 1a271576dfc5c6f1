"""Where the mismatch is: unknown heat at a part, through a link, an unknown offset of a channel, or an unknown
temperature of surroundings of which no course is given, over time.

Heat f(t) ~ OU(σ, ℓ), straight between knots, enters at one place; its log evidence over no such heat, at the best σ
and ℓ tried, and its course are those of heat_evidence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.calibration.measured_means import Measured
from network.analysis.diagnosis.latent_heat.heat_evidence import explain_best, gain_of, roots_of
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.unknown_heat import (
    heat_answers,
    heat_knots,
    part_spread,
    temperature_answers,
)
from network.catalogue.declaration.declare import Array
from network.engine.response.model import Prediction
from network.machine.checks import places_of
from network.machine.machine import Machine

SIZES = (1.0, 4.0, 16.0, 64.0)
"""1σ tried, in multiples of what lifts a channel by one noise unit."""
KNOTS = 900.0
"""s: distance of the knots of the unknown heat."""
FINE, FINEST = 120.0, 180
"""s: the same of the course that is told of one place, so that steps show, and how many of a run at most."""
FLATTER = 0.15
"""Share of a gain in log evidence that counts towards the probability of a place: the map alone is often wrong."""

KEPT = 2e7
"""Numbers of the parts' answers that are kept for the links (160 MB)."""
LIKELY = 0.1
"""Share of the gain at the best part from which something is looked for at another: what lies next to it gains nearly
as much, and the map is often wrong by that."""


@dataclass(frozen=True)
class _Place:
    """answers: of every run, whitened, to 1 W (1 K of surroundings, 1 SI unit of a channel) about each of its knots
    (knots, rows)."""

    at: Location
    answers: Sequence[Array]


def locate(fit: Linearised, machine: Machine, scale: float | None = None) -> tuple[UnknownHeat, ...]:
    """All places, the most probable first; scale: χ² that is left beside the heat, by default what is left without
    it."""
    knots = [heat_knots(d, KNOTS) for d in fit.problem.data]
    found = [_explain_place(fit, place, knots, scale) for place in _list_places(fit, machine, knots)]
    gains = np.array([u.gain for u in found])
    share = np.exp(FLATTER * (gains - gains.max()))
    share /= share.sum()
    told = [replace(u, probability=float(p)) for u, p in zip(found, share, strict=True)]
    return tuple(sorted(told, key=lambda u: -u.probability))


def explain_unknown_at_most(fit: Linearised, machine: Machine) -> float:
    """What unknown heat, or an unknown error of a channel, explains at most [nats], in stated noise."""
    chi2 = max(1.0, float(np.mean(fit.left**2)))
    return chi2 * max(u.gain for u in locate(fit, machine))


def list_likely_parts(located: Sequence[UnknownHeat]) -> dict[str, float]:
    """What unknown heat gains in the parts where that is not much less than in the best of them [nats]."""
    gains = {u.at.nodes[0]: u.gain for u in located if u.at.kind == "node"}
    least = LIKELY * max(gains.values(), default=0.0)
    return {name: gain for name, gain in gains.items() if gain >= least}


def trace(fit: Linearised, of: UnknownHeat, scale: float) -> UnknownHeat:
    """One unknown heat with a course that is fine enough to show steps, its rms and σ those of that course; scale: χ²
    that is left beside it."""
    knots = [heat_knots(d, FINE, FINEST) for d in fit.problem.data]
    fine = _explain_place(fit, _place(fit, of.at, knots), knots, scale)
    files = tuple(d.recording.file for d in fit.problem.data)
    return replace(of, rms=fine.rms, t=fine.t, heat=fine.heat, std=fine.std, files=files)


def _list_places(fit: Linearised, machine: Machine, knots: list[Array]) -> Iterator[_Place]:
    """What flows through a link is what one part gives and the other takes, where both are known by then."""
    parts: dict[str, Sequence[Array]] = {}
    for at in _list_locations(fit, machine):
        if at.kind == "link" and {*at.nodes} <= parts.keys():
            giver, taker = (parts[name] for name in at.nodes)
            yield _Place(at, [b - a for a, b in zip(giver, taker, strict=True)])
            continue
        place = _place(fit, at, knots)
        if at.kind == "node" and (len(parts) + 1) * sum(rows.size for rows in place.answers) <= KEPT:
            parts[at.nodes[0]] = place.answers
        yield place


def _list_locations(fit: Linearised, machine: Machine) -> Iterator[Location]:
    yield from (Location((name,)) for name, node in machine.nodes.items() if node.is_part)
    yield from (Location((a, b)) for a, b in machine.list_joined_parts())
    yield from (Location((name,), is_held=True) for name in _list_stated(fit, machine))
    yield from (Location(channel=name) for name in dict.fromkeys(n for d in fit.problem.data for n in d.run.channels))


def has_stated(fit: Linearised, machine: Machine) -> bool:
    """Whether there are surroundings of which no course is given."""
    return any(_list_stated(fit, machine))


def _list_stated(fit: Linearised, machine: Machine) -> Iterator[str]:
    """Held nodes whose temperature nobody recorded, and the file or what came with a recording states. What is joined
    to one part alone is no other suspect than heat in that part."""
    recorded = {name for d in fit.problem.data for name in d.recording.columns}
    joined = [{place.node for _, place in places_of(link)} for link in machine.links.values()]
    for name in (n for n, node in machine.nodes.items() if node.is_held and not recorded & node.needs().keys()):
        if len({n for places in joined if name in places for n in places}) > 2:
            yield name


def _place(fit: Linearised, at: Location, knots: list[Array]) -> _Place:
    if at.kind == "channel":
        return _Place(at, _offsets(fit, knots, at.channel))
    if at.kind == "surroundings":
        return _Place(at, _answers(fit, knots, lambda p, t: temperature_answers(p, at.nodes[0], t)))
    into, *out_of = reversed(at.nodes)

    def answer(p: Prediction, t: Array) -> Array:
        return heat_answers(p, sum((-part_spread(p, n) for n in out_of), part_spread(p, into)), t)

    return _Place(at, _answers(fit, knots, answer))


def _answers(fit: Linearised, knots: list[Array], answer: Callable[[Prediction, Array], Array]) -> list[Array]:
    rows = (answer(p, t) for p, t in zip(fit.predictions, knots, strict=True))
    return [whiten(r) for whiten, r in zip(fit.problem.whiteners, rows, strict=True)]


def _offsets(fit: Linearised, knots: list[Array], channel: str) -> list[Array]:
    rows = []
    for data, prediction, t in zip(fit.problem.data, fit.predictions, knots, strict=True):
        own = np.zeros((len(t), len(data.means)))
        if channel in data.run.channels:
            i, cells = data.run.channels.index(channel), data.run.knots.cells
            own[:, i * cells : (i + 1) * cells] = _at_cells(data, prediction, t)
        rows.append(own)
    return [whiten(r) for whiten, r in zip(fit.problem.whiteners, rows, strict=True)]


def _at_cells(data: Measured, prediction: Prediction, t: Array) -> Array:
    """Hat functions at the middles of the cells (knots, cells)."""
    del prediction
    return np.stack([np.interp(data.centres, t, row) for row in np.eye(len(t))])


def explain_unknown(fit: Linearised, of: UnknownHeat) -> UnknownHeat:
    """The heat at a place anew, where nothing but noise is left beside it."""
    knots = [heat_knots(d, KNOTS) for d in fit.problem.data]
    return _explain_place(fit, _place(fit, of.at, knots), knots, 1.0)


def rows_of(fit: Linearised, of: UnknownHeat) -> Array:
    """What an unknown heat does to the whitened rows of all runs."""
    answers = _place(fit, of.at, [*of.t]).answers
    return np.concatenate([heat @ rows for heat, rows in zip(of.heat, answers, strict=True)])


def predict_unknown(fit: Linearised, of: UnknownHeat, precision: Array, left: Array) -> float:
    """By how much an unknown heat of a σ and ℓ that were learned elsewhere raises the log probability of runs that were
    not seen (nats). precision: of numbers and constants, left: at the most probable ones."""
    knots = [heat_knots(d, KNOTS) for d in fit.problem.data]
    rows = block_diag(*_place(fit, of.at, knots).answers)
    along = rows @ fit.slopes.T
    H = rows @ rows.T - along @ np.linalg.solve(precision, along.T)
    roots = roots_of(knots, of.ell)
    return gain_of(roots.transposed(roots.transposed(H).T), roots.transposed(rows @ left), of.size)[0]


def _explain_place(fit: Linearised, place: _Place, knots: list[Array], scale: float | None = None) -> UnknownHeat:
    """The unknown heat of one place at its best size and correlation time; scale: χ² that is left beside it, by
    default what is left without it."""
    H, g = fit.weigh_runs(place.answers)
    scale = max(1.0, float(np.mean(fit.left**2))) if scale is None else scale
    best = explain_best(H / scale, g / scale, knots, list_sizes(H))
    f, std = best.course, best.std
    cuts = np.cumsum([len(t) for t in knots])[:-1]
    rms = float(np.sqrt(np.mean(f**2)))
    heat, spread = tuple(np.split(f, cuts)), tuple(np.split(std, cuts))
    return UnknownHeat(place.at, 0.0, rms, best.gain, tuple(knots), heat, spread, size=best.size, ell=best.ell)


def list_sizes(H: Array) -> list[float]:
    """1σ of a heat [W] that are tried; H: R Rᵀ of the answers R to 1 W."""
    unit = 1 / np.sqrt(max(float(np.diag(H).max()), 1e-300))
    return [size * unit for size in SIZES]


def weigh_place(fit: Linearised, at: Location, knots: list[Array]) -> tuple[Array, Array]:
    """R M Rᵀ and R r of the answers R to 1 W at a place about each knot of the runs."""
    return fit.weigh_runs(_place(fit, at, knots).answers)
