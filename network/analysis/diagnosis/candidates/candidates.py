"""What could be missing: every patch that the catalogue proposes for a machine, and several laid over one another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.catalogue.declaration.declare import Effect, list_kinds
from network.catalogue.declaration.discovery import open_rooms
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.proposals import Runs
from network.catalogue.declaration.registry import sections
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine

NO_RUNS = Runs()


def kinds() -> Iterator[type[Effect]]:
    """Every kind that can be missing and is looked for."""
    open_rooms()
    for section in sections():
        for kind in list_kinds(section).values():
            if issubclass(kind, Effect) and kind.strength and kind.is_searched():
                yield kind


def candidates(
    machine: Machine, known: Iterable[str], structural: bool = False, among: Iterable[type[Effect]] | None = None,
    runs: Runs = NO_RUNS,
) -> tuple[Candidate, ...]:  # fmt: skip
    """All that is proposed for a machine and can be computed with the inputs known: what has a strength to be fitted,
    or what is structural. among: the kinds in question, if not all; runs: what the recordings bring."""
    known_kinds = kinds() if among is None else among
    wanted = [k for k in known_kinds if isinstance(k.fields[k.strength], ParamField) != structural]
    patches = ((kind, patch) for kind in wanted for patch in kind.proposes_on(machine, runs))
    found = (c for kind, patch in patches if (c := candidate(machine, kind, patch)))
    have = {*known}
    return tuple(c for c in found if have.issuperset(c.machine.inputs))


def lay_over(machine: Machine, found: Iterable[Candidate]) -> tuple[Machine, tuple[Candidate, ...]] | None:
    """Another machine with findings laid over it, one on the other, and these; None where one does not fit, where two
    have one number, or where the numbers of an earlier one do not stand any more: an effect of a sensor moves those
    behind it."""
    laid: list[Candidate] = []
    for c in found:
        again = candidate(machine, c.kind, c.patch)
        if again is None:
            return None
        laid.append(replace(again, proposed=c.proposed))
        machine = again.machine
    own = {p.path: p for c in laid for p in c.own}
    is_once = len(own) == sum(len(c.own) for c in laid)
    return (machine, tuple(laid)) if is_once and has_numbers(machine, own.values()) else None


def has_numbers(machine: Machine, own: Iterable[Parameter]) -> bool:
    """Whether the numbers of earlier findings still stand in a machine."""
    pairs = ((machine.by_path.get(p.entry), p.attribute) for p in own)
    return all(entry is not None and entry.__dict__.get(attribute) is not None for entry, attribute in pairs)
