"""A run that leaves all temperatures that mean anything: which part, when, and which entry brought most of the heat."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Declared
from network.engine.network import Network
from network.engine.solvers.carry_out import Outcome
from network.platform.quantities.text_table import digits
from network.platform.refusal import Failed

HOPELESS = 1e4
"""°C: beyond it nothing computed means anything; no solid is left at half of it."""


def check_sane(network: Network, outcome: Outcome) -> None:
    """Raises Failed for a machine that has run away, at the end of the run or at any instant that was asked for."""
    found = _find_runaway(network, outcome)
    if found is None:
        return
    name, T, when = found
    told, read = _tell_cause(network, outcome, -1.0 if T < 0 else 1.0)
    right = f"check {read}the heat capacity and the links of {name}"
    far = f"{T:.3g} degC" if np.isfinite(T) else "no finite temperature"
    raise Failed(f"{name} reaches {far} {when}: it runs away{told}; {right}")


def extremes(network: Network, outcome: Outcome, within: tuple[float, float]) -> dict[str, tuple[float, float]]:
    """Lowest and highest temperature of every part [°C], over all instants where these were asked for; of one that
    surely stays `within` two temperatures, at the start and at the end alone."""
    found = {}
    for name, part in network.bodies.items():
        seen = [outcome.T_end[part], outcome.T_start[part]]
        row, _ = outcome.readouts.where.get(("part", name), (None, 0.0))
        if row is not None and not (within[0] < outcome.limits[0][row] and outcome.limits[1][row] < within[1]):
            seen.append(outcome.courses[row])
        T = np.concatenate([values[np.isfinite(values)] for values in seen])
        found[name] = (float(T.min()), float(T.max())) if len(T) else (np.nan, np.nan)
    return found


def _find_runaway(network: Network, outcome: Outcome) -> tuple[str, float, str] | None:
    """Part, temperature and instant. A reading is a mean over lumps, so that one of them is at least as far off."""
    for name, part in network.bodies.items():
        T = outcome.T_end[part]
        worst = float(T[np.argmax(np.where(np.isfinite(T), np.abs(T), np.inf))])
        if not abs(worst) < HOPELESS:
            return name, worst, "at the end"
    rows = outcome.readouts.rows
    size = np.abs(rows).sum(axis=1)
    own = np.flatnonzero((size > 0) & ~(np.abs(rows[:, network.is_state]).sum(axis=1) > 0))
    furthest = np.maximum(np.abs(outcome.limits[0][own]), np.abs(outcome.limits[1][own]))
    own = own[~(furthest < HOPELESS * size[own])]
    if not len(own):
        return None
    y = outcome.courses.rows(own)
    means = np.abs(y) / size[own, None]
    if bool((means < HOPELESS).all()):
        return None
    row, instant = np.unravel_index(int(np.argmax(np.where(np.isfinite(means), means, np.inf))), means.shape)
    lump = int(np.argmax(np.abs(rows[own[row]])))
    name = next(name for name, part in network.bodies.items() if part.start <= lump < part.stop)
    return name, float(y[row, instant] / size[own[row]]), f"after {digits(outcome.plan.t[instant])} s"


def _tell_cause(network: Network, outcome: Outcome, sign: float) -> tuple[str, str]:
    """The entry that brought (or took) most and the line it stands in; what is to be looked at there."""
    heat = np.where(np.isfinite(outcome.account.heat_by_mechanism), outcome.account.heat_by_mechanism, sign * np.inf)
    if not len(heat) or not (heat * sign > 0).any():
        return "", ""
    path = network.mechanisms[int(np.argmax(heat * sign))]
    entry: Declared = next(entry for own, entry in network.machine.entries() if str(own) == path)
    verb = "brings" if sign > 0 else "takes"
    inputs = ", ".join(entry.needs())
    read = f"its numbers, the input {inputs}, " if inputs else "its numbers, "
    return f", and {path} ({entry.spot}) {verb} most of the heat{_tell_growth(network, outcome, path)}", read


def _tell_growth(network: Network, outcome: Outcome, path: str) -> str:
    """Whether its heat grows with the temperatures it reads, at those of the start."""
    u = {"time": outcome.plan.t[0]} | {name: values[0] for name, values in outcome.plan.left.items()}
    at = network.mechanisms.index(path)
    for heats in network.heats:
        if heats.is_heat and heats.reads and at in heats.entry:
            T: Array = outcome.T_start
            slopes = heats.slopes(u, *(R @ T for R in heats.reads))
            grows = any(float(np.broadcast_to(s, heats.entry.shape)[list(heats.entry).index(at)]) > 0 for s in slopes)
            return ", which grows with its temperature" if grows else ""
    return ""
