"""The few sentences on a recording that tell most."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from network.analysis.comparison.examine import ChannelTests
from network.analysis.comparison.periodicity import Periodicity
from network.analysis.comparison.whiteness import WHITE, Whiteness
from network.platform.wording import join_names

MOST = 5
LEAST = 0.25
"""What accounts for less than this many σ is not told."""
ALIKE = 1.15
"""Periods within this factor are one."""
Told = tuple[float, str]
"""(σ that it accounts for, sentence)"""


def telling(tests: Mapping[str, ChannelTests], most: int = MOST) -> list[str]:
    """At most so many sentences: the strongest of every kind first, then the next ones by size."""
    kinds = [_sizeable(kind(tests)) for kind in (_periods, _drivers, _regimes, _pairs)]
    first = [kind[0][1] for kind in kinds if kind]
    more = [sentence for _, sentence in sorted((t for kind in kinds[:2] for t in kind[1:]), reverse=True)]
    judged = [found.whiteness for found in tests.values() if found.whiteness is not None]
    white = _white(judged) or ([] if first else _longest(judged))
    spikes = [found.spikes.sentence for found in tests.values() if found.spikes is not None]
    room = most - len(spikes) - len(first) - len(white)
    return [sentence + "." for sentence in [*spikes, *first, *more[: max(room, 0)], *white][:most]]


def _sizeable(found: Iterator[Told]) -> list[Told]:
    return sorted((told for told in found if told[0] >= LEAST), reverse=True)


def _periods(tests: Mapping[str, ChannelTests]) -> Iterator[Told]:
    """One sentence for every period, with the channels that share it."""
    left = sorted((f.period for f in tests.values() if f.period is not None), key=lambda p: -p.weight)
    while left:
        strongest = left[0]
        like = [p for p in left[1:] if abs(np.log(p.period / strongest.period)) < np.log(ALIKE)]
        left = [p for p in left[1:] if p not in like]
        yield strongest.weight, strongest.sentence + _also(like)


def _also(like: Sequence[Periodicity]) -> str:
    return f"; so do{'es' if len(like) == 1 else ''} {join_names([p.name for p in like])}" if like else ""


def _drivers(tests: Mapping[str, ChannelTests]) -> Iterator[Told]:
    """One sentence for every driver, about the channel it accounts for most of."""
    found = [driver for channel in tests.values() for driver in channel.drivers]
    for name in dict.fromkeys(driver.of for driver in found):
        strongest = max((driver for driver in found if driver.of == name), key=lambda driver: driver.weight)
        others = [d.name for d in found if d.of == name and d is not strongest and d.r * strongest.r > 0]
        also = f"; so do{'es' if len(others) == 1 else ''} {join_names(others)}" if others else ""
        yield strongest.weight, strongest.sentence + also


def _regimes(tests: Mapping[str, ChannelTests]) -> Iterator[Told]:
    for channel in tests.values():
        if channel.regimes is not None and channel.regimes.differs:
            yield channel.regimes.weight, channel.regimes.sentence


def _pairs(tests: Mapping[str, ChannelTests]) -> Iterator[Told]:
    for channel in tests.values():
        for companion in channel.companions:
            yield companion.weight, companion.sentence


def _white(found: Sequence[Whiteness]) -> list[str]:
    """The white ones together."""
    plain = [w.name for w in found if w.is_white and not w.but]
    sentences = [w.sentence for w in found if w.is_white and w.but and w.scatter >= LEAST * w.sigma]
    if len(plain) == len(found) > 1:
        return ["All " + WHITE]
    if plain:
        sentences.append(f"{join_names(plain)}: {WHITE}")
    return sentences[:2]


def _longest(found: Sequence[Whiteness]) -> list[str]:
    """Where nothing else can be told: how long residuals last that are not white."""
    sizeable = [w for w in found if w.scatter >= LEAST * w.sigma]
    return [max(sizeable, key=lambda w: w.scatter / w.sigma).sentence] if sizeable else []
