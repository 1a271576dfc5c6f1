"""What is said of lumps: what finer ones would change, and how many are enough."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from network.analysis.sweep.finer_lumps import Change, has_chosen_lumps
from network.catalogue.expansions.base import AXES
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits
from network.platform.quantities.units import difference, unit
from network.platform.wording import join_names

if TYPE_CHECKING:
    from network.analysis.sweep.lump_choice import LumpChoice
    from network.analysis.sweep.lumping_error import LumpingError

TINY = 1e-3
"""Share of its range below which a change is none to speak of."""


def tell_lumping(error: LumpingError) -> str:
    """What finer lumps would change: of every axis, and of the thermometer that is off most."""
    lines = [f"Lumps: with {_tell_finer(error.finer)}, {_tell_changes([*_main(error.changes)])}."]
    if error.noise is not None and digits(error.noise[0], 3) != digits(error.noise[1], 3):
        noise = " σ instead of ".join(digits(each, 3) for each in reversed(error.noise))
        lines.append(f"With these numbers the residual would be {noise} σ.")
    if error.choice is not None:
        lines += _tell_need(error.choice, error.lumps)
    elif not error.is_within and not has_chosen_lumps(error.machine):
        lines.append("`--lumps auto` chooses as many for every bar as keep each channel within 2 % of its range.")
    return "\n".join(lines)


def tell_cut(error: LumpingError | None) -> list[str]:
    """The same as sentences; none where it is not known."""
    return [] if error is None else tell_lumping(error).splitlines()


def _main(changes: Sequence[Change]) -> Iterator[Change]:
    yield from (change for change in changes if change.name in AXES)
    rest = [change for change in changes if change.name not in AXES]
    if rest:
        yield max(rest, key=lambda change: change.size)


def _tell_finer(finer: Mapping[str, int]) -> str:
    counts = set(finer.values())
    if len(counts) == 1:
        return f"{counts.pop()} in every bar"
    return f"every bar cut twice as finely, into {min(counts)} at least"


def _tell_changes(changes: Sequence[Change]) -> str:
    """z would be up to 13.7 µm higher (20 % of its range), y up to 3.3 µm lower (34 %); x would not change."""
    most = {u: max(c.range for c in changes if c.unit == u) for u in {c.unit for c in changes}}
    moved = [change for change in changes if _is_told(change, most[change.unit])]
    still = [change.name for change in changes if change not in moved]
    told = [_tell_change(change, k == 0) for k, change in enumerate(moved)]
    stays = [f"{join_names(still)} would not change"] if still else []
    return "; ".join([*([join_names(told)] if told else []), *stays])


def _is_told(change: Change, most: float) -> bool:
    """Not where it is nothing to its own range, or to the largest of its kind: what moves by rounding alone."""
    if abs(change.largest) < TINY * most:
        return False
    return change.share >= TINY if change.range else change.largest != 0


def _tell_change(change: Change, is_first: bool) -> str:
    shown = difference(unit(change.unit))
    size, way = digits(abs(change.largest) / shown.scale, 3), "higher" if change.largest > 0 else "lower"
    verb, whole = ("would be up to", " of its range") if is_first else ("up to", "")
    share = f"{digits(100 * change.share, 2)} %{whole}" if change.range else "it stands still then"
    return f"{change.name} {verb} {size} {pretty(shown.text)} {way} ({share})"


def _tell_need(choice: LumpChoice, now: Mapping[str, int]) -> Iterator[str]:
    more = [f"{name} {count}" for name, count in choice.lumps.items() if count > now[name]]
    few = "" if len(more) == len(now) else "; the others are fine"
    total = f"{choice.machine.lumps} lumps in all"
    if choice.is_settled and more:
        yield f"Within 2 % of every range: {', '.join(more)}{few} (`--lumps auto`: {total})."
    elif not choice.is_settled:
        yield f"How many are enough is not told: {_tell_unsettled(choice)}."


def tell_choice(choice: LumpChoice) -> str:
    """The lumps of every bar, and what they leave."""
    each = ", ".join(f"{name} {count}" for name, count in choice.lumps.items())
    worst = max(choice.changes, key=lambda change: change.size)
    share = f"{100 * choice.share:.3g} %"
    left = f"{worst.name} is off by {digits(100 * worst.share, 2)} % of its range at most"
    kept = f"within {share} or a reading's noise" if choice.is_within else f"beyond {share}"
    least = " at least" if any(count > choice.finest for count in choice.lumps.values()) else ""
    finest = f"{choice.finest} in every bar{least}"
    lines = [f"Lumps: {each} ({choice.machine.lumps} in all); {left}, {kept}, of {finest}."]
    if not choice.is_settled:
        lines.append(f"That is not settled itself: {_tell_unsettled(choice)}.")
    return "\n".join(lines)


def _tell_unsettled(choice: LumpChoice) -> str:
    still = choice.still
    assert still is not None
    change = f"changed {still.name} by {digits(100 * still.share, 2)} % of its range"
    return f"the last doubling, to {choice.finest} in every bar, still {change}, and no finer ones are tried"
