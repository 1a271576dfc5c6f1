"""A coarser machine in the stead of a finer one: what its lumps lack is found once and taken from what was measured.

y_fine(θ) ≈ y_coarse(θ) + [y_fine(θ₀) − y_coarse(θ₀)] about a fit θ₀, with an error of second order in lumping times
θ − θ₀. Rivals are compared on the coarse machine; what is kept is fitted again on the fine one. Source: additive
corrections of first-order model management, Alexandrov & Lewis, Optimization and Engineering 2 (2001) 413; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.calibration.evidence import Measured
from network.calibration.predictor import Model
from network.declare import Array
from network.diagnosis.candidates import Candidate, laid_over
from network.diagnosis.case import Hypothesis, Lack, parameters_of, suppose
from network.diagnosis.refine import ROUNDS, finer
from network.machine import Machine
from network.refusal import Failed

SMALL = 30
"""Lumps up to which a machine stands for itself."""
LACK = 6.0
"""Most that the coarser lumps may lack, rms in noise units."""
STEPS = 6


def stand_in(fine: Hypothesis) -> Hypothesis:
    """The same hypothesis on the coarsest lumps that lack little, told what they lack; itself where there are none."""
    if lumps_of(fine.machine) <= SMALL:
        return fine
    for machine, found in _coarser(fine):
        try:
            lack = _lacking(fine, machine)
            if _rms(fine, lack) > LACK:
                continue
            told = tuple(_over_time(d, x) for d, x in zip(fine.fit.problem.data, lack, strict=True))
            case = replace(fine.case, machine=found[0].base if found else machine, lacking=told)
            return suppose(case, machine, found, fine.own, fine.values, steps=STEPS)
        except (Failed, np.linalg.LinAlgError):
            continue
    return fine


def lumps_of(machine: Machine) -> int:
    return sum(node.lumps for node in machine.nodes.values() if node.is_part)


def _coarser(fine: Hypothesis) -> Iterator[tuple[Machine, tuple[Candidate, ...]]]:
    """The machine as it was written and its refinements short of this one, with the findings laid over them."""
    root = fine.case.machine
    for _ in range(ROUNDS + 1):
        if lumps_of(root) >= lumps_of(fine.root):
            return
        laid = laid_over(root, fine.found)
        if laid is not None:
            yield laid[-1].machine if laid else root, laid
        patch = finer(root)
        if patch is None:
            return
        root = root.patched(patch)


def _lacking(fine: Hypothesis, machine: Machine) -> tuple[Array, ...]:
    """Means of all runs on the fine lumps less those on coarser ones, at the same numbers. Raises Failed where the
    machines do not have the same numbers."""
    parameters = parameters_of(machine, fine.own)
    if [p.path for p in parameters] != [p.path for p in fine.fit.problem.parameters]:
        raise Failed("the coarser machine has other numbers")
    there = Model(machine, parameters, [d.run for d in fine.fit.problem.data]).predict(fine.fit.theta)
    return tuple(f.cells - c.cells for f, c in zip(fine.predictions, there, strict=True))


def _over_time(data: Measured, lack: Array) -> Lack:
    return Lack(data.centres, lack.reshape(len(data.run.channels), -1))


def _rms(fine: Hypothesis, lack: tuple[Array, ...]) -> float:
    white = [w(x) for w, x in zip(fine.fit.problem.whiteners, lack, strict=True)]
    return float(np.sqrt(np.mean(np.concatenate(white) ** 2)))
