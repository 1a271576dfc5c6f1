"""Heat that lumping misplaces: how much of it every part may have, and what that does to the channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from network.calibration.evidence import Measured
from network.calibration.noise import heat_answers, ou, part_spread, slack_knots
from network.calibration.prediction import Prediction
from network.declare import Array

MOST_SHARE = 0.12
"""Of the installed power: the largest slack that columns are kept for."""
NEGLIGIBLE = 0.04
"""Variance of a column over the white noise, at that slack, below which it is left out."""


def installed_power(predictions: Sequence[Prediction]) -> float:
    """Largest heat of all sources together in the runs [W]; where nothing heats, of what the parts take up."""
    largest, taken_up = 0.0, 0.0
    for p in predictions:
        problem = p.course.problem
        capacity = problem.plan.network.capacity[problem.plan.network.free]
        for source in problem.forcing.sources:
            largest = max([largest, *(float(np.abs(q).sum(axis=1).max(initial=0.0)) for q in source)])
        rates = np.abs(p.course.rates[0][:, : len(capacity)]) @ capacity
        taken_up = max(taken_up, float(np.median(rates)))
    return largest or taken_up


def shares(prediction: Prediction) -> Mapping[str, float]:
    """Share of every part's heat capacity in the machine's."""
    network = prediction.course.problem.plan.network
    own = {n: float(network.capacity[part].sum()) for n, part in network.parts.items() if n in network.machine.nodes}
    heavy = {n: c for n, c in own.items() if 0 < c < np.inf}
    return {n: c / sum(heavy.values()) for n, c in heavy.items()}


def slack_columns(
    prediction: Prediction, data: Measured, share: Mapping[str, float], power: float, ell: float
) -> Array:
    """Columns (rank, channels · cells) whose squares add up to the covariance by slack heat of 1 share × power in every
    part, but for what white noise hides."""
    knots = slack_knots(data)
    root = np.linalg.cholesky(ou(knots, ell))
    answers = [s * heat_answers(prediction, part_spread(prediction, n), knots) for n, s in share.items()]
    columns = power * np.concatenate([root.T @ own for own in answers])
    whitened = np.where(data.known, columns / np.sqrt(data.variance), 0.0)
    size, turn = np.linalg.eigh(whitened @ whitened.T)
    felt = size > NEGLIGIBLE / MOST_SHARE**2
    return np.asarray(turn[:, felt].T @ columns)
