"""A coarser machine in the stead of a finer one: what its lumps lack is found and taken from what was measured.

y_fine(θ) ≈ y_coarse(θ) + [y_fine(θ₀) − y_coarse(θ₀)] about a fit θ₀, with an error of second order in lumping times
θ − θ₀. What is proposed is screened and compared on the coarse machine; the few that come near the best are fitted on
the fine one. Source: additive corrections of first-order model management, Alexandrov & Lewis, Optimization and
Engineering 2 (2001) 413; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import lay_over
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.falling_short import FallsShort
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis, parameters_of
from network.analysis.diagnosis.lumps.additive_correction import AdditiveCorrection
from network.analysis.diagnosis.lumps.lump_refinement import list_finer_machines
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.switching.carried_relays import carry_in_step
from network.analysis.diagnosis.switching.shown_relays import SLACK
from network.catalogue.declaration.declare import Array
from network.engine.response.model import Model
from network.machine.machine import Machine
from network.platform.refusal import Failed

SMALL = 30
"""Lumps up to which a machine stands for itself."""
LACK, SWITCHED_LACK = 150.0, 6.0
"""Most that the coarser lumps may lack, rms in noise units; the same where relays are found, whose switchings move."""
CUTS = (3, 5)
"""Lumps a bar that are tried."""
STEPS, CARRIED_STEPS = 6, 15
"""Of a fit with a lack, and of one on the finer lumps themselves."""
AGAIN, MOVED, HOPELESS = 2, 0.5, 2.0
"""Fits of a stand-in until its lack stays, to a share of the misfit χ; and where it moves too far to try again."""


def build_surrogate(fine: Hypothesis) -> Hypothesis:
    """The same hypothesis on the coarsest lumps that lack little, told what they lack; itself where there are none."""
    if fine.machine.lumps <= SMALL:
        return fine
    most = SWITCHED_LACK if fine.switches else LACK
    for machine, found in _list_coarser(fine):
        try:
            coarse = replace(fine, machine=machine, found=found)
            lack = correction_of(coarse, fine)
            told = _fit_until_steady(coarse, lack, fine) if _rms(fine, lack) <= most else None
            if told is not None:
                return told
        except (Failed, np.linalg.LinAlgError):
            continue
    return fine


def _fit_until_steady(coarse: Hypothesis, lack: Sequence[Array], fine: Hypothesis) -> Hypothesis | None:
    """A coarse hypothesis fitted with what it lacks; None where the lack does not stay what it was, for then the fit
    has followed the lumps and not the machine."""
    for _ in range(AGAIN):
        coarse, before = _fit_with_correction(coarse, lack), lack
        lack = correction_of(coarse, fine)
        moved = _rms(fine, [x - y for x, y in zip(lack, before, strict=True)]) / max(1.0, fine.chi)
        if moved < MOVED or moved > HOPELESS:
            return coarse if moved < MOVED else None
    return None


def fit_on_finer_lumps(
    case: Case, coarse: Hypothesis, root: Machine, steps: int = CARRIED_STEPS, needed: float = -np.inf
) -> Hypothesis | None:  # fmt: skip
    """A hypothesis fitted on finer lumps, relays by the instants that they had; None where it does not fit there or
    runs away. needed: evidence that it must come to, without which it is not fitted to the end."""
    about = replace(case, began=coarse.case.began)
    over = lay_over(root, coarse.found) if coarse.switches else None
    carried = over and carry_in_step(about, root, over[1], coarse, steps < CARRIED_STEPS)
    if carried and carried.chi < coarse.chi * (1 + SLACK):
        return carried
    until = FallsShort(needed, steps)
    led = fit_findings(about, root, coarse.found, coarse.values, not coarse.switches, steps, until)
    return best_of(carried, led)


def fit_on_finer_lumps_afresh(
    case: Case, coarse: Hypothesis, root: Machine, needed: float = -np.inf
) -> Hypothesis | None:  # fmt: skip
    """The same, where that leaves much also from the numbers of the file and with its last finding where that was
    proposed."""
    about, best = replace(case, began=coarse.case.began), fit_on_finer_lumps(case, coarse, root, needed=needed)
    back = coarse.found[-1].back if coarse.found else None
    if best is None or back is None or best.chi < SETTINGS.adequate or coarse.switches:
        return best
    values, until = coarse.own_values | back.usual, FallsShort(max(needed, best.evidence), CARRIED_STEPS)
    again = fit_findings(about, root, (*coarse.found[:-1], back), values, steps=CARRIED_STEPS, until=until)
    return best if again is None else max(best, again, key=lambda h: h.evidence)


def _list_coarser(fine: Hypothesis) -> Iterator[tuple[Machine, tuple[Candidate, ...]]]:
    """The machine with a few lumps a bar, and its refinements short of this one, the findings over them."""
    for root in chain((_cut_lumps(fine.root, lumps) for lumps in CUTS), list_finer_machines(fine.case.machine)):
        if root.lumps < fine.root.lumps and (over := lay_over(root, fine.found)) is not None:
            yield over


def _cut_lumps(machine: Machine, lumps: int) -> Machine:
    """The machine with at most so many lumps a bar."""
    wide = {name: node.to_plain() for name, node in machine.nodes.items() if node.lumps > lumps}
    return machine.patched({"nodes": {name: {**body, "lumps": lumps} for name, body in wide.items()}})


def _fit_with_correction(coarse: Hypothesis, lack: Sequence[Array]) -> Hypothesis:
    """A coarse hypothesis told what its lumps lack."""
    told = tuple(AdditiveCorrection.of(d, x) for d, x in zip(coarse.fit.problem.data, lack, strict=True))
    case = replace(coarse.case, lacking=told)
    return fit_hypothesis(case, coarse.machine, coarse.found, coarse.own, coarse.values, steps=STEPS)


def correction_of(coarse: Hypothesis, finer: Hypothesis) -> tuple[Array, ...]:
    """Means of all runs on finer lumps less those on the coarse ones, at the numbers of their fit, which is of one of
    both and has its own already. Raises Failed where the machines do not have the same numbers."""
    parameters, theta = coarse.fit.problem.parameters, coarse.fit.theta
    runs = [d.run for d in coarse.fit.problem.data]
    if any([p.path for p in parameters_of(m, coarse.own)] != [p.path for p in parameters]
           for m in (coarse.machine, finer.machine)):  # fmt: skip
        raise Failed("the coarser machine has other numbers")
    other = coarse.machine if coarse.fit is finer.fit else finer.machine
    told = Model(other, parameters, runs).predict(theta)
    there, here = (finer.predictions, told) if other is coarse.machine else (told, coarse.predictions)
    return tuple(f.cells - c.cells for f, c in zip(there, here, strict=True))


def _rms(h: Hypothesis, lack: Sequence[Array]) -> float:
    white = [w(x) for w, x in zip(h.fit.problem.whiteners, lack, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(white) ** 2)))
