"""What bands of 95 % say of themselves in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits

if TYPE_CHECKING:
    from network.analysis.calibration.band_coverage import Coverage
    from network.analysis.calibration.tcp_bands import Band

NOT_MEASURED = "by its numbers alone: no probe measured this axis when it was calibrated"


def tell_bands(bands: Iterable[Band]) -> Iterator[str]:
    """One sentence for each axis."""
    for band in bands:
        alone = f", {NOT_MEASURED}" if band.left is None else ""
        yield f"{band.axis}: ±{digits(band.widest, 2)} {pretty(band.unit)} (95 %) at worst{alone}"


def summarise_bands(bands: Iterable[Band]) -> list[dict[str, Any]]:
    """The key `bands` of `simulate --json`."""
    return [{"axis": b.axis, "widest95": b.widest, "at": float(b.t[int(np.argmax(b.total))]), "unit": b.unit,
             "measured": b.left is not None} for b in bands]  # fmt: skip


def tell_coverage(several: Sequence[Coverage]) -> Iterator[str]:
    """One sentence for each channel of each recording."""
    yield from (f"{c.sentence}." for c in several)
