"""A machine without relays and bent laws in the stead of one that has them: what that changes is taken from the fit.

y(θ) ≈ y_affine(θ) + [y(θ₀) − y_affine(θ₀)] about a fit θ₀: a link that bends, follows an input or is switched becomes a
constant conductance, the one that carries its heat along the fit's runs best, G = Σ Q ΔT / Σ ΔT²; sources that read a
temperature are left out, for what they did stands in the difference. Relays are drawn on it, and the best of them
fitted on the machine itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from network.analysis.calibration.linearised import linearise
from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import theta_of
from network.analysis.diagnosis.lumps.additive_correction import AdditiveCorrection
from network.analysis.diagnosis.switching.written_numbers import write_or_leave
from network.catalogue.declaration.declare import list_kinds
from network.catalogue.declaration.fields import REQUIRED
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.entry_groups import Flows
from network.engine.network import Network
from network.engine.response.followed_relays import follow_relays
from network.engine.response.model import Model
from network.engine.response.nonlinear_laws import heat_of
from network.engine.response.parameters import Parameter, at_values, free_parameters
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused

NO_DIFFERENCE = 1e-9
"""K² below which a link carries nothing that could be told."""


def straighten(h: Hypothesis, relay: Candidate | None = None) -> Hypothesis | None:
    """The hypothesis on an affine machine without relays; itself where it has one, None where it cannot be had. relay:
    of what was found, beside which the difference is taken, so that it does not stand in that."""
    network = h.predictions[0].course.problem.plan.network
    bent, reading = _find_bent(network), [n for n in _find_reading(network) if relay is None or n in relay.base.sources]
    machine = follow_relays(h.root, h.fit.problem.data[0].run.schedule.signals)
    if not bent and not reading and machine is h.root:
        return None if network.melting else h
    try:
        patch: dict[str, Any] = {"links": dict(_straight_links(h, network, bent)), "sources": dict.fromkeys(reading)}
        machine = (relay.base if relay else h.machine).patched(patch)
        machine = follow_relays(machine, h.fit.problem.data[0].run.schedule.signals)
        machine = write_or_leave(machine, _list_kept(machine, h, relay, patch), h.own_values)
        return None if network.melting else _correct(h, machine, relay)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None


def _find_bent(network: Network) -> list[Flows]:
    return [g for g in network.flows if not g.law.is_affine() or g.law.needs() or g.relay is not None]


def _find_reading(network: Network) -> list[str]:
    """Names of sources that read a temperature, relays among them."""
    groups = [*(g for g in network.heats if g.reads), *network.relays]
    named = {network.mechanisms[i] for g in groups for i in np.unique(g.entry)}
    return sorted(name.partition(".")[2] for name in named if name.startswith("sources."))


def _straight_links(
    h: Hypothesis, network: Network, bent: list[Flows]
) -> Iterator[tuple[str, Mapping[str, str] | None]]:
    for group in bent:
        heats = [heat_of(group, p.course.T_ends, p.course.inputs) for p in h.predictions]
        for entry in np.unique(group.entry):
            mine = group.entry == entry
            Q = np.concatenate([heat[:, mine].sum(axis=1) for heat in heats])
            apart = [p.course.T_ends[:, group.a[mine]] - p.course.T_ends[:, group.b[mine]] for p in h.predictions]
            D = np.concatenate([d @ group.w[mine] for d in apart])
            G = max(float(Q @ D) / float(D @ D), 0.0) if float(D @ D) > NO_DIFFERENCE else 0.0
            name = network.mechanisms[entry].partition(".")[2]
            link = h.machine.links[name]
            yield name, _plain(link, G) if isinstance(link, Link) and G > 0 else None


def _plain(link: Link, G: float) -> dict[str, Any]:
    """A link between the same places that is nothing but a conductance, of the kind with the fewest fields."""
    able = [k for k in list_kinds("links").values() if issubclass(k, Link) and _is_told_by_strength(k)]
    kind = min(able, key=lambda k: len(k.fields))
    return {
        "kind": kind.kind,
        "between": [str(p) for p in link.between],
        kind.fields[kind.strength].key: f"{G:.9g} W/K",
    }


def _is_told_by_strength(kind: type[Link]) -> bool:
    """Whether places and a conductance are all that such a link needs."""
    strength = kind.fields[kind.strength]
    other = [f for f in kind.fields.values() if f is not strength and f.key != "between"]
    plain = kind.affine and not issubclass(kind, Relay) and getattr(strength, "unit", "") == "W/K"
    return plain and all(f.default is not REQUIRED for f in other)


def _list_kept(
    machine: Machine, h: Hypothesis, relay: Candidate | None, exchanged: Mapping[str, Mapping[str, Any]]
) -> list[Parameter]:  # fmt: skip
    """Numbers of those findings beside a relay that are in a machine and were not exchanged; what comes with the relay
    may stand there as another thing, like a tank as a coolant that is held."""
    own = {p.path for p in relay.own} if relay else set[str]()
    there = [p for p in h.own if p.path not in own and p.entry in machine.by_path]
    return [p for p in there if p.entry.name not in exchanged.get(p.entry.section, {})]


def _correct(h: Hypothesis, machine: Machine, relay: Candidate | None) -> Hypothesis | None:
    """The hypothesis on another machine, told what that lacks; None where its runs are laid out otherwise."""
    parameters = free_parameters(machine)
    theta = theta_of(parameters, h.values)
    data, beside = h.fit.problem.data, machine
    if relay is not None:
        again = candidate(machine, relay.kind, relay.patch)
        if again is None:
            return None
        beside = at_values(again.machine, {p.path: h.values[p.path] for p in relay.own})
    there = Model(beside, parameters, [d.run for d in data]).predict(theta)
    if any(a.cells.shape != b.cells.shape for a, b in zip(there, h.predictions, strict=True)):
        return None
    lack = []
    for i, (d, full, plain) in enumerate(zip(data, h.predictions, there, strict=True)):
        values = (full.cells - plain.cells).reshape(len(d.run.channels), -1)
        before = h.case.lacking[i].at(d).reshape(values.shape) if h.case.lacking else 0.0
        lack.append(AdditiveCorrection.of(d, values + before))
    case = replace(h.case, lacking=tuple(lack))
    return Hypothesis(case, machine, (), (), linearise(case.problem(machine, parameters), theta))
